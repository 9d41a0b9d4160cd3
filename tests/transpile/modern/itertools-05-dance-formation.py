import itertools as it
import math
from helper import *

"""
dancers in formation on a stage
"""

COSTUMES = [("red", (0.8, 0.1, 0.2)), ("gold", (0.9, 0.75, 0.2)), ("teal", (0.1, 0.6, 0.6))]
ARM_POSES = ("up", "side", "down")


def angle_of(pose: str) -> float:
    return {"up": 1.2, "side": 0.0, "down": -1.0}[pose]


@register()
def dancer(color: tuple, left: str, right: str) -> Shape:
    skirt = primitive_call('cylinder', color=color, shape_kwargs={'radius': 0.25, 'p0': (0, 0.3, 0), 'p1': (0, 0.7, 0)})
    torso = primitive_call('cylinder', color=color, shape_kwargs={'radius': 0.12, 'p0': (0, 0.7, 0), 'p1': (0, 1.2, 0)})
    head = transform_shape(primitive_call('sphere', color=(0.9, 0.7, 0.55), shape_kwargs={'radius': 0.14}), translation_matrix((0, 1.4, 0)))
    arms = [
        primitive_call('cylinder', color=(0.9, 0.7, 0.55), shape_kwargs={'radius': 0.04, 'p0': (0.12 * side, 1.1, 0), 'p1': (side * (0.12 + 0.5 * math.cos(a)), 1.1 + 0.5 * math.sin(a), 0)})
        for side, a in zip((-1, 1), map(angle_of, (left, right)))
    ]
    legs = [primitive_call('cylinder', color=(0.9, 0.7, 0.55), shape_kwargs={'radius': 0.05, 'p0': (x, 0, 0), 'p1': (x, 0.3, 0)}) for x in (-0.08, 0.08)]
    return concat_shapes(skirt, torso, head, *arms, *legs)


@register()
def formation() -> Shape:
    poses = it.product(ARM_POSES, repeat=2)
    costumes = it.cycle(COSTUMES)
    spots = it.chain(
        ((1.2 * i - 1.2, 1.5) for i in range(3)),
        ((2.0 * math.cos(a), -1.5 + 0.8 * math.sin(a)) for a in it.islice(it.count(0, math.pi / 3), 6)),
    )
    cast = []
    for (left, right), (name, color), spot in zip(poses, costumes, spots):
        cast.append((name, color, left, right, spot))
    cast.sort(key=lambda c: c[0])
    shapes = []
    for name, group in it.groupby(cast, key=lambda c: c[0]):
        members = list(group)
        for level, (_, color, left, right, (x, z)) in enumerate(members):
            pose = translation_matrix((x, 0.1 * level, z)) @ rotation_matrix(0.3 * level, (0, 1, 0), (0, 0, 0))
            shapes.append(transform_shape(library_call('dancer', color=color, left=left, right=right), pose))
    links = [
        primitive_call('cylinder', color=(1, 1, 1), shape_kwargs={'radius': 0.01, 'p0': (a[4][0], 0.05, a[4][1]), 'p1': (b[4][0], 0.05, b[4][1])})
        for a, b in it.combinations(cast, 2) if a[0] == b[0]
    ]
    floor = primitive_call('cube', color=(0.25, 0.15, 0.1), shape_kwargs={'scale': (7, 0.1, 6)})
    return concat_shapes(floor, *shapes, *links)

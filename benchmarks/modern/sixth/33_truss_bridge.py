"""a steel truss railway bridge across a river, with rivets at the joints"""
from helper import *
import math
from collections import Counter, defaultdict
from itertools import chain, combinations, pairwise, product, starmap

BAYS, BAY, RISE, HALF_WIDTH = 8, 1.0, 1.3, 0.8
STEEL = {'chord': (0.35, 0.15, 0.12), 'web': (0.5, 0.22, 0.16), 'brace': (0.42, 0.3, 0.28), 'deck': (0.3, 0.3, 0.32)}
GAUGE = {'chord': 0.07, 'web': 0.045, 'brace': 0.03, 'deck': 0.06}

Node = tuple[int, int, int]  # bay, level, side


def position(node: Node) -> tuple[float, float, float]:
    bay, level, side = node
    arch = math.sin(math.pi * bay / BAYS) * 0.5 if level else 0.0
    return ((bay - BAYS / 2) * BAY, level * RISE + arch, (2 * side - 1) * HALF_WIDTH)


def side_members(side: int):
    """Yield (kind, node, node) of one vertical truss of the Pratt type."""
    lower = [(k, 0, side) for k in range(BAYS + 1)]
    upper = [(k, 1, side) for k in range(1, BAYS)]
    yield from (('chord', a, b) for a, b in chain(pairwise(lower), pairwise(upper)))
    yield 'chord', lower[0], upper[0]
    yield 'chord', lower[-1], upper[-1]
    for k in range(1, BAYS):
        yield 'web', (k, 0, side), (k, 1, side)
        toward_middle = k + 1 if k < BAYS // 2 else k - 1
        if k != BAYS // 2:
            yield 'web', (k, 1, side), (toward_middle, 0, side)


def cross_members():
    for k, level in product(range(BAYS + 1), (0, 1)):
        if level == 1 and not 0 < k < BAYS:
            continue
        yield 'deck' if level == 0 else 'brace', (k, level, 0), (k, level, 1)
    for k in range(1, BAYS - 1):
        quad = [(k, 1, 0), (k + 1, 1, 1), (k, 1, 1), (k + 1, 1, 0)]
        for a, b in combinations(quad, 2):
            if a[0] != b[0] and a[2] != b[2]:
                yield 'brace', a, b


MEMBERS = [*chain.from_iterable(map(side_members, (0, 1))), *cross_members()]
DEGREE = Counter(chain.from_iterable((a, b) for _, a, b in MEMBERS))
LENGTHS: defaultdict[str, float] = defaultdict(float)
for kind, a, b in MEMBERS:
    LENGTHS[kind] += math.dist(position(a), position(b))
print({kind: round(length, 1) for kind, length in LENGTHS.items()}, DEGREE.most_common(1))


@register("one steel member between two points")
def member(kind: str = 'web', a: tuple[float, float, float] = (0.0, 0.0, 0.0), b: tuple[float, float, float] = (1.0, 0.0, 0.0)) -> Shape:
    return primitive_call('cylinder', shape_kwargs={'radius': GAUGE[kind], 'p0': a, 'p1': b}, color=STEEL[kind])


@register("all members, and gusset balls that grow with the number of members")
def truss() -> Shape:
    steel = starmap(lambda kind, a, b: library_call('member', kind=kind, a=position(a), b=position(b)), MEMBERS)
    gussets = [
        transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.05 + 0.012 * degree}, color=STEEL['chord']), translation_matrix(position(node)))
        for node, degree in sorted(DEGREE.items()) if degree > 2
    ]
    return concat_shapes(*steel, *gussets)


@register("sleepers and rails")
def railway(length: float = 12.0, sleepers: int = 40) -> Shape:
    pitch = length / sleepers
    ties = loop(sleepers, lambda i: transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.12, 0.06, 1.1)}, color=(0.35, 0.25, 0.18)),
                                                    translation_matrix(((i + 0.5) * pitch - length / 2, 0.1, 0))))
    rails = [transform_shape(primitive_call('cube', shape_kwargs={'scale': (length, 0.08, 0.05)}, color=(0.6, 0.6, 0.62)), translation_matrix((0, 0.17, s * 0.36))) for s in (-1, 1)]
    return concat_shapes(ties, *rails)


@register("a stone abutment with courses")
def abutment(courses: int = 5) -> Shape:
    return loop(courses, lambda i: transform_shape(
        primitive_call('cube', shape_kwargs={'scale': (1.8 + 0.1 * i, 0.38, 2.2 + 0.1 * i)}, color=(0.62 - 0.02 * i, 0.6 - 0.02 * i, 0.56 - 0.02 * i)),
        translation_matrix((0, -0.27 - 0.4 * i, 0))))


@register()
def truss_bridge() -> Shape:
    river = transform_shape(primitive_call('cube', shape_kwargs={'scale': (14, 0.2, 8)}, color=(0.2, 0.42, 0.55)), translation_matrix((0, -2.2, 0)))
    ends = [transform_shape(library_call('abutment'), translation_matrix((s * (BAYS * BAY / 2 + 0.6), 0, 0))) for s in (-1, 1)]
    return concat_shapes(river, *ends, library_call('truss'), library_call('railway'))

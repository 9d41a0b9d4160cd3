from typing import Any, Callable, Unpack, TypedDict
from helper import *

"""
a suspension bridge
"""

class RodStyle(TypedDict, total=False):
    radius: float
    color: tuple[float, float, float]

def rod(a, b, **style: Unpack[RodStyle]) -> Shape:
    radius = style.pop("radius", 0.05)
    return primitive_call("cylinder", shape_kwargs={"radius": radius, "p0": tuple(a), "p1": tuple(b)}, **style)

def apply_all(shape, *poses):
    for pose in poses:
        shape = transform_shape(shape, pose)
    return shape

def mirrored(fn: Callable[..., Shape]) -> Callable[..., Shape]:
    def both(*args: Any, axis: tuple = (0, 0, 1), **kwargs: Any) -> Shape:
        first = fn(*args, **kwargs)
        return concat_shapes(first, transform_shape(first, reflection_matrix((0, 0, 0), axis)))
    return both

@mirrored
def main_cable(span: float, sag: float, z: float, *, segments: int = 12, **style) -> Shape:
    f = lambda t: (span * (t - 0.5), 1 + sag * (2 * t - 1) ** 2, z)
    ts = [i / segments for i in range(segments + 1)]
    return concat_shapes(*(rod(f(a), f(b), **style) for a, b in zip(ts, ts[1:])))

@mirrored
def hangers(span: float, sag: float, z: float, *, n: int, **style) -> Shape:
    result = []
    for i in range(1, n):
        t = i / n
        x, y = span * (t - 0.5), 1 + sag * (2 * t - 1) ** 2
        result += [rod((x, 0, z), (x, y, z), **{**style, "radius": 0.02})]
    return concat_shapes(*result)

@register("bridge tower")
def tower(height: float) -> Shape:
    legs = [rod((0, -1.5, z), (0, height, z), radius=0.15, color=(0.75, 0.25, 0.15)) for z in (-1, 1)]
    beams = [rod((0, y, -1), (0, y, 1), radius=0.1, color=(0.75, 0.25, 0.15)) for y in (height * 0.5, height * 0.95)]
    return concat_shapes(*legs, *beams)

@register("suspension bridge")
def bridge(span: float = 12.0, sag: float = 2.5) -> Shape:
    common = dict(color=(0.7, 0.2, 0.15))
    args = (span, sag, 1.0)
    towers = [apply_all(library_call("bridge tower", height=1 + sag), translation_matrix((s * span / 2, 0, 0))) for s in (-1, 1)]
    deck = apply_all(primitive_call("cube", color=(0.3, 0.3, 0.32)), scale_matrix((span * 1.4, 0.15, 1.8), (0, 0, 0)), translation_matrix((0, 0, 0)))
    lamps = apply_all(primitive_call("sphere", color=(1, 1, 0.7), shape_kwargs={"radius": 0.12}), translation_matrix((0, 0.8, 0)), rotation_matrix(0.1, (0, 0, 1), (0, 0, 0)))
    return concat_shapes(main_cable(*args, **common, radius=0.07), hangers(*args, n=16, **common), *towers, deck, lamps)

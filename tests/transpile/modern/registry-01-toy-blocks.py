from __future__ import annotations
import math
from typing import Callable, Protocol
from helper import *

"""
a nursery: builders registered by name, dispatched from an order list
"""


class Builder(Protocol):
    def __call__(self, size: float, **options) -> Shape: ...


BUILDERS: dict[str, Builder] = {}
ALIASES: dict[str, str] = {}


def builder(name: str | None = None, *, aliases: tuple[str, ...] = ()):
    def add(fn: Builder) -> Builder:
        key = name or fn.__name__.removeprefix("build_")
        BUILDERS[key] = fn
        ALIASES.update(dict.fromkeys(aliases, key))
        return fn
    return add


def build(name: str, *args, **kwargs) -> Shape:
    key = ALIASES.get(name, name)
    try:
        fn = BUILDERS[key]
    except KeyError:
        fn = BUILDERS["block"]
    return fn(*args, **kwargs)


@builder(aliases=("brick", "cube"))
def build_block(size: float, *, color=(0.8, 0.3, 0.3), **_) -> Shape:
    return transform_shape(primitive_call('cube', color=color, shape_kwargs={'scale': size}), translation_matrix((0, size / 2, 0)))


@builder("ring")
def make_ring(size: float, *, n: int = 10, **_) -> Shape:
    return loop(n, lambda i: transform_shape(primitive_call('sphere', color=(0.2, 0.5, 0.9), shape_kwargs={'radius': size * 0.25}), translation_matrix((size * math.cos(math.tau * i / n), size * 0.25, size * math.sin(math.tau * i / n)))))


@builder()
def build_arch(size: float, **options) -> Shape:
    legs = [transform_shape(build("brick", size / 2, **options), translation_matrix((s * size, 0, 0))) for s in (-1, 1)]
    top = primitive_call('cube', color=options.get("color", (0.9, 0.8, 0.2)), shape_kwargs={'scale': (size * 2.6, size / 3, size / 2)})
    return concat_shapes(*legs, transform_shape(top, translation_matrix((0, size * 2 / 3, 0))))


@builder()
def build_pile(size: float, *, of: str = "block", count: int = 3, **options) -> Shape:
    shapes, y = [], 0.0
    for k in range(count):
        part = build(of, size * 0.8 ** k, **options)
        shapes.append(transform_shape(part, translation_matrix((0, y, 0))))
        y = compute_shape_max(shapes[-1])[1]
    return concat_shapes(*shapes)


@register("one toy")
def toy(name: str, size: float, options: dict) -> Shape:
    return build(name, size, **options)


@register("nursery floor")
def nursery() -> Shape:
    orders = [("cube", 0.8, {}), ("ring", 0.9, {"n": 8}), ("pile", 0.9, {"of": "ring", "count": 4}), ("arch", 0.7, {"color": (0.3, 0.7, 0.4)}), ("pile", 1.0, dict(of="arch", count=2)), ("teddy", 0.5, {}), ("pile", 0.8, {})]
    row = [transform_shape(library_call('toy', name=n, size=s, options=o), translation_matrix((2.6 * (k % 4), 0, 2.8 * (k // 4)))) for k, (n, s, o) in enumerate(orders)]
    pegs = [primitive_call('cylinder', color=(0.5, 0.4, 0.3), shape_kwargs={'radius': 0.1, 'p0': (k, 0, -2), 'p1': (k, 0.2 * len(name), -2)}) for k, name in enumerate(sorted([*BUILDERS, *ALIASES]))]
    return concat_shapes(*row, *pegs)

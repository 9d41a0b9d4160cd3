from __future__ import annotations
from textwrap import dedent
from typing import Callable
from helper import *

"""
a pirate island parsed from a text map with a legend
"""

MAP = dedent("""
    ~ water 0.1 0.2,0.4,0.8
    s sand 0.3 0.9,0.8,0.5
    g grass 0.5 0.3,0.6,0.3
    h hill 1.1 0.5,0.45,0.35
    ===
    ~~~~~~~~
    ~~ssgT~~
    ~sgghhs~
    ~sgThXs~
    ~~ssssP~
    ~~~~~~~~
""").strip()


def parse(text: str):
    head, _, body = text.partition("===")
    legend = {}
    for line in head.strip().splitlines():
        symbol, name, height, rgb = line.split()
        legend[symbol] = (name, float(height), tuple(float(v) for v in rgb.split(",")))
    grid = [list(row) for row in body.split()]
    return legend, grid


def under(grid: list[list[str]], x: int, z: int) -> str:
    """Features stand on the terrain to their left."""
    while grid[z][x].isupper():
        x -= 1
    return grid[z][x]


@register()
def palm(height: float = 1.0) -> Shape:
    trunk = primitive_call("cylinder", color=(0.5, 0.35, 0.2), shape_kwargs={"radius": 0.07, "p0": (0, 0, 0), "p1": (0.1, height, 0)})
    fronds = loop(5, lambda i: primitive_call("cylinder", color=(0.1, 0.5, 0.2), shape_kwargs={"radius": 0.04, "p0": (0.1, height, 0), "p1": (0.1 + 0.4 * math.cos(1.256 * i), height - 0.1, 0.4 * math.sin(1.256 * i))}))
    return concat_shapes(trunk, fronds)


@register()
def cross() -> Shape:
    bars = [transform_shape(primitive_call("cube", color=(0.9, 0.1, 0.1), shape_kwargs={"scale": (0.8, 0.06, 0.15)}), rotation_matrix(s * math.pi / 4, (0, 1, 0), (0, 0, 0))) for s in (-1, 1)]
    return concat_shapes(*bars)


@register()
def pier() -> Shape:
    return loop(4, lambda i: transform_shape(primitive_call("cube", color=(0.5, 0.35, 0.2), shape_kwargs={"scale": (0.2, 0.05, 0.6)}), translation_matrix((0.25 * i, 0.2, 0))))


FEATURES: dict[str, Callable[[], Shape]] = {"T": lambda: library_call("palm", height=1.2), "X": lambda: library_call("cross"), "P": lambda: library_call("pier")}


@register()
def island() -> Shape:
    legend, grid = parse(MAP)
    shapes = []
    for z, row in enumerate(grid):
        for x, symbol in enumerate(row):
            name, height, color = legend[under(grid, x, z)]
            shapes.append(transform_shape(primitive_call("cube", color=color, shape_kwargs={"scale": (1, height, 1)}), translation_matrix((x, height / 2, z))))
            if feature := FEATURES.get(symbol):
                shapes.append(transform_shape(feature(), translation_matrix((x, height, z))))
    return concat_shapes(*shapes)

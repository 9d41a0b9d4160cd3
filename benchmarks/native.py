"""The benchmarks' computations as plain Python."""

from __future__ import annotations

import math
import random
from typing import Any


class Embedding:
    __slots__ = ("attributes",)

    def __init__(self, attributes: dict[str, Any]) -> None:
        self.attributes = attributes


class Entity:
    """An entity as a Python program would write it: word, embedding, children with poses."""

    __slots__ = ("children", "embedding", "word")

    def __init__(self, word: str, embedding: Embedding, children: list[Part]) -> None:
        self.word = word
        self.embedding = embedding
        self.children = children


class Part:
    __slots__ = ("entity", "pose")

    def __init__(self, entity: Entity, pose: tuple[float, ...]) -> None:
        self.entity = entity
        self.pose = pose


def call(word: str, children: list[Part] | None = None, **attributes: Any) -> Entity:
    return Entity(word, Embedding(attributes), children if children is not None else [])


def translate(offset: list[float]) -> tuple[float, ...]:
    x, y, z = offset
    return (1.0, 0.0, 0.0, float(x), 0.0, 1.0, 0.0, float(y), 0.0, 0.0, 1.0, float(z))


def transform(entity: Entity, pose: tuple[float, ...]) -> Part:
    return Part(entity, pose)


def fib(n: int) -> int:
    return n if n < 2 else fib(n - 1) + fib(n - 2)


def tak(x: int, y: int, z: int) -> int:
    return z if not y < x else tak(tak(x - 1, y, z), tak(y - 1, z, x), tak(z - 1, x, y))


def loop() -> int:
    i = total = 0
    while i != 1_000_000:
        total += i
        i += 1
    return total


def placed() -> Entity:
    return call("row", [transform(call("cube", color=[1.0, 0.0, 0.0]), translate([i, 0, 0])) for i in range(100_000)])


def chessboard() -> Entity:
    squares = []
    for i in range(64):
        x, z = i % 8, i // 8
        shade = [0.9, 0.9, 0.9] if (x + z) % 2 == 0 else [0.1, 0.1, 0.1]
        squares.append(transform(call("cube", color=shade, scale=[1, 0.1, 1]), translate([x, 0, z])))
    pieces = []
    for i in range(8):
        for z, color in ((1, [1.0, 1.0, 1.0]), (6, [0.0, 0.0, 0.0])):
            pieces.append(transform(call("pawn", color=color), translate([i, 0.1, z])))
    order = ("rook", "knight", "bishop", "queen", "king", "bishop", "knight", "rook")
    for i, name in enumerate(order):
        for z, color in ((0, [1.0, 1.0, 1.0]), (7, [0.0, 0.0, 0.0])):
            pieces.append(transform(call(name, color=color), translate([i, 0.1, z])))
    identity = translate([0, 0, 0])
    return call(
        "chessboard", [transform(call("board", squares), identity), transform(call("pieces", pieces), identity)]
    )


def safe(row: int, placed: list[int]) -> bool:
    for distance, other in enumerate(placed, 1):  # noqa: SIM110
        if other in (row, row + distance, row - distance):
            return False
    return True


def queens(n: int) -> int:
    def place(k: int, placed: list[int]) -> int:
        if k == 0:
            return 1
        count = 0
        for row in range(1, n + 1):
            if safe(row, placed):
                count += place(k - 1, [row, *placed])
        return count

    return place(n, [])


def spell(n: int) -> str:
    return "" if n == 0 else "".join((spell(n - 1), str(n), ","))


def strings() -> int:
    total = 0
    for _ in range(200):
        total += len(spell(100))
    return total


Triple = tuple[float, float, float]


def _sum(a: Triple, b: Triple) -> Triple:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def _difference(a: Triple, b: Triple) -> Triple:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def _times(a: Triple, k: float) -> Triple:
    return (a[0] * k, a[1] * k, a[2] * k)


def vectors() -> Triple:
    position, velocity = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
    for _ in range(100_000):
        position, velocity = _sum(position, _times(velocity, 0.01)), _difference(velocity, _times(position, 0.01))
    return position


def compose(m: tuple[float, ...], n: tuple[float, ...]) -> tuple[float, ...]:
    a, b, c, x, d, e, f, y, g, h, i, z = m
    j, k, l, u, o, p, q, v, r, s, t, w = n  # noqa: E741
    return (
        a * j + b * o + c * r, a * k + b * p + c * s, a * l + b * q + c * t, a * u + b * v + c * w + x,
        d * j + e * o + f * r, d * k + e * p + f * s, d * l + e * q + f * t, d * u + e * v + f * w + y,
        g * j + h * o + i * r, g * k + h * p + i * s, g * l + h * q + i * t, g * u + h * v + i * w + z,
    )  # fmt: skip


def rotate(angle: float, axis: list[float]) -> tuple[float, ...]:
    x, y, z = axis
    norm = math.sqrt(x * x + y * y + z * z)
    x, y, z = x / norm, y / norm, z / norm
    c, s = math.cos(angle), math.sin(angle)
    t = 1.0 - c
    return (
        t * x * x + c, t * x * y - s * z, t * x * z + s * y, 0.0,
        t * x * y + s * z, t * y * y + c, t * y * z - s * x, 0.0,
        t * x * z - s * y, t * y * z + s * x, t * z * z + c, 0.0,
    )  # fmt: skip


def scale(k: float) -> tuple[float, ...]:
    return (k, 0.0, 0.0, 0.0, 0.0, k, 0.0, 0.0, 0.0, 0.0, k, 0.0)


def tree(level: int) -> Entity:
    if level == 0:
        return call("leaf", [transform(call("sphere", radius=0.1), translate([0, 0, 0]))])
    bend, size = random.uniform(0.2, 0.6), random.uniform(0.6, 0.8)
    trunk = transform(call("cylinder", radius=0.1, height=1.0), translate([0, 0, 0]))
    left = compose(translate([0, 1, 0]), compose(rotate(bend, [0, 0, 1]), scale(size)))
    right = compose(translate([0, 1, 0]), compose(rotate(-bend, [0, 0, 1]), scale(size)))
    children = [trunk, transform(tree(level - 1), left), transform(tree(level - 1), right)]
    return call("tree", children, level=level)


def nested() -> Entity:
    parts = []
    for i in range(30):
        row = [
            transform(call("cube", color=[1.0, 0.0, 0.0]), compose(translate([i, 0, j]), rotate(0.1 * j, [0, 1, 0])))
            for j in range(1000)
        ]
        parts.extend(Part(part.entity, compose(translate([0, i, 0]), part.pose)) for part in row)
    return call("grid", parts)

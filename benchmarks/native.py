"""The benchmarks' computations as plain Python."""

from __future__ import annotations

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

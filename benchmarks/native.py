"""The benchmarks' computations as plain Python."""

from __future__ import annotations

from typing import Any


class Shape:
    """An entity as a Python program would write it."""

    __slots__ = ("attributes", "children", "word")

    def __init__(self, word: str, attributes: dict[str, Any], children: list[tuple[Shape, tuple[float, ...]]]) -> None:
        self.word = word
        self.attributes = attributes
        self.children = children


def translation(x: float, y: float, z: float) -> tuple[float, ...]:
    return (1.0, 0.0, 0.0, float(x), 0.0, 1.0, 0.0, float(y), 0.0, 0.0, 1.0, float(z))


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


def placed() -> Shape:
    children = []
    for i in range(100_000):
        children.append((Shape("cube", {"color": (1.0, 0.0, 0.0)}, []), translation(i, 0, 0)))
    return Shape("row", {}, children)


def chessboard() -> Shape:
    squares = []
    for i in range(64):
        x, z = i % 8, i // 8
        shade = (0.9, 0.9, 0.9) if (x + z) % 2 == 0 else (0.1, 0.1, 0.1)
        squares.append((Shape("cube", {"color": shade, "scale": (1, 0.1, 1)}, []), translation(x, 0, z)))
    board = Shape("board", {}, squares)
    pieces = []
    for i in range(8):
        for z, color in ((1, (1.0, 1.0, 1.0)), (6, (0.0, 0.0, 0.0))):
            pieces.append((Shape("pawn", {"color": color}, []), translation(i, 0.1, z)))
    order = ("rook", "knight", "bishop", "queen", "king", "bishop", "knight", "rook")
    for i, name in enumerate(order):
        for z, color in ((0, (1.0, 1.0, 1.0)), (7, (0.0, 0.0, 0.0))):
            pieces.append((Shape(name, {"color": color}, []), translation(i, 0.1, z)))
    return Shape("chessboard", {}, [(board, translation(0, 0, 0)), (Shape("pieces", {}, pieces), translation(0, 0, 0))])

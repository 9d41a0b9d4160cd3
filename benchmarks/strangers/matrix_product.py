# Powers of a matrix of lists, the textbook product of rows and columns; 2026-11-29.
from __future__ import annotations

Matrix = list[list[int]]


def make_matrix(n: int) -> Matrix:
    return [[(7 * i + 3 * j + 1) % 11 for j in range(n)] for i in range(n)]


def product(a: Matrix, b: Matrix) -> Matrix:
    turned = list(zip(*b))
    return [[sum(x * y for x, y in zip(row, column)) % 10007 for column in turned] for row in a]


def power(a: Matrix, n: int) -> Matrix:
    if n == 1:
        return a
    if n % 2 == 0:
        half = power(a, n // 2)
        return product(half, half)
    return product(a, power(a, n - 1))


def run(size: int = 20) -> int:
    return sum(row[i] for i, row in enumerate(power(make_matrix(size), 13)))

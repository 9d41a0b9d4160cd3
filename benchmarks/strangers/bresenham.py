# Lines of a fan on a grid of cells (Bresenham 1965), with all octants; 2026-11-29.
from __future__ import annotations


def line(grid: list[list[int]], x: int, y: int, x1: int, y1: int) -> None:
    dx, dy = abs(x1 - x), -abs(y1 - y)
    sx = 1 if x < x1 else -1
    sy = 1 if y < y1 else -1
    slip = dx + dy
    while True:
        grid[y][x] += 1
        if x == x1 and y == y1:
            return
        twice = 2 * slip
        if twice >= dy:
            slip += dy
            x += sx
        if twice <= dx:
            slip += dx
            y += sy


def run(size: int = 61) -> int:
    grid = [[0] * size for _ in range(size)]
    middle = size // 2
    for i in range(size):
        line(grid, middle, middle, i, 0)
        line(grid, middle, middle, i, size - 1)
        line(grid, 0, i, middle, middle)
        line(grid, size - 1, i, middle, middle)
    h = 7
    for row in grid:
        for k in row:
            h = (31 * h + k) % 1000003
    return h

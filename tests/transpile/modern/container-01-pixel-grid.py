from __future__ import annotations
from typing import Iterator
from helper import *

"""
a pixel art invader drawn on a Grid container class
"""


class Grid:
    def __init__(self, width: int, height: int, fill: str = ".") -> None:
        self.width = width
        self.height = height
        self._cells = [[fill] * width for _ in range(height)]

    def __getitem__(self, key):
        if isinstance(key, tuple):
            x, y = key
            return self._cells[y][x]
        return self._cells[key]

    def __setitem__(self, key: tuple[int, int], value: str) -> None:
        x, y = key
        self._cells[y][x] = value

    def __contains__(self, value: str) -> bool:
        return any(value in row for row in self._cells)

    def __len__(self) -> int:
        return self.width * self.height

    def __iter__(self) -> Iterator[tuple[int, int, str]]:
        for y, row in enumerate(self._cells):
            for x, value in enumerate(row):
                yield x, y, value

    def __delitem__(self, key: tuple[int, int]) -> None:
        self[key] = "."

    def mirror(self) -> None:
        for x, y, value in list(self):
            if value != ".":
                self[self.width - 1 - x, y] = value

    def __str__(self) -> str:
        return "\n".join("".join(row) for row in self._cells)


COLORS = {"#": (0.2, 0.9, 0.3), "o": (1, 1, 1), "*": (1, 0.3, 0.2)}


@register()
def pixel(value: str, depth: float = 1.0) -> Shape:
    return primitive_call("cube", color=COLORS.get(value, (0.1, 0.1, 0.1)), shape_kwargs={"scale": (0.95, 0.95, depth)})


@register()
def invader() -> Shape:
    grid = Grid(11, 8)
    spans = {0: [2], 1: [3], 2: range(2, 6), 3: [1, 2, 4, 5], 4: range(0, 6), 5: [0, 2, 3, 4, 5], 6: [0, 2], 7: [3, 4]}
    for y, xs in spans.items():
        for x in xs:
            grid[x, y] = "#"
    grid[3, 3] = "o"
    grid.mirror()
    grid[5, 4] = "*"
    del grid[0, 6]
    print(grid)
    assert "o" in grid and "@" not in grid
    depth = 1.0 if len(grid) > 80 else 2.0
    pixels = [
        transform_shape(library_call("pixel", value=v, depth=depth * (1 + grid[y].count("#") / 11)), translation_matrix((x - 5, 7 - y, 0)))
        for x, y, v in grid if v != "."
    ]
    return concat_shapes(*pixels)

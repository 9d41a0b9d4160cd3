"""Sizes of everyday objects in metres, from a table with sources: what a chair measures, and relative to a table.

The ranges are those of what is sold and built, from the smallest to the largest common one.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from types import MappingProxyType

from scenelang.grammar.datum import dataclass


@dataclass(frozen=True, slots=True)
class EverydaySize:
    """Ranges of an object's height, and of its length: the larger one of its horizontal extents."""

    height: tuple[float, float]
    length: tuple[float, float]
    source: str

    def in_metres(self, word: str) -> list[str]:
        """Return the declarations that the things of a word have this size."""
        return [
            f'(size "{word}" :axis "{axis}" :min {low:g} :max {high:g})'
            for axis, (low, high) in (("y", self.height), ("xz", self.length))
        ]

    def relative_to(self, word: str, other: str, size: EverydaySize) -> list[str]:
        """Return the declarations that the things of a word have a usual size beside those of another one."""
        rows = (("y", self.height, size.height), ("xz", self.length, size.length))
        return [
            f'(proportion "{word}" "{other}" :axis "{axis}" :min {low / top:.3g} :max {high / bottom:.3g})'
            for axis, (low, high), (bottom, top) in rows
        ]


@cache
def everyday_sizes() -> Mapping[str, EverydaySize]:
    """Return the sizes by noun."""
    table = tomllib.loads((files("scenelang.bench") / "sizes.toml").read_text("utf-8"))
    return MappingProxyType({
        noun: EverydaySize(_range(row["height"]), _range(row["length"]), str(row["source"]))
        for noun, row in table.items()
    })  # fmt: skip


def _range(ends: list[float]) -> tuple[float, float]:
    low, high = (float(end) for end in ends)
    return low, high

"""Compounds one after another that differ in their numbers only, as the blocks of a structure: read by numpy."""

from __future__ import annotations

from collections.abc import Mapping
from struct import pack
from typing import Any

import numpy as np

_MOST = 1 << 22  # bytes that are looked at together
_WIDEST = 16  # fields of a compound that is looked at
_INT, _LIST = 3, 9


def rows_like(first: Mapping[str, Any], size: int, data: bytes, at: int, count: int) -> list[dict[str, Any]]:
    """The compounds from the byte ``at`` on, ``count`` at most, that are as ``first``, which took ``size`` bytes: ints
    and lists of ints under the same names. None where ``first`` has anything else, or too many fields."""
    values = list(first.values())
    if len(values) > _WIDEST or not all(type(value) is int or _is_ints(value) for value in values):
        return []
    heads = [_head(name, value) for name, value in first.items()]
    fields: list[Any] = []
    for i, (head, value) in enumerate(zip(heads, values)):
        shape = () if type(value) is int else (len(value),)
        fields += [(f"head{i}", np.uint8, (len(head),)), (f"value{i}", ">i4", shape)]
    layout = np.dtype([*fields, ("end", np.uint8)])
    if layout.itemsize != size:
        return []
    rows = np.frombuffer(data, layout, min(count, 1 + _MOST // size, (len(data) - at) // size), at)
    alike = rows["end"] == 0
    for i, head in enumerate(heads):
        alike &= (rows[f"head{i}"] == np.frombuffer(head, np.uint8)).all(axis=1)
    rows = rows[: len(rows) if alike.all() else int(np.argmin(alike))]
    columns = [_column(rows[f"value{i}"]) for i in range(len(values))]
    return [dict(zip(first, row)) for row in zip(*columns)]


def _column(values: np.ndarray[Any, Any]) -> list[Any]:
    return values.tolist() if values.ndim == 1 else list(values)


def _is_ints(value: Any) -> bool:
    return isinstance(value, np.ndarray) and value.dtype == np.dtype(">i4") and len(value) > 0


def _head(name: str, value: Any) -> bytes:
    """The bytes before the numbers of a field."""
    label = name.encode("utf-8", "replace")
    if type(value) is int:
        return pack(">bH", _INT, len(label)) + label
    return pack(">bH", _LIST, len(label)) + label + pack(">bi", _INT, len(value))

"""The game's binary format ("named binary tags") written.

Plain values become tags: ``dict`` a compound, ``str`` a text, ``int`` an int, ``Byte``, ``Short`` and ``Long`` those,
numpy arrays of 8, 32 and 64 bits arrays, a ``list`` a list of the kind of its first item, ``Compounds`` a list.
"""

from __future__ import annotations

import gzip
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from struct import pack
from typing import Any

import numpy as np

from scenelang.backends.files import written_whole

_LEVEL = 5  # of gzip: higher takes twice as long for a few hundredths less
_BYTE, _SHORT, _INT, _LONG, _STRING, _LIST, _COMPOUND = 1, 2, 3, 4, 8, 9, 10
_ARRAYS = {1: (7, ">i1"), 4: (11, ">i4"), 8: (12, ">i8")}  # by the bytes of an item


class Byte(int):
    """An integer of one byte."""


class Short(int):
    """An integer of two bytes, from 0 to 65,535: that is how lengths are read."""


class Long(int):
    """An integer of eight bytes."""


@dataclass(frozen=True, slots=True)
class Compounds:
    """A list of ``count`` compounds whose bytes are known."""

    count: int
    data: bytes


def write_nbt(path: Path, name: str, root: Mapping[str, Any]) -> None:
    """Write the compound ``root``, called ``name``, packed by gzip, whole or not at all; raises SceneError("file")."""
    with (
        written_whole(path) as temporary,
        temporary.open("wb") as file,
        gzip.GzipFile("", "wb", _LEVEL, file, mtime=0) as packed,
    ):
        for piece in (bytes([_COMPOUND]), _text(name), *_payload(root)):
            packed.write(piece)


def _kind(value: Any) -> int:
    if isinstance(value, np.ndarray):
        return _ARRAYS[value.dtype.itemsize][0]
    kinds = {Byte: _BYTE, Short: _SHORT, Long: _LONG, int: _INT, str: _STRING, dict: _COMPOUND}
    return kinds.get(type(value), _LIST)


def _payload(value: Any) -> Iterator[bytes]:
    kind = _kind(value)
    if kind == _COMPOUND:
        for name, item in value.items():
            yield bytes([_kind(item)]) + _text(name)
            yield from _payload(item)
        yield b"\0"
    elif kind == _LIST:
        yield from _list(value)
    elif kind == _STRING:
        yield _text(value)
    elif isinstance(value, np.ndarray):
        yield pack(">i", len(value))
        yield value.astype(_ARRAYS[value.dtype.itemsize][1], copy=False).tobytes()
    else:
        yield pack({_BYTE: ">b", _SHORT: ">H", _INT: ">i", _LONG: ">q"}[kind], value)


def _list(value: list[Any] | Compounds) -> Iterator[bytes]:
    if isinstance(value, Compounds):
        yield pack(">bi", _COMPOUND if value.count else 0, value.count)
        yield value.data
        return
    yield pack(">bi", _kind(value[0]) if value else 0, len(value))
    for item in value:
        yield from _payload(item)


def _text(text: str) -> bytes:
    """As Java writes texts: NUL in two bytes, letters beyond 16 bits as two halves."""
    units = text.encode("utf-16-be", "surrogatepass")
    halves = "".join(chr(units[i] << 8 | units[i + 1]) for i in range(0, len(units), 2))
    data = halves.encode("utf-8", "surrogatepass").replace(b"\0", b"\xc0\x80")
    return pack(">H", len(data)) + data

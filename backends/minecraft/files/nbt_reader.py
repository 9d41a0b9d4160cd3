"""The game's binary format ("named binary tags") read from bytes that nobody vouches for.

Tags become plain values: numbers are ``int`` and ``float``, texts ``str``, compounds ``dict``, arrays and lists of
numbers numpy arrays of big-endian numbers, other lists ``list``.
"""

from __future__ import annotations

import zlib
from pathlib import Path
from struct import Struct
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.files import read_regular
from scenelang.backends.minecraft.files.damage import Damaged
from scenelang.backends.minecraft.files.nbt_rows import rows_like

LARGEST = 512_000_000  # bytes of a file, and of what it unpacks to
MOST_TAGS = 8_000_000
DEEPEST = 200  # lists and compounds within one another; each is a call of Python
_FEW = 16  # compounds that are read one by one as fast
_TRIES = 200  # to find more than a few that are alike, in one list
_STRING, _LIST, _COMPOUND = 8, 9, 10
_NUMBERS = {1: Struct(">b"), 2: Struct(">h"), 3: Struct(">i"), 4: Struct(">q"), 5: Struct(">f"), 6: Struct(">d")}
_TYPES = {kind: np.dtype(name) for kind, name in enumerate((">i1", ">i2", ">i4", ">i8", ">f4", ">f8"), 1)}
_ARRAYS = {7: _TYPES[1], 11: _TYPES[3], 12: _TYPES[4]}
_COUNT, _LENGTH = Struct(">i"), Struct(">H")


def read_nbt(path: Path, largest: int = LARGEST) -> dict[str, Any]:
    """The root compound of a file, packed by gzip or zlib or not at all.

    Raises Damaged where it is none, and for what is larger than ``largest`` bytes, has more than MOST_TAGS tags or is
    nested deeper than DEEPEST; OSError where the file cannot be read.
    """
    if path.stat().st_size > largest:
        raise Damaged(f"it is larger than {largest:,} bytes")
    reader = _Reader(_unpacked(read_regular(path), largest))
    if reader.kind() != _COMPOUND:
        raise Damaged("it does not begin as such a file does")
    reader.text()
    return reader.compound(0)


def _unpacked(data: bytes, largest: int) -> bytes:
    """``data`` without the packing that its first bytes tell of, and never more than ``largest`` bytes of it."""
    if data[:2] != b"\x1f\x8b" and data[:1] != b"\x78":
        return data
    unpacker = zlib.decompressobj(wbits=47)  # gzip or zlib, whichever it is
    try:
        found = unpacker.decompress(data, largest + 1)
    except zlib.error:
        raise Damaged("its packing is damaged") from None
    if len(found) > largest:
        raise Damaged(f"it unpacks to more than {largest:,} bytes")
    if not unpacker.eof:
        raise Damaged("it ends too early")
    return found


class _Reader:
    """Where reading has come to, and how many tags may still come."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._at = 0
        self._tags = MOST_TAGS

    def kind(self) -> int:
        """The next byte, which says what kind of tag follows."""
        return self._taken(1)[0]

    def text(self) -> str:
        """The next text. Names of blocks are ASCII, so the game's own way of writing other letters may be lost."""
        (length,) = _LENGTH.unpack(self._taken(2))
        return self._taken(length).decode("utf-8", "replace")

    def compound(self, depth: int) -> dict[str, Any]:
        """The next compound, ``depth`` levels deep."""
        found: dict[str, Any] = {}
        while kind := self.kind():
            name = self.text()
            found[name] = self._payload(kind, depth)
        return found

    def _payload(self, kind: int, depth: int) -> Any:
        self._tags -= 1
        if self._tags < 0:
            raise Damaged(f"it has more than {MOST_TAGS:,} tags")
        number = _NUMBERS.get(kind)
        if number is not None:
            return number.unpack(self._taken(number.size))[0]
        if kind == _STRING:
            return self.text()
        if kind in _ARRAYS:
            return self._array(_ARRAYS[kind], self._count())
        if depth >= DEEPEST:
            raise Damaged(f"it is nested deeper than {DEEPEST} levels")
        if kind == _COMPOUND:
            return self.compound(depth + 1)
        if kind == _LIST:
            return self._list(depth + 1)
        raise Damaged(f"it has a tag of the kind {kind}, which there is not")

    def _list(self, depth: int) -> Any:
        kind, count = self.kind(), self._count()
        if not count:
            return []
        if kind in _TYPES:
            return self._array(_TYPES[kind], count)
        if kind == _COMPOUND:
            return self._compounds(count, depth)
        return [self._payload(kind, depth) for _ in range(count)]

    def _compounds(self, count: int, depth: int) -> list[dict[str, Any]]:
        """The next ``count`` compounds; many that are alike are read together, as long as that pays."""
        found: list[dict[str, Any]] = []
        tries = _TRIES
        while len(found) < count:
            start = self._at
            found.append(self._payload(_COMPOUND, depth))
            if tries and count - len(found) > _FEW:
                size = self._at - start
                alike = rows_like(found[-1], size, self._data, self._at, count - len(found))
                tries -= len(alike) < _FEW
                self._at += size * len(alike)
                self._tags -= len(alike) * (1 + len(found[-1]))
                found += alike
        return found

    def _array(self, dtype: np.dtype[Any], count: int) -> npt.NDArray[Any]:
        return np.frombuffer(self._taken(count * dtype.itemsize), dtype)

    def _count(self) -> int:
        return max(0, int(_COUNT.unpack(self._taken(4))[0]))

    def _taken(self, count: int) -> bytes:
        """The next ``count`` bytes."""
        end = self._at + count
        if end > len(self._data):
            raise Damaged("it ends too early")
        start, self._at = self._at, end
        return self._data[start:end]

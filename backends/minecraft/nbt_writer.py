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
import numpy.typing as npt

from scenelang.backends.files import written_whole
from scenelang.backends.minecraft.nbt import Damaged

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


# Numbers of cells as bytes: variable-length integers, and integers of some bits in longs.


Numbers = npt.NDArray[np.uint32]
Bytes = npt.NDArray[np.uint8]
Longs = npt.NDArray[np.uint64]

_GROUP = 64  # so many numbers of n bits fill n longs
_SLAB = 1 << 20  # numbers that are looked at together
_LONGEST = 5  # bytes of a 32-bit number, seven bits in each


def varints(numbers: Numbers) -> Bytes:
    """``numbers`` (N,) as LEB128: seven bits a byte, the lowest first, the high bit set in all bytes but the last."""
    if not len(numbers) or int(numbers.max()) < 0x80:
        return numbers.astype(np.uint8)
    return np.concatenate([_varints(numbers[i : i + _SLAB]) for i in range(0, len(numbers), _SLAB)])


def _varints(numbers: Numbers) -> Bytes:
    lengths = np.ones(len(numbers), np.int64)
    for n in range(1, _LONGEST):
        lengths += numbers >= np.uint32(1 << (7 * n))
    starts = np.cumsum(lengths) - lengths
    out = np.zeros(int(lengths.sum()), np.uint8)
    for n in range(int(lengths.max())):
        has = lengths > n
        more = np.where(lengths[has] > n + 1, 0x80, 0).astype(np.uint32)
        out[starts[has] + n] = (numbers[has] >> np.uint32(7 * n) & np.uint32(0x7F)) | more
    return out


def from_varints(data: Bytes, count: int) -> Numbers:
    """The ``count`` numbers that ``varints`` packed; raises Damaged where ``data`` holds more or fewer, or too long
    ones."""
    last = data < 0x80
    if int(np.count_nonzero(last)) != count or (len(data) and not last[-1]):
        raise Damaged(f"its blocks are not the {count:,} that its size asks for")
    if len(data) == count:
        return data.astype(np.uint32)
    numbers = np.empty(count, np.uint32)
    ends = np.flatnonzero(last)
    for at in range(0, count, _SLAB):
        part = ends[at : at + _SLAB]
        starts = np.concatenate(([ends[at - 1] + 1 if at else 0], part[:-1] + 1))
        numbers[at : at + len(part)] = _from_varints(data, starts, part - starts + 1)
    return numbers


def _from_varints(data: Bytes, starts: npt.NDArray[np.int64], lengths: npt.NDArray[np.int64]) -> Numbers:
    if int(lengths.max()) > _LONGEST:
        raise Damaged("the number of a block takes too many bytes")
    numbers = np.zeros(len(starts), np.uint32)
    for n in range(int(lengths.max())):
        has = lengths > n
        numbers[has] |= (data[starts[has] + n].astype(np.uint32) & np.uint32(0x7F)) << np.uint32(7 * n)
    return numbers


def long_count(count: int, bits: int) -> int:
    """The longs that ``count`` numbers of ``bits`` bits fill."""
    return -(-count * bits // 64)


def packed_longs(numbers: Numbers, bits: int) -> Longs:
    """``numbers`` (N,) of ``bits`` bits one after another, from the lowest bit of the first long on; numbers may lie
    across two longs."""
    out = np.zeros((-(-len(numbers) // _GROUP), bits), np.uint64)
    for i in range(_GROUP):
        column = numbers[i::_GROUP].astype(np.uint64)
        word, shift = divmod(i * bits, 64)
        out[: len(column), word] |= column << np.uint64(shift)
        if shift + bits > 64:
            out[: len(column), word + 1] |= column >> np.uint64(64 - shift)
    return out.reshape(-1)[: long_count(len(numbers), bits)]


def from_packed_longs(longs: Longs, count: int, bits: int) -> Numbers:
    """The ``count`` numbers that ``packed_longs`` packed; raises Damaged where ``longs`` holds fewer."""
    if len(longs) < long_count(count, bits):
        raise Damaged(f"its blocks are not the {count:,} that its size asks for")
    groups = -(-count // _GROUP)
    rows = np.zeros(groups * bits, np.uint64)
    rows[: min(len(longs), len(rows))] = longs[: len(rows)]
    table = rows.reshape(groups, bits)
    numbers = np.empty((groups, _GROUP), np.uint32)
    mask = np.uint64((1 << bits) - 1)
    for i in range(_GROUP):
        word, shift = divmod(i * bits, 64)
        column = table[:, word] >> np.uint64(shift)
        if shift + bits > 64:
            column |= table[:, word + 1] << np.uint64(64 - shift)
        numbers[:, i] = column & mask
    return numbers.reshape(-1)[:count]

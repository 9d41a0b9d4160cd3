"""The game's binary format ("named binary tags") read from bytes that nobody vouches for.

Tags become plain values: numbers are ``int`` and ``float``, texts ``str``, compounds ``dict``, arrays and lists of
numbers numpy arrays of big-endian numbers, other lists ``list``.
"""

from __future__ import annotations

import gzip
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from struct import Struct, pack
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.files import read_regular, written_whole
from scenelang.backends.minecraft.voxels import MOST_CELLS

# What is wrong with a file of a build, before it is known which file that is.


class Damaged(Exception):
    """A file is not what it should be; the message says why, as the end of a sentence."""


# What the compounds of a file hold, each field of the kind that it must be.


Triple = tuple[int, int, int]
_FARTHEST = 1 << 31  # cells from the origin: what a file's ints can say


def compound(tag: Mapping[str, Any], name: str) -> dict[str, Any]:
    """The compound called ``name``; raises Damaged."""
    found = tag.get(name)
    if not isinstance(found, dict):
        raise Damaged(f"it has no compound `{name}`")
    return found


def whole(tag: Mapping[str, Any], name: str) -> int:
    """The integer called ``name``; raises Damaged."""
    found = tag.get(name)
    if not isinstance(found, int):
        raise Damaged(f"it has no integer `{name}`")
    return found


def array(tag: Mapping[str, Any], name: str, bits: int) -> npt.NDArray[Any]:
    """The array of integers of ``bits`` bits called ``name``; raises Damaged."""
    found = tag.get(name)
    if not isinstance(found, np.ndarray) or found.dtype.kind != "i" or found.dtype.itemsize * 8 != bits:
        raise Damaged(f"it has no array `{name}` of numbers of {bits} bits")
    return found


def listed(tag: Mapping[str, Any], name: str) -> list[Any]:
    """The list of compounds or lists called ``name``; raises Damaged."""
    found = tag.get(name)
    if not isinstance(found, list):
        raise Damaged(f"it has no list `{name}`")
    return found


def how_many(tag: Mapping[str, Any], *names: str) -> int:
    """The items of all lists of these names that there are."""
    return sum(len(found) for name in names if isinstance(found := tag.get(name), list))


def triple_of_array(tag: Mapping[str, Any], name: str) -> Triple:
    """The three ints of the array or list called ``name``; raises Damaged."""
    found = array(tag, name, 32)
    if len(found) != 3:
        raise Damaged(f"`{name}` is not three numbers")
    x, y, z = found.tolist()
    return x, y, z


def triple_of_compound(tag: Mapping[str, Any], name: str) -> Triple:
    """The ints ``x``, ``y`` and ``z`` of the compound called ``name``; raises Damaged."""
    found = compound(tag, name)
    x, y, z = (whole(found, axis) for axis in "xyz")
    if any(not -_FARTHEST <= n < _FARTHEST for n in (x, y, z)):
        raise Damaged(f"`{name}` is farther away than a block can be")
    return x, y, z


def checked_size(size: Triple) -> Triple:
    """``size``, cells along each axis; raises Damaged where a build cannot be so large."""
    x, y, z = size
    if min(size) < 0 or x * y * z > MOST_CELLS or max(size) > MOST_CELLS:
        shown = " x ".join(f"{n:,}" for n in size)
        raise Damaged(f"its box is {shown} cells, and a build may have {MOST_CELLS:,}")
    return size


# Compounds one after another that differ in their numbers only, as the blocks of a structure: read by numpy.


_BYTE, _SHORT, _INT, _LONG, _STRING, _LIST, _COMPOUND = 1, 2, 3, 4, 8, 9, 10  # kinds of tags
_MOST = 1 << 22  # bytes that are looked at together
_WIDEST = 16  # fields of a compound that is looked at


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


LARGEST = 512_000_000  # bytes of a file, and of what it unpacks to
MOST_TAGS = 8_000_000
DEEPEST = 200  # lists and compounds within one another; each is a call of Python
_FEW = 16  # compounds that are read one by one as fast
_TRIES = 200  # to find more than a few that are alike, in one list
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


# The game's binary format ("named binary tags") written.
#
# Plain values become tags: ``dict`` a compound, ``str`` a text, ``int`` an int, ``Byte``, ``Short`` and ``Long``
# those,
# numpy arrays of 8, 32 and 64 bits arrays, a ``list`` a list of the kind of its first item, ``Compounds`` a list.


_LEVEL = 5  # of gzip: higher takes twice as long for a few hundredths less
_ARRAYS_BY_SIZE = {1: (7, ">i1"), 4: (11, ">i4"), 8: (12, ">i8")}  # by the bytes of an item


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
        return _ARRAYS_BY_SIZE[value.dtype.itemsize][0]
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
        yield value.astype(_ARRAYS_BY_SIZE[value.dtype.itemsize][1], copy=False).tobytes()
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

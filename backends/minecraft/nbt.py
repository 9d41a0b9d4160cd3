"""NBT ("named binary tags"), the game's binary format: robust reading of untrusted files, and writing.

Tags become plain values: numbers ``int`` and ``float``, strings ``str``, compounds ``dict``, arrays and lists of
numbers numpy arrays of big-endian numbers, other lists ``list``. The format is described at
https://minecraft.wiki/w/NBT_format. nbtlib is not used because its reader cannot limit depth, size or time; the tests
compare this one with nbtlib and mcschematic.
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

from scenelang.backends.files import atomic_write, read_regular
from scenelang.backends.minecraft.voxels import MAX_CELLS

# Errors in a file, raised before the name of the file is known.


class Damaged(Exception):
    """The content of a file is invalid; the message completes the sentence "FILE is not a valid build: ..."."""


# Typed access to the fields of compounds.


Triple = tuple[int, int, int]
_MAX_COORDINATE = 1 << 31  # cells from the origin: the range of 32-bit integers in files


def compound(tag: Mapping[str, Any], name: str) -> dict[str, Any]:
    """Return the compound ``name``; raises Damaged."""
    value = tag.get(name)
    if not isinstance(value, dict):
        raise Damaged(f"missing compound `{name}`")
    return value


def whole(tag: Mapping[str, Any], name: str) -> int:
    """Return the integer ``name``; raises Damaged."""
    value = tag.get(name)
    if not isinstance(value, int):
        raise Damaged(f"missing integer `{name}`")
    return value


def array(tag: Mapping[str, Any], name: str, bits: int) -> npt.NDArray[Any]:
    """Return the array ``name`` of ``bits``-bit integers; raises Damaged."""
    value = tag.get(name)
    if not isinstance(value, np.ndarray) or value.dtype.kind != "i" or value.dtype.itemsize * 8 != bits:
        raise Damaged(f"missing array `{name}` of {bits}-bit integers")
    return value


def listed(tag: Mapping[str, Any], name: str) -> list[Any]:
    """Return the list ``name`` of compounds or lists; raises Damaged."""
    value = tag.get(name)
    if not isinstance(value, list):
        raise Damaged(f"missing list `{name}`")
    return value


def how_many(tag: Mapping[str, Any], *names: str) -> int:
    """Return the total number of items in the existing lists with these names."""
    return sum(len(items) for name in names if isinstance(items := tag.get(name), list))


def triple_of_array(tag: Mapping[str, Any], name: str) -> Triple:
    """Return the three ints of the array or list ``name``; raises Damaged."""
    numbers = array(tag, name, 32)
    if len(numbers) != 3:
        raise Damaged(f"`{name}` must be three numbers")
    x, y, z = numbers.tolist()
    return x, y, z


def triple_of_compound(tag: Mapping[str, Any], name: str) -> Triple:
    """Return the ints ``x``, ``y`` and ``z`` of the compound ``name``; raises Damaged."""
    coordinates = compound(tag, name)
    x, y, z = (whole(coordinates, axis) for axis in "xyz")
    if any(not -_MAX_COORDINATE <= n < _MAX_COORDINATE for n in (x, y, z)):
        raise Damaged(f"`{name}` is out of range")
    return x, y, z


def checked_size(size: Triple) -> Triple:
    """Return ``size``, in cells along each axis; raises Damaged if it exceeds the limit of a build."""
    x, y, z = size
    if min(size) < 0 or x * y * z > MAX_CELLS or max(size) > MAX_CELLS:
        shown = " x ".join(f"{n:,}" for n in size)
        raise Damaged(f"invalid size {shown}: a build must have 0 to {MAX_CELLS:,} cells")
    return size


# Fast path: consecutive compounds that differ only in their numbers, such as the blocks of a structure, are read by
# numpy.


_BYTE, _SHORT, _INT, _LONG, _STRING, _LIST, _COMPOUND = 1, 2, 3, 4, 8, 9, 10  # tag types
_BATCH_BYTES = 1 << 22  # processed per batch
_MAX_FIELDS = 16  # of a compound for the fast path


def rows_like(first: Mapping[str, Any], size: int, data: bytes, at: int, count: int) -> list[dict[str, Any]]:
    """Return up to ``count`` compounds from byte ``at`` with the layout of ``first``, which is ``size`` bytes long.

    The layout consists of ints and lists of ints under the same names; the result is empty if ``first`` has other
    fields or too many.
    """
    values = list(first.values())
    if len(values) > _MAX_FIELDS or not all(type(value) is int or _is_ints(value) for value in values):
        return []
    heads = [_head(name, value) for name, value in first.items()]
    fields: list[Any] = []
    for i, (head, value) in enumerate(zip(heads, values)):
        shape = () if type(value) is int else (len(value),)
        fields += [(f"head{i}", np.uint8, (len(head),)), (f"value{i}", ">i4", shape)]
    layout = np.dtype([*fields, ("end", np.uint8)])
    if layout.itemsize != size:
        return []
    rows = np.frombuffer(data, layout, min(count, 1 + _BATCH_BYTES // size, (len(data) - at) // size), at)
    is_alike = rows["end"] == 0
    for i, head in enumerate(heads):
        is_alike &= (rows[f"head{i}"] == np.frombuffer(head, np.uint8)).all(axis=1)
    rows = rows[: len(rows) if is_alike.all() else int(np.argmin(is_alike))]
    columns = [_column(rows[f"value{i}"]) for i in range(len(values))]
    return [dict(zip(first, row)) for row in zip(*columns)]


def _column(values: np.ndarray[Any, Any]) -> list[Any]:
    """Return the values of a field of all rows."""
    return values.tolist() if values.ndim == 1 else list(values)


def _is_ints(value: Any) -> bool:
    """Return whether a value is a list of 32-bit integers."""
    return isinstance(value, np.ndarray) and value.dtype == np.dtype(">i4") and len(value) > 0


def _head(name: str, value: Any) -> bytes:
    """Return the bytes before the numbers of a field."""
    label = name.encode("utf-8", "replace")
    if type(value) is int:
        return pack(">bH", _INT, len(label)) + label
    return pack(">bH", _LIST, len(label)) + label + pack(">bi", _INT, len(value))


LARGEST = 512_000_000  # bytes, compressed and uncompressed
MAX_TAGS = 8_000_000  # of a file
DEEPEST = 200  # nesting of lists and compounds; each level is a recursive call
_MIN_FAST_RUN = 16  # compounds for which the fast path does not pay
_MAX_FAST_FAILURES = 200  # unsuccessful attempts at the fast path per list
_NUMBERS = {1: Struct(">b"), 2: Struct(">h"), 3: Struct(">i"), 4: Struct(">q"), 5: Struct(">f"), 6: Struct(">d")}
_TYPES = {kind: np.dtype(name) for kind, name in enumerate((">i1", ">i2", ">i4", ">i8", ">f4", ">f8"), 1)}
_ARRAYS = {7: _TYPES[1], 11: _TYPES[3], 12: _TYPES[4]}
_COUNT, _LENGTH = Struct(">i"), Struct(">H")


def read_nbt(path: Path, largest: int = LARGEST) -> dict[str, Any]:
    """Read the root compound of a file compressed with gzip or zlib, or uncompressed.

    Raises Damaged if it is invalid, larger than ``largest`` bytes, has more than MAX_TAGS tags or is nested deeper
    than DEEPEST; OSError if the file cannot be read.
    """
    if path.stat().st_size > largest:
        raise Damaged(f"larger than the limit of {largest:,} bytes")
    reader = _Reader(_unpacked(read_regular(path), largest))
    if reader.kind() != _COMPOUND:
        raise Damaged("missing root compound")
    reader.text()
    return reader.compound(0)


def _unpacked(data: bytes, largest: int) -> bytes:
    """Decompress ``data`` according to its first bytes, up to ``largest`` bytes."""
    if data[:2] != b"\x1f\x8b" and data[:1] != b"\x78":
        return data
    unpacker = zlib.decompressobj(wbits=47)  # gzip or zlib, detected automatically
    try:
        unpacked = unpacker.decompress(data, largest + 1)
    except zlib.error:
        raise Damaged("corrupt compressed data") from None
    if len(unpacked) > largest:
        raise Damaged(f"decompresses to more than the limit of {largest:,} bytes")
    if not unpacker.eof:
        raise Damaged("unexpected end of data")
    return unpacked


class _Reader:
    """Reader with the current position and the number of tags that may still follow."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._at = 0
        self._tags = MAX_TAGS

    def kind(self) -> int:
        """Read a tag type byte."""
        return self._take(1)[0]

    def text(self) -> str:
        """Read a string; non-ASCII characters in Java's modified UTF-8 may be lost, but block names are ASCII."""
        (length,) = _LENGTH.unpack(self._take(2))
        return self._take(length).decode("utf-8", "replace")

    def compound(self, depth: int) -> dict[str, Any]:
        """Read a compound at nesting level ``depth``."""
        fields: dict[str, Any] = {}
        while kind := self.kind():
            name = self.text()
            fields[name] = self._payload(kind, depth)
        return fields

    def _payload(self, kind: int, depth: int) -> Any:
        """Read the value of a tag; raises Damaged for too many or too deeply nested tags."""
        self._tags -= 1
        if self._tags < 0:
            raise Damaged(f"more than the limit of {MAX_TAGS:,} tags")
        number = _NUMBERS.get(kind)
        if number is not None:
            return number.unpack(self._take(number.size))[0]
        if kind == _STRING:
            return self.text()
        if kind in _ARRAYS:
            return self._array(_ARRAYS[kind], self._count())
        if depth >= DEEPEST:
            raise Damaged(f"nested deeper than the limit of {DEEPEST} levels")
        if kind == _COMPOUND:
            return self.compound(depth + 1)
        if kind == _LIST:
            return self._list(depth + 1)
        raise Damaged(f"unknown tag type {kind}")

    def _list(self, depth: int) -> Any:
        """Read a list; a list of numbers becomes an array."""
        kind, count = self.kind(), self._count()
        if not count:
            return []
        if kind in _TYPES:
            return self._array(_TYPES[kind], count)
        if kind == _COMPOUND:
            return self._compounds(count, depth)
        return [self._payload(kind, depth) for _ in range(count)]

    def _compounds(self, count: int, depth: int) -> list[dict[str, Any]]:
        """Read ``count`` compounds, using the fast path for runs of equal layout as long as that pays."""
        compounds: list[dict[str, Any]] = []
        remaining_tries = _MAX_FAST_FAILURES
        while len(compounds) < count:
            start = self._at
            compounds.append(self._payload(_COMPOUND, depth))
            if remaining_tries and count - len(compounds) > _MIN_FAST_RUN:
                size = self._at - start
                alike = rows_like(compounds[-1], size, self._data, self._at, count - len(compounds))
                remaining_tries -= len(alike) < _MIN_FAST_RUN
                self._at += size * len(alike)
                self._tags -= len(alike) * (1 + len(compounds[-1]))
                compounds += alike
        return compounds

    def _array(self, dtype: np.dtype[Any], count: int) -> npt.NDArray[Any]:
        """Read an array of ``count`` numbers."""
        return np.frombuffer(self._take(count * dtype.itemsize), dtype)

    def _count(self) -> int:
        """Read a length; negative ones count as 0, as in the game."""
        return max(0, int(_COUNT.unpack(self._take(4))[0]))

    def _take(self, count: int) -> bytes:
        """Consume the next ``count`` bytes."""
        end = self._at + count
        if end > len(self._data):
            raise Damaged("unexpected end of data")
        start, self._at = self._at, end
        return self._data[start:end]


# Writing NBT. Plain values become tags: ``dict`` a compound, ``str`` a string, ``int`` an int, ``Byte``, ``Short`` and
# ``Long`` the corresponding types, numpy arrays of 8, 32 and 64 bits arrays, a ``list`` a list with the type of its
# first item, ``Compounds`` a list of compounds.


_GZIP_LEVEL = 5  # of gzip: a higher level takes twice as long for a few percent
_ARRAYS_BY_SIZE = {1: (7, ">i1"), 4: (11, ">i4"), 8: (12, ">i8")}  # by item size in bytes


class Byte(int):
    """A one-byte integer."""


class Short(int):
    """A two-byte integer, from 0 to 65,535, since lengths are read as unsigned."""


class Long(int):
    """An eight-byte integer."""


@dataclass(frozen=True, slots=True)
class Compounds:
    """A list of ``count`` serialized compounds."""

    count: int
    data: bytes


def write_nbt(path: Path, name: str, root: Mapping[str, Any]) -> None:
    """Write the compound ``root`` named ``name``, compressed with gzip, atomically; raises SceneError("file")."""
    with (
        atomic_write(path) as temporary,
        temporary.open("wb") as file,
        gzip.GzipFile("", "wb", _GZIP_LEVEL, file, mtime=0) as packed,
    ):
        for piece in (bytes([_COMPOUND]), _text(name), *_payload(root)):
            packed.write(piece)


def _kind(value: Any) -> int:
    """Return the tag type of a value."""
    if isinstance(value, np.ndarray):
        return _ARRAYS_BY_SIZE[value.dtype.itemsize][0]
    kinds = {Byte: _BYTE, Short: _SHORT, Long: _LONG, int: _INT, str: _STRING, dict: _COMPOUND}
    return kinds.get(type(value), _LIST)


def _payload(value: Any) -> Iterator[bytes]:
    """Yield the bytes of a value without its type and name."""
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
    """Yield the bytes of a list."""
    if isinstance(value, Compounds):
        yield pack(">bi", _COMPOUND if value.count else 0, value.count)
        yield value.data
        return
    yield pack(">bi", _kind(value[0]) if value else 0, len(value))
    for item in value:
        yield from _payload(item)


def _text(text: str) -> bytes:
    """Encode a string in Java's modified UTF-8: NUL as two bytes, characters beyond 16 bits as surrogate pairs."""
    units = text.encode("utf-16-be", "surrogatepass")
    halves = "".join(chr(units[i] << 8 | units[i + 1]) for i in range(0, len(units), 2))
    data = halves.encode("utf-8", "surrogatepass").replace(b"\0", b"\xc0\x80")
    return pack(">H", len(data)) + data


# Encodings of cell indices: variable-length integers, and fixed-width integers packed in longs.


Numbers = npt.NDArray[np.uint32]
Bytes = npt.NDArray[np.uint8]
Longs = npt.NDArray[np.uint64]

_GROUP_SIZE = 64  # numbers: 64 numbers of n bits fill exactly n longs
_BATCH_NUMBERS = 1 << 20  # numbers processed per batch
_MAX_VARINT_BYTES = 5  # bytes of a 32-bit number, with seven bits each


def varints(numbers: Numbers) -> Bytes:
    """Encode ``numbers`` (N,) as LEB128.

    That is seven bits per byte, lowest first, with the high bit set except in the last byte.
    """
    if not len(numbers) or int(numbers.max()) < 0x80:
        return numbers.astype(np.uint8)
    return np.concatenate([_varints(numbers[i : i + _BATCH_NUMBERS]) for i in range(0, len(numbers), _BATCH_NUMBERS)])


def _varints(numbers: Numbers) -> Bytes:
    """Encode one batch of numbers, one byte position after the other."""
    lengths = np.ones(len(numbers), np.int64)
    for n in range(1, _MAX_VARINT_BYTES):
        lengths += numbers >= np.uint32(1 << (7 * n))
    starts = np.cumsum(lengths) - lengths
    out = np.zeros(int(lengths.sum()), np.uint8)
    for n in range(int(lengths.max())):
        has = lengths > n
        more = np.where(lengths[has] > n + 1, 0x80, 0).astype(np.uint32)
        out[starts[has] + n] = (numbers[has] >> np.uint32(7 * n) & np.uint32(0x7F)) | more
    return out


def from_varints(data: Bytes, count: int) -> Numbers:
    """Decode ``count`` numbers encoded by ``varints``; raises Damaged for a different number, or for overlong ones."""
    last = data < 0x80
    if int(np.count_nonzero(last)) != count or (len(data) and not last[-1]):
        raise Damaged(f"the number of its blocks does not match its size of {count:,} cells")
    if len(data) == count:
        return data.astype(np.uint32)
    numbers = np.empty(count, np.uint32)
    ends = np.flatnonzero(last)
    for at in range(0, count, _BATCH_NUMBERS):
        part = ends[at : at + _BATCH_NUMBERS]
        starts = np.concatenate(([ends[at - 1] + 1 if at else 0], part[:-1] + 1))
        numbers[at : at + len(part)] = _from_varints(data, starts, part - starts + 1)
    return numbers


def _from_varints(data: Bytes, starts: npt.NDArray[np.int64], lengths: npt.NDArray[np.int64]) -> Numbers:
    """Decode one batch of numbers that begin at ``starts`` and have ``lengths`` bytes."""
    if int(lengths.max()) > _MAX_VARINT_BYTES:
        raise Damaged("a block index is encoded in too many bytes")
    numbers = np.zeros(len(starts), np.uint32)
    for n in range(int(lengths.max())):
        has = lengths > n
        numbers[has] |= (data[starts[has] + n].astype(np.uint32) & np.uint32(0x7F)) << np.uint32(7 * n)
    return numbers


def long_count(count: int, bits: int) -> int:
    """Return the number of longs that ``count`` numbers of ``bits`` bits occupy."""
    return -(-count * bits // 64)


def packed_longs(numbers: Numbers, bits: int) -> Longs:
    """Pack ``numbers`` (N,) of ``bits`` bits into longs, lowest bits first; numbers may span two longs."""
    out = np.zeros((-(-len(numbers) // _GROUP_SIZE), bits), np.uint64)
    for i in range(_GROUP_SIZE):
        column = numbers[i::_GROUP_SIZE].astype(np.uint64)
        word, shift = divmod(i * bits, 64)
        out[: len(column), word] |= column << np.uint64(shift)
        if shift + bits > 64:
            out[: len(column), word + 1] |= column >> np.uint64(64 - shift)
    return out.reshape(-1)[: long_count(len(numbers), bits)]


def from_packed_longs(longs: Longs, count: int, bits: int) -> Numbers:
    """Unpack ``count`` numbers packed by ``packed_longs``; raises Damaged if ``longs`` is too short."""
    if len(longs) < long_count(count, bits):
        raise Damaged(f"the number of its blocks does not match its size of {count:,} cells")
    groups = -(-count // _GROUP_SIZE)
    rows = np.zeros(groups * bits, np.uint64)
    rows[: min(len(longs), len(rows))] = longs[: len(rows)]
    table = rows.reshape(groups, bits)
    numbers = np.empty((groups, _GROUP_SIZE), np.uint32)
    mask = np.uint64((1 << bits) - 1)
    for i in range(_GROUP_SIZE):
        word, shift = divmod(i * bits, 64)
        column = table[:, word] >> np.uint64(shift)
        if shift + bits > 64:
            column |= table[:, word + 1] << np.uint64(64 - shift)
        numbers[:, i] = column & mask
    return numbers.reshape(-1)[:count]

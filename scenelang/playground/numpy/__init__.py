"""Arrays in plain Python, under the names of numpy: what the interpreter uses of numpy, for Pyodide without packages.

The playground puts this folder on the module path as ``numpy``; nothing else imports it. An array is a view (shape,
strides, offset) of a flat list, so that basic indexing shares memory as in numpy. Elements are Python's numbers, which
lists keep without conversion; 32-bit floats and fixed-size integers are rounded when an array is made. Operations map
C functions over flat lists, and fall back to IEEE rules (``_ieee``) only where Python raises.

A name that is missing raises ``MissingError`` through ``__getattr__`` of this module, a coded diagnostic at the call's
place. ``tests/playground`` compares each function with numpy's.
"""

from __future__ import annotations

import builtins
import math
import operator
from array import array as _native
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import reduce
from itertools import accumulate, chain, pairwise, product
from itertools import repeat as _repeat
from typing import Any

from scenelang.playground import MissingError

__version__ = "2.0.0"  # the interface whose names and promotion of types these are

inf = math.inf
nan = math.nan
pi = math.pi
e = math.e
newaxis = None

_List = list[Any]
_Shape = tuple[int, ...]


# --- types of elements -------------------------------------------------------------------------------------------


class generic:
    """Base of the types of elements."""

    def __class_getitem__(cls, item: Any) -> Any:
        return cls


class number(generic):
    """Base of numeric types."""


class floating(number):
    """Base of types of floating-point numbers."""


class integer(number):
    """Base of types of integers."""


def _safe(name: str) -> Callable[[Any, Any], Any]:
    """Return an operation of scalars that follows IEEE rules where Python's float raises."""
    plain = getattr(float, name)

    def operate(self: Any, other: Any) -> Any:
        try:
            result = plain(self, other)
        except (ZeroDivisionError, OverflowError, ValueError):
            a, b = (other, self) if name.startswith("__r") and name != "__round__" else (self, other)
            result = _IEEE[name.replace("__r", "__")](float(a), float(b))
        return float64(result) if type(result) is float else result

    return operate


class _Scalar:
    """What a number taken out of an array has of an array's methods."""

    shape: _Shape = ()
    ndim = 0
    size = 1

    def item(self) -> Any:
        return self.tolist()

    def tolist(self) -> Any:
        return float(self) if isinstance(self, float) else int(self)  # type: ignore[call-overload]

    def astype(self, kind: Any) -> Any:
        return asarray(self).astype(kind)[()]

    def copy(self) -> Any:
        return self

    def ravel(self) -> ndarray:
        return asarray(self).ravel()

    def reshape(self, *shape: Any) -> ndarray:
        return asarray(self).reshape(*shape)

    def all(self) -> bool:
        return bool(self)

    any = all

    def sum(self) -> Any:
        return self

    max = min = sum

    def clip(self, low: Any, high: Any) -> Any:
        return clip(self, low, high)

    def round(self, digits: int = 0) -> Any:
        return round(self, digits)

    def __getitem__(self, key: Any) -> Any:
        return asarray(self)[key]


class float64(_Scalar, float, floating):
    """64-bit float; a subclass of Python's, which divides by zero as IEEE says."""

    @property
    def dtype(self) -> dtype:
        return _F8

    __add__, __radd__, __sub__, __rsub__ = map(_safe, ("__add__", "__radd__", "__sub__", "__rsub__"))
    __mul__, __rmul__, __truediv__ = map(_safe, ("__mul__", "__rmul__", "__truediv__"))
    __rtruediv__, __pow__, __rpow__ = map(_safe, ("__rtruediv__", "__pow__", "__rpow__"))  # type: ignore[assignment]

    def __neg__(self) -> float64:
        return float64(-float(self))

    def __abs__(self) -> float64:
        return float64(builtins.abs(float(self)))

    def __repr__(self) -> str:
        return f"np.float64({float(self)!r})"

    __str__ = float.__repr__


class float32(_Scalar, float, floating):
    """32-bit float, kept as the double that it is."""

    def __new__(cls, value: Any = 0.0) -> float32:
        return super().__new__(cls, _round32([float(value)])[0])

    @property
    def dtype(self) -> dtype:
        return _F4


class float16(floating):
    """16-bit float; only its name is known."""


class int64(_Scalar, int, integer):
    """64-bit integer; a subclass of Python's."""

    @property
    def dtype(self) -> dtype:
        return _I8


class int32(int64):
    """32-bit integer."""


class int16(int64):
    """16-bit integer."""


class int8(int64):
    """8-bit integer."""


class uint64(int64):
    """64-bit unsigned integer, of which the largest are no others."""

    @property
    def dtype(self) -> dtype:
        return _U8


class uint32(int64):
    """32-bit unsigned integer."""


class uint16(int64):
    """16-bit unsigned integer."""


class uint8(int64):
    """8-bit unsigned integer."""


class bool_(generic):
    """Truth value; elements are Python's."""

    def __new__(cls, value: Any = False) -> Any:
        return bool(value)


class object_(generic):
    """Any object."""


class str_(str, generic):
    """Text."""


class complex128(complex, generic):
    """Complex number."""


class void(generic):
    """Bytes of a fixed number, seen as one element."""


intp = int64
uintp = uint64
complexfloating = complex128


class dtype:
    """Type of the elements of an array; equal to the scalar type and to the names that numpy has for it."""

    __slots__ = ("code", "itemsize", "kind", "name", "type")
    code: Any
    itemsize: int
    kind: Any
    name: Any
    type: Any

    def __new__(cls, spec: Any = float64) -> dtype:
        return _dtype(spec)

    @classmethod
    def _make(cls, name: str, kind: str, itemsize: int, scalar: Any, code: str) -> dtype:
        self = super().__new__(cls)
        self.name, self.kind, self.itemsize, self.type, self.code = name, kind, itemsize, scalar, code
        return self

    @property
    def str(self) -> str:
        mark = "|" if self.itemsize == 1 or self.kind in "OV" else "<"
        return f"{mark}{self.kind}{'' if self.kind == 'O' else self.itemsize}"

    def newbyteorder(self, order: Any = None) -> dtype:
        return self

    def __eq__(self, other: Any) -> bool:
        try:
            return _dtype(other) is self
        except (TypeError, KeyError):
            return False

    def __hash__(self) -> int:
        return hash(self.name)

    def __repr__(self) -> Any:
        return f"dtype({self.name!r})"


_F8 = dtype._make("float64", "f", 8, float64, "d")
_F4 = dtype._make("float32", "f", 4, float32, "f")
_I8 = dtype._make("int64", "i", 8, int64, "q")
_I4 = dtype._make("int32", "i", 4, int32, "i")
_I2 = dtype._make("int16", "i", 2, int16, "h")
_I1 = dtype._make("int8", "i", 1, int8, "b")
_U8 = dtype._make("uint64", "u", 8, uint64, "Q")
_U4 = dtype._make("uint32", "u", 4, uint32, "I")
_U2 = dtype._make("uint16", "u", 2, uint16, "H")
_U1 = dtype._make("uint8", "u", 1, uint8, "B")
_B1 = dtype._make("bool", "b", 1, bool_, "?")
_OBJECT = dtype._make("object", "O", 8, object_, "")
_TEXT = dtype._make("str", "U", 4, str_, "")
_COMPLEX = dtype._make("complex128", "c", 16, complex128, "")
_TYPES = (_F8, _F4, _I8, _I4, _I2, _I1, _U8, _U4, _U2, _U1, _B1, _OBJECT, _TEXT, _COMPLEX)
_BY_NAME: dict[Any, dtype] = {kind.name: kind for kind in _TYPES}
_BY_NAME |= {kind.type: kind for kind in _TYPES}
_BY_NAME |= {kind.str: kind for kind in _TYPES if kind.kind != "O"}
_BY_NAME |= {kind.str[1:]: kind for kind in _TYPES}
_BY_NAME |= {float: _F8, int: _I8, bool: _B1, object: _OBJECT, str: _TEXT, complex: _COMPLEX}
_BY_NAME |= {"float": _F8, "int": _I8, ">u4": _U4, "U": _TEXT}


def _dtype(spec: Any) -> dtype:
    if isinstance(spec, dtype):
        return spec
    if spec is None:
        return _F8
    try:
        return _BY_NAME[spec]
    except KeyError:
        raise TypeError(f"no element type {spec!r}") from None


def _round32(values: Iterable[float]) -> _List:
    """Return floats as the nearest 32-bit ones."""
    return _native("f", values).tolist()


def _wrap(values: _List, kind: dtype) -> _List:
    """Return integers modulo the size of a type."""
    bits = 8 * kind.itemsize
    low, high = (-(1 << (bits - 1)), (1 << (bits - 1)) - 1) if kind.kind == "i" else (0, (1 << bits) - 1)
    if not values or (low <= builtins.min(values) and builtins.max(values) <= high):
        return values
    mask = (1 << bits) - 1
    return [((value - low) & mask) + low for value in values]


def _as_integer(value: Any) -> int:
    try:
        return int(value)
    except (ValueError, OverflowError):  # not a number, or infinite
        return -(1 << 63)


def _converted(values: _List, kind: dtype) -> _List:
    """Return elements as those of a type."""
    letter = kind.kind
    if letter == "f":
        return _round32(values) if kind is _F4 else list(map(float, values))
    if letter in "iu":
        try:
            return _wrap(list(map(int, values)), kind)
        except (ValueError, OverflowError):
            return _wrap(list(map(_as_integer, values)), kind)
    if letter == "b":
        return list(map(bool, values))
    if letter == "U":
        return list(map(str, values))
    if letter == "c":
        return list(map(complex, values))
    return list(values)


def _kind_of(values: Iterable[Any]) -> dtype:
    """Return the type that numpy gives a list of Python's numbers."""
    types = set(map(type, values))
    if types <= {bool}:
        return _B1 if types else _F8
    if all_in(types, (uint64,)):
        return _U8
    if all_in(types, (bool, int)):
        return _I8
    if all_in(types, (float32,)):
        return _F4
    if all_in(types, (bool, int, float)):
        return _F8
    if all_in(types, (str,)):
        return _TEXT
    if all_in(types, (bool, int, float, complex)):
        return _COMPLEX
    return _OBJECT


def all_in(types: set[type], bases: tuple[type, ...]) -> bool:
    """Return whether all types are subclasses of some of ``bases``."""
    return builtins.all(issubclass(each, bases) for each in types)


_RANK = {"b": 0, "u": 1, "i": 1, "f": 2, "c": 3, "O": 4, "U": 4}


def result_type(*kinds: Any) -> dtype:
    """Return the type of what an operation of these types gives."""
    return reduce(_promoted, [each.dtype if isinstance(each, ndarray) else _dtype(each) for each in kinds])


def _promoted(a: dtype, b: dtype) -> dtype:
    if a is b:
        return a
    if _RANK[a.kind] != _RANK[b.kind]:
        low, high = (a, b) if _RANK[a.kind] < _RANK[b.kind] else (b, a)
        return _F8 if high is _F4 and low.kind in "iu" and low.itemsize > 2 else high
    if a.kind != b.kind:  # signed and unsigned
        unsigned, signed = (a, b) if a.kind == "u" else (b, a)
        if unsigned.itemsize < signed.itemsize:
            return signed
        return {1: _I2, 2: _I4, 4: _I8, 8: _F8}[unsigned.itemsize]
    return a if a.itemsize >= b.itemsize else b


# --- the array -----------------------------------------------------------------------------------------------------


def _strides_of(shape: _Shape) -> _Shape:
    """Return the strides of a contiguous array, in elements."""
    strides, step = [], 1
    for extent in reversed(shape):
        strides.append(step)
        step *= extent
    return tuple(reversed(strides))


def _size_of(shape: _Shape) -> int:
    return math.prod(shape)


def _spread(shape: _Shape, strides: _Shape, start: int = 0) -> _List:
    """Return the offsets of the elements of a strided block, in C order."""
    offsets = [start]
    for extent, stride in zip(shape, strides, strict=True):
        steps = range(0, extent * stride, stride) if stride else [0] * extent
        offsets = [base + step for base in offsets for step in steps] if len(offsets) > 1 else [
            offsets[0] + step for step in steps
        ] if offsets else []  # fmt: skip
    return offsets


def _regrouped(shape: _Shape, strides: _Shape, new: _Shape) -> _Shape | None:
    """Return the strides of a strided block under another shape, None if only a copy has this shape.

    Axes are joined and split in groups of equal size; the axes of a group must follow each other in memory.
    """
    if not math.prod(shape):
        return _strides_of(new)
    old = [(extent, stride) for extent, stride in zip(shape, strides, strict=True) if extent != 1]
    result: list[int] = []
    i = j = 0
    while j < len(new):
        if new[j] == 1:
            result.append(0)
            j += 1
            continue
        size, first, last, split = old[i][0], i, i + 1, j + 1
        total = new[j]
        while size != total:
            if size < total:
                size *= old[last][0]
                last += 1
            else:
                total *= new[split]
                split += 1
        if builtins.any(old[k][1] != old[k + 1][0] * old[k + 1][1] for k in range(first, last - 1)):
            return None
        step, steps = old[last - 1][1], []
        for extent in reversed(new[j:split]):
            steps.append(step)
            step *= extent
        result += reversed(steps)
        i, j = last, split
    return tuple(result)


class ndarray:
    """Array of numbers; see the module."""

    __slots__ = ("_buffer", "_offset", "_strides", "_writes", "base", "dtype", "shape")
    __array_priority__ = 1.0
    __hash__ = None  # type: ignore[assignment]
    _buffer: _List
    _offset: int
    _strides: _Shape
    _writes: bool
    base: Any
    dtype: Any
    shape: _Shape

    def __init__(self, shape: Any, dtype: Any = None) -> None:
        extents = _extents(shape)
        kind = _dtype(dtype)
        zero = {"f": 0.0, "b": False, "O": None, "U": "", "c": 0j}.get(kind.kind, 0)
        self._set([zero] * _size_of(extents), extents, kind)

    def _set(self, flat: _List, shape: _Shape, kind: dtype) -> None:
        self._buffer, self.shape, self.dtype = flat, shape, kind
        self._strides, self._offset, self.base, self._writes = _strides_of(shape), 0, None, True

    # --- memory

    @property
    def size(self) -> int:
        return math.prod(self.shape)

    @property
    def ndim(self) -> int:
        return len(self.shape)

    @property
    def itemsize(self) -> int:
        return self.dtype.itemsize

    @property
    def nbytes(self) -> int:
        return self.size * self.dtype.itemsize

    @property
    def flags(self) -> Any:
        return _Flags(self._writes)

    @property
    def T(self) -> ndarray:
        return self.transpose()

    @property
    def flat(self) -> Iterator[Any]:
        return iter(self._flat())

    @property
    def real(self) -> ndarray:
        return self if self.dtype.kind != "c" else _made([value.real for value in self._flat()], self.shape, _F8)

    @property
    def imag(self) -> ndarray:
        flat = [value.imag if isinstance(value, complex) else 0.0 for value in self._flat()]
        return _made(flat, self.shape, _F8)

    def setflags(self, write: bool = True) -> None:
        self._writes = write

    def _is_contiguous(self) -> bool:
        return self._strides == _strides_of(self.shape)

    def _flat(self) -> _List:
        """Return the elements in C order, as a list of its own."""
        shape, strides, start, buffer = self.shape, self._strides, self._offset, self._buffer
        if strides == _strides_of(shape):
            return buffer[start : start + math.prod(shape)]
        if not math.prod(shape):
            return []
        *outer, extent = shape
        *steps, stride = strides
        rows = _spread(tuple(outer), tuple(steps), start)
        if stride > 0:
            reach = (extent - 1) * stride + 1
            return list(chain.from_iterable(buffer[row : row + reach : stride] for row in rows))
        if stride == 0:
            return list(chain.from_iterable([buffer[row]] * extent for row in rows))
        steps_ = range(0, extent * stride, stride)
        return [buffer[row + step] for row in rows for step in steps_]

    def _view(self, shape: _Shape, strides: _Shape, offset: int) -> ndarray:
        view = _new()
        view._buffer, view.shape, view.dtype, view._strides = self._buffer, shape, self.dtype, strides
        view._offset, view.base, view._writes = offset, self if self.base is None else self.base, self._writes
        return view

    # --- conversions

    def tolist(self) -> Any:
        flat = self._flat()
        if not self.shape:
            return flat[0]
        for extent in reversed(self.shape[1:]):
            flat = [flat[i : i + extent] for i in range(0, len(flat), extent)] if extent else [
                [] for _ in range(_size_of(self.shape[: self.shape.index(0)]))
            ]  # fmt: skip
        return flat

    def item(self, *index: int) -> Any:
        value = self[index] if index else self._flat()[0]
        return value.tolist() if isinstance(value, _Scalar) else value

    def tobytes(self) -> bytes:
        flat = self._flat()
        if self.dtype.kind == "b":
            return bytes(flat)
        return _native(self.dtype.code, flat).tobytes()

    def copy(self, order: str = "C") -> ndarray:
        return _made(self._flat(), self.shape, self.dtype)

    __copy__ = copy

    def __deepcopy__(self, memo: Any) -> ndarray:
        return self.copy()

    def __reduce__(self) -> Any:
        return _made, (self._flat(), self.shape, self.dtype.name)

    def astype(self, kind: Any, copy: bool = True) -> ndarray:
        kind = _dtype(kind)
        if kind is self.dtype and not copy:
            return self
        flat = self._flat()
        return _made(flat if kind is self.dtype else _converted(flat, kind), self.shape, kind)

    def view(self, kind: Any) -> ndarray:
        kind = _dtype(kind)
        code, flat = self.dtype.code, self._flat()
        values = _native(kind.code)
        values.frombytes(_native(code, flat).tobytes())
        last = self.shape[-1] * self.dtype.itemsize // kind.itemsize
        return _made(values.tolist(), (*self.shape[:-1], last), kind)

    def __len__(self) -> int:
        if not self.shape:
            raise TypeError("len() of unsized object")
        return self.shape[0]

    def __iter__(self) -> Iterator[Any]:
        if not self.shape:
            raise TypeError("iteration over a 0-d array")
        if len(self.shape) == 1:
            return map(_scalar_type(self.dtype), self._flat())
        return (self[i] for i in range(self.shape[0]))

    def __bool__(self) -> bool:
        if self.size != 1:
            raise ValueError("The truth value of an array with more than one element is ambiguous.")
        return bool(self._flat()[0])

    def __float__(self) -> float:
        return float(self._only())

    def __int__(self) -> int:
        return int(self._only())

    def __index__(self) -> int:
        if self.dtype.kind not in "iub":
            raise TypeError("only integer scalar arrays can be converted to a scalar index")
        return int(self._only())

    def _only(self) -> Any:
        if self.size != 1:
            raise TypeError("only length-1 arrays can be converted to Python scalars")
        return self._flat()[0]

    def __repr__(self) -> str:
        return f"array({self.tolist()!r})"

    # --- indexing

    def __getitem__(self, key: Any) -> Any:
        if type(key) is int and len(self.shape) == 1:
            extent = self.shape[0]
            if not -extent <= key < extent:
                raise IndexError(f"index {key} is out of bounds for axis 0 with size {extent}")
            return _scalar_type(self.dtype)(self._buffer[self._offset + (key % extent) * self._strides[0]])
        view, advanced = self._located(key)
        if advanced is None:
            if not view.shape and not (key is Ellipsis or (isinstance(key, tuple) and Ellipsis in _plain(key))):
                return _scalar_type(self.dtype)(self._buffer[view._offset])
            return view
        positions, shape = _gathered(view, advanced)
        buffer = self._buffer
        return _made([buffer[i] for i in positions], shape, self.dtype)

    def __setitem__(self, key: Any, value: Any) -> None:
        if not self._writes:
            raise ValueError("assignment destination is read-only")
        view, advanced = self._located(key)
        if advanced is None:
            shape = view.shape
            positions: Sequence[int] = _spread(shape, view._strides, view._offset)
        else:
            positions, shape = _gathered(view, advanced)
        values = _cast_to(value, shape, self.dtype)
        buffer = self._buffer
        for i, element in zip(positions, values, strict=True):
            buffer[i] = element

    def _located(self, key: Any) -> tuple[ndarray, dict[int, ndarray] | None]:
        """Return the view that slices and integers select, and index arrays by axis of this view, if there are any."""
        keys = _expanded(key if isinstance(key, tuple) else (key,), len(self.shape))
        is_advanced = builtins.any(isinstance(each, ndarray) for each in keys)
        shape, strides, offset, axis = [], [], self._offset, 0
        advanced: dict[int, ndarray] = {}
        for each in keys:
            if each is None:
                shape.append(1)
                strides.append(0)
                continue
            extent, stride = self.shape[axis], self._strides[axis]
            if isinstance(each, slice):
                start, stop, step = each.indices(extent)
                shape.append(len(range(start, stop, step)))
                strides.append(stride * step)
                offset += start * stride if shape[-1] else 0
            elif isinstance(each, ndarray) or is_advanced:
                advanced[len(shape)] = each if isinstance(each, ndarray) else asarray(each)
                shape.append(extent)
                strides.append(stride)
            else:
                if not -extent <= each < extent:
                    raise IndexError(f"index {each} is out of bounds for axis {axis} with size {extent}")
                offset += (each % extent) * stride
            axis += 1
        return self._view(tuple(shape), tuple(strides), offset), advanced if is_advanced else None

    # --- shapes

    def reshape(self, *shape: Any, order: str = "C") -> ndarray:
        extents = list(_extents(shape[0] if len(shape) == 1 else shape))
        if -1 in extents:
            rest = math.prod(extent for extent in extents if extent != -1)
            extents[extents.index(-1)] = self.size // rest if rest else 0
        if math.prod(extents) != self.size:
            raise ValueError(f"cannot reshape array of size {self.size} into shape {tuple(extents)}")
        shape_ = tuple(extents)
        strides = _strides_of(shape_) if self._is_contiguous() else _regrouped(self.shape, self._strides, shape_)
        if strides is not None:
            return self._view(shape_, strides, self._offset)
        return _made(self._flat(), shape_, self.dtype)

    def ravel(self, order: str = "C") -> ndarray:
        return self.reshape(self.size)

    def flatten(self, order: str = "C") -> ndarray:
        return _made(self._flat(), (self.size,), self.dtype)

    def transpose(self, *axes: Any) -> ndarray:
        order = axes[0] if len(axes) == 1 and not isinstance(axes[0], int) else axes
        order = tuple(order) if order else tuple(range(len(self.shape)))[::-1]
        order = tuple(axis % len(self.shape) for axis in order)
        shape = tuple(self.shape[axis] for axis in order)
        return self._view(shape, tuple(self._strides[axis] for axis in order), self._offset)

    def swapaxes(self, a: int, b: int) -> ndarray:
        order = list(range(len(self.shape)))
        order[a], order[b] = order[b], order[a]
        return self.transpose(order)

    def squeeze(self, axis: int | None = None) -> ndarray:
        drop = [axis % self.ndim] if axis is not None else [i for i, extent in enumerate(self.shape) if extent == 1]
        kept = [i for i in range(self.ndim) if i not in drop]
        return self._view(tuple(self.shape[i] for i in kept), tuple(self._strides[i] for i in kept), self._offset)

    def repeat(self, counts: Any, axis: int | None = None) -> ndarray:
        source = self.ravel() if axis is None else self
        axis = 0 if axis is None else axis % source.ndim
        numbers = asarray(counts)._flat()
        numbers = numbers * source.shape[axis] if len(numbers) == 1 else numbers
        index = list(chain.from_iterable([i] * n for i, n in enumerate(numbers)))
        return take(source, index, axis)

    def fill(self, value: Any) -> None:
        self[...] = value

    # --- reductions

    def sum(
        self, axis: Any = None, dtype: Any = None, out: Any = None, keepdims: bool = False, initial: Any = 0
    ) -> Any:
        kind = _dtype(dtype) if dtype is not None else _summed_type(self.dtype)
        return _reduced(self, axis, lambda row: builtins.sum(row, initial), kind, keepdims=keepdims)

    def prod(self, axis: Any = None, dtype: Any = None, keepdims: bool = False) -> Any:
        return _reduced(self, axis, math.prod, _summed_type(self.dtype), keepdims=keepdims)

    def mean(self, axis: Any = None, keepdims: bool = False) -> Any:
        kind = self.dtype if self.dtype.kind == "f" else _F8
        return _reduced(self, axis, lambda row: builtins.sum(row) / len(row) if row else nan, kind, keepdims=keepdims)

    def max(self, axis: Any = None, keepdims: bool = False, initial: Any = None) -> Any:
        return _reduced(self, axis, _extreme(builtins.max, initial), self.dtype, keepdims=keepdims)

    def min(self, axis: Any = None, keepdims: bool = False, initial: Any = None) -> Any:
        return _reduced(self, axis, _extreme(builtins.min, initial), self.dtype, keepdims=keepdims)

    def all(self, axis: Any = None, keepdims: bool = False) -> Any:
        return _reduced(self, axis, builtins.all, _B1, keepdims=keepdims)

    def any(self, axis: Any = None, keepdims: bool = False) -> Any:
        return _reduced(self, axis, builtins.any, _B1, keepdims=keepdims)

    def argmax(self, axis: Any = None) -> Any:
        return _reduced(self, axis, lambda row: row.index(_extreme(builtins.max, None)(row)), _I8, keepdims=False)

    def argmin(self, axis: Any = None) -> Any:
        return _reduced(self, axis, lambda row: row.index(_extreme(builtins.min, None)(row)), _I8, keepdims=False)

    def cumsum(self, axis: int | None = None, dtype: Any = None, out: ndarray | None = None) -> ndarray:
        result = _accumulated(self, axis, operator.add)
        if out is None:
            return result
        out[...] = result
        return out

    def cumprod(self, axis: int | None = None) -> ndarray:
        return _accumulated(self, axis, operator.mul)

    def sort(self, axis: int = -1, kind: str | None = None) -> None:
        self[...] = sort(self, axis)

    def argsort(self, axis: int = -1, kind: str | None = None) -> ndarray:
        return argsort(self, axis)

    def searchsorted(self, values: Any, side: str = "left") -> Any:
        return searchsorted(self, values, side)

    def clip(self, min: Any = None, max: Any = None, out: ndarray | None = None) -> Any:
        result = clip(self, min, max)
        if out is None:
            return result
        out[...] = result
        return out

    def round(self, digits: int = 0) -> Any:
        return round(self, digits)

    def take(self, index: Any, axis: int | None = None) -> Any:
        return take(self, index, axis)

    def put(self, index: Any, values: Any) -> None:
        put(self, index, values)

    def dot(self, other: Any) -> Any:
        return dot(self, other)

    def trace(self, offset: int = 0, axis1: int = 0, axis2: int = 1) -> Any:
        return self.diagonal(offset, axis1, axis2).sum(axis=-1)

    def diagonal(self, offset: int = 0, axis1: int = 0, axis2: int = 1) -> ndarray:
        axis1, axis2 = axis1 % self.ndim, axis2 % self.ndim
        rest = [axis for axis in range(self.ndim) if axis not in (axis1, axis2)]
        rows, columns = self.shape[axis1], self.shape[axis2]
        extent = builtins.max(0, builtins.min(rows + builtins.min(offset, 0), columns - builtins.max(offset, 0)))
        start = offset * self._strides[axis2] if offset > 0 else -offset * self._strides[axis1]
        shape = (*(self.shape[axis] for axis in rest), extent)
        strides = (*(self._strides[axis] for axis in rest), self._strides[axis1] + self._strides[axis2])
        return self._view(shape, strides, self._offset + start)

    def nonzero(self) -> tuple[ndarray, ...]:
        return nonzero(self)

    def compress(self, condition: Any) -> ndarray:
        result: ndarray = self[asarray(condition, bool)]
        return result

    def partition(self, kth: int) -> None:
        self.sort()

    # --- operators; the functions are below

    def __add__(self, other: Any) -> Any:
        return add(self, other)

    def __radd__(self, other: Any) -> Any:
        return add(other, self)

    def __sub__(self, other: Any) -> Any:
        return subtract(self, other)

    def __rsub__(self, other: Any) -> Any:
        return subtract(other, self)

    def __mul__(self, other: Any) -> Any:
        return multiply(self, other)

    def __rmul__(self, other: Any) -> Any:
        return multiply(other, self)

    def __truediv__(self, other: Any) -> Any:
        return divide(self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return divide(other, self)

    def __floordiv__(self, other: Any) -> Any:
        return floor_divide(self, other)

    def __rfloordiv__(self, other: Any) -> Any:
        return floor_divide(other, self)

    def __mod__(self, other: Any) -> Any:
        return mod(self, other)

    def __rmod__(self, other: Any) -> Any:
        return mod(other, self)

    def __pow__(self, other: Any) -> Any:
        return power(self, other)

    def __rpow__(self, other: Any) -> Any:
        return power(other, self)

    def __matmul__(self, other: Any) -> Any:
        return matmul(self, other)

    def __rmatmul__(self, other: Any) -> Any:
        return matmul(other, self)

    def __and__(self, other: Any) -> Any:
        return bitwise_and(self, other)

    def __rand__(self, other: Any) -> Any:
        return bitwise_and(other, self)

    def __or__(self, other: Any) -> Any:
        return bitwise_or(self, other)

    def __ror__(self, other: Any) -> Any:
        return bitwise_or(other, self)

    def __xor__(self, other: Any) -> Any:
        return bitwise_xor(self, other)

    def __lshift__(self, other: Any) -> Any:
        return left_shift(self, other)

    def __rlshift__(self, other: Any) -> Any:
        return left_shift(other, self)

    def __rshift__(self, other: Any) -> Any:
        return right_shift(self, other)

    def __neg__(self) -> Any:
        return negative(self)

    def __pos__(self) -> Any:
        return self.copy()

    def __abs__(self) -> Any:
        return absolute(self)

    def __invert__(self) -> Any:
        return invert(self)

    def __eq__(self, other: Any) -> Any:
        return equal(self, other)

    def __ne__(self, other: Any) -> Any:
        return not_equal(self, other)

    def __lt__(self, other: Any) -> Any:
        return less(self, other)

    def __le__(self, other: Any) -> Any:
        return less_equal(self, other)

    def __gt__(self, other: Any) -> Any:
        return greater(self, other)

    def __ge__(self, other: Any) -> Any:
        return greater_equal(self, other)

    def __iadd__(self, other: Any) -> ndarray:
        self[...] = add(self, other)
        return self

    def __isub__(self, other: Any) -> ndarray:
        self[...] = subtract(self, other)
        return self

    def __imul__(self, other: Any) -> ndarray:
        self[...] = multiply(self, other)
        return self

    def __itruediv__(self, other: Any) -> ndarray:
        self[...] = divide(self, other)
        return self

    def __ifloordiv__(self, other: Any) -> ndarray:
        self[...] = floor_divide(self, other)
        return self

    def __ior__(self, other: Any) -> ndarray:
        self[...] = bitwise_or(self, other)
        return self

    def __iand__(self, other: Any) -> ndarray:
        self[...] = bitwise_and(self, other)
        return self

    def __class_getitem__(cls, item: Any) -> Any:
        return cls


class _Flags:
    def __init__(self, writeable: bool) -> None:
        self.writeable = writeable
        self.c_contiguous = True


def _new() -> ndarray:
    return object.__new__(ndarray)


def _made(flat: _List, shape: _Shape, kind: Any) -> ndarray:
    """Return an array that owns a flat list of elements of its type."""
    result = _new()
    result._set(flat, tuple(shape), kind if type(kind) is dtype else _dtype(kind))
    return result


def _extents(shape: Any) -> _Shape:
    if isinstance(shape, (tuple, list, ndarray)):
        return tuple(int(extent) for extent in shape)
    return (int(shape),)


_identity = lambda value: value


def _scalar_type(kind: dtype) -> Callable[[Any], Any]:
    """Return the type of an element that is taken out of an array."""
    if kind.kind == "f":
        return float64 if kind is _F8 else float32
    if kind.kind in "iu":
        scalar: Callable[[Any], Any] = kind.type
        return scalar
    return _identity


def _scalar(value: Any, kind: dtype) -> Any:
    return _scalar_type(kind)(value)


def _plain(key: tuple[Any, ...]) -> list[Any]:
    """Return the items of an index that are no arrays, which cannot be compared."""
    return [each for each in key if not isinstance(each, ndarray)]


def _expanded(key: tuple[Any, ...], ndim: int) -> _List:
    """Return an index with one item an axis: slices, integers, None, and arrays of integers."""
    items: _List = []
    for each in key:
        if isinstance(each, (list, range)):
            each = asarray(each) if len(each) else _made([], (0,), _I8)
        elif isinstance(each, ndarray) and not each.shape and each.dtype.kind in "iu":
            each = int(each)
        if isinstance(each, ndarray) and each.dtype.kind == "b":
            items += nonzero(each)
        elif isinstance(each, bool):
            raise MissingError("an index that is one truth value")
        elif isinstance(each, (slice, ndarray)) or each is None or each is Ellipsis:
            items.append(each)
        else:
            items.append(operator.index(each))
    used = builtins.sum(each is not None and each is not Ellipsis for each in items)
    if used > ndim:
        raise IndexError(f"too many indices for array: array is {ndim}-dimensional, but {used} were indexed")
    missing = [slice(None)] * (ndim - used)
    place = next((i for i, each in enumerate(items) if each is Ellipsis), None)
    if place is None:
        return items + missing
    return items[:place] + missing + items[place + 1 :]


def _gathered(view: ndarray, advanced: dict[int, ndarray]) -> tuple[_List, _Shape]:
    """Return the positions that index arrays select in a view, and the shape of the selection."""
    shape = broadcast_shapes(*(index.shape for index in advanced.values()))
    offsets = [0] * math.prod(shape)
    for axis, index in advanced.items():
        extent, stride = view.shape[axis], view._strides[axis]
        numbers = (index if index.shape == shape else broadcast_to(index, shape))._flat()
        if numbers and not (-extent <= builtins.min(numbers) and builtins.max(numbers) < extent):
            wrong = next(number for number in numbers if not -extent <= number < extent)
            raise IndexError(f"index {wrong} is out of bounds for axis {axis} with size {extent}")
        offsets = [offset + (number % extent) * stride for offset, number in zip(offsets, numbers, strict=True)]
    axes = sorted(advanced)
    is_block = axes[-1] - axes[0] == len(axes) - 1
    first = axes[0] if is_block else 0
    before = [axis for axis in range(first) if axis not in advanced]
    after = [axis for axis in range(first, view.ndim) if axis not in advanced]
    heads = _spread(_at(view.shape, before), _at(view._strides, before), view._offset)
    tails = _spread(_at(view.shape, after), _at(view._strides, after))
    if tails == [0]:
        positions = [head + offset for head in heads for offset in offsets]
    else:
        positions = [base + tail for base in [h + o for h in heads for o in offsets] for tail in tails]
    return positions, (*_at(view.shape, before), *shape, *_at(view.shape, after))


def _at(values: Sequence[int], axes: Sequence[int]) -> _Shape:
    return tuple(values[axis] for axis in axes)


def _cast_to(value: Any, shape: _Shape, kind: dtype) -> _List:
    """Return a value that is assigned as the elements of a shape and a type."""
    if not isinstance(value, ndarray):
        if kind.kind == "O" and not isinstance(value, (list, tuple)):
            return [value] * math.prod(shape)
        value = array(value)
    flat = value._flat() if value.dtype is kind else _converted(value._flat(), kind)
    if value.shape == shape:
        return flat
    extra = value.ndim - len(shape)
    own = value.shape[extra:] if extra > 0 and math.prod(value.shape[:extra]) == 1 else value.shape
    return broadcast_to(_made(flat, own, kind), shape)._flat()


# --- making arrays -------------------------------------------------------------------------------------------------


def array(value: Any, dtype: Any = None, copy: Any = True, ndmin: int = 0) -> ndarray:
    """Return a value as a new array."""
    if isinstance(value, ndarray):
        result = value.astype(value.dtype if dtype is None else dtype)
    elif hasattr(value, "__array__"):
        result = array(value.__array__(), dtype)
    else:
        flat, shape = _flattened(value, objects=dtype is not None and _dtype(dtype).kind == "O")
        kind = _dtype(dtype) if dtype is not None else _kind_of(flat)
        result = _made(_converted(flat, kind), shape, kind)
    return result if result.ndim >= ndmin else result.reshape((1,) * (ndmin - result.ndim) + result.shape)


def _flattened(value: Any, *, objects: bool = False) -> tuple[_List, _Shape]:
    """Return the elements of nested sequences and their shape; raises ValueError where rows differ."""
    if isinstance(value, ndarray):
        return value._flat(), value.shape
    if isinstance(value, (bytes, bytearray, memoryview, _native)):
        return list(value), (len(value),)
    if not isinstance(value, (list, tuple, range)):
        return [value], ()
    if not value:
        return [], (0,)
    first = value[0]
    if not isinstance(first, (list, tuple, range, ndarray, _native)):
        if builtins.any(isinstance(each, (list, tuple, range, ndarray)) for each in value) and not objects:
            raise ValueError("setting an array element with a sequence. The array has an inhomogeneous shape")
        return list(value), (len(value),)
    rows = [_flattened(each, objects=objects) for each in value]
    shape = rows[0][1]
    if builtins.any(row[1] != shape for row in rows):
        raise ValueError("setting an array element with a sequence. The array has an inhomogeneous shape")
    return list(chain.from_iterable(row[0] for row in rows)), (len(rows), *shape)


def asarray(value: Any, dtype: Any = None) -> ndarray:
    """Return a value as an array, itself where it is one of the type."""
    if isinstance(value, ndarray) and (dtype is None or _dtype(dtype) is value.dtype):
        return value
    return array(value, dtype)


def ascontiguousarray(value: Any, dtype: Any = None) -> ndarray:
    """Return a value as an array whose elements are in order."""
    result = asarray(value, dtype)
    return result if result._is_contiguous() else result.copy()


asanyarray = asarray


def zeros(shape: Any, dtype: Any = None) -> ndarray:
    """Return an array of zeros."""
    return ndarray(shape, dtype)


empty = zeros


def ones(shape: Any, dtype: Any = None) -> ndarray:
    """Return an array of ones."""
    return full(shape, 1, _dtype(dtype))


def full(shape: Any, value: Any, dtype: Any = None) -> ndarray:
    """Return an array of one value."""
    extents = _extents(shape)
    filling = asarray(value, dtype)
    if filling.shape:
        return broadcast_to(filling, extents).copy()
    return _made(filling._flat() * math.prod(extents), extents, filling.dtype)


def zeros_like(value: Any, dtype: Any = None) -> ndarray:
    """Return zeros of the shape and type of an array."""
    like = asarray(value)
    return zeros(like.shape, like.dtype if dtype is None else dtype)


empty_like = zeros_like


def ones_like(value: Any, dtype: Any = None) -> ndarray:
    """Return ones of the shape and type of an array."""
    like = asarray(value)
    return ones(like.shape, like.dtype if dtype is None else dtype)


def full_like(value: Any, filling: Any, dtype: Any = None) -> ndarray:
    """Return an array of one value, of the shape and type of another."""
    like = asarray(value)
    return full(like.shape, filling, like.dtype if dtype is None else dtype)


def eye(rows: int, columns: int | None = None, dtype: Any = None) -> ndarray:
    """Return an identity matrix."""
    result = zeros((rows, rows if columns is None else columns), dtype)
    for i in range(builtins.min(result.shape)):
        result[i, i] = 1
    return result


identity = eye


def arange(*bounds: Any, dtype: Any = None) -> ndarray:
    """Return evenly spaced numbers of a half-open range."""
    start, stop, step = (0, bounds[0], 1) if len(bounds) == 1 else (*bounds, 1)[:3]
    if builtins.all(isinstance(each, int) for each in (start, stop, step)):
        values: _List = list(range(start, stop, step))
        kind = _I8
    else:
        count = builtins.max(0, math.ceil((stop - start) / step))
        values, kind = [start + i * step for i in range(count)], _F8
    result = _made(values, (len(values),), kind)
    return result if dtype is None else result.astype(dtype)


def linspace(start: Any, stop: Any, num: int = 50, endpoint: bool = True, dtype: Any = None, axis: int = 0) -> ndarray:
    """Return evenly spaced numbers from ``start`` to ``stop``; both may be arrays."""
    divisions = num - 1 if endpoint else num
    steps = arange(0, num).astype(_F8)
    low, high = asarray(start, _F8), asarray(stop, _F8)
    steps = steps.reshape((num,) + (1,) * builtins.max(low.ndim, high.ndim))
    span = high - low
    result = asarray(steps * (span / divisions) + low if divisions > 0 else steps * span + low)
    if endpoint and num > 1:
        result[-1] = high
    result = moveaxis(result, 0, axis) if axis else result
    return result if dtype is None else result.astype(dtype)


def fromiter(values: Iterable[Any], dtype: Any, count: int = -1) -> ndarray:
    """Return the numbers of an iterable as an array."""
    kind = _dtype(dtype)
    flat = _converted(list(values), kind)
    return _made(flat, (len(flat),), kind)


def frombuffer(data: Any, dtype: Any = float64, count: int = -1, offset: int = 0) -> ndarray:
    """Return the numbers in bytes as an array."""
    kind = _dtype(dtype)
    raw = bytes(data)[offset:]
    raw = raw[: count * kind.itemsize] if count >= 0 else raw
    flat = list(map(bool, raw)) if kind.kind == "b" else _read(kind.code, raw)
    return _made(flat, (len(flat),), kind)


def _read(code: str, raw: bytes) -> _List:
    values = _native(code)
    values.frombytes(raw)
    return values.tolist()


def meshgrid(*axes: Any, indexing: str = "xy") -> tuple[ndarray, ...]:
    """Return coordinates of a grid."""
    lines = [asarray(axis) for axis in axes]
    shape = [line.size for line in lines]
    grids = []
    for i, line in enumerate(lines):
        extents = [1] * len(lines)
        extents[i] = line.size
        grids.append(broadcast_to(line.reshape(extents), tuple(shape)).copy())
    return tuple(grid.swapaxes(0, 1) for grid in grids) if indexing == "xy" and len(grids) > 1 else tuple(grids)


def indices(shape: Any) -> ndarray:
    """Return the index along each axis of every element."""
    return stack(meshgrid(*(arange(extent) for extent in shape), indexing="ij"))


def ndindex(*shape: Any) -> Iterator[_Shape]:
    """Yield the indices of an array of a shape."""
    extents = shape[0] if len(shape) == 1 and not isinstance(shape[0], int) else shape
    return product(*map(range, extents))


def ix_(*lines: Any) -> tuple[ndarray, ...]:
    """Return index arrays of the product of lines."""
    arrays = [nonzero(asarray(line))[0] if asarray(line).dtype.kind == "b" else asarray(line) for line in lines]
    return tuple(
        line.reshape([-1 if j == i else 1 for j in range(len(arrays))]) for i, line in enumerate(arrays)
    )  # fmt: skip


# --- broadcasting --------------------------------------------------------------------------------------------------


def broadcast_shapes(*shapes: _Shape) -> _Shape:
    """Return the shape that arrays of these shapes take together."""
    result: _Shape = ()
    for shape in shapes:
        if shape == result:
            continue
        length = builtins.max(len(shape), len(result))
        a, b = (1,) * (length - len(shape)) + tuple(shape), (1,) * (length - len(result)) + result
        if builtins.any(x != y and x != 1 and y != 1 for x, y in zip(a, b, strict=True)):
            raise ValueError(f"shape mismatch: objects cannot be broadcast to a single shape {shapes}")
        result = tuple(y if x == 1 else x for x, y in zip(a, b, strict=True))
    return result


def broadcast_to(value: Any, shape: Any) -> ndarray:
    """Return a view of an array under a larger shape."""
    source, extents = asarray(value), _extents(shape)
    extra = len(extents) - source.ndim
    own = (1,) * builtins.max(extra, 0) + source.shape
    if extra < 0 or builtins.any(x != y and x != 1 for x, y in zip(own, extents, strict=True)):
        raise ValueError(f"could not broadcast input array from shape {source.shape} into shape {extents}")
    steps = (0,) * extra + source._strides
    strides = tuple(0 if x == 1 and y != 1 else step for x, y, step in zip(own, extents, steps, strict=True))
    return source._view(extents, strides, source._offset)


def broadcast_arrays(*values: Any) -> tuple[ndarray, ...]:
    """Return arrays under their common shape."""
    arrays = [asarray(value) for value in values]
    shape = broadcast_shapes(*(each.shape for each in arrays))
    return tuple(broadcast_to(each, shape) for each in arrays)


# --- functions of elements -----------------------------------------------------------------------------------------


def _ieee_divide(a: float, b: float) -> float:
    if b:
        return a / b
    if a == 0 or a != a:
        return nan
    return math.copysign(inf, a) * math.copysign(1.0, b)


def _ieee_power(a: float, b: float) -> float:
    try:
        return math.pow(a, b)
    except OverflowError:
        return -inf if a < 0 and b % 2 == 1 else inf
    except ValueError:
        return math.copysign(inf, a) if a == 0 and b % 2 == 1 else inf if a == 0 else nan


def _ieee_mod(a: float, b: float) -> float:
    return a % b if b and not math.isinf(a) else nan


_IEEE = {
    "__truediv__": _ieee_divide, "__pow__": _ieee_power, "__mod__": _ieee_mod,
    "__add__": operator.add, "__sub__": operator.sub, "__mul__": operator.mul,
}  # fmt: skip


def _guarded(function: Callable[[float], float], limits: Callable[[float], float]) -> Callable[[float], float]:
    """Return a function that gives ``limits`` of a number where Python raises."""

    def guarded(value: float) -> float:
        try:
            return function(value)
        except (ValueError, OverflowError, ZeroDivisionError):
            return limits(value)

    return guarded


class ufunc:
    """Function of two arrays, element by element, with numpy's ``at``, ``reduce``, ``accumulate`` and ``outer``."""

    def __init__(self, fast: Callable[..., Any], kind: str, slow: Callable[..., Any] | None = None) -> None:
        self.fast, self.kind, self.slow = fast, kind, slow

    def __call__(self, a: Any, b: Any, out: ndarray | None = None, where: Any = None, dtype: Any = None) -> Any:
        kind, is_scalar, shape, flats = self._operands(a, b)
        if self.kind == "float" and kind.kind in "iub":
            kind = _F8
        values = self._mapped(flats, kind)
        target = _B1 if self.kind == "compare" else kind
        result = _finished(values, shape, target)
        if where is not None and out is not None:
            out[asarray(where)] = result[asarray(where)]
            return out
        if out is not None:
            out[...] = result
            return out
        return _scalar(values[0], target) if is_scalar else result

    def _operands(self, a: Any, b: Any) -> tuple[dtype, bool, _Shape, tuple[Iterable[Any], Iterable[Any]]]:
        """Return the type of the result, whether it is a scalar, its shape, and the operands as iterables."""
        weak_a, weak_b = not isinstance(a, (ndarray, list, tuple)), not isinstance(b, (ndarray, list, tuple))
        left, right = asarray(a), asarray(b)
        kind = _result_kind(left, right, weak_left=weak_a, weak_right=weak_b)
        if left.shape == right.shape:
            return kind, weak_a and weak_b, left.shape, (left._flat(), right._flat())
        if not right.shape:
            return kind, False, left.shape, (left._flat(), _repeat(right._flat()[0], left.size))
        if not left.shape:
            return kind, False, right.shape, (_repeat(left._flat()[0], right.size), right._flat())
        shape = broadcast_shapes(left.shape, right.shape)
        return kind, False, shape, (broadcast_to(left, shape)._flat(), broadcast_to(right, shape)._flat())

    def _mapped(self, flats: tuple[Iterable[Any], Iterable[Any]], kind: dtype) -> _List:
        first, second = list(flats[0]), list(flats[1])
        if kind.kind == "b" and self.kind in ("arithmetic", "bits"):
            return [bool(self.fast(x, y)) for x, y in zip(first, second, strict=True)]
        try:
            return list(map(self.fast, first, second))
        except (ZeroDivisionError, OverflowError, ValueError):
            slow = self.slow
            if slow is None:
                raise
            return [slow(x, y) for x, y in zip(first, second, strict=True)]

    def at(self, target: ndarray, index: Any, values: Any) -> None:
        """Apply the function at indices, one after the other, so that repeated ones add up."""
        view, advanced = target._located(index)
        positions, shape = (
            (_spread(view.shape, view._strides, view._offset), view.shape)
            if advanced is None
            else _gathered(view, advanced)
        )
        elements = _cast_to(values, shape, target.dtype)
        buffer, fast = target._buffer, self.fast
        for i, element in zip(positions, elements, strict=True):
            buffer[i] = fast(buffer[i], element)

    def reduce(self, value: Any, axis: Any = 0, keepdims: bool = False) -> Any:
        source = asarray(value)
        return _reduced(source, axis, lambda row: reduce(self.fast, row), source.dtype, keepdims=keepdims)

    def accumulate(self, value: Any, axis: int = 0) -> ndarray:
        return _accumulated(asarray(value), axis, self.fast)

    def reduceat(self, value: Any, starts: Any, axis: int = 0) -> ndarray:
        source, marks = asarray(value), asarray(starts)._flat()
        moved = moveaxis(source, axis, 0)
        ends = [*marks[1:], moved.shape[0]]
        rows = [self.reduce(moved[a : builtins.max(b, a + 1)], 0) for a, b in zip(marks, ends, strict=True)]
        return moveaxis(stack([asarray(row) for row in rows]), 0, axis)

    def outer(self, a: Any, b: Any) -> Any:
        left, right = asarray(a), asarray(b)
        return self(left.reshape(left.shape + (1,) * right.ndim), right)


def _result_kind(left: ndarray, right: ndarray, *, weak_left: bool, weak_right: bool) -> dtype:
    """Return the type of a result; Python's numbers take the type of an array of their kind or above."""
    if weak_left != weak_right:
        strong, weak = (right, left) if weak_left else (left, right)
        if _RANK[weak.dtype.kind] <= _RANK[strong.dtype.kind]:
            return strong.dtype
        if strong.dtype.kind == "b" or weak.dtype.kind in "OcU":
            return weak.dtype
        return _F8
    return left.dtype if left.dtype is right.dtype else _promoted(left.dtype, right.dtype)


def _finished(values: _List, shape: _Shape, kind: dtype) -> ndarray:
    """Return computed elements as an array; those of small types are rounded or wrapped."""
    if kind is _F4:
        values = _round32(values)
    elif kind.kind in "iu":
        values = _wrap(values, kind)
    elif kind is _F8 and values and type(values[0]) is int:
        values = list(map(float, values))
    return _made(values, shape, kind)


def _least(a: Any, b: Any) -> Any:
    return a if a <= b or a != a else b


def _greatest(a: Any, b: Any) -> Any:
    return a if a >= b or a != a else b


def _logical(function: Callable[[bool, bool], bool]) -> ufunc:
    return ufunc(lambda a, b: function(bool(a), bool(b)), "compare")


def _float_divmod(a: Any, b: Any) -> Any:
    return a // b if b else (_ieee_divide(a, b) if isinstance(a, float) or isinstance(b, float) else 0)


add = ufunc(operator.add, "arithmetic")
subtract = ufunc(operator.sub, "arithmetic")
multiply = ufunc(operator.mul, "arithmetic")
divide = true_divide = ufunc(operator.truediv, "float", _ieee_divide)
floor_divide = ufunc(operator.floordiv, "arithmetic", _float_divmod)
mod = remainder = ufunc(operator.mod, "arithmetic", lambda a, b: _ieee_mod(a, b) if isinstance(a + b, float) else 0)
fmod = ufunc(math.fmod, "float", lambda a, b: nan)
power = float_power = ufunc(operator.pow, "arithmetic", _ieee_power)
minimum = ufunc(_least, "arithmetic")
maximum = ufunc(_greatest, "arithmetic")
fmin = ufunc(lambda a, b: b if a != a else a if b != b else _least(a, b), "arithmetic")
fmax = ufunc(lambda a, b: b if a != a else a if b != b else _greatest(a, b), "arithmetic")
hypot = ufunc(math.hypot, "float")
arctan2 = ufunc(math.atan2, "float")
copysign = ufunc(math.copysign, "float")
bitwise_and = ufunc(operator.and_, "bits")
bitwise_or = ufunc(operator.or_, "bits")
bitwise_xor = ufunc(operator.xor, "bits")
left_shift = ufunc(operator.lshift, "bits")
right_shift = ufunc(operator.rshift, "bits")
equal = ufunc(operator.eq, "compare")
not_equal = ufunc(operator.ne, "compare")
less = ufunc(operator.lt, "compare")
less_equal = ufunc(operator.le, "compare")
greater = ufunc(operator.gt, "compare")
greater_equal = ufunc(operator.ge, "compare")
logical_and = _logical(lambda a, b: a and b)
logical_or = _logical(lambda a, b: a or b)
logical_xor = _logical(operator.xor)


def _unary(function: Callable[[Any], Any], kind: str, slow: Callable[[Any], Any] | None = None) -> Callable[..., Any]:
    """Return a function of each element; ``kind`` is "float", "same" or "truth"."""

    def operate(value: Any, out: ndarray | None = None, where: Any = None) -> Any:
        source = asarray(value)
        flat = source._flat()
        try:
            values = list(map(function, flat))
        except (ValueError, OverflowError, ZeroDivisionError, TypeError):
            if slow is None:
                raise
            values = list(map(slow, flat))
        target = _B1 if kind == "truth" else _F8 if kind == "float" and source.dtype.kind in "iub" else source.dtype
        result = _finished(values, source.shape, target)
        if out is not None:
            out[...] = result
            return out
        return result if source.shape or isinstance(value, ndarray) else _scalar(result._buffer[0], target)

    return operate


def _real(function: Callable[[float], float], limits: Callable[[float], float]) -> Callable[..., Any]:
    return _unary(function, "float", _guarded(function, limits))


def _nan(_: float) -> float:
    return nan


def _half_even(value: Any) -> Any:
    """Return a number rounded to an integer, halves to even, as a number of its own kind."""
    if isinstance(value, int) or not math.isfinite(value):
        return value
    return math.copysign(float(builtins.round(value)), value)


def _whole(function: Callable[[Any], int]) -> Callable[[Any], Any]:
    """Return a rounding that keeps infinite numbers, the kind, and the sign of zero."""

    def rounded(value: Any) -> Any:
        if isinstance(value, int) or not math.isfinite(value):
            return value
        return math.copysign(float(function(value)), value) if -1.0 < value < 1.0 and not function(value) else float(
            function(value)
        )  # fmt: skip

    return rounded


def _sign(value: Any) -> Any:
    return value if value != value else type(value)((value > 0) - (value < 0))


sqrt = _real(math.sqrt, _nan)
cbrt = _real(math.cbrt, _nan)
sin = _real(math.sin, _nan)
cos = _real(math.cos, _nan)
tan = _real(math.tan, _nan)
arcsin = _real(math.asin, _nan)
arccos = _real(math.acos, _nan)
arctan = _real(math.atan, _nan)
sinh = _real(math.sinh, lambda x: math.copysign(inf, x))
cosh = _real(math.cosh, lambda x: inf)
tanh = _real(math.tanh, _nan)
exp = _real(math.exp, lambda x: inf)
expm1 = _real(math.expm1, lambda x: inf)
log = _real(math.log, lambda x: -inf if x == 0 else nan)
log2 = _real(math.log2, lambda x: -inf if x == 0 else nan)
log10 = _real(math.log10, lambda x: -inf if x == 0 else nan)
log1p = _real(math.log1p, lambda x: -inf if x == -1 else nan)
degrees = rad2deg = _real(math.degrees, _nan)
radians = deg2rad = _real(math.radians, _nan)
absolute = abs = fabs = _unary(operator.abs, "same")
negative = _unary(operator.neg, "same")
sign = _unary(_sign, "same")
square = _unary(lambda value: value * value, "same")
reciprocal = _unary(lambda value: _ieee_divide(1.0, value), "float")
floor = _unary(_whole(math.floor), "same")
ceil = _unary(_whole(math.ceil), "same")
trunc = fix = _unary(_whole(math.trunc), "same")
rint = _unary(_half_even, "same")
isfinite = _unary(math.isfinite, "truth")
isnan = _unary(lambda value: value != value, "truth")
isinf = _unary(math.isinf, "truth")
logical_not = _unary(operator.not_, "truth")
signbit = _unary(lambda value: math.copysign(1.0, value) < 0, "truth")
conj = _unary(lambda value: value.conjugate(), "same")


def invert(value: Any) -> Any:
    """Return the complement of truth values or of bits."""
    source = asarray(value)
    function: Callable[[Any], Any] = operator.not_ if source.dtype.kind == "b" else operator.invert
    return _finished(list(map(function, source._flat())), source.shape, source.dtype)


bitwise_not = invert


def round(value: Any, digits: int = 0) -> Any:
    """Return numbers rounded to decimals, halves to even, as numpy: scaled, rounded and scaled back."""
    if digits == 0:
        return rint(value)
    factor = 10.0 ** builtins.abs(digits)
    scaled = multiply(value, factor) if digits > 0 else divide(value, factor)
    return divide(rint(scaled), factor) if digits > 0 else multiply(rint(scaled), factor)


around = round


def clip(value: Any, low: Any = None, high: Any = None) -> Any:
    """Return numbers limited to a range."""
    result = value if low is None else maximum(value, low)
    return result if high is None else minimum(result, high)


def where(condition: Any, *choices: Any) -> Any:
    """Return elements of the first choice where a condition holds, else of the second; alone, its indices."""
    if not choices:
        return nonzero(asarray(condition))
    yes, no = choices
    kind = _result_kind(
        asarray(yes), asarray(no),
        weak_left=not isinstance(yes, (ndarray, list)), weak_right=not isinstance(no, (ndarray, list)),
    )  # fmt: skip
    test, first, second = broadcast_arrays(condition, yes, no)
    flat = [a if c else b for c, a, b in zip(test._flat(), first._flat(), second._flat(), strict=True)]
    return _made(_converted(flat, kind), test.shape, kind)


def nan_to_num(value: Any, nan: float = 0.0, posinf: float | None = None, neginf: float | None = None) -> Any:
    """Return numbers with those that are not finite replaced."""
    high = 1.7976931348623157e308 if posinf is None else posinf
    low = -1.7976931348623157e308 if neginf is None else neginf
    source = asarray(value)
    flat = [nan if x != x else high if x == inf else low if x == -inf else x for x in source._flat()]
    result = _finished(flat, source.shape, source.dtype)
    return result if isinstance(value, ndarray) else result[()]


def isclose(a: Any, b: Any, rtol: float = 1e-5, atol: float = 1e-8, equal_nan: bool = False) -> Any:
    """Return where numbers are equal within a tolerance."""
    return less_equal(absolute(subtract(a, b)), add(atol, multiply(rtol, absolute(b)))) | equal(a, b)


def allclose(a: Any, b: Any, rtol: float = 1e-5, atol: float = 1e-8) -> bool:
    """Return whether all numbers are equal within a tolerance."""
    return bool(asarray(isclose(asarray(a), asarray(b), rtol, atol)).all())


def array_equal(a: Any, b: Any) -> bool:
    """Return whether arrays have the same shape and elements."""
    left, right = asarray(a), asarray(b)
    return left.shape == right.shape and left._flat() == right._flat()


def isscalar(value: Any) -> bool:
    """Return whether a value is a number or text."""
    return isinstance(value, (int, float, complex, str))


# --- reductions ----------------------------------------------------------------------------------------------------


def _summed_type(kind: dtype) -> dtype:
    return {"b": _I8, "i": _I8, "u": _U8}.get(kind.kind, kind)


def _extreme(function: Callable[..., Any], initial: Any) -> Callable[[_List], Any]:
    """Return a reduction to the least or greatest element; one that is no number wins."""

    def reduced(row: _List) -> Any:
        if not row and initial is None:
            raise ValueError("zero-size array to reduction operation which has no identity")
        for value in row:
            if value != value:
                return value
        return function(row) if initial is None else function([*row, initial])

    return reduced


def _reduced(source: ndarray, axis: Any, function: Callable[[_List], Any], kind: dtype, *, keepdims: bool) -> Any:
    """Return a reduction of lines along an axis, several axes, or of all elements."""
    if axis is None:
        value = function(source._flat())
        if not keepdims:
            return _scalar(value, kind) if kind.kind != "b" else bool(value)
        return _finished([value], (1,) * source.ndim, kind)
    axes = [each % source.ndim for each in (axis if isinstance(axis, tuple) else (axis,))]
    rest = [each for each in range(source.ndim) if each not in axes]
    flat = source.transpose([*rest, *axes])._flat() if axes != [source.ndim - 1] else source._flat()
    length = math.prod(source.shape[each] for each in axes)
    shape = tuple(source.shape[each] for each in rest)
    values = [function(flat[i * length : (i + 1) * length]) for i in range(math.prod(shape))]
    if keepdims:
        shape = tuple(1 if each in axes else extent for each, extent in enumerate(source.shape))
    return _finished(values, shape, kind) if shape or keepdims else _scalar(values[0], kind)


def _accumulated(source: ndarray, axis: int | None, function: Callable[[Any, Any], Any]) -> ndarray:
    """Return running results along an axis."""
    if axis is None:
        return _accumulated(source.ravel(), 0, function)
    moved = moveaxis(source, axis, -1)
    flat, length = moved._flat(), moved.shape[-1]
    rows = [accumulate(flat[i : i + length], function) for i in range(0, len(flat), length)] if length else []
    kind = _summed_type(source.dtype) if function in (operator.add, operator.mul) else source.dtype
    return moveaxis(_finished(list(chain.from_iterable(rows)), moved.shape, kind), -1, axis)


def _method(name: str) -> Callable[..., Any]:
    """Return the function that calls an array's method."""

    def call(value: Any, *arguments: Any, **options: Any) -> Any:
        return getattr(asarray(value), name)(*arguments, **options)

    return call


sum = _method("sum")
prod = _method("prod")
mean = _method("mean")
max = amax = _method("max")
min = amin = _method("min")
all = _method("all")
any = _method("any")
argmax = _method("argmax")
argmin = _method("argmin")
cumsum = _method("cumsum")
cumprod = _method("cumprod")
reshape = _method("reshape")
ravel = _method("ravel")
squeeze = _method("squeeze")
repeat = _method("repeat")
swapaxes = _method("swapaxes")
transpose = _method("transpose")
trace = _method("trace")
diagonal = _method("diagonal")
copy = _method("copy")


def ptp(value: Any, axis: Any = None) -> Any:
    """Return the extent of numbers along an axis."""
    source = asarray(value)
    return source.max(axis=axis) - source.min(axis=axis)


def var(value: Any, axis: Any = None, ddof: int = 0) -> Any:
    """Return the variance of numbers along an axis."""
    source = asarray(value, float)
    count = source.size if axis is None else source.shape[axis]
    spread = source - source.mean(axis=axis, keepdims=True)
    return (spread * spread).sum(axis=axis) / (count - ddof)


def std(value: Any, axis: Any = None, ddof: int = 0) -> Any:
    """Return the standard deviation of numbers along an axis."""
    return sqrt(var(value, axis, ddof))


def median(value: Any, axis: Any = None) -> Any:
    """Return the median of numbers along an axis."""
    return quantile(value, 0.5, axis)


def quantile(value: Any, share: Any, axis: Any = None) -> Any:
    """Return a quantile along an axis, interpolated linearly."""

    def of(row: _List) -> float:
        ordered = sorted(row)
        place = float(share) * (len(ordered) - 1)
        low = math.floor(place)
        high = builtins.min(low + 1, len(ordered) - 1)
        return float(ordered[low] + (ordered[high] - ordered[low]) * (place - low))

    return _reduced(asarray(value, float), axis, of, _F8, keepdims=False)


def percentile(value: Any, share: float, axis: Any = None) -> Any:
    """Return a percentile along an axis."""
    return quantile(value, share / 100.0, axis)


def average(value: Any, axis: Any = None, weights: Any = None) -> Any:
    """Return the weighted mean along an axis."""
    if weights is None:
        return mean(value, axis=axis)
    return sum(multiply(asarray(value), weights), axis=axis) / sum(weights)


def count_nonzero(value: Any) -> int:
    """Return how many elements are not zero."""
    return builtins.sum(map(bool, asarray(value)._flat()))


def shape(value: Any) -> _Shape:
    """Return the shape of a value."""
    return asarray(value).shape


def ndim(value: Any) -> int:
    """Return the number of axes of a value."""
    return asarray(value).ndim


def size(value: Any) -> int:
    """Return the number of elements of a value."""
    return asarray(value).size


# --- joining and rearranging ---------------------------------------------------------------------------------------


def concatenate(parts: Iterable[Any], axis: int | None = 0) -> ndarray:
    """Return arrays joined along an axis."""
    arrays = [asarray(part) for part in parts]
    if not arrays:
        raise ValueError("need at least one array to concatenate")
    if axis is None:
        arrays, axis = [each.ravel() for each in arrays], 0
    kind = reduce(_promoted, [each.dtype for each in arrays])
    first = arrays[0]
    axis %= first.ndim
    if builtins.any(
        each.ndim != first.ndim
        or each.shape[:axis] + each.shape[axis + 1 :] != first.shape[:axis] + first.shape[axis + 1 :]
        for each in arrays
    ):
        raise ValueError("all the input array dimensions except for the concatenation axis must match exactly")
    arrays = [each.astype(kind, copy=False) for each in arrays]
    shape = list(first.shape)
    shape[axis] = builtins.sum(each.shape[axis] for each in arrays)
    if axis == 0:
        return _made(list(chain.from_iterable(each._flat() for each in arrays)), tuple(shape), kind)
    flats = [each._flat() for each in arrays]
    widths = [math.prod(each.shape[axis:]) for each in arrays]
    pieces = [
        flat[row * width : (row + 1) * width]
        for row in range(math.prod(first.shape[:axis]))
        for flat, width in zip(flats, widths, strict=True)
    ]
    return _made(list(chain.from_iterable(pieces)), tuple(shape), kind)


def stack(parts: Iterable[Any], axis: int = 0) -> ndarray:
    """Return arrays joined along a new axis."""
    arrays = [asarray(part) for part in parts]
    if not arrays:
        raise ValueError("need at least one array to stack")
    if builtins.any(each.shape != arrays[0].shape for each in arrays):
        raise ValueError("all input arrays must have the same shape")
    axis %= arrays[0].ndim + 1
    return concatenate([expand_dims(each, axis) for each in arrays], axis)


def _at_least(value: Any, count: int) -> ndarray:
    source = asarray(value)
    return source if source.ndim >= count else source.reshape((1,) * (count - source.ndim) + source.shape)


def vstack(parts: Iterable[Any]) -> ndarray:
    """Return arrays joined as rows."""
    return concatenate([_at_least(part, 2) for part in parts], 0)


def hstack(parts: Iterable[Any]) -> ndarray:
    """Return arrays joined as columns."""
    arrays = [_at_least(part, 1) for part in parts]
    return concatenate(arrays, 0 if arrays[0].ndim == 1 else 1)


def column_stack(parts: Iterable[Any]) -> ndarray:
    """Return arrays as columns of a matrix."""
    arrays = [asarray(part) for part in parts]
    return concatenate([each.reshape(-1, 1) if each.ndim < 2 else each for each in arrays], 1)


def atleast_1d(value: Any) -> ndarray:
    """Return a value as an array with an axis."""
    return _at_least(value, 1)


def atleast_2d(value: Any) -> ndarray:
    """Return a value as an array with two axes."""
    return _at_least(value, 2)


def expand_dims(value: Any, axis: int) -> ndarray:
    """Return an array with a new axis."""
    source = asarray(value)
    axis %= source.ndim + 1
    shape = (*source.shape[:axis], 1, *source.shape[axis:])
    return source._view(shape, (*source._strides[:axis], 0, *source._strides[axis:]), source._offset).reshape(shape)


def moveaxis(value: Any, old: int, new: int) -> ndarray:
    """Return an array with an axis at another place."""
    source = asarray(value)
    order = [axis for axis in range(source.ndim) if axis != old % source.ndim]
    order.insert(new % source.ndim, old % source.ndim)
    return source.transpose(order)


def tile(value: Any, counts: Any) -> ndarray:
    """Return an array repeated along its axes."""
    numbers = _extents(counts)
    source = _at_least(value, len(numbers))
    numbers = (1,) * (source.ndim - len(numbers)) + numbers
    for axis, count in enumerate(numbers):
        if count != 1:
            source = concatenate([source] * count, axis) if count else take(source, [], axis)
    return source.copy()


def roll(value: Any, shift: Any, axis: Any = None) -> ndarray:
    """Return an array with elements moved along an axis, around its end."""
    source = asarray(value)
    if axis is None:
        return roll(source.ravel(), shift, 0).reshape(source.shape)
    if isinstance(axis, tuple):
        for each, step in zip(axis, shift, strict=True):
            source = roll(source, step, each)
        return source
    extent = source.shape[axis]
    return take(source, [(i - int(shift)) % extent for i in range(extent)], axis)


def flip(value: Any, axis: int | None = None) -> ndarray:
    """Return an array with an axis reversed."""
    source = asarray(value)
    key = tuple(
        slice(None, None, -1) if axis is None or i == axis % source.ndim else slice(None) for i in range(source.ndim)
    )
    result: ndarray = source[key]
    return result


def take(value: Any, index: Any, axis: int | None = None, out: ndarray | None = None, mode: str = "raise") -> Any:
    """Return the elements at indices along an axis."""
    if out is not None:
        out[...] = take(value, index, axis, mode=mode)
        return out
    source = asarray(value)
    if axis is None:
        source, axis = source.ravel(), 0
    if isinstance(index, list):
        index = _made([int(i) for i in index], (len(index),), _I8)
    return source[(slice(None),) * (axis % source.ndim) + (index,)]


def put(target: ndarray, index: Any, values: Any) -> None:
    """Set the elements at flat indices."""
    places = asarray(index)._flat()
    elements = asarray(values)._flat()
    positions = _spread(target.shape, target._strides, target._offset)
    for i, place in enumerate(places):
        target._buffer[positions[place]] = _converted([elements[i % len(elements)]], target.dtype)[0]


def putmask(target: ndarray, mask: Any, values: Any) -> None:
    """Set the elements where a mask holds."""
    elements = asarray(values)
    target[asarray(mask)] = elements if not elements.shape else broadcast_to(elements, target.shape)[asarray(mask)]


def take_along_axis(value: Any, index: Any, axis: int) -> ndarray:
    """Return elements at indices of an array of the same number of axes."""
    source, places = asarray(value), asarray(index)
    keys = list(meshgrid(*(arange(extent) for extent in places.shape), indexing="ij"))
    keys[axis] = places
    result: ndarray = source[tuple(keys)]
    return result


def insert(value: Any, index: Any, values: Any, axis: int = 0) -> ndarray:
    """Return an array with values before an index."""
    source = asarray(value)
    new = asarray(values, source.dtype)
    new = new if new.ndim == source.ndim else new.reshape((1,) * (source.ndim - new.ndim) + new.shape)
    extents = tuple(new.shape[i] if i == axis else extent for i, extent in enumerate(source.shape))
    new = broadcast_to(new, extents)
    low, high = split(source, [int(index)], axis)
    return concatenate([low, new, high], axis)


def append(value: Any, values: Any, axis: int | None = None) -> ndarray:
    """Return an array with values after it."""
    return concatenate([value, values], axis)


def delete(value: Any, index: Any, axis: int | None = None) -> ndarray:
    """Return an array without the elements at indices."""
    source = asarray(value) if axis is not None else asarray(value).ravel()
    axis = axis or 0
    gone = {i % source.shape[axis] for i in asarray(index).ravel().tolist()}
    result: ndarray = take(source, [i for i in range(source.shape[axis]) if i not in gone], axis)
    return result


def split(value: Any, marks: Any, axis: int = 0) -> list[ndarray]:
    """Return the parts of an array between indices, or a number of equal parts."""
    source = asarray(value)
    extent = source.shape[axis]
    cuts = [extent * i // marks for i in range(1, marks)] if isinstance(marks, int) else asarray(marks, int).tolist()
    edges = [0, *cuts, extent]
    before = (slice(None),) * (axis % source.ndim)
    return [source[(*before, slice(a, builtins.max(a, b)))] for a, b in pairwise(edges)]


def pad(value: Any, widths: Any, mode: str = "constant", constant_values: Any = 0) -> ndarray:
    """Return an array with a border."""
    source = asarray(value)
    pairs = broadcast_to(asarray(widths), (source.ndim, 2)).tolist()
    if mode != "constant":
        for axis, (low, high) in enumerate(pairs):
            extent = source.shape[axis]
            places = range(-low, extent + high)
            index = [i % extent if mode == "wrap" else builtins.min(builtins.max(i, 0), extent - 1) for i in places]
            source = take(source, index, axis)
        return source
    shape = tuple(extent + low + high for extent, (low, high) in zip(source.shape, pairs, strict=True))
    result = full(shape, constant_values, source.dtype)
    key = tuple(slice(low, low + extent) for extent, (low, _) in zip(source.shape, pairs, strict=True))
    result[key] = source
    return result


def diff(value: Any, n: int = 1, axis: int = -1, prepend: Any = None, append: Any = None) -> ndarray:
    """Return the differences of neighbors along an axis."""
    source = asarray(value)
    ends = [[asarray(each)] if each is not None else [] for each in (prepend, append)]
    parts = [*ends[0], source, *ends[1]]
    if len(parts) > 1:
        source = concatenate([part if part.ndim else part.reshape((1,) * source.ndim) for part in parts], axis)
    key = (slice(None),) * (axis % source.ndim)
    result: ndarray = source[(*key, slice(1, None))] - source[(*key, slice(None, -1))]
    return result


def unravel_index(index: Any, shape: Any) -> tuple[Any, ...]:
    """Return flat indices as indices of each axis."""
    result = []
    for stride, extent in zip(_strides_of(tuple(shape)), shape, strict=True):
        result.append(floor_divide(index, stride) % extent)
    return tuple(result)


def triu_indices(count: int, k: int = 0) -> tuple[ndarray, ndarray]:
    """Return the indices of the upper triangle of a square matrix."""
    pairs = [(i, j) for i in range(count) for j in range(builtins.max(0, i + k), count)]
    return array([i for i, _ in pairs], int), array([j for _, j in pairs], int)


# --- searching and sorting -----------------------------------------------------------------------------------------


def nonzero(value: Any) -> tuple[ndarray, ...]:
    """Return the indices of the elements that are not zero, by axis."""
    source = asarray(value)
    places = [i for i, element in enumerate(source._flat()) if element]
    if source.ndim == 1:
        return (_made(places, (len(places),), _I8),)
    strides = _strides_of(source.shape)
    return tuple(
        _made([i // stride % extent for i in places], (len(places),), _I8)
        for stride, extent in zip(strides, source.shape, strict=True)
    )


def flatnonzero(value: Any) -> ndarray:
    """Return the flat indices of the elements that are not zero."""
    return nonzero(asarray(value).ravel())[0]


def argwhere(value: Any) -> ndarray:
    """Return the indices of the elements that are not zero, as rows."""
    return stack(nonzero(value), 1)


def _last_key(value: Any) -> tuple[bool, Any]:
    return (value != value, value)  # what is no number comes last


def sort(value: Any, axis: int | None = -1, kind: str | None = None) -> ndarray:
    """Return an array in order along an axis."""
    source = asarray(value)
    if axis is None:
        return sort(source.ravel(), 0)
    moved = moveaxis(source, axis, -1)
    flat, length = moved._flat(), builtins.max(moved.shape[-1], 1)
    key = _last_key if source.dtype.kind == "f" and builtins.any(x != x for x in flat) else None
    rows = [sorted(flat[i : i + length], key=key) for i in range(0, len(flat), length)]
    return moveaxis(_made(list(chain.from_iterable(rows)), moved.shape, source.dtype), -1, axis)


def _order(row: _List) -> list[int]:
    """Return the indices that put a list in order."""
    return sorted(range(len(row)), key=lambda i: _last_key(row[i]))


def argsort(value: Any, axis: int = -1, kind: str | None = None) -> ndarray:
    """Return the indices that put an array in order along an axis; equal elements keep theirs."""
    moved = moveaxis(asarray(value), axis, -1)
    flat, length = moved._flat(), builtins.max(moved.shape[-1], 1)
    rows = [flat[i : i + length] for i in range(0, len(flat), length)]
    order = [_order(row) for row in rows]
    return moveaxis(_made(list(chain.from_iterable(order)), moved.shape, _I8), -1, axis)


def lexsort(keys: Any) -> ndarray:
    """Return the indices that sort by several keys, the last one first."""
    columns = [asarray(key)._flat() for key in keys][::-1]
    order = sorted(range(len(columns[0])), key=lambda i: [column[i] for column in columns])
    return _made(order, (len(order),), _I8)


def searchsorted(values: Any, wanted: Any, side: str = "left") -> Any:
    """Return where numbers belong in an array that is in order."""
    row, search = asarray(values)._flat(), bisect_left if side == "left" else bisect_right
    places = asarray(wanted)
    flat = [search(row, value) for value in places._flat()]
    return _made(flat, places.shape, _I8) if places.shape else int64(flat[0])


def digitize(value: Any, edges: Any) -> Any:
    """Return the interval of each number."""
    return searchsorted(edges, value, "right")


def unique(
    value: Any, return_index: bool = False, return_inverse: bool = False, return_counts: bool = False,
    axis: int | None = None,
) -> Any:  # fmt: skip
    """Return the distinct elements, or rows with ``axis`` 0, in order; and first places, numbers and counts."""
    source = asarray(value)
    if axis is None:
        items: _List = source._flat()
    else:
        items = [tuple(row) for row in source.reshape(source.shape[0], -1).tolist()]
    first: dict[Any, int] = {}
    for i, item in enumerate(items):
        first.setdefault(item, i)
    ordered = sorted(first)
    if axis is None:
        distinct = _made(ordered, (len(ordered),), source.dtype)
    else:
        flat = list(chain.from_iterable(ordered))
        distinct = _made(flat, (len(ordered), *source.shape[1:]), source.dtype)
    extras: list[ndarray] = []
    rank = {item: i for i, item in enumerate(ordered)}
    if return_index:
        extras.append(_made([first[item] for item in ordered], (len(ordered),), _I8))
    if return_inverse:
        numbers = [rank[item] for item in items]
        extras.append(_made(numbers, source.shape if axis is None else (len(numbers),), _I8))
    if return_counts:
        counts = [0] * len(ordered)
        for item in items:
            counts[rank[item]] += 1
        extras.append(_made(counts, (len(ordered),), _I8))
    return (distinct, *extras) if extras else distinct


def isin(value: Any, among: Any, invert: bool = False) -> ndarray:
    """Return which elements are among others."""
    source, known = asarray(value), set(asarray(among)._flat())
    return _made([(element in known) != invert for element in source._flat()], source.shape, _B1)


in1d = isin


def intersect1d(a: Any, b: Any) -> ndarray:
    """Return the distinct elements that arrays share, in order."""
    left = asarray(a)
    both = sorted(set(left._flat()) & set(asarray(b)._flat()))
    return _made(both, (len(both),), left.dtype)


def union1d(a: Any, b: Any) -> ndarray:
    """Return the distinct elements of two arrays, in order."""
    result: ndarray = unique(concatenate([asarray(a).ravel(), asarray(b).ravel()]))
    return result


def setdiff1d(a: Any, b: Any) -> ndarray:
    """Return the distinct elements of an array that another lacks, in order."""
    left = asarray(a)
    rest = sorted(set(left._flat()) - set(asarray(b)._flat()))
    return _made(rest, (len(rest),), left.dtype)


def bincount(value: Any, weights: Any = None, minlength: int = 0) -> ndarray:
    """Return how often each number occurs, or the sum of its weights."""
    numbers = asarray(value)._flat()
    length = builtins.max(minlength, builtins.max(numbers, default=-1) + 1)
    if weights is None:
        counts: _List = [0] * length
        for number in numbers:
            counts[number] += 1
        return _made(counts, (length,), _I8)
    sums = [0.0] * length
    for number, weight in zip(numbers, asarray(weights)._flat(), strict=True):
        sums[number] += weight
    return _made(sums, (length,), _F8)


def interp(x: Any, xs: Any, ys: Any) -> Any:
    """Return values of a piecewise linear function."""
    places, values = asarray(xs, float)._flat(), asarray(ys, float)._flat()

    def at(value: float) -> float:
        if value <= places[0]:
            return values[0]
        if value >= places[-1]:
            return values[-1]
        i = bisect_right(places, value) - 1
        share = (value - places[i]) / (places[i + 1] - places[i])
        return float(values[i] + share * (values[i + 1] - values[i]))

    return _unary(at, "float")(x)


# --- products ------------------------------------------------------------------------------------------------------


def _sum_products(a: Iterable[Any], b: Iterable[Any]) -> Any:
    return builtins.sum(map(operator.mul, a, b))


def matmul(a: Any, b: Any, out: ndarray | None = None) -> Any:
    """Return the product of matrices, of stacks of them, or of a matrix and a vector."""
    if out is not None:
        out[...] = matmul(a, b)
        return out
    left, right = asarray(a), asarray(b)
    if not left.ndim or not right.ndim:
        raise ValueError("matmul: Input operand does not have enough dimensions")
    kind = _promoted(left.dtype, right.dtype)
    rows = left.reshape(1, -1) if left.ndim == 1 else left
    columns = right.reshape(-1, 1) if right.ndim == 1 else right
    if rows.shape[-1] != columns.shape[-2]:
        raise ValueError(
            f"matmul: Input operand 1 has a mismatch in its core dimension 0 ({left.shape}, {right.shape})"
        )
    outer = broadcast_shapes(rows.shape[:-2], columns.shape[:-2])
    (n, k), m = rows.shape[-2:], columns.shape[-1]
    first = broadcast_to(rows, (*outer, n, k))._flat()
    second = broadcast_to(columns, (*outer, k, m)).swapaxes(-1, -2)._flat()
    flat = []
    for block in range(math.prod(outer)):
        lines = [first[(block * n + i) * k : (block * n + i + 1) * k] for i in range(n)]
        others = [second[(block * m + j) * k : (block * m + j + 1) * k] for j in range(m)]
        flat += [_sum_products(line, other) for line in lines for other in others]
    shape = (*outer, *((n,) if left.ndim > 1 else ()), *((m,) if right.ndim > 1 else ()))
    result = _finished(flat, shape, kind)
    return result if shape else _scalar(flat[0], kind)


def dot(a: Any, b: Any) -> Any:
    """Return the product of arrays along the last axis of the first and the last but one of the second."""
    left, right = asarray(a), asarray(b)
    if not left.ndim or not right.ndim:
        return multiply(a, b)
    if right.ndim <= 2:
        return matmul(left, right)
    raise MissingError("`numpy.dot` of arrays of more than two axes")


def vdot(a: Any, b: Any) -> Any:
    """Return the sum of products of all elements."""
    return dot(asarray(a).ravel(), asarray(b).ravel())


inner = dot


def outer(a: Any, b: Any) -> ndarray:
    """Return the products of each element of one with each of another."""
    result: ndarray = multiply(asarray(a).reshape(-1, 1), asarray(b).reshape(1, -1))
    return result


def cross(a: Any, b: Any, axis: int = -1) -> ndarray:
    """Return the vector product of arrays of vectors in space, or of the plane."""
    left, right = moveaxis(asarray(a), axis, -1), moveaxis(asarray(b), axis, -1)
    if left.shape[-1] == 2:
        flat: ndarray = left[..., 0] * right[..., 1] - left[..., 1] * right[..., 0]
        return flat
    shape = broadcast_shapes(left.shape, right.shape)
    first, second = broadcast_to(left, shape)._flat(), broadcast_to(right, shape)._flat()
    out: _List = []
    for i in range(0, len(first), 3):
        (x, y, z), (u, v, w) = first[i : i + 3], second[i : i + 3]
        out += (y * w - z * v, z * u - x * w, x * v - y * u)
    return moveaxis(_finished(out, shape, _promoted(left.dtype, right.dtype)), -1, axis)


def _products(a: _List, b: _List) -> _List:
    return list(map(operator.mul, a, b))


def einsum(formula: str, *operands: Any) -> Any:
    """Return a sum of products that index letters describe; every letter is one axis."""
    arrays = [asarray(each) for each in operands]
    inputs, _, output = formula.replace(" ", "").partition("->")
    letters = inputs.split(",")
    extents: dict[str, int] = {}
    for names, each in zip(letters, arrays, strict=True):
        for name, extent in zip(names, each.shape, strict=True):
            extents[name] = builtins.max(extents.get(name, 1), extent)
    summed = [name for name in extents if name not in output]
    order = [*output, *summed]
    shape = tuple(extents[name] for name in order)
    flats = []
    for names, each in zip(letters, arrays, strict=True):
        strides = [0] * len(order)
        for name, stride, extent in zip(names, each._strides, each.shape, strict=True):
            strides[order.index(name)] += stride if extent > 1 or extents[name] == 1 else 0
        flats.append(each._view(shape, tuple(strides), each._offset)._flat())
    values = flats[0] if len(flats) == 1 else reduce(_products, flats)
    kind = reduce(_promoted, [each.dtype for each in arrays])
    length = math.prod(extents[name] for name in summed)
    kept = tuple(extents[name] for name in output)
    if summed:
        values = [builtins.sum(values[i * length : (i + 1) * length]) for i in range(math.prod(kept))]
    return _finished(values, kept, kind) if kept else _scalar(values[0], kind)


# --- numeric limits and error states -------------------------------------------------------------------------------


class finfo:
    """Limits of floating-point numbers."""

    def __init__(self, kind: Any = float64) -> None:
        single = _dtype(kind) is _F4
        self.eps = 2.0**-23 if single else 2.0**-52
        self.max = 3.4028234663852886e38 if single else 1.7976931348623157e308
        self.min = -self.max
        self.tiny = 2.0**-126 if single else 2.0**-1022


class iinfo:
    """Limits of integers."""

    def __init__(self, kind: Any) -> None:
        type_ = _dtype(kind)
        bits = 8 * type_.itemsize
        self.max = (1 << (bits - 1)) - 1 if type_.kind == "i" else (1 << bits) - 1
        self.min = -self.max - 1 if type_.kind == "i" else 0


class errstate:
    """Context that numpy needs to silence warnings; nothing here warns."""

    def __init__(self, **options: str) -> None:
        self.options = options

    def __enter__(self) -> None:
        return None

    def __exit__(self, *error: object) -> None:
        return None

    def __call__(self, function: Any) -> Any:
        return function


def seterr(**options: str) -> dict[str, str]:
    """Accept numpy's settings of warnings; nothing here warns."""
    return options


def may_share_memory(a: ndarray, b: ndarray) -> bool:
    """Return whether arrays are views of one list."""
    return a._buffer is b._buffer


shares_memory = may_share_memory


def vectorize(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function of arrays that calls one of numbers for each element."""

    def call(*values: Any) -> Any:
        arrays = broadcast_arrays(*values)
        flat = [function(*row) for row in zip(*(each._flat() for each in arrays), strict=True)]
        return _made(flat, arrays[0].shape, _kind_of(flat))

    return call


def packbits(value: Any) -> ndarray:
    """Return truth values as bytes, eight in each."""
    bits = [int(bool(x)) for x in asarray(value)._flat()]
    bits += [0] * (-len(bits) % 8)
    flat = [int("".join(map(str, bits[i : i + 8])), 2) for i in range(0, len(bits), 8)]
    return _made(flat, (len(flat),), _U1)


def __getattr__(name: str) -> Any:
    if name.startswith("__"):
        raise AttributeError(name)
    raise MissingError(f"`numpy.{name}`")


from . import linalg as linalg  # noqa: E402 (their functions are made of those above)
from . import random as random  # noqa: E402

"""The data of the language that Python does not already have (docs/language.md, "Values").

Numbers, strings, booleans and ``none`` are Python's own. Everything here is immutable except the classes under
"mutable twins", whose instances carry a birth stamp so that memoised calls stay sound (see ``runtime``).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from scenelang.grammar.datum import Keyword as Keyword
from scenelang.grammar.datum import Symbol as Symbol

if TYPE_CHECKING:
    import numpy.typing as npt

    from scenelang.grammar.diagnostics import SceneError


class Nil:
    """The empty list."""

    __slots__ = ()

    def __repr__(self) -> str:
        return "NIL"


NIL = Nil()


class Pair:
    """An immutable pair. A list is ``NIL`` or a pair whose ``cdr`` is a list."""

    __slots__ = ("car", "cdr")

    def __init__(self, car: Any, cdr: Any) -> None:
        self.car = car
        self.cdr = cdr

    def __repr__(self) -> str:
        return "<pair>"


def make_list(items: Iterable[Any], tail: Any = NIL) -> Any:
    """The list of ``items``, ending in ``tail``."""
    result = tail
    for item in reversed(items if isinstance(items, (list, tuple)) else list(items)):
        result = Pair(item, result)
    return result


def iterate_list(value: Any) -> Iterator[Any]:
    """The items of a proper list (the tail of an improper one is ignored)."""
    while type(value) is Pair:
        yield value.car
        value = value.cdr


def list_items(value: Any) -> list[Any]:
    """The items of a proper list as a Python list."""
    items = []
    while type(value) is Pair:
        items.append(value.car)
        value = value.cdr
    return items


class Vector(tuple[Any, ...]):
    """A one-dimensional array: all items are ``int`` or all are ``float``."""

    __slots__ = ()


class Matrix(tuple[float, ...]):
    """An affine pose: the upper three rows of a 4x4 matrix, row-major, 12 floats; the last row is 0 0 0 1."""

    __slots__ = ()


IDENTITY = Matrix((1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0))


class Array:
    """An immutable array of two or more dimensions that is no pose."""

    __slots__ = ("data",)

    def __init__(self, data: npt.NDArray[Any]) -> None:
        data.setflags(write=False)
        self.data = data


class Embedding:
    """What tells one instance of a class from another: handle, text and attributes, each optional (paper, eq. 1).

    ``handle`` is the name between the angle brackets (``z1``), ``attributes`` maps names (no colon) to values.
    """

    __slots__ = ("attributes", "handle", "key", "text")

    def __init__(
        self, handle: str | None = None, text: str | None = None, attributes: Mapping[str, Any] | None = None
    ) -> None:
        self.handle = handle
        self.text = text
        self.attributes: Mapping[str, Any] = attributes if attributes is not None else {}
        self.key: Any = None  # cached by ``equality.embedding_key``

    def __repr__(self) -> str:
        return f"<embedding {self.handle or ''}>"


ANONYMOUS = Embedding()


class HandleList:
    """The root's gamma: the lazy, endless list ``<zk> <zk+1> ...`` (language.md, section 4)."""

    __slots__ = ("start",)

    def __init__(self, start: int) -> None:
        self.start = start


class Procedure:
    """Anything that can be applied. ``name`` is what diagnostics call it."""

    __slots__ = ()
    name: str


@dataclass(frozen=True, slots=True, eq=False)
class Condition:
    """What ``guard`` binds for an error that is not a raised value: the error, as data."""

    error: SceneError


# --- mutable twins ---------------------------------------------------------------------------------------------


class Mutable:
    """Something that can change: ``birth`` orders it against running calls, ``observed`` says a stored call read it.

    A negative birth marks a copy that belongs to an embedding and can no longer be changed.
    """

    __slots__ = ("birth", "observed")

    def __init__(self, birth: int) -> None:
        self.birth = birth
        self.observed = False


class MutableList(Mutable):
    __slots__ = ("items",)

    def __init__(self, items: list[Any], birth: int) -> None:
        super().__init__(birth)
        self.items = items


class MutableArray(Mutable):
    __slots__ = ("data",)

    def __init__(self, data: npt.NDArray[Any], birth: int) -> None:
        super().__init__(birth)
        self.data = data


class Table(Mutable):
    """Insertion-ordered; ``entries`` maps a canonical key to ``(key, value)``."""

    __slots__ = ("entries",)

    def __init__(self, entries: dict[Any, tuple[Any, Any]], birth: int) -> None:
        super().__init__(birth)
        self.entries = entries


class Set(Mutable):
    """Insertion-ordered; ``entries`` maps a canonical key to the member."""

    __slots__ = ("entries",)

    def __init__(self, entries: dict[Any, Any], birth: int) -> None:
        super().__init__(birth)
        self.entries = entries


class RecordType:
    """The type that ``define-record`` makes."""

    __slots__ = ("fields", "name")

    def __init__(self, name: str, fields: tuple[str, ...]) -> None:
        self.name = name
        self.fields = fields


class Record(Mutable):
    __slots__ = ("type", "values")

    def __init__(self, record_type: RecordType, values: list[Any], birth: int) -> None:
        super().__init__(birth)
        self.type = record_type
        self.values = values


class Stream(Mutable):
    """A random stream of one's own; ``generator`` is numpy's ``RandomState``/``Generator`` or ``random.Random``."""

    __slots__ = ("generator", "kind")

    def __init__(self, kind: str, generator: Any, birth: int) -> None:
        super().__init__(birth)
        self.kind = kind
        self.generator = generator

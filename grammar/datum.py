"""Datums, the syntax tree that the reader produces from text; every datum carries its source span. Also the data
classes that the rest is made of."""

from __future__ import annotations

import gc
from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Mapping, Set
from contextlib import contextmanager
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias, TypeVar, cast, dataclass_transform


@contextmanager
def rare_collection() -> Iterator[None]:
    """Context in which garbage is collected rarely: programs and scenes are many small objects that stay.

    Formatting 1 MB takes half the time.
    """
    thresholds = gc.get_threshold()
    gc.set_threshold(200_000, 50, 100)
    try:
        yield
    finally:
        gc.set_threshold(*thresholds)


# Data classes. Those of the standard library write and compile up to eight methods of each class when it is defined,
# which was half of what a command took to start. Here the constructor is written for the first instance, and the other
# methods are shared. They are data classes to type checkers, and to the functions of ``dataclasses``.

T = TypeVar("T")
_MISSING: Any = object()
_NO_METADATA: Mapping[str, Any] = MappingProxyType({})


class Field:
    """Field of a data class; the arguments are those of ``dataclasses.field``."""

    __slots__ = ("compare", "default", "factory", "init", "metadata", "name", "repr")

    def __init__(
        self, default: Any, factory: Any = _MISSING, init: bool = True, repr: bool = True, compare: bool = True,
        metadata: Mapping[str, Any] = _NO_METADATA,
    ) -> None:  # fmt: skip
        self.name = ""
        self.default, self.factory, self.init, self.repr, self.compare = default, factory, init, repr, compare
        self.metadata = metadata


def field(
    *, default: Any = _MISSING, default_factory: Any = _MISSING, init: bool = True, repr: bool = True,
    compare: bool = True, metadata: Mapping[str, Any] = _NO_METADATA,
) -> Any:  # fmt: skip
    """Declare a field of a data class, as ``dataclasses.field`` does."""
    return Field(default, default_factory, init, repr, compare, metadata)


@dataclass_transform(field_specifiers=(field,))
def dataclass(
    *, frozen: bool = False, slots: bool = False, eq: bool = True, kw_only: bool = False, repr: bool = True
) -> Callable[[type[T]], type[T]]:
    """Return a decorator that makes a data class, as ``dataclasses.dataclass`` does.

    Methods that the class defines are kept.
    """

    def decorate(kind: type[T]) -> type[T]:
        own = _own_fields(kind)
        made = _with_slots(kind, own) if slots else kind
        known = {each.name: each for each in getattr(kind, "__record__", ())} | {each.name: each for each in own}
        methods: dict[str, Any] = {
            "__record__": tuple(known.values()),
            "__match_args__": () if kw_only else tuple(name for name, each in known.items() if each.init),
            "__init__": _first_constructor(made, frozen, kw_only),
            "__signature__": _Signature(made, frozen, kw_only),
            "__dataclass_fields__": _Standard("__dataclass_fields__", made, frozen, eq, kw_only),
            "__dataclass_params__": _Standard("__dataclass_params__", made, frozen, eq, kw_only),
        }
        if repr:
            methods["__repr__"] = _repr
        if eq:
            methods |= {"__eq__": _is_equal, "__hash__": _hash if frozen else None}
        if frozen:
            methods |= {"__setattr__": _refuse_to_set, "__delattr__": _refuse_to_delete}
        if frozen and slots:
            methods |= {"__getstate__": _state, "__setstate__": _set_state}
        for name, method in methods.items():
            if name not in kind.__dict__ or (name == "__hash__" and kind.__dict__[name] is None):
                setattr(made, name, method)
        return made

    return decorate


def _own_fields(kind: type) -> list[Field]:
    """Return the fields that a class declares, and leave only their defaults in it."""
    found = []
    for name, annotation in kind.__annotations__.items():
        if str(annotation).startswith("ClassVar"):
            continue
        default = kind.__dict__.get(name, _MISSING)
        each = default if isinstance(default, Field) else Field(default)
        each.name = name
        if each is default:
            if each.default is _MISSING:
                delattr(kind, name)
            else:
                setattr(kind, name, each.default)
        found.append(each)
    return found


def _with_slots(kind: type[T], own: list[Field]) -> type[T]:
    names = tuple(each.name for each in own)
    space = {name: value for name, value in kind.__dict__.items() if name not in (*names, "__dict__", "__weakref__")}
    make: Any = type(kind)
    made = make(kind.__name__, kind.__bases__, {**space, "__slots__": names})
    made.__qualname__ = kind.__qualname__
    return cast("type[T]", made)


def _first_constructor(kind: type, frozen: bool, kw_only: bool) -> Callable[..., None]:
    """Return a constructor that puts the real one in its place."""

    def __init__(self: Any, *values: Any, **named: Any) -> None:
        _complete(kind, frozen, kw_only)
        kind.__init__(self, *values, **named)  # type: ignore[misc]

    return __init__


def _complete(kind: type, frozen: bool, kw_only: bool) -> None:
    """Write and compile the constructor of a data class."""
    fields: tuple[Field, ...] = kind.__record__  # type: ignore[attr-defined]
    space: dict[str, Any] = {"_missing": _MISSING, "_set": object.__setattr__}
    parameters, lines = ["self", *(["*"] if kw_only else [])], []
    for each in fields:
        value = name = each.name
        if each.factory is not _MISSING:
            space[f"_make_{name}"] = each.factory
            value = f"_make_{name}() if {name} is _missing else {name}" if each.init else f"_make_{name}()"
        if each.default is not _MISSING:
            space[f"_default_{name}"] = each.default
        default = "_missing" if each.factory is not _MISSING else f"_default_{name}"
        if each.init:
            parameters.append(name if each.factory is each.default else f"{name}={default}")
        elif each.factory is _MISSING:
            if each.default is _MISSING:
                continue
            value = f"_default_{name}"
        lines.append(f" _set(self, {name!r}, {value})" if frozen else f" self.{name} = {value}")
    if hasattr(kind, "__post_init__"):
        lines.append(" self.__post_init__()")
    exec(f"def __init__({', '.join(parameters)}):\n" + "\n".join([*lines, " return None"]), space)  # noqa: S102  # nosec
    constructor = space["__init__"]
    constructor.__qualname__ = f"{kind.__qualname__}.__init__"
    types = {each.name: _annotation(kind, each.name) for each in fields if each.init}
    constructor.__annotations__ = types | {"return": None}
    kind.__init__ = constructor  # type: ignore[misc]


class _Standard:
    """Attribute by which ``dataclasses`` knows its classes; it is made when somebody asks."""

    def __init__(self, name: str, kind: type, frozen: bool, eq: bool, kw_only: bool) -> None:
        self._name, self._kind, self._frozen, self._eq, self._kw_only = name, kind, frozen, eq, kw_only

    def __get__(self, instance: object, owner: type) -> Any:
        import dataclasses

        space: dict[str, Any] = {"__annotations__": {}}
        for each in self._kind.__record__:  # type: ignore[attr-defined]
            options: dict[str, Any] = {"init": each.init, "repr": each.repr, "compare": each.compare}
            options |= {} if each.default is _MISSING else {"default": each.default}
            options |= {} if each.factory is _MISSING else {"default_factory": each.factory}
            space[each.name] = dataclasses.field(metadata=each.metadata, kw_only=self._kw_only, **options)
            space["__annotations__"][each.name] = _annotation(self._kind, each.name)
        made: Any = type(self._kind.__name__, (), space)
        made = dataclasses.dataclass(frozen=self._frozen, eq=self._eq)(made)
        value = getattr(made, self._name)
        setattr(self._kind, self._name, value)
        return value


class _Signature:
    """Attribute that ``inspect`` asks for before it looks at the constructor, which must be the real one then."""

    def __init__(self, kind: type, frozen: bool, kw_only: bool) -> None:
        self._options = kind, frozen, kw_only

    def __get__(self, instance: object, owner: type) -> Any:
        _complete(*self._options)
        raise AttributeError("__signature__")


def _annotation(kind: type, name: str) -> Any:
    return next(types[name] for base in kind.__mro__ if name in (types := getattr(base, "__annotations__", {})))


def _key(record: Any) -> tuple[Any, ...]:
    return tuple(getattr(record, each.name) for each in record.__record__ if each.compare)


def _repr(self: Any) -> str:
    name = type(self).__qualname__
    try:
        parts = (f"{each.name}={getattr(self, each.name)!r}" for each in self.__record__ if each.repr)
        return f"{name}({', '.join(parts)})"
    except RecursionError:  # a program may be nested more deeply than calls
        return f"{name}(...)"


def _is_equal(self: Any, other: object) -> Any:
    return _key(self) == _key(other) if type(other) is type(self) else NotImplemented


def _hash(self: Any) -> int:
    return hash(_key(self))


def _refuse_to_set(self: Any, name: str, value: Any) -> None:
    from dataclasses import FrozenInstanceError

    if "__record__" in type(self).__dict__ or name in self.__match_args__:
        raise FrozenInstanceError(f"cannot assign to field {name!r}")
    object.__setattr__(self, name, value)


def _refuse_to_delete(self: Any, name: str) -> None:
    from dataclasses import FrozenInstanceError

    raise FrozenInstanceError(f"cannot delete field {name!r}")


def _state(self: Any) -> list[Any]:
    return [getattr(self, each.name) for each in self.__record__]


def _set_state(self: Any, state: list[Any]) -> None:
    for each, value in zip(self.__record__, state):
        object.__setattr__(self, each.name, value)


if TYPE_CHECKING:
    from dataclasses import fields as fields
    from dataclasses import replace as replace
else:

    def fields(kind):
        """Return the fields of a data class, as ``dataclasses.fields`` does."""
        return (
            kind.__record__ if _is_ours(kind if isinstance(kind, type) else type(kind)) else _standard("fields")(kind)
        )

    def replace(record, /, **changes):
        """Return a copy of a data class with changes, as ``dataclasses.replace`` does."""
        if not _is_ours(type(record)):
            return _standard("replace")(record, **changes)
        kept = {each.name: getattr(record, each.name) for each in record.__record__ if each.init}
        return type(record)(**kept | changes)

    def _is_ours(kind):
        """Whether the nearest class with fields is ours, not one of the standard library that extends one of ours."""
        declared = (base.__dict__ for base in kind.__mro__)
        found = next((each for each in declared if "__record__" in each or "__dataclass_fields__" in each), {})
        return "__record__" in found

    def _standard(name):
        import dataclasses

        return getattr(dataclasses, name)


# Source files and locations. Spans are character offsets; line and column are computed only on demand.


@dataclass(frozen=True, eq=False)
class Source:
    """Named source text. The name is the path as the user wrote it, or a placeholder such as ``<stdin>``."""

    name: str
    text: str = field(repr=False)

    @cached_property
    def _line_starts(self) -> list[int]:
        starts = [0]
        find = self.text.find
        position = find("\n")
        while position >= 0:
            starts.append(position + 1)
            position = find("\n", position + 1)
        return starts

    def position(self, offset: int) -> tuple[int, int]:
        """Return the line and column of ``offset``, both counted from 1; columns count characters."""
        line = bisect_right(self._line_starts, offset)
        return line, offset - self._line_starts[line - 1] + 1

    def line_start(self, number: int) -> int:
        """Return the offset of the first character of line ``number`` (from 1)."""
        return self._line_starts[number - 1]

    def line(self, number: int) -> str:
        """Return the text of line ``number`` (from 1) without its line ending."""
        starts = self._line_starts
        end = starts[number] if number < len(starts) else len(self.text)
        return self.text[starts[number - 1] : end].rstrip("\r\n")


def comment_above(source: Source, offset: int) -> list[str]:
    """Return the comment lines directly above the line of ``offset``, unchanged."""
    number = source.position(offset)[0] - 1
    found: list[str] = []
    while number >= 1 and (line := source.line(number).strip()).startswith(";"):
        found.insert(0, line)
        number -= 1
    return found


class Expansion(NamedTuple):
    """Macro expansion that produced a datum: the macro's name, the span of its definition, the enclosing expansion."""

    macro: str
    definition: Span | None
    outer: Expansion | None = None


class Span(NamedTuple):
    """Half-open range of characters, ``source.text[start:end]``.

    ``expansion`` is set on datums produced by a macro; the span is then that of the macro use.
    """

    source: Source
    start: int
    end: int
    expansion: Expansion | None = None

    def overlaps(self, other: Span) -> bool:
        """Return whether both are ranges of one source that share a character."""
        return self.source is other.source and self.start < other.end and other.start < self.end

    @property
    def text(self) -> str:
        return self.source.text[self.start : self.end]


class TextEdit(NamedTuple):
    """Replacement of the text from ``start`` to ``end``."""

    start: int
    end: int
    text: str

    def overlaps(self, other: TextEdit) -> bool:
        """Return whether both replace a common character, or the same place."""
        is_same = (self.start, self.end) == (other.start, other.end)
        return is_same or (self.start < other.end and other.start < self.end)


def with_edits(text: str, edits: Iterable[TextEdit]) -> str:
    """Return a text after edits that do not overlap, whose offsets are those of the text before all of them."""
    for start, end, new in sorted(edits, reverse=True):
        text = text[:start] + new + text[end:]
    return text


class Symbol(str):
    """Symbol. Compares and hashes like its name; only its type distinguishes it from a string."""

    __slots__ = ()


class Keyword(str):
    """Keyword ``:name``; the text is the name without the colon."""

    __slots__ = ()


class Handle(str):
    """Embedding handle ``<z1>``; the text is the name without the angle brackets."""

    __slots__ = ()


@dataclass(frozen=True, slots=True, eq=False)
class Atom:
    """Leaf of the tree. ``value`` is a Symbol, Keyword, Handle, int, float, str or bool, or None for ``none``."""

    value: Any
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class ListDatum:
    """Proper list ``(a b)``, or improper list ``(a . b)`` if ``tail`` is not None. ``'x`` reads as ``(quote x)``."""

    items: tuple[Any, ...]
    tail: Any
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class ArrayDatum:
    """Array literal ``[a b]``."""

    items: tuple[Any, ...]
    span: Span


Datum: TypeAlias = Atom | ListDatum | ArrayDatum

PREFIXES = {"'": "quote", "`": "quasiquote", ",": "unquote", ",@": "unquote-splicing"}


def subdatums(datum: Datum) -> Iterator[Datum]:
    """Iterate over the direct children of a datum, including the tail of an improper list."""
    if not isinstance(datum, Atom):
        yield from datum.items
        if isinstance(datum, ListDatum) and datum.tail is not None:
            yield datum.tail


def walk(*datums: Datum) -> Iterator[Datum]:
    """Iterate over ``datums`` and all their descendants in unspecified order, without recursion."""
    stack = list(datums)
    while stack:
        datum = stack.pop()
        yield datum
        if not isinstance(datum, Atom):
            stack.extend(subdatums(datum))


def is_deeper(datums: Iterable[Datum], most: int) -> bool:
    """Return whether lists are nested in more than ``most`` levels."""
    level = [datum for datum in datums if not isinstance(datum, Atom)]
    for _ in range(most):
        level = [below for datum in level for below in subdatums(datum) if not isinstance(below, Atom)]
        if not level:
            return False
    return bool(level)


# Printing datums as text that reads back equal. It is iterative, so that deep nesting cannot overflow the stack.


_MAX_BITS = 14_000  # Python refuses to print more than 4,300 digits
_NO_SPELLING: Mapping[int, str] = MappingProxyType({})
_PREFIX_OF = {name: prefix for prefix, name in PREFIXES.items()}
_STRING_ESCAPES = {
    '"': '\\"', "\\": "\\\\", "\n": "\\n", "\t": "\\t", "\r": "\\r", "\a": "\\a", "\b": "\\b", "\0": "\\0",
}  # fmt: skip


def number_text(value: int | float) -> str:
    """Return a number as text that reads back equal; ``nan`` and ``inf`` by name."""
    if type(value) is int and value.bit_length() > _MAX_BITS:
        return f"<integer of {value.bit_length():,} bits>"
    return repr(value)


def string_text(value: str) -> str:
    """Return ``value`` as a string literal, with escapes."""
    pieces = []
    for c in value:
        if c in _STRING_ESCAPES:
            pieces.append(_STRING_ESCAPES[c])
        else:
            pieces.append(c if c.isprintable() else f"\\x{ord(c):x};")
    return '"' + "".join(pieces) + '"'


def atom_text(value: Any) -> str:
    """Return the text of an atom's value; a value that is not an atom prints as ``<type>``."""
    kind = type(value)
    if kind is Symbol:
        return str(value)
    if kind is Keyword:
        return f":{value}"
    if kind is Handle:
        return f"<{value}>"
    if kind is str:
        return string_text(value)
    if kind is bool:
        return "#t" if value else "#f"
    if value is None:
        return "none"
    if kind is int or kind is float:
        return number_text(value)
    return f"<{kind.__name__}>"


def print_datum(datum: Datum, spelling: Mapping[int, str] = _NO_SPELLING, plain: Set[int] = frozenset()) -> str:
    """Return the text of ``datum`` on one line.

    Parameters
    ----------
    datum
        The datum to print.
    spelling
        Original spelling of atoms, by ``id``, which takes precedence over their canonical text.
    plain
        Ids of lists such as ``(quote x)`` that are printed in full rather than as ``'x``.
    """
    out: list[str] = []
    stack: list[Any] = [datum]
    while stack:
        item = stack.pop()
        if isinstance(item, str) and type(item) is str:
            out.append(item)
        elif isinstance(item, Atom):
            out.append(spelling.get(id(item)) or atom_text(item.value))
        else:
            _push(item, stack, plain)
    return "".join(out)


def quote_prefix(datum: Datum) -> str | None:
    """Return the prefix character of a list such as ``(quote x)``, or None if it is not written with one."""
    if not isinstance(datum, ListDatum) or len(datum.items) != 2 or datum.tail is not None:
        return None
    head, operand = datum.items
    if isinstance(operand, Atom) and str(operand.value).startswith("@"):  # `,` before `@x` would read back as `,@`
        return None
    return _PREFIX_OF.get(head.value) if isinstance(head, Atom) and type(head.value) is Symbol else None


def _push(item: Any, stack: list[Any], plain: Set[int]) -> None:
    """Push the pieces of a compound datum onto ``stack``, in reverse order."""
    prefix = quote_prefix(item) if id(item) not in plain else None
    if prefix is not None:
        stack += (item.items[1], prefix)
        return
    opening, closing = ("[", "]") if isinstance(item, ArrayDatum) else ("(", ")")
    stack.append(closing)
    if isinstance(item, ListDatum) and item.tail is not None:
        stack += (item.tail, " . ")
    for position in range(len(item.items) - 1, -1, -1):
        stack.append(item.items[position])
        if position:
            stack.append(" ")
    stack.append(opening)

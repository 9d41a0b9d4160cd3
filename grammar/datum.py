"""Datums, the syntax tree that the reader produces from text; every datum carries its source span.

Also the data classes of the whole project."""

from __future__ import annotations

import gc
from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Mapping, Set
from contextlib import contextmanager
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias, TypeVar, cast, dataclass_transform

_RARE_THRESHOLDS = (200_000, 50, 100)  # objects, and collections of the younger generation, as in ``gc.set_threshold``


@contextmanager
def rare_collection() -> Iterator[None]:
    """Collect garbage rarely within the context.

    Programs and scenes are many small objects that stay, so with the default thresholds the collector traverses the
    same trees again and again. With these, formatting 1 MB takes half the time.
    """
    thresholds = gc.get_threshold()
    gc.set_threshold(*_RARE_THRESHOLDS)
    try:
        yield
    finally:
        gc.set_threshold(*thresholds)


# Data classes. Those of the standard library write and compile up to eight methods of each class when it is defined: 83
# classes took a third of the time of ``check``. Here the constructor is compiled for classes of many instances, and the
# other methods are shared. They are data classes to type checkers and to the functions of ``dataclasses``. Every class
# that declares settings (``grammar/settings``) must be one of them. A module takes ``dataclass``, ``field``, ``fields``
# and ``replace`` either from here or from ``dataclasses``, never from both, because the two kinds of fields do not mix.

T = TypeVar("T")
_MISSING: Any = object()
_NO_METADATA: Mapping[str, Any] = MappingProxyType({})


class Field:
    """Field of a data class; the arguments are those of ``dataclasses.field``."""

    __slots__ = ("compare", "default", "factory", "init", "metadata", "name", "repr")

    def __init__(
        self, default: Any, factory: Any = _MISSING, *, init: bool = True, repr: bool = True, compare: bool = True,
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
    return Field(default, default_factory, init=init, repr=repr, compare=compare, metadata=metadata)


@dataclass_transform(field_specifiers=(field,))
def dataclass(
    *, frozen: bool = False, slots: bool = False, eq: bool = True, kw_only: bool = False, repr: bool = True
) -> Callable[[type[T]], type[T]]:
    """Return a decorator that makes a data class, as ``dataclasses.dataclass`` does.

    Methods that the class defines itself are not replaced.
    """

    def decorate(kind: type[T]) -> type[T]:
        """Add the shared methods, and a constructor that compiles itself once the class has some instances."""
        declared = _own_fields(kind)
        itself: list[type] = []  # the data class, which the methods refer to before it exists
        by_name = {entry.name: entry for entry in getattr(kind, "__record__", ())} | {
            entry.name: entry for entry in declared
        }
        options = {"frozen": frozen, "eq": eq, "kw_only": kw_only}
        methods: dict[str, Any] = {
            "__record__": tuple(by_name.values()),
            "__match_args__": () if kw_only else tuple(name for name, entry in by_name.items() if entry.init),
            "__init__": _first_constructor(itself, frozen=frozen, kw_only=kw_only),
            "__signature__": _Signature(itself, frozen=frozen, kw_only=kw_only),
            "__dataclass_fields__": _Standard("__dataclass_fields__", itself, options),
            "__dataclass_params__": _Standard("__dataclass_params__", itself, options),
        }
        if repr:
            methods["__repr__"] = _repr
        if eq:
            methods |= {"__eq__": _is_equal, "__hash__": _hash if frozen else None}
        if frozen:
            methods |= {"__setattr__": _refuse_to_set, "__delattr__": _refuse_to_delete}
        if frozen and slots:
            methods |= {"__getstate__": _state, "__setstate__": _set_state}
        own = kind.__dict__
        methods = {
            name: method
            for name, method in methods.items()
            if name not in own or (name == "__hash__" and own[name] is None)
        }
        if slots:
            itself.append(_with_slots(kind, declared, methods))
        else:
            itself.append(kind)
            for name, method in methods.items():
                setattr(kind, name, method)
        return cast("type[T]", itself[0])

    return decorate


def _own_fields(kind: type) -> list[Field]:
    """Return the fields that a class itself declares, and leave only their defaults in its namespace."""
    declared = []
    for name, annotation in kind.__annotations__.items():
        if str(annotation).startswith("ClassVar"):
            continue
        default = kind.__dict__.get(name, _MISSING)
        entry = default if isinstance(default, Field) else Field(default)
        entry.name = name
        if entry is default:
            if entry.default is _MISSING:
                delattr(kind, name)
            else:
                setattr(kind, name, entry.default)
        declared.append(entry)
    return declared


def _with_slots(kind: type, declared: list[Field], methods: Mapping[str, Any]) -> type:
    """Return a copy of a class with slots for its fields, because a class cannot gain slots once it exists.

    It is made with its methods: each one that is set later updates the class and those derived from it.
    """
    names = tuple(entry.name for entry in declared)
    namespace = {
        name: value for name, value in kind.__dict__.items() if name not in (*names, "__dict__", "__weakref__")
    }
    metaclass: Any = type(kind)
    slotted: type = metaclass(kind.__name__, kind.__bases__, {**namespace, **methods, "__slots__": names})
    slotted.__qualname__ = kind.__qualname__
    return slotted


# Instances of a class before its constructor is compiled: half of the classes of a command have fewer.
_UNCOMPILED_INSTANCES = 20


def _first_constructor(itself: list[type], *, frozen: bool, kw_only: bool) -> Callable[..., None]:
    """Return a constructor that replaces itself by a compiled one, if the class gets more than a few instances.

    ``itself`` contains the class, once it exists. Compiling a constructor takes as long as 40 calls of this one.
    """
    left = _UNCOMPILED_INSTANCES

    def __init__(self: Any, *values: Any, **named: Any) -> None:
        nonlocal left
        left -= 1
        kind: Any = itself[0]
        if left < 0 or (kw_only and values) or not _construct(self, kind, values, named):
            _complete(kind, frozen=frozen, kw_only=kw_only)
            kind.__init__(self, *values, **named)

    return __init__


def _construct(self: Any, kind: Any, values: tuple[Any, ...], named: dict[str, Any]) -> bool:
    """Set the fields of a new instance; return whether the arguments fit, which a compiled constructor reports."""
    fields: tuple[Field, ...] = kind.__record__
    names = [entry.name for entry in fields if entry.init]
    given = dict(zip(names, values))
    if len(values) > len(names) or not named.keys() <= set(names[len(values) :]):
        return False
    given |= named
    if not all(
        entry.name in given or entry.default is not _MISSING or entry.factory is not _MISSING
        for entry in fields
        if entry.init
    ):
        return False
    for entry in fields:
        if entry.name in given:
            value = given[entry.name]
        elif entry.factory is not _MISSING:
            value = entry.factory()
        elif entry.default is not _MISSING:
            value = entry.default
        else:
            continue
        object.__setattr__(self, entry.name, value)
    if hasattr(kind, "__post_init__"):
        self.__post_init__()
    return True


def _complete(kind: type, *, frozen: bool, kw_only: bool) -> None:
    """Write, compile and install the constructor of a data class.

    Its text is that of a class written by hand: default factories run only if the argument is missing, and fields of
    frozen classes are set past ``__setattr__``.
    """
    fields: tuple[Field, ...] = kind.__record__  # type: ignore[attr-defined]
    namespace: dict[str, Any] = {"_missing": _MISSING, "_set": object.__setattr__}
    parameters, lines = ["self", *(["*"] if kw_only else [])], []
    for entry in fields:
        value = name = entry.name
        if entry.factory is not _MISSING:
            namespace[f"_make_{name}"] = entry.factory
            value = f"_make_{name}() if {name} is _missing else {name}" if entry.init else f"_make_{name}()"
        if entry.default is not _MISSING:
            namespace[f"_default_{name}"] = entry.default
        default = "_missing" if entry.factory is not _MISSING else f"_default_{name}"
        if entry.init:
            parameters.append(name if entry.factory is entry.default else f"{name}={default}")
        elif entry.factory is _MISSING:
            if entry.default is _MISSING:
                continue
            value = f"_default_{name}"
        lines.append(f" _set(self, {name!r}, {value})" if frozen else f" self.{name} = {value}")
    if hasattr(kind, "__post_init__"):
        lines.append(" self.__post_init__()")
    exec(f"def __init__({', '.join(parameters)}):\n" + "\n".join([*lines, " return None"]), namespace)  # noqa: S102  # nosec
    constructor = namespace["__init__"]
    constructor.__qualname__ = f"{kind.__qualname__}.__init__"
    types = {entry.name: _annotation(kind, entry.name) for entry in fields if entry.init}
    constructor.__annotations__ = types | {"return": None}
    kind.__init__ = constructor  # type: ignore[misc]


class _Standard:
    """Attribute by which ``dataclasses`` recognizes its classes; it is computed on first access.

    ``options`` are the arguments ``frozen``, ``eq`` and ``kw_only`` of the decorator.
    """

    def __init__(self, name: str, itself: list[type], options: Mapping[str, bool]) -> None:
        self._name, self._itself, self._options = name, itself, options

    def __get__(self, instance: object, owner: type) -> Any:
        """Build an equal class of the standard library, and store its attribute in place of this descriptor."""
        import dataclasses

        kind: Any = self._itself[0]
        namespace: dict[str, Any] = {"__annotations__": {}}
        for entry in kind.__record__:
            options: dict[str, Any] = {"init": entry.init, "repr": entry.repr, "compare": entry.compare}
            options["kw_only"] = self._options["kw_only"]
            options |= {} if entry.default is _MISSING else {"default": entry.default}
            options |= {} if entry.factory is _MISSING else {"default_factory": entry.factory}
            namespace[entry.name] = dataclasses.field(metadata=entry.metadata, **options)
            namespace["__annotations__"][entry.name] = _annotation(kind, entry.name)
        standard: Any = type(kind.__name__, (), namespace)
        standard = dataclasses.dataclass(frozen=self._options["frozen"], eq=self._options["eq"])(standard)
        value = getattr(standard, self._name)
        setattr(kind, self._name, value)
        return value


class _Signature:
    """Attribute that ``inspect.signature`` reads before the constructor, which must be the real one by then."""

    def __init__(self, itself: list[type], *, frozen: bool, kw_only: bool) -> None:
        self._itself, self._frozen, self._kw_only = itself, frozen, kw_only

    def __get__(self, instance: object, owner: type) -> Any:
        _complete(self._itself[0], frozen=self._frozen, kw_only=self._kw_only)
        raise AttributeError("__signature__")


def _annotation(kind: type, name: str) -> Any:
    """Return the annotation of a field, which a base class may declare."""
    return next(types[name] for base in kind.__mro__ if name in (types := getattr(base, "__annotations__", {})))


def _key(record: Any) -> tuple[Any, ...]:
    """Return the values by which instances of one class are compared and hashed."""
    return tuple(getattr(record, entry.name) for entry in record.__record__ if entry.compare)


def _repr(self: Any) -> str:
    name = type(self).__qualname__
    try:
        parts = (f"{entry.name}={getattr(self, entry.name)!r}" for entry in self.__record__ if entry.repr)
        return f"{name}({', '.join(parts)})"
    except RecursionError:  # a program may be nested more deeply than calls
        return f"{name}(...)"


def _is_equal(self: Any, other: object) -> Any:
    return _key(self) == _key(other) if type(other) is type(self) else NotImplemented


def _hash(self: Any) -> int:
    return hash(_key(self))


def _refuse_to_set(self: Any, name: str, value: Any) -> None:
    """Refuse to set a field of a frozen class; a subclass that is not a data class may have attributes of its own."""
    from dataclasses import FrozenInstanceError

    if "__record__" in type(self).__dict__ or name in self.__match_args__:
        raise FrozenInstanceError(f"cannot assign to field {name!r}")
    object.__setattr__(self, name, value)


def _refuse_to_delete(self: Any, name: str) -> None:
    from dataclasses import FrozenInstanceError

    raise FrozenInstanceError(f"cannot delete field {name!r}")


def _state(self: Any) -> list[Any]:
    return [getattr(self, entry.name) for entry in self.__record__]


def _set_state(self: Any, state: list[Any]) -> None:
    for entry, value in zip(self.__record__, state):
        object.__setattr__(self, entry.name, value)


if TYPE_CHECKING:
    from dataclasses import asdict as asdict
    from dataclasses import fields as fields
    from dataclasses import replace as replace
else:

    def fields(kind):
        """Return the fields of a data class, as ``dataclasses.fields`` does."""
        return (
            kind.__record__ if _is_ours(kind if isinstance(kind, type) else type(kind)) else _standard("fields")(kind)
        )

    def asdict(record):
        """Return the fields of a data class by name, with those of data classes in them, as ``dataclasses.asdict``
        does."""
        return _standard("asdict")(record)

    def replace(record, /, **changes):
        """Return a copy of a data class with changes, as ``dataclasses.replace`` does."""
        if not _is_ours(type(record)):
            return _standard("replace")(record, **changes)
        values = {entry.name: getattr(record, entry.name) for entry in record.__record__ if entry.init}
        return type(record)(**values | changes)

    def _is_ours(kind):
        """Return whether the nearest data class is one of this module, not one of ``dataclasses`` that extends it."""
        namespaces = (base.__dict__ for base in kind.__mro__)
        nearest = next(
            (namespace for namespace in namespaces if "__record__" in namespace or "__dataclass_fields__" in namespace),
            {},
        )
        return "__record__" in nearest

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
    """Return the comment lines directly above the line of ``offset``, without indentation."""
    number = source.position(offset)[0] - 1
    lines: list[str] = []
    while number >= 1 and (line := source.line(number).strip()).startswith(";"):
        lines.insert(0, line)
        number -= 1
    return lines


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
        """Characters of the range."""
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
    """Return whether lists are nested in more than ``most`` levels.

    Level by level rather than by recursion, because the caller asks before it knows that recursion is safe.
    """
    level = [datum for datum in datums if not isinstance(datum, Atom)]
    for _ in range(most):
        level = [below for datum in level for below in subdatums(datum) if not isinstance(below, Atom)]
        if not level:
            return False
    return bool(level)


# Printing datums as text that reads back equal. It is iterative, so that deep nesting cannot overflow the stack.


_MAX_BITS = 14_000  # 4,215 digits: CPython refuses to print integers of more than 4,300 (``sys.int_info``)
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

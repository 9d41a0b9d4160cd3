"""Parameter types: the paper's annotations and the types of builtins' parameters, with checks and conversions."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from functools import cache, cached_property, partial
from itertools import islice
from typing import Any, Protocol

from scenelang.grammar.datum import Datum, ListDatum, Source, Span, dataclass, field
from scenelang.grammar.lazy_patterns import lazy_pattern
from scenelang.grammar.reader import piece_at, read
from scenelang.interpreter.loading import np
from scenelang.interpreter.scene import pose
from scenelang.interpreter.scene.entity import Entity, Frames
from scenelang.interpreter.values.values import (
    NIL,
    Array,
    Condition,
    Embedding,
    HandleList,
    Keyword,
    Matrix,
    Mutable,
    MutableArray,
    MutableList,
    Pair,
    Procedure,
    Record,
    RecordType,
    Set,
    Stream,
    Symbol,
    Table,
    Vector,
    iterate_list,
    list_items,
    make_list,
)


class Mismatch(Exception):
    """Raised for a value of the wrong type; converted to a diagnostic by code that knows the parameter."""


class TypeReader(Protocol):
    """Callbacks of conversions, implemented by the runtime, that track reads of mutable values and the work done."""

    def read(self, value: Mutable) -> None:
        """Record that ``value`` is read."""

    @property
    def charge(self) -> Callable[[int], None]:
        """Function that counts steps of work."""


@dataclass(frozen=True, slots=True, eq=False)
class Type:
    """Type of a parameter.

    ``checker(reader)`` returns a function that converts a value to this type or raises ``Mismatch``. A type that
    inspects the contents of values has ``walk``, which also takes the reader; other types have ``convert``.
    """

    name: str
    convert: Callable[[Any], Any]
    walk: Callable[[TypeReader, Any], Any] | None = None

    @property
    def is_checked(self) -> bool:
        """Whether the checker does anything; of the other types, builtins check the values themselves."""
        return self.convert is not _identity or self.walk is not None

    def converted(self, reader: TypeReader, value: Any) -> Any:
        """Return a value converted to this type; raise ``Mismatch`` if it does not fit."""
        return self.convert(value) if self.walk is None else self.walk(reader, value)

    def checker(self, reader: TypeReader) -> Callable[[Any], Any]:
        """Return the function that converts a value to this type or raises ``Mismatch``."""
        return self.convert if self.walk is None else partial(self.walk, reader)


def type_name(value: Any) -> str:
    """Return the name of a value's type with an article for error messages, such as ``a String`` or ``an Entity``."""
    kind = type(value)
    if kind in _NAMES:
        return _NAMES[kind]
    if isinstance(value, Procedure):
        return "a Function"
    if kind is Record:
        return f"a {value.type.name}"
    return f"a {kind.__name__}"


_NAMES: dict[type, str] = {
    bool: "a Boolean", int: "an Integer", float: "a Float", str: "a String", type(None): "`none`",
    Symbol: "a symbol", Keyword: "a keyword", Pair: "a List", type(NIL): "the empty list", Vector: "a Vector",
    Matrix: "a Matrix", Array: "an Array", MutableArray: "a mutable array", MutableList: "a mutable list",
    Table: "a table", Set: "a set", Stream: "a random stream", Embedding: "an Embedding", Entity: "an Entity",
    Frames: "frames", Condition: "an error", HandleList: "the root's list of handles", RecordType: "a record type",
}  # fmt: skip


def _instance(*kinds: type) -> Callable[[Any], Any]:
    """Return the check that a value is an instance of a class."""

    def convert(value: Any) -> Any:
        if isinstance(value, kinds):
            return value
        raise Mismatch

    return convert


def _integer(value: Any) -> int:
    """Accept an Integer, or a Float without a fraction, which is converted."""
    if type(value) is int:
        return value
    if type(value) is float and value.is_integer():
        return int(value)
    raise Mismatch


def _float(value: Any) -> int | float:
    """Accept a Float, or an Integer, which is not converted."""
    if type(value) is float or type(value) is int:
        return value
    raise Mismatch


def _string(value: Any) -> str:
    if type(value) is str:
        return value
    raise Mismatch


def _boolean(value: Any) -> bool:
    if type(value) is bool:
        return value
    raise Mismatch


def _symbol(value: Any) -> Any:
    if type(value) is Symbol:
        return value
    raise Mismatch


def _keyword(value: Any) -> Any:
    if type(value) is Keyword:
        return value
    raise Mismatch


def _embedding(value: Any) -> Embedding:
    """Accept an Embedding, or a String, which becomes its text."""
    if type(value) is Embedding:
        return value
    if type(value) is str:
        return Embedding(text=value)
    raise Mismatch


def numbers_of(value: Any, reader: TypeReader | None = None) -> list[Any] | None:
    """Return the items of a Vector, one-dimensional array or list if all are numbers, else None.

    ``reader`` records the read of a mutable value.
    """
    if type(value) is Vector:
        if reader is not None:
            reader.charge(len(value) >> 4)
        return list(value)
    if reader is not None:
        _record_read(reader, value)
    if type(value) is Pair:
        items = []
        rest: Any = value
        while type(rest) is Pair:
            items.append(rest.car)
            rest = rest.cdr
        if rest is not NIL:
            return None
    elif isinstance(value, MutableList):
        items = value.items
    elif isinstance(value, MutableArray) and value.data.ndim == 1:
        items = value.data.tolist()
    else:
        return None
    if reader is not None:
        reader.charge(len(items) >> 4)
    return list(items) if all(type(item) in (int, float) for item in items) else None


def _record_read(reader: TypeReader, value: Any) -> None:
    """Record the read of a value if it is mutable."""
    if isinstance(value, Mutable):
        reader.read(value)


def _vector(reader: TypeReader, value: Any) -> Vector:
    """Accept a Vector, or a list or array of numbers, which is converted."""
    if type(value) is Vector:
        return value
    numbers = numbers_of(value, reader)
    if numbers is None:
        raise Mismatch
    return vector_of(numbers)


def vector_of(numbers: list[Any]) -> Vector:
    """Return a Vector of ``numbers``; unless all are integers, they are converted to floats."""
    if all(type(n) is int for n in numbers):
        return Vector(numbers)
    try:
        return Vector([float(n) for n in numbers])
    except OverflowError:
        raise Mismatch from None


def _point(reader: TypeReader, value: Any) -> Vector:
    """Accept a vector of three numbers."""
    vector = _vector(reader, value)
    if len(vector) != 3:
        raise Mismatch
    return vector


def matrix_or_none(reader: TypeReader, value: Any) -> Matrix | None:
    """Convert a Matrix, 4x4 array or nested list to a pose, or return None if it is not one."""
    if type(value) is Matrix:
        return value
    _record_read(reader, value)
    if isinstance(value, (Array, MutableArray)):
        return pose.from_array(value.data)
    if isinstance(value, (Pair, MutableList)):
        members = value.items if isinstance(value, MutableList) else list(islice(iterate_list(value), 5))
        if len(members) != 4:
            return None
        rows = [numbers_of(row, reader) for row in members]
        if all(row is not None and len(row) == 4 for row in rows):
            return pose.from_array(np.array(rows, float))
    return None


def _matrix(reader: TypeReader, value: Any) -> Matrix:
    """Accept a pose, or whatever can be converted to one."""
    matrix = matrix_or_none(reader, value)
    if matrix is None:
        raise Mismatch
    return matrix


def _list(value: Any) -> Any:
    """Accept a list, whatever its items are."""
    if type(value) is Pair or value is NIL or isinstance(value, (MutableList, HandleList)):
        return value
    raise Mismatch


def _list_of(item: Type) -> Callable[[TypeReader, Any], Any]:
    """Return the check of a list whose items have a type; mutable lists are checked, not converted."""

    def walk(reader: TypeReader, value: Any) -> Any:
        """Check a list and convert its items."""
        _list(value)
        if isinstance(value, HandleList):
            return value
        _record_read(reader, value)
        members = value.items if isinstance(value, MutableList) else list_items(value)
        reader.charge(1 + (len(members) >> 3))
        check = item.checker(reader)
        converted = [check(member) for member in members]
        return value if isinstance(value, MutableList) else make_list(converted)

    return walk


def _tuple_of(items: tuple[Type, ...]) -> Callable[[TypeReader, Any], Any]:
    """Return the check of a list with one item of each type, or of a pair of two values."""

    def walk(reader: TypeReader, value: Any) -> Any:
        """Check the length and convert the items."""
        if type(value) is Pair and len(items) == 2 and type(value.cdr) is not Pair and value.cdr is not NIL:
            return Pair(items[0].checker(reader)(value.car), items[1].checker(reader)(value.cdr))
        _record_read(reader, _list(value))
        maximum = len(items) + 1
        members = value.items if isinstance(value, MutableList) else list(islice(iterate_list(value), maximum))
        if len(members) != len(items):
            raise Mismatch
        reader.charge(1)
        converted = [kind.checker(reader)(member) for kind, member in zip(items, members)]
        return value if isinstance(value, MutableList) else make_list(converted)

    return walk


# Entities and the root's handles are accepted here, because functions on sequences report a more specific error.
_SEQUENCES = (Pair, type(NIL), MutableList, Vector, Matrix, Array, MutableArray, Table, Set, HandleList, Entity)


def _sequence(value: Any) -> Any:
    if isinstance(value, _SEQUENCES) or type(value) is str:
        return value
    raise Mismatch


def _identity(value: Any) -> Any:
    """Accept any value."""
    return value


_AXES = ("x", "y", "z")
_ALIGNMENTS = ("min", "center", "max", "before", "after")


def _axis(value: Any) -> Any:
    if type(value) is Keyword and str(value) in _AXES:
        return value
    raise Mismatch


def _alignment(value: Any) -> Any:
    """Accept a keyword of ``align``, or none for an axis that stays."""
    if value is None or (type(value) is Keyword and str(value) in _ALIGNMENTS):
        return value
    raise Mismatch


def _extent(reader: TypeReader, value: Any) -> Any:
    """Accept one number or three."""
    return value if type(value) in (int, float) else _point(reader, value)


_EXPECTED = {
    "Parts": "an Entity, a pair or a list of these", "List[Parts]": "a list of entities",
    "Point": "three numbers `[x y z]`", "Sequence": "a list or another sequence",
    "Template": "an Entity, parts or a function", "Numeric": "a number or an array",
    "ArrayLike": "a number, an array or a list of numbers", "Axis": "`:x`, `:y` or `:z`",
    "Alignment": "`:min`, `:center`, `:max`, `:before` or `:after`", "Extent": "one number or three",
}  # fmt: skip


def expected_name(name: str) -> str:
    """Return the description of a type with an article, for error messages."""
    return _EXPECTED.get(name) or ("an " if name[0] in "AEIOU" else "a ") + name


BASE_TYPES: Mapping[str, Type] = {
    kind.name: kind
    for kind in (
        Type("Any", _identity),
        Type("Word", _string),
        Type("String", _string),
        Type("Embedding", _embedding),
        Type("Matrix", _identity, _matrix),
        Type("Vector", _identity, _vector),
        Type("Point", _identity, _point),
        Type("Array", _instance(Vector, Matrix, Array, MutableArray)),
        Type("Entity", _instance(Entity)),
        Type("Parts", _instance(Entity, Pair, type(NIL), MutableList)),
        Type("Integer", _integer),
        Type("Float", _float),
        Type("Number", _float),
        Type("Numeric", _identity),
        Type("ArrayLike", _identity),
        Type("Boolean", _boolean),
        Type("Function", _instance(Procedure)),
        Type("List", _list),
        Type("Sequence", _sequence),
        Type("Symbol", _symbol),
        Type("Keyword", _keyword),
        Type("Pair", _instance(Pair, HandleList)),
        Type("MutableList", _instance(MutableList)),
        Type("MutableArray", _instance(MutableArray)),
        Type("Table", _instance(Table)),
        Type("Set", _instance(Set)),
        Type("Stream", _instance(Stream)),
        Type("Record", _instance(Record)),
        Type("Axis", _axis),
        Type("Alignment", _alignment),
        Type("Extent", _identity, _extent),
        Type("Template", _instance(Entity, Pair, type(NIL), MutableList, Procedure)),
    )
}
_GENERIC = lazy_pattern(r"(\w+)\[(.*)\]\Z", re.S)


def _split_arguments(text: str) -> list[str]:
    """Split the arguments of a generic type at commas outside brackets."""
    depth, start, parts = 0, 0, []
    for i, c in enumerate(text):
        depth += (c == "[") - (c == "]")
        if c == "," and depth == 0:
            parts.append(text[start:i])
            start = i + 1
    return [part.strip() for part in (*parts, text[start:])]


@cache
def parse_type(text: str) -> Type:
    """Return the type named by an annotation; raise ``KeyError`` with the name if it is unknown."""
    text = text.strip()
    if text in BASE_TYPES:
        return BASE_TYPES[text]
    match = _GENERIC.match(text)
    if match and match[1] in ("List", "Array", "Tuple"):
        arguments = tuple(parse_type(part) for part in _split_arguments(match[2]))
        name = f"{match[1]}[{', '.join(argument.name for argument in arguments)}]"
        if match[1] == "Tuple":
            return Type(name, _identity, _tuple_of(arguments))
        if len(arguments) == 1:
            if match[1] == "List":
                return Type(name, _identity, _list_of(arguments[0]))
            return Type(name, BASE_TYPES["Array"].convert)
    raise KeyError(text)


def record_type(name: str) -> Type:
    """Return the type of the records of ``(define-record name ...)``."""

    def convert(value: Any) -> Any:
        """Accept a record of that type name; a redefined type has the name of the old one."""
        if type(value) is Record and value.type.name == name:
            return value
        raise Mismatch

    return Type(name, convert)


# Interface between the interpreter and the standard library, which the interpreter never imports.
#
# The registry entry of a builtin is the single source of its signature, documentation and example, from which help,
# reference documentation, completion and prompts are generated. Signatures use this notation::
#
#     angle::Float axis::Vector [point::Vector]      two required parameters and an optional one
#     count::Integer items::Any ...                  a rest parameter
#     xs::Sequence [:key::Function] [:reverse::Boolean]   keyword parameters, each optional


STD = "std/"  # prefix of library names, which are never shadowed, and of library modules


@dataclass(frozen=True, slots=True)
class BuiltinParameter:
    """Parameter of a builtin; keyword parameters are optional."""

    name: str
    type: Type
    optional: bool = False
    keyword: bool = False
    rest: bool = False  # takes all remaining arguments


@dataclass(frozen=True)
class Signature:
    """Parameters of a builtin by kind: required, optional and keyword parameters, and one for the remaining arguments.

    ``text`` is the signature as written.
    """

    text: str
    required: tuple[BuiltinParameter, ...]
    optional: tuple[BuiltinParameter, ...]
    rest: BuiltinParameter | None
    keywords: tuple[BuiltinParameter, ...]

    @cached_property
    def positional(self) -> tuple[BuiltinParameter, ...]:
        """Required and optional parameters."""
        return (*self.required, *self.optional)

    @property
    def parameters(self) -> tuple[BuiltinParameter, ...]:
        """All parameters but the one for the remaining arguments."""
        return (*self.positional, *self.keywords)

    def taking(self, count: int) -> Sequence[BuiltinParameter]:
        """Return the parameters that take ``count`` positional arguments."""
        named = self.positional[:count]
        return named if self.rest is None else (*named, *[self.rest] * (count - len(named)))

    def takes(self, count: int) -> bool:
        """Return whether a call may have ``count`` positional arguments."""
        return len(self.required) <= count and (count <= len(self.positional) or self.rest is not None)


_PARAMETER = lazy_pattern(r"\[(?P<inner>[^\s\[\]]+(?:\[.*?\])?)\]|(?P<plain>\.\.\.|[^\s\[\]]+(?:\[[^\s]*\])?)")


def parse_signature(text: str) -> Signature:
    """Parse a signature in the notation above; raise ``ValueError`` for a parameter out of order."""
    parameters: list[BuiltinParameter] = []
    for match in _PARAMETER.finditer(text):
        word = match["inner"] or match["plain"]
        if word == "...":
            last = parameters.pop()
            parameters.append(BuiltinParameter(last.name, last.type, rest=True))
            continue
        keyword = word.startswith(":")
        name, _, annotation = word.lstrip(":").partition("::")
        optional = match["inner"] is not None or keyword
        parameters.append(BuiltinParameter(name, parse_type(annotation or "Any"), optional, keyword))
    required = tuple(p for p in parameters if not (p.optional or p.rest))
    optional = tuple(p for p in parameters if p.optional and not p.keyword)
    rest = next((p for p in parameters if p.rest), None)
    keywords = tuple(p for p in parameters if p.keyword)
    if parameters != [*required, *optional, *([rest] if rest else []), *keywords]:
        raise ValueError(f"parameters out of order in {text!r}")
    return Signature(text, required, optional, rest, keywords)


@dataclass(frozen=True, eq=False)
class Builtin(Procedure):
    """Builtin function, an entry of the registry.

    Attributes
    ----------
    name, parameters, result
        Name, signature of the parameters and type of the result.
    function
        Implementation, called as ``function(runtime, *positionals, **keywords)``. Omitted optional arguments are not
        passed, rest arguments are passed as ``*args``, and dashes in keyword names become underscores.
    doc, example
        Documentation, and an expression with its printed value.
    topic
        Section of the reference documentation.
    since
        Version that introduced the builtin.
    intrinsic
        Operation for which the compiler has a fast path.
    check
        Function that checks literal arguments before the program runs; it raises ``SceneError``, with the names that
        may have been meant as its value.
    picture
        Expression whose rendering illustrates the builtin in the reference.
    """

    name: str
    parameters: str
    result: str
    function: Callable[..., Any]
    doc: str
    example: tuple[str, str] | None
    topic: str
    since: str = "0.1"
    intrinsic: str | None = None
    check: Callable[..., object] | None = None
    picture: str | None = None

    @property
    def checks_arguments(self) -> bool:
        """Whether the function checks its arguments itself, as the intrinsics do, with more specific messages."""
        return self.intrinsic is not None

    @cached_property
    def signature(self) -> Signature:
        """Parsed signature."""
        return parse_signature(self.parameters)

    def checked(self, count: int) -> Sequence[tuple[int, BuiltinParameter]] | None:
        """Return which of ``count`` positional arguments are checked before a call, with their parameters.

        None for a number of arguments that the function does not accept. Kept, since calls without generated code ask
        for it every time.
        """
        if count not in self._checked:
            signature = self.signature
            if not signature.takes(count):
                return None
            checked = () if self.checks_arguments else enumerate(signature.taking(count))
            pairs = [(i, parameter) for i, parameter in checked if parameter.type.is_checked]
            if count > _MAX_KEPT:
                return pairs
            self._checked[count] = tuple(pairs)
        return self._checked[count]

    @cached_property
    def _checked(self) -> dict[int, Sequence[tuple[int, BuiltinParameter]]]:
        return {}

    @property
    def usage(self) -> str:
        """Signature for diagnostics and help, such as ``(rotate angle::Float axis::Vector) -> Matrix``."""
        return f"({self.name}{' ' if self.parameters else ''}{self.parameters}) -> {self.result}"

    @property
    def call_hint(self) -> str:
        """Hint for a wrong call: a call that works, or the signature of a builtin that has no example."""
        text = self.example[0] if self.example is not None else ""
        start = max(text.find(f"({self.name} "), text.find(f"({self.name})"))
        if start < 0:
            return f"for example `{text}`" if text else f"signature: {self.usage}"
        return f"for example `{text[slice(*piece_at(text, start))]}`"


_MAX_KEPT = 16  # arguments of a call whose checked parameters are kept
_MAX_CALL = 80  # characters of a call in a hint


def call_hint(owner: str, usage: str) -> str:
    """Return the hint how a function of the program, or of a module in the language, is called.

    Parameters
    ----------
    owner
        The function as messages name it: a name in backquotes, a word in quotes, or anything else for a function
        without a name.
    usage
        Its parameter list, which begins with its name if it has one.
    """
    forms = read(Source("<usage>", usage)).forms
    if len(forms) != 1 or not isinstance(forms[0], ListDatum):
        return f"parameters: {usage}"
    items = [*forms[0].items, *([forms[0].tail] if forms[0].tail is not None else [])]
    if owner.startswith('"'):
        written = ["call", owner]
    elif items and owner == f"`{items[0].span.text}`":
        written = [items.pop(0).span.text]
    else:
        names = [_argument(item).split()[0] for item in items]
        listed = ", ".join(f"`{name}`" for name in names)
        verb = "parameters are" if len(names) > 1 else "parameter is"
        return f"its {verb} {listed}" if names else "it takes no arguments"
    for number, item in enumerate(items):
        text = _argument(item)
        is_last = number + 1 == len(items)
        if sum(map(len, written)) + len(written) + len(text) > _MAX_CALL - (1 if is_last else len(" ...")):
            written.append("...")
            break
        written.append(text)
    if forms[0].tail is not None and written[-1] != "...":
        written.append("...")
    return f"call it as `({' '.join(written)})`"


def default_hint(owner: str, usage: str) -> str | None:
    """Return the hint of ``call_hint`` if it has defaults, which show the types of arguments; else None.

    Names alone say nothing about an argument of the wrong type.
    """
    hint = call_hint(owner, usage)
    return hint if re.search(r" :\S+ (?!\.\.\.)", hint) else None


def _argument(parameter: Datum) -> str:
    """Return an argument for a parameter: its name, or a keyword with its default."""
    default = "..."
    if isinstance(parameter, ListDatum) and parameter.items:
        default = " ".join(item.span.text for item in parameter.items[1:]) or default
        parameter = parameter.items[0]
    name = parameter.span.text.partition("::")[0]
    return f"{name} {default}" if name.startswith(":") else name


_DEFINED = lazy_pattern(r"^\(define \(?([^\s()]+)", re.M)


@dataclass(frozen=True, eq=False)
class Library:
    """Standard library.

    Attributes
    ----------
    builtins, constants
        Predefined builtins and constants, by name.
    modules
        Source text of the modules written in the language, by name.
    prelude
        Names of the modules whose definitions are predefined.
    constant_docs
        Documentation of the constants.
    imported
        Builtins that must be imported, by module.
    """

    builtins: Mapping[str, Builtin]
    constants: Mapping[str, Any]
    modules: Mapping[str, str]
    prelude: tuple[str, ...]
    constant_docs: Mapping[str, str]
    imported: Mapping[str, Mapping[str, Builtin]] = field(default_factory=dict)

    @cached_property
    def prelude_names(self) -> dict[str, Span]:
        """Definitions of the prelude by name: each from its parenthesis at the start of a line to the next one."""
        places: dict[str, Span] = {}
        for module in self.prelude:
            source = Source(f"{STD}{module}", self.modules[module])
            definitions = [*_DEFINED.finditer(source.text)]
            ends = [*(match.start() for match in definitions[1:]), len(source.text)]
            places |= {match[1]: Span(source, match.start(), end) for match, end in zip(definitions, ends)}
        return places

    @cached_property
    def names(self) -> frozenset[str]:
        """All names of the library, with those that must be imported."""
        imported = {name for names in self.imported.values() for name in names}
        return frozenset(self.builtins.keys() | self.constants.keys() | self.prelude_names.keys() | imported)

    def module_of(self, name: str) -> str | None:
        """Return the module from which the builtin ``name`` must be imported, or None."""
        return next((module for module, builtins in self.imported.items() if name in builtins), None)


class Registry:
    """Registry of the builtins of one topic, filled by the decorator ``@registry.define(...)``."""

    def __init__(self, topic: str) -> None:
        self.topic = topic
        self.entries: dict[str, Builtin] = {}

    def define(
        self,
        name: str,
        parameters: str,
        result: str,
        doc: str,
        example: tuple[str, str] | None = None,
        intrinsic: str | None = None,
        check: Callable[..., object] | None = None,
        picture: str | None = None,
    ) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
        """Register the decorated function as a builtin.

        Parameters
        ----------
        name, parameters, result
            Name, signature such as ``"x::Number [:key::Function]"``, and type of the result.
        doc, example
            Documentation, and an expression with its printed value; the tests run it.
        intrinsic, check, picture
            As in ``Builtin``: the fast path of the compiler, a check of literal arguments, and an expression to render.

        Raises
        ------
        ValueError
            If a builtin of this name is registered already.
        """

        def register(function: Callable[..., Any]) -> Callable[..., Any]:
            """Add the entry, and return the function unchanged, so that other builtins can call it."""
            if name in self.entries:
                raise ValueError(f"{name} is registered twice")
            entry = Builtin(
                name,
                parameters,
                result,
                function,
                doc,
                example,
                self.topic,
                intrinsic=intrinsic,
                check=check,
                picture=picture,
            )
            self.entries[name] = entry
            return function

        return register

"""Callable values and argument binding: closures, escape procedures, builtins, records and iteration."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from itertools import islice
from typing import TYPE_CHECKING, Any, TypeAlias

from scenelang.grammar.datum import dataclass, field
from scenelang.grammar.diagnostics import LimitError, SceneError, suggest
from scenelang.interpreter.runtime.show import described, from_numpy, show
from scenelang.interpreter.runtime.types import (
    Builtin,
    BuiltinParameter,
    Mismatch,
    Type,
    call_hint,
    default_hint,
    expected_name,
    type_name,
)
from scenelang.interpreter.scene import pose
from scenelang.interpreter.scene.primitives.base import PHYSICS
from scenelang.interpreter.values.values import (
    NIL,
    Array,
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
    Table,
    Vector,
    make_list,
)
from scenelang.interpreter.values.values import Condition as Condition

if TYPE_CHECKING:
    from scenelang.interpreter.runtime.runtime import Runtime


Frame: TypeAlias = list[Any]  # [frame of the enclosing function, slot 1, slot 2, ...]
Node: TypeAlias = Callable[[Frame], Any]  # a compiled expression


class Tail:
    """Marker returned by a compiled expression to request that its caller perform a tail call."""

    __slots__ = ()


TAIL = Tail()
_MIN_CHARGED_ARGUMENTS = 32  # the step of the call pays for shorter lists


class Undefined:
    """Value of a variable before its definition is evaluated."""

    __slots__ = ()


UNDEFINED = Undefined()


class Cell(Mutable):
    """Storage of a variable that is assigned by ``set!``."""

    __slots__ = ("value",)

    def __init__(self, value: Any, birth: int) -> None:
        self.birth = birth
        self.observed = False
        self.value = value


@dataclass(frozen=True, slots=True)
class CodeParameter:
    """Parameter of compiled code.

    Attributes
    ----------
    name, kind
        Name, and one of required, optional, keyword, rest and keys.
    slot, in_cell
        Slot in the frame, and whether it contains a ``Cell`` with the value.
    type
        Type that arguments must have, if one is declared.
    default
        Compiled default of an optional or keyword parameter.
    """

    name: str
    kind: str
    slot: int
    type: Type | None = None
    default: Node | None = None
    in_cell: bool = False


class Exposure:
    """Whether others than calls of its word call a function, so that it must return lists of parts and no columns."""

    __slots__ = ("is_exposed",)

    def __init__(self) -> None:
        self.is_exposed = False


@dataclass(eq=False, slots=True)
class ClosureCode:
    """Compiled ``lambda``.

    Attributes
    ----------
    name, usage
        Name and parameter list, for messages.
    parameters
        Parameters in order.
    arity
        Number of parameters if all are plain, else -1.
    body, entry
        ``body`` takes a frame; ``entry`` takes the frame of the enclosing function and the values of plain parameters.
        Both are replaced when the code becomes hot (see ``compile``), so they are read at every call.
    direct
        Generated function, once the code is hot.
    returns_tail
        Whether ``direct`` may request a tail call.
    keyword_names
        Names of the keyword parameters; None if it takes no keywords.
    takes_any_keyword
        Whether a parameter collects further keyword arguments.
    exposure
        Shared with the other codes of the same function, which is compiled again with the code around it.
    required, positional
        Number of required parameters, and of required and optional ones.
    rest
        Parameter for the remaining arguments, if any.
    """

    name: str
    parameters: tuple[CodeParameter, ...]
    usage: str
    arity: int
    body: Node
    exposure: Exposure
    entry: Callable[..., Any] = field(init=False)
    direct: Callable[..., Any] | None = field(init=False, default=None)
    returns_tail: bool = field(init=False, default=True)
    keyword_names: frozenset[str] | None = field(init=False)
    takes_any_keyword: bool = field(init=False)
    required: int = field(init=False)
    positional: int = field(init=False)
    rest: CodeParameter | None = field(init=False)

    def __post_init__(self) -> None:
        """Derive the arity and the names that argument binding looks up at every call."""
        kinds = [p.kind for p in self.parameters]
        names = frozenset(p.name for p in self.parameters if p.kind == "keyword")
        self.keyword_names = names if names or "keys" in kinds else None
        self.takes_any_keyword = "keys" in kinds
        self.required = kinds.count("required")
        self.positional = self.required + kinds.count("optional")
        self.rest = next((p for p in self.parameters if p.kind == "rest"), None)
        self.entry = lambda env, *values: self.body([env, *values])


class Closure(Procedure):
    """Function value. ``arity`` is copied from ``code`` for faster access.

    ``traced`` replaces the body while the REPL traces calls; ``arity`` is then -1, so that all calls see it.
    """

    __slots__ = ("arity", "code", "env", "traced")

    def __init__(self, code: ClosureCode, env: Frame) -> None:
        self.code = code
        self.env = env
        self.arity = code.arity
        self.traced: Node | None = None

    @property
    def body(self) -> Node:
        """Code to run on the frame of a call."""
        return self.traced or self.code.body

    @property
    def name(self) -> str:  # type: ignore[override]
        """Name of the function in the program."""
        return self.code.name


class Escape(Procedure):
    """Escape procedure bound by ``let/ec``."""

    __slots__ = ("active", "name")

    def __init__(self, name: str) -> None:
        self.name = name
        self.active = True


class EscapeSignal(Exception):
    """Exception that unwinds the stack to the ``let/ec`` that created ``escape``."""

    def __init__(self, escape: Escape, value: Any) -> None:
        super().__init__()
        self.escape = escape
        self.value = value


def arity_error(code: ClosureCode, count: int) -> SceneError:
    """Return the error for a call of a function with ``count`` positional arguments, which it does not accept."""
    required, positional = code.required, code.positional
    if code.rest is not None:
        expected = f"at least {required}"
    elif required == positional:
        expected = str(required)
    else:
        expected = f"{required} to {positional}"
    plural = "" if expected.split()[-1] == "1" else "s"
    message = f"`{code.name}` expects {expected} argument{plural}, got {count}"
    return SceneError("arity", message, hint=call_hint(f"`{code.name}`", code.usage))


def split_keywords(name: str, usage: str, arguments: Sequence[Any]) -> tuple[list[Any], dict[str, Any]]:
    """Split the arguments of a call into positional arguments and keyword arguments by name."""
    positional: list[Any] = []
    keywords: dict[str, Any] = {}
    pending = iter(arguments)
    for argument in pending:
        if type(argument) is not Keyword:
            positional.append(argument)
            continue
        key = str(argument)
        if key in keywords:
            raise SceneError("keyword", f"duplicate argument `:{key}` of `{name}`", hint="leave out one of them")
        try:
            keywords[key] = next(pending)
        except StopIteration:
            raise SceneError("keyword", f"missing value after `:{key}` in a call of `{name}`") from None
    return positional, keywords


def bind_arguments(runtime: Runtime, closure: Closure, arguments: Sequence[Any]) -> Frame:
    """Return the frame of a call of ``closure``.

    Keywords are treated as keyword arguments if the closure has keyword parameters, otherwise as plain values.
    """
    code = closure.code
    if len(arguments) > _MIN_CHARGED_ARGUMENTS:
        runtime.charge(len(arguments) >> 2)
    if code.keyword_names is None:
        return _fill(runtime, closure, arguments, {})
    positional, keywords = split_keywords(code.name, code.usage, arguments)
    check_keywords(code, keywords)
    return _fill(runtime, closure, positional, keywords)


_PHYSICS_NAMES = frozenset(attribute.name for attribute in PHYSICS)


def check_keywords(code: ClosureCode, names: Collection[str], word: str | None = None) -> None:
    """Raise SceneError for the first of the keywords ``names`` that a function does not accept.

    ``word`` is the word that the function is bound to, None for other functions; every word accepts attributes of
    physics.
    """
    accepted = code.keyword_names
    if accepted is None or code.takes_any_keyword or accepted.issuperset(names):
        return
    for name in names:
        if name not in accepted and not (word is not None and name in _PHYSICS_NAMES):
            target = f'"{word}"' if word is not None else f"`{code.name}`"
            hint = suggest(name, accepted) or call_hint(target, code.usage)
            raise SceneError("keyword", f"{target} has no parameter `:{name}`", hint=hint)


def bind_entity(runtime: Runtime, closure: Closure, word: str, z: Embedding, rest: Any) -> Frame:
    """Return the frame of a call of an entity function (docs/language.md, "Entities and embeddings").

    Parameters
    ----------
    closure
        Entity function.
    word
        Word that it is bound to, for error messages.
    z
        Embedding of the entity: the first positional argument; its attributes are passed by keyword.
    rest
        List of the embeddings of its descendants (gamma): the second positional argument.

    Raises
    ------
    SceneError
        "arity" if the function requires more arguments, and the errors of its keywords.
    """
    code = closure.code
    if code.required > 2:
        message = f'the function of "{word}" has {code.required} required parameters, but `call` passes at most two'
        hint = f"`call` passes an embedding and the list of its descendants' embeddings; parameters: {code.usage}"
        raise SceneError("arity", message, hint=hint)
    positional = [*(z, rest)][: code.required]
    tail: Any = NIL
    if code.rest is not None:
        tail = (Pair(z, rest), rest, NIL)[code.required]
    return _fill(runtime, closure, positional, z.attributes, tail, word)


def _fill(
    runtime: Runtime,
    closure: Closure,
    positional: Sequence[Any],
    keywords: Mapping[str, Any],
    entity_rest: Any = None,
    word: str | None = None,
) -> Frame:
    """Return the frame of a call with its parameters filled, defaults evaluated and types checked.

    ``word`` is set for a call of an entity function, whose rest parameter gets ``entity_rest``, and which may have more
    positional parameters than there are arguments. Defaults see the parameters before them, so the order matters.
    """
    code = closure.code
    count = len(positional)
    if word is None and (count < code.required or (count > code.positional and code.rest is None)):
        raise arity_error(code, count)
    frame: Frame = [closure.env, *([None] * len(code.parameters))]
    index = 0
    for parameter in code.parameters:
        kind = parameter.kind
        if kind == "required" or (kind == "optional" and index < count):
            value = _checked(runtime, code, parameter, positional[index], word)
            index += 1
        elif kind == "keyword" and parameter.name in keywords:
            value = _checked(runtime, code, parameter, keywords[parameter.name], word)
        elif kind == "rest":
            value = entity_rest if word is not None else make_list(positional[code.positional :])
            value = _checked(runtime, code, parameter, value, word)
        elif kind == "keys":
            known = code.keyword_names or frozenset()
            extra = {name: value for name, value in keywords.items() if name not in known}
            value = runtime.table_of({name: (name, value) for name, value in extra.items()})
        elif parameter.default is not None:
            value = _checked(runtime, code, parameter, parameter.default(frame), word)
        else:
            owner = f'"{word}"' if word is not None else f"`{code.name}`"
            noun = "attribute" if word is not None else "argument"
            message = f"missing {noun} `:{parameter.name}` of {owner}"
            raise SceneError("keyword", message, hint=call_hint(owner, code.usage))
        frame[parameter.slot] = Cell(value, runtime.clock) if parameter.in_cell else value
    return frame


def _checked(runtime: Runtime, code: ClosureCode, parameter: CodeParameter, value: Any, word: str | None) -> Any:
    """Return a value converted to the type of its parameter; raise ``SceneError`` if it has another type."""
    if parameter.type is None:
        return value
    try:
        return parameter.type.checker(runtime)(value)
    except Mismatch:
        owner = f'"{word}"' if word is not None else f"`{code.name}`"
        sign = ":" if parameter.kind == "keyword" else ""
        message = (
            f"the parameter `{sign}{parameter.name}` of {owner} expects {expected_name(parameter.type.name)}, "
            f"got {described(value, 60)}"
        )
        raise SceneError("type", message, hint=default_hint(owner, code.usage)) from None


# Calls of builtins and record procedures with evaluated arguments: checks of arity, keywords and types.


def builtin_arity_error(builtin: Builtin, count: int) -> SceneError:
    """Return the error for a call of a builtin with ``count`` positional arguments, which it does not accept."""
    signature = builtin.signature
    required = len(signature.required)
    maximum = required + len(signature.optional)
    if signature.rest is not None:
        expected = f"at least {required}"
    else:
        expected = str(required) if required == maximum else f"{required} to {maximum}"
    plural = "" if expected.split()[-1] == "1" else "s"
    message = f"`{builtin.name}` expects {expected} argument{plural}, got {count}"
    return SceneError("arity", message, hint=builtin.call_hint)


def type_error(builtin: Builtin, parameter: BuiltinParameter, value: Any) -> SceneError:
    """Return the error for an argument of a builtin with the wrong type."""
    message = (
        f"`{builtin.name}` expects {expected_name(parameter.type.name)} for `{parameter.name}`, "
        f"got {described(value, 60)}"
    )
    required = [each.name for each in builtin.signature.required]
    if required[:1] == ["profile"] and parameter.name in required[1:] and not isinstance(value, (int, float)):
        return SceneError("type", message, hint=f"the profile comes first: `({builtin.name} {' '.join(required)})`")
    return SceneError("type", message, hint=builtin.call_hint)


def convert(runtime: Runtime, builtin: Builtin, parameter: BuiltinParameter, value: Any) -> Any:
    """Convert the argument ``value`` of a builtin to the type of its parameter.

    Raises SceneError("type") if it does not fit.
    """
    try:
        return parameter.type.converted(runtime, value)
    except Mismatch:
        raise type_error(builtin, parameter, value) from None


def call_builtin(runtime: Runtime, builtin: Builtin, arguments: Sequence[Any]) -> Any:
    """Call a builtin with arbitrary arguments; arithmetic errors of Python are converted to diagnostics."""
    signature = builtin.signature
    if len(arguments) > _MIN_CHARGED_ARGUMENTS:
        runtime.charge(len(arguments) >> 1)
    keywords: dict[str, Any] = {}
    if signature.keywords:
        positional, named = split_keywords(builtin.name, builtin.usage, arguments)
        keywords = _keywords(runtime, builtin, named)
    else:
        positional = list(arguments)
    _convert_positionals(runtime, builtin, positional)
    try:
        return builtin.function(runtime, *positional, **keywords)
    except (ArithmeticError, MemoryError) as error:
        raise python_error(builtin.name, error) from None


def _convert_positionals(runtime: Runtime, builtin: Builtin, positional: list[Any]) -> None:
    """Convert the positional arguments of a builtin in place; raise ``SceneError`` for a wrong number or type."""
    checked = builtin.checked(len(positional))
    if checked is None:
        raise builtin_arity_error(builtin, len(positional))
    for index, parameter in checked:
        positional[index] = convert(runtime, builtin, parameter, positional[index])


def _keywords(runtime: Runtime, builtin: Builtin, named: dict[str, Any]) -> dict[str, Any]:
    """Return keyword arguments of a builtin under their Python names, converted to the types of the parameters."""
    parameters = {parameter.name: parameter for parameter in builtin.signature.keywords}
    out: dict[str, Any] = {}
    for name, value in named.items():
        if name not in parameters:
            hint = suggest(name, parameters) or builtin.call_hint
            raise SceneError("keyword", f"`{builtin.name}` has no parameter `:{name}`", hint=hint)
        out[name.replace("-", "_")] = convert(runtime, builtin, parameters[name], value)
    return out


def python_error(name: str, error: Exception) -> SceneError:
    """Convert a Python arithmetic or memory error to a diagnostic."""
    if isinstance(error, ZeroDivisionError):
        return SceneError("zero-division", f"division by zero in `{name}`")
    if isinstance(error, MemoryError):
        return LimitError("memory", f"`{name}` ran out of memory")
    return SceneError("domain", f"numeric overflow in `{name}`")


class RecordProcedure(Procedure):
    """Constructor, predicate, accessor or modifier created by ``define-record``."""

    __slots__ = ("call", "name")

    def __init__(self, name: str, call: Any) -> None:
        self.name = name
        self.call = call


# Iteration over sequences.


_BLOCK_ITEMS = 1024  # items between two charges


def iterate(rt: Runtime, value: Any) -> Iterable[Any]:
    """Return an iterable over a sequence as in a ``for`` clause; an integer n iterates over 0 to n - 1."""
    kind = type(value)
    if kind is Pair:
        return _list_iterator(value)
    if value is NIL:
        return ()
    if kind is Vector or kind is str:
        return value  # type: ignore[no-any-return]
    if kind is int:
        return range(value)
    if kind is MutableList:
        rt.read(value)
        return value.items  # type: ignore[no-any-return]
    if kind is Table:
        rt.read(value)
        rt.charge(len(value.entries) >> 4)
        return _iterate_unmodified(value, [key for key, _ in value.entries.values()])
    if kind is Set:
        rt.read(value)
        rt.charge(len(value.entries) >> 4)
        members = list(value.entries.values())
        warn_set_order(rt, members)
        return _iterate_unmodified(value, members)
    return rows(rt, value)


def warn_set_order(rt: Runtime, members: list[Any]) -> None:
    """Warn that the iteration order of a set of strings differs from Python's."""
    if len(members) > 1 and any(type(member) is str for member in members):
        rt.warn("set-order", "a set of strings is iterated in insertion order, unlike in Python")


def rows(rt: Runtime, value: Any) -> list[Any]:
    """Return the rows of an array of two or more dimensions; raise ``SceneError`` for other values."""
    if type(value) is Matrix:
        return [Vector(row) for row in pose.to_array(value).tolist()]
    if isinstance(value, (Array, MutableArray)):
        if isinstance(value, MutableArray):
            rt.read(value)
        return array_rows(rt, value.data)
    if type(value) is HandleList:
        raise SceneError(
            "endless",
            "the root's list of handles is infinite",
            "to use the first n handles, write `(list-head gamma n)`",
        )
    raise SceneError("type", f"expected a sequence, got {described(value, 60)}")


def array_rows(rt: Runtime, data: Any) -> list[Any]:
    """Return the items of a numpy array along its first axis, as values of the language."""
    if data.ndim == 1:
        rt.charge(data.size >> 6)
        numbers: list[Any] = data.tolist()
        return numbers
    out: list[Any] = []
    for start in range(0, len(data), _BLOCK_ITEMS):
        block = data[start : start + _BLOCK_ITEMS]
        rt.charge((len(block) >> 2) + (block.size >> 5) + 1)
        out += [Vector(row) for row in block.tolist()] if data.ndim == 2 else map(from_numpy, block)
    return out


def _list_iterator(value: Any) -> Iterator[Any]:
    """Iterate over a list; raise ``SceneError`` at the end of an improper one."""
    while type(value) is Pair:
        yield value.car
        value = value.cdr
    if value is not NIL:
        raise SceneError("type", "expected a list, got an improper list")


def _iterate_unmodified(collection: Any, members: list[Any]) -> Iterator[Any]:
    """Iterate over ``members`` of a table or set; raise ``SceneError`` if its size changes, as Python does."""
    size = len(collection.entries)

    def check_size() -> None:
        """Raise if an item was added or removed since the iteration began."""
        if len(collection.entries) != size:
            raise SceneError("changed", "a table or set was modified during iteration", "iterate over a copy")

    for member in members:
        check_size()
        yield member
    if members:  # the last turn, too
        check_size()


def items_of(rt: Runtime, value: Any) -> list[Any]:
    """Return the items of a sequence as a new Python list, for destructuring and builtins."""
    if type(value) is int:
        raise SceneError("type", f"expected a sequence, got an Integer: {show(value, 60)}")
    out: list[Any] = []
    pending = iter(iterate(rt, value))
    while block := list(islice(pending, _BLOCK_ITEMS)):
        out += block
        if len(block) == _BLOCK_ITEMS:
            rt.charge(_BLOCK_ITEMS >> 4)
    return out


# ``define-record``: constructor, predicate, accessors and modifiers, created at run time from the field names.


def record_procedure_names(name: str, fields: Sequence[str]) -> list[str]:
    """Return the names defined by ``define-record``, in the order of the values returned by ``make_record``."""
    accessors = [f"{name}-{field}" for field in fields]
    return [name, f"{name}?", *accessors, *(f"set-{accessor}!" for accessor in accessors)]


def make_record(rt: Runtime, definition: Any, *defaults: Any) -> Any:
    """Create the procedures of a record type and return them as a list.

    ``definition`` are the name of the type, the names of its fields and their types (or None).
    """
    name, fields, types = definition
    kind = RecordType(name, fields)
    procedures = [
        RecordProcedure(name, _constructor(kind, types, defaults)),
        RecordProcedure(f"{name}?", _predicate(kind)),
        *(RecordProcedure(f"{name}-{field}", _accessor(kind, i)) for i, field in enumerate(fields)),
        *(RecordProcedure(f"set-{name}-{field}!", _modifier(kind, i, types[i])) for i, field in enumerate(fields)),
    ]
    return make_list(procedures)


def _converted(rt: Runtime, kind: RecordType, index: int, types: Sequence[Type | None], value: Any) -> Any:
    """Return a value converted to the type of a field; raise ``SceneError`` if it has another type."""
    expected = types[index]
    if expected is None:
        return value
    try:
        return expected.checker(rt)(value)
    except Mismatch:
        field = kind.fields[index]
        message = f"the field `{field}` of `{kind.name}` expects {expected_name(expected.name)}, got {type_name(value)}"
        raise SceneError("type", f"{message}: {show(value, 60)}") from None


def _constructor(kind: RecordType, types: Sequence[Type | None], defaults: Sequence[Any]) -> Any:
    """Return the constructor of a record type; a default is a function of the fields before it, or False."""
    usage = "(" + " ".join((kind.name, *kind.fields)) + ")"
    is_untyped = all(expected is None for expected in types)

    def construct(rt: Runtime, arguments: Sequence[Any]) -> Record:
        """Create a record from positional and keyword arguments."""
        if is_untyped and len(arguments) == len(kind.fields) and Keyword not in map(type, arguments):
            return Record(kind, list(arguments), rt.clock)
        positional, keywords = split_keywords(kind.name, usage, arguments)
        if len(positional) > len(kind.fields):
            message = f"`{kind.name}` has {len(kind.fields)} fields, got {len(positional)} arguments"
            raise SceneError("arity", message, hint=f"usage: {usage}")
        values: list[Any] = []
        for index, name in enumerate(kind.fields):
            if index < len(positional):
                value = positional[index]
            elif name in keywords:
                value = keywords.pop(name)
            elif defaults[index] is not False:
                value = rt.apply(defaults[index], values)
            else:
                raise SceneError("keyword", f"missing field `{name}` of `{kind.name}`", hint=f"usage: {usage}")
            values.append(_converted(rt, kind, index, types, value))
        for name in keywords:
            raise SceneError("keyword", f"unknown or duplicate field `{name}` of `{kind.name}`", hint=f"usage: {usage}")
        return Record(kind, values, rt.clock)

    return construct


def _record_argument(kind: RecordType, name: str, arguments: Sequence[Any], count: int) -> Record:
    """Return the record that is the first of ``count`` arguments; raise ``SceneError`` for anything else."""
    if len(arguments) != count:
        raise SceneError("arity", f"`{name}` expects {count} argument{'s' * (count > 1)}, got {len(arguments)}")
    record = arguments[0]
    if type(record) is not Record or record.type is not kind:
        message = f"`{name}` expects a {kind.name}, got {described(record, 60)}"
        is_older = type(record) is Record and record.type.name == kind.name
        hint = "the record type was redefined; this value belongs to the old definition" if is_older else None
        raise SceneError("type", message, hint)
    return record


def _predicate(kind: RecordType) -> Any:
    """Return the predicate of a record type."""

    def test(rt: Runtime, arguments: Sequence[Any]) -> bool:
        """Return whether the argument is a record of the type."""
        if len(arguments) != 1:
            raise SceneError("arity", f"`{kind.name}?` expects 1 argument, got {len(arguments)}")
        return type(arguments[0]) is Record and arguments[0].type is kind

    return test


def _accessor(kind: RecordType, index: int) -> Any:
    """Return the accessor of a field."""
    name = f"{kind.name}-{kind.fields[index]}"

    def access(rt: Runtime, arguments: Sequence[Any]) -> Any:
        """Return the value of the field."""
        if len(arguments) != 1 or type(record := arguments[0]) is not Record or record.type is not kind:
            record = _record_argument(kind, name, arguments, 1)
        if record.birth < rt.serial:
            rt.read(record)
        return record.values[index]

    return access


def _modifier(kind: RecordType, index: int, expected: Type | None) -> Any:
    """Return the modifier of a field."""
    name = f"set-{kind.name}-{kind.fields[index]}!"

    def modify(rt: Runtime, arguments: Sequence[Any]) -> None:
        """Set the field to the second argument."""
        record = _record_argument(kind, name, arguments, 2)
        value = _converted(rt, kind, index, {index: expected}, arguments[1])  # type: ignore[arg-type]
        rt.write(record)
        record.values[index] = value

    return modify


MAKE_RECORD = Builtin(
    "define-record", "definition defaults ...", "List", make_record, "Expansion of `define-record`.", None, "records"
)

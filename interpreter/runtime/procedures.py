"""Procedures at run time: closures, escapes, and how arguments meet parameters."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import islice
from typing import TYPE_CHECKING, Any, TypeAlias

from scenelang.grammar.diagnostics import LimitError, SceneError, suggest
from scenelang.interpreter.runtime.show import from_numpy, show
from scenelang.interpreter.runtime.types import Builtin, BuiltinParameter, Mismatch, Type, type_name
from scenelang.interpreter.runtime.values import (
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
from scenelang.interpreter.runtime.values import Condition as Condition
from scenelang.interpreter.scene import pose

if TYPE_CHECKING:
    from scenelang.interpreter.runtime.runtime import Runtime


# arguments: more of them are charged


Frame: TypeAlias = list[Any]  # [frame of the enclosing function, slot 1, slot 2, ...]
Node: TypeAlias = Callable[[Frame], Any]  # a compiled expression


class Tail:
    """The mark that a compiled expression returns to ask its caller to make a tail call."""

    __slots__ = ()


TAIL = Tail()
_FEW = 32  # arguments: more of them are charged


class Undefined:
    """What a variable holds before its definition has run."""

    __slots__ = ()


UNDEFINED = Undefined()


class Cell(Mutable):
    """A variable that some ``set!`` assigns."""

    __slots__ = ("value",)

    def __init__(self, value: Any, birth: int) -> None:
        self.birth = birth
        self.observed = False
        self.value = value


@dataclass(frozen=True, slots=True)
class CodeParameter:
    """A parameter of compiled code. ``kind``: required, optional, keyword, rest or keys."""

    name: str
    kind: str
    slot: int
    type: Type | None = None
    default: Node | None = None
    in_cell: bool = False


@dataclass(eq=False, slots=True)
class ClosureCode:
    """A compiled ``lambda``. ``arity`` is the number of parameters when all are plain, else -1."""

    name: str
    parameters: tuple[CodeParameter, ...]
    usage: str
    arity: int
    body: Node
    keyword_names: frozenset[str] | None = field(init=False)
    required: int = field(init=False)
    positional: int = field(init=False)
    rest: CodeParameter | None = field(init=False)

    def __post_init__(self) -> None:
        kinds = [p.kind for p in self.parameters]
        names = frozenset(p.name for p in self.parameters if p.kind == "keyword")
        self.keyword_names = names if names or "keys" in kinds else None
        self.required = kinds.count("required")
        self.positional = self.required + kinds.count("optional")
        self.rest = next((p for p in self.parameters if p.kind == "rest"), None)

    @property
    def takes_any_keyword(self) -> bool:
        return any(p.kind == "keys" for p in self.parameters)


class Closure(Procedure):
    """A function value. ``arity`` and ``body`` repeat the code's, to be near at hand."""

    __slots__ = ("arity", "body", "code", "env")

    def __init__(self, code: ClosureCode, env: Frame) -> None:
        self.code = code
        self.env = env
        self.arity = code.arity
        self.body = code.body

    @property
    def name(self) -> str:  # type: ignore[override]
        return self.code.name


class Escape(Procedure):
    """The procedure that ``let/ec`` binds."""

    __slots__ = ("active", "name")

    def __init__(self, name: str) -> None:
        self.name = name
        self.active = True


class EscapeSignal(Exception):
    """Unwinds to the ``let/ec`` that made ``escape``."""

    def __init__(self, escape: Escape, value: Any) -> None:
        super().__init__()
        self.escape = escape
        self.value = value


def arity_error(code: ClosureCode, given: int) -> SceneError:
    required, positional = code.required, code.positional
    if code.rest is not None:
        wanted = f"at least {required}"
    elif required == positional:
        wanted = str(required)
    else:
        wanted = f"{required} to {positional}"
    plural = "" if wanted.split()[-1] == "1" else "s"
    message = f"`{code.name}` wants {wanted} argument{plural}, got {given}"
    return SceneError("arity", message, hint=f"its parameters are {code.usage}")


def split_keywords(name: str, usage: str, arguments: Sequence[Any]) -> tuple[list[Any], dict[str, Any]]:
    """Positional arguments, and keyword arguments by name."""
    positional: list[Any] = []
    keywords: dict[str, Any] = {}
    pending = iter(arguments)
    for argument in pending:
        if type(argument) is not Keyword:
            positional.append(argument)
            continue
        key = str(argument)
        if key in keywords:
            raise SceneError("keyword", f"`:{key}` is given twice to `{name}`", hint=f"its parameters are {usage}")
        try:
            keywords[key] = next(pending)
        except StopIteration:
            raise SceneError("keyword", f"`:{key}` is followed by no value in a call of `{name}`") from None
    return positional, keywords


def bind_arguments(runtime: Runtime, closure: Closure, arguments: Sequence[Any]) -> Frame:
    """The frame for a call of ``closure``; the callee decides whether keywords are arguments or plain values."""
    code = closure.code
    if len(arguments) > _FEW:
        runtime.charge(len(arguments) >> 2)
    if code.keyword_names is None:
        return _fill(runtime, closure, arguments, {})
    positional, keywords = split_keywords(code.name, code.usage, arguments)
    check_keywords(code, keywords)
    return _fill(runtime, closure, positional, keywords)


def check_keywords(code: ClosureCode, names: Sequence[str] | Mapping[str, Any], word: str | None = None) -> None:
    """Refuse keywords that ``code`` does not know."""
    known = code.keyword_names
    if known is None or code.takes_any_keyword:
        return
    for name in names:
        if name not in known:
            target = f'"{word}"' if word is not None else f"`{code.name}`"
            hint = suggest(name, known) or f"its parameters are {code.usage}"
            raise SceneError("keyword", f"{target} has no parameter `:{name}`", hint=hint)


def bind_entity(runtime: Runtime, closure: Closure, word: str, z: Embedding, rest: Any) -> Frame:
    """The frame for an entity function: z, then gamma, and z's attributes by keyword (language.md, section 2)."""
    code = closure.code
    if code.required > 2:
        message = f'the function of "{word}" has {code.required} required parameters; `call` gives it at most two'
        hint = f"an embedding and the list of its descendants' embeddings; its parameters are {code.usage}"
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
    code = closure.code
    given = len(positional)
    if word is None and (given < code.required or (given > code.positional and code.rest is None)):
        raise arity_error(code, given)
    frame: Frame = [closure.env, *([None] * len(code.parameters))]
    index = 0
    for parameter in code.parameters:
        kind = parameter.kind
        if kind == "required" or (kind == "optional" and index < given):
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
            what = "attribute" if word is not None else "argument"
            message = f"{owner} needs the {what} `:{parameter.name}`"
            raise SceneError("keyword", message, hint=f"its parameters are {code.usage}")
        frame[parameter.slot] = Cell(value, runtime.clock) if parameter.in_cell else value
    return frame


def _checked(runtime: Runtime, code: ClosureCode, parameter: CodeParameter, value: Any, word: str | None) -> Any:
    if parameter.type is None:
        return value
    try:
        return parameter.type.checker(runtime)(value)
    except Mismatch:
        owner = f'"{word}"' if word is not None else f"`{code.name}`"
        sign = ":" if parameter.kind == "keyword" else ""
        message = (
            f"the parameter `{sign}{parameter.name}` of {owner} is of type {parameter.type.name}, "
            f"but got {type_name(value)}: {show(value, 60)}"
        )
        raise SceneError("type", message, hint=f"its parameters are {code.usage}") from None


# Calling builtins and record procedures with arguments that were evaluated: arity, keywords and types.


def builtin_arity_error(builtin: Builtin, given: int) -> SceneError:
    signature = builtin.signature
    required = len(signature.required)
    most = required + len(signature.optional)
    if signature.rest is not None:
        wanted = f"at least {required}"
    else:
        wanted = str(required) if required == most else f"{required} to {most}"
    plural = "" if wanted.split()[-1] == "1" else "s"
    message = f"`{builtin.name}` wants {wanted} argument{plural}, got {given}"
    return SceneError("arity", message, hint=f"its signature is {builtin.usage}")


def type_error(builtin: Builtin, parameter: BuiltinParameter, value: Any) -> SceneError:
    message = (
        f"`{builtin.name}` wants {_article(parameter.type.name)} for `{parameter.name}`, "
        f"got {type_name(value)}: {show(value, 60)}"
    )
    return SceneError("type", message, hint=f"its signature is {builtin.usage}")


def _article(name: str) -> str:
    if name == "Parts":
        return "an Entity, a pair or a list of these"
    return ("an " if name[0] in "AEIOU" else "a ") + name


def convert(runtime: Runtime, builtin: Builtin, parameter: BuiltinParameter, value: Any) -> Any:
    """``value`` as the parameter's type, or a diagnostic."""
    try:
        return parameter.type.checker(runtime)(value)
    except Mismatch:
        raise type_error(builtin, parameter, value) from None


def call_builtin(runtime: Runtime, builtin: Builtin, arguments: Sequence[Any]) -> Any:
    """Call a builtin with any arguments; Python's own arithmetic errors become diagnostics."""
    signature = builtin.signature
    if len(arguments) > _FEW:
        runtime.charge(len(arguments) >> 1)
    keywords: dict[str, Any] = {}
    if signature.keywords:
        positional, given = split_keywords(builtin.name, builtin.usage, arguments)
        keywords = _keywords(runtime, builtin, given)
    else:
        positional = list(arguments)
    _convert_positionals(runtime, builtin, positional)
    try:
        return builtin.function(runtime, *positional, **keywords)
    except (ArithmeticError, MemoryError) as error:
        raise python_error(builtin.name, error) from None


def _convert_positionals(runtime: Runtime, builtin: Builtin, positional: list[Any]) -> None:
    signature = builtin.signature
    parameters = (*signature.required, *signature.optional)
    if len(positional) < len(signature.required) or (len(positional) > len(parameters) and signature.rest is None):
        raise builtin_arity_error(builtin, len(positional))
    for index, parameter in enumerate(parameters[: len(positional)]):
        positional[index] = convert(runtime, builtin, parameter, positional[index])
    if signature.rest is not None:
        for index in range(len(parameters), len(positional)):
            positional[index] = convert(runtime, builtin, signature.rest, positional[index])


def _keywords(runtime: Runtime, builtin: Builtin, given: dict[str, Any]) -> dict[str, Any]:
    known = {parameter.name: parameter for parameter in builtin.signature.keywords}
    out: dict[str, Any] = {}
    for name, value in given.items():
        if name not in known:
            hint = suggest(name, known) or f"its signature is {builtin.usage}"
            raise SceneError("keyword", f"`{builtin.name}` has no parameter `:{name}`", hint=hint)
        out[name.replace("-", "_")] = convert(runtime, builtin, known[name], value)
    return out


def python_error(name: str, error: Exception) -> SceneError:
    """The diagnostic for an error of Python's arithmetic or allocation."""
    if isinstance(error, ZeroDivisionError):
        return SceneError("zero-division", f"division by zero in `{name}`")
    if isinstance(error, MemoryError):
        return LimitError("memory", f"`{name}` ran out of memory")
    return SceneError("domain", f"the result of `{name}` is too large for a number")


class RecordProcedure(Procedure):
    """A constructor, predicate, accessor or modifier that ``define-record`` made."""

    __slots__ = ("call", "name")

    def __init__(self, name: str, call: Any) -> None:
        self.name = name
        self.call = call


def call_record_procedure(runtime: Runtime, procedure: Procedure, arguments: Sequence[Any]) -> Any:
    """Call one of the procedures of ``define-record``."""
    assert isinstance(procedure, RecordProcedure)
    return procedure.call(runtime, arguments)


# Iterating and taking apart the language's sequences.


_BLOCK = 1024  # items between two checks


def iterate(rt: Runtime, value: Any) -> Iterable[Any]:
    """What a ``for`` clause runs through: the items of a sequence, or 0 .. n-1 for a whole number n."""
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
        return _unchanging(value, [key for key, _ in value.entries.values()])
    if kind is Set:
        rt.read(value)
        rt.charge(len(value.entries) >> 4)
        members = list(value.entries.values())
        warn_of_order(rt, members)
        return _unchanging(value, members)
    return rows(rt, value)


def warn_of_order(rt: Runtime, members: list[Any]) -> None:
    """Warn that the order of a set of strings is not Python's."""
    if len(members) > 1 and any(type(member) is str for member in members):
        rt.warn("set-order", "a set of strings is taken in the order of insertion, which Python does not keep")


def rows(rt: Runtime, value: Any) -> list[Any]:
    """The rows of an array of two or more dimensions."""
    if type(value) is Matrix:
        return [Vector(row) for row in pose.to_array(value).tolist()]
    if isinstance(value, (Array, MutableArray)):
        if isinstance(value, MutableArray):
            rt.read(value)
        return array_rows(rt, value.data)
    if type(value) is HandleList:
        raise SceneError("endless", "the root's list of handles has no end", "take some: `(list-head gamma n)`")
    raise SceneError("type", f"a sequence is wanted here, got {type_name(value)}: {show(value, 60)}")


def array_rows(rt: Runtime, data: Any) -> list[Any]:
    """The items of a numpy array along its first axis, as values."""
    if data.ndim == 1:
        rt.charge(data.size >> 6)
        numbers: list[Any] = data.tolist()
        return numbers
    out: list[Any] = []
    for start in range(0, len(data), _BLOCK):
        block = data[start : start + _BLOCK]
        rt.charge((len(block) >> 2) + (block.size >> 5) + 1)
        out += [Vector(row) for row in block.tolist()] if data.ndim == 2 else map(from_numpy, block)
    return out


def _list_iterator(value: Any) -> Iterator[Any]:
    while type(value) is Pair:
        yield value.car
        value = value.cdr
    if value is not NIL:
        raise SceneError("type", "a list is wanted here, got a pair whose tail is no list")


def _unchanging(collection: Any, members: list[Any]) -> Iterator[Any]:
    size = len(collection.entries)
    for member in members:
        if len(collection.entries) != size:
            raise SceneError("changed", "a table or set was changed while it was being iterated", "iterate a copy")
        yield member
    if members and len(collection.entries) != size:
        raise SceneError("changed", "a table or set was changed while it was being iterated", "iterate a copy")


def items_of(rt: Runtime, value: Any) -> list[Any]:
    """The items of a sequence as a new Python list, for patterns and builtins."""
    if type(value) is int:
        raise SceneError("type", f"a sequence is wanted here, got an Integer: {show(value, 60)}")
    out: list[Any] = []
    pending = iter(iterate(rt, value))
    while block := list(islice(pending, _BLOCK)):
        out += block
        if len(block) == _BLOCK:
            rt.charge(_BLOCK >> 4)
    return out


# ``define-record``: constructor, predicate, accessors and modifiers, made at run time from the field names.


def record_procedure_names(name: str, fields: Sequence[str]) -> list[str]:
    """The names that ``define-record`` defines, in the order in which ``make_record`` gives their values."""
    accessors = [f"{name}-{field}" for field in fields]
    return [name, f"{name}?", *accessors, *(f"set-{accessor}!" for accessor in accessors)]


def make_record(rt: Runtime, facts: Any, *defaults: Any) -> Any:
    """The procedures of a record type as a list. ``facts``: name, field names, field types or None."""
    name, fields, types = facts
    kind = RecordType(name, fields)
    procedures = [
        RecordProcedure(name, _constructor(kind, types, defaults)),
        RecordProcedure(f"{name}?", _predicate(kind)),
        *(RecordProcedure(f"{name}-{field}", _accessor(kind, i)) for i, field in enumerate(fields)),
        *(RecordProcedure(f"set-{name}-{field}!", _modifier(kind, i, types[i])) for i, field in enumerate(fields)),
    ]
    return make_list(procedures)


def _converted(rt: Runtime, kind: RecordType, index: int, types: Sequence[Type | None], value: Any) -> Any:
    wanted = types[index]
    if wanted is None:
        return value
    try:
        return wanted.checker(rt)(value)
    except Mismatch:
        field = kind.fields[index]
        message = f"the field `{field}` of `{kind.name}` is of type {wanted.name}, got {type_name(value)}"
        raise SceneError("type", f"{message}: {show(value, 60)}") from None


def _constructor(kind: RecordType, types: Sequence[Type | None], defaults: Sequence[Any]) -> Any:
    usage = "(" + " ".join((kind.name, *kind.fields)) + ")"

    def construct(rt: Runtime, arguments: Sequence[Any]) -> Record:
        positional, keywords = split_keywords(kind.name, usage, arguments)
        if len(positional) > len(kind.fields):
            message = f"`{kind.name}` has {len(kind.fields)} fields, got {len(positional)} arguments"
            raise SceneError("arity", message, hint=f"make one with {usage}")
        values: list[Any] = []
        for index, name in enumerate(kind.fields):
            if index < len(positional):
                value = positional[index]
            elif name in keywords:
                value = keywords.pop(name)
            elif defaults[index] is not False:
                value = rt.apply(defaults[index], values)
            else:
                raise SceneError("keyword", f"`{kind.name}` needs the name `{name}`", hint=f"make one with {usage}")
            values.append(_converted(rt, kind, index, types, value))
        for name in keywords:
            raise SceneError(
                "keyword", f"`{kind.name}` has no name `{name}` left to fill", hint=f"make one with {usage}"
            )
        return Record(kind, values, rt.clock)

    return construct


def _one(kind: RecordType, name: str, arguments: Sequence[Any], count: int) -> Record:
    if len(arguments) != count:
        raise SceneError("arity", f"`{name}` wants {count} argument{'s' * (count > 1)}, got {len(arguments)}")
    record = arguments[0]
    if type(record) is not Record or record.type is not kind:
        message = f"`{name}` wants a {kind.name}, got {type_name(record)}: {show(record, 60)}"
        is_older = type(record) is Record and record.type.name == kind.name
        hint = "the record was defined anew; this one is of the old definition" if is_older else None
        raise SceneError("type", message, hint)
    return record


def _predicate(kind: RecordType) -> Any:
    def test(rt: Runtime, arguments: Sequence[Any]) -> bool:
        if len(arguments) != 1:
            raise SceneError("arity", f"`{kind.name}?` wants 1 argument, got {len(arguments)}")
        return type(arguments[0]) is Record and arguments[0].type is kind

    return test


def _accessor(kind: RecordType, index: int) -> Any:
    name = f"{kind.name}-{kind.fields[index]}"

    def access(rt: Runtime, arguments: Sequence[Any]) -> Any:
        record = _one(kind, name, arguments, 1)
        rt.read(record)
        return record.values[index]

    return access


def _modifier(kind: RecordType, index: int, wanted: Type | None) -> Any:
    name = f"set-{kind.name}-{kind.fields[index]}!"

    def modify(rt: Runtime, arguments: Sequence[Any]) -> None:
        record = _one(kind, name, arguments, 2)
        value = _converted(rt, kind, index, {index: wanted}, arguments[1])  # type: ignore[arg-type]
        rt.write(record)
        record.values[index] = value

    return modify


MAKE_RECORD = Builtin(
    "define-record", "facts defaults ...", "List", make_record, "What `define-record` expands to.", None, "records"
)

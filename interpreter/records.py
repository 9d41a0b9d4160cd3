"""``define-record``: constructor, predicate, accessors and modifiers, made at run time from the field names."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.arguments import RecordProcedure
from scenelang.interpreter.library import Builtin
from scenelang.interpreter.procedures import split_keywords
from scenelang.interpreter.show import show
from scenelang.interpreter.types import Mismatch, Type, type_name
from scenelang.interpreter.values import Record, RecordType, make_list

if TYPE_CHECKING:
    from scenelang.interpreter.runtime import Runtime


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
        for index, field in enumerate(kind.fields):
            if index < len(positional):
                value = positional[index]
            elif field in keywords:
                value = keywords.pop(field)
            elif defaults[index] is not False:
                value = rt.apply(defaults[index], values)
            else:
                raise SceneError("keyword", f"`{kind.name}` needs the field `{field}`", hint=f"make one with {usage}")
            values.append(_converted(rt, kind, index, types, value))
        for name in keywords:
            raise SceneError(
                "keyword", f"`{kind.name}` has no field `{name}` left to fill", hint=f"make one with {usage}"
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

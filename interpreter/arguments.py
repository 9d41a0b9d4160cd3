"""Calling builtins and record procedures with arguments that were evaluated: arity, keywords and types."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from scenelang.grammar.diagnostics import LimitError, SceneError, suggest
from scenelang.interpreter.library import Builtin, Parameter
from scenelang.interpreter.procedures import split_keywords
from scenelang.interpreter.show import show
from scenelang.interpreter.types import Mismatch, type_name
from scenelang.interpreter.values import Procedure

if TYPE_CHECKING:
    from scenelang.interpreter.runtime import Runtime


_FEW = 32  # arguments: more of them are charged


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


def type_error(builtin: Builtin, parameter: Parameter, value: Any) -> SceneError:
    message = (
        f"`{builtin.name}` wants {_article(parameter.type.name)} for `{parameter.name}`, "
        f"got {type_name(value)}: {show(value, 60)}"
    )
    return SceneError("type", message, hint=f"its signature is {builtin.usage}")


def _article(name: str) -> str:
    if name == "Parts":
        return "an Entity, a pair or a list of these"
    return ("an " if name[0] in "AEIOU" else "a ") + name


def convert(runtime: Runtime, builtin: Builtin, parameter: Parameter, value: Any) -> Any:
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

"""Errors as data, printing, and other things that are done rather than computed."""

from __future__ import annotations

from typing import Any

from scenelang.grammar.datum import Symbol
from scenelang.grammar.diagnostics import CODES, SceneError, suggest
from scenelang.interpreter.runtime.procedures import Condition
from scenelang.interpreter.runtime.runtime import Runtime
from scenelang.interpreter.runtime.show import LONGEST, show
from scenelang.interpreter.runtime.types import Registry
from scenelang.stdlib.lists import wrong_type

registry = Registry("control")

_MOST_TEXTS = 100  # of an error's message and what it is about
_TOLD = ("user", "assert")  # errors that a program made itself: what their messages show was read then


@registry.define("error", "message::Any irritants::Any ...", "Any",
                 "Raises an error with a message, followed by the values that it is about.",
                 ('(guard (e (#t (error-message e))) (error "no such leg:" 5))', '"no such leg: 5"'))  # fmt: skip
def error(rt: Runtime, message: Any, *irritants: Any) -> Any:
    texts = [_message(rt, message)]
    for irritant in irritants:
        texts.append(rt.show(irritant, 200))
        if len(texts) > _MOST_TEXTS:
            texts.append("...")
            break
    raise SceneError("user", " ".join(texts))


def _message(rt: Runtime, value: Any) -> str:
    """The value that an error has for its message, as text that is not too long for one."""
    if type(value) is not str:
        return rt.show(value, 1000)
    return value if len(value) <= LONGEST else value[: LONGEST - 3] + "..."


@registry.define("raise", "value::Any", "Any",
                 "Raises any value, which `guard` gets; an error that was caught is raised again as it was.",
                 ("(guard (e (#t (+ e 1))) (raise 41))", "42"))  # fmt: skip
def raise_(rt: Runtime, value: Any) -> Any:
    if type(value) is Condition:
        raise value.error
    raise SceneError("user", f"the program raised {rt.show(value, 200)}", value=value)


@registry.define("gensym", "[prefix::String]", "Symbol",
                 "A symbol that no program writes and no other call gives, for the names that a macro makes.",
                 ("(eq? (gensym) (gensym))", "#f"))  # fmt: skip
def gensym(rt: Runtime, prefix: str = "g") -> Symbol:
    rt.charge(len(prefix) >> 8)
    rt.symbols_made += 1
    return Symbol(f"{prefix}|{rt.symbols_made}|")


@registry.define("assertion-failed", "message::Any", "Any", "Raises the error of `assert`, which calls this.",
                 ('(guard (e ((error-is? e "assert") (error-message e))) (assert (= 1 2) "no"))', '"no"'))  # fmt: skip
def assertion_failed(rt: Runtime, message: Any) -> Any:
    raise SceneError("assert", _message(rt, message))


@registry.define("error?", "value::Any", "Boolean", "True for an error that `guard` caught; false for a raised value.",
                 ("(guard (e (#t (error? e))) (car '()))", "#t"))  # fmt: skip
def is_error(rt: Runtime, value: Any) -> bool:
    return type(value) is Condition


@registry.define("error-message", "error::Any", "String", "The message of an error; of a raised value, its text.",
                 ("(guard (e (#t (error-message e))) (ref '(1 2) 5))",
                  '"index 5 is outside the list of length 2"'))  # fmt: skip
def error_message(rt: Runtime, caught: Any) -> str:
    if type(caught) is Condition:
        error: SceneError = caught.error
        if error.name not in _TOLD:
            rt.look_at_error()
        return error.message
    return rt.display(caught)


def _condition(name: str, value: Any) -> SceneError:
    if type(value) is not Condition:
        raise wrong_type(name, "an error that `guard` caught", value)
    found: SceneError = value.error
    return found


@registry.define("error-code", "error::Any", "String", "The stable code of an error, such as E405.",
                 ("(guard (e (#t (error-code e))) (ref '(1 2) 5))", '"E405"'))  # fmt: skip
def error_code(rt: Runtime, caught: Any) -> str:
    return CODES[_condition("error-code", caught).name].code


@registry.define("error-place", "error::Any", "Any",
                 "Where an error happened, a string `file:line:column`; none where that is not known.",
                 ("(guard (e (#t (string? (error-place e)))) (car '()))", "#t"))  # fmt: skip
def error_place(rt: Runtime, caught: Any) -> str | None:
    span = _condition("error-place", caught).span
    if span is None:
        return None
    line, column = span.source.position(span.start)
    return f"{span.source.name}:{line}:{column}"


@registry.define("error-is?", "error::Any name::String", "Boolean",
                 "True for an error of this name, such as \"index\", \"key\", \"type\" or \"user\".",
                 ("(guard (e ((error-is? e \"zero-division\") 0)) (/ 1 0))", "0"))  # fmt: skip
def error_is(rt: Runtime, caught: Any, name: str) -> bool:
    if name not in CODES:
        hint = suggest(name, CODES) or 'such as "index", "key", "type", "value" or "user"'
        raise SceneError("value", f"no error has the name {show(name, 40)}", hint=hint)
    if type(caught) is Condition:
        return bool(caught.error.name == name)
    return name == "user"


@registry.define("print", "values::Any ...", "Any",
                 "Writes the values into the log, with blanks between them; gives none.",
                 ('(print "legs:" 4)', "none"))  # fmt: skip
def print_(rt: Runtime, *values: Any) -> None:
    texts = [rt.display(value) for value in values]
    rt.meter.check_size(sum(map(len, texts)) + len(texts), "a string")
    rt.print(" ".join(texts))


@registry.define("void", "values::Any ...", "Any", "Gives none, whatever the arguments.", ("(void 1 2)", "none"))
def void(rt: Runtime, *values: Any) -> None:
    return None


@registry.define("identity", "value::Any", "Any", "Gives its argument.", ("(map identity '(1 2))", "(1 2)"))
def identity(rt: Runtime, value: Any) -> Any:
    return value

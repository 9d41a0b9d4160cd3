"""Builtins for higher-order functions, errors as values, and output."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenelang.grammar.datum import Symbol
from scenelang.grammar.diagnostics import CODES, SceneError, suggest
from scenelang.interpreter.runtime.declaring import declared
from scenelang.interpreter.runtime.procedures import Condition
from scenelang.interpreter.runtime.show import MAX_LENGTH, show
from scenelang.interpreter.runtime.types import Registry
from scenelang.interpreter.values.values import make_list
from scenelang.stdlib.operands import is_true, items, iterate, wrong_type

if TYPE_CHECKING:
    from scenelang.interpreter.runtime.runtime import Runtime

# Higher-order functions: map, filter, fold and related ones (R7RS, section 6.10; SRFI 1).
calling = Registry("sequences")

_NOTHING = object()


def map_items(rt: Runtime, name: str, f: Any, sequences: tuple[Any, ...]) -> list[Any]:
    """Return the results of the function ``f`` for the items of one sequence, or of several in parallel.

    ``name`` is the builtin that errors name. The shortest sequence ends the iteration.
    """
    if len(sequences) == 1:
        call = rt.call1
        return [call(f, item) for item in iterate(rt, sequences[0], name)]
    columns = [items(rt, xs, name) for xs in sequences]
    if len(columns) == 2:
        return [rt.call2(f, a, b) for a, b in zip(*columns)]
    return [rt.apply(f, row) for row in zip(*columns)]


@calling.define("map", "f::Function xs::Sequence more::Sequence ...", "List",
                 "Return the list of the results of `f` for every item. With several sequences, `f` is called with an "
                 "item of each, up to the length of the shortest.",
                 ("(list (map square '(1 2 3)) (map + '(1 2) [10 20]))", "((1 4 9) (11 22))"))  # fmt: skip
def map_(rt: Runtime, f: Any, xs: Any, *more: Any) -> Any:
    return make_list(map_items(rt, "map", f, (xs, *more)))


@calling.define("for-each", "f::Function xs::Sequence more::Sequence ...", "Any",
                 "Call `f` on every item, in order, for its effects; return none.",
                 ("(let ((out (mutable-list))) (for-each (lambda (x) (push! out (* x x))) '(1 2 3)) out)",
                  "(mutable-list 1 4 9)"))  # fmt: skip
def for_each(rt: Runtime, f: Any, xs: Any, *more: Any) -> None:
    if more:
        map_items(rt, "for-each", f, (xs, *more))
        return
    for item in iterate(rt, xs, "for-each"):
        rt.call1(f, item)


@calling.define("append-map", "f::Function xs::Sequence more::Sequence ...", "List",
                 "Concatenate the results of `f`, which are lists.",
                 ("(append-map (lambda (x) (list x x)) '(1 2))", "(1 1 2 2)"))  # fmt: skip
def append_map(rt: Runtime, f: Any, xs: Any, *more: Any) -> Any:
    out: list[Any] = []
    for result in map_items(rt, "append-map", f, (xs, *more)):
        if type(result) is str:
            raise wrong_type("append-map", "a function that returns lists", result)
        out.extend(items(rt, result, "append-map"))
        rt.meter.check_size(len(out), "a list")
    return make_list(out)


@calling.define("filter-map", "f::Function xs::Sequence more::Sequence ...", "List",
                 "Return the results of `f` that are neither #f nor none.",
                 ("(filter-map (lambda (x) (and (odd? x) (* x x))) '(1 2 3))", "(1 9)"))  # fmt: skip
def filter_map(rt: Runtime, f: Any, xs: Any, *more: Any) -> Any:
    return make_list([result for result in map_items(rt, "filter-map", f, (xs, *more)) if is_true(result)])


@calling.define("filter", "f::Function xs::Sequence", "List", "Return the items for which `f` is true.",
                 ("(filter odd? '(1 2 3))", "(1 3)"))  # fmt: skip
def filter_(rt: Runtime, f: Any, xs: Any) -> Any:
    return make_list([item for item in iterate(rt, xs, "filter") if is_true(rt.call1(f, item))])


@calling.define("remove", "f::Function xs::Sequence", "List", "Return the items for which `f` is false.",
                 ("(remove odd? '(1 2 3))", "(2)"))  # fmt: skip
def remove(rt: Runtime, f: Any, xs: Any) -> Any:
    return make_list([item for item in iterate(rt, xs, "remove") if not is_true(rt.call1(f, item))])


@calling.define("partition", "f::Function xs::Sequence", "List",
                 "Return the list of two lists: the items for which `f` is true, and the others.",
                 ("(partition odd? '(1 2 3))", "((1 3) (2))"))  # fmt: skip
def partition(rt: Runtime, f: Any, xs: Any) -> Any:
    accepted: list[Any] = []
    others: list[Any] = []
    for item in iterate(rt, xs, "partition"):
        (accepted if is_true(rt.call1(f, item)) else others).append(item)
    return make_list((make_list(accepted), make_list(others)))


@calling.define("find", "f::Function xs::Sequence", "Any", "Return the first item for which `f` is true, or #f.",
                 ("(find even? '(1 4 6))", "4"))  # fmt: skip
def find(rt: Runtime, f: Any, xs: Any) -> Any:
    for item in iterate(rt, xs, "find"):
        if is_true(rt.call1(f, item)):
            return item
    return False


@calling.define("list-index", "f::Function xs::Sequence", "Any",
                 "Return the index of the first item for which `f` is true, or #f. `index-of` searches for a value.",
                 ("(list-index even? '(1 4 6))", "1"))  # fmt: skip
def list_index(rt: Runtime, f: Any, xs: Any) -> Any:
    for index, item in enumerate(iterate(rt, xs, "list-index")):
        if is_true(rt.call1(f, item)):
            return index
    return False


def _rows(rt: Runtime, name: str, sequences: tuple[Any, ...]) -> Any:
    """Return the argument lists for calls along one or several sequences."""
    if len(sequences) == 1:
        return ((item,) for item in iterate(rt, sequences[0], name))
    return zip(*[items(rt, xs, name) for xs in sequences])


@calling.define("any", "f::Function xs::Sequence more::Sequence ...", "Any",
                 "Return the first true result of `f`, or #f; later items are not evaluated.",
                 ("(any even? '(1 2 3))", "#t"))  # fmt: skip
def any_(rt: Runtime, f: Any, xs: Any, *more: Any) -> Any:
    for row in _rows(rt, "any", (xs, *more)):
        result = rt.apply(f, row)
        if is_true(result):
            return result
    return False


@calling.define("every", "f::Function xs::Sequence more::Sequence ...", "Any",
                 "Return #f at the first item for which `f` is false, otherwise the last result (#t for no items).",
                 ("(every odd? '(1 3))", "#t"))  # fmt: skip
def every(rt: Runtime, f: Any, xs: Any, *more: Any) -> Any:
    result: Any = True
    for row in _rows(rt, "every", (xs, *more)):
        result = rt.apply(f, row)
        if not is_true(result):
            return False
    return result


# --- folds -----------------------------------------------------------------------------------------------------


@calling.define("fold", "f::Function start::Any xs::Sequence more::Sequence ...", "Any",
                 "Fold the items from the left: each accumulated value is `(f item value)`, the first one is `start`.",
                 ("(fold cons '() '(1 2 3))", "(3 2 1)"))  # fmt: skip
def fold(rt: Runtime, f: Any, start: Any, xs: Any, *more: Any) -> Any:
    value = start
    if not more:
        for item in iterate(rt, xs, "fold"):
            value = rt.call2(f, item, value)
        return value
    for row in _rows(rt, "fold", (xs, *more)):
        value = rt.apply(f, (*row, value))
    return value


@calling.define("fold-left", "f::Function start::Any xs::Sequence more::Sequence ...", "Any",
                 "Fold the items from the left: each accumulated value is `(f value item)`, the first one is `start`.",
                 ("(fold-left - 10 '(1 2 3))", "4"))  # fmt: skip
def fold_left(rt: Runtime, f: Any, start: Any, xs: Any, *more: Any) -> Any:
    value = start
    for row in _rows(rt, "fold-left", (xs, *more)):
        value = rt.apply(f, (value, *row))
    return value


@calling.define("fold-right", "f::Function start::Any xs::Sequence more::Sequence ...", "Any",
                 "Fold the items from the right: each accumulated value is `(f item value)`, the first one is `start`.",
                 ("(fold-right cons '() '(1 2 3))", "(1 2 3)"))  # fmt: skip
def fold_right(rt: Runtime, f: Any, start: Any, xs: Any, *more: Any) -> Any:
    value = start
    for row in reversed(list(_rows(rt, "fold-right", (xs, *more)))):
        value = rt.apply(f, (*row, value))
    return value


@calling.define("reduce", "f::Function start::Any [xs::Sequence]", "Any",
                 "The same as `fold`, but starting with the first item: `start` is only the result for no items. "
                 "`(reduce f xs)` needs at least one item.",
                 ("(list (reduce max 0 '(3 8 5)) (reduce + '(1 2 3)))", "(8 6)"))  # fmt: skip
def reduce(rt: Runtime, f: Any, start: Any, *start_and_items: Any) -> Any:
    members = iter(iterate(rt, start_and_items[0] if start_and_items else start, "reduce"))
    value = next(members, _NOTHING)
    if value is _NOTHING:
        if start_and_items:
            return start
        hint = "to define the result for no items, write `(reduce f start xs)`"
        raise SceneError("value", "`reduce` expects at least one item, got an empty sequence", hint=hint)
    for item in members:
        value = rt.call2(f, item, value)
    return value


@calling.define("apply", "f::Function argument::Any more::Any ...", "Any",
                 "Call `f` with the items of the last argument, a list; other arguments come before them.",
                 ("(apply + 1 2 '(3 4))", "10"))  # fmt: skip
def apply(rt: Runtime, f: Any, *arguments: Any) -> Any:
    last = arguments[-1]
    if type(last) is str:
        raise wrong_type("apply", "a list as the last argument", last)
    return rt.apply(f, [*arguments[:-1], *items(rt, last, "apply")])


registry = Registry("control")

_MAX_TEXTS = 100  # of an error: its message and its irritants
_MAX_IRRITANT_CHARACTERS = 200  # of each irritant, and of a value that is raised
_MAX_MESSAGE_CHARACTERS = 1000  # of a message that is not a string
# Errors that the program itself raises: reads of the values in their messages were recorded when they were raised.
_USER_ERRORS = ("user", "assert")


@registry.define("error", "message::Any irritants::Any ...", "Any",
                 "Raise an error with a message, followed by the values that it refers to.",
                 ('(guard (e (#t (error-message e))) (error "no such leg:" 5))', '"no such leg: 5"'))  # fmt: skip
def error(rt: Runtime, message: Any, *irritants: Any) -> Any:
    texts = [_message(rt, message)]
    for irritant in irritants:
        texts.append(rt.show(irritant, _MAX_IRRITANT_CHARACTERS))
        if len(texts) > _MAX_TEXTS:
            texts.append("...")
            break
    raise SceneError("user", " ".join(texts))


def _message(rt: Runtime, value: Any) -> str:
    """Return the text of the message of an error, truncated to the maximum length."""
    if type(value) is not str:
        return rt.show(value, _MAX_MESSAGE_CHARACTERS)
    return value if len(value) <= MAX_LENGTH else value[: MAX_LENGTH - 3] + "..."


@registry.define("raise", "value::Any", "Any",
                 "Raise any value, to be caught by `guard`; a caught error is raised again unchanged.",
                 ("(guard (e (#t (+ e 1))) (raise 41))", "42"))  # fmt: skip
def raise_(rt: Runtime, value: Any) -> Any:
    if type(value) is Condition:
        raise value.error
    raise SceneError("user", f"the program raised {rt.show(value, _MAX_IRRITANT_CHARACTERS)}", value=value)


@registry.define("gensym", "[prefix::String]", "Symbol",
                 "Return a unique symbol, for the names in the expansion of a macro.",
                 ("(eq? (gensym) (gensym))", "#f"))  # fmt: skip
def gensym(rt: Runtime, prefix: str = "g") -> Symbol:
    rt.charge(len(prefix) >> 8)
    rt.generated_symbols += 1
    return Symbol(f"{prefix}|{rt.generated_symbols}|")


@registry.define("assertion-failed", "message::Any", "Any", "Raise the error of a failed `assert`.",
                 ('(guard (e ((error-is? e "assert") (error-message e))) (assert (= 1 2) "no"))', '"no"'))  # fmt: skip
def assertion_failed(rt: Runtime, message: Any) -> Any:
    raise SceneError("assert", _message(rt, message))


@registry.define("declare-that",
                 "relation::String operands::List [:any] [:all] [:within] [:min] [:max] [:share] [:each] [:axis] [:to]"
                 " [:along] [:around] [:across] [:about] [:message] [:negated] [:first] [:last] [:sometime] [:never]",
                 "None",
                 "State a relation of objects about the entity that is being made, or at top level about the scene, as"
                 " `assert-that` does. `run` and `check --run` test whether it holds.",
                 ('(declare-that "on" (list "cup" "table") :any #t)', "none"))  # fmt: skip
def declare_that(rt: Runtime, relation: str, operands: Any, **options: Any) -> None:
    rt.declare(declared(relation, items(rt, operands, "declare-that"), options, rt.site))


@registry.define("error?", "value::Any", "Boolean",
                 "Return whether a value is an error caught by `guard`; false for another value that was raised.",
                 ("(guard (e (#t (error? e))) (car '()))", "#t"))  # fmt: skip
def is_error(rt: Runtime, value: Any) -> bool:
    return type(value) is Condition


@registry.define("error-message", "error::Any", "String",
                 "Return the message of an error; of a raised value, its text.",
                 ("(guard (e (#t (error-message e))) (ref '(1 2) 5))",
                  '"index 5 is outside the list of length 2"'))  # fmt: skip
def error_message(rt: Runtime, caught: Any) -> str:
    if type(caught) is Condition:
        error: SceneError = caught.error
        if error.name not in _USER_ERRORS:
            rt.read_error()
        return error.message
    return rt.display(caught)


def _condition(name: str, value: Any) -> SceneError:
    """Return the error that ``guard`` caught."""
    if type(value) is not Condition:
        raise wrong_type(name, "an error caught by `guard`", value)
    error: SceneError = value.error
    return error


@registry.define("error-code", "error::Any", "String", "Return the stable code of an error, such as E405.",
                 ("(guard (e (#t (error-code e))) (ref '(1 2) 5))", '"E405"'))  # fmt: skip
def error_code(rt: Runtime, caught: Any) -> str:
    return CODES[_condition("error-code", caught).name].code


@registry.define("error-place", "error::Any", "Any",
                 "Return the location of an error as a string `file:line:column`, or none if it is not known.",
                 ("(guard (e (#t (string? (error-place e)))) (car '()))", "#t"))  # fmt: skip
def error_place(rt: Runtime, caught: Any) -> str | None:
    span = _condition("error-place", caught).span
    if span is None:
        return None
    rt.read_error()  # the location changes with the text above
    span = rt.place(span)
    line, column = span.source.position(span.start)
    return f"{span.source.name}:{line}:{column}"


@registry.define("error-is?", "error::Any name::String", "Boolean",
                 'Return whether an error has this name, such as "index", "key", "type" or "user".',
                 ("(guard (e ((error-is? e \"zero-division\") 0)) (/ 1 0))", "0"))  # fmt: skip
def error_is(rt: Runtime, caught: Any, name: str) -> bool:
    if name not in CODES:
        hint = suggest(name, CODES) or 'use a name such as "index", "key", "type", "value" or "user"'
        raise SceneError("value", f"unknown error name {show(name, 40)}", hint=hint)
    if type(caught) is Condition:
        return bool(caught.error.name == name)
    return name == "user"


@registry.define("print", "values::Any ...", "Any",
                 "Write the values to the log, separated by spaces; return none.",
                 ('(print "legs:" 4)', "none"))  # fmt: skip
def print_(rt: Runtime, *values: Any) -> None:
    texts = [rt.display(value) for value in values]
    rt.meter.check_size(sum(map(len, texts)) + len(texts), "a string")
    rt.print(" ".join(texts))


@registry.define("void", "values::Any ...", "Any", "Return none for any arguments.", ("(void 1 2)", "none"))
def void(rt: Runtime, *values: Any) -> None:
    return None


@registry.define("identity", "value::Any", "Any", "Return the argument.", ("(map identity '(1 2))", "(1 2)"))
def identity(rt: Runtime, value: Any) -> Any:
    return value

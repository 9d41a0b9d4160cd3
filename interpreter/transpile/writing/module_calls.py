"""Calls of `itertools`, `functools`, `collections` and other small modules."""

from __future__ import annotations

import ast
from typing import TYPE_CHECKING

from scenelang.interpreter.transpile.analysis.domain import DICT, RECORD, Type
from scenelang.interpreter.transpile.analysis.scopes import Variable
from scenelang.interpreter.transpile.writing.arguments import arguments_of
from scenelang.interpreter.transpile.writing.call_basics import CallWriter, keyword_of, plain_arguments
from scenelang.interpreter.transpile.writing.code import (
    Code,
    Form,
    Name,
    Ref,
    form,
    number,
)
from scenelang.interpreter.transpile.writing.operators import numeric

if TYPE_CHECKING:
    from scenelang.interpreter.transpile.writing.expressions import ExpressionWriter


def write_reduce(w: ExpressionWriter, node: ast.Call) -> Code:
    function, source, *start = plain_arguments(w, node)
    if start:
        return form("fold-left", w.expr(function), w.expr(start[0]), w.iterable(source))
    first = w.iterable(source)
    return form("fold-left", w.expr(function), form("first", first), form("rest", w.iterable(source)))


def write_itertools_product(w: ExpressionWriter, node: ast.Call) -> Code:
    repeat = keyword_of(node, "repeat")
    sources = list(plain_arguments(w, node))
    if repeat is not None:
        if not isinstance(repeat, ast.Constant) or not isinstance(repeat.value, int) or not 0 < repeat.value < 9:
            raise w.unsupported("a computed `repeat`", repeat)
        sources = sources * repeat.value
    variables = [Variable("item", None, is_temporary=True) for _ in sources]
    clauses = Form([Form([Ref(v), w.iterable(s)]) for v, s in zip(variables, sources)])
    return Form([Name("for*/list"), clauses, form("list", *(Ref(v) for v in variables))])


def write_combinations(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "iterable r", "combinations")
    if not isinstance(given["r"], ast.Constant) or given["r"].value != 2:
        raise w.unsupported("combinations of any number but 2", node)
    i, j, items = (Variable(name, None, is_temporary=True) for name in ("i", "j", "items"))
    length = form("length", Ref(items))
    clauses = Form([
        Form([Ref(i), form("range", length)]),
        Form([Ref(j), form("range", form("+", Ref(i), number(1)), form("length", Ref(items)))]),
    ])  # fmt: skip
    body = form("list", form("ref", Ref(items), Ref(i)), form("ref", Ref(items), Ref(j)))
    return form(
        "let", Form([Form([Ref(items), w.iterable(given["iterable"])])]), Form([Name("for*/list"), clauses, body])
    )


def write_chain(w: ExpressionWriter, node: ast.Call) -> Code:
    if len(node.args) == 1 and isinstance(node.args[0], ast.Starred):
        return form("apply", Name("append"), w.iterable(node.args[0].value))
    return form("append", *(w.iterable(a) for a in plain_arguments(w, node)))


def write_chain_from_iterable(w: ExpressionWriter, node: ast.Call) -> Code:
    return form(
        "apply", Name("append"), w.iterable(arguments_of(w, node, "iterable", "chain.from_iterable")["iterable"])
    )


def write_cycle(w: ExpressionWriter, node: ast.Call) -> Code:
    """A cycle is a list that ``next`` turns around."""
    return form("mutable", w.iterable(arguments_of(w, node, "iterable", "itertools.cycle")["iterable"]))


def write_accumulate(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "iterable", "itertools.accumulate")
    return form("->list", form("cumsum", w.iterable(given["iterable"])))


def write_itertools_repeat(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "object times", "itertools.repeat")
    return form("make-list", w.expr(given["times"]), w.expr(given["object"]))


def write_hsv(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "h s v", "colorsys.hsv_to_rgb")
    return form("hsv", *(numeric(w, given[name]) for name in "hsv"))


def write_copy(w: ExpressionWriter, node: ast.Call) -> Code:
    value = arguments_of(w, node, "x", "copy")["x"]
    is_deep = w.paths.of(node.func) == "copy.deepcopy"
    if w.type(value).kinds & RECORD:
        raise w.unsupported("a copy of a record", node, "make a new one")
    return _copied(w, w.expr(value), w.type(value) | w.type(node), is_deep, 0)


def _copied(w: ExpressionWriter, code: Code, found: Type, is_deep: bool, level: int) -> Code:
    """A copy of containers that change, level by level where it is deep; what never changes needs none."""
    if not _changes(found, 0) or level > 3:
        return code
    inner = Type(0)
    for site in found.sites:
        inner = inner | site.element
    if not is_deep or not _changes(inner, 0):
        return form("mutable", code)
    item = Variable("item", None, is_temporary=True)
    copied = _copied(w, Ref(item), inner, True, level + 1)
    if found.only(DICT):
        key = Variable("key", None, is_temporary=True)
        clauses = Form([Form([Form([Ref(key), Ref(item)]), form("table-items", code)])])
        return Form([Name("for/table"), clauses, form("list", Ref(key), copied)])
    return form("mutable", Form([Name("for/list"), Form([Form([Ref(item), code])]), copied]))


def _changes(found: Type, level: int) -> bool:
    """Whether a container, or one inside it, is changed somewhere."""
    return any(site.is_mutated or (level < 4 and _changes(site.element, level + 1)) for site in found.sites)


def _not_here(what: str, hint: str) -> CallWriter:
    def write(w: ExpressionWriter, node: ast.Call) -> Code:
        raise w.unsupported(what, node, hint)

    return write

"""Calls of the program's own functions: which arguments go by position and which by name."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from typing import TYPE_CHECKING

from scenelang.grammar.diagnostics import suggest
from scenelang.interpreter.transpile.analysis.domain import BOOL, FLOAT, INT, NOTHING
from scenelang.interpreter.transpile.analysis.scopes import Class, Function, Parameter, Variable
from scenelang.interpreter.transpile.writing.code import ArgumentName, Code, Form, Name, Ref, form
from scenelang.interpreter.transpile.writing.operators import numeric

if TYPE_CHECKING:
    from scenelang.interpreter.transpile.writing.expressions import ExpressionWriter


def call_function(w: ExpressionWriter, node: ast.Call) -> Code:
    """A call of a variable, a lambda or the result of another call."""
    from scenelang.interpreter.transpile.writing.records import construct

    record = _record_of(w, node.func)
    if record is not None:
        return construct(w, node, record)
    target = w.single_function(node.func)
    if target is None and isinstance(node.func, ast.Name):
        targets = w.facts.targets.get(node, [])
        target = targets[0] if len(targets) == 1 and isinstance(targets[0].node, ast.Lambda) else None
        variable = w.variable(node.func)
        if target is not None and (variable is None or len(variable.stores) != 1 or not _is_named(w, variable, target)):
            target = None
    if target is None:
        return _call_value(w, node)
    assert isinstance(node.func, ast.Name)
    function = Ref(w.names.variables[node.func], w.span(node.func))
    return call_known(w, node, function, target, [])


def _is_named(w: ExpressionWriter, variable: Variable, function: Function) -> bool:
    """Whether a variable is just the name of a lambda."""
    outer = w.parent(variable.stores[0])
    return isinstance(outer, ast.Assign) and outer.value is function.node


def _record_of(w: ExpressionWriter, func: ast.expr) -> Class | None:
    variable = w.variable(func)
    return next((c for c in w.names.classes.values() if c.variable is variable), None) if variable is not None else None


def call_known(w: ExpressionWriter, node: ast.Call, function: Code, target: Function, first: list[Code]) -> Code:
    """Call ``target``, whose parameters are known; ``first`` are arguments before those of ``node``."""
    parameters = target.parameters[len(first) :]
    stars = [a for a in node.args if isinstance(a, ast.Starred)]
    _check(w, node, target, parameters, bool(stars))
    if stars:
        return _spread(w, node, function, parameters, first)
    items = list(first)
    rest = next((p for p in parameters if p.kind == "rest"), None)
    plain = [p for p in parameters if p.kind == "plain"]
    for position, argument in enumerate(node.args):
        if position < len(plain):
            if plain[position].variable.is_keyword:
                items.append(ArgumentName(plain[position].variable.name, w.span(argument)))
        elif rest is None:
            break
        items.append(w.comment_item(write_argument(w, argument, plain[position : position + 1]), argument))
    tables: list[Code] = []
    for keyword in node.keywords:
        if keyword.arg is None:
            tables.append(form("keywords", w.expr(keyword.value)))
            continue
        named = [p for p in parameters if p.variable.name == keyword.arg]
        value = write_argument(w, keyword.value, named)
        items += w.comment_pair(ArgumentName(keyword.arg, w.span(keyword)), value, keyword)
    if tables:
        return form("apply", function, *items, *([form("append", *tables)] if len(tables) > 1 else tables))
    return Form([function, *items])


def write_argument(w: ExpressionWriter, node: ast.expr, parameters: Sequence[Parameter] = ()) -> Code:
    """An argument of a function of the program: a display that only serves as a vector becomes one, a Boolean beside
    numbers a number."""
    if w.type(node).only(BOOL) and any(
        w.facts.variables.get(p.variable, NOTHING).kinds & (INT | FLOAT) for p in parameters
    ):
        return numeric(w, node)
    return w.vector(node) if w.is_vector_literal(node) and w.wants_vector(node) else w.expr(node)


def _check(w: ExpressionWriter, node: ast.Call, target: Function, parameters: list[Parameter], has_star: bool) -> None:
    """Raise what the call gets wrong about the function's parameters."""
    plain = [p for p in parameters if p.kind == "plain"]
    names = [p.variable.name for p in parameters if p.kind in ("plain", "keyword")]
    kinds = {p.kind for p in parameters}
    if not has_star and len(node.args) > len(plain) and "rest" not in kinds:
        takes = f"{len(plain)} argument{'s' if len(plain) != 1 else ''}"
        raise w.error("python-call", f"`{target.name}` takes {takes}, got {len(node.args)}", node)
    given = {p.variable.name for p, _ in zip(plain, node.args)} if not has_star else set()
    for keyword in node.keywords:
        if keyword.arg is None:
            return
        if keyword.arg not in names and "keys" not in kinds:
            raise w.error(
                "python-call", f"`{target.name}` has no parameter `{keyword.arg}`", keyword, suggest(keyword.arg, names)
            )
        if keyword.arg in given:
            raise w.error("python-call", f"`{target.name}` gets `{keyword.arg}` twice", keyword)
        given.add(keyword.arg)
    missing = [
        p.variable.name for p in parameters
        if p.kind in ("plain", "keyword") and p.default is None and p.variable.name not in given
    ]  # fmt: skip
    if missing and not has_star:
        raise w.error("python-call", f"the call of `{target.name}` lacks {', '.join(f'`{m}`' for m in missing)}", node)


def _spread(
    w: ExpressionWriter, node: ast.Call, function: Code, parameters: list[Parameter], first: list[Code]
) -> Code:
    """``f(*xs)``. Parameters that go by name are given by position through a function between."""
    before: list[Code] = list(first)
    lists: list[Code] = []
    named = [k for k in node.keywords if k.arg is not None]
    plain = [p for p in parameters if p.kind == "plain" and p.variable.name not in {k.arg for k in named}]
    given: list[Code] = []
    tables: list[Code] = []
    for keyword in node.keywords:
        if keyword.arg is None:
            tables.append(form("keywords", w.expr(keyword.value)))
            continue
        given += [ArgumentName(keyword.arg, w.span(keyword)), w.expr(keyword.value)]
    if any(p.variable.is_keyword for p in plain):
        count = _positional_count(w, node)
        plain = plain if count is None else plain[:count]
        rest = next((p for p in parameters if p.kind == "rest"), None)
        function, given, tables = by_position(function, plain, given, tables, rest), [], []
    for argument in node.args:
        if isinstance(argument, ast.Starred):
            lists.append(w.iterable(argument.value))
        elif lists:
            lists.append(form("list", w.expr(argument)))
        else:
            before.append(w.expr(argument))
    before += given
    lists += tables
    tail = lists[0] if len(lists) == 1 else form("append", *lists)
    return form("apply", function, *before, tail)


def _positional_count(w: ExpressionWriter, node: ast.Call) -> int | None:
    """How many arguments a call with stars gives by position, where inference knows."""
    total = 0
    for argument in node.args:
        length = w.known_length(argument.value) if isinstance(argument, ast.Starred) else 1
        if length is None:
            return None
        total += length
    return total


def by_position(
    function: Code, parameters: list[Parameter], given: Sequence[Code] = (), tables: Sequence[Code] = (),
    rest: Parameter | None = None,
) -> Code:  # fmt: skip
    """``(lambda (a b) (f :a a :b b))``: a function that takes by position what ``function`` takes by name; ``given``
    and ``tables`` are further arguments by name, ``rest`` takes what is over."""
    variables = [Variable(p.variable.name, None, is_temporary=True) for p in parameters]
    items: list[Code] = []
    for parameter, variable in zip(parameters, variables):
        if parameter.variable.is_keyword:
            items.append(ArgumentName(parameter.variable.name))
        items.append(Ref(variable))
    over = Variable(rest.variable.name, None, is_temporary=True) if rest is not None else None
    lists: list[Code] = [*([Ref(over)] if over is not None else []), *tables]
    call: Code = Form([function, *items, *given])
    if lists:
        tail = lists[0] if len(lists) == 1 else form("append", *lists)
        call = form("apply", function, *items, *given, tail)
    signature = Form([Ref(v) for v in variables], None, Ref(over) if over is not None else None)
    return Form([Name("lambda"), signature, call])


def wrapped(w: ExpressionWriter, function: Function, node: ast.Name) -> Code:
    """A function with keyword parameters as a value that is called by position: those without defaults."""
    plain = [p for p in function.parameters if p.kind == "plain"]
    required = sum(1 for p in plain if p.default is None)
    given = 1 if isinstance(w.parent(node), (ast.Call, ast.keyword)) else 0  # what `loop`, `map` or a key gives
    return by_position(Ref(w.names.variables[node], w.span(node)), plain[: max(required, given)])


def _call_value(w: ExpressionWriter, node: ast.Call) -> Code:
    """A call of a function that is only known when the program runs: where all that it may be agree, by name."""
    targets = w.facts.targets.get(node, [])
    names = {tuple(p.variable.name for p in t.parameters) for t in targets}
    is_named = any(p.variable.is_keyword for t in targets for p in t.parameters)
    if is_named and len(names) == 1 and not isinstance(node.func, ast.Lambda):
        return call_known(w, node, w.expr(node.func), targets[0], [])
    function = w.expr(node.func)
    if any(isinstance(a, ast.Starred) for a in node.args):
        return _spread(w, node, function, [], [])
    items = [w.comment_item(write_argument(w, a), a) for a in node.args]
    for keyword in node.keywords:
        if keyword.arg is None:
            items_list = form("keywords", w.expr(keyword.value))
            return form("apply", function, *items, items_list)
        items += [ArgumentName(keyword.arg, w.span(keyword)), w.expr(keyword.value)]
    return Form([function, *items])

"""Type inference: what kinds of values every expression of the Python may have.

The whole program is interpreted over abstract values: flow-sensitive inside a function, the arguments of
all call sites joined, containers by the place that makes them. Functions are looked at again until nothing grows.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any

from scenelang.interpreter.transpile.analysis.expressions import (
    assign,
    call_function,
    call_value,
    expression_type,
    infer_defaults,
    operation,
    target_type,
)
from scenelang.interpreter.transpile.analysis.inference import (
    ANYTHING,
    ARRAY,
    FUNCTION,
    LIST,
    NOTHING,
    RECORD,
    SHAPE,
    T_NONE,
    T_SHAPE,
    AbstractType,
    InferenceState,
    TypeFacts,
    annotated,
    merge,
    narrow,
)
from scenelang.interpreter.transpile.analysis.scopes import Function, LibraryPaths, PythonNames, is_annotation

# The inference of a whole program.


def infer(
    names: PythonNames, paths: LibraryPaths, words: dict[str, Function], root: Function | None, additions: set[ast.AST]
) -> TypeFacts:
    """Infer the types of a program. ``words`` maps what ``library_call`` may say to registered functions; what
    ``additions`` add to lists does not count as changing them."""
    state = InferenceState(names, paths, words, additions, call_value)
    state.enqueue(names.module)
    _run(state)
    if root is not None:
        call_function(state, root, root.node, [], {})
    _run(state)
    for function in names.ordered:  # functions that nothing calls are looked at with what their annotations say
        if function not in state.facts.reached:
            _assume_annotations(state, function)
            state.enqueue(function)
            _run(state)
    _propagate_effects(state)
    return state.facts


def _propagate_effects(state: InferenceState) -> None:
    effects, callees = state.facts.effects, state.callees
    changed = True
    while changed:
        changed = False
        for function, called in callees.items():
            total = effects.get(function, 0)
            for callee in called:
                total |= effects.get(callee, 0)
            if total != effects.get(function, 0):
                effects[function] = total
                changed = True


# The work list, and functions as a whole.


def _run(state: InferenceState) -> None:
    while state.queue:
        function = state.queue.popleft()
        state.visits[function] = state.visits.get(function, 0) + 1
        state.facts.reached.add(function)
        _analyse(state, function)


def _analyse(state: InferenceState, function: Function) -> None:
    saved = state.function, state.env, state.exits
    state.function, state.exits = function, []
    state.env = {p.variable: state.facts.variables.get(p.variable, NOTHING) for p in function.parameters}
    node = function.node
    if isinstance(node, ast.Lambda):
        state.returned(function, expression_type(state, node.body))
    else:
        _block(state, node.body)
        if state.env is not None and not isinstance(node, ast.Module) and not function.is_generator:
            state.returned(function, T_NONE)
    state.function, state.env, state.exits = saved


def _assume_annotations(state: InferenceState, function: Function) -> None:
    for parameter in function.parameters:
        if parameter.kind in ("plain", "keyword"):
            known = annotated(parameter.annotation)
            if parameter.default is not None:
                known = known | state.facts.type(parameter.default)
            state.store(parameter.variable, known)


# Statements: the flow of a function.


_DEEPEST_LOOPS = 5


def _block(state: InferenceState, body: Sequence[ast.stmt]) -> None:
    for statement in body:
        if state.env is None:
            state.env = {}  # unreachable; looked at all the same
            for rest in body[body.index(statement) :]:
                _statement(state, rest)
            state.env = None
            return
        _statement(state, statement)


def _statement(state: InferenceState, node: ast.stmt) -> None:
    handler = _STATEMENTS.get(type(node))
    if handler is not None:
        handler(state, node)


def _expression_statement(state: InferenceState, node: ast.Expr) -> None:
    expression_type(state, node.value)


def _assign_statement(state: InferenceState, node: ast.Assign) -> None:
    if is_annotation(state.paths, node.value):
        return
    value = expression_type(state, node.value)
    for target in node.targets:
        assign(state, target, value)


def _annotated_assign(state: InferenceState, node: ast.AnnAssign) -> None:
    if node.value is not None:
        assign(state, node.target, expression_type(state, node.value))


def _augmented_assign(state: InferenceState, node: ast.AugAssign) -> None:
    value = expression_type(state, node.value)
    old = target_type(state, node.target)
    if isinstance(node.op, ast.Add) and old.kinds & LIST:
        state.mutated(old, state.elements(value), node=node)
        if value.only(SHAPE):
            old = old | T_SHAPE
        state.facts.types[node] = old
        assign(state, node.target, old)
        return
    result = operation(state, node, node.op, old, value)
    if old.kinds & ARRAY:
        state.mutated(old, state.elements(result) if old.only(ARRAY) else NOTHING, node=node)
        if old.only(ARRAY):  # the array itself changes
            result = old
    state.facts.types[node] = result
    assign(state, node.target, result)


def _delete(state: InferenceState, node: ast.Delete) -> None:
    for target in node.targets:
        if isinstance(target, ast.Subscript):
            expression_type(state, target.slice)
            state.mutated(expression_type(state, target.value), node=target)


def _return(state: InferenceState, node: ast.Return) -> None:
    value = expression_type(state, node.value) if node.value is not None else T_NONE
    if not state.function.is_generator:
        state.returned(state.function, value)
    state.env = None


def _raise(state: InferenceState, node: ast.Raise) -> None:
    if node.exc is not None:
        expression_type(state, node.exc)
    state.env = None


def _break(state: InferenceState, node: ast.Break) -> None:
    if state.exits and state.env is not None:
        state.exits[-1].append(state.env)
    state.env = None


def _assert(state: InferenceState, node: ast.Assert) -> None:
    expression_type(state, node.test)
    narrow(state, node.test, True)


def _if(state: InferenceState, node: ast.If) -> None:
    expression_type(state, node.test)
    before = dict(state.env or {})
    narrow(state, node.test, True)
    _block(state, node.body)
    after_body = state.env
    state.env = before
    narrow(state, node.test, False)
    _block(state, node.orelse)
    state.env = merge(after_body, state.env)


def _for(state: InferenceState, node: ast.For) -> None:
    elements = state.elements(expression_type(state, node.iter))
    state.facts.types[node] = elements
    _loop(state, node, lambda: assign(state, node.target, elements))


def _while(state: InferenceState, node: ast.While) -> None:
    def test() -> None:
        expression_type(state, node.test)
        narrow(state, node.test, True)

    _loop(state, node, test)


def _loop(state: InferenceState, node: ast.For | ast.While, begin: object) -> None:
    assert callable(begin)
    if len(state.exits) >= _DEEPEST_LOOPS:  # without the flow, so that the work does not double with every level
        state.env = {}
        state.exits.append([])
        begin()
        _block(state, node.body)
        state.exits.pop()
        state.env = {}
        _block(state, node.orelse)
        return
    head = dict(state.env or {})
    for _ in range(8):
        state.env = dict(head)
        state.exits.append([])
        begin()
        _block(state, node.body)
        ends = state.exits.pop()
        merged = dict(head)
        for env in (state.env, *ends):
            merged = merge(merged, env) or merged
        if all(merged.get(v) is head.get(v) for v in merged):
            break
        head = merged
    state.env = head
    _block(state, node.orelse)


def _with(state: InferenceState, node: ast.With) -> None:
    for item in node.items:
        expression_type(state, item.context_expr)
    _block(state, node.body)


def _try(state: InferenceState, node: ast.Try) -> None:
    before = dict(state.env or {})
    _block(state, node.body)
    _block(state, node.orelse)
    merged = state.env
    for handler in node.handlers:
        state.env = merge(dict(before), merged) or {}
        if handler.name and handler in state.names.variables:
            state.store(state.names.variables[handler], ANYTHING)
        _block(state, handler.body)
        merged = merge(merged, state.env)
    state.env = merged
    _block(state, node.finalbody)


def _function(state: InferenceState, node: ast.FunctionDef) -> None:
    function = state.names.functions[node]
    infer_defaults(state, function)
    if function.variable is not None:
        state.store(function.variable, AbstractType(FUNCTION, frozenset((function,))))


def _class(state: InferenceState, node: ast.ClassDef) -> None:
    record = state.names.classes.get(node)
    if record is None:
        return
    for name, default in record.fields:
        if default is not None:
            state.set_field(record, name, expression_type(state, default))
    for value in record.constants.values():
        expression_type(state, value)
    for method in record.methods.values():
        infer_defaults(state, method)
        if method.parameters and not method.is_static:
            state.store(method.parameters[0].variable, AbstractType(RECORD, frozenset((record,))))
    state.store(record.variable, AbstractType(FUNCTION, frozenset((record,))))


_STATEMENTS: Mapping[type[ast.stmt], Callable[[InferenceState, Any], None]] = MappingProxyType({
    ast.AnnAssign: _annotated_assign, ast.Assert: _assert, ast.Assign: _assign_statement,
    ast.AugAssign: _augmented_assign, ast.Break: _break, ast.ClassDef: _class, ast.Continue: _break,
    ast.Delete: _delete, ast.Expr: _expression_statement, ast.For: _for, ast.FunctionDef: _function, ast.If: _if,
    ast.Raise: _raise, ast.Return: _return, ast.Try: _try, ast.While: _while, ast.With: _with,
})  # fmt: skip

"""Type inference: the possible kinds of every expression of the Python code.

The whole program is abstractly interpreted: flow-sensitive within a function, with the arguments of all call sites
joined, and with containers represented by their allocation sites. Functions are analysed repeatedly until a fixed point
is reached.
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
    annotated_type,
    merge,
    narrow,
)
from scenelang.interpreter.transpile.analysis.scopes import Function, LibraryPaths, PythonNames, is_annotation

# Inference of a whole program.


def infer(
    names: PythonNames, paths: LibraryPaths, words: dict[str, Function], root: Function | None, additions: set[ast.AST]
) -> TypeFacts:
    """Infer the types of a program.

    Parameters
    ----------
    words
        Registered functions by the argument of ``library_call``.
    root
        Root of the scene, which is called without arguments.
    additions
        Nodes that add to collected lists, which do not count as mutations.
    """
    state = InferenceState(names, paths, words, additions, call_value)
    state.enqueue(names.module)
    _run(state)
    if root is not None:
        call_function(state, root, root.node, [], {})
    _run(state)
    for function in names.ordered:  # functions without call sites get their annotated types
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


# Work list and functions.


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
        state.add_return(function, expression_type(state, node.body))
    else:
        _block(state, node.body)
        if state.env is not None and not isinstance(node, ast.Module) and not function.is_generator:
            state.add_return(function, T_NONE)
    state.function, state.env, state.exits = saved


def _assume_annotations(state: InferenceState, function: Function) -> None:
    for parameter in function.parameters:
        if parameter.kind in ("plain", "keyword"):
            known = annotated_type(parameter.annotation)
            if parameter.default is not None:
                known = known | state.facts.type(parameter.default)
            state.store(parameter.variable, known)


# Statements.


_MAX_NESTED_LOOPS = 5
_MAX_ITERATIONS = 8  # of the analysis of a loop's body; types that still grow are joined by ``store``


def _block(state: InferenceState, body: Sequence[ast.stmt]) -> None:
    for statement in body:
        if state.env is None:
            state.env = {}  # unreachable statements are analysed too
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
        state.mutate(old, state.elements(value), node=node)
        if value.only(SHAPE):
            old = old | T_SHAPE
        state.facts.types[node] = old
        assign(state, node.target, old)
        return
    result = operation(state, node, node.op, old, value)
    if old.kinds & ARRAY:
        state.mutate(old, state.elements(result) if old.only(ARRAY) else NOTHING, node=node)
        if old.only(ARRAY):  # modified in place
            result = old
    state.facts.types[node] = result
    assign(state, node.target, result)


def _delete(state: InferenceState, node: ast.Delete) -> None:
    for target in node.targets:
        if isinstance(target, ast.Subscript):
            expression_type(state, target.slice)
            state.mutate(expression_type(state, target.value), node=target)


def _return(state: InferenceState, node: ast.Return) -> None:
    value = expression_type(state, node.value) if node.value is not None else T_NONE
    if not state.function.is_generator:
        state.add_return(state.function, value)
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


def _loop(state: InferenceState, node: ast.For | ast.While, bind_head: object) -> None:
    assert callable(bind_head)
    if len(state.exits) >= _MAX_NESTED_LOOPS:  # flow-insensitive, since every level of nesting multiplies the work
        state.env = {}
        state.exits.append([])
        bind_head()
        _block(state, node.body)
        state.exits.pop()
        state.env = {}
        _block(state, node.orelse)
        return
    loop_env = dict(state.env or {})
    for _ in range(_MAX_ITERATIONS):
        state.env = dict(loop_env)
        state.exits.append([])
        bind_head()
        _block(state, node.body)
        ends = state.exits.pop()
        merged = dict(loop_env)
        for env in (state.env, *ends):
            merged = merge(merged, env) or merged
        if all(merged.get(v) is loop_env.get(v) for v in merged):
            break
        loop_env = merged
    state.env = loop_env
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

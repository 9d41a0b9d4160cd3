"""Decorators of the program in place of which stands what they make: a function around another, or a table's entry."""

from __future__ import annotations

import ast
import copy

from scenelang.interpreter.transpile.analysis.dispatching import without_dispatch
from scenelang.interpreter.transpile.analysis.python_text import walk_tree
from scenelang.interpreter.transpile.analysis.rewriting import Substitution, names_in, parents_of, placed


def without_decorators(tree: ast.Module) -> ast.Module:
    """Write, in place, what the decorators of a module make of the functions that they decorate."""
    without_dispatch(tree)
    known = {each.name: each for each in tree.body if isinstance(each, ast.FunctionDef)}
    taken = names_in(tree)
    body: list[ast.stmt] = []
    for each in tree.body:
        made = _written(each, known, taken) if isinstance(each, ast.FunctionDef) else None
        body += [each] if made is None else made
    used = {n.id for each in body for n in walk_tree(each) if isinstance(n, ast.Name)}
    decorating = {_name(d) for each in tree.body if isinstance(each, ast.FunctionDef) for d in each.decorator_list}
    tree.body = [
        each for each in body
        if not (isinstance(each, ast.FunctionDef) and each.name in decorating and each.name not in used)
    ]  # fmt: skip
    return tree


def _name(node: ast.expr) -> str:
    called = node.func if isinstance(node, ast.Call) else node
    return called.id if isinstance(called, ast.Name) else ""


def _written(node: ast.FunctionDef, known: dict[str, ast.FunctionDef], taken: set[str]) -> list[ast.stmt] | None:
    """Return a decorated function with what its decorators do written out; None if they are not understood."""
    own = [each for each in node.decorator_list if _name(each) in known]
    if not own or own[-1] is not node.decorator_list[-1] or len(own) > 1:
        return None
    decorator = own[0]
    parts = _parts(decorator, known[_name(decorator)])
    if parts is None:
        return None
    parameter, values, before, result = parts
    if isinstance(result, ast.Name):  # the function itself, which a table holds
        if result.id != parameter or not before:
            return None
        rename = Substitution({**values, parameter: ast.Name(node.name, ast.Load())})
        statements = [rename.visit(copy.deepcopy(each)) for each in before]
        node.decorator_list = [each for each in node.decorator_list if each is not decorator]
        return [node, *(placed(each, node) for each in statements)]
    return _around(node, decorator, result, parameter, values, taken) if not before else None


def _parts(
    decorator: ast.expr, function: ast.FunctionDef
) -> tuple[str, dict[str, ast.expr], list[ast.stmt], ast.FunctionDef | ast.Name] | None:
    """Return the parameter of a decorator that is the function, its arguments, its statements and its result."""
    values: dict[str, ast.expr] = {}
    if isinstance(decorator, ast.Call):  # which makes the decorator
        names = [each.arg for each in function.args.args]
        given = dict(zip(names, decorator.args)) | {str(k.arg): k.value for k in decorator.keywords}
        defaults = dict(zip(names[len(names) - len(function.args.defaults) :], function.args.defaults))
        values = {**defaults, **given}
        inner = _inner(function)
        if len(decorator.args) > len(names):
            return None
        if inner is None or set(values) != set(names) or not all(isinstance(v, ast.Constant) for v in values.values()):
            return None
        function = inner
    body = [each for each in function.body if not _is_text(each)]
    if len(function.args.args) != 1 or function.args.vararg or function.args.kwarg or not body:
        return None
    last = body[-1]
    result = last.value if isinstance(last, ast.Return) else None
    if not isinstance(result, ast.Name):
        return None
    parameter = function.args.args[0].arg
    if result.id == parameter:
        simple = all(isinstance(each, (ast.Assign, ast.Expr)) for each in body[:-1])
        return (parameter, values, body[:-1], result) if simple else None
    wrapper = next((each for each in body if isinstance(each, ast.FunctionDef) and each.name == result.id), None)
    if wrapper is None or len(body) != 2:
        return None
    return parameter, values, [], wrapper


def _inner(function: ast.FunctionDef) -> ast.FunctionDef | None:
    """Return the function that another defines and returns, and does nothing else."""
    body = [each for each in function.body if not _is_text(each)]
    if len(body) != 2 or not isinstance(body[0], ast.FunctionDef) or not isinstance(body[1], ast.Return):
        return None
    result = body[1].value
    return body[0] if isinstance(result, ast.Name) and result.id == body[0].name else None


def _is_text(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def _around(
    node: ast.FunctionDef,
    decorator: ast.expr,
    wrapper: ast.FunctionDef,
    parameter: str,
    values: dict[str, ast.expr],
    taken: set[str],
) -> list[ast.stmt] | None:
    """Return a function and the one around it, which gets its name, its parameters and its other decorators."""
    if any("wraps" not in ast.unparse(each) for each in wrapper.decorator_list):
        return None
    inner = copy.deepcopy(node)
    inner.name = f"{node.name}_plain"
    if inner.name in taken:
        return None
    made = copy.deepcopy(wrapper)
    made.name, made.decorator_list, made.returns = (
        node.name,
        [e for e in node.decorator_list if e is not decorator],
        None,
    )
    inner.decorator_list = []
    rest, named = made.args.vararg, made.args.kwarg
    if rest is not None or named is not None:
        if rest is None or named is None or made.args.args or node.args.vararg or node.args.kwarg:
            return None
        if not _passes_all(made, parameter, rest.arg, named.arg):
            return None
        calls = [n for n in walk_tree(made) if isinstance(n, ast.Call) and isinstance(n.func, ast.Name)]
        local = {n.id for n in walk_tree(made) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
        clashing = local & {each.arg for each in walk_tree(node.args) if isinstance(each, ast.arg)}
        for each in walk_tree(made):
            if isinstance(each, ast.Name) and each.id in clashing:
                each.id = f"{each.id}_made"  # a variable of the function around, not the parameter
        for call in calls:
            if isinstance(call.func, ast.Name) and call.func.id == parameter:
                call.args = [ast.Name(each.arg, ast.Load()) for each in (*node.args.posonlyargs, *node.args.args)]
                call.keywords = [ast.keyword(each.arg, ast.Name(each.arg, ast.Load())) for each in node.args.kwonlyargs]
        made.args = copy.deepcopy(node.args)
    made = Substitution({**values, parameter: ast.Name(inner.name, ast.Load())}).visit(made)
    docs = node.body[:1] if _is_text(node.body[0]) else []
    made.body = [*copy.deepcopy(docs), *(each for each in made.body if not _is_text(each))]
    return [placed(inner, node), placed(made, node)]


def _passes_all(wrapper: ast.FunctionDef, function: str, rest: str, named: str) -> bool:
    """Return whether a function uses all its arguments only to pass them on to another."""
    parents = parents_of(wrapper)
    for node in walk_tree(wrapper):
        if not isinstance(node, ast.Name) or node.id not in (rest, named, function):
            continue
        parent = parents[node]
        call = parents[parent] if isinstance(parent, (ast.Starred, ast.keyword)) else parent
        if (
            isinstance(parent, ast.Call)
            and any(node is each for each in parent.args)
            and "wraps" in ast.unparse(parent.func)
        ):
            continue
        if not isinstance(call, ast.Call) or not isinstance(call.func, ast.Name) or call.func.id != function:
            return False
        if ast.unparse(call) != f"{function}(*{rest}, **{named})":
            return False
    return True

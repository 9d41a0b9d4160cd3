"""Functions that choose an implementation by the class of an argument (`functools.singledispatch`), as tests of it."""

from __future__ import annotations

import ast
import copy
from typing import Any

from scenelang.interpreter.transpile.analysis.python_text import walk_tree
from scenelang.interpreter.transpile.analysis.rewriting import free_name, names_in, placed

_DISPATCHING = ("singledispatch", "singledispatchmethod")
_BUILTINS = ("bool", "int", "float", "str", "list", "tuple", "dict", "set")


def without_dispatch(tree: ast.Module) -> None:
    """Write such functions, in place, as ones that look at the class of their first argument."""
    _rewrite(tree, tree)
    for each in tree.body:
        if isinstance(each, ast.ClassDef):
            _rewrite(each, tree)


def _rewrite(owner: Any, tree: ast.Module) -> None:
    for function in [each for each in owner.body if isinstance(each, ast.FunctionDef)]:
        if any(ast.unparse(d).rpartition(".")[2] in _DISPATCHING for d in function.decorator_list):
            implementations = _implementations(function, owner)
            uses = [
                n for n in walk_tree(tree) if isinstance(n, ast.Attribute) and ast.unparse(n.value) == function.name
            ]
            count = sum(len(each.decorator_list) for each, _ in implementations or ())
            if implementations and count == len(uses):  # nothing else is asked of the function, such as `dispatch`
                _write(function, implementations, owner, tree)


def _implementations(function: ast.FunctionDef, owner: Any) -> list[tuple[ast.FunctionDef, list[str]]] | None:
    """Return the functions that are registered for another, with their classes; None if these are not known."""
    place = 1 if isinstance(owner, ast.ClassDef) else 0
    implementations: list[tuple[ast.FunctionDef, list[str]]] = []
    for each in owner.body:
        decorators = each.decorator_list if isinstance(each, ast.FunctionDef) else []
        own = [d for d in decorators if _registers(d, function.name)]
        if not own:
            continue
        if len(own) < len(decorators) or not _has_same_parameters(each, function, place):
            return None
        kinds: list[str] = []
        for decorator in own:
            argument = each.args.args[place].annotation if len(each.args.args) > place else None
            argument = decorator.args[0] if isinstance(decorator, ast.Call) and decorator.args else argument
            kinds += _classes_in(argument)
        if not kinds:
            return None
        implementations.append((each, kinds))
    return implementations


def _registers(decorator: ast.expr, name: str) -> bool:
    function = decorator.func if isinstance(decorator, ast.Call) else decorator
    return ast.unparse(function) == f"{name}.register"


def _has_same_parameters(one: ast.FunctionDef, other: ast.FunctionDef, place: int) -> bool:
    """Return whether functions take the same arguments, but for the one that is looked at, with the same defaults."""
    given = [copy.deepcopy(each.args) for each in (one, other)]
    if any(each.vararg or each.kwarg or each.posonlyargs for each in given) or len(given[0].args) <= place:
        return False
    for each in given:
        each.args = each.args[place + 1 :]
        for parameter in (*each.args, *each.kwonlyargs):
            parameter.annotation = None
    return ast.dump(given[0]) == ast.dump(given[1])


def _classes_in(node: ast.expr | None) -> list[str]:
    """Return the names of the classes of an annotation: one, or a union of some."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.BitOr):
        return [*_classes_in(node.left), *_classes_in(node.right)]
    if isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value.isidentifier():
        return [node.value]
    return [node.id] if isinstance(node, ast.Name) else []


def _write(
    function: ast.FunctionDef, implementations: list[tuple[ast.FunctionDef, list[str]]], owner: Any, tree: ast.Module
) -> None:
    """Write the tests into a function, in place, and give the implementations names."""
    classes = {each.name: each for each in tree.body if isinstance(each, ast.ClassDef)}
    rows = [(kind, each) for each, kinds in implementations for kind in kinds]
    if any(kind not in classes and kind not in _BUILTINS for kind, _ in rows):
        return
    taken = names_in(tree)
    for each, kinds in implementations:
        each.name = free_name(f"{function.name}_{kinds[0]}".lower(), taken)
        each.decorator_list = []
    rows.sort(key=lambda row: (-_depth(row[0], classes), row[0] != "bool"))  # the narrowest class first
    names = [each.arg for each in function.args.args]
    place = 1 if isinstance(owner, ast.ClassDef) else 0
    passed = [*names[place:], *(f"{each.arg}={each.arg}" for each in function.args.kwonlyargs)]
    prefix = f"{names[0]}." if place else ""
    tests = [
        f"if isinstance({names[place]}, {kind}):\n    return {prefix}{each.name}({', '.join(passed)})"
        for kind, each in rows
    ]
    doc = function.body[:1] if ast.get_docstring(function) else []
    made = [placed(each, function, is_new=True) for each in ast.parse("\n".join(tests)).body]
    function.body = [*doc, *made, *function.body[len(doc) :]]
    function.decorator_list = [
        d for d in function.decorator_list if ast.unparse(d).rpartition(".")[2] not in _DISPATCHING
    ]


def _depth(name: str, classes: dict[str, ast.ClassDef]) -> int:
    """Return how many classes of the program a class is derived from, at most."""
    node = classes.get(name)
    bases = [base.id for base in node.bases if isinstance(base, ast.Name) and base.id != name] if node else []
    return max((_depth(base, classes) + 1 for base in bases), default=0)

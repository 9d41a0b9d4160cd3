"""What all that rewrites the syntax tree of Python needs: places, substitutions, and what may be repeated."""

from __future__ import annotations

import ast
import copy
from collections.abc import Mapping
from typing import TypeGuard, TypeVar

from scenelang.interpreter.transpile.analysis.python_text import child_nodes, walk_tree

Node = TypeVar("Node", bound=ast.AST)

# The names of operator methods as plain ones: ``__add__`` is ``add``, ``__radd__`` ``radd``.
OPERATOR_METHODS: dict[type[ast.operator], str] = {
    ast.Add: "add", ast.Sub: "sub", ast.Mult: "mul", ast.Div: "truediv", ast.MatMult: "matmul", ast.Mod: "mod",
    ast.FloorDiv: "floordiv", ast.Pow: "pow", ast.BitOr: "or_", ast.BitAnd: "and_", ast.BitXor: "xor",
    ast.LShift: "lshift", ast.RShift: "rshift",
}  # fmt: skip


def placed(node: Node, origin: ast.AST, is_new: bool = False) -> Node:
    """Return a node whose parts without a place are where another is; all of them if it is new."""
    for each in walk_tree(node):
        if "lineno" in each._attributes and (is_new or not hasattr(each, "lineno")):
            ast.copy_location(each, origin)
    return node


def names_in(tree: ast.AST) -> set[str]:
    """Return all names that a tree uses or defines: of variables, parameters, functions, classes and modules."""
    names: set[str] = set()
    for node in walk_tree(tree):
        if isinstance(node, ast.Name):
            names.add(node.id)
        elif isinstance(node, ast.arg):
            names.add(node.arg)
        elif isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            names.add(node.name)
        elif isinstance(node, ast.alias):
            names.add(node.asname or node.name)
    return names


def free_name(stem: str, taken: set[str]) -> str:
    """Return a name that starts with ``stem`` and is not taken, and add it to those that are."""
    number, name = 2, stem
    while name in taken:
        name, number = f"{stem}_{number}", number + 1
    taken.add(name)
    return name


def parents_of(tree: ast.AST) -> dict[ast.AST, ast.AST]:
    """Return the parent of each node."""
    return {child: node for node in walk_tree(tree) for child in child_nodes(node)}


class Substitution(ast.NodeTransformer):
    """Replaces variables by expressions; one that is assigned keeps its name unless the expression is a name."""

    def __init__(self, known: Mapping[str, ast.expr]) -> None:
        self._known = known

    def visit_Name(self, node: ast.Name) -> ast.expr:
        other = self._known.get(node.id)
        if isinstance(other, ast.Name):
            return ast.copy_location(ast.Name(other.id, node.ctx), node)
        if other is None or not isinstance(node.ctx, ast.Load):
            return node
        return copy.deepcopy(other)


def name_of(node: ast.AST | None) -> str:
    """Return the last name of a variable or attribute, or of what a call calls; no name for anything else."""
    named = node.func if isinstance(node, ast.Call) else node
    return str(getattr(named, "attr", getattr(named, "id", "")))


def is_registering(decorator: ast.expr, *names: str) -> bool:
    """Return whether a decorator registers a function as a word, or as the animation."""
    function = decorator.func if isinstance(decorator, ast.Call) else decorator
    return isinstance(function, ast.Name) and function.id in (names or ("register", "register_animation"))


def is_registered(node: ast.AST) -> bool:
    """Return whether a function is registered."""
    return any(map(is_registering, getattr(node, "decorator_list", ())))


def is_test_of_class(node: ast.AST) -> TypeGuard[ast.Call]:
    """Return whether a node is a call of ``isinstance``."""
    is_call = isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "isinstance"
    return is_call and isinstance(node, ast.Call) and len(node.args) == 2


def is_repeatable(node: ast.expr) -> bool:
    """Return whether it does not matter how often an expression is evaluated."""
    plain = (ast.Tuple, ast.List, ast.Constant, ast.Name, ast.Attribute, ast.Load)
    return all(isinstance(n, (*plain, ast.BinOp, ast.UnaryOp, ast.operator, ast.unaryop)) for n in walk_tree(node))


def is_sized(node: ast.expr) -> bool:
    """Return whether an expression has a length, and may be evaluated twice."""
    is_range = isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "range"
    return is_repeatable(node) or (is_range and isinstance(node, ast.Call) and all(map(is_repeatable, node.args)))


def is_annotation(node: ast.AST, parents: Mapping[ast.AST, ast.AST]) -> bool:
    """Return whether a node is part of an annotation."""
    while node in parents:
        parent = parents[node]
        if node is getattr(parent, "annotation", None) or node is getattr(parent, "returns", None):
            return True
        node = parent
    return False

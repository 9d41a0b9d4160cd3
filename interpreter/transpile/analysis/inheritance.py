"""Classes that are derived from others, as plain classes: each has copies of what it inherits.

A call or a field of a value that may be of several classes becomes a call of a function that looks at the class.
"""

from __future__ import annotations

import ast
import copy
from typing import Any

from scenelang.interpreter.transpile.analysis.python_text import walk_tree


def without_bases(tree: ast.Module) -> None:
    """Give the classes of a module, in place, what they inherit from one base that is a class of the module, too."""
    known: dict[str, ast.ClassDef] = {}
    heirs: dict[str, list[str]] = {}
    made = {n.func.id for n in walk_tree(tree) if isinstance(n, ast.Call) and isinstance(n.func, ast.Name)}
    for node in tree.body:
        if not isinstance(node, ast.ClassDef):
            continue
        bases = [each.id for each in node.bases if isinstance(each, ast.Name) and each.id in known]
        is_known = len(bases) == len(node.bases) and not node.keywords
        if is_known and all(_fits(node, known[each]) for each in bases) and not (len(bases) > 1 and _asks_super(node)):
            for base in bases:  # the first one that has a member gives it
                _inherit(node, known[base])
                for name, others in heirs.items():
                    if (name == base or base in others) and node.name not in others:
                        others.append(node.name)
            node.bases = []
        if not node.bases and not node.keywords:
            known[node.name] = node
            heirs[node.name] = []
    for name, others in heirs.items():
        if others and name not in made:  # it has no instances of its own
            known[name].body = [each for each in known[name].body if not isinstance(each, ast.FunctionDef)]
            known[name].body = known[name].body or [ast.copy_location(ast.Pass(), known[name])]
    for call in walk_tree(tree):
        if isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "isinstance":
            call.args[1:] = [_with_heirs(each, heirs) for each in call.args[1:]]


def _asks_super(node: ast.ClassDef) -> bool:
    return any(isinstance(n, ast.Name) and n.id == "super" for n in walk_tree(node))


def has_bases(tree: ast.Module) -> bool:
    """Return whether a class of a module has a base that is a class of the module."""
    names = {each.name for each in tree.body if isinstance(each, ast.ClassDef)}
    bases = (base for each in tree.body if isinstance(each, ast.ClassDef) for base in each.bases)
    return any(isinstance(base, ast.Name) and base.id in names for base in bases)


def _with_heirs(kind: ast.expr, heirs: dict[str, list[str]]) -> ast.expr:
    if not isinstance(kind, ast.Name) or not heirs.get(kind.id):
        return kind
    names = [kind.id, *heirs[kind.id]]
    found = ast.Tuple([ast.copy_location(ast.Name(name, ast.Load()), kind) for name in names], ast.Load())
    return ast.copy_location(found, kind)


def _is_dataclass(node: ast.ClassDef) -> bool:
    return any("dataclass" in ast.unparse(each) for each in node.decorator_list)


def _fits(node: ast.ClassDef, base: ast.ClassDef) -> bool:
    """Return whether copies of the members mean the same: a data class has a base that is one, or has no state."""
    has_fields = any(isinstance(each, ast.AnnAssign) for each in base.body)
    own_fields = any(isinstance(each, ast.AnnAssign) for each in node.body)
    if _is_dataclass(base) and not _is_dataclass(node):
        return not own_fields
    has_init = any(isinstance(each, ast.FunctionDef) and each.name == "__init__" for each in base.body)
    return _is_dataclass(base) or not (_is_dataclass(node) and (has_init or has_fields))


def _key(node: ast.stmt) -> str | None:
    """Return the name that a statement of a class defines."""
    if isinstance(node, ast.FunctionDef):
        return node.name
    target = (
        node.target if isinstance(node, ast.AnnAssign) else node.targets[0] if isinstance(node, ast.Assign) else None
    )
    return target.id if isinstance(target, ast.Name) else None


def _inherit(node: ast.ClassDef, base: ast.ClassDef) -> None:
    own = {key: each for each in node.body if (key := _key(each)) is not None}
    prefix = base.name.lower()
    called = _replace_super(node, prefix)
    inherited: list[ast.stmt] = []
    used: set[str] = set()
    for each in base.body:
        key = _key(each)
        if key is None:
            continue
        if key in called and isinstance(each, ast.FunctionDef):
            method = copy.deepcopy(each)
            method.name = f"{prefix}_{key.strip('_')}"
            inherited.append(method)
        replacement = own.get(key)
        if replacement is None:
            inherited.append(copy.deepcopy(each))
        elif isinstance(each, ast.AnnAssign) and isinstance(replacement, ast.AnnAssign):
            inherited.append(replacement)  # a field keeps its place
            used.add(key)
    node.body = [*inherited, *(each for each in node.body if _key(each) not in used)]
    if _is_dataclass(base) and not _is_dataclass(node):
        node.decorator_list = copy.deepcopy(base.decorator_list)
    if any("kw_only=True" in ast.unparse(each) for each in node.decorator_list):  # whose fields have no order
        node.body.sort(key=lambda each: isinstance(each, ast.AnnAssign) and each.value is not None)
        node.body.sort(key=lambda each: not isinstance(each, ast.AnnAssign))


def _replace_super(node: ast.ClassDef, prefix: str) -> set[str]:
    """Write ``super().m()`` as ``self.base_m()``; return the names of the methods."""
    called: set[str] = set()
    for method in node.body:
        if not isinstance(method, ast.FunctionDef) or not method.args.args:
            continue
        for each in walk_tree(method):
            owner = each.value if isinstance(each, ast.Attribute) else None
            is_super = isinstance(owner, ast.Call) and isinstance(owner.func, ast.Name) and owner.func.id == "super"
            if is_super and isinstance(each, ast.Attribute) and owner is not None:
                called.add(each.attr)
                each.value = ast.copy_location(ast.Name(method.args.args[0].arg, ast.Load()), owner)
                each.attr = f"{prefix}_{each.attr.strip('_')}"
    return called


class Dispatch:
    """Functions that choose the method, or the field, of a value that may be of several classes."""

    def __init__(self, taken: set[str]) -> None:
        self._taken = taken
        self._names: dict[tuple[Any, ...], str] = {}
        self.made: list[ast.stmt] = []

    def call(self, node: ast.Call, owner: ast.expr, method: str, classes: list[str]) -> ast.expr | None:
        """Return the call of the function in place of one of a method."""
        if any(isinstance(each, ast.Starred) for each in node.args) or any(k.arg is None for k in node.keywords):
            return None
        keywords = [str(each.arg) for each in node.keywords]
        given = [*(f"argument_{n}" for n in range(len(node.args))), *keywords]
        passed = [*given[: len(node.args)], *(f"{name}={name}" for name in keywords)]
        name = self._function(method, given, f"thing.{method}({', '.join(passed)})", classes)
        function = ast.copy_location(ast.Name(name, ast.Load()), node)
        return ast.copy_location(ast.Call(function, [owner, *node.args], node.keywords), node)

    def field(self, node: ast.Attribute, classes: list[str]) -> ast.expr:
        """Return the call of the function in place of a field."""
        name = self._function(f"{node.attr}_of", [], f"thing.{node.attr}", classes)
        return ast.copy_location(ast.Call(ast.copy_location(ast.Name(name, ast.Load()), node), [node.value], []), node)

    def _function(self, stem: str, given: list[str], value: str, classes: list[str]) -> str:
        key = (stem, *given, value, *classes)
        if key not in self._names:
            number = 2
            name = stem
            while name in self._taken:
                name, number = f"{stem}_{number}", number + 1
            self._taken.add(name)
            self._names[key] = name
            lines = [f"def {name}({', '.join(['thing', *given])}):"]
            lines += [f"    if isinstance(thing, {each}):\n        return {value}" for each in classes]
            self.made += ast.parse("\n".join([*lines, "    raise TypeError('no such class')"])).body
        return self._names[key]

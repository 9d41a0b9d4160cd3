"""Classes that are derived from others, as plain classes: each has copies of what it inherits.

A call or a field of a value that may be of several classes becomes a call of a function that looks at the class.
"""

from __future__ import annotations

import ast
import copy
import itertools
from collections.abc import Mapping
from typing import Any

from scenelang.interpreter.transpile.analysis.python_text import walk_tree
from scenelang.interpreter.transpile.analysis.rewriting import Substitution, free_name, placed

_HOOK = "__init_subclass__"


def without_hooks(tree: ast.Module) -> None:
    """Write what ``__init_subclass__`` does, in place, after each class that is derived from the one that has it."""
    classes = {each.name: each for each in tree.body if isinstance(each, ast.ClassDef)}
    hooks = {name: m for name, each in classes.items() for m in each.body if getattr(m, "name", "") == _HOOK}
    body: list[ast.stmt] = []
    written: set[str] = set()
    for each in tree.body:
        body.append(each)
        line = _line_of(each, classes) if isinstance(each, ast.ClassDef) else []
        hook = next((name for name in line[1:] if name in hooks), None)
        if hook is None or not isinstance(each, ast.ClassDef):
            continue
        made = _called_hook(hooks[hook], each, [classes[name] for name in line])
        if made is None:
            return
        body += made
        written.add(each.name)
    for name in hooks:
        classes[name].body = [m for m in classes[name].body if getattr(m, "name", "") != _HOOK] or [
            ast.copy_location(ast.Pass(), classes[name])
        ]
    for name in written:
        classes[name].keywords = []
    tree.body = body


def _line_of(node: ast.ClassDef, classes: Mapping[str, ast.ClassDef]) -> list[str]:
    """Return a class and those of a module that it is derived from, in the order in which Python asks them (C3)."""
    bases = [each.id for each in node.bases if isinstance(each, ast.Name) and classes.get(each.id, node) is not node]
    pending = [*(_line_of(classes[each], classes) for each in bases), bases]
    names = [node.name]
    while pending := [each for each in pending if each]:
        head = next((p[0] for p in pending if not any(p[0] in other[1:] for other in pending)), None)
        if head is None:
            return [node.name]  # which is an error of Python's
        names.append(head)
        pending = [[each for each in other if each != head] for other in pending]
    return names


def _called_hook(hook: Any, node: ast.ClassDef, line: list[ast.ClassDef]) -> list[ast.stmt] | None:
    """Return the statements of a hook for a class; its assignments of attributes go into the class."""
    given = hook.args
    names = [each.arg for each in (*given.posonlyargs, *given.args, *given.kwonlyargs)]
    plain = [each.arg for each in (*given.posonlyargs, *given.args)]
    defaults = dict(zip(plain[len(plain) - len(given.defaults) :], given.defaults))
    defaults |= {a.arg: d for a, d in zip(given.kwonlyargs, given.kw_defaults) if d is not None}
    values = {**defaults, **{str(k.arg): k.value for k in node.keywords}}
    rest = given.kwarg.arg if given.kwarg is not None else None
    if given.vararg or set(values) != set(names[1:]) or not all(isinstance(v, ast.Constant) for v in values.values()):
        return None
    body: list[ast.stmt] = []
    for each in hook.body:
        if isinstance(each, ast.Expr) and (isinstance(each.value, ast.Constant) or _is_super_call(each.value)):
            continue
        if not isinstance(each, (ast.Assign, ast.Expr, ast.If, ast.AugAssign)):
            return None
        if any(isinstance(n, ast.Name) and n.id == rest for n in walk_tree(each)):
            return None
        made = _OfClass(names[0], line).visit(Substitution(values).visit(copy.deepcopy(each)))
        target = made.targets[0] if isinstance(made, ast.Assign) else None
        if isinstance(target, ast.Attribute) and ast.unparse(target.value) == node.name:
            node.body.append(ast.copy_location(ast.Assign([ast.Name(target.attr, ast.Store())], made.value), node))
            placed(node.body[-1], node)
        else:
            body.append(placed(made, node))
    return body


def _is_super_call(node: ast.expr) -> bool:
    return isinstance(node, ast.Call) and ast.unparse(node.func) == f"super().{_HOOK}"


class _OfClass(ast.NodeTransformer):
    """Writes a class for its parameter, and attributes that it inherits as those of the class that has them."""

    def __init__(self, parameter: str, line: list[ast.ClassDef]) -> None:
        self._parameter, self._line = parameter, line

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        if not isinstance(node.value, ast.Name) or node.value.id != self._parameter:
            self.generic_visit(node)
            return node
        if node.attr in ("__name__", "__qualname__"):
            return ast.copy_location(ast.Constant(self._line[0].name), node)
        owners = [each.name for each in self._line if any(_key(s) == node.attr for s in each.body)]
        is_stored = not isinstance(node.ctx, ast.Load)
        node.value.id = self._line[0].name if is_stored or not owners else owners[0]
        return node

    def visit_Name(self, node: ast.Name) -> ast.expr:
        return ast.copy_location(ast.Name(self._line[0].name, node.ctx), node) if node.id == self._parameter else node


def without_bases(tree: ast.Module) -> None:
    """Give the classes of a module, in place, what they inherit from bases that are classes of the module, too.

    What `super` means follows from the order of all classes around, so it is asked of the classes as they were written.
    """
    known: dict[str, ast.ClassDef] = {}
    written: dict[str, ast.ClassDef] = {}
    heirs: dict[str, list[str]] = {}
    made = {n.func.id for n in walk_tree(tree) if isinstance(n, ast.Call) and isinstance(n.func, ast.Name)}
    for node in tree.body:
        if not isinstance(node, ast.ClassDef):
            continue
        bases = [each.id for each in node.bases if isinstance(each, ast.Name) and each.id in known]
        is_known = len(bases) == len(node.bases) and not node.keywords
        written[node.name] = copy.deepcopy(node)
        if is_known and bases and all(_fits(node, known[each]) for each in bases):
            line = [copy.deepcopy(written[name]) for name in _line_of(node, written)]
            for cls, base in reversed([*itertools.pairwise(line)]):
                _inherit(cls, base)
            node.body, node.decorator_list = line[0].body, line[0].decorator_list
            for name in (each.name for each in line[1:]):
                heirs[name].append(node.name)
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


def _with_heirs(kind: ast.expr, heirs: dict[str, list[str]]) -> ast.expr:
    if not isinstance(kind, ast.Name) or not heirs.get(kind.id):
        return kind
    names = [kind.id, *heirs[kind.id]]
    kinds = ast.Tuple([ast.copy_location(ast.Name(name, ast.Load()), kind) for name in names], ast.Load())
    return ast.copy_location(kinds, kind)


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
    node.body.sort(key=lambda each: isinstance(each, ast.AnnAssign) and "kw_only=True" in ast.unparse(each))
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
        self._values: dict[str, str] = {}  # what the functions return, by name
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
            self._names[key] = name = free_name(stem, self._taken)
            text = f"def {name}({', '.join(['thing', *given])}):\n    raise TypeError('no such class')"
            self.made += ast.parse(text).body
            self._values[name] = value
            self.extend(self.made[-1], classes)
        return self._names[key]

    def extend(self, function: Any, classes: list[str]) -> bool:
        """Add classes to a function that chooses by them; returns whether it is one, and some of them are new."""
        if function.name not in self._values:
            return False
        known = {each.test.args[1].id for each in function.body[:-1]}
        tests = [
            ast.parse(f"if isinstance(thing, {each}):\n    return {self._values[function.name]}").body[0]
            for each in classes if each not in known
        ]  # fmt: skip
        function.body[-1:-1] = tests
        return bool(tests)

"""Classes that only describe, and what they describe, as plain Python: typed dictionaries, protocols, exceptions,
namespaces, and arguments that a function passes on by ``**``.
"""

from __future__ import annotations

import ast
import copy
from collections.abc import Iterable

from scenelang.interpreter.transpile.analysis.python_text import walk_tree
from scenelang.interpreter.transpile.analysis.rewriting import is_annotation, is_registered, name_of, parents_of

_EXCEPTIONS = (
    "Exception", "ValueError", "TypeError", "KeyError", "IndexError", "RuntimeError", "LookupError", "ArithmeticError",
    "AssertionError", "NotImplementedError",
)  # fmt: skip
_PROTOCOLS = ("Protocol", "typing.Protocol")
_KEYWORD_MARKERS = ("KW_ONLY", "dataclasses.KW_ONLY")  # annotation after which fields are passed by name
_CHECKED = ("runtime_checkable", "typing.runtime_checkable")


def with_plain_classes(tree: ast.Module) -> ast.Module:
    """Make the descriptions of a module plain, in place."""
    assigned = {n.attr for n in walk_tree(tree) if isinstance(n, ast.Attribute) and not isinstance(n.ctx, ast.Load)}
    for node in walk_tree(tree):
        if isinstance(node, ast.ClassDef):
            _write_aliases(node)
            _write_attributes(node, assigned)
            node.body = [each for each in node.body if not _is_keyword_marker(each)]
    _leave_out_aliases(tree)
    _leave_out_typed_dicts(tree)
    _leave_out_exceptions(tree)
    _name_classes_of_protocols(tree)
    name_rest(tree)
    _Namespaces(tree).write()
    return tree


def _is_called(node: ast.AST, name: str) -> bool:
    return isinstance(node, ast.Call) and ast.unparse(node.func).rpartition(".")[2] == name


def _is_protocol(base: ast.expr) -> bool:
    return ast.unparse(base.value if isinstance(base, ast.Subscript) else base) in _PROTOCOLS


def _is_keyword_marker(node: ast.stmt) -> bool:
    return isinstance(node, ast.AnnAssign) and ast.unparse(node.annotation) in _KEYWORD_MARKERS


def _replace_names(tree: ast.AST, known: dict[str, str]) -> None:
    for node in walk_tree(tree):
        if isinstance(node, ast.Name) and node.id in known:
            node.id = known[node.id]


# --- members --------------------------------------------------------------------------------------------------------


def _write_aliases(node: ast.ClassDef) -> None:
    """Copy methods that a class has by a second name, and write ``A, B = 1, 2`` as two assignments."""
    methods = {each.name: each for each in node.body if isinstance(each, ast.FunctionDef)}
    body: list[ast.stmt] = []
    for each in node.body:
        target = each.targets[0] if isinstance(each, ast.Assign) and len(each.targets) == 1 else None
        value = each.value if isinstance(each, ast.Assign) else None
        if isinstance(target, ast.Name) and isinstance(value, ast.Name) and value.id in methods:
            made = copy.deepcopy(methods[value.id])
            made.name = target.id
            body.append(made)
        elif isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple) and len(target.elts) == len(value.elts):
            pairs = zip(target.elts, value.elts)
            body += [ast.copy_location(ast.Assign([name], item), each) for name, item in pairs]
        else:
            body.append(each)
    node.body = body


def _write_attributes(node: ast.ClassDef, assigned: set[str]) -> None:
    """Write annotated attributes of a class that nobody assigns as plain ones, in place, unless they are fields."""
    bases = {ast.unparse(base).rpartition(".")[2] for base in node.bases}
    has_fields = any("dataclass" in ast.unparse(d) for d in node.decorator_list) or bases & {"NamedTuple", "TypedDict"}
    for n, each in enumerate(node.body):
        if not isinstance(each, ast.AnnAssign) or each.value is None or not isinstance(each.target, ast.Name):
            continue
        if each.target.id not in assigned and (not has_fields or "ClassVar" in ast.unparse(each.annotation)):
            node.body[n] = ast.copy_location(ast.Assign([each.target], each.value), each)


# --- classes --------------------------------------------------------------------------------------------------------


def _classes(tree: ast.Module) -> list[ast.ClassDef]:
    return [each for each in tree.body if isinstance(each, ast.ClassDef)]


def _leave_out(tree: ast.Module, names: Iterable[str]) -> None:
    gone = {*names}
    tree.body = [each for each in tree.body if not (isinstance(each, ast.ClassDef) and each.name in gone)]


_TYPES = ("tuple", "list", "dict", "set", "frozenset", "type", "Callable", "Optional", "Union", "Sequence", "Iterable")


def _leave_out_aliases(tree: ast.Module) -> None:
    """Leave out names for types, such as ``Cell = tuple[int, int]``, that only annotations use."""
    parents = parents_of(tree)
    for each in [*tree.body]:
        target = each.targets[0] if isinstance(each, ast.Assign) and len(each.targets) == 1 else None
        value = each.value if isinstance(each, ast.Assign) else None
        if not isinstance(target, ast.Name) or not isinstance(value, ast.Subscript):
            continue
        uses = [n for n in walk_tree(tree) if isinstance(n, ast.Name) and n.id == target.id and n is not target]
        if name_of(value.value) in _TYPES and all(is_annotation(n, parents) or _is_alias(n, parents) for n in uses):
            tree.body.remove(each)


def _is_alias(name: ast.AST, parents: dict[ast.AST, ast.AST]) -> bool:
    """Return whether a name is part of another alias."""
    while isinstance(parents.get(name), (ast.Subscript, ast.Tuple, ast.List)):
        name = parents[name]
    parent = parents.get(name)
    is_type = isinstance(name, ast.Subscript) and name_of(name.value) in _TYPES
    return is_type and isinstance(parent, ast.Assign) and isinstance(parents.get(parent), ast.Module)


def _leave_out_typed_dicts(tree: ast.Module) -> None:
    """Leave out the classes of dictionaries, which only annotations and calls for a dictionary name."""
    typed: set[str] = set()
    for each in _classes(tree):
        bases = {ast.unparse(base).rpartition(".")[2] for base in each.bases}
        if (
            bases
            and bases <= {"TypedDict", *typed}
            and all(isinstance(s, (ast.AnnAssign, ast.Expr, ast.Pass)) for s in each.body)
        ):
            typed.add(each.name)
    if not typed:
        return
    _leave_out(tree, typed)
    for node in walk_tree(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in typed:
            node.func.id = "dict"


def _leave_out_exceptions(tree: ast.Module) -> None:
    """Write an exception of the program that nobody catches by its name as the one that it is derived from."""
    caught = {
        n.id for each in walk_tree(tree) if isinstance(each, ast.ExceptHandler) and each.type is not None
        for n in walk_tree(each.type) if isinstance(n, ast.Name)
    }  # fmt: skip
    known: dict[str, str] = {}
    for each in _classes(tree):
        bases = [known.get(ast.unparse(base), ast.unparse(base)) for base in each.bases]
        is_plain = all(isinstance(s, (ast.Pass, ast.Expr)) for s in each.body) and not each.decorator_list
        if len(bases) == 1 and bases[0] in _EXCEPTIONS and is_plain and not caught & {each.name, *known}:
            known[each.name] = bases[0]
    if known:
        _leave_out(tree, known)
        _replace_names(tree, known)


def _name_classes_of_protocols(tree: ast.Module) -> None:
    """Write the classes that have the methods of a protocol in place of it in ``isinstance``."""
    classes = _classes(tree)
    for protocol in classes:
        if not any(map(_is_protocol, protocol.bases)) or not {ast.unparse(d) for d in protocol.decorator_list} & {
            *_CHECKED
        }:
            continue
        wanted = _members(protocol)
        fitting = [c.name for c in classes if c is not protocol and wanted and wanted <= _all_members(c, classes)]
        tests = [
            node for node in walk_tree(tree)
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "isinstance"
            and len(node.args) == 2 and isinstance(node.args[1], ast.Name) and node.args[1].id == protocol.name
        ]  # fmt: skip
        if fitting:
            for test in tests:
                names: list[ast.expr] = [ast.copy_location(ast.Name(name, ast.Load()), test) for name in fitting]
                test.args[1] = ast.copy_location(ast.Tuple(names, ast.Load()), test)
            protocol.decorator_list = []


def _members(node: ast.ClassDef) -> set[str]:
    names = {each.name for each in node.body if isinstance(each, ast.FunctionDef)}
    return names | {
        each.target.id for each in node.body if isinstance(each, ast.AnnAssign) and isinstance(each.target, ast.Name)
    }


def _all_members(node: ast.ClassDef, classes: list[ast.ClassDef]) -> set[str]:
    bases = {ast.unparse(base) for base in node.bases}
    inherited = [_all_members(each, classes) for each in classes if each.name in bases and each is not node]
    return _members(node).union(*inherited)


# --- arguments that are passed on -----------------------------------------------------------------------------------


def name_rest(tree: ast.Module) -> None:
    """Give functions that only pass ``**rest`` on the parameters by name that their calls pass."""
    for _ in range(4):  # such functions call each other
        functions = [n for n in walk_tree(tree) if isinstance(n, ast.FunctionDef) and n.args.kwarg is not None]
        if not any(_name_rest_of(tree, each) for each in functions):
            return


def _name_rest_of(tree: ast.Module, function: ast.FunctionDef) -> bool:
    rest = function.args.kwarg
    assert rest is not None
    if is_registered(function):
        return False
    parents = parents_of(tree)
    owner = parents.get(function)
    name = owner.name if function.name == "__init__" and isinstance(owner, ast.ClassDef) else function.name
    own_uses = [n for n in walk_tree(function) if isinstance(n, ast.Name) and n.id == rest.arg]
    passing = [
        n
        for n in walk_tree(function)
        if isinstance(n, ast.Call)
        for k in n.keywords
        if k.arg is None and k.value in own_uses
    ]
    uses = [
        n for n in walk_tree(tree)
        if (isinstance(n, ast.Name) and n.id == name) or (isinstance(n, ast.Attribute) and n.attr == name)
    ]  # fmt: skip
    calls = [parents[n] for n in uses if isinstance(parents.get(n), ast.Call) and parents[n].func is n]  # type: ignore[attr-defined]
    others = [n for n in uses if not (isinstance(parents.get(n), ast.Call) and parents[n].func is n)]  # type: ignore[attr-defined]
    definitions = [n for n in walk_tree(tree) if isinstance(n, ast.FunctionDef) and n.name == function.name]
    is_unique = len(definitions) == 1 or name != function.name
    has_heirs = name != function.name and any(
        name in {ast.unparse(base) for base in each.bases} for each in _classes(tree)
    )
    if len(passing) != len(own_uses) or not calls or others or not is_unique or has_heirs or len(passing) != 1:
        return False
    known = {each.arg for each in (*function.args.args, *function.args.kwonlyargs, *function.args.posonlyargs)}
    given = [[str(k.arg) for k in call.keywords if k.arg is not None and k.arg not in known] for call in calls]  # type: ignore[attr-defined]
    if any(k.arg is None for call in calls for k in call.keywords):  # type: ignore[attr-defined]
        return False
    names = list(dict.fromkeys(each for row in given for each in row))
    defaults: dict[str, ast.expr | None] = {}
    for each in names:
        called = passing[0].func.id if isinstance(passing[0].func, ast.Name) else ""
        first = function.args.args[0].arg if function.args.args and isinstance(owner, ast.ClassDef) else None
        called = owner.name if called == first and isinstance(owner, ast.ClassDef) else called
        default = None if all(each in row for row in given) else _default_of(tree, called, each)
        if isinstance(owner, ast.ClassDef) and isinstance(passing[0].func, ast.Attribute):  # a method of its own
            method = next((m for m in owner.body if getattr(m, "name", "") == passing[0].func.attr), None)
            default = _default_in(method, each) if isinstance(method, ast.FunctionDef) else default
        if default is None and not all(each in row for row in given):
            return False
        defaults[each] = default
    function.args.kwarg = None
    for each in names:
        function.args.kwonlyargs.append(ast.copy_location(ast.arg(each), rest))
        function.args.kw_defaults.append(copy.deepcopy(defaults[each]))
    call = passing[0]
    call.keywords = [k for k in call.keywords if k.arg is not None]
    call.keywords += [
        ast.copy_location(ast.keyword(each, ast.copy_location(ast.Name(each, ast.Load()), call)), call)
        for each in names
    ]
    return True


def _default_of(tree: ast.Module, called: str, name: str) -> ast.expr | None:
    """Return the constant default of a parameter, or of a field, of a function or class."""
    for each in tree.body:
        if isinstance(each, ast.ClassDef) and each.name == called:
            for field in each.body:
                if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name) and field.target.id == name:
                    return field.value if field.value is not None and _is_constant(field.value) else None
            init = next((m for m in each.body if isinstance(m, ast.FunctionDef) and m.name == "__init__"), None)
            return _default_in(init, name) if init is not None else None
        if isinstance(each, ast.FunctionDef) and each.name == called:
            return _default_in(each, name)
    return None


def _default_in(function: ast.FunctionDef, name: str) -> ast.expr | None:
    given = function.args
    plain = [*given.posonlyargs, *given.args]
    defaults = dict(zip([a.arg for a in plain[len(plain) - len(given.defaults) :]], given.defaults))
    defaults |= {a.arg: d for a, d in zip(given.kwonlyargs, given.kw_defaults) if d is not None}
    default = defaults.get(name)
    return default if default is not None and _is_constant(default) else None


def _is_constant(node: ast.expr) -> bool:
    return all(isinstance(n, (ast.Constant, ast.Tuple, ast.UnaryOp, ast.USub, ast.Load)) for n in walk_tree(node))


# --- namespaces -----------------------------------------------------------------------------------------------------


class _Namespaces:
    """Writes variables that hold a ``SimpleNamespace``, and of which only attributes are used, as dictionaries."""

    def __init__(self, tree: ast.Module) -> None:
        self._tree = tree
        self._parents = parents_of(tree)

    def write(self) -> None:
        """Write them, in place."""
        for node in walk_tree(self._tree):
            if not isinstance(node, ast.Assign) or not _is_called(node.value, "SimpleNamespace"):
                continue
            target = node.targets[0]
            if isinstance(target, ast.Name) and len(node.targets) == 1 and isinstance(node.value, ast.Call):
                self._write(node.value, target)

    def _write(self, call: ast.Call, target: ast.Name) -> None:
        """Write a namespace as a dictionary and its attributes as items, unless the variable has other uses."""
        scope: ast.AST = target
        while not isinstance(scope, (ast.FunctionDef, ast.Module)):
            scope = self._parents[scope]
        uses = [n for n in walk_tree(scope) if isinstance(n, ast.Name) and n.id == target.id and n is not target]
        owners = [self._parents[n] for n in uses]
        is_parameter = any(isinstance(n, ast.arg) and n.arg == target.id for n in walk_tree(scope))
        if call.args or is_parameter or not all(isinstance(each, ast.Attribute) for each in owners):
            return
        call.func = ast.copy_location(ast.Name("dict", ast.Load()), call.func)
        for each in owners:
            assert isinstance(each, ast.Attribute)
            key = ast.copy_location(ast.Constant(each.attr), each)
            item = ast.copy_location(ast.Subscript(each.value, key, each.ctx), each)
            parent = self._parents[each]
            for name, value in ast.iter_fields(parent):
                if value is each:
                    setattr(parent, name, item)
                elif isinstance(value, list):
                    value[:] = [item if part is each else part for part in value]

"""Enumerations as what the translation knows: members are constants, of a frozen data class or plain numbers and texts.

Members that are numbers or texts themselves (`IntEnum`, `Flag`, `StrEnum`) become these, unless the program asks them
for more than their values. An enumeration that does anything else stays as it is, and is an error of the translation.
"""

from __future__ import annotations

import ast
import copy
import re
from collections.abc import Iterator
from dataclasses import dataclass, field

from scenelang.interpreter.transpile.analysis.python_text import walk_tree
from scenelang.interpreter.transpile.analysis.rewriting import Substitution, is_annotation, name_of, parents_of, placed

_BASES = ("Enum", "IntEnum", "StrEnum", "Flag", "IntFlag", "ReprEnum")
_TAKERS = ("list", "tuple", "sorted", "enumerate", "len", "zip", "set", "reversed", "iter", "cycle", "min", "max")


@dataclass
class _Enumeration:
    """Enumeration of a program; ``members`` are the expressions of their values by name."""

    node: ast.ClassDef
    kinds: set[str]
    members: dict[str, ast.expr] = field(default_factory=dict)
    methods: list[ast.FunctionDef] = field(default_factory=list)
    is_plain: bool = False

    @property
    def stem(self) -> str:
        return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", self.node.name)

    def constant(self, member: str) -> str:
        return f"{self.stem}_{member}".upper()

    @property
    def everything(self) -> str:
        return f"{self.stem}_MEMBERS".upper()

    @property
    def by_name(self) -> str:
        return f"{self.stem}_BY_NAME".upper()

    @property
    def finder(self) -> str:
        return f"{self.stem}_of".lower()


def without_enumerations(tree: ast.Module) -> ast.Module:
    """Write the enumerations of a module, in place, as constants."""
    classes = [each for each in tree.body if isinstance(each, ast.ClassDef)]
    enumerations = {each.name: made for each in classes if (made := _enumeration(each))}
    if not enumerations:
        return tree
    parents = parents_of(tree)
    names = {n.id for n in walk_tree(tree) if isinstance(n, ast.Name)}
    used = {n.attr for n in walk_tree(tree) if isinstance(n, ast.Attribute)}
    for name, each in [*enumerations.items()]:
        _decide(each, tree, used)
        new = {each.everything, each.finder, each.by_name, *map(each.constant, each.members)}
        nodes = [n for n in walk_tree(tree) if isinstance(n, ast.Name) and n.id == name]
        if new & names or not all(_is_understood(n, each, parents) for n in nodes):
            del enumerations[name]
    for each in enumerations.values():
        _bind_classes(each)
    uses = _Uses(enumerations)
    tree = uses.visit(tree)
    body: list[ast.stmt] = []
    for statement in tree.body:
        made = enumerations.get(statement.name) if isinstance(statement, ast.ClassDef) else None
        body += [statement] if made is None else _written(made, uses)
    tree.body = body
    return tree


def is_enumeration(node: ast.ClassDef) -> bool:
    """Return whether a class stands for an enumeration, each of whose members there is once."""
    return bool(node.__dict__.get("is_enumeration"))


def is_its_value(node: ast.ClassDef) -> bool:
    """Return whether members of an enumeration are numbers or texts, as those of ``StrEnum``."""
    return bool(node.__dict__.get("has_value"))


def _kinds(node: ast.ClassDef) -> set[str]:
    return {ast.unparse(base).rpartition(".")[2] for base in node.bases}


def _enumeration(node: ast.ClassDef) -> _Enumeration | None:
    """Return the members of a class that is an enumeration of a simple form, else None."""
    kinds = _kinds(node)
    decorators = {ast.unparse(each).rpartition(".")[2] for each in node.decorator_list}
    if not kinds & {*_BASES} or node.keywords or kinds - {*_BASES, "int", "str"} or decorators - {"unique"}:
        return None
    enumeration = _Enumeration(node, kinds)
    last = 0
    for each in node.body:
        if isinstance(each, ast.FunctionDef) and (not each.name.startswith("__") or each.name == "__init__"):
            enumeration.methods.append(each)
            continue
        if isinstance(each, ast.Pass) or (isinstance(each, ast.Expr) and isinstance(each.value, ast.Constant)):
            continue
        target = each.targets[0] if isinstance(each, ast.Assign) and len(each.targets) == 1 else None
        if not isinstance(each, ast.Assign) or not isinstance(target, ast.Name) or target.id.startswith("_"):
            return None
        value: ast.expr = Substitution(enumeration.members).visit(copy.deepcopy(each.value))
        if isinstance(value, ast.Call) and ast.unparse(value.func).rpartition(".")[2] == "auto":
            following = last + 1 if not kinds & {"Flag", "IntFlag"} else 1 << last.bit_length()
            value = ast.copy_location(ast.Constant(target.id.lower() if "StrEnum" in kinds else following), value)
        if isinstance(value, ast.Constant) and type(value.value) is int:
            last = value.value
        enumeration.members[target.id] = value
    for each in enumeration.methods:
        if each.name == "__init__":
            each.body = [part for statement in each.body for part in _one_by_one(statement)]
    texts = [ast.unparse(each) for each in enumeration.members.values()]
    if any(each.name == "__init__" and not _is_simple(each, enumeration) for each in enumeration.methods):
        return None
    return enumeration if texts and len(set(texts)) == len(texts) else None  # no aliases


def _decide(enumeration: _Enumeration, tree: ast.Module, used: set[str]) -> None:
    """Decide whether members are plain numbers or texts."""
    is_value = bool(enumeration.kinds & {"IntEnum", "StrEnum", "Flag", "IntFlag", "int", "str"})
    asked = {"name", "bit_count"} & used
    enumeration.is_plain = is_value and not enumeration.methods and not asked and not _is_told(enumeration, tree)


def _is_told(enumeration: _Enumeration, tree: ast.Module) -> bool:
    """Return whether a text may contain a member, which it names where its class is not ``IntEnum`` or ``StrEnum``."""
    if enumeration.kinds & {"IntEnum", "StrEnum"}:
        return False
    nodes = walk_tree(tree)
    told = {name_of(n.value) for n in nodes if isinstance(n, ast.FormattedValue)}
    told |= {
        name_of(each)
        for n in nodes
        if isinstance(n, ast.Call) and isinstance(n.func, ast.Name) and n.func.id in ("str", "repr", "format")
        for each in n.args
    }
    return bool(told & ({n.arg for n in nodes if isinstance(n, ast.arg)} | _holders(enumeration, nodes)))


def _holders(enumeration: _Enumeration, nodes: list[ast.AST]) -> set[str]:
    """Return the variables that are assigned from what names the enumeration."""
    names: set[str] = set()
    for each in nodes:
        value = getattr(each, "value", getattr(each, "iter", None))
        if isinstance(each, (ast.Assign, ast.AnnAssign, ast.For, ast.comprehension)) and value is not None:
            if any(isinstance(n, ast.Name) and n.id == enumeration.node.name for n in walk_tree(value)):
                targets = each.targets if isinstance(each, ast.Assign) else [each.target]
                names |= {n.id for target in targets for n in walk_tree(target) if isinstance(n, ast.Name)}
    return names


def _is_understood(node: ast.Name, enumeration: _Enumeration, parents: dict[ast.AST, ast.AST]) -> bool:
    """Return whether the name of an enumeration stands where it is known what becomes of it."""
    parent = parents.get(node)
    if isinstance(parent, ast.Attribute):
        return parent.attr in enumeration.members or parent.attr in {each.name for each in enumeration.methods}
    if isinstance(parent, ast.Call):
        if node is parent.func:
            return len(parent.args) == 1 and not parent.keywords and not isinstance(parent.args[0], ast.Starred)
        function = ast.unparse(parent.func).rpartition(".")[2]
        return function in (*_TAKERS, "choice", "sample", "choices") or (
            function == "isinstance" and not enumeration.is_plain
        )
    if isinstance(parent, ast.Subscript) and node is parent.value:
        is_member = not isinstance(parent.slice, ast.Constant) or parent.slice.value in enumeration.members
        return is_member or is_annotation(node, parents)
    is_iterated = isinstance(parent, (ast.For, ast.comprehension)) and node is parent.iter
    return is_iterated or isinstance(parent, ast.Starred) or is_annotation(node, parents)


def _bind_classes(enumeration: _Enumeration) -> None:
    """Write the name of the class for ``cls`` in class methods."""
    for method in enumeration.methods:
        if any(ast.unparse(each) == "classmethod" for each in method.decorator_list) and method.args.args:
            cls = method.args.args.pop(0).arg
            method.decorator_list = [ast.copy_location(ast.Name("staticmethod", ast.Load()), method)]
            for each in walk_tree(method):
                if isinstance(each, ast.Name) and each.id == cls:
                    each.id = enumeration.node.name


class _Uses(ast.NodeTransformer):
    """Replaces members by constants; ``listed``, ``searched`` and ``named`` are the enumerations that need more."""

    def __init__(self, enumerations: dict[str, _Enumeration]) -> None:
        self._enumerations = enumerations
        self.listed: set[str] = set()
        self.searched: set[str] = set()
        self.named: set[str] = set()
        self._constants = {each.constant(m) for each in enumerations.values() for m in each.members}

    def _of(self, node: ast.AST) -> _Enumeration | None:
        return self._enumerations.get(node.id) if isinstance(node, ast.Name) else None

    def visit_arg(self, node: ast.arg) -> ast.arg:
        return node  # annotations stay

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.FunctionDef:
        returns, node.returns = node.returns, None
        self.generic_visit(node)
        node.returns = returns
        return node

    def visit_AnnAssign(self, node: ast.AnnAssign) -> ast.AnnAssign:
        if node.value is not None:
            node.value = self.visit(node.value)
        return node

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        enumeration = self._of(node.value)
        if enumeration is not None and node.attr in enumeration.members:
            return ast.copy_location(ast.Name(enumeration.constant(node.attr), ast.Load()), node)
        if enumeration is not None:
            return node  # a method of the class
        self.generic_visit(node)
        return node

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        enumeration = self._of(node.value)
        if enumeration is not None and isinstance(node.slice, ast.Constant) and node.slice.value in enumeration.members:
            return ast.copy_location(ast.Name(enumeration.constant(str(node.slice.value)), ast.Load()), node)
        if enumeration is not None:
            self.named.add(enumeration.node.name)
            table = ast.copy_location(ast.Name(enumeration.by_name, ast.Load()), node)
            return ast.copy_location(ast.Subscript(table, self.visit(node.slice), ast.Load()), node)
        self.generic_visit(node)
        return node

    def visit_Call(self, node: ast.Call) -> ast.expr:
        enumeration = self._of(node.func)
        if enumeration is not None and enumeration.is_plain and enumeration.kinds & {"Flag", "IntFlag"}:
            return self.visit(node.args[0])  # type: ignore[no-any-return]
        if enumeration is not None:
            self.searched.add(enumeration.node.name)
            node.func = ast.copy_location(ast.Name(enumeration.finder, ast.Load()), node.func)
        if isinstance(node.func, ast.Name) and node.func.id == "isinstance":
            node.args[:1] = [self.visit(each) for each in node.args[:1]]
            return node
        self.generic_visit(node)
        return node

    def visit_Name(self, node: ast.Name) -> ast.expr:
        enumeration = self._of(node)
        if enumeration is None:
            return node
        self.listed.add(enumeration.node.name)
        return ast.copy_location(ast.Name(enumeration.everything, ast.Load()), node)

    def visit_Compare(self, node: ast.Compare) -> ast.expr:
        self.generic_visit(node)
        for n, (operation, value) in enumerate(zip(node.ops, node.comparators)):
            left = node.left if n == 0 else node.comparators[n - 1]
            is_member = any(isinstance(each, ast.Name) and each.id in self._constants for each in (left, value))
            if is_member and isinstance(operation, (ast.Is, ast.IsNot)):
                node.ops[n] = ast.Eq() if isinstance(operation, ast.Is) else ast.NotEq()
        return node


def _written(enumeration: _Enumeration, uses: _Uses) -> list[ast.stmt]:
    """Return the statements in place of the class of an enumeration."""
    node = enumeration.node
    body: list[ast.stmt] = []
    init = next((each for each in enumeration.methods if each.name == "__init__"), None)
    if not enumeration.is_plain:
        fields = "".join(f"\n    {name}: object" for name in ("name", "value", *_fields_of(init)))
        made = ast.parse(f"@dataclass(frozen=True)\nclass {node.name}:{fields}").body[0]
        assert isinstance(made, ast.ClassDef)
        placed(made, node, is_new=True)
        made.__dict__["is_enumeration"] = True
        made.__dict__["has_value"] = bool(enumeration.kinds & {"IntEnum", "StrEnum", "int", "str"})
        made.body += [uses.visit(each) for each in enumeration.methods if each.name != "__init__"]
        body.append(made)
    for name, value in enumeration.members.items():
        value = uses.visit(value)
        if not enumeration.is_plain:
            values = [value] if init is None else [value, *_values_of(init, value)]
            call = ast.Call(ast.Name(node.name, ast.Load()), [ast.Constant(name), *values], [])
            value = call
        body.append(ast.Assign([ast.Name(enumeration.constant(name), ast.Store())], value))
    everything = ", ".join(map(enumeration.constant, enumeration.members))
    if node.name in uses.listed | uses.searched:
        body += ast.parse(f"{enumeration.everything} = [{everything}]").body
    if node.name in uses.searched:
        test = "each == value" if enumeration.is_plain else "each.value == value"
        body += ast.parse(
            f"def {enumeration.finder}(value):\n    for each in {enumeration.everything}:\n        if {test}:\n"
            f"            return each\n    raise ValueError(value)"
        ).body
    if node.name in uses.named:
        rows = ", ".join(f"{name!r}: {enumeration.constant(name)}" for name in enumeration.members)
        body += ast.parse(f"{enumeration.by_name} = {{{rows}}}").body
    for each in body[len(enumeration.members) + (not enumeration.is_plain) :]:
        placed(each, node, is_new=True)
    for each in body:
        placed(each, node)
    return body


def _one_by_one(statement: ast.stmt) -> list[ast.stmt]:
    """Return ``a, b = c, d`` as two assignments."""
    target = statement.targets[0] if isinstance(statement, ast.Assign) else None
    if not isinstance(statement, ast.Assign) or not isinstance(target, ast.Tuple):
        return [statement]
    if not isinstance(statement.value, ast.Tuple) or len(statement.value.elts) != len(target.elts):
        return [statement]
    return [ast.copy_location(ast.Assign([t], v), statement) for t, v in zip(target.elts, statement.value.elts)]


def _is_simple(init: ast.FunctionDef, enumeration: _Enumeration) -> bool:
    """Return whether a constructor only assigns attributes from its parameters."""
    own, *parameters = [each.arg for each in init.args.args]
    count = len(parameters)
    fits = all(count == 1 or (isinstance(v, ast.Tuple) and len(v.elts) == count) for v in enumeration.members.values())
    return fits and not init.args.defaults and not init.args.vararg and all(
        isinstance(each, ast.Assign) and len(each.targets) == 1 and isinstance(each.targets[0], ast.Attribute)
        and not any(isinstance(n, ast.Name) and n.id == own for n in walk_tree(each.value))
        for each in init.body
    )  # fmt: skip


def _fields_of(init: ast.FunctionDef | None) -> list[str]:
    return [each.targets[0].attr for each in _assignments(init)] if init is not None else []  # type: ignore[attr-defined]


def _assignments(init: ast.FunctionDef) -> Iterator[ast.Assign]:
    return (each for each in init.body if isinstance(each, ast.Assign))


def _values_of(init: ast.FunctionDef, value: ast.expr) -> list[ast.expr]:
    """Return what the constructor of a member assigns."""
    parameters = [each.arg for each in init.args.args[1:]]
    given = value.elts if isinstance(value, ast.Tuple) and len(parameters) != 1 else [value]
    known = dict(zip(parameters, given))
    return [Substitution(known).visit(copy.deepcopy(each.value)) for each in _assignments(init)]

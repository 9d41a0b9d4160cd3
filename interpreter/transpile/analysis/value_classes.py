"""Classes whose instances are values, as tuples: named tuples and data classes that are keys, members, or ordered.

The language compares records that are keys by identity, and has no order of them; Python compares such instances as
their fields. A class becomes tuples only where the type of each of its instances is known.
"""

from __future__ import annotations

import ast
import copy
from collections.abc import Callable, Iterable

from scenelang.interpreter.transpile.analysis.enumerations import is_enumeration
from scenelang.interpreter.transpile.analysis.inference import (
    DICT,
    NONE,
    NOTHING,
    RECORD,
    SET,
    TUPLE,
    UNKNOWN,
    AbstractType,
    TypeFacts,
)
from scenelang.interpreter.transpile.analysis.python_text import walk_tree
from scenelang.interpreter.transpile.analysis.rewriting import free_name, is_annotation, names_in, parents_of, placed
from scenelang.interpreter.transpile.analysis.scopes import Class

_SORTING = ("sorted", "min", "max", "sort")
_MAX_ITEM_DEPTH = 3  # lists in lists whose items are looked at


def compares_fields(record: Class) -> bool:
    """Return whether Python compares the instances of a class by their fields."""
    decorators = [ast.unparse(d).replace(" ", "") for d in record.node.decorator_list]
    is_data = record.is_dataclass and not any("eq=False" in d for d in decorators)
    return is_data or "__eq__" in record.methods or _is_named_tuple(record)


def classes_compared_by_value(value: AbstractType, depth: int = _MAX_ITEM_DEPTH) -> list[Class]:
    """Return the classes of what a value is, or contains, that have no identity in Python."""
    classes = [c for c in value.classes if compares_fields(c) and not is_enumeration(c.node)]
    classes = classes if value.kinds & RECORD else []
    for each in [site.element for site in value.sites] if depth else []:
        classes += classes_compared_by_value(each, depth - 1)
    return classes


def keys_in(facts: TypeFacts) -> Iterable[tuple[ast.AST, AbstractType]]:
    """Iterate over the places that make tables and sets, with the types of their keys or members."""
    sites = {site for value in facts.types.values() for site in value.sites}
    for site in sorted(sites, key=lambda each: (getattr(each.node, "lineno", 0), getattr(each.node, "col_offset", 0))):
        yield site.node, site.key if site.kind == DICT else site.element if site.kind == SET else NOTHING


def values_of(tree: ast.Module, facts: TypeFacts) -> Values | None:
    """Return what writes the classes whose instances are values as tuples, None if there are no such classes."""
    classes = {c for _, keys in keys_in(facts) for c in classes_compared_by_value(keys)}
    classes |= {c for node in walk_tree(tree) for c in _ordered(node, facts)}
    parents = parents_of(tree)
    by_name = {c.name: c for c in classes if _is_simple(c)}
    known = Values(by_name, facts.type, names_in(tree))
    while True:
        wrong = {
            name for node in walk_tree(tree) for name in known.classes_at(node) if not known.fits(node, parents)
        }  # fmt: skip
        if not wrong:
            break
        for name in wrong:
            by_name.pop(name, None)
    return known if by_name else None


def _is_named_tuple(record: Class) -> bool:
    return any("NamedTuple" in ast.unparse(base) for base in record.node.bases)


def _ordered(node: ast.AST, facts: TypeFacts) -> list[Class]:
    """Return the named tuples that a node orders, takes an item of, or compares with a tuple."""
    operands: list[AbstractType] = []
    if isinstance(node, ast.Subscript) and isinstance(node.ctx, ast.Load):
        operands = [facts.type(node.value)]
    elif isinstance(node, ast.Compare):
        types = [facts.type(each) for each in (node.left, *node.comparators)]
        is_ordered = any(isinstance(each, (ast.Lt, ast.LtE, ast.Gt, ast.GtE)) for each in node.ops)
        operands = types if is_ordered or any(each.kinds & TUPLE for each in types) else []
    elif isinstance(node, ast.Call) and not any(k.arg == "key" for k in node.keywords):
        name = ast.unparse(node.func).rpartition(".")[2]
        given = node.args or ([node.func.value] if isinstance(node.func, ast.Attribute) else [])
        types = [facts.type(each) for each in given] if name in _SORTING else []
        operands = [*types, *(site.element for each in types for site in each.sites)]
    return [c for each in operands if each.kinds & RECORD for c in each.classes if _is_named_tuple(c)]


def _is_simple(record: Class) -> bool:
    """Return whether a class has fields that its constructor takes, and methods; the rest of it is not known."""
    node = record.node
    special = {name for name in record.methods if name.startswith("__")}
    has_other = special or record.constants or node.keywords or not record.fields or not record.is_dataclass
    bases = [base for base in node.bases if "NamedTuple" not in ast.unparse(base)]
    decorators = " ".join(map(ast.unparse, node.decorator_list))
    is_value = _is_named_tuple(record) or "frozen=True" in decorators
    defaults = [default for _, default in record.fields if default is not None]
    is_constant = all(
        isinstance(n, (ast.Constant, ast.Tuple, ast.Load, ast.UnaryOp, ast.USub))
        for d in defaults
        for n in walk_tree(d)
    )
    is_plain = "order=" not in decorators and "eq=" not in decorators and "kw_only" not in decorators
    return not has_other and not bases and is_value and is_plain and is_constant


class Values(ast.NodeTransformer):
    """Writes instances of some classes as tuples of their fields."""

    def __init__(self, classes: dict[str, Class], type_of: Callable[[ast.expr], AbstractType], taken: set[str]) -> None:
        self._classes, self._type, self._taken = classes, type_of, taken
        self._functions: dict[tuple[str, str], str] = {}  # names of those that methods become

    def _class_of(self, node: ast.expr) -> Class | None:
        """Return the class of which an expression is an instance, if there is only one."""
        value = self._type(node)
        is_known = not value.kinds & ~(RECORD | NONE | UNKNOWN) and len(value.classes) == 1
        only = value.classes[0] if is_known else None
        return only if only is not None and self._classes.get(only.name) is only else None

    def _names(self, value: AbstractType) -> set[str]:
        is_instance = bool(value.kinds & RECORD)
        return {c.name for c in value.classes if is_instance and self._classes.get(c.name) is c}

    def classes_at(self, node: ast.AST) -> set[str]:
        """Return the names of the classes that matter where a node is."""
        if isinstance(node, ast.Name):
            return {node.id} & {*self._classes}
        if isinstance(node, ast.Attribute):
            untyped = not self._type(node.value).kinds & ~UNKNOWN
            fields = {n for n, c in self._classes.items() if node.attr in (*dict(c.fields), *c.methods)}
            return self._names(self._type(node.value)) | (fields if untyped else set())
        if isinstance(node, ast.Compare):  # an instance of one class is no tuple, and none of another class
            types = [self._type(each) for each in (node.left, *node.comparators)]
            return {name for each in types for name in self._names(each)}
        if isinstance(node, ast.Call) and ast.unparse(node.func) in (
            "str",
            "repr",
            "type",
            "len",
            "hash",
            "isinstance",
        ):
            return {name for each in node.args for name in self._names(self._type(each))}
        if isinstance(node, ast.FormattedValue):
            return self._names(self._type(node.value))
        return set()

    def fits(self, node: ast.AST, parents: dict[ast.AST, ast.AST]) -> bool:
        """Return whether it is known how to write a node at which some of the classes matter."""
        if isinstance(node, ast.Attribute):
            record = self._class_of(node.value)
            if record is None or not isinstance(node.ctx, ast.Load):
                return False
            if node.attr in record.methods and node.attr not in record.properties:
                parent = parents.get(node)
                return isinstance(parent, ast.Call) and parent.func is node
            return node.attr in (*dict(record.fields), *record.properties)
        if isinstance(node, ast.Name):
            parent = parents.get(node)
            if isinstance(parent, ast.Call) and parent.func is node:
                return self._arguments(self._classes[node.id], parent) is not None
            is_static = isinstance(parent, ast.Attribute) and parent.attr in self._classes[node.id].methods
            return is_static or is_annotation(node, parents)
        if isinstance(node, ast.Compare):
            types = [self._type(each) for each in (node.left, *node.comparators)]
            named = [c for each in types for c in each.classes if c.name in self._classes]
            is_tuple = any(each.kinds & TUPLE for each in types)
            is_one = len({*named}) == 1 and not (is_tuple and not _is_named_tuple(named[0]))
            is_same = any(isinstance(op, (ast.Is, ast.IsNot)) for op in node.ops)
            return (is_one and not is_same) or _asks_none(node)
        name = ast.unparse(node.func) if isinstance(node, ast.Call) else ""
        return name == "len" and all(map(_is_named_tuple, self._classes.values()))

    def _arguments(self, record: Class, call: ast.Call) -> list[ast.expr] | None:
        """Return the values of the fields in a call of the class, None for a call that is not understood."""
        names = [name for name, _ in record.fields]
        if any(isinstance(each, ast.Starred) for each in call.args) or len(call.args) > len(names):
            if len(call.args) == 1 and isinstance(call.args[0], ast.Starred) and not call.keywords:
                return call.args if _is_named_tuple(record) else None
            return None
        given = dict(zip(names, call.args)) | {str(k.arg): k.value for k in call.keywords}
        defaults = {name: copy.deepcopy(default) for name, default in record.fields if default is not None}
        is_in_order = [name for name in names if name in given] == [*given]
        if not {*given} <= {*names} or not {*names} <= {*given, *defaults}:
            return None
        if not is_in_order and any(isinstance(n, ast.Call) for each in given.values() for n in walk_tree(each)):
            return None  # whose order matters
        return [given.get(name) or defaults[name] for name in names]

    def visit_Call(self, node: ast.Call) -> ast.expr:
        """Write the call of a class as a tuple, and that of a method as one of a function."""
        record = self._classes.get(node.func.id) if isinstance(node.func, ast.Name) else None
        if record is not None:
            given = self._arguments(record, node)
            assert given is not None
            values: list[ast.expr] = [self.visit(each) for each in given]
            if len(values) == 1 and isinstance(values[0], ast.Starred):
                return placed(ast.Call(ast.Name("tuple", ast.Load()), [values[0].value], []), node)
            return placed(ast.Tuple(values, ast.Load()), node)
        function = node.func
        if isinstance(function, ast.Attribute):
            static = self._classes.get(function.value.id) if isinstance(function.value, ast.Name) else None
            record = static or self._class_of(function.value)
            if record is not None and function.attr in record.methods and function.attr not in record.properties:
                own = record.methods[function.attr].is_static
                owner = [] if own else [self.visit(function.value)]
                name = ast.copy_location(ast.Name(self._function(record, function.attr), ast.Load()), function)
                node.func, node.args = name, [*owner, *(self.visit(each) for each in node.args)]
                node.keywords = [self.visit(each) for each in node.keywords]
                return node
        self.generic_visit(node)
        return node

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        record = self._class_of(node.value)
        self.generic_visit(node)
        if record is None:
            return node
        if node.attr in record.properties:
            function = ast.Name(self._function(record, node.attr), ast.Load())
            return placed(ast.Call(function, [node.value], []), node)
        index = [name for name, _ in record.fields].index(node.attr)
        return placed(ast.Subscript(node.value, ast.Constant(index), ast.Load()), node)

    def _function(self, record: Class, method: str) -> str:
        key = (record.name, method)
        if key not in self._functions:
            self._functions[key] = free_name(f"{record.name}_{method}".lower(), self._taken)
        return self._functions[key]

    def visit_Module(self, node: ast.Module) -> ast.Module:
        self.generic_visit(node)
        node.body = self._with_functions(node.body)
        return node

    def _with_functions(self, body: list[ast.stmt]) -> list[ast.stmt]:
        """Return statements with the methods of the classes as functions."""
        made: list[ast.stmt] = []
        for each in body:
            record = self._classes.get(each.name) if isinstance(each, ast.ClassDef) else None
            if record is None:
                made.append(each)
                continue
            for method in each.body if isinstance(each, ast.ClassDef) else ():
                if isinstance(method, ast.FunctionDef):
                    method.name, method.decorator_list = self._function(record, method.name), []
                    made.append(method)
        return made


def _asks_none(node: ast.Compare) -> bool:
    """Return whether a comparison only asks whether there is a value."""
    return all(isinstance(each, ast.Constant) and each.value is None for each in node.comparators)

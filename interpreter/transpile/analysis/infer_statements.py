"""Inference through statements: the flow of a function, and what tests say about variables."""

from __future__ import annotations

import ast
from collections.abc import Sequence

from scenelang.interpreter.transpile.analysis.domain import (
    ANYTHING,
    ARRAY,
    BOOL,
    DICT,
    FLOAT,
    FUNCTION,
    INT,
    LIST,
    NONE,
    NOTHING,
    NUMBERS,
    POSE,
    RECORD,
    SET,
    SHAPE,
    STR,
    T_NONE,
    T_SHAPE,
    TUPLE,
    UNKNOWN,
    Type,
)
from scenelang.interpreter.transpile.analysis.infer_expressions import ExpressionInference
from scenelang.interpreter.transpile.analysis.inference import (
    CHANGES,
    Environment,
    constant_index,
)
from scenelang.interpreter.transpile.analysis.paths import Paths, is_annotation
from scenelang.interpreter.transpile.analysis.syntax import is_none

_DEEPEST_LOOPS = 5


class StatementInference(ExpressionInference):
    """Looks at statements."""

    def block(self, body: Sequence[ast.stmt]) -> None:
        for statement in body:
            if self.env is None:
                self.env = {}  # unreachable; looked at all the same
                for rest in body[body.index(statement) :]:
                    self.statement(rest)
                self.env = None
                return
            self.statement(statement)

    def statement(self, node: ast.stmt) -> None:
        handler = getattr(self, f"_{type(node).__name__}", None)
        if handler is not None:
            handler(node)

    def _Expr(self, node: ast.Expr) -> None:
        self.expression(node.value)

    def _Assign(self, node: ast.Assign) -> None:
        if is_annotation(self.paths, node.value):
            return
        value = self.expression(node.value)
        for target in node.targets:
            self.assign(target, value)

    def _AnnAssign(self, node: ast.AnnAssign) -> None:
        if node.value is not None:
            self.assign(node.target, self.expression(node.value))

    def _AugAssign(self, node: ast.AugAssign) -> None:
        value = self.expression(node.value)
        old = self._target_value(node.target)
        if isinstance(node.op, ast.Add) and old.kinds & LIST:
            self.mutated(old, self.elements(value), node=node)
            if value.only(SHAPE):
                old = old | T_SHAPE
            self.facts.types[node] = old
            self.assign(node.target, old)
            return
        result = self.operation(node, node.op, old, value)
        if old.kinds & ARRAY:
            self.mutated(old, self.elements(result) if old.only(ARRAY) else NOTHING, node=node)
            if old.only(ARRAY):  # the array itself changes
                result = old
        self.facts.types[node] = result
        self.assign(node.target, result)

    def _target_value(self, target: ast.expr) -> Type:
        if isinstance(target, ast.Name):
            variable = self.names.variables.get(target)
            found = self.load(variable) if variable is not None else ANYTHING
        elif isinstance(target, ast.Subscript):
            found = self.subscript(target, self.expression(target.value), target.slice)
        elif isinstance(target, ast.Attribute):
            found = self.attribute(target, self.expression(target.value))
        else:
            found = ANYTHING
        self.facts.types[target] = found
        return found

    def assign(self, target: ast.expr, value: Type) -> None:
        if isinstance(target, ast.Name):
            variable = self.names.variables.get(target)
            if variable is not None:
                if variable.function is not self.function:
                    self.effect(target, CHANGES)
                self.store(variable, value)
            self.facts.types[target] = value
        elif isinstance(target, (ast.Tuple, ast.List)):
            self._unpack(target.elts, value, target)
        elif isinstance(target, ast.Starred):
            self.assign(target.value, value)
        elif isinstance(target, ast.Subscript):
            container = self.expression(target.value)
            key = self.expression(target.slice)
            is_slice = isinstance(target.slice, ast.Slice)
            for site in container.sites:
                if site.kind == DICT and isinstance(target.slice, ast.Constant):
                    self.table(site, key, value, {target.slice.value: value}, NOTHING)
                elif site.kind == DICT:
                    self.table(site, key, value, {}, value)
            self.mutated(
                container, self.elements(value) if is_slice else value, key, target, constant_index(target.slice)
            )
        elif isinstance(target, ast.Attribute):
            owner = self.expression(target.value)
            for record in owner.classes:
                self.set_field(record, target.attr, value)
            self.effect(target, CHANGES)

    def _unpack(self, targets: list[ast.expr], value: Type, node: ast.AST) -> None:
        star = next((i for i, t in enumerate(targets) if isinstance(t, ast.Starred)), None)
        after = 0 if star is None else len(targets) - star - 1
        for position, target in enumerate(targets):
            if position == star:
                self.assign(target, self._star(value, position, after, target))
            elif star is None or position < star:
                self.assign(target, self.at(value, position))
            else:
                self.assign(target, self.at(value, position - len(targets)))

    def _star(self, value: Type, before: int, after: int, node: ast.AST) -> Type:
        items: list[Type] | None = None
        for site in self.read_sites(value):
            if site.items is not None and len(value.sites) == 1:
                items = site.items[before : len(site.items) - after]
        if items is not None:
            return self.tuple_of(node, items, kind=LIST)
        return self.container(node, LIST, self.elements(value))

    def _Delete(self, node: ast.Delete) -> None:
        for target in node.targets:
            if isinstance(target, ast.Subscript):
                self.expression(target.slice)
                self.mutated(self.expression(target.value), node=target)

    def _Return(self, node: ast.Return) -> None:
        value = self.expression(node.value) if node.value is not None else T_NONE
        if not self.function.is_generator:
            self._returned(self.function, value)
        self.env = None

    def _Raise(self, node: ast.Raise) -> None:
        if node.exc is not None:
            self.expression(node.exc)
        self.env = None

    def _Break(self, node: ast.Break) -> None:
        if self.exits and self.env is not None:
            self.exits[-1].append(self.env)
        self.env = None

    _Continue = _Break

    def _Assert(self, node: ast.Assert) -> None:
        self.expression(node.test)
        self.narrow(node.test, True)

    def _If(self, node: ast.If) -> None:
        self.expression(node.test)
        before = dict(self.env or {})
        self.narrow(node.test, True)
        self.block(node.body)
        after_body = self.env
        self.env = before
        self.narrow(node.test, False)
        self.block(node.orelse)
        self.env = _merge(after_body, self.env)

    def _For(self, node: ast.For) -> None:
        elements = self.elements(self.expression(node.iter))
        self.facts.types[node] = elements
        self._loop(node, lambda: self.assign(node.target, self._iterated(node.iter, elements)))

    def _While(self, node: ast.While) -> None:
        def test() -> None:
            self.expression(node.test)
            self.narrow(node.test, True)

        self._loop(node, test)

    def _iterated(self, iterable: ast.expr, elements: Type) -> Type:
        return elements

    def _loop(self, node: ast.For | ast.While, begin: object) -> None:
        assert callable(begin)
        if len(self.exits) >= _DEEPEST_LOOPS:  # without the flow, so that the work does not double with every level
            self.env = {}
            self.exits.append([])
            begin()
            self.block(node.body)
            self.exits.pop()
            self.env = {}
            self.block(node.orelse)
            return
        head = dict(self.env or {})
        for _ in range(8):
            self.env = dict(head)
            self.exits.append([])
            begin()
            self.block(node.body)
            ends = self.exits.pop()
            merged = dict(head)
            for env in (self.env, *ends):
                merged = _merge(merged, env) or merged
            if all(merged.get(v) is head.get(v) for v in merged):
                break
            head = merged
        self.env = head
        self.block(node.orelse)

    def _With(self, node: ast.With) -> None:
        for item in node.items:
            self.expression(item.context_expr)
        self.block(node.body)

    def _Try(self, node: ast.Try) -> None:
        before = dict(self.env or {})
        self.block(node.body)
        self.block(node.orelse)
        merged = self.env
        for handler in node.handlers:
            self.env = _merge(dict(before), merged) or {}
            if handler.name and handler in self.names.variables:
                self.store(self.names.variables[handler], ANYTHING)
            self.block(handler.body)
            merged = _merge(merged, self.env)
        self.env = merged
        self.block(node.finalbody)

    def _FunctionDef(self, node: ast.FunctionDef) -> None:
        function = self.names.functions[node]
        self.defaults(function)
        if function.variable is not None:
            self.store(function.variable, Type(FUNCTION, frozenset((function,))))

    def _ClassDef(self, node: ast.ClassDef) -> None:
        record = self.names.classes.get(node)
        if record is None:
            return
        for name, default in record.fields:
            if default is not None:
                self.set_field(record, name, self.expression(default))
        for value in record.constants.values():
            self.expression(value)
        for method in record.methods.values():
            self.defaults(method)
            if method.parameters and not method.is_static:
                self.store(method.parameters[0].variable, Type(RECORD, frozenset((record,))))
        self.store(record.variable, Type(FUNCTION, frozenset((record,))))

    # --- narrowing ---

    def narrow(self, test: ast.expr, holds: bool) -> None:
        """What a test says about the variables in it."""
        if isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not):
            self.narrow(test.operand, not holds)
        elif isinstance(test, ast.BoolOp) and isinstance(test.op, ast.And) == holds:
            for value in test.values:
                self.narrow(value, holds)
        elif isinstance(test, ast.Name) and holds:
            self._without(test, NONE)
        elif isinstance(test, ast.Compare) and len(test.ops) == 1 and is_none(test.comparators[0]):
            is_test = isinstance(test.ops[0], (ast.Is, ast.Eq))
            if is_test != holds:
                self._without(test.left, NONE)
            elif isinstance(test.left, ast.Name):
                self._keep(test.left, NONE)
        elif isinstance(test, ast.Call) and self.paths.of(test.func) == "isinstance" and len(test.args) == 2:
            kinds = _isinstance_kinds(self.paths, test.args[1])
            if kinds and holds:
                self._keep(test.args[0], kinds)
            elif kinds:
                self._without(test.args[0], kinds)

    def _without(self, node: ast.expr, kinds: int) -> None:
        if isinstance(node, ast.Name) and self.env is not None:
            variable = self.names.variables.get(node)
            if variable is not None and variable in self.env:
                found = self.env[variable]
                if found.kinds & kinds:
                    self.env[variable] = found.without(kinds)

    def _keep(self, node: ast.expr, kinds: int) -> None:
        if isinstance(node, ast.Name) and self.env is not None:
            variable = self.names.variables.get(node)
            if variable is not None and variable in self.env:
                found = self.env[variable]
                if found.kinds & UNKNOWN and kinds & NUMBERS:
                    self.env[variable] = Type(kinds)
                elif found.kinds & kinds:
                    self.env[variable] = found.without(~kinds)


def _merge(a: Environment | None, b: Environment | None) -> Environment | None:
    if a is None or b is None:
        return b if a is None else a
    merged = dict(a)
    for variable, value in b.items():
        old = merged.get(variable)
        merged[variable] = value if old is None else old | value
    return merged


def _isinstance_kinds(paths: Paths, node: ast.expr) -> int:
    if isinstance(node, ast.Tuple):
        kinds = 0
        for element in node.elts:
            kinds |= _isinstance_kinds(paths, element)
        return kinds
    known = {
        "int": INT | BOOL, "float": FLOAT, "bool": BOOL, "str": STR, "list": LIST | SHAPE, "tuple": TUPLE, "dict": DICT,
        "set": SET, "numpy.ndarray": ARRAY | POSE, "numpy.floating": FLOAT,
    }  # fmt: skip
    return known.get(paths.of(node) or "", 0)

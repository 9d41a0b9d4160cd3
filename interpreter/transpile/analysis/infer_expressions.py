"""Inference through expressions."""

from __future__ import annotations

import ast

from scenelang.interpreter.transpile.analysis.domain import (
    ANYTHING,
    ARRAY,
    BOOL,
    DICT,
    FLOAT,
    FUNCTION,
    INT,
    LIST,
    MODULE,
    NONE,
    NOTHING,
    NUMBERS,
    POSE,
    SEQUENCES,
    SET,
    SHAPE,
    STR,
    T_BOOL,
    T_FLOAT,
    T_INT,
    T_NONE,
    T_NUMBER,
    T_POSE,
    T_SHAPE,
    T_STR,
    TUPLE,
    UNKNOWN,
    Site,
    Type,
    join_all,
)
from scenelang.interpreter.transpile.analysis.infer_calls import CallInference
from scenelang.interpreter.transpile.analysis.inference import (
    constant_index,
    constant_type,
    has_slice,
)
from scenelang.interpreter.transpile.analysis.known import RESULTS
from scenelang.interpreter.transpile.analysis.paths import is_module
from scenelang.interpreter.transpile.analysis.scopes import Comprehension


class ExpressionInference(CallInference):
    """Looks at expressions."""

    def expression(self, node: ast.expr) -> Type:
        handler = getattr(self, f"_{type(node).__name__}", None)
        found: Type = handler(node) if handler is not None else ANYTHING
        self.facts.types[node] = found
        return found

    def _Constant(self, node: ast.Constant) -> Type:
        return constant_type(node.value)

    def _Name(self, node: ast.Name) -> Type:
        variable = self.names.variables.get(node)
        path = self.paths.of(node)
        if path is not None:
            if is_module(path):
                return Type(MODULE, frozenset((path,)))
            return self._named(path)
        assert variable is not None
        return self.load(variable)

    def _named(self, path: str) -> Type:
        if path in RESULTS:
            result = RESULTS[path]
            if isinstance(result, Type) and path in (
                "math.pi",
                "math.e",
                "math.tau",
                "math.inf",
                "numpy.pi",
                "numpy.e",
            ):
                return result
            return Type(FUNCTION, frozenset((path,)))
        return ANYTHING

    def _Attribute(self, node: ast.Attribute) -> Type:
        path = self.paths.of(node)
        if path is not None:
            return Type(MODULE, frozenset((path,))) if is_module(path) else self._named(path)
        return self.attribute(node, self.expression(node.value))

    def attribute(self, node: ast.Attribute, owner: Type) -> Type:
        """The field of a record, or the shape of an array."""
        result = NOTHING
        for record in owner.classes:
            if node.attr in record.properties:
                result = result | self.call_function(record.methods[node.attr], node, [owner], {})
            elif node.attr in record.constants:
                result = result | self.facts.type(record.constants[node.attr])
            elif node.attr not in record.methods:
                site = self.site(record.node, DICT, f".{node.attr}")
                site.readers.add(self.function)
                result = result | site.element
        if owner.kinds & (ARRAY | POSE):
            if node.attr == "shape":
                result = result | self.container(node, TUPLE, T_INT)
            elif node.attr == "size":
                result = result | T_INT
            elif node.attr == "T":
                result = result | owner
        return result

    def _Tuple(self, node: ast.Tuple) -> Type:
        return self._sequence(node, node.elts, TUPLE)

    def _List(self, node: ast.List) -> Type:
        return self._sequence(node, node.elts, LIST)

    def _sequence(self, node: ast.expr, elements: list[ast.expr], kind: int) -> Type:
        if not any(isinstance(element, ast.Starred) for element in elements):
            return self.tuple_of(node, [self.expression(element) for element in elements], kind=kind)
        items: list[Type] | None = []
        joined = NOTHING
        for element in elements:
            if isinstance(element, ast.Starred):
                value = self.expression(element.value)
                self.facts.types[element] = value
                sites = self.read_sites(value)
                joined = joined | self.elements(value)
                if (
                    items is not None
                    and len(sites) == 1
                    and sites[0].items is not None
                    and not value.kinds & ~SEQUENCES
                ):
                    items += sites[0].items
                else:
                    items = None
            else:
                found = self.expression(element)
                joined = joined | found
                if items is not None:
                    items.append(found)
        if items is not None:
            return self.tuple_of(node, items, kind=kind)
        return self.container(node, kind, joined)

    def _Set(self, node: ast.Set) -> Type:
        return self.container(node, SET, join_all([self.expression(e) for e in node.elts]))

    def _Dict(self, node: ast.Dict) -> Type:
        keys = values = other = NOTHING
        fields: dict[object, Type] = {}
        for key, value in zip(node.keys, node.values):
            found = self.expression(value)
            if key is None:
                for site in self.read_sites(found):
                    keys, values = keys | site.key, values | site.element
                    for name, inner in site.fields.items():
                        fields[name] = fields.get(name, NOTHING) | inner
                    other = other | site.other
                continue
            keys, values = keys | self.expression(key), values | found
            if isinstance(key, ast.Constant):
                fields[key.value] = fields.get(key.value, NOTHING) | found
            else:
                other = other | found
        return self.table(self.site(node, DICT), keys, values, fields, other)

    def _comprehension(self, node: Comprehension, kind: int) -> Type:
        for generator in node.generators:
            elements = self.elements(self.expression(generator.iter))
            self.facts.types[generator] = elements
            self.assign(generator.target, elements)
            for condition in generator.ifs:
                self.expression(condition)
                self.narrow(condition, True)
        if isinstance(node, ast.DictComp):
            key, value = self.expression(node.key), self.expression(node.value)
            return self.table(self.site(node, kind), key, value, {}, value)
        return self.container(node, kind, self.expression(node.elt))

    def _ListComp(self, node: ast.ListComp) -> Type:
        return self._comprehension(node, LIST)

    def _GeneratorExp(self, node: ast.GeneratorExp) -> Type:
        return self._comprehension(node, LIST)

    def _SetComp(self, node: ast.SetComp) -> Type:
        return self._comprehension(node, SET)

    def _DictComp(self, node: ast.DictComp) -> Type:
        return self._comprehension(node, DICT)

    def _Starred(self, node: ast.Starred) -> Type:
        return self.expression(node.value)

    def _NamedExpr(self, node: ast.NamedExpr) -> Type:
        value = self.expression(node.value)
        self.assign(node.target, value)
        return value

    def _Lambda(self, node: ast.Lambda) -> Type:
        function = self.names.functions[node]
        self.defaults(function)
        return Type(FUNCTION, frozenset((function,)))

    def _IfExp(self, node: ast.IfExp) -> Type:
        self.expression(node.test)
        saved = dict(self.env or {})
        self.narrow(node.test, True)
        first = self.expression(node.body)
        self.env = dict(saved)
        self.narrow(node.test, False)
        second = self.expression(node.orelse)
        self.env = saved
        return first | second

    def _BoolOp(self, node: ast.BoolOp) -> Type:
        saved = dict(self.env or {})
        result = NOTHING
        for position, value in enumerate(node.values):
            found = self.expression(value)
            if isinstance(node.op, ast.Or) and position < len(node.values) - 1:
                found = found.without(NONE)
            result = result | found
            self.narrow(value, isinstance(node.op, ast.And))
        self.env = saved
        return result

    def _Compare(self, node: ast.Compare) -> Type:
        kinds = self.expression(node.left).kinds
        for comparator in node.comparators:
            kinds |= self.expression(comparator).kinds
        is_containment = isinstance(node.ops[0], (ast.In, ast.NotIn, ast.Is, ast.IsNot))
        if kinds & ARRAY and not is_containment:
            return self.container(node, ARRAY, T_INT, T_BOOL)
        return T_BOOL

    def _UnaryOp(self, node: ast.UnaryOp) -> Type:
        operand = self.expression(node.operand)
        if isinstance(node.op, ast.Not):
            return T_BOOL
        return T_INT if operand.only(BOOL) else operand

    def _BinOp(self, node: ast.BinOp) -> Type:
        left = self.expression(node.left)
        return self.operation(node, node.op, left, self.expression(node.right))

    def operation(self, node: ast.AST, op: ast.operator, left: Type, right: Type) -> Type:
        """The type of ``left op right``."""
        kinds = left.kinds | right.kinds
        if not left.kinds or (not right.kinds and not left.kinds & SEQUENCES):
            known = left | right
            return known if known.only(NUMBERS | ARRAY | STR | SHAPE) else NOTHING
        result = NOTHING
        if kinds & ARRAY and isinstance(op, (ast.BitAnd, ast.BitOr)):
            return self.container(node, ARRAY, T_INT, T_BOOL)
        if kinds & (ARRAY | POSE):
            if isinstance(op, ast.MatMult) and left.kinds & POSE and right.kinds & POSE:
                result = T_POSE
            elif isinstance(op, ast.MatMult):
                result = self.container(node, ARRAY, T_FLOAT)
            else:
                result = self._array_result(node, left, right)
            if not (left.only(ARRAY | POSE) or right.only(ARRAY | POSE)):
                result = result | self.operation(node, op, left.without(ARRAY | POSE), right.without(ARRAY | POSE))
            return result
        if isinstance(op, ast.Add) and kinds & (SEQUENCES | SHAPE):
            if kinds & SHAPE:
                return T_SHAPE
            a, b = left.sites, right.sites
            if len(a) == len(b) == 1 and a[0].items is not None and b[0].items is not None and a[0].kind == b[0].kind:
                self.read_sites(left | right)
                return self.tuple_of(node, [*a[0].items, *b[0].items], kind=a[0].kind)
            return self.container(node, kinds & SEQUENCES or LIST, self.elements(left | right))
        if isinstance(op, ast.Mult) and kinds & (SEQUENCES | SHAPE | STR):
            if kinds & STR:
                return T_STR
            if kinds & SHAPE:
                return T_SHAPE
            return self._repeated(node, left if left.kinds & SEQUENCES else right, kinds)
        if kinds & SET and isinstance(op, (ast.BitAnd, ast.BitOr, ast.Sub, ast.BitXor)):
            return self.container(node, SET, self.elements(left | right))
        if kinds & DICT and isinstance(op, ast.BitOr):
            sites = self.read_sites(left | right)
            return self.container(node, DICT, join_all([s.element for s in sites]), join_all([s.key for s in sites]))
        if left.kinds & STR and isinstance(op, (ast.Add, ast.Mod)):
            return T_STR if left.only(STR) else T_STR | ANYTHING
        if kinds & UNKNOWN:
            return ANYTHING
        return _number_result(op, left, right)

    def _repeated(self, node: ast.AST, value: Type, kinds: int) -> Type:
        count = node.right if isinstance(node, ast.BinOp) else None
        sites = self.read_sites(value)
        if (
            isinstance(count, ast.Constant)
            and isinstance(count.value, int)
            and 0 < count.value <= 16
            and len(sites) == 1
            and sites[0].items is not None
        ):
            return self.tuple_of(node, sites[0].items * count.value, kind=sites[0].kind)
        return self.container(node, kinds & SEQUENCES, self.elements(value))

    def _array_result(self, node: ast.AST, left: Type, right: Type) -> Type:
        """Element by element: as many dimensions as the operand that has more."""
        element = NOTHING
        for value in (left, right):
            if value.kinds & ARRAY:
                element = element | self.elements(value)
            elif value.kinds & POSE:
                element = element | Type(ARRAY)
        if element.kinds & ARRAY and element.kinds & NUMBERS:
            element = element.without(NUMBERS)
        return self.container(node, ARRAY, element if element.kinds else T_FLOAT)

    def _JoinedStr(self, node: ast.JoinedStr) -> Type:
        for value in node.values:
            if isinstance(value, ast.FormattedValue):
                self.expression(value.value)
        return T_STR

    def _Slice(self, node: ast.Slice) -> Type:
        for part in (node.lower, node.upper, node.step):
            if part is not None:
                self.expression(part)
        return NOTHING

    def _Subscript(self, node: ast.Subscript) -> Type:
        return self.subscript(node, self.expression(node.value), node.slice)

    def subscript(self, node: ast.AST, value: Type, index: ast.expr) -> Type:
        """What ``value[index]`` gives."""
        key = self.expression(index)
        result = ANYTHING if value.kinds & UNKNOWN else NOTHING
        if isinstance(index, ast.Slice):
            return result | self._slice(node, value, index)
        if value.kinds & STR:
            result = result | T_STR
        if value.kinds & SHAPE:
            result = result | T_SHAPE
        position = constant_index(index)
        for site in self.read_sites(value):
            if site.kind & SEQUENCES and position is not None and site.items is not None:
                if -len(site.items) <= position < len(site.items):
                    result = result | site.items[position]
            elif site.kind == ARRAY:
                result = result | self._array_item(node, site, index, key)
            elif site.kind == POSE:
                continue
            elif site.kind == DICT:
                result = result | self.field(site, index)
            else:
                result = result | site.element
        if value.kinds & POSE:
            result = result | self._pose_item(node, index)
        elif value.kinds & ARRAY and not value.sites:
            result = result | T_FLOAT
        return result

    def _pose_item(self, node: ast.AST, index: ast.expr) -> Type:
        """A number, row or part of a 4x4 matrix."""
        if not isinstance(index, ast.Tuple):
            return Type(ARRAY)
        axes = sum(isinstance(axis, ast.Slice) for axis in index.elts) + max(2 - len(index.elts), 0)
        if axes == 0:
            return T_FLOAT
        return self.container(node, ARRAY, Type(ARRAY) if axes > 1 else T_FLOAT, tag="part")

    def _array_item(self, node: ast.AST, site: Site, index: ast.expr, key: Type) -> Type:
        if isinstance(index, ast.Tuple):
            if has_slice(index):
                is_matrix = sum(isinstance(axis, ast.Slice) for axis in index.elts) > 1
                return self.container(node, ARRAY, Type(ARRAY) if is_matrix else T_FLOAT)
            found = Type(ARRAY, frozenset((site,)))
            for _ in index.elts:
                found = self.elements(found)
            return found if found.kinds else T_FLOAT
        if key.kinds & (ARRAY | LIST):
            return self.container(node, ARRAY, site.element)
        return site.element

    def _slice(self, node: ast.AST, value: Type, index: ast.Slice) -> Type:
        result = Type(value.kinds & STR) | (T_SHAPE if value.kinds & SHAPE else NOTHING)
        sites = self.read_sites(value)
        bounds = [constant_index(b) if b is not None else "" for b in (index.lower, index.upper, index.step)]
        is_known = None not in bounds and bounds[2] != 0
        if len(sites) == 1 and sites[0].items is not None and is_known and sites[0].kind & SEQUENCES:
            lower, upper, step = (b if isinstance(b, int) else None for b in bounds)
            return result | self.tuple_of(node, sites[0].items[lower:upper:step], kind=sites[0].kind)
        for kind in (LIST, TUPLE, ARRAY):
            if value.kinds & kind:
                element = join_all([s.element for s in sites if s.kind == kind])
                result = result | self.container(node, kind, element, tag=str(kind))
        if value.kinds & POSE:
            result = result | self.container(node, ARRAY, Type(ARRAY), tag="rows")
        return result

    def _Yield(self, node: ast.Yield) -> Type:
        value = self.expression(node.value) if node.value is not None else T_NONE
        self._returned(self.function, self.container(self.function.node, LIST, value))
        return T_NONE

    def _YieldFrom(self, node: ast.YieldFrom) -> Type:
        value = self.elements(self.expression(node.value))
        self._returned(self.function, self.container(self.function.node, LIST, value))
        return T_NONE


def _number_result(op: ast.operator, left: Type, right: Type) -> Type:
    if isinstance(op, ast.Div):
        return T_FLOAT
    if left.only(INT | BOOL) and right.only(INT | BOOL):
        return T_NUMBER if isinstance(op, ast.Pow) else T_INT
    if left.only(FLOAT) or right.only(FLOAT):
        return T_FLOAT
    return T_NUMBER

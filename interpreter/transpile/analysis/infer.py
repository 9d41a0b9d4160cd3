"""Type inference: what kinds of values every expression of the Python may have.

The whole program is interpreted over abstract values (``domain``): flow-sensitive inside a function, the arguments of
all call sites joined, containers by the place that makes them. Functions are looked at again until nothing grows.
"""

from __future__ import annotations

import ast
from collections.abc import Sequence

from scenelang.interpreter.transpile.analysis.inference import (
    ANYTHING,
    ARRAY,
    BOOL,
    CHANGES,
    DICT,
    DRAWS,
    FLOAT,
    FUNCTION,
    INT,
    LIST,
    MODULE,
    NONE,
    NOTHING,
    NUMBERS,
    POSE,
    RECORD,
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
    AbstractType,
    Environment,
    InferenceState,
    Site,
    TypeFacts,
    constant_index,
    constant_type,
    has_slice,
    join_all,
)
from scenelang.interpreter.transpile.analysis.known import METHODS, MUTATORS, RESULTS, draws
from scenelang.interpreter.transpile.analysis.scopes import (
    Class,
    Comprehension,
    Function,
    LibraryPaths,
    PythonNames,
    PythonVariable,
    is_annotation,
    is_module,
    is_none,
)

# Inference through calls: of functions of the program, its classes, the library and methods.


class CallInference(InferenceState):
    """Looks at calls."""

    def _Call(self, node: ast.Call) -> AbstractType:
        path = self.paths.of(node.func)
        positional = self._positional(node)
        named = {k.arg: self.expression(k.value) for k in node.keywords if k.arg is not None}
        for keyword in node.keywords:
            if keyword.arg is None:
                self.expression(keyword.value)
        if path is not None:
            return self._call_path(path, node, positional, named)
        if isinstance(node.func, ast.Attribute):
            return self._call_method(node, node.func, positional, named)
        return self.call(self.expression(node.func), node, positional, named)

    def _positional(self, node: ast.Call) -> list[AbstractType]:
        positional: list[AbstractType] = []
        for argument in node.args:
            value = self.expression(argument)
            if isinstance(argument, ast.Starred):
                sites = self.read_sites(value)
                if len(sites) == 1 and sites[0].items is not None:
                    positional += sites[0].items
                else:
                    positional += [self.elements(value)] * 8  # as many as anything could take
            else:
                positional.append(value)
        return positional

    def _call_path(
        self, path: str, node: ast.Call, positional: list[AbstractType], named: dict[str, AbstractType]
    ) -> AbstractType:
        self.facts.types[node.func] = AbstractType(FUNCTION, frozenset((path,)))
        if path == "library_call":
            return self._library_call(node, positional, named)
        if draws(path):
            self.effect(node, DRAWS)
        if path == "print":
            self.effect(node, CHANGES)
        if path in MUTATORS and positional:
            self.mutated(positional[0], node=node)
        result = RESULTS.get(path)
        if result is None:
            return ANYTHING
        return result if isinstance(result, AbstractType) else result(self, node, positional, named)

    def _library_call(
        self, node: ast.Call, positional: list[AbstractType], named: dict[str, AbstractType]
    ) -> AbstractType:
        word = node.args[0] if node.args else next((k.value for k in node.keywords if k.arg == "func_name"), None)
        named = {name: value for name, value in named.items() if name != "func_name"}
        if isinstance(word, ast.Constant):
            target = self.facts.words.get(str(word.value))
            targets = [target] if target is not None else []
        else:
            targets = [f for f in dict.fromkeys(self.facts.words.values()) if all(f.parameter(name) for name in named)]
        self.facts.targets[node] = targets
        stars = [k for k in node.keywords if k.arg is None]
        for target in targets:
            extra = dict(named)
            for star in stars:
                for site in self.read_sites(self.facts.type(star.value)):
                    for parameter in target.parameters:
                        if parameter.variable.name not in extra and parameter.kind != "keys":
                            known = site.fields.get(parameter.variable.name, NOTHING) | site.other
                            extra[parameter.variable.name] = known if site.fields else site.element
            self.call_function(target, node, [], extra)
        return T_SHAPE

    def _call_method(
        self, node: ast.Call, func: ast.Attribute, positional: list[AbstractType], named: dict[str, AbstractType]
    ) -> AbstractType:
        owner = self.expression(func.value)
        result = NOTHING
        for record in owner.classes:
            method = record.methods.get(func.attr)
            if method is not None:
                is_instance = bool(owner.kinds & RECORD) and not method.is_static
                arguments = [AbstractType(RECORD, frozenset((record,))), *positional] if is_instance else positional
                self.facts.targets.setdefault(node, [])
                if method not in self.facts.targets[node]:
                    self.facts.targets[node].append(method)
                result = result | self.call_function(method, node, arguments, named)
            elif func.attr not in record.methods:
                site = self.site(record.node, DICT, f".{func.attr}")
                site.readers.add(self.function)
                result = result | self.call(site.element, node, positional, named)
        handler = METHODS.get(func.attr)
        if handler is not None and not owner.classes:
            result = result | handler(self, node, owner, positional, named)
        elif not owner.classes:
            result = result | ANYTHING
        return result

    def call(
        self, function: AbstractType, node: ast.AST, positional: list[AbstractType], named: dict[str, AbstractType]
    ) -> AbstractType:
        """Call anything that may be a function."""
        result = ANYTHING if function.kinds & UNKNOWN else NOTHING
        for target in function.functions:
            if isinstance(node, ast.Call) and self.facts.types.get(node.func) is function:
                known = self.facts.targets.setdefault(node, [])
                if target not in known:
                    known.append(target)
            result = result | self.call_function(target, node, positional, named)
        for record in function.classes:
            result = result | self._construct(record, node, positional, named)
        for path in function.names:
            entry = RESULTS.get(path)
            if draws(path):
                self.effect(node, DRAWS)
            if isinstance(entry, AbstractType):
                result = result | entry
            elif entry is not None:
                result = result | entry(self, node, positional, named)
        return result

    def call_function(
        self, function: Function, node: ast.AST, positional: list[AbstractType], named: dict[str, AbstractType]
    ) -> AbstractType:
        """Join the arguments into the parameters; what the function is known to return."""
        self.facts.callbacks.setdefault(node, set()).add(function)
        self.callees.setdefault(self.function, set()).add(function)
        self.callers.setdefault(function, set()).add(self.function)
        rest: list[AbstractType] = []
        used: set[str] = set()
        position = 0
        for parameter in function.parameters:
            name = parameter.variable.name
            if parameter.kind == "plain" and position < len(positional):
                value = positional[position]
                position += 1
            elif parameter.kind in ("plain", "keyword") and name in named:
                value = named[name]
                used.add(name)
            elif parameter.kind == "rest":
                rest = positional[position:]
                value = self.container(parameter.annotation or function.node, TUPLE, join_all(rest), tag="*")
            elif parameter.kind == "keys":
                extra = [v for n, v in named.items() if n not in used]
                value = self.container(function.node, DICT, join_all(extra), T_STR, tag="**")
            elif parameter.default is not None:
                value = self.facts.type(parameter.default)
            else:
                continue
            self._bind(function, parameter.variable, value)
        if function not in self.facts.reached:
            self.enqueue(function)
        return self.facts.returns.get(function, NOTHING)

    def _bind(self, function: Function, variable: PythonVariable, value: AbstractType) -> None:
        old = self.facts.variables.get(variable, NOTHING)
        new = old | value
        if new is not old:
            self.facts.variables[variable] = new
            self.enqueue(function)
            for reader in variable.readers:
                if reader is not function:
                    self.enqueue(reader)

    def _construct(
        self, record: Class, node: ast.AST, positional: list[AbstractType], named: dict[str, AbstractType]
    ) -> AbstractType:
        made = AbstractType(RECORD, frozenset((record,)))
        constructor = record.methods.get("__init__")
        if constructor is not None:
            self.call_function(constructor, node, [made, *positional], named)
        else:
            for (name, _), value in zip(record.fields, positional):
                self.set_field(record, name, value)
            for name, value in named.items():
                self.set_field(record, name, value)
        return made


# Inference through expressions.


class ExpressionInference(CallInference):
    """Looks at expressions."""

    def expression(self, node: ast.expr) -> AbstractType:
        handler = getattr(self, f"_{type(node).__name__}", None)
        found: AbstractType = handler(node) if handler is not None else ANYTHING
        self.facts.types[node] = found
        return found

    def _Constant(self, node: ast.Constant) -> AbstractType:
        return constant_type(node.value)

    def _Name(self, node: ast.Name) -> AbstractType:
        variable = self.names.variables.get(node)
        path = self.paths.of(node)
        if path is not None:
            if is_module(path):
                return AbstractType(MODULE, frozenset((path,)))
            return self._named(path)
        assert variable is not None
        return self.load(variable)

    def _named(self, path: str) -> AbstractType:
        if path in RESULTS:
            result = RESULTS[path]
            if isinstance(result, AbstractType) and path in (
                "math.pi",
                "math.e",
                "math.tau",
                "math.inf",
                "numpy.pi",
                "numpy.e",
            ):
                return result
            return AbstractType(FUNCTION, frozenset((path,)))
        return ANYTHING

    def _Attribute(self, node: ast.Attribute) -> AbstractType:
        path = self.paths.of(node)
        if path is not None:
            return AbstractType(MODULE, frozenset((path,))) if is_module(path) else self._named(path)
        return self.attribute(node, self.expression(node.value))

    def attribute(self, node: ast.Attribute, owner: AbstractType) -> AbstractType:
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

    def _Tuple(self, node: ast.Tuple) -> AbstractType:
        return self._sequence(node, node.elts, TUPLE)

    def _List(self, node: ast.List) -> AbstractType:
        return self._sequence(node, node.elts, LIST)

    def _sequence(self, node: ast.expr, elements: list[ast.expr], kind: int) -> AbstractType:
        if not any(isinstance(element, ast.Starred) for element in elements):
            return self.tuple_of(node, [self.expression(element) for element in elements], kind=kind)
        items: list[AbstractType] | None = []
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

    def _Set(self, node: ast.Set) -> AbstractType:
        return self.container(node, SET, join_all([self.expression(e) for e in node.elts]))

    def _Dict(self, node: ast.Dict) -> AbstractType:
        keys = values = other = NOTHING
        fields: dict[object, AbstractType] = {}
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

    def _comprehension(self, node: Comprehension, kind: int) -> AbstractType:
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

    def _ListComp(self, node: ast.ListComp) -> AbstractType:
        return self._comprehension(node, LIST)

    def _GeneratorExp(self, node: ast.GeneratorExp) -> AbstractType:
        return self._comprehension(node, LIST)

    def _SetComp(self, node: ast.SetComp) -> AbstractType:
        return self._comprehension(node, SET)

    def _DictComp(self, node: ast.DictComp) -> AbstractType:
        return self._comprehension(node, DICT)

    def _Starred(self, node: ast.Starred) -> AbstractType:
        return self.expression(node.value)

    def _NamedExpr(self, node: ast.NamedExpr) -> AbstractType:
        value = self.expression(node.value)
        self.assign(node.target, value)
        return value

    def _Lambda(self, node: ast.Lambda) -> AbstractType:
        function = self.names.functions[node]
        self.defaults(function)
        return AbstractType(FUNCTION, frozenset((function,)))

    def _IfExp(self, node: ast.IfExp) -> AbstractType:
        self.expression(node.test)
        saved = dict(self.env or {})
        self.narrow(node.test, True)
        first = self.expression(node.body)
        self.env = dict(saved)
        self.narrow(node.test, False)
        second = self.expression(node.orelse)
        self.env = saved
        return first | second

    def _BoolOp(self, node: ast.BoolOp) -> AbstractType:
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

    def _Compare(self, node: ast.Compare) -> AbstractType:
        kinds = self.expression(node.left).kinds
        for comparator in node.comparators:
            kinds |= self.expression(comparator).kinds
        is_containment = isinstance(node.ops[0], (ast.In, ast.NotIn, ast.Is, ast.IsNot))
        if kinds & ARRAY and not is_containment:
            return self.container(node, ARRAY, T_INT, T_BOOL)
        return T_BOOL

    def _UnaryOp(self, node: ast.UnaryOp) -> AbstractType:
        operand = self.expression(node.operand)
        if isinstance(node.op, ast.Not):
            return T_BOOL
        return T_INT if operand.only(BOOL) else operand

    def _BinOp(self, node: ast.BinOp) -> AbstractType:
        left = self.expression(node.left)
        return self.operation(node, node.op, left, self.expression(node.right))

    def operation(self, node: ast.AST, op: ast.operator, left: AbstractType, right: AbstractType) -> AbstractType:
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

    def _repeated(self, node: ast.AST, value: AbstractType, kinds: int) -> AbstractType:
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

    def _array_result(self, node: ast.AST, left: AbstractType, right: AbstractType) -> AbstractType:
        """Element by element: as many dimensions as the operand that has more."""
        element = NOTHING
        for value in (left, right):
            if value.kinds & ARRAY:
                element = element | self.elements(value)
            elif value.kinds & POSE:
                element = element | AbstractType(ARRAY)
        if element.kinds & ARRAY and element.kinds & NUMBERS:
            element = element.without(NUMBERS)
        return self.container(node, ARRAY, element if element.kinds else T_FLOAT)

    def _JoinedStr(self, node: ast.JoinedStr) -> AbstractType:
        for value in node.values:
            if isinstance(value, ast.FormattedValue):
                self.expression(value.value)
        return T_STR

    def _Slice(self, node: ast.Slice) -> AbstractType:
        for part in (node.lower, node.upper, node.step):
            if part is not None:
                self.expression(part)
        return NOTHING

    def _Subscript(self, node: ast.Subscript) -> AbstractType:
        return self.subscript(node, self.expression(node.value), node.slice)

    def subscript(self, node: ast.AST, value: AbstractType, index: ast.expr) -> AbstractType:
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

    def _pose_item(self, node: ast.AST, index: ast.expr) -> AbstractType:
        """A number, row or part of a 4x4 matrix."""
        if not isinstance(index, ast.Tuple):
            return AbstractType(ARRAY)
        axes = sum(isinstance(axis, ast.Slice) for axis in index.elts) + max(2 - len(index.elts), 0)
        if axes == 0:
            return T_FLOAT
        return self.container(node, ARRAY, AbstractType(ARRAY) if axes > 1 else T_FLOAT, tag="part")

    def _array_item(self, node: ast.AST, site: Site, index: ast.expr, key: AbstractType) -> AbstractType:
        if isinstance(index, ast.Tuple):
            if has_slice(index):
                is_matrix = sum(isinstance(axis, ast.Slice) for axis in index.elts) > 1
                return self.container(node, ARRAY, AbstractType(ARRAY) if is_matrix else T_FLOAT)
            found = AbstractType(ARRAY, frozenset((site,)))
            for _ in index.elts:
                found = self.elements(found)
            return found if found.kinds else T_FLOAT
        if key.kinds & (ARRAY | LIST):
            return self.container(node, ARRAY, site.element)
        return site.element

    def _slice(self, node: ast.AST, value: AbstractType, index: ast.Slice) -> AbstractType:
        result = AbstractType(value.kinds & STR) | (T_SHAPE if value.kinds & SHAPE else NOTHING)
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
            result = result | self.container(node, ARRAY, AbstractType(ARRAY), tag="rows")
        return result

    def _Yield(self, node: ast.Yield) -> AbstractType:
        value = self.expression(node.value) if node.value is not None else T_NONE
        self._returned(self.function, self.container(self.function.node, LIST, value))
        return T_NONE

    def _YieldFrom(self, node: ast.YieldFrom) -> AbstractType:
        value = self.elements(self.expression(node.value))
        self._returned(self.function, self.container(self.function.node, LIST, value))
        return T_NONE


def _number_result(op: ast.operator, left: AbstractType, right: AbstractType) -> AbstractType:
    if isinstance(op, ast.Div):
        return T_FLOAT
    if left.only(INT | BOOL) and right.only(INT | BOOL):
        return T_NUMBER if isinstance(op, ast.Pow) else T_INT
    if left.only(FLOAT) or right.only(FLOAT):
        return T_FLOAT
    return T_NUMBER


# Inference through statements: the flow of a function, and what tests say about variables.


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

    def _target_value(self, target: ast.expr) -> AbstractType:
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

    def assign(self, target: ast.expr, value: AbstractType) -> None:
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

    def _unpack(self, targets: list[ast.expr], value: AbstractType, node: ast.AST) -> None:
        star = next((i for i, t in enumerate(targets) if isinstance(t, ast.Starred)), None)
        after = 0 if star is None else len(targets) - star - 1
        for position, target in enumerate(targets):
            if position == star:
                self.assign(target, self._star(value, position, after, target))
            elif star is None or position < star:
                self.assign(target, self.at(value, position))
            else:
                self.assign(target, self.at(value, position - len(targets)))

    def _star(self, value: AbstractType, before: int, after: int, node: ast.AST) -> AbstractType:
        items: list[AbstractType] | None = None
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

    def _iterated(self, iterable: ast.expr, elements: AbstractType) -> AbstractType:
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
            self.store(function.variable, AbstractType(FUNCTION, frozenset((function,))))

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
                self.store(method.parameters[0].variable, AbstractType(RECORD, frozenset((record,))))
        self.store(record.variable, AbstractType(FUNCTION, frozenset((record,))))

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
                    self.env[variable] = AbstractType(kinds)
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


def _isinstance_kinds(paths: LibraryPaths, node: ast.expr) -> int:
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


def infer(
    names: PythonNames, paths: LibraryPaths, words: dict[str, Function], root: Function | None, additions: set[ast.AST]
) -> TypeFacts:
    """Infer the types of a program. ``words`` maps what ``library_call`` may say to registered functions; what
    ``additions`` add to lists does not count as changing them."""
    inference = StatementInference(names, paths, words, additions)
    inference.enqueue(names.module)
    inference.run()
    if root is not None:
        inference.call_function(root, root.node, [], {})
    inference.run()
    for function in names.ordered:  # functions that nothing calls are looked at with what their annotations say
        if function not in inference.facts.reached:
            inference.assume_annotations(function)
            inference.enqueue(function)
            inference.run()
    _propagate_effects(inference)
    return inference.facts


def _propagate_effects(inference: StatementInference) -> None:
    effects, callees = inference.facts.effects, inference.callees
    changed = True
    while changed:
        changed = False
        for function, called in callees.items():
            total = effects.get(function, 0)
            for callee in called:
                total |= effects.get(callee, 0)
            if total != effects.get(function, 0):
                effects[function] = total
                changed = True

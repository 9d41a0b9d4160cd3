"""Type inference of expressions, calls and assignment targets, by recursion on the syntax tree."""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

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
    InferenceState,
    Site,
    constant_index,
    constant_type,
    has_slice,
    join_all,
    narrow,
)
from scenelang.interpreter.transpile.analysis.known import METHODS, MUTATORS, RESULTS, uses_random_stream
from scenelang.interpreter.transpile.analysis.operator_cases import method_for
from scenelang.interpreter.transpile.analysis.rewriting import OPERATOR_METHODS
from scenelang.interpreter.transpile.analysis.scopes import Class, Comprehension, Function, PythonVariable, is_module

# Calls of functions and classes of the program, library functions and methods.


_MAX_STARRED = 8  # arguments assumed for `*args` of unknown length, more than any function takes


def _call_expression(state: InferenceState, node: ast.Call) -> AbstractType:
    path = state.paths.of(node.func)
    positional = _positional(state, node)
    named = {k.arg: expression_type(state, k.value) for k in node.keywords if k.arg is not None}
    for keyword in node.keywords:
        if keyword.arg is None:
            expression_type(state, keyword.value)
    if path is not None:
        return _call_path(state, path, node, positional, named)
    if isinstance(node.func, ast.Attribute):
        return _call_method(state, node, node.func, positional, named)
    return call_value(state, expression_type(state, node.func), node, positional, named)


def _positional(state: InferenceState, node: ast.Call) -> list[AbstractType]:
    positional: list[AbstractType] = []
    for argument in node.args:
        value = expression_type(state, argument)
        if isinstance(argument, ast.Starred):
            sites = state.read_sites(value)
            if len(sites) == 1 and sites[0].items is not None:
                positional += sites[0].items
            else:
                positional += [state.elements(value)] * _MAX_STARRED
        else:
            positional.append(value)
    return positional


def _call_path(
    state: InferenceState, path: str, node: ast.Call, positional: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    state.facts.types[node.func] = AbstractType(FUNCTION, frozenset((path,)))
    if path == "library_call":
        return _library_call(state, node, positional, named)
    if uses_random_stream(path):
        state.effect(node, DRAWS)
    if path == "print":
        state.effect(node, CHANGES)
    if path in MUTATORS and positional:
        state.mutate(positional[0], node=node)
    result = RESULTS.get(path)
    if result is None:
        return ANYTHING
    return result if isinstance(result, AbstractType) else result(state, node, positional, named)


def _library_call(
    state: InferenceState, node: ast.Call, positional: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    """Return the type of a ``library_call``, a shape, after analyzing the words that it may call."""
    word = node.args[0] if node.args else next((k.value for k in node.keywords if k.arg == "func_name"), None)
    named = {name: value for name, value in named.items() if name != "func_name"}
    if isinstance(word, ast.Constant):
        target = state.facts.words.get(str(word.value))
        targets = [target] if target is not None else []
    else:
        # a computed word may be that of any function with the given parameters
        targets = [f for f in dict.fromkeys(state.facts.words.values()) if all(f.parameter(name) for name in named)]
    state.facts.targets[node] = targets
    stars = [k for k in node.keywords if k.arg is None]
    for target in targets:
        extra = dict(named)
        for star in stars:
            for site in state.read_sites(state.facts.type(star.value)):
                for parameter in target.parameters:
                    if parameter.variable.name not in extra and parameter.kind != "keys":
                        known = site.fields.get(parameter.variable.name, NOTHING) | site.other
                        extra[parameter.variable.name] = known if site.fields else site.element
        call_function(state, target, node, [], extra)
    return T_SHAPE


def _call_method(
    state: InferenceState,
    node: ast.Call,
    func: ast.Attribute,
    positional: list[AbstractType],
    named: dict[str, AbstractType],
) -> AbstractType:
    """Return the type of a method call, from the owner's classes or from the name of a library method."""
    owner = expression_type(state, func.value)
    result = NOTHING
    for record in owner.classes:
        method = record.methods.get(func.attr)
        if method is not None:
            is_instance = bool(owner.kinds & RECORD) and not method.is_static
            arguments = [AbstractType(RECORD, frozenset((record,))), *positional] if is_instance else positional
            state.facts.targets.setdefault(node, [])
            if method not in state.facts.targets[node]:
                state.facts.targets[node].append(method)
            result = result | call_function(state, method, node, arguments, named)
        elif func.attr not in record.methods:
            # a field that contains a function
            site = state.site(record.node, DICT, f".{func.attr}")
            site.readers.add(state.function)
            result = result | call_value(state, site.element, node, positional, named)
    handler = METHODS.get(func.attr)
    if handler is not None and not owner.classes:
        result = result | handler(state, node, owner, positional, named)
    elif not owner.classes:
        result = result | ANYTHING
    return result


def call_value(
    state: InferenceState,
    function: AbstractType,
    node: ast.AST,
    positional: list[AbstractType],
    named: dict[str, AbstractType],
) -> AbstractType:
    """Return the type of a call of any value."""
    result = ANYTHING if function.kinds & UNKNOWN else NOTHING
    for target in function.functions:
        if isinstance(node, ast.Call) and state.facts.types.get(node.func) is function:
            known = state.facts.targets.setdefault(node, [])
            if target not in known:
                known.append(target)
        result = result | call_function(state, target, node, positional, named)
    for record in function.classes:
        result = result | _construct(state, record, node, positional, named)
    for path in function.names:
        entry = RESULTS.get(path)
        if uses_random_stream(path):
            state.effect(node, DRAWS)
        if isinstance(entry, AbstractType):
            result = result | entry
        elif entry is not None:
            result = result | entry(state, node, positional, named)
    return result


def call_function(
    state: InferenceState,
    function: Function,
    node: ast.AST,
    positional: list[AbstractType],
    named: dict[str, AbstractType],
) -> AbstractType:
    """Join the arguments into the parameters, and return the type of the result as known so far."""
    state.facts.callbacks.setdefault(node, set()).add(function)
    state.callees.setdefault(state.function, set()).add(function)
    state.callers.setdefault(function, set()).add(state.function)
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
            value = state.container(parameter.annotation or function.node, TUPLE, join_all(rest), tag="*")
        elif parameter.kind == "keys":
            extra = [v for n, v in named.items() if n not in used]
            value = state.container(function.node, DICT, join_all(extra), T_STR, tag="**")
        elif parameter.default is not None:
            value = state.facts.type(parameter.default)
        else:
            continue
        _bind(state, function, parameter.variable, value)
    if function not in state.facts.reached:
        state.enqueue(function)
    return state.facts.returns.get(function, NOTHING)


def _bind(state: InferenceState, function: Function, variable: PythonVariable, value: AbstractType) -> None:
    old = state.facts.variables.get(variable, NOTHING)
    new = old | value
    if new is not old:
        state.facts.variables[variable] = new
        state.enqueue(function)
        for reader in variable.readers:
            if reader is not function:
                state.enqueue(reader)


def _construct(
    state: InferenceState, record: Class, node: ast.AST, positional: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    instance = AbstractType(RECORD, frozenset((record,)))
    constructor = record.methods.get("__init__")
    if constructor is not None:
        call_function(state, constructor, node, [instance, *positional], named)
    else:
        for (name, _), value in zip(record.fields, positional):
            state.set_field(record, name, value)
        for name, value in named.items():
            state.set_field(record, name, value)
    return instance


def infer_defaults(state: InferenceState, function: Function) -> None:
    """Infer the types of default values, which are evaluated where the function is defined."""
    for parameter in function.parameters:
        if parameter.default is not None:
            expression_type(state, parameter.default)


# Expressions.


def expression_type(state: InferenceState, node: ast.expr) -> AbstractType:
    """Infer the type of an expression and record it."""
    handler = _EXPRESSIONS.get(type(node))
    inferred = handler(state, node) if handler is not None else ANYTHING
    state.facts.types[node] = inferred
    return inferred


def _constant(state: InferenceState, node: ast.Constant) -> AbstractType:
    return constant_type(node.value)


def _name(state: InferenceState, node: ast.Name) -> AbstractType:
    variable = state.names.variables.get(node)
    path = state.paths.of(node)
    if path is not None:
        if is_module(path):
            return AbstractType(MODULE, frozenset((path,)))
        return _named(state, path)
    assert variable is not None
    return state.load(variable)


def _named(state: InferenceState, path: str) -> AbstractType:
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


def _attribute(state: InferenceState, node: ast.Attribute) -> AbstractType:
    path = state.paths.of(node)
    if path is not None:
        return AbstractType(MODULE, frozenset((path,))) if is_module(path) else _named(state, path)
    return _attribute_of(state, node, expression_type(state, node.value))


def _attribute_of(state: InferenceState, node: ast.Attribute, owner: AbstractType) -> AbstractType:
    """Return the type of a field of a record, or of an attribute of an array."""
    result = NOTHING
    for record in owner.classes:
        if node.attr in record.properties:
            result = result | call_function(state, record.methods[node.attr], node, [owner], {})
        elif node.attr in record.constants:
            result = result | state.facts.type(record.constants[node.attr])
        elif node.attr not in record.methods:
            site = state.site(record.node, DICT, f".{node.attr}")
            site.readers.add(state.function)
            result = result | site.element
    if owner.kinds & (ARRAY | POSE):
        if node.attr == "shape":
            result = result | state.container(node, TUPLE, T_INT)
        elif node.attr == "size":
            result = result | T_INT
        elif node.attr == "T":
            result = result | owner
    return result


def _sequence(state: InferenceState, node: ast.Tuple | ast.List) -> AbstractType:
    """Return the type of a tuple or list display, with a type for each item while its length is known."""
    elements, kind = node.elts, _SEQUENCE_KINDS[type(node)]
    if not any(isinstance(element, ast.Starred) for element in elements):
        return state.tuple_of(node, [expression_type(state, element) for element in elements], kind=kind)
    items: list[AbstractType] | None = []
    joined = NOTHING
    for element in elements:
        if isinstance(element, ast.Starred):
            value = expression_type(state, element.value)
            state.facts.types[element] = value
            sites = state.read_sites(value)
            joined = joined | state.elements(value)
            if items is not None and len(sites) == 1 and sites[0].items is not None and not value.kinds & ~SEQUENCES:
                items += sites[0].items
            else:
                items = None
        else:
            inferred = expression_type(state, element)
            joined = joined | inferred
            if items is not None:
                items.append(inferred)
    if items is not None:
        return state.tuple_of(node, items, kind=kind)
    return state.container(node, kind, joined)


def _set(state: InferenceState, node: ast.Set) -> AbstractType:
    return state.container(node, SET, join_all([expression_type(state, e) for e in node.elts]))


def _dict(state: InferenceState, node: ast.Dict) -> AbstractType:
    keys = values = other = NOTHING
    fields: dict[object, AbstractType] = {}
    for key, value in zip(node.keys, node.values):
        inferred = expression_type(state, value)
        if key is None:
            for site in state.read_sites(inferred):
                keys, values = keys | site.key, values | site.element
                for name, inner in site.fields.items():
                    fields[name] = fields.get(name, NOTHING) | inner
                other = other | site.other
            continue
        keys, values = keys | expression_type(state, key), values | inferred
        if isinstance(key, ast.Constant):
            fields[key.value] = fields.get(key.value, NOTHING) | inferred
        else:
            other = other | inferred
    return state.table(state.site(node, DICT), keys, values, fields, other)


def _comprehension(state: InferenceState, node: Comprehension) -> AbstractType:
    kind = _COMPREHENSION_KINDS[type(node)]
    for generator in node.generators:
        elements = state.elements(expression_type(state, generator.iter))
        state.facts.types[generator] = elements
        assign(state, generator.target, elements)
        for condition in generator.ifs:
            expression_type(state, condition)
            narrow(state, condition, True)
    if isinstance(node, ast.DictComp):
        key, value = expression_type(state, node.key), expression_type(state, node.value)
        return state.table(state.site(node, kind), key, value, {}, value)
    return state.container(node, kind, expression_type(state, node.elt))


def _starred(state: InferenceState, node: ast.Starred) -> AbstractType:
    return expression_type(state, node.value)


def _named_expression(state: InferenceState, node: ast.NamedExpr) -> AbstractType:
    value = expression_type(state, node.value)
    assign(state, node.target, value)
    return value


def _lambda(state: InferenceState, node: ast.Lambda) -> AbstractType:
    function = state.names.functions[node]
    infer_defaults(state, function)
    return AbstractType(FUNCTION, frozenset((function,)))


def _conditional(state: InferenceState, node: ast.IfExp) -> AbstractType:
    expression_type(state, node.test)
    saved = dict(state.env or {})
    narrow(state, node.test, True)
    first = expression_type(state, node.body)
    state.env = dict(saved)
    narrow(state, node.test, False)
    second = expression_type(state, node.orelse)
    state.env = saved
    return first | second


def _boolean(state: InferenceState, node: ast.BoolOp) -> AbstractType:
    saved = dict(state.env or {})
    result = NOTHING
    for position, value in enumerate(node.values):
        inferred = expression_type(state, value)
        if isinstance(node.op, ast.Or) and position < len(node.values) - 1:
            inferred = inferred.without(NONE)
        result = result | inferred
        narrow(state, value, isinstance(node.op, ast.And))
    state.env = saved
    return result


def _comparison(state: InferenceState, node: ast.Compare) -> AbstractType:
    kinds = expression_type(state, node.left).kinds
    for comparator in node.comparators:
        kinds |= expression_type(state, comparator).kinds
    is_containment = isinstance(node.ops[0], (ast.In, ast.NotIn, ast.Is, ast.IsNot))
    if kinds & ARRAY and not is_containment:
        return state.container(node, ARRAY, T_INT, T_BOOL)
    return T_BOOL


def _unary(state: InferenceState, node: ast.UnaryOp) -> AbstractType:
    operand = expression_type(state, node.operand)
    if isinstance(node.op, ast.Not):
        return T_BOOL
    return T_INT if operand.only(BOOL) else operand


def _binary(state: InferenceState, node: ast.BinOp) -> AbstractType:
    left = expression_type(state, node.left)
    return operation(state, node, node.op, left, expression_type(state, node.right))


def _by_method(
    state: InferenceState, node: ast.AST, op: ast.operator, left: AbstractType, right: AbstractType
) -> AbstractType | None:
    """Return the type of an operation that a method of an operand implements, None without such a method."""
    name = OPERATOR_METHODS.get(type(op), "")
    in_place = [(left, right, f"i{name}")] if isinstance(node, ast.AugAssign) else []
    for own, other, method in (*in_place, (left, right, name), (right, left, f"r{name}")):
        owners = own.classes if own.kinds & RECORD else frozenset()
        if owners and all(method in record.methods for record in owners):
            if not other.kinds:
                return NOTHING  # so far; a method may have cases for types of operands
            names = {record.name for record in other.classes}
            results = []
            for record in owners:
                function = record.methods[method_for(record, method, other.kinds, names)]
                instance = AbstractType(RECORD, frozenset((record,)))
                results.append(call_function(state, function, node, [instance, other], {}))
            return join_all(results)
    return None


def operation(
    state: InferenceState, node: ast.AST, op: ast.operator, left: AbstractType, right: AbstractType
) -> AbstractType:
    """Return the type of ``left op right``."""
    by_method = _by_method(state, node, op, left, right)
    if by_method is not None:
        return by_method
    kinds = left.kinds | right.kinds
    if not left.kinds or (not right.kinds and not left.kinds & SEQUENCES):
        known = left | right
        return known if known.only(NUMBERS | ARRAY | STR | SHAPE) else NOTHING
    result = NOTHING
    if kinds & ARRAY and isinstance(op, (ast.BitAnd, ast.BitOr)):
        return state.container(node, ARRAY, T_INT, T_BOOL)
    if kinds & (ARRAY | POSE):
        if isinstance(op, ast.MatMult) and left.kinds & POSE and right.kinds & POSE:
            result = T_POSE
        elif isinstance(op, ast.MatMult):
            result = state.container(node, ARRAY, T_FLOAT)
        else:
            result = _array_result(state, node, left, right)
        if not (left.only(ARRAY | POSE) or right.only(ARRAY | POSE)):
            result = result | operation(state, node, op, left.without(ARRAY | POSE), right.without(ARRAY | POSE))
        return result
    if isinstance(op, ast.Add) and kinds & (SEQUENCES | SHAPE):
        if kinds & SHAPE:
            return T_SHAPE
        a, b = left.sites, right.sites
        if len(a) == len(b) == 1 and a[0].items is not None and b[0].items is not None and a[0].kind == b[0].kind:
            state.read_sites(left | right)
            return state.tuple_of(node, [*a[0].items, *b[0].items], kind=a[0].kind)
        return state.container(node, kinds & SEQUENCES or LIST, state.elements(left | right))
    if isinstance(op, ast.Mult) and kinds & (SEQUENCES | SHAPE | STR):
        if kinds & STR:
            return T_STR
        if kinds & SHAPE:
            return T_SHAPE
        return _repeated(state, node, left if left.kinds & SEQUENCES else right, kinds)
    if kinds & SET and isinstance(op, (ast.BitAnd, ast.BitOr, ast.Sub, ast.BitXor)):
        return state.container(node, SET, state.elements(left | right))
    if kinds & DICT and isinstance(op, ast.BitOr):
        sites = state.read_sites(left | right)
        return state.container(node, DICT, join_all([s.element for s in sites]), join_all([s.key for s in sites]))
    if left.kinds & STR and isinstance(op, (ast.Add, ast.Mod)):
        return T_STR if left.only(STR) else T_STR | ANYTHING
    if kinds & UNKNOWN:
        return ANYTHING
    return _number_result(op, left, right)


def _repeated(state: InferenceState, node: ast.AST, value: AbstractType, kinds: int) -> AbstractType:
    count = node.right if isinstance(node, ast.BinOp) else None
    sites = state.read_sites(value)
    if (
        isinstance(count, ast.Constant)
        and isinstance(count.value, int)
        and 0 < count.value <= 16
        and len(sites) == 1
        and sites[0].items is not None
    ):
        return state.tuple_of(node, sites[0].items * count.value, kind=sites[0].kind)
    return state.container(node, kinds & SEQUENCES, state.elements(value))


def _array_result(state: InferenceState, node: ast.AST, left: AbstractType, right: AbstractType) -> AbstractType:
    """Return the type of an elementwise operation, with the dimensions of the operand that has more."""
    element = NOTHING
    for value in (left, right):
        if value.kinds & ARRAY:
            element = element | state.elements(value)
        elif value.kinds & POSE:
            element = element | AbstractType(ARRAY)
    if element.kinds & ARRAY and element.kinds & NUMBERS:
        element = element.without(NUMBERS)
    return state.container(node, ARRAY, element if element.kinds else T_FLOAT)


def _joined_string(state: InferenceState, node: ast.JoinedStr) -> AbstractType:
    for value in node.values:
        if isinstance(value, ast.FormattedValue):
            expression_type(state, value.value)
    return T_STR


def _slice_bounds(state: InferenceState, node: ast.Slice) -> AbstractType:
    for part in (node.lower, node.upper, node.step):
        if part is not None:
            expression_type(state, part)
    return NOTHING


def _subscript(state: InferenceState, node: ast.Subscript) -> AbstractType:
    return _item_of(state, node, expression_type(state, node.value), node.slice)


def _item_of(state: InferenceState, node: ast.AST, value: AbstractType, index: ast.expr) -> AbstractType:
    """Return the type of ``value[index]``."""
    key = expression_type(state, index)
    result = ANYTHING if value.kinds & UNKNOWN else NOTHING
    if isinstance(index, ast.Slice):
        return result | _slice(state, node, value, index)
    if value.kinds & STR:
        result = result | T_STR
    if value.kinds & SHAPE:
        result = result | T_SHAPE
    position = constant_index(index)
    for site in state.read_sites(value):
        if site.kind & SEQUENCES and position is not None and site.items is not None:
            if -len(site.items) <= position < len(site.items):
                result = result | site.items[position]
        elif site.kind == ARRAY:
            result = result | _array_item(state, node, site, index, key)
        elif site.kind == POSE:
            continue
        elif site.kind == DICT:
            result = result | state.field(site, index)
        else:
            result = result | site.element
    if value.kinds & POSE:
        result = result | _pose_item(state, node, index)
    elif value.kinds & ARRAY and not value.sites:
        result = result | T_FLOAT
    return result


def _pose_item(state: InferenceState, node: ast.AST, index: ast.expr) -> AbstractType:
    """Return the type of a number, row or submatrix of a 4x4 matrix."""
    if not isinstance(index, ast.Tuple):
        return AbstractType(ARRAY)
    axes = sum(isinstance(axis, ast.Slice) for axis in index.elts) + max(2 - len(index.elts), 0)
    if axes == 0:
        return T_FLOAT
    return state.container(node, ARRAY, AbstractType(ARRAY) if axes > 1 else T_FLOAT, tag="part")


def _array_item(state: InferenceState, node: ast.AST, site: Site, index: ast.expr, key: AbstractType) -> AbstractType:
    if isinstance(index, ast.Tuple):
        if any(isinstance(axis, ast.Constant) and axis.value is None for axis in index.elts):
            return state.container(node, ARRAY, AbstractType(ARRAY))
        if has_slice(index):
            is_matrix = sum(isinstance(axis, ast.Slice) for axis in index.elts) > 1
            return state.container(node, ARRAY, AbstractType(ARRAY) if is_matrix else T_FLOAT)
        inferred = AbstractType(ARRAY, frozenset((site,)))
        for _ in index.elts:
            inferred = state.elements(inferred)
        return inferred if inferred.kinds else T_FLOAT
    if key.kinds & (ARRAY | LIST):
        return state.container(node, ARRAY, site.element)
    return site.element


def _slice(state: InferenceState, node: ast.AST, value: AbstractType, index: ast.Slice) -> AbstractType:
    result = AbstractType(value.kinds & STR) | (T_SHAPE if value.kinds & SHAPE else NOTHING)
    sites = state.read_sites(value)
    bounds = [constant_index(b) if b is not None else "" for b in (index.lower, index.upper, index.step)]
    is_known = None not in bounds and bounds[2] != 0
    if len(sites) == 1 and sites[0].items is not None and is_known and sites[0].kind & SEQUENCES:
        lower, upper, step = (b if isinstance(b, int) else None for b in bounds)
        return result | state.tuple_of(node, sites[0].items[lower:upper:step], kind=sites[0].kind)
    for kind in (LIST, TUPLE, ARRAY):
        if value.kinds & kind:
            element = join_all([s.element for s in sites if s.kind == kind])
            result = result | state.container(node, kind, element, tag=str(kind))
    if value.kinds & POSE:
        result = result | state.container(node, ARRAY, AbstractType(ARRAY), tag="rows")
    return result


def _yield(state: InferenceState, node: ast.Yield) -> AbstractType:
    value = expression_type(state, node.value) if node.value is not None else T_NONE
    state.add_return(state.function, state.container(state.function.node, LIST, value))
    return T_NONE


def _yield_from(state: InferenceState, node: ast.YieldFrom) -> AbstractType:
    value = state.elements(expression_type(state, node.value))
    state.add_return(state.function, state.container(state.function.node, LIST, value))
    return T_NONE


def _number_result(op: ast.operator, left: AbstractType, right: AbstractType) -> AbstractType:
    if isinstance(op, ast.Div):
        return T_FLOAT
    if left.only(INT | BOOL) and right.only(INT | BOOL):
        return T_NUMBER if isinstance(op, ast.Pow) else T_INT
    if left.only(FLOAT) or right.only(FLOAT):
        return T_FLOAT
    return T_NUMBER


_SEQUENCE_KINDS = {ast.Tuple: TUPLE, ast.List: LIST}
_COMPREHENSION_KINDS = {ast.ListComp: LIST, ast.GeneratorExp: LIST, ast.SetComp: SET, ast.DictComp: DICT}
_EXPRESSIONS: Mapping[type[ast.expr], Callable[[InferenceState, Any], AbstractType]] = MappingProxyType({
    ast.Attribute: _attribute, ast.BinOp: _binary, ast.BoolOp: _boolean, ast.Call: _call_expression,
    ast.Compare: _comparison, ast.Constant: _constant, ast.Dict: _dict, ast.DictComp: _comprehension,
    ast.GeneratorExp: _comprehension, ast.IfExp: _conditional, ast.JoinedStr: _joined_string, ast.Lambda: _lambda,
    ast.List: _sequence, ast.ListComp: _comprehension, ast.Name: _name, ast.NamedExpr: _named_expression,
    ast.Set: _set, ast.SetComp: _comprehension, ast.Slice: _slice_bounds, ast.Starred: _starred,
    ast.Subscript: _subscript, ast.Tuple: _sequence, ast.UnaryOp: _unary, ast.Yield: _yield, ast.YieldFrom: _yield_from,
})  # fmt: skip


# Targets of assignments.


def target_type(state: InferenceState, target: ast.expr) -> AbstractType:
    """Return the type of an assignment target before the assignment."""
    if isinstance(target, ast.Name):
        variable = state.names.variables.get(target)
        inferred = state.load(variable) if variable is not None else ANYTHING
    elif isinstance(target, ast.Subscript):
        inferred = _item_of(state, target, expression_type(state, target.value), target.slice)
    elif isinstance(target, ast.Attribute):
        inferred = _attribute_of(state, target, expression_type(state, target.value))
    else:
        inferred = ANYTHING
    state.facts.types[target] = inferred
    return inferred


def assign(state: InferenceState, target: ast.expr, value: AbstractType) -> None:
    """Assign a value of the given type to a target."""
    if isinstance(target, ast.Name):
        variable = state.names.variables.get(target)
        if variable is not None:
            if variable.function is not state.function:
                state.effect(target, CHANGES)
            state.store(variable, value)
        state.facts.types[target] = value
    elif isinstance(target, (ast.Tuple, ast.List)):
        _unpack(state, target.elts, value, target)
    elif isinstance(target, ast.Starred):
        assign(state, target.value, value)
    elif isinstance(target, ast.Subscript):
        container = expression_type(state, target.value)
        key = expression_type(state, target.slice)
        is_slice = isinstance(target.slice, ast.Slice)
        for site in container.sites:
            if site.kind == DICT and isinstance(target.slice, ast.Constant):
                state.table(site, key, value, {target.slice.value: value}, NOTHING)
            elif site.kind == DICT:
                state.table(site, key, value, {}, value)
        state.mutate(container, state.elements(value) if is_slice else value, key, target, constant_index(target.slice))
    elif isinstance(target, ast.Attribute):
        owner = expression_type(state, target.value)
        for record in owner.classes:
            state.set_field(record, target.attr, value)
        state.effect(target, CHANGES)


def _unpack(state: InferenceState, targets: list[ast.expr], value: AbstractType, node: ast.AST) -> None:
    star = next((i for i, t in enumerate(targets) if isinstance(t, ast.Starred)), None)
    after = 0 if star is None else len(targets) - star - 1
    for position, target in enumerate(targets):
        if position == star:
            assign(state, target, _star(state, value, position, after, target))
        elif star is None or position < star:
            assign(state, target, state.item_at(value, position))
        else:
            assign(state, target, state.item_at(value, position - len(targets)))


def _star(state: InferenceState, value: AbstractType, before: int, after: int, node: ast.AST) -> AbstractType:
    items: list[AbstractType] | None = None
    for site in state.read_sites(value):
        if site.items is not None and len(value.sites) == 1:
            items = site.items[before : len(site.items) - after]
    if items is not None:
        return state.tuple_of(node, items, kind=LIST)
    return state.container(node, LIST, state.elements(value))

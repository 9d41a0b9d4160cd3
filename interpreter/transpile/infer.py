"""Type inference: what kinds of values every expression of the Python may have.

The whole program is interpreted over abstract values (``domain``): flow-sensitive inside a function, the arguments of
all call sites joined, containers by the place that makes them. Functions are looked at again until nothing grows.
"""

from __future__ import annotations

import ast
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

from scenelang.interpreter.transpile.annotations import annotated
from scenelang.interpreter.transpile.domain import (
    ANYTHING,
    ARRAY,
    BOOL,
    CONTAINERS,
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
    Site,
    Type,
)
from scenelang.interpreter.transpile.known import METHODS, MUTATORS, RESULTS, draws
from scenelang.interpreter.transpile.paths import Paths, is_annotation, is_module
from scenelang.interpreter.transpile.scopes import Class, Comprehension, Function, Names, Variable

Environment = dict[Variable, Type]
DRAWS, CHANGES = 1, 2
_MOST_VISITS = 40


@dataclass(eq=False)
class Facts:
    """What inference found out."""

    types: dict[ast.AST, Type] = field(default_factory=dict)
    variables: dict[Variable, Type] = field(default_factory=dict)
    returns: dict[Function, Type] = field(default_factory=dict)
    targets: dict[ast.Call, list[Function]] = field(default_factory=dict)
    callbacks: dict[ast.AST, set[Function]] = field(default_factory=dict)
    effects: dict[Function, int] = field(default_factory=dict)
    effect_nodes: dict[ast.AST, int] = field(default_factory=dict)
    words: dict[str, Function] = field(default_factory=dict)
    reached: set[Function] = field(default_factory=set)

    def type(self, node: ast.AST) -> Type:
        return self.types.get(node, NOTHING)


def infer(
    names: Names, paths: Paths, words: dict[str, Function], root: Function | None, additions: set[ast.AST]
) -> Facts:
    """Infer the types of a program. ``words`` maps what ``library_call`` may say to registered functions; what
    ``additions`` add to lists does not count as changing them."""
    inference = _Inference(names, paths, words, additions)
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


def _propagate_effects(inference: _Inference) -> None:
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


class _Inference:
    def __init__(self, names: Names, paths: Paths, words: dict[str, Function], additions: set[ast.AST]) -> None:
        self.additions = additions
        self.names = names
        self.paths = paths
        self.facts = Facts(words=words)
        self.sites: dict[tuple[ast.AST, str], Site] = {}
        self.callees: dict[Function, set[Function]] = {}
        self.callers: dict[Function, set[Function]] = {}
        self.function = names.module
        self.env: Environment | None = {}
        self.queue: deque[Function] = deque()
        self.visits: dict[Function, int] = {}
        self.exits: list[list[Environment]] = []

    # --- the work list -----------------------------------------------------------------------------------------

    def enqueue(self, function: Function) -> None:
        if function not in self.queue and self.visits.get(function, 0) < _MOST_VISITS:
            self.queue.append(function)

    def run(self) -> None:
        while self.queue:
            function = self.queue.popleft()
            self.visits[function] = self.visits.get(function, 0) + 1
            self.facts.reached.add(function)
            self._analyse(function)

    def _analyse(self, function: Function) -> None:
        saved = self.function, self.env, self.exits
        self.function, self.exits = function, []
        self.env = {p.variable: self.facts.variables.get(p.variable, NOTHING) for p in function.parameters}
        node = function.node
        if isinstance(node, ast.Lambda):
            self._returned(function, self.expression(node.body))
        else:
            self.block(node.body)
            if self.env is not None and not isinstance(node, ast.Module) and not function.is_generator:
                self._returned(function, T_NONE)
        self.function, self.env, self.exits = saved

    def assume_annotations(self, function: Function) -> None:
        for parameter in function.parameters:
            if parameter.kind in ("plain", "keyword"):
                known = annotated(parameter.annotation)
                if parameter.default is not None:
                    known = known | self.facts.type(parameter.default)
                self.store(parameter.variable, known)

    def _returned(self, function: Function, found: Type) -> None:
        old = self.facts.returns.get(function, NOTHING)
        new = old | found
        if new is not old:
            self.facts.returns[function] = new
            for caller in self.callers.get(function, ()):
                self.enqueue(caller)

    # --- variables and sites -----------------------------------------------------------------------------------

    def store(self, variable: Variable, value: Type) -> None:
        """Assign: here for this function's own flow, and joined for all others."""
        if self.env is not None and variable.function is self.function:
            self.env[variable] = value
        old = self.facts.variables.get(variable, NOTHING)
        new = old | value
        if new is not old:
            self.facts.variables[variable] = new
            for reader in variable.readers:
                if reader is not self.function:
                    self.enqueue(reader)
            if variable.is_parameter and variable.function is not None and variable.function is not self.function:
                self.enqueue(variable.function)

    def load(self, variable: Variable) -> Type:
        if variable.function is self.function and self.env is not None and not variable.is_assigned_elsewhere:
            found = self.env.get(variable)
            if found is not None:
                return found
        return self.facts.variables.get(variable, NOTHING)

    def site(self, node: ast.AST, kind: int, tag: str = "") -> Site:
        found = self.sites.get((node, tag))
        if found is None:
            found = self.sites[node, tag] = Site(node, kind)
        return found

    def grow(self, site: Site, element: Type, key: Type = NOTHING, items: Sequence[Type] | None = None) -> Type:
        """Note what a site holds; gives the type of what it makes. Readers are looked at again when it grew."""
        joined, joined_key = site.element | element, site.key | key
        changed = joined is not site.element or joined_key is not site.key
        site.element, site.key = joined, joined_key
        if items is not None:
            if site.items is None and not site.readers and site.element is element:
                site.items = list(items)
                changed = True
            elif site.items is not None and len(site.items) == len(items):
                merged = [a | b for a, b in zip(site.items, items)]
                changed |= any(a is not b for a, b in zip(site.items, merged))
                site.items = merged
        if changed:
            for reader in site.readers:
                if reader is not self.function:
                    self.enqueue(reader)
        return Type(site.kind, frozenset((site,)))

    def container(self, node: ast.AST, kind: int, element: Type, key: Type = NOTHING, tag: str = "") -> Type:
        return self.grow(self.site(node, kind, tag), element, key)

    def tuple_of(self, node: ast.AST, items: Sequence[Type], tag: str = "", kind: int = TUPLE) -> Type:
        """A sequence of known length."""
        site = self.site(node, kind, tag)
        if site.items is None and not site.element.kinds:
            site.items = [NOTHING] * len(items)
        return self.grow(site, _join(items), items=items)

    def read_sites(self, value: Type) -> list[Site]:
        sites = value.sites
        for site in sites:
            site.readers.add(self.function)
        return sites

    def elements(self, value: Type) -> Type:
        """What iterating ``value`` gives."""
        result = NOTHING
        if value.kinds & SHAPE:
            result = result | T_SHAPE
        if value.kinds & STR:
            result = result | T_STR
        if value.kinds & UNKNOWN:
            result = result | ANYTHING
        for site in self.read_sites(value):
            result = result | (site.key if site.kind == DICT else site.element)
        if value.kinds & POSE:
            result = result | Type(ARRAY)
        if value.kinds & ARRAY and not value.sites:
            result = result | T_NUMBER
        return result

    def mutated(self, value: Type, element: Type = NOTHING, key: Type = NOTHING, node: ast.AST | None = None) -> None:
        """The containers that ``value`` may be are changed in place, taking in ``element``."""
        for site in self.read_sites(value):
            if site.kind & (CONTAINERS | ARRAY):
                if not site.is_mutated and node not in self.additions:
                    site.is_mutated = True
                    for reader in site.readers:
                        self.enqueue(reader)
                site.items = None if element.kinds else site.items
                self.grow(site, element, key)
        if node is not None and node not in self.additions:
            is_own = bool(value.sites) and all(_belongs(site.node, self.function) for site in value.sites)
            self.effect(node, 0 if is_own else CHANGES, here=CHANGES)

    def effect(self, node: ast.AST, effect: int, here: int = 0) -> None:
        """Note that evaluating ``node`` does something; ``here`` is what matters inside this function only."""
        self.facts.effect_nodes[node] = self.facts.effect_nodes.get(node, 0) | effect | here
        if effect:
            self.facts.effects[self.function] = self.facts.effects.get(self.function, 0) | effect

    # --- statements --------------------------------------------------------------------------------------------

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
        if old.kinds & ARRAY:
            self.mutated(old, node=node)
        result = self.operation(node, node.op, old, value)
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
            self.mutated(container, self.elements(value) if is_slice else value, key, node=target)
        elif isinstance(target, ast.Attribute):
            owner = self.expression(target.value)
            for record in owner.classes:
                self._set_field(record, target.attr, value)
            self.effect(target, CHANGES)

    def _set_field(self, record: Class, name: str, value: Type) -> None:
        self.grow(self.site(record.node, DICT, f".{name}"), value)

    def _unpack(self, targets: list[ast.expr], value: Type, node: ast.AST) -> None:
        star = next((i for i, t in enumerate(targets) if isinstance(t, ast.Starred)), None)
        after = 0 if star is None else len(targets) - star - 1
        for position, target in enumerate(targets):
            if position == star:
                self.assign(target, self._star(value, position, after, target))
            elif star is None or position < star:
                self.assign(target, self._at(value, position))
            else:
                self.assign(target, self._at(value, position - len(targets)))

    def _at(self, value: Type, position: int) -> Type:
        result = NOTHING
        for site in self.read_sites(value):
            if site.kind & SEQUENCES and site.items is not None and -len(site.items) <= position < len(site.items):
                result = result | site.items[position]
            else:
                result = result | (site.key if site.kind == DICT else site.element)
        return result | self.elements(value.without(CONTAINERS | (ARRAY if value.sites else 0)).bare())

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
        self._defaults(function)
        if function.variable is not None:
            self.store(function.variable, Type(FUNCTION, frozenset((function,))))

    def _defaults(self, function: Function) -> None:
        for parameter in function.parameters:
            if parameter.default is not None:
                self.expression(parameter.default)

    def _ClassDef(self, node: ast.ClassDef) -> None:
        record = self.names.classes.get(node)
        if record is None:
            return
        for name, default in record.fields:
            if default is not None:
                self._set_field(record, name, self.expression(default))
        for value in record.constants.values():
            self.expression(value)
        for method in record.methods.values():
            self._defaults(method)
            if method.parameters and not method.is_static:
                self.store(method.parameters[0].variable, Type(RECORD, frozenset((record,))))
        self.store(record.variable, Type(FUNCTION, frozenset((record,))))

    # --- narrowing ---------------------------------------------------------------------------------------------

    def narrow(self, test: ast.expr, holds: bool) -> None:
        """What a test says about the variables in it."""
        if isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not):
            self.narrow(test.operand, not holds)
        elif isinstance(test, ast.BoolOp) and isinstance(test.op, ast.And) == holds:
            for value in test.values:
                self.narrow(value, holds)
        elif isinstance(test, ast.Name) and holds:
            self._without(test, NONE)
        elif isinstance(test, ast.Compare) and len(test.ops) == 1 and _is_none(test.comparators[0]):
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

    # --- expressions -------------------------------------------------------------------------------------------

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
        return self.container(node, SET, _join([self.expression(e) for e in node.elts]))

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

    def table(self, site: Site, keys: Type, values: Type, fields: dict[object, Type], other: Type) -> Type:
        """Note what a table holds: by key where keys are constants."""
        changed = False
        for name, found in fields.items():
            old = site.fields.get(name, NOTHING)
            site.fields[name] = old | found
            changed |= site.fields[name] is not old
        joined = site.other | other
        changed |= joined is not site.other
        site.other = joined
        if changed:
            for reader in site.readers:
                if reader is not self.function:
                    self.enqueue(reader)
        return self.grow(site, values, keys)

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
        self._defaults(function)
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
        return Type(ARRAY) if kinds & ARRAY and not is_containment else T_BOOL

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
            return self.container(node, DICT, _join([s.element for s in sites]), _join([s.key for s in sites]))
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
        position = _constant_index(index)
        for site in self.read_sites(value):
            if site.kind & SEQUENCES and position is not None and site.items is not None:
                if -len(site.items) <= position < len(site.items):
                    result = result | site.items[position]
            elif site.kind == ARRAY:
                result = result | self._array_item(node, site, index, key)
            elif site.kind == DICT:
                result = result | self.field(site, index)
            else:
                result = result | site.element
        if value.kinds & POSE:
            result = result | (T_FLOAT if isinstance(index, ast.Tuple) and not _has_slice(index) else Type(ARRAY))
        elif value.kinds & ARRAY and not value.sites:
            result = result | T_FLOAT
        return result

    def field(self, site: Site, key: ast.expr) -> Type:
        """The value under a key of a table."""
        if isinstance(key, ast.Constant) and key.value in site.fields:
            return site.fields[key.value] | site.other
        return site.element

    def _array_item(self, node: ast.AST, site: Site, index: ast.expr, key: Type) -> Type:
        if isinstance(index, ast.Tuple):
            if _has_slice(index):
                return self.container(node, ARRAY, T_FLOAT)
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
        bounds = [_constant_index(b) if b is not None else "" for b in (index.lower, index.upper, index.step)]
        if len(sites) == 1 and sites[0].items is not None and None not in bounds and sites[0].kind & SEQUENCES:
            lower, upper, step = (b if isinstance(b, int) else None for b in bounds)
            return result | self.tuple_of(node, sites[0].items[lower:upper:step], kind=sites[0].kind)
        for kind in (LIST, TUPLE, ARRAY):
            if value.kinds & kind:
                element = _join([s.element for s in sites if s.kind == kind])
                result = result | self.container(node, kind, element, tag=str(kind))
        if value.kinds & POSE:
            result = result | Type(ARRAY)
        return result

    def _Yield(self, node: ast.Yield) -> Type:
        value = self.expression(node.value) if node.value is not None else T_NONE
        self._returned(self.function, self.container(self.function.node, LIST, value))
        return T_NONE

    def _YieldFrom(self, node: ast.YieldFrom) -> Type:
        value = self.elements(self.expression(node.value))
        self._returned(self.function, self.container(self.function.node, LIST, value))
        return T_NONE

    # --- calls -------------------------------------------------------------------------------------------------

    def _Call(self, node: ast.Call) -> Type:
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

    def _positional(self, node: ast.Call) -> list[Type]:
        positional: list[Type] = []
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

    def _call_path(self, path: str, node: ast.Call, positional: list[Type], named: dict[str, Type]) -> Type:
        self.facts.types[node.func] = Type(FUNCTION, frozenset((path,)))
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
        return result if isinstance(result, Type) else result(self, node, positional, named)

    def _library_call(self, node: ast.Call, positional: list[Type], named: dict[str, Type]) -> Type:
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
                            extra[parameter.variable.name] = site.element
            self.call_function(target, node, [], extra)
        return T_SHAPE

    def _call_method(self, node: ast.Call, func: ast.Attribute, positional: list[Type], named: dict[str, Type]) -> Type:
        owner = self.expression(func.value)
        result = NOTHING
        for record in owner.classes:
            method = record.methods.get(func.attr)
            if method is not None:
                is_instance = bool(owner.kinds & RECORD) and not method.is_static
                arguments = [Type(RECORD, frozenset((record,))), *positional] if is_instance else positional
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

    def call(self, function: Type, node: ast.AST, positional: list[Type], named: dict[str, Type]) -> Type:
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
            if isinstance(entry, Type):
                result = result | entry
            elif entry is not None:
                result = result | entry(self, node, positional, named)
        return result

    def call_function(self, function: Function, node: ast.AST, positional: list[Type], named: dict[str, Type]) -> Type:
        """Join the arguments into the parameters; what the function is known to return."""
        self.facts.callbacks.setdefault(node, set()).add(function)
        self.callees.setdefault(self.function, set()).add(function)
        self.callers.setdefault(function, set()).add(self.function)
        rest: list[Type] = []
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
                value = self.container(parameter.annotation or function.node, TUPLE, _join(rest), tag="*")
            elif parameter.kind == "keys":
                extra = [v for n, v in named.items() if n not in used]
                value = self.container(function.node, DICT, _join(extra), T_STR, tag="**")
            elif parameter.default is not None:
                value = self.facts.type(parameter.default)
            else:
                continue
            self._bind(function, parameter.variable, value)
        if function not in self.facts.reached:
            self.enqueue(function)
        return self.facts.returns.get(function, NOTHING)

    def _bind(self, function: Function, variable: Variable, value: Type) -> None:
        old = self.facts.variables.get(variable, NOTHING)
        new = old | value
        if new is not old:
            self.facts.variables[variable] = new
            self.enqueue(function)
            for reader in variable.readers:
                if reader is not function:
                    self.enqueue(reader)

    def _construct(self, record: Class, node: ast.AST, positional: list[Type], named: dict[str, Type]) -> Type:
        made = Type(RECORD, frozenset((record,)))
        constructor = record.methods.get("__init__")
        if constructor is not None:
            self.call_function(constructor, node, [made, *positional], named)
        else:
            for (name, _), value in zip(record.fields, positional):
                self._set_field(record, name, value)
            for name, value in named.items():
                self._set_field(record, name, value)
        return made


def _belongs(node: ast.AST, function: Function) -> bool:
    """Whether a site stands in the text of ``function`` itself, so that changing it is that function's own affair."""
    own = function.node
    if isinstance(own, ast.Module):
        return False
    line = getattr(node, "lineno", 0)
    return own.lineno <= line <= (own.end_lineno or own.lineno) and node is not own


def _merge(a: Environment | None, b: Environment | None) -> Environment | None:
    if a is None or b is None:
        return b if a is None else a
    merged = dict(a)
    for variable, value in b.items():
        old = merged.get(variable)
        merged[variable] = value if old is None else old | value
    return merged


def _join(types: Sequence[Type]) -> Type:
    result = NOTHING
    for each in types:
        result = result | each
    return result


def constant_type(value: object) -> Type:
    if isinstance(value, bool):
        return T_BOOL
    if isinstance(value, int):
        return T_INT
    if isinstance(value, float):
        return T_FLOAT
    if isinstance(value, str):
        return T_STR
    return T_NONE if value is None else ANYTHING


def _number_result(op: ast.operator, left: Type, right: Type) -> Type:
    if isinstance(op, ast.Div):
        return T_FLOAT
    if left.only(INT | BOOL) and right.only(INT | BOOL):
        return T_NUMBER if isinstance(op, ast.Pow) else T_INT
    if left.only(FLOAT) or right.only(FLOAT):
        return T_FLOAT
    return T_NUMBER


def _constant_index(node: ast.expr | None) -> int | None:
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        value = _constant_index(node.operand)
        return -value if value is not None else None
    if isinstance(node, ast.Constant) and type(node.value) is int:
        return node.value
    return None


def _has_slice(index: ast.Tuple) -> bool:
    return any(isinstance(element, ast.Slice) for element in index.elts)


def _is_none(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and node.value is None


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

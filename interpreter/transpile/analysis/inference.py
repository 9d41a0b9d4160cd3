"""What inference finds out, and the state that it works on."""

from __future__ import annotations

import ast
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

from scenelang.interpreter.transpile.analysis.annotations import annotated
from scenelang.interpreter.transpile.analysis.domain import (
    ANYTHING,
    ARRAY,
    CONTAINERS,
    DICT,
    NOTHING,
    POSE,
    SEQUENCES,
    SHAPE,
    STR,
    T_BOOL,
    T_FLOAT,
    T_INT,
    T_NONE,
    T_NUMBER,
    T_SHAPE,
    T_STR,
    TUPLE,
    UNKNOWN,
    Site,
    Type,
    join_all,
)
from scenelang.interpreter.transpile.analysis.paths import Paths
from scenelang.interpreter.transpile.analysis.scopes import Class, Function, Names, Variable

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


class InferenceState(ABC):
    """The state of an inference: facts, the work list, the flow of the function being looked at, the sites."""

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

    @abstractmethod
    def expression(self, node: ast.expr) -> Type:
        """The type of an expression, noted in the facts."""

    @abstractmethod
    def assign(self, target: ast.expr, value: Type) -> None:
        """Assign a value of this type to a target."""

    @abstractmethod
    def call(self, function: Type, node: ast.AST, positional: list[Type], named: dict[str, Type]) -> Type:
        """Call anything that may be a function."""

    @abstractmethod
    def call_function(self, function: Function, node: ast.AST, positional: list[Type], named: dict[str, Type]) -> Type:
        """Join the arguments into the parameters; what the function is known to return."""

    @abstractmethod
    def narrow(self, test: ast.expr, holds: bool) -> None:
        """What a test says about the variables in it."""

    @abstractmethod
    def block(self, body: Sequence[ast.stmt]) -> None:
        """Look at the statements of a block in order."""

    # --- the work list ---

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

    # --- variables and sites ---

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
        return self.grow(site, join_all(items), items=items)

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

    def mutated(
        self, value: Type, element: Type = NOTHING, key: Type = NOTHING, node: ast.AST | None = None,
        position: int | None = None,
    ) -> None:  # fmt: skip
        """The containers that ``value`` may be are changed in place, taking in ``element`` (``position``: where)."""
        for site in self.read_sites(value):
            if site.kind & (CONTAINERS | ARRAY | POSE):
                if not site.is_mutated and node not in self.additions:
                    site.is_mutated = True
                    for reader in site.readers:
                        self.enqueue(reader)
                self._put(site, element, position)
                self.grow(site, element, key)
        if node is not None and node not in self.additions:
            is_own = bool(value.sites) and all(_belongs(site.node, self.function) for site in value.sites)
            self.effect(node, 0 if is_own else CHANGES, here=CHANGES)

    def _put(self, site: Site, element: Type, position: int | None) -> None:
        if site.items is None or not element.kinds:
            return
        if position is None or not -len(site.items) <= position < len(site.items):
            site.items = None
            return
        old = site.items[position]
        if old | element is not old:
            site.items[position] = old | element
            for reader in site.readers:
                if reader is not self.function:
                    self.enqueue(reader)

    def effect(self, node: ast.AST, effect: int, here: int = 0) -> None:
        """Note that evaluating ``node`` does something; ``here`` is what matters inside this function only."""
        self.facts.effect_nodes[node] = self.facts.effect_nodes.get(node, 0) | effect | here
        if effect:
            self.facts.effects[self.function] = self.facts.effects.get(self.function, 0) | effect

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

    def field(self, site: Site, key: ast.expr) -> Type:
        """The value under a key of a table."""
        if isinstance(key, ast.Constant) and (site.fields or site.other.kinds):
            return site.fields.get(key.value, NOTHING) | site.other
        return site.element

    def at(self, value: Type, position: int) -> Type:
        result = NOTHING
        for site in self.read_sites(value):
            if site.kind & SEQUENCES and site.items is not None and -len(site.items) <= position < len(site.items):
                result = result | site.items[position]
            else:
                result = result | (site.key if site.kind == DICT else site.element)
        return result | self.elements(value.without(CONTAINERS | (ARRAY if value.sites else 0)).bare())

    def set_field(self, record: Class, name: str, value: Type) -> None:
        self.grow(self.site(record.node, DICT, f".{name}"), value)

    def defaults(self, function: Function) -> None:
        for parameter in function.parameters:
            if parameter.default is not None:
                self.expression(parameter.default)


def _belongs(node: ast.AST, function: Function) -> bool:
    """Whether a site stands in the text of ``function`` itself, so that changing it is that function's own affair."""
    own = function.node
    if isinstance(own, ast.Module):
        return False
    line = getattr(node, "lineno", 0)
    return own.lineno <= line <= (own.end_lineno or own.lineno) and node is not own


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


def constant_index(node: ast.expr | None) -> int | None:
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        value = constant_index(node.operand)
        return -value if value is not None else None
    if isinstance(node, ast.Constant) and type(node.value) is int:
        return node.value
    return None


def has_slice(index: ast.Tuple) -> bool:
    return any(isinstance(element, ast.Slice) for element in index.elts)

"""What inference finds out, and the state that it works on."""

from __future__ import annotations

import ast
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

from scenelang.interpreter.transpile.analysis.scopes import (
    Class,
    Function,
    LibraryPaths,
    PythonNames,
    PythonVariable,
    is_none,
)

# The abstract values of type inference: the kinds of things an expression may be, and where containers are made.


INT, FLOAT, BOOL, STR, NONE = 1, 2, 4, 8, 16
SHAPE, ARRAY, FUNCTION, LIST, TUPLE, DICT, SET = 32, 64, 128, 256, 512, 1024, 2048
RECORD, STREAM, MODULE, POSE, UNKNOWN = 4096, 8192, 16384, 32768, 65536

NUMBERS = INT | FLOAT | BOOL
SEQUENCES = LIST | TUPLE
CONTAINERS = LIST | TUPLE | DICT | SET


@dataclass(eq=False, slots=True)
class Site:
    """A place that makes containers (or arrays). What it holds only grows while inference runs.

    ``items``: the types position by position while the length is known; ``element`` their join. For tables: ``key``,
    ``fields`` by constant key, and ``other`` under the other keys.
    ``is_mutated``: the program changes what was made here.
    """

    node: ast.AST
    kind: int
    items: list[AbstractType] | None = None
    element: AbstractType = field(default_factory=lambda: AbstractType(0))
    key: AbstractType = field(default_factory=lambda: AbstractType(0))
    fields: dict[object, AbstractType] = field(default_factory=dict)
    other: AbstractType = field(default_factory=lambda: AbstractType(0))
    is_mutated: bool = False
    readers: set[Function] = field(default_factory=set)


Reference: TypeAlias = object


class AbstractType:
    """``kinds``: the kinds it may be of; ``references``: its sites, functions, classes and the names of modules."""

    __slots__ = ("kinds", "references")

    def __init__(self, kinds: int, references: frozenset[Reference] = frozenset()) -> None:
        self.kinds = kinds
        self.references = references

    def __or__(self, other: AbstractType) -> AbstractType:
        """The join; it is one of the two objects where that says it all, so that growth shows by identity."""
        if other is self or (not other.kinds & ~self.kinds and other.references <= self.references):
            return self
        if not self.kinds & ~other.kinds and self.references <= other.references:
            return other
        return AbstractType(self.kinds | other.kinds, self.references | other.references)

    def only(self, kinds: int) -> bool:
        """Whether it is known and nothing but ``kinds``."""
        return bool(self.kinds) and not self.kinds & ~kinds

    def may(self, kinds: int) -> bool:
        """Whether it may be of one of ``kinds``."""
        return bool(self.kinds & (kinds | UNKNOWN))

    def without(self, kinds: int) -> AbstractType:
        """The same, known not to be of ``kinds``."""
        return AbstractType(self.kinds & ~kinds, self.references)

    def bare(self) -> AbstractType:
        """The same kinds without references."""
        return AbstractType(self.kinds) if self.references else self

    @property
    def sites(self) -> list[Site]:
        return [r for r in self.references if type(r) is Site]

    @property
    def functions(self) -> list[Function]:
        return [r for r in self.references if type(r) is Function]

    @property
    def classes(self) -> list[Class]:
        return [r for r in self.references if type(r) is Class]

    @property
    def names(self) -> list[str]:
        """Dotted names of modules and known functions."""
        return [r for r in self.references if type(r) is str]


NOTHING = AbstractType(0)
ANYTHING = AbstractType(UNKNOWN)
T_INT = AbstractType(INT)
T_FLOAT = AbstractType(FLOAT)
T_NUMBER = AbstractType(INT | FLOAT)
T_BOOL = AbstractType(BOOL)
T_STR = AbstractType(STR)
T_NONE = AbstractType(NONE)
T_SHAPE = AbstractType(SHAPE)
T_POSE = AbstractType(POSE)
T_STREAM = AbstractType(STREAM)


def join_all(types: Sequence[AbstractType]) -> AbstractType:
    """What is of any of ``types``."""
    result = NOTHING
    for each in types:
        result = result | each
    return result


def never_equal(left: AbstractType, right: AbstractType, depth: int = 8) -> bool:
    """Whether no value of ``left`` equals one of ``right``, since one has a tuple where the other has a list."""
    if not depth or not left.only(SEQUENCES) or not right.only(SEQUENCES):
        return False
    if not left.kinds & right.kinds:
        return True
    pairs = [(a, b) for a in left.sites for b in right.sites if a.kind == b.kind]
    return bool(pairs) and all(_sites_differ(a, b, depth - 1) for a, b in pairs)


def _sites_differ(left: Site, right: Site, depth: int) -> bool:
    holds = any(site.items and not site.is_mutated for site in (left, right))  # else both may be empty
    if holds and never_equal(left.element, right.element, depth):
        return True
    if left.items is None or right.items is None:
        return False
    if left.is_mutated or right.is_mutated or len(left.items) != len(right.items):
        return False
    return any(never_equal(a, b, depth) for a, b in zip(left.items, right.items))


# What annotations say about types; inference falls back on them where no call site tells more.


_SIMPLE = {"int": T_INT, "float": T_FLOAT, "bool": T_BOOL, "str": T_STR, "Shape": T_SHAPE, "None": T_NONE}


def annotated(annotation: ast.expr | None) -> AbstractType:
    """The type that an annotation tells for sure; NOTHING where it does not."""
    if isinstance(annotation, ast.Name):
        return _SIMPLE.get(annotation.id, NOTHING)
    if isinstance(annotation, ast.Constant):
        return T_NONE if annotation.value is None else _SIMPLE.get(str(annotation.value), NOTHING)
    if isinstance(annotation, ast.Attribute) and annotation.attr == "ndarray":
        return AbstractType(ARRAY)
    if isinstance(annotation, ast.Subscript) and isinstance(annotation.value, ast.Name):
        if annotation.value.id == "Optional":
            return annotated(annotation.slice) | T_NONE
    if isinstance(annotation, ast.BinOp):
        return annotated(annotation.left) | annotated(annotation.right)
    return NOTHING


Environment = dict[PythonVariable, AbstractType]
DRAWS, CHANGES = 1, 2
_MOST_VISITS = 40


@dataclass(eq=False)
class TypeFacts:
    """What inference found out."""

    types: dict[ast.AST, AbstractType] = field(default_factory=dict)
    variables: dict[PythonVariable, AbstractType] = field(default_factory=dict)
    returns: dict[Function, AbstractType] = field(default_factory=dict)
    targets: dict[ast.Call, list[Function]] = field(default_factory=dict)
    callbacks: dict[ast.AST, set[Function]] = field(default_factory=dict)
    effects: dict[Function, int] = field(default_factory=dict)
    effect_nodes: dict[ast.AST, int] = field(default_factory=dict)
    words: dict[str, Function] = field(default_factory=dict)
    reached: set[Function] = field(default_factory=set)

    def type(self, node: ast.AST) -> AbstractType:
        return self.types.get(node, NOTHING)


CallValue: TypeAlias = (
    "Callable[[InferenceState, AbstractType, ast.AST, list[AbstractType], dict[str, AbstractType]], AbstractType]"
)


class InferenceState:
    """The state of an inference: facts, the work list, the flow of the function being looked at, the sites. ``call``
    looks at a call of anything that may be a function: library functions that call what they are given come back
    to the inference through it."""

    def __init__(
        self,
        names: PythonNames,
        paths: LibraryPaths,
        words: dict[str, Function],
        additions: set[ast.AST],
        call: CallValue,
    ) -> None:
        self._call = call
        self.additions = additions
        self.names = names
        self.paths = paths
        self.facts = TypeFacts(words=words)
        self.sites: dict[tuple[ast.AST, str], Site] = {}
        self.callees: dict[Function, set[Function]] = {}
        self.callers: dict[Function, set[Function]] = {}
        self.function = names.module
        self.env: Environment | None = {}
        self.queue: deque[Function] = deque()
        self.visits: dict[Function, int] = {}
        self.exits: list[list[Environment]] = []

    def call(
        self, function: AbstractType, node: ast.AST, positional: list[AbstractType], named: dict[str, AbstractType]
    ) -> AbstractType:
        """Call anything that may be a function."""
        return self._call(self, function, node, positional, named)

    # --- the work list ---

    def enqueue(self, function: Function) -> None:
        if function not in self.queue and self.visits.get(function, 0) < _MOST_VISITS:
            self.queue.append(function)

    def returned(self, function: Function, found: AbstractType) -> None:
        """Note what a function returns; its callers are looked at again when that grew."""
        old = self.facts.returns.get(function, NOTHING)
        new = old | found
        if new is not old:
            self.facts.returns[function] = new
            for caller in self.callers.get(function, ()):
                self.enqueue(caller)

    # --- variables and sites ---

    def store(self, variable: PythonVariable, value: AbstractType) -> None:
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

    def load(self, variable: PythonVariable) -> AbstractType:
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

    def grow(
        self,
        site: Site,
        element: AbstractType,
        key: AbstractType = NOTHING,
        items: Sequence[AbstractType] | None = None,
    ) -> AbstractType:
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
        return AbstractType(site.kind, frozenset((site,)))

    def container(
        self, node: ast.AST, kind: int, element: AbstractType, key: AbstractType = NOTHING, tag: str = ""
    ) -> AbstractType:
        return self.grow(self.site(node, kind, tag), element, key)

    def tuple_of(self, node: ast.AST, items: Sequence[AbstractType], tag: str = "", kind: int = TUPLE) -> AbstractType:
        """A sequence of known length."""
        site = self.site(node, kind, tag)
        if site.items is None and not site.element.kinds:
            site.items = [NOTHING] * len(items)
        return self.grow(site, join_all(items), items=items)

    def read_sites(self, value: AbstractType) -> list[Site]:
        sites = value.sites
        for site in sites:
            site.readers.add(self.function)
        return sites

    def elements(self, value: AbstractType) -> AbstractType:
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
            result = result | AbstractType(ARRAY)
        if value.kinds & ARRAY and not value.sites:
            result = result | T_NUMBER
        return result

    def mutated(
        self, value: AbstractType, element: AbstractType = NOTHING, key: AbstractType = NOTHING,
        node: ast.AST | None = None, position: int | None = None,
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

    def _put(self, site: Site, element: AbstractType, position: int | None) -> None:
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

    def table(
        self,
        site: Site,
        keys: AbstractType,
        values: AbstractType,
        fields: dict[object, AbstractType],
        other: AbstractType,
    ) -> AbstractType:
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

    def field(self, site: Site, key: ast.expr) -> AbstractType:
        """The value under a key of a table."""
        if isinstance(key, ast.Constant) and (site.fields or site.other.kinds):
            return site.fields.get(key.value, NOTHING) | site.other
        return site.element

    def at(self, value: AbstractType, position: int) -> AbstractType:
        result = NOTHING
        for site in self.read_sites(value):
            if site.kind & SEQUENCES and site.items is not None and -len(site.items) <= position < len(site.items):
                result = result | site.items[position]
            else:
                result = result | (site.key if site.kind == DICT else site.element)
        return result | self.elements(value.without(CONTAINERS | (ARRAY if value.sites else 0)).bare())

    def set_field(self, record: Class, name: str, value: AbstractType) -> None:
        self.grow(self.site(record.node, DICT, f".{name}"), value)


def _belongs(node: ast.AST, function: Function) -> bool:
    """Whether a site stands in the text of ``function`` itself, so that changing it is that function's own affair."""
    own = function.node
    if isinstance(own, ast.Module):
        return False
    line = getattr(node, "lineno", 0)
    return own.lineno <= line <= (own.end_lineno or own.lineno) and node is not own


def constant_type(value: object) -> AbstractType:
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


# The flow: what a test says about the variables in it, and where branches meet.


def narrow(state: InferenceState, test: ast.expr, holds: bool) -> None:
    """What a test says about the variables in it."""
    if isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not):
        narrow(state, test.operand, not holds)
    elif isinstance(test, ast.BoolOp) and isinstance(test.op, ast.And) == holds:
        for value in test.values:
            narrow(state, value, holds)
    elif isinstance(test, ast.Name) and holds:
        _without(state, test, NONE)
    elif isinstance(test, ast.Compare) and len(test.ops) == 1 and is_none(test.comparators[0]):
        is_test = isinstance(test.ops[0], (ast.Is, ast.Eq))
        if is_test != holds:
            _without(state, test.left, NONE)
        elif isinstance(test.left, ast.Name):
            _keep(state, test.left, NONE)
    elif isinstance(test, ast.Call) and state.paths.of(test.func) == "isinstance" and len(test.args) == 2:
        kinds = _isinstance_kinds(state.paths, test.args[1])
        if kinds and holds:
            _keep(state, test.args[0], kinds)
        elif kinds:
            _without(state, test.args[0], kinds)


def _without(state: InferenceState, node: ast.expr, kinds: int) -> None:
    if isinstance(node, ast.Name) and state.env is not None:
        variable = state.names.variables.get(node)
        if variable is not None and variable in state.env:
            found = state.env[variable]
            if found.kinds & kinds:
                state.env[variable] = found.without(kinds)


def _keep(state: InferenceState, node: ast.expr, kinds: int) -> None:
    if isinstance(node, ast.Name) and state.env is not None:
        variable = state.names.variables.get(node)
        if variable is not None and variable in state.env:
            found = state.env[variable]
            if found.kinds & UNKNOWN and kinds & NUMBERS:
                state.env[variable] = AbstractType(kinds)
            elif found.kinds & kinds:
                state.env[variable] = found.without(~kinds)


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


def merge(a: Environment | None, b: Environment | None) -> Environment | None:
    """What holds where two flows meet; None is a flow that does not get there."""
    if a is None or b is None:
        return b if a is None else a
    merged = dict(a)
    for variable, value in b.items():
        old = merged.get(variable)
        merged[variable] = value if old is None else old | value
    return merged

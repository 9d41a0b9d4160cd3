"""Abstract values and state of type inference."""

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

# Abstract values: the kinds of values that an expression may have, and the allocation sites of containers.


INT, FLOAT, BOOL, STR, NONE = 1, 2, 4, 8, 16
SHAPE, ARRAY, FUNCTION, LIST, TUPLE, DICT, SET = 32, 64, 128, 256, 512, 1024, 2048
RECORD, STREAM, MODULE, POSE, UNKNOWN = 4096, 8192, 16384, 32768, 65536

NUMBERS = INT | FLOAT | BOOL
SEQUENCES = LIST | TUPLE
CONTAINERS = LIST | TUPLE | DICT | SET


@dataclass(eq=False, slots=True)
class Site:
    """Allocation site of containers or arrays. Its contents only grow during inference.

    Attributes
    ----------
    items
        Types by position, if the length is known.
    element
        Join of all item types; the type of the values of a table.
    key, fields, other
        For tables: type of the keys, types of the values by constant key, and type of the values of other keys.
    is_mutated
        Whether the program modifies a container allocated here.
    readers
        Functions to analyse again when the contents grow.
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
    """Abstract value: a set of possible ``kinds``, with ``references`` to sites, functions, classes and names of
    modules."""

    __slots__ = ("kinds", "references")

    def __init__(self, kinds: int, references: frozenset[Reference] = frozenset()) -> None:
        self.kinds = kinds
        self.references = references

    def __or__(self, other: AbstractType) -> AbstractType:
        """Return the join.

        It is one of the operands if that covers the other, so that growth is detected by identity.
        """
        if other is self or (not other.kinds & ~self.kinds and other.references <= self.references):
            return self
        if not self.kinds & ~other.kinds and self.references <= other.references:
            return other
        return AbstractType(self.kinds | other.kinds, self.references | other.references)

    def only(self, kinds: int) -> bool:
        """Return whether the type is known and has no kinds other than ``kinds``."""
        return bool(self.kinds) and not self.kinds & ~kinds

    def may(self, kinds: int) -> bool:
        """Return whether the value may be of one of ``kinds``."""
        return bool(self.kinds & (kinds | UNKNOWN))

    def without(self, kinds: int) -> AbstractType:
        """Return the type without ``kinds``."""
        return AbstractType(self.kinds & ~kinds, self.references)

    def bare(self) -> AbstractType:
        """Return the type without references."""
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
        """Dotted names of modules and library functions."""
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
    """Return the join of ``types``."""
    result = NOTHING
    for each in types:
        result = result | each
    return result


def never_equal(left: AbstractType, right: AbstractType, depth: int = 8) -> bool:
    """Return whether no value of ``left`` can equal one of ``right``, because one has a tuple where the other has a
    list."""
    if not depth or not left.only(SEQUENCES) or not right.only(SEQUENCES):
        return False
    if not left.kinds & right.kinds:
        return True
    pairs = [(a, b) for a in left.sites for b in right.sites if a.kind == b.kind]
    return bool(pairs) and all(_sites_differ(a, b, depth - 1) for a, b in pairs)


def _sites_differ(left: Site, right: Site, depth: int) -> bool:
    has_items = any(site.items and not site.is_mutated for site in (left, right))  # else both may be empty
    if has_items and never_equal(left.element, right.element, depth):
        return True
    if left.items is None or right.items is None:
        return False
    if left.is_mutated or right.is_mutated or len(left.items) != len(right.items):
        return False
    return any(never_equal(a, b, depth) for a, b in zip(left.items, right.items))


# Types from annotations, used for functions that have no call site.


_SIMPLE = {"int": T_INT, "float": T_FLOAT, "bool": T_BOOL, "str": T_STR, "Shape": T_SHAPE, "None": T_NONE}


def annotated_type(annotation: ast.expr | None) -> AbstractType:
    """Return the type of an annotation, or NOTHING if it is not certain."""
    if isinstance(annotation, ast.Name):
        return _SIMPLE.get(annotation.id, NOTHING)
    if isinstance(annotation, ast.Constant):
        return T_NONE if annotation.value is None else _SIMPLE.get(str(annotation.value), NOTHING)
    if isinstance(annotation, ast.Attribute) and annotation.attr == "ndarray":
        return AbstractType(ARRAY)
    if isinstance(annotation, ast.Subscript) and isinstance(annotation.value, ast.Name):
        if annotation.value.id == "Optional":
            return annotated_type(annotation.slice) | T_NONE
    if isinstance(annotation, ast.BinOp):
        return annotated_type(annotation.left) | annotated_type(annotation.right)
    return NOTHING


Environment = dict[PythonVariable, AbstractType]
DRAWS, CHANGES = 1, 2
_MAX_VISITS = 40  # analyses of one function


@dataclass(eq=False)
class TypeFacts:
    """Results of inference.

    Attributes
    ----------
    types
        Type of each expression.
    variables, returns
        Types of variables and of the results of functions.
    targets
        Functions of the program that a call may invoke.
    callbacks
        Functions that evaluating a node may call.
    effects, effect_nodes
        Effects of functions and nodes (``DRAWS``, ``CHANGES``).
    words
        Registered functions by the argument of ``library_call``.
    reached
        Functions that have been analysed.
    """

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
    """State of inference: facts, work list, environment of the function being analysed, and sites.

    ``call`` analyses a call of any value; the models of library functions use it for the functions that they are
    passed.
    """

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
        # None where control does not arrive, such as after `return`
        self.env: Environment | None = {}
        self.queue: deque[Function] = deque()
        self.visits: dict[Function, int] = {}
        self.exits: list[list[Environment]] = []

    def call(
        self, function: AbstractType, node: ast.AST, positional: list[AbstractType], named: dict[str, AbstractType]
    ) -> AbstractType:
        """Return the type of a call of any value."""
        return self._call(self, function, node, positional, named)

    # --- the work list ---

    def enqueue(self, function: Function) -> None:
        if function not in self.queue and self.visits.get(function, 0) < _MAX_VISITS:
            self.queue.append(function)

    def add_return(self, function: Function, inferred: AbstractType) -> None:
        """Join a type into the result of a function; if it grows, the callers are analysed again."""
        old = self.facts.returns.get(function, NOTHING)
        new = old | inferred
        if new is not old:
            self.facts.returns[function] = new
            for caller in self.callers.get(function, ()):
                self.enqueue(caller)

    # --- variables and sites ---

    def store(self, variable: PythonVariable, value: AbstractType) -> None:
        """Assign a variable, in the flow of the current function and joined for all others."""
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
            inferred = self.env.get(variable)
            if inferred is not None:
                return inferred
        return self.facts.variables.get(variable, NOTHING)

    def site(self, node: ast.AST, kind: int, tag: str = "") -> Site:
        site = self.sites.get((node, tag))
        if site is None:
            site = self.sites[node, tag] = Site(node, kind)
        return site

    def grow(
        self,
        site: Site,
        element: AbstractType,
        key: AbstractType = NOTHING,
        items: Sequence[AbstractType] | None = None,
    ) -> AbstractType:
        """Join types into the contents of a site, and return the type of its containers.

        If they grow, readers are analysed again.
        """
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
        """Return the type of a sequence of known length."""
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
        """Return the type of the items of an iteration over ``value``."""
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

    def mutate(
        self, value: AbstractType, element: AbstractType = NOTHING, key: AbstractType = NOTHING,
        node: ast.AST | None = None, position: int | None = None,
    ) -> None:  # fmt: skip
        """Record an in-place modification of the containers that ``value`` may be, which stores ``element`` at
        ``position``."""
        for site in self.read_sites(value):
            if site.kind & (CONTAINERS | ARRAY | POSE):
                if not site.is_mutated and node not in self.additions:
                    site.is_mutated = True
                    for reader in site.readers:
                        self.enqueue(reader)
                self._store_item(site, element, position)
                self.grow(site, element, key)
        if node is not None and node not in self.additions:
            is_own = bool(value.sites) and all(_is_local(site.node, self.function) for site in value.sites)
            self.effect(node, 0 if is_own else CHANGES, here=CHANGES)

    def _store_item(self, site: Site, element: AbstractType, position: int | None) -> None:
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
        """Record an effect of evaluating ``node``; ``here`` are effects that are only visible inside this function."""
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
        """Join types into a table, by key for constant keys."""
        changed = False
        for name, added in fields.items():
            old = site.fields.get(name, NOTHING)
            site.fields[name] = old | added
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
        """Return the type of the value of a key of a table."""
        if isinstance(key, ast.Constant) and (site.fields or site.other.kinds):
            return site.fields.get(key.value, NOTHING) | site.other
        return site.element

    def item_at(self, value: AbstractType, position: int) -> AbstractType:
        """Return the type of the item at a constant position."""
        result = NOTHING
        for site in self.read_sites(value):
            if site.kind & SEQUENCES and site.items is not None and -len(site.items) <= position < len(site.items):
                result = result | site.items[position]
            else:
                result = result | (site.key if site.kind == DICT else site.element)
        return result | self.elements(value.without(CONTAINERS | (ARRAY if value.sites else 0)).bare())

    def set_field(self, record: Class, name: str, value: AbstractType) -> None:
        self.grow(self.site(record.node, DICT, f".{name}"), value)


def _is_local(node: ast.AST, function: Function) -> bool:
    """Return whether a site is in the text of ``function``, so that modifying its containers is not a side effect."""
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


# Flow sensitivity: narrowing of variables by tests, and the join of branches.


def narrow(state: InferenceState, test: ast.expr, holds: bool) -> None:
    """Narrow the types of the variables in ``test``, given its result."""
    if isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not):
        narrow(state, test.operand, not holds)
    elif isinstance(test, ast.BoolOp) and isinstance(test.op, ast.And) == holds:
        for value in test.values:
            narrow(state, value, holds)
    elif isinstance(test, ast.Name) and holds:
        _exclude(state, test, NONE)
    elif isinstance(test, ast.Compare) and len(test.ops) == 1 and is_none(test.comparators[0]):
        is_test = isinstance(test.ops[0], (ast.Is, ast.Eq))
        if is_test != holds:
            _exclude(state, test.left, NONE)
        elif isinstance(test.left, ast.Name):
            _restrict(state, test.left, NONE)
    elif isinstance(test, ast.Call) and state.paths.of(test.func) == "isinstance" and len(test.args) == 2:
        kinds = _isinstance_kinds(state.paths, test.args[1])
        classes = _isinstance_classes(state, test.args[1])
        if classes and not kinds:
            _narrow_classes(state, test.args[0], classes, holds=holds)
        elif kinds and holds:
            _restrict(state, test.args[0], kinds)
        elif kinds:
            _exclude(state, test.args[0], kinds)


def _isinstance_classes(state: InferenceState, node: ast.expr) -> frozenset[Class]:
    """Return the classes of the program in the second argument of ``isinstance``; none if it names others, too."""
    elements = node.elts if isinstance(node, ast.Tuple) else [node]
    variables = {state.names.variables.get(each) for each in elements}
    classes = frozenset(each for each in state.names.classes.values() if each.variable in variables)
    return classes if len(classes) == len(elements) else frozenset()


def _narrow_classes(state: InferenceState, node: ast.expr, classes: frozenset[Class], *, holds: bool) -> None:
    """Narrow a variable that may be of several classes to some of them, or to the others."""
    variable = state.names.variables.get(node) if isinstance(node, ast.Name) else None
    if state.env is None or variable is None or variable not in state.env:
        return
    value = state.env[variable]
    kept = frozenset(each for each in value.references if type(each) is not Class or (each in classes) is holds)
    if len([each for each in kept if type(each) is Class]):
        kinds = value.kinds & (RECORD | UNKNOWN) if holds else value.kinds
        state.env[variable] = AbstractType(kinds, kept)
    elif holds and value.classes:  # it is of none of them, as far as is known by now
        state.env[variable] = AbstractType(RECORD, frozenset[Reference](classes))
    elif value.classes and value.kinds & ~RECORD:
        state.env[variable] = AbstractType(value.kinds & ~RECORD, kept)


def _exclude(state: InferenceState, node: ast.expr, kinds: int) -> None:
    if isinstance(node, ast.Name) and state.env is not None:
        variable = state.names.variables.get(node)
        if variable is not None and variable in state.env:
            inferred = state.env[variable]
            if inferred.kinds & kinds:
                state.env[variable] = inferred.without(kinds)


def _restrict(state: InferenceState, node: ast.expr, kinds: int) -> None:
    if isinstance(node, ast.Name) and state.env is not None:
        variable = state.names.variables.get(node)
        if variable is not None and variable in state.env:
            inferred = state.env[variable]
            if inferred.kinds & UNKNOWN and kinds & NUMBERS:
                state.env[variable] = AbstractType(kinds)
            elif inferred.kinds & kinds:
                state.env[variable] = inferred.without(~kinds)


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
    """Return the join of the environments of two flows; None is an unreachable flow."""
    if a is None or b is None:
        return b if a is None else a
    merged = dict(a)
    for variable, value in b.items():
        old = merged.get(variable)
        merged[variable] = value if old is None else old | value
    return merged

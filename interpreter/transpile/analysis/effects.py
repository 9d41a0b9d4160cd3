"""What evaluating a piece of Python does beside giving a value: whether two pieces may change places."""

from __future__ import annotations

import ast
from collections.abc import Iterable
from dataclasses import dataclass

from scenelang.interpreter.transpile.analysis.domain import ARRAY, CONTAINERS, RECORD, Site, Type
from scenelang.interpreter.transpile.analysis.inference import CHANGES, DRAWS, Facts
from scenelang.interpreter.transpile.analysis.scopes import Function, Names, Variable

_EMPTY: frozenset[Variable] = frozenset()


@dataclass(frozen=True, slots=True)
class Effect:
    """``draws`` random numbers, ``changes`` containers, ``looks`` into those that change, ``reads`` and ``writes``
    cells."""

    draws: bool = False
    changes: bool = False
    looks: bool = False
    reads: frozenset[Variable] = _EMPTY
    writes: frozenset[Variable] = _EMPTY

    def __or__(self, other: Effect) -> Effect:
        return Effect(
            self.draws or other.draws,
            self.changes or other.changes,
            self.looks or other.looks,
            self.reads | other.reads,
            self.writes | other.writes,
        )

    @property
    def acts(self) -> bool:
        """Whether it does anything at all."""
        return self.draws or self.changes or bool(self.writes)

    def commutes(self, other: Effect) -> bool:
        """Whether the order of the two does not matter."""
        if self.draws and other.draws:
            return False
        if (self.changes and (other.changes or other.looks)) or (other.changes and self.looks):
            return False
        return not (self.writes & (other.reads | other.writes) or other.writes & self.reads)


PURE = Effect()


class Effects:
    """The effects of expressions of one program."""

    def __init__(self, names: Names, facts: Facts) -> None:
        self._names = names
        self._facts = facts
        self._cells: dict[Function, tuple[frozenset[Variable], frozenset[Variable]]] = {}

    def of(self, *nodes: ast.AST | None) -> Effect:
        """The effect of evaluating ``nodes``; functions defined in them count as called."""
        draws = changes = looks = False
        reads: set[Variable] = set()
        writes: set[Variable] = set()
        for node in _walk(nodes):
            found = self._facts.effect_nodes.get(node, 0)
            if type(node) is ast.Call or type(node) is ast.Attribute:
                for target in self._facts.callbacks.get(node, ()):
                    found |= self._facts.effects.get(target, 0)
                    read, written = self._cells_of(target)
                    reads |= read
                    writes |= written
            draws |= bool(found & DRAWS)
            changes |= bool(found & CHANGES)
            if type(node) is ast.Name:
                variable = self._names.variables.get(node)
                if variable is not None and variable.is_cell:
                    (reads if type(node.ctx) is ast.Load else writes).add(variable)
                value = self._facts.types.get(node)
                if value is not None and value.kinds & (CONTAINERS | ARRAY | RECORD):
                    looks |= bool(value.kinds & RECORD) or self._reaches_mutated(value)
        return Effect(draws, changes, looks, frozenset(reads), frozenset(writes))

    def _reaches_mutated(self, value: Type) -> bool:
        """Whether a value is, or holds at any depth, something that is changed somewhere."""
        seen: set[Site] = set()
        stack = value.sites
        while stack:
            site = stack.pop()
            if site in seen:
                continue
            seen.add(site)
            if site.is_mutated:
                return True
            stack += [*site.element.sites, *site.key.sites]
        return False

    def _cells_of(self, function: Function) -> tuple[frozenset[Variable], frozenset[Variable]]:
        """The cells of other functions that calling ``function`` reads and writes, directly or through its callees."""
        known = self._cells.get(function)
        if known is not None:
            return known
        self._cells[function] = (_EMPTY, _EMPTY)
        reads: set[Variable] = set()
        writes: set[Variable] = set()
        for node in ast.walk(function.node):
            variable = self._names.variables.get(node)
            if variable is not None and variable.is_cell and variable.function is not function:
                is_load = isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load)
                (reads if is_load else writes).add(variable)
            if isinstance(node, ast.Call):
                for target in self._facts.callbacks.get(node, ()):
                    read, written = self._cells_of(target)
                    reads |= read
                    writes |= written
        self._cells[function] = (frozenset(reads), frozenset(writes))
        return self._cells[function]


def _walk(nodes: Iterable[ast.AST | None]) -> Iterable[ast.AST]:
    for node in nodes:
        if node is not None:
            yield from ast.walk(node)

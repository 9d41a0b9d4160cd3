"""The abstract values of type inference: the kinds of things an expression may be, and where containers are made."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from scenelang.interpreter.transpile.analysis.scopes import Class, Function

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
    items: list[Type] | None = None
    element: Type = field(default_factory=lambda: Type(0))
    key: Type = field(default_factory=lambda: Type(0))
    fields: dict[object, Type] = field(default_factory=dict)
    other: Type = field(default_factory=lambda: Type(0))
    is_mutated: bool = False
    readers: set[Function] = field(default_factory=set)


Reference: TypeAlias = object


class Type:
    """``kinds``: the kinds it may be of; ``references``: its sites, functions, classes and the names of modules."""

    __slots__ = ("kinds", "references")

    def __init__(self, kinds: int, references: frozenset[Reference] = frozenset()) -> None:
        self.kinds = kinds
        self.references = references

    def __or__(self, other: Type) -> Type:
        """The join; it is one of the two objects where that says it all, so that growth shows by identity."""
        if other is self or (not other.kinds & ~self.kinds and other.references <= self.references):
            return self
        if not self.kinds & ~other.kinds and self.references <= other.references:
            return other
        return Type(self.kinds | other.kinds, self.references | other.references)

    def only(self, kinds: int) -> bool:
        """Whether it is known and nothing but ``kinds``."""
        return bool(self.kinds) and not self.kinds & ~kinds

    def may(self, kinds: int) -> bool:
        """Whether it may be of one of ``kinds``."""
        return bool(self.kinds & (kinds | UNKNOWN))

    def without(self, kinds: int) -> Type:
        """The same, known not to be of ``kinds``."""
        return Type(self.kinds & ~kinds, self.references)

    def bare(self) -> Type:
        """The same kinds without references."""
        return Type(self.kinds) if self.references else self

    @property
    def sites(self) -> list[Site]:
        return [r for r in self.references if type(r) is Site]

    @property
    def functions(self) -> list[Function]:
        from scenelang.interpreter.transpile.analysis.scopes import Function

        return [r for r in self.references if type(r) is Function]

    @property
    def classes(self) -> list[Class]:
        from scenelang.interpreter.transpile.analysis.scopes import Class

        return [r for r in self.references if type(r) is Class]

    @property
    def names(self) -> list[str]:
        """Dotted names of modules and known functions."""
        return [r for r in self.references if type(r) is str]


NOTHING = Type(0)
ANYTHING = Type(UNKNOWN)
T_INT = Type(INT)
T_FLOAT = Type(FLOAT)
T_NUMBER = Type(INT | FLOAT)
T_BOOL = Type(BOOL)
T_STR = Type(STR)
T_NONE = Type(NONE)
T_SHAPE = Type(SHAPE)
T_POSE = Type(POSE)
T_STREAM = Type(STREAM)


def join_all(types: Sequence[Type]) -> Type:
    """What is of any of ``types``."""
    result = NOTHING
    for each in types:
        result = result | each
    return result


def never_equal(left: Type, right: Type, depth: int = 8) -> bool:
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

"""Regular expressions that never have a choice: each character of a text fits at most one place of the pattern.

Such a pattern is matched without going back, in steps proportional to the text, whatever it nests:
``([a-h1-8]+/){7}[a-h1-8]+`` is one, ``(\\w+)*`` is none. The places and what may follow them are those of the automaton
of Glushkov (Brueggemann-Klein and Wood, One-unambiguous regular languages, 1998), but no place may follow another in
two ways either, as ``b`` itself does in ``(b*)*``. Characters beyond ASCII count as one.
"""

from __future__ import annotations

import importlib
import re
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

PARSER: Any = importlib.import_module("re._parser" if sys.version_info >= (3, 11) else "sre_parse")
_OTHER = 128  # stands for all characters beyond ASCII
_ALL = frozenset(range(_OTHER + 1))
_MOST_PLACES = 400  # of a pattern with its counted repetitions written out
_ENDLESS = 64  # a repetition with a larger maximum is one without


class _Undecided(Exception):
    """Raised for a pattern that can go on in two ways, or has more than characters, options, groups and repetitions."""


@dataclass(frozen=True, slots=True)
class _Part:
    """Part of a pattern: its places that may be first and last, and whether it matches the empty text."""

    first: frozenset[int]
    last: frozenset[int]
    is_nullable: bool


_EMPTY = _Part(frozenset(), frozenset(), True)


def is_deterministic(pattern: str) -> bool:
    """Return whether each character of a text fits at most one place of a pattern, as far as this can be decided.

    The pattern has no flags, as by ``re.IGNORECASE`` more characters fit.

    Examples
    --------
    >>> is_deterministic(r"([a-z]+,)*[0-9]+"), is_deterministic(r"([a-z]+)*")
    (True, False)
    """
    try:
        automaton = _Automaton()
        parsed = PARSER.parse(pattern)
        if parsed.state.flags & ~re.UNICODE:
            raise _Undecided
        whole = automaton.sequence(parsed)
    except (_Undecided, re.error, RecursionError):
        return False
    return all(map(automaton.are_disjoint, [whole.first, *automaton.follow]))


class _Automaton:
    """Places of a pattern: the characters that fit each, and the places that may follow it."""

    def __init__(self) -> None:
        self._fitting: list[frozenset[int]] = []
        self.follow: list[frozenset[int]] = []

    def are_disjoint(self, places: frozenset[int]) -> bool:
        """Return whether no character fits two of the places."""
        return sum(len(self._fitting[place]) for place in places) == len(
            frozenset().union(*(self._fitting[place] for place in places))
        )

    def sequence(self, parts: Sequence[tuple[Any, Any]]) -> _Part:
        """Return the part of a sequence."""
        whole = _EMPTY
        for operation, value in parts:
            whole = self._joined(whole, self._part(str(operation), value))
        return whole

    def _joined(self, one: _Part, two: _Part) -> _Part:
        """Return the part of two parts in sequence."""
        self._connect(one.last, two.first)
        return _Part(
            one.first | two.first if one.is_nullable else one.first,
            one.last | two.last if two.is_nullable else two.last,
            one.is_nullable and two.is_nullable,
        )

    def _connect(self, last: frozenset[int], first: frozenset[int]) -> None:
        """Let places follow others, which they may not do already."""
        for place in last:
            if self.follow[place] & first:
                raise _Undecided
            self.follow[place] |= first

    def _part(self, operation: str, value: Any) -> _Part:
        """Return the part of an operation of the parser."""
        if operation == "SUBPATTERN":
            _, added, removed, inner = value
            if added or removed:
                raise _Undecided
            return self.sequence(inner)
        if operation == "BRANCH":
            options = [self.sequence(each) for each in value[1]]
            if sum(each.is_nullable for each in options) > 1:
                raise _Undecided
            return _Part(
                frozenset().union(*(each.first for each in options)),
                frozenset().union(*(each.last for each in options)),
                any(each.is_nullable for each in options),
            )
        if operation == "MAX_REPEAT":
            return self._repeated(*value)
        if operation == "AT":
            return _EMPTY
        return self._place(_characters(operation, value))

    def _repeated(self, least: int, most: int, inner: Any) -> _Part:
        """Return the part of a repetition: copies up to its least number, then optional ones, or a loop."""
        whole = _EMPTY
        for _ in range(least):
            whole = self._joined(whole, self.sequence(inner))
        for _ in range(1 if most > _ENDLESS else most - least):
            again = self.sequence(inner)
            if again.is_nullable:
                raise _Undecided
            if most > _ENDLESS:
                self._connect(again.last, again.first)
            whole = self._joined(whole, _Part(again.first, again.last, True))
        return whole

    def _place(self, fitting: frozenset[int]) -> _Part:
        """Return the part of a new place."""
        if len(self._fitting) >= _MOST_PLACES:
            raise _Undecided
        self._fitting.append(fitting)
        self.follow.append(frozenset())
        only = frozenset((len(self.follow) - 1,))
        return _Part(only, only, False)


def _characters(operation: str, value: Any) -> frozenset[int]:
    """Return the characters that a single place matches."""
    if operation == "LITERAL":
        return frozenset((min(value, _OTHER),))
    if operation == "NOT_LITERAL":
        return _ALL - {value} if value < _OTHER else _ALL
    if operation == "ANY":
        return _ALL
    if operation == "RANGE":
        return frozenset(range(min(value[0], _OTHER), min(value[1], _OTHER) + 1))
    if operation == "CATEGORY":
        kind = str(value).removeprefix("CATEGORY_")
        letter = {"DIGIT": r"\d", "SPACE": r"\s", "WORD": r"\w"}.get(kind.removeprefix("NOT_"))
        if letter is None:
            raise _Undecided
        return _category(letter.upper() if kind.startswith("NOT_") else letter)
    if operation == "IN":
        is_negated = str(value[0][0]) == "NEGATE"
        members = [_characters(str(kind), each) for kind, each in value[is_negated:]]
        union = frozenset[int]().union(*members)
        return (_ALL - union) | {_OTHER} if is_negated else union
    raise _Undecided


def _category(letter: str) -> frozenset[int]:
    """Return the characters of a class such as ``\\d``; beyond ASCII there are some of each."""
    return frozenset(code for code in range(_OTHER) if re.match(letter, chr(code))) | {_OTHER}

"""LALR parsing with the tables that Lark makes of ``reader.lark`` and ``core.lark``.

The tables are files of this package, so that parsing imports no Lark: ``make tables`` writes them after a change of a
grammar, and a test compares them with the grammars. Lark is a development dependency only.

A state whose only action is one reduction is never entered: what the parser does there is known in advance, and is
part of the action that would lead to it. So an atom inside a list costs one action, not five. An error is found at the
same token as without this, because a reduction consumes nothing.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple, TypeAlias

from scenelang.grammar.datum import dataclass

END = "$END"

# What an action does with the value of its symbol, after the rule of the action, if any, was applied to it.
APPEND = 0  # append it to the repetition on top of the stack
BEGIN = 1  # push a repetition that begins with it
PUSH = 2  # push it
CLOSE = 3  # push it, then reduce by the rule that is the target
REDUCE = 4  # reduce by the rule that is the target, without consuming the token
ACCEPT = 5

Action: TypeAlias = Sequence[int]  # kind; rule applied to the value first, -1 for none; target state or rule
Builders: TypeAlias = Sequence[Callable[..., Any]]


class Rule(NamedTuple):
    """Rule of a grammar.

    Attributes
    ----------
    builder
        Name of the method that builds the value; "" if it is the value of the only symbol, None for repetitions, whose
        value is the list of their children.
    origin
        Nonterminal that the rule derives.
    length
        Number of its symbols.
    spread
        Positions of children that are repetitions; their items become arguments.
    absent
        Positions before which an argument is None, because an optional part is left out.
    """

    builder: str | None
    origin: str
    length: int
    spread: Sequence[int]
    absent: Sequence[int]


class Misfit(NamedTuple):
    """Token without an action in the parser's state; ``expected`` are the terminals that have one."""

    terminal: str
    value: Any
    expected: frozenset[str]


@dataclass(frozen=True, slots=True)
class Tables:
    """Tables of a grammar; the first state is the initial one.

    Attributes
    ----------
    terminals
        Names and regular expressions of the terminals in the order in which they are tried; the names of ignored ones
        start with ``__``.
    rules
        Rules, by number.
    rows
        Actions of each state, by symbol.
    """

    terminals: Sequence[tuple[str, str]]
    rules: Sequence[Rule]
    rows: Sequence[Mapping[str, Action]]

    def builders(self, builder: object) -> Builders:
        """Return the methods of ``builder`` for the rules, by number."""
        return [getattr(builder, rule.builder) if rule.builder else _same for rule in self.rules]

    def parse(self, tokens: Iterable[tuple[str, Any]], build: Builders, max_height: int = sys.maxsize) -> Any:
        """Parse tokens, and return the value of the start rule, or a ``Misfit``.

        Parameters
        ----------
        tokens
            Terminals with their values; the last one is ``END``.
        build
            Builders of the rules, by number; their arguments are the values of the rule's symbols.
        max_height
            Height of the stack from which on a token that makes it grow is a misfit.
        """
        rows = self.rows
        row = rows[0]
        states: list[int] = [0]
        values: list[Any] = [None]
        for terminal, value in tokens:
            while (action := row.get(terminal)) is not None:
                kind, rule, target = action
                if kind == REDUCE:
                    self._reduce(target, states, values, build)
                    row = rows[states[-1]]
                    continue
                if kind == ACCEPT:
                    return values[-1]
                if rule >= 0:
                    value = build[rule](value)
                if kind == APPEND:
                    values[-1].append(value)
                    break
                values.append([value] if kind == BEGIN else value)
                states.append(target)
                if kind == CLOSE:
                    self._reduce(target, states, values, build)
                    row = rows[states[-1]]
                elif len(states) > max_height:
                    return Misfit(terminal, value, frozenset())
                else:
                    row = rows[target]
                break
            else:
                return Misfit(terminal, value, frozenset(filter(_is_terminal, row)))
        raise ValueError("the tokens have no end")

    def _reduce(self, number: int, states: list[int], values: list[Any], build: Builders) -> None:
        """Reduce by a rule, and by the rules that the result completes in turn."""
        kind = CLOSE
        while kind == CLOSE:
            name, origin, length, spread, absent = self.rules[number]
            first = len(values) - length
            children = values[first:]
            del values[first:], states[first:]
            if spread or absent:
                children = _arguments(children, spread, absent)
            value = children if name is None else build[number](*children)
            kind, rule, number = self.rows[states[-1]][origin]
            if rule >= 0:
                value = build[rule](value)
            if kind == APPEND:
                values[-1].append(value)
            else:
                values.append([value] if kind == BEGIN else value)
                states.append(number)


def _same(value: Any) -> Any:
    """Builder of rules whose value is that of their only symbol."""
    return value


def _is_terminal(symbol: str) -> bool:
    """Return whether a symbol is a terminal; Lark spells these in capitals."""
    return symbol.isupper()


def _arguments(children: list[Any], spread: Sequence[int], absent: Sequence[int]) -> list[Any]:
    """Return the arguments of a builder, with repetitions spread and None for absent optional parts.

    A repetition at the beginning is extended in place, because it is not used again.
    """
    for position in absent:
        children.insert(position, None)
    for position in reversed(spread):
        if position == 0:
            head: list[Any] = children[0]
            head.extend(children[1:])
            return head
        children[position : position + 1] = children[position]
    return children


def tables_of(module: Any) -> Tables:
    """Return the tables of a module of ``grammar/tables``."""
    return Tables(module.TERMINALS, [Rule(*rule) for rule in module.RULES], module.ROWS)

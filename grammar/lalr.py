"""LALR parsing with the tables that Lark makes of ``reader.lark`` and ``core.lark``.

The tables are files of this package, so that parsing imports no Lark: ``make tables`` writes them after a change of a
grammar, and a test compares them with the grammars. Lark is a development dependency only.

A state whose only action is one reduction is never entered: what the parser does there is known in advance, and is
part of the action that would lead to it. So an atom inside a list costs one action, not five. An error is found at the
same token as without this, because a reduction consumes nothing.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
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
    spread: list[int]
    absent: list[int]


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


def _arguments(children: list[Any], spread: list[int], absent: list[int]) -> list[Any]:
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


def load_tables(name: str) -> Tables:
    """Load the tables of a grammar, a key of ``GRAMMARS``."""
    terminals, rules, rows = json.loads(_file(name).read_bytes())
    return Tables(terminals, [Rule(*rule) for rule in rules], rows)


def _file(name: str) -> Path:
    return Path(__file__).with_name(f"{name}.json")


# Making the tables with Lark, for this package only: Lark is imported here and in the tests.


class _Grammar(NamedTuple):
    """Grammar file, start rule, and whether states that can only reduce are left out.

    They are not where messages list the expected terminals, because reductions made in advance change these.
    """

    file: str
    start: str
    runs_ahead: bool = True


GRAMMARS = {
    "reader": _Grammar("reader.lark", "start"),
    "core": _Grammar("core.lark", "start"),
    "strict": _Grammar("core.lark", "strict_start", runs_ahead=False),
}


def tables_text(name: str) -> str:
    """Return the text of a table file, made from its grammar."""
    grammar = GRAMMARS[name]
    lark = _lark(grammar)
    maker = _Maker(lark.rules, lark.parser.parser.parser.parse_table, grammar)
    terminals = [(t.name, t.pattern.to_regexp()) for t in sorted(lark.terminals, key=_terminal_key)]
    sections = []
    for entries in (terminals, maker.rules, maker.rows()):  # one entry per line, so that diffs can be read
        sections.append("[" + ",\n".join(json.dumps(entry) for entry in entries) + "]")
    return "[" + ",\n".join(sections) + "]\n"


def _terminal_key(terminal: Any) -> tuple[int, int, int, str]:
    """Sort key of terminals in the order in which Lark's basic lexer tries them."""
    pattern = terminal.pattern
    return -terminal.priority, -pattern.max_width, -len(pattern.value), terminal.name


def _lark(grammar: _Grammar) -> Any:
    """Parse a grammar file with Lark; only ``reader.lark`` is over text and has a lexer."""
    from lark import Lark
    from lark.lexer import Lexer

    class NoLexer(Lexer):
        """Placeholder, because terminals of datums have no patterns."""

        def __init__(self, _: Any) -> None:
            pass

        def lex(self, *_: Any) -> Any:
            raise NotImplementedError

    text = Path(__file__).with_name(grammar.file).read_text("utf-8")
    return Lark(text, parser="lalr", lexer="basic" if grammar.file == "reader.lark" else NoLexer, start=grammar.start)


class _Maker:
    """Converts Lark's tables: numbers states in breadth-first order, and leaves out states that can only reduce."""

    def __init__(self, rules: Sequence[Any], table: Any, grammar: _Grammar) -> None:
        self._table = table
        self._runs_ahead = grammar.runs_ahead
        (self._start,), (self._end,) = table.start_states.values(), table.end_states.values()
        self._lark_rules = sorted((rule for row in table.states.values() for rule in _reductions(row)), key=_rule_key)
        self._lark_rules = list(dict.fromkeys(self._lark_rules))
        self._number = {rule: number for number, rule in enumerate(self._lark_rules)}
        self._symbol = {  # through which each state is entered; there is one
            target: symbol for row in table.states.values() for symbol, (kind, target) in row.items() if _shifts(kind)
        }
        self.rules = [self._rule(rule) for rule in self._lark_rules]

    def _rule(self, rule: Any) -> Rule:
        """Convert a rule of Lark."""
        names = [symbol.name for symbol in rule.expansion]
        spread = [position for position, name in enumerate(names) if _is_repetition(name)]
        flags = "".join(str(int(flag)) for flag in rule.options.empty_indices)
        absent = [position for position, run in enumerate(flags.split("0")) for _ in run]  # one for each "1"
        name = "" if _passes(rule) else rule.alias or str(rule.origin.name)
        name = None if _is_repetition(rule.origin.name) else name
        return Rule(name, str(rule.origin.name), len(names), spread, absent)

    def rows(self) -> list[dict[str, Action]]:
        """Return the actions of every state that is reached, by symbol."""
        rows, numbers = [], {self._start: 0}
        states = [self._start]
        for state in states:
            row: dict[str, Action] = {END: (ACCEPT, -1, -1)} if state == self._end else {}
            for symbol in sorted(self._table.states[state]):
                kind, rule, target = self._action(state, symbol)
                if kind in (BEGIN, PUSH):
                    if target not in numbers:
                        numbers[target] = len(states)
                        states.append(target)
                    target = numbers[target]
                row[symbol] = kind, rule, target
            rows.append(row)
        return rows

    def _action(self, state: int, symbol: str) -> Action:
        """Return the action of a state on a symbol, with the reductions that follow whatever the next token is."""
        applied = -1
        while True:
            kind, target = self._table.states[state][symbol]
            if not _shifts(kind):
                return REDUCE, -1, self._number[target]
            rule = self._only_reduction(target)
            if rule is None:
                return PUSH, applied, target
            names, origin = [part.name for part in rule.expansion], rule.origin.name
            if names == [symbol] and _is_repetition(origin):
                return BEGIN, applied, self._table.states[state][origin][1]
            if names == [origin, symbol] and self._symbol.get(state) == origin:
                return APPEND, applied, -1
            passes = names == [symbol] and _passes(rule)
            if names != [symbol] or _is_repetition(symbol) or (applied >= 0 and not passes):
                return CLOSE, applied, self._number[rule]
            applied = applied if passes else self._number[rule]
            symbol = origin

    def _only_reduction(self, state: int) -> Any:
        """Return the rule by which a state reduces whatever comes next, or None."""
        row = self._table.states[state]
        rules = set(_reductions(row))
        return rules.pop() if self._runs_ahead and len(rules) == 1 and len(_reductions(row)) == len(row) else None


def _shifts(kind: Any) -> bool:
    """Return whether an action of Lark is a shift; the class is private there."""
    return str(kind.name) == "Shift"


def _reductions(row: Mapping[str, Any]) -> list[Any]:
    """Return the rules of the reductions in a row of Lark's table."""
    return [target for kind, target in row.values() if not _shifts(kind)]


def _rule_key(rule: Any) -> tuple[str, list[str]]:
    return rule.origin.name, [symbol.name for symbol in rule.expansion]


def _is_repetition(name: str) -> bool:
    """Return whether a symbol is one that Lark makes for ``*`` and ``+``."""
    return name.startswith("__")


def _passes(rule: Any) -> bool:
    """Return whether the value of a rule is that of its only symbol: ``?rule`` without a name, or ``_rule``."""
    name = rule.origin.name
    return not rule.alias and (rule.options.expand1 or name.startswith("_")) and not _is_repetition(name)


if __name__ == "__main__":
    for grammar_name in GRAMMARS:
        (Path(sys.argv[1]) / f"{grammar_name}.json").write_text(tables_text(grammar_name), "utf-8")

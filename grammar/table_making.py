"""The parser's tables from the grammars, by Lark, which only this module and the tests import: ``make tables``.

The tables are modules of Python, whose bytecode is read in a sixth of the time that JSON takes.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from scenelang.grammar.lalr import ACCEPT, APPEND, BEGIN, CLOSE, END, PUSH, REDUCE, Action, Rule


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
    """Return the text of the module of a grammar's tables, with one entry a line, so that differences can be read."""
    grammar = GRAMMARS[name]
    lark = _lark(grammar)
    maker = _Maker(lark.rules, lark.parser.parser.parser.parse_table, grammar)
    terminals = [(t.name, t.pattern.to_regexp()) for t in sorted(lark.terminals, key=_terminal_key)]
    sections = [f'"""Tables of ``{grammar.file}`` from ``{grammar.start}``, written by ``make tables``."""\n']
    for title, entries in (("TERMINALS", terminals), ("RULES", map(tuple, maker.rules)), ("ROWS", maker.rows())):
        sections.append(f"{title} = (\n" + "".join(f"{entry!r},\n" for entry in entries) + ")\n")
    return "".join(sections)


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
        spread = tuple(position for position, name in enumerate(names) if _is_repetition(name))
        flags = "".join(str(int(flag)) for flag in rule.options.empty_indices)
        absent = tuple(position for position, run in enumerate(flags.split("0")) for _ in run)  # one for each "1"
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
        (Path(sys.argv[1]) / f"{grammar_name}_tables.py").write_text(tables_text(grammar_name), "utf-8")

"""Rules written as Lark writes them -> the model: literals in quotes, ``*``, ``+``, ``?``, ``[optional]``, ``|``."""

from __future__ import annotations

import re
from collections.abc import Mapping

from scenelang.grammar.export.model import (
    Choice,
    Expression,
    Literal,
    Ref,
    Repeat,
    Sequence,
    Terminal,
    choice,
    sequence,
)

_TOKEN = re.compile(r'"((?:[^"\\]|\\.)+)"|([A-Z][A-Z0-9_]*)|([a-z][a-z0-9_]*)|([()\[\]|*+?])|(\s+)')
_RULE = re.compile(r"^\??([a-z][a-z0-9_]*)\s*:(.*(?:\n[ \t]+\|.*)*)", re.M)


def parse_rules(text: str) -> dict[str, Expression]:
    """The rules of ``name: alternatives`` lines. An alternative may stand on a line of its own that begins with `|`."""
    return {name: parse_expression(body) for name, body in _RULE.findall(text)}


def parse_expression(text: str) -> Expression:
    """One right-hand side. Raises ValueError where it is malformed."""
    return _Parser(text).whole()


class _Parser:
    """Recursive descent over a right-hand side."""

    def __init__(self, text: str) -> None:
        self._tokens: list[tuple[str, str]] = []
        position = 0
        for match in _TOKEN.finditer(text):
            if match.start() != position:
                break
            position = match.end()
            if match.lastindex != 5:
                kind = ("literal", "terminal", "rule", "sign")[(match.lastindex or 1) - 1]
                self._tokens.append((kind, match[match.lastindex or 1]))
        if position != len(text):
            raise ValueError(f"malformed rule: {text[position:]!r}")

    def _peek(self) -> str:
        return self._tokens[0][1] if self._tokens and self._tokens[0][0] == "sign" else ""

    def whole(self) -> Expression:
        expression = self._choice()
        if self._tokens:
            raise ValueError(f"malformed rule at {self._tokens[0][1]!r}")
        return expression

    def _choice(self) -> Expression:
        options = [self._sequence()]
        while self._peek() == "|":
            self._tokens.pop(0)
            options.append(self._sequence())
        return choice(*options)

    def _sequence(self) -> Expression:
        items = []
        while self._tokens and self._peek() not in ("|", ")", "]"):
            items.append(self._repeated())
        if not items:
            raise ValueError("an alternative is empty")
        return sequence(*items)

    def _repeated(self) -> Expression:
        item = self._item()
        while self._peek() in ("*", "+", "?") and self._peek():
            sign = self._tokens.pop(0)[1]
            item = Repeat(item, 1 if sign == "+" else 0, once=sign == "?")
        return item

    def _item(self) -> Expression:
        kind, text = self._tokens.pop(0)
        if kind == "literal":
            return Literal(text.replace('\\"', '"').replace("\\\\", "\\"))
        if kind == "terminal":
            return Terminal(text)
        if kind == "rule":
            return Ref(text)
        inner = self._choice()
        closing = {"(": ")", "[": "]"}.get(text)
        if closing is None or not self._tokens or self._tokens.pop(0) != ("sign", closing):
            raise ValueError(f"malformed rule at {text!r}")
        return Repeat(inner, 0, once=True) if text == "[" else inner


def substitute(expression: Expression, replacements: Mapping[str, Expression]) -> Expression:
    """``expression`` with terminals replaced by what ``replacements`` has under their names."""
    if isinstance(expression, Terminal):
        return replacements.get(expression.name, expression)
    if isinstance(expression, Sequence):
        return sequence(*(substitute(item, replacements) for item in expression.items))
    if isinstance(expression, Choice):
        return choice(*(substitute(option, replacements) for option in expression.options))
    if isinstance(expression, Repeat):
        return Repeat(substitute(expression.item, replacements), expression.least, expression.once)
    return expression

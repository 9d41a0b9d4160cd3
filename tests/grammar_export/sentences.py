"""Random sentences of a grammar, for property tests."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from random import Random

from scenelang.grammar.export.model import Choice, Expression, Grammar, Literal, Ref, Repeat, Sequence, Terminal

Words = Callable[[str], str]


class Writer:
    """Writes sentences: ``words(terminal)`` gives a token; options that hold one of ``avoid`` are not taken."""

    def __init__(self, grammar: Grammar, random: Random, words: Words, avoid: frozenset[Expression]) -> None:
        self._rules = grammar.rules
        self._random = random
        self._words = words
        self._avoid = avoid
        self._costs = _costs(grammar.rules)

    def sentence(self, rule: str, depth: int) -> list[str]:
        """The tokens of one; below ``depth`` rules the shortest way out is taken."""
        return self._write(self._rules[rule], depth)

    def _write(self, expression: Expression, depth: int) -> list[str]:
        if isinstance(expression, Literal):
            return [expression.text]
        if isinstance(expression, Terminal):
            return [self._words(expression.name)]
        if isinstance(expression, Ref):
            return self._write(self._rules[expression.name], depth - 1)
        if isinstance(expression, Sequence):
            return [token for item in expression.items for token in self._write(item, depth)]
        if isinstance(expression, Repeat):
            maximum = 1 if expression.once else 3
            turns = self._random.randint(expression.minimum, maximum) if depth > 0 else expression.minimum
            return [token for _ in range(turns) for token in self._write(expression.item, depth)]
        options = [option for option in expression.options if option not in self._avoid]
        if depth <= 0:
            minimum = min(self._cost(option) for option in options)
            options = [option for option in options if self._cost(option) == minimum]
        return self._write(self._random.choice(options), depth)

    def _cost(self, expression: Expression) -> float:
        return _cost(expression, self._costs)


def _costs(rules: Mapping[str, Expression]) -> dict[str, float]:
    """How deep each rule must nest at least."""
    costs = dict.fromkeys(rules, float("inf"))
    while True:
        better = {name: 1 + _cost(expression, costs) for name, expression in rules.items()}
        if better == costs:
            return costs
        costs = better


def _cost(expression: Expression, costs: Mapping[str, float]) -> float:
    if isinstance(expression, Ref):
        return costs[expression.name]
    if isinstance(expression, Sequence):
        return max(_cost(item, costs) for item in expression.items)
    if isinstance(expression, Choice):
        return min(_cost(option, costs) for option in expression.options)
    if isinstance(expression, Repeat):
        return _cost(expression.item, costs) if expression.minimum else 0
    return 0

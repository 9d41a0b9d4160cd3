"""Patterns of ``match``."""

from __future__ import annotations

import ast
from functools import lru_cache
from typing import Any

from scenelang.interpreter.transpile.evaluation import UnsupportedPython
from scenelang.interpreter.transpile.evaluation.classes import is_instance
from scenelang.interpreter.transpile.evaluation.objects import MISSING, Evaluating, Frame, Native
from scenelang.interpreter.transpile.evaluation.residue import has_kind, undecided


@lru_cache(maxsize=1_000)
def as_conditions(node: ast.Match) -> ast.If | None:
    """Return conditions in place of a ``match`` whose patterns are values, without guards; else None."""
    subject = node.subject
    while isinstance(subject, ast.Attribute):
        subject = subject.value
    if not isinstance(subject, ast.Name):
        return None  # which may do things each time
    rest: list[ast.stmt] = []
    for case in reversed(node.cases):
        pattern = case.pattern
        values = pattern.patterns if isinstance(pattern, ast.MatchOr) else [pattern]
        if case.guard is not None:
            return None
        if isinstance(pattern, ast.MatchAs) and pattern.pattern is None and pattern.name is None:
            rest = case.body
            continue
        tests: list[ast.expr] = [
            ast.Compare(node.subject, [ast.Eq()], [each.value]) for each in values if isinstance(each, ast.MatchValue)
        ]
        if len(tests) < len(values):
            return None
        test = tests[0] if len(tests) == 1 else ast.BoolOp(ast.Or(), tests)
        rest = [ast.copy_location(ast.If(test, case.body, rest), case.body[0])]
    first = rest[0] if rest else None
    return first if isinstance(first, ast.If) and first.body is node.cases[0].body else None


def matches(evaluator: Evaluating, pattern: ast.pattern, value: Any, bound: dict[str, Any], frame: Frame) -> bool:
    """Return whether a value matches a pattern; captured names are added to ``bound``."""
    evaluator.tick()
    if has_kind(value, "any") and not isinstance(pattern, ast.MatchAs):
        # the case would depend on a value that only the translated program knows
        raise undecided(value)
    if isinstance(pattern, ast.MatchValue):
        return bool(value == evaluator.eval(pattern.value, frame))
    if isinstance(pattern, ast.MatchSingleton):
        return value is pattern.value
    if isinstance(pattern, ast.MatchAs):
        if pattern.pattern is not None and not matches(evaluator, pattern.pattern, value, bound, frame):
            return False
        if pattern.name is not None:
            bound[pattern.name] = value
        return True
    if isinstance(pattern, ast.MatchOr):
        return any(matches(evaluator, each, value, bound, frame) for each in pattern.patterns)
    if isinstance(pattern, ast.MatchSequence):
        return _matches_sequence(evaluator, pattern, value, bound, frame)
    if isinstance(pattern, ast.MatchMapping):
        return _matches_mapping(evaluator, pattern, value, bound, frame)
    if isinstance(pattern, ast.MatchClass):
        return _matches_class(evaluator, pattern, value, bound, frame)
    raise UnsupportedPython("this pattern is not supported")


def _matches_sequence(
    evaluator: Evaluating, pattern: ast.MatchSequence, value: Any, bound: dict[str, Any], frame: Frame
) -> bool:
    if not isinstance(value, (list, tuple, range)) and type(value).__name__ != "deque":
        return False
    items, patterns = list(value), pattern.patterns
    star = next((i for i, each in enumerate(patterns) if isinstance(each, ast.MatchStar)), None)
    if star is None:
        return len(items) == len(patterns) and all(
            matches(evaluator, each, item, bound, frame) for each, item in zip(patterns, items)
        )
    after = len(patterns) - star - 1
    if len(items) < star + after:
        return False
    starred = patterns[star]
    if isinstance(starred, ast.MatchStar) and starred.name is not None:
        bound[starred.name] = items[star : len(items) - after]
    pairs = [*zip(patterns[:star], items), *zip(patterns[star + 1 :], items[len(items) - after :])]
    return all(matches(evaluator, each, item, bound, frame) for each, item in pairs)


def _matches_mapping(
    evaluator: Evaluating, pattern: ast.MatchMapping, value: Any, bound: dict[str, Any], frame: Frame
) -> bool:
    if not isinstance(value, dict):
        return False
    keys = [evaluator.eval(key, frame) for key in pattern.keys]
    if not all(key in value for key in keys):
        return False
    if pattern.rest is not None:
        bound[pattern.rest] = {key: item for key, item in value.items() if key not in keys}
    return all(matches(evaluator, each, value[key], bound, frame) for key, each in zip(keys, pattern.patterns))


def _matches_class(
    evaluator: Evaluating, pattern: ast.MatchClass, value: Any, bound: dict[str, Any], frame: Frame
) -> bool:
    """Return whether a value is an instance of a class and its attributes match the subpatterns."""
    cls = evaluator.eval(pattern.cls, frame)
    if not is_instance(evaluator, value, cls):
        return False
    names = list(pattern.kwd_attrs)
    patterns = list(pattern.kwd_patterns)
    # `int(x)` and some other built-in classes match the whole value (PEP 634)
    if pattern.patterns and isinstance(cls, Native):
        return len(pattern.patterns) == 1 and matches(evaluator, pattern.patterns[0], value, bound, frame)
    if pattern.patterns:
        given = cls.find("__match_args__")
        fields = [each.name for each in cls.data or () if each.in_init] or list(cls.tuple_fields or ())
        arguments = list(given) if given is not MISSING else fields
        names = [*arguments[: len(pattern.patterns)], *names]
        patterns = [*pattern.patterns, *patterns]
    for name, each in zip(names, patterns):
        item = evaluator.attribute(value, name, MISSING)
        if item is MISSING or not matches(evaluator, each, item, bound, frame):
            return False
    return True

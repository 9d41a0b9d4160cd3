"""The conversion that ``(degrees x)`` was meant to be.

Earlier versions had ``degrees``, which converts radians to degrees, and which people wrote to give an angle in degrees.
The place says what was meant: where radians are expected, or if a number is larger than a full turn in radians, it is
``deg``; otherwise it is ``to-degrees``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache

from scenelang.grammar.diagnostics import Diagnostic, Edit, Fix
from scenelang.grammar.lazy_patterns import lazy_pattern
from scenelang.interpreter.checker.builtins import ANGLE_KEYWORDS, ANGLES
from scenelang.interpreter.checker.habits import MAX_TEXT, Tree, trees, walk
from scenelang.interpreter.runtime.types import STD

_ARITHMETIC = frozenset(("+", "-", "*", "/", "min", "max", "abs", "%", "if"))  # pass an angle on


def with_meant_conversions(diagnostics: Sequence[Diagnostic]) -> list[Diagnostic]:
    """Return the diagnostics; those about ``degrees`` have the fix for its place.

    Parameters
    ----------
    diagnostics
        Diagnostics of a program.

    Returns
    -------
    list
        The same diagnostics in the same order.

    Examples
    --------
    >>> from scenelang import Session, Source
    >>> fixed, _ = Session().autofix(Source("a.scene", "(define pose (rotate (degrees 90) [0 1 0]))"))
    >>> fixed.text
    '(define pose (rotate (deg 90) [0 1 0]))'
    """
    return [_meant(d) if _is_about_degrees(d) else d for d in diagnostics]


def _is_about_degrees(diagnostic: Diagnostic) -> bool:
    """Return whether a diagnostic says that ``degrees`` is not defined, with a fix."""
    is_about = diagnostic.name == "unbound" and diagnostic.near in (("to-degrees",), (f"{STD}to-degrees",))
    return is_about and bool(diagnostic.fixes)


def _meant(diagnostic: Diagnostic) -> Diagnostic:
    """Return the diagnostic with the conversion that was meant."""
    span = diagnostic.span
    assert span is not None
    text = span.source.text
    if len(text) > MAX_TEXT or not _gives_degrees(_path(_tree(text), span.start)):
        return diagnostic
    # A variable of this name may hide the function.
    name = f"{STD}deg" if _NAMED.search(text) or span.text.startswith(STD) else "deg"
    fix = Fix(f"Change to `{name}`", (Edit(span, name),), safe=True)
    return replace(diagnostic, hint=f"an angle in degrees is written `({name} 90)`", fixes=(fix,), near=(name,))


_NAMED = lazy_pattern(r"(?<![\w/-])deg(?![\w/-])")


@lru_cache(maxsize=1)
def _tree(text: str) -> Tree:
    """Return the datums of a text, which are the same for all its diagnostics."""
    return trees(text)


def _path(root: Tree, position: int) -> list[Tree]:
    """Return the lists around a position, from the outermost to the innermost."""
    path = [root]
    while True:
        inner = next((t for t in path[-1].items if t.opener and t.start <= position < t.end), None)
        if inner is None:
            return path
        path.append(inner)


def _gives_degrees(path: Sequence[Tree]) -> bool:
    """Return whether the innermost list, ``(degrees x)``, gives an angle in degrees where radians are expected."""
    call = path[-1]
    is_large = any(abs(number) > math.tau for item in call.items[1:] for number in _numbers(item))
    return is_large or _is_expected(path)


def _is_expected(path: Sequence[Tree]) -> bool:
    """Return whether the place of the innermost list expects an angle in radians, perhaps through arithmetic."""
    for outer, inner in zip(reversed(path[:-1]), reversed(path[1:])):
        index = next(i for i, item in enumerate(outer.items) if item is inner)
        before = outer.items[index - 1].text if index else ""
        if before.startswith(":") and before.lstrip(":") in ANGLE_KEYWORDS:
            return True
        head = outer.items[0].text
        if head in ANGLES:
            return index == ANGLES[head] + 1
        if head not in _ARITHMETIC:
            return False
    return False


def _numbers(tree: Tree) -> Iterator[float]:
    """Iterate over the numbers in a datum."""
    for part in (tree, *walk(tree)):
        if _NUMBER.fullmatch(part.text):
            yield float(part.text)


_NUMBER = lazy_pattern(r"[-+]?(?:\d+\.?\d*|\.\d+)")

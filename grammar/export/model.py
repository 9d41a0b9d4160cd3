"""A surface grammar as data: rules over literals and terminals, and what the terminals look like."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TypeAlias


@dataclass(frozen=True, slots=True)
class Literal:
    """A text that stands as it is: a bracket, a prefix, or the word of a form."""

    text: str


@dataclass(frozen=True, slots=True)
class Terminal:
    """A class of tokens, by its name in capitals."""

    name: str


@dataclass(frozen=True, slots=True)
class Ref:
    """Another rule, by its name in small letters."""

    name: str


@dataclass(frozen=True, slots=True)
class Sequence:
    items: tuple[Expression, ...]


@dataclass(frozen=True, slots=True)
class Choice:
    options: tuple[Expression, ...]


@dataclass(frozen=True, slots=True)
class Repeat:
    """``item`` at least ``least`` times; at most once when ``once``, else without end."""

    item: Expression
    least: int
    once: bool = False


Expression: TypeAlias = Literal | Terminal | Ref | Sequence | Choice | Repeat

OPENERS = frozenset({"(", "[", "'", "`", ",", ",@", "#;"})  # what follows them needs no white space before it
CLOSERS = frozenset({")", "]"})


# --- what tokens look like -----------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Chars:
    """One character of ``ranges`` (pairs of first and last code point), or of all others when ``negated``."""

    ranges: tuple[tuple[int, int], ...]
    negated: bool = False


@dataclass(frozen=True, slots=True)
class Text:
    """The characters of ``text``, one after the other."""

    text: str


@dataclass(frozen=True, slots=True)
class Joined:
    parts: tuple[Pattern, ...]


@dataclass(frozen=True, slots=True)
class Either:
    options: tuple[Pattern, ...]


@dataclass(frozen=True, slots=True)
class Many:
    """``part`` from ``least`` to ``most`` times; None: without end."""

    part: Pattern
    least: int = 0
    most: int | None = None


@dataclass(frozen=True, slots=True)
class Use:
    """What another token matches, by its name."""

    token: str


Pattern: TypeAlias = Chars | Text | Joined | Either | Many | Use


@dataclass(frozen=True, slots=True)
class Token:
    """What a terminal matches: ``pattern``, but none of the words in ``excluded``.

    ``is_word``: it must not touch another word. ``title`` says for people what it is.
    """

    pattern: Pattern
    title: str
    excluded: frozenset[str] = frozenset()
    is_word: bool = True


@dataclass(frozen=True, slots=True)
class Grammar:
    """Rules by name, ``start`` among them, with the tokens that they use."""

    start: str
    rules: Mapping[str, Expression]
    tokens: Mapping[str, Token]
    title: str


def is_punctuation(text: str) -> bool:
    """True for a literal that may touch whatever stands beside it."""
    return text in OPENERS or text in CLOSERS


def parts(expression: Expression) -> Iterator[Expression]:
    """The expression and all below it."""
    yield expression
    if isinstance(expression, Sequence):
        below: tuple[Expression, ...] = expression.items
    elif isinstance(expression, Choice):
        below = expression.options
    else:
        below = (expression.item,) if isinstance(expression, Repeat) else ()
    for item in below:
        yield from parts(item)


def literals(rules: Mapping[str, Expression]) -> frozenset[str]:
    """The words that stand in the rules as they are, brackets and prefixes left out."""
    found = (part for expression in rules.values() for part in parts(expression))
    return frozenset(part.text for part in found if isinstance(part, Literal) and not is_punctuation(part.text))


def used_terminals(rules: Mapping[str, Expression]) -> frozenset[str]:
    found = (part for expression in rules.values() for part in parts(expression))
    return frozenset(part.name for part in found if isinstance(part, Terminal))


def sequence(*items: Expression) -> Expression:
    """One after the other; sequences among ``items`` are joined."""
    flat: list[Expression] = []
    for item in items:
        flat.extend(item.items if isinstance(item, Sequence) else (item,))
    return flat[0] if len(flat) == 1 else Sequence(tuple(flat))


def choice(*options: Expression) -> Expression:
    """One of ``options``; choices among them are joined."""
    flat: list[Expression] = []
    for option in options:
        flat.extend(option.options if isinstance(option, Choice) else (option,))
    return flat[0] if len(flat) == 1 else Choice(tuple(flat))

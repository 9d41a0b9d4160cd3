"""Explicit white space for grammar formats that describe characters: each token states what may precede it.

Adjacent words must be separated: a word that does not follow an opening bracket or a prefix requires white space before
it. So does `[` (`xs[0]` is a mistake). `#;` with its datum requires it on both sides, except before a closing bracket.
"""

from __future__ import annotations

from collections.abc import Mapping
from collections.abc import Sequence as Items
from types import MappingProxyType
from typing import Literal as OneOf

from scenelang.grammar.export.model import (
    CLOSERS,
    OPENERS,
    Chars,
    Choice,
    Either,
    Expression,
    Grammar,
    Joined,
    Literal,
    Many,
    Pattern,
    Ref,
    Repeat,
    RuleUse,
    Sequence,
    Terminal,
    TerminalToken,
    Text,
    choice,
    parse_rules,
    sequence,
)

Start = OneOf["word", "sign", "mixed"]

WHITE = Chars(((9, 10), (13, 13), (32, 32)))  # tab, newline, return, space
_NEWLINE = Chars(((10, 10),), negated=True)
_HASH, _BAR = Text("#"), Text("|")
_NEITHER = Chars(((35, 35), (124, 124)), negated=True)

_RULES = """
gap: blank+ (hidden blank+)*
blank: WHITE | COMMENT | block
hidden: "#;" gap? datum
end: (gap hidden?)? LAST_COMMENT?
block: BLOCK_OPEN inner* BLOCK_CLOSE
nested: NESTED_OPEN inner* BLOCK_CLOSE
inner: PLAIN | HASHES | BARS | nested
"""


def _space_tokens(white: Pattern) -> dict[str, TerminalToken]:
    """Return tokens of white space and comments.

    Block comments are split into tokens none of which is a prefix of another, so that no lexer needs to backtrack.
    """
    return {
        "WHITE": TerminalToken(white, "white space"),
        "COMMENT": TerminalToken(Joined((Text(";"), Many(_NEWLINE), Text("\n"))), "a comment to the end of the line"),
        "LAST_COMMENT": TerminalToken(Joined((Text(";"), Many(_NEWLINE))), "a comment to the end of the text"),
        "BLOCK_OPEN": TerminalToken(Text("#|"), "the beginning of a block comment"),
        "NESTED_OPEN": TerminalToken(Joined((Many(_HASH, 1), _BAR)), "the beginning of one inside another"),
        "BLOCK_CLOSE": TerminalToken(Joined((Many(_BAR, 1), _HASH)), "the end of a block comment"),
        "PLAIN": TerminalToken(Many(_NEITHER, 1), "text of a block comment"),
        "HASHES": TerminalToken(Joined((Many(_HASH, 1), _NEITHER)), "text of a block comment that begins with #"),
        "BARS": TerminalToken(Joined((Many(_BAR, 1), _NEITHER)), "text of a block comment that begins with |"),
    }


def spaced(grammar: Grammar, white: Pattern = WHITE) -> Grammar:
    """Return a grammar of the same language with explicit white space; ``white`` is the pattern of its WHITE token."""
    spacer = _Spacer(grammar)
    rules: dict[str, Expression] = {}
    for name, expression in grammar.rules.items():
        rules[name] = spacer.bare(expression)
        if name != grammar.start and spacer.start_of(Ref(name)) == "mixed":
            rules[_spaced_name(name)] = spacer.spaced(expression)
    rules[grammar.start] = sequence(_MAYBE_GAP, rules[grammar.start], Ref("end"))
    white_rules = parse_rules(_RULES)
    assert not white_rules.keys() & rules.keys(), "a rule has the name of one of white space"
    tokens = {**grammar.tokens, **_space_tokens(white)}
    return Grammar(grammar.start, MappingProxyType(rules | white_rules), MappingProxyType(tokens), grammar.title)


_GAP = Ref("gap")
_MAYBE_GAP = Repeat(_GAP, 0, once=True)
_MAYBE_HIDDEN = Repeat(Ref("hidden"), 0, once=True)
_BEFORE_CLOSER = Repeat(sequence(_GAP, _MAYBE_HIDDEN), 0, once=True)


def _spaced_name(name: str) -> str:
    """Return the name of the variant of a rule with leading white space."""
    return f"spaced_{name}"


class _Spacer:
    """Rewrites expressions in two variants: ``bare``, without leading white space, and ``spaced``, with it."""

    def __init__(self, grammar: Grammar) -> None:
        self._rules: Mapping[str, Expression] = grammar.rules
        self._tokens = grammar.tokens
        self._starts: dict[str, Start] = {}

    def start_of(self, expression: Expression) -> Start:
        """Return whether the first token is a word (or `[`), a sign that may follow any token directly, or either."""
        if isinstance(expression, Literal):
            return "sign" if expression.text != "[" and expression.text in OPENERS | CLOSERS else "word"
        if isinstance(expression, Terminal):
            return "word" if self._tokens[expression.name].is_word else "sign"
        if isinstance(expression, Ref):
            if expression.name not in self._starts:
                self._starts[expression.name] = "mixed"  # ends the recursion for a left-recursive rule
                self._starts[expression.name] = self.start_of(self._rules[expression.name])
            return self._starts[expression.name]
        if isinstance(expression, Repeat):
            return self.start_of(expression.item)
        if isinstance(expression, Choice):
            return _united({self.start_of(option) for option in expression.options})
        first: set[Start] = set()
        for item in expression.items:
            first.add(self.start_of(item))
            if not _may_be_empty(item):
                break
        return _united(first)

    def spaced(self, expression: Expression) -> Expression:
        """Rewrite an expression so that it begins with the white space that its first token requires."""
        if isinstance(expression, Sequence):
            return self._sequence(expression.items, bare=False)
        if isinstance(expression, Repeat):
            return Repeat(self.spaced(expression.item), expression.minimum, expression.once)
        if isinstance(expression, Literal) and expression.text in CLOSERS:
            return sequence(_BEFORE_CLOSER, expression)
        if isinstance(expression, Choice):
            return self._spaced_choice(expression)
        start = self.start_of(expression)
        if start == "mixed":
            assert isinstance(expression, Ref)
            return Ref(_spaced_name(expression.name))
        return sequence(_GAP if start == "word" else _MAYBE_GAP, expression)

    def _spaced_choice(self, expression: Choice) -> Expression:
        """Group options that require the same white space, so that they share it."""
        groups: dict[Start, list[Expression]] = {"word": [], "sign": [], "mixed": []}
        for option in expression.options:
            start = self.start_of(option)
            closing = isinstance(option, Sequence) and isinstance(option.items[0], Repeat)
            kind: Start = "mixed" if start == "mixed" or closing else start
            groups[kind].append(self.spaced(option) if kind == "mixed" else self.bare(option))
        options: list[Expression] = list(groups["mixed"])
        if groups["word"]:
            options.append(sequence(_GAP, choice(*groups["word"])))
        if groups["sign"]:
            options.append(sequence(_MAYBE_GAP, choice(*groups["sign"])))
        return choice(*options)

    def bare(self, expression: Expression) -> Expression:
        """Rewrite an expression for a place where white space has been read, or where none is needed."""
        if isinstance(expression, Sequence):
            return self._sequence(expression.items, bare=True)
        if isinstance(expression, Choice):
            return choice(*(self.bare(option) for option in expression.options))
        if isinstance(expression, Repeat):
            return self._sequence((expression,), bare=True)
        return expression

    def _sequence(self, items: Items[Expression], *, bare: bool) -> Expression:
        """Rewrite a sequence; whether an item is bare depends on the literal before it."""
        done: list[Expression] = []
        for position, item in enumerate(items):
            if bare and isinstance(item, Repeat):
                return sequence(*done, self._bare_repeat(item, items[position + 1 :]))
            if bare and isinstance(item, Literal) and item.text in CLOSERS:
                done.append(_MAYBE_HIDDEN)
            done.append(self.bare(item) if bare else self.spaced(item))
            bare = isinstance(item, Literal) and (item.text in OPENERS or item.text == ".")
            if bare:
                done.append(_GAP if item == Literal(".") else _MAYBE_GAP)
        return sequence(*done)

    def _bare_repeat(self, item: Repeat, rest: Items[Expression]) -> Expression:
        """Rewrite a repetition without leading white space: only its first iteration is bare."""
        iterations = [self.bare(item.item)]
        if not item.once:
            iterations.append(Repeat(self.spaced(item.item), 0))
        with_items = sequence(*iterations, *([self._sequence(rest, bare=False)] if rest else []))
        if item.minimum:
            return with_items
        if not rest:
            return Repeat(with_items, 0, once=True)
        return choice(with_items, self._sequence(rest, bare=True))


def _united(starts: set[Start]) -> Start:
    """Return the start that all alternatives have in common, or mixed."""
    return starts.pop() if len(starts) == 1 else "mixed"


def _may_be_empty(expression: Expression) -> bool:
    """Return whether an expression matches no token at all."""
    return isinstance(expression, Repeat) and not expression.minimum


# Names except certain words as plain patterns, for formats without an exclusion operator.


def without_exclusions(tokens: Mapping[str, TerminalToken]) -> dict[str, TerminalToken]:
    """Return equivalent tokens without exclusions, by expanding excluded words letter by letter into helper tokens."""
    expanded: dict[str, TerminalToken] = {}
    for name, token in tokens.items():
        if token.excluded:
            expanded |= _Excluder(name, token).tokens
        else:
            expanded[name] = token
    return expanded


class _Excluder:
    """Expands the excluded words of a token as a trie; each branch becomes a token ``NAME_1``, ``NAME_2`` and so on."""

    def __init__(self, name: str, token: TerminalToken) -> None:
        self._name = name
        self.tokens: dict[str, TerminalToken] = {name: token}
        self.tokens[name] = TerminalToken(
            self._without(token.pattern, token.excluded), token.title, is_word=token.is_word
        )

    def _without(self, pattern: Pattern, words: frozenset[str]) -> Pattern:
        """Remove the excluded words from options of the form "one character of a class, then any number of another"."""
        if isinstance(pattern, Either):
            return Either(tuple(self._without(option, words) for option in pattern.options))
        if isinstance(pattern, Joined) and len(pattern.parts) == 2:
            first, rest = pattern.parts
            if isinstance(first, Chars) and isinstance(rest, Many) and isinstance(rest.part, Chars):
                matched = {word for word in words if _has(first, word[0]) and all(_has(rest.part, c) for c in word[1:])}
                return self._branch(first, rest, frozenset(matched)) if matched else pattern
        return pattern

    def _branch(self, chars: Chars, rest: Many, words: frozenset[str]) -> Pattern:
        """Return a pattern for one character of ``chars`` followed by ``rest``, except ``words``."""
        assert isinstance(rest.part, Chars)
        options: list[Pattern] = []
        for letter in sorted({word[0] for word in words}):
            endings = frozenset(word[1:] for word in words if word[0] == letter)
            longer = endings - {""}
            more = self._branch(rest.part, rest, longer) if longer else Joined((rest.part, self._rest(rest)))
            after: Pattern = self._named(more)
            options.append(Joined((Text(letter), after if "" in endings else Many(after, 0, 1))))
            chars = _minus(chars, ord(letter))
        return Either((Joined((chars, self._rest(rest))), *options))

    def _rest(self, rest: Many) -> Pattern:
        """Return a reference to the token of the characters after the first one."""
        name = f"{self._name}_REST"
        self.tokens.setdefault(name, TerminalToken(rest, f"the rest of {self._name}"))
        return RuleUse(name)

    def _named(self, pattern: Pattern) -> Pattern:
        """Return a reference to a named token of the pattern; equal patterns share one token."""
        for name, token in self.tokens.items():
            if token.pattern == pattern and name != self._name:
                return RuleUse(name)
        name = f"{self._name}_{len(self.tokens)}"
        self.tokens[name] = TerminalToken(pattern, f"a branch of {self._name}")
        return RuleUse(name)


def _has(chars: Chars, character: str) -> bool:
    """Return whether a character is in a class."""
    return any(first <= ord(character) <= last for first, last in chars.ranges)


def _minus(chars: Chars, point: int) -> Chars:
    """Return a class without one code point."""
    ranges: list[tuple[int, int]] = []
    for first, last in chars.ranges:
        if first <= point <= last:
            ranges += [(low, high) for low, high in ((first, point - 1), (point + 1, last)) if low <= high]
        else:
            ranges.append((first, last))
    return Chars(tuple(ranges))

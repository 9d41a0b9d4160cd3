"""Names without certain words as plain patterns, for formats that cannot say "but not"."""

from __future__ import annotations

from collections.abc import Mapping

from scenelang.grammar.export.model import Chars, Either, Joined, Many, Pattern, Text, Token, Use


def without_exclusions(tokens: Mapping[str, Token]) -> dict[str, Token]:
    """The same tokens, none of which excludes words: their letters are followed one by one, in tokens of their own."""
    found: dict[str, Token] = {}
    for name, token in tokens.items():
        if token.excluded:
            found |= _Excluder(name, token).tokens
        else:
            found[name] = token
    return found


class _Excluder:
    """Follows the words that a token excludes letter by letter; each branch becomes a token ``NAME_1``, ``NAME_2``."""

    def __init__(self, name: str, token: Token) -> None:
        self._name = name
        self.tokens: dict[str, Token] = {name: token}
        self.tokens[name] = Token(self._without(token.pattern, token.excluded), token.title, is_word=token.is_word)

    def _without(self, pattern: Pattern, words: frozenset[str]) -> Pattern:
        """Options that are one character of a class and any number of another lose the words that they match."""
        if isinstance(pattern, Either):
            return Either(tuple(self._without(option, words) for option in pattern.options))
        if isinstance(pattern, Joined) and len(pattern.parts) == 2:
            first, rest = pattern.parts
            if isinstance(first, Chars) and isinstance(rest, Many) and isinstance(rest.part, Chars):
                matched = {word for word in words if _has(first, word[0]) and all(_has(rest.part, c) for c in word[1:])}
                return self._branch(first, rest, frozenset(matched)) if matched else pattern
        return pattern

    def _branch(self, chars: Chars, rest: Many, words: frozenset[str]) -> Pattern:
        """One character of ``chars``, then ``rest``, but none of ``words``."""
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
        name = f"{self._name}_REST"
        self.tokens.setdefault(name, Token(rest, f"the rest of {self._name}"))
        return Use(name)

    def _named(self, pattern: Pattern) -> Pattern:
        """The pattern under a name: equal ones share it."""
        for name, token in self.tokens.items():
            if token.pattern == pattern and name != self._name:
                return Use(name)
        name = f"{self._name}_{len(self.tokens)}"
        self.tokens[name] = Token(pattern, f"a branch of {self._name}")
        return Use(name)


def _has(chars: Chars, character: str) -> bool:
    return any(first <= ord(character) <= last for first, last in chars.ranges)


def _minus(chars: Chars, point: int) -> Chars:
    ranges: list[tuple[int, int]] = []
    for first, last in chars.ranges:
        if first <= point <= last:
            ranges += [(low, high) for low, high in ((first, point - 1), (point + 1, last)) if low <= high]
        else:
            ranges.append((first, last))
    return Chars(tuple(ranges))

"""Patterns of tokens as regular expressions that Python and Rust read alike."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from scenelang.grammar.export.model import Chars, Either, Joined, Many, Pattern, Text, Use

_SPECIAL = frozenset(r".^$*+?{}[]\|()/-&~#")
_NAMED = {"\n": r"\n", "\t": r"\t", "\r": r"\r"}


def regex(pattern: Pattern, uses: Mapping[str, str] = MappingProxyType({})) -> str:
    """The pattern; `/` is escaped, since Lark writes regular expressions between two of them.

    ``uses`` has the regular expressions of the tokens that the pattern uses.
    """
    if isinstance(pattern, Chars):
        return _class(pattern)
    if isinstance(pattern, Text):
        return "".join(_character(c) for c in pattern.text)
    if isinstance(pattern, Joined):
        return "".join(_part(part, uses) for part in pattern.parts)
    if isinstance(pattern, Either):
        return "|".join(regex(option, uses) for option in pattern.options)
    if isinstance(pattern, Use):
        return uses[pattern.token]
    return _part(pattern.part, uses, repeated=True) + _times(pattern)


def _part(pattern: Pattern, uses: Mapping[str, str], repeated: bool = False) -> str:
    """A pattern as a part of a longer one."""
    text = regex(pattern, uses)
    simple = isinstance(pattern, Chars) or (isinstance(pattern, Text) and len(pattern.text) == 1)
    if isinstance(pattern, (Either, Use)) or (repeated and not simple):
        return f"(?:{text})"
    return text


def _times(pattern: Many) -> str:
    least, most = pattern.least, pattern.most
    if most is None:
        return {0: "*", 1: "+"}.get(least, f"{{{least},}}")
    if (least, most) == (0, 1):
        return "?"
    return f"{{{least}}}" if least == most else f"{{{least},{most}}}"


def _class(chars: Chars) -> str:
    ranges = [
        _character(chr(first)) + ("" if first == last else f"-{_character(chr(last))}") for first, last in chars.ranges
    ]
    if len(ranges) == 1 and not chars.negated and chars.ranges[0][0] == chars.ranges[0][1]:
        return ranges[0]
    return f"[{'^' if chars.negated else ''}{''.join(ranges)}]"


def _character(character: str) -> str:
    if character in _NAMED:
        return _NAMED[character]
    if ord(character) > 126:
        return f"\\u{ord(character):04x}"
    return f"\\{character}" if character in _SPECIAL else character

"""GBNF, the grammar format of llama.cpp, also accepted by xgrammar.

It describes characters rather than tokens, so white space is explicit.
"""

from __future__ import annotations

from functools import partial

from scenelang.grammar.export.model import (
    Chars,
    Either,
    Grammar,
    Joined,
    Leaf,
    Literal,
    Many,
    Pattern,
    RuleUse,
    Terminal,
    Text,
    written,
)
from scenelang.grammar.export.spacing import spaced, without_exclusions

_NAMED = {"\n": r"\n", "\t": r"\t", "\r": r"\r", "\\": r"\\"}


def gbnf_text(grammar: Grammar) -> str:
    """Return the grammar as GBNF text with the start rule `root`.

    It uses only literals, character classes, groups and `* + ? {m,n}`.
    """
    whole = spaced(grammar)
    leaf = partial(_leaf, start=whole.start)
    lines = [f"# {grammar.title}"]
    for name, expression in whole.rules.items():
        lines.append(f"{_rule_name(name, whole.start)} ::= {written(expression, leaf)}")
    plain = without_exclusions(whole.tokens)
    lines += [f"{_token_name(name)} ::= {_pattern(token.pattern)}" for name, token in plain.items()]
    return "\n".join(lines) + "\n"


def _rule_name(name: str, start: str) -> str:
    return "root" if name == start else name.replace("_", "-")


def _token_name(name: str) -> str:
    return f"{name.lower().replace('_', '-')}-token"


def _leaf(leaf: Leaf, start: str) -> str:
    if isinstance(leaf, Literal):
        return _quoted(leaf.text)
    return _token_name(leaf.name) if isinstance(leaf, Terminal) else _rule_name(leaf.name, start)


# --- tokens --------------------------------------------------------------------------------------------------------


def _pattern(pattern: Pattern) -> str:
    if isinstance(pattern, Text):
        return _quoted(pattern.text)
    if isinstance(pattern, Chars):
        return _class(pattern)
    if isinstance(pattern, Joined):
        return " ".join(f"({_pattern(part)})" if isinstance(part, Either) else _pattern(part) for part in pattern.parts)
    if isinstance(pattern, Either):
        return " | ".join(_pattern(option) for option in pattern.options)
    if isinstance(pattern, RuleUse):
        return _token_name(pattern.token)
    text = _pattern(pattern.part)
    return (text if isinstance(pattern.part, (Chars, Text, RuleUse)) else f"({text})") + _times(pattern)


def _times(pattern: Many) -> str:
    signs = {(0, None): "*", (1, None): "+", (0, 1): "?"}
    minimum, maximum = pattern.minimum, pattern.maximum
    return signs.get(
        (minimum, maximum),
        f"{{{minimum}}}" if minimum == maximum else f"{{{minimum},{'' if maximum is None else maximum}}}",
    )


def _quoted(text: str) -> str:
    return '"' + "".join('\\"' if c == '"' else _NAMED.get(c, c) for c in text) + '"'


def _class(chars: Chars) -> str:
    """Write a character class; `-` comes last, where every parser treats it as a literal."""
    ranges = [pair for pair in chars.ranges if pair != (45, 45)]
    pieces = [_member(first) + ("" if first == last else f"-{_member(last)}") for first, last in ranges]
    if pieces and pieces[0].startswith("^"):
        pieces.append(pieces.pop(0))
    dash = "-" if len(ranges) < len(chars.ranges) else ""
    return f"[{'^' if chars.negated else ''}{''.join(pieces)}{dash}]"


def _member(point: int) -> str:
    character = chr(point)
    return f"\\{character}" if character in "[]" else _NAMED.get(character, character)

"""EBNF in W3C notation, for human readers: rules over tokens, without white space and comments."""

from __future__ import annotations

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
    TerminalToken,
    Text,
    written,
)

_ABOUT = (
    "White space and comments are allowed between tokens: `; to the end of the line`, `#| nested |#`, `#; datum`.",
    "Adjacent words must be separated by white space. `A - B` matches what A matches but B does not.",
)


def ebnf_text(grammar: Grammar) -> str:
    """Return the grammar as EBNF text, starting with the start rule."""
    lines = [f"/* {grammar.title} */", *(f"/* {line} */" for line in _ABOUT), ""]
    ordered = sorted(grammar.rules, key=lambda name: name != grammar.start)
    lines += [f"{name} ::= {written(grammar.rules[name], _leaf)}" for name in ordered]
    lines += ["", *(f"{name} ::= {_token(token)} /* {token.title} */" for name, token in grammar.tokens.items())]
    return "\n".join(lines) + "\n"


def _leaf(leaf: Leaf) -> str:
    return _quoted(leaf.text) if isinstance(leaf, Literal) else leaf.name


# --- tokens --------------------------------------------------------------------------------------------------------


def _token(token: TerminalToken) -> str:
    text = _pattern(token.pattern)
    if not token.excluded:
        return text
    words = " | ".join(_quoted(word) for word in sorted(token.excluded))
    return f"({text}) - ({words})"


def _pattern(pattern: Pattern) -> str:
    if isinstance(pattern, RuleUse):
        return pattern.token
    if isinstance(pattern, Text):
        return _quoted(pattern.text)
    if isinstance(pattern, Chars):
        return _class(pattern)
    if isinstance(pattern, Joined):
        return " ".join(f"({_pattern(part)})" if isinstance(part, Either) else _pattern(part) for part in pattern.parts)
    if isinstance(pattern, Either):
        return " | ".join(_pattern(option) for option in pattern.options)
    return _repeated(pattern)


def _repeated(pattern: Many) -> str:
    """Write a repetition; W3C notation has no counts, so they are expanded."""
    text = _pattern(pattern.part)
    item = text if isinstance(pattern.part, (Chars, Text, RuleUse)) else f"({text})"
    if pattern.maximum is None:
        return item + ("*" if not pattern.minimum else "+")
    return " ".join([item] * pattern.minimum + [f"{item}?"] * (pattern.maximum - pattern.minimum))


def _quoted(text: str) -> str:
    """Write a literal; characters that are not allowed in quotes are written as code points."""
    if text.isprintable():
        return f"'{text}'" if '"' in text else f'"{text}"'
    return " ".join(_code(ord(c)) for c in text)


def _class(chars: Chars) -> str:
    """Write a character class; code points come last, so that no digit follows one."""
    pieces = [_member(first) + ("" if first == last else f"-{_member(last)}") for first, last in chars.ranges]
    ordered = sorted(pieces, key=lambda piece: piece.startswith("#x"))
    return f"[{'^' if chars.negated else ''}{''.join(ordered)}]"


def _member(point: int) -> str:
    character = chr(point)
    return character if 32 < point < 127 and character not in "[]^-#\\" else _code(point)


def _code(point: int) -> str:
    return f"#x{point:X}"

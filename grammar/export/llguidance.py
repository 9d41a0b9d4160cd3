"""llguidance's dialect of Lark: no look-around, so white space is written out and names say what they are not."""

from __future__ import annotations


from scenelang.grammar.export.model import (
    Choice,
    Expression,
    Grammar,
    Literal,
    Many,
    Ref,
    Sequence,
    Terminal,
    Text,
    Token,
)
from scenelang.grammar.export.regex import regex
from scenelang.grammar.export.spacing import WHITE, spaced


def llguidance_text(grammar: Grammar) -> str:
    """The grammar as `llguidance.LLMatcher` takes it."""
    whole = spaced(grammar, Many(WHITE, 1))
    lines = [f"// {grammar.title}, for llguidance.", ""]
    lines += [f"{name}: {_write(expression)}" for name, expression in whole.rules.items()]
    lines.append("")
    for name, token in whole.tokens.items():
        lines += _token(name, token)
    return "\n".join(lines) + "\n"


def _write(expression: Expression) -> str:
    if isinstance(expression, Literal):
        return f'"{expression.text}"'
    if isinstance(expression, (Terminal, Ref)):
        return expression.name
    if isinstance(expression, Sequence):
        return " ".join(_group(item, Choice) for item in expression.items)
    if isinstance(expression, Choice):
        return " | ".join(_write(option) for option in expression.options)
    sign = "?" if expression.once else "+" if expression.least else "*"
    return _group(expression.item, Choice, Sequence) + sign


def _group(expression: Expression, *kinds: type) -> str:
    text = _write(expression)
    return f"({text})" if isinstance(expression, kinds) else text


def _token(name: str, token: Token) -> list[str]:
    """A terminal, with the words that it excludes and its fixed ends as terminals of their own."""
    text = f"/{regex(token.pattern)}/"
    lines = []
    if token.excluded:
        words = "|".join(regex(Text(word)) for word in sorted(token.excluded))
        text = f"{text} & ~/{words}/"
    if token.prefix or token.suffix:
        lines.append(f"{name}_NAME: {text}")
        ends = [f"/{regex(end)}/" if end else "" for end in (token.prefix, token.suffix)]
        text = f"{ends[0]} {name}_NAME {ends[1]}".strip()
    return [*lines, f"{name}: {text}  // {token.title}"]

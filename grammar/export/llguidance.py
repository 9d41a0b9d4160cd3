"""llguidance's dialect of Lark: no look-around, so white space is written out and names say what they are not."""

from __future__ import annotations

from scenelang.grammar.export.model import (
    Choice,
    Either,
    Expression,
    Grammar,
    Joined,
    Literal,
    Many,
    Pattern,
    Ref,
    RuleUse,
    Sequence,
    Terminal,
    TerminalToken,
    Text,
    regex,
)
from scenelang.grammar.export.spacing import WHITE, spaced


def llguidance_text(grammar: Grammar) -> str:
    """The grammar as `llguidance.LLMatcher` takes it."""
    whole = spaced(grammar, Many(WHITE, 1))
    lines = [f"// {grammar.title}, for llguidance.", ""]
    lines += [f"{name}: {_write(expression)}" for name, expression in whole.rules.items()]
    lines.append("")
    for name, token in whole.tokens.items():
        lines.append(_token(name, token))
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


def _token(name: str, token: TerminalToken) -> str:
    text = _terminal(token.pattern)
    if token.excluded:
        words = "|".join(regex(Text(word)) for word in sorted(token.excluded))
        text = f"{text} & ~/{words}/"
    return f"{name}: {text}  // {token.title}"


def _terminal(pattern: Pattern) -> str:
    """A pattern: a regular expression, or several and the tokens that it uses side by side."""
    if isinstance(pattern, RuleUse):
        return pattern.token
    if isinstance(pattern, Joined) and _uses(pattern):
        return " ".join(_terminal(part) for part in pattern.parts)
    if isinstance(pattern, Either) and _uses(pattern):
        return f"({' | '.join(_terminal(option) for option in pattern.options)})"
    return f"/{regex(pattern)}/"


def _uses(pattern: Pattern) -> bool:
    if isinstance(pattern, Joined):
        return any(map(_uses, pattern.parts))
    return isinstance(pattern, RuleUse) or (isinstance(pattern, Either) and any(map(_uses, pattern.options)))

"""Lark grammars: the standard format, where white space and comments are ignored, and llguidance's dialect."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import partial

from scenelang.grammar.export.model import (
    Either,
    Expression,
    Grammar,
    Joined,
    Leaf,
    Literal,
    Many,
    Pattern,
    Ref,
    RuleUse,
    Terminal,
    TerminalToken,
    Text,
    choice,
    is_punctuation,
    literals,
    regex,
    substitute,
    written,
)
from scenelang.grammar.export.spacing import WHITE, spaced

_END = r"""(?=[\s()\]";'`,]|#\||$)"""  # lookahead for the end of a word
_NESTED = 4  # depth of nested comments: a regular expression can only nest to a fixed depth

_SYMBOLS = ("SYMBOL", "TEMPLATE_SYMBOL", "PATTERN_SYMBOL")  # tokens that also match words of the rules
_SIGNS = {
    "*": "star", "/": "slash", "+": "plus", "-": "minus", "%": "percent", "=": "equals", "<": "less", ">": "greater",
    "!": "bang", "@": "at", "&": "and", "_": "underscore", ".": "dot", ":": "colon",
}  # fmt: skip


def lark_text(grammar: Grammar) -> str:
    """Return the grammar as text for `lark.Lark(text, parser="lalr")`.

    Lark's Earley parser accepts it too, but is slow.
    """
    names = word_names(literals(grammar.rules))
    classes = _classes(grammar, names)
    text_of = partial(written, leaf=partial(_leaf, names=names), several=(Literal, Terminal))
    lines = [f'// {grammar.title}, for lark.Lark(text, parser="lalr").', f"// Comments nest up to {_NESTED} deep.", ""]
    for name, expression in grammar.rules.items():
        text = text_of(substitute(expression, {name.upper(): Ref(name) for name in classes}))
        lines.append(f"{name}: _hidden {text}" if name == grammar.start else f"{name}: {text}")
    lines += [f"{name}: {text_of(expression)}" for name, expression in classes.items()]
    lines += [
        "",
        "// `#;` hides the next datum; every token may be followed by hidden ones",
        '_hidden: ("#;" _hidden datum)?',
        "",
    ]
    lines += [f"{name}: /{_word_regex(word)}/" for word, name in names.items()]
    for name, token in grammar.tokens.items():
        if name not in _SYMBOLS:
            lines.append(f"{name}: /{_token_regex(name, grammar, names)}/  // {token.title}")
    return "\n".join([*lines, "", r"%ignore /\s+/", r"%ignore /;[^\n]*/", f"%ignore /{_block(_NESTED)}/"]) + "\n"


def _classes(grammar: Grammar, names: Mapping[str, str]) -> dict[str, Expression]:
    """Return rules for tokens that also match words of the rules: Lark's lexer assigns each text a single terminal."""
    rules: dict[str, Expression] = {}
    for name in _SYMBOLS:
        if name in grammar.tokens:
            words = [word for word in names if is_symbol(word) and word not in grammar.tokens[name].excluded]
            rules[name.lower()] = choice(Terminal("NAME"), *map(Literal, words))
    keywords = [word for word in names if word[0] == ":"]
    if keywords:
        rules["keyword"] = choice(Terminal("KEYWORD"), *map(Literal, keywords))
    return rules


def is_symbol(word: str) -> bool:
    """Return whether a word of the rules reads as a symbol."""
    return word[0] != ":" and word != "."


def word_names(words: Iterable[str]) -> dict[str, str]:
    """Return a terminal name for each literal word of the rules, such as WORD_LET_STAR for ``let*``."""
    names = {}
    for word in sorted(words):
        spelled = word.replace("-", "_") if word[0].isalpha() else word
        pieces = [f"_{_SIGNS[c]}_" if (c in _SIGNS and c != "_") or word == "_" else c for c in spelled]
        name = "_".join(piece for piece in "".join(pieces).split("_") if piece)
        names[word] = f"{'WORD' if word[0].isalpha() else 'SIGN'}_{name}".upper()
    return names


def _leaf(leaf: Leaf, names: Mapping[str, str]) -> str:
    """Write a leaf; every token may be followed by hidden datums, which are a separate rule."""
    if isinstance(leaf, Ref):
        return leaf.name
    if isinstance(leaf, Terminal):
        return f"{leaf.name} _hidden"
    return f'"{leaf.text}" _hidden' if is_punctuation(leaf.text) else f"{names[leaf.text]} _hidden"


def _word_regex(word: str) -> str:
    return regex(Text(word)) + _END


def _token_regex(name: str, grammar: Grammar, names: Mapping[str, str]) -> str:
    token = grammar.tokens[name]
    used = grammar.tokens["NAME"]
    uses = {"NAME": _excluding(used.excluded, "::") + f"(?:{regex(used.pattern)})"}
    text = regex(token.pattern, uses)
    if isinstance(token.pattern, Either):
        text = f"(?:{text})"
    excluded = token.excluded | {word for word in names if word[0] == ":" and name == "KEYWORD"}
    return _excluding(excluded, _END) + text + (_END if token.is_word else "")


def _excluding(words: Iterable[str], end: str) -> str:
    """Return a negative lookahead for ``words`` followed by ``end``."""
    options = "|".join(regex(Text(word)) for word in sorted(words))
    return f"(?!(?:{options}){end})" if options else ""


def _block(depth: int) -> str:
    """Return a regular expression of block comments nested up to ``depth`` levels."""
    inner = r"[^#|]|#(?!\|)|\|(?!#)"
    return rf"#\|(?:{inner}|{_block(depth - 1)})*\|#" if depth > 1 else rf"#\|(?:{inner})*\|#"


# llguidance's dialect of Lark has no lookaround, so white space is explicit and names exclude words with `& ~`.


def llguidance_text(grammar: Grammar) -> str:
    """Return the grammar as text for `llguidance.LLMatcher`."""
    whole = spaced(grammar, Many(WHITE, 1))
    lines = [f"// {grammar.title}, for llguidance.", ""]
    lines += [f"{name}: {written(expression, _llguidance_leaf)}" for name, expression in whole.rules.items()]
    lines.append("")
    for name, token in whole.tokens.items():
        lines.append(_token(name, token))
    return "\n".join(lines) + "\n"


def _llguidance_leaf(leaf: Leaf) -> str:
    return f'"{leaf.text}"' if isinstance(leaf, Literal) else leaf.name


def _token(name: str, token: TerminalToken) -> str:
    text = _terminal(token.pattern)
    if token.excluded:
        words = "|".join(regex(Text(word)) for word in sorted(token.excluded))
        text = f"{text} & ~/{words}/"
    return f"{name}: {text}  // {token.title}"


def _terminal(pattern: Pattern) -> str:
    """Write a pattern as a regular expression, or as a sequence of expressions and references to other tokens."""
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

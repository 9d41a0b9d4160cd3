"""The grammar as text: Lark, llguidance's dialect of it, GBNF of llama.cpp, EBNF for readers, TextMate for editors."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any

from scenelang.grammar.export.model import (
    ANNOTATION,
    Chars,
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
    tokens,
    written,
)
from scenelang.grammar.export.spacing import WHITE, spaced, without_exclusions

_END = r"""(?=[\s()\]";'`,]|#\||$)"""  # lookahead for the end of a word
_MAX_NESTED_COMMENTS = 4  # levels: a regular expression nests to a fixed depth only, and grows with it

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
    lines = [
        f'// {grammar.title}, for lark.Lark(text, parser="lalr").',
        f"// Comments nest up to {_MAX_NESTED_COMMENTS} deep.",
        "",
    ]
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
    return (
        "\n".join([*lines, "", r"%ignore /\s+/", r"%ignore /;[^\n]*/", f"%ignore /{_block(_MAX_NESTED_COMMENTS)}/"])
        + "\n"
    )


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
    """Return a regular expression of a word of the rules, which must not continue."""
    return regex(Text(word)) + _END


def _token_regex(name: str, grammar: Grammar, names: Mapping[str, str]) -> str:
    """Return a regular expression of a terminal; words of the rules are excluded by a lookahead."""
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
    """Write a leaf in llguidance's dialect."""
    return f'"{leaf.text}"' if isinstance(leaf, Literal) else leaf.name


def _token(name: str, token: TerminalToken) -> str:
    """Write the definition of a terminal in llguidance's dialect."""
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
    """Return whether a pattern refers to another token."""
    if isinstance(pattern, Joined):
        return any(map(_uses, pattern.parts))
    return isinstance(pattern, RuleUse) or (isinstance(pattern, Either) and any(map(_uses, pattern.options)))


def _pattern_text(
    pattern: Pattern,
    use: Callable[[str], str],
    quoted: Callable[[str], str],
    characters: Callable[[Chars], str],
    repeated: Callable[[str, Many], str],
) -> str:
    """Write a token's pattern in the notation of EBNF and GBNF.

    They differ in names (``use``), literals (``quoted``), classes (``characters``) and counts (``repeated``).
    """

    def write(part: Pattern) -> str:
        """Write a subpattern."""
        if isinstance(part, RuleUse):
            return use(part.token)
        if isinstance(part, Text):
            return quoted(part.text)
        if isinstance(part, Chars):
            return characters(part)
        if isinstance(part, Joined):
            return " ".join(f"({write(p)})" if isinstance(p, Either) else write(p) for p in part.parts)
        if isinstance(part, Either):
            return " | ".join(write(option) for option in part.options)
        text = write(part.part)
        return repeated(text if isinstance(part.part, (Chars, Text, RuleUse)) else f"({text})", part)

    return write(pattern)


_EBNF_NOTES = (
    "White space and comments are allowed between tokens: `; to the end of the line`, `#| nested |#`, `#; datum`.",
    "Adjacent words must be separated by white space. `A - B` matches what A matches but B does not.",
)


def ebnf_text(grammar: Grammar) -> str:
    """Return the grammar as EBNF text, starting with the start rule."""
    lines = [f"/* {grammar.title} */", *(f"/* {line} */" for line in _EBNF_NOTES), ""]
    ordered = sorted(grammar.rules, key=lambda name: name != grammar.start)
    lines += [f"{name} ::= {written(grammar.rules[name], _ebnf_leaf)}" for name in ordered]
    lines += ["", *(f"{name} ::= {_ebnf_token(token)} /* {token.title} */" for name, token in grammar.tokens.items())]
    return "\n".join(lines) + "\n"


def _ebnf_leaf(leaf: Leaf) -> str:
    """Write a leaf as EBNF."""
    return _ebnf_quoted(leaf.text) if isinstance(leaf, Literal) else leaf.name


def _ebnf_token(token: TerminalToken) -> str:
    """Write a terminal as EBNF, its excluded words as ``A - B``."""
    text = _ebnf_pattern(token.pattern)
    if not token.excluded:
        return text
    words = " | ".join(_ebnf_quoted(word) for word in sorted(token.excluded))
    return f"({text}) - ({words})"


def _ebnf_pattern(pattern: Pattern) -> str:
    """Write a pattern as EBNF."""
    return _pattern_text(pattern, lambda name: name, _ebnf_quoted, _ebnf_class, _ebnf_repeated)


def _ebnf_repeated(item: str, pattern: Many) -> str:
    """Write a repetition; W3C notation has no counts, so they are expanded."""
    if pattern.maximum is None:
        return item + ("*" if not pattern.minimum else "+")
    return " ".join([item] * pattern.minimum + [f"{item}?"] * (pattern.maximum - pattern.minimum))


def _ebnf_quoted(text: str) -> str:
    """Write a literal; characters that are not allowed in quotes are written as code points."""
    if text.isprintable():
        return f"'{text}'" if '"' in text else f'"{text}"'
    return " ".join(_ebnf_code(ord(c)) for c in text)


def _ebnf_class(chars: Chars) -> str:
    """Write a character class; code points come last, so that no digit follows one."""
    pieces = [_ebnf_member(first) + ("" if first == last else f"-{_ebnf_member(last)}") for first, last in chars.ranges]
    ordered = sorted(pieces, key=lambda piece: piece.startswith("#x"))
    return f"[{'^' if chars.negated else ''}{''.join(ordered)}]"


def _ebnf_member(point: int) -> str:
    """Write a code point within a class: as itself if that is plain ASCII."""
    character = chr(point)
    return character if 32 < point < 127 and character not in "[]^-#\\" else _ebnf_code(point)


def _ebnf_code(point: int) -> str:
    """Write a code point as W3C EBNF does."""
    return f"#x{point:X}"


_GBNF_ESCAPES = {"\n": r"\n", "\t": r"\t", "\r": r"\r", "\\": r"\\"}


def gbnf_text(grammar: Grammar) -> str:
    """Return the grammar as GBNF text with the start rule `root`.

    It uses only literals, character classes, groups and `* + ? {m,n}`.
    """
    whole = spaced(grammar)
    leaf = partial(_gbnf_leaf, start=whole.start)
    lines = [f"# {grammar.title}"]
    for name, expression in whole.rules.items():
        lines.append(f"{_gbnf_rule(name, whole.start)} ::= {written(expression, leaf)}")
    plain = without_exclusions(whole.tokens)
    lines += [f"{_gbnf_token(name)} ::= {_gbnf_pattern(token.pattern)}" for name, token in plain.items()]
    return "\n".join(lines) + "\n"


def _gbnf_rule(name: str, start: str) -> str:
    """Return the GBNF name of a rule; llama.cpp starts with ``root`` and allows no underscores."""
    return "root" if name == start else name.replace("_", "-")


def _gbnf_token(name: str) -> str:
    """Return the GBNF name of a terminal, which is a rule like others there."""
    return f"{name.lower().replace('_', '-')}-token"


def _gbnf_leaf(leaf: Leaf, start: str) -> str:
    """Write a leaf as GBNF."""
    if isinstance(leaf, Literal):
        return _gbnf_quoted(leaf.text)
    return _gbnf_token(leaf.name) if isinstance(leaf, Terminal) else _gbnf_rule(leaf.name, start)


def _gbnf_pattern(pattern: Pattern) -> str:
    """Write a pattern as GBNF."""
    return _pattern_text(pattern, _gbnf_token, _gbnf_quoted, _gbnf_class, _gbnf_repeated)


def _gbnf_repeated(item: str, pattern: Many) -> str:
    """Write a repetition with the shortest quantifier."""
    minimum, maximum = pattern.minimum, pattern.maximum
    sign = {(0, None): "*", (1, None): "+", (0, 1): "?"}.get((minimum, maximum))
    if sign is None:
        sign = f"{{{minimum}}}" if minimum == maximum else f"{{{minimum},{'' if maximum is None else maximum}}}"
    return item + sign


def _gbnf_quoted(text: str) -> str:
    """Write a literal as GBNF."""
    return '"' + "".join('\\"' if c == '"' else _GBNF_ESCAPES.get(c, c) for c in text) + '"'


def _gbnf_class(chars: Chars) -> str:
    """Write a character class; `-` comes last, where every parser treats it as a literal."""
    ranges = [pair for pair in chars.ranges if pair != (45, 45)]
    pieces = [_gbnf_member(first) + ("" if first == last else f"-{_gbnf_member(last)}") for first, last in ranges]
    if pieces and pieces[0].startswith("^"):
        pieces.append(pieces.pop(0))
    dash = "-" if len(ranges) < len(chars.ranges) else ""
    return f"[{'^' if chars.negated else ''}{''.join(pieces)}{dash}]"


def _gbnf_member(point: int) -> str:
    """Write a code point within a class."""
    character = chr(point)
    return f"\\{character}" if character in "[]" else _GBNF_ESCAPES.get(character, character)


# TextMate grammars, which VS Code and others read: patterns over single lines, with scopes that themes color.

SCOPE = "source.scene"
_STOPS = r"""\s()\[\]";'`,"""
_TOKEN_END = rf"(?=[{_STOPS}]|$)"
_TOKEN_START = rf"(?<=[{_STOPS}]|^)"
_SYMBOL = rf"[^{_STOPS}:]+"


def textmate_text(names: Mapping[str, Iterable[str]]) -> str:
    """Return the TextMate grammar as JSON.

    ``names`` maps a scope, such as `keyword.control`, to words of the language.
    """
    grammar = {
        "name": "Scene",
        "scopeName": SCOPE,
        "fileTypes": ["scene"],
        "patterns": [{"include": "#datum"}],
        "repository": {
            "datum": _patterns("comments", "string", "definition", "word", "annotation", "atoms", "names", "brackets"),
            "comments": {"patterns": _comments()},
            "block-comment": _block_comment(),
            "hidden-list": _hidden_list(),
            "string": _string("string.quoted.double"),
            "definition": {"patterns": _definitions()},
            "word": _word(),
            "annotation": _annotation(),
            "atoms": {"patterns": _atoms()},
            "names": {"patterns": [_named(scope, words) for scope, words in names.items()]},
            "brackets": {"patterns": _brackets()},
        },
    }
    return json.dumps(grammar, indent=2, ensure_ascii=True) + "\n"


def _scoped(name: str) -> str:
    """Return a scope with the suffix of the language."""
    return f"{name}.scene"


def _patterns(*names: str) -> dict[str, Any]:
    """Return a rule that tries other rules of the repository in order."""
    return {"patterns": [{"include": f"#{name}"} for name in names]}


def _captures(*names: str) -> dict[str, Any]:
    """Return the scopes of the groups of a pattern, from group 1 on; an empty one has no scope."""
    return {str(number): {"name": _scoped(name)} for number, name in enumerate(names, 1) if name}


def _comments() -> list[dict[str, Any]]:
    """Patterns of comments; a hidden list is commented out up to its closing bracket."""
    hidden = _scoped("comment.block.datum")
    return [
        {"include": "#block-comment"},
        {"name": hidden, "begin": r"#;\s*['`,@]*[(\[]", "end": r"[)\]]", "patterns": [{"include": "#hidden-list"}]},
        {"name": hidden, "match": rf"#;\s*['`,@]*[^{_STOPS}]+"},
        {"name": hidden, "match": "#;"},
        {"name": _scoped("comment.line.semicolon"), "match": ";.*$"},
    ]


def _block_comment() -> dict[str, Any]:
    inner = [{"include": "#block-comment"}]
    return {"name": _scoped("comment.block"), "begin": r"#\|", "end": r"\|#", "patterns": inner}


def _hidden_list() -> dict[str, Any]:
    """Contents of a hidden list; only constructs that may contain a closing bracket matter."""
    nested = {"begin": r"[(\[]", "end": r"[)\]]", "patterns": [{"include": "#hidden-list"}]}
    plain = {"begin": '"', "end": '"', "patterns": [{"match": r"\\."}]}
    return {"patterns": [{"include": "#block-comment"}, {"match": ";.*$"}, plain, nested]}


def _string(name: str) -> dict[str, Any]:
    """Pattern of a string, in which unknown escapes are marked."""
    escapes = [
        {
            "name": _scoped("constant.character.escape"),
            "match": r"\\(?:[ntrab0\"\\]|u[0-9A-Fa-f]{4}|x[0-9A-Fa-f]+;|\s*$)",
        },
        {"name": _scoped("invalid.illegal.escape"), "match": r"\\."},
    ]
    return {"name": _scoped(name), "begin": '"', "end": '"', "patterns": escapes}


def _definitions() -> list[dict[str, Any]]:
    """Patterns of a defining form and the name it defines."""
    functions = r"define-macro|define"
    values = r"define-record|define-syntax|define|param"
    after = r"(?<=\()\s*"
    function = ("storage.type", "punctuation.section.parens", "entity.name.function")
    return [
        {"match": rf"{after}({functions})\s+(\()({_SYMBOL})", "captures": _captures(*function)},
        {"match": rf"{after}({values})\s+({_SYMBOL})", "captures": _captures("storage.type", "entity.name.variable")},
    ]


def _word() -> dict[str, Any]:
    """Pattern of the word after `bind`, `call` and similar forms."""
    return {
        "match": r'(?<=\()\s*(bind|call|retrieve|primitive|scene|bound\?)\s+("(?:[^"\\]|\\.)*")',
        "captures": _captures("keyword.other.paper", "string.quoted.double.word entity.name.type.word"),
    }


def _annotation() -> dict[str, Any]:
    """Pattern of a parameter with a type, ``name::Type``."""
    type_ = regex(Joined(ANNOTATION.parts[1:]))
    return {
        "match": rf"{_TOKEN_START}(:?{_SYMBOL})(::)({type_}){_TOKEN_END}",
        "captures": _captures("variable.parameter", "punctuation.separator.annotation", "storage.type.annotation"),
    }


def _atoms() -> list[dict[str, Any]]:
    """Patterns of numbers and other constants, as the other notations have them."""
    terminals = tokens(frozenset())
    scopes = {
        "NUMBER": "constant.numeric", "BOOLEAN": "constant.language.boolean", "NONE": "constant.language.none",
        "HANDLE": "constant.other.handle", "KEYWORD": "constant.other.keyword",
    }  # fmt: skip
    return [
        {"name": _scoped(scope), "match": f"{_TOKEN_START}(?:{regex(terminals[name].pattern)}){_TOKEN_END}"}
        for name, scope in scopes.items()
    ]


def _named(scope: str, words: Iterable[str]) -> dict[str, Any]:
    """Pattern of words of the language, longest first."""
    options = "|".join(regex(Text(word)) for word in sorted(words, key=lambda word: (-len(word), word)))
    return {"name": _scoped(scope), "match": f"{_TOKEN_START}(?:{options}){_TOKEN_END}"}


def _brackets() -> list[dict[str, Any]]:
    """Patterns of brackets and prefixes, and last of all other symbols."""
    return [
        {"name": _scoped("punctuation.section.parens"), "match": r"[()]"},
        {"name": _scoped("punctuation.section.array"), "match": r"[\[\]]"},
        {"name": _scoped("keyword.operator.quote"), "match": "['`]|,@?"},
        {"name": _scoped("variable.other"), "match": rf"[^{_STOPS}]+"},
    ]

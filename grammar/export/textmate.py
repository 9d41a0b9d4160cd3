"""TextMate grammar for syntax highlighting in editors; it matches lines, not nested forms."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Any

from scenelang.grammar.export.model import ANNOTATION, Joined, Text, regex, tokens

SCOPE = "source.scene"
_STOP = r"""\s()\[\]";'`,"""
_END = rf"(?=[{_STOP}]|$)"
_START = rf"(?<=[{_STOP}]|^)"
_SYMBOL = rf"[^{_STOP}:]+"


def textmate_text(names: Mapping[str, Iterable[str]]) -> str:
    """Return the grammar as JSON; ``names`` maps a scope, such as `keyword.control`, to words of the language."""
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
    return f"{name}.scene"


def _patterns(*names: str) -> dict[str, Any]:
    return {"patterns": [{"include": f"#{name}"} for name in names]}


def _captures(*names: str) -> dict[str, Any]:
    return {str(number): {"name": _scoped(name)} for number, name in enumerate(names, 1) if name}


def _comments() -> list[dict[str, Any]]:
    hidden = _scoped("comment.block.datum")
    return [
        {"include": "#block-comment"},
        {"name": hidden, "begin": r"#;\s*['`,@]*[(\[]", "end": r"[)\]]", "patterns": [{"include": "#hidden-list"}]},
        {"name": hidden, "match": rf"#;\s*['`,@]*[^{_STOP}]+"},
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
    type_ = regex(Joined(ANNOTATION.parts[1:]))
    return {
        "match": rf"{_START}(:?{_SYMBOL})(::)({type_}){_END}",
        "captures": _captures("variable.parameter", "punctuation.separator.annotation", "storage.type.annotation"),
    }


def _atoms() -> list[dict[str, Any]]:
    known = tokens(frozenset())
    scopes = {
        "NUMBER": "constant.numeric", "BOOLEAN": "constant.language.boolean", "NONE": "constant.language.none",
        "HANDLE": "constant.other.handle", "KEYWORD": "constant.other.keyword",
    }  # fmt: skip
    return [
        {"name": _scoped(scope), "match": f"{_START}(?:{regex(known[name].pattern)}){_END}"}
        for name, scope in scopes.items()
    ]


def _named(scope: str, words: Iterable[str]) -> dict[str, Any]:
    options = "|".join(regex(Text(word)) for word in sorted(words, key=lambda word: (-len(word), word)))
    return {"name": _scoped(scope), "match": f"{_START}(?:{options}){_END}"}


def _brackets() -> list[dict[str, Any]]:
    return [
        {"name": _scoped("punctuation.section.parens"), "match": r"[()]"},
        {"name": _scoped("punctuation.section.array"), "match": r"[\[\]]"},
        {"name": _scoped("keyword.operator.quote"), "match": "['`]|,@?"},
        {"name": _scoped("variable.other"), "match": rf"[^{_STOP}]+"},
    ]

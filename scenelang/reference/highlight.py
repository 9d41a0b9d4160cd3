"""Pygments lexer of the language, with the alias `scene`. Names are loaded lazily, when text is highlighted.

Incomplete text is supported: an unterminated string or comment extends to the end. No text is lost, and nothing
is an error token, so the lexer serves while a program is being typed.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import Any, ClassVar

from pygments.lexer import RegexLexer, bygroups
from pygments.token import Comment, Keyword, Name, Number, Operator, Punctuation, String, Text, Whitespace, _TokenType

_STOP = r"""\s()\[\]";'`,"""
_END = rf"(?=[{_STOP}]|\Z)"
_SYMBOL = rf"[^{_STOP}]+"
_PLAIN = rf"(?:(?!::)[^{_STOP}])+"  # a symbol without its annotation
_WORD = r'"(?:[^"\\]|\\.)*"?'
_TYPE = r"[^\s()\[\]\";'`,]*(?:\[[^()\"\n]*?\]+)?"


class SceneLexer(RegexLexer):  # type: ignore[misc]
    """Lexer for Pygments, and for prompt_toolkit through ``PygmentsLexer``."""

    name = "Scene"
    aliases: ClassVar[list[str]] = ["scene", "scenelang"]
    filenames: ClassVar[list[str]] = ["*.scene"]
    mimetypes: ClassVar[list[str]] = ["text/x-scene"]
    url = ""

    tokens: ClassVar[dict[str, Any]] = {
        "root": [
            (r"\s+", Whitespace),
            (r"#\|", Comment.Multiline, "block"),
            (r"#;", Comment.Preproc, "hidden"),
            (r";[^\n]*", Comment.Single),
            (r'(\()(\s*)(bind|call|retrieve|primitive|scene|bound\?)(\s+)(")',
             bygroups(Punctuation, Whitespace, Keyword.Namespace, Whitespace, Name.Class), "word"),
            (rf"(\()(\s*)(define-macro|define)(\s+)(\()({_PLAIN})",
             bygroups(Punctuation, Whitespace, Keyword.Declaration, Whitespace, Punctuation, Name.Function)),
            (rf"(\()(\s*)(define-syntax|define-record|define|param)(\s+)({_PLAIN})",
             bygroups(Punctuation, Whitespace, Keyword.Declaration, Whitespace, Name.Variable)),
            (r'"', String.Double, "string"),
            (r"[()\[\]]", Punctuation),
            (r"['`]|,@?", Operator),
            (rf"(:?{_PLAIN})(::)({_TYPE})", bygroups(Name.Variable, Punctuation, Keyword.Type)),
            (rf"[+-]?\d+{_END}", Number.Integer),
            (rf"[+-]?(?:\d+\.\d*|\.\d+|\d+)(?:[eE][+-]?\d+)?{_END}", Number.Float),
            (rf"(?:#t|#f|#true|#false|none){_END}", Keyword.Constant),
            (rf"<[A-Za-z][A-Za-z0-9_-]*\*?>{_END}", Name.Decorator),
            (rf":{_SYMBOL}", Name.Attribute),
            (_SYMBOL, Name),
            (r".", Text),
        ],
        "string": [
            (r'[^"\\]+', String.Double),
            (r"\\(?:x[0-9A-Fa-f]+;|u[0-9A-Fa-f]{4}|.|\n)", String.Escape),
            (r"\\", String.Escape),
            (r'"', String.Double, "#pop"),
        ],
        "word": [
            (r'[^"\\]+', Name.Class),
            (r"\\(?:.|\n)?", String.Escape),
            (r'"', Name.Class, "#pop"),
        ],
        "block": [
            (r"[^#|]+", Comment.Multiline),
            (r"#\|", Comment.Multiline, "#push"),
            (r"\|#", Comment.Multiline, "#pop"),
            (r"[#|]", Comment.Multiline),
        ],
        "hidden": [  # up to the end of one datum
            (r"\s+", Comment.Preproc),
            (r"#;|['`]|,@?", Comment.Preproc),
            (r"[(\[]", Comment.Preproc, ("#pop", "hidden-list")),
            (_WORD, Comment.Preproc, "#pop"),
            (r";[^\n]*", Comment.Single),
            (_SYMBOL, Comment.Preproc, "#pop"),
            (r"", Comment.Preproc, "#pop"),
        ],
        "hidden-list": [
            (r"#\|", Comment.Multiline, "block"),
            (r";[^\n]*", Comment.Single),
            (_WORD, Comment.Preproc),
            (r"[(\[]", Comment.Preproc, "#push"),
            (r"[)\]]", Comment.Preproc, "#pop"),
            (r"[^()\[\]\";#]+|#", Comment.Preproc),
        ],
    }  # fmt: skip

    def get_tokens_unprocessed(
        self, text: str, stack: Iterable[str] = ("root",)
    ) -> Iterator[tuple[int, _TokenType, str]]:
        """Yield tokens with offsets; symbols known to the language get specific token types."""
        known = _known()
        for start, token, value in super().get_tokens_unprocessed(text, stack):
            yield start, known.get(value, token) if token is Name else token, value


@cache
def _known() -> dict[str, _TokenType]:
    """Return the token types of the language's names, from its registry."""
    from scenelang.stdlib.reference import vocabulary

    names = vocabulary()
    return {
        **dict.fromkeys(names.functions, Name.Builtin),
        **dict.fromkeys(names.constants, Name.Constant),
        **dict.fromkeys(names.forms, Keyword),
        **dict.fromkeys(names.definitions, Keyword.Declaration),
        **dict.fromkeys(names.paper, Keyword.Namespace),
    }


# Generated files of the VS Code extension: the TextMate grammar and the snippets.
#
# ``python -P -m scenelang.reference.highlight editors/vscode`` writes both (`make editors`); a test
# detects stale files.


def snippets_text() -> str:
    """Return a snippet for every standalone form, as JSON for VS Code."""
    from scenelang.interpreter.expand.forms import FORMS, SPELLED_OUT, snippet

    forms = [form for form in FORMS.values() if form.name not in SPELLED_OUT - {"begin"}]
    entries = {form.name: {"prefix": form.name, "body": snippet(form), "description": form.doc} for form in forms}
    return json.dumps(entries, indent=2) + "\n"


def files() -> dict[str, str]:
    """Return the generated texts by path within the extension's folder."""
    from scenelang.stdlib.reference import TEXTMATE, grammar_text

    return {"syntaxes/scene.tmLanguage.json": grammar_text(TEXTMATE), "snippets/scene.json": snippets_text()}


def main(folder: str) -> None:
    """Write the TextMate grammar and the snippets to ``folder``, that of the VS Code extension."""
    for name, text in files().items():
        Path(folder, name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1])

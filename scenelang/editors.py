"""What the extension for VS Code takes from the language: its TextMate grammar and its snippets.

``python -P -m scenelang.editors editors/vscode`` writes both (`make editors`); a test says when they are stale.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from scenelang.cli.grammar import TEXTMATE, grammar_text
from scenelang.interpreter.form_shapes import SPELLED_OUT
from scenelang.interpreter.forms import FORMS
from scenelang.interpreter.snippets import snippet


def snippets_text() -> str:
    """A snippet for every form that stands by itself, as VS Code's JSON."""
    forms = [form for form in FORMS.values() if form.name not in SPELLED_OUT - {"begin"}]
    entries = {form.name: {"prefix": form.name, "body": snippet(form), "description": form.doc} for form in forms}
    return json.dumps(entries, indent=2) + "\n"


def files() -> dict[str, str]:
    """The texts by path in the extension's folder."""
    return {"syntaxes/scene.tmLanguage.json": grammar_text(TEXTMATE), "snippets/scene.json": snippets_text()}


def main(folder: str) -> None:
    """Write the files into the extension's folder."""
    for name, text in files().items():
        Path(folder, name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1])

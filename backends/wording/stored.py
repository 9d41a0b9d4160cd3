"""A wording as JSON data and back, for the header of the file Z (docs/embeddings.md shows the form)."""

from __future__ import annotations

from typing import Any

from scenelang.backends.wording.handles import packed, unpacked
from scenelang.backends.wording.wording import Row, Wording

VERSION = 1


def to_json(wording: Wording) -> dict[str, Any]:
    """The wording as JSON data."""
    return {
        "version": VERSION,
        "style": {"handle": wording.style, "text": wording.style_text},
        "rows": [
            {"word": row.word, "text": row.text, "template": row.template, "handles": packed(row.handles)}
            for row in wording.rows
        ],
    }


def from_json(data: Any) -> Wording:
    """The inverse of ``to_json``; raises ValueError, KeyError, TypeError or AttributeError for what is none."""
    if data["version"] != VERSION:
        raise ValueError(f"its wording is of version {str(data['version'])[:20]}; this program knows {VERSION}")
    rows = tuple(
        Row(_text(row["word"]), _text(row["text"]), _text(row["template"]), unpacked(row["handles"]))
        for row in data["rows"]
    )
    return Wording(_text(data["style"]["handle"]), _text(data["style"]["text"]), rows)


def _text(value: object) -> str:
    if not isinstance(value, str) or not value:
        raise ValueError("a wording is made of texts")
    return value

"""Building Lark parsers. Their tables are kept in the user's cache folder, since building them takes a while."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

from lark import Lark


def build_parser(grammar: str, start: str, lexer: Any, transformer: Any = None) -> Lark:
    """The LALR parser of a grammar file of this package. Lark checks that cached tables belong to its text."""
    text = Path(__file__).with_name(grammar).read_text("utf-8")
    options: dict[str, Any] = {"parser": "lalr", "lexer": lexer, "start": start, "transformer": transformer}
    folder = _cache_folder()
    if folder is not None:
        version = f"{sys.version_info.major}.{sys.version_info.minor}"
        options["cache"] = str(folder / f"{Path(grammar).stem}-{start}-{version}.tables")
    return Lark(text, **options)


def _cache_folder() -> Path | None:
    """The folder for cached tables, or None where none can be written."""
    base = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    folder = Path(base) / "scenelang"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return None
    return folder if os.access(folder, os.W_OK) else None

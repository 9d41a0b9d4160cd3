"""The viewer page: its files for the server, and a self-contained HTML file that needs no server."""

from __future__ import annotations

import base64
import gzip
import hashlib
import html
import json
import os
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from scenelang.backends.files import check_folder
from scenelang.grammar.diagnostics import UsageError

STATIC = {"viewer.js": "text/javascript; charset=utf-8", "viewer.css": "text/css; charset=utf-8"}
_HEAD, _BODY = "<!--head-->", "<!--body-->"
_ICON = '<link rel="icon" href="data:,">'  # prevents browsers from requesting /favicon.ico


@dataclass(frozen=True, slots=True)
class SavedScene:
    """Scene to embed in a page, with the server's response ``state`` and its ``packet``, if any."""

    name: str
    state: Mapping[str, Any]
    packet: bytes | None


@cache
def static(name: str) -> bytes:
    """Return a built file; ``name`` is a key of ``STATIC`` or ``page.html``."""
    return files(__package__).joinpath("static", name).read_bytes()


def served_page() -> bytes:
    """Return the page for a server that also serves ``STATIC``."""
    head = f'{_ICON}<link rel="stylesheet" href="viewer.css">'
    page = _template().replace(_HEAD, head).replace(_BODY, '<script src="viewer.js"></script>')
    return page.encode()


def self_contained_page(scenes: Sequence[SavedScene]) -> str:
    """Return an HTML page with the viewer and ``scenes`` embedded; its content security policy forbids loading
    anything."""
    return inline_page(_template(), _text("viewer.js"), _text("viewer.css"), "scenes", _scene_data(scenes))


def inline_page(template: str, script: str, style: str, name: str, data: Any) -> str:
    """Return ``template`` with a script, a style sheet, and ``data`` as JSON in the element ``name``.

    The content security policy allows only this script and style.
    """
    script = script.replace("</script", "<\\/script").replace("<!--", "<\\!--")
    policy = f"default-src 'none'; img-src data:; script-src '{_digest(script)}'; style-src '{_digest(style)}'"
    head = f'<meta http-equiv="Content-Security-Policy" content="{html.escape(policy)}">{_ICON}<style>{style}</style>'
    body = f'<script type="application/json" id="{name}">{_json_text(data)}</script><script>{script}</script>'
    return template.replace(_HEAD, head).replace(_BODY, body)


def page_path(text: str) -> str:
    """Validate a path for a page; raises UsageError for another extension, SceneError if the folder does not exist."""
    path = Path(text)
    if path.suffix.lower() not in (".html", ".htm"):
        raise UsageError("file", f"a page must be an .html file, not {path.name}")
    check_folder(path)
    return text


def iframe(page: str, height: int) -> str:
    """Return an isolated iframe that shows ``page``; ``height`` in CSS pixels."""
    return (
        f'<iframe srcdoc="{html.escape(page)}" sandbox="allow-scripts" title="scene" '
        f'style="width:100%;height:{height}px;border:0"></iframe>'
    )


def _template() -> str:
    return _text("page.html")


def _text(name: str) -> str:
    return static(name).decode()


def _digest(text: str) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()


def _json_text(data: Any) -> str:
    """Return ``data`` as JSON that is safe in a script element: every ``<`` is escaped."""
    return json.dumps(data).replace("<", "\\u003c")


def _scene_data(scenes: Sequence[SavedScene]) -> list[dict[str, Any]]:
    return [
        {
            "name": scene.name,
            "state": dict(scene.state),
            "picture": None
            if scene.packet is None
            else base64.b64encode(gzip.compress(scene.packet, 6, mtime=0)).decode(),
        }
        for scene in scenes
    ]


def has_screen() -> bool:
    """Return whether a graphical browser can be opened."""
    if sys.platform in ("darwin", "win32"):
        return True
    return any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"))


def open_in_browser(address: str) -> None:
    """Open a page in the browser if there is a display."""
    if has_screen():
        import webbrowser

        webbrowser.open(address)

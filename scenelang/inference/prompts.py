"""The texts of prompts: files with places to fill, ``{{name}}``, each of which a file of the user's may replace."""

from __future__ import annotations

import re
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path

from scenelang.backends.files import read_regular
from scenelang.grammar.diagnostics import SceneError, suggest

_PLACE = re.compile(r"\{\{(\w+)\}\}")
_NEEDED = frozenset(("task", "program", "instruction", "diagnostics", "questions"))
_LARGEST = 1_000_000  # bytes


class Prompts:
    """Prompts from ``folder`` where it has a file of the name, else the package's own. Raises SceneError for files that
    nothing reads, and for places that nothing fills or that must be there: before anything is paid for."""

    def __init__(self, folder: Path | None = None) -> None:
        self._texts = {name: _own(name) for name in prompt_names()}
        self._replaced = _replaced(folder, self._texts) if folder is not None else {}

    def text(self, name: str, **values: str) -> str:
        """The text of the file ``name`` with its places filled."""
        template = self._replaced.get(name, self._texts[name])
        return _PLACE.sub(lambda match: values[match[1]], template.strip("\n"))

    def is_replaced(self, name: str) -> bool:
        """Whether a prompt is the user's."""
        return name in self._replaced


def prompt_names() -> tuple[str, ...]:
    """The files that there are."""
    folder = files("scenelang.inference") / "prompts"
    return tuple(sorted(entry.name for entry in folder.iterdir() if entry.name.endswith(".md")))


def _own(name: str) -> str:
    return (files("scenelang.inference") / "prompts" / name).read_text("utf-8")


def _replaced(folder: Path, own: Mapping[str, str]) -> dict[str, str]:
    """The prompts that a folder has, checked."""
    if not folder.is_dir():
        raise SceneError("prompt", f"--prompt-dir: there is no folder {folder}")
    found: dict[str, str] = {}
    for path in sorted(folder.glob("*.md")):
        if path.name not in own:
            hint = suggest(path.name, own) or f"there are {' '.join(own)}"
            raise SceneError("prompt", f"{path} is no prompt that is read", hint)
        found[path.name] = _file_text(path)
        _check_places(path, found[path.name], own[path.name])
    return found


def _check_places(path: Path, text: str, own: str) -> None:
    places, known = set(_PLACE.findall(text)), set(_PLACE.findall(own))
    for place in sorted(places - known):
        message = f"the prompt {path} has the place {{{{{place}}}}}, for which there is no text"
        listed = ", ".join(sorted(known)) or "none"
        raise SceneError("prompt", message, suggest(place, known) or f"it may have: {listed}")
    for place in sorted((known & _NEEDED) - places):
        raise SceneError("prompt", f"the prompt {path} lacks the place {{{{{place}}}}}: the model would not see it")


def _file_text(path: Path) -> str:
    try:
        if path.stat().st_size > _LARGEST:
            raise SceneError("prompt", f"{path} is too large for a prompt")
        return read_regular(path).decode("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is no UTF-8 text"
        raise SceneError("prompt", f"cannot read the prompt {path}: {reason}") from None

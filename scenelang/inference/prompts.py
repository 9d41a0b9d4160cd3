"""The texts of prompts: files with places to fill, ``{{name}}``, each of which a file of the user's may replace."""

from __future__ import annotations

import re
from importlib.resources import files
from pathlib import Path

from scenelang.grammar.diagnostics import SceneError, suggest

_PLACE = re.compile(r"\{\{(\w+)\}\}")
_LARGEST = 1_000_000  # bytes


class Prompts:
    """Prompts from ``folder`` where it has a file of the name, else the package's own."""

    def __init__(self, folder: Path | None = None) -> None:
        if folder is not None:
            _check(folder)
        self._folder = folder

    def text(self, name: str, **values: str) -> str:
        """The text of the file ``name`` with its places filled. Raises SceneError for a place without a value."""
        template = self._read(name).strip("\n")
        unknown = [place for place in _PLACE.findall(template) if place not in values]
        if unknown:
            known = ", ".join(sorted(values)) or "none"
            message = f"the prompt {self._shown(name)} has the place {{{{{unknown[0]}}}}}, for which there is no text"
            raise SceneError("prompt", message, suggest(unknown[0], values) or f"it may have: {known}")
        return _PLACE.sub(lambda match: values[match[1]], template)

    def _read(self, name: str) -> str:
        if self._folder is not None and (self._folder / name).exists():
            return _file_text(self._folder / name)
        return (files("scenelang.inference") / "prompts" / name).read_text("utf-8")

    def _shown(self, name: str) -> str:
        return str(self._folder / name) if self._folder is not None else name


def prompt_names() -> tuple[str, ...]:
    """The files that there are."""
    folder = files("scenelang.inference") / "prompts"
    return tuple(sorted(entry.name for entry in folder.iterdir() if entry.name.endswith(".md")))


def _check(folder: Path) -> None:
    """Raises SceneError for a folder that is none, or that holds a prompt that nothing reads."""
    if not folder.is_dir():
        raise SceneError("prompt", f"--prompt-dir: there is no folder {folder}")
    known = prompt_names()
    for path in sorted(folder.iterdir()):
        if path.suffix == ".md" and path.name not in known:
            hint = suggest(path.name, known) or f"there are {' '.join(known)}"
            raise SceneError("prompt", f"{path} is no prompt that is read", hint)


def _file_text(path: Path) -> str:
    try:
        if path.stat().st_size > _LARGEST:
            raise SceneError("prompt", f"{path} is too large for a prompt")
        return path.read_text("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is no UTF-8 text"
        raise SceneError("prompt", f"cannot read the prompt {path}: {reason}") from None

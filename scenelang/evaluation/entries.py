"""What is to be evaluated: programs, or a JSON list of programs and films with the texts that they were made for."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from scenelang.backends.files import read_regular
from scenelang.grammar.diagnostics import SceneError, suggest

_MOST_BYTES, _MOST_ENTRIES, _LONGEST = 16_000_000, 10_000, 10_000
_KEYS = ("scene", "film", "prompt", "method", "image", "count", "distilled", "dynamic")


@dataclass(frozen=True, slots=True)
class Entry:
    """A ``scene`` or a ``film`` (one of them), made for the text ``prompt`` (None: what the program's head says).

    ``method`` made it (None: it is called after the backend that draws it). ``image`` is the picture that it is to
    look like, ``count`` how many of each word there are to be (None: what the prompt says), ``distilled`` the folder
    of a run of `distill`; ``is_dynamic`` says that a film shows a scene that moves, not a turn around one.
    """

    scene: Path | None = None
    film: Path | None = None
    prompt: str | None = None
    method: str | None = None
    image: Path | None = None
    count: tuple[tuple[str, int], ...] | None = None
    distilled: Path | None = None
    is_dynamic: bool = False

    @property
    def place(self) -> str:
        """The file of the scene or film."""
        return str(self.scene or self.film)


def entries_of(files: Sequence[str]) -> list[Entry]:
    """Programs and lists as entries, each once; raises SceneError: "file" for a list that cannot be read, "value" for
    one that makes no sense."""
    found = [entry for file in files for entry in _read(Path(file))]
    if len(found) > _MOST_ENTRIES:
        raise SceneError("value", f"{_MOST_ENTRIES:,} scenes at most are evaluated at once, not {len(found):,}")
    return list(dict.fromkeys(found))


def _read(path: Path) -> list[Entry]:
    if path.suffix.lower() != ".json":
        return [Entry(scene=path)]
    try:
        if path.stat().st_size > _MOST_BYTES:
            raise SceneError("file", f"{path} is too large for a list of scenes")
        data = json.loads(read_regular(path))
    except (OSError, ValueError, RecursionError) as error:
        said = error.strerror if isinstance(error, OSError) else str(error)
        raise SceneError("file", f"{path} cannot be read: {said}") from None
    if not isinstance(data, list):  # a scene may be JSON too
        return [Entry(scene=path)]
    return [_entry(item, path, number) for number, item in enumerate(data, 1)]


def _entry(item: Any, path: Path, number: int) -> Entry:
    where = f"{path}, entry {number}"
    if not isinstance(item, dict):
        raise SceneError("value", f'{where}: an entry is an object such as {{"scene": "a.scene", "prompt": "..."}}')
    for key in item:
        if key not in _KEYS:
            hint = suggest(key, _KEYS) or f"it can have {', '.join(_KEYS)}"
            raise SceneError("value", f"{where} has a key `{key[:40]}` that means nothing", hint=hint)
    if ("scene" in item) == ("film" in item):
        raise SceneError("value", f"{where} must have one of `scene` and `film`")
    is_dynamic = item.get("dynamic", False)
    if not isinstance(is_dynamic, bool):
        raise SceneError("value", f"{where}: `dynamic` is true or false")
    texts = {key: _text(item, key, where) for key in ("scene", "film", "prompt", "method", "image", "distilled")}
    files = {key: _beside(path, texts[key]) for key in ("scene", "film", "image", "distilled")}
    return Entry(
        **files, prompt=texts["prompt"], method=texts["method"], count=_counts(item.get("count"), where),
        is_dynamic=is_dynamic,
    )  # fmt: skip


def _text(item: Mapping[str, Any], key: str, where: str) -> str | None:
    value = item.get(key)
    if value is None:
        return None
    if not isinstance(value, str) or not value.strip() or len(value) > _LONGEST or "\0" in value:
        raise SceneError("value", f"{where}: `{key}` must be a text")
    return value if key in ("scene", "film", "image", "distilled") else " ".join(value.split())


def _beside(path: Path, name: str | None) -> Path | None:
    return None if name is None else path.parent / name


def _counts(value: Any, where: str) -> tuple[tuple[str, int], ...] | None:
    if value is None:
        return None
    if not isinstance(value, dict) or not all(type(count) is int and count >= 0 for count in value.values()):
        raise SceneError("value", f'{where}: `count` is an object of whole numbers, such as {{"can": 15}}')
    return tuple(value.items())

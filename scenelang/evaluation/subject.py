"""A thing that is measured: a scene as a backend draws it, or a film, with the text that it was made for."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from scenelang.backends.base import Progress
from scenelang.backends.metrics.counting import Asked, asked_in, asked_of
from scenelang.backends.metrics.films import read_film
from scenelang.backends.metrics.views import around, drawn, steady
from scenelang.backends.picture import Picture, PictureOptions
from scenelang.evaluation.entries import Entry
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.entity import Scene, count_words
from scenelang.interpreter.flatten import flatten
from scenelang.interpreter.plain import primitive_attributes

NUMERIC, GENERIC, DYNAMIC = "numeric", "generic", "4d"  # the paper's groups of tasks


@dataclass(frozen=True, slots=True)
class Drawing:
    """How scenes are drawn: by which backend, as ``options`` say; ``fps`` is how fast the frames of a 4D one pass."""

    backend: str
    options: PictureOptions
    fps: float


@dataclass(frozen=True, slots=True, eq=False)
class Subject:
    """``scene`` is None for a film, ``prompt`` where nothing says what it shows."""

    entry: Entry
    method: str
    prompt: str | None
    scene: Scene | None
    drawing: Drawing

    @property
    def asked(self) -> tuple[Asked, ...]:
        """How many of what there are to be."""
        if self.entry.count is not None:
            return asked_of(dict(self.entry.count))
        return asked_in(self.prompt or "")

    @property
    def is_dynamic(self) -> bool:
        return self.entry.is_dynamic if self.scene is None else self.scene.animated

    @property
    def group(self) -> str:
        """In which of the paper's groups it is counted."""
        return DYNAMIC if self.is_dynamic else NUMERIC if self.asked else GENERIC

    def around(self, count: int, progress: Progress | None = None) -> list[Picture]:
        """``count`` pictures from all around, of a film as many of its own at most; raises SceneError."""
        if self.scene is None:
            pictures = self._film()
            least = min(count, len(pictures))
            return [pictures[i * len(pictures) // least] for i in range(least)]
        options = self.drawing.options
        shots = around(self.scene, count, options.width, options.height)
        return drawn(self.scene, shots, options, self.drawing.backend, progress)

    def steady(self, progress: Progress | None = None) -> list[Picture]:
        """Every frame, seen by a camera that stands still; raises SceneError."""
        if self.scene is None:
            return self._film()
        options = self.drawing.options
        shots = steady(self.scene, options.width, options.height)
        return drawn(self.scene, shots, options, self.drawing.backend, progress)

    def fingerprint(self, asks: Mapping[str, Any]) -> str:
        """What tells this measurement from any other: the scene as evaluated, its text, how it is drawn, and what the
        metric ``asks`` besides; raises SceneError."""
        options = self.drawing.options
        told = {
            "content": self._content(),
            "prompt": self.prompt,
            "backend": None if self.scene is None else self.drawing.backend,
            "size": None if self.scene is None else [options.width, options.height],
            "environment": [options.environment, options.ground, options.seed],
            "settings": {key: str(value) for key, value in sorted(options.settings.items()) if value is not None},
            "image": None if self.entry.image is None else file_digest(self.entry.image),
            "asks": dict(asks),
        }
        return hashlib.sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()

    def _content(self) -> str:
        if self.scene is None:
            assert self.entry.film is not None
            return file_digest(self.entry.film)
        content = scene_digest(self.scene, self.drawing.options.limit)
        run = self.entry.distilled
        return content if run is None else f"{content} {file_digest(run / 'state.safetensors')}"

    def _film(self) -> list[Picture]:
        assert self.entry.film is not None
        return read_film(self.entry.film)


def scene_digest(scene: Scene, limit: int) -> str:
    """A sum of all that a scene's pictures and counts come from; raises SceneError for one of too many primitives."""
    found = hashlib.sha256()
    for frame in flatten(scene, limit).frames:
        for array in (frame.index, frame.matrices):
            found.update(array.tobytes())
        for entity in frame.primitives:
            found.update(repr((entity.word, sorted(primitive_attributes(entity).items()))).encode())
    for root in scene.frames:
        found.update(repr(sorted(count_words(root).items())).encode())
    return found.hexdigest()


def file_digest(path: Path) -> str:
    """The sum of a file; raises SceneError("file")."""
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise SceneError("file", f"{path} cannot be read: {error.strerror or error}") from None

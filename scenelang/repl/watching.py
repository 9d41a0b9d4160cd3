"""A watched file: evaluated again when it or what it imports changes, with a word on what that did to the scene."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.runtime.types import STD
from scenelang.interpreter.scene.entity import Scene, primitive_count
from scenelang.repl.display import clean
from scenelang.repl.loop import Repl
from scenelang.viewer.workspace import stamps_of

_POLL = 0.2  # seconds
_COMPARED = 50_000  # primitives; larger scenes are only counted


class Watch:
    """A thread that looks at a file's stamp until ``stop``."""

    def __init__(self, repl: Repl, path: str) -> None:
        self.path = path
        self._repl = repl
        self._scene = self._root()
        self._ended = threading.Event()
        self._stamps = stamps_of(self._names())
        threading.Thread(target=self._look, daemon=True).start()

    def again(self) -> Watch:
        """Another watch in the place of one whose thread is gone."""
        return Watch(self._repl, self.path)

    def stop(self) -> None:
        """Look no more."""
        self._ended.set()

    def _names(self) -> list[str]:
        files = self._repl.evaluation.top.file.imports
        return [self.path, *(file.source.name for file in files if not file.source.name.startswith(("<", STD)))]

    def _look(self) -> None:
        while not self._ended.wait(_POLL):
            if self._stamps.are_old():
                with self._repl.lock:
                    if not self._ended.is_set():
                        self._again()

    def _again(self) -> None:
        repl = self._repl
        self._stamps = stamps_of(self._names())
        outcome = repl.evaluation.reload(self.path)
        repl.show(outcome)
        if not outcome.ok:
            return
        self._stamps = stamps_of(self._names())
        old, self._scene = self._scene, self._root()
        repl.screen.write(clean(f"{Path(self.path).name} changed: {', '.join(what_changed(old, self._scene))}"))
        repl.changed()

    def _root(self) -> Scene | None:
        try:
            return self._repl.evaluation.root()
        except (SceneError, RecursionError, MemoryError):
            return None


def what_changed(old: Scene | None, new: Scene | None) -> Iterator[str]:
    """What is different in the first frame of a scene, in brief."""
    if new is None:
        yield "there is no scene now"
        return
    count = primitive_count(new.root)
    if old is None:
        yield f"{count:,} primitives"
        return
    before = primitive_count(old.root)
    yield f"{count:,} primitives" if count == before else f"{before:,} -> {count:,} primitives"
    yield from _bounds(old, new)
    if max(count, before) <= _COMPARED:
        yield from _differences(old, new)


def _bounds(old: Scene, new: Scene) -> Iterator[str]:
    from scenelang.interpreter.scene.bounds import word_box

    a, b = word_box(old, None), word_box(new, None)
    if b is not None and (a is None or any(abs(x - y) > 1e-9 for x, y in zip(a, b))):
        yield "sizes [" + " ".join(f"{b[i + 3] - b[i]:.4g}" for i in range(3)) + "]"


def _differences(old: Scene, new: Scene) -> Iterator[str]:
    from scenelang.interpreter.scene.difference import compare_frames, sheet_of
    from scenelang.interpreter.scene.flatten import flatten

    before, after = (sheet_of(flatten(scene, 2 * _COMPARED).frames[0]) for scene in (old, new))
    found = compare_frames(before, after)
    if found.equal:
        yield "no primitive differs"
        return
    for number, what in (
        (len(found.moved), "moved"), (len(found.recolored), "recoloured"),
        (len(found.missing), "gone"), (len(found.extra), "new"),
    ):  # fmt: skip
        if number:
            yield f"{number:,} {what}"

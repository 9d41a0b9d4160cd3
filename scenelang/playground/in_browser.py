"""The interpreter's side of the playground: a folder of programs in memory, their scenes, and the language server."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from scenelang.backends.base import BackendOptions
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.values.limits import Limits
from scenelang.playground import DESKTOP
from scenelang.session.session import Options, Session, definition
from scenelang.viewer.answers import PageAnswers
from scenelang.viewer.program_tools import tools
from scenelang.viewer.workspace import Workspace, evaluator

FOLDER = "/scenes"  # of the programs, in the file system of the interpreter
MAX_PRIMITIVES = 200_000  # of a scene: arrays without numpy take about 10 us for each instance

# Calls of this depth need more of Python's frames than a browser's stack has (``values/limits``), which end most
# programs first. Steps are the desktop's: about 5 s.
LIMITS = Limits(depth=400)


class Playground(PageAnswers):
    """Programs of one page in memory; ``send`` receives the messages of the language server."""

    def __init__(self, send: Callable[[str], None]) -> None:
        Path(FOLDER).mkdir(exist_ok=True)
        self._evaluate = evaluator(open_session, MAX_PRIMITIVES)
        super().__init__("playground", send, Workspace([], self._evaluate), [])

    def open(self, texts: Mapping[str, str], names: list[str]) -> list[str]:
        """Start with programs by name; ``names`` are those that are shown, the others may be imported."""
        for name, text in texts.items():
            path = Path(FOLDER, name)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        self.names = list(names)
        self.workspace = Workspace([f"{FOLDER}/{name}" for name in names], self._evaluate, tools(open_session))
        return self.names

    def export(self, file: int, kind: str) -> bytes:
        """Return the scene as a file: "glb"."""
        if kind != "glb":
            raise SceneError("unsupported", f"the playground does not write .{kind} files", DESKTOP)
        from scenelang.backends.exports.gltf import GLTF

        path, out = self.workspace.files[file], Path(FOLDER, ".scene.glb")
        session = open_session(path, {})
        scene = session.evaluate(session.source(path)).scene
        if scene is None:
            raise SceneError("unsupported", "the program has a mistake, so there is no scene to write")
        GLTF.run(scene, out, BackendOptions(limit=MAX_PRIMITIVES))
        return out.read_bytes()

    def call(self, method: str, arguments: str) -> Any:
        """Call a method with JSON arguments; the result is JSON, bytes, or None.

        Errors of the user come back as ``{"error": message, "hint": hint}``.
        """
        if method not in _METHODS:
            raise ValueError(f"unknown method {method!r}")
        try:
            result = getattr(self, method)(*json.loads(arguments))
        except SceneError as error:
            return json.dumps({"error": error.message, "hint": error.hint})
        return result if isinstance(result, bytes) else json.dumps(result)


_METHODS = ("open", "state", "edit", "set", "literal", "change", "picture", "export", "lsp")


def open_session(path: str, values: Mapping[str, str], folder: str | None = None) -> Session:
    """Create the session of a program, with values of the sliders for its params."""
    defines = dict(definition(f"{name}={text}") for name, text in values.items())
    return Session(Options(defines=defines, limits=LIMITS, project=Path(folder or FOLDER)))

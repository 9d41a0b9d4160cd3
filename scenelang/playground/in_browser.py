"""The interpreter's side of the playground: a folder of programs in memory, their scenes, and the language server."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from scenelang.backends.base import BackendOptions
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.plugins import SERVICES
from scenelang.interpreter.values.limits import Limits
from scenelang.session.session import Options, Session, definition
from scenelang.viewer.workspace import DESKTOP, Workspace, evaluator, state_data, tools

FOLDER = "/scenes"  # of the programs, in the file system of the interpreter
MAX_PRIMITIVES = 200_000  # of a scene: arrays without numpy take about 10 us for each instance

# Calls of this depth need more of Python's frames than a browser's stack has (``values/limits``), which end most
# programs first. Steps are the desktop's: about 5 s.
LIMITS = Limits(depth=400)


class Playground:
    """Programs of one page, and what it asks about them.

    Methods take and return data of JSON, except ``picture`` and ``export``, which return bytes. ``send`` receives the
    messages of the language server.
    """

    def __init__(self, send: Callable[[str], None]) -> None:
        Path(FOLDER).mkdir(exist_ok=True)
        self._send = send
        self._channel: Any = None
        self._names: list[str] = []
        self._evaluate = evaluator(open_session, MAX_PRIMITIVES)
        self._workspace = Workspace([], self._evaluate)

    def open(self, texts: Mapping[str, str], names: list[str]) -> list[str]:
        """Start with programs by name; ``names`` are those that are shown, the others may be imported."""
        for name, text in texts.items():
            path = Path(FOLDER, name)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        self._names = list(names)
        files = [f"{FOLDER}/{name}" for name in self._names]
        self._workspace = Workspace(files, self._evaluate, tools(open_session))
        return self._names

    def state(self, file: int) -> dict[str, Any]:
        """Return the state of a program for the page."""
        return state_data(self._names[file], self._workspace.state(file))

    def edit(self, file: int, text: str | None) -> dict[str, Any]:
        """Evaluate a program's new text; None evaluates it as it is."""
        if text is not None:
            Path(FOLDER, self._names[file]).write_text(text, encoding="utf-8")
        self._workspace.edit(file, text)
        return self.state(file)

    def set(self, file: int, name: str, value: Any) -> dict[str, Any]:
        """Try a value of a param."""
        self._workspace.state(file)
        self._workspace.try_value(file, name, value)
        return self.state(file)

    def literal(self, file: int, name: str, value: Any, text: str) -> dict[str, Any]:
        """Return the edit of a text that gives a param a value."""
        return self._workspace.literal_edit(file, name, value, text)

    def change(self, file: int, text: str, change: Mapping[str, Any]) -> dict[str, Any]:
        """Return a program in which the objects of a path are changed."""
        return self._workspace.use("change", file, text, change)

    def picture(self, file: int) -> bytes | None:
        """Return the last valid packet of a program."""
        return self._workspace.state(file).packet

    def export(self, file: int, kind: str) -> bytes:
        """Return the scene as a file: "glb"."""
        if kind != "glb":
            raise SceneError("unsupported", f"the playground does not write .{kind} files", DESKTOP)
        from scenelang.backends.exports.gltf import GLTF

        path, out = f"{FOLDER}/{self._names[file]}", Path(FOLDER, ".scene.glb")
        session = open_session(path, {})
        scene = session.evaluate(session.source(path)).scene
        if scene is None:
            raise SceneError("unsupported", "the program has a mistake, so there is no scene to write")
        GLTF.run(scene, out, BackendOptions(limit=MAX_PRIMITIVES))
        return out.read_bytes()

    def lsp(self, message: str) -> None:
        """Pass a message to the language server, which is made by the first one."""
        if self._channel is None:
            self._channel = SERVICES.find("language-server")("playground", self._send)
        self._channel.receive(message)

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

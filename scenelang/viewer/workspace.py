"""The programs that a viewer shows: evaluated anew when their files change or a param is moved, the last good kept."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from scenelang.backends.viewer.packet import packet_of
from scenelang.backends.viewer.splats import SplatsOf
from scenelang.grammar.diagnostics import Diagnostic, SceneError, capped, render_text
from scenelang.interpreter.entity import Scene, descendants
from scenelang.interpreter.library import STD
from scenelang.interpreter.program import Program
from scenelang.sandbox.supervision import Ended, limited
from scenelang.session import Session
from scenelang.viewer.params import Control, controls_of, write_back
from scenelang.viewer.stamps import Stamps, stamps_of
from scenelang.zfile import beside

OpenSession = Callable[[str, Mapping[str, str]], Session]  # (file, overridden params) -> the session for it
Evaluate = Callable[[str, Mapping[str, str]], "Evaluation"]  # (file, overridden params) -> what came of it
Announce = Callable[[int], None]  # called with the number of a file whose state is new


@dataclass(frozen=True, slots=True, eq=False)
class Evaluation:
    """What an evaluation of a file came to, as data that can go from one process to another. ``controls`` is None where
    the params are not known, and ``all_known`` False where some may be missing."""

    packet: bytes | None
    diagnostics: tuple[Diagnostic, ...]
    stamps: Stamps
    controls: tuple[Control, ...] | None = None
    all_known: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """What is known of one file. ``version`` grows with each evaluation; ``picture`` is the version that ``packet`` was
    made in, the last good one, None before there is any. ``values`` are the params' values that are tried out."""

    version: int = 0
    ok: bool = False
    picture: int | None = None
    packet: bytes | None = None
    diagnostics: tuple[Diagnostic, ...] = ()
    controls: tuple[Control, ...] = ()
    values: Mapping[str, Any] = field(default_factory=dict)
    stamps: Stamps = field(default_factory=Stamps)

    def control(self, name: str) -> Control:
        """The control of the param ``name``; raises SceneError("param")."""
        for control in self.controls:
            if control.param.name == name:
                return control
        raise SceneError("param", f"the program has no `param` named `{name[:60]}`")


class Workspace:
    """``files`` as the user named them; ``evaluate`` as ``evaluator`` makes one, here or in a worker's process.

    Everything may be called from several threads; one evaluates at a time.
    """

    def __init__(self, files: Sequence[str], evaluate: Evaluate) -> None:
        self.files = tuple(files)
        self._evaluate_file = evaluate
        self._states = [State() for _ in files]
        self._evaluating = threading.Lock()
        self._listeners: list[Announce] = []

    def listen(self, announce: Announce) -> None:
        """Have ``announce`` called whenever a file's state is new."""
        self._listeners.append(announce)

    def state(self, file: int) -> State:
        """The state of a file, evaluated when nothing has asked for it before."""
        if self._states[file].version == 0:
            with self._evaluating:
                if self._states[file].version == 0:
                    self._evaluate(file, {})
        return self._states[file]

    def try_value(self, file: int, name: str, value: Any) -> None:
        """Evaluate with another value of a param, None for the file's own; raises SceneError("param")."""
        with self._evaluating:
            state = self._states[file]
            values = {key: old for key, old in state.values.items() if key != name}
            if value is not None:
                state.control(name).literal(value)
                values[name] = value
            self._evaluate(file, values)

    def save(self, file: int, name: str) -> None:
        """Write the value that is tried out into the file; raises SceneError("param") or ("file")."""
        with self._evaluating:
            state = self._states[file]
            if name not in state.values:
                raise SceneError("param", f"`{name[:60]}` has the file's own value")
            write_back({control.param.name: control for control in state.controls}, name, state.values[name])
            self._evaluate(file, {key: value for key, value in state.values.items() if key != name})

    def refresh(self) -> None:
        """Evaluate the files whose text, imports, assets or embeddings have changed on disk."""
        for file, state in enumerate(self._states):
            if state.version and state.stamps.are_old():
                with self._evaluating:
                    self._evaluate(file, self._states[file].values)

    def _evaluate(self, file: int, values: Mapping[str, Any]) -> None:
        """Evaluate a file and keep what comes of it; the caller holds the lock."""
        old = self._states[file]
        defines = {control.param.name: control for control in old.controls}
        literals = {name: defines[name].literal(value) for name, value in values.items() if name in defines}
        state = self._evaluated(file, old, literals)
        kept = _kept_values(old, state, values)
        if kept != values:  # a param that was tried out is gone, or its own value has changed
            state = self._evaluated(file, old, {name: literals[name] for name in kept if name in literals})
        self._states[file] = replace(state, values=kept)
        for announce in self._listeners:
            announce(file)

    def _evaluated(self, file: int, old: State, literals: Mapping[str, str]) -> State:
        version = old.version + 1
        try:
            found = self._evaluate_file(self.files[file], literals)
        except Ended as error:
            found = Evaluation(None, (error.problem,), stamps_of(_beside(self.files[file])))
        ok = found.packet is not None
        controls = old.controls
        if found.controls is not None and (found.all_known or not controls):
            controls = found.controls
        picture = version if ok else old.picture
        packet = found.packet if ok else old.packet
        return State(version, ok, picture, packet, found.diagnostics, controls, {}, found.stamps)


def evaluator(open_session: OpenSession, limit: int, splats: SplatsOf | None = None) -> Evaluate:
    """Evaluates files for a workspace; ``splats`` gives the Gaussians that are seen in place of solids."""

    def evaluate(path: str, literals: Mapping[str, str]) -> Evaluation:
        program: Program | None = None
        packet: bytes | None = None
        found: tuple[Diagnostic, ...] = ()
        stamps = stamps_of([path])
        try:
            session = open_session(path, literals)
            with limited(session.options.limits):
                result = session.evaluate(session.source(path))
                program, found = result.program, result.diagnostics
                stamps = _stamps(path, program, result.scene, found)
                if result.scene is not None:
                    words = program.all_words if program is not None else None
                    packet = packet_of(result.scene, limit, words, splats)
        except SceneError as error:
            found = (*found, error.diagnostic)
        except Exception as error:  # a fault of ours must not end the viewer
            said = f"internal error: {type(error).__name__}: {error}"
            found = (*found, SceneError("unsupported", said, "please report it").diagnostic)
        controls = controls_of(program.params) if program is not None else None
        return Evaluation(packet, found, stamps, controls, program is not None and _is_read(program))

    return evaluate


def _is_read(program: Program) -> bool:
    """Whether all params are known: of a text with other mistakes some may be missing."""
    return all(d.name == "param" for d in program.diagnostics if d.is_error)


def _kept_values(old: State, new: State, values: Mapping[str, Any]) -> dict[str, Any]:
    """The tried-out values of params that are still there, with the same value of their own."""
    before = {control.param.name: control.param.default for control in old.controls}
    now = {control.param.name: control.param.default for control in new.controls}
    return {name: value for name, value in values.items() if name in now and before.get(name) == now[name]}


def _beside(path: str) -> list[str]:
    """A program and its file of embeddings."""
    return [path, str(beside(path))]


def _stamps(path: str, program: Program | None, scene: Scene | None, found: Sequence[Diagnostic]) -> Stamps:
    """The stamps of everything that a program was made of."""
    names = _beside(path)
    if program is not None:
        names += [source.name for source in program.sources if not source.name.startswith(("<", STD))]
    if scene is not None:
        shapes = (entity.shape for entity in descendants(*scene.frames))
        names += [shape.file for shape in shapes if shape is not None and shape.file is not None]
    if any(diagnostic.name == "file" for diagnostic in found):  # what was not found may come to be
        names += sorted({str(Path(name).parent) for name in names})
    return stamps_of(dict.fromkeys(names))


def state_data(name: str, state: State, is_live: bool = True) -> dict[str, Any]:
    """The state as JSON data for the page; ``is_live`` is False for a page without a server."""
    return {
        "name": name,
        "version": state.version,
        "ok": state.ok,
        "picture": state.picture,
        "diagnostics": [_diagnostic_data(diagnostic) for diagnostic in capped(state.diagnostics)],
        "params": [_param_data(control, state.values, is_live) for control in state.controls],
    }


def _diagnostic_data(diagnostic: Diagnostic) -> dict[str, str]:
    """The first line in its parts, and the rest as the command line prints it."""
    _, _, rest = render_text(diagnostic).partition(diagnostic.message)
    severity = "error" if diagnostic.is_error else "warning"
    return {"severity": severity, "code": diagnostic.code, "message": diagnostic.message, "text": rest.strip("\n")}


def _param_data(control: Control, values: Mapping[str, Any], is_live: bool) -> dict[str, Any]:
    param = control.param
    reason = control.reason if is_live else "This page was saved; `scenelang view` moves params."
    return {
        "name": param.name,
        "doc": param.doc,
        "min": param.minimum,
        "max": param.maximum,
        "kind": control.kind,
        "value": values.get(param.name, control.value),
        "changed": param.name in values,
        "live": is_live,
        "writable": control.place is not None,
        "reason": reason,
    }

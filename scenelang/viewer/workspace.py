"""The programs that a viewer shows: evaluated anew when their files change or a param is moved, the last good kept."""

from __future__ import annotations

import math
import os
import re
import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from scenelang.backends.files import read_regular, written_whole
from scenelang.backends.pictures.studio import from_srgb, to_srgb
from scenelang.backends.viewer.packet import SplatsOf, packet_of
from scenelang.grammar.datum import ArrayDatum, Atom, Datum, Handle, Keyword, ListDatum, Source, Span, Symbol, atom_text
from scenelang.grammar.diagnostics import Diagnostic, SceneError, capped, render_text
from scenelang.grammar.reader import read
from scenelang.interpreter.program.program import Param, Program
from scenelang.interpreter.runtime.types import STD
from scenelang.interpreter.scene.entity import Scene, descendants
from scenelang.sandbox.supervision import Ended, limited
from scenelang.session import Session
from scenelang.stdlib.colors import color_of
from scenelang.zfile import beside

# Params of a program for people to move: their kinds and values, literals for them, writing one back to its file.


_HEX = re.compile(r"#[0-9a-fA-F]{6}")
_BOM = b"\xef\xbb\xbf"
_DIGITS = 4  # of a colour's linear channels: finer than 8-bit sRGB


@dataclass(frozen=True, slots=True, eq=False)
class ParamControl:
    """A param as a control. ``kind``: integer, number, boolean, text, color, literal (as it is written) or computed.

    ``value`` is the file's own: a number, a truth value, a text, or ``#rrggbb``. ``place`` is where it is written, None
    where it cannot be written back; then ``reason`` says why.
    """

    param: Param
    kind: str
    value: Any
    place: Span | None
    reason: str | None

    def literal(self, value: Any) -> str:
        """``value``, as the page sends it, as a literal of the language; raises SceneError("param")."""
        text = _literal(self.kind, value)
        if text is not None and self.kind == "number" and type(self.value) is int and value == int(value):
            return str(int(value))
        if text is not None and self.kind == "color" and self.param.default.startswith('"'):
            return atom_text(value)
        if text is None:
            raise SceneError("param", f"`{self.param.name}` cannot be {str(value)[:60]!r}")
        return text

    def written(self, value: Any) -> str:
        """The literal for the file, in the manner of what stands there: `(color "#c08040")` stays one."""
        text = self.literal(value)
        return f'(color "{value}")' if self.kind == "color" and self.param.default.startswith("(") else text


def controls_of(params: tuple[Param, ...]) -> tuple[ParamControl, ...]:
    """The controls of a program's params, in reading order."""
    return tuple(_control(param) for param in params)


def _control(param: Param) -> ParamControl:
    datum = _value_datum(param.span)
    kind, value = _kind(datum) if datum is not None else ("computed", param.default)
    if kind == "integer" and not all(
        limit is None or float(limit).is_integer() for limit in (param.minimum, param.maximum)
    ):
        kind = "number"
    name = param.span.source.name
    reason = None
    if datum is None or param.span.expansion is not None:
        reason = "A macro made it, so it can be tried out, not saved."
    elif kind == "computed":
        reason = "Its value is computed, so it is changed in the program."
    elif name.startswith(("<", STD)) or not Path(name).is_file():
        reason = "It does not come from a file, so it can be tried out, not saved."
    return ParamControl(param, kind, value, datum.span if datum is not None and reason is None else None, reason)


def _value_datum(span: Span) -> Datum | None:
    """The datum of the value in `(param name value ...)`, read anew where ``span`` lies."""
    forms = read(Source(span.source.name, span.text)).forms
    if len(forms) != 1 or not isinstance(forms[0], ListDatum) or len(forms[0].items) < 3:
        return None
    datum: Datum = forms[0].items[2]
    start, end = datum.span.start + span.start, datum.span.end + span.start
    place = Span(span.source, start, end)
    if isinstance(datum, Atom):
        return Atom(datum.value, place)
    if isinstance(datum, ArrayDatum):
        return ArrayDatum(datum.items, place)
    return ListDatum(datum.items, datum.tail, place)


def _kind(datum: Datum) -> tuple[str, Any]:
    text = " ".join(datum.span.text.split())
    if isinstance(datum, Atom):
        return _atom_kind(datum.value, text)
    if isinstance(datum, ArrayDatum):
        channels = _channels(datum)
        return ("color", _hex(channels)) if channels is not None else ("literal", text)
    named = _named_color(datum)
    return ("color", named) if named is not None else ("computed", text)


def _atom_kind(value: Any, text: str) -> tuple[str, Any]:
    if isinstance(value, bool):
        return "boolean", value
    if type(value) is int:
        return ("integer", value) if abs(value) < 2**53 else ("literal", text)
    if type(value) is float:
        return ("number", value) if math.isfinite(value) else ("literal", text)
    if type(value) is str:
        return ("color", value.lower()) if _HEX.fullmatch(value) else ("text", value)
    return ("computed", text) if isinstance(value, (Symbol, Keyword, Handle)) else ("literal", text)


def _channels(datum: ArrayDatum) -> tuple[float, ...] | None:
    """The numbers of an array that can be a colour: three from 0 to 1."""
    values = [item.value for item in datum.items if isinstance(item, Atom) and type(item.value) in (int, float)]
    if len(values) != 3 or len(datum.items) != 3 or not all(0.0 <= value <= 1.0 for value in values):
        return None
    return tuple(float(value) for value in values)


def _named_color(datum: ListDatum) -> str | None:
    """The hexadecimal form of `(color "...")`, None where it is something else."""
    items = datum.items
    if len(items) != 2 or datum.tail is not None or not all(isinstance(item, Atom) for item in items):
        return None
    head, name = items[0].value, items[1].value
    if head != "color" or not isinstance(head, Symbol) or type(name) is not str:
        return None
    try:
        linear = color_of(name)
    except SceneError:
        return None
    return _hex(tuple(linear))


def _hex(linear: tuple[float, ...]) -> str:
    channels = np.rint(to_srgb(np.array(linear)) * 255.0).astype(int).tolist()
    return "#" + "".join(f"{channel:02x}" for channel in channels)


def _literal(kind: str, value: Any) -> str | None:
    if kind == "boolean":
        return ("#t" if value else "#f") if isinstance(value, bool) else None
    if kind in ("integer", "number"):
        return _number_literal(kind, value)
    if not isinstance(value, str) or len(value) > 10_000:
        return None
    if kind == "text":
        return atom_text(value)
    if kind == "color":
        return _color_literal(value) if _HEX.fullmatch(value) else None
    if kind == "literal":
        forms = read(Source("<param>", value))
        fits = len(forms.forms) == 1 and not forms.diagnostics and not isinstance(forms.forms[0], ListDatum)
        return value.strip() if fits and ";" not in value and "|" not in value else None
    return None


def _number_literal(kind: str, value: Any) -> str | None:
    if type(value) not in (int, float) or not math.isfinite(value):
        return None
    if kind == "integer":
        return str(int(value)) if value == int(value) else None
    return atom_text(float(value))


def _color_literal(value: str) -> str:
    encoded = np.array([int(value[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0
    return "[" + " ".join(f"{round(channel, _DIGITS):g}" for channel in from_srgb(encoded).tolist()) + "]"


def write_back(controls: Mapping[str, ParamControl], name: str, value: Any) -> None:
    """Put ``value`` in the place of the param's own in its file; all else in the file stays as it is.

    Raises SceneError: "param" for a value or a param that does not fit, "file" when the file was changed since it was
    read, or cannot be written.
    """
    control = controls.get(name)
    if control is None:
        raise SceneError("param", f"the program has no `param` named `{name}`")
    if control.place is None:
        raise SceneError("param", f"`{name}` cannot be saved", control.reason)
    source, text = control.place.source, control.written(value)
    path = Path(source.name).resolve()  # a link stays one
    before = _bytes(path)
    bom = _BOM if before.startswith(_BOM) else b""
    if before != bom + source.text.encode():
        raise SceneError("file", f"{source.name} has changed since it was read, so `{name}` was not saved")
    after = source.text[: control.place.start] + text + source.text[control.place.end :]
    mode = path.stat().st_mode & 0o7777
    with written_whole(path) as temporary:
        temporary.write_bytes(bom + after.encode())
        if _bytes(path) != before:
            raise SceneError("file", f"{source.name} changed meanwhile, so `{name}` was not saved")
    os.chmod(path, mode)


def _bytes(path: Path) -> bytes:
    try:
        return read_regular(path)
    except OSError as error:
        raise SceneError("file", f"cannot read {path.name}: {error.strerror or error}") from None


# Whether files have changed since they were looked at.


Stamp = tuple[int, int, int] | None  # time of change, size, inode; None where there is no such file


@dataclass(frozen=True, slots=True)
class Stamps:
    """The files that were looked at, and how they were then."""

    files: tuple[tuple[str, Stamp], ...] = ()

    def are_old(self) -> bool:
        """True when one of the files is not as it was."""
        return any(_stamp(name) != stamp for name, stamp in self.files)


def stamps_of(names: Iterable[str]) -> Stamps:
    """The stamps of files and folders as they are now."""
    return Stamps(tuple((name, _stamp(name)) for name in names))


def _stamp(name: str) -> Stamp:
    try:
        found = os.stat(name)
    except (OSError, ValueError):
        return None
    return found.st_mtime_ns, found.st_size, found.st_ino


OpenSession = Callable[[str, Mapping[str, str]], Session]  # (file, overridden params) -> the session for it
Evaluate = Callable[[str, Mapping[str, str]], "WorkspaceEvaluation"]  # (file, overridden params) -> what came of it
Announce = Callable[[int], None]  # called with the number of a file whose state is new


@dataclass(frozen=True, slots=True, eq=False)
class WorkspaceEvaluation:
    """What an evaluation of a file came to, as data that can go from one process to another. ``controls`` is None where
    the params are not known, and ``all_known`` False where some may be missing."""

    packet: bytes | None
    diagnostics: tuple[Diagnostic, ...]
    stamps: Stamps
    controls: tuple[ParamControl, ...] | None = None
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
    controls: tuple[ParamControl, ...] = ()
    values: Mapping[str, Any] = field(default_factory=dict)
    stamps: Stamps = field(default_factory=Stamps)

    def control(self, name: str) -> ParamControl:
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
            found = WorkspaceEvaluation(None, (error.problem,), stamps_of(_beside(self.files[file])))
        ok = found.packet is not None
        controls = old.controls
        if found.controls is not None and (found.all_known or not controls):
            controls = found.controls
        picture = version if ok else old.picture
        packet = found.packet if ok else old.packet
        return State(version, ok, picture, packet, found.diagnostics, controls, {}, found.stamps)


def evaluator(open_session: OpenSession, limit: int, splats: SplatsOf | None = None) -> Evaluate:
    """Evaluates files for a workspace; ``splats`` gives the Gaussians that are seen in place of solids."""

    def evaluate(path: str, literals: Mapping[str, str]) -> WorkspaceEvaluation:
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
        return WorkspaceEvaluation(packet, found, stamps, controls, program is not None and _is_read(program))

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
        files = (getattr(entity.shape, "file", None) for entity in descendants(*scene.frames))
        names += [file for file in files if file is not None]
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


def _param_data(control: ParamControl, values: Mapping[str, Any], is_live: bool) -> dict[str, Any]:
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


def saved_page(workspace: Workspace, told: Callable[[Sequence[Diagnostic]], None]) -> str | None:
    """One page with the scenes of all files, which needs no server; None where one of them has a mistake. ``told``
    hears of the diagnostics."""
    from scenelang.backends.viewer.page import SavedScene, self_contained

    scenes = []
    for number, name in enumerate(workspace.files):
        state = workspace.state(number)
        told(state.diagnostics)
        if state.packet is None or not state.ok:
            return None
        scenes.append(SavedScene(name, state_data(name, state, is_live=False), state.packet))
    return self_contained(scenes)

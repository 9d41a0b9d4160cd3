"""Implementation of the tools. Errors in a program are part of the answer; invalid calls raise WrongArguments."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.backends.base import frame_of
from scenelang.backends.geometry.lint import check_geometry
from scenelang.backends.geometry.relations import check_declarations
from scenelang.files import beside
from scenelang.files.zfile import read_entries
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import Diagnostic, SceneError, printable, render_text, suggest, to_json
from scenelang.interpreter.inspection.instance_paths import part_of
from scenelang.interpreter.inspection.outline import summary, summary_rows
from scenelang.interpreter.plugins import SERVICES
from scenelang.interpreter.scene.entity import Scene, count_words
from scenelang.interpreter.scene.primitives import docs_of_words
from scenelang.interpreter.scene.primitives.mesh_file import is_hidden
from scenelang.interpreter.values.limits import Limits
from scenelang.reference.primer import description, known_names, primer
from scenelang.reference.sections import SECTIONS, fitting_sections, with_sections
from scenelang.sandbox.supervision import limited
from scenelang.session.declarations import declaration_source
from scenelang.session.scene_changes import (
    TOLERANCE,
    change_lines,
    changes_between,
    compared_frames,
    compared_frames_in,
)
from scenelang.session.session import Options, Session, linted
from scenelang.stdlib.reference import TOPICS, records

if TYPE_CHECKING:
    from scenelang.backends.pictures.camera import Camera, Viewpoint
    from scenelang.backends.pictures.declared import ProgramView
    from scenelang.interpreter.inspection.difference import ComparedFrame
    from scenelang.interpreter.runtime.runtime import ZEntry
    from scenelang.session.session import Evaluated


# Answers of tools: text for people and models, data for programs, an image. All parts are limited in size and contain
# no control characters.


MAX_ITEMS = 100  # of lists of changes and of printed lines
_MAX_DIAGNOSTICS = 20  # of an answer
_MAX_NESTED_ITEMS = 10  # items of nested lists
_MAX_TEXT_LENGTH = 20_000  # characters of an answer's text
_MAX_STRING_LENGTH = 500  # characters of a string in data
MAX_ANSWER = 4_000  # bytes of text and data together
_MIN_TEXT_BYTES = 2_200  # bytes of text, if the data needs more than the rest
# numbers of items and characters that are tried, in this order, until the data fits
_TRUNCATIONS = ((100, 500), (50, 400), (20, 300), (10, 200), (5, 160), (3, 120), (2, 80), (1, 60), (0, 40))


@dataclass(frozen=True, slots=True)
class ToolAnswer:
    """Answer of a tool. ``data`` is None if the image or the text is the whole answer; ``png`` is the image.

    ``program`` is a new text of the program, for the server and not for the client.
    """

    text: str
    data: dict[str, Any] | None = None
    png: bytes | None = None
    program: str | None = None


def answer(lines: Iterable[str], data: dict[str, Any]) -> ToolAnswer:
    """Create an answer with text and data truncated to a size suitable for models."""
    return ToolAnswer(bounded_text(lines), bounded(data))


def bounded_text(lines: Iterable[str]) -> str:
    """Join lines to a text, truncated with the number of omitted characters."""
    text = printable("\n".join(lines))
    if len(text) <= _MAX_TEXT_LENGTH:
        return text
    return f"{text[:_MAX_TEXT_LENGTH]}\n... and {len(text) - _MAX_TEXT_LENGTH:,} more characters"


def fitted(full: ToolAnswer) -> ToolAnswer:
    """Return an answer whose text and data have at most 4,000 bytes together, with the numbers of omitted parts."""
    needed = 0 if full.data is None else len(json.dumps(full.data))
    text = _cut(full.text, MAX_ANSWER - min(needed, MAX_ANSWER - _MIN_TEXT_BYTES))
    if full.data is None:
        return replace(full, text=text)
    return replace(full, text=text, data=_shrunk(full.data, MAX_ANSWER - len(text.encode("utf-8"))))


def _cut(text: str, most: int) -> str:
    """Truncate a text at the end of a line."""
    if len(text.encode("utf-8")) <= most:
        return text
    cut = text.encode("utf-8")[: most - 60].decode("utf-8", "ignore")
    cut = cut[: cut.rfind("\n")] if cut.rfind("\n") > most // 2 else cut
    return f"{cut}\n... and {len(text) - len(cut):,} more characters"


def _shrunk(data: dict[str, Any], max_bytes: int) -> dict[str, Any]:
    """Truncate lists, tables and strings until the data fits."""
    for most, length in _TRUNCATIONS:
        shorter = _with_fewer(data, most, length)
        if len(json.dumps(shorter)) <= max_bytes:
            return shorter
    plain = {name: value for name, value in data.items() if isinstance(value, bool | int | float)}
    return {**plain, "truncated": True}


def _with_fewer(data: dict[str, Any], most: int, length: int) -> dict[str, Any]:
    """Return data with lists of at most ``most`` items and strings of at most ``length`` characters."""
    shorter: dict[str, Any] = {}
    for name, value in data.items():
        omitted_name = f"{name}_left_out"
        if isinstance(value, list):
            shorter[name] = [_shortened(item, most, length) for item in value[:most]]
        elif isinstance(value, dict):
            shorter[name] = {k: _shortened(value[k], most, length) for k in islice(value, max(2 * most, 12))}
        else:
            shorter.setdefault(name, _shortened(value, most, length))
            continue
        missing = len(value) - len(shorter[name])
        if missing:
            shorter[omitted_name] = missing + int(data.get(omitted_name, 0))
    return shorter


def _shortened(value: Any, most: int, length: int) -> Any:
    """Return a value with its strings and lists truncated."""
    if isinstance(value, str):
        return value if len(value) <= length else f"{value[:length]}..."
    if isinstance(value, dict):
        return {name: _shortened(item, most, length) for name, item in value.items()}
    if isinstance(value, list):
        return [_shortened(item, most, length) for item in value[: max(most, 4)]]
    return value


def bounded(data: dict[str, Any], most: int = MAX_ITEMS) -> dict[str, Any]:
    """Truncate lists and strings in JSON data.

    ``NAME_left_out`` next to a truncated list is the number of omitted items.
    """
    short: dict[str, Any] = {}
    for name, value in data.items():
        short[printable(name)] = _bounded(value, most)
        if isinstance(value, list) and len(value) > most:
            short[f"{name}_left_out"] = len(value) - most
    return short


def _bounded(value: Any, most: int) -> Any:
    """Return a value with its strings, lists and tables truncated."""
    if isinstance(value, str):
        return clipped(value)
    if isinstance(value, dict):
        return bounded(value, min(most, _MAX_NESTED_ITEMS))
    if isinstance(value, list):
        return [_bounded(item, min(most, _MAX_NESTED_ITEMS)) for item in value[:most]]
    return value


def clipped(text: str) -> str:
    """Truncate a string and remove control characters."""
    shown = printable(text[:_MAX_STRING_LENGTH])
    left = len(text) - _MAX_STRING_LENGTH
    return shown if left <= 0 else f"{shown}... and {left:,} more characters"


# --- diagnostics and logs ------------------------------------------------------------------------------------------


def diagnosed(diagnostics: Sequence[Diagnostic]) -> tuple[list[str], dict[str, Any]]:
    """Format the first diagnostics, errors first, as lines and as data, with the number of omitted ones."""
    ordered = sorted(diagnostics, key=lambda diagnostic: not diagnostic.is_error)
    shown = ordered[:_MAX_DIAGNOSTICS]
    left = len(ordered) - len(shown)
    lines = [render_text(diagnostic) for diagnostic in shown] + ([f"... and {left:,} more"] if left else [])
    data: dict[str, Any] = {"diagnostics": [_filled(to_json(diagnostic)) for diagnostic in shown]}
    return lines, data | ({"diagnostics_left_out": left} if left else {})


def _filled(data: dict[str, Any]) -> dict[str, Any]:
    """Return the fields of a diagnostic that are not empty."""
    return {name: value for name, value in data.items() if value not in (None, [], "")}


def printed(log: Sequence[str]) -> tuple[list[str], dict[str, Any]]:
    """Format the printed output of a program, as lines and as data."""
    left = len(log) - MAX_ITEMS
    lines = [clipped(line) for line in log[:MAX_ITEMS]] + ([f"... and {left:,} more lines"] if left > 0 else [])
    return ["printed:", *lines] if log else [], {"log": list(log)}


def refused(diagnostics: Sequence[Diagnostic], log: Sequence[str] = ()) -> ToolAnswer:
    """Return the answer for a program with errors."""
    lines, data = diagnosed(diagnostics)
    printed_lines, more = printed(log)
    return answer([*lines, *printed_lines], {"ok": False, **data, **(more if log else {})})


# Language overview for agents.


_START = """# The Scene Language

A scene is a program of words and functions. `bind` binds a function to a word, `call` makes an entity of a word,
`transform` puts it under a pose (a 4x4 matrix), `union` brings several together. A word that nothing binds is a
primitive: one of those below, or a box with its word on it. The scene is the word that no other function calls.

y is up, lengths are the scene's units, angles radians. Colors are linear, `[red green blue]` from 0 to 1, or
`(color "ivory")`. `[1 2 3]` is an array, `:name` a keyword argument, `;` begins a comment.

```scene
(bind "step"
  (lambda (:width)
    (call "cube" :scale [width .2 .6] :color [.6 .4 .3])))

(bind "stairs"
  (lambda ()
    (union-loop 8
      (lambda (i)
        (transform (call "step" :width 2) (translate [0 (* i .2) (* i -.6)]))))))
```

A 4D scene is a root whose value is `(frames list)`, one entity for every moment.
"""
_END = "\nUse the tool `help` for the description of a name, and `search` to find one."


def primer_text() -> str:
    """Return the primer as Markdown, with an example and all sections."""
    return "\n".join([_START, with_sections(primer(), list(SECTIONS)), _END])


def sections_for(task: str) -> str:
    """Return the sections of the primer that a task asks for; "" without any."""
    names = fitting_sections(task)
    return with_sections("For this task:", names) if names else ""


def overview_text() -> str:
    """Return the beginning of the primer and the names for scenes, short enough for a tool."""
    topics = ("paper", "poses", "combinators", "solids", "entities")
    lines = [f"{title}: {', '.join(r.name for r in records() if r.topic == topic)}" for topic, title in _titles(topics)]
    words = f"Primitives: {', '.join(docs_of_words())}"
    return "\n".join([_START, words, *lines, _END.strip(), "The resource scenelang://primer has all of it."])


def _titles(topics: Sequence[str]) -> list[tuple[str, str]]:
    """Return topics with their titles."""
    return [(topic, TOPICS[topic][0]) for topic in topics]


# Project folder: the only folder that agents may read, and the programs in it.


_NAME = "<program>"
MAX_PROGRAM_LENGTH = 1_000_000  # characters; larger programs can be passed as files
_MAX_SHOWN_LENGTH = 120  # characters of a path in a message


class WrongArguments(Exception):
    """Raised for an invalid call, independent of the program. The message is one line for the agent, ``name`` that of
    its diagnostic."""

    def __init__(self, message: str, name: str = "value") -> None:
        """Store the one-line message and the name of its diagnostic."""
        super().__init__(message, name)
        self.name = name

    def __str__(self) -> str:
        """Return the message."""
        return str(self.args[0])


def wrong_arguments(error: SceneError) -> WrongArguments:
    """Convert a SceneError about arguments to one line."""
    return WrongArguments("; ".join(part for part in (error.message, error.hint) if part), error.name)


@dataclass(frozen=True, slots=True)
class ProjectProgram:
    """Program of a call: its text or a file, the other is empty.

    ``root`` is the word to evaluate (empty: the program's default), ``name`` the file of a session's text.
    """

    text: str = ""
    path: str = ""
    root: str = ""
    name: str = ""


@dataclass(frozen=True, slots=True)
class Project:
    """Resolved project folder ``root``, and the limits of evaluations in it.

    It is also the working directory, so that imports are resolved relative to it.
    """

    root: Path
    limits: Limits

    def file(self, path: str) -> Path:
        """Resolve a path to a regular file; raises WrongArguments if there is none, or it is outside the folder."""
        shown = printable(path[:_MAX_SHOWN_LENGTH]).replace("\n", " ")
        try:
            target = (self.root / path).resolve()
            is_inside, is_file = target.is_relative_to(self.root), target.is_file()
        except (OSError, ValueError, RuntimeError):
            raise WrongArguments(f"invalid path `{shown}`", "file") from None
        if not is_inside:
            raise WrongArguments(f"`{shown}` is outside the project folder", "import-outside")
        if is_hidden(target, self.root):
            raise WrongArguments(f"`{shown}` is hidden", "file")
        if not is_file:
            raise WrongArguments(f"no file `{shown}` in the project folder", "file")
        return target

    def opened(self, program: ProjectProgram) -> tuple[Session, Source]:
        """Return session and source to check or evaluate. Raises WrongArguments if the call specifies no program,
        SceneError if the file cannot be read."""
        if bool(program.text) == bool(program.path):
            raise WrongArguments("expected one of `session`, `program` (text) and `path` (file of the project folder)")
        if program.text:
            near = self.root / program.name if program.name else None
            session = self._session(program, {} if near is None else self._embeddings(near))
            return session, Source(program.name or _NAME, _checked(program.text))
        file = self.file(program.path)
        session = self._session(program, self._embeddings(file))
        return session, Source(str(file.relative_to(self.root)), session.source(str(file)).text)

    def _session(self, program: ProjectProgram, entries: dict[str, ZEntry]) -> Session:
        """Return a session for a program."""
        return Session(Options(root=program.root or None, limits=self.limits, project=self.root, z_entries=entries))

    def _embeddings(self, file: Path) -> dict[str, ZEntry]:
        """Return the embeddings next to a program, as on the command line."""
        z = beside(str(file))
        return read_entries(self.file(str(z))) if os.path.exists(z) else {}


def _checked(text: str) -> str:
    """Return the text of a program; raises WrongArguments if it is too long."""
    if len(text) > MAX_PROGRAM_LENGTH:
        raise WrongArguments(
            f"`program` exceeds {MAX_PROGRAM_LENGTH:,} characters; save it as a file and use `path`", "size"
        )
    return text


MAX_SIDE = 1024  # pixels per side of an image
SIZE = 512  # default width and height of an image, in pixels
_MAX_WORDS = 200  # in counts
_MAX_WORD_LENGTH = 200  # characters of a word in counts
_MAX_LISTED_CHANGES = 20  # changes that the text lists


@dataclass(frozen=True, slots=True)
class ToolView:
    """View of an image: frame of a 4D scene (None: the first), camera, size in pixels, and the path of a part."""

    camera: str = ""
    frame: int | None = None
    width: int = SIZE
    height: int = SIZE
    part: str = ""


def check(
    project: Project, program: ProjectProgram, geometry: bool, that: Sequence[str] = (), physics: bool = False
) -> ToolAnswer:
    """Return all errors and warnings.

    ``geometry`` also evaluates the program and runs the geometry lint, ``physics`` simulates it; ``that`` are
    declarations, which are tested besides those of the program.
    """
    try:
        with limited(project.limits):
            session, source = project.opened(program)
            declarations = [
                declaration for text in that for declaration in session.declarations(declaration_source(text))
            ]
            diagnostics: Sequence[Diagnostic] = session.check(source).diagnostics
            if geometry or declarations or physics:
                result = session.evaluate(source)
                lints = [lambda scene: check_declarations(scene, declarations), *([check_geometry] if geometry else [])]
                lints += [_check_physics] if physics else []
                diagnostics = [*result.diagnostics, *linted(result, *lints)]
    except SceneError as error:
        return refused([error.diagnostic])
    lines, data = diagnosed(diagnostics)
    ok = not any(diagnostic.is_error for diagnostic in diagnostics)
    return answer(lines or ["no errors and no warnings"], {"ok": ok, **data})


def _check_physics(scene: Scene) -> list[Diagnostic]:
    """Return the warnings of a simulation."""
    diagnostics: list[Diagnostic] = SERVICES.find("physics").check_physics(scene)
    return diagnostics


def run(project: Project, program: ProjectProgram) -> ToolAnswer:
    """Return a summary of the scene: root, counts, bounding box, frames, printed output."""

    def reply(scene: Scene, result: Evaluated) -> ToolAnswer:
        facts = summary(scene)
        lines, data = diagnosed(result.diagnostics)
        printed_lines, log = printed(result.log)
        rows = [f"{name}: {value}" for name, value in summary_rows(facts)]
        return answer([*rows, *printed_lines, *lines], {"ok": True, **facts, **log, **data})

    return of_scene(project, program, reply)


def count(project: Project, program: ProjectProgram, frame: int) -> ToolAnswer:
    """Return the instances of every word in a frame, in order of first appearance."""

    def reply(scene: Scene, _: Evaluated) -> ToolAnswer:
        """Return the answer for an evaluated scene."""
        counts = count_words(scene.frames[frame_in(scene, frame)])
        shown = dict(islice(((word, n) for word, n in counts.items() if len(word) <= _MAX_WORD_LENGTH), _MAX_WORDS))
        left = len(counts) - len(shown)
        lines = [f"{n:,} {word}" for word, n in shown.items()] + ([f"... and {left:,} more words"] if left else [])
        data: dict[str, Any] = {"ok": True, "frame": frame, "counts": shown}
        return answer(lines, data | ({"counts_left_out": left} if left else {}))

    return of_scene(project, program, reply)


def render(project: Project, program: ProjectProgram, view: ToolView) -> ToolAnswer:
    """Render a draft image of a frame."""
    camera = camera_in(project, view.camera)

    def reply(scene: Scene, result: Evaluated) -> ToolAnswer:
        """Return the image, with a caption and the warnings."""
        from scenelang.backends.pictures import film

        scene = part_of(scene, view.part) if view.part else scene
        frame = frame_in(scene, view.frame)
        warned = list(result.diagnostics)
        options = film.PictureOptions(
            frame=frame,
            limit=project.limits.primitives,
            warn=warned.append,
            width=view.width,
            height=view.height,
            camera=camera,
        )
        png = film.png_of(film.render(scene, options))
        of = f", frame {frame} of {len(scene.frames)} (0 to {len(scene.frames) - 1})" if scene.animated else ""
        lines, _ = diagnosed(warned)
        return ToolAnswer(
            bounded_text([f"{view.part or scene.word}{of}, {view.width} x {view.height} pixels", *lines]), None, png
        )

    return of_scene(project, program, reply)


def diff(project: Project, a: ProjectProgram, b: ProjectProgram, tolerance: float = TOLERANCE) -> ToolAnswer:
    """List moved, recolored, removed and added primitives in B."""
    sides: list[list[ComparedFrame]] = []
    for name, program in (("a", a), ("b", b)):
        try:
            side = _compared_frames(project, program)
        except WrongArguments as error:
            raise WrongArguments(f"scene {name.upper()}: {error}") from None
        if isinstance(side, ToolAnswer):
            return ToolAnswer(f"scene {name.upper()} has errors:\n{side.text}", {"side": name, **(side.data or {})})
        sides.append(side)
    try:
        with limited(project.limits):
            changes = changes_between(sides[0], sides[1], tolerance)
    except SceneError as error:
        return refused([error.diagnostic])
    data = changes.data(MAX_ITEMS)
    omitted = len(changes.changes) - MAX_ITEMS
    more = {"changes_left_out": omitted} if omitted > 0 else {}
    return answer(change_lines(changes, _MAX_LISTED_CHANGES), {"ok": True, **data, **more})


def explain(name: str) -> ToolAnswer:
    """Describe a name of the language, a primitive, an attribute or a diagnostic; without a name, return the primer."""
    query = name.strip()
    if not query:
        return ToolAnswer(overview_text())
    lines = description(query)
    if not lines:
        hint = suggest(query, known_names()) or "call help without a name for an overview"
        raise WrongArguments(f"unknown name `{query[:80]}`; {hint}")
    return ToolAnswer(bounded_text(lines))


# --- shared --------------------------------------------------------------------------------------------------------


def of_scene(project: Project, program: ProjectProgram, reply: Callable[[Scene, Evaluated], ToolAnswer]) -> ToolAnswer:
    """Apply ``reply`` to the program's scene; return its diagnostics if the program has errors or ``reply`` raises."""
    try:
        with limited(project.limits):
            session, source = project.opened(program)
            result = session.evaluate(source)
            if result.scene is None:
                return refused(result.diagnostics, result.log)
            return reply(result.scene, result)
    except SceneError as error:
        return refused([error.diagnostic])


def _compared_frames(project: Project, program: ProjectProgram) -> list[ComparedFrame] | ToolAnswer:
    """Return the frames of a program or of a flattened scene (.json), or an answer that explains why there are none."""
    limit = project.limits.primitives
    try:
        sheets = (
            compared_frames_in(str(project.file(program.path)), limit) if program.path and not program.text else None
        )
        if sheets is not None:
            return sheets
        with limited(project.limits):
            session, source = project.opened(program)
            result = session.evaluate(source)
            return (
                refused(result.diagnostics, result.log)
                if result.scene is None
                else compared_frames(result.scene, limit)
            )
    except SceneError as error:
        return refused([error.diagnostic])


def frame_in(scene: Scene, frame: int | None) -> int:
    """Return the number of a frame, by default the first; raises WrongArguments if it does not exist."""
    try:
        return frame_of(scene, frame)
    except SceneError as error:
        raise wrong_arguments(error) from None


def camera_in(project: Project, text: str) -> Viewpoint | Camera | ProgramView:
    """Parse a camera as `--camera` does; camera files must be in the project folder."""
    from scenelang.backends.pictures.declared import view_of

    query = text.strip()
    try:
        return view_of(str(project.file(query)) if query.lower().endswith(".json") else query)
    except SceneError as error:
        raise wrong_arguments(error) from None

"""Programs of an agent: texts in memory with undo, and files that are written in the project folder.

``Workbench`` lives in the server; the functions below it evaluate, and run in a worker.
"""

from __future__ import annotations

import difflib
import os
import stat
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.backends import base
from scenelang.backends.files import atomic_write_all, read_regular, write_text
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import Diagnostic, SceneError, printable, to_json
from scenelang.mcp.tools import (
    MAX_PROGRAM_LENGTH,
    Project,
    ProjectProgram,
    ToolAnswer,
    WrongArguments,
    answer,
    clipped,
    diagnosed,
    refused,
    wrong_arguments,
)
from scenelang.repairs.instance_edits import InstanceEdit, edited
from scenelang.repairs.repairing import repaired
from scenelang.sandbox.supervision import limited
from scenelang.session.declarations import declaration_source, with_acceptance, without_acceptance
from scenelang.session.session import is_python

if TYPE_CHECKING:
    from scenelang.backends.physics.settling import EditedProgram, RestingScene

MAX_SESSIONS = 16  # that are open at a time
MAX_EXPORT = 200_000_000  # of an export, in bytes
MAX_UNDO = 200  # versions of a session
MAX_ACCEPTANCE = 50  # declarations of a session, or of a call
MAX_DECLARATION_LENGTH = 1_000  # characters
_MAX_DIFF_LINES = 40  # lines
_MAX_HISTORY_LENGTH = 20_000_000  # characters of all versions of a session
_MAX_READ_LINES = 60  # lines that are read at a time
_CONTEXT_LINES = 2  # lines around an edit
_MAX_MATCHES = 10_000  # of a replacement
_MAX_READ = 16_000_000  # bytes
_MAX_COMPARED = (500, 120)  # lines, and characters of a line, in which a similar line is searched
_MAX_LINES_BYTES = 3_000  # of lines that are read at a time
_MAX_BODIES = 20  # that an answer lists
_MAX_NAME_BYTES = 200  # of a file name, as file systems allow
_SAVED = (".scene",)


# --- sessions --------------------------------------------------------------------------------------------------------


@dataclass(slots=True)
class WorkingProgram:
    """Program in memory.

    Attributes
    ----------
    path
        Its file, relative to the project, empty without one.
    saved
        Text of that file, with the acceptance.
    before, after
        Texts for undo and redo.
    acceptance
        Declarations, as texts, that the scene is tested against after every change.
    """

    name: str
    text: str
    path: str = ""
    saved: str | None = None
    before: list[str] = field(default_factory=list)
    after: list[str] = field(default_factory=list)
    acceptance: tuple[str, ...] = ()

    def program(self, root: str = "") -> ProjectProgram:
        """Return the program for a worker."""
        return ProjectProgram(self.text or "\n", "", root, self.path)

    def state(self) -> dict[str, Any]:
        """Return the name and the state of the session, which every answer contains."""
        return {"session": self.name, "version": len(self.before), "unsaved": self.file_text != (self.saved or "")}

    @property
    def file_text(self) -> str:
        """Text of the session's file, which states its acceptance at its end."""
        return with_acceptance(self.text, self.acceptance)

    def set(self, text: str) -> None:
        """Replace the text; the last one can be undone."""
        if len(text) > MAX_PROGRAM_LENGTH:
            raise WrongArguments(f"the program would exceed {MAX_PROGRAM_LENGTH:,} characters", "size")
        if text == self.text:
            return
        self.before.append(self.text)
        self.after.clear()
        self.text = text
        while len(self.before) > MAX_UNDO or (
            len(self.before) > 1 and sum(map(len, self.before)) > _MAX_HISTORY_LENGTH
        ):
            del self.before[0]

    def step(self, steps: int, back: bool) -> int:
        """Go back or forward; returns the number of steps taken."""
        source, target = (self.before, self.after) if back else (self.after, self.before)
        taken = 0
        while source and taken < steps:
            target.append(self.text)
            self.text = source.pop()
            taken += 1
        return taken


class Workbench:
    """Open sessions of a server, by name."""

    def __init__(self, drafts: Iterable[WorkingProgram] = (), number: int = 0) -> None:
        """Start with the sessions of an earlier server; ``number`` is the highest that it gave to one."""
        self._drafts = {draft.name: draft for draft in drafts}
        self._number = number

    def open(self, text: str, path: str = "", saved: str | None = None) -> WorkingProgram:
        """Open a session; raises WrongArguments if there are too many."""
        if len(self._drafts) >= MAX_SESSIONS:
            raise WrongArguments(f"{MAX_SESSIONS} sessions are open; close one", "size")
        if len(text) > MAX_PROGRAM_LENGTH:
            raise WrongArguments(f"the program exceeds {MAX_PROGRAM_LENGTH:,} characters", "size")
        self._number += 1
        body, acceptance = without_acceptance(text)
        draft = WorkingProgram(f"s{self._number}", body, path, saved, acceptance=acceptance)
        self._drafts[draft.name] = draft
        return draft

    def __getitem__(self, name: str) -> WorkingProgram:
        """Return a session; raises WrongArguments if it is not open."""
        draft = self._drafts.get(name)
        if draft is None:
            known = f"open are {', '.join(self._drafts)}" if self._drafts else "none is open; call `open`"
            raise WrongArguments(f"no session `{clipped(name[:40])}`; {known}")
        return draft

    def close(self, name: str) -> WorkingProgram:
        """Close a session and return it."""
        draft = self[name]
        del self._drafts[name]
        return draft

    def names(self) -> list[str]:
        """Return the names of the open sessions."""
        return list(self._drafts)


# --- edits of text ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class TextSpan:
    """Range of a text: lines and columns from 1 as in diagnostics, the end excluded, or offsets from 0.

    Without an end it is empty, which inserts. ``old`` is the expected text of the range.
    """

    line: int = 0
    column: int = 1
    end_line: int = 0
    end_column: int = 0
    start: int = -1
    end: int = -1
    old: str | None = None

    def offsets(self, text: str) -> tuple[int, int]:
        """Return the range as offsets; raises WrongArguments if it is not a range of the text."""
        by_line = self.line > 0
        if by_line == (self.start >= 0):
            raise WrongArguments("expected either `line` and `column`, or the offset `start`")
        if by_line:
            start = _offset(text, self.line, self.column)
            end = _offset(text, self.end_line or self.line, self.end_column) if self.end_column else start
            if not self.end_column and self.old is not None:
                end = start + len(self.old)
            elif self.end_line and not self.end_column:
                raise WrongArguments("`end_line` needs `end_column`")
        else:
            start = self.start
            end = self.end if self.end >= 0 else start + len(self.old or "")
        if not 0 <= start <= end <= len(text):
            raise WrongArguments(f"the span {start} to {end} is no range of a text of {len(text):,} characters")
        if self.old is not None and text[start:end] != self.old:
            actual = clipped(text[start:end][:80]).replace("\n", " ")
            raise WrongArguments(f"`old` differs from the text of the span, which is `{actual}`")
        return start, end


def _offset(text: str, line: int, column: int) -> int:
    """Return the offset of a line and column; raises WrongArguments if it does not exist."""
    lines = text.count("\n") + 1
    if line > lines:
        raise WrongArguments(f"line {line} does not exist; the program has {lines:,}")
    source = Source("<program>", text)
    start, length = source.line_start(line), len(source.line(line))
    if not 1 <= column <= length + 1:
        raise WrongArguments(f"column {column} does not exist; line {line} has {length:,} characters")
    return start + column - 1


def spliced(text: str, span: TextSpan, new: str) -> tuple[str, int]:
    """Return a text with a range replaced, and the offset of the change."""
    start, end = span.offsets(text)
    return text[:start] + new + text[end:], start


def substituted(text: str, old: str, new: str, every: bool) -> tuple[str, int, int]:
    """Return a text with ``old`` replaced, the offset of the first change, and the number of changes.

    Raises WrongArguments if it does not occur, or more than once without ``every``.
    """
    if not old:
        raise WrongArguments("`old` is empty; insert text with `edit`")
    count = text.count(old)
    if count == 0:
        raise WrongArguments(f"`old` does not occur in the program{_nearest(text, old)}")
    if count > 1 and not every:
        lines = [text.count("\n", 0, at) + 1 for at in _places(text, old, 5)]
        shown = ", ".join(map(str, lines))
        raise WrongArguments(f"`old` occurs {count:,} times (lines {shown}); add more context, or pass `every`")
    if count > _MAX_MATCHES or len(text) + count * (len(new) - len(old)) > MAX_PROGRAM_LENGTH:
        raise WrongArguments(f"replacing {count:,} places would exceed the limits of a program", "size")
    return text.replace(old, new), text.index(old), count


def _nearest(text: str, old: str) -> str:
    """Return a hint with the line most similar to the first line of a text that does not occur."""
    lines, length = _MAX_COMPARED
    line = next((part for part in old[:10_000].splitlines() if part.strip()), old).strip()[:length]
    every = [part.strip() for part in text.splitlines() if len(part) <= length][:lines]
    near = difflib.get_close_matches(line, every, 1, 0.6)
    return f"; the nearest line is `{clipped(near[0])}`" if near else ""


def _places(text: str, old: str, most: int) -> list[int]:
    """Return the offsets of the first occurrences of a text."""
    offsets: list[int] = []
    offset = text.find(old)
    while offset >= 0 and len(offsets) < most:
        offsets.append(offset)
        offset = text.find(old, offset + len(old))
    return offsets


def numbered(text: str, first: int, last: int) -> list[str]:
    """Return lines with their numbers, at most 60 and about 3,000 bytes."""
    source = Source("<program>", text)
    first, last = max(1, first), min(last, line_count(text), first + _MAX_READ_LINES - 1)
    lines: list[str] = []
    size = 0
    for number in range(first, last + 1):
        line = f"{number:>4}  {clipped(source.line(number))}"
        size += len(line.encode("utf-8")) + 1
        if size > _MAX_LINES_BYTES and lines:
            break
        lines.append(line)
    return lines


def line_count(text: str) -> int:
    """Return the number of lines of a text, 0 for an empty one."""
    return text.count("\n") + (not text.endswith("\n")) if text else 0


def around(text: str, offset: int, length: int) -> list[str]:
    """Return the lines of a change with some context."""
    first = text.count("\n", 0, offset) + 1
    last = first + text.count("\n", offset, offset + length)
    return numbered(text, first - _CONTEXT_LINES, min(last, first + 10) + _CONTEXT_LINES)


# --- files -----------------------------------------------------------------------------------------------------------


def target_of(project: Project, path: str, endings: Iterable[str], overwrite: bool) -> Path:
    """Return the file to write, in an existing folder of the project.

    Raises WrongArguments for a path that is outside, hidden, through a link, not a regular file, of another extension,
    or of an existing file without ``overwrite``.
    """
    shown = clipped(path[:120]).replace("\n", " ")
    known = tuple(endings)
    if not path or "\0" in path or not printable(path) == path:
        raise WrongArguments("expected the path of a file in the project folder", "file")
    relative = Path(path)
    if relative.is_absolute():
        if not relative.is_relative_to(project.root):
            raise WrongArguments(f"`{shown}` is outside the project folder", "import-outside")
        relative = relative.relative_to(project.root)
    if any(len(part.encode("utf-8", "replace")) > _MAX_NAME_BYTES for part in relative.parts):
        raise WrongArguments(f"the name `{shown}` is too long", "file")
    if ".." in relative.parts:
        raise WrongArguments(f"`{shown}` is outside the project folder", "import-outside")
    if any(part.startswith(".") for part in relative.parts):
        raise WrongArguments(f"`{shown}` is hidden; write another name", "file")
    if relative.suffix.lower() not in known:
        raise WrongArguments(f"`{shown}` cannot be written; expected the ending {', '.join(known)}", "file")
    target = project.root / relative
    try:
        check_folders(project.root, target, shown)
        check_file(target, shown, overwrite=overwrite)
    except (OSError, ValueError):
        raise WrongArguments(f"invalid path `{shown}`", "file") from None
    return target


def check_folders(root: Path, target: Path, shown: str) -> None:
    """Check that all folders of the path exist, and that none is a link."""
    folder = root
    for part in target.relative_to(root).parts[:-1]:
        folder = folder / part
        if not os.path.lexists(folder):
            raise WrongArguments(f"the folder of `{shown}` does not exist", "file")
        if not stat.S_ISDIR(os.lstat(folder).st_mode):
            raise WrongArguments(f"`{shown}` is below a link or a file; folders of the project only", "file")


def check_file(target: Path, shown: str, *, overwrite: bool) -> None:
    """Check that a file is a regular one without other links, and may be replaced."""
    if not os.path.lexists(target):
        return
    status = os.lstat(target)
    if not stat.S_ISREG(status.st_mode) or status.st_nlink > 1:
        raise WrongArguments(f"`{shown}` exists and is a link, a folder or a special file", "file")
    if not overwrite:
        raise WrongArguments(f"`{shown}` exists; pass `overwrite` to replace it", "file")


def save(project: Project, draft: WorkingProgram, path: str, overwrite: bool) -> Path:
    """Write a session to a file, atomically, and return it."""
    name = path or draft.path
    if not name:
        raise WrongArguments("the session has no file yet; pass `path`", "file")
    target = target_of(project, name, _SAVED, overwrite or _is_own(project, draft, name))
    text = draft.file_text
    text = text if text.endswith("\n") or not text else f"{text}\n"
    try:
        text.encode("utf-8")
        write_text(target, text)
    except UnicodeEncodeError:
        raise WrongArguments("the program has characters that UTF-8 cannot encode", "encoding") from None
    except SceneError as error:
        raise WrongArguments(error.message.replace(str(project.root) + os.sep, ""), error.name) from None
    draft.path, draft.saved = str(target.relative_to(project.root)), draft.file_text
    return target


def _is_own(project: Project, draft: WorkingProgram, name: str) -> bool:
    """Return whether a file is the session's own and unchanged; raises WrongArguments if it was changed."""
    if not draft.path or draft.saved is None or (project.root / name) != project.root / draft.path:
        return False
    try:
        now = read_regular(project.root / draft.path, _MAX_READ).decode("utf-8", "replace")
    except OSError:
        return True
    if now.rstrip("\n") != draft.saved.rstrip("\n"):
        raise WrongArguments(f"`{draft.path}` was changed since it was opened; pass `overwrite` to replace it", "file")
    return True


# --- work in a worker ------------------------------------------------------------------------------------------------


def opened_text(project: Project, program: ProjectProgram) -> ToolAnswer:
    """Read a program of the project, or translate a model's Python; ``program`` of the answer is its text."""
    try:
        with limited(project.limits):
            session, source = project.opened(program)
            if not is_python(source):
                return ToolAnswer("", {"ok": True, "translated": False}, program=source.text)
            translation = session.transpile(source)
    except SceneError as error:
        return refused([error.diagnostic])
    if not translation.ok:
        return refused(translation.diagnostics)
    lines, data = diagnosed(translation.diagnostics)
    return ToolAnswer("\n".join(lines), {"ok": True, "translated": True, **data}, program=translation.text)


def changed_lines(project: Project, old: str, new: str, names: tuple[str, str]) -> ToolAnswer:
    """Return a unified diff of two texts, at most 40 lines."""
    try:
        with limited(project.limits):
            diff = list(difflib.unified_diff(old.splitlines(), new.splitlines(), *names, lineterm="", n=1))
    except SceneError as error:
        return refused([error.diagnostic])
    omitted = len(diff) - _MAX_DIFF_LINES
    lines = [*map(clipped, diff[:_MAX_DIFF_LINES]), *([f"... and {omitted:,} more lines"] if omitted > 0 else [])]
    return answer(lines, {"ok": True})


def repair(project: Project, program: ProjectProgram, that: Sequence[str], geometry: bool, effort: float) -> ToolAnswer:
    """Repair a program without a model; one line for each edit."""
    try:
        session, source = project.opened(program)
        sources = map(declaration_source, that)
        declarations = [declaration for written in sources for declaration in session.declarations(written)]
        outcome = repaired(session, source, declarations, effort=effort, geometry=geometry)
    except SceneError as error:
        return refused([error.diagnostic])
    lines = [
        f"line {edit.line}: {_line(edit.old)} -> {_line(edit.new) or 'nothing'}, since {_line(edit.resolves)}"
        for edit in outcome.edits
    ]
    lines += [f"remains: {_line(message)}" for message in outcome.left]
    data = {"ok": not outcome.left, **outcome.data()}
    return ToolAnswer("\n".join(lines) or "nothing to repair", data, program=outcome.text)


def _line(text: str) -> str:
    """Return a text as one line of at most 160 characters."""
    line = " ".join(text.split())
    return line if len(line) <= 160 else line[:157] + "..."


def edit_part(project: Project, program: ProjectProgram, edit: InstanceEdit) -> ToolAnswer:
    """Edit the form that makes the instances of a path."""
    try:
        session, source = project.opened(program)
        outcome = edited(session, source, edit)
    except SceneError as error:
        return refused([error.diagnostic])
    count = f"{outcome.instances:,} instance{'s' * (outcome.instances != 1)}"
    old, new = _line(outcome.old), _line(outcome.new)
    change = f"{old} -> {new or 'nothing'}" if old else f"{new} added"
    others = f"{outcome.others:,} other primitives" if outcome.others else "nothing else"
    line = f"line {outcome.line}: {change} ({count}, {others} change{'' if outcome.others else 's'})"
    data = {"ok": True, "line": outcome.line, "instances": outcome.instances, "others": outcome.others}
    return ToolAnswer(line, data, program=outcome.text)


def settle(project: Project, program: ProjectProgram, seconds: float) -> ToolAnswer:
    """Let the scene of a program come to rest, and put the new poses into its text where literals say them.

    Raises WrongArguments with a line about the installation if the packages for physics are missing.
    """
    from scenelang.backends.physics.settling import edited_program, settled

    try:
        with limited(project.limits):
            session, source = project.opened(program)
            result = session.evaluate(source)
            if result.scene is None:
                return refused(result.diagnostics, result.log)
            if result.scene.animated:
                raise WrongArguments("the frames of a 4D scene do not come to rest; settle a still scene", "frames")
            rest = settled(result.scene, seconds)
            placed = edited_program(source, result.scene, None, rest, lambda text: session.evaluate(text).scene)
    except SceneError as error:
        if error.name == "backend":
            raise wrong_arguments(error) from None
        return refused([error.diagnostic])
    return _settled_answer(rest, placed)


def _settled_answer(rest: RestingScene, placed: EditedProgram) -> ToolAnswer:
    """Return which bodies moved, and which the program still has where they were."""
    why = "; no literal of the program is its pose alone, use `edit_part`"
    rows = [
        f"moved: {_body(rest, number)}" if number in placed.bodies else f"not moved: {_body(rest, number)}{why}"
        for number in rest.moved
    ]
    shown = rows[:_MAX_BODIES] + ([f"... and {len(rows) - _MAX_BODIES:,} more"] if len(rows) > _MAX_BODIES else [])
    left = len(rest.moved) - len(placed.bodies)
    data = {"ok": left == 0, "moved": len(placed.bodies), "left": left}
    return ToolAnswer("\n".join(shown) or "everything rests", data, program=placed.text)


def _body(rest: RestingScene, number: int) -> str:
    """Return what a body does before it rests."""
    body = rest.report.bodies[number]
    words = "/".join(body.words[-3:])
    return _line(f"{words} {body.kind}, by {body.moved:.4g}, {body.tilt:.1f} degrees: {body.why}")


def export(project: Project, program: ProjectProgram, path: str, frame: int | None, overwrite: bool) -> ToolAnswer:
    """Export the scene of a program to a file of the project, with the files that belong to it."""
    endings = sorted({ending for backend in base.all_backends(base.Work.EXPORT) for ending in backend.endings})
    target = target_of(project, path, endings, overwrite)
    warned: list[Diagnostic] = []
    try:
        session, source = project.opened(program)
        with limited(project.limits):
            result = session.evaluate(source)
            if result.scene is None:
                return refused(result.diagnostics, result.log)
            backend = base.for_file(target, base.Work.EXPORT)
            options = base.BackendOptions(frame, project.limits.primitives, None, {}, warned.append)
            with atomic_write_all(target.parent) as folder:
                backend.run(result.scene, folder / target.name, options)
                files = _written(folder, target, overwrite=overwrite)
    except SceneError as error:
        return refused([error.diagnostic])
    lines, data = diagnosed(warned)
    rows = [f"wrote {name}, {size:,} bytes" for name, size in files]
    return answer([*rows, *lines], {"ok": True, "files": [name for name, _ in files], **data})


def _written(folder: Path, target: Path, *, overwrite: bool) -> list[tuple[str, int]]:
    """Check the files of an export before they are moved to their folder, and return their names and sizes."""
    files = []
    for file in sorted(folder.iterdir()):
        if file.name != target.name:
            check_file(target.parent / file.name, file.name, overwrite=overwrite)
        if not stat.S_ISREG(os.lstat(file).st_mode):
            raise SceneError("unsupported", f"an export to `{target.name}` makes a folder; use the command line")
        files.append((file.name, file.stat().st_size))
    total = sum(size for _, size in files)
    if total > MAX_EXPORT:
        raise SceneError("size", f"the export has {total:,} bytes, more than {MAX_EXPORT:,}")
    return files


def findings_data(diagnostics: Sequence[Diagnostic]) -> list[dict[str, Any]]:
    """Return the essentials of the first findings as JSON data."""
    first = [to_json(diagnostic) for diagnostic in diagnostics[:3]]
    return [{key: data[key] for key in ("code", "message", "place", "hint") if data[key]} for data in first]

"""Files of sessions, in ``.scenelang/sessions`` of a project, so that sessions survive the end of their server.

One server at a time owns this folder, by a lock that ends with its process; another one keeps nothing, since both name
their sessions s1, s2, ... Nothing here evaluates, and what is read is checked like any other input.
"""

from __future__ import annotations

import json
import math
import os
import re
import stat
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

from scenelang.backends.files import atomic_write, make_folder, read_regular
from scenelang.grammar.diagnostics import SceneError
from scenelang.mcp.tools import MAX_PROGRAM_LENGTH, WrongArguments, clipped
from scenelang.mcp.workbench import (
    MAX_ACCEPTANCE,
    MAX_DECLARATION_LENGTH,
    MAX_SESSIONS,
    MAX_UNDO,
    WorkingProgram,
    check_file,
    check_folders,
)

FOLDER = Path(".scenelang") / "sessions"
NO_PROJECT = "sessions end with the server; start it with `--project` to keep them"
NO_WRITER = "sessions end with the server, which is read-only"
_FORMAT = 1
# A file is written anew at every change: with this much history that takes 20 ms on the test machine.
_MAX_HISTORY_LENGTH = 2_000_000  # characters of all versions of a session that are kept
# A character has at most 12 bytes in JSON. A file has a text, the saved text and their history.
_MAX_BYTES = 12 * (2 * MAX_PROGRAM_LENGTH + _MAX_HISTORY_LENGTH) + 1_000_000
_MAX_PATH_LENGTH = 4_000  # characters
_MAX_ENTRIES = 10_000  # of the folder that are looked at
_MAX_NOTES = 3  # about files that were skipped
_FILE = re.compile(r"s([1-9][0-9]{0,5})\.json")
_LOCK_SECONDS = 1.0  # that a server which just ended may still hold the lock
_LOCK_POLL_SECONDS = 0.05


@dataclass(frozen=True, slots=True)
class ReadSessions:
    """Sessions of an earlier server, notes about files that were skipped, and the highest number of a file."""

    drafts: tuple[WorkingProgram, ...] = ()
    notes: tuple[str, ...] = ()
    number: int = 0


@dataclass(frozen=True, slots=True)
class SessionFiles:
    """Keeps the sessions of a server in files; with a ``problem``, the reason why it keeps none.

    ``lock`` is the open handle of the folder's lock, -1 without one.
    """

    root: Path
    problem: str = ""
    lock: int = -1

    def read(self) -> ReadSessions:
        """Return the sessions of an earlier server, at most 16; a file that is damaged is skipped with a note."""
        if self.problem:
            return ReadSessions()
        drafts: list[WorkingProgram] = []
        notes: list[str] = []
        numbers = sorted(_numbers(self.root / FOLDER))
        for number in numbers:
            name = f"s{number}"
            if len(drafts) == MAX_SESSIONS:
                notes.append(f"skipped {_shown(name)}: {MAX_SESSIONS} sessions are open")
                continue
            try:
                drafts.append(_read(self.root / FOLDER / f"{name}.json", name))
            except (OSError, WrongArguments, ValueError, RecursionError, MemoryError) as error:
                notes.append(f"skipped {_shown(name)}: {_reason(error)}")
        left = len(notes) - _MAX_NOTES
        shown = (*notes[:_MAX_NOTES], *((f"skipped {left:,} more files",) if left > 0 else ()))
        return ReadSessions(tuple(drafts), shown, max(numbers, default=0))

    def keep(self, draft: WorkingProgram) -> str:
        """Write a session, atomically; return why it was not written, empty if it was or none are kept."""
        if self.problem:
            return ""
        try:
            target = self._target(draft.name)
            with atomic_write(target, mode=0o600) as temporary:
                temporary.write_text(json.dumps(_data(draft)), "ascii")
        except (OSError, WrongArguments, SceneError) as error:
            return f"not kept for another server: {_reason(error)}"
        return ""

    def remove(self, name: str) -> str:
        """Remove the file of a session; return why that failed, empty if it did not."""
        if self.problem:
            return ""
        try:
            self._target(name).unlink(missing_ok=True)
        except (OSError, WrongArguments) as error:
            return f"its file was not removed: {_reason(error)}"
        return ""

    def _target(self, name: str) -> Path:
        """Return the file of a session; raises WrongArguments if it, or a folder of it, is a link or special."""
        make_folder_of_sessions(self.root)
        target = self.root / FOLDER / f"{name}.json"
        check_file(target, _shown(name), overwrite=True)
        return target


def session_files(root: Path) -> SessionFiles:
    """Return the files of a project's sessions, locked for this process."""
    try:
        make_folder_of_sessions(root)
        return SessionFiles(root, lock=_locked(root / FOLDER))
    except BlockingIOError:
        return SessionFiles(root, "sessions end with this server, as another server keeps those of the project")
    except (OSError, WrongArguments, SceneError) as error:
        return SessionFiles(root, f"sessions end with the server: {_reason(error)}")


def make_folder_of_sessions(root: Path) -> None:
    """Create the folder of sessions if necessary; raises WrongArguments if one on the way is a link or a file."""
    folder = root
    for part in FOLDER.parts:
        folder = folder / part
        if not os.path.lexists(folder):
            make_folder(folder)
        check_folders(root, folder / "file", f"{folder.relative_to(root)}")


def _locked(folder: Path) -> int:
    """Return the handle of an exclusive lock on a folder, -1 where there is no ``flock``.

    Raises BlockingIOError if another process holds it for longer than a server takes to end.
    """
    try:
        import fcntl
    except ImportError:
        return -1
    handle = os.open(folder, os.O_RDONLY | os.O_CLOEXEC)
    end = time.monotonic() + _LOCK_SECONDS
    while True:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if time.monotonic() > end:
                os.close(handle)
                raise
            time.sleep(_LOCK_POLL_SECONDS)
        else:
            return handle


def _numbers(folder: Path) -> Iterator[int]:
    """Yield the numbers of the session files in a folder."""
    with os.scandir(folder) as entries:
        for entry in islice(entries, _MAX_ENTRIES):
            match = _FILE.fullmatch(entry.name)
            if match is not None:
                yield int(match[1])


def _shown(name: str) -> str:
    """Return the file of a session as messages name it."""
    return f"{FOLDER.as_posix()}/{name}.json"


def _reason(error: Exception) -> str:
    """Return an error as part of a line."""
    text = error.message if isinstance(error, SceneError) else getattr(error, "strerror", None) or str(error)
    return clipped(text or type(error).__name__).replace("\n", " ")


# --- contents of a file ----------------------------------------------------------------------------------------------


def _data(draft: WorkingProgram) -> dict[str, Any]:
    """Return a session as JSON data, with as many of its last versions as the limit allows."""
    before = _newest(draft.before, _MAX_HISTORY_LENGTH)
    after = _newest(draft.after, _MAX_HISTORY_LENGTH - sum(map(len, before)))
    return {
        "format": _FORMAT,
        "text": draft.text,
        "path": draft.path,
        "saved": draft.saved,
        "acceptance": list(draft.acceptance),
        "before": before,
        "after": after,
    }


def _newest(versions: Sequence[str], most: int) -> list[str]:
    """Return the last versions, which are the next to undo or redo, of at most ``most`` characters."""
    kept: list[str] = []
    for text in reversed(versions):
        most -= len(text)
        if most < 0:
            break
        kept.append(text)
    return kept[::-1]


def _read(path: Path, name: str) -> WorkingProgram:
    """Return the session of a file; raises ValueError, OSError or WrongArguments if it is none."""
    status = os.lstat(path)
    if not stat.S_ISREG(status.st_mode) or status.st_nlink > 1:
        raise ValueError("it is a link, a folder or a special file")
    if status.st_size > _MAX_BYTES:
        raise ValueError(f"it exceeds {_MAX_BYTES:,} bytes")
    try:
        data = json.loads(read_regular(path, _MAX_BYTES))
    except (ValueError, RecursionError):
        raise ValueError("it is no JSON") from None
    if not isinstance(data, dict) or data.get("format") != _FORMAT:
        raise ValueError(f"it is no session of format {_FORMAT}")
    saved = None if data.get("saved") is None else _text(data, "saved", MAX_PROGRAM_LENGTH)
    return WorkingProgram(
        name,
        _text(data, "text", MAX_PROGRAM_LENGTH),
        _project_path(_text(data, "path", _MAX_PATH_LENGTH)),
        saved,
        _texts(data, "before", MAX_UNDO, MAX_PROGRAM_LENGTH),
        _texts(data, "after", MAX_UNDO, MAX_PROGRAM_LENGTH),
        tuple(_texts(data, "acceptance", MAX_ACCEPTANCE, MAX_DECLARATION_LENGTH)),
    )


def _text(data: dict[str, Any], key: str, most: int) -> str:
    """Return a text of a file; raises ValueError if it is none, or too long."""
    value = data.get(key)
    if not isinstance(value, str) or len(value) > most:
        raise ValueError(f"`{key}` is no text of at most {most:,} characters")
    return value


def _texts(data: dict[str, Any], key: str, most: int, length: int) -> list[str]:
    """Return a list of texts of a file; raises ValueError if it is none, or too long."""
    values = data.get(key)
    if not isinstance(values, list) or len(values) > most:
        raise ValueError(f"`{key}` is no list of at most {most:,} texts")
    texts = [_text({key: value}, key, length) for value in values]
    if sum(map(len, texts)) > (math.inf if key == "acceptance" else _MAX_HISTORY_LENGTH):
        raise ValueError(f"`{key}` exceeds {_MAX_HISTORY_LENGTH:,} characters")
    return texts


def _project_path(path: str) -> str:
    """Return the path of a session's program; raises ValueError if it leads out of the project."""
    parts = Path(path).parts
    if "\0" in path or Path(path).is_absolute() or ".." in parts or any(part.startswith(".") for part in parts):
        raise ValueError("`path` is no file of the project")
    return path

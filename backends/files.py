"""Writing files whole or not at all, one alone or several together."""

from __future__ import annotations

import errno
import json
import os
import shutil
import stat
import sys
import tempfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any

from scenelang.grammar.diagnostics import SceneError

_NONBLOCK = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0)
_FOLDERS = {"CACHE": ".cache", "CONFIG": ".config", "STATE": ".local/state"}


def check_folder(output: Path) -> None:
    """Raises SceneError where ``output`` cannot be a file: before the work, so that typos are cheap."""
    if not output.parent.is_dir():
        raise SceneError("file", f"cannot write {output}: there is no folder {output.parent}")
    if output.is_dir():
        raise SceneError("file", f"cannot write {output}: it is a folder")


def user_folder(purpose: str) -> Path:
    """The user's folder of this program for ``purpose``, "CACHE", "CONFIG" or "STATE", which may not be there yet."""
    base = os.environ.get(f"XDG_{purpose}_HOME")
    return (Path(base) if base else Path.home() / _FOLDERS[purpose]) / "scenelang"


def made_folder(path: Path) -> Path:
    """A folder to write to, made where it is not there; raises SceneError("file")."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise SceneError("file", f"`{path}` cannot be a folder: {error.strerror or error}") from error
    return path


def read_regular(path: Path | str, most: int | None = None) -> bytes:
    """The bytes of a regular file, at most ``most`` of them. Raises OSError for anything else: a device has no end, and
    nobody may ever write to a pipe."""
    handle = os.open(path, os.O_RDONLY | _NONBLOCK)
    with open(handle, "rb") as file:
        mode = os.fstat(handle).st_mode
        if stat.S_ISDIR(mode):
            raise IsADirectoryError(errno.EISDIR, "it is a folder", str(path))
        if not stat.S_ISREG(mode):
            raise OSError(errno.EINVAL, "it is not a regular file", str(path))
        return file.read() if most is None else file.read(most)


@contextmanager
def alone_in(folder: Path) -> Iterator[None]:
    """While this lasts no other process is in such a block for the same folder, so that what is read, changed and
    written back loses no other change. Without effect where the system has no such locks, or there is no folder."""
    try:
        import fcntl

        handle = os.open(folder, os.O_RDONLY)
        fcntl.flock(handle, fcntl.LOCK_EX)
    except (ImportError, OSError):
        yield
        return
    try:
        yield
    finally:
        os.close(handle)


@contextmanager
def written_whole(path: Path | str, mode: int | None = None) -> Iterator[Path]:
    """A temporary path beside ``path`` with the same ending, moved onto it when the block ends well. ``mode``: the
    permissions of the file, by default those of any new file.

    On any error, Ctrl-C included, the temporary file is removed and ``path`` stays as it was. Raises
    SceneError("file") when the folder or the file cannot be written.
    """
    target = Path(path)
    try:
        _sweep(target.parent)
        handle, name = tempfile.mkstemp(suffix=target.suffix, prefix=_mark(), dir=target.parent)
    except OSError as error:
        raise SceneError("file", f"`{target}` cannot be written: {error.strerror or error}") from error
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        if mode is None:
            _give_usual_mode(temporary)
        else:
            temporary.chmod(mode)
        os.replace(temporary, target)
    except OSError as error:
        raise SceneError("file", f"`{target}` cannot be written: {error.strerror or error}") from error
    finally:
        temporary.unlink(missing_ok=True)


def _mark() -> str:
    """How the names of this process's temporary files begin: the machine and the process."""
    return f".scenelang-{_machine()}-{os.getpid()}-"


@cache
def _machine() -> str:
    return f"{zlib.crc32(os.uname().nodename.encode()):08x}" if hasattr(os, "uname") else "0"


def _sweep(folder: Path) -> None:
    """Remove what processes of this machine left in ``folder`` that were killed while they wrote."""
    for path in folder.glob(f".scenelang-{_machine()}-*"):
        process = path.name.split("-")[2]
        if not process.isdecimal() or _is_running(int(process)):
            continue
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:
            with suppress(OSError):
                path.unlink()


def _is_running(process: int) -> bool:
    if sys.platform == "win32":
        return True  # os.kill would end it
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True


def rewrite(path: Path, text: str) -> None:
    """Replace a file's text, whole or not at all; its permissions stay, a link still leads to it. Raises
    SceneError("file")."""
    target = path.resolve()
    if not os.access(target, os.W_OK):
        raise SceneError("file", f"`{path}` cannot be written: it is read-only")
    with written_whole(target, mode=stat.S_IMODE(target.stat().st_mode)) as temporary:
        temporary.write_bytes(text.encode("utf-8"))


def write_text(path: Path | str, text: str) -> None:
    """Write a text as UTF-8, whole or not at all; raises SceneError("file")."""
    with written_whole(path) as temporary:
        temporary.write_text(text, "utf-8")


def write_json(path: Path, data: Any) -> None:
    """Write ``data`` as JSON, whole or not at all; raises SceneError("file")."""
    write_text(path, json.dumps(data))


def _give_usual_mode(path: Path) -> None:
    """``mkstemp`` makes files private; give this one the mode that ``open`` would have."""
    mask = os.umask(0)
    os.umask(mask)
    path.chmod(0o666 & ~mask)


# --- several files ------------------------------------------------------------------------------------------------


@contextmanager
def written_together(folder: Path) -> Iterator[Path]:
    """A temporary folder inside ``folder``; the files made in it are moved to ``folder`` when the block ends well.

    On any error, Ctrl-C included, nothing in ``folder`` changes: files that were replaced come back. Raises
    SceneError("file") when the folder or a file cannot be written.
    """
    try:
        _sweep(folder)
        temporary = Path(tempfile.mkdtemp(prefix=_mark(), dir=folder))
    except OSError as error:
        raise SceneError("file", f"`{folder}` cannot be written: {error.strerror or error}") from error
    try:
        made = temporary / "made"
        made.mkdir()
        yield made
        _move_all(made, folder, temporary / "replaced")
    except OSError as error:
        name = Path(error.filename).name if error.filename else folder
        raise SceneError("file", f"`{name}` cannot be written: {error.strerror or error}") from error
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def _move_all(made: Path, folder: Path, kept: Path) -> None:
    """Move every file; what they replace is kept until all are moved, and comes back when one cannot be."""
    files = sorted(made.iterdir())
    for file in files:
        target = folder / file.name
        if target.is_dir():
            raise IsADirectoryError(21, "it is a folder", str(target))
    if len(files) == 1:
        os.replace(files[0], folder / files[0].name)
        return
    kept.mkdir()
    moved: list[Path] = []
    try:
        for file in files:
            target = folder / file.name
            if target.exists():
                _keep(target, kept / file.name)
            os.replace(file, target)
            moved.append(target)
    except BaseException:
        for target in moved:
            if (kept / target.name).exists():
                os.replace(kept / target.name, target)
            else:
                target.unlink(missing_ok=True)
        raise


def _keep(target: Path, copy: Path) -> None:
    """Another name for a file; a copy where the disk knows no such thing."""
    try:
        os.link(target, copy)
    except OSError:
        shutil.copy2(target, copy)

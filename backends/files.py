"""Files: atomic output, where several files are either written completely or not at all, and programs in folders."""

from __future__ import annotations

import errno
import os
import stat
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from typing import TYPE_CHECKING, Any

from scenelang.grammar.diagnostics import SceneError

if TYPE_CHECKING:
    from pathlib import Path

# Without O_NONBLOCK, opening a named pipe would block until another process writes to it.
_NONBLOCK = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0)


def reason_of(error: Exception) -> str:
    """Return the cause of a failed read or write, without the path, in at most 120 characters."""
    return str(getattr(error, "strerror", None) or error)[:120]


def check_folder(output: Path) -> None:
    """Check before the work starts that ``output`` can be a file; raises SceneError("file")."""
    if not os.path.isdir(output.parent):  # unlike Path.is_dir, false for a name that is too long
        is_file = os.path.exists(output.parent)
        reason = f"{output.parent} is not a folder" if is_file else f"the folder {output.parent} does not exist"
        hint = "name another folder" if is_file else f"create it: `mkdir -p {output.parent}`"
        raise SceneError("file", f"cannot write {output}: {reason}", hint)
    if os.path.isdir(output):
        raise SceneError("file", f"cannot write {output}: it is a directory")


def output_path(program: str, output: str | None, ending: str, is_generated: Callable[[Path], bool]) -> Path:
    """Return the path to write: ``output``, or by default that of ``program`` with another file extension.

    Raises SceneError("file") for a program from standard input, and if the default path exists and was not written by
    scenelang, which ``is_generated`` checks.
    """
    from pathlib import Path

    if output:
        return Path(output)
    if program == "-":
        raise SceneError("file", "a program from standard input needs `-o`", hint=f"add `-o out{ending}`")
    default = Path(program).with_suffix(ending)
    if default.exists() and not is_generated(default):
        message = f"`{default}` exists and was not written by scenelang"
        raise SceneError("file", message, hint=f"add `-o` with another name, or `-o {default}` to replace it")
    return default


def make_folder(path: Path) -> Path:
    """Create the directory ``path`` if necessary and return it; raises SceneError("file")."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise SceneError("file", f"cannot create the folder `{path}`: {error.strerror or error}") from error
    return path


@contextmanager
def new_folder(path: Path) -> Iterator[Path]:
    """Create a folder if necessary, and remove it afterwards if nothing was written to it.

    Raises SceneError("file").
    """
    created = [folder for folder in (path, *path.parents) if not os.path.lexists(folder)]
    try:
        yield make_folder(path)
    finally:
        with suppress(OSError):  # of the first that is not empty
            for folder in created:
                folder.rmdir()


def read_regular(path: Path | str, max_bytes: int | None = None) -> bytes:
    """Return at most ``max_bytes`` bytes of a regular file.

    Raises OSError for anything else: reading a device never ends, and reading a pipe may block forever.
    """
    handle = os.open(path, os.O_RDONLY | _NONBLOCK)
    with open(handle, "rb") as file:
        mode = os.fstat(handle).st_mode
        if stat.S_ISDIR(mode):
            raise IsADirectoryError(errno.EISDIR, "it is a directory", str(path))
        if not stat.S_ISREG(mode):
            raise OSError(errno.EINVAL, "it is not a regular file", str(path))
        return file.read() if max_bytes is None else file.read(max_bytes)


def read_program(path: Path, max_bytes: int) -> str:
    """Return the text of a regular file in UTF-8; raises SceneError("encoding"), and OSError as ``read_regular``."""
    try:
        return read_regular(path, max_bytes).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise SceneError("encoding", f"`{path}` is not valid UTF-8 at byte {error.start}") from error


@contextmanager
def lock_folder(folder: Path) -> Iterator[None]:
    """Hold an exclusive lock on ``folder``, so that concurrent read-modify-write cycles lose no changes.

    Does nothing if the system lacks ``flock`` or the directory does not exist.
    """
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
def atomic_write(path: Path | str, mode: int | None = None) -> Iterator[Path]:
    """Write ``path`` atomically: yield a temporary path in the same directory and rename it to ``path`` on success.

    On any error, Ctrl-C included, the temporary file is removed and ``path`` is unchanged. What a symbolic link leads
    to is written, and the link stays. ``mode`` is the permissions of the file, by default those of any new file. Raises
    SceneError("file") if the directory or the file cannot be written.
    """
    from pathlib import Path

    target = Path(os.path.realpath(path))  # a link stays
    check_replaceable(target)
    try:
        _sweep(target.parent)
        import tempfile

        handle, name = tempfile.mkstemp(suffix=Path(path).suffix, prefix=_temporary_prefix(), dir=target.parent)
    except OSError as error:
        raise _not_written(path, error) from error
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        if mode is None:
            _apply_default_mode(temporary)
        else:
            temporary.chmod(mode)
        os.replace(temporary, target)
    except OSError as error:
        raise _not_written(path, error) from error
    finally:
        temporary.unlink(missing_ok=True)


def check_replaceable(path: Path) -> None:
    """Raise SceneError("file") for a device or pipe: a file would take its place."""
    if path.exists() and not path.is_file() and not path.is_dir():
        raise SceneError("file", f"cannot write `{path}`: it is not a regular file")


def _not_written(path: Path | str, error: OSError) -> SceneError:
    return SceneError("file", f"cannot write `{path}`: {reason_of(error)}")


def _temporary_prefix() -> str:
    """Return the prefix of this process's temporary files; it identifies the machine and the process."""
    return f".scenelang-{_machine()}-{os.getpid()}-"


@cache
def _machine() -> str:
    from zlib import crc32

    return f"{crc32(os.uname().nodename.encode()):08x}" if hasattr(os, "uname") else "0"


def _sweep(folder: Path) -> None:
    """Remove temporary files in ``folder`` that killed processes of this machine left behind."""
    for path in folder.glob(f".scenelang-{_machine()}-*"):
        process = path.name.split("-")[2]
        if not process.isdecimal() or _is_running(int(process)):
            continue
        if path.is_dir():
            import shutil

            shutil.rmtree(path, ignore_errors=True)
        else:
            with suppress(OSError):
                path.unlink()


def _is_running(process: int) -> bool:
    """Return whether a process runs; True if that cannot be known."""
    from pathlib import Path

    if sys.platform == "win32":
        return True  # os.kill would terminate it
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    try:  # a zombie, which has ended but was not waited for, accepts signals
        return Path(f"/proc/{process}/stat").read_text("ascii", "replace").rpartition(")")[2].split()[0] != "Z"
    except (OSError, IndexError):
        return True


def rewrite(path: Path, text: str) -> None:
    """Replace the text of an existing file atomically; preserves its permissions and follows symbolic links.

    Raises SceneError("file").
    """
    target = path.resolve()
    if not os.access(target, os.W_OK):
        raise SceneError("file", f"cannot write `{path}`: the file is read-only")
    with atomic_write(target, mode=stat.S_IMODE(target.stat().st_mode)) as temporary:
        temporary.write_bytes(text.encode("utf-8"))


def write_text(path: Path | str, text: str) -> None:
    """Write ``text`` to a UTF-8 file atomically; raises SceneError("file")."""
    with atomic_write(path) as temporary:
        temporary.write_text(text, "utf-8")


def write_json(path: Path, data: Any) -> None:
    """Write ``data`` to a JSON file atomically; raises SceneError("file")."""
    import json

    write_text(path, json.dumps(data))


def _apply_default_mode(path: Path) -> None:
    """Give a file made by ``mkstemp``, which is private to the user, the permissions of a file made by ``open``."""
    mask = os.umask(0)  # there is no call that only reads the mask
    os.umask(mask)
    path.chmod(0o666 & ~mask)


# --- several files ------------------------------------------------------------------------------------------------


@contextmanager
def atomic_write_all(folder: Path, main: Path | None = None) -> Iterator[Path]:
    """Write several files atomically: yield a temporary directory whose files are moved to ``folder`` on success.

    On any error, Ctrl-C included, ``folder`` is unchanged: files that were already replaced are restored. ``main`` is
    the file that errors name if nothing can be written to ``folder``. Raises SceneError("file") if the directory or a
    file cannot be written.
    """
    with _temporary_folder(folder, main) as (staged, replaced):
        yield staged
        _move_all(staged, folder, replaced)


@contextmanager
def replaced_folder(path: Path) -> Iterator[Path]:
    """Write a folder as a whole: yield a temporary folder, which takes the place of ``path`` on success.

    On any error, Ctrl-C included, ``path`` is unchanged. Raises SceneError("file") if it cannot be written.
    """
    make_folder(path.parent)
    with _temporary_folder(path.parent, path) as (staged, replaced):
        yield staged
        try:
            if path.exists():
                path.rename(replaced)
            staged.rename(path)
        except BaseException as error:
            if replaced.exists() and not path.exists():
                replaced.rename(path)
            if isinstance(error, OSError):
                error.filename = str(path)  # not the temporary one
            raise


@contextmanager
def _temporary_folder(folder: Path, main: Path | None = None) -> Iterator[tuple[Path, Path]]:
    """Yield an empty folder in ``folder``, and a path beside it for what it replaces; both are removed afterwards."""

    import shutil
    import tempfile
    from pathlib import Path

    try:
        _sweep(folder)
        temporary = Path(tempfile.mkdtemp(prefix=_temporary_prefix(), dir=folder))
    except OSError as error:
        raise _not_written(main or folder, error) from error
    try:
        staged = temporary / "made"
        staged.mkdir()
        yield staged, temporary / "replaced"
    except OSError as error:
        raise _not_written(_meant(error, staged, folder), error) from error
    except SceneError as error:
        error.message = error.message.replace(str(staged), str(folder))
        raise
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def _meant(error: OSError, staged: Path, folder: Path) -> Path:
    """Return the path in ``folder`` of the file in ``staged`` that an error is about: the last, unless it is named."""
    from pathlib import Path

    written = sorted((path for path in staged.rglob("*") if path.is_file()), key=lambda file: file.stat().st_mtime_ns)
    path = Path(error.filename) if error.filename else [staged, *written][-1]
    return folder / path.relative_to(staged) if path.is_relative_to(staged) else path


def _move_all(staged: Path, folder: Path, backup: Path) -> None:
    """Move every file to ``folder``; if one fails, restore the files that were replaced."""
    from pathlib import Path

    files = sorted(staged.iterdir())
    targets = {file: Path(os.path.realpath(folder / file.name)) for file in files}  # links stay
    for target in targets.values():
        check_replaceable(target)
        if target.is_dir():
            raise IsADirectoryError(21, "it is a directory", str(target))
    if len(files) == 1:
        _replace(files[0], targets[files[0]])
        return
    backup.mkdir()
    moved: list[Path] = []
    try:
        for file in files:
            if targets[file].exists():
                _back_up(targets[file], backup / file.name)
            _replace(file, targets[file])
            moved.append(file)
    except BaseException:
        for file in moved:
            if (backup / file.name).exists():
                _replace(backup / file.name, targets[file])
            else:
                targets[file].unlink(missing_ok=True)
        raise


def _replace(file: Path, target: Path) -> None:
    """Move a file atomically, to another file system too, where a link may lead."""
    try:
        os.replace(file, target)
    except OSError as error:
        if error.errno != errno.EXDEV:
            raise
        import shutil

        with atomic_write(target) as temporary:
            shutil.copyfile(file, temporary)


def _back_up(target: Path, copy: Path) -> None:
    """Hard-link ``target`` as ``copy``, or copy it on file systems without hard links."""
    try:
        os.link(target, copy)
    except OSError:
        import shutil

        shutil.copy2(target, copy)


def program_files(names: Iterable[str]) -> list[str]:
    """Return the program files that are named or located in a named folder (.scene, not hidden), without duplicates."""
    by_real_path: dict[str, str] = {}
    for name in names:
        programs = [name]
        if name != "-" and os.path.isdir(name):
            from pathlib import Path

            programs = [str(path) for path in _programs(Path(name))] or [name]
        for program in programs:
            by_real_path.setdefault(program if program == "-" else os.path.realpath(program), program)
    return list(by_real_path.values())


def _programs(folder: Path) -> list[Path]:
    """Return the programs in a folder that are not hidden, sorted."""
    files = [path for path in folder.rglob("*.scene") if path.is_file()]
    return sorted(p for p in files if not any(part.startswith(".") for part in p.relative_to(folder).parts))

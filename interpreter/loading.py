"""What is loaded when it is needed: numpy, the entry points of installed packages, and files of the user's folders."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import suppress
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Any, NamedTuple

from scenelang.grammar.diagnostics import SceneError, missing_part

if TYPE_CHECKING:
    from pathlib import Path

_FOLDERS = {"CACHE": ".cache", "CONFIG": ".config", "STATE": ".local/state"}


def user_folder(purpose: str) -> Path:
    """Return the user's scenelang directory for ``purpose`` ("CACHE", "CONFIG" or "STATE"); it may not exist yet.

    Follows the XDG Base Directory Specification.
    """
    from pathlib import Path

    base = os.environ.get(f"XDG_{purpose}_HOME")
    return (Path(base) if base else Path.home() / _FOLDERS[purpose]) / "scenelang"


# --- arrays in the user's cache folder -------------------------------------------------------------------------------

MAX_CACHED_BYTES = 512 << 20  # of all files of a kind; those used longest ago are deleted first
_MAX_CACHED_FILE_BYTES = 256 << 20  # of one file: another program may have replaced it by any other


def read_cached(kind: str, name: str) -> dict[str, Any] | None:
    """Return arrays from the user's cache, or None if they are missing or cannot be read.

    Parameters
    ----------
    kind, name
        Folder within the cache and file, as for ``write_cached``.

    Returns
    -------
    dict of arrays
        The file may have been replaced by another program, so callers must check that these are what was stored.
    """
    import zipfile

    try:
        path = _cached(kind, name)
        if path.stat().st_size > _MAX_CACHED_FILE_BYTES:
            return None
        with np.load(path, allow_pickle=False) as file:
            arrays = {key: file[key] for key in file.files}
    except (OSError, RuntimeError, KeyError, ValueError, EOFError, AttributeError, zipfile.BadZipFile):
        return None
    with suppress(OSError):
        os.utime(path)
    return arrays


def write_cached(kind: str, name: str, arrays: Mapping[str, Any]) -> None:
    """Store arrays in the user's cache, unless a file of this name exists. Errors of the file system are ignored.

    Parameters
    ----------
    kind
        Folder within the cache. If its first part exceeds its size, the files that were used longest ago are deleted.
    name
        Name of the file.
    arrays
        Arrays by name.
    """

    import tempfile
    from pathlib import Path

    temporary = None
    with suppress(OSError, RuntimeError):
        path = _cached(kind, name)
        if path.exists():
            return
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=path.parent, suffix=".new", delete=False) as file:
            temporary = file.name
            np.savez(file, **arrays)
        os.replace(temporary, path)
        temporary = None
        _prune(user_folder("CACHE") / Path(kind).parts[0])
    if temporary is not None:
        with suppress(OSError):
            os.unlink(temporary)


def _cached(kind: str, name: str) -> Path:
    return user_folder("CACHE") / kind / f"{name}.npz"


def _prune(folder: Path) -> None:
    """Delete the files used longest ago while there are too many bytes."""
    files = sorted(((path.stat(), path) for path in folder.rglob("*.*")), key=lambda each: each[0].st_mtime)
    total = sum(stat.st_size for stat, _ in files)
    for stat, path in files:
        if total <= MAX_CACHED_BYTES:
            return
        path.unlink(missing_ok=True)
        total -= stat.st_size


# --- packages that add parts -----------------------------------------------------------------------------------------


def is_present(module: str) -> bool:
    """Return whether a module can be found; only the packages around it are imported."""
    from importlib.util import find_spec

    try:
        return find_spec(module) is not None
    except ModuleNotFoundError:  # a package around it
        return False


def require(package: str, install: str) -> Any:
    """Import and return a module that an extra provides.

    Parameters
    ----------
    package : str
        Name of the module.
    install : str
        Arguments of ``pip install`` that provide it, as the hint of the error shows them.

    Returns
    -------
    module
        The imported module.

    Raises
    ------
    SceneError
        "backend" if the package is missing or cannot be imported.

    Examples
    --------
    >>> require("json", "such-a-package").dumps([1])
    '[1]'
    """
    try:
        return import_module(package)
    except (ImportError, OSError) as error:  # OSError: one of its shared libraries fails to load
        raise SceneError(
            "backend",
            f"the package `{package}` cannot be imported: {error}",
            hint=f"install it with `pip install {install}`",
        ) from error


class EntryPoint(NamedTuple):
    """What an installed package names in a group: ``value`` is ``module:attribute``, perhaps with extras behind it."""

    name: str
    value: str

    def load(self) -> Any:
        """Import the module, and return the object; may raise whatever a package raises on import.

        A module of ours that this installation lacks is a ``MissingPart``.
        """
        module, _, attributes = self.value.partition("[")[0].strip().partition(":")
        try:
            loaded: Any = import_module(module.strip())
        except ModuleNotFoundError as error:
            part = missing_part(error)
            if part is None:
                raise
            raise part from error
        for attribute in attributes.strip().split(".") if attributes.strip() else ():
            loaded = getattr(loaded, attribute)
        return loaded


def entry_points_of(group: str) -> Mapping[str, EntryPoint]:
    """Return the entry points of ``group`` by name, without loading them; the first package on ``sys.path`` wins.

    Results are cached for each ``sys.path``; call ``forget`` to detect packages that were installed since.
    """
    return _points(group, tuple(sys.path))


@cache
def _points(group: str, path: tuple[str, ...]) -> Mapping[str, EntryPoint]:
    """Read the files directly: importing ``importlib.metadata`` takes longer than a small program does."""
    points: dict[str, EntryPoint] = {}
    for folder in path:
        for text in _entry_point_files(folder):
            if f"[{group}]" in text:
                for name, value in _entries(text, group):
                    points.setdefault(name, EntryPoint(name, value))
    return points


def _entries(text: str, group: str) -> Iterator[tuple[str, str]]:
    """Iterate over the names and values of one section of ``entry_points.txt``."""
    section = ""
    for line in map(str.strip, text.splitlines()):
        if line.startswith("[") and line.endswith("]"):
            section = line[1:-1].strip()
        elif section == group and "=" in line and line[0] not in "#;":
            name, _, value = line.partition("=")
            yield name.strip(), value.strip()


@cache
def _entry_point_files(folder: str) -> tuple[str, ...]:
    """Return the contents of ``entry_points.txt`` of all packages in ``folder``, by the names of the packages."""
    try:
        entries = sorted(entry.path for entry in os.scandir(folder or "."))
    except OSError:
        return ()
    metadata_folders = [path for path in entries if path.endswith((".dist-info", ".egg-info"))]
    return tuple(filter(None, (_text(os.path.join(path, "entry_points.txt")) for path in metadata_folders)))


def _text(path: str) -> str:
    try:
        with open(path, encoding="utf-8", errors="replace") as file:
            return file.read()
    except OSError:
        return ""


def forget() -> None:
    """Clear the caches, so that installed packages are detected again."""
    _entry_point_files.cache_clear()
    _points.cache_clear()


# Numpy, which the check of a program does not need.


__all__ = ["np"]

if TYPE_CHECKING:
    import numpy as np
else:

    class _Numpy:
        """Proxy of the numpy module that caches names on first use."""

        def __getattr__(self, name: str) -> Any:
            import numpy

            value = getattr(numpy, name)
            setattr(self, name, value)
            return value

    np = _Numpy()

"""Several files written together, all or none."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from scenelang.grammar.diagnostics import SceneError


@contextmanager
def written_together(folder: Path) -> Iterator[Path]:
    """A temporary folder inside ``folder``; the files made in it are moved to ``folder`` when the block ends well.

    On any error, Ctrl-C included, nothing in ``folder`` changes: files that were replaced come back. Raises
    SceneError("file") when the folder or a file cannot be written.
    """
    try:
        temporary = Path(tempfile.mkdtemp(prefix=".scenelang-", dir=folder))
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


def _move_all(made: Path, folder: Path, replaced: Path) -> None:
    """Move every file, what it replaces out of the way first; undo all of it when one cannot be moved."""
    replaced.mkdir()
    moved: list[Path] = []
    try:
        for file in sorted(made.iterdir()):
            target = folder / file.name
            if target.is_dir():
                raise IsADirectoryError(21, "it is a folder", str(target))
            if target.exists():
                os.replace(target, replaced / file.name)
            moved.append(target)
            os.replace(file, target)
    except BaseException:
        for target in moved:
            target.unlink(missing_ok=True)
            if (replaced / target.name).exists():
                os.replace(replaced / target.name, target)
        raise

"""Writing files whole or not at all."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from scenelang.grammar.diagnostics import SceneError


@contextmanager
def written_whole(path: Path | str) -> Iterator[Path]:
    """A temporary path beside ``path`` with the same ending, moved onto it when the block ends well.

    On any error, Ctrl-C included, the temporary file is removed and ``path`` stays as it was. Raises
    SceneError("file") when the folder or the file cannot be written.
    """
    target = Path(path)
    try:
        handle, name = tempfile.mkstemp(suffix=target.suffix, prefix=".scenelang-", dir=target.parent)
    except OSError as error:
        raise SceneError("file", f"`{target}` cannot be written: {error.strerror or error}") from error
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        _give_usual_mode(temporary)
        os.replace(temporary, target)
    except OSError as error:
        raise SceneError("file", f"`{target}` cannot be written: {error.strerror or error}") from error
    finally:
        temporary.unlink(missing_ok=True)


def write_json(path: Path, data: Any) -> None:
    """Write ``data`` as JSON, whole or not at all; raises SceneError("file")."""
    with written_whole(path) as temporary:
        temporary.write_text(json.dumps(data), "utf-8")


def _give_usual_mode(path: Path) -> None:
    """``mkstemp`` makes files private; give this one the mode that ``open`` would have."""
    mask = os.umask(0)
    os.umask(mask)
    path.chmod(0o666 & ~mask)

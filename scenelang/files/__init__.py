"""Files beside programs.

``zfile`` reads and writes embeddings, ``toml_places`` settings in TOML with the places of their values. Nothing here
evaluates.
"""

from __future__ import annotations

import os

TYPE_CHECKING = False
if TYPE_CHECKING:
    from pathlib import Path

_SUFFIX = ".z.safetensors"


def beside(program: str) -> Path:
    """Return the path of a program's embeddings file: ``chess.z.safetensors`` for ``chess.scene``."""
    from pathlib import Path

    return Path(_name_beside(program))


def existing_beside(program: str) -> Path | None:
    """Return the path of a program's embeddings file, or None if there is none."""
    return beside(program) if os.path.exists(_name_beside(program)) else None


def _name_beside(program: str) -> str:
    """Return the name of the embeddings file; without ``pathlib``, which costs a twentieth of ``check``."""
    name = program.rstrip("/")
    return os.path.splitext(name)[0] + _SUFFIX if os.path.basename(name) not in ("", ".") else f"{name}/{_SUFFIX}"

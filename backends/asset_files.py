"""Mesh files that programs place with the primitive "asset": found inside the project folder, and measured."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.shapes import Box


class AssetFiles:
    """Finds and measures the assets of a scene. ``folder`` is its file's own, ``project`` the one not to be left."""

    def __init__(self, folder: Path, project: Path, allow_outside: bool) -> None:
        self._folder = folder
        self._project = project
        self._allow_outside = allow_outside

    def measure(self, file: str) -> tuple[Box, str]:
        """The mesh's own box and its resolved path; raises SceneError when it cannot be read."""
        try:
            target = (self._folder / file).resolve()
        except (OSError, ValueError, RuntimeError):
            raise SceneError("file", f"`{file[:80]}` is no path") from None
        if not self._allow_outside and not target.is_relative_to(self._project):
            hint = "assets must lie in the project folder; --allow-outside lifts this"
            raise SceneError("import-outside", f"`{file[:80]}` leads out of {self._project}", hint)
        if not target.is_file():
            raise SceneError("file", f"there is no asset {file[:200]}")
        return _box(str(target), target.stat().st_mtime_ns), str(target)


@lru_cache(maxsize=256)
def _box(path: str, version: int) -> Box:
    """The box of a mesh file; ``version`` tells its states apart."""
    from scenelang.backends.assets import load_asset

    vertices = load_asset(path).vertices
    x0, y0, z0 = vertices.min(axis=0).tolist()
    x1, y1, z1 = vertices.max(axis=0).tolist()
    return (x0, y0, z0, x1, y1, z1)

"""Mesh files that programs place with the primitive "asset": found inside the project folder, and measured."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.shapes import Box


class AssetBoxes:
    """Measures the assets of one program. ``folder`` is the main file's, ``project`` the one that may not be left."""

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
            raise SceneError("import-outside", f"`{file}` leads out of {self._project}", hint)
        if not target.is_file():
            raise SceneError("file", f"there is no asset {file}")
        return _box(str(target), target.stat().st_mtime_ns), str(target)


@cache
def _box(path: str, version: int) -> Box:
    """The box of a mesh file; ``version`` tells its states apart."""
    from scenelang.backends.base import need

    trimesh = need("trimesh", "trimesh")
    try:
        bounds = trimesh.load(path, force="mesh").bounds
    except Exception as error:  # trimesh raises whatever its loaders meet
        raise SceneError("file", f"the asset {Path(path).name} cannot be read: {str(error)[:120]}") from None
    if bounds is None:
        raise SceneError("file", f"the asset {Path(path).name} holds no mesh")
    low, high = bounds.tolist()
    return (low[0], low[1], low[2], high[0], high[1], high[2])

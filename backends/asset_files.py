"""Mesh files that programs place with the primitive "asset": found inside the project folder, and measured."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from pathlib import Path

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.shapes import Asset


def _uncharged(work: int) -> None:
    """Nothing is counted outside an evaluation."""


class AssetFiles:
    """Finds and measures the assets of a scene. ``folder`` is its file's own, ``project`` the one not to be left, by
    assets and by what they refer to."""

    def __init__(self, folder: Path, project: Path, allow_outside: bool) -> None:
        self._folder = folder
        self._project = project
        self._allow_outside = allow_outside

    def measure(self, file: str, charge: Callable[[int], None] = _uncharged) -> Asset:
        """What is known of the mesh file ``file``; raises SceneError when it cannot be read. ``charge`` counts the
        work, before it is done where that is known, and raises LimitError where it is too much."""
        try:
            target = (self._folder / file).resolve()
        except (OSError, ValueError, RuntimeError):
            raise SceneError("file", f"`{file[:80]}` is no path") from None
        is_inside = target.is_relative_to(self._project)
        if not self._allow_outside and not is_inside:
            hint = "assets must lie in the project folder; --allow-outside lifts this"
            raise SceneError("import-outside", f"`{file[:80]}` leads out of {self._project}", hint)
        if not target.is_file():
            raise SceneError("file", f"there is no asset {file[:200]}")
        state = target.stat()
        charge(_CHECKED + (state.st_size >> 5))
        asset = _measured(str(target), str(self._project if is_inside else target.parent), state.st_mtime_ns)
        charge(_CHECKED + (len(asset.support) >> 3))
        return asset


_CHECKED = 4096  # steps, after which a meter looks at the clock


@lru_cache(maxsize=64)
def _measured(path: str, root: str, version: int) -> Asset:
    """What is known of a mesh file; ``version`` tells its states apart."""
    import numpy as np

    from scenelang.backends.assets import load_asset
    from scenelang.backends.support import PointSupport

    mesh = load_asset(path, root)
    points = mesh.vertices[np.unique(mesh.faces)]
    x0, y0, z0 = points.min(axis=0).tolist()
    x1, y1, z1 = points.max(axis=0).tolist()
    return Asset(path, root, (x0, y0, z0, x1, y1, z1), PointSupport(points))

"""Scenes as images, labels, exports and splats draw them: with cubes in place of Minecraft blocks."""

from __future__ import annotations

from collections.abc import Callable

from scenelang.grammar.diagnostics import Diagnostic
from scenelang.interpreter.plugins import SERVICES
from scenelang.interpreter.scene.entity import Scene, descendants


def drawn_scene(scene: Scene, limit: int = 2_000_000, warn: Callable[[Diagnostic], None] | None = None) -> Scene:
    """Return ``scene`` with its blocks as cubes and everything else unchanged; the scene itself if it has no blocks.

    Meshes and solids need no stand-in: their triangles are part of their shape. Blocks do, since the model of a block
    depends on its neighbors (a fence post connects to the next one); ``backends/minecraft/models`` computes it.

    Parameters
    ----------
    limit : int
        Maximum number of primitives and of cubes.
    warn : callable, optional
        Called with a warning for each block that is replaced by another.

    Raises
    ------
    SceneError
        "blocks" for poses that blocks do not support, "attribute" for invalid blocks, "backend" without the Minecraft
        backend.
    LimitError
        For more than ``limit`` primitives or cubes, or too many cells.
    """
    if not any(entity.is_block for entity in descendants(*scene.frames)):
        return scene
    cubes: Scene = SERVICES.find("block-cubes")(scene, limit, warn)
    return cubes

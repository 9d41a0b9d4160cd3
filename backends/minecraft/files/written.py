"""What a file of a build is made of."""

from __future__ import annotations

from scenelang.backends.minecraft.blocks import Build
from scenelang.backends.minecraft.files.history import fitted
from scenelang.backends.minecraft.files.versions import GameVersion
from scenelang.grammar.diagnostics import SceneError


def with_blocks(build: Build) -> Build:
    """``build``; raises SceneError("empty-scene") where it holds no block, for which files have no place."""
    if len(build.palette) < 2 or not build.cells.size:
        raise SceneError("empty-scene", "the scene lays no blocks, so there is nothing to write")
    return build


def as_written(build: Build, version: GameVersion) -> Build:
    """``build`` in the blocks of ``version``; raises SceneError("empty-scene") where that has none of them."""
    return with_blocks(fitted(build, version).build)

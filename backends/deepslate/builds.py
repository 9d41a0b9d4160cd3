"""The builds of a scene's frames, as the page draws them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from scenelang.backends.deepslate.visible import Seen, seen
from scenelang.backends.minecraft.blocks import AIR_STATE, BlockState, Build
from scenelang.backends.minecraft.settle import settled
from scenelang.backends.minecraft.voxels import voxelised
from scenelang.grammar.diagnostics import Diagnostic, LimitError, SceneError
from scenelang.interpreter.entity import Entity

MOST_IN_ALL = 8_000_000  # blocks that can be seen, in all frames


@dataclass(frozen=True, slots=True, eq=False)
class Builds:
    """``frames[n]``: what is seen of frame ``n``, in cells from ``corner``, its states numbered as in ``palette``.
    ``warnings``: what was replaced or left out."""

    frames: Mapping[int, Seen]
    corner: tuple[int, int, int]
    palette: tuple[BlockState, ...]
    warnings: tuple[Diagnostic, ...]

    @property
    def box(self) -> tuple[list[int], list[int]]:
        """The low and high corner of what is seen in any frame, in cells from ``corner``."""
        cells = [seen.cells for seen in self.frames.values() if len(seen.states)]
        low = np.min([each.min(axis=1) for each in cells], axis=0)
        high = np.max([each.max(axis=1) for each in cells], axis=0) + 1
        return low.tolist(), high.tolist()


def builds_of(roots: Mapping[int, Entity], limit: int) -> Builds:
    """The builds of frames by number; entities that frames share are laid once.

    Raises SceneError where there are no blocks, or they cannot be laid, and LimitError.
    """
    palette: dict[BlockState, int] = {AIR_STATE: 0}
    warnings: dict[str, Diagnostic] = {}
    done: dict[int, Seen] = {}
    frames: dict[int, Seen] = {}
    corner: tuple[int, int, int] | None = None
    for number, root in roots.items():
        if id(root) not in done:
            whole = settled(voxelised(root, limit))
            build = whole.build
            warnings |= {warning.message: warning for warning in whole.warnings}
            if corner is None and len(build.palette) > 1:
                corner = build.origin
            done[id(root)] = _renumbered(seen(build, corner or build.origin), build, palette)
            _check(sum(len(each.states) for each in done.values()))
        frames[number] = done[id(root)]
    if corner is None:
        raise SceneError(
            "empty-scene",
            "the scene lays no blocks, so there is nothing to show with the game's looks",
            hint="lay blocks with `set-cuboid`, or draw the scene with another backend",
        )
    return Builds(frames, corner, tuple(palette), tuple(warnings.values()))


def _renumbered(found: Seen, build: Build, palette: dict[BlockState, int]) -> Seen:
    numbers = np.array([palette.setdefault(state, len(palette)) for state in build.palette], np.uint32)
    return replace(found, states=numbers[found.states])


def _check(count: int) -> None:
    if count > MOST_IN_ALL:
        raise LimitError(
            "size",
            f"more than {MOST_IN_ALL:,} blocks can be seen in all frames, more than one page may show",
            hint="show fewer frames or a part of the scene",
        )

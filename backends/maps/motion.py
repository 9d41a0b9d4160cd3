"""4D: where what each pixel shows is in other frames, and the ways of tracked points.

Entities of two frames correspond when they share a path, the child positions from the root. A point of one goes where
the same place in its own frame is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenelang.backends.maps.truth import Truth, into_local
from scenelang.interpreter.ancestry import Ancestry

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

GONE, HIDDEN, VISIBLE = 0, 1, 2  # where a point is in another frame: nowhere, covered or out of view, in view
_TOLERANCE = 2e-3  # of the distance, by which a point may lie behind what is seen


class PathNumbers:
    """Numbers for paths of child positions, the same in all frames of a film."""

    def __init__(self) -> None:
        self._numbers: dict[tuple[int, int], int] = {}

    def of(self, ancestry: Ancestry) -> IntArray:
        """The path number (M,) of every instance; the root's is 0."""
        out = np.zeros(len(ancestry), np.int64)
        for depth in range(1, ancestry.deepest + 1):
            rows = np.flatnonzero(ancestry.depth == depth)
            above, position = out[ancestry.parent[rows]].tolist(), ancestry.position[rows].tolist()
            table = self._numbers
            out[rows] = [table.setdefault(key, len(table) + 1) for key in zip(above, position, strict=True)]
        return out


@dataclass(frozen=True, slots=True, eq=False)
class Places:
    """What N points are stuck to: path numbers (N,) and places in the primitives' own frames (N, 3)."""

    path: IntArray
    local: FloatArray


def places_of(truth: Truth, paths: IntArray, pixels: IntArray) -> Places:
    """The places that the flat ``pixels`` (N,) of a shot show, all of them of something. ``paths`` are its instances'
    path numbers."""
    instance = truth.instance.reshape(-1)[pixels]
    used, inverse = np.unique(instance, return_inverse=True)
    local = into_local(truth.position.reshape(-1, 3)[pixels], truth.ancestry.poses[used], inverse)
    return Places(paths[instance], local)


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """Where N points are in a frame: ``pixels`` (N, 2) from the top left corner, ``world`` (N, 3), both nan where they
    are not, and ``state`` (N,), GONE, HIDDEN or VISIBLE."""

    pixels: FloatArray
    world: FloatArray
    state: npt.NDArray[np.uint8]


def found_in(places: Places, truth: Truth, paths: IntArray) -> Found:
    """Where ``places`` are in the frame of ``truth``, whose instances have the numbers ``paths`` (M,)."""
    leaves = truth.ancestry.primitives
    order = np.argsort(paths[leaves], kind="stable")
    known = paths[leaves][order]
    slot = np.searchsorted(known, places.path)
    slot = np.minimum(slot, max(0, len(known) - 1))
    exists = known[slot] == places.path if len(known) else np.zeros(len(places.path), bool)
    world = np.full((len(places.path), 3), np.nan)
    at = np.flatnonzero(exists)
    poses = truth.ancestry.poses[leaves[order[slot[at]]]]
    world[at] = np.einsum("nij,nj->ni", poses[:, :, :3], places.local[at]) + poses[:, :, 3]
    pixels, depth = truth.camera.project(np.nan_to_num(world))
    pixels[~exists] = np.nan
    state = np.where(exists, HIDDEN, GONE).astype(np.uint8)
    column, row = np.floor(np.nan_to_num(pixels, nan=-1.0)).astype(np.int64).T
    inside = exists & (column >= 0) & (row >= 0) & (column < truth.camera.width) & (row < truth.camera.height)
    inside &= depth > 0.0
    rows = np.flatnonzero(inside)
    # a pixel's depth is that of its middle: what slopes is compared with the nearest and farthest around it
    farthest = _farthest_around(truth.depth)[row[rows], column[rows]]
    state[rows[depth[rows] <= farthest * (1.0 + _TOLERANCE)]] = VISIBLE
    return Found(pixels, world, state)


def _farthest_around(depth: FloatArray) -> FloatArray:
    """The greatest finite depth (H, W) among each pixel and its four neighbours."""
    finite = np.where(np.isfinite(depth), depth, -np.inf)
    padded = np.pad(finite, 1, constant_values=-np.inf)
    around = [padded[1:-1, 1:-1], padded[:-2, 1:-1], padded[2:, 1:-1], padded[1:-1, :-2], padded[1:-1, 2:]]
    return np.asarray(np.max(around, axis=0), np.float64)


@dataclass(frozen=True, slots=True, eq=False)
class Flow:
    """For every pixel (H, W) of a frame: ``motion`` (H, W, 2) in pixels to where it is in the next frame, nan where it
    is not, ``world`` (H, W, 3) the motion in the world, ``state`` (H, W)."""

    motion: npt.NDArray[np.float32]
    world: npt.NDArray[np.float32]
    state: npt.NDArray[np.uint8]


def flow_between(here: Truth, there: Truth, paths_here: IntArray, paths_there: IntArray) -> Flow:
    """The dense correspondence from one frame to another."""
    height, width = here.instance.shape
    pixels = np.flatnonzero(here.seen)
    found = found_in(places_of(here, paths_here, pixels), there, paths_there)
    row, column = np.divmod(pixels, width)
    motion, world = np.full((height * width, 2), np.nan, np.float32), np.full((height * width, 3), np.nan, np.float32)
    state = np.full(height * width, GONE, np.uint8)
    motion[pixels] = found.pixels - np.stack([column + 0.5, row + 0.5], axis=1)
    world[pixels] = found.world - here.position.reshape(-1, 3)[pixels]
    state[pixels] = found.state
    return Flow(motion.reshape(height, width, 2), world.reshape(height, width, 3), state.reshape(height, width))


@dataclass(frozen=True, slots=True, eq=False)
class Tracks:
    """The ways of N points through F frames: ``pixels`` (F, N, 2), ``world`` (F, N, 3), ``state`` (F, N)."""

    pixels: FloatArray
    world: FloatArray
    state: npt.NDArray[np.uint8]


def start_places(truth: Truth, paths: IntArray, count: int, seed: int) -> Places:
    """``count`` places that a frame shows, spread over what is seen, the same for the same ``seed``."""
    pixels = np.flatnonzero(truth.seen)
    random = np.random.default_rng(seed)
    chosen = random.choice(pixels, size=min(count, len(pixels)), replace=False) if len(pixels) else pixels
    return places_of(truth, paths, np.sort(chosen))


def tracks_of(found: Sequence[Found]) -> Tracks:
    """The ways of points that were found in one frame after the other."""
    return Tracks(
        np.stack([one.pixels for one in found]),
        np.stack([one.world for one in found]),
        np.stack([one.state for one in found]),
    )

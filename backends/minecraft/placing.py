"""Where cuboids of blocks stand: whole cells from the poses of primitives, or what is wrong with these."""

from __future__ import annotations

import numpy as np

from scenelang.backends.minecraft.asked import place_of
from scenelang.backends.minecraft.blocks import AIR
from scenelang.backends.minecraft.painting import BoolArray, FloatArray, IntArray, Laid
from scenelang.backends.minecraft.repeats import FARTHEST
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.entity import Entity
from scenelang.interpreter.flatten import FlatFrame

_NEAR = 1e-9  # cells: what sums of poses may be off
_SLACK = 1e-6  # cells: what multiplied poses may be off


def first_cells(flat: FlatFrame) -> IntArray:
    """The first cell of each instance (N, 3): its position, truncated toward zero. What rounding of floats left beside
    a whole number is that number."""
    position = flat.matrices[:, :, 3]
    whole = np.rint(position)
    first: IntArray = np.where(np.abs(position - whole) < _NEAR, whole, np.trunc(position)).astype(np.int64)
    return first


def off_cells(flat: FlatFrame) -> tuple[int, list[float], int] | None:
    """How many instances stand between cells where truncation does not move all alike, so that distances change, the
    position (3,) of the first of them, and its number; None where it moves all alike."""
    position = flat.matrices[:, :, 3]
    if not len(position):
        return None
    moved = position - first_cells(flat)
    unlike = (np.abs(moved - moved[0]) > _NEAR).any(axis=1)
    if not unlike.any():
        return None
    apart = (np.abs(moved) > _NEAR).any(axis=1)
    first = int(np.argmax(apart))
    return int(apart.sum()), position[first].tolist(), first


def whole_sizes(flat: FlatFrame) -> IntArray:
    """The cells of each instance along each axis (N, 3); raises SceneError("blocks") for the first pose that blocks
    cannot have."""
    own = np.array([_own_size(p) for p in flat.primitives], np.float64).reshape(-1, 3)
    linear, position = flat.matrices[:, :, :3], flat.matrices[:, :, 3]
    along = np.diagonal(linear, axis1=1, axis2=2)
    across = np.abs(linear * (1.0 - np.eye(3))).max(axis=(1, 2), initial=0.0)
    with np.errstate(invalid="ignore", over="ignore"):
        size = along * own[flat.index]
        whole = np.rint(size)
        far = np.asarray(~((np.abs(position) < FARTHEST).all(axis=1) & (size < FARTHEST).all(axis=1)))
        leans = across > _SLACK * np.maximum(np.abs(along).max(axis=1, initial=0.0), _SLACK)
        turned: BoolArray = ~far & (leans | (along < 0.0).any(axis=1))
        broken = ~far & (
            (np.abs(size - whole) > np.clip(_SLACK * whole, _SLACK, 0.01)) | ((whole == 0) & (size > 0))
        ).any(axis=1)
    wrong = far | turned | broken
    if wrong.any():
        i = int(np.argmax(wrong))
        raise _misplaced(flat, i, "far" if far[i] else "turned" if turned[i] else "broken", size[i])
    return whole.astype(np.int64)


def _own_size(primitive: Entity) -> tuple[float, float, float]:
    assert primitive.shape is not None
    return primitive.shape.size


def _misplaced(flat: FlatFrame, i: int, reason: str, size: FloatArray) -> SceneError:
    entity = flat.primitives[int(flat.index[i])]
    path = " > ".join((*flat.paths[int(flat.path_index[i])], entity.word))
    shown = " x ".join(f"{n:.6g}" for n in size)
    problem, hint = {
        "far": ("stands farther from the origin than cells can be counted", None),
        "turned": (
            "is turned, mirrored or sheared, which blocks cannot be",
            "compose blocks with `translate` and whole `scale` only; stairs and logs turn with `:block-kwargs`",
        ),
        "broken": (f"is {shown} cells large, and blocks fill whole cells", "scale blocks by whole numbers"),
    }[reason]
    return SceneError("blocks", f'"{entity.word}" at {path} {problem}', hint=hint, span=place_of(entity))


def cells_around(laid: Laid, most_cells: int) -> tuple[IntArray, tuple[int, ...]]:
    """The first cell (3,) and the size of the box around all that is laid; raises LimitError for too many cells."""
    lays = ((laid.number != AIR) | (laid.stamp >= 0)) & (laid.high > laid.low).all(axis=1)
    if not lays.any():
        return np.zeros(3, np.int64), (0, 0, 0)
    low, high = laid.low[lays].min(axis=0), laid.high[lays].max(axis=0)
    size = tuple((high - low).tolist())
    if size[0] * size[1] * size[2] > most_cells:
        shown = " x ".join(f"{n:,}" for n in size)
        raise LimitError(
            "size",
            f"the build's box is {shown} cells, more than the {most_cells:,} that one build may have",
            hint="bring its parts nearer to one another, or lay smaller cuboids",
        )
    return low, size

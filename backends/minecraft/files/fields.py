"""What the compounds of a file hold, each field of the kind that it must be."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.minecraft.files.damage import Damaged
from scenelang.backends.minecraft.voxels import MOST_CELLS

Triple = tuple[int, int, int]
_FARTHEST = 1 << 31  # cells from the origin: what a file's ints can say


def compound(tag: Mapping[str, Any], name: str) -> dict[str, Any]:
    """The compound called ``name``; raises Damaged."""
    found = tag.get(name)
    if not isinstance(found, dict):
        raise Damaged(f"it has no compound `{name}`")
    return found


def whole(tag: Mapping[str, Any], name: str) -> int:
    """The integer called ``name``; raises Damaged."""
    found = tag.get(name)
    if not isinstance(found, int):
        raise Damaged(f"it has no integer `{name}`")
    return found


def array(tag: Mapping[str, Any], name: str, bits: int) -> npt.NDArray[Any]:
    """The array of integers of ``bits`` bits called ``name``; raises Damaged."""
    found = tag.get(name)
    if not isinstance(found, np.ndarray) or found.dtype.kind != "i" or found.dtype.itemsize * 8 != bits:
        raise Damaged(f"it has no array `{name}` of numbers of {bits} bits")
    return found


def listed(tag: Mapping[str, Any], name: str) -> list[Any]:
    """The list of compounds or lists called ``name``; raises Damaged."""
    found = tag.get(name)
    if not isinstance(found, list):
        raise Damaged(f"it has no list `{name}`")
    return found


def how_many(tag: Mapping[str, Any], *names: str) -> int:
    """The items of all lists of these names that there are."""
    return sum(len(found) for name in names if isinstance(found := tag.get(name), list))


def triple_of_array(tag: Mapping[str, Any], name: str) -> Triple:
    """The three ints of the array or list called ``name``; raises Damaged."""
    found = array(tag, name, 32)
    if len(found) != 3:
        raise Damaged(f"`{name}` is not three numbers")
    x, y, z = found.tolist()
    return x, y, z


def triple_of_compound(tag: Mapping[str, Any], name: str) -> Triple:
    """The ints ``x``, ``y`` and ``z`` of the compound called ``name``; raises Damaged."""
    found = compound(tag, name)
    x, y, z = (whole(found, axis) for axis in "xyz")
    if any(not -_FARTHEST <= n < _FARTHEST for n in (x, y, z)):
        raise Damaged(f"`{name}` is farther away than a block can be")
    return x, y, z


def checked_size(size: Triple) -> Triple:
    """``size``, cells along each axis; raises Damaged where a build cannot be so large."""
    x, y, z = size
    if min(size) < 0 or x * y * z > MOST_CELLS or max(size) > MOST_CELLS:
        shown = " x ".join(f"{n:,}" for n in size)
        raise Damaged(f"its box is {shown} cells, and a build may have {MOST_CELLS:,}")
    return size

"""The leaves of a scene where they stand in the world: what formats without a hierarchy are made of."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenelang.backends.appearance import Look, look_of
from scenelang.backends.exports.export import unsupported_frames
from scenelang.backends.exports.items import Item, Plan, distinct
from scenelang.backends.exports.merging import MOST_VERTICES, merged, segments_for
from scenelang.backends.exports.surfaces import Surface, surface_of
from scenelang.backends.studio import to_srgb
from scenelang.grammar.diagnostics import LimitError
from scenelang.interpreter import pose
from scenelang.interpreter.entity import primitive_count
from scenelang.interpreter.values import IDENTITY, Matrix

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """One leaf: the words from the root down to it, its look, its ``surface`` in the world. Where the surface has
    colours, these are the whole colour; else the look's is."""

    path: tuple[str, ...]
    look: Look
    surface: Surface

    def srgb(self) -> npt.NDArray[np.uint8]:
        """The colour of every vertex (V, 4), sRGB-encoded, with the opacity: what files of 8 bits hold."""
        linear = self.surface.colors if self.surface.colors is not None else np.array([self.look.color])
        out = np.full((len(self.surface.vertices), 4), round(255 * self.look.opacity), np.uint8)
        out[:, :3] = np.rint(255.0 * to_srgb(np.clip(linear, 0.0, 1.0)))
        return out


@dataclass(frozen=True, slots=True)
class Leaf:
    """An item that is a mesh, its world pose, and the words down to it."""

    item: Item
    pose: Matrix
    path: tuple[str, ...]


def leaves(plan: Plan, limit: int) -> Iterator[Leaf]:
    """The leaves of the only frame in depth-first order. Raises LimitError for more than ``limit``."""
    count = _leaf_count(plan.roots[0])
    if count > limit:
        raise LimitError(
            "primitives",
            f"the scene expands to {count:,} primitives, more than the limit of {limit:,}",
            hint="raise it with --max-primitives, or choose .glb or .usd, which share what is repeated",
        )
    stack = [Leaf(plan.roots[0], IDENTITY, (plan.roots[0].word,))]
    while stack:
        leaf = stack.pop()
        if leaf.item.is_leaf:
            yield leaf
        for child, place in reversed(leaf.item.parts):
            stack.append(Leaf(child, pose.compose(leaf.pose, place), (*leaf.path, child.word)))


def _leaf_count(root: Item) -> int:
    """How many leaves there are, worked out without expanding them."""
    counts: dict[int, int] = {}
    for item in distinct(root):  # children first
        counts[id(item)] = item.is_leaf + sum(counts[id(child)] for child, _ in item.parts)
    return counts[id(root)]


def placed(plan: Plan, limit: int, ending: str) -> Iterator[Placed]:
    """Every visible leaf with its triangles, one patch of one material after the other.

    Round primitives have fewer sides where the file would be too large; raises LimitError where that is not enough.
    """
    unsupported_frames(plan.roots, ending)
    found = list(leaves(plan, min(limit, MOST_VERTICES)))
    hint = "choose .glb or .usd, which share what is repeated"
    total = sum(primitive_count(leaf.item.entity) for leaf in found)
    if total > limit:
        raise LimitError("primitives", f"the scene expands to {total:,} primitives, over the limit of {limit:,}", hint)
    segments = segments_for([leaf.item.entity for leaf in found], f"the {ending} file", hint)
    patches: dict[int, Sequence[tuple[Look, Surface]]] = {}
    for leaf in found:
        if id(leaf.item) not in patches:
            patches[id(leaf.item)] = _patches(leaf.item, segments)
        for look, surface in patches[id(leaf.item)]:
            yield Placed(leaf.path, look, surface.under(np.array(leaf.pose).reshape(1, 3, 4)))


def _patches(item: Item, segments: int) -> Sequence[tuple[Look, Surface]]:
    if item.merged:
        return [(patch.look, patch.surface) for patch in merged(item.entity, segments)]
    look = look_of(item.entity)
    surface = None if look.opacity == 0.0 else surface_of(item.entity, segments)
    if surface is None:
        return []
    if surface.colors is not None:
        surface = Surface(surface.vertices, surface.normals, surface.faces, surface.colors * np.array(look.color))
    return [(look, surface)]

"""What is learned for a scene: one set of Gaussians for all leaves of the same sentence and shape of box, and where
each leaf stands in every frame.

The Gaussians of a figure live in a frame of their own, in which the leaf's box is centred and its half sizes have the
norm 1. The pose of a leaf takes that to the world: in the paper's words the primitive is normalised, and leaves with
equal ``z`` and equal ``S_t / ||S_t||`` share ``theta``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenelang.backends.clip.conditions import Condition
from scenelang.backends.clip.leaves import Leaf
from scenelang.interpreter.entity import Entity

FloatArray = npt.NDArray[np.float64]

_ALIKE = 1e-3  # boxes whose half sizes differ by less are equal
_THINNEST = 1e-3  # of the largest half size: a flat thing is as thick


@dataclass(frozen=True, slots=True, eq=False)
class Figure:
    """What some leaves have in common: the sentence, the half sizes ``box`` (3,) of norm 1, and the entity that the
    first of them is, which ``local`` (3, 4) takes to the figure's frame."""

    condition: Condition
    box: FloatArray
    entity: Entity
    local: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Actor:
    """One leaf over time: which figure it is, and for each of F frames where that stands: ``poses`` (F, 3, 4) from the
    figure's frame to the world, and whether it is there, ``shown`` (F,)."""

    figure: int
    name: str
    handle: str
    poses: FloatArray
    shown: npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Cast:
    """All figures of a scene of ``frames`` frames, and who plays them."""

    figures: tuple[Figure, ...]
    actors: tuple[Actor, ...]
    frames: int


def cast_of(frames: Sequence[Sequence[Leaf]]) -> Cast:
    """The cast of a scene from the leaves of its frames; those at the same path under the same word are one over
    time, as the paper's 4D scenes have them."""
    over_time: dict[tuple[tuple[int, ...], str], dict[int, Leaf]] = {}
    for number, leaves in enumerate(frames):
        for leaf in leaves:
            over_time.setdefault((leaf.path, leaf.entity.word), {})[number] = leaf
    figures: list[Figure] = []
    known: dict[object, int] = {}
    actors = []
    for seen in over_time.values():
        first = next(iter(seen.values()))
        box, local = _normalised(first)
        key = (first.condition.prompt, tuple(np.round(box / _ALIKE).astype(int).tolist()))
        if key not in known:
            known[key] = len(figures)
            figures.append(Figure(first.condition, box, first.entity, local))
        actors.append(_actor(known[key], figures[known[key]].box, seen, len(frames)))
    return Cast(tuple(figures), tuple(actors), len(frames))


def _actor(figure: int, box: FloatArray, seen: dict[int, Leaf], frames: int) -> Actor:
    poses = np.zeros((frames, 3, 4))
    for number, leaf in seen.items():
        center, half = _center_and_half(leaf)
        poses[number, :, :3] = leaf.pose[:, :3] * (half / box)
        poses[number, :, 3] = leaf.pose[:, :3] @ center + leaf.pose[:, 3]
    first = next(iter(seen.values()))
    shown = np.array([number in seen for number in range(frames)])
    return Actor(figure, first.name, first.handle, poses, shown)


def _center_and_half(leaf: Leaf) -> tuple[FloatArray, FloatArray]:
    """The middle and the half sizes (3,) of a leaf's box in its own frame, no side thinner than can be drawn."""
    low, high = np.array(leaf.box[:3]), np.array(leaf.box[3:])
    half = (high - low) / 2.0
    return (low + high) / 2.0, np.maximum(half, _THINNEST * max(float(half.max()), 1e-9))


def _normalised(leaf: Leaf) -> tuple[FloatArray, FloatArray]:
    """The box of norm 1 as the world sees it, unturned; and what takes the leaf's own frame to the figure's."""
    center, half = _center_and_half(leaf)
    sizes = np.linalg.norm(leaf.pose[:, :3] * half, axis=0)
    box = np.maximum(sizes, _THINNEST * max(float(sizes.max()), 1e-9))
    box = box / np.linalg.norm(box)
    scale = box / half
    return box, np.hstack([np.diag(scale), (-scale * center)[:, None]])

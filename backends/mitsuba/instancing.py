"""What is drawn once and placed many times: a cut through the entity DAG, and the solids that stand alone.

Mitsuba has one level of instancing and no lamps inside instances. So each way from the root to a primitive is cut
once: below the cut lie prototypes, shared entities whose solids become one group of shapes, above it their instances.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenelang.backends.appearance import look_of
from scenelang.backends.assets import load_asset
from scenelang.backends.solids import Solids, composed, normalized, solids_of
from scenelang.backends.stage import Staging
from scenelang.interpreter.entity import Entity, descendants, instance_counts
from scenelang.interpreter.flatten import flatten_entity
from scenelang.interpreter.shapes import Kind

FloatArray = npt.NDArray[np.float64]

FEW = 20_000


@dataclass(frozen=True, slots=True, eq=False)
class Prototype:
    """``solids`` of one shared entity, in its own frame brought to a good size, and where it stands: ``matrices``
    (N, 3, 4) into the stage's frame. ``entity`` is what it was made of."""

    entity: Entity
    solids: Solids
    matrices: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Parts:
    """A frame as prototypes, and the ``loose`` solids in the stage's frame that are no part of one."""

    prototypes: tuple[Prototype, ...]
    loose: Solids


@dataclass(frozen=True, slots=True, eq=False)
class _Counts:
    """Of every distinct entity by ``id``: solids below it, instances of it, whether it may be a prototype."""

    order: tuple[Entity, ...]  # children before parents
    solids: dict[int, int]
    instances: dict[int, int]
    allowed: dict[int, bool]


def parts_of(staging: Staging, frame: int) -> Parts | None:
    """Frame number ``frame`` of a staging as prototypes and loose solids, None where hardly anything is shared."""
    root = staging.roots[frame]
    cut = _best_cut(root, _counted(root))
    if not cut:
        return None
    flat = flatten_entity(root, cut)
    is_cut = np.array([id(entity) in cut for entity in flat.primitives], bool)
    prototypes = []
    index = np.asarray(flat.index)
    for number in np.flatnonzero(is_cut):
        found = _prototype(staging, flat.primitives[number], flat.matrices[index == number])
        if found is not None:
            prototypes.append(found)
    loose = flat.only(~is_cut[index])
    return Parts(tuple(prototypes), normalized(solids_of(loose), staging.center, staging.scale))


def _prototype(staging: Staging, entity: Entity, matrices: FloatArray) -> Prototype | None:
    """The prototype that ``entity`` is under world ``matrices`` (N, 3, 4), None where nothing of it can be drawn."""
    solids = solids_of(flatten_entity(entity))
    if not len(solids):
        return None
    reach = np.abs(solids.matrices[:, :, :3]).sum(axis=2)
    low, high = (solids.matrices[:, :, 3] - reach).min(axis=0), (solids.matrices[:, :, 3] + reach).max(axis=0)
    middle, half = (low + high) / 2.0, 0.5 * float(np.linalg.norm(high - low))
    size = half if half > 1e-300 else 1.0
    own = normalized(solids, middle, 1.0 / size)
    outward = np.concatenate([np.eye(3) * size, middle[:, None]], axis=1)
    to_stage = np.concatenate([np.eye(3) * staging.scale, (-staging.center * staging.scale)[:, None]], axis=1)
    placed = composed(composed(to_stage[None], matrices), outward[None])
    sound = np.isfinite(placed).all(axis=(1, 2)) & (np.abs(np.linalg.det(placed[:, :, :3])) > 1e-30)
    return Prototype(entity, own, placed[sound]) if len(own) and sound.any() else None


def _counted(root: Entity) -> _Counts:
    order = tuple(descendants(root))
    solids: dict[int, int] = {}
    allowed: dict[int, bool] = {}
    for entity in order:
        below = [id(part.car) for part in entity.children]
        solids[id(entity)] = _solids_in(entity) + sum(solids[child] for child in below)
        own = not (entity.is_primitive and any(look_of(entity).emission))  # lamps cannot be instanced
        allowed[id(entity)] = own and all(allowed[child] for child in below)
    return _Counts(order, solids, instance_counts(order), allowed)


def _solids_in(entity: Entity) -> int:
    """How many solids a primitive is: one, but as many as it has triangles for a mesh file."""
    if entity.shape is not None and entity.shape.kind is Kind.ASSET and entity.shape.file is not None:
        return len(load_asset(entity.shape.file, entity.shape.root).faces)
    return int(entity.is_primitive)


def _best_cut(root: Entity, counts: _Counts) -> frozenset[int]:
    """The ids of the prototypes: entities of at most so many solids that few shapes are stored in all."""
    largest = counts.solids[id(root)]
    distinct = sum(counts.solids[id(entity)] for entity in counts.order if entity.is_primitive)
    if 2 * distinct > largest:
        return frozenset()
    sizes = sorted({1 << k for k in range(largest.bit_length())} | set(_sample(sorted(set(counts.solids.values())))))
    best: tuple[int, frozenset[int]] = (largest, frozenset())
    for size in sizes:
        cut, stored = _cut_below(root, counts, size)
        if stored < best[0]:
            best = (stored, cut)
    return best[1]


def _sample(values: Sequence[int]) -> Sequence[int]:
    return values[:: max(1, len(values) // 32)]


def _cut_below(root: Entity, counts: _Counts, size: int) -> tuple[frozenset[int], int]:
    """The cut at entities of at most ``size`` solids, and how many shapes it stores: solids and instances."""
    cut: set[int] = set()
    stored = 0
    opened = {id(root)}
    for entity in reversed(counts.order):  # parents before children
        if id(entity) not in opened:
            continue
        for part in entity.children:
            child = id(part.car)
            if not counts.solids[child]:
                continue
            shared = counts.allowed[child] and counts.instances[child] > 1
            if shared and counts.solids[child] <= size:
                if child not in cut:
                    cut.add(child)
                    stored += counts.solids[child]
                stored += counts.instances[id(entity)]
            elif part.car.is_primitive:
                stored += counts.instances[id(entity)]
            else:
                opened.add(child)
    return frozenset(cut), stored

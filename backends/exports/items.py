"""Export plan: the entity DAG, with some entities marked to be merged into one mesh.

An ``ExportItem`` is a distinct entity in one role. ``--depth N`` marks the entities at level N (the root is level 0),
so that each becomes one part; ``--instance-limit`` marks repeated small subtrees, so that a strict tree of nodes stays
small (``cut_below``). Items are shared like entities.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass

from scenelang.backends.base import frame_of
from scenelang.backends.minecraft.models import as_cubes
from scenelang.backends.pictures.appearance import check_seen
from scenelang.grammar.diagnostics import Diagnostic, LimitError, SceneError
from scenelang.interpreter.runtime.values import Matrix
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.entity import Entity, Scene, descendants

MAX_NODES = 1_000_000  # of a strict tree
_MAX_COORDINATE = 1e30  # limit for single precision, with a margin for products


@dataclass(frozen=True, slots=True, eq=False)
class ExportItem:
    """An entity to export; ``parts`` are pairs of item and pose. ``merged``: the whole subtree becomes one mesh."""

    entity: Entity
    parts: tuple[tuple[ExportItem, Matrix], ...] = ()
    merged: bool = False

    @property
    def word(self) -> str:
        return self.entity.word

    @property
    def is_leaf(self) -> bool:
        """Whether the item is a single mesh."""
        return self.merged or self.entity.is_primitive


@dataclass(frozen=True, slots=True, eq=False)
class ExportPlan:
    """The items of every exported frame; ``animated`` if they are the frames of a 4D scene."""

    word: str
    roots: tuple[ExportItem, ...]
    animated: bool


def planned(
    scene: Scene,
    frame: int | None = None,
    depth: int | None = None,
    limit: int = 2_000_000,
    warn: Callable[[Diagnostic], None] | None = None,
) -> ExportPlan:
    """Return the export plan of ``scene`` with blocks converted to cubes.

    Parameters
    ----------
    frame : int, optional
        Zero-based; by default all frames.
    depth : int, optional
        Level at which entities are merged; by default none.
    limit, warn
        As for ``as_cubes``.

    Raises
    ------
    SceneError
        "value" if the frame does not exist, "empty-scene" if nothing has geometry, "pose" if coordinates are too large.
    """
    scene = as_cubes(chosen(scene, frame), limit, warn)
    heights = _heights(scene.frames)
    cut = {id(root): math.inf if depth is None else depth for root in scene.frames}
    items = _Items(heights)
    roots = tuple(items.of(root, cut[id(root)]) for root in scene.frames)
    return ExportPlan(scene.word, roots, len(roots) > 1)


def chosen(scene: Scene, frame: int | None) -> Scene:
    """Return ``scene``, or its single frame ``frame``, if it can be exported; raises SceneError as ``planned`` does."""
    roots = scene.frames if frame is None else (scene.frames[frame_of(scene, frame)],)
    boxes = [box for box in map(entity_box, roots) if box is not None]
    if not boxes:
        raise SceneError("empty-scene", f'the scene "{scene.word}" has no primitives, so there is nothing to export')
    if not all(abs(number) < _MAX_COORDINATE for box in boxes for number in box):
        raise SceneError("pose", "pose overflow: coordinates exceed the range of single precision")
    check_seen(scene)
    return Scene(scene.word, roots, scene.animated and frame is None)


class _Items:
    """Creates items, one for each distinct entity and number of remaining levels above the cut."""

    def __init__(self, heights: Mapping[int, int]) -> None:
        self._heights = heights
        self._made: dict[tuple[int, float], ExportItem] = {}

    def of(self, root: Entity, levels: float) -> ExportItem:
        """Return the item of ``root`` with its descendants ``levels`` below it merged; no recursion."""
        stack = [(root, levels)]
        while stack:
            entity, left = stack[-1]
            key = self._key(entity, left)
            if key in self._made:
                stack.pop()
                continue
            waiting = [] if left <= 0 else self._missing(entity, left - 1)
            if waiting:
                stack.extend(waiting)
                continue
            stack.pop()
            self._made[key] = self._item(entity, left)
        return self._made[self._key(root, levels)]

    def _key(self, entity: Entity, left: float) -> tuple[int, float]:
        return id(entity), (left if left < self._heights[id(entity)] else math.inf)

    def _missing(self, entity: Entity, left: float) -> list[tuple[Entity, float]]:
        found = {self._key(part.car, left): part.car for part in entity.children}
        return [(child, left) for key, child in found.items() if key not in self._made]

    def _item(self, entity: Entity, left: float) -> ExportItem:
        if left <= 0 and entity.children:
            return ExportItem(entity, merged=True)
        parts = tuple((self._made[self._key(part.car, left - 1)], part.cdr) for part in entity.children)
        return ExportItem(entity, parts)


def _heights(roots: Iterable[Entity]) -> dict[int, int]:
    """Return the number of levels below each distinct entity, 0 for a leaf."""
    heights: dict[int, int] = {}
    for entity in descendants(*roots):
        heights[id(entity)] = 1 + max((heights[id(part.car)] for part in entity.children), default=-1)
    return heights


# --- items as a DAG --------------------------------------------------------------------------------------------


def distinct(*roots: ExportItem) -> Iterator[ExportItem]:
    """Yield every distinct item below and including ``roots``, children before parents."""
    seen: set[int] = set()
    for root in roots:
        stack = [(root, iter(root.parts))] if id(root) not in seen else []
        seen.add(id(root))
        while stack:
            item, parts = stack[-1]
            for child, _ in parts:
                if id(child) not in seen:
                    seen.add(id(child))
                    stack.append((child, iter(child.parts)))
                    break
            else:
                stack.pop()
                yield item


def sizes(roots: Sequence[ExportItem]) -> dict[int, int]:
    """Return the number of instances below and including each distinct item."""
    counts: dict[int, int] = {}
    for item in distinct(*roots):
        counts[id(item)] = 1 + sum(counts[id(child)] for child, _ in item.parts)
    return counts


def cut_below(plan: ExportPlan, limit: int) -> ExportPlan:
    """Merge the smallest repeated subtrees of ``plan`` so that every frame has at most ``limit`` nodes.

    All subtrees of at most T instances that occur in several places are merged, with the smallest sufficient power of
    two T, so that merged parts are small and the hierarchy above them is preserved. Subtrees that occur once are not
    merged, which would make the file larger. Raises LimitError if more than ``MAX_NODES`` remain.
    """
    counts = sizes(plan.roots)
    most = max(counts[id(root)] for root in plan.roots)
    if most <= limit:
        return plan
    repeated = _repeated(plan.roots)
    threshold = 2
    while _nodes(plan.roots, counts, repeated, threshold) > limit and threshold < most:
        threshold *= 2
    nodes = _nodes(plan.roots, counts, repeated, threshold)
    if nodes > max(limit, MAX_NODES):
        raise LimitError(
            "primitives",
            f"the scene needs {nodes:,} nodes, more than the limit of {MAX_NODES:,} for a file",
            hint="merge parts with --depth N, or write .usd",
        )
    return _merged_below(plan, counts, repeated, threshold)


def _repeated(roots: Sequence[ExportItem]) -> set[int]:
    """Return the ids of the items that occur in several places of one frame."""
    found: set[int] = set()
    for root in {id(root): root for root in roots}.values():
        order = list(distinct(root))
        places = dict.fromkeys((id(item) for item in order), 0)
        places[id(root)] = 1
        for item in reversed(order):
            for child, _ in item.parts:
                places[id(child)] += places[id(item)]
        found.update(key for key, count in places.items() if count > 1)
    return found


def _nodes(roots: Sequence[ExportItem], counts: Mapping[int, int], repeated: Set[int], threshold: int) -> int:
    """Return the number of nodes of the largest frame if repeated subtrees of at most ``threshold`` instances are
    merged."""
    nodes: dict[int, int] = {}
    for item in distinct(*roots):
        is_one = counts[id(item)] <= threshold and id(item) in repeated
        nodes[id(item)] = 1 if is_one else 1 + sum(nodes[id(child)] for child, _ in item.parts)
    return max(nodes[id(root)] for root in roots)


def _merged_below(plan: ExportPlan, counts: Mapping[int, int], repeated: Set[int], threshold: int) -> ExportPlan:
    made: dict[int, ExportItem] = {}
    for item in distinct(*plan.roots):
        if item.is_leaf or not item.parts:
            made[id(item)] = item
        elif counts[id(item)] <= threshold and id(item) in repeated:
            made[id(item)] = ExportItem(item.entity, merged=True)
        else:
            made[id(item)] = ExportItem(item.entity, tuple((made[id(child)], pose) for child, pose in item.parts))
    return ExportPlan(plan.word, tuple(made[id(root)] for root in plan.roots), plan.animated)

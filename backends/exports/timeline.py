"""The frames of a 4D scene matched: entities with the same path (child positions from the root) are one thing over
time. Where the word at a path changes, each word is a thing of its own, there in the frames that have it."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass, field

from scenelang.backends.appearance import look_of
from scenelang.backends.exports.items import Item
from scenelang.backends.exports.surfaces import solid_of
from scenelang.grammar.diagnostics import LimitError
from scenelang.interpreter.values import IDENTITY, Matrix

MOST_MOVING = 1_000_000  # items of all frames that are no longer shared between them


@dataclass(frozen=True, slots=True, eq=False)
class Moving:
    """One path over F frames. ``items`` and ``poses`` are None in frames without it. ``fixed`` is its item where that
    never changes: then nothing below it does, and ``children`` is empty."""

    word: str
    items: tuple[Item | None, ...]
    poses: tuple[Matrix | None, ...]
    fixed: Item | None
    children: list[Moving] = field(default_factory=list)

    @property
    def first(self) -> Item:
        """The item in the first frame that has it."""
        return next(item for item in self.items if item is not None)

    @property
    def shown(self) -> tuple[bool, ...]:
        """In which frames it is there."""
        return tuple(item is not None for item in self.items)

    @property
    def is_still(self) -> bool:
        """True when it is in all frames, under one pose."""
        return None not in self.items and len(set(self.poses)) == 1

    def filled_poses(self) -> tuple[Matrix, ...]:
        """A pose for every frame: that of the frame before where it is not there."""
        found = next(pose for pose in self.poses if pose is not None)
        filled = []
        for pose in self.poses:
            found = pose if pose is not None else found
            filled.append(found)
        return tuple(filled)


def matched(roots: Sequence[Item]) -> Moving:
    """The roots of all frames as one thing over time; raises LimitError when too much of it changes."""
    top = _moving(roots[0].word, list(roots), [IDENTITY] * len(roots))
    waiting = [top]
    room = MOST_MOVING
    while waiting:
        moving = waiting.pop()
        if moving.fixed is not None:
            continue
        moving.children.extend(_children(moving))
        room -= sum(len(item.parts) for item in moving.items if item is not None)
        if room < 0:
            raise LimitError(
                "primitives",
                f"more than {MOST_MOVING:,} entities change over the frames, too many for an animation",
                hint="export a still with --frame N, or merge what moves together with --depth N",
            )
        waiting.extend(moving.children)
    return top


def _moving(word: str, items: Sequence[Item | None], poses: Sequence[Matrix | None]) -> Moving:
    kinds = {id(item): item for item in items if item is not None}
    fixed = next(iter(kinds.values())) if len(kinds) == 1 else None
    return Moving(word, tuple(items), tuple(poses), fixed)


def _children(moving: Moving) -> Iterator[Moving]:
    """What is at each child position, one for each word that is ever there."""
    frames = len(moving.items)
    most = max(len(item.parts) for item in moving.items if item is not None)
    for position in range(most):
        words: dict[str, tuple[list[Item | None], list[Matrix | None]]] = {}
        for frame, item in enumerate(moving.items):
            if item is None or position >= len(item.parts):
                continue
            child, pose = item.parts[position]
            items, poses = words.setdefault(child.word, ([None] * frames, [None] * frames))
            items[frame], poses[frame] = child, pose
        for word, (items, poses) in words.items():
            yield _moving(word, items, poses)


def variants(moving: Moving) -> list[tuple[Item, tuple[bool, ...]]]:
    """The meshes that the thing itself is over time, and in which frames each is."""
    found: dict[Hashable, tuple[Item, list[bool]]] = {}
    for frame, item in enumerate(moving.items):
        if item is None or not item.is_leaf:
            continue
        _, shown = found.setdefault(leaf_key(item), (item, [False] * len(moving.items)))
        shown[frame] = True
    return [(item, tuple(shown)) for item, shown in found.values()]


def leaf_key(item: Item) -> Hashable:
    """What the mesh of a leaf depends on."""
    solid = None if item.merged else solid_of(item.entity)
    return ("merged", id(item.entity)) if solid is None else (solid.key, look_of(item.entity))

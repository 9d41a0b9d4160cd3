"""The hierarchy of a scene as glTF nodes, named by words, and its frames as an animation.

Every instance of an entity is a node whose ``extras`` say what it is. A primitive's node takes its canonical solid (a
unit cube, ball, cylinder or cone, which all of one look share) to its place, so its pose is the entity's times the
solid's. A pose that shears has a child node ``word/shear``; what is not there in all frames a child ``word/shown``,
whose scale is 0 or 1; a primitive whose look changes a child ``word/1``, ``word/2``, ... for each.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from scenelang.backends.appearance import look_of
from scenelang.backends.exports.facts import facts_of, merged_facts
from scenelang.backends.exports.gltf_document import Document
from scenelang.backends.exports.gltf_tracks import Tracks
from scenelang.backends.exports.items import Item, distinct
from scenelang.backends.exports.surfaces import Solid, solid_of
from scenelang.backends.exports.timeline import Moving, variants
from scenelang.backends.exports.turns import node_fields, track_of, turns_of
from scenelang.interpreter import pose
from scenelang.interpreter.values import IDENTITY, Matrix

Node = dict[str, Any]


@dataclass(slots=True)
class Nodes:
    """Adds nodes to ``document``; remembers what poses, primitives and extras become."""

    document: Document
    _poses: dict[Matrix, list[Node]] = field(default_factory=dict)
    _solids: dict[int, Solid | None] = field(default_factory=dict)
    _extras: dict[int, Node] = field(default_factory=dict)

    # --- what does not move ---

    def prepare(self, items: Iterable[Item]) -> None:
        """Decompose all poses below ``items`` at once, which is much faster than one by one."""
        found = {self.placed(child, place) for item in distinct(*items) for child, place in item.parts}
        fresh = [place for place in found if place not in self._poses]
        for start in range(0, len(fresh), 1 << 16):
            block = fresh[start : start + (1 << 16)]
            turns = turns_of(np.array(block).reshape(-1, 3, 4))
            for index, place in enumerate(block):
                self._poses[place] = node_fields(turns, index)

    def add_still(self, root: Item, place: Matrix, siblings: list[int] | None) -> None:
        """One node for each instance below and including ``root``, without recursion."""
        waiting: list[tuple[Item, Matrix, list[int] | None]] = [(root, place, siblings)]
        while waiting:
            item, local, siblings = waiting.pop()
            node = self._add_posed(item.word, self._fields(self.placed(item, local)), self.extras(item), siblings)
            self._fill(node, item)
            if item.parts:
                children: list[int] = []
                node["children"] = children
                waiting.extend((child, pose_, children) for child, pose_ in reversed(item.parts))

    def placed(self, item: Item, local: Matrix) -> Matrix:
        """The pose of the item's node: a primitive's solid has its own."""
        solid = self.solid(item)
        return local if solid is None or solid.pose is IDENTITY else pose.compose(local, solid.pose)

    def solid(self, item: Item) -> Solid | None:
        """The solid of a primitive, None of all else."""
        key = id(item.entity)
        if key not in self._solids:
            self._solids[key] = None if item.merged else solid_of(item.entity)
        return self._solids[key]

    def extras(self, item: Item) -> Node:
        """What the node says of its entity."""
        if id(item) not in self._extras:
            self._extras[id(item)] = merged_facts(item.entity) if item.merged else facts_of(item.entity)
        return self._extras[id(item)]

    def _fields(self, place: Matrix) -> list[Node]:
        if place not in self._poses:
            self._poses[place] = node_fields(turns_of(np.array(place).reshape(1, 3, 4)), 0)
        return self._poses[place]

    def _add_posed(self, word: str, fields: Sequence[Node], extras: Node | None, siblings: list[int] | None) -> Node:
        """A node, and a child where the pose shears; the innermost, which holds what is posed."""
        outer, *inner = fields
        node = {"name": word, **outer} | ({"extras": extras} if extras else {})
        self._append(node, siblings)
        for more in inner:
            node = self._add_inner(f"{word}/shear", more, node)
        return node

    def _append(self, node: Node, siblings: list[int] | None) -> int:
        if siblings is not None:
            siblings.append(len(self.document.nodes))
        self.document.nodes.append(node)
        return len(self.document.nodes) - 1

    def _add_inner(self, name: str, fields: Node, outer: Node) -> Node:
        node = {"name": name, **fields}
        outer["children"] = [self._append(node, None)]
        return node

    def _fill(self, node: Node, item: Item) -> None:
        """Give the node the mesh of its item, where it has one."""
        mesh = self.mesh(item)
        if mesh is not None:
            node["mesh"] = mesh

    def mesh(self, item: Item) -> int | None:
        """The number of the item's mesh."""
        if item.merged:
            return self.document.merged_mesh(item.entity)
        solid = self.solid(item)
        return None if solid is None else self.document.solid_mesh(item.word, solid, look_of(item.entity))

    # --- what moves ---

    def add_moving(self, root: Moving, tracks: Tracks) -> None:
        """One node for each path over all frames, with a track for what changes."""
        waiting: list[tuple[Moving, list[int] | None]] = [(root, None)]
        while waiting:
            moving, siblings = waiting.pop()
            if moving.fixed is not None and moving.is_still:
                self.add_still(moving.fixed, moving.poses[0] or IDENTITY, siblings)
                continue
            children: list[int] = []
            self._add_changing(moving, siblings, tracks, children)
            if moving.fixed is not None:
                for child, place in moving.fixed.parts:
                    self.add_still(child, place, children)
            waiting.extend((child, children) for child in reversed(moving.children))

    def _add_changing(self, moving: Moving, siblings: list[int] | None, tracks: Tracks, children: list[int]) -> None:
        kinds = variants(moving)
        one = len(kinds) == 1 and not moving.children
        places = list(moving.filled_poses())
        if one:
            items = _filled(moving.items)
            places = [self.placed(item, place) for item, place in zip(items, places, strict=True)]
        node = self._add_track(moving.word, places, moving.shown, self.extras(moving.first), siblings, tracks)
        if one:
            self._fill(node, kinds[0][0])
        elif kinds:
            self._add_variants(moving, kinds, children, tracks)
        if children or moving.children or (moving.fixed is not None and moving.fixed.parts):
            node["children"] = children

    def _add_variants(
        self,
        moving: Moving,
        kinds: Sequence[tuple[Item, tuple[bool, ...]]],
        children: list[int],
        tracks: Tracks,
    ) -> None:
        """A child for each mesh that the thing ever is, seen in its frames only."""
        for number, (item, shown) in enumerate(kinds, start=1):
            mine = [other if seen else None for other, seen in zip(moving.items, shown, strict=True)]
            places = [self.placed(other, IDENTITY) for other in _filled(mine)]
            node = self._add_track(f"{moving.word}/{number}", places, shown, None, children, tracks)
            self._fill(node, item)

    def _add_track(
        self,
        name: str,
        places: Sequence[Matrix],
        shown: tuple[bool, ...],
        extras: Node | None,
        siblings: list[int] | None,
        tracks: Tracks,
    ) -> Node:
        """A node under one pose a frame, seen in the frames ``shown``; the innermost, which holds what is posed."""
        still = len(set(places)) == 1
        turns = None if still else track_of(np.array(places).reshape(-1, 3, 4))
        fields = self._fields(places[0]) if turns is None else node_fields(turns, 0)
        number = len(self.document.nodes)
        node = self._add_posed(name, fields, extras, siblings)
        if turns is not None:
            tracks.add(number, "translation", turns.translation)
            tracks.add(number, "rotation", turns.rotation)
            tracks.add(number, "scale", turns.scale)
            if turns.shears[0]:
                tracks.add(number + 1, "rotation", turns.inner)
        if not all(shown):
            first = {} if shown[0] else {"scale": [0.0, 0.0, 0.0]}
            node = self._add_inner(f"{name}/shown", first, node)
            tracks.add(len(self.document.nodes) - 1, "scale", np.repeat(np.array(shown, float)[:, None], 3, 1), True)
        return node


def _filled(items: Sequence[Item | None]) -> list[Item]:
    """An item for every frame: that of the frame before where there is none."""
    found = next(item for item in items if item is not None)
    filled = []
    for item in items:
        found = item if item is not None else found
        filled.append(found)
    return filled

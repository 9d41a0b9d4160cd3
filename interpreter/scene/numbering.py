"""The numbers of embeddings: a view of the scene, made when asked for (docs/language.md, section 4, "Z and numbers").

A counter runs over the expanded graph in depth-first pre-order. An instance whose embedding has a handle takes no
number; each other takes the next one that is no handle anywhere in the scene. In a 4D scene corresponding entities
(equal child positions from the root) share a number, and paths that appear later are numbered after.
"""

from __future__ import annotations

import re
from bisect import bisect_left
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from scenelang.interpreter.runtime.runtime import Runtime, ZEntry
from scenelang.interpreter.runtime.values import Embedding, Pair
from scenelang.interpreter.scene.entity import Entity, Scene, descendants
from scenelang.interpreter.scene.flatten import FlatFrame, FlatScene, Graph, Level, Paths, graph_of, levels

if TYPE_CHECKING:
    import numpy.typing as npt

    IntArray = npt.NDArray[np.int64]


# Every instance of every entity of a scene, numbered, and the way from each primitive up to the root.


@dataclass(frozen=True, slots=True, eq=False)
class Ancestry:
    """The M instances that are primitives or have primitives below them, level by level from the root, number 0.

    ``nodes[node[i]]`` is the entity of instance i, ``parent[i]`` its parent (-1 for the root), ``position[i]`` its
    place among the parent's children, ``depth[i]`` how far it is from the root, ``poses[i]`` (3, 4) where it stands in
    the world. ``primitives[k]`` (N,) is the instance that the k-th primitive of the flattened frame is.
    """

    nodes: tuple[Entity, ...]
    node: IntArray  # (M,)
    parent: IntArray  # (M,)
    position: IntArray  # (M,)
    depth: IntArray  # (M,)
    poses: npt.NDArray[np.float64]  # (M, 3, 4)
    primitives: IntArray  # (N,)

    def __len__(self) -> int:
        return len(self.node)

    @property
    def deepest(self) -> int:
        return int(self.depth.max())

    def entity(self, instance: int) -> Entity:
        return self.nodes[int(self.node[instance])]

    def at_depth(self, depth: int) -> IntArray:
        """For every instance (M,) its ancestor at ``depth``; itself where it stands higher than that."""
        found = np.arange(len(self))
        while True:
            deeper = np.flatnonzero(self.depth[found] > depth)
            if not len(deeper):
                return found
            found[deeper] = self.parent[found[deeper]]

    def path(self, instance: int) -> tuple[int, ...]:
        """The child positions from the root to an instance."""
        found: list[int] = []
        while self.parent[instance] >= 0:
            found.append(int(self.position[instance]))
            instance = int(self.parent[instance])
        return tuple(reversed(found))


def ancestry_of(root: Entity) -> Ancestry:
    """Number every instance below and including ``root``. The caller has checked the number of primitives."""
    graph = graph_of(root, frozenset())
    is_leaf = np.array([entity.is_primitive for entity in graph.nodes])
    found = list(levels(graph, is_leaf, Paths(graph.nodes)))
    return _joined(graph, found)


def _joined(graph: Graph, found: list[tuple[Level, Level]]) -> Ancestry:
    """The levels one after the other, at each depth the opened instances before the leaves."""
    node, parent, position, depth, poses = [], [], [], [], []
    primitives = np.zeros(int(graph.leaves[-1]), np.int64)
    above, start = 0, 0  # where the opened instances of the level above begin, and this level
    for number, (leaves, inner) in enumerate(found):
        primitives[leaves.offset] = start + len(inner.node) + np.arange(len(leaves.node))
        for part in (inner, leaves):
            node.append(part.node)
            parent.append(part.parent + above if number else np.full(len(part.node), -1, np.int64))
            position.append(part.position)
            depth.append(np.full(len(part.node), number, np.int64))
            poses.append(part.pose.T.reshape(-1, 3, 4))
        above, start = start, start + len(inner.node) + len(leaves.node)
    return Ancestry(
        tuple(graph.nodes),
        np.concatenate(node),
        np.concatenate(parent),
        np.concatenate(position),
        np.concatenate(depth),
        np.concatenate(poses),
        primitives,
    )


_NUMBERED = re.compile(r"z([1-9]\d{0,17})\Z")
Path = tuple[int, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Numbering:
    """``taken`` are the numbers that handles in the scene use; ``unhandled`` counts instances below each node."""

    scene: Scene
    taken: tuple[int, ...]
    unhandled: dict[int, int]

    def number(self, rank: int) -> int:
        """The number of the instance that is the ``rank``-th (from 1) without a handle."""
        free_before = [k - 1 - i for i, k in enumerate(self.taken)]
        return rank + bisect_left(free_before, rank)

    def rank(self, number: int) -> int | None:
        """The inverse of ``number``; None for a number that a handle in the scene uses."""
        position = bisect_left(self.taken, number)
        if position < len(self.taken) and self.taken[position] == number:
            return None
        return number - position

    def children(self, entity: Entity, rank: int) -> Iterator[tuple[Any, int]]:
        """The parts of an instance with ``rank`` unhandled instances before it, each with its own such count."""
        before = rank + (entity.embedding.handle is None)
        for part in entity.children:
            yield part, before
            before += self.unhandled[id(part.car)]

    def handle(self, entity: Entity, before: int) -> str:
        """The handle of an instance: its embedding's own, or its number's."""
        return entity.embedding.handle or f"z{self.number(before + 1)}"

    def path(self, number: int) -> Path | None:
        """The child positions from the root to the instance with an automatic number, in the first frame."""
        rank = self.rank(number)
        if rank is None or not 1 <= rank <= self.unhandled[id(self.scene.root)]:
            return None
        entity, before, path = self.scene.root, 0, []
        while not (entity.embedding.handle is None and before + 1 == rank):
            for position, (part, count) in enumerate(self.children(entity, before)):
                if count < rank <= count + self.unhandled[id(part.car)]:
                    path.append(position)
                    entity, before = part.car, count
                    break
        return tuple(path)


def first_handles(scene: Scene, frame: int) -> dict[int, str]:
    """The handle of the first instance of every distinct entity of one frame, by ``id``: its own or its number's.

    Exact for static scenes; numbers of a later frame of a 4D scene count as if it stood alone.
    """
    root = scene.frames[frame]
    alone = scene if len(scene.frames) == 1 else Scene(scene.word, [root], False)
    numbering = number_scene(alone)
    found: dict[int, str] = {}
    stack: list[tuple[Entity, int]] = [(root, 0)]
    while stack:
        entity, before = stack.pop()
        if id(entity) in found:
            continue
        found[id(entity)] = numbering.handle(entity, before)
        stack += [(part.car, count) for part, count in reversed(list(numbering.children(entity, before)))]
    return found


def handles_in(scene: Scene) -> set[str]:
    """Every handle that an embedding in the scene carries."""
    return {e.embedding.handle for e in descendants(*scene.frames) if e.embedding.handle is not None}


def number_scene(scene: Scene) -> Numbering:
    """The numbering of a scene; exact without expanding its first frame."""
    taken = sorted(int(m[1]) for m in map(_NUMBERED.match, handles_in(scene)) if m)
    unhandled: dict[int, int] = {}
    for entity in descendants(*scene.frames):
        below = sum(unhandled[id(part.car)] for part in entity.children)
        unhandled[id(entity)] = below + (entity.embedding.handle is None)
    return Numbering(scene, tuple(taken), unhandled)


def instances(root: Entity) -> Iterator[tuple[Path, Entity]]:
    """Every instance below and including ``root`` with its child positions, in depth-first pre-order."""
    stack: list[tuple[Path, Entity]] = [((), root)]
    while stack:
        path, entity = stack.pop()
        yield path, entity
        for position in range(len(entity.children) - 1, -1, -1):
            stack.append(((*path, position), entity.children[position].car))


def frame_numbers(scene: Scene) -> dict[Path, int]:
    """The number of every path of a 4D scene: those of the first frame, then what appears in each later one."""
    numbering = number_scene(scene)
    numbers: dict[Path, int] = {}
    for root in scene.frames:
        for path, entity in instances(root):
            if entity.embedding.handle is None and path not in numbers:
                numbers[path] = numbering.number(len(numbers) + 1)
    return numbers


def instance_handles(scene: Scene, ancestry: Ancestry, numbers: Mapping[Path, int] | None = None) -> list[str]:
    """The handle of every instance of one frame, in the order of ``ancestry``; ``numbers`` are ``frame_numbers`` of a
    scene of several frames, None for one of one frame."""
    if numbers is not None:
        own = [ancestry.entity(i).embedding.handle for i in range(len(ancestry))]
        return [handle or f"z{numbers[ancestry.path(i)]}" for i, handle in enumerate(own)]
    numbering = number_scene(scene)
    offsets: dict[int, list[int]] = {}
    before = [0] * len(ancestry)
    parents, positions = ancestry.parent.tolist(), ancestry.position.tolist()
    for i in range(1, len(ancestry)):  # parents come first
        parent = ancestry.entity(parents[i])
        if id(parent) not in offsets:
            offsets[id(parent)] = [count for _, count in numbering.children(parent, 0)]
        before[i] = before[parents[i]] + offsets[id(parent)][positions[i]]
    return [numbering.handle(ancestry.entity(i), before[i]) for i in range(len(ancestry))]


def primitive_handles(scene: Scene, flat: FlatScene) -> list[Sequence[str]]:
    """The handle of every primitive of every frame, in the order of ``flat``."""
    if len(scene.frames) > 1:
        numbers = frame_numbers(scene)
        return [_handles_below(root, numbers) for root in scene.frames]
    return [_static_handles(scene, flat.frames[0])]


def frame_handles(scene: Scene, number: int, frame: FlatFrame) -> Sequence[str]:
    """The handle of every primitive of one frame of a scene, in the order of ``frame``."""
    if len(scene.frames) > 1:
        return _handles_below(scene.frames[number], frame_numbers(scene))
    return _static_handles(scene, frame)


def _handles_below(root: Entity, numbers: Mapping[Any, int]) -> Sequence[str]:
    return [e.embedding.handle or f"z{numbers[path]}" for path, e in instances(root) if e.is_primitive]


def _static_handles(scene: Scene, frame: FlatFrame) -> Sequence[str]:
    numbering = number_scene(scene)
    taken = np.array(numbering.taken, np.int64)
    free_before = taken - 1 - np.arange(len(taken))
    numbers_of = frame.ranks + np.searchsorted(free_before, frame.ranks, side="left")
    own = [entity.embedding.handle for entity in frame.primitives]
    return [own[i] or f"z{n}" for i, n in zip(frame.index.tolist(), numbers_of.tolist())]


# Applying entries of Z to automatic numbers: one instance is made again under its new embedding, all else is shared.
#
# Numbering the scene without the entries fixes each entry's path. Then, outermost first, each entry is merged over its
# instance's embedding, that call alone runs again, with the function that it had and the random streams as they stood
# when it began, and its result is grafted in (docs/language.md, section 4).


_NUMBER = "z"


def automatic_entries(scene: Scene, entries: Mapping[str, ZEntry]) -> tuple[dict[Path, ZEntry], list[str]]:
    """The entries that address instances by number, by path, outermost first; and the names that fit nothing."""
    written = handles_in(scene)
    numbering = number_scene(scene)
    later = {number: path for path, number in frame_numbers(scene).items()} if len(scene.frames) > 1 else {}
    found: dict[Path, ZEntry] = {}
    unused: list[str] = []
    for name, entry in entries.items():
        if name in written:
            continue
        digits = name[1:] if name.startswith(_NUMBER) and name[1:].isdigit() else ""
        path = None
        if digits and len(digits) < 19:
            path = later.get(int(digits)) if later else numbering.path(int(digits))
        if path is None:
            unused.append(name)
        else:
            found[path] = entry
    return {path: found[path] for path in sorted(found, key=lambda p: (len(p), p))}, unused


def serials_at(scene: Scene, paths: Mapping[Path, ZEntry]) -> frozenset[int]:
    """The serials of the calls that made the instances at ``paths``, in every frame."""
    found = (find(root, path) for root in scene.frames for path in paths)
    return frozenset(entity.serial for entity in found if entity is not None)


def find(root: Entity, path: Path) -> Entity | None:
    """The instance at ``path``, or None."""
    for position in path:
        if position >= len(root.children):
            return None
        root = root.children[position].car
    return root


def graft(rt: Runtime, scene: Scene, entries: Mapping[Path, ZEntry]) -> Scene:
    """The scene with ``entries`` applied. ``rt`` ran the program and kept the streams at ``serials_at``."""
    frames = list(scene.frames)
    for path, entry in entries.items():
        for index, root in enumerate(frames):
            entity = find(root, path)
            if entity is None:
                if len(frames) == 1:
                    rt.warn(
                        "unused-entry",
                        f"an entry's instance, at {list(path)}, is gone since an entry around it changed",
                    )
                continue
            frames[index] = _replaced(rt, root, path, _remade(rt, entity, entry))
    return Scene(scene.word, frames, scene.animated)


def _remade(rt: Runtime, entity: Entity, entry: ZEntry) -> Entity:
    old = entity.embedding
    text = entry.text if entry.text is not None else old.text
    z = Embedding(old.handle, text, {**old.attributes, **entry.attributes})
    if entity.effects:
        rt.warn("embedding-only", f'"{entity.word}" changed things outside itself, so only its embedding was replaced')
        return _with_embedding(rt, entity, z)
    if entity.serial in rt.snapshots:
        rt.streams.restore(rt.snapshots[entity.serial])
    return rt.remake(entity, z)


def _with_embedding(rt: Runtime, entity: Entity, z: Embedding) -> Entity:
    copy = rt.make_entity(entity.word, z, entity.children)
    copy.function, copy.rest, copy.serial, copy.effects = entity.function, entity.rest, entity.serial, entity.effects
    return copy


def _replaced(rt: Runtime, root: Entity, path: Path, replacement: Entity) -> Entity:
    """``root`` with the instance at ``path`` replaced; the entities on the way are copied, all others shared."""
    chain = [root]
    for position in path[:-1]:
        chain.append(chain[-1].children[position].car)
    for parent, position in zip(reversed(chain[: len(path)]), reversed(path)):
        children = list(parent.children)
        children[position] = Pair(replacement, children[position].cdr)
        copy = rt.make_entity(parent.word, parent.embedding, tuple(children))
        copy.function, copy.rest, copy.serial, copy.effects = (
            parent.function,
            parent.rest,
            parent.serial,
            parent.effects,
        )
        replacement = copy
    return replacement

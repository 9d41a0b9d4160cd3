"""Automatic numbers of embeddings, a view of the scene computed on demand (docs/language.md, "Numbers and the file Z").

The expanded graph is numbered in depth-first pre-order. An instance whose embedding has a handle gets no number; every
other instance gets the next number that is not the handle of any embedding in the scene. In a 4D scene, corresponding
entities (with the same child positions from the root) share a number, and paths that first appear in a later frame are
numbered after those of the earlier frames.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from scenelang.grammar.lazy_patterns import lazy_pattern
from scenelang.interpreter.loading import np
from scenelang.interpreter.runtime.runtime import Runtime, ZEntry
from scenelang.interpreter.scene.entity import Entity, Scene, descendants
from scenelang.interpreter.scene.flatten import FlatFrame, FlatScene, Graph, Level, Paths, graph_of, levels
from scenelang.interpreter.scene.part_columns import entity_times
from scenelang.interpreter.values.values import Embedding, Pair

if TYPE_CHECKING:
    import numpy.typing as npt

    IntArray = npt.NDArray[np.int64]


# --- the instance tree of a frame ------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class Ancestry:
    """Tree of the M instances that are primitives or have primitives below them.

    They are numbered in breadth-first order; the root is 0.

    Attributes
    ----------
    nodes, node : (M,)
        ``nodes[node[i]]`` is the entity of instance ``i``.
    parent : (M,)
        Parent instance; -1 for the root.
    position : (M,)
        Index among the children of the parent.
    depth : (M,)
        Distance from the root.
    poses : (M, 3, 4)
        World poses.
    primitives : (N,)
        Instance of each primitive of the flattened frame.
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
    def max_depth(self) -> int:
        """Largest distance of an instance from the root."""
        return int(self.depth.max(initial=0))

    def entity(self, instance: int) -> Entity:
        """Return the entity of an instance."""
        return self.nodes[int(self.node[instance])]

    def at_depth(self, depth: int) -> IntArray:
        """Return for every instance (M,) its ancestor at ``depth``, or itself if it is nearer to the root."""
        ancestors = np.arange(len(self))
        while True:
            deeper = np.flatnonzero(self.depth[ancestors] > depth)
            if not len(deeper):
                return ancestors
            ancestors[deeper] = self.parent[ancestors[deeper]]

    def ranges(self, leaves: IntArray) -> tuple[IntArray, IntArray]:
        """Return the first and last position (M,) in ``leaves`` (K,), instances of leaves, at or below every instance.

        Where there is none, the first is the largest integer and the last -1.
        """
        first, last = np.full(len(self), np.iinfo(np.int64).max), np.full(len(self), -1)
        first[leaves] = last[leaves] = np.arange(len(leaves))
        for depth in range(self.max_depth, 0, -1):
            level = np.flatnonzero(self.depth == depth)
            np.minimum.at(first, self.parent[level], first[level])
            np.maximum.at(last, self.parent[level], last[level])
        return first, last

    def path_of_instances(self, instance: int) -> tuple[int, ...]:
        """Return the instances from the root to an instance, both included."""
        chain = [instance]
        while self.parent[chain[-1]] >= 0:
            chain.append(int(self.parent[chain[-1]]))
        return tuple(reversed(chain))

    def path(self, instance: int) -> tuple[int, ...]:
        """Return the child positions from the root to an instance."""
        positions: list[int] = []
        while self.parent[instance] >= 0:
            positions.append(int(self.position[instance]))
            instance = int(self.parent[instance])
        return tuple(reversed(positions))


def ancestry_of(root: Entity) -> Ancestry:
    """Build the instance tree of ``root``. The caller has checked the number of primitives."""
    graph = graph_of(root, frozenset())
    is_leaf = np.array([entity.is_primitive for entity in graph.nodes])
    by_depth = list(levels(graph, is_leaf, Paths(graph.nodes)))
    return _concatenated(graph, by_depth)


def _concatenated(graph: Graph, by_depth: list[tuple[Level, Level]]) -> Ancestry:
    """Concatenate the levels; at each depth, the inner instances precede the leaves."""
    node, parent, position, depth, poses = [], [], [], [], []
    primitives = np.zeros(int(graph.leaves[-1]), np.int64)
    above, start = 0, 0  # first inner instance of the level above, first instance of this level
    for number, (leaves, inner) in enumerate(by_depth):
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


# --- numbers ---------------------------------------------------------------------------------------------------------

_NUMBERED = lazy_pattern(r"z([1-9]\d{0,17})\Z")  # 18 digits fit 64 bits
Path = tuple[int, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Numbering:
    """Numbers of the instances of a scene.

    Attributes
    ----------
    taken
        Numbers that handles in the scene use, ascending.
    unhandled
        Number of instances without a handle below and including each entity, by ``id``.
    """

    scene: Scene
    taken: tuple[int, ...]
    unhandled: dict[int, int]

    def number(self, rank: int) -> int:
        """Return the number of the ``rank``-th instance without a handle, counted from 1.

        Numbers that handles of the scene use, such as ``<z3>``, are skipped.
        """
        free_before = [k - 1 - i for i, k in enumerate(self.taken)]  # free numbers below each taken one
        return rank + bisect_left(free_before, rank)

    def rank(self, number: int) -> int | None:
        """Return the inverse of ``number``: which instance without a handle has this number, counted from 1.

        None if a handle of the scene uses the number.
        """
        position = bisect_left(self.taken, number)
        if position < len(self.taken) and self.taken[position] == number:
            return None
        return number - position

    def children(self, entity: Entity, rank: int) -> Iterator[tuple[Any, int]]:
        """Iterate over the parts of an instance, each with the number of unhandled instances before it.

        ``rank`` is the number of unhandled instances before the instance itself.
        """
        before = rank + (entity.embedding.handle is None)
        for part in entity.children:
            yield part, before
            before += self.unhandled[id(part.car)]

    def handle(self, entity: Entity, before: int) -> str:
        """Return the handle of an instance: that of its embedding, or its automatic number.

        ``before`` is the number of automatic numbers before it in the order of the tree.
        """
        return entity.embedding.handle or f"z{self.number(before + 1)}"

    def path(self, number: int) -> Path | None:
        """Return the child positions of the instance with an automatic number in the first frame, or None.

        The walk goes down to the part whose range of ranks contains the number, so it needs no expansion.
        """
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
    """Return the handle of the first instance of each distinct entity of one frame, keyed by ``id``.

    In a 4D scene, numbers of a later frame are those that the frame would have as a static scene.
    """
    root = scene.frames[frame]
    static = scene if len(scene.frames) == 1 else Scene(scene.word, [root], animated=False)
    numbering = number_scene(static)
    handles: dict[int, str] = {}
    stack: list[tuple[Entity, int]] = [(root, 0)]
    while stack:
        entity, before = stack.pop()
        if id(entity) in handles:
            continue
        handles[id(entity)] = numbering.handle(entity, before)
        stack += [(part.car, count) for part, count in reversed(list(numbering.children(entity, before)))]
    return handles


def handles_in(scene: Scene) -> set[str]:
    """Return all handles that embeddings of the scene have."""
    return {e.embedding.handle for e in descendants(*scene.frames) if e.embedding.handle is not None}


def number_scene(scene: Scene) -> Numbering:
    """Compute the numbering of a scene, exact for its first frame, without expanding it."""
    used = sorted(int(m[1]) for m in map(_NUMBERED.match, handles_in(scene)) if m)
    unhandled: dict[int, int] = {}
    for entity in descendants(*scene.frames):
        below = sum(times * unhandled[id(child)] for child, times in entity_times(entity.children))
        unhandled[id(entity)] = below + (entity.embedding.handle is None)
    return Numbering(scene, tuple(used), unhandled)


def instances(root: Entity) -> Iterator[tuple[Path, Entity]]:
    """Iterate over all instances below and including ``root`` in depth-first pre-order, with their child positions."""
    stack: list[tuple[Path, Entity]] = [((), root)]
    while stack:
        path, entity = stack.pop()
        yield path, entity
        for position in range(len(entity.children) - 1, -1, -1):
            stack.append(((*path, position), entity.children[position].car))


def frame_numbers(scene: Scene) -> dict[Path, int]:
    """Return the number of every path of a 4D scene: those of the first frame, then the new ones of each later frame.

    A static scene is numbered on the graph; here every instance of every frame is walked, because paths that first
    appear in a later frame are numbered after those of earlier frames.
    """
    numbering = number_scene(scene)
    numbers: dict[Path, int] = {}
    for root in scene.frames:
        for path, entity in instances(root):
            if entity.embedding.handle is None and path not in numbers:
                numbers[path] = numbering.number(len(numbers) + 1)
    return numbers


def instance_handles(scene: Scene, ancestry: Ancestry, numbers: Mapping[Path, int] | None = None) -> list[str]:
    """Return the handle of every instance of one frame, in the order of ``ancestry``.

    Parameters
    ----------
    scene
        The scene.
    ancestry
        Instances of the frame.
    numbers
        The ``frame_numbers`` of a scene with several frames, None for a static scene.
    """
    if numbers is not None:
        declared = [ancestry.entity(i).embedding.handle for i in range(len(ancestry))]
        return [handle or f"z{numbers[ancestry.path(i)]}" for i, handle in enumerate(declared)]
    numbering = number_scene(scene)
    offsets: dict[int, list[int]] = {}
    before = [0] * len(ancestry)
    parents, positions = ancestry.parent.tolist(), ancestry.position.tolist()
    for i in range(1, len(ancestry)):  # parents precede their children
        parent = ancestry.entity(parents[i])
        if id(parent) not in offsets:
            offsets[id(parent)] = [count for _, count in numbering.children(parent, 0)]
        before[i] = before[parents[i]] + offsets[id(parent)][positions[i]]
    return [numbering.handle(ancestry.entity(i), before[i]) for i in range(len(ancestry))]


def some_handles(
    scene: Scene, ancestry: Ancestry, rows: Sequence[int], numbers: Mapping[Path, int] | None = None
) -> dict[int, str]:
    """Return the handles of some instances of one frame, by row of ``ancestry``.

    Parameters
    ----------
    rows
        Instances, as rows of ``ancestry``.
    numbers
        As for ``instance_handles``, which returns the handles of all instances.
    """
    if numbers is not None:
        declared = {i: ancestry.entity(i).embedding.handle for i in rows}
        return {i: handle or f"z{numbers[ancestry.path(i)]}" for i, handle in declared.items()}
    numbering = number_scene(scene)
    offsets: dict[int, list[int]] = {}
    before = {0: 0}
    for i in rows:
        above = [i]
        while above[-1] not in before:
            above.append(int(ancestry.parent[above[-1]]))
        for below, parent in zip(above[-2::-1], above[:0:-1]):
            entity = ancestry.entity(parent)
            if id(entity) not in offsets:
                offsets[id(entity)] = [count for _, count in numbering.children(entity, 0)]
            before[below] = before[parent] + offsets[id(entity)][int(ancestry.position[below])]
    return {i: numbering.handle(ancestry.entity(i), before[i]) for i in rows}


def primitive_handles(scene: Scene, flat: FlatScene) -> list[Sequence[str]]:
    """Return for each frame the handles of its primitives, in the order of ``flat``."""
    if len(scene.frames) > 1:
        numbers = frame_numbers(scene)
        return [_handles_below(root, numbers) for root in scene.frames]
    return [_static_handles(scene, flat.frames[0])]


def frame_handles(scene: Scene, number: int, frame: FlatFrame) -> Sequence[str]:
    """Return the handle of every primitive of frame ``number`` of a scene, in the order of ``frame``."""
    if len(scene.frames) > 1:
        return _handles_below(scene.frames[number], frame_numbers(scene))
    return _static_handles(scene, frame)


def _handles_below(root: Entity, numbers: Mapping[Any, int]) -> Sequence[str]:
    """Return the handles of the primitives of one frame of a 4D scene."""
    return [e.embedding.handle or f"z{numbers[path]}" for path, e in instances(root) if e.is_primitive]


def _static_handles(scene: Scene, frame: FlatFrame) -> Sequence[str]:
    """Return the handles of the primitives of a static scene: ``Numbering.number`` for all ranks at once."""
    numbering = number_scene(scene)
    used = np.array(numbering.taken, np.int64)
    free_before = used - 1 - np.arange(len(used))
    numbers_of = frame.ranks + np.searchsorted(free_before, frame.ranks, side="left")
    declared = [entity.embedding.handle for entity in frame.primitives]
    return [declared[i] or f"z{n}" for i, n in zip(frame.index.tolist(), numbers_of.tolist())]


# --- overrides -------------------------------------------------------------------------------------------------------
#
# Entries of the embeddings file that address an automatic number override the embedding of a single instance. Numbering
# the scene without the entries fixes the path of each entry. Then, outermost first, each entry is merged into the
# embedding of its instance, the call of that instance runs again with the same function and the random streams in the
# state at its start, and the result replaces the instance (docs/language.md, "Numbers and the file Z").


_NUMBER_PREFIX = "z"


def overrides_by_path(scene: Scene, entries: Mapping[str, ZEntry]) -> tuple[dict[Path, ZEntry], list[str]]:
    """Return the entries that address instances by number, keyed by path, outermost first, and the unmatched names."""
    written = handles_in(scene)
    numbering = number_scene(scene)
    later = {number: path for path, number in frame_numbers(scene).items()} if len(scene.frames) > 1 else {}
    by_path: dict[Path, ZEntry] = {}
    unused: list[str] = []
    for name, entry in entries.items():
        if name in written:
            continue
        digits = name[1:] if name.startswith(_NUMBER_PREFIX) and name[1:].isdigit() else ""
        path = None
        if digits and len(digits) < 19:  # as in _NUMBERED: fits 64 bits
            path = later.get(int(digits)) if later else numbering.path(int(digits))
        if path is None:
            unused.append(name)
        else:
            by_path[path] = entry
    return {path: by_path[path] for path in sorted(by_path, key=lambda p: (len(p), p))}, unused


def serials_at(scene: Scene, paths: Mapping[Path, ZEntry]) -> frozenset[int]:
    """Return the serial numbers of the calls that created the instances at ``paths``, in every frame."""
    entities = (instance_at(root, path) for root in scene.frames for path in paths)
    return frozenset(entity.serial for entity in entities if entity is not None)


def instance_at(root: Entity, path: Path) -> Entity | None:
    """Return the entity at ``path``, or None if there is none."""
    for position in path:
        if position >= len(root.children):
            return None
        root = root.children[position].car
    return root


def apply_overrides(rt: Runtime, scene: Scene, entries: Mapping[Path, ZEntry]) -> Scene:
    """Return the scene with ``entries`` applied.

    ``rt`` must be the runtime that ran the program, with snapshots of the random streams at ``serials_at``.
    """
    frames = list(scene.frames)
    for path, entry in entries.items():
        for index, root in enumerate(frames):
            entity = instance_at(root, path)
            if entity is None:
                if len(frames) == 1:
                    rt.warn(
                        "unused-entry",
                        f"the instance at {list(path)} no longer exists, because an entry for an enclosing instance "
                        "changed the scene",
                    )
                continue
            frames[index] = _replace_at(rt, root, path, _reevaluated(rt, entity, entry))
    return Scene(scene.word, frames, scene.animated, scene.declarations, scene.setup)


def _reevaluated(rt: Runtime, entity: Entity, entry: ZEntry) -> Entity:
    """Return ``entity`` created again with the override merged into its embedding."""
    old = entity.embedding
    text = entry.text if entry.text is not None else old.text
    z = Embedding(old.handle, text, {**old.attributes, **entry.attributes})
    if entity.effects:
        rt.warn("embedding-only", f'the call of "{entity.word}" has side effects, so only its embedding was replaced')
        return _with_embedding(rt, entity, z)
    if entity.serial in rt.snapshots:
        rt.streams.restore(rt.snapshots[entity.serial])
    return rt.reevaluate(entity, z)


def _with_embedding(rt: Runtime, entity: Entity, z: Embedding) -> Entity:
    """Return a copy of ``entity`` with another embedding and the same children."""
    return _like(entity, rt.make_entity(entity.word, z, entity.children))


def _like(entity: Entity, copy: Entity) -> Entity:
    """Return ``copy`` as the result of the same call as ``entity``."""
    copy.function, copy.rest, copy.serial, copy.effects = entity.function, entity.rest, entity.serial, entity.effects
    copy.declarations = entity.declarations
    return copy


def _replace_at(rt: Runtime, root: Entity, path: Path, replacement: Entity) -> Entity:
    """Return ``root`` with the instance at ``path`` replaced.

    Its ancestors are copied, all other entities are shared.
    """
    chain = [root]
    for position in path[:-1]:
        chain.append(chain[-1].children[position].car)
    for parent, position in zip(reversed(chain[: len(path)]), reversed(path)):
        children = list(parent.children)
        children[position] = Pair(replacement, children[position].cdr)
        replacement = _like(parent, rt.make_entity(parent.word, parent.embedding, tuple(children)))
    return replacement

"""Entities: the nodes of the DAG that a program evaluates to (paper, section 3.1).

``Entity = Tuple[Tuple[Word, Embedding], List[Tuple[Entity, Matrix]]]``. An entity is immutable and compares by
identity; calls that are shared give the same object, so a scene is a DAG whose size follows distinct calls.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

from scenelang.grammar.datum import Span
from scenelang.interpreter.runtime.values import Embedding, Matrix
from scenelang.interpreter.scene.primitives.base import Box, Primitive


class Entity:
    """``children`` holds pairs ``(Entity . Matrix)``; ``shape`` is the geometry of a primitive, else None.

    ``function``, ``rest`` and ``serial`` say how it was made (the entity function, gamma, the number of the call in
    the run, whether it changed things outside), so that one instance can be made again under another embedding.
    ``tainted``: reaches a mutable thing or a function. ``box`` caches the exact bounding box (see ``bounds``),
    ``has_blocks`` what ``lays_blocks`` finds.
    ``places`` are the calls that made a primitive: equal calls share it, so there may be several (of which the first
    sixteen are kept).
    """

    __slots__ = (
        "box", "children", "effects", "embedding", "function", "has_blocks", "places", "rest", "serial", "shape",
        "tainted", "word",
    )  # fmt: skip

    def __init__(
        self,
        word: str,
        embedding: Embedding,
        children: tuple[Any, ...],
        shape: Primitive | None = None,
        tainted: bool = False,
        places: tuple[Span, ...] = (),
    ) -> None:
        self.word = word
        self.embedding = embedding
        self.children = children
        self.shape = shape
        self.tainted = tainted
        self.function: Any = None
        self.rest: Any = None
        self.serial = 0
        self.effects = False
        self.box: Box | tuple[()] | None = None
        self.has_blocks: bool | None = None
        self.places = places

    @property
    def is_primitive(self) -> bool:
        return self.shape is not None

    @property
    def is_block(self) -> bool:
        """True of a primitive of Minecraft blocks."""
        return self.shape is not None and self.shape.is_block

    def __repr__(self) -> str:
        return f"<entity {self.word}>"


class Frames:
    """The value of a 4D root: one list of parts, pairs ``(Entity . Matrix)``, per frame."""

    __slots__ = ("frames",)

    def __init__(self, frames: tuple[tuple[Any, ...], ...]) -> None:
        self.frames = frames


class Scene:
    """What a program evaluates to: one root entity per frame (a static scene has one)."""

    __slots__ = ("animated", "frames", "word")

    def __init__(self, word: str, frames: Sequence[Entity], animated: bool) -> None:
        self.word = word
        self.frames = tuple(frames)
        self.animated = animated

    @property
    def root(self) -> Entity:
        """The root entity of the first frame."""
        return self.frames[0]


def descendants(*roots: Entity) -> Iterator[Entity]:
    """Every distinct entity below and including ``roots``, children before parents."""
    seen: set[int] = set()
    for root in roots:
        if id(root) in seen:
            continue
        seen.add(id(root))
        stack = [(root, iter(root.children))]
        while stack:
            entity, children = stack[-1]
            for part in children:
                child = part.car
                if id(child) not in seen:
                    seen.add(id(child))
                    stack.append((child, iter(child.children)))
                    break
            else:
                stack.pop()
                yield entity


def lays_blocks(entity: Entity, charge: Callable[[int], None]) -> bool:
    """Whether a primitive of Minecraft blocks is ``entity`` or below it. ``charge`` counts the work."""
    stack = [entity]
    while stack:
        top = stack[-1]
        charge(1 + (len(top.children) >> 3))
        waiting = [part.car for part in top.children if part.car.has_blocks is None]
        if top.has_blocks is None and waiting:
            stack.extend({id(child): child for child in waiting}.values())
            continue
        stack.pop()
        if top.has_blocks is None:
            own = top.shape is not None and top.shape.is_block
            top.has_blocks = own or any(part.car.has_blocks for part in top.children)
    return bool(entity.has_blocks)


def instance_counts(order: Sequence[Entity]) -> dict[int, int]:
    """How often each distinct entity stands in the expanded scene, by ``id``; ``order`` is ``descendants`` of one root:
    children before parents, the root last."""
    instances = dict.fromkeys(map(id, order), 0)
    instances[id(order[-1])] = 1
    for entity in reversed(order):
        for part in entity.children:
            instances[id(part.car)] += instances[id(entity)]
    return instances


def count_words(root: Entity) -> dict[str, int]:
    """Instances of every word in the expanded scene, worked out on the DAG; in depth-first order of appearance."""
    order = list(descendants(root))
    instances = instance_counts(order)
    totals = dict.fromkeys(_words_in_order(root), 0)
    for entity in order:
        totals[entity.word] += instances[id(entity)]
    return totals


def _words_in_order(root: Entity) -> Iterator[str]:
    """The words of the distinct entities, depth first from the root."""
    seen: set[int] = set()
    stack = [root]
    while stack:
        entity = stack.pop()
        if id(entity) in seen:
            continue
        seen.add(id(entity))
        yield entity.word
        stack.extend(part.car for part in reversed(entity.children) if id(part.car) not in seen)


def primitive_count(root: Entity) -> int:
    """Number of primitives in the expanded scene, worked out on the DAG."""
    counts: dict[int, int] = {}
    for entity in descendants(root):
        below = sum(counts[id(part.car)] for part in entity.children)
        counts[id(entity)] = below + (1 if entity.is_primitive else 0)
    return counts[id(root)]


def pose_of(part: Any) -> Matrix:
    """The pose of a part ``(Entity . Matrix)``."""
    pose: Matrix = part.cdr
    return pose

"""Entities: the nodes of the DAG that a program evaluates to (paper, section 3.1).

``Entity = Tuple[Tuple[Word, Embedding], List[Tuple[Entity, Matrix]]]``. Entities are immutable and compare by identity.
Memoized calls return the same object, so a scene is a DAG whose size depends on the number of distinct calls.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from scenelang.grammar.datum import Span
from scenelang.interpreter.scene.part_columns import distinct_entities, entity_times
from scenelang.interpreter.scene.primitives.base import Box, Primitive
from scenelang.interpreter.values.values import Embedding, Matrix

if TYPE_CHECKING:
    from scenelang.interpreter.scene.declarations import Declaration
    from scenelang.interpreter.scene.setup import Setup


class Entity:
    """Entity of a scene.

    Attributes
    ----------
    word, embedding
        The word and the embedding z of the call.
    children
        Pairs ``(Entity . Matrix)``: a tuple, or columns for many of them.
    shape
        Geometry of a primitive, else None.
    function, rest, serial, effects
        How the entity was created: the entity function, gamma, the number of the call in the run, and whether the call
        had side effects. They allow re-evaluating one instance with another embedding.
    tainted
        Whether the entity refers to a mutable value or a function.
    box
        Cached exact bounding box (see ``bounds``); ``()`` if it has no geometry.
    has_blocks
        Cached result of ``contains_blocks``.
    call_sites
        Locations of the calls that created a primitive. Equal calls share the primitive, so there may be several; only
        the first sixteen are recorded.
    """

    __slots__ = (
        "box", "call_sites", "children", "declarations", "effects", "embedding", "function", "has_blocks", "rest",
        "serial", "shape", "tainted", "word",
    )  # fmt: skip

    def __init__(
        self,
        word: str,
        embedding: Embedding,
        children: Sequence[Any],
        shape: Primitive | None = None,
        tainted: bool = False,
        call_sites: tuple[Span, ...] = (),
    ) -> None:
        """Create an entity; how it was created is set afterwards by the runtime, if it is needed."""
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
        self.call_sites = call_sites
        self.declarations: tuple[Declaration, ...] = ()

    @property
    def is_primitive(self) -> bool:
        """Whether this is a leaf with geometry."""
        return self.shape is not None

    @property
    def is_block(self) -> bool:
        """Whether this is a primitive made of Minecraft blocks."""
        return self.shape is not None and self.shape.is_block

    def __repr__(self) -> str:
        return f"<entity {self.word}>"


class Frames:
    """Value of a 4D root: for each frame, a tuple of parts, pairs ``(Entity . Matrix)``."""

    __slots__ = ("frames",)

    def __init__(self, frames: tuple[Sequence[Any], ...]) -> None:
        self.frames = frames


class Scene:
    """Result of a program.

    Attributes
    ----------
    word
        Word of the root.
    frames
        Root entity of each frame; a static scene has one frame.
    animated
        Whether the scene is 4D.
    declarations
        Relations that the program declares outside of calls, about the root.
    setup
        Cameras, lights, environment and render settings that the program declares.
    """

    __slots__ = ("animated", "declarations", "frames", "setup", "word")

    def __init__(
        self,
        word: str,
        frames: Sequence[Entity],
        animated: bool,
        declarations: Sequence[Declaration] = (),
        setup: Setup = (),
    ) -> None:
        self.word = word
        self.frames = tuple(frames)
        self.animated = animated
        self.declarations = tuple(declarations)
        self.setup = setup

    def with_frames(self, frames: Sequence[Entity], animated: bool | None = None) -> Scene:
        """Return a scene of other frames with the same word and setup; its relations are not those of the frames."""
        return Scene(self.word, frames, self.animated if animated is None else animated, (), self.setup)

    def with_setup(self, setup: Setup) -> Scene:
        """Return the scene with another setup."""
        return Scene(self.word, self.frames, self.animated, self.declarations, setup)

    @property
    def root(self) -> Entity:
        """Root entity of the first frame."""
        return self.frames[0]


def descendants(*roots: Entity) -> Iterator[Entity]:
    """Iterate over the distinct entities below and including ``roots``, children before parents."""
    visited: set[Entity] = set()
    for root in roots:
        if root in visited:
            continue
        visited.add(root)
        stack = [(root, iter(distinct_entities(root.children)))]
        while stack:
            entity, children = stack[-1]
            for child in children:
                if child not in visited:
                    visited.add(child)
                    stack.append((child, iter(distinct_entities(child.children))))
                    break
            else:
                stack.pop()
                yield entity


def contains_blocks(entity: Entity, charge: Callable[[int], None]) -> bool:
    """Return whether ``entity`` or a descendant is a primitive made of Minecraft blocks.

    The answers are cached on the entities. ``charge`` is called with the number of steps.
    """
    stack = [entity]
    while stack:
        top = stack[-1]
        charge(1 + (len(top.children) >> 3))
        below = distinct_entities(top.children)
        pending = [entity for entity in below if entity.has_blocks is None]
        if top.has_blocks is None and pending:
            stack.extend(pending)
            continue
        stack.pop()
        if top.has_blocks is None:
            is_block = top.shape is not None and top.shape.is_block
            top.has_blocks = is_block or any(entity.has_blocks for entity in below)
    return bool(entity.has_blocks)


def instance_counts(order: Sequence[Entity]) -> dict[int, int]:
    """Count the instances of each distinct entity in the expanded scene, keyed by ``id``.

    Parameters
    ----------
    order
        The ``descendants`` of one root: children before parents, the root last.
    """
    instances = dict.fromkeys(map(id, order), 0)
    instances[id(order[-1])] = 1
    for entity in reversed(order):
        for child, times in entity_times(entity.children):
            instances[id(child)] += times * instances[id(entity)]
    return instances


def count_words(root: Entity) -> dict[str, int]:
    """Count the instances of each word in the expanded scene, without expanding it; words are in depth-first order."""
    order = list(descendants(root))
    instances = instance_counts(order)
    totals = dict.fromkeys(_words_in_order(root), 0)
    for entity in order:
        totals[entity.word] += instances[id(entity)]
    return totals


def _words_in_order(root: Entity) -> Iterator[str]:
    """Iterate over the words of the distinct entities in depth-first order."""
    visited: set[int] = set()
    stack = [root]
    while stack:
        entity = stack.pop()
        if id(entity) in visited:
            continue
        visited.add(id(entity))
        yield entity.word
        below = [*distinct_entities(entity.children)]
        stack.extend(child for child in reversed(below) if id(child) not in visited)


def primitive_count(root: Entity) -> int:
    """Count the primitives of the expanded scene, without expanding it."""
    counts: dict[Entity, int] = {}
    for entity in descendants(root):
        below = [times * counts[child] for child, times in entity_times(entity.children)]
        counts[entity] = sum(below) + entity.is_primitive
    return counts[root]


def pose_of(part: Any) -> Matrix:
    """Return the pose of a part ``(Entity . Matrix)``."""
    pose: Matrix = part.cdr
    return pose

"""Minecraft's primitives in exports: their positions are whole cells, which a shared hierarchy cannot say.

``flatten`` truncates the world position of every block toward zero. Where that moves something, the way to each block
is copied and the block's own pose corrected, so that the product of the poses is where ``flatten`` puts it.
"""

from __future__ import annotations

import math

from scenelang.grammar.diagnostics import LimitError
from scenelang.interpreter import pose
from scenelang.interpreter.entity import Entity, Scene, descendants, primitive_count
from scenelang.interpreter.shapes import BLOCK_WORDS
from scenelang.interpreter.values import IDENTITY, Matrix, Pair

_MOST_BLOCKS = 200_000


def settled(scene: Scene) -> Scene:
    """``scene`` with every block at whole cells; itself where none moves. Raises LimitError for too many blocks."""
    return Scene(scene.word, [_settled_root(root) for root in scene.frames], scene.animated)


def _settled_root(root: Entity) -> Entity:
    with_blocks: set[int] = set()
    for entity in descendants(root):
        if entity.word in BLOCK_WORDS or any(id(part.car) in with_blocks for part in entity.children):
            with_blocks.add(id(entity))
    if id(root) not in with_blocks:
        return root
    whole = all(_is_whole(part.cdr) for e in descendants(root) if id(e) in with_blocks for part in e.children)
    if whole:
        return root
    count = primitive_count(root)
    if count > _MOST_BLOCKS:
        raise LimitError("primitives", f"the scene has {count:,} blocks, more than the {_MOST_BLOCKS:,} of an export")
    return _copied(root, with_blocks)


def _is_whole(m: Matrix) -> bool:
    """True when the pose takes whole cells to whole cells."""
    return all(number == math.trunc(number) for number in m)


def _copied(root: Entity, with_blocks: set[int]) -> Entity:
    """The tree of all instances with blocks below them, the blocks' poses corrected; no recursion."""
    done: list[Pair] = []
    stack: list[tuple[Entity, Matrix, Matrix, list[Pair], list[Pair] | None]] = [(root, IDENTITY, IDENTITY, done, None)]
    while stack:
        entity, local, world, siblings, finished = stack.pop()
        if finished is not None:
            siblings.append(Pair(_twin(entity, tuple(finished)), local))
        elif entity.word in BLOCK_WORDS:
            siblings.append(Pair(entity, _corrected(local, world)))
        elif id(entity) not in with_blocks:
            siblings.append(Pair(entity, local))
        else:
            children: list[Pair] = []
            stack.append((entity, local, world, siblings, children))
            for part in reversed(entity.children):
                stack.append((part.car, part.cdr, pose.compose(world, part.cdr), children, None))
    copy: Entity = done[0].car
    return copy


def _corrected(local: Matrix, world: Matrix) -> Matrix:
    """``local`` moved so that the world position is whole; as it is where the world pose is singular."""
    import numpy as np

    there, here = pose.to_array(world), pose.to_array(local)
    aim = there.copy()
    aim[:3, 3] = np.trunc(there[:3, 3])
    try:
        moved = here @ np.linalg.solve(there, aim)
    except np.linalg.LinAlgError:
        return local
    return Matrix(moved[:3].ravel().tolist())


def _twin(entity: Entity, children: tuple[Pair, ...]) -> Entity:
    twin = Entity(entity.word, entity.embedding, children, entity.shape, entity.tainted)
    twin.function = entity.function
    return twin

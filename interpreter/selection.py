"""Finding entities by word on the DAG, and measuring them where they stand in the world."""

from __future__ import annotations

from math import isfinite

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.bounds import entity_box
from scenelang.interpreter.entity import Entity, Scene, descendants
from scenelang.interpreter.shapes import Box
from scenelang.interpreter.values import Pair


def word_box(scene: Scene, word: str | None) -> Box | None:
    """The exact world box of the scene over all its frames, or of the entities of ``word``; None without geometry.

    For a word, the DAG is rebuilt with everything else left out, so that nothing is expanded.
    """
    boxes = []
    for root in scene.frames:
        kept = root if word is None else _only(root, word)
        box = entity_box(kept) if kept is not None else None
        if box is not None:
            boxes.append(box)
    if not boxes:
        return None
    if not all(map(isfinite, (x for box in boxes for x in box))):
        raise SceneError("pose", "poses multiply to numbers too large to tell, so the scene has no bounding box")
    return (
        min(b[0] for b in boxes), min(b[1] for b in boxes), min(b[2] for b in boxes),
        max(b[3] for b in boxes), max(b[4] for b in boxes), max(b[5] for b in boxes),
    )  # fmt: skip


def _only(root: Entity, word: str) -> Entity | None:
    """The scene with only the entities of ``word`` (whole, wherever they are)."""
    kept: dict[int, Entity | None] = {}
    for entity in descendants(root):
        if entity.word == word:
            kept[id(entity)] = entity
            continue
        parts = tuple(Pair(kept[id(p.car)], p.cdr) for p in entity.children if kept[id(p.car)] is not None)
        kept[id(entity)] = Entity(entity.word, entity.embedding, parts) if parts else None
    return kept[id(root)]

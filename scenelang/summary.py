"""What a scene is, in a few facts: its root, how much there is of everything, where it lies."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from scenelang.interpreter.entity import Scene, count_words, descendants, primitive_count


def summary(scene: Scene) -> dict[str, Any]:
    """The facts as plain data, of all frames of a 4D scene together; ``bounds`` is None where nothing has a box."""
    from scenelang.interpreter.selection import word_box

    box = word_box(scene, None)
    facts: dict[str, Any] = {"root": scene.word}
    if scene.animated:
        facts["frames"] = len(scene.frames)
    return facts | {
        "entities": sum(1 for _ in descendants(*scene.frames)),
        "instances": sum(sum(count_words(root).values()) for root in scene.frames),
        "primitives": sum(primitive_count(root) for root in scene.frames),
        "bounds": {"min": list(box[:3]), "max": list(box[3:])} if box is not None else None,
    }


def summary_rows(facts: Mapping[str, Any]) -> list[tuple[str, str]]:
    """The facts as people read them: name and value."""
    rows = [
        (name, f"{value:,}" if isinstance(value, int) else str(value))
        for name, value in facts.items()
        if name != "bounds"
    ]
    corners: Mapping[str, Any] = facts["bounds"] or {}
    return rows + [(name, "[" + " ".join(f"{x:.6g}" for x in corner) + "]") for name, corner in corners.items()]

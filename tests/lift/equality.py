"""Equality of two scenes in everything that lifting must preserve."""

from __future__ import annotations

from typing import Any

import numpy as np

from scenelang.interpreter.scene.entity import Entity, Scene
from scenelang.interpreter.scene.flatten import flatten

CLOSE = 1e-9  # of the scene's size


def scene_difference(a: Scene, b: Scene) -> str | None:
    """What differs in words, embeddings, hierarchy, sharing, frames, or, by more than rounding, in poses."""
    if len(a.frames) != len(b.frames):
        return f"{len(a.frames)} and {len(b.frames)} frames"
    tolerance = CLOSE * _size(a)
    pairs: dict[tuple[int, int], None] = {}
    for one, other in zip(a.frames, b.frames):
        found = _entity_difference(one, other, tolerance, pairs)
        if found is not None:
            return found
    lefts, rights = {left for left, _ in pairs}, {right for _, right in pairs}
    if len(lefts) != len(rights):
        return f"{len(lefts)} and {len(rights)} distinct entities"
    return None


def _size(scene: Scene) -> float:
    points = [frame.matrices[:, :, 3] for frame in flatten(scene).frames if len(frame)]
    return float(max((np.abs(rows).max() for rows in points), default=1.0)) or 1.0


def _entity_difference(a: Entity, b: Entity, tolerance: float, seen: dict[tuple[int, int], None]) -> str | None:
    stack = [(a, b)]
    while stack:
        a, b = stack.pop()
        if (id(a), id(b)) in seen:
            continue
        seen[id(a), id(b)] = None
        if a.word != b.word or repr(a.embedding) != repr(b.embedding):
            found = _attribute_difference(a, b)
            if found is not None:
                return found
        ours, theirs = list(a.children), list(b.children)
        if len(ours) != len(theirs):
            return f'"{a.word}" has {len(ours)} and {len(theirs)} parts'
        for one, other in zip(ours, theirs):
            apart = float(np.abs(np.asarray(one.cdr, float) - np.asarray(other.cdr, float)).max())
            if not apart <= tolerance:
                return f'"{one.car.word}" in "{a.word}" is {apart} away'
            stack.append((one.car, other.car))
    return None


def _attribute_difference(a: Entity, b: Entity) -> str | None:
    if a.word != b.word:
        return f'"{a.word}" is "{b.word}"'
    if a.embedding.text != b.embedding.text or a.embedding.handle != b.embedding.handle:
        return f'the embeddings of "{a.word}" differ'
    ours, theirs = dict(a.embedding.attributes), dict(b.embedding.attributes)
    if list(ours) != list(theirs):
        return f'"{a.word}" has the attributes {list(ours)} and {list(theirs)}'
    for name, value in ours.items():
        if not _is_close(value, theirs[name]):
            return f'`{name}` of "{a.word}" is {value!r} and {theirs[name]!r}'
    return None


def _is_close(a: Any, b: Any) -> bool:
    try:
        return bool(np.allclose(np.asarray(a, float), np.asarray(b, float), rtol=1e-9, atol=1e-12))
    except (TypeError, ValueError):
        return repr(a) == repr(b)

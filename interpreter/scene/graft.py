"""Applying entries of Z to automatic numbers: one instance is made again under its new embedding, all else is shared.

Numbering the scene without the entries fixes each entry's path. Then, outermost first, each entry is merged over its
instance's embedding, that call alone runs again, with the function that it had and the random streams as they stood
when it began, and its result is grafted in (docs/language.md, section 4).
"""

from __future__ import annotations

from collections.abc import Mapping

from scenelang.interpreter.runtime.runtime import Runtime, ZEntry
from scenelang.interpreter.runtime.values import Embedding, Pair
from scenelang.interpreter.scene.entity import Entity, Scene
from scenelang.interpreter.scene.numbering import Path, frame_numbers, handles_in, number_scene

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

"""Entities of a scene whose embeddings are to be learned: those that a user names, or all that have a name."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from scenelang.backends.wording.readable import has_meaning, thing
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.ancestry import Ancestry, ancestry_of
from scenelang.interpreter.entity import Scene, primitive_count
from scenelang.interpreter.numbering import frame_numbers, instance_handles, number_scene

MOST = 100_000  # primitives of all frames
_MOST_HANDLES = 2_000  # of one word: each has a vector of its own in Z
_MOST_WORDS = 50  # learned together: a step takes each of them


@dataclass(frozen=True, slots=True)
class Target:
    """``handles`` of entities that one picture shows, and ``text``, what they are in words. ``whole``: the root is
    among them, whose embedding is the style of the scene."""

    text: str
    handles: tuple[str, ...]
    whole: bool

    @property
    def name(self) -> str:
        """The first handle, which stands for all."""
        return self.handles[0]


@dataclass(frozen=True, slots=True, eq=False)
class _Frame:
    ancestry: Ancestry
    handles: list[str]


def targets_named(scene: Scene, names: Sequence[str]) -> list[Target]:
    """The target of each name: a handle `<z4>`, a word, or words down to entities with
    slashes between, `tower/roof`, or places of children from the root, `0/2`.

    Raises SceneError("value") for a name that no entity has, LimitError for too large scenes.
    """
    frames = _frames(scene)
    return [_named(frames, name) for name in dict.fromkeys(names)]


def named_parts(scene: Scene) -> list[Target]:
    """One target for each word that says what primitives are: their own, else that of the nearest thing around them.

    The root is left out. Raises SceneError("value") where nothing is left, LimitError for too large scenes.
    """
    found: dict[str, list[tuple[_Frame, int]]] = {}
    for frame in _frames(scene):
        for primitive in frame.ancestry.primitives.tolist():
            chain = [i for i in _upward(frame.ancestry, primitive) if i]
            named = next((i for i in chain if has_meaning(frame.ancestry.entity(i).word)), chain[0] if chain else None)
            if named is not None:
                found.setdefault(frame.ancestry.entity(named).word, []).append((frame, named))
    if not found:
        raise SceneError("value", f'the scene "{scene.word}" has no parts whose embeddings could be learned')
    if len(found) > _MOST_WORDS:
        hint = "name some of them with --entity"
        raise LimitError("entities", f"the scene has {len(found):,} words, more than {_MOST_WORDS}", hint=hint)
    return [_target(instances) for instances in found.values()]


def style_handle(scene: Scene) -> str:
    """The handle of the root, which is the style of the scene."""
    return number_scene(scene).handle(scene.root, 0)


def _frames(scene: Scene) -> list[_Frame]:
    if sum(map(primitive_count, scene.frames)) > MOST:
        raise LimitError("primitives", f"the scene has more than the {MOST:,} primitives whose parts can be told apart")
    numbers = frame_numbers(scene) if len(scene.frames) > 1 else None
    ancestries = [ancestry_of(root) for root in scene.frames]
    return [_Frame(each, instance_handles(scene, each, numbers)) for each in ancestries]


def _named(frames: Sequence[_Frame], name: str) -> Target:
    if name.startswith("<"):
        found = [(f, i) for f in frames for i, handle in enumerate(f.handles) if f"<{handle}>" == name]
    else:
        found = [(f, i) for f in frames for i in _of_word(f.ancestry, name)]
        found = found or [(f, i) for f in frames for i in _at_path(f.ancestry, name)]
    if not found:
        called = f"handle {name}" if name.startswith("<") else f'word "{name}"'
        raise SceneError("value", f"no entity of the scene that is to be seen has the {called}")
    return _target(found)


def _of_word(ancestry: Ancestry, word: str) -> list[int]:
    return [i for i in range(len(ancestry)) if ancestry.entity(i).word == word]


def _at_path(ancestry: Ancestry, path: str) -> Iterator[int]:
    """The instance at places of children from the root, `0/2`; else those whose words, and those above, end in
    ``path``."""
    if all(part.isdecimal() for part in path.split("/")):
        places = tuple(map(int, path.split("/")))
        yield from (i for i in range(len(ancestry)) if ancestry.depth[i] == len(places) and ancestry.path(i) == places)
        return
    words = [word for word in path.split("/") if word][::-1]
    for i in _of_word(ancestry, words[0]) if words else ():
        above = [ancestry.entity(k).word for k in _upward(ancestry, i)]
        if above[: len(words)] == words:
            yield i


def _upward(ancestry: Ancestry, instance: int) -> Iterator[int]:
    """An instance and those around it, the root last."""
    while instance >= 0:
        yield instance
        instance = int(ancestry.parent[instance])


def _target(instances: Sequence[tuple[_Frame, int]]) -> Target:
    handles = tuple(dict.fromkeys(frame.handles[i] for frame, i in instances))
    frame, first = instances[0]
    entity = frame.ancestry.entity(first)
    if len(handles) > _MOST_HANDLES:
        message = f'"{entity.word}" has {len(handles):,} embeddings, more than {_MOST_HANDLES:,} that are stored alike'
        raise LimitError("entities", message, hint="name an entity around them, whose embedding is said of all in it")
    return Target(thing(entity), handles, any(i == 0 for _, i in instances))

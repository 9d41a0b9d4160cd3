"""Instances of a scene by path, such as ``chair/leg[2]``: where they are, scenes of parts, and other materials."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import frame_of
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.settings import fits, typed
from scenelang.interpreter.runtime.show import plain_attributes
from scenelang.interpreter.runtime.values import Embedding, Pair, Vector
from scenelang.interpreter.scene.bounds import parts_box
from scenelang.interpreter.scene.entity import Entity, descendants
from scenelang.interpreter.scene.instance_paths import Locator, part_of
from scenelang.interpreter.scene.primitives.base import color_of

if TYPE_CHECKING:
    from scenelang.grammar.datum import Span
    from scenelang.scene import Scene

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class SceneInstance:
    """An instance of a scene.

    Attributes
    ----------
    path
        The path that means this instance only, such as "chair[1]/leg[2]".
    handle
        Its handle, such as "z3".
    word
        Its word.
    pose : (4, 4) float64
        Its pose in the scene.
    box : (2, 3) float64 or None
        Its exact bounding box in the scene, low corner first; None without geometry.
    attributes
        The attributes of its embedding, as JSON data.
    entity
        The entity, which equal instances share.
    definition, place
        Where the program binds the word, and where it calls the instance, or its first primitive; None if unknown.
    """

    path: str
    handle: str
    word: str
    pose: FloatArray
    box: FloatArray | None
    attributes: dict[str, Any]
    entity: Entity
    definition: Span | None
    place: Span | None

    def data(self) -> dict[str, Any]:
        """Return the instance as JSON data."""
        box = None if self.box is None else self.box.tolist()
        data = {"path": self.path, "handle": self.handle, "word": self.word, "pose": self.pose[:3].tolist(), "box": box}
        if self.attributes:
            data["attributes"] = self.attributes
        for name, span in (("defined", self.definition), ("called", self.place)):
            if span is not None:
                data[name] = {"file": span.source.name, "line": span.source.position(span.start)[0]}
        return data

    def __repr__(self) -> str:
        return f"<SceneInstance {self.path}>"


@typed
def instances(self: Scene, path: str, frame: int = 0, limit: int = 20_000) -> list[SceneInstance]:
    """Return the instances that a path means, in the order of the tree.

    Parameters
    ----------
    path : str
        Words from the root down, such as ``chair/leg[2]``: every outermost instance of "chair", and in each the third
        "leg". ``<z3>`` is the instance with a handle, ``*`` every direct part; a backslash escapes a character.
    frame : int
        Frame of a 4D scene, counted from 0.
    limit : int
        Maximum number of instances to return.

    Raises
    ------
    SceneError
        If the path is malformed, or there is no such instance.

    Examples
    --------
    >>> import scenelang as sl
    >>> pair = '(bind "pair" (lambda () (for/union ((i 2)) (transform (call "cube") (translate [i 0 0])))))'
    >>> sl.evaluate(pair).instances("cube[1]")
    [<SceneInstance cube[1]>]
    """
    locator = Locator(self.graph, frame_of(self.graph, frame))
    words: Mapping[str, Span] = {} if self.program is None else self.program.words
    found = []
    for each in locator.find(path)[:limit]:
        pose = np.eye(4)
        pose[:3] = np.array(each.pose, np.float64).reshape(3, 4)
        box = parts_box((Pair(each.entity, each.pose),))
        found.append(
            SceneInstance(
                locator.path(each.positions),
                locator.handle(each.positions),
                each.entity.word,
                pose,
                None if box is None else np.array(box, np.float64).reshape(2, 3),
                plain_attributes(each.entity),
                each.entity,
                words.get(each.entity.word),
                next((span for entity in descendants(each.entity) for span in entity.call_sites[:1]), None),
            )
        )
    return found


@typed
def part(self: Scene, path: str) -> Scene:
    """Return the scene of the instances that a path means, where they are in this scene; see ``instances``.

    Examples
    --------
    >>> import scenelang as sl
    >>> pair = '(bind "pair" (lambda () (for/union ((i 2)) (transform (call "cube") (translate [i 0 0])))))'
    >>> sl.evaluate(pair).part("cube[1]").bounds[0].tolist()
    [0.5, -0.5, -0.5]
    """
    return replace(self, graph=part_of(self.graph, path), program=None)


# --- materials -------------------------------------------------------------------------------------------------------


def look_value(name: str, value: Any) -> Any:
    """Return the value of an attribute of a material from a plain Python value; raises SceneError."""
    if name == "color" and isinstance(value, str):
        from scenelang.stdlib.colors import color_of as named_color

        return named_color(value)
    if fits(value, "float"):
        return float(value)
    if isinstance(value, Sequence | np.ndarray) and all(fits(x, "float") for x in value):
        return Vector(float(x) for x in value)
    raise SceneError("value", f"`{name}`: expected a number or a vector, got {value!r}")


def restyled(entity: Entity, word: str, look: Mapping[str, Any], known: dict[tuple[int, bool], Entity]) -> Entity:
    """Copy the graph below ``entity`` and add the attributes ``look`` to everything at or below ``word``.

    Shared parts stay shared. Iterative, since deep graphs would exceed the recursion limit.
    """
    stack = [(entity, False)]
    while stack:
        top, inherited = stack[-1]
        inside = inherited or top.word == word
        if (id(top), inherited) in known:
            stack.pop()
            continue
        waiting = [(part.car, inside) for part in top.children if (id(part.car), inside) not in known]
        if waiting:
            stack.extend(waiting)
            continue
        stack.pop()
        children = tuple(Pair(known[id(part.car), inside], part.cdr) for part in top.children)
        known[id(top), inherited] = _copy(top, children, look if inside else {})
    return known[id(entity), False]


def _copy(entity: Entity, children: tuple[Any, ...], look: Mapping[str, Any]) -> Entity:
    own = entity.embedding
    embedding = Embedding(own.handle, own.text, {**own.attributes, **look}) if look else own
    shape = entity.shape
    if shape is not None and "color" in look:
        shape = replace(shape, color=color_of(entity.word, look["color"]))
    return Entity(entity.word, embedding, children, shape, entity.tainted, entity.call_sites)

"""Models of the game as the page draws them: parents merged, textures by their full names, every number checked.

The page trusts these numbers, so that what a resource pack may hold ends here: loops of parents or of textures, boxes
without end, values that are none.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from scenelang.backends.deepslate.layers import full_name
from scenelang.grammar.diagnostics import SceneError

Json = dict[str, Any]

_MOST_PARENTS = 32
_MOST_ELEMENTS = 2_000
_MOST_TEXTURES = 1_000
_FARTHEST = 1_000.0  # sixteenths of a block
_SIDES = ("down", "up", "north", "south", "west", "east")
_TURNS = (0, 90, 180, 270)
MISSING = "minecraft:missing"  # a texture that no layer has


def flat_model(name: str, model: Callable[[str], Any]) -> Json | None:
    """The model called ``name`` (full) without parents: ``{"elements": [...]}``, whose faces name their textures in
    full; None where no layer has it, or the ancestor with its boxes. Raises SceneError("file") for a model that is
    none."""
    textures: Json = {}
    elements: Any = None
    for ancestor in _line(name, model):
        if ancestor is None:
            if elements is None:
                return None
            break
        given = ancestor.get("textures", {})
        for key, value in given.items() if isinstance(given, Mapping) else ():
            textures.setdefault(key, value)
        elements = ancestor.get("elements") if elements is None else elements
    elements = elements or []
    if len(textures) > _MOST_TEXTURES or not isinstance(elements, list) or len(elements) > _MOST_ELEMENTS:
        raise _wrong(name)
    try:
        return {"elements": [_element(each, textures) for each in elements]}
    except (TypeError, ValueError, KeyError, AttributeError, IndexError):
        raise _wrong(name) from None


def turn(value: Any) -> int:
    """A rotation of a whole model or face in degrees; raises ValueError."""
    if value not in _TURNS:
        raise ValueError(value)
    return int(value)


def textures_of(model: Json) -> Iterator[str]:
    """The full names of the textures of a flat model."""
    for element in model["elements"]:
        for face in element["faces"].values():
            yield face["texture"]


def _wrong(name: str) -> SceneError:
    return SceneError("file", f"the model `{name}` of these textures is malformed")


def _line(name: str, model: Callable[[str], Any]) -> Iterator[Json | None]:
    """A model and its ancestors; None in place of one that no layer has."""
    wanted: str | None = name
    for _ in range(_MOST_PARENTS):
        if wanted is None:
            return
        found = model(wanted)
        if found is not None and not isinstance(found, dict):
            raise _wrong(name)
        yield found
        if found is None:
            return
        wanted = full_name(found.get("parent"))
    raise _wrong(name)


def _element(given: Json, textures: Json) -> Json:
    element: Json = {"from": _numbers(given["from"], 3), "to": _numbers(given["to"], 3)}
    element["faces"] = {side: _face(face, textures) for side, face in given["faces"].items() if side in _SIDES}
    if given.get("rotation"):
        element["rotation"] = _rotation(given["rotation"])
    return element


def _face(given: Json, textures: Json) -> Json:
    face: Json = {"texture": _texture(given["texture"], textures), "rotation": turn(given.get("rotation", 0))}
    if "uv" in given:
        face["uv"] = _numbers(given["uv"], 4)
    if given.get("cullface") in _SIDES:
        face["cullface"] = given["cullface"]
    if type(given.get("tintindex")) is int:
        face["tintindex"] = max(-1, min(given["tintindex"], 16))
    return face


def _texture(name: Any, textures: Json) -> str:
    for _ in range(_MOST_PARENTS):
        if isinstance(name, Mapping):
            name = name.get("sprite")
        if not isinstance(name, str):
            return MISSING
        key = name.removeprefix("#")
        if key not in textures:
            return MISSING if name.startswith("#") else full_name(name) or MISSING
        name = textures[key]
    return MISSING


def _rotation(given: Json) -> Json:
    """About one axis; of a rotation about several, the first."""
    axis, angle = given.get("axis"), given.get("angle", 0)
    if axis is None:
        axis, angle = next(((each, given[each]) for each in "xyz" if given.get(each)), ("y", 0))
    if axis not in ("x", "y", "z"):
        raise ValueError(axis)
    (angle,) = _numbers([angle], 1)
    origin = _numbers(given.get("origin", [8, 8, 8]), 3)
    return {"origin": origin, "axis": axis, "angle": angle, "rescale": given.get("rescale") is True}


def _numbers(given: Any, count: int) -> list[float]:
    numbers = [float(n) for n in given]
    if len(numbers) != count or not all(math.isfinite(n) and abs(n) <= _FARTHEST for n in numbers):
        raise ValueError(given)
    return numbers

"""The looks of a build's blocks: of every state its models, and all textures in one picture."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np

from scenelang.backends.deepslate.atlas import Atlas, Pixels, atlas_of, texture_from
from scenelang.backends.deepslate.layers import Layer, full_name, stacked
from scenelang.backends.deepslate.models import MISSING, Json, flat_model, textures_of, turn
from scenelang.backends.deepslate.places import HINT
from scenelang.backends.deepslate.plain import plain_model, plain_texture
from scenelang.backends.deepslate.water import WATER_TEXTURES, is_wet
from scenelang.backends.minecraft.blocks import AIR_STATE, BlockState
from scenelang.backends.minecraft.state_models import variants
from scenelang.backends.minecraft.table import load_table
from scenelang.grammar.diagnostics import Diagnostic, SceneError

_MOST_PARTS = 64  # models of one state
_MOST_NAMED = 8  # blocks in a warning
_PLAIN = "scenelang:plain"  # models and textures of what no layer draws; no layer is asked for these


@dataclass(frozen=True, slots=True)
class Look:
    """How a state is drawn: with ``parts``, models ``{"model": name, "x": degrees, "y": degrees}``; where
    ``is_special``, by deepslate itself, as chests are; where ``is_wet``, with water around it."""

    parts: tuple[Json, ...]
    is_special: bool = False
    is_wet: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Looks:
    """``states[n]`` is the look of state ``n`` of the palette; ``models`` by name, without parents. ``plain`` are the
    blocks that no layer draws: boxes of their average colour."""

    states: tuple[Look, ...]
    models: dict[str, Json]
    atlas: Atlas
    plain: tuple[str, ...]

    @property
    def warnings(self) -> tuple[Diagnostic, ...]:
        """The one that names ``plain``, where there are some."""
        if not self.plain:
            return ()
        more = ", .." if len(self.plain) > _MOST_NAMED else ""
        shown = ", ".join(f"`{name}`" for name in self.plain[:_MOST_NAMED]) + more
        message = f"the looks have no model, or not all of it, for: {shown}; drawn as boxes of their average colour"
        hint = "if they are a resource pack, install the game too: what a pack leaves out is taken from there"
        return (Diagnostic("plain-look", message, hint=hint),)


def looks_of(palette: Sequence[BlockState], layers: Sequence[Layer]) -> Looks:
    """How ``layers``, the first first, show the states of ``palette``.

    Raises SceneError("file") for looks that cannot be read, or where the layers have none of these blocks.
    """
    layer = stacked(layers)
    _check(palette, layer)
    models: dict[str, Json] = {}
    textures = {MISSING: _checkered()}
    looks, plain = [], set()
    for number, state in enumerate(palette):
        look = _look(state, layer, models)
        if look is None:
            name = f"{_PLAIN}/{number}"
            models[name], textures[name] = plain_model(state, name), plain_texture(state)
            look = Look(({"model": name, "x": 0, "y": 0},), is_wet=is_wet(state))
            plain.add(state.name)
        looks.append(look)
    textures |= _textures(_wanted(palette, looks, models) - textures.keys(), layer)
    return Looks(tuple(looks), models, atlas_of(textures), tuple(sorted(plain)))


def _check(palette: Sequence[BlockState], layer: Layer) -> None:
    """Raise SceneError where ``layer`` has none of the blocks."""
    names = sorted({state.name for state in palette} - {AIR_STATE.name})
    if names and all(layer.definition(name) is None for name in names):
        raise SceneError("file", f"{layer.name} has none of the build's blocks ({names[0]})", hint=HINT)


def _look(state: BlockState, layer: Layer, models: dict[str, Json]) -> Look | None:
    """The look of a state, its models added to ``models``; None where the layer does not draw it."""
    parts = _parts(state, layer)
    found = {part["model"]: flat_model(part["model"], layer.model) for part in parts or ()}
    is_special = any(layer.picture(name) is not None for name in _special(state))
    if not (is_special or _is_unseen(state) or _is_whole(found, state, layer)):
        return None
    models |= {name: model for name, model in found.items() if model is not None}
    return Look(tuple(part for part in parts or () if part["model"] in models), is_special, is_wet(state))


def _is_unseen(state: BlockState) -> bool:
    """True for air, barriers and the like."""
    return load_table().blocks[state.name].color is None


def _is_whole(found: Mapping[str, Json | None], state: BlockState, layer: Layer) -> bool:
    """True where no model is missing and there is something to draw; or nothing for this state alone, as for the upper
    half of a young plant."""
    if None in found.values():
        return False
    others = (part["model"] for part in _parts(state, layer, every=True) or ())
    models = (*found.values(), *(flat_model(name, layer.model) for name in dict.fromkeys(others)))
    return any(model is not None and model["elements"] for model in models)


def _parts(state: BlockState, layer: Layer, every: bool = False) -> tuple[Json, ...] | None:
    """The models of a state, of all states of its block where ``every``; None where the layer does not have it."""
    definition = layer.definition(state.name)
    if definition is None:
        return None
    try:
        found = [_part(variant) for variant in variants(definition, dict(state.properties), every)]
    except (TypeError, ValueError, KeyError, AttributeError, IndexError, RecursionError):
        raise SceneError("file", f"the definition of `{state.name}` in these textures is malformed") from None
    return tuple(found[:_MOST_PARTS])


def _part(variant: Any) -> Json:
    name = full_name(variant["model"])
    if name is None:
        raise ValueError(variant["model"])
    return {"model": name, "x": turn(variant.get("x", 0)), "y": turn(variant.get("y", 0))}


@cache
def _special_textures() -> dict[str, list[str]]:
    """The textures of what deepslate draws without a model (chests, signs, beds), by block."""
    text = files(__package__).joinpath("static", "special.json").read_text("utf-8")
    return dict(json.loads(text))


def _special(state: BlockState) -> frozenset[str]:
    """The textures with which deepslate draws a state by itself, without the water around it."""
    own = frozenset(_special_textures().get(state.name, ()))
    return own - frozenset(WATER_TEXTURES) if is_wet(state) else own


# --- textures ------------------------------------------------------------------------------------------------------


def _wanted(palette: Sequence[BlockState], looks: Sequence[Look], models: Mapping[str, Json]) -> set[str]:
    """The full names of all textures."""
    wanted = {name for model in models.values() for name in textures_of(model)}
    for state, look in zip(palette, looks, strict=True):
        wanted |= _special(state) if look.is_special else set()
        wanted |= set(WATER_TEXTURES) if look.is_wet else set()
    return wanted


def _textures(names: Iterable[str], layer: Layer) -> dict[str, Pixels]:
    """Those that the layer has."""
    pictures = ((name, layer.picture(name)) for name in sorted(names))
    return {name: texture_from(png, name) for name, png in pictures if png is not None}


def _checkered() -> Pixels:
    """What the game shows for a texture that is not there."""
    squares = (np.indices((16, 16)) // 8).sum(axis=0) % 2
    return np.asarray(np.array([[248, 0, 248, 255], [0, 0, 0, 255]])[squares], np.uint8)

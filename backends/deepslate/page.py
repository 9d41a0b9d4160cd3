"""The page of a build: one HTML text that needs no server and loads nothing."""

from __future__ import annotations

import base64
import gzip
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.camera import Camera
from scenelang.backends.deepslate.builds import Builds, builds_of
from scenelang.backends.deepslate.looks import Looks, looks_of
from scenelang.backends.deepslate.places import layers_for
from scenelang.backends.deepslate.water import WATER_TEXTURES
from scenelang.backends.shots import box_of
from scenelang.backends.stage import BELOW, unit_size
from scenelang.backends.studio import Studio, film, studio_for, to_srgb
from scenelang.backends.viewer.page import inlined
from scenelang.backends.viewpoint import Viewpoint, place
from scenelang.grammar.diagnostics import Diagnostic
from scenelang.interpreter.entity import Scene

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """What builds stand in: ``center`` (3,) and ``scale`` bring the scene to unit size, ``lowest`` is its lowest point,
    all in the program's units; ``environment`` and ``ground`` are names of ``studio``."""

    center: FloatArray
    scale: float
    lowest: float
    environment: str = "studio"
    ground: str | None = None


@dataclass(frozen=True, slots=True)
class SavedPage:
    """A page as HTML, and what the scene has that it does not show as asked."""

    text: str
    warnings: tuple[Diagnostic, ...]


def page_of_scene(scene: Scene, textures: str = "", limit: int = 2_000_000) -> SavedPage:
    """The page of all frames of ``scene`` with the looks at ``textures`` (empty: where they usually are).

    Raises SceneError: for a scene without blocks, for poses that blocks cannot have, and where there are no looks.
    """
    layers = layers_for(textures)  # looked for first: a build may take long
    builds = builds_of(dict(enumerate(scene.frames)), limit)
    looks = looks_of(builds.palette, layers)
    low, high = box_of(scene)
    around = Surroundings(*unit_size(scene), float(low[1]))
    text = page_of(scene.word, builds, looks, around, place(Viewpoint(), low, high, 512, 512))
    return SavedPage(text, (*builds.warnings, *looks.warnings))


def page_of(name: str, builds: Builds, looks: Looks, around: Surroundings, camera: Camera) -> str:
    """The page that shows all frames of ``builds``; ``camera`` is where any of its pictures is taken from."""
    studio = studio_for(camera.rescaled(around.center, around.scale), around.environment, around.ground)
    data = _data(name, builds, looks, around, studio)
    return inlined(_text("page.html"), _text("page.js"), _text("page.css"), "build", data)


@cache
def _text(name: str) -> str:
    return files(__package__).joinpath("static", name).read_text("utf-8")


def _data(name: str, builds: Builds, looks: Looks, around: Surroundings, studio: Studio) -> dict[str, Any]:
    low, high = builds.box
    has_water = all(name in looks.atlas.places for name in WATER_TEXTURES)
    states = [
        {
            "name": state.name,
            "properties": dict(state.properties),
            "parts": list(look.parts),
            "isSpecial": look.is_special,
            "isWet": look.is_wet and has_water,
        }
        for state, look in zip(builds.palette, looks.states, strict=True)
    ]
    distinct = {id(seen): seen for seen in builds.frames.values()}
    numbers = {key: i for i, key in enumerate(distinct)}
    planes = [
        plane.astype("<i4").tobytes() if plane.dtype == np.int32 else plane.astype("<u4").tobytes()
        for seen in distinct.values()
        for plane in (*seen.cells, seen.states, seen.around)
    ]
    return {
        "name": name,
        "states": states,
        "models": looks.models,
        "atlas": _atlas(looks),
        "corner": list(builds.corner),
        "box": {
            "low": list(low),
            "high": list(high),
            "center": (around.center - np.array(builds.corner)).tolist(),
            "scale": around.scale,
        },
        "studio": _studio(studio, around),
        "counts": [len(seen.states) for seen in distinct.values()],
        "frames": {str(number): numbers[id(seen)] for number, seen in builds.frames.items()},
        "cells": base64.b64encode(gzip.compress(b"".join(planes), 6, mtime=0)).decode(),
    }


def _atlas(looks: Looks) -> dict[str, Any]:
    atlas = looks.atlas
    return {
        "image": "data:image/png;base64," + base64.b64encode(atlas.png).decode(),
        "side": atlas.side,
        "places": dict(atlas.places),
        "translucent": sorted(atlas.translucent),
    }


def _studio(studio: Studio, around: Surroundings) -> Mapping[str, Sequence[Any] | float | None]:
    """The surroundings as colours: sRGB of what lies behind and below, linear light on what faces up."""
    environment = studio.environment
    light = np.array(environment.ambient) + np.array(environment.key) * studio.key_direction[1]
    ground = None if studio.ground is None else to_srgb(film(studio.ground * light, environment)).tolist()
    return {
        "backdrop": to_srgb(film(np.array(environment.backdrop), environment)).tolist(),
        "ground": ground,
        "height": float(around.lowest - around.center[1]) * around.scale - BELOW,
        "light": light.tolist(),
    }

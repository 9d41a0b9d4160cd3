"""Options of a picture that its scene decides: what the program declares, and the environment of one that names none.

Matte objects show their shape by their own shading, polished metal and glass by what they reflect and refract: large
lights with dark between them. So a scene of which enough is polished has ``softboxes`` in place of the usual studio.
Both light a surface that faces upwards alike, by the sky and by the key light.

It is chosen by one view of the first frame: that of the program's first camera, else the default one. So all images of
a scene have the same light, whatever camera they have.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.pictures.declared import Lighting, ProgramView, setting_of
from scenelang.backends.pictures.rays import camera_rays, caster_for, ids_of
from scenelang.backends.pictures.stage import staging_of, still
from scenelang.backends.surfaces.appearance import Looks
from scenelang.backends.surfaces.environments import SKY, USUAL, environment_of
from scenelang.backends.surfaces.lights import light_track
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.scene.entity import Scene, descendants, primitive_count
from scenelang.interpreter.scene.setup import ENVIRONMENT, LIGHT, Declared, named

if TYPE_CHECKING:
    from scenelang.backends.pictures.film import PictureOptions

POLISHED = "softboxes"
_LEAST_SHARE = 1.0 / 3.0  # of what is seen of the objects; with less, metal is one material of several
_MAX_GLOSS = 0.4  # roughness up to which a surface reflects shapes; metal without one has .35
_SIZE = 96, 72  # pixels of the view: a share is then precise to some percent
_SIZE_IN_BROWSER = 24, 18  # where arrays are Python's lists: the larger view took 1 to 3 s at each evaluation
_MAX_PRIMITIVES = 50_000  # primitives of a scene that is examined: more would take as long as a small image
# Share of the environment's light in a program with lights and no environment: the shadows of its lights stay readable,
# and what they do not reach is not black.
_AMBIENT_BESIDE_LIGHTS = 0.1
_POLISHING = ("material", "metallic", "ior")  # attributes without which nothing is metal or glass


def environment_for(scene: Scene) -> str:
    """Return the name of the environment of a scene that names none.

    A scene without metal and glass is not looked at. Neither is one that cannot be drawn: its image says why.
    """
    root = scene.frames[0]
    if primitive_count(root) > _MAX_PRIMITIVES or not _may_be_polished(scene):
        return USUAL
    try:
        return POLISHED if _polished_share(scene) >= _LEAST_SHARE else USUAL
    except (SceneError, LimitError):
        return USUAL


def _may_be_polished(scene: Scene) -> bool:
    """Return whether a primitive of the first frame has an attribute by which it may be metal or glass."""
    return any(
        any(entity.embedding.attributes.get(name) is not None for name in _POLISHING)
        for entity in descendants(scene.frames[0])
        if entity.is_primitive
    )


def _polished_share(scene: Scene) -> float:
    """Return the share of polished metal and glass in what is seen of the objects; raises SceneError and LimitError."""
    shot = still(scene, ProgramView(), 0, *(_SIZE_IN_BROWSER if sys.platform == "emscripten" else _SIZE))
    stage = staging_of(scene, [0], _MAX_PRIMITIVES, ground="none").stage(shot)
    solids = stage.solids
    seen = ids_of(caster_for(solids, camera_rays(stage.camera, 1)).cast(solids.opacity > 0.0))
    seen = seen[seen >= 0]
    return float(_polished(solids.looks)[solids.look[seen]].mean()) if len(seen) else 0.0


def _polished(looks: Looks) -> npt.NDArray[np.bool_]:
    """Return which materials (K,) are polished metal or glass."""
    return np.asarray(((looks.metallic >= 0.5) | looks.refractive) & (looks.gloss <= _MAX_GLOSS), bool)


def _environment(item: Declared) -> str:
    """Return the environment that a program declares, as options name it; raises SceneError."""
    given = [f"{key}={item.values[key]:.17g}" for key in ("hour", "haze") if key in item.values]
    if given and item.name != SKY:
        raise SceneError(
            "value", f'the environment "{item.name}" has no hour and no haze', 'they are those of "sky"', item.span
        )
    text = ",".join([item.name, *given])
    try:
        environment_of(text)
    except SceneError as error:
        raise SceneError(error.name, error.message, error.hint, item.span) from None
    return text


def settled(scene: Scene, options: PictureOptions) -> PictureOptions:
    """Return options of a picture with what the program declares in place of those that the user did not state.

    Where neither names an environment, the scene chooses it. Raises SceneError for a light that looks at nothing.
    """
    if options.stated is None:
        return options
    changes: dict[str, Any] = {"stated": None}
    is_free = "environment" not in options.stated and options.environment == USUAL
    if is_free and not named(scene.setup, ENVIRONMENT) and not named(scene.setup, LIGHT):
        changes["environment"] = environment_for(scene)
    if not scene.setup:
        return replace(options, **changes)
    size, ground, samples = (setting_of(scene, key) for key in ("size", "ground", "samples"))
    if size is not None and "size" not in options.stated:
        changes |= {"width": size[0], "height": size[1]}
    if ground is not None and "ground" not in options.stated:
        changes["ground"] = ground
    if samples is not None and "samples" not in options.settings:
        changes["settings"] = {**options.settings, "samples": samples}
    environment = next(iter(named(scene.setup, ENVIRONMENT)), None) if "environment" not in options.stated else None
    if environment is not None:
        changes["environment"] = _environment(environment)
    track = light_track(scene)
    (_, lights), *later = track
    is_lit_alone = bool(lights) and environment is None and "environment" not in options.stated
    values = environment.values if environment is not None else {}
    changes["lighting"] = Lighting(
        lights, values.get("strength", _AMBIENT_BESIDE_LIGHTS if is_lit_alone else 1.0), values.get("turn"),
        setting_of(scene, "exposure") or 0.0, not is_lit_alone, track=track if later else (),
    )  # fmt: skip
    return replace(options, **changes)

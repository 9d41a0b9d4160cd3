"""The environment of a scene that names none, chosen by what the scene is made of.

Matte objects show their shape by their own shading, polished metal and glass by what they reflect and refract: large
lights with dark between them. So a scene of which enough is polished has ``softboxes`` in place of the usual studio.
Both light a surface that faces upwards alike, by the sky and by the key light.

It is chosen by one view of the first frame: that of the program's first camera, else the default one. So all images of
a scene have the same light, whatever camera they have.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from scenelang.backends.pictures.declared import ProgramView
from scenelang.backends.pictures.rays import camera_rays, caster_for, ids_of
from scenelang.backends.pictures.stage import staging_of, still
from scenelang.backends.surfaces.appearance import Looks
from scenelang.backends.surfaces.environments import USUAL
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.scene.entity import Scene, descendants, primitive_count

POLISHED = "softboxes"
_ENOUGH = 1.0 / 3.0  # of what is seen of the objects: beside as much that is matte, metal is one thing of several
_MAX_GLOSS = 0.4  # roughness up to which a surface reflects shapes; metal without one has .35
_SIZE = 96, 72  # pixels of the view: a share is then precise to some percent
_MOST = 50_000  # primitives of a scene that is looked at: of more, it would take as long as a small image
_POLISHING = ("material", "metallic", "ior")  # attributes without which nothing is metal or glass


def environment_for(scene: Scene) -> str:
    """Return the name of the environment of a scene that names none.

    A scene without metal and glass is not looked at. Neither is one that cannot be drawn: its image says why.
    """
    root = scene.frames[0]
    if primitive_count(root) > _MOST or not _may_be_polished(scene):
        return USUAL
    try:
        return POLISHED if _polished_share(scene) >= _ENOUGH else USUAL
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
    shot = still(scene, ProgramView(), 0, *_SIZE)
    stage = staging_of(scene, [0], _MOST, ground="none").stage(shot)
    solids = stage.solids
    seen = ids_of(caster_for(solids, camera_rays(stage.camera, 1)).cast(solids.opacity > 0.0))
    seen = seen[seen >= 0]
    return float(_polished(solids.looks)[solids.look[seen]].mean()) if len(seen) else 0.0


def _polished(looks: Looks) -> npt.NDArray[np.bool_]:
    """Return which materials (K,) are polished metal or glass."""
    return np.asarray(((looks.metallic >= 0.5) | looks.refractive) & (looks.gloss <= _MAX_GLOSS), bool)

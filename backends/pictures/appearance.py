"""Surface appearance: the material of a primitive, derived from its word and attributes, for geometric backends.

``:color`` is the reflectance in linear sRGB; ``:roughness`` from 0 (polished) to 1, matte if absent; ``:metallic`` from
0 to 1; ``:opacity`` from 0 (transparent) to 1; ``:emission`` the emitted radiance, one number (multiplied by the
colour) or three; ``:ior`` the index of refraction: the surface is glossy, and light transmitted by its ``:opacity`` is
refracted, as by glass.
"""

from __future__ import annotations

import colorsys
import hashlib
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.pictures.studio import from_srgb
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene import primitives
from scenelang.interpreter.scene.entity import Entity, Scene, descendants
from scenelang.interpreter.scene.primitives import items_of

FloatArray = npt.NDArray[np.float64]
Point = tuple[float, float, float]

GLASS = 1.5  # index of refraction of a glossy surface without `:ior`
_HIGHEST_IOR = 4.0

# One-line descriptions of the material attributes; `:color` belongs to the shape.
MATERIALS: Mapping[str, str] = MappingProxyType({attribute.name: attribute.doc for attribute in primitives.MATERIALS})
READ = tuple(MATERIALS)


@dataclass(frozen=True, slots=True)
class Look:
    """Material of a surface.

    ``color`` and ``emission`` (radiance) are linear sRGB; see the module's docstring for the others. ``roughness`` None
    means matte, ``ior`` None means not refractive.
    """

    color: Point
    emission: Point = (0.0, 0.0, 0.0)
    opacity: float = 1.0
    roughness: float | None = None
    metallic: float = 0.0
    ior: float | None = None

    @property
    def is_matte(self) -> bool:
        """Whether the surface is Lambertian: no highlights, no reflections."""
        return self.roughness is None and self.metallic == 0.0 and self.ior is None

    @property
    def gloss(self) -> float:
        """Roughness of the reflecting layer; if not given, a default for glass, metal or diffuse surfaces."""
        if self.roughness is not None:
            return self.roughness
        return 0.05 if self.ior is not None else 0.35 if self.metallic > 0.0 else 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Looks:
    """The columns of K materials (structure of arrays)."""

    rows: tuple[Look, ...]
    color: FloatArray  # (K, 3)
    emission: FloatArray  # (K, 3)
    opacity: FloatArray  # (K,)
    matte: npt.NDArray[np.bool_]  # (K,)
    gloss: FloatArray  # (K,)
    metallic: FloatArray  # (K,)
    ior: FloatArray  # (K,), that of glass where not given


def looks_of(rows: Iterable[Look]) -> Looks:
    """Return ``rows`` as columns."""
    rows = tuple(rows)
    count = len(rows)
    return Looks(
        rows,
        np.array([look.color for look in rows], np.float64).reshape(count, 3),
        np.array([look.emission for look in rows], np.float64).reshape(count, 3),
        np.array([look.opacity for look in rows], np.float64),
        np.array([look.is_matte for look in rows], bool),
        np.array([look.gloss for look in rows], np.float64),
        np.array([look.metallic for look in rows], np.float64),
        np.array([look.ior or GLASS for look in rows], np.float64),
    )


def look_of(entity: Entity) -> Look:
    """Return the material given by a primitive's attributes; raises SceneError("attribute") if one is invalid.

    Semantic primitives and blocks without ``:color`` get a stable tint derived from their word or block type.
    """
    attributes, shape = entity.embedding.attributes, entity.shape
    color = shape.color if shape is not None else (1.0, 1.0, 1.0)
    if attributes.get("color") is None and shape is not None:
        chosen = shape.color_seed(entity.word, attributes)
        color = color if chosen is None else tint(*chosen)
    given = {name: value for name in READ if (value := attributes.get(name)) is not None}
    if not given:
        return Look(color)
    emission = _numbers_in(entity.word, "emission", given.get("emission"), (1, 3), (0.0, 0.0, 0.0))
    if len(emission) == 1:
        emission = tuple(emission[0] * channel for channel in color)
    red, green, blue = (max(0.0, channel) for channel in emission)
    opacity = _share(entity.word, "opacity", given.get("opacity"))
    metallic = _share(entity.word, "metallic", given.get("metallic"))
    return Look(
        color,
        (red, green, blue),
        1.0 if opacity is None else opacity,
        _share(entity.word, "roughness", given.get("roughness")),
        metallic or 0.0,
        _ior(entity.word, given.get("ior")),
    )


def check_seen(scene: Scene) -> None:
    """Raise SceneError("empty-scene") if all geometry of the scene has ``:opacity 0``."""
    solid = (e for e in descendants(*scene.frames) if e.shape is not None and e.shape.has_geometry)
    if not any(look_of(entity).opacity > 0.0 for entity in solid):
        message = f'the scene "{scene.word}" is invisible: all of it has `:opacity 0`'
        raise SceneError("empty-scene", message)


def _share(word: str, name: str, value: Any) -> float | None:
    """Return ``value`` clipped to [0, 1], or None if it is not given."""
    return None if value is None else min(1.0, max(0.0, _numbers_in(word, name, value, (1,), (0.0,))[0]))


def _ior(word: str, value: Any) -> float | None:
    if value is None:
        return None
    (ior,) = _numbers_in(word, "ior", value, (1,), (GLASS,))
    if not 1.0 <= ior <= _HIGHEST_IOR:
        raise SceneError("attribute", f'the attribute `:ior` of "{word}" must be from 1 to {_HIGHEST_IOR:g}')
    return ior


def tint(text: str, saturation: float, value: float) -> Point:
    """Return a stable colour (linear sRGB) for ``text``: a hashed hue with the given HSV saturation and value."""
    hue = int.from_bytes(hashlib.blake2s(text.encode("utf-8", "surrogatepass"), digest_size=4).digest(), "big") / 2**32
    red, green, blue = from_srgb(np.array(colorsys.hsv_to_rgb(hue, saturation, value))).tolist()
    return (red, green, blue)


def _numbers_in(
    word: str, name: str, value: Any, lengths: Iterable[int], default: tuple[float, ...]
) -> tuple[float, ...]:
    """Return the attribute ``value`` as a tuple of finite floats whose length is one of ``lengths``."""
    if value is None:
        return default
    if type(value) in (int, float) and 1 in lengths and math.isfinite(value):
        return (float(value),)
    listed = items_of(value)
    numbers = (value,) if listed is None else listed
    try:
        floats = tuple(float(number) for number in numbers)
    except (TypeError, ValueError, OverflowError):
        floats = ()
    if len(floats) not in tuple(lengths) or not np.isfinite(floats).all() or any(isinstance(n, str) for n in numbers):
        expected = " or ".join("a number" if length == 1 else f"{length} numbers" for length in lengths)
        raise SceneError("attribute", f'the attribute `:{name}` of "{word}" must be {expected}')
    return floats

"""Appearance: the materials of primitives, derived from their words and attributes.

``:color`` is the reflectance in linear sRGB, of metals at normal incidence; ``:roughness`` from 0 (polished) to 1,
matte if absent; ``:metallic`` from 0 to 1; ``:opacity`` from 0 (transparent) to 1; ``:emission`` the emitted radiance,
one number (multiplied by the color) or three; ``:ior`` the index of refraction: the surface is glossy, and light
transmitted by its ``:opacity`` is refracted, as by glass; ``:coat`` from 0 to 1 a varnish, ``:sheen`` from 0 to 1 the
bright rim of fabric. ``:material`` names a substance (``primitives/substances``), which sets what the other attributes
do not set.
"""

from __future__ import annotations

import colorsys
import hashlib
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.surfaces.image_files import encode, from_srgb
from scenelang.backends.surfaces.tiles import tile_of
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene import primitives
from scenelang.interpreter.scene.entity import Entity, Scene, descendants
from scenelang.interpreter.scene.primitives import items_of
from scenelang.interpreter.scene.primitives.base import WHITE
from scenelang.interpreter.scene.primitives.substances import SUBSTANCES, Substance
from scenelang.interpreter.scene.primitives.textures import PATTERNS, SIDES, Texture
from scenelang.interpreter.values.values import IDENTITY

FloatArray = npt.NDArray[np.float64]
AnyFloats = npt.NDArray[np.floating]
Color = tuple[float, float, float]
Point = tuple[float, float, float]

GLASS = 1.5  # index of refraction of a glossy surface without `:ior`
_MAX_IOR = 4.0  # highest accepted index of refraction
# Gloss of surfaces without `:roughness`: glass is polished, metal satin.
_GLASS_ROUGHNESS, _METAL_ROUGHNESS = 0.05, 0.35

# One-line descriptions of the material attributes; `:color` belongs to the shape.
MATERIALS: Mapping[str, str] = MappingProxyType({attribute.name: attribute.doc for attribute in primitives.MATERIALS})
READ = tuple(MATERIALS)
_DECAL_SHARE = 0.6  # width of a decal, as a share of the shorter extent of its side
_OF_SUBSTANCES = ("roughness", "metallic", "ior", "opacity", "coat", "sheen")  # attributes that a substance sets


@dataclass(frozen=True, slots=True)
class Look:
    """Material of a surface.

    ``color`` and ``emission`` (radiance) are linear sRGB; see the module's docstring for the others. ``roughness`` None
    means matte, ``ior`` None means not refractive. ``material`` is the name of a substance, which exports show.
    With a ``texture``, ``color`` is its mean.
    """

    color: Point
    emission: Point = (0.0, 0.0, 0.0)
    opacity: float = 1.0
    roughness: float | None = None
    metallic: float = 0.0
    ior: float | None = None
    coat: float = 0.0
    sheen: float = 0.0
    material: str | None = None
    texture: Texture | None = None

    @property
    def is_matte(self) -> bool:
        """Whether the surface is Lambertian: no highlights, no reflections."""
        return self.is_diffuse and self.coat == self.sheen == 0.0

    @property
    def is_diffuse(self) -> bool:
        """Whether the surface below its coat and its sheen is Lambertian."""
        return self.roughness is None and self.metallic == 0.0 and self.ior is None

    @property
    def gloss(self) -> float:
        """Roughness of the reflecting layer; if not given, a default for glass, metal or diffuse surfaces."""
        if self.roughness is not None:
            return self.roughness
        return _GLASS_ROUGHNESS if self.ior is not None else _METAL_ROUGHNESS if self.metallic > 0.0 else 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Looks:
    """The columns of K materials (structure of arrays)."""

    rows: tuple[Look, ...]
    color: FloatArray  # (K, 3)
    emission: FloatArray  # (K, 3)
    opacity: FloatArray  # (K,)
    matte: npt.NDArray[np.bool_]  # (K,)
    diffuse: npt.NDArray[np.bool_]  # (K,)
    gloss: FloatArray  # (K,)
    metallic: FloatArray  # (K,)
    ior: FloatArray  # (K,), that of glass where not given
    textured: npt.NDArray[np.bool_]  # (K,)
    refractive: npt.NDArray[np.bool_]  # (K,)
    coat: FloatArray  # (K,)
    sheen: FloatArray  # (K,)


def looks_of(rows: Iterable[Look]) -> Looks:
    """Return materials as the columns of a table: an array for each property, with a row for each material."""
    rows = tuple(rows)
    count = len(rows)
    return Looks(
        rows,
        np.array([look.color for look in rows], np.float64).reshape(count, 3),
        np.array([look.emission for look in rows], np.float64).reshape(count, 3),
        np.array([look.opacity for look in rows], np.float64),
        np.array([look.is_matte for look in rows], bool),
        np.array([look.is_diffuse for look in rows], bool),
        np.array([look.gloss for look in rows], np.float64),
        np.array([look.metallic for look in rows], np.float64),
        np.array([look.ior or GLASS for look in rows], np.float64),  # renderers need one for every glossy surface
        np.array([look.texture is not None for look in rows], bool),
        np.array([look.ior is not None and look.opacity < 1.0 for look in rows], bool),
        np.array([look.coat for look in rows], np.float64),
        np.array([look.sheen for look in rows], np.float64),
    )


def look_of(entity: Entity) -> Look:
    """Return the material given by a primitive's attributes; raises SceneError("attribute") if one is invalid.

    Semantic primitives and blocks without ``:color`` get a stable tint derived from their word or block type.
    """
    attributes, shape = entity.embedding.attributes, entity.shape
    substance = _substance(entity.word, attributes.get("material"))
    color = shape.color if shape is not None else (1.0, 1.0, 1.0)
    if attributes.get("color") is None and shape is not None and substance is None:
        chosen = shape.color_seed(entity.word, attributes)
        color = color if chosen is None else tint(*chosen)
    if attributes.get("color") is None and substance is not None:
        color = substance.color
    values = {name: value for name in READ if (value := attributes.get(name)) is not None}
    texture = None if shape is None else shape.own_texture
    if not values and texture is None:
        return Look(color)
    if values.get("texture") is not None:
        texture = _texture(entity, values["texture"])
    if texture is not None:
        color = tile_of(texture).mean
    if substance is not None:
        values = {name: getattr(substance, name) for name in _OF_SUBSTANCES} | values
    emission = _numbers_in(entity.word, "emission", values.get("emission"), (1, 3), (0.0, 0.0, 0.0))
    if len(emission) == 1:
        emission = tuple(emission[0] * channel for channel in color)
    red, green, blue = (max(0.0, channel) for channel in emission)
    opacity = _share(entity.word, "opacity", values.get("opacity"))
    metallic = _share(entity.word, "metallic", values.get("metallic"))
    return Look(
        color,
        (red, green, blue),
        1.0 if opacity is None else opacity,
        _share(entity.word, "roughness", values.get("roughness")),
        metallic or 0.0,
        _ior(entity.word, values.get("ior")),
        _share(entity.word, "coat", values.get("coat")) or 0.0,
        _share(entity.word, "sheen", values.get("sheen")) or 0.0,
        None if substance is None else attributes["material"],
        texture,
    )


def _texture(entity: Entity, value: Any) -> Texture | None:
    """Return the texture of a primitive with its colors and its scale; None for an entity without a surface."""
    shape = entity.shape
    if shape is None:
        return None
    texture = primitives.texture_of(entity.word, "texture", value)
    box = shape.box_under(IDENTITY)
    lengths = [1.0] * 3 if box is None else [high - low for low, high in zip(box[:3], box[3:], strict=True)]
    size = max(lengths) or 1.0
    if texture.side:
        axis, _ = SIDES[texture.side]
        size = _DECAL_SHARE * (min(lengths[:axis] + lengths[axis + 1 :]) or size)
    if texture.projection == "uv":
        if not shape.is_file:
            message = f'the attribute `:texture` of "{entity.word}" has the projection uv, which only mesh files have'
            raise SceneError("attribute", message, "leave `:projection` out, or write box, cylindrical or spherical")
        size = 1.0 if texture.is_image else 1.0 / PATTERNS[texture.name].share
    is_colored = shape.color != WHITE
    if texture.is_image:
        colors: tuple[Point, ...] = (shape.color,) if is_colored else ()
        name, scale = shape.image or texture.name, size
    else:
        pattern = PATTERNS[texture.name]
        own = pattern.colors_on(shape.color) if is_colored else pattern.colors
        colors, name, scale = texture.colors or own, texture.name, size * pattern.share
    return replace(texture, name=name, scale=texture.scale or scale, colors=colors)


def _substance(word: str, name: Any) -> Substance | None:
    """Return the substance of a ``:material``, None without one; raises SceneError("attribute")."""
    return None if name is None else SUBSTANCES[primitives.material_of(word, "material", name)]


def material_name(look: Look) -> str:
    """Return a name for a look: its substance or texture, else its color as ``#rrggbb``."""
    if look.material is not None:
        return look.material
    if look.texture is not None:
        return Path(look.texture.name).stem
    return "#" + bytes(encode(np.array(look.color)).tolist()).hex()


def check_seen(scene: Scene) -> None:
    """Raise SceneError("empty-scene") if all geometry of a scene has ``:opacity 0``."""
    solid = (e for e in descendants(*scene.frames) if e.shape is not None and e.shape.has_geometry)
    if not any(look_of(entity).opacity > 0.0 for entity in solid):
        message = f'the scene "{scene.word}" is invisible: all of it has `:opacity 0`'
        raise SceneError("empty-scene", message)


def _share(word: str, name: str, value: Any) -> float | None:
    """Return ``value`` clipped to [0, 1], or None if it is not given."""
    return None if value is None else min(1.0, max(0.0, _numbers_in(word, name, value, (1,), (0.0,))[0]))


def _ior(word: str, value: Any) -> float | None:
    """Validate an index of refraction; None if it is not given."""
    if value is None:
        return None
    (ior,) = _numbers_in(word, "ior", value, (1,), (GLASS,))
    if not 1.0 <= ior <= _MAX_IOR:
        raise SceneError("attribute", f'the attribute `:ior` of "{word}" must be from 1 to {_MAX_IOR:g}')
    return ior


def tint(text: str, saturation: float, value: float) -> Point:
    """Return a stable color (linear sRGB) for ``text``: a hashed hue with the given HSV saturation and value."""
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


# Oklab (Ottosson 2020): linear sRGB to cone responses, and their cube roots to lightness and two opponent axes.
_CONES = np.array([
    [0.4122214708, 0.5363325363, 0.0514459929],
    [0.2119034982, 0.6806995451, 0.1073969566],
    [0.0883024619, 0.2817188376, 0.6299787005],
])  # fmt: skip
_OPPONENTS = np.array([
    [0.2104542553, 0.7936177850, -0.0040720468],
    [1.9779984951, -2.4285922050, 0.4505937099],
    [0.0259040371, 0.7827717662, -0.8086757660],
])  # fmt: skip


def oklab(linear: npt.ArrayLike) -> FloatArray:
    """Convert linear sRGB (..., 3) to Oklab (..., 3): lightness and two opponent axes."""
    cones = np.asarray(linear, np.float64) @ _CONES.T
    return np.asarray(np.cbrt(cones) @ _OPPONENTS.T, np.float64)


def word_color(word: str) -> tuple[int, int, int]:
    """Return a bright 8-bit color for a word, stable across machines."""
    level = hashlib.blake2s(word.encode("utf-8", "surrogatepass"), digest_size=2).digest()
    saturation, value = (0.40, 0.65, 0.90)[level[0] % 3], (0.60, 0.80, 1.0)[level[1] % 3]
    red, green, blue = encode(np.array(tint(word, saturation, value))).tolist()
    return (red, green, blue)

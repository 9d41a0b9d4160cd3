"""Appearance: the materials of primitives, derived from their words and attributes, and the lighting around them.

``:color`` is the reflectance in linear sRGB; ``:roughness`` from 0 (polished) to 1, matte if absent; ``:metallic`` from
0 to 1; ``:opacity`` from 0 (transparent) to 1; ``:emission`` the emitted radiance, one number (multiplied by the
color) or three; ``:ior`` the index of refraction: the surface is glossy, and light transmitted by its ``:opacity`` is
refracted, as by glass; ``:coat`` from 0 to 1 a varnish, ``:sheen`` from 0 to 1 the bright rim of fabric. ``:material``
names a substance (``primitives/substances``), which sets what the other attributes do not set.
"""

from __future__ import annotations

import colorsys
import hashlib
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.surfaces.dome import UNIFORM, Dome, Sky, Softbox, panorama_of
from scenelang.backends.surfaces.image_files import encode, from_srgb
from scenelang.backends.surfaces.tiles import tile_of
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene import primitives
from scenelang.interpreter.scene.entity import Entity, Scene, descendants
from scenelang.interpreter.scene.primitives import items_of
from scenelang.interpreter.scene.primitives.base import WHITE
from scenelang.interpreter.scene.primitives.substances import SUBSTANCES, Substance
from scenelang.interpreter.scene.primitives.textures import PATTERNS, Texture
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
    values = {name: value for name in READ if (value := attributes.get(name)) is not None}
    if not values:
        return Look(color)
    texture = None if values.get("texture") is None else _texture(entity, values["texture"])
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
    size = 1.0 if box is None else max(high - low for low, high in zip(box[:3], box[3:], strict=True)) or 1.0
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


BRIGHTEST = 0.92  # maximum reflectance; no surface reflects all light
GROUND_EDGE = 5e4  # extent of the ground, in units of the scene's half diagonal
SHOULDER = 0.7  # radiance above which the tone curve bends: diffuse colors below it are shown as they are


@dataclass(frozen=True, slots=True)
class Environment:
    """A lighting environment.

    Attributes
    ----------
    doc
        One-line description.
    backdrop
        Radiance behind the scene, linear sRGB; None shows the sky.
    ambient
        Radiance of a white surface that faces upwards, from the sky alone.
    key
        Radiance of a white surface that faces the key light, from that light alone.
    turn, height, radius
        Direction of the key light relative to the camera's azimuth and above the horizon, and its angular radius, in
        degrees. It turns with the camera, so that a turntable looks like an object that rotates before a fixed camera.
    toned
        Whether images have a soft shoulder instead of clipping.
    sky
        Radiance by direction, relative to ``ambient`` and to the camera's azimuth: at azimuth 0 is the camera.
    unlit
        Whether surfaces show their colors unshaded. Both qualities then draw the same image, without ray tracing.
    ground
        Name of the default ground.
    """

    doc: str
    backdrop: Color | None
    ambient: Color
    key: Color
    sky: Sky = UNIFORM
    turn: float = -72.0
    height: float = 50.0
    radius: float = 5.0
    toned: bool = True
    unlit: bool = False
    ground: str = "seamless"
    gain: float = 1.0  # exposure, a factor of radiance before the tone curve


# Lights that polished surfaces reflect: over the scene, around the key light, to the right, and two behind it that draw
# bright rims.
_STUDIO = Sky((0.62, 0.62, 0.64), (0.50, 0.505, 0.52), (0.36, 0.36, 0.37), (
    Softbox(180.0, 74.0, 34.0, 18.0, (2.0, 2.0, 2.05)),
    Softbox(-72.0, 48.0, 15.0, 15.0, (3.4, 3.25, 3.0)),
    Softbox(76.0, 22.0, 9.0, 34.0, (2.3, 2.4, 2.5)),
    Softbox(-148.0, 24.0, 8.0, 30.0, (2.6, 2.6, 2.6)),
    Softbox(146.0, 34.0, 15.0, 13.0, (2.4, 2.35, 2.3)),
))  # fmt: skip
ENVIRONMENTS = {
    "studio": Environment(
        "a bright room with softboxes, the brightest beside the camera",
        (0.60, 0.61, 0.625), (0.42, 0.43, 0.445), (0.76, 0.73, 0.68), _STUDIO, radius=8.0,
    ),
    "overcast": Environment(
        "a white sky with faint shadows", (0.68, 0.70, 0.73), (0.66, 0.69, 0.73), (0.14, 0.14, 0.14),
        Sky((1.12, 1.12, 1.12), (0.76, 0.76, 0.76), (0.3, 0.3, 0.3)), radius=20.0,
    ),
    "sunny": Environment(
        "a blue sky and a hard sun", None, (0.30, 0.38, 0.50), (1.05, 0.98, 0.85),
        Sky((0.50, 0.80, 1.15), (1.75, 1.55, 1.35), (0.45, 0.5, 0.3)), -60.0, 55.0, 1.0, ground="meadow",
    ),
    "sunset": Environment(
        "a low warm sun", None, (0.24, 0.22, 0.30), (1.05, 0.62, 0.32),
        Sky((0.45, 0.65, 0.95), (2.7, 1.75, 0.95), (0.5, 0.4, 0.3)), -65.0, 18.0, 2.5, ground="earth",
    ),
    "night": Environment(
        "moonlight, for scenes with :emission", (0.010, 0.014, 0.030), (0.016, 0.020, 0.036), (0.05, 0.06, 0.09),
        Sky((0.7, 0.7, 0.8), (1.6, 1.5, 1.4), (0.2, 0.2, 0.2)), -50.0, 60.0, 2.0, ground="dark",
    ),
    "flat": Environment(
        "unlit: every surface has exactly its :color, without shadows", (1.0, 1.0, 1.0),
        (1.0, 1.0, 1.0), (0.0, 0.0, 0.0), toned=False, unlit=True, ground="none",
    ),
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Ground:
    """A ground.

    ``color`` is its reflectance, None for the seamless one. With ``other`` it is a checkerboard of both.
    """

    doc: str
    color: Color | None
    other: Color | None = None


GROUNDS = {
    "seamless": Ground("as bright as the backdrop: no horizon", None),
    "none": Ground("nothing below the scene", None),
    "white": Ground("white", (0.8, 0.8, 0.8)),
    "dark": Ground("nearly black", (0.04, 0.04, 0.045)),
    "meadow": Ground("grass green", (0.16, 0.26, 0.08)),
    "earth": Ground("sand and soil", (0.32, 0.22, 0.14)),
    "checker": Ground("a checkerboard, each square a quarter of the scene's half diagonal", (0.62,) * 3, (0.24,) * 3),
}
CHECKER = 0.25  # side of a square, in units of the scene's half diagonal
CHECKER_EDGE = 1000.0  # extent of the squares; the mean color continues beyond


@dataclass(frozen=True, slots=True, eq=False)
class Studio:
    """Lighting of one image.

    Attributes
    ----------
    key_direction : (3,)
        Unit vector from the scene to the key light.
    ground : (2, 3) or None
        Reflectances of the two kinds of squares of the ground, equal for a plain one; None without a ground.
    dome
        Radiance by direction, without the key light.
    """

    environment: Environment
    key_direction: FloatArray
    ground: FloatArray | None
    dome: Dome


def studio_for(
    right: FloatArray, environment: str = "studio", ground: str | None = None, backdrop: Color | None = None
) -> Studio:
    """Return the lighting of an image, with the key light beside the camera.

    Parameters
    ----------
    right : (3,)
        Direction to the right in the camera's image.
    environment, ground
        Names in ``ENVIRONMENTS`` and ``GROUNDS``; the ground is by default that of the environment.
    backdrop
        Radiance that replaces the environment's behind the scene.
    """
    chosen = ENVIRONMENTS[environment]
    if backdrop is not None:
        chosen = replace(chosen, backdrop=backdrop)
    turn = math.atan2(-right[2], right[0]) + math.radians(chosen.turn)
    height = math.radians(chosen.height)
    flat = math.cos(height)
    direction = np.array([math.sin(turn) * flat, math.sin(height), math.cos(turn) * flat])
    name = ground or chosen.ground
    dome = Dome(panorama_of(chosen.sky, chosen.ambient), math.degrees(turn) - chosen.turn)
    return Studio(chosen, direction, None if name == "none" else _ground(GROUNDS[name], chosen, direction), dome)


def _ground(ground: Ground, environment: Environment, direction: FloatArray) -> FloatArray:
    """Return the reflectances (2, 3) of a ground; a seamless one is lit as bright as the backdrop."""
    if ground.color is None and environment.backdrop is not None:
        light = np.array(environment.ambient) + np.array(environment.key) * direction[1]
        return np.tile(np.minimum(np.array(environment.backdrop) / light, 1.0), (2, 1))
    color = ground.color or (0.5, 0.5, 0.5)  # before a sky, a seamless ground is gray
    return np.array([color, ground.other or color])


def ground_colors(ground: FloatArray, x: AnyFloats, z: AnyFloats) -> FloatArray:
    """Return the reflectance (N, 3) of a ground at positions ``x`` and ``z`` (N,).

    ``ground`` (2, 3) are the two colors of its checkerboard; equal ones give a plain ground.
    """
    if (ground[0] == ground[1]).all():
        return np.broadcast_to(ground[0], (len(x), 3))
    second = (np.floor(x / CHECKER) + np.floor(z / CHECKER)) % 2.0 != 0.0
    colors = ground[second.astype(np.int64)]
    colors[np.maximum(np.abs(x), np.abs(z)) > CHECKER_EDGE] = ground.mean(axis=0)
    return np.asarray(colors, np.float64)


def tone_map(radiance: AnyFloats, environment: Environment) -> AnyFloats:
    """Map linear radiance to [0, 1] with the tone curve of ``environment``."""
    radiance = radiance if environment.gain == 1.0 else radiance * environment.gain
    return tone(radiance) if environment.toned else np.clip(radiance, 0.0, 1.0)


def tone(linear: AnyFloats) -> AnyFloats:
    """Map linear radiance to [0, 1): the identity up to ``SHOULDER``, then an exponential curve, without clipping."""
    room = 1.0 - SHOULDER
    over = np.maximum(linear - SHOULDER, 0.0)
    return np.where(linear <= SHOULDER, np.maximum(linear, 0.0), 1.0 - room * np.exp(-over / room))


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

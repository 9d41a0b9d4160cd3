"""Environments: the light around a scene, the ground below it, and the tone curves of its images."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from scenelang.backends.surfaces.daylight import CLEAREST, HAZIEST, SUNRISE, SUNSET, daylight
from scenelang.backends.surfaces.dome import UNIFORM, Dome, Panorama, Sky, Softbox, direction_at, panorama_of
from scenelang.backends.surfaces.panoramas import LUMINANCE, panorama_from, without_sun
from scenelang.grammar.diagnostics import SceneError, suggest
from scenelang.interpreter.scene.setup import PANORAMAS

FloatArray = npt.NDArray[np.float64]
AnyFloats = npt.NDArray[np.floating]
Color = tuple[float, float, float]

GROUND_EDGE = 5e4  # extent of the ground, in units of the scene's half diagonal
# The light on a seamless ground falls off away from the scene, as in a photographer's studio: between two distances, in
# half diagonals of the scene, to a share of it, which the backdrop has. It gives images depth: in one tone, ground and
# backdrop are like paper.
FADE_FROM, FADE_TO, FADED = 1.2, 12.0, 0.5
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
    curve
        Tone curve of its images, a name in ``CURVES``.
    sky
        Radiance by direction, relative to ``ambient`` and to the camera's azimuth: at azimuth 0 is the camera.
    panorama
        Image in place of ``sky``.
    is_fixed
        Whether it stays in the world instead of turning with the camera.
    spin
        Degrees by which the sky or the panorama is turned about the vertical.
    strength
        Factor of the panorama's radiance.
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
    curve: str = "soft"
    unlit: bool = False
    ground: str = "seamless"
    gain: float = 1.0  # exposure, a factor of radiance before the tone curve
    panorama: Panorama | None = None
    is_fixed: bool = False
    spin: float = 0.0
    strength: float = 1.0

    def on_level(self, direction: FloatArray) -> FloatArray:
        """Return the radiance (3,) of a white surface that faces upwards, with the key light from ``direction``."""
        return np.asarray(np.array(self.ambient) + np.array(self.key) * direction[1], np.float64)


# Lights that polished surfaces reflect: over the scene, around the key light, to the right, and two behind it that draw
# bright rims.
_STUDIO = Sky((0.62, 0.62, 0.64), (0.50, 0.505, 0.52), (0.36, 0.36, 0.37), (
    Softbox(180.0, 74.0, 34.0, 18.0, (2.0, 2.0, 2.05)),
    Softbox(-72.0, 48.0, 15.0, 15.0, (3.4, 3.25, 3.0)),
    Softbox(76.0, 22.0, 9.0, 34.0, (2.3, 2.4, 2.5)),
    Softbox(-148.0, 24.0, 8.0, 30.0, (2.6, 2.6, 2.6)),
    Softbox(146.0, 34.0, 15.0, 13.0, (2.4, 2.35, 2.3)),
))  # fmt: skip
# Larger ones in a dark room, the largest over and before the scene, with a dark band at the horizon: as photographers
# light metal and glass, which have no shape of their own under even light.
_SOFTBOXES = Sky((0.30, 0.30, 0.31), (0.060, 0.062, 0.066), (0.50, 0.50, 0.50), (
    Softbox(0.0, 62.0, 52.0, 22.0, (2.4, 2.4, 2.45)),
    Softbox(-76.0, 34.0, 16.0, 40.0, (4.2, 4.05, 3.8)),
    Softbox(90.0, 30.0, 10.0, 50.0, (3.2, 3.3, 3.4)),
    Softbox(180.0, 32.0, 60.0, 22.0, (1.9, 1.9, 1.9)),  # what a level face reflects, seen from 10 to 54 degrees
))  # fmt: skip
ENVIRONMENTS = {
    "studio": Environment(
        "a bright room with softboxes, the brightest beside the camera",
        (0.60, 0.61, 0.625), (0.42, 0.43, 0.445), (0.76, 0.73, 0.68), _STUDIO, radius=8.0,
    ),
    "softboxes": Environment(
        "a dark room with large softboxes, for polished metal and glass",
        (0.60, 0.61, 0.625), (0.42, 0.43, 0.445), (0.76, 0.73, 0.68), _SOFTBOXES, radius=8.0,
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
        (1.0, 1.0, 1.0), (0.0, 0.0, 0.0), curve="clip", unlit=True, ground="none",
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
    fades
        Whether the light on the ground falls off to that of the backdrop; see ``faded``.
    """

    environment: Environment
    key_direction: FloatArray
    ground: FloatArray | None
    dome: Dome
    fades: bool = False


def studio_for(
    right: FloatArray,
    environment: str = "studio",
    ground: str | None = None,
    backdrop: Color | None = None,
    panorama: Panorama | None = None,
) -> Studio:
    """Return the lighting of an image, by default with the key light beside the camera.

    Parameters
    ----------
    right : (3,)
        Direction to the right in the camera's image.
    environment
        As ``environment_of`` reads it.
    ground
        Name in ``GROUNDS``, by default that of the environment.
    backdrop
        Radiance that replaces the environment's behind the scene.
    panorama
        Replaces the image of the dome, which takes a while to compute.

    Raises
    ------
    SceneError
        If there is no such environment.
    """
    chosen = environment_of(environment)
    if backdrop is not None:
        chosen = replace(chosen, backdrop=backdrop)
    camera = 0.0 if chosen.is_fixed else math.atan2(-right[2], right[0])
    turn, height = camera + math.radians(chosen.turn), math.radians(chosen.height)
    direction = direction_at(turn, height)
    name = ground or chosen.ground
    panorama = panorama or chosen.panorama or panorama_of(chosen.sky, chosen.ambient)
    dome = Dome(panorama, math.degrees(camera) + chosen.spin, chosen.strength)
    fades = name == "seamless" and chosen.backdrop is not None and not chosen.unlit
    return Studio(chosen, direction, None if name == "none" else _ground(GROUNDS[name], chosen, direction), dome, fades)


def faded(distance: AnyFloats) -> AnyFloats:
    """Return the share (N,) of the light on a seamless ground at distances (N,) from the scene, in half diagonals.

    >>> faded(np.array([0.0, 1.2, 12.0, 1e9])).tolist()
    [1.0, 1.0, 0.5, 0.5]
    """
    along = np.log(np.maximum(distance, FADE_FROM) / FADE_FROM) / math.log(FADE_TO / FADE_FROM)
    t = np.minimum(along, 1.0)
    return np.asarray(1.0 - (1.0 - FADED) * t * t * (3.0 - 2.0 * t), distance.dtype)


def _ground(ground: Ground, environment: Environment, direction: FloatArray) -> FloatArray:
    """Return the reflectances (2, 3) of a ground; a seamless one is lit as bright as the backdrop."""
    if ground.color is None and environment.backdrop is not None:
        return np.tile(np.minimum(np.array(environment.backdrop) / environment.on_level(direction), 1.0), (2, 1))
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
    """Map linear radiance to [0, 1] with the exposure and the tone curve of ``environment``."""
    radiance = radiance if environment.gain == 1.0 else radiance * environment.gain
    return CURVES[environment.curve](radiance)


def tone(linear: AnyFloats) -> AnyFloats:
    """Map linear radiance to [0, 1): the identity up to ``SHOULDER``, then an exponential curve, without clipping."""
    room = 1.0 - SHOULDER
    over = np.maximum(linear - SHOULDER, 0.0)
    return np.where(linear <= SHOULDER, np.maximum(linear, 0.0), 1.0 - room * np.exp(-over / room))


def clipped(linear: AnyFloats) -> AnyFloats:
    """Map linear radiance to [0, 1] by clipping it."""
    return np.clip(linear, 0.0, 1.0)


def agx(linear: AnyFloats) -> AnyFloats:
    """Map linear radiance (..., 3) to linear sRGB in [0, 1]: bright colors fade to white, as on photographic film."""
    from scenelang.backends.surfaces import agx  # few images have it

    return agx.agx(linear)


CURVES: Mapping[str, Callable[[AnyFloats], AnyFloats]] = MappingProxyType({"soft": tone, "agx": agx, "clip": clipped})
TONES = ("soft", "agx")  # curves that options name


# --- environments by name, hour or file ---------------------------------------------------------------------------

USUAL = "studio"  # where nothing is said of the light
SKY = "sky"
IMAGES = PANORAMAS
USAGE = f"{', '.join(ENVIRONMENTS)}, sky,hour=15, or an image FILE.hdr or FILE.exr, with turn=30,strength=1.5"
_NUMBERS = {"turn": (-1e6, 1e6), "strength": (0.0, 1e6), "hour": (SUNRISE, SUNSET), "haze": (CLEAREST, HAZIEST)}
_FILE = re.compile(r".*\.(hdr|exr)\s*(?=,|\Z)", re.IGNORECASE | re.DOTALL)  # its name may have commas
_HORIZONTAL = 1.0  # radiance of a white surface that faces upwards under a sky or an image of strength 1
_SUN_RADIUS = 0.5  # degrees, twice that of the sun, so that few rays show no noise


@lru_cache(maxsize=32)
def environment_of(text: str) -> Environment:
    """Return the environment that a text names.

    It is a name in ``ENVIRONMENTS``, "sky" with an hour from 6 to 18 and a haze from 2 to 10, or the file of an image
    in latitude and longitude; then settings, as in ``studio,turn=30`` and ``sky,hour=17,strength=1.5``. A turn in
    degrees fixes in the world what else turns with the camera.

    Raises
    ------
    SceneError
        "value" for an unknown name or setting, "file" for a file that is not such an image.
    """
    file = _FILE.match(text)
    name = text.partition(",")[0].strip() if file is None else file[0].strip()
    items = [piece.strip() for piece in text[len(name if file is None else file[0]) :].split(",")[1:]]
    given: dict[str, float] = {}
    for item in items:
        key, value = _setting(item, is_sky=name == SKY)
        given[key] = value
    strength, turn = given.get("strength", 1.0), given.get("turn")
    if name in ENVIRONMENTS:
        chosen = ENVIRONMENTS[name]
    elif name == SKY:
        chosen = _daylight(given.get("hour", 15.0), given.get("haze", 2.5))
    elif name.lower().endswith(IMAGES):
        chosen = _pictured(name)
    else:
        hint = suggest(name, (*ENVIRONMENTS, SKY)) or f"expected {USAGE}"
        raise SceneError("value", f"unknown environment `{name[:60]}`", hint)
    return _changed(chosen, strength, turn)


def _setting(item: str, *, is_sky: bool) -> tuple[str, float]:
    """Parse one setting of an environment; raises SceneError."""
    key, _, text = (piece.strip() for piece in item.partition("="))
    known = ("turn", "strength", "hour", "haze") if is_sky else ("turn", "strength")
    if key not in known:
        raise SceneError("value", f"unknown setting `{item[:40]}` of the environment", suggest(key, known) or USAGE)
    low, high = _NUMBERS[key]
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not low <= value <= high:
        raise SceneError(
            "value", f"the environment's `{key}` must be a number from {low:g} to {high:g}, not `{text[:40]}`"
        )
    return key, value


def _changed(environment: Environment, strength: float, turn: float | None) -> Environment:
    """Return an environment with its light multiplied, and turned by degrees in the world."""
    behind = None if environment.backdrop is None else times(environment.backdrop, strength)
    out = replace(
        environment, backdrop=behind, ambient=times(environment.ambient, strength),
        key=times(environment.key, strength),
        strength=environment.strength * (1.0 if environment.panorama is None else strength),
    )  # fmt: skip
    if turn is None:
        return out
    return replace(out, is_fixed=True, turn=out.turn + turn, spin=out.spin + turn)


def times(color: Color, factor: float) -> Color:
    """Return a color multiplied by a factor."""
    red, green, blue = (channel * factor for channel in color)
    return red, green, blue


def _daylight(hour: float, haze: float) -> Environment:
    """Return the environment of a clear day."""
    light = daylight(hour, haze)
    return _measured(
        Environment("a clear day by the hour", None, (0.0,) * 3, (0.0,) * 3, turn=light.azimuth,
                    height=light.elevation, radius=_SUN_RADIUS, is_fixed=True),
        light.panorama, light.sun,
    )  # fmt: skip


def _pictured(path: str) -> Environment:
    """Return the environment of an image file, whose sun becomes the key light."""
    panorama, sun = without_sun(panorama_from(path))
    base = Environment("an image", None, (0.0,) * 3, (0.0,) * 3, ground="none", is_fixed=True)
    if sun is None:
        return _measured(base, panorama, np.zeros(3))
    return _measured(replace(base, turn=sun.azimuth, height=sun.elevation, radius=sun.radius), panorama, sun.light)


def _measured(environment: Environment, panorama: Panorama, sun: FloatArray) -> Environment:
    """Return an environment with a panorama and a sun, exposed so that a white horizontal surface is white."""
    up = np.array([[0.0, 1.0, 0.0]])
    ambient = Dome(panorama).irradiance(up, above=True)[0].astype(np.float64)
    total = float((ambient + sun * math.sin(math.radians(environment.height))) @ LUMINANCE)
    scale = _HORIZONTAL / total if total > 0.0 else 1.0
    return replace(
        environment, panorama=panorama, strength=scale, ambient=_color(ambient * scale), key=_color(sun * scale)
    )


def _color(values: FloatArray) -> Color:
    """Return an array (3,) as a color."""
    red, green, blue = values.tolist()
    return red, green, blue

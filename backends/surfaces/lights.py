"""Lights and cameras that a program declares, in the world: what they look at is looked up in the scene.

Units. Radiance 1 is white at exposure 0, and lengths are scene units. A lamp of ``:power`` P emits the radiant flux P:
a point has the radiant intensity P / 4 pi, so that a white surface that faces it at the distance d has the irradiance
E = P / (4 pi d^2) and the radiance E / pi. A spot is a point whose cone cuts the light off, and a rectangle of area A
has the radiance P / (pi A) on one side. A sun has the irradiance E = ``:strength``. These are the units of Blender.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.grammar.diagnostics import SceneError, suggest
from scenelang.interpreter.inspection.instance_paths import box_of
from scenelang.interpreter.scene.entity import Scene, count_words
from scenelang.interpreter.scene.setup import LIGHT, Declared, is_keyed, named

FloatArray = npt.NDArray[np.float64]
Point = tuple[float, float, float]


def level_axes(forward: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return right, up and forward of a level camera with the unit view direction ``forward`` (3,)."""
    above = np.array([0.0, 1.0, 0.0]) if abs(forward[1]) < 1.0 - 1e-9 else np.array([0.0, 0.0, -forward[1]])
    right = np.cross(forward, above)
    right = right / np.linalg.norm(right)
    return right, np.cross(right, forward), forward


def center_of(scene: Scene, words: str, item: Declared, frame: int | None = None) -> Point:
    """Return the center (3,) of the box of the instances of a word or path: in a frame, or in all frames.

    Where a frame has none of them, it is that of all frames. Raises SceneError("declaration-subject").
    """
    if frame is not None and len(scene.frames) > 1:
        try:
            center = center_in(scene.with_frames([scene.frames[frame]], False), words)
        except SceneError:  # not in this frame
            center = None
        if center is not None:
            return center
    message = f'`{item.form}` looks at "{words}", which names nothing that is drawn'
    try:
        center = center_in(scene, words)
    except SceneError as error:
        raise SceneError("declaration-subject", message, error.hint, item.span) from None
    if center is None:
        hint = suggest(words, count_words(scene.root))
        raise SceneError("declaration-subject", message, hint, item.span)
    return center


def center_in(scene: Scene, words: str | None) -> Point | None:
    """Return the center (3,) of a scene or of what words name in it, None without geometry."""
    box = box_of(scene, words)
    if box is None:
        return None
    x, y, z = ((low + high) / 2.0 for low, high in zip(box[:3], box[3:], strict=True))
    return x, y, z


@dataclass(frozen=True, slots=True)
class Light:
    """A light of a program.

    Attributes
    ----------
    kind
        "point" (a sphere if it has a radius), "spot", "area" or "sun".
    position : (3,)
        Of a lamp; the origin of a sun.
    direction : (3,)
        Unit vector in which it shines; down for a point.
    color : (3,)
        Linear sRGB, a factor of its light.
    power
        Radiant flux of a lamp, and irradiance of a sun.
    radius
        Of a sphere; of a sun its angular radius in degrees.
    angle, blend
        Full angle of the cone of a spot in degrees, and the share of its radius over which it fades.
    size : (2,)
        Width and height of an area.
    """

    kind: str
    position: Point
    direction: Point
    color: Point
    power: float
    radius: float = 0.0
    angle: float = 180.0
    blend: float = 0.0
    size: tuple[float, float] = (0.0, 0.0)
    name: str = ""

    def scaled(self, center: FloatArray, scale: float) -> Light:
        """Return the light after the world is transformed by ``p -> scale (p - center)``, which looks the same."""
        if self.kind == "sun":
            return self
        x, y, z = ((np.array(self.position) - center) * scale).tolist()
        width, height = self.size
        return replace(
            self, position=(x, y, z), power=self.power * scale * scale, radius=self.radius * scale,
            size=(width * scale, height * scale),
        )  # fmt: skip

    def toward(self, points: FloatArray) -> FloatArray:
        """Return the unit directions (N, 3) from points (N, 3) to the light."""
        if self.kind == "sun":
            return np.broadcast_to(-np.array(self.direction), points.shape)
        return _apart(points, np.array(self.position))[0]

    @property
    def flux(self) -> FloatArray:
        """Power of each channel (3,)."""
        return np.array(self.color) * self.power

    @property
    def radiance(self) -> FloatArray:
        """Radiance (3,) of the surface of a sphere or of an area."""
        width, height = self.size
        surface = width * height if self.kind == "area" else 4.0 * math.pi * self.radius**2
        return self.flux / (math.pi * surface)


_AREA_PLACES = 4  # per side of an area, for its irradiance


def irradiance_of(light: Light, points: FloatArray, normals: FloatArray) -> FloatArray:
    """Return the irradiance (N,) of points (N, 3) with unit ``normals`` (N, 3) by a light of white color."""
    direction = np.array(light.direction)
    if light.kind == "sun":
        return np.asarray(light.power * np.maximum(normals @ -direction, 0.0), np.float64)
    if light.kind == "area":
        return _of_area(light, points, normals)
    toward, distance = _apart(points, np.array(light.position))
    facing = np.maximum(np.einsum("ni,ni->n", normals, toward), 0.0)
    irradiance = light.power * facing / (4.0 * math.pi * distance**2)
    if light.kind == "spot":
        half = light.angle / 2.0
        angle = np.degrees(np.arccos(np.clip(toward @ -direction, -1.0, 1.0)))
        irradiance *= np.clip((half - angle) / (half * max(light.blend, 1e-3)), 0.0, 1.0)
    return np.asarray(irradiance, np.float64)


def _apart(points: FloatArray, place: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the unit directions (N, 3) from points (N, 3) to a place, and the distances (N,)."""
    offset = place - points
    distance = np.maximum(np.linalg.norm(offset, axis=1), 1e-6)
    return offset / distance[:, None], distance


def _of_area(light: Light, points: FloatArray, normals: FloatArray) -> FloatArray:
    """Return the irradiance (N,) by a rectangle, as the sum over places on it."""
    right, up, forward = level_axes(np.array(light.direction))
    width, height = light.size
    steps = (np.arange(_AREA_PLACES) + 0.5) / _AREA_PLACES - 0.5
    total = np.zeros(len(points))
    for across in steps:
        for along in steps:
            place = np.array(light.position) + across * width * right + along * height * up
            toward, distance = _apart(points, place)
            facing = np.maximum(np.einsum("ni,ni->n", normals, toward), 0.0)
            total += facing * np.maximum(-(toward @ forward), 0.0) / distance**2
    return light.power / (math.pi * _AREA_PLACES**2) * total


def lights_of(scene: Scene) -> tuple[Light, ...]:
    """Return the lights that a program declares, at the first frame; raises SceneError if one looks at nothing."""
    return _lights_at(scene, 0.0)


LightTrack = tuple[tuple[float, tuple[Light, ...]], ...]  # lights at shares of the way through a video, from 0 to 1


def light_track(scene: Scene) -> LightTrack:
    """Return the lights of a program over a video, between which they move linearly; one entry if they stand still.

    Raises SceneError for a light that looks at nothing.
    """
    shares = {0.0}
    for item in named(scene.setup, LIGHT):
        for key, value in item.values.items():
            if is_keyed(LIGHT, key, value):
                shares |= {k / max(1, len(value) - 1) for k in range(len(value))}
        if _follows(item):
            shares |= {k / max(1, len(scene.frames) - 1) for k in range(len(scene.frames))}
    return tuple((share, _lights_at(scene, share)) for share in sorted(shares))


def lights_at(track: LightTrack, share: float) -> tuple[Light, ...]:
    """Return the lights of a track at a share of the way through the video."""
    last = min(bisect_left([at for at, _ in track], share), len(track) - 1)
    (before, one), (after, other) = track[max(0, last - 1)], track[last]
    between = 1.0 if after == before else min(1.0, max(0.0, (share - before) / (after - before)))
    return tuple(_between(a, b, between) for a, b in zip(one, other, strict=True))


def _between(one: Light, other: Light, between: float) -> Light:
    """Return a light on the way from one to another of its kind."""
    direction = mixed(one.direction, other.direction, between)
    return replace(
        one, position=mixed(one.position, other.position, between), power=mixed(one.power, other.power, between),
        direction=_unit(direction) if any(direction) else one.direction,
        radius=mixed(one.radius, other.radius, between), angle=mixed(one.angle, other.angle, between),
    )  # fmt: skip


def value_at(item: Declared, key: str, share: float, place: Callable[[Any], Any] = lambda value: value) -> Any:
    """Return a value of a declaration at a share of the way through a video, linear between those given; None without.

    ``place`` is applied to each of the values first.
    """
    value = item.values.get(key)
    if value is None or not is_keyed(item.form, key, value):
        return None if value is None else place(value)
    way = min(1.0, max(0.0, share)) * (len(value) - 1)
    first = min(int(way), len(value) - 1)
    return mixed(place(value[first]), place(value[min(first + 1, len(value) - 1)]), way - first)


def mixed(one: Any, other: Any, between: float) -> Any:
    """Return a number or point between two others; exactly the first at 0."""
    if between == 0.0:
        return one
    if isinstance(one, tuple):
        return tuple(a + (b - a) * between for a, b in zip(one, other, strict=True))
    return one + (other - one) * between


def target_at(scene: Scene, item: Declared, frame: int, share: float) -> Point | None:
    """Return what a camera or a light looks at (3,) in a frame, None for nothing in particular; raises SceneError."""

    def place(target: str | Point) -> Point:
        """Return a point, or the center of what words name in the frame."""
        return center_of(scene, target, item, frame) if isinstance(target, str) else target

    point: Point | None = value_at(item, "look-at", share, place)
    return point


def _follows(item: Declared) -> bool:
    """Return whether a light looks at what words name, which may move."""
    target = item.values.get("look-at", ())
    return isinstance(target, str) or any(isinstance(one, str) for one in target)


def _lights_at(scene: Scene, share: float) -> tuple[Light, ...]:
    """Return the lights of a program at a share of the way through a video."""
    return tuple(_light(scene, item, share) for item in named(scene.setup, LIGHT))


def _light(scene: Scene, item: Declared, share: float) -> Light:
    values = {key: value_at(item, key, share) for key in item.values if key != "look-at"}
    color, direction = values.get("color", (1.0, 1.0, 1.0)), values.get("direction")
    if "position" not in values:
        shape = {"radius": values.get("angle", 0.5) / 2.0}  # the sun is seen under half a degree
        return Light("sun", (0.0, 0.0, 0.0), _unit(direction), color, values.get("strength", math.pi), **shape,
                     name=item.name)  # fmt: skip
    position = values["position"]
    point = target_at(scene, item, round(share * (len(scene.frames) - 1)), share)
    if point is not None:
        direction = tuple(b - a for a, b in zip(position, point, strict=True))
        if not any(direction):
            raise SceneError("value", "the light is at the point that it looks at", None, item.span)
    kind = "spot" if "angle" in values else "area" if "size" in values else "point"
    more = {key: values[key] for key in ("radius", "angle", "blend", "size") if key in values}
    power = values.get("power")
    if power is None:
        power = _power_for(scene, value_at(item, "position", 0.0))
    return Light(kind, position, _unit(direction or (0.0, -1.0, 0.0)), color, power, **more, name=item.name)


def _power_for(scene: Scene, position: Point) -> float:
    """Return the power with which a point makes a white surface that faces it white, at the center of the scene."""
    center = center_in(scene, None) or (0.0, 0.0, 0.0)
    return 4.0 * math.pi**2 * max(math.dist(position, center) ** 2, 1e-12)


def _unit(vector: Any) -> Point:
    """Return a vector (3,) with length 1; down for one without a length, as halfway between opposite ones."""
    largest = max(map(abs, vector))
    if largest == 0.0:
        return 0.0, -1.0, 0.0
    x, y, z = (component / largest for component in vector)
    length = math.hypot(x, y, z)
    return x / length, y / length, z / length

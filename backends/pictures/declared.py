"""What a program declares of its images: cameras, lights, environment and settings, as data of renderers.

The program stores names and checked numbers (``interpreter.scene.setup``). Here cameras are placed, what they look at
is looked up in the scene, and lights become frozen data that both qualities draw.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.pictures.camera import (
    PRESETS,
    Camera,
    Changes,
    Viewpoint,
    camera_at,
    named_changes,
    parse_viewpoint,
)
from scenelang.backends.surfaces.dome import direction_at
from scenelang.backends.surfaces.environments import Studio, times
from scenelang.backends.surfaces.lights import (
    Light,
    LightTrack,
    Point,
    center_in,
    level_axes,
    lights_at,
    target_at,
    value_at,
)
from scenelang.grammar.diagnostics import SceneError, UsageError, suggest, usage_errors
from scenelang.interpreter.scene.entity import Scene
from scenelang.interpreter.scene.setup import (
    CAMERA,
    EXCLUSIVE,
    SETTINGS,
    Declared,
    declared_setup,
    is_keyed,
    named,
)

if TYPE_CHECKING:
    pass

FloatArray = npt.NDArray[np.float64]

_FRAME_HEIGHT = 24.0  # mm of the frame of 36 x 24 mm that `:lens` is about


# --- cameras ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class ProgramCamera:
    """A camera that a program declares, placed for each frame."""

    item: Declared

    @property
    def varies(self) -> bool:
        """Whether values are given over the frames."""
        return any(is_keyed(CAMERA, key, value) for key, value in self.item.values.items())

    @property
    def orbit(self) -> float | None:
        """Angle in degrees that the camera of a video travels around."""
        orbit: float | None = self.item.values.get("orbit")
        return orbit

    def viewpoint(self, scene: Scene) -> Viewpoint | None:
        """Return the viewpoint that this camera is for all frames, None if it is not one."""
        target = self.item.values.get("look-at")
        if self.varies or "eye" in self.item.values or "roll" in self.item.values:
            return None
        return self._viewpoint(scene, 0, 0.0) if not isinstance(target, str) or len(scene.frames) == 1 else None

    def changed(self, changes: Changes) -> ProgramCamera:
        """Return the camera with other values; what they stand for is left out. Raises UsageError."""
        values = dict(self.item.values)
        for key, value in changes.items():
            for one, others in EXCLUSIVE[CAMERA]:
                for excluded in others if key == one else (one,) if key in others else ():
                    values.pop(excluded, None)
            values["look-at" if key == "target" else key] = value
        with usage_errors():
            return ProgramCamera(declared_setup(CAMERA, self.item.name, values, self.item.span)) if changes else self

    def target(self, scene: Scene, frame: int = 0, share: float = 0.0) -> Point | None:
        """Return what it looks at (3,) in a frame, None for the whole scene."""
        return target_at(scene, self.item, frame, share)

    def _value(self, key: str, share: float) -> Any:
        """Return a value at a share of the way from the first frame to the last, linear between those given."""
        return value_at(self.item, key, share)

    def _fov(self, share: float) -> float | None:
        """Return the vertical field of view in degrees, None for that of the preset."""
        lens = self._value("lens", share)
        if lens is None:
            fov: float | None = self._value("fov", share)
            return fov
        return math.degrees(2.0 * math.atan(_FRAME_HEIGHT / 2.0 / lens))

    def _viewpoint(self, scene: Scene, frame: int, share: float) -> Viewpoint:
        """Return the viewpoint of a frame, of a camera without an eye."""
        name = self.item.values.get("preset")
        given = {key: self._value(key, share) for key in ("azimuth", "elevation", "distance", "aperture", "focus")}
        given |= {"fov": self._fov(share), "target": self.target(scene, frame, share)}
        given |= {"orthographic": self.item.values.get("orthographic"), "orbit": self.orbit}
        start = PRESETS[name] if name is not None else Viewpoint()
        return replace(start, **{key: value for key, value in given.items() if value is not None})

    def at(
        self, scene: Scene, frame: int, share: float, size: tuple[int, int], place: Callable[[Viewpoint], Camera]
    ) -> Camera:
        """Return the placed camera of a frame.

        Parameters
        ----------
        frame
            Frame of the scene.
        share
            From 0 at the first frame of the video to 1 at the last.
        size
            Width and height of the image in pixels.
        place
            Places a viewpoint in front of the scene.

        Raises
        ------
        SceneError
            If it looks at nothing, or at itself.
        """
        eye = self._value("eye", share)
        camera = place(self._viewpoint(scene, frame, share)) if eye is None else self._seeing(
            scene, np.array(eye), self.target(scene, frame, share), share, size
        )  # fmt: skip
        roll = self._value("roll", share)
        return camera if not roll else rolled(camera, roll)

    def _seeing(
        self, scene: Scene, eye: FloatArray, target: Point | None, share: float, size: tuple[int, int]
    ) -> Camera:
        """Return the camera at ``eye`` (3,) that looks at a target, by default the center of the scene."""
        width, height = size
        point = np.array(center_in(scene, None) if target is None else target)
        forward = point - eye
        distance = float(np.linalg.norm(forward))
        if distance < 1e-9:
            raise SceneError("value", "the camera is at the point that it looks at", None, self.item.span)
        tangent = math.tan(math.radians(self._fov(share) or Viewpoint().fov) / 2.0)
        lens = {"aperture": self._value("aperture", share) or 0.0, "focus": self._value("focus", share) or distance}
        axes = level_axes(forward / distance)
        if self.item.values.get("orthographic"):  # what it looks at is as large as in a perspective
            focal = height / (2.0 * distance * tangent)
            return camera_at(eye, axes, focal, width, height, projection="orthographic", **lens)
        return camera_at(eye, axes, height / (2.0 * tangent), width, height, **lens)


@dataclass(frozen=True, slots=True)
class ProgramView:
    """A view that is known once the scene is: a camera of the program by name, or its first one.

    Attributes
    ----------
    name
        Name of a camera; empty for the first one, or the default viewpoint in a program without cameras.
    other
        What the name means if no camera of the program has it: a preset, or an error.
    changes
        Fields of a viewpoint by which a camera of the program is changed.
    """

    name: str = ""
    other: Viewpoint | Camera | None = None
    error: str = field(default="", compare=False)
    hint: str | None = field(default=None, compare=False)
    changes: Changes = field(default_factory=dict, hash=False)

    def of(self, scene: Scene) -> Viewpoint | Camera | ProgramCamera:
        """Return the view of a scene; raises UsageError if it has no such camera."""
        cameras = named(scene.setup, CAMERA)
        chosen = next((item for item in cameras if not self.name or item.name == self.name), None)
        if chosen is not None:
            camera = ProgramCamera(chosen).changed(self.changes)
            return camera.viewpoint(scene) or camera
        if not self.name:
            return Viewpoint()
        if self.other is not None:
            return self.other
        names = ", ".join(f"`{item.name}`" for item in cameras if item.name)
        hint = suggest(self.name, [item.name for item in cameras]) or (
            f"the program has {names}" if names else self.hint
        )
        raise UsageError("value", self.error, hint)


View = Viewpoint | Camera | ProgramView | ProgramCamera


def view_of(text: str | None) -> Viewpoint | Camera | ProgramView:
    """Return the view of ``--camera``: the name of a camera of the program, or what ``parse_viewpoint`` reads.

    Raises SceneError. A first word may be a camera's name, which is known once the program has run; ``key=value`` pairs
    after it change that camera.
    """
    text = (text or "").strip()
    if not text:
        return ProgramView()
    named_view = named_changes(text)
    if named_view is None:
        return parse_viewpoint(text)
    name, changes = named_view
    try:
        return ProgramView(name, parse_viewpoint(text), changes=changes)
    except SceneError as error:
        return ProgramView(name, None, error.message, error.hint, changes)


def resolved(scene: Scene, view: View) -> Viewpoint | Camera | ProgramCamera:
    """Return a view of a scene that can be placed; raises UsageError."""
    return view.of(scene) if isinstance(view, ProgramView) else view


def share_of(scene: Scene, frame: int) -> float:
    """Return how far a frame is on the way from the first to the last, from 0 to 1."""
    return frame / max(1, len(scene.frames) - 1)


def rolled(camera: Camera, degrees: float) -> Camera:
    """Return a camera that is turned clockwise about its view, so that its image turns counterclockwise."""
    turn = math.radians(degrees)
    rotation = np.array(
        [[math.cos(turn), math.sin(turn), 0.0], [-math.sin(turn), math.cos(turn), 0.0], [0.0, 0.0, 1.0]]
    )
    pose = camera.world_to_camera.copy()
    pose[:3] = rotation @ pose[:3]
    return replace(camera, world_to_camera=pose)


# --- environment and settings ----------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Lighting:
    """What a program declares of the light of its pictures.

    Attributes
    ----------
    lights
        In the world, at the first frame of a video.
    track
        Lights at shares of the way through a video, if they move.
    strength
        Factor of the environment's light.
    turn
        Degrees by which the environment is turned about the vertical, in the world; None to turn with the camera.
    exposure
        Stops.
    is_metered
        Whether the first image changes the exposure by what it shows.
    has_key
        Whether the environment's key light shines.
    tone
        Name of the tone curve; None for that of the environment.
    """

    lights: tuple[Light, ...] = ()
    strength: float = 1.0
    turn: float | None = None
    exposure: float = 0.0
    has_key: bool = True
    tone: str | None = None
    is_metered: bool = False
    track: LightTrack = ()

    def lights_at(self, share: float) -> tuple[Light, ...]:
        """Return the lights at a share of the way through a video, from 0 to 1."""
        return lights_at(self.track, share) if self.track else self.lights

    def studio(self, studio: Studio) -> Studio:
        """Return the lighting of an image as the program declares it."""
        environment, direction = studio.environment, studio.key_direction
        if self.turn is not None:
            around, height = math.radians(self.turn + environment.turn), math.radians(environment.height)
            direction = direction_at(around, height)
        key = times(environment.key, self.strength if self.has_key else 0.0)
        behind = None if environment.backdrop is None else times(environment.backdrop, self.strength)
        if behind is not None and not self.has_key:  # as bright as the ground without the key light: no horizon
            share = np.array(environment.ambient) / environment.on_level(direction)
            red, green, blue = (np.array(behind) * share).tolist()
            behind = (red, green, blue)
        changed = replace(
            environment, backdrop=behind, key=key, ambient=times(environment.ambient, self.strength),
            gain=environment.gain * 2.0**self.exposure,
            curve=environment.curve if self.tone is None or environment.unlit else self.tone,
        )  # fmt: skip
        turn = studio.dome.turn if self.turn is None else self.turn
        dome = replace(studio.dome, turn=turn, strength=studio.dome.strength * self.strength)
        return replace(studio, environment=changed, key_direction=direction, dome=dome)


def setting_of(scene: Scene, key: str) -> Any:
    """Return a value of ``render-settings``, None without one."""
    return next((item.values.get(key) for item in named(scene.setup, SETTINGS)), None)

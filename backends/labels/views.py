"""Cameras around a scene, and what each sees: pictures, ground truth, motion and tracks, each computed once."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from functools import cached_property

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import Progress
from scenelang.backends.labels import ground_truth
from scenelang.backends.labels.ground_truth import Expanded, Flow, Tracks, Truth, expanded, truth_in
from scenelang.backends.labels.things import Things, things_of
from scenelang.backends.pictures.camera import Camera, Viewpoint, camera_at
from scenelang.backends.pictures.film import Image, Painter, PictureBackend, PictureOptions, painters
from scenelang.backends.pictures.stage import Shot, still, unit_size
from scenelang.grammar.datum import replace
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.inspection.numbering import ancestry_of, frame_numbers, instance_handles, some_handles
from scenelang.interpreter.scene.entity import Scene

FloatArray = npt.NDArray[np.float64]
View = Viewpoint | Camera
MAX_VIEWS = 10_000
_KEPT_BYTES = 200_000_000  # of ground truth of a view
_INSTANCE_BYTES = 500  # of the poses, ancestors and solids of an instance


# --- where cameras are -----------------------------------------------------------------------------------------------


def hemisphere_views(count: int, random: np.random.Generator, like: Viewpoint) -> tuple[Viewpoint, ...]:
    """Return ``count`` random viewpoints around and above a scene, which share the other settings of ``like``."""
    azimuths, elevations = random.uniform(-180.0, 180.0, count), random.uniform(5.0, 65.0, count)
    pairs = zip(azimuths.tolist(), elevations.tolist(), strict=True)
    return tuple(replace(like, azimuth=azimuth, elevation=elevation) for azimuth, elevation in pairs)


def orbit_views(first: Viewpoint, count: int, sweep: float) -> tuple[Viewpoint, ...]:
    """Return ``count`` viewpoints on a circle from ``first``, evenly spaced over ``sweep`` degrees.

    The last one is a step before the end of a full turn, and at the end of a shorter arc.

    Examples
    --------
    >>> [view.azimuth for view in orbit_views(Viewpoint(azimuth=10), 4, 360.0)]
    [10.0, 100.0, 190.0, 280.0]
    """
    is_closed = abs(sweep) % 360.0 == 0.0
    step = sweep / (count if is_closed else max(1, count - 1))
    return tuple(replace(first, azimuth=first.azimuth + step * i) for i in range(count))


def trajectory_views(
    eyes: Sequence[Sequence[float]], target: Sequence[float], count: int, fov: float, size: tuple[int, int]
) -> tuple[Camera, ...]:
    """Return ``count`` cameras at equal distances along the polyline through ``eyes``, which look at ``target``.

    ``eyes`` (K, 3) and ``target`` (3,) are in the world, ``fov`` is the vertical field of view in degrees, ``size`` in
    pixels. Raises SceneError("value") if a camera is at its target.
    """
    points = np.array(eyes, np.float64)
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    places = np.linspace(0.0, lengths[-1], count)
    along = np.stack([np.interp(places, lengths, points[:, axis]) for axis in range(3)], axis=1)
    width, height = size
    focal = height / (2.0 * np.tan(np.radians(fov) / 2.0))
    return tuple(camera_at(eye, _looking(eye, np.array(target)), float(focal), width, height) for eye in along)


def _looking(eye: FloatArray, target: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return right, up and forward of a level camera at ``eye`` that looks at ``target``."""
    forward = target - eye
    length = float(np.linalg.norm(forward))
    if length < 1e-12:
        raise SceneError("value", "a camera of the trajectory is at the point that it looks at")
    forward = forward / length
    above = np.array([0.0, 1.0, 0.0]) if abs(forward[1]) < 1.0 - 1e-9 else np.array([0.0, 0.0, -1.0])
    right = np.cross(forward, above)
    right = right / np.linalg.norm(right)
    return right, np.cross(right, forward), forward


def views_of(given: Sequence[View], count: int | None, seed: int) -> tuple[View, ...]:
    """Return the given cameras, or ``count`` random ones that share the given viewpoint's other settings.

    Raises SceneError("value").
    """
    if count is None:
        return tuple(given)
    if not 1 <= count <= MAX_VIEWS:
        raise SceneError("value", f"`--views` must be 1 to {MAX_VIEWS:,}, not {count}")
    (like,) = given if len(given) == 1 else (None,)
    if like is None or isinstance(like, Camera):
        raise SceneError("value", "`--views` places cameras at random: give at most one viewpoint, which they share")
    return hemisphere_views(count, np.random.default_rng(seed), like)


# --- what they see ---------------------------------------------------------------------------------------------------


class SceneFacts:
    """What all cameras of a scene share: its size, and the numbers of its paths and handles."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.paths = ground_truth.PathNumbers()
        self._handles: dict[int, list[str]] = {}
        self._expanded: dict[int, Expanded] = {}

    @cached_property
    def unit(self) -> tuple[FloatArray, float]:
        """Centre (3,) and scale that bring the scene to unit size."""
        return unit_size(self.scene)

    @cached_property
    def numbers(self) -> dict[tuple[int, ...], int] | None:
        """Numbers of handles by path; None for a scene with one frame."""
        return frame_numbers(self.scene) if len(self.scene.frames) > 1 else None

    def expanded(self, frame: int, limit: int) -> Expanded:
        """Return a frame as all cameras see it; the last one is kept. Raises LimitError."""
        if frame not in self._expanded:
            self._expanded = {frame: expanded(self.scene, frame, limit, *self.unit)}
        return self._expanded[frame]

    def number_paths(self, frames: int) -> None:
        """Number the paths of the first frames, so that those of a frame are the same whichever frame is seen first."""
        for frame in self.scene.frames[:frames]:
            self.paths.of(ancestry_of(frame))

    def handles(self, truth: Truth, frame: int) -> list[str]:
        """Return the handle of every instance of a frame."""
        if frame not in self._handles:
            self._handles = {frame: instance_handles(self.scene, truth.ancestry, self.numbers)}
        return self._handles[frame]


class LabelledView:
    """What one camera sees of the chosen frames of a scene; without ``make_painter``, its labels only.

    ``shots`` are the frames with their placed cameras, ``tracked`` is the number of tracked points. Raises SceneError
    if the scene cannot be seen.
    """

    def __init__(
        self,
        facts: SceneFacts,
        options: PictureOptions,
        frames: Sequence[int],
        tracked: int,
        make_painter: Callable[[Sequence[Shot]], Painter] | None = None,
    ) -> None:
        size = options.width, options.height
        self.facts = facts
        self.shots = {frame: still(facts.scene, options.camera, frame, *size) for frame in frames}
        self._options = options
        self._tracked = tracked
        self._make_painter = make_painter
        self._recent: dict[int, Truth] = {}
        self._things: dict[tuple[int, tuple[str, ...]], Things] = {}

    @cached_property
    def _painter(self) -> Painter:
        assert self._make_painter is not None, "this view has labels only"
        return self._make_painter(list(self.shots.values()))

    def image(self, frame: int, progress: Progress | None = None) -> Image:
        """Draw the picture of a frame."""
        return self._painter.paint(self.shots[frame], progress)

    def truth(self, frame: int) -> Truth:
        """Return the ground truth of a frame.

        Those of the last frames are kept, at least two because each frame is compared with the next, and as many as
        fit ``_KEPT_BYTES`` because filters and boxes look at all frames first.
        """
        if frame not in self._recent:
            made = truth_in(self.facts.expanded(frame, self._options.limit), self.shots[frame])
            keep = max(2, _KEPT_BYTES // _bytes_of(made))
            for old in list(self._recent)[: max(0, len(self._recent) - keep + 1)]:
                del self._recent[old]
                self._things = {key: things for key, things in self._things.items() if key[0] != old}
            self._recent[frame] = made
        return self._recent[frame]

    def things(self, frame: int, words: Collection[str] = ()) -> Things:
        """Return the things of a frame, kept with its ground truth; see ``things_of``."""
        truth, key = self.truth(frame), (frame, tuple(words))
        if key not in self._things:
            self._things[key] = things_of(truth, words)
        return self._things[key]

    def paths(self, frame: int) -> npt.NDArray[np.int64]:
        """Return the path number (M,) of every instance of a frame."""
        return self.facts.paths.of(self.truth(frame).ancestry)

    def some_handles(self, frame: int, rows: Sequence[int]) -> dict[int, str]:
        """Return the handles of some instances of a frame, by instance."""
        return some_handles(self.facts.scene, self.truth(frame).ancestry, rows, self.facts.numbers)

    def handles(self, frame: int) -> list[str]:
        """Return the handle of every instance of a frame."""
        return self.facts.handles(self.truth(frame), frame)

    def flow(self, frame: int) -> Flow | None:
        """Return the motion from a frame to the next, None if the next is not among the frames."""
        if frame + 1 not in self.shots:
            return None
        here, there = self.truth(frame), self.truth(frame + 1)
        return ground_truth.flow_between(here, there, self.paths(frame), self.paths(frame + 1))

    @cached_property
    def tracks(self) -> Tracks | None:
        """Trajectories of points visible in the first frame; None for a single frame."""
        if len(self.shots) < 2:
            return None
        places: ground_truth.Places | None = None
        found = []
        for frame in self.shots:
            truth, paths = self.truth(frame), self.paths(frame)
            if places is None:
                places = ground_truth.sample_places(truth, paths, self._tracked, self._options.seed)
            found.append(ground_truth.found_in(places, truth, paths))
        return ground_truth.tracks_of(found)


def _bytes_of(truth: Truth) -> int:
    """Return about how much memory a ground truth takes."""
    maps = (truth.instance, truth.depth, truth.normal, truth.albedo, truth.position)
    return sum(each.nbytes for each in maps) + _INSTANCE_BYTES * len(truth.ancestry)


def labelled_view(
    facts: SceneFacts, options: PictureOptions, backend: PictureBackend, frames: Sequence[int], tracked: int
) -> LabelledView:
    """Return what the camera of ``options`` sees of ``frames``, drawn by ``backend``."""

    def painter(shots: Sequence[Shot]) -> Painter:
        (found,) = painters(facts.scene, options, [backend], shots)
        return found

    return LabelledView(facts, options, frames, tracked, painter)

"""Views of a scene by its cameras: image, ground truth, motion and tracks, each computed once."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from functools import cached_property

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import Progress
from scenelang.backends.labels import ground_truth
from scenelang.backends.labels.ground_truth import Expanded, Flow, IntArray, Tracks, Truth, expanded, truth_in
from scenelang.backends.labels.object_labels import ObjectLabels, objects_of
from scenelang.backends.pictures.film import Image, Painter, PictureBackend, PictureOptions, painters
from scenelang.backends.pictures.stage import Shot, stills, unit_size
from scenelang.interpreter.inspection.numbering import ancestry_of, frame_numbers, instance_handles, some_handles
from scenelang.interpreter.scene.entity import Scene

FloatArray = npt.NDArray[np.float64]
_MAX_CACHE_BYTES = 200_000_000  # of the ground truths that a view caches; two frames are always cached
_INSTANCE_BYTES = 500  # estimated size of an instance's poses, ancestors and solids


class SceneFacts:
    """Data that all cameras of a scene share: its size, and the numbers of its paths and handles."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.paths = ground_truth.PathNumbers()
        self._handles: dict[int, list[str]] = {}
        self._expanded: dict[int, Expanded] = {}
        self._bodies: dict[int, IntArray] = {}

    @cached_property
    def unit(self) -> tuple[FloatArray, float]:
        """Center (3,) and scale that bring the scene to unit size."""
        return unit_size(self.scene)

    @cached_property
    def numbers(self) -> dict[tuple[int, ...], int] | None:
        """Numbers of handles by path; None for a scene with one frame."""
        return frame_numbers(self.scene) if len(self.scene.frames) > 1 else None

    def expanded(self, frame: int, limit: int) -> Expanded:
        """Return a frame, expanded once for all cameras; the last frame is cached. Raises LimitError."""
        if frame not in self._expanded:
            self._expanded = {frame: expanded(self.scene, frame, limit, *self.unit)}
        return self._expanded[frame]

    def number_paths(self, frames: int) -> None:
        """Number the paths of the first frames, so that numbers do not depend on which frame is labeled first."""
        for frame in self.scene.frames[:frames]:
            self.paths.of(ancestry_of(frame))

    def handles(self, truth: Truth, frame: int) -> list[str]:
        """Return the handle of every instance of a frame."""
        if frame not in self._handles:
            self._handles = {frame: instance_handles(self.scene, truth.ancestry, self.numbers)}
        return self._handles[frame]

    def bodies(self, truth: Truth, frame: int) -> IntArray:
        """Return the number of the body of every instance of a frame."""
        if frame not in self._bodies:
            self._bodies = {frame: ground_truth.bodies_of_instances(truth.ancestry)}
        return self._bodies[frame]


class LabeledView:
    """View of the chosen frames of a scene by one camera: images, ground truth, motion and tracks.

    Parameters
    ----------
    facts : SceneFacts
        Data that the views of a scene share.
    options : PictureOptions
        Camera, size in pixels and limits.
    frames : Sequence[int]
        Frames of the scene, each with its placed camera in ``shots``.
    tracked : int
        Number of tracked points.
    make_painter : callable, optional
        Creates the painter of the shots; without it the view has labels only.

    Raises
    ------
    SceneError
        If the camera cannot see the scene.
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
        # Motion and tracks relate the frames, so that a camera frames all of them, whichever are labeled.
        shots = stills(facts.scene, options.camera, frames, *size, seen=range(len(facts.scene.frames)))
        self.shots = {shot.frame: shot for shot in shots}
        self._options = options
        self._tracked = tracked
        self._make_painter = make_painter
        self._recent: dict[int, Truth] = {}
        self._objects: dict[tuple[int, tuple[str, ...]], ObjectLabels] = {}

    @cached_property
    def _painter(self) -> Painter:
        assert self._make_painter is not None, "this view has labels only"
        return self._make_painter(list(self.shots.values()))

    def image(self, frame: int, progress: Progress | None = None) -> Image:
        """Draw the image of a frame."""
        return self._painter.paint(self.shots[frame], progress)

    def truth(self, frame: int) -> Truth:
        """Return the ground truth of a frame.

        Cached for the last frames: at least two, because each frame is compared with the next, and as many as fit
        ``_MAX_CACHE_BYTES``, because filters and boxes visit all frames first.
        """
        if frame not in self._recent:
            new = truth_in(self.facts.expanded(frame, self._options.limit), self.shots[frame])
            max_frames = max(2, _MAX_CACHE_BYTES // _bytes_of(new))
            for old in list(self._recent)[: max(0, len(self._recent) - max_frames + 1)]:
                del self._recent[old]
                self._objects = {key: objects for key, objects in self._objects.items() if key[0] != old}
            self._recent[frame] = new
        return self._recent[frame]

    def objects(self, frame: int, words: Collection[str] = ()) -> ObjectLabels:
        """Return the objects of a frame, cached with its ground truth; see ``objects_of``."""
        truth, key = self.truth(frame), (frame, tuple(words))
        if key not in self._objects:
            self._objects[key] = objects_of(truth, words)
        return self._objects[key]

    def paths(self, frame: int) -> npt.NDArray[np.int64]:
        """Return the path number (M,) of every instance of a frame."""
        return self.facts.paths.of(self.truth(frame).ancestry)

    def some_handles(self, frame: int, rows: Sequence[int]) -> dict[int, str]:
        """Return the handles of some instances of a frame, by instance."""
        return some_handles(self.facts.scene, self.truth(frame).ancestry, rows, self.facts.numbers)

    def handles(self, frame: int) -> list[str]:
        """Return the handle of every instance of a frame."""
        return self.facts.handles(self.truth(frame), frame)

    def bodies(self, frame: int) -> IntArray:
        """Return the number of the body of every instance of a frame, -1 for several bodies."""
        return self.facts.bodies(self.truth(frame), frame)

    def flow(self, frame: int) -> Flow | None:
        """Return the motion from a frame to the next, None if the next is not among the frames."""
        if frame + 1 not in self.shots:
            return None
        truth, following = self.truth(frame), self.truth(frame + 1)
        return ground_truth.flow_between(truth, following, self.paths(frame), self.paths(frame + 1))

    @cached_property
    def tracks(self) -> Tracks | None:
        """Trajectories of points visible in the first frame; None for a single frame."""
        if len(self.shots) < 2:
            return None
        places: ground_truth.Places | None = None
        matches = []
        for frame in self.shots:
            truth, paths = self.truth(frame), self.paths(frame)
            if places is None:
                places = ground_truth.sample_places(truth, paths, self._tracked, self._options.seed)
            matches.append(ground_truth.locate(places, truth, paths))
        return ground_truth.tracks_of(matches)


def _bytes_of(truth: Truth) -> int:
    """Return the approximate memory of a ground truth, in bytes."""
    maps = (truth.instance, truth.depth, truth.normal, truth.albedo, truth.position)
    return sum(array.nbytes for array in maps) + _INSTANCE_BYTES * len(truth.ancestry)


def labeled_view(
    facts: SceneFacts, options: PictureOptions, backend: PictureBackend, frames: Sequence[int], tracked: int
) -> LabeledView:
    """Return the view of ``frames`` by the camera of ``options``, drawn by ``backend``."""

    def make_painter(shots: Sequence[Shot]) -> Painter:
        """Return the backend's painter; a shot is drawn by one backend only."""
        (painter_of_view,) = painters(facts.scene, options, [backend], shots)
        return painter_of_view

    return LabeledView(facts, options, frames, tracked, make_painter)

"""What each camera around a scene sees: image, ground truth, motion and tracks, each computed once."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from functools import cached_property

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import Progress
from scenelang.backends.labels import ground_truth
from scenelang.backends.labels.ground_truth import Expanded, Flow, Tracks, Truth, expanded, truth_in
from scenelang.backends.labels.things import Things, things_of
from scenelang.backends.pictures.film import Image, Painter, PictureBackend, PictureOptions, painters
from scenelang.backends.pictures.stage import Shot, still, unit_size
from scenelang.interpreter.inspection.numbering import ancestry_of, frame_numbers, instance_handles, some_handles
from scenelang.interpreter.scene.entity import Scene

FloatArray = npt.NDArray[np.float64]
_KEPT_BYTES = 200_000_000  # of ground truth of a view
_INSTANCE_BYTES = 500  # of the poses, ancestors and solids of an instance


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

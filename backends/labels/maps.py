"""Ground truth of one image as arrays: the class ``Maps`` of the Python API."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import require_word
from scenelang.backends.files import new_folder, write_json
from scenelang.backends.labels.dataset import ShotMaps, annotations_of, dataset, word_numbers, write_tracks
from scenelang.backends.labels.ground_truth import Tracks, bodies_of_instances
from scenelang.backends.labels.views import LabeledView, SceneFacts
from scenelang.backends.pictures.film import PictureOptions, check_opaque
from scenelang.backends.pictures.images import ApiScene, Image, shot_of
from scenelang.backends.surfaces.stand_ins import drawn_scene
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.settings import typed
from scenelang.interpreter.inspection.instance_paths import Locator, is_plain
from scenelang.interpreter.inspection.numbering import frame_numbers, instance_handles
from scenelang.interpreter.scene.entity import Scene


@dataclass(frozen=True, slots=True)
class _DrawnScene:
    """A scene whose graph is what the image shows: cubes in place of blocks."""

    graph: Scene


def maps_of(graph: Scene, options: PictureOptions, quality: str | Sequence[str] = "draft", tracked: int = 64) -> Maps:
    """Render an image with its ground truth; ``tracked`` is the number of points that ``Maps.tracks`` follows."""
    check_opaque(options)
    drawn = drawn_scene(graph, options.limit, options.warn)  # the maps must match the rendered geometry
    image, shot = shot_of(drawn, options, quality, range(len(drawn.frames)))  # as `LabeledView` does
    return Maps(_DrawnScene(drawn), replace(options, progress=None), shot.frame, tracked, image)


class Maps(Mapping[str, npt.NDArray[Any]]):
    """Ground-truth maps of a rendered image, as a mapping from names to arrays (H, W, ...).

    ``color`` is the image (H, W, 3) uint8. ``instance`` contains instance ids (-1: background), ``semantic`` word ids
    (0: background, see ``words``), ``depth`` the distance along the viewing axis in scene units (infinity: background),
    ``normal`` and ``position`` are in world space, ``albedo`` is linear sRGB. 4D scenes also have ``flow`` (pixels to
    the next frame), ``path`` and ``local``, which are equal where two frames show the same point. ``list(maps)`` lists
    all of them (docs/labels.md).
    """

    def __init__(self, scene: ApiScene, options: PictureOptions, frame: int, tracked: int, image: Image) -> None:
        """Compute the maps of a frame, and its flow if there is a next frame."""
        self.image = image
        self.graph = graph = scene.graph
        self._options, self._frame, self._tracked = options, frame, tracked
        view = self._view(range(frame, min(frame + 2, len(graph.frames))))
        self.truth = view.truth(frame)
        self.camera = self.truth.camera
        self._maps = ShotMaps(self.truth, np.ascontiguousarray(image.pixels[:, :, :3]))
        if graph.animated:
            self._maps.add_identities(view.paths(frame))
        flow = view.flow(frame)
        if flow is not None:
            self._maps.add_flow(flow)
        self._arrays: dict[str, npt.NDArray[Any]] = {"color": image.pixels[:, :, :3], **self._maps.arrays}

    def _view(self, frames: Sequence[int]) -> LabeledView:
        """Return the labels of some frames, without images."""
        facts = SceneFacts(self.graph)
        facts.number_paths(frames[-1] + 1)
        return LabeledView(facts, self._options, frames, self._tracked)

    @cached_property
    def tracks(self) -> Tracks | None:
        """Trajectories, through all frames, of points that are visible in the first one; None for a single frame."""
        return self._view(range(len(self.graph.frames))).tracks

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        return self._arrays[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._arrays)

    def __len__(self) -> int:
        return len(self._arrays)

    @property
    def words(self) -> dict[int, str]:
        """Mapping from ids in ``semantic`` to words."""
        return {number: word for word, number in word_numbers(self.truth).items()}

    @cached_property
    def _handles(self) -> list[str]:
        numbers = frame_numbers(self.graph) if len(self.graph.frames) > 1 else None
        return instance_handles(self.graph, self.truth.ancestry, numbers)

    @typed
    def annotations(self, limit: int = 20_000) -> list[dict[str, Any]]:
        """Return the visible instances as COCO annotations, at most ``limit``, highest in the hierarchy first.

        Fields: ``category``, ``bbox``, ``area``, ``segmentation``, ``box3d``, ``handle``, ``path`` (docs/labels.md).
        """
        return annotations_of(self.truth, self._maps.boxes, self._handles, limit)

    @typed
    def coco(self, limit: int = 20_000) -> dict[str, Any]:
        """Return a COCO document of this image, as JSON-serializable data."""
        image = {"file_name": "color.png", "width": self.camera.width, "height": self.camera.height}
        return dataset([image], [self.annotations(limit)])

    @typed
    def mask(self, word: str) -> npt.NDArray[np.bool_]:
        """Return the mask (H, W) of the pixels that show an entity of ``word`` or one of its parts.

        A path, such as ``pawn[2]``, selects instances as ``Scene.instances`` does. Raises SceneError("value") if the
        scene has no such word or instance.
        """
        pixels = np.zeros(self["instance"].shape, bool)
        is_selected = self._is_selected(word)
        for level in self["instance_by_depth"]:
            pixels |= (level >= 0) & is_selected[np.maximum(level, 0)]
        return pixels

    def _is_selected(self, word: str) -> npt.NDArray[np.bool_]:
        """Return which instances (M,) of the frame have a word, or are at a path."""
        require_word(self.graph, word)
        ancestry = self.truth.ancestry
        if is_plain(word):
            return np.array([entity.word == word for entity in ancestry.nodes], bool)[ancestry.node]
        paths = {each.positions for each in Locator(self.graph, self._frame).find(word)}
        return np.array([tuple(ancestry.path(i)) in paths for i in range(len(ancestry))], bool)

    @typed
    def crops(self, word: str | None = None, margin: float = 0.1) -> list[Image]:
        """Crop square images of single instances, as input for CLIP.

        Parameters
        ----------
        word : str, optional
            Word of the instances, or a path; None selects every visible instance below the root.
        margin : float
            Margin around the instance's box, as a fraction of its longer side.
        """
        if margin < 0.0:
            raise SceneError("value", f"`margin`: expected at least 0, got {margin:g}")
        is_selected = self.truth.ancestry.depth > 0 if word is None else self._is_selected(word)
        annotations = [each for each in self.annotations() if is_selected[each["instance"]]]
        return [_crop(self.image, annotation["bbox"], margin) for annotation in annotations]

    @typed
    def save(self, folder: str | Path, annotations: int = 20_000) -> Path:
        """Write all maps to a new or existing folder as PNG, NPZ, EXR and JSON (docs/labels.md). Returns it.

        ``annotations`` is the maximum number of annotated instances. Trajectories are written for 4D scenes.
        """
        with new_folder(Path(folder)) as target:
            if self.tracks is not None:
                self._maps.add_tracks(self.tracks, self._frame)
                write_tracks(target, self.tracks)
            self._maps.write(target, self._handles, bodies_of_instances(self.truth.ancestry), annotations)
            write_json(target / "coco.json", self.coco(annotations))
        return target

    def __repr__(self) -> str:
        return f"<Maps {self.camera.width} x {self.camera.height}: {', '.join(self)}>"


def _crop(image: Image, bbox: Sequence[float], margin: float) -> Image:
    """Crop a square around a pixel box (x, y, width, height), clipped to the image."""
    x, y, width, height = bbox
    half = max(width, height) * (0.5 + margin)
    x0, x1 = max(0, int(x + width / 2 - half)), min(image.size[0], int(np.ceil(x + width / 2 + half)))
    y0, y1 = max(0, int(y + height / 2 - half)), min(image.size[1], int(np.ceil(y + height / 2 + half)))
    intrinsics = image.camera.intrinsics.copy()
    intrinsics[:2, 2] -= (x0, y0)
    camera = replace(image.camera, width=x1 - x0, height=y1 - y0, intrinsics=intrinsics)
    return Image(image.pixels[y0:y1, x0:x1].copy(), image.radiance[y0:y1, x0:x1].copy(), camera)

"""What figures draw over the images of a painter: outlines, callouts and dimensions."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import Progress
from scenelang.backends.pictures import notes
from scenelang.backends.pictures.backdrops import metering
from scenelang.backends.pictures.camera import Camera
from scenelang.backends.pictures.figures import EVERYTHING, OUTLINE_WIDTH, WHOLE, WIRE_WIDTH, Figure
from scenelang.backends.pictures.linework import lines_of
from scenelang.backends.pictures.notes import Callout, Dimension, Overlay
from scenelang.backends.pictures.painted import Image, Painter, Picture, flattened
from scenelang.backends.pictures.rays import camera_rays, caster_for, ids_of
from scenelang.backends.pictures.stage import Shot, Staging
from scenelang.backends.surfaces.image_files import encode
from scenelang.grammar.diagnostics import SceneError, UsageError
from scenelang.interpreter.inspection.instance_paths import Located, Locator, box_of, primitive_ranges
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.entity import Entity, Scene, count_words
from scenelang.interpreter.scene.primitives.base import Box
from scenelang.interpreter.values.values import IDENTITY
from scenelang.stdlib.colors import color_of

IntArray = npt.NDArray[np.int64]
Float32Array = npt.NDArray[np.float32]

_WHITE = np.full(3, 255, np.uint8)
_PAPER = 0.9  # opacity of the paper around annotations, by which they are readable before dark and busy images
_LEAST_ROOM = 0.4
_MOST_LISTED = 8  # words of a scene that an error names
_MOST_SEARCHED = 100  # levels with a single part that are passed for top-level objects


class FigurePainter:
    """Draws shots as another painter does, and the lines and notes of a figure over them.

    Styles that consist of lines alone need no other painter.
    """

    def __init__(self, painter: Painter | None, staging: Staging, figure: Figure, background: str | None) -> None:
        self._painter, self._staging = painter, staging
        self._figure, self._background = figure, background

    def paint(self, shot: Shot, progress: Progress | None = None) -> Image:
        """Draw one shot; see ``Painter``."""
        figure, stage = self._figure, self._staging.stage(shot)
        ink = encode(np.array(color_of(figure.outline_color), np.float32))
        image = None if self._painter is None else self._painter.paint(shot, progress)
        if figure.has_lines or image is None:
            is_wire = figure.style == "wire"
            width = figure.outline or (WIRE_WIDTH if is_wire else OUTLINE_WIDTH)
            lines = lines_of(stage, width, every_triangle=is_wire)
            image = image or self._sheet(lines.objects, lines.ink)
            image = covered(image, ink, lines.ink)
        if figure.has_notes:
            written = notes.drawn(self._notes(shot), shot.camera.width, shot.camera.height)
            image = covered(covered(image, _WHITE, written.paper * np.float32(_PAPER)), ink, written.ink)
        return image

    def _sheet(self, objects: Float32Array, ink: Float32Array) -> Image:
        """Return white surfaces, before the background, white paper, or nothing."""
        share = np.asarray(np.rint(objects * 255.0), np.uint8)
        white = np.full((*objects.shape, 3), 255, np.uint8)
        radiance = np.ones(white.shape, np.float32)
        if self._background is None and self._staging.ground in ("transparent", "shadow"):
            return Image(white, radiance, share)
        behind = _WHITE
        if self._background is not None:
            behind = encode(np.array(color_of(self._background), np.float32))
        return Image(flattened(np.dstack([white, share]), behind), radiance)

    def _notes(self, shot: Shot) -> Overlay:
        """Return the callouts and dimensions of a shot."""
        figure, drawing = self._figure, Overlay()
        size = shot.camera.width, shot.camera.height
        root = self._staging.roots[shot.frame]
        seen = instances_seen(self._staging, shot)
        around = notes.rectangle_of(seen >= 0) or (0.0, 0.0, float(size[0]), float(size[1]))
        if figure.dimensions is not None:
            box = dimensioned_box(root, figure.dimensions)
            dimensions = notes.dimensions_of(box, shot.camera) if box is not None else []
            notes.place_dimensions(dimensions, size, drawing)
            around = notes.extent_of(dimensions, around, size)
        if figure.callouts is not None:
            notes.place_callouts(callouts_of(root, figure.callouts, seen), around, size, drawing)
        return drawing


def covered(image: Image, color: Picture, share: Float32Array) -> Image:
    """Return an image with a color (3,), 8-bit sRGB, over the ``share`` (H, W) of each pixel; its radiance stays."""
    below = np.ones_like(share) if image.alpha is None else image.alpha.astype(np.float32) / np.float32(255.0)
    alpha = share + below * (1.0 - share)
    weight = (share / np.maximum(alpha, 1e-6))[:, :, None]
    mixed = np.where(share[:, :, None] > 0.0, image.picture * (1.0 - weight) + color * weight, image.picture)
    picture = np.asarray(np.rint(mixed), np.uint8)
    total = None if image.alpha is None else np.asarray(np.rint(alpha * 255.0), np.uint8)
    return Image(picture, image.radiance, total)


def instances_seen(staging: Staging, shot: Shot) -> IntArray:
    """Return the index in the flattened frame of the primitive that each pixel (H, W) shows, -1 for none."""
    stage = staging.stage(shot)
    rays = camera_rays(stage.camera, 1)
    ids = ids_of(caster_for(stage.solids, rays).cast(stage.solids.opacity > 0.0)).astype(np.int64)
    ids[ids < 0] = -1
    return np.asarray(np.append(stage.solids.instance, -1)[ids], np.int64)


def objects_of(root: Entity, paths: tuple[str, ...]) -> list[Located]:
    """Return the instances that paths select; ``*`` means the parts of the first entity that has several.

    Raises SceneError for a path that selects nothing.
    """
    locator = Locator(Scene(root.word, [root], False))
    instances: list[Located] = []
    for path in paths:
        if path != EVERYTHING:
            instances += _selected(locator, path)
            continue
        top = Located((), root, IDENTITY)
        for _ in range(_MOST_SEARCHED):
            if len(top.entity.children) != 1 or top.entity.children[0].car.is_primitive:
                break
            top = locator.find(EVERYTHING, top)[0]
        instances += locator.find(EVERYTHING, top) if top.entity.children else [top]
    return instances


def _selected(locator: Locator, path: str) -> list[Located]:
    """Return the instances that a path selects; raises UsageError for one that selects nothing."""
    try:
        return locator.find(path)
    except SceneError as error:
        words = [word for word in count_words(locator.scene.root) if word]
        listed = ", ".join(f"`{word[:40]}`" for word in words[:_MOST_LISTED]) + ", ..." * (len(words) > _MOST_LISTED)
        raise UsageError(error.name, error.message, error.hint or f"the scene has {listed}") from None


def callouts_of(root: Entity, paths: tuple[str, ...], seen: IntArray) -> list[Callout]:
    """Return one callout for each word of the objects that paths select, largest first.

    It points at the instance that is seen best; the word of several instances has their number. ``seen`` (H, W) are
    the primitives of pixels. Raises SceneError if none of the objects is seen.
    """
    instances = objects_of(root, paths)
    areas = np.bincount(seen[seen >= 0].reshape(-1), minlength=1)
    total = np.concatenate([[0], np.cumsum(areas)])
    best: dict[str, tuple[int, tuple[int, int]]] = {}
    counts: dict[str, int] = {}
    for instance, (first, last) in zip(instances, primitive_ranges(root, instances), strict=True):
        word = instance.entity.word
        counts[word] = counts.get(word, 0) + 1
        area = int(total[min(last, len(areas))] - total[min(first, len(areas))])
        if area > best.get(word, (0, (0, 0)))[0]:
            best[word] = (area, (first, last))
    if not best:
        message = f"no object of the callouts is seen: {', '.join(paths)[:80]}"
        raise SceneError("value", message, hint="choose another camera, or other objects: `--callouts WORD,WORD`")
    callouts = []
    for word, (_, (first, last)) in sorted(best.items(), key=lambda one: -one[1][0]):
        text = _numbered(word, counts[word])
        callouts.append(Callout(text, notes.inner_point((seen >= first) & (seen < last))))
    return callouts


def _numbered(word: str, count: int) -> str:
    """Return the text of a callout: the word, and the number of its instances."""
    return notes.shown_text(word) + (f" ({count})" if count > 1 else "")


def dimensioned_box(root: Entity, path: str) -> Box | None:
    """Return the box of the objects of a path in a frame, or of the frame; None without geometry.

    Raises SceneError for a path that selects nothing.
    """
    if path == WHOLE:
        return entity_box(root)
    frame = Scene(root.word, [root], False)
    Locator(frame).find(path)
    return box_of(frame, path)


def with_room(staging: Staging, shot: Shot, figure: Figure, view: Any) -> Shot:
    """Return a shot whose objects leave room for the notes beside them, if the camera is chosen to frame them.

    ``view`` is the camera that was asked for: one that is placed, or has a distance, stays as it is.
    """
    if not figure.has_notes or isinstance(view, Camera) or getattr(view, "distance", None) is not None:
        return shot
    root, share = staging.roots[shot.frame], 1.0
    dimensions: list[Dimension] = []
    size = shot.camera.width, shot.camera.height
    if figure.dimensions is not None:
        box = dimensioned_box(root, figure.dimensions)
        dimensions = notes.dimensions_of(box, shot.camera) if box is not None else []
        share = notes.room_for(dimensions, size)
    if figure.callouts is not None:
        probe = replace(shot, camera=metering(shot.camera))
        around = notes.rectangle_of(instances_seen(staging, probe) >= 0)
        if around is not None:
            font = notes.font_size(*size)
            counts = Counter(one.entity.word for one in objects_of(root, figure.callouts))
            column = notes.column_width([_numbered(word, count) for word, count in counts.items()], font)
            ratio = shot.camera.width / probe.camera.width
            left, top, right, bottom = (ratio * side for side in around)
            left, _, right, _ = notes.extent_of(dimensions, (left, top, right, bottom), size)
            share = min(share, (shot.camera.width - 2.0 * column) / (right - left))
    return replace(shot, camera=zoomed(shot.camera, max(_LEAST_ROOM, min(1.0, share))))


def zoomed(camera: Camera, factor: float) -> Camera:
    """Return a camera in whose image everything is ``factor`` times as large, around the middle of the image."""
    intrinsics = camera.intrinsics.copy()
    half = np.array([camera.width, camera.height]) / 2.0
    intrinsics[[0, 1], [0, 1]] *= factor
    intrinsics[:2, 2] = half + (intrinsics[:2, 2] - half) * factor
    return replace(camera, intrinsics=intrinsics)

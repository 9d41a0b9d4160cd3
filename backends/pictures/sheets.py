"""Contact sheets and comparisons: grids of images with captions, in one light and before one backdrop."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import frame_of, require, sub_progress
from scenelang.backends.pictures import film, notes
from scenelang.backends.pictures.camera import PRESETS, Camera, Viewpoint
from scenelang.backends.pictures.declared import resolved, view_of
from scenelang.backends.pictures.draft import adjusted
from scenelang.backends.pictures.drawn_over import covered, instances_seen, with_room, zoomed
from scenelang.backends.pictures.figures import figured
from scenelang.backends.pictures.film import Image, Painter, Picture, PictureBackend, PictureOptions
from scenelang.backends.pictures.linework import averaged, widened
from scenelang.backends.pictures.stage import CLEAR_GROUNDS, Shot, Staging, staging_of, stills
from scenelang.backends.pictures.stage import film as shots_of
from scenelang.grammar.datum import dataclass, field, replace
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.settings import names, setting, typed, whole
from scenelang.interpreter.inspection.difference import FrameDifference, compare_frames, compared_frame
from scenelang.interpreter.scene.entity import Scene
from scenelang.interpreter.scene.exploding import with_frames
from scenelang.interpreter.scene.flatten import flatten_entity

Mask = npt.NDArray[np.bool_]

VIEWS = ("front", "right", "top", "three-quarter")  # of a sheet by default
CELL = (320, 240)  # pixels
MOST_CELLS = 100
_SIDES = ("front", "right", "back", "left", "top", "bottom", "elevation", "plan")  # parallel and to one scale in sheets
_GAP = 10  # pixels between cells
_PAPER, _INK = (255, 255, 255), (28, 30, 36)
_LINE = 1.7  # height of a caption, in sizes of its font
_TINT, _RING_PIXELS, _FINE = 0.45, 2, 3  # of what differs: opacity, width of its outline, rays per pixel and axis
# Colors of what differs between two scenes, 8-bit sRGB, with the words of the legend; readable in color blindness.
MARKS = MappingProxyType({
    "removed": (213, 94, 0), "added": (0, 158, 115), "moved": (240, 190, 20), "recolored": (0, 114, 178),
})  # fmt: skip


@dataclass(frozen=True, slots=True)
class SheetOptions:
    """What the cells of a contact sheet show: one of views, frames, values of a param, and seeds."""

    views: tuple[str, ...] | None = setting(
        None, "one cell for each camera (default front,right,top,three-quarter); views from a side are to one scale",
        metavar="VIEW,...", read=names,
    )  # fmt: skip
    frames: int | None = setting(
        None, "so many frames of a 4D scene, or of a turntable of a static one", metavar="N", read=whole
    )
    vary: str | None = setting(None, "one cell for each value of a param", metavar="PARAM=A,B,...")
    seeds: int | None = setting(None, "one cell for each of so many seeds of random numbers", metavar="N", read=whole)
    columns: int | None = setting(None, "cells of a row (default: about as many as rows)", metavar="N", read=whole)


@dataclass(frozen=True, slots=True, eq=False)
class Sheet:
    """A contact sheet.

    Attributes
    ----------
    pixels : (H, W, 3) uint8
        sRGB.
    captions : tuple of str
        Text below each cell.
    """

    pixels: Picture
    captions: tuple[str, ...]

    @typed
    def save(self, path: str | Path) -> Path:
        """Write a .png, .jpg or .webp atomically. Returns the path."""
        film.save_picture(self.pixels, path)
        return Path(path)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> npt.NDArray[Any]:
        return np.asarray(self.pixels, dtype) if not copy else np.array(self.pixels, dtype)

    def _repr_png_(self) -> bytes:
        return film.png_of(self.pixels)

    def __repr__(self) -> str:
        height, width = self.pixels.shape[:2]
        return f"<Sheet of {len(self.captions)} cells, {width} x {height}>"


@dataclass(frozen=True, slots=True, eq=False)
class SheetCell:
    """A cell of a sheet: a frame of a scene that a camera sees, and the text below."""

    caption: str
    scene: Scene
    shot: Shot


def check_sheet(options: PictureOptions, backend: PictureBackend) -> None:
    """Validate the options of sheets; raises SceneError("value")."""
    film.check(options, [backend])
    if options.background is None and film.ground_of(options) in CLEAR_GROUNDS:
        hint = "leave out the ground, or put the scene before a color: `--background white`"
        raise SceneError("value", f"a sheet has no transparency, but `{options.ground}` is the ground", hint=hint)


def check_count(count: int, what: str) -> None:
    """Raise SceneError for a sheet without cells, or with too many."""
    if not 1 <= count <= MOST_CELLS:
        raise SceneError("value", f"a sheet has 1 to {MOST_CELLS} {what}, not {count:,}")


# --- what cells show -------------------------------------------------------------------------------------------------


def cells_of_views(scene: Scene, options: PictureOptions, views: Sequence[str] = VIEWS) -> list[SheetCell]:
    """Return one cell for each view of a frame; those from a side are parallel projections to one scale.

    Raises SceneError for an unknown view.
    """
    check_count(len(views), "views")
    scene = _figured(scene, options)
    shots, sides = [], []
    for name in views:
        view = resolved(scene, view_of(name))
        is_side = name.strip().lower() in _SIDES and isinstance(view, Viewpoint)
        if is_side and isinstance(view, Viewpoint):
            view = replace(view, orthographic=True)
        (shot,) = stills(scene, view, [frame_of(scene, options.frame)], options.width, options.height)
        shots.append(shot)
        sides.append(is_side)
    least = min((shot.camera.focal[0] for shot, is_side in zip(shots, sides, strict=True) if is_side), default=0.0)
    cells = []
    for name, shot, is_side in zip(views, shots, sides, strict=True):
        camera = zoomed(shot.camera, least / shot.camera.focal[0]) if is_side else shot.camera
        cells.append(SheetCell(name.strip(), scene, replace(shot, camera=camera)))
    return cells


def cells_of_frames(scene: Scene, options: PictureOptions, count: int) -> list[SheetCell]:
    """Return cells of so many frames, evenly spaced, each once, or of a static scene of so many angles.

    Raises SceneError.
    """
    check_count(count, "frames")
    count = min(count, len(scene.frames)) if scene.animated else count
    scene = _figured(scene, options)
    shots = shots_of(scene, options.camera, options.width, options.height, count, None)
    if scene.animated:
        return [SheetCell(f"frame {shot.frame}", scene, shot) for shot in shots]
    return [SheetCell(f"{360.0 * k / count:.4g}°", scene, shot) for k, shot in enumerate(shots)]


def cells_of_scenes(named: Sequence[tuple[str, Scene]], options: PictureOptions, *, to_scale: bool) -> list[SheetCell]:
    """Return one cell for each of several scenes: with ``to_scale``, one camera sees them all at one place.

    Raises SceneError if one is empty.
    """
    check_count(len(named), "scenes")
    scenes = [(name, _figured(scene, options)) for name, scene in named]
    if not to_scale:
        size = options.width, options.height
        shots = [stills(scene, options.camera, [frame_of(scene, options.frame)], *size)[0] for _, scene in scenes]
        return [SheetCell(name, scene, shot) for (name, scene), shot in zip(scenes, shots, strict=True)]
    every = joined([scene for _, scene in scenes], options.frame)
    shots = stills(every, options.camera, range(len(scenes)), options.width, options.height)
    return [SheetCell(name, every, shot) for (name, _), shot in zip(scenes, shots, strict=True)]


def joined(scenes: Sequence[Scene], frame: int | None) -> Scene:
    """Return a 4D scene whose frames are one frame of each scene."""
    every = with_frames(scenes[0], [scene.frames[frame_of(scene, frame)] for scene in scenes])
    every.animated = True
    return every


def _figured(scene: Scene, options: PictureOptions) -> Scene:
    """Return the scene of the figure that the options ask for."""
    return figured(scene, options.figure, options.limit, options.warn)


# --- drawing ---------------------------------------------------------------------------------------------------------


def sheet_of(
    cells: Sequence[SheetCell], options: PictureOptions, backend: PictureBackend, columns: int | None = None
) -> Sheet:
    """Draw the cells of a sheet; raises SceneError and LimitError as drawing an image does."""
    check_sheet(options, backend)
    _grid(len(cells), (options.width, options.height), columns)  # before the images are drawn
    images = [image.picture for _, _, image in _drawn(cells, options, backend)]
    return arranged(images, [cell.caption for cell in cells], columns)


def _drawn(
    cells: Sequence[SheetCell], options: PictureOptions, backend: PictureBackend
) -> Iterator[tuple[Staging, Shot, Image]]:
    """Yield the staging, the shot and the image of each cell; the first one decides backdrop and exposure of all."""
    first: Staging | None = None
    known: tuple[Any, Staging, list[Painter]] | None = None
    for k, cell in enumerate(cells):
        key = (id(cell.scene), cell.shot.frame)
        if known is None or known[0] != key:
            staging = staging_of(
                cell.scene,
                [cell.shot.frame],
                options.limit,
                options.environment,
                film.ground_of(options),
                options.warn,
                film.lighting_of(options),
            )
            first = first or adjusted(staging, cell.shot)
            staging = replace(staging, backdrop=first.backdrop, lighting=first.lighting)
            known = key, staging, film.staged_painters(staging, options, [backend], len(cells))
        _, staging, painters = known
        shot = with_room(staging, cell.shot, options.figure, options.camera)
        progress = sub_progress(options.progress, k / len(cells), (k + 1) / len(cells))
        yield staging, shot, film.paint_shot(painters, shot, progress)


def arranged(
    images: Sequence[Picture], captions: Sequence[str], columns: int | None = None, legend: Legend = ()
) -> Sheet:
    """Return images of one size as a grid with captions, and a legend of texts with colors below."""
    height, width = images[0].shape[:2]
    across, font, size = _grid(len(images), (width, height), columns, has_legend=bool(legend))
    line = round(_LINE * font)
    module, pen_of = require("PIL.Image", "pillow"), require("PIL.ImageDraw", "pillow").Draw
    sheet = module.new("RGB", size, _PAPER)
    pen = pen_of(sheet)
    for k, (image, caption) in enumerate(zip(images, captions, strict=True)):
        x, y = _GAP + k % across * (width + _GAP), _GAP + k // across * (height + line)
        sheet.paste(module.fromarray(image), (x, y))
        _write(pen, (x + width / 2.0, y + height + line / 2.0), _fitting(caption, font, width), font, "mm")
    x, y = float(_GAP), size[1] - line / 2.0 - _GAP / 2.0
    for text, color in legend:
        if color is not None:
            pen.rectangle((x, y - 0.4 * font, x + 0.8 * font, y + 0.4 * font), color)
            x += 1.2 * font
        _write(pen, (x, y), text, font, "lm")
        x += notes.text_width(text, font) + 1.5 * font
    return Sheet(np.asarray(sheet, np.uint8).copy(), tuple(captions))


def _grid(
    count: int, cell: tuple[int, int], columns: int | None, *, has_legend: bool = False
) -> tuple[int, int, tuple[int, int]]:
    """Return the cells of a row, the size of the captions' font, and that of a sheet, width and height in pixels.

    Raises SceneError if the sheet is larger than an image may be.
    """
    width, height = cell
    across = min(count, columns or math.ceil(math.sqrt(count)))
    font = notes.font_size(width, height) + 1
    line = round(_LINE * font)
    down = -(-count // across) * (height + line) + _GAP + (line + _GAP if has_legend else 0)
    size = across * (width + _GAP) + _GAP, down
    try:
        film.check(PictureOptions(width=size[0], height=size[1]), [])
    except SceneError as error:
        error.hint = "draw fewer or smaller cells: `--size 320x240`"
        raise
    return across, font, size


Legend = Sequence[tuple[str, tuple[int, int, int] | None]]


def _write(pen: Any, at: tuple[float, float], text: str, font: int, anchor: str) -> None:
    """Write a text at a pixel."""
    pen.text(at, text, _INK, film.font_for(text, font), anchor)


def _fitting(text: str, font: int, width: int) -> str:
    """Return a caption shortened to the width of its cell."""
    shown = notes.shown_text(text)
    while len(shown) > 2 and notes.text_width(shown, font) > width:
        shown = f"{shown[:-2]}…"
    return shown


# --- comparison ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class Comparison(Sheet):
    """Two scenes side by side, seen by one camera, with what differs in color.

    ``counts`` are the numbers of primitives that are removed, added, moved and recolored, by name.
    """

    counts: dict[str, int] = field(default_factory=dict)

    @property
    def equal(self) -> bool:
        """Whether nothing differs."""
        return not any(self.counts.values())


def compared(
    named: Sequence[tuple[str, Scene]], options: PictureOptions, backend: PictureBackend, tolerance: float
) -> Comparison:
    """Draw two scenes side by side, and mark the primitives that differ.

    Parameters
    ----------
    named
        Both scenes, with their captions.
    tolerance
        Largest difference that is ignored, relative to the size of the scene.

    Raises
    ------
    SceneError
        If one is empty, or the options are invalid.
    """
    check_sheet(options, backend)
    _grid(2, (options.width, options.height), 2, has_legend=True)
    if options.figure.section is not None or options.figure.style == "wire":
        message = "a comparison shows whole primitives, which a section or a wireframe has not"
        raise SceneError("value", message, hint="leave it out, or draw a sheet without `--compare`")
    cells = cells_of_scenes(named, options, to_scale=True)
    drawn = list(_drawn(cells, options, backend))
    roots = [staging.roots[shot.frame] for staging, shot, _ in drawn]
    before, after = (compared_frame(flatten_entity(root)) for root in roots)
    difference = compare_frames(before, after, tolerance)
    images = [
        _marked(staging, shot, image, rows).picture
        for (staging, shot, image), rows in zip(drawn, _rows(difference), strict=True)
    ]
    counts = {
        "removed": len(difference.missing), "added": len(difference.extra), "moved": len(difference.moved),
        "recolored": len(difference.recolored),
    }  # fmt: skip
    legend = [(f"{count:,} {kind}", MARKS[kind]) for kind, count in counts.items() if count]
    sheet = arranged(images, [cell.caption for cell in cells], 2, legend or [("nothing differs", None)])
    return Comparison(sheet.pixels, sheet.captions, counts)


def _rows(difference: FrameDifference) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the primitives of each side that differ, by the kind of difference."""
    moved, recolored = difference.moved.reshape(-1, 2), difference.recolored.reshape(-1, 2)
    return (
        {"removed": difference.missing, "moved": moved[:, 0], "recolored": recolored[:, 0]},
        {"added": difference.extra, "moved": moved[:, 1], "recolored": recolored[:, 1]},
    )


def _marked(staging: Staging, shot: Shot, image: Image, rows: dict[str, Any]) -> Image:
    """Return an image in which primitives are tinted and outlined in the color of their kind of difference."""
    camera: Camera = shot.camera
    fine = Shot(shot.frame, camera.resized(camera.width * _FINE, camera.height * _FINE))
    seen = instances_seen(staging, fine)
    for kind, which in rows.items():
        mask = (seen >= 0) & np.isin(seen, which)
        if mask.any():
            color = np.array(MARKS[kind], np.uint8)
            ring = widened(mask, float(_RING_PIXELS * _FINE)) & ~mask
            image = covered(image, color, averaged(mask, _FINE) * np.float32(_TINT))
            image = covered(image, color, averaged(ring, _FINE))
    return image


def cells_of(scene: Scene, wanted: SheetOptions, options: PictureOptions) -> list[SheetCell]:
    """Return the cells of a sheet of one scene: of frames, or of views. Raises SceneError."""
    if wanted.frames is not None:
        return cells_of_frames(scene, options, wanted.frames)
    return cells_of_views(scene, options, wanted.views or VIEWS)


def check_wanted(wanted: SheetOptions, scenes: int, *, is_comparison: bool = False) -> None:
    """Raise SceneError if several contents of a sheet are asked for, or what several scenes cannot have."""
    given = [name for name in ("views", "frames", "vary", "seeds") if getattr(wanted, name) is not None]
    if len(given) > 1:
        message = f"`{given[0]}` and `{given[1]}` exclude each other: a sheet varies one thing"
        raise SceneError("value", message, hint=f"leave out `--{given[1]}`")
    if is_comparison and scenes != 2:
        raise SceneError("value", f"a comparison is of two scenes, not {scenes}", hint="write `sheet A B --compare`")
    if given and (scenes > 1 or is_comparison):
        message = f"`{given[0]}` is for a sheet of one scene, not of {scenes}"
        raise SceneError("value", message, hint="give one file, or leave it out for one cell for each file")
    if wanted.columns is not None and not 1 <= wanted.columns <= MOST_CELLS:
        raise SceneError("value", f"a sheet has 1 to {MOST_CELLS} columns, not {wanted.columns}")
    if wanted.views is not None and not (wanted.views and all(map(str.strip, wanted.views))):
        message = f"`views` expects names of cameras with commas between them, got `{','.join(wanted.views)[:60]}`"
        raise SceneError("value", message, hint=f"name a camera of the program, or {', '.join(PRESETS)}")
    for name in ("frames", "seeds"):
        if (count := getattr(wanted, name)) is not None:
            check_count(count, name)


def values_in(text: str) -> tuple[str, list[str]]:
    """Read ``PARAM=A,B,...`` as a name and the texts of values; raises SceneError("value").

    Examples
    --------
    >>> values_in("legs=3,4,5")
    ('legs', ['3', '4', '5'])
    """
    name, equals, values = text.partition("=")
    listed = [value.strip() for value in values.split(",")]
    if not equals or not name.strip() or not all(listed):
        message = "`vary` expects a param of the program and its values"
        raise SceneError("value", f"{message}, got `{text[:60]}`", hint="write `--vary legs=3,4,5`")
    check_count(len(listed), "values")
    return name.strip(), listed

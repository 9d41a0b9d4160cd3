"""Pictures of scenes: what the backends that draw have in common."""

from __future__ import annotations

import io
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import (
    Backend,
    BackendOptions,
    PluginRegistry,
    Progress,
    check_settings,
    find,
    need,
    part_of,
)
from scenelang.backends.files import written_whole
from scenelang.backends.geometry.solids import Solids
from scenelang.backends.pictures.camera import LARGEST, Camera, Viewpoint
from scenelang.backends.pictures.stage import Shot, Staging, staging_of, still
from scenelang.backends.pictures.stage import film as shots_of
from scenelang.backends.pictures.studio import ENVIRONMENTS, GROUNDS
from scenelang.grammar.diagnostics import SceneError, suggest
from scenelang.grammar.settings import setting, whole
from scenelang.interpreter.scene.entity import Scene

Picture = npt.NDArray[np.uint8]

SOFTWARE = "scenelang"  # what the metadata of images says
STILL_ENDINGS = (".png", ".jpg", ".jpeg", ".webp", ".exr")
_MOST_PIXELS = 4096 * 4096


@dataclass(frozen=True, slots=True)
class PictureOptions(BackendOptions):
    """``width`` and ``height`` in pixels; ``camera`` is placed or to be placed; ``environment`` and ``ground`` (None:
    the environment's own) are names of ``studio``; the same ``seed`` gives the same picture; ``labels`` writes the
    words of semantic primitives on the picture."""

    width: int = 512
    height: int = 512
    camera: Viewpoint | Camera = field(default_factory=Viewpoint)
    environment: str = setting("studio", "the light: studio, overcast, sunny, sunset, night, flat", metavar="NAME")
    ground: str | None = setting(None, "seamless, none, white, dark, meadow, earth, checker", metavar="NAME")
    seed: int = 0
    labels: bool = setting(True, "no words on the boxes of semantic primitives", "--no-labels")


@dataclass(frozen=True, slots=True, eq=False)
class Image:
    """A drawn shot: ``picture`` (H, W, 3) 8-bit sRGB with labels, ``radiance`` (H, W, 3) linear sRGB without."""

    picture: Picture
    radiance: npt.NDArray[np.float32]


class Painter(Protocol):
    """Draws shots of one staging; what they have in common is worked out once."""

    def paint(self, shot: Shot, progress: Progress | None = None) -> Image:
        """Draw one shot; ``progress`` is called with a fraction from 0 to 1. Raises SceneError."""


@dataclass(frozen=True, slots=True)
class PictureBackend(Backend):
    """A backend that draws pictures: ``painter(staging, options, shots)`` for a picture or a film of so many shots."""

    painter: Callable[[Staging, PictureOptions, int], Painter] | None = None


@dataclass(frozen=True, slots=True)
class Quality:
    """A quality of pictures: the backend that draws them, and values of its own options, which users' win over."""

    name: str
    doc: str
    backend: str
    settings: Mapping[str, Any] = field(default_factory=dict)


DRAFT_QUALITY = Quality("draft", "solid shading, in a moment", "draft")
FINAL_QUALITY = Quality("final", "path traced", "mitsuba")
QUALITIES = PluginRegistry("scenelang.qualities", "quality", Quality)


def picture_backend(name: str) -> PictureBackend:
    """The backend that is called ``name`` or draws pictures of that quality; raises SceneError("backend")."""
    quality = QUALITIES.get(name) or Quality(name, "", name)
    backend = find(quality.backend)
    if not isinstance(backend, PictureBackend) or backend.painter is None:
        raise SceneError("backend", f"the backend `{name}` draws no pictures", hint="`scenelang backends` lists them")
    return _with_settings(backend, quality.settings) if quality.settings else backend


def _with_settings(backend: PictureBackend, settings: Mapping[str, Any]) -> PictureBackend:
    """A backend whose own options have these values where users give none."""
    paint = backend.painter
    assert paint is not None

    def painter(staging: Staging, options: PictureOptions, shots: int) -> Painter:
        given = {name: value for name, value in options.settings.items() if value is not None}
        return paint(staging, replace(options, settings={**settings, **given}), shots)

    return replace(backend, painter=painter)


def render(scene: Scene, options: PictureOptions | None = None, backend: str = "draft") -> Picture:
    """One frame of ``scene`` as a picture: (height, width, 3), 8-bit sRGB. ``backend`` is a name or a quality.

    Raises SceneError: "empty-scene" when nothing would be drawn, "backend" when a package is missing, "value" for
    sizes and cameras that make no sense, "attribute" for an attribute that fits no surface.
    """
    return draw(scene, options or PictureOptions(), picture_backend(backend)).picture


def draw(scene: Scene, options: PictureOptions, backend: PictureBackend) -> Image:
    """One frame of ``scene`` as an image, drawn by ``backend``; raises SceneError as ``render`` does."""
    check(options, [backend])
    shot = still(scene, options.camera, options.frame, options.width, options.height)
    return paint_shot(painters(scene, options, [backend], [shot]), shot, options.progress)


def painters(
    scene: Scene, options: PictureOptions, backends: Sequence[PictureBackend], shots: Sequence[Shot]
) -> list[Painter]:
    """The painters of several backends for the same ``shots``; raises SceneError."""
    frames = [shot.frame for shot in shots]
    staging = staging_of(scene, frames, options.limit, options.environment, options.ground, options.warn)
    return [backend.painter(staging, options, len(shots)) for backend in backends if backend.painter is not None]


def paint_shot(painters: Sequence[Painter], shot: Shot, progress: Progress | None = None) -> Image:
    """One shot as each painter draws it, side by side; raises SceneError."""
    count = len(painters)
    images = [painter.paint(shot, part_of(progress, i / count, (i + 1) / count)) for i, painter in enumerate(painters)]
    if count == 1:
        return images[0]
    pictures, radiances = [image.picture for image in images], [image.radiance for image in images]
    return Image(np.concatenate(pictures, axis=1), np.concatenate(radiances, axis=1))


def check(options: PictureOptions, backends: Sequence[Backend]) -> None:
    """Raises SceneError("value") for options that make no sense, whatever the scene."""
    if not (1 <= options.width <= LARGEST and 1 <= options.height <= LARGEST):
        raise SceneError(
            "value", f"a picture is 1 to {LARGEST} pixels wide and high, not {options.width} x {options.height}"
        )
    if options.width * options.height > _MOST_PIXELS:
        raise SceneError("value", f"a picture may have {_MOST_PIXELS:,} pixels, not {options.width} x {options.height}")
    _check_name("environment", options.environment, tuple(ENVIRONMENTS))
    if options.ground is not None:
        _check_name("ground", options.ground, tuple(GROUNDS))
    check_settings(options, backends)


def _check_name(what: str, name: str, known: Sequence[str]) -> None:
    if name not in known:
        hint = suggest(name, known) or f"it can be one of {', '.join(known)}"
        raise SceneError("value", f"there is no {what} `{name}`", hint=hint)


def write_still(backend_name: str) -> Callable[[Scene, Path, BackendOptions], None]:
    """The operation R of a picture backend, for the registry: draws one picture and writes it."""

    def run(scene: Scene, path: Path, options: BackendOptions) -> None:
        if not isinstance(options, PictureOptions):
            options = PictureOptions(options.frame, options.limit, options.progress, options.settings, options.warn)
        save_image(draw(scene, options, picture_backend(backend_name)), path)

    return run


def save_image(image: Image, path: Path | str) -> None:
    """Write ``image`` by the ending of ``path``, whole or not at all: PNG, JPEG, WebP, or its radiance as EXR.

    Raises SceneError: "backend" for another ending, "file" when the file cannot be written.
    """
    target = Path(path)
    if target.suffix.lower() == ".exr":
        save_radiance(image.radiance, target)
    else:
        save_picture(image.picture, target)


def save_picture(picture: Picture, path: Path | str) -> None:
    """Write ``picture`` (H, W, 3) as PNG, JPEG or WebP by the ending of ``path``, whole or not at all.

    Raises SceneError: "backend" for another ending, "file" when the file cannot be written.
    """
    target = Path(path)
    endings = tuple(ending for ending in STILL_ENDINGS if ending != ".exr")
    if target.suffix.lower() not in endings:
        raise SceneError("backend", f"a picture cannot be written as `{target.name}`", hint=f"use {' '.join(endings)}")
    image = need("PIL.Image", "pillow").fromarray(picture)
    named = {"pnginfo": png_text({"Software": SOFTWARE})} if target.suffix.lower() == ".png" else {}
    with written_whole(target) as temporary:
        image.save(temporary, quality=92, **named)


def png_text(chunks: Mapping[str, str]) -> Any:
    """Return text chunks of a PNG for Pillow's ``pnginfo``."""
    info = need("PIL.PngImagePlugin", "pillow").PngInfo()
    for name, text in chunks.items():
        info.add_text(name, text)
    return info


def wrote_picture(path: Path) -> bool:
    """Return whether ``path`` is a PNG or a GIF that scenelang wrote, so that it may be replaced without asking."""
    module = need("PIL.Image", "pillow")
    try:
        with module.open(path) as image:
            found = image.info.get("Software") or image.info.get("comment", b"").decode("latin-1")
    except (OSError, ValueError, SyntaxError):  # not an image, or a broken one
        return False
    return str(found).startswith(SOFTWARE)


def png_of(picture: Picture) -> bytes:
    """``picture`` (H, W, 3) as PNG; raises SceneError("backend") without pillow."""
    data = io.BytesIO()
    need("PIL.Image", "pillow").fromarray(picture).save(data, "PNG")
    return data.getvalue()


def save_radiance(radiance: npt.NDArray[np.float32], path: Path | str) -> None:
    """Write ``radiance`` (H, W, 3), linear sRGB, as OpenEXR, whole or not at all; raises SceneError."""

    write_exr({"": radiance}, Path(path))


# Films: turntables of static scenes, the frames of 4D ones; GIF, animated PNG and WebP by Pillow, MP4 by PyAV.


ENDINGS = (".gif", ".mp4", ".apng", ".webp")
FPS = 24
HIGHEST_FPS = 240.0
_MOST_BYTES = 4_000_000_000  # of all pictures of one film in memory
_GIF_COLORS = 255


def is_film(path: Path | str, wanted: bool) -> bool:
    """Whether ``path`` is to be a film: by its ending; a WebP file or a PNG may be either and is what is ``wanted``."""
    ending = Path(path).suffix.lower()
    return ending in (".gif", ".mp4", ".apng") or (wanted and ending in (".webp", ".png"))


def save_film(
    painters: Sequence[Painter],
    shots: Sequence[Shot],
    path: Path | str,
    fps: float = FPS,
    progress: Progress | None = None,
) -> None:
    """Draw ``shots`` and write them as one film by the ending of ``path``, whole or not at all.

    Several painters draw side by side. Raises SceneError: "value" for a frame rate that is none, "backend" for another
    ending or a missing package, "unsupported" where the film would not fit the memory, "file" when the file cannot be
    written.
    """
    target = Path(path)
    check_film(target, fps)
    size = sum(shot.camera.width * shot.camera.height * 3 for shot in shots) * len(painters)
    if target.suffix.lower() != ".mp4" and size > _MOST_BYTES:
        raise SceneError(
            "unsupported", f"{len(shots)} pictures of that size do not fit one {target.suffix} file",
            hint="write an .mp4, fewer --frames, or a smaller --size",
        )  # fmt: skip
    pictures = _drawn(painters, shots, progress)
    with written_whole(target) as temporary:
        if target.suffix.lower() == ".mp4":
            _write_mp4(pictures, temporary, fps)
        else:
            _write_pillow(pictures, temporary, fps)
    if progress is not None:
        progress(1.0)


def check_film(path: Path, fps: float) -> None:
    """Raises SceneError for a frame rate or an ending that no film has, or when its package is missing."""
    if not 0.0 < fps <= HIGHEST_FPS:
        raise SceneError("value", f"a film has up to {HIGHEST_FPS:g} frames per second, not {fps:g}")
    ending = path.suffix.lower()
    if ending not in (*ENDINGS, ".png"):
        raise SceneError("backend", f"a film cannot be written as `{path.name}`", hint=f"use {' '.join(ENDINGS)}")
    if ending == ".mp4":
        need("av", "'scenelang[video]'")


@dataclass(frozen=True, slots=True)
class FilmOptions:
    """A film's number of pictures (None: the scene's own, or 48), pictures per second (None: 24), and how many degrees
    the camera goes round the scene (None: once round a static scene)."""

    frames: int | None = setting(None, "pictures of a film (default: the scene's, or 48)", metavar="N", read=whole)
    fps: float | None = setting(None, "pictures per second (default 24)", metavar="X", read=float)
    orbit: float | None = setting(None, "how far the camera goes round the scene", metavar="DEGREES", read=float)

    @property
    def is_wanted(self) -> bool:
        """True where any of these was asked for."""
        return any(value is not None for value in (self.frames, self.fps, self.orbit))


def check_output(path: Path, frame: int | None, film: FilmOptions, backends: int) -> None:
    """Raises SceneError for a file that no picture or film can be written to."""
    ending = path.suffix.lower()
    known = sorted({*STILL_ENDINGS, *ENDINGS})
    if ending not in known:
        shown = f"`{ending}` files" if ending else "a file without an ending"
        raise SceneError("backend", f"no backend writes {shown}", hint=f"it can be one of {' '.join(known)}")
    if is_film(path, film.is_wanted):
        if frame is not None:
            raise SceneError("value", "`--frame` asks for one picture, but a film is to be written")
        check_film(path, FPS if film.fps is None else film.fps)
    elif film.is_wanted:
        hint = f"write {' '.join(ENDINGS)}, or leave out --frames, --fps and --orbit"
        raise SceneError("value", f"`{path.name}` is one picture, but a film is asked for", hint=hint)
    elif ending == ".exr" and backends > 1:
        raise SceneError("value", "an .exr file holds what one backend draws")


def write_drawing(
    scene: Scene, path: Path, options: PictureOptions, film: FilmOptions, backends: Sequence[PictureBackend]
) -> None:
    """Draw the scene by one backend, or by several side by side, and write a picture or a film by the ending of
    ``path``: a WebP file of a 4D scene is a film. Raises SceneError."""
    wanted = film.is_wanted or (scene.animated and options.frame is None and path.suffix.lower() == ".webp")
    if is_film(path, wanted):
        shots = shots_of(scene, options.camera, options.width, options.height, film.frames, film.orbit)
        fps = FPS if film.fps is None else film.fps
        save_film(painters(scene, options, backends, shots), shots, path, fps, options.progress)
        return
    shot = still(scene, options.camera, options.frame, options.width, options.height)
    save_image(paint_shot(painters(scene, options, backends, [shot]), shot, options.progress), path)


def _drawn(painters: Sequence[Painter], shots: Sequence[Shot], progress: Progress | None) -> Iterator[Picture]:
    step = 0.98 / len(shots)
    for i, shot in enumerate(shots):
        yield paint_shot(painters, shot, part_of(progress, step * i, step * (i + 1))).picture


def _write_pillow(pictures: Iterator[Picture], path: Path, fps: float) -> None:
    module = need("PIL.Image", "pillow")
    images = [module.fromarray(picture) for picture in pictures]
    ending = path.suffix.lower()
    if ending == ".gif":
        images = [image.quantize(_GIF_COLORS, module.Quantize.FASTOCTREE) for image in images]
    first, rest = images[0], images[1:]
    kind = {".gif": "GIF", ".webp": "WEBP"}.get(ending, "PNG")
    more: dict[str, Any] = {"quality": 88, "method": 4} if kind == "WEBP" else {}
    if kind == "GIF":
        more = {"optimize": False, "comment": SOFTWARE.encode()}
    first.save(
        path, kind, save_all=True, append_images=rest, duration=_durations(len(images), fps, kind), loop=0, **more
    )


def _durations(count: int, fps: float, kind: str) -> list[int]:
    """Milliseconds that each picture stands, so that they add up; GIF counts in hundredths of a second."""
    unit = 10 if kind == "GIF" else 1
    ends = [round(1000.0 * (i + 1) / fps / unit) * unit for i in range(count)]
    return [max(unit, end - start) for start, end in zip([0, *ends[:-1]], ends, strict=True)]


def _write_mp4(pictures: Iterator[Picture], path: Path, fps: float) -> None:
    """H.264 as most players know it: even sizes, 4:2:0."""
    av = need("av", "'scenelang[video]'")
    with av.open(str(path), "w", format="mp4", options={"movflags": "faststart"}) as container:
        stream = container.add_stream("libx264", rate=Fraction(fps).limit_denominator(1001))
        stream.pix_fmt, stream.options = "yuv420p", {"crf": "18"}
        for i, picture in enumerate(pictures):
            even = np.pad(picture, ((0, picture.shape[0] % 2), (0, picture.shape[1] % 2), (0, 0)), mode="edge")
            if i == 0:
                stream.height, stream.width = even.shape[:2]
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(even), format="rgb24")
            for packet in stream.encode(frame):
                container.mux(packet)
        for packet in stream.encode():
            container.mux(packet)


# The words of semantic primitives, written on a picture where their boxes can be seen (Pillow).


Rectangle = tuple[float, float, float, float]

_MOST = 40
_MOST_PER_WORD = 6
_LONGEST = 32
_LEAST_SHARE = 1.5e-4  # of the picture's pixels that a box must show to be labelled
_INK = (28, 30, 36)
_PAPER = (255, 255, 255)
_SHIFTS = (0.0, -1.0, 1.0, -2.0, 2.0)  # lines that a word's first label may move to find room


@dataclass(frozen=True, slots=True)
class Label:
    """``text`` centred at pixel (``x``, ``y``); ``first`` when no larger box has the same word."""

    text: str
    x: float
    y: float
    first: bool


def labelled(picture: Picture, solids: Solids, ids: npt.NDArray[np.int64]) -> Picture:
    """``picture`` (H, W, 3), whose pixels see the solids ``ids`` (H, W), with the words of semantic primitives."""
    return write_labels(picture, labels_of(solids, ids))


def labels_of(solids: Solids, ids: npt.NDArray[np.int64]) -> list[Label]:
    """What to write on a picture whose pixels (H, W) see the solids ``ids``: the largest seen boxes first.

    A label stands at the middle of what is seen of its box, so nothing nearer hides it.
    """
    rows, columns = np.nonzero(ids >= 0)
    seen = ids[rows, columns]
    semantic = solids.semantic[seen]
    rows, columns, seen = rows[semantic], columns[semantic], seen[semantic]
    if not len(seen):
        return []
    numbers, inverse = np.unique(seen, return_inverse=True)
    area = np.bincount(inverse)
    x, y = np.bincount(inverse, columns + 0.5) / area, np.bincount(inverse, rows + 0.5) / area
    labels: list[Label] = []
    used: Counter[str] = Counter()
    for k in np.argsort(-area, kind="stable"):
        word = solids.words[int(solids.word[numbers[k]])]
        if area[k] < max(4.0, _LEAST_SHARE * ids.size) or used[word] >= _MOST_PER_WORD:
            continue
        labels.append(Label(_shortened(word), float(x[k]), float(y[k]), used[word] == 0))
        used[word] += 1
    labels.sort(key=lambda label: not label.first)
    return labels


def write_labels(picture: Picture, labels: list[Label]) -> Picture:
    """A copy of ``picture`` (H, W, 3) with ``labels`` written on it; those that would overlap others are left out."""
    if not labels:
        return picture
    image_module, draw_module = need("PIL.Image", "pillow"), need("PIL.ImageDraw", "pillow")
    image = image_module.fromarray(picture)
    pen = draw_module.Draw(image)
    height, width = picture.shape[:2]
    size = int(min(32, max(10, round(min(height, width) / 30))))
    stroke = max(1, round(size / 9))
    taken: list[Rectangle] = []
    for label in labels:
        font = _font(label.text, size)
        for x, y in _places(label, size * 1.25):
            box: Rectangle = pen.textbbox((x, y), label.text, font=font, anchor="mm", stroke_width=stroke)
            x, y = x + _inward(box[0], box[2], width), y + _inward(box[1], box[3], height)
            box = pen.textbbox((x, y), label.text, font=font, anchor="mm", stroke_width=stroke)
            if not any(_overlap(box, other) for other in taken):
                pen.text((x, y), label.text, font=font, anchor="mm", fill=_INK, stroke_width=stroke, stroke_fill=_PAPER)
                taken.append(box)
                break
        if len(taken) >= _MOST:
            break
    return np.asarray(image, np.uint8).copy()


def _places(label: Label, line: float) -> Iterator[tuple[float, float]]:
    for shift in _SHIFTS if label.first else (0.0,):
        yield label.x, label.y + shift * line


def _inward(low: float, high: float, size: int) -> float:
    """How far to move the span from ``low`` to ``high`` so that it lies in a picture of ``size``, if it fits."""
    return max(0.0, 2.0 - low) if low < 2.0 else min(0.0, size - 2.0 - high)


def _overlap(a: Rectangle, b: Rectangle) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def _shortened(word: str) -> str:
    """The word on one line, without what cannot be printed."""
    text = "".join(c if c.isprintable() else " " for c in word).strip()
    return text if len(text) <= _LONGEST else text[: _LONGEST - 1] + "…"


def _font(text: str, size: int) -> Any:
    """Pillow's own font, or a wider system font where the text goes beyond Latin letters and one is found."""
    fonts = need("PIL.ImageFont", "pillow")
    if not text.isascii():
        for name in ("DejaVuSans.ttf", "NotoSans-Regular.ttf", "Arial Unicode.ttf", "arial.ttf"):
            try:
                return fonts.truetype(name, size)
            except OSError:
                continue
    return fonts.load_default(size)


# OpenEXR files of several named layers, written by Mitsuba's bitmaps (no variant is needed).


_CHANNELS = {1: ("Y",), 2: ("X", "Y"), 3: ("R", "G", "B"), 4: ("R", "G", "B", "A")}


def write_exr(layers: Mapping[str, npt.NDArray[np.float32]], path: Path, xyz: frozenset[str] = frozenset()) -> None:
    """Write ``layers``, each (H, W) or (H, W, C) with C <= 4, as one file of 32-bit floats, whole or not at all.

    The layer called "" has the channels R G B; others ``name.R`` and so on, ``name.X`` ... where named in ``xyz``.
    Raises SceneError: "backend" without Mitsuba, "file" when the file cannot be written.
    """
    mi = need("mitsuba", "mitsuba")
    names: list[str] = []
    columns: list[npt.NDArray[np.float32]] = []
    for name, values in layers.items():
        grid = np.asarray(values, np.float32).reshape(*values.shape[:2], -1)
        channels = ("X", "Y", "Z", "W") if name in xyz else _CHANNELS[grid.shape[2]]
        names += [f"{name}.{channel}" if name else channel for channel in channels[: grid.shape[2]]]
        columns.append(grid)
    joined = np.ascontiguousarray(np.concatenate(columns, axis=2))
    bitmap = mi.Bitmap(joined, pixel_format=mi.Bitmap.PixelFormat.MultiChannel, channel_names=names)
    with written_whole(path) as temporary:
        bitmap.write(str(temporary))

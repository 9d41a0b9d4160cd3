"""Images and videos: what all picture backends share, from options to files.

``draft`` and ``mitsuba`` draw the shots of a ``stage``; this module chooses a backend, joins images, and writes files.
"""

from __future__ import annotations

import io
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import (
    Backend,
    BackendOptions,
    Progress,
    Work,
    all_backends,
    check_settings,
    find,
    frame_of,
    names,
    require,
    sub_progress,
)
from scenelang.backends.files import atomic_write, reason_of
from scenelang.backends.pictures.camera import LARGEST
from scenelang.backends.pictures.declared import Lighting, ProgramView, View
from scenelang.backends.pictures.figures import PLAIN, Figure, check_drawable, check_figure, figured
from scenelang.backends.pictures.painted import Image as Image
from scenelang.backends.pictures.painted import Painter as Painter
from scenelang.backends.pictures.painted import Picture as Picture
from scenelang.backends.pictures.painted import flattened as flattened
from scenelang.backends.pictures.painted import font_for as font_for
from scenelang.backends.pictures.stage import CLEAR_GROUNDS, MOST_ORBIT, Shot, Staging, staging_of, stills
from scenelang.backends.pictures.stage import film as shots_of
from scenelang.backends.pictures.surroundings import settled
from scenelang.backends.surfaces.environments import GROUNDS, TONES, environment_of
from scenelang.backends.surfaces.image_files import encode
from scenelang.backends.surfaces.solids import Solids
from scenelang.grammar.datum import dataclass, field, replace
from scenelang.grammar.diagnostics import SceneError, suggest
from scenelang.grammar.settings import FRAME_RATES, frame_rate, setting, whole, within
from scenelang.interpreter.plugins import PluginRegistry
from scenelang.interpreter.scene.entity import Scene
from scenelang.interpreter.scene.setup import SETTINGS, named
from scenelang.stdlib.colors import color_of

SOFTWARE = "scenelang"  # in the metadata of images, by which `wrote_picture` recognizes them
FINAL_EXTRA = "'scenelang[final]'"  # what installs Mitsuba, as error messages show it
STILL_ENDINGS = (".png", ".jpg", ".jpeg", ".webp", ".exr")
_OPAQUE = (".jpg", ".jpeg")
_MAX_PIXELS = 4096 * 4096  # of one image
_STILL_QUALITY, _WEBP_VIDEO_QUALITY = 92, 88  # percent
_MAX_INPUT_PIXELS = 64_000_000  # of an image that is read: a 64-megapixel photo, 200 MB as RGB


METERED = "auto"  # the exposure by what the first image shows


def _exposure(text: str) -> float | str:
    """Parse the exposure of an option; raises ValueError."""
    if text == METERED:
        return METERED
    try:
        return within(-30.0, 30.0)(text)
    except ValueError as error:
        raise ValueError(f"{error}; or `{METERED}`") from None


@dataclass(frozen=True, slots=True)
class PictureOptions(BackendOptions):
    """Options of picture backends.

    Attributes
    ----------
    width, height
        In pixels.
    camera
        A placed camera, a viewpoint to be placed, or a camera of the program, by default its first one.
    environment, ground
        As ``environment_of`` reads it, and a name in ``GROUNDS`` or ``CLEAR_GROUNDS``; the ground is by default that of
        the environment.
    exposure
        Stops by which images are brighter, by default what the program declares; ``METERED`` for those by which what
        the first image shows is neither dark nor burnt out.
    tone
        Name of the tone curve, in ``TONES``.
    shutter
        Share of the time between two frames during which what moves is blurred; 0 draws sharp images.
    background
        Flat color behind the scene, which then has no ground but perhaps its shadow: a CSS name or ``#rrggbb``.
    seed
        Images are reproducible for a given seed.
    labels
        Write the words of semantic primitives on the image.
    figure
        What a publication figure shows of the scene, and over its image.
    stated
        Fields that what a program declares does not replace: "size", "environment" and "ground"; None if it replaces
        nothing.
    lighting
        What the program declares of its light, once ``settled`` knows the scene.
    """

    width: int = 512
    height: int = 512
    camera: View = field(default_factory=ProgramView)
    environment: str = setting(
        "studio",
        "lighting: studio, softboxes, overcast, sunny, sunset, night, flat, sky,hour=15, or FILE.hdr or FILE.exr; then "
        "turn=DEGREES,strength=X",
        metavar="NAME",
    )
    exposure: float | str | None = setting(
        None,
        "stops by which images are brighter, or auto: by what the first image shows",
        metavar="STOPS",
        read=_exposure,
    )
    tone: str | None = setting(None, "tone curve: soft (default) or agx", metavar="NAME")
    shutter: float = setting(
        0.0,
        "motion blur over this share of the time between frames, such as 0.5",
        metavar="SHARE",
        read=within(0.0, 1.0),
    )
    ground: str | None = setting(
        None,
        "ground: seamless, none, white, dark, meadow, earth, checker; transparent or shadow: an image with alpha",
        metavar="NAME",
    )
    background: str | None = setting(
        None, "flat color behind the scene, without a ground: a CSS name or #rrggbb", metavar="COLOR"
    )
    seed: int = 0
    labels: bool = setting(True, "do not label the boxes of semantic primitives", "--no-labels")
    figure: Figure = PLAIN
    stated: tuple[str, ...] | None = ("size",)
    lighting: Lighting | None = None


@dataclass(frozen=True, slots=True)
class PictureBackend(Backend):
    """A backend that draws pictures; ``painter(staging, options, shots)`` creates a painter for a number of shots."""

    painter: Callable[[Staging, PictureOptions, int], Painter] | None = None
    has_alpha: bool = False  # whether it draws without ground and backdrop


@dataclass(frozen=True, slots=True)
class Quality:
    """A quality preset: the backend and the default values of its options, which explicit settings override."""

    name: str
    doc: str
    backend: str
    settings: Mapping[str, Any] = field(default_factory=dict)


DRAFT_QUALITY = Quality("draft", "fast solid shading", "draft")
FINAL_QUALITY = Quality("final", "path traced", "mitsuba")
QUALITIES = PluginRegistry("scenelang.qualities", "quality", Quality)


def picture_backend(name: str) -> PictureBackend:
    """Return the picture backend for a backend name or a quality preset; raises SceneError("backend")."""
    quality = QUALITIES.get(name) or Quality(name, "", name)
    if QUALITIES.get(name) is None and name not in names():
        known = list(dict.fromkeys((*QUALITIES.names(), *(backend.name for backend in all_backends(Work.PICTURE)))))
        hint = suggest(name.lower(), known)
        raise SceneError("backend", f"unknown quality or backend `{name}` (available: {', '.join(known)})", hint=hint)
    backend = find(quality.backend)
    if not isinstance(backend, PictureBackend) or backend.painter is None:
        raise SceneError(
            "backend", f"the backend `{name}` does not draw pictures", hint="run `scenelang backends` to list them"
        )
    return _with_settings(backend, quality.settings) if quality.settings else backend


def declared_backend(scene: Scene) -> PictureBackend | None:
    """Return the picture backend of the ``:quality`` of ``render-settings``, None without one.

    Raises SceneError("backend") for an unknown one, where the program states it.
    """
    item = next(iter(named(scene.setup, SETTINGS)), None)
    if item is None or "quality" not in item.values:
        return None
    try:
        return picture_backend(item.values["quality"])
    except SceneError as error:
        raise SceneError(error.name, f"`:quality` of `{SETTINGS}`: {error.message}", error.hint, item.span) from None


def _with_settings(backend: PictureBackend, settings: Mapping[str, Any]) -> PictureBackend:
    """Return ``backend`` with ``settings`` as the defaults of its options."""
    paint = backend.painter
    assert paint is not None

    def painter(staging: Staging, options: PictureOptions, shots: int) -> Painter:
        """Create a painter; settings that the options give explicitly come first."""
        given = {name: value for name, value in options.settings.items() if value is not None}
        return paint(staging, replace(options, settings={**settings, **given}), shots)

    return replace(backend, painter=painter)


def render(scene: Scene, options: PictureOptions | None = None, backend: str = "draft") -> Picture:
    """Render one frame of ``scene`` as a picture: (height, width, 3), 8-bit sRGB.

    Parameters
    ----------
    scene : Scene
    options : PictureOptions, optional
    backend : str
        Name of a backend or a quality preset.

    Raises
    ------
    SceneError
        "empty-scene" if nothing would be drawn, "backend" if a package is missing, "value" for an invalid size or
        camera,
        "attribute" for an invalid material attribute.
    """
    return draw(scene, options or PictureOptions(), picture_backend(backend)).picture


def draw(scene: Scene, options: PictureOptions, backend: PictureBackend) -> Image:
    """Draw one frame of ``scene`` with ``backend``; raises SceneError as ``render`` does."""
    options = settled(scene, options)
    check(options, [backend])
    scene, shot = figure_shot(scene, options)
    return paint_shot(painters(scene, options, [backend], [shot]), shot, options.progress)


def figure_shot(scene: Scene, options: PictureOptions, seen: Sequence[int] | None = None) -> tuple[Scene, Shot]:
    """Return the scene of the figure that the options ask for, and the shot of its image.

    ``seen`` are the frames that the camera frames, by default the drawn one. Raises SceneError and LimitError.
    """
    scene = figured(scene, options.figure, options.limit, options.warn)
    frame = frame_of(scene, options.frame)
    (shot,) = stills(scene, options.camera, [frame], options.width, options.height, seen)
    if not options.figure.has_notes:
        return scene, shot
    from scenelang.backends.pictures.drawn_over import with_room

    return scene, with_room(_staging(scene, [shot], options), shot, options.figure, options.camera)


def _staging(scene: Scene, shots: Sequence[Shot], options: PictureOptions) -> Staging:
    """Return the staging of shots; raises SceneError."""
    frames = [shot.frame for shot in shots]
    return staging_of(
        scene, frames, options.limit, options.environment, ground_of(options), options.warn, lighting_of(options)
    )


def painters(
    scene: Scene, options: PictureOptions, backends: Sequence[PictureBackend], shots: Sequence[Shot]
) -> list[Painter]:
    """Return the painters of several backends for the same ``shots`` of a ``figured`` scene; raises SceneError."""
    if not options.shutter:
        return staged_painters(_staging(scene, shots, options), options, backends, len(shots))
    from scenelang.backends.pictures.draft import adjusted
    from scenelang.backends.pictures.motion_blur import BlurPainter, instants_of

    scene, instants = instants_of(scene, shots, options.shutter)
    every = [instant for each in instants for instant in each]
    staging = adjusted(_staging(scene, [*shots, *every], options), every[0])
    backends = [_shared_out(backend, len(instants[0])) for backend in backends]
    sharp = staged_painters(staging, replace(options, figure=PLAIN), backends, len(every))
    blurred: list[Painter] = [BlurPainter(painter, staging, shots, instants) for painter in sharp]
    return _drawn_over(blurred, staging, options) if options.figure.is_drawn_over else blurred


def _shared_out(backend: PictureBackend, instants: int) -> PictureBackend:
    """Return a backend whose samples of a pixel are shared by the instants of an image."""
    if all(option.name != "samples" for option in backend.options):
        return backend
    paint = backend.painter
    assert paint is not None

    def painter(staging: Staging, options: PictureOptions, shots: int) -> Painter:
        """Create a painter of instants."""
        samples = -(-int(backend.setting(options, "samples")) // instants)
        return paint(staging, replace(options, settings={**options.settings, "samples": samples}), shots)

    return replace(backend, painter=painter)


def staged_painters(
    staging: Staging, options: PictureOptions, backends: Sequence[PictureBackend], shots: int
) -> list[Painter]:
    """Return the painters of several backends for a number of shots of a staging; raises SceneError."""
    if not options.figure.is_drawn_over:
        return [backend.painter(staging, options, shots) for backend in backends if backend.painter is not None]
    below = staged_painters(staging, replace(options, figure=PLAIN), backends, shots)
    return _drawn_over(below, staging, options)


def _drawn_over(below: Sequence[Painter], staging: Staging, options: PictureOptions) -> list[Painter]:
    """Return painters that draw what a figure shows over the images of others, or in their place."""
    from scenelang.backends.pictures.drawn_over import FigurePainter

    is_drawn = options.figure.style not in ("line", "wire")
    return [
        FigurePainter(painter if is_drawn else None, staging, options.figure, options.background) for painter in below
    ]


def paint_shot(painters: Sequence[Painter], shot: Shot, progress: Progress | None = None) -> Image:
    """Draw one shot with each painter and join the pictures side by side; raises SceneError."""
    count = len(painters)
    images = [
        painter.paint(shot, sub_progress(progress, i / count, (i + 1) / count)) for i, painter in enumerate(painters)
    ]
    if count == 1:
        return images[0]
    rgba = np.concatenate([image.rgba for image in images], axis=1)
    is_opaque = all(image.alpha is None for image in images)
    radiance = np.concatenate([image.radiance for image in images], axis=1)
    return Image(np.ascontiguousarray(rgba[:, :, :3]), radiance, None if is_opaque else rgba[:, :, 3])


def lighting_of(options: PictureOptions) -> Lighting | None:
    """Return what the program declares of its light, with the exposure and the tone curve that the user states."""
    if options.exposure is None and options.tone is None:
        return options.lighting
    lighting = replace(options.lighting or Lighting(), tone=options.tone)
    if options.exposure == METERED:
        return replace(lighting, exposure=0.0, is_metered=True)
    if options.exposure is None:
        return lighting
    if isinstance(options.exposure, str):
        raise SceneError("value", f"unknown exposure `{options.exposure[:40]}`", hint=f"stops, or `{METERED}`")
    return replace(lighting, exposure=options.exposure)


def ground_of(options: PictureOptions) -> str | None:
    """Return the ground of images: a clear one before a flat background. Raises SceneError if both are given."""
    if options.background is None:
        return options.ground
    if options.ground in (None, "none", *CLEAR_GROUNDS):
        return "shadow" if options.ground == "shadow" else "transparent"
    message = f"a flat background has no ground, but `{options.ground}` is asked for"
    raise SceneError("value", message, hint="leave out the ground, or use `--ground shadow` for the scene's shadow")


def clear_image(
    linear: npt.NDArray[np.float32],
    radiance: npt.NDArray[np.float32],
    alpha: npt.NDArray[np.float32],
    labels: list[Label],
    background: str | None,
) -> Image:
    """Return an image of a stage without backdrop, with alpha or over a flat background.

    Colors are encoded before they are put over the background, since all viewers blend 8-bit sRGB: so an image with
    alpha looks over a background as the one that is drawn with it.

    Parameters
    ----------
    linear : (H, W, 3)
        Tone-mapped linear sRGB, multiplied by ``alpha`` (H, W).
    radiance : (H, W, 3)
        Linear sRGB, multiplied by ``alpha``.
    background
        A CSS name or ``#rrggbb``.
    """
    own = encode(linear / np.maximum(alpha, 1e-6)[:, :, None])
    share = np.asarray(np.rint(np.clip(alpha, 0.0, 1.0) * 255.0), np.uint8)
    own[share == 0] = 0
    rgba = np.dstack([own, share])
    if labels:
        rgba[share == 0, :3] = _PAPER  # what the edges of letters blend with
        rgba = write_labels(rgba, labels)
        rgba[rgba[:, :, 3] == 0] = 0
    if background is None:
        return Image(np.ascontiguousarray(rgba[:, :, :3]), radiance, np.ascontiguousarray(rgba[:, :, 3]))
    color = np.array(color_of(background), np.float32)
    behind = color * (1.0 - np.clip(alpha, 0.0, 1.0))[:, :, None]
    return Image(flattened(rgba, encode(color)), (radiance + behind).astype(np.float32))


def check(options: PictureOptions, backends: Sequence[Backend]) -> None:
    """Validate ``options`` independently of a scene; raises SceneError("value")."""
    if not (1 <= options.width <= LARGEST and 1 <= options.height <= LARGEST):
        raise SceneError(
            "value", f"width and height must be 1 to {LARGEST} pixels, not {options.width} x {options.height}"
        )
    if options.width * options.height > _MAX_PIXELS:
        raise SceneError(
            "value", f"a picture may have at most {_MAX_PIXELS:,} pixels, not {options.width} x {options.height}"
        )
    environment_of(options.environment)
    if options.tone is not None:
        _check_name("tone", options.tone, TONES)
    if options.ground is not None:
        _check_name("ground", options.ground, (*GROUNDS, *CLEAR_GROUNDS))
    if options.background is not None:
        color_of(options.background)
    if ground_of(options) in CLEAR_GROUNDS:
        for backend in backends:
            if isinstance(backend, PictureBackend) and not backend.has_alpha:
                message = f"the backend `{backend.name}` draws no image without a ground"
                raise SceneError("value", message, hint="use `--quality draft` or `--quality final`")
    check_figure(options.figure)
    check_settings(options, backends, _as_quality)


def _as_quality(backend: str) -> str:
    """Return how the command line chooses a backend: by a quality that it draws, else by its name."""
    qualities = (QUALITIES.find(name) for name in QUALITIES.names())
    return next((f"`--quality {each.name}`" for each in qualities if each.backend == backend), backend)


def check_alpha(options: PictureOptions, path: Path, is_video: bool) -> None:
    """Raise SceneError if images have alpha but the file would not, or a figure is more than the file can show."""
    check_drawable(options.figure, path, is_video)
    if options.background is not None or ground_of(options) not in CLEAR_GROUNDS:
        return
    if is_video or path.suffix.lower() in _OPAQUE:
        what = "a video" if is_video else f"a {path.suffix.lower()} file"
        hint = f"write `-o {path.stem}.png`, or put the scene before a color: `--background white`"
        raise SceneError("value", f"{what} has no transparency, but `--ground {options.ground}` needs it", hint=hint)


def check_opaque(options: PictureOptions) -> None:
    """Raise SceneError if images would have alpha, which those of labels and datasets have not."""
    if options.ground in CLEAR_GROUNDS:
        message = f"labeled images have no transparency, but `{options.ground}` is the ground"
        raise SceneError("value", message, hint="use `--ground none`; the instance map tells objects from background")


def _check_name(what: str, name: str, known: Sequence[str]) -> None:
    """Raise SceneError if a name is not one of ``known``."""
    if name not in known:
        hint = suggest(name, known) or f"expected one of {', '.join(known)}"
        raise SceneError("value", f"unknown {what} `{name}`", hint=hint)


def write_still(backend_name: str) -> Callable[[Scene, Path, BackendOptions], None]:
    """Return the ``Backend.run`` of a picture backend, which draws one picture and writes it."""

    def run(scene: Scene, path: Path, options: BackendOptions) -> None:
        """Draw one image and write it."""
        if not isinstance(options, PictureOptions):
            options = PictureOptions(options.frame, options.limit, options.progress, options.settings, options.warn)
        save_image(draw(scene, options, picture_backend(backend_name)), path)

    return run


def open_image(path: Path | str | BytesIO) -> Any:
    """Open an image file as an RGB PIL image; raises SceneError("file") if it is unreadable or too large."""
    image = require("PIL.Image", "pillow")
    try:
        with image.open(path) as picture:
            if picture.width * picture.height > _MAX_INPUT_PIXELS:
                raise SceneError("file", f"{path} has more than {_MAX_INPUT_PIXELS:,} pixels")
            return require("PIL.ImageOps", "pillow").exif_transpose(picture).convert("RGB")
    except (OSError, ValueError, SyntaxError, image.DecompressionBombError) as error:
        raise SceneError("file", f"cannot read {path} as an image: {reason_of(error)}") from None


def save_image(image: Image, path: Path | str) -> None:
    """Write ``image`` atomically in the format of ``path``'s extension: PNG, JPEG, WebP, or its radiance as EXR.

    Raises SceneError: "backend" for another extension, "value" for a JPEG of an image with alpha, "file" if the file
    cannot be written.
    """
    target = Path(path)
    if target.suffix.lower() != ".exr":
        save_picture(image.picture if image.alpha is None else image.rgba, target)
    elif image.alpha is None:
        save_radiance(image.radiance, target)
    else:
        share = np.asarray(image.alpha, np.float32)[:, :, None] / np.float32(255.0)
        save_radiance(np.concatenate([image.radiance, share], axis=2), target)


def save_picture(picture: Picture, path: Path | str) -> None:
    """Write ``picture`` (H, W, 3), or (H, W, 4) with alpha, atomically as PNG, JPEG or WebP, by the path's extension.

    Raises SceneError: "backend" for another extension, "value" for a JPEG with alpha, "file" if the file cannot be
    written.
    """
    target = Path(path)
    check_still(target)
    if picture.shape[2] == 4 and target.suffix.lower() in _OPAQUE:
        raise SceneError("value", f"{target.name}: JPEG has no transparency", hint="write a .png or a .webp")
    image = require("PIL.Image", "pillow").fromarray(picture)
    named = {"pnginfo": png_text({"Software": SOFTWARE})} if target.suffix.lower() == ".png" else {}
    with atomic_write(target) as temporary:
        image.save(temporary, quality=_STILL_QUALITY, **named)


def check_still(path: Path) -> None:
    """Raise SceneError("backend") for a file that ``save_picture`` does not write."""
    endings = tuple(ending for ending in STILL_ENDINGS if ending != ".exr")
    if path.suffix.lower() not in endings:
        raise SceneError("backend", f"cannot write a picture as `{path.name}`", hint=f"use {' '.join(endings)}")


def png_text(chunks: Mapping[str, str]) -> Any:
    """Return text chunks of a PNG for Pillow's ``pnginfo``."""
    info = require("PIL.PngImagePlugin", "pillow").PngInfo()
    for name, text in chunks.items():
        info.add_text(name, text)
    return info


def wrote_picture(path: Path) -> bool:
    """Return whether ``path`` is a PNG or a GIF that scenelang wrote, so that it may be replaced without asking."""
    module = require("PIL.Image", "pillow")
    try:
        with module.open(path) as image:
            software = image.info.get("Software") or image.info.get("comment", b"").decode("latin-1")
    except (OSError, ValueError, SyntaxError):  # not an image, or a broken one
        return False
    return str(software).startswith(SOFTWARE)


def png_of(picture: Picture) -> bytes:
    """Encode ``picture`` (H, W, 3) as PNG; raises SceneError("backend") without pillow."""
    data = io.BytesIO()
    require("PIL.Image", "pillow").fromarray(picture).save(data, "PNG")
    return data.getvalue()


def save_radiance(radiance: npt.NDArray[np.float32], path: Path | str) -> None:
    """Write linear sRGB ``radiance`` (H, W, 3), or (H, W, 4) multiplied by alpha, as OpenEXR; raises SceneError."""

    write_exr({"": radiance}, Path(path))


# Videos: turntables of static scenes and the frames of 4D scenes; GIF, animated PNG and WebP by Pillow, MP4 by PyAV.


ENDINGS = (".gif", ".mp4", ".apng", ".webp")
FPS = 24
_MAX_BYTES = 4_000_000_000  # of all images of a video: Pillow writes files from all images at once
_GIF_COLORS = 255  # of each image; one of the 256 is left for transparency


def is_film(path: Path | str, film_requested: bool) -> bool:
    """Return whether a path is a video, by its extension; WebP and PNG may be either: ``film_requested`` decides."""
    ending = Path(path).suffix.lower()
    return ending in (".gif", ".mp4", ".apng") or (film_requested and ending in (".webp", ".png"))


def save_film(
    painters: Sequence[Painter],
    shots: Sequence[Shot],
    path: Path | str,
    fps: float = FPS,
    progress: Progress | None = None,
) -> None:
    """Draw shots and write them atomically as one video in the format of the path's extension.

    Parameters
    ----------
    painters
        Several draw side by side.
    fps
        Frames per second.
    progress
        Called with a fraction from 0 to 1.

    Raises
    ------
    SceneError
        "value" for an invalid frame rate, "backend" for another extension or a missing package, "unsupported" if the
        video would exceed the memory limit, "file" if the file cannot be written.
    """
    target = Path(path)
    check_film(target, fps)
    size = sum(shot.camera.width * shot.camera.height * 3 for shot in shots) * len(painters)
    if target.suffix.lower() != ".mp4" and size > _MAX_BYTES:
        raise SceneError(
            "unsupported", f"{len(shots)} pictures of this size are too many for one {target.suffix} file",
            hint="write an .mp4, or reduce --frames or --size",
        )  # fmt: skip
    pictures = _draw_all(painters, shots, progress)
    with atomic_write(target) as temporary:
        if target.suffix.lower() == ".mp4":
            _write_mp4(pictures, temporary, fps)
        else:
            _write_pillow(pictures, temporary, fps)
    if progress is not None:
        progress(1.0)


def check_film(path: Path, fps: float) -> None:
    """Raise SceneError for an invalid frame rate, an unsupported extension, or a missing package."""
    low, high = FRAME_RATES
    if not low <= fps <= high:
        raise SceneError("value", f"the frame rate must be from {low:g} to {high:g} per second, not {fps:g}")
    ending = path.suffix.lower()
    if ending not in (*ENDINGS, ".png"):
        raise SceneError("backend", f"cannot write a film as `{path.name}`", hint=f"use {' '.join(ENDINGS)}")
    if ending == ".mp4":
        require("av", "'scenelang[video]'")


@dataclass(frozen=True, slots=True)
class FilmOptions:
    """Options of a video.

    Attributes
    ----------
    frames
        Number of images; None for those of the scene, or 48.
    fps
        Frames per second; None for 24.
    orbit
        Angle in degrees that the camera travels around the scene; None for one full turn around a static scene.
    """

    frames: int | None = setting(
        None, "number of frames of a film (default: the scene's, or 48)", metavar="N", read=whole
    )
    fps: float | None = setting(None, "frames per second (default 24)", metavar="X", read=frame_rate)
    orbit: float | None = setting(
        None, "angle of the camera's orbit around the scene", metavar="DEGREES", read=within(-MOST_ORBIT, MOST_ORBIT)
    )

    @property
    def is_wanted(self) -> bool:
        """Whether any of these options is set."""
        return any(value is not None for value in (self.frames, self.fps, self.orbit))


def check_output(path: Path, frame: int | None, film: FilmOptions, backends: int) -> None:
    """Raise SceneError if ``path`` cannot be an image or video with these options."""
    ending = path.suffix.lower()
    known = sorted({*STILL_ENDINGS, *ENDINGS})
    if ending not in known:
        shown = f"`{ending}` files" if ending else "files without an extension"
        films = " ".join(sorted(ENDINGS))
        hint = f"write `-o {path.stem}.png`; pictures are {' '.join(sorted(STILL_ENDINGS))}, films are {films}"
        raise SceneError("backend", f"`render` does not write {shown}", hint=hint)
    if is_film(path, film.is_wanted):
        if frame is not None:
            given = [name for name in ("frames", "fps", "orbit") if getattr(film, name) is not None]
            if given:
                message = f"`--frame` and `--{given[0]}` exclude each other: one picture, or a film"
                raise SceneError("value", message, f"leave out `--frame {frame}` or `--{given[0]}`")
            message = f"`--frame {frame}` selects one picture, but {path.name} is a film"
            raise SceneError("value", message, f"write a picture, such as {path.with_suffix('.png').name}")
        check_film(path, FPS if film.fps is None else film.fps)
    elif film.is_wanted:
        hint = f"write {' '.join(ENDINGS)}, or leave out --frames, --fps and --orbit"
        raise SceneError("value", f"`{path.name}` is a single picture, but film options are given", hint=hint)
    elif ending == ".exr" and backends > 1:
        raise SceneError("value", "an .exr file can contain the picture of only one backend")


def write_drawing(
    scene: Scene, path: Path, options: PictureOptions, film: FilmOptions, backends: Sequence[PictureBackend]
) -> None:
    """Draw a scene with one backend, or with several side by side, and write an image or a video.

    The extension of ``path`` decides which; a WebP file of a 4D scene is a video. Raises SceneError.
    """
    options = settled(scene, options)
    film_requested = film.is_wanted or (scene.animated and options.frame is None and path.suffix.lower() == ".webp")
    is_video = is_film(path, film_requested)
    check_alpha(options, path, is_video)
    if is_video:
        scene = figured(scene, options.figure, options.limit, options.warn)
        shots = shots_of(scene, options.camera, options.width, options.height, film.frames, film.orbit)
        fps = FPS if film.fps is None else film.fps
        save_film(painters(scene, options, backends, shots), shots, path, fps, options.progress)
        return
    scene, shot = figure_shot(scene, options)
    save_image(paint_shot(painters(scene, options, backends, [shot]), shot, options.progress), path)


def _draw_all(painters: Sequence[Painter], shots: Sequence[Shot], progress: Progress | None) -> Iterator[Picture]:
    """Yield the images of shots; the last 2 % of the progress are for writing the file."""
    step = 0.98 / len(shots)
    for i, shot in enumerate(shots):
        image = paint_shot(painters, shot, sub_progress(progress, step * i, step * (i + 1)))
        if image.alpha is not None:
            raise SceneError("value", "a video has no transparency", hint="choose a `background`, or another `ground`")
        yield image.picture


def _write_pillow(pictures: Iterator[Picture], path: Path, fps: float) -> None:
    """Write a GIF, animated PNG or animated WebP."""
    module = require("PIL.Image", "pillow")
    images = [module.fromarray(picture) for picture in pictures]
    ending = path.suffix.lower()
    if ending == ".gif":
        images = [image.quantize(_GIF_COLORS, module.Quantize.FASTOCTREE) for image in images]
    first, rest = images[0], images[1:]
    kind = {".gif": "GIF", ".webp": "WEBP"}.get(ending, "PNG")
    more: dict[str, Any] = {"quality": _WEBP_VIDEO_QUALITY, "method": 4} if kind == "WEBP" else {}
    if kind == "GIF":
        more = {"optimize": False, "comment": SOFTWARE.encode()}
    if kind == "PNG":
        more = {"pnginfo": png_text({"Software": SOFTWARE})}
    first.save(
        path, kind, save_all=True, append_images=rest, duration=_durations(len(images), fps, kind), loop=0, **more
    )


def _durations(count: int, fps: float, kind: str) -> list[int]:
    """Return the duration of each picture in milliseconds, rounded without drift; GIF uses hundredths of a second."""
    unit = 10 if kind == "GIF" else 1
    ends = [round(1000.0 * (i + 1) / fps / unit) * unit for i in range(count)]
    return [max(unit, end - start) for start, end in zip([0, *ends[:-1]], ends, strict=True)]


def _write_mp4(pictures: Iterator[Picture], path: Path, fps: float) -> None:
    """Write H.264 video in the most widely supported form: even sizes, 4:2:0 chroma subsampling, index first."""
    av = require("av", "'scenelang[video]'")
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


# Labels: the words of semantic primitives, written on an image where their boxes are visible (Pillow).


Rectangle = tuple[float, float, float, float]

_MAX_LABELS = 40  # of an image: 40 of eight letters cover a fifth of 512 x 512 pixels; more would hide what they name
_MAX_LABELS_PER_WORD = 6  # so that a crowd of one word leaves room for the labels of others
_MAX_LENGTH = 32  # characters
_MIN_SHARE = 1.5e-4  # of the image that a box must cover to be labeled: 39 pixels of 512 x 512
_MIN_VISIBLE_PIXELS = 4.0  # of a box that is labeled; more than _MIN_SHARE in images of less than 163 x 163 pixels
_FONT_PIXELS = (10, 32)  # smallest and largest font size; a thirtieth of the shorter side between them
_INK = (28, 30, 36)
_PAPER = (255, 255, 255)
_SHIFTS = (0.0, -1.0, 1.0, -2.0, 2.0)  # vertical shifts, in lines, to try for a word's first label


@dataclass(frozen=True, slots=True)
class Label:
    """``text`` centered at pixel (``x``, ``y``); ``first`` marks the largest box of the word."""

    text: str
    x: float
    y: float
    first: bool


def labeled(picture: Picture, solids: Solids, ids: npt.NDArray[np.int64]) -> Picture:
    """Return ``picture`` (H, W, 3) with the words of semantic primitives; its pixels see the solids ``ids`` (H, W)."""
    return write_labels(picture, labels_of(solids, ids))


def labels_of(solids: Solids, ids: npt.NDArray[np.int64]) -> list[Label]:
    """Return the labels for a picture whose pixels (H, W) see the solids ``ids``, largest visible boxes first.

    A label is at the centroid of the visible part of its box.
    """
    rows, columns = np.nonzero(ids >= 0)
    visible = ids[rows, columns]
    semantic = solids.semantic[visible]
    rows, columns, visible = rows[semantic], columns[semantic], visible[semantic]
    if not len(visible):
        return []
    numbers, inverse = np.unique(visible, return_inverse=True)
    area = np.bincount(inverse)
    x, y = np.bincount(inverse, columns + 0.5) / area, np.bincount(inverse, rows + 0.5) / area
    labels: list[Label] = []
    used: Counter[str] = Counter()
    for k in np.argsort(-area, kind="stable"):
        word = solids.words[int(solids.word[numbers[k]])]
        if area[k] < max(_MIN_VISIBLE_PIXELS, _MIN_SHARE * ids.size) or used[word] >= _MAX_LABELS_PER_WORD:
            continue
        labels.append(Label(_shorten(word), float(x[k]), float(y[k]), used[word] == 0))
        used[word] += 1
    labels.sort(key=lambda label: not label.first)
    return labels


def write_labels(picture: Picture, labels: list[Label]) -> Picture:
    """Return a copy of ``picture`` (H, W, 3 or 4) with ``labels``, without those that would overlap others."""
    if not labels:
        return picture
    image_module, draw_module = require("PIL.Image", "pillow"), require("PIL.ImageDraw", "pillow")
    image = image_module.fromarray(picture)
    pen = draw_module.Draw(image)
    height, width = picture.shape[:2]
    size = int(min(_FONT_PIXELS[1], max(_FONT_PIXELS[0], round(min(height, width) / 30))))
    stroke = max(1, round(size / 9))
    taken: list[Rectangle] = []
    for label in labels:
        font = font_for(label.text, size)
        for x, y in _places(label, size * 1.25):
            box: Rectangle = pen.textbbox((x, y), label.text, font=font, anchor="mm", stroke_width=stroke)
            x, y = x + _inward(box[0], box[2], width), y + _inward(box[1], box[3], height)
            box = pen.textbbox((x, y), label.text, font=font, anchor="mm", stroke_width=stroke)
            if not any(_overlap(box, other) for other in taken):
                pen.text((x, y), label.text, font=font, anchor="mm", fill=_INK, stroke_width=stroke, stroke_fill=_PAPER)
                taken.append(box)
                break
        if len(taken) >= _MAX_LABELS:
            break
    return np.asarray(image, np.uint8).copy()


def _places(label: Label, line: float) -> Iterator[tuple[float, float]]:
    """Yield positions to try for a label; only the first of a word is worth moving."""
    for shift in _SHIFTS if label.first else (0.0,):
        yield label.x, label.y + shift * line


def _inward(low: float, high: float, size: int) -> float:
    """Return the shift that moves the span from ``low`` to ``high`` inside a picture of ``size``, if it fits."""
    return max(0.0, 2.0 - low) if low < 2.0 else min(0.0, size - 2.0 - high)


def _overlap(a: Rectangle, b: Rectangle) -> bool:
    """Return whether two rectangles share an area."""
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def _shorten(word: str) -> str:
    """Return the word on one line, without unprintable characters, truncated if necessary."""
    text = "".join(c if c.isprintable() else " " for c in word).strip()
    return text if len(text) <= _MAX_LENGTH else text[: _MAX_LENGTH - 1] + "…"


# OpenEXR files with several named layers, written by Mitsuba's ``Bitmap`` (which needs no variant).


_CHANNELS = {1: ("Y",), 2: ("X", "Y"), 3: ("R", "G", "B"), 4: ("R", "G", "B", "A")}


def write_exr(layers: Mapping[str, npt.NDArray[np.float32]], path: Path, xyz: frozenset[str] = frozenset()) -> None:
    """Write ``layers``, each (H, W) or (H, W, C) with C <= 4, atomically as one OpenEXR file of 32-bit floats.

    The layer "" has the channels R G B; others have ``name.R`` and so on, or ``name.X`` ... if named in ``xyz``. Raises
    SceneError: "backend" without Mitsuba, "file" if the file cannot be written.
    """
    mi = require("mitsuba", FINAL_EXTRA)
    names: list[str] = []
    columns: list[npt.NDArray[np.float32]] = []
    for name, values in layers.items():
        grid = np.asarray(values, np.float32).reshape(*values.shape[:2], -1)
        channels = ("X", "Y", "Z", "W") if name in xyz else _CHANNELS[grid.shape[2]]
        names += [f"{name}.{channel}" if name else channel for channel in channels[: grid.shape[2]]]
        columns.append(grid)
    joined = np.ascontiguousarray(np.concatenate(columns, axis=2))
    bitmap = mi.Bitmap(joined, pixel_format=mi.Bitmap.PixelFormat.MultiChannel, channel_names=names)
    stream = mi.MemoryStream()  # because Mitsuba accepts only file names in UTF-8
    bitmap.write(stream, mi.Bitmap.FileFormat.OpenEXR)
    with atomic_write(path) as temporary:
        temporary.write_bytes(stream.raw_buffer())

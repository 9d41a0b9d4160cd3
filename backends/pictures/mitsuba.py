"""Final images: path tracing with Mitsuba 3, denoised with Open Image Denoise if it is installed.

Camera, lighting, ground and tone curve are those of draft images (``appearance``), so that both agree. Repeated parts
are drawn as instances; shapes that the frames of a video share are built once.

Up to 20,000 solids are instances of exact unit shapes. Larger scenes are cut once on every path from the root into
shared prototypes and instances, because Mitsuba has one level of instancing (``mitsuba_scene``). Emissive solids, and
kinds beyond the 512 most frequent, become merged meshes with per-face materials. The ``llvm`` and ``cuda`` variants
always use merged meshes, because their compile time grows too fast with the number of instances.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from importlib import import_module
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import Option, Progress, Work, require, sub_progress
from scenelang.backends.pictures.draft import Draft, DraftCache, adjusted, draw_lens
from scenelang.backends.pictures.draft_lamps import show_lamps
from scenelang.backends.pictures.draft_light import backdrop, ground_light, ground_radiance
from scenelang.backends.pictures.film import (
    FINAL_EXTRA,
    STILL_ENDINGS,
    Image,
    Painter,
    PictureBackend,
    PictureOptions,
    clear_image,
    labeled,
    labels_of,
    write_still,
)
from scenelang.backends.pictures.mitsuba_scene import (
    FEW,
    Prototype,
    is_too_flat,
    merged_meshes,
    parts_of,
    segments_for,
    sizes_of,
    surroundings,
    unit_group,
)
from scenelang.backends.pictures.rays import pixel_directions
from scenelang.backends.pictures.stage import Shot, Stage, Staging
from scenelang.backends.surfaces.appearance import Look
from scenelang.backends.surfaces.environments import tone_map
from scenelang.backends.surfaces.image_files import encode
from scenelang.backends.surfaces.solids import Solids
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.primitives.forms import CanonicalForm

# Mitsuba variants are compute backends: ``scalar`` always works, ``llvm`` compiles for the CPU, ``cuda`` for a GPU. An
# incompatible compiler terminates the whole process, so a variant is tried in a subprocess before it is used.


NAMES = {"scalar": "scalar_rgb", "llvm": "llvm_ad_rgb", "cuda": "cuda_ad_rgb"}
CHOICES = ("auto", *NAMES)
MANY_SAMPLES = 64 * 1024 * 1024  # samples per image above which compilation pays off
_TRIAL_SECONDS = 120.0  # timeout; a trial takes 0.5 s, and the first import from a slow disk far longer

_TEST_PROGRAM = """
import sys, mitsuba as mi
mi.set_variant(sys.argv[1])
mi.set_log_level(mi.LogLevel.Error)
film = {"type": "hdrfilm", "width": 4, "height": 4}
scene = mi.load_dict({"type": "scene", "integrator": {"type": "path"}, "light": {"type": "constant"},
    "ball": {"type": "sphere", "bsdf": {"type": "principled"}},
    "sensor": {"type": "perspective", "film": film,
               "to_world": mi.ScalarTransform4f().look_at(origin=[0, 0, 4], target=[0, 0, 0], up=[0, 1, 0])}})
print(float(sum(mi.render(scene, spp=2).numpy().ravel())) > 0)
"""


def use(choice: str, samples: int, has_instances: bool) -> Any:
    """Return the mitsuba module with the variant selected by ``choice`` for a picture of ``samples`` samples in total.

    ``auto`` selects llvm, if it works, for many samples of scenes without instances (with instances the compile time
    explodes), else scalar. Raises SceneError("backend") if Mitsuba or the requested variant does not work.
    """
    mi = require("mitsuba", FINAL_EXTRA)
    chosen = choice
    if choice == "auto":
        chosen = "llvm" if samples >= MANY_SAMPLES and not has_instances and works("llvm") else "scalar"
    elif choice != "scalar" and not works(choice):
        what = "no compatible LLVM (Debian: libllvm19)" if choice == "llvm" else "no compatible NVIDIA GPU"
        raise SceneError("backend", f"the Mitsuba variant `{choice}` does not work here: {what} found",
                         hint="use `--variant scalar`, which works everywhere")  # fmt: skip
    if mi.variant() != NAMES[chosen]:
        mi.set_variant(NAMES[chosen])
    mi.set_log_level(mi.LogLevel.Error)
    return mi


@cache
def works(name: str) -> bool:
    """Return whether a variant renders a small image, tried in a subprocess."""
    try:
        # An argument list, no shell: this interpreter with a fixed program.
        done = subprocess.run(trial_command(name), capture_output=True, text=True, timeout=_TRIAL_SECONDS)  # noqa: S603  # nosec B603
    except (OSError, subprocess.TimeoutExpired):
        return False
    return done.returncode == 0 and done.stdout.strip() == "True"


def trial_command(name: str) -> list[str]:
    """Return a command that prints ``True`` if the variant ``name`` renders a small picture."""
    return [sys.executable, "-P", "-c", _TEST_PROGRAM, NAMES[name]]


Float32Array = npt.NDArray[np.float32]
FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

_NOTHING = 1e-3  # share of a pixel that does not count
# An image of no more samples is drawn in one pass, as after each the film starts anew: eight take up to 8 % longer. It
# takes two seconds, after which progress is told and an interruption heeded.
_SAMPLES_OF_PASS = 1 << 21
_MAX_GROUPS = 512  # distinct exact shapes; solids of rarer kinds are merged into meshes


class MitsubaPainter:
    """Path traces the shots of one staging. ``mitsuba`` is the module with the selected variant."""

    def __init__(self, staging: Staging, options: PictureOptions, shots: int) -> None:
        """Select the variant by the number of samples of all ``shots``."""
        self._staging = staging
        self._options = options
        self._samples = int(MITSUBA.setting(options, "samples"))
        self._depth = int(MITSUBA.setting(options, "bounces"))
        self._denoise = MITSUBA.setting(options, "denoise") == "on"
        self._guides = DraftCache()
        total = self._samples * options.width * options.height * shots
        crowded = any(len(solids) + len(staging.fixed or ()) > FEW for solids in staging.moving.values())
        choice = MITSUBA.setting(options, "variant")
        self.mitsuba = use(choice, total, crowded)
        self._shapes = _Shapes(self.mitsuba, staging, instances=str(self.mitsuba.variant()).startswith("scalar"))

    def paint(self, shot: Shot, progress: Progress | None = None) -> Image:
        """Draw one shot; a draft of its geometry guides the denoiser and gives the ids of labels."""
        self._staging = adjusted(self._staging, shot)
        stage = self._staging.stage(shot)
        shown = shot.frame, shot.camera.identity, stage.lights, stage.instant
        return self._guides.get("image", shown, lambda: self._draw(stage, shot, progress))

    def _draw(self, stage: Stage, shot: Shot, progress: Progress | None) -> Image:
        """Draw the stage of a shot."""
        if stage.is_clear:
            return self._clear(stage, shot, progress)
        unlit = stage.studio.environment.unlit  # without lighting there is nothing to trace
        guide = draw_lens(stage, sub_progress(progress, 0.0, 0.1), shaded=unlit, cache=self._guides)
        radiance = (
            guide.radiance if unlit else self._path_trace(stage, shot.frame, guide, sub_progress(progress, 0.1, 1.0))
        )
        picture = encode(tone_map(radiance, stage.studio.environment) if not unlit else guide.linear)
        return Image(labeled(picture, stage.solids, guide.ids) if self._options.labels else picture, radiance)

    def shapes_of(self, frame: int, stage: Stage) -> dict[str, Any]:
        """Return Mitsuba's shapes of one frame by name, tessellated finely enough for the camera of ``stage``."""
        return self._shapes.of(frame, stage)

    def _path_trace(self, stage: Stage, frame: int, guide: Draft, progress: Progress | None) -> Float32Array:
        """Return the path-traced radiance (H, W, 3) of ``stage``."""
        mi, report = self.mitsuba, progress or (lambda _: None)
        scene = mi.load_dict(surroundings(mi, stage, self._depth) | self.shapes_of(frame, stage))
        report(0.1)
        radiance = self._sampled(scene, stage, report)[:, :, :3]
        radiance = _before_backdrop(radiance, stage, guide)
        noisy = np.maximum(radiance, 0.0).astype(np.float32)
        clean = np.where(guide.sky[:, :, None] < 1.0, _denoised(noisy, guide), noisy) if self._denoise else noisy
        report(1.0)
        return np.asarray(clean, np.float32)

    def _sampled(self, scene: Any, stage: Stage, report: Progress | None) -> FloatArray:
        """Return the mean (H, W, C) of the samples of a loaded scene, without the values that are not finite."""
        total = np.zeros(())
        most = max(1, self._samples // (8 if self._samples <= 64 else 16))
        passes = min(most, -(-self._samples * stage.width * stage.height // _SAMPLES_OF_PASS))
        for k in range(passes):
            share = self._samples // passes + (k < self._samples % passes)
            image = self.mitsuba.render(scene, seed=(self._options.seed * 4096 + k) % 2**32, spp=share)
            total = total + share * np.array(image, np.float64).reshape(stage.height, stage.width, -1)
            if report is not None:
                report(0.1 + 0.85 * (k + 1) / passes)
        return np.nan_to_num(total / self._samples, nan=0.0, posinf=1e4, neginf=0.0)

    def _clear(self, stage: Stage, shot: Shot, progress: Progress | None) -> Image:
        """Draw a shot without backdrop; the shadow on the ground is the draft's."""
        environment = stage.studio.environment
        guide = draw_lens(stage, sub_progress(progress, 0.0, 0.1), cache=self._guides)
        if environment.unlit:
            linear, radiance, alpha = guide.linear, guide.radiance, guide.alpha
        else:
            bare = replace(stage, ground=None)  # which would hide the background
            radiance, alpha = self._trace_clear(bare, shot.frame, guide, sub_progress(progress, 0.1, 1.0))
            share = np.maximum(alpha, 1e-6)[:, :, None]
            linear = tone_map(radiance / share, environment) * share
        alpha = alpha + (1.0 - alpha) * guide.shadow / np.maximum(1.0 - guide.alpha, 1e-6)
        labels = labels_of(stage.solids, guide.ids) if self._options.labels else []
        return clear_image(linear, radiance, alpha, labels, self._options.background)

    def _trace_clear(
        self, stage: Stage, frame: int, guide: Draft, progress: Progress | None
    ) -> tuple[Float32Array, Float32Array]:
        """Return the radiance (H, W, 3) of the objects alone, multiplied by alpha, and alpha (H, W).

        Alpha is that of the same rays in a scene without lights, since Mitsuba's is 1 before lights all around; its
        `hide_emitters` would hide emissive objects too, and ends the process where there are instances (3.9.1).
        """
        report = progress or (lambda _: None)
        around, shapes = surroundings(self.mitsuba, stage, self._depth), self.shapes_of(frame, stage)
        lit = self._sampled(self.mitsuba.load_dict(around | shapes), stage, sub_progress(report, 0.0, 0.7))
        around["sensor"]["film"]["pixel_format"] = "rgba"
        dark = {name: around[name] for name in ("type", "integrator", "sensor")}
        covered = self._sampled(self.mitsuba.load_dict(dark | shapes), stage, sub_progress(report, 0.7, 1.0))
        # Mitsuba's alpha is 1 where light is refracted too; there the draft tells what is seen through.
        is_clear = (guide.ids >= 0) & (stage.solids.opacity[np.maximum(guide.ids, 0)] < 1.0)
        alpha = np.where(is_clear, np.minimum(covered[:, :, 3], guide.alpha), covered[:, :, 3])
        behind = stage.studio.dome.radiance(pixel_directions(stage.camera)).reshape(*alpha.shape, 3)
        radiance = np.where(alpha[:, :, None] > 0.0, lit[:, :, :3] - (1.0 - alpha)[:, :, None] * behind, 0.0)
        noisy = np.maximum(radiance, 0.0).astype(np.float32)
        cover = np.clip(alpha, 0.0, 1.0).astype(np.float32)
        if self._denoise:
            noisy = np.where(cover[:, :, None] > 0.0, _denoised(noisy, guide), noisy)
            if (stage.solids.opacity < 1.0).any():
                smooth = _denoised(np.repeat(cover[:, :, None], 3, axis=2), guide)[:, :, 0]
                cover = np.where((cover > 0.0) & (cover < 1.0), np.clip(smooth, 0.0, 1.0), cover)
        return noisy, cover


def _before_backdrop(radiance: FloatArray, stage: Stage, guide: Draft) -> FloatArray:
    """Return ``radiance`` (H, W, 3) before the backdrop, which the camera sees in place of the lights of the studio.

    The light on the ground falls off as in drafts, for which there is no stock emitter. Where a pixel shows objects or
    lamps too, the lights are subtracted, and the ground's share is taken for one without shadow. Else the lights are
    replaced: a difference leaves the edges of softboxes, which Mitsuba blurs otherwise than the dome does.
    """
    seen, shape = pixel_directions(stage.camera), radiance.shape
    behind = np.broadcast_to(backdrop(stage.studio, seen), seen.shape).reshape(shape)
    sky, cover = guide.sky[:, :, None], guide.alpha[:, :, None]
    ground = np.clip(1.0 - sky - cover, 0.0, 1.0)
    kept = ground_light(stage).reshape(*shape[:2], 1) if stage.fades else np.ones((1, 1, 1))
    lit = kept * ground_radiance(stage)
    over = radiance + sky * (behind - stage.studio.dome.radiance(seen).reshape(shape))
    over = over - ground * (1.0 - kept) * ground_radiance(stage)
    alone = np.where(sky > _NOTHING, sky * behind + ground * lit, radiance * kept)
    return np.where((cover > _NOTHING) | show_lamps(stage)[:, :, None], over, alone)


def _denoised(radiance: Float32Array, guide: Draft) -> Float32Array:
    """Return ``radiance`` without noise, or unchanged if the denoiser is not installed."""
    try:
        oidn = import_module("mitsuba_oidn")
    except ImportError:
        return radiance
    guides = {"albedo": np.ascontiguousarray(guide.albedo), "normal": np.ascontiguousarray(guide.normal)}
    clean = oidn.denoise(np.ascontiguousarray(radiance), hdr=True, clean_aux=True, **guides)
    return np.maximum(np.asarray(clean, np.float32), 0.0)


# --- shapes ----------------------------------------------------------------------------------------------------


class _Shapes:
    """Mitsuba's shapes of the frames of a staging; shapes shared by frames are built once."""

    def __init__(self, mi: Any, staging: Staging, *, instances: bool) -> None:
        self._mi = mi
        self._staging = staging
        self._instances = instances
        self._units: dict[tuple[CanonicalForm, tuple[float, ...], Look], Any] = {}
        self._groups: dict[int, tuple[Prototype, Any]] = {}  # by the prototype's entity
        self._fixed: dict[str, Any] | None = None
        self._frames: dict[int, dict[str, Any]] = {}

    def of(self, frame: int, stage: Stage) -> dict[str, Any]:
        """Return the shapes of one frame by name, tessellated finely enough for the camera of ``stage``."""
        if frame not in self._frames:
            self._frames.clear()  # cache only the last frame: a film may have many
            self._frames[frame] = self._build(frame, stage)
        return self._frames[frame]

    def _build(self, frame: int, stage: Stage) -> dict[str, Any]:
        """Return the shapes of a frame: prototypes with instances, or all solids, of which the static ones are kept."""
        # Small scenes need no prototypes: each solid is an instance of its exact shape.
        parts = parts_of(self._staging, frame) if self._instances and len(stage.solids) > FEW else None
        if parts is not None:
            shapes = dict(self._alone(parts.loose, stage, "loose"))
            for k, prototype in enumerate(parts.prototypes):
                shapes |= self._placed(f"p{k}", self._group(prototype, stage), prototype.matrices)
            return shapes
        if self._staging.fixed is not None:
            if self._fixed is None:
                self._fixed = dict(self._alone(self._staging.fixed, stage, "fixed"))
            return self._fixed | dict(self._alone(self._staging.moving[frame], stage, "moving"))
        return dict(self._alone(self._staging.moving[frame], stage, "loose"))

    def _group(self, prototype: Prototype, stage: Stage) -> Any:
        """Return the shape group of a prototype; frames whose graphs share its entity share the group."""
        entry = self._groups.get(id(prototype.entity))
        if entry is None:
            largest = float((sizes_of(prototype.matrices) * _pixels_per_unit(prototype.matrices, stage)).max())
            segments = segments_for(prototype.solids, sizes_of(prototype.solids.matrices) * largest)
            meshes = {f"m{k}": mesh for k, mesh in enumerate(merged_meshes(self._mi, prototype.solids, segments))}
            entry = self._groups[id(prototype.entity)] = (
                prototype,
                self._mi.load_dict({"type": "shapegroup", **meshes}),
            )
        return entry[1]

    def _alone(self, solids: Solids, stage: Stage, name: str) -> Iterator[tuple[str, Any]]:
        """Yield shapes of solids: instances of the most frequent exact shapes, and merged meshes for the rest."""
        exact = self._exact(solids) if self._instances else np.zeros(len(solids), bool)
        rows = np.flatnonzero(exact)
        used, first, kind = np.unique(_kinds(solids)[rows], axis=0, return_index=True, return_inverse=True)
        for k in range(len(used)):
            form, ratios = solids.form(int(rows[first[k]]))
            unit = self._unit(form, ratios, solids.looks.rows[int(used[k, 1])])
            yield from self._placed(f"{name}{k}", unit, solids.matrices[rows[kind.reshape(-1) == k]]).items()
        rest = solids.take(~exact)
        if len(rest):
            size = sizes_of(rest.matrices)
            segments = segments_for(rest, size * _pixels_per_unit(rest.matrices, stage))
            for k, mesh in enumerate(merged_meshes(self._mi, rest, segments)):
                yield f"{name}-mesh{k}", mesh

    def _exact(self, solids: Solids) -> npt.NDArray[np.bool_]:
        """Return which solids are drawn as exact shapes: plain ones of the most frequent kinds.

        Emitters, triangles and textures need meshes.
        """
        able = ~solids.emission.any(axis=1) & solids.that_are("is_closed") & ~is_too_flat(solids)
        able &= ~solids.looks.textured[solids.look]
        _, kind, count = np.unique(_kinds(solids), axis=0, return_inverse=True, return_counts=True)
        if len(count) > _MAX_GROUPS:
            least = np.sort(count)[-_MAX_GROUPS]
            common = count > least  # strict, so that equally frequent kinds cannot exceed the limit
            able &= common[kind.reshape(-1)]
        return np.asarray(able, bool)

    def _unit(self, form: CanonicalForm, ratios: tuple[float, ...], look: Look) -> Any:
        """Return the shape group of a form with one look, built once."""
        key = (form, ratios, look)
        if key not in self._units:
            self._units[key] = unit_group(self._mi, form, ratios, look)
        return self._units[key]

    def _placed(self, name: str, group: Any, matrices: FloatArray) -> dict[str, Any]:
        """Return a shape group and its instances under ``matrices`` (N, 3, 4), by name."""
        transform = self._mi.ScalarTransform4f
        poses = np.zeros((len(matrices), 4, 4))
        poses[:, :3], poses[:, 3, 3] = matrices, 1.0
        shapes = {f"{name}-group": group}
        for i, pose in enumerate(poses):
            shapes[f"{name}-{i}"] = {"type": "instance", "shapegroup": group, "to_world": transform(pose)}
        return shapes


def _kinds(solids: Solids) -> FloatArray:
    """Return rows (N, K) that are equal for solids with the same form, ratios and look."""
    return np.column_stack([solids.forms, solids.look, solids.ratios])


def _pixels_per_unit(matrices: FloatArray, stage: Stage) -> FloatArray:
    """Return the pixels per unit (N,) at the nearest points of solids under ``matrices`` (N, 3, 4)."""
    focal = stage.camera.focal[1]
    if stage.camera.is_parallel:
        return np.full(len(matrices), focal)
    depth = (matrices[:, :, 3] - stage.camera.eye) @ stage.camera.forward
    return np.asarray(focal / np.maximum(depth - sizes_of(matrices), 0.02), np.float64)


def _painter(staging: Staging, options: PictureOptions, shots: int) -> Painter:
    """Create the painter of a staging; see ``PictureBackend``."""
    return MitsubaPainter(staging, options, shots)


MITSUBA = PictureBackend(
    name="mitsuba",
    doc="path-traced pictures by Mitsuba 3, denoised",
    work=Work.PICTURE,
    endings=STILL_ENDINGS,
    run=write_still("mitsuba"),
    options=(
        Option("samples", "samples per pixel of path-traced pictures", 64, minimum=1, maximum=65536),
        Option("bounces", "maximum path length, in bounces", 8, minimum=1, maximum=64),
        Option("denoise", "remove noise with Open Image Denoise", "on", choices=("on", "off")),
        Option("variant", "Mitsuba variant; `auto` is scalar, or llvm for many samples", "auto",
               choices=CHOICES),
    ),
    packages=("mitsuba", "PIL"),
    install=FINAL_EXTRA,
    painter=_painter,
    has_alpha=True,
)  # fmt: skip

"""Distillation runs: training loop, checkpoints, outputs, and rendering of the result."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import Progress, require
from scenelang.backends.files import atomic_write, write_json
from scenelang.backends.neural.distillation.terms import PoseOffsets, Theta, compose
from scenelang.backends.neural.distillation.training import (
    DistillationSettings,
    DistillationTrainer,
    Losses,
    SceneGroups,
    group_key,
    group_state,
    local_splats,
    orbit_cameras,
    render,
)
from scenelang.backends.neural.splats.files import write_gaussians
from scenelang.backends.neural.splats.gaussians import Splats, gaussians_from, view_of
from scenelang.backends.neural.splats.initial import backdrop, shadow_of
from scenelang.backends.neural.splats.rasterise import rasterise
from scenelang.backends.neural.weights import INSTALL
from scenelang.backends.pictures.draft import adjusted
from scenelang.backends.pictures.film import Image, save_picture
from scenelang.backends.pictures.stage import Shot, Staging
from scenelang.backends.surfaces.environments import tone_map
from scenelang.backends.surfaces.image_files import encode, from_srgb
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.entity import descendants

if TYPE_CHECKING:
    from torch import Tensor

    from scenelang.backends.neural.splats.gaussians import Gaussians, Splats


# Checkpoints: `state.safetensors` in the run folder, for resuming the run and rendering its result.
#
# The file is written atomically. Its header contains the configuration, the prompt and box of every group, and the
# group of every instance.


CHECKPOINT = "state.safetensors"
VERSION = 1
_METADATA_KEY = "scenelang-distillation"
_METHOD = 2  # version of the optimization; runs of another version cannot be resumed


@dataclass(frozen=True, slots=True)
class SavedInstance:
    """Instance in a checkpoint.

    Attributes
    ----------
    group
        Index of its group.
    name, handle
        Words from the root, and handle.
    visible
        Visibility in each frame.
    """

    group: int
    name: str
    handle: str
    visible: tuple[bool, ...]

    @property
    def word(self) -> str:
        """Word of the entity."""
        return self.name.rpartition("/")[2]


@dataclass(frozen=True, slots=True, eq=False)
class SavedDistillation:
    """Checkpoint of a run.

    Attributes
    ----------
    tensors
        State of the trainer.
    keys
        Keys of the groups.
    instances
        Instances of the groups.
    config
        Settings, models and prompt, as JSON data.
    seconds
        Duration of the run.
    frozen
        Indices of the groups reused from another run.
    """

    tensors: Mapping[str, Tensor]
    keys: tuple[str, ...]
    instances: tuple[SavedInstance, ...]
    config: Mapping[str, Any]
    seconds: float
    frozen: tuple[int, ...] = ()

    @property
    def frames(self) -> int:
        return len(self.instances[0].visible)

    def frozen_states(self) -> dict[int, dict[str, Tensor]]:
        """Return the states of the groups reused from another run."""
        return {number: group_state(self.tensors, number) for number in self.frozen}

    def groups(self) -> list[Gaussians]:
        """Return the Gaussians of every group in its frame, colors sRGB."""
        gaussians = []
        for number in range(len(self.keys)):
            state = group_state(self.tensors, number)
            columns = {name.removeprefix("theta/"): state[name] for name in state if name.startswith("theta/")}
            gaussians.append(Theta(**columns).gaussians())
        return gaussians

    def offsets(self) -> PoseOffsets:
        """Return the learned pose offsets."""
        return PoseOffsets(*(self.tensors[f"poses/{name}"] for name in ("turns", "shifts", "log_scales")))

    def splats(self, frame: int) -> Splats:
        """Return all Gaussians of a frame in the world, colors sRGB; the frame must have a visible instance."""
        return compose(self.groups(), self.instances, self.tensors["starts"], self.offsets(), frame)

    def matrices(self, instance: int) -> list[list[list[float]] | None]:
        """Return the learned pose (3, 4) of an instance in every frame, from its group's frame to the world.

        The pose is None in frames where the instance is not visible.
        """
        import torch

        offsets = self.offsets()
        poses: list[list[list[float]] | None] = []
        for frame, visible in enumerate(self.instances[instance].visible):
            matrix, translation = offsets.apply(torch.tensor([instance]), frame, self.tensors["starts"])
            poses.append(torch.cat([matrix, translation[:, :, None]], 2)[0].tolist() if visible else None)
        return poses


def run_config(settings: DistillationSettings, models: Sequence[str], prompt: str) -> dict[str, Any]:
    """Return the configuration of a run, which must be equal to resume it, except for the number of steps."""
    return {**asdict(settings), "models": list(models), "prompt": prompt, "method": _METHOD}


def save_checkpoint(
    folder: Path,
    state: Mapping[str, Tensor],
    scene: SceneGroups,
    config: Mapping[str, Any],
    seconds: float,
    frozen: Sequence[int] = (),
) -> None:
    """Write the checkpoint of a run, atomically; raises SceneError("file")."""
    save = require("safetensors.torch", INSTALL).save
    instances = [
        {"figure": each.group, "name": each.name, "handle": each.handle, "shown": [bool(v) for v in each.visible]}
        for each in scene.instances
    ]
    header = {
        "version": VERSION,
        "keys": [group_key(group) for group in scene.groups],
        "players": instances,
        "asked": dict(config),
        "seconds": seconds,
        "frozen": list(frozen),
    }
    data = save(dict(state), metadata={_METADATA_KEY: json.dumps(header)})
    with atomic_write(folder / CHECKPOINT) as temporary:
        temporary.write_bytes(data)


def load_checkpoint(folder: Path) -> SavedDistillation:
    """Load the checkpoint of the run in ``folder``; raises SceneError("file") if it does not exist or is invalid."""
    with _checkpoint_errors(folder):
        from safetensors import safe_open

        with safe_open(str(folder / CHECKPOINT), framework="pt") as file:
            header = json.loads((file.metadata() or {})[_METADATA_KEY])
            if header["version"] != VERSION:
                raise ValueError(f"unsupported version {str(header['version'])[:20]}, expected {VERSION}")
            tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
        instances = tuple(
            SavedInstance(int(each["figure"]), str(each["name"]), str(each["handle"]), tuple(map(bool, each["shown"])))
            for each in header["players"]
        )
        keys = tuple(map(str, header["keys"]))
        saved = SavedDistillation(tensors, keys, instances, header["asked"], float(header["seconds"]), _frozen(header))
        _check(saved)
        return saved


def _frozen(header: Mapping[str, Any]) -> tuple[int, ...]:
    """Return the indices of reused groups; raises ValueError for an index out of range."""
    numbers = tuple(int(number) for number in header["frozen"])
    if any(not 0 <= number < len(header["keys"]) for number in numbers):
        raise ValueError("a reused group does not exist")
    return numbers


def _check(saved: SavedDistillation) -> None:
    """Raise ValueError or KeyError for tensors that are inconsistent with the header."""
    count, frames = len(saved.instances), saved.frames
    if saved.tensors["starts"].shape != (count, frames, 3, 4):
        raise ValueError("the number of poses differs from the number of instances")
    if any(len(each.visible) != frames or not 0 <= each.group < len(saved.keys) for each in saved.instances):
        raise ValueError("an instance has an unknown group or another number of frames")
    for gaussians in saved.groups():
        size = len(gaussians)
        shapes = (
            gaussians.means.shape,
            gaussians.log_scales.shape,
            gaussians.quaternions.shape,
            gaussians.colors.shape,
        )
        if shapes != ((size, 3), (size, 3), (size, 4), (size, 3)) or gaussians.opacity_logits.shape != (size,):
            raise ValueError("its Gaussians have the wrong shapes")


@contextmanager
def _checkpoint_errors(folder: Path) -> Iterator[None]:
    """Translate errors while reading a checkpoint to SceneError("file")."""
    from safetensors import SafetensorError

    try:
        yield
    except FileNotFoundError:
        raise SceneError("file", f"no distillation in {folder}") from None
    except (SafetensorError, OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError, IndexError) as e:
        message = f"{folder / CHECKPOINT} is not a readable distillation checkpoint: {str(e)[:120]}"
        raise SceneError("file", message) from None


def check_same(saved: SavedDistillation, scene: SceneGroups, config: Mapping[str, Any]) -> None:
    """Raise SceneError("value") if the run is of another scene or has another configuration."""
    if list(saved.keys) != [group_key(group) for group in scene.groups] or saved.frames != scene.frames:
        raise SceneError("value", "cannot resume the run: it is of another scene", hint=_FORCE_HINT)
    current = json.loads(json.dumps(dict(config)))
    different = sorted(name for name in current if name != "steps" and saved.config.get(name) != current[name])
    if different:
        message = f"cannot resume the run: it has other settings: {', '.join(different)}"
        raise SceneError("value", message, hint=_FORCE_HINT)


_FORCE_HINT = "use --force to start over, or --start DIR to reuse the parts that did not change"


def unchanged_groups(saved: SavedDistillation, scene: SceneGroups) -> dict[int, dict[str, Tensor]]:
    """Return the states of the groups with equal prompt and box in an earlier run."""
    indices = {key: number for number, key in enumerate(saved.keys)}
    states = {}
    for number, group in enumerate(scene.groups):
        if group_key(group) in indices:
            states[number] = group_state(saved.tensors, indices[group_key(group)])
    return states


# Outputs besides the checkpoint: a preview during the run; Gaussians and poses at its end.


PREVIEW = "preview.png"
_PREVIEW_SIZE, _PREVIEW_VIEWS, _MAX_PREVIEWS = 160, 4, 8


def write_preview(trainer: DistillationTrainer, folder: Path) -> None:
    """Write an image of the first groups, a row of four views for each."""
    rows = [_preview_row(group.theta.gaussians()) for group in trainer.groups[:_MAX_PREVIEWS]]
    with atomic_write(folder / PREVIEW) as temporary:
        save_picture(np.concatenate(rows), temporary)


def _preview_row(gaussians: Gaussians) -> npt.NDArray[np.uint8]:
    import torch

    with torch.no_grad():
        splats = local_splats(gaussians)
        cameras = orbit_cameras(_PREVIEW_VIEWS, _PREVIEW_SIZE)
        pictures = [render(splats, camera).cpu().numpy() for camera in cameras]
    return np.asarray(np.rint(255.0 * np.clip(np.concatenate(pictures, 1), 0.0, 1.0)), np.uint8)


def write_outcome(saved: SavedDistillation, scene: SceneGroups, folder: Path) -> list[Path]:
    """Write `scene.ply`, or one file per frame of a 4D scene, and `poses.json`; returns their paths.

    Raises SceneError("file").
    """
    import torch

    written = []
    for frame in range(saved.frames):
        if not any(instance.visible[frame] for instance in saved.instances):
            continue
        path = folder / ("scene.ply" if saved.frames == 1 else f"scene-{frame:03d}.ply")
        with torch.no_grad():
            splats = saved.splats(frame)
            linear = torch.from_numpy(np.asarray(from_srgb(splats.colors.numpy()), np.float32))
            lit = Splats(splats.means, splats.covariances, splats.opacities, linear)
            write_gaussians(gaussians_from(lit), path)
        written.append(path)
    path = folder / "poses.json"
    write_json(path, poses_of(saved, scene))
    return [*written, path]


def poses_of(saved: SavedDistillation, scene: SceneGroups) -> dict[str, Any]:
    """Return the learned poses as JSON data.

    Of each instance: words, handle, group, matrices (3, 4) in every frame, and the path of its center; both are null in
    frames where it is not visible. Of each group: prompt, key and half sizes of the box.
    """
    instances = []
    for number, instance in enumerate(saved.instances):
        matrices = saved.matrices(number)
        path = [None if matrix is None else [row[3] for row in matrix] for matrix in matrices]
        instances.append(
            {
                "name": instance.name,
                "handle": f"<{instance.handle}>",
                "figure": instance.group,
                "poses": matrices,
                "path": path,
            }
        )
    groups = [
        {"sentence": group.condition.plain, "key": key, "box": group.box.tolist()}
        for group, key in zip(scene.groups, saved.keys)
    ]
    return {"format": "scenelang-distillation", "version": 1, "figures": groups, "actors": instances}


# Training loop.


LOSSES = "losses.jsonl"
_CHECKPOINT_INTERVAL = 30.0  # minimum seconds between checkpoints
_MAX_OVERHEAD = 0.1  # fraction of the time that may be spent on checkpoints


@dataclass(frozen=True, slots=True)
class DistillationProgress:
    """Progress of a run: ``done`` of ``steps`` steps, completed fraction ``share``, and losses of the last step."""

    done: int
    steps: int
    share: float
    losses: Losses

    def __str__(self) -> str:
        losses = self.losses
        parts = f"object {losses.group:.4g}  scene {losses.scene:.4g}  layout {losses.layout:.3g}"
        return f"{100 * self.share:3.0f}%  step {self.done:,}/{self.steps:,}  {parts}"


def run(
    trainer: DistillationTrainer,
    folder: Path,
    config: Mapping[str, Any],
    *,
    seconds: float = 0.0,
    budget: float | None = None,
    on_step: Callable[[DistillationProgress], None] = lambda _: None,
    stop: Callable[[], bool] = lambda: False,
) -> bool:
    """Run the remaining steps; returns True if the run is finished.

    Parameters
    ----------
    trainer : DistillationTrainer
        Trainer in its initial or restored state.
    folder : Path
        Run folder; a checkpoint is written every half minute and at the end.
    config : mapping
        Configuration of the run.
    seconds : float
        Duration of the run before it was resumed.
    budget : float, optional
        Maximum duration in seconds. The timestep annealing then follows the time, so the result depends on the machine.
    on_step : callable
        Called after each step.
    stop : callable
        Called before each step; the run ends if it returns True.

    Raises
    ------
    SceneError
        "file" if a checkpoint cannot be written, "unsupported" if the loss is not finite.
    """
    begun = time.monotonic() - seconds
    last, cost = time.monotonic(), 0.0
    log: list[dict[str, Any]] = []
    while trainer.step_number < trainer.steps and not stop():
        elapsed = time.monotonic() - begun
        if budget is not None and elapsed >= budget:
            break
        try:
            losses = trainer.step(None if budget is None else elapsed / budget)
        except SceneError:
            _write(trainer, folder, config, elapsed, log)
            raise
        share = max(trainer.step_number / trainer.steps, 0.0 if budget is None else elapsed / budget)
        log.append({"step": trainer.step_number, **losses.data()})
        on_step(DistillationProgress(trainer.step_number, trainer.steps, min(share, 1.0), losses))
        if time.monotonic() - last > max(_CHECKPOINT_INTERVAL, cost / _MAX_OVERHEAD):
            start = time.monotonic()
            _write(trainer, folder, config, start - begun, log)
            last, cost = time.monotonic(), time.monotonic() - start
    _write(trainer, folder, config, time.monotonic() - begun, log)
    return trainer.step_number >= trainer.steps or (budget is not None and time.monotonic() - begun >= budget)


def _write(
    trainer: DistillationTrainer, folder: Path, config: Mapping[str, Any], seconds: float, log: list[dict[str, Any]]
) -> None:
    """Write checkpoint, losses and preview; clears ``log``."""
    save_checkpoint(folder, trainer.state(), trainer.scene, config, seconds, trainer.frozen)
    _append_losses(folder / LOSSES, log)
    log.clear()
    write_preview(trainer, folder)


def _append_losses(path: Path, log: list[dict[str, Any]]) -> None:
    """Append lines to the log of losses; replaces those of steps after the checkpoint from which a run was resumed."""
    first = log[0]["step"] if log else 0
    before = path.read_text("utf-8").splitlines() if path.exists() else []
    remaining = [line for line in before if not log or json.loads(line)["step"] < first]
    with atomic_write(path) as temporary:
        temporary.write_text("".join(f"{line}\n" for line in [*remaining, *map(json.dumps, log)]), "utf-8")


# Rendering of the result: the learned Gaussians, over the usual ground and sky.


class DistilledPainter:
    """Painter for the result of a run. The learned colors include lighting, so they are rendered unlit."""

    def __init__(self, staging: Staging, folder: Path) -> None:
        self._staging = staging
        self._saved: SavedDistillation = load_checkpoint(folder)
        self._folder = folder
        words = {entity.word for entity in descendants(*staging.roots.values())}
        frames = [frame for frame in staging.roots if frame < self._saved.frames]
        instances = [each for each in self._saved.instances if any(each.visible[frame] for frame in frames)]
        unknown = next((each.name for each in instances if each.word not in words), None)
        if unknown is not None:
            message = f"the run in {folder} is of another scene: this one has no `{unknown}`"
            raise SceneError("value", message)

    def paint(self, shot: Shot, progress: Progress | None = None) -> Image:
        import torch

        saved = self._saved
        if shot.frame >= saved.frames:
            raise SceneError("value", f"the run in {self._folder} has {saved.frames} frames, not {shot.frame + 1}")
        self._staging = adjusted(self._staging, shot)
        stage = self._staging.stage(shot)
        moved = stage.scale * torch.eye(3), torch.from_numpy(-stage.scale * stage.center).float()
        splats = saved.splats(shot.frame).transformed(*moved) if self._is_visible(shot.frame) else _no_splats()
        drawn = rasterise(splats, view_of(stage.camera, splats.means), antialiased=True)
        background = np.asarray(backdrop(stage, shadow_of(stage)), np.float32)
        behind = encode(tone_map(background, stage.studio.environment)) / 255.0
        alpha = drawn.alpha.numpy()[:, :, None]
        picture = np.clip(drawn.color.numpy() + (1.0 - alpha) * behind, 0.0, 1.0)
        if progress is not None:
            progress(1.0)
        return Image(np.asarray(np.rint(255.0 * picture), np.uint8), np.asarray(from_srgb(picture), np.float32))

    def _is_visible(self, frame: int) -> bool:
        return any(instance.visible[frame] for instance in self._saved.instances)


def _no_splats() -> Splats:
    import torch

    return Splats(torch.zeros(0, 3), torch.zeros(0, 3, 3), torch.zeros(0), torch.zeros(0, 3))

"""A run from its beginning or a break to its end: steps, a file now and then, a stop when it is asked for."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import Progress
from scenelang.backends.files import write_json, written_whole
from scenelang.backends.neural.distillation.checkpoint import SavedDistillation, keep, kept_in
from scenelang.backends.neural.distillation.learning import Cast, Learning, Losses, alone, pictured, ring
from scenelang.backends.neural.splats.files import write_gaussians
from scenelang.backends.neural.splats.gaussians import Splats, gaussians_from, view_of
from scenelang.backends.neural.splats.lighting import backdrop, shadow_of
from scenelang.backends.neural.splats.rasterise import rasterise
from scenelang.backends.pictures.film import Image, save_picture
from scenelang.backends.pictures.stage import Shot, Staging
from scenelang.backends.pictures.studio import encode, from_srgb, tone_map
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.entity import descendants

if TYPE_CHECKING:
    from scenelang.backends.neural.distillation.learning import Learning
    from scenelang.backends.neural.splats.gaussians import Gaussians


# What a run leaves besides its state: pictures while it goes on; Gaussians, poses and their paths at its end.


PREVIEW = "preview.png"
_SIZE, _VIEWS, _MOST = 160, 4, 8


def write_preview(learning: Learning, folder: Path) -> None:
    """The first figures from four sides each, below each other, as the models see them."""
    rows = [_strip(figure.theta.gaussians()) for figure in learning.figures[:_MOST]]
    with written_whole(folder / PREVIEW) as temporary:
        save_picture(np.concatenate(rows), temporary)


def _strip(gaussians: Gaussians) -> npt.NDArray[np.uint8]:
    import torch

    with torch.no_grad():
        splats = alone(gaussians)
        pictures = [pictured(splats, camera).cpu().numpy() for camera in ring(_VIEWS, _SIZE)]
    return np.asarray(np.rint(255.0 * np.clip(np.concatenate(pictures, 1), 0.0, 1.0)), np.uint8)


def write_outcome(kept: SavedDistillation, cast: Cast, folder: Path) -> list[Path]:
    """`scene.ply`, or one file for each frame of a 4D scene, and `poses.json`; returns what was written. Raises
    SceneError("file")."""
    import torch

    written = []
    for frame in range(kept.frames):
        if not any(player.shown[frame] for player in kept.players):
            continue
        path = folder / ("scene.ply" if kept.frames == 1 else f"scene-{frame:03d}.ply")
        with torch.no_grad():
            splats = kept.splats(frame)
            linear = torch.from_numpy(np.asarray(from_srgb(splats.colors.numpy()), np.float32))
            lit = Splats(splats.means, splats.covariances, splats.opacities, linear)
            write_gaussians(gaussians_from(lit), path)
        written.append(path)
    path = folder / "poses.json"
    write_json(path, poses_of(kept, cast))
    return [*written, path]


def poses_of(kept: SavedDistillation, cast: Cast) -> dict[str, Any]:
    """The learned poses as JSON data: for each actor its words, handle and figure, its matrix (3, 4) in every frame
    and the path of its middle, null where it is not shown; for each figure its sentence and the half sizes of its
    box."""
    actors = []
    for number, player in enumerate(kept.players):
        matrices = kept.matrices(number)
        path = [None if matrix is None else [row[3] for row in matrix] for matrix in matrices]
        actors.append(
            {
                "name": player.name,
                "handle": f"<{player.handle}>",
                "figure": player.figure,
                "poses": matrices,
                "path": path,
            }
        )
    figures = [
        {"sentence": figure.condition.plain, "key": key, "box": figure.box.tolist()}
        for figure, key in zip(cast.figures, kept.keys)
    ]
    return {"format": "scenelang-distillation", "version": 1, "figures": figures, "actors": actors}


LOSSES = "losses.jsonl"
_PAUSE = 30.0  # seconds between two files
_SLOWEST = 0.1  # of the time that may go into files


@dataclass(frozen=True, slots=True)
class DistillationProgress:
    """Where a run stands: steps ``done`` of ``steps``, the share of it all, and the losses of the last step."""

    done: int
    steps: int
    share: float
    losses: Losses

    def __str__(self) -> str:
        losses = self.losses
        parts = f"figure {losses.figure:.4g}  scene {losses.scene:.4g}  layout {losses.layout:.3g}"
        return f"{100 * self.share:3.0f}%  step {self.done:,}/{self.steps:,}  {parts}"


def run(
    learning: Learning,
    folder: Path,
    asked: Mapping[str, Any],
    *,
    seconds: float = 0.0,
    budget: float | None = None,
    tell: Callable[[DistillationProgress], None] = lambda _: None,
    stopped: Callable[[], bool] = lambda: False,
) -> bool:
    """Make the steps that are left and keep the run in ``folder``; True where it came to its end.

    ``seconds`` were used before; ``budget`` are all that may be. With one the annealing follows the time, so that the
    result depends on the machine. The state is written every half minute, at the end and where ``stopped`` says so:
    a kill loses no more. Raises SceneError("file").
    """
    begun = time.monotonic() - seconds
    last, cost = time.monotonic(), 0.0
    told: list[dict[str, Any]] = []
    while learning.step_number < learning.steps and not stopped():
        used = time.monotonic() - begun
        if budget is not None and used >= budget:
            break
        try:
            losses = learning.step(None if budget is None else used / budget)
        except SceneError:
            _write(learning, folder, asked, used, told)
            raise
        share = max(learning.step_number / learning.steps, 0.0 if budget is None else used / budget)
        told.append({"step": learning.step_number, **asdict(losses)})
        tell(DistillationProgress(learning.step_number, learning.steps, min(share, 1.0), losses))
        if time.monotonic() - last > max(_PAUSE, cost / _SLOWEST):
            start = time.monotonic()
            _write(learning, folder, asked, start - begun, told)
            last, cost = time.monotonic(), time.monotonic() - start
    _write(learning, folder, asked, time.monotonic() - begun, told)
    return learning.step_number >= learning.steps or (budget is not None and time.monotonic() - begun >= budget)


def _write(
    learning: Learning, folder: Path, asked: Mapping[str, Any], seconds: float, told: list[dict[str, Any]]
) -> None:
    keep(folder, learning.state(), learning.cast, asked, seconds, learning.frozen)
    _add_losses(folder / LOSSES, told)
    told.clear()
    write_preview(learning, folder)


def _add_losses(path: Path, told: list[dict[str, Any]]) -> None:
    """Add lines to the record of losses; steps that a killed run made after its last file are not told twice."""
    first = told[0]["step"] if told else 0
    before = path.read_text("utf-8").splitlines() if path.exists() else []
    kept = [line for line in before if not told or json.loads(line)["step"] < first]
    with written_whole(path) as temporary:
        temporary.write_text("".join(f"{line}\n" for line in [*kept, *map(json.dumps, told)]), "utf-8")


# Pictures of what was distilled: the learned Gaussians over the ground and sky of every other picture.


class DistilledPainter:
    """Draws shots of the run in a folder. Its colours are those of pictures, so that no light falls on them."""

    def __init__(self, staging: Staging, folder: Path) -> None:
        self._staging = staging
        self._kept: SavedDistillation = kept_in(folder)
        self._folder = folder
        words = {entity.word for entity in descendants(*staging.roots.values())}
        frames = [frame for frame in staging.roots if frame < self._kept.frames]
        players = [player for player in self._kept.players if any(player.shown[frame] for frame in frames)]
        strange = next((player.name for player in players if player.word not in words), None)
        if strange is not None:
            message = f"the run in {folder} was made of another scene: there is no `{strange}` in this one"
            raise SceneError("value", message)

    def paint(self, shot: Shot, progress: Progress | None = None) -> Image:
        import torch

        kept = self._kept
        if shot.frame >= kept.frames:
            raise SceneError("value", f"the run in {self._folder} has {kept.frames} frames, not {shot.frame + 1}")
        stage = self._staging.stage(shot)
        moved = stage.scale * torch.eye(3), torch.from_numpy(-stage.scale * stage.center).float()
        splats = kept.splats(shot.frame).moved(*moved) if self._is_shown(shot.frame) else _nothing()
        drawn = rasterise(splats, view_of(stage.camera, splats.means), antialiased=True)
        behind = (
            encode(tone_map(np.asarray(backdrop(stage, shadow_of(stage)), np.float32), stage.studio.environment))
            / 255.0
        )
        hidden = drawn.alpha.numpy()[:, :, None]
        picture = np.clip(drawn.color.numpy() + (1.0 - hidden) * behind, 0.0, 1.0)
        if progress is not None:
            progress(1.0)
        return Image(np.asarray(np.rint(255.0 * picture), np.uint8), np.asarray(from_srgb(picture), np.float32))

    def _is_shown(self, frame: int) -> bool:
        return any(player.shown[frame] for player in self._kept.players)


def _nothing() -> Splats:
    import torch

    return Splats(torch.zeros(0, 3), torch.zeros(0, 3, 3), torch.zeros(0), torch.zeros(0, 3))

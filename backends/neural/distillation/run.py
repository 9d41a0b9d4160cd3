"""A run from its beginning or a break to its end: steps, a file now and then, a stop when it is asked for."""

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
from scenelang.backends.neural.distillation.learning import (
    Cast,
    DistillationSettings,
    Learning,
    Losses,
    alone,
    figure_key,
    figure_state,
    pictured,
    ring,
)
from scenelang.backends.neural.distillation.theta import Poses, Theta, on_stage
from scenelang.backends.neural.splats.files import write_gaussians
from scenelang.backends.neural.splats.gaussians import Splats, gaussians_from, view_of
from scenelang.backends.neural.splats.initial import backdrop, shadow_of
from scenelang.backends.neural.splats.rasterise import rasterise
from scenelang.backends.neural.weights import INSTALL
from scenelang.backends.pictures.film import Image, save_picture
from scenelang.backends.pictures.stage import Shot, Staging
from scenelang.backends.pictures.studio import encode, from_srgb, tone_map
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.entity import descendants

if TYPE_CHECKING:
    from torch import Tensor

    from scenelang.backends.neural.distillation.learning import Learning
    from scenelang.backends.neural.splats.gaussians import Gaussians, Splats


# A distillation as files, so that it goes on after a break and is drawn later: `state.safetensors` in its folder.
#
# The file is written whole or not at all. Its header says what the tensors belong to: the settings, every figure's
# sentence and box, and which figure each actor is.


STATE = "state.safetensors"
VERSION = 1
_ENTRY = "scenelang-distillation"
_METHOD = 2  # what a step does; a run that was made by another one does not go on


@dataclass(frozen=True, slots=True)
class Player:
    """An actor by what its file says: the figure's number, the words down to it, its handle, where it is shown."""

    figure: int
    name: str
    handle: str
    shown: tuple[bool, ...]

    @property
    def word(self) -> str:
        """The word of the thing itself."""
        return self.name.rpartition("/")[2]


@dataclass(frozen=True, slots=True, eq=False)
class SavedDistillation:
    """What a run's file holds: ``tensors`` as ``Learning.state`` gives them, ``keys`` of the figures, the actors, what
    was ``asked`` (settings, models and prompt, as JSON data) and how long it took in seconds; the figures numbered
    ``frozen`` were taken over from another run."""

    tensors: Mapping[str, Tensor]
    keys: tuple[str, ...]
    players: tuple[Player, ...]
    asked: Mapping[str, Any]
    seconds: float
    frozen: tuple[int, ...] = ()

    @property
    def frames(self) -> int:
        return len(self.players[0].shown)

    def frozen_states(self) -> dict[int, dict[str, Tensor]]:
        """The states of the figures that were taken over."""
        return {number: figure_state(self.tensors, number) for number in self.frozen}

    def thetas(self) -> list[Gaussians]:
        """The Gaussians of every figure in its frame, colours sRGB."""
        found = []
        for number in range(len(self.keys)):
            state = figure_state(self.tensors, number)
            columns = {name.removeprefix("theta/"): state[name] for name in state if name.startswith("theta/")}
            found.append(Theta(**columns).gaussians())
        return found

    def splats(self, frame: int) -> Splats:
        """All that is on the stage in a frame, of which there is at least one; colours sRGB."""
        poses = Poses(*(self.tensors[f"poses/{name}"] for name in ("turns", "shifts", "log_scales")))
        return on_stage(self.thetas(), self.players, self.tensors["starts"], poses, frame)

    def matrices(self, player: int) -> list[list[list[float]] | None]:
        """The learned pose (3, 4) of an actor in every frame, from its figure's frame to the world; None where it is
        not shown."""
        import torch

        poses = Poses(*(self.tensors[f"poses/{name}"] for name in ("turns", "shifts", "log_scales")))
        found: list[list[list[float]] | None] = []
        for frame, shown in enumerate(self.players[player].shown):
            matrix, place = poses.of(torch.tensor([player]), frame, self.tensors["starts"])
            found.append(torch.cat([matrix, place[:, :, None]], 2)[0].tolist() if shown else None)
        return found


def asked_of(settings: DistillationSettings, models: Sequence[str], prompt: str) -> dict[str, Any]:
    """What must be the same for a run to go on; more steps may be asked for."""
    return {**asdict(settings), "models": list(models), "prompt": prompt, "method": _METHOD}


def keep(
    folder: Path,
    state: Mapping[str, Tensor],
    cast: Cast,
    asked: Mapping[str, Any],
    seconds: float,
    frozen: Sequence[int] = (),
) -> None:
    """Write the state of a run, whole or not at all; raises SceneError("file")."""
    save = require("safetensors.torch", INSTALL).save
    players = [
        {"figure": a.figure, "name": a.name, "handle": a.handle, "shown": [bool(s) for s in a.shown]}
        for a in cast.actors
    ]
    told = {
        "version": VERSION,
        "keys": [figure_key(figure) for figure in cast.figures],
        "players": players,
        "asked": dict(asked),
        "seconds": seconds,
        "frozen": list(frozen),
    }
    data = save(dict(state), metadata={_ENTRY: json.dumps(told)})
    with atomic_write(folder / STATE) as temporary:
        temporary.write_bytes(data)


def kept_in(folder: Path) -> SavedDistillation:
    """The run in ``folder``; raises SceneError("file") where there is none, or none that can be read."""
    with _faults(folder):
        from safetensors import safe_open

        with safe_open(str(folder / STATE), framework="pt") as file:
            told = json.loads((file.metadata() or {})[_ENTRY])
            if told["version"] != VERSION:
                raise ValueError(f"its version is {str(told['version'])[:20]}; this program knows {VERSION}")
            tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
        players = tuple(
            Player(int(p["figure"]), str(p["name"]), str(p["handle"]), tuple(map(bool, p["shown"])))
            for p in told["players"]
        )
        kept = SavedDistillation(
            tensors, tuple(map(str, told["keys"])), players, told["asked"], float(told["seconds"]), _numbers(told)
        )
        _check(kept)
        return kept


def _numbers(told: Mapping[str, Any]) -> tuple[int, ...]:
    """The figures that were taken over; raises ValueError for numbers of none."""
    found = tuple(int(number) for number in told["frozen"])
    if any(not 0 <= number < len(told["keys"]) for number in found):
        raise ValueError("it took over figures that it does not have")
    return found


def _check(kept: SavedDistillation) -> None:
    """Raises ValueError or KeyError for tensors that do not fit what the header says."""
    count, frames = len(kept.players), kept.frames
    if kept.tensors["starts"].shape != (count, frames, 3, 4):
        raise ValueError("its poses do not belong to its actors")
    if any(len(p.shown) != frames or not 0 <= p.figure < len(kept.keys) for p in kept.players):
        raise ValueError("its actors do not belong to its figures")
    for theta in kept.thetas():
        size = len(theta)
        shapes = (theta.means.shape, theta.log_scales.shape, theta.quaternions.shape, theta.colors.shape)
        if shapes != ((size, 3), (size, 3), (size, 4), (size, 3)) or theta.opacity_logits.shape != (size,):
            raise ValueError("its Gaussians have the wrong shapes")


@contextmanager
def _faults(folder: Path) -> Iterator[None]:
    from safetensors import SafetensorError

    try:
        yield
    except FileNotFoundError:
        raise SceneError("file", f"no distillation in {folder}") from None
    except (SafetensorError, OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError, IndexError) as e:
        raise SceneError(
            "file", f"{folder / STATE} is not a readable distillation checkpoint: {str(e)[:120]}"
        ) from None


def check_same(kept: SavedDistillation, cast: Cast, asked: Mapping[str, Any]) -> None:
    """Raises SceneError("value") where the run is not that of ``cast`` with ``asked``, so that it cannot go on."""
    if list(kept.keys) != [figure_key(figure) for figure in cast.figures] or kept.frames != cast.frames:
        raise SceneError("value", "the run there was made of another scene, so it cannot go on", hint=_AGAIN)
    mine = json.loads(json.dumps(dict(asked)))
    different = sorted(name for name in mine if name != "steps" and kept.asked.get(name) != mine[name])
    if different:
        raise SceneError("value", f"the run there had other settings: {', '.join(different)}", hint=_AGAIN)


_AGAIN = "use --force to start over, or --start DIR to reuse the parts that did not change"


def same_figures(kept: SavedDistillation, cast: Cast) -> dict[int, dict[str, Tensor]]:
    """The states of the figures that an earlier run has learned already: those of equal sentence and box."""
    known = {key: number for number, key in enumerate(kept.keys)}
    found = {}
    for number, figure in enumerate(cast.figures):
        if figure_key(figure) in known:
            found[number] = figure_state(kept.tensors, known[figure_key(figure)])
    return found


# What a run leaves besides its state: pictures while it goes on; Gaussians, poses and their paths at its end.


PREVIEW = "preview.png"
_SIZE, _VIEWS, _MOST = 160, 4, 8


def write_preview(learning: Learning, folder: Path) -> None:
    """The first figures from four sides each, below each other, as the models see them."""
    rows = [_strip(figure.theta.gaussians()) for figure in learning.figures[:_MOST]]
    with atomic_write(folder / PREVIEW) as temporary:
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
    with atomic_write(path) as temporary:
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

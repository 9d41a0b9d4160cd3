"""A distillation as files, so that it goes on after a break and is drawn later: `state.safetensors` in its folder.

The file is written whole or not at all. Its header says what the tensors belong to: the settings, every figure's
sentence and box, and which figure each actor is.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.backends.base import need
from scenelang.backends.files import written_whole
from scenelang.backends.neural.distillation.learning import Cast, DistillationSettings, figure_key, figure_state
from scenelang.backends.neural.distillation.theta import Poses, Theta, on_stage
from scenelang.backends.neural.weights import INSTALL
from scenelang.grammar.diagnostics import SceneError

if TYPE_CHECKING:
    from torch import Tensor

    from scenelang.backends.neural.splats.gaussians import Gaussians, Splats


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
    save = need("safetensors.torch", INSTALL).save
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
    with written_whole(folder / STATE) as temporary:
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
        raise SceneError("file", f"there is no distillation in {folder}") from None
    except (SafetensorError, OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError, IndexError) as e:
        raise SceneError("file", f"{folder / STATE} is no distillation that can be read: {str(e)[:120]}") from None


def check_same(kept: SavedDistillation, cast: Cast, asked: Mapping[str, Any]) -> None:
    """Raises SceneError("value") where the run is not that of ``cast`` with ``asked``, so that it cannot go on."""
    if list(kept.keys) != [figure_key(figure) for figure in cast.figures] or kept.frames != cast.frames:
        raise SceneError("value", "the run there was made of another scene, so it cannot go on", hint=_AGAIN)
    mine = json.loads(json.dumps(dict(asked)))
    different = sorted(name for name in mine if name != "steps" and kept.asked.get(name) != mine[name])
    if different:
        raise SceneError("value", f"the run there had other settings: {', '.join(different)}", hint=_AGAIN)


_AGAIN = "--force begins anew; --start DIR takes over what is still the same"


def same_figures(kept: SavedDistillation, cast: Cast) -> dict[int, dict[str, Tensor]]:
    """The states of the figures that an earlier run has learned already: those of equal sentence and box."""
    known = {key: number for number, key in enumerate(kept.keys)}
    found = {}
    for number, figure in enumerate(cast.figures):
        if figure_key(figure) in known:
            found[number] = figure_state(kept.tensors, known[figure_key(figure)])
    return found

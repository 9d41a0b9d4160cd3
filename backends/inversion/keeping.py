"""An inversion as a file, so that it goes on after a break: `inversion.safetensors` in its folder, written whole or
not at all."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.backends.base import need
from scenelang.backends.clip.encodings import written
from scenelang.backends.files import written_whole
from scenelang.backends.inversion.learning import Inverting
from scenelang.backends.inversion.settings import Settings
from scenelang.backends.inversion.subjects import Subject
from scenelang.backends.weights import INSTALL
from scenelang.grammar.diagnostics import SceneError

if TYPE_CHECKING:
    from torch import Tensor

STATE = "inversion.safetensors"
VERSION = 1
_ENTRY = "scenelang-inversion"
_AGAIN = "--force begins anew"


@dataclass(frozen=True, slots=True, eq=False)
class Kept:
    """What a run's file holds: ``tensors`` after ``done`` steps, what was ``asked`` (JSON data), the loss of each step,
    and the loss measured at the start."""

    tensors: Mapping[str, Tensor]
    done: int
    asked: Mapping[str, Any]
    losses: tuple[float, ...]
    first: float

    @property
    def finished(self) -> bool:
        return self.done >= int(self.asked["steps"])


def asked_of(settings: Settings, model: str, subjects: Sequence[Subject], starts: Mapping[str, str]) -> dict[str, Any]:
    """What must be the same for a run to go on; more steps may be asked for. ``starts`` are the words by name."""
    shown = [
        [written(subject.prompt), hashlib.sha256(subject.picture.cpu().numpy().tobytes()).hexdigest()]
        for subject in subjects
    ]
    return {**asdict(settings), "model": model, "pictures": shown, "words": dict(starts)}


def keep(folder: Path, learning: Inverting, asked: Mapping[str, Any], losses: Sequence[float], first: float) -> None:
    """Write a run's file; raises SceneError("file")."""
    save = need("safetensors.torch", INSTALL).save
    told = {"version": VERSION, "done": learning.done, "asked": asked, "losses": list(losses), "first": first}
    data = save(learning.state(), metadata={_ENTRY: json.dumps(told)})
    with written_whole(folder / STATE) as temporary:
        temporary.write_bytes(data)


def kept_in(folder: Path) -> Kept:
    """The run in ``folder``; raises SceneError("file") where there is none, or none that can be read."""
    safetensors = need("safetensors", INSTALL)
    try:
        with safetensors.safe_open(str(folder / STATE), framework="pt") as file:
            told = json.loads((file.metadata() or {})[_ENTRY])
            tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
        if told["version"] != VERSION:
            raise ValueError(f"its version is {str(told['version'])[:20]}; this program knows {VERSION}")
        kept = Kept(
            tensors, int(told["done"]), dict(told["asked"]), tuple(map(float, told["losses"])), float(told["first"])
        )
        if not 0 <= kept.done == len(kept.losses) or int(kept.asked["steps"]) < 1:
            raise ValueError("its steps are not those of its losses")
        return kept
    except FileNotFoundError:
        raise SceneError("file", f"there is no inversion in {folder}") from None
    except (safetensors.SafetensorError, OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise _unreadable(folder, error) from None


def restore(learning: Inverting, kept: Kept, asked: Mapping[str, Any], folder: Path) -> None:
    """Have ``learning`` go on from ``kept``; raises SceneError: "value" for a run that was asked for something else,
    "file" for tensors that are not those of its vectors."""
    mine = json.loads(json.dumps(dict(asked)))
    different = sorted(name for name in mine if name != "steps" and kept.asked.get(name) != mine[name])
    if different:
        raise SceneError("value", f"the inversion in {folder} had other {', '.join(different)}", hint=_AGAIN)
    if kept.done > learning.steps:
        message = f"the inversion in {folder} has made {kept.done} steps already, more than {learning.steps}"
        raise SceneError("value", message, hint=_AGAIN)
    try:
        learning.restore(kept.tensors, kept.done)
    except (KeyError, ValueError) as error:
        raise _unreadable(folder, error) from None


def _unreadable(folder: Path, error: Exception) -> SceneError:
    return SceneError("file", f"{folder / STATE} is no inversion that can be read: {str(error)[:120]}")

"""Weights that torchvision publishes as single files, by name."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from scenelang.backends.base import need
from scenelang.backends.weights import INSTALL, Shelf

_HOST = "https://download.pytorch.org/models/"


@dataclass(frozen=True, slots=True)
class Published:
    """A model's name on the shelf, and its file as torchvision calls it, whose last part is the sum that is checked."""

    name: str
    file: str


ALEXNET = Published("alexnet", "alexnet-owt-7be5be79.pth")
RAFT_LARGE = Published("raft_large", "raft_large_C_T_V1-22a6c225.pth")  # ported from RAFT's own: chairs, then things


def state_of(published: Published, shelf: Shelf) -> dict[str, Any]:
    """The tensors of a published model: from the folder on the shelf that is called after it (its file there, else the
    only ``.pth`` or ``.safetensors``), from torch's own cache, or from the network.

    Raises SceneError("weights") where they are not to be had.
    """

    def hub(_: str, offline: bool) -> dict[str, Any]:
        torch = need("torch", INSTALL)
        kept = Path(torch.hub.get_dir()) / "checkpoints" / published.file
        if kept.is_file():
            return _read(kept)
        if offline:
            raise FileNotFoundError(f"{published.file} has not been fetched")
        found: dict[str, Any] = torch.hub.load_state_dict_from_url(
            f"{_HOST}{published.file}", map_location="cpu", check_hash=True, progress=False, weights_only=True
        )
        return found

    return shelf.load(published.name, lambda folder: _read(_file_in(folder, published)), hub, _HOST)


def _file_in(folder: Path, published: Published) -> Path:
    own = folder / published.file
    if own.is_file():
        return own
    found = sorted(path for path in folder.iterdir() if path.suffix in (".pth", ".safetensors"))
    if len(found) != 1:
        raise FileNotFoundError(f"there is no {published.file}")
    return found[0]


def _read(path: Path) -> dict[str, Any]:
    if path.suffix == ".safetensors":
        tensors: dict[str, Any] = need("safetensors.torch", INSTALL).load_file(path)
        return tensors
    found = need("torch", INSTALL).load(path, map_location="cpu", weights_only=True)
    if not isinstance(found, dict):
        raise ValueError(f"{path.name} holds no named tensors")
    return found

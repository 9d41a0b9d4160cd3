"""Networks of transformers with what prepares their inputs, by name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from scenelang.backends.base import need
from scenelang.backends.diffusion.fitting import other_model
from scenelang.backends.diffusion.memory import memory_told
from scenelang.backends.diffusion.quiet import quiet_libraries
from scenelang.backends.weights import INSTALL, Shelf


@dataclass(frozen=True, slots=True, eq=False)
class Loaded:
    """A frozen ``network`` of transformers on its device, and the ``processor`` of its inputs."""

    name: str
    network: Any
    processor: Any


def load_network(name: str, network: str, processor: str, shelf: Shelf | None, device: str) -> Loaded:
    """The model ``name`` as the classes ``network`` and ``processor`` of transformers, in float32.

    Raises SceneError: "weights" where these are not to be had, or are of another model; "backend" without the packages.
    """
    transformers = need("transformers", INSTALL)
    need("torchvision", INSTALL)  # the processors of pictures import it
    kinds = (getattr(transformers, network), getattr(transformers, processor))
    made, prepare = (shelf or Shelf()).load(
        name,
        lambda folder: _made(kinds, str(folder), True, device),
        lambda repository, offline: _made(kinds, repository, offline, device),
    )
    return Loaded(name, made, prepare)


def _made(kinds: tuple[Any, Any], name: str, offline: bool, device: str) -> tuple[Any, Any]:
    torch = need("torch", INSTALL)
    with quiet_libraries(bars=not Path(name).is_dir()):
        prepare = kinds[1].from_pretrained(name, local_files_only=offline)
        network, found = kinds[0].from_pretrained(
            name,
            local_files_only=offline,
            output_loading_info=True,
            ignore_mismatched_sizes=True,  # told below, in one line
            dtype=torch.float32,
        )
    wrong = _first_wrong(found)
    if wrong is not None:
        raise other_model(name, wrong)
    with memory_told():
        return network.to(device).eval().requires_grad_(False), prepare


def _first_wrong(found: Mapping[str, Any]) -> str | None:
    """What is wrong with the weights, in words. Some that a network has no use for come with the published ones."""
    if found["missing_keys"]:
        return f"`{min(found['missing_keys'])}` is missing"
    if found["mismatched_keys"]:
        return f"`{min(key for key, *_ in found['mismatched_keys'])}` has another shape"
    return None

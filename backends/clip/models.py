"""OpenCLIP models by name: loaded from a folder, from the hub's cache or from the hub."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from scenelang.backends.base import need
from scenelang.backends.weights import INSTALL, Shelf
from scenelang.grammar.diagnostics import SceneError


@dataclass(frozen=True, slots=True)
class ClipName:
    """An architecture of OpenCLIP and the tag of its weights; ``weights`` is empty for a folder that has its own."""

    architecture: str
    weights: str = ""

    def __str__(self) -> str:
        return f"{self.architecture}/{self.weights}" if self.weights else self.architecture

    @staticmethod
    def parse(text: str) -> ClipName:
        """``ViT-H-14/laion2b_s32b_b79k``, or a folder."""
        if Path(text).expanduser().is_dir():
            return ClipName(text)
        architecture, _, weights = text.partition("/")
        return ClipName(architecture, weights)


TEXT_SPACE = ClipName("ViT-H-14", "laion2b_s32b_b79k")  # Z_CLIP, the space of the paper's embeddings
JUDGE = ClipName("ViT-H-14-378-quickgelu", "dfn5b")  # that of its metric


@dataclass(frozen=True, slots=True, eq=False)
class ClipModel:
    """A model, its tokenizer and the function that prepares a PIL picture for it; weights are frozen."""

    name: ClipName
    network: Any
    tokenizer: Any
    prepare: Any


def load_clip(name: ClipName = TEXT_SPACE, shelf: Shelf | None = None, device: str = "cpu") -> ClipModel:
    """The model ``name``, ready to encode.

    A folder on the shelf called after the architecture holds ``open_clip_config.json`` and the weights, as OpenCLIP
    writes them. Raises SceneError: "weights" where these are not to be had, "backend" without the packages.
    """
    open_clip = need("open_clip", INSTALL)
    network, prepare, tokenizer = (shelf or Shelf()).load(
        name.architecture,
        lambda folder: _made(open_clip, f"local-dir:{folder}", device),
        partial(_from_hub, open_clip, name, device),
    )
    network.eval().requires_grad_(False)
    return ClipModel(name, network, tokenizer, prepare)


def _from_hub(open_clip: Any, name: ClipName, device: str, architecture: str, offline: bool) -> Any:
    if (architecture, name.weights) not in open_clip.list_pretrained():
        known = sorted({tag for model, tag in open_clip.list_pretrained() if model == architecture})
        hint = f"its weights are {', '.join(known)}" if known else "name a model of OpenCLIP, or a folder"
        raise SceneError("value", f"OpenCLIP has no model `{name}`", hint=hint)
    if offline:
        _check_cached(open_clip, name)
    return _made(open_clip, architecture, device, pretrained=name.weights)


def _check_cached(open_clip: Any, name: ClipName) -> None:
    """Raises FileNotFoundError where the hub would be asked for the weights."""
    hub = need("huggingface_hub", INSTALL)
    found = open_clip.get_pretrained_cfg(name.architecture, name.weights).get("hf_hub", "")
    repository = found.rstrip("/")
    for file in ("open_clip_model.safetensors", "open_clip_pytorch_model.bin"):
        if isinstance(hub.try_to_load_from_cache(repository, file), str):
            return
    raise FileNotFoundError(f"{repository or name} has not been fetched, and the hub cannot be asked")


def _made(open_clip: Any, architecture: str, device: str, **options: Any) -> Any:
    network, _, prepare = open_clip.create_model_and_transforms(architecture, device=device, **options)
    return network, prepare, open_clip.get_tokenizer(architecture)

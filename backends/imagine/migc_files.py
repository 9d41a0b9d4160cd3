"""MIGC's checkpoint: its key names in terms of diffusers' layers, and the shapes that it must have."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from scenelang.backends.base import need
from scenelang.backends.weights import INSTALL, Shelf
from scenelang.grammar.diagnostics import SceneError

WEIGHTS = "limuloo/MIGC"
FILE = "MIGC_SD14.ckpt"
SLOTS = 30
_KEY = re.compile(r"(?:.*\.)?(input_blocks|middle_block|output_blocks)\.(\d+)\.(?:.*\.)?migc\.(.+)\Z")
_START = "model.diffusion_model"
_WHERE = "1.transformer_blocks.0.attn2.migc"
_HOME = re.compile(r"(down_blocks|up_blocks)\.(\d+)\.attentions\.(\d+)\.")


@dataclass(frozen=True, slots=True, eq=False)
class Migc:
    """The tensors of each layer by their names within MIGC, by the name of diffusers' attention processor there."""

    layers: Mapping[str, Mapping[str, Any]]

    @property
    def text_width(self) -> int:
        """Numbers of a token that enhancement attention reads."""
        layer = next(iter(self.layers.values()))
        return int(layer["ea.to_k.weight"].shape[1])


def load_migc(name: str = WEIGHTS, shelf: Shelf | None = None) -> Migc:
    """MIGC's weights: a file, or a folder on the shelf that holds MIGC_SD14.ckpt.

    Raises SceneError("weights") where they are not to be had, or are no weights of MIGC.
    """
    path = Path(name).expanduser()
    place = path if path.is_file() else (shelf or Shelf()).place(name)
    if place is None:
        hint = f"fetch {FILE} from its makers (github.com/{WEIGHTS}, not for commercial use), and name it: --migc FILE"
        raise SceneError("weights", f"MIGC's weights `{name}` are not on this machine", hint=hint)
    file = place if place.is_file() else place / FILE
    try:
        return from_checkpoint(_read(file))
    except SceneError:
        raise
    except Exception as error:  # what torch raises for files that are no weights has no common type
        said = " ".join(str(error).split())[:160] or type(error).__name__
        raise SceneError("weights", f"{file} does not hold MIGC's weights: {said}") from error


def from_checkpoint(tensors: Mapping[str, Any]) -> Migc:
    """The layers of a checkpoint's tensors; raises SceneError("weights") for others."""
    layers: dict[str, dict[str, Any]] = {}
    for key, tensor in tensors.items():
        processor, inner = layer_of(key)
        layers.setdefault(processor, {})[inner] = tensor
    if not layers:
        raise SceneError("weights", "the checkpoint is empty: it holds no weights of MIGC")
    for processor, layer in layers.items():
        _check(processor, layer)
    return Migc(layers)


def to_checkpoint(migc: Migc) -> dict[str, Any]:
    """The tensors under the names that MIGC's checkpoint has for them."""
    return {
        f"{_START}.{original(processor)}.{_WHERE}.{inner}"
        if not processor.startswith("mid")
        else f"{_START}.middle_block.{_WHERE}.{inner}": tensor
        for processor, layer in migc.layers.items()
        for inner, tensor in layer.items()
    }


def layer_of(key: str) -> tuple[str, str]:
    """Diffusers' processor and the name within MIGC of a checkpoint's key; raises SceneError("weights")."""
    found = _KEY.match(key)
    if found is None:
        raise SceneError("weights", f"`{key[:120]}` is no key of MIGC's checkpoint")
    block, number, inner = found[1], int(found[2]), found[3]
    if block == "middle_block":
        home = "mid_block.attentions.0"
    elif block == "input_blocks":
        home = f"down_blocks.{number // 3}.attentions.{number % 3 - 1}"
    else:
        home = f"up_blocks.{number // 3}.attentions.{number % 3}"
    return f"{home}.transformer_blocks.0.attn2.processor", inner


def original(processor: str) -> str:
    """The block of the original model that holds a layer of diffusers' down or up blocks; raises SceneError."""
    found = _HOME.match(processor)
    if found is None:
        raise SceneError("weights", f"`{processor[:120]}` is no layer that MIGC knows")
    level, place = int(found[2]), int(found[3])
    return (
        f"input_blocks.{3 * level + place + 1}" if found[1] == "down_blocks" else f"output_blocks.{3 * level + place}"
    )


def shapes(width: int, text: int) -> dict[str, tuple[int, ...]]:
    """The shape of every tensor of a layer with ``width`` channels, for text tokens of ``text`` numbers."""
    found: dict[str, tuple[int, ...]] = {"norm.weight": (width,), "norm.bias": (width,)}
    for part, read in (("ea", text), ("la", width)):
        found |= {f"{part}.to_q.weight": (width, width), f"{part}.to_k.weight": (width, read)}
        found |= {f"{part}.to_v.weight": (width, read)} | _layer(f"{part}.to_out.0", width, width)
    found |= _layer("sac.conv1", width, width + 1, 1, 1) | _layer("sac.conv2", 1, width, 1, 1)
    for part, channels, hidden in (("sac.cbam1", width, width // 16), ("sac.cbam2", SLOTS, SLOTS)):
        found |= _layer(f"{part}.ChannelGate.mlp.1", hidden, channels)
        found |= _layer(f"{part}.ChannelGate.mlp.3", channels, hidden)
        found[f"{part}.SpatialGate.spatial.conv.weight"] = (1, 2, 7, 7)
    for layer, size, read in ((0, 512, 64), (2, 512, 512), (4, text, 512)):
        found |= _layer(f"pos_net.linears_position.{layer}", size, read)
    return found


def _layer(name: str, out: int, *rest: int) -> dict[str, tuple[int, ...]]:
    return {f"{name}.weight": (out, *rest), f"{name}.bias": (out,)}


def _check(processor: str, layer: Mapping[str, Any]) -> None:
    """Raises SceneError("weights") where a layer lacks a tensor, or has one of another shape or name."""
    if not {"norm.weight", "ea.to_k.weight"} <= layer.keys() or layer["ea.to_k.weight"].ndim != 2:
        raise SceneError("weights", f"MIGC's weights lack parts of {processor}")
    wanted = shapes(len(layer["norm.weight"]), layer["ea.to_k.weight"].shape[1])
    have = {name: tuple(tensor.shape) for name, tensor in layer.items()}
    if have != wanted:
        wrong = sorted(name for name in wanted.keys() | have.keys() if wanted.get(name) != have.get(name))
        raise SceneError("weights", f"MIGC's weights are not as expected in {processor}: {wrong[0]}")


def _read(file: Path) -> Mapping[str, Any]:
    if file.suffix == ".safetensors":
        found: Mapping[str, Any] = need("safetensors.torch", INSTALL).load_file(file)
        return found
    held = need("torch", INSTALL).load(file, map_location="cpu", weights_only=True)
    return held.get("state_dict", held) if isinstance(held, dict) else {}

"""Diffusion models by name: from a folder or file, from the hub's cache, or from the hub."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from scenelang.backends.base import need
from scenelang.backends.neural.clip import TextEncoder, empty_tower, text_weights, tower_model
from scenelang.backends.neural.diffusion import (
    VIEWS,
    Autoencoder,
    ClipWords,
    Diffusion,
    Pixels,
    Schedule,
    TransformerWords,
    Unshuffled,
    Words,
    quiet_libraries,
    schedule_of,
)
from scenelang.backends.neural.diffusion import memory_told as memory_told
from scenelang.backends.neural.mvdream import (
    FILE,
    ORIGINAL,
    REPOSITORY,
    Architecture,
    fitted,
    other_model,
    read_config,
    read_mvdream,
    read_tensors,
)
from scenelang.backends.neural.weights import INSTALL, Shelf
from scenelang.grammar.diagnostics import SceneError

MULTIVIEW = REPOSITORY
PICTURES = "stabilityai/stable-diffusion-2-1-base"
DEPTH = "thibaud/controlnet-sd21-depth-diffusers"
_FILES = (".safetensors", ".pt", ".ckpt")


@dataclass(frozen=True, slots=True)
class _Place:
    """A folder, or a repository of the hub by name; ``offline``: the hub is not asked. Weights are put on ``device``
    as ``dtype`` of torch, by default float32."""

    name: str
    offline: bool
    device: str
    dtype: Any

    def file(self, part: str) -> Path:
        """The file ``part``, whose path begins at the place."""
        if Path(self.name).is_dir():
            return Path(self.name) / part
        hub = need("huggingface_hub", INSTALL)
        return Path(hub.hf_hub_download(self.name, part, local_files_only=self.offline))

    def network(self, kind: Any, part: str | None) -> Any:
        """The network of the class ``kind`` in the folder ``part``; raises SceneError("weights") for another's."""
        inside = {} if part is None else {"subfolder": part}
        with quiet_libraries(bars=not Path(self.name).is_dir()):
            network, found = kind.from_pretrained(
                self.name,
                local_files_only=self.offline,
                output_loading_info=True,
                ignore_mismatched_sizes=True,  # told below, in one line
                torch_dtype=self._type(),
                **inside,
            )
        wrong = _first_wrong(found)
        if wrong is not None:
            raise other_model(f"`{part}` of {self.name}" if part else self.name, wrong)
        with memory_told():
            return network.to(self.device).eval().requires_grad_(False)

    def put(self, network: Any) -> Any:
        """The network, frozen, where and as what it computes."""
        with memory_told():
            return network.to(self.device, self._type()).eval().requires_grad_(False)

    def _type(self) -> Any:
        return self.dtype or need("torch", INSTALL).float32


def _first_wrong(found: Mapping[str, Any]) -> str | None:
    """What the libraries report of weights that are not the network's, in words."""
    for said, keys in (("is missing", found["missing_keys"]), ("does not belong there", found["unexpected_keys"])):
        if keys:
            return f"`{min(keys)}` {said}"
    if found["mismatched_keys"]:
        return f"`{min(key for key, *_ in found['mismatched_keys'])}` has another shape"
    return " ".join(str(found["error_msgs"][0]).split())[:160] if found["error_msgs"] else None


# --- by name ---------------------------------------------------------------------------------------------------------


def load_multiview(
    name: str = MULTIVIEW,
    shelf: Shelf | None = None,
    device: str = "cpu",
    dtype: Any = None,
    architecture: Architecture = ORIGINAL,
) -> Diffusion:
    """The multi-view model ``name``; ``dtype`` and errors as in ``load_any``, "weights" for one of single pictures."""
    found = load_any(name, shelf, device, dtype, architecture)
    if found.views == 1:
        raise SceneError("weights", f"the model `{name}` denoises single pictures, not several views together")
    return found


def load_any(
    name: str = MULTIVIEW,
    shelf: Shelf | None = None,
    device: str = "cpu",
    dtype: Any = None,
    architecture: Architecture = ORIGINAL,
) -> Diffusion:
    """The model ``name``, of several views or of single pictures: MVDream's repository, one of diffusers' layout, a
    folder that ``load_diffusion`` reads, or a checkpoint.

    ``dtype`` of torch is that of the weights, by default float32. Raises SceneError: "weights" where these are not to
    be had, or are of another model; "backend" without the packages; "unsupported" where the GPU is too small.
    """
    own = Path(name).expanduser()
    if own.is_file():
        return load_diffusion(own, device, dtype, architecture)
    found = (shelf or Shelf()).load(
        name,
        lambda folder: _in_folder(folder, device, dtype, architecture),
        partial(_of_hub, device, dtype, architecture),
    )
    return replace(found, name=name)


def load_depth(
    name: str = PICTURES,
    control: str | None = None,
    shelf: Shelf | None = None,
    device: str = "cpu",
    dtype: Any = None,
) -> Diffusion:
    """The model of single pictures ``name`` with the ControlNet ``control``, which keeps pictures to a depth map.

    By default the control is that in the model's own folder, else DEPTH. ``dtype`` and errors: as ``load_any``;
    also where model and control do not belong together.
    """
    shelf = shelf or Shelf()
    own = Path(name).expanduser()
    found = (
        load_diffusion(own, device, dtype)
        if own.is_file()
        else shelf.load(
            name,
            lambda folder: _in_folder(folder, device, dtype, ORIGINAL),
            lambda repository, offline: _assembled(_Place(repository, offline, device, dtype)),
        )
    )
    if control is None and found.control is not None:
        return replace(found, name=name)
    wanted = control or DEPTH
    network = shelf.load(
        wanted,
        lambda folder: _control(_Place(str(folder), True, device, dtype), None),
        lambda repository, offline: _control(_Place(repository, offline, device, dtype), None),
    )
    _check_control(wanted, found.network, network)
    return replace(found, name=name, control=network)


def load_diffusion(
    path: Path, device: str = "cpu", dtype: Any = None, architecture: Architecture = ORIGINAL
) -> Diffusion:
    """The model at ``path``: a folder with ``unet``, ``scheduler``, ``vae`` (none: the network denoises pixels),
    ``text`` of OpenCLIP or ``text_encoder`` and ``tokenizer`` of transformers, and ``controlnet`` where there is one;
    or a checkpoint of MVDream with the networks of ``architecture``, alone or in a folder.

    A network with cameras for classes denoises VIEWS pictures together. ``dtype`` and errors: as ``load_any``.
    """
    path = path.expanduser()
    if path.is_file():
        return _of_file(path, device, dtype, architecture)
    if not path.is_dir():
        raise SceneError("weights", f"no diffusion model at {path}")
    return Shelf(fetch=False).load(
        str(path),
        lambda folder: _in_folder(folder, device, dtype, architecture),
        lambda repository, offline: _assembled(_Place(repository, offline, device, dtype)),
    )


# --- what is there ---------------------------------------------------------------------------------------------------


def _of_hub(device: str, dtype: Any, architecture: Architecture, name: str, offline: bool) -> Diffusion:
    """The checkpoint of MVDream's repository; of any other, the folders of diffusers."""
    place = _Place(name, offline, device, dtype)
    if name == REPOSITORY:
        return _of_file(place.file(FILE), device, dtype, architecture)
    return _assembled(place)


def _in_folder(folder: Path, device: str, dtype: Any, architecture: Architecture) -> Diffusion:
    if not (folder / "unet").is_dir():
        files = sorted(path for path in folder.iterdir() if path.suffix.lower() in _FILES)
        file = next((path for path in files if path.name == FILE), files[0] if files else None)
        if file is None:
            raise other_model(str(folder), f"it has neither a folder `unet` nor a file `{FILE}`")
        return _of_file(file, device, dtype, architecture)
    return _assembled(_Place(str(folder), True, device, dtype))


def _of_file(path: Path, device: str, dtype: Any, architecture: Architecture) -> Diffusion:
    place = _Place(str(path), True, device, dtype)
    networks = read_mvdream(path, architecture)
    unet, pixels = place.put(networks.unet), Autoencoder(place.put(networks.vae))
    words = ClipWords(TextEncoder(tower_model(path.name, place.put(networks.text))))
    schedule = schedule_of(architecture.scheduler)
    return Diffusion(str(path), unet, schedule, pixels, words, unet.config.sample_size * pixels.factor, VIEWS)


def _assembled(place: _Place) -> Diffusion:
    """The model whose parts stand in folders of their own."""
    unet = place.network(need("diffusers", INSTALL).UNet2DConditionModel, "unet")
    views = _views(place.name, unet.config)
    pixels, words = _pixels(place, unet.config), _words(place)
    if words.width != unet.config.cross_attention_dim:
        message = f"it listens to states of {unet.config.cross_attention_dim}, its text encoder's have {words.width}"
        raise other_model(place.name, message)
    control = None
    if (Path(place.name) / "controlnet").is_dir():
        control = _control(place, "controlnet")
        _check_control(place.name, unet, control)
    size = unet.config.sample_size * pixels.factor
    return Diffusion(place.name, unet, _schedule(place), pixels, words, size, views, control)


def _views(name: str, config: Any) -> int:
    kind = config.class_embed_type
    cameras = kind == "projection" and config.projection_class_embeddings_input_dim == 16
    if config.addition_embed_type is not None or config.num_class_embeds is not None or (kind and not cameras):
        raise other_model(name, "its `unet` expects conditions other than cameras")
    if type(config.sample_size) is not int:
        raise other_model(name, "its `unet` says no size of pictures")
    return VIEWS if cameras else 1


def _pixels(place: _Place, config: Any) -> Pixels:
    if not Path(place.name).is_dir() or (Path(place.name) / "vae").is_dir():
        return Autoencoder(place.network(need("diffusers", INSTALL).AutoencoderKL, "vae"))
    factor = math.isqrt(config.in_channels // 3)
    if 3 * factor * factor != config.in_channels:
        raise other_model(
            place.name, f"it has no `vae`, and {config.in_channels} channels are not a square number of pixels"
        )
    return Unshuffled(factor)


def _words(place: _Place) -> Words:
    folder = Path(place.name) / "text"
    if folder.is_dir():
        return _clip_words(place, folder)
    transformers = need("transformers", INSTALL)
    tokenizer = transformers.CLIPTokenizer.from_pretrained(
        place.name, subfolder="tokenizer", local_files_only=place.offline
    )
    return TransformerWords(place.network(transformers.CLIPTextModel, "text_encoder"), tokenizer)


def _clip_words(place: _Place, folder: Path) -> Words:
    config = read_config(folder / "open_clip_config.json").get("model_cfg")
    tower = empty_tower(config if isinstance(config, dict) else {})
    tensors = text_weights(read_tensors(folder / "open_clip_model.safetensors"))
    tower = fitted(str(folder), tower, tensors)
    return ClipWords(TextEncoder(tower_model(str(folder), place.put(tower))))


def _schedule(place: _Place) -> Schedule:
    return schedule_of(read_config(place.file("scheduler/scheduler_config.json")))


def _control(place: _Place, part: str | None) -> Any:
    return place.network(need("diffusers", INSTALL).ControlNetModel, part)


def _check_control(name: str, network: Any, control: Any) -> None:
    for setting in ("in_channels", "cross_attention_dim", "block_out_channels", "layers_per_block"):
        own, other = (_plain(config[setting]) for config in (network.config, control.config))
        if own != other:
            raise other_model(name, f"its control has {setting} {other}, the model {own}")


def _plain(value: Any) -> Any:
    """Settings that were read have lists where those of a network made here have tuples."""
    return list(value) if isinstance(value, tuple) else value

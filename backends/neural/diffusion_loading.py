"""Loading diffusion models by name: from a folder or file, the hub's cache, or the hub."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from scenelang.backends.base import require
from scenelang.backends.neural.clip import TextEncoder, build_text_tower, text_only_model, text_weights
from scenelang.backends.neural.diffusion import (
    VIEWS,
    Autoencoder,
    ClipPromptEncoder,
    DiffusionModel,
    LatentCodec,
    NoiseSchedule,
    PixelUnshuffle,
    PromptEncoder,
    TransformersPromptEncoder,
    schedule_of,
    silence_libraries,
)
from scenelang.backends.neural.diffusion import translate_out_of_memory as translate_out_of_memory
from scenelang.backends.neural.mvdream import (
    FILE,
    ORIGINAL,
    REPOSITORY,
    Architecture,
    load_weights,
    read_config,
    read_mvdream,
    read_tensors,
    weights_mismatch,
)
from scenelang.backends.neural.weights import INSTALL, ModelHub
from scenelang.grammar.diagnostics import SceneError

MULTIVIEW_MODEL = REPOSITORY
SINGLE_VIEW_MODEL = "stabilityai/stable-diffusion-2-1-base"
DEPTH_CONTROLNET = "thibaud/controlnet-sd21-depth-diffusers"
_CHECKPOINT_SUFFIXES = (".safetensors", ".pt", ".ckpt")


@dataclass(frozen=True, slots=True)
class _Location:
    """Location of a model: a folder, or the name of a repository on the hub.

    ``offline`` disables downloads. Weights are loaded to ``device`` as ``dtype`` of torch, by default float32.
    """

    name: str
    offline: bool
    device: str
    dtype: Any

    def file(self, part: str) -> Path:
        """Return the local path of the file ``part``, which is relative to the location."""
        if Path(self.name).is_dir():
            return Path(self.name) / part
        huggingface_hub = require("huggingface_hub", INSTALL)
        return Path(huggingface_hub.hf_hub_download(self.name, part, local_files_only=self.offline))

    def network(self, cls: Any, part: str | None) -> Any:
        """Load the network of class ``cls`` from the subfolder ``part``; raises SceneError("weights")."""
        subfolder = {} if part is None else {"subfolder": part}
        with silence_libraries(progress_bars=not Path(self.name).is_dir()):
            network, info = cls.from_pretrained(
                self.name,
                local_files_only=self.offline,
                output_loading_info=True,
                ignore_mismatched_sizes=True,  # reported below in one line
                torch_dtype=self._dtype(),
                **subfolder,
            )
        mismatch = _first_mismatch(info)  # diffusers itself only warns, and initializes missing weights randomly
        if mismatch is not None:
            raise weights_mismatch(f"`{part}` of {self.name}" if part else self.name, mismatch)
        with translate_out_of_memory():
            return network.to(self.device).eval().requires_grad_(False)

    def to_device(self, network: Any) -> Any:
        """Move the network to the device and dtype, frozen."""
        with translate_out_of_memory():
            return network.to(self.device, self._dtype()).eval().requires_grad_(False)

    def _dtype(self) -> Any:
        return self.dtype or require("torch", INSTALL).float32


def _first_mismatch(info: Mapping[str, Any]) -> str | None:
    """Describe the first mismatch in the loading info of ``from_pretrained``; None if all weights match."""
    for kind, keys in (("missing", info["missing_keys"]), ("unexpected", info["unexpected_keys"])):
        if keys:
            return f"{kind} key `{min(keys)}`"
    if info["mismatched_keys"]:
        return f"shape mismatch of `{min(key for key, *_ in info['mismatched_keys'])}`"
    return " ".join(str(info["error_msgs"][0]).split())[:160] if info["error_msgs"] else None


# --- loading by name -------------------------------------------------------------------------------------------------


def load_multiview(
    name: str = MULTIVIEW_MODEL,
    hub: ModelHub | None = None,
    device: str = "cpu",
    dtype: Any = None,
    architecture: Architecture = ORIGINAL,
) -> DiffusionModel:
    """Load the multi-view model ``name``; arguments and errors are those of ``load_any``.

    Also raises SceneError("weights") for a model without camera conditioning.
    """
    model = load_any(name, hub, device, dtype, architecture)
    if model.views == 1:
        raise SceneError("weights", f"`{name}` is not a multi-view model: it denoises single images")
    return model


def load_any(
    name: str = MULTIVIEW_MODEL,
    hub: ModelHub | None = None,
    device: str = "cpu",
    dtype: Any = None,
    architecture: Architecture = ORIGINAL,
) -> DiffusionModel:
    """Load the multi-view or single-view model ``name``.

    Parameters
    ----------
    name : str
        MVDream's repository, a repository in the layout of diffusers, a folder for ``load_diffusion``, or a checkpoint.
    hub : ModelHub, optional
        Source of the weights.
    device : str
        Device of the weights.
    dtype : torch.dtype, optional
        Type of the weights; default float32.
    architecture : Architecture
        Configuration of the networks in a checkpoint.

    Raises
    ------
    SceneError
        "weights" if they are unavailable or belong to another model, "backend" without the packages, "unsupported" if
        the GPU runs out of memory.
    """
    own = Path(name).expanduser()
    if own.is_file():
        return load_diffusion(own, device, dtype, architecture)
    model = (hub or ModelHub()).load(
        name,
        lambda folder: _from_folder(folder, device, dtype, architecture),
        lambda repository, offline: _from_hub(device, dtype, architecture, repository, offline=offline),
    )
    return replace(model, name=name)


def load_depth(
    name: str = SINGLE_VIEW_MODEL,
    control: str | None = None,
    hub: ModelHub | None = None,
    device: str = "cpu",
    dtype: Any = None,
) -> DiffusionModel:
    """Load the single-view model ``name`` with the depth ControlNet ``control``.

    The default ControlNet is that in the model's folder, otherwise DEPTH_CONTROLNET. The other arguments and the errors
    are those of ``load_any``; also raises SceneError("weights") if the ControlNet does not fit the model.
    """
    hub = hub or ModelHub()
    own = Path(name).expanduser()
    model = (
        load_diffusion(own, device, dtype)
        if own.is_file()
        else hub.load(
            name,
            lambda folder: _from_folder(folder, device, dtype, ORIGINAL),
            lambda repository, offline: _from_parts(_Location(repository, offline, device, dtype)),
        )
    )
    if control is None and model.control is not None:
        return replace(model, name=name)
    control_name = control or DEPTH_CONTROLNET
    network = hub.load(
        control_name,
        lambda folder: _control(_Location(str(folder), True, device, dtype), None),
        lambda repository, offline: _control(_Location(repository, offline, device, dtype), None),
    )
    _check_control(control_name, model.network, network)
    return replace(model, name=name, control=network)


def load_diffusion(
    path: Path, device: str = "cpu", dtype: Any = None, architecture: Architecture = ORIGINAL
) -> DiffusionModel:
    """Load the model at ``path``: a folder with one subfolder per component, or a checkpoint of MVDream.

    The subfolders are ``unet``, ``scheduler``, ``vae`` (without it, the network denoises pixels), ``text`` of OpenCLIP
    or ``text_encoder`` and ``tokenizer`` of transformers, and optionally ``controlnet``. A checkpoint, with the
    networks of ``architecture``, may also be in a folder. A network with camera conditioning denoises VIEWS images
    jointly. The other arguments and the errors are those of ``load_any``.
    """
    path = path.expanduser()
    if path.is_file():
        return _from_file(path, device, dtype, architecture)
    if not path.is_dir():
        raise SceneError("weights", f"no diffusion model at {path}")
    return ModelHub(download=False).load(
        str(path),
        lambda folder: _from_folder(folder, device, dtype, architecture),
        lambda repository, offline: _from_parts(_Location(repository, offline, device, dtype)),
    )


# --- checkpoints and components --------------------------------------------------------------------------------------


def _from_hub(device: str, dtype: Any, architecture: Architecture, name: str, *, offline: bool) -> DiffusionModel:
    """Load MVDream's checkpoint from its repository; from any other repository, the components."""
    location = _Location(name, offline, device, dtype)
    if name == REPOSITORY:
        return _from_file(location.file(FILE), device, dtype, architecture)
    return _from_parts(location)


def _from_folder(folder: Path, device: str, dtype: Any, architecture: Architecture) -> DiffusionModel:
    if not (folder / "unet").is_dir():
        files = sorted(path for path in folder.iterdir() if path.suffix.lower() in _CHECKPOINT_SUFFIXES)
        file = next((path for path in files if path.name == FILE), files[0] if files else None)
        if file is None:
            raise weights_mismatch(str(folder), f"expected a folder `unet` or a file `{FILE}`")
        return _from_file(file, device, dtype, architecture)
    return _from_parts(_Location(str(folder), True, device, dtype))


def _from_file(path: Path, device: str, dtype: Any, architecture: Architecture) -> DiffusionModel:
    location = _Location(str(path), True, device, dtype)
    networks = read_mvdream(path, architecture)
    unet, codec = location.to_device(networks.unet), Autoencoder(location.to_device(networks.vae))
    text_encoder = ClipPromptEncoder(TextEncoder(text_only_model(path.name, location.to_device(networks.text))))
    schedule = schedule_of(architecture.scheduler)
    size = unet.config.sample_size * codec.factor
    return DiffusionModel(str(path), unet, schedule, codec, text_encoder, size, VIEWS)


def _from_parts(location: _Location) -> DiffusionModel:
    """Load a model whose components are in separate folders."""
    unet = location.network(require("diffusers", INSTALL).UNet2DConditionModel, "unet")
    views = _views(location.name, unet.config)
    codec, text_encoder = _codec(location, unet.config), _prompt_encoder(location)
    if text_encoder.width != unet.config.cross_attention_dim:
        expected, width = unet.config.cross_attention_dim, text_encoder.width
        raise weights_mismatch(location.name, f"the UNet expects text states of width {expected}, got {width}")
    control = None
    if (Path(location.name) / "controlnet").is_dir():
        control = _control(location, "controlnet")
        _check_control(location.name, unet, control)
    size = unet.config.sample_size * codec.factor
    return DiffusionModel(location.name, unet, _schedule(location), codec, text_encoder, size, views, control)


def _views(name: str, config: Any) -> int:
    kind = config.class_embed_type
    cameras = kind == "projection" and config.projection_class_embeddings_input_dim == 16
    if config.addition_embed_type is not None or config.num_class_embeds is not None or (kind and not cameras):
        raise weights_mismatch(name, "its `unet` requires conditions other than cameras")
    if type(config.sample_size) is not int:
        raise weights_mismatch(name, "the configuration of its `unet` has no `sample_size`")
    return VIEWS if cameras else 1


def _codec(location: _Location, config: Any) -> LatentCodec:
    if not Path(location.name).is_dir() or (Path(location.name) / "vae").is_dir():
        return Autoencoder(location.network(require("diffusers", INSTALL).AutoencoderKL, "vae"))
    factor = math.isqrt(config.in_channels // 3)
    if 3 * factor * factor != config.in_channels:
        message = f"without a `vae`, the UNet must have 3 n^2 input channels, not {config.in_channels}"
        raise weights_mismatch(location.name, message)
    return PixelUnshuffle(factor)


def _prompt_encoder(location: _Location) -> PromptEncoder:
    folder = Path(location.name) / "text"
    if folder.is_dir():
        return _clip_prompt_encoder(location, folder)
    transformers = require("transformers", INSTALL)
    tokenizer = transformers.CLIPTokenizer.from_pretrained(
        location.name, subfolder="tokenizer", local_files_only=location.offline
    )
    return TransformersPromptEncoder(location.network(transformers.CLIPTextModel, "text_encoder"), tokenizer)


def _clip_prompt_encoder(location: _Location, folder: Path) -> PromptEncoder:
    config = read_config(folder / "open_clip_config.json").get("model_cfg")
    tower = build_text_tower(config if isinstance(config, dict) else {})
    tensors = text_weights(read_tensors(folder / "open_clip_model.safetensors"))
    tower = load_weights(str(folder), tower, tensors)
    return ClipPromptEncoder(TextEncoder(text_only_model(str(folder), location.to_device(tower))))


def _schedule(location: _Location) -> NoiseSchedule:
    return schedule_of(read_config(location.file("scheduler/scheduler_config.json")))


def _control(location: _Location, part: str | None) -> Any:
    return location.network(require("diffusers", INSTALL).ControlNetModel, part)


def _check_control(name: str, network: Any, control: Any) -> None:
    for setting in ("in_channels", "cross_attention_dim", "block_out_channels", "layers_per_block"):
        own, other = (_as_list(config[setting]) for config in (network.config, control.config))
        if own != other:
            raise weights_mismatch(name, f"the ControlNet has {setting} {other}, the model {own}")


def _as_list(value: Any) -> Any:
    """Return tuples as lists: settings read from JSON have lists where those of networks built here have tuples."""
    return list(value) if isinstance(value, tuple) else value

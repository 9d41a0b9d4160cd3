"""The toy diffusion model as files: built with random weights, packed into one small file, unpacked again."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from later import later

from toy.pictures import SIZE

open_clip, torch = later("open_clip"), later("torch")
files = later("safetensors.torch")

WEIGHTS = Path(__file__).parent / "weights.safetensors"  # over backgrounds of all greys, as distillation has them
ONE_GREY = Path(__file__).parent / "weights_grey.safetensors"  # over one grey, as the pictures of an inversion have
WIDTH, CONTEXT = 64, 32
_UNET = {
    "sample_size": SIZE // 2,
    "in_channels": 12,
    "out_channels": 12,
    "block_out_channels": [48, 96],
    "layers_per_block": 1,
    "down_block_types": ["DownBlock2D", "CrossAttnDownBlock2D"],
    "up_block_types": ["CrossAttnUpBlock2D", "UpBlock2D"],
    "cross_attention_dim": WIDTH,
    "attention_head_dim": 4,
    "norm_num_groups": 8,
    "class_embed_type": "projection",
    "projection_class_embeddings_input_dim": 16,
    "use_linear_projection": True,
}
_CLIP = {
    "embed_dim": 32,
    "vision_cfg": {"image_size": 32, "layers": 1, "width": 16, "head_width": 16, "patch_size": 16},
    "text_cfg": {"context_length": CONTEXT, "vocab_size": 49408, "width": WIDTH, "heads": 4, "layers": 3},
}
_SCHEDULER = {
    "_class_name": "DDIMScheduler",
    "num_train_timesteps": 1000,
    "beta_start": 0.00085,
    "beta_end": 0.012,
    "beta_schedule": "scaled_linear",
    "prediction_type": "v_prediction",
}
_TOKENS = "text/token_embedding.weight"  # only the rows of words that were learned are kept


def build(folder: Path, seed: int = 0) -> Path:
    """The toy with random weights in ``folder``: `unet`, `scheduler`, `text`."""
    from diffusers import UNet2DConditionModel

    torch.manual_seed(seed)
    UNet2DConditionModel(**_UNET).save_pretrained(folder / "unet")
    clip = open_clip.model.CLIP(**_clip_config())
    torch.nn.init.normal_(clip.token_embedding.weight, std=0.3)  # OpenCLIP's own start is too small to learn from fast
    save_clip(folder / "text", clip)
    (folder / "scheduler").mkdir()
    (folder / "scheduler" / "scheduler_config.json").write_text(json.dumps(_SCHEDULER))
    return folder


def save_clip(folder: Path, network: Any) -> None:
    """A CLIP as OpenCLIP writes it."""
    folder.mkdir(parents=True, exist_ok=True)
    preprocess = {"mean": [0.5] * 3, "std": [0.5] * 3, "interpolation": "bicubic"}
    (folder / "open_clip_config.json").write_text(json.dumps({"model_cfg": _CLIP, "preprocess_cfg": preprocess}))
    tensors = {name: tensor.contiguous() for name, tensor in network.state_dict().items()}
    files.save_file(tensors, folder / "open_clip_model.safetensors")


def pack(folder: Path, file: Path, tokens: list[int], told: dict[str, str]) -> None:
    """The weights in ``folder`` as half-precision numbers in one file; of the token vectors those of ``tokens``."""
    kept = {}
    for name, path in _parts(folder).items():
        for key, tensor in files.load_file(path).items():
            kept[f"{name}/{key}"] = tensor.half() if tensor.is_floating_point() else tensor
    kept[_TOKENS] = kept[_TOKENS][tokens].contiguous()
    kept["tokens"] = torch.tensor(tokens, dtype=torch.int32)
    files.save_file(kept, file, metadata=told)


def unpack(folder: Path, file: Path = WEIGHTS) -> Path:
    """The layout that ``load_diffusion`` reads, from a packed file."""
    build(folder)
    packed = files.load_file(file)
    for name, path in _parts(folder).items():
        whole = files.load_file(path)
        for key in whole:
            found = packed[f"{name}/{key}"]
            if f"{name}/{key}" == _TOKENS:
                whole[key].zero_()
                whole[key][packed["tokens"].long()] = found.float()
            else:
                whole[key] = found.to(whole[key].dtype)
        files.save_file(whole, path, metadata={"format": "pt"})
    return folder


def _parts(folder: Path) -> dict[str, Path]:
    return {
        "unet": folder / "unet" / "diffusion_pytorch_model.safetensors",
        "text": folder / "text" / "open_clip_model.safetensors",
    }


def _clip_config() -> dict[str, Any]:
    return {
        "embed_dim": _CLIP["embed_dim"],
        "vision_cfg": open_clip.model.CLIPVisionCfg(**_CLIP["vision_cfg"]),
        "text_cfg": open_clip.model.CLIPTextCfg(**_CLIP["text_cfg"]),
    }

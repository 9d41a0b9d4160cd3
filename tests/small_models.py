"""Small neural models with random weights, built and saved as the large ones are distributed."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any


def seeded(seed: int = 0) -> Any:
    """torch with one thread and a seed: two threads on busy cores are far slower than one."""
    import torch

    torch.set_num_threads(1)
    torch.manual_seed(seed)
    return torch


def small_clip(folder: Path, width: int = 32, layers: int = 3, dim: int = 16, seed: int = 0) -> Path:
    """A CLIP in OpenCLIP's own form: ``folder`` with ``open_clip_config.json`` and the weights."""
    import open_clip
    from safetensors.torch import save_file

    torch = seeded(seed)
    config = {
        "embed_dim": dim,
        "vision_cfg": {"image_size": 32, "layers": 2, "width": width, "head_width": 16, "patch_size": 8},
        "text_cfg": {"context_length": 77, "vocab_size": 49408, "width": width, "heads": 2, "layers": layers},
    }
    name = f"small-{folder.name}"
    open_clip.add_model_config(_saved(folder, name, config))
    model = open_clip.create_model(name)
    with torch.no_grad():  # positions begin too small to matter
        for parameter in model.parameters():
            if parameter.ndim > 1:
                torch.nn.init.normal_(parameter, std=0.15)
    save_file(
        {key: value.contiguous() for key, value in model.state_dict().items()}, folder / "open_clip_model.safetensors"
    )
    preprocess = {"mean": [0.48, 0.46, 0.41], "std": [0.27, 0.26, 0.28], "interpolation": "bicubic"}
    (folder / "open_clip_config.json").write_text(json.dumps({"model_cfg": config, "preprocess_cfg": preprocess}))
    return folder


def _saved(folder: Path, name: str, config: dict[str, Any]) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.json"
    path.write_text(json.dumps(config))
    return path


# --- diffusion -------------------------------------------------------------------------------------------------------

SMALL_UNET = {
    "sample_size": 8, "in_channels": 4, "out_channels": 4, "block_out_channels": (32, 64), "layers_per_block": 1,
    "down_block_types": ("CrossAttnDownBlock2D", "DownBlock2D"), "up_block_types": ("UpBlock2D", "CrossAttnUpBlock2D"),
    "attention_head_dim": (2, 4), "cross_attention_dim": 32, "use_linear_projection": True,
}  # fmt: skip
CAMERAS = {"class_embed_type": "projection", "projection_class_embeddings_input_dim": 16}
SMALL_VAE = {
    "sample_size": 32, "in_channels": 3, "out_channels": 3, "latent_channels": 4, "block_out_channels": (32, 32, 32),
    "layers_per_block": 1, "down_block_types": ("DownEncoderBlock2D",) * 3, "up_block_types": ("UpDecoderBlock2D",) * 3,
    "scaling_factor": 0.18215,
}  # fmt: skip
SMALL_SCHEDULER = {"_class_name": "DDPMScheduler", "num_train_timesteps": 1000, "beta_schedule": "scaled_linear",
                   "beta_start": 0.00085, "beta_end": 0.012, "prediction_type": "epsilon"}  # fmt: skip


def small_unet(views: bool = True, **settings: Any) -> Any:
    """A UNet2DConditionModel, with cameras for classes where it is one of several views. No layer begins at zero."""
    from diffusers import UNet2DConditionModel

    return _shaken(UNet2DConditionModel(**{**SMALL_UNET, **(CAMERAS if views else {}), **settings}))


def small_vae(**settings: Any) -> Any:
    """An AutoencoderKL of factor 4."""
    from diffusers import AutoencoderKL

    return _shaken(AutoencoderKL(**{**SMALL_VAE, **settings}))


def small_control(unet: Any) -> Any:
    """A ControlNetModel for ``unet`` that adds nothing yet, with a hint four times as large as the latents."""
    from diffusers import ControlNetModel

    return ControlNetModel.from_unet(unet, conditioning_embedding_out_channels=(8, 8, 16)).eval()


def small_text(width: int = 32, layers: int = 2, **settings: Any) -> Any:
    """A CLIPTextModel of transformers."""
    from transformers import CLIPTextConfig, CLIPTextModel

    config = CLIPTextConfig(
        vocab_size=49408, hidden_size=width, intermediate_size=4 * width, num_hidden_layers=layers, num_attention_heads=2,
        max_position_embeddings=77, hidden_act="gelu", bos_token_id=49406, eos_token_id=49407, pad_token_id=0, **settings,
    )  # fmt: skip
    return CLIPTextModel(config).eval()


def clip_tokenizer() -> Any:
    """The CLIPTokenizer of transformers with the table that OpenCLIP carries."""
    from open_clip import SimpleTokenizer
    from transformers import CLIPTokenizer

    table = SimpleTokenizer()
    names = {"<start_of_text>": "<|startoftext|>", "<end_of_text>": "<|endoftext|>"}
    vocabulary = {names.get(token, token): number for token, number in table.encoder.items()}
    return CLIPTokenizer(vocab=vocabulary, merges=list(table.bpe_ranks), pad_token="!")


def small_diffusion(folder: Path, views: bool = True, pixels: bool = False, control: bool = False, **unet: Any) -> Path:
    """A diffusion model in the local layout; ``pixels``: without an autoencoder, on squares of 2 x 2 pixels."""
    settings = {"in_channels": 12, "out_channels": 12, "sample_size": 16} if pixels else {}
    network = small_unet(views, **{**settings, **unet})
    network.save_pretrained(folder / "unet")
    if not pixels:
        small_vae().save_pretrained(folder / "vae")
    if control:
        small_control(network).save_pretrained(folder / "controlnet")
    small_text().save_pretrained(folder / "text_encoder")
    clip_tokenizer().save_pretrained(folder / "tokenizer")
    (folder / "scheduler").mkdir()
    (folder / "scheduler" / "scheduler_config.json").write_text(json.dumps(SMALL_SCHEDULER))
    return folder


def _shaken(network: Any) -> Any:
    import torch

    with torch.no_grad():
        for parameter in network.parameters():
            parameter.add_(torch.randn_like(parameter) * 0.05)
    return network.eval()

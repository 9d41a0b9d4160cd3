"""A small Stable Diffusion with random weights in diffusers' folder layout, and what goes with it."""

from __future__ import annotations

import gzip
from pathlib import Path
from typing import Any

from small_models import seeded

WIDTH = 32  # of the text encoder's tokens, and of the model's levels


def small_diffusion(folder: Path, gated: bool = False, seed: int = 0) -> Path:
    """A checkpoint of pictures of 64 x 64 pixels; ``gated``: with GLIGEN's layers, whose gates are closed."""
    import diffusers

    torch = seeded(seed)
    pipeline = diffusers.StableDiffusionPipeline(
        vae=_vae(diffusers),
        text_encoder=_text_encoder(torch),
        tokenizer=_tokenizer(),
        unet=_unet(torch, diffusers, gated),
        scheduler=diffusers.DDIMScheduler(steps_offset=1, clip_sample=False, set_alpha_to_one=False),
        safety_checker=None,
        feature_extractor=None,
        requires_safety_checker=False,
    )
    pipeline.save_pretrained(folder)
    return folder


def small_control(folder: Path, checkpoint: Path, seed: int = 1) -> Path:
    """A ControlNet for the checkpoint, its last layers zero as before training."""
    import diffusers

    seeded(seed)
    unet = diffusers.UNet2DConditionModel.from_pretrained(checkpoint / "unet")
    network = diffusers.ControlNetModel.from_unet(unet, conditioning_embedding_out_channels=(4, 4, 8, 8))
    network.save_pretrained(folder)
    return folder


def _unet(torch: Any, diffusers: Any, gated: bool) -> Any:
    unet = diffusers.UNet2DConditionModel(
        sample_size=8,
        in_channels=4,
        out_channels=4,
        block_out_channels=(WIDTH, WIDTH),
        layers_per_block=1,
        down_block_types=("CrossAttnDownBlock2D", "DownBlock2D"),
        up_block_types=("UpBlock2D", "CrossAttnUpBlock2D"),
        cross_attention_dim=WIDTH,
        attention_head_dim=4,
        norm_num_groups=8,
        attention_type="gated" if gated else "default",
    )
    with torch.no_grad():  # so that words matter before any training
        for name, parameter in unet.named_parameters():
            if ".attn2." in name and parameter.ndim == 2:
                torch.nn.init.normal_(parameter, std=0.35)
    return unet


def _vae(diffusers: Any) -> Any:
    return diffusers.AutoencoderKL(
        block_out_channels=(8, 8, 8, 8),
        down_block_types=("DownEncoderBlock2D",) * 4,
        up_block_types=("UpDecoderBlock2D",) * 4,
        layers_per_block=1,
        norm_num_groups=4,
        latent_channels=4,
        sample_size=64,
    )


def _text_encoder(torch: Any) -> Any:
    from transformers import CLIPTextConfig, CLIPTextModel

    model = CLIPTextModel(
        CLIPTextConfig(
            vocab_size=49408,
            hidden_size=WIDTH,
            intermediate_size=64,
            num_hidden_layers=2,
            num_attention_heads=2,
            hidden_act="gelu",
            bos_token_id=49406,
            eos_token_id=49407,
        )
    )
    with torch.no_grad():
        for parameter in model.parameters():
            if parameter.ndim > 1:
                torch.nn.init.normal_(parameter, std=0.3)
    return model


def _tokenizer() -> Any:
    """CLIP's tokenizer from the table that open_clip brings; its special tokens have other names there."""
    from open_clip.tokenizer import SimpleTokenizer, default_bpe
    from transformers import CLIPTokenizer

    names = {"<start_of_text>": "<|startoftext|>", "<end_of_text>": "<|endoftext|>"}
    vocab = {names.get(token, token): number for token, number in SimpleTokenizer().encoder.items()}
    with gzip.open(default_bpe(), "rt", encoding="utf-8") as file:
        lines = file.read().split("\n")
    merges = [tuple(line.split()) for line in lines[1 : 49152 - 256 - 2 + 1]]
    return CLIPTokenizer(vocab=vocab, merges=merges, model_max_length=77, pad_token="!")

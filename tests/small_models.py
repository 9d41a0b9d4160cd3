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

"""MVDream's checkpoint: its names, round trips, and files that are none."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import pytest
from small_models import CAMERAS, SMALL_SCHEDULER, SMALL_UNET, SMALL_VAE, seeded, small_clip, small_unet, small_vae

from scenelang.backends.neural.clip import ClipName, TextEncoder, build_text_tower, load_clip, text_weights
from scenelang.backends.neural.diffusion import Autoencoder, fold_views
from scenelang.backends.neural.diffusion_loading import load_multiview
from scenelang.backends.neural.mvdream import (
    ORIGINAL,
    TEXT,
    UNET,
    VAE,
    Architecture,
    Networks,
    convert_mvdream,
    empty_networks,
    load_weights,
    mvdream_tensors,
    read_mvdream,
    text_names,
    vae_names,
)
from scenelang.grammar.diagnostics import SceneError

from .support import Evil, predicted, wrong

TEXT_CONFIG = {
    "embed_dim": 16,
    "text_cfg": {"context_length": 77, "vocab_size": 49408, "width": 32, "heads": 2, "layers": 3},
}
SMALL = Architecture({**SMALL_UNET, **CAMERAS}, SMALL_VAE, TEXT_CONFIG, SMALL_SCHEDULER)


@pytest.fixture(scope="module")
def checkpoint(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Networks]:
    """A file in the form of MVDream's, and the networks in it."""
    torch = seeded()
    place = tmp_path_factory.mktemp("mvdream")
    clip = load_clip(ClipName(str(small_clip(place / "clip"))))
    networks = Networks(small_unet(), small_vae(), clip.network)
    tensors = mvdream_tensors(Networks(networks.unet, networks.vae, _text_only(clip.network)))
    extra = {"betas": torch.zeros(1000), f"{TEXT}logit_scale": torch.ones(()), f"{TEXT}attn_mask": torch.zeros(77, 77)}
    torch.save({**tensors, **extra}, place / "small.pt")
    return place / "small.pt", networks


def _text_only(network: Any) -> Any:
    return load_weights("clip", build_text_tower(TEXT_CONFIG), text_weights(network.state_dict()))


def test_a_checkpoint_comes_back(checkpoint: tuple[Path, Networks]) -> None:
    torch = seeded()
    path, networks = checkpoint
    found = read_mvdream(path, SMALL)
    for one, other in ((found.unet, networks.unet), (found.vae, networks.vae)):
        assert all(torch.equal(tensor, other.state_dict()[key]) for key, tensor in one.state_dict().items())
    kept = torch.load(path, weights_only=True)
    again = mvdream_tensors(found)
    assert set(again) == {key for key in kept if key.startswith((UNET, VAE, TEXT))} - {
        f"{TEXT}logit_scale",
        f"{TEXT}attn_mask",
    }
    assert all(torch.equal(tensor, kept[key]) for key, tensor in again.items())
    assert again[f"{VAE}encoder.mid.attn_1.q.weight"].shape == (32, 32, 1, 1)


def test_a_checkpoint_works_as_its_networks_do(checkpoint: tuple[Path, Networks]) -> None:
    torch = seeded()
    path, networks = checkpoint
    found = load_multiview(str(path), architecture=SMALL)
    assert (found.views, found.size) == (4, 32)
    latents, cameras = torch.randn(4, 4, 8, 8), torch.randn(4, 16)
    clip = load_clip(ClipName(str(path.parent / "clip")))
    states = TextEncoder(clip).encode([("a red sphere",)] * 4).penultimate
    assert torch.equal(found.text_encoder.encode([("a red sphere",)] * 4), states)
    steps = torch.full((4,), 300)
    fold_views(networks.unet)
    with torch.no_grad():
        own = networks.unet(latents, steps, states, class_labels=cameras, cross_attention_kwargs={"views": 4}).sample
        assert torch.equal(found.predict(latents, steps, states, cameras), own)
        pictures = torch.rand(1, 3, 32, 32)
        assert torch.equal(found.codec.encode(pictures), Autoencoder(networks.vae).encode(pictures))


def test_a_checkpoint_as_a_folder(checkpoint: tuple[Path, Networks], tmp_path: Path) -> None:
    torch = seeded()
    path, _ = checkpoint
    convert_mvdream(path, tmp_path / "made", SMALL)
    one, other = load_multiview(str(path), architecture=SMALL), load_multiview(str(tmp_path / "made"))
    latents, cameras = torch.randn(4, 4, 8, 8), torch.randn(4, 16)
    assert torch.equal(predicted(one, latents, cameras), predicted(other, latents, cameras))
    assert torch.equal(one.schedule.alphas_cumprod, other.schedule.alphas_cumprod)
    with pytest.raises(SceneError, match=r"cannot write `.*made`"):
        convert_mvdream(path, tmp_path / "made", SMALL)
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["made"]


def test_safetensors_of_the_same(checkpoint: tuple[Path, Networks], tmp_path: Path) -> None:
    from safetensors.torch import save_file

    torch = seeded()
    tensors = torch.load(checkpoint[0], weights_only=True)
    save_file({key: tensor.contiguous().clone() for key, tensor in tensors.items()}, tmp_path / "small.safetensors")
    assert load_multiview(str(tmp_path), architecture=SMALL).views == 4


def test_the_full_size_names() -> None:
    """Of the autoencoder by a list of Stable Diffusion's own names, of the text encoder by OpenCLIP's."""
    seeded()
    networks = empty_networks(ORIGINAL)
    vae = networks.vae.state_dict()
    assert {VAE + key for key in stable_diffusion_vae()} == set(vae_names(vae).values())
    assert len(set(vae_names(vae).values())) == len(vae) == 248
    text = set(text_names(networks.text.state_dict()).values())
    assert f"{TEXT}transformer.resblocks.23.mlp.c_proj.bias" in text
    assert len(text) == 24 * 12 + 5


def stable_diffusion_vae() -> set[str]:
    found = {"quant_conv", "post_quant_conv"}
    for side in ("encoder", "decoder"):
        found |= {f"{side}.{name}" for name in ("conv_in", "norm_out", "conv_out")}
        found |= {f"{side}.mid.attn_1.{name}" for name in ("norm", "q", "k", "v", "proj_out")}
        blocks = [f"{side}.mid.block_{number}" for number in (1, 2)]
        part, changing, count = ("down", (1, 2), 2) if side == "encoder" else ("up", (1, 0), 3)
        blocks += [f"{side}.{part}.{level}.block.{number}" for level in range(4) for number in range(count)]
        found |= {f"{block}.{name}" for block in blocks for name in ("norm1", "conv1", "norm2", "conv2")}
        found |= {f"{side}.{part}.{level}.block.0.nin_shortcut" for level in changing}
        levels = (0, 1, 2) if side == "encoder" else (1, 2, 3)
        found |= {f"{side}.{part}.{level}.{part}sample.conv" for level in levels}
    return {f"{name}.{end}" for name in found for end in ("weight", "bias")}


# --- what is wrong ---------------------------------------------------------------------------------------------------


def test_code_in_a_checkpoint_is_not_run(tmp_path: Path) -> None:
    torch = seeded()
    evil = Evil(tmp_path / "was-here")
    torch.save({"x": evil}, tmp_path / "new.pt")
    (tmp_path / "old.ckpt").write_bytes(pickle.dumps({"x": evil}))
    (tmp_path / "noise.pt").write_bytes(b"\x00\x01 nothing")
    (tmp_path / "empty.ckpt").write_bytes(b"")
    (tmp_path / "noise.safetensors").write_bytes(b"\xff" * 100)
    torch.save([torch.zeros(3)], tmp_path / "list.pt")
    torch.save({"state_dict": {"a": "text"}}, tmp_path / "text.pt")
    for name in ("new.pt", "old.ckpt", "noise.pt", "empty.ckpt", "noise.safetensors", "list.pt", "text.pt"):
        wrong(tmp_path / name, name, SMALL)
    assert not evil.mark.exists()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda t: t.pop(f"{UNET}camera_embed.0.weight"), f"missing key `{UNET}camera_embed.0.weight`"),
        (lambda t: t.update({f"{UNET}more.weight": t["betas"]}), f"unexpected key `{UNET}more.weight`"),
        (lambda t: t.update({"lora.up": t["betas"]}), "unexpected key `lora.up`"),
        (lambda t: t.update({f"{VAE}quant_conv.bias": t["betas"]}), "quant_conv.bias` has the shape 1000, expected 8"),
        (lambda t: t.pop(f"{TEXT}ln_final.bias"), f"missing key `{TEXT}ln_final.bias`"),
    ],
)
def test_checkpoints_of_other_models(checkpoint: tuple[Path, Networks], tmp_path: Path, change: Any, said: str) -> None:
    torch = seeded()
    tensors = torch.load(checkpoint[0], weights_only=True)
    change(tensors)
    torch.save(tensors, tmp_path / "other.pt")
    wrong(tmp_path / "other.pt", said, SMALL)


def test_the_full_size_model_is_not_the_small_one(checkpoint: tuple[Path, Networks]) -> None:
    wrong(checkpoint[0], f"`{UNET}")

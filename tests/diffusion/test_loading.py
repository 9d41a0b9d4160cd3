"""Models from folders and files; what is not there, broken, foreign or hostile is one clear line."""

from __future__ import annotations

import json
import pickle
from pathlib import Path
from typing import Any

import pytest
from small_models import (
    CAMERAS,
    SMALL_SCHEDULER,
    SMALL_UNET,
    SMALL_VAE,
    seeded,
    small_clip,
    small_control,
    small_diffusion,
    small_text,
    small_unet,
    small_vae,
)

from scenelang.backends.clip.models import ClipName, load_clip
from scenelang.backends.clip.text import TextEncoder
from scenelang.backends.diffusion.loading import DEPTH, MULTIVIEW, load_depth, load_diffusion, load_multiview
from scenelang.backends.diffusion.mvdream import (
    ORIGINAL,
    Architecture,
    Networks,
    convert_mvdream,
    empty_networks,
    mvdream_tensors,
    read_mvdream,
)
from scenelang.backends.diffusion.mvdream_keys import TEXT, UNET, VAE, text_names, vae_names
from scenelang.backends.diffusion.pixels import Autoencoder, Unshuffled
from scenelang.backends.diffusion.words import ClipWords, TransformerWords
from scenelang.backends.weights import Shelf
from scenelang.grammar.diagnostics import SceneError

TEXT_CONFIG = {
    "embed_dim": 16,
    "text_cfg": {"context_length": 77, "vocab_size": 49408, "width": 32, "heads": 2, "layers": 3},
}
SMALL = Architecture({**SMALL_UNET, **CAMERAS}, SMALL_VAE, TEXT_CONFIG, SMALL_SCHEDULER)


def predicted(diffusion: Any, latents: Any, cameras: Any = None, depth: Any = None) -> Any:
    torch = seeded()
    states = diffusion.words.encode([("a red sphere",)] * len(latents))
    with torch.no_grad():
        return diffusion.predict(latents, torch.full((len(latents),), 300), states, cameras, depth)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Several views, with an autoencoder, a text encoder of transformers and a control."""
    seeded()
    return small_diffusion(tmp_path_factory.mktemp("models") / "small", control=True)


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
    from scenelang.backends.clip.towers import empty_tower, text_weights
    from scenelang.backends.diffusion.fitting import fitted

    return fitted("clip", empty_tower(TEXT_CONFIG), text_weights(network.state_dict()))


# --- folders ---------------------------------------------------------------------------------------------------------


def test_a_folder_of_several_views(folder: Path) -> None:
    found = load_diffusion(folder)
    assert (found.views, found.size, found.pixels.factor) == (4, 32, 4)
    assert isinstance(found.pixels, Autoencoder)
    assert isinstance(found.words, TransformerWords)
    assert found.control is not None
    assert not any(parameter.requires_grad for parameter in found.network.parameters())
    torch = seeded()
    depth = torch.rand(4, 3, 32, 32)
    assert predicted(found, torch.randn(4, 4, 8, 8), torch.randn(4, 16), depth).shape == (4, 4, 8, 8)


def test_what_is_loaded_is_what_was_saved(folder: Path) -> None:
    from diffusers import UNet2DConditionModel

    torch = seeded()
    found = load_diffusion(folder).network.state_dict()
    expected = UNet2DConditionModel.from_pretrained(folder / "unet").state_dict()
    assert all(torch.equal(found[key], tensor) for key, tensor in expected.items())


def test_half_weights(folder: Path) -> None:
    torch = seeded()
    found = load_diffusion(folder, dtype=torch.bfloat16)
    assert found.network.dtype == found.control.dtype == torch.bfloat16
    assert found.words.encode([("a moai",)]).dtype == torch.bfloat16
    assert found.pixels.encode(torch.rand(1, 3, 32, 32)).dtype == torch.float32
    assert predicted(found, torch.randn(4, 4, 8, 8), torch.randn(4, 16)).dtype == torch.float32


def test_pixels_without_an_autoencoder(tmp_path: Path) -> None:
    seeded()
    found = load_diffusion(small_diffusion(tmp_path / "toy", pixels=True))
    assert isinstance(found.pixels, Unshuffled)
    assert (found.size, found.pixels.factor, found.control) == (32, 2, None)


def test_the_text_encoder_of_openclip(tmp_path: Path, folder: Path) -> None:
    """It is read without the encoder of pictures beside it, and hears what the whole model does."""
    import shutil

    torch = seeded()
    place = tmp_path / "clip-words"
    shutil.copytree(folder, place, ignore=shutil.ignore_patterns("text_encoder", "tokenizer"))
    small_clip(place / "text")
    found = load_diffusion(place)
    assert isinstance(found.words, ClipWords)
    whole = TextEncoder(load_clip(ClipName(str(place / "text"))))
    assert torch.equal(found.words.encode([("a moai",)]), whole.encode([("a moai",)]).earlier)


def test_names_are_found_on_the_shelf(tmp_path: Path, folder: Path) -> None:
    (tmp_path / "MVDream").symlink_to(folder)
    assert load_multiview(shelf=Shelf(tmp_path, fetch=False)).name == MULTIVIEW


def test_a_model_of_pictures_with_a_control(tmp_path: Path) -> None:
    seeded()
    small_diffusion(tmp_path / "pictures", views=False)
    small_control(small_unet(False)).save_pretrained(tmp_path / DEPTH.replace("/", "--"))
    shelf = Shelf(tmp_path, fetch=False)
    found = load_depth("pictures", shelf=shelf)
    assert (found.views, found.control.config.cross_attention_dim, found.name) == (1, 32, "pictures")
    small_control(small_unet(False, cross_attention_dim=16)).save_pretrained(tmp_path / "other")
    with pytest.raises(SceneError, match="cross_attention_dim 16, the model 32"):
        load_depth("pictures", "other", shelf)
    with pytest.raises(SceneError, match="single pictures, not several views"):
        load_multiview("pictures", shelf)


def test_text_encoders_saved_by_older_versions(tmp_path: Path, folder: Path) -> None:
    """Hub repositories have the names of transformers before version 5."""
    import shutil

    from safetensors.torch import load_file, save_file

    torch = seeded()
    place = tmp_path / "older"
    shutil.copytree(folder, place)
    file = place / "text_encoder" / "model.safetensors"
    plain = {key.removeprefix("text_model."): tensor for key, tensor in load_file(file).items()}
    save_file({f"text_model.{key}": tensor for key, tensor in plain.items()}, file, metadata={"format": "pt"})
    prompt = [("a moai",)]
    assert torch.equal(load_diffusion(place).words.encode(prompt), load_diffusion(folder).words.encode(prompt))


# --- MVDream's checkpoint --------------------------------------------------------------------------------------------


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
    states = TextEncoder(clip).encode([("a red sphere",)] * 4).earlier
    assert torch.equal(found.words.encode([("a red sphere",)] * 4), states)
    steps = torch.full((4,), 300)
    from scenelang.backends.diffusion.multiview import fold_views

    fold_views(networks.unet)
    with torch.no_grad():
        own = networks.unet(latents, steps, states, class_labels=cameras, cross_attention_kwargs={"views": 4}).sample
        assert torch.equal(found.predict(latents, steps, states, cameras), own)
        pictures = torch.rand(1, 3, 32, 32)
        assert torch.equal(found.pixels.encode(pictures), Autoencoder(networks.vae).encode(pictures))


def test_a_checkpoint_as_a_folder(checkpoint: tuple[Path, Networks], tmp_path: Path) -> None:
    torch = seeded()
    path, _ = checkpoint
    convert_mvdream(path, tmp_path / "made", SMALL)
    one, other = load_multiview(str(path), architecture=SMALL), load_multiview(str(tmp_path / "made"))
    latents, cameras = torch.randn(4, 4, 8, 8), torch.randn(4, 16)
    assert torch.equal(predicted(one, latents, cameras), predicted(other, latents, cameras))
    assert torch.equal(one.schedule.alphas, other.schedule.alphas)
    with pytest.raises(SceneError, match="cannot be written"):
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


class Evil:
    def __init__(self, mark: Path) -> None:
        self.mark = mark

    def __reduce__(self) -> Any:
        return (Path.touch, (self.mark,))


def wrong(path: Path, said: str, architecture: Architecture = SMALL) -> None:
    with pytest.raises(SceneError, match=said) as caught:
        load_diffusion(path, architecture=architecture)
    assert caught.value.name == "weights"
    assert "\n" not in caught.value.message
    assert len(caught.value.message) < 500


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
        wrong(tmp_path / name, name)
    assert not evil.mark.exists()


def test_code_in_a_folder_is_not_run(tmp_path: Path, folder: Path) -> None:
    import shutil

    torch = seeded()
    evil = Evil(tmp_path / "was-here")
    for file, old in ((UNET_FILE, "unet/diffusion_pytorch_model.bin"), (TEXT_FILE, "text_encoder/pytorch_model.bin")):
        place = tmp_path / old.partition("/")[0]
        shutil.copytree(folder, place)
        (place / file).unlink()
        torch.save({"conv_in.weight": evil}, place / old)
        wrong(place, "does not hold the model")
    pickle.loads(pickle.dumps(Evil(tmp_path / "shown")))
    assert (tmp_path / "shown").exists()  # it would run
    assert not evil.mark.exists()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda t: t.pop(f"{UNET}camera_embed.0.weight"), f"`{UNET}camera_embed.0.weight` is missing"),
        (lambda t: t.update({f"{UNET}more.weight": t["betas"]}), f"`{UNET}more.weight` does not belong there"),
        (lambda t: t.update({"lora.up": t["betas"]}), "`lora.up` does not belong there"),
        (lambda t: t.update({f"{VAE}quant_conv.bias": t["betas"]}), "quant_conv.bias` has the shape 1000, not 8"),
        (lambda t: t.pop(f"{TEXT}ln_final.bias"), f"`{TEXT}ln_final.bias` is missing"),
    ],
)
def test_checkpoints_of_other_models(checkpoint: tuple[Path, Networks], tmp_path: Path, change: Any, said: str) -> None:
    torch = seeded()
    tensors = torch.load(checkpoint[0], weights_only=True)
    change(tensors)
    torch.save(tensors, tmp_path / "other.pt")
    wrong(tmp_path / "other.pt", said)


def test_the_full_size_model_is_not_the_small_one(checkpoint: tuple[Path, Networks]) -> None:
    wrong(checkpoint[0], f"`{UNET}", ORIGINAL)


def _changed(path: Path, change: Any) -> None:
    from safetensors.torch import load_file, save_file

    tensors = load_file(path)
    change(tensors)
    save_file(tensors, path, metadata={"format": "pt"})


UNET_FILE, TEXT_FILE = "unet/diffusion_pytorch_model.safetensors", "text_encoder/model.safetensors"


@pytest.mark.parametrize(
    ("file", "change", "said"),
    [
        (UNET_FILE, lambda t: t.pop("conv_in.weight"), "`conv_in.weight` is missing"),
        (UNET_FILE, lambda t: t.update(foreign=t["conv_in.bias"].clone()), "`foreign` does not belong there"),
        (UNET_FILE, lambda t: t.update({"conv_in.bias": t["conv_in.bias"][:5].clone()}), "conv_in.bias"),
        (TEXT_FILE, lambda t: t.pop(min(t)), "is missing"),
        (TEXT_FILE, lambda t: t.update({min(t): t[min(t)][:5].clone()}), "shape"),
    ],
)
def test_folders_of_other_models(tmp_path: Path, folder: Path, file: str, change: Any, said: str) -> None:
    import shutil

    shutil.copytree(folder, tmp_path / "other")
    _changed(tmp_path / "other" / file, change)
    wrong(tmp_path / "other", said)


def _setting(name: str, **settings: Any) -> Any:
    def change(place: Path) -> None:
        path = place / name
        path.write_text(json.dumps({**json.loads(path.read_text()), **settings}))

    return change


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda place: (place / "scheduler" / "scheduler_config.json").write_text("[]"), "no JSON object"),
        (lambda place: (place / "scheduler" / "scheduler_config.json").unlink(), "scheduler_config.json"),
        (lambda place: (place / "unet" / "config.json").write_text("{"), "does not hold the model"),
        (lambda place: (place / "unet" / "diffusion_pytorch_model.safetensors").unlink(), "does not hold the model"),
        (_setting("unet/config.json", sample_size=[8, 9]), "no size of pictures"),
        (_setting("unet/config.json", block_out_channels=[32, 10**9]), "does not hold the model"),
    ],
)
def test_broken_folders(tmp_path: Path, folder: Path, change: Any, said: str) -> None:
    import shutil

    shutil.copytree(folder, tmp_path / "other")
    change(tmp_path / "other")
    wrong(tmp_path / "other", said)


def test_networks_with_other_conditions(tmp_path: Path) -> None:
    seeded()
    wrong(small_diffusion(tmp_path / "classes", views=False, num_class_embeds=10), "conditions that are no cameras")


def test_parts_that_do_not_belong_together(tmp_path: Path, folder: Path) -> None:
    import shutil

    seeded()
    shutil.copytree(folder, tmp_path / "other")
    shutil.rmtree(tmp_path / "other" / "text_encoder")
    small_text(width=64).save_pretrained(tmp_path / "other" / "text_encoder")
    wrong(tmp_path / "other", "listens to states of 32, its text encoder's have 64")
    shutil.rmtree(tmp_path / "other" / "vae")
    wrong(tmp_path / "other", "4 channels are no squares")


def test_what_is_not_there(tmp_path: Path) -> None:
    offline = Shelf(tmp_path, fetch=False)
    for load in (load_multiview, load_depth):
        with pytest.raises(SceneError) as caught:
            load(shelf=offline)
        assert caught.value.name == "weights"
        assert "--models-dir" in (caught.value.hint or "")
    wrong(tmp_path / "nowhere", "no folder or file")
    wrong(tmp_path, "neither a folder `unet` nor a file")

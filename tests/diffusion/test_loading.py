"""Models from folders and files; what is not there, broken, foreign or hostile is one clear line."""

from __future__ import annotations

import json
import pickle
from pathlib import Path
from typing import Any

import pytest
from small_models import seeded, small_clip, small_control, small_diffusion, small_text, small_unet

from scenelang.backends.neural.clip import ClipName, Slot, TextEncoder, load_clip
from scenelang.backends.neural.diffusion import (
    Autoencoder,
    ClipPromptEncoder,
    PixelUnshuffle,
    TransformersPromptEncoder,
)
from scenelang.backends.neural.diffusion_loading import (
    DEPTH_CONTROLNET,
    MULTIVIEW_MODEL,
    load_depth,
    load_diffusion,
    load_multiview,
)
from scenelang.backends.neural.weights import ModelHub
from scenelang.grammar.diagnostics import SceneError

from .support import Evil, predicted, wrong


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Several views, with an autoencoder, a text encoder of transformers and a control."""
    seeded()
    return small_diffusion(tmp_path_factory.mktemp("models") / "small", control=True)


# --- folders ---------------------------------------------------------------------------------------------------------


def test_a_folder_of_several_views(folder: Path) -> None:
    found = load_diffusion(folder)
    assert (found.views, found.size, found.codec.factor) == (4, 32, 4)
    assert isinstance(found.codec, Autoencoder)
    assert isinstance(found.text_encoder, TransformersPromptEncoder)
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
    assert found.text_encoder.encode([("a moai",)]).dtype == torch.bfloat16
    assert found.codec.encode(torch.rand(1, 3, 32, 32)).dtype == torch.float32
    assert predicted(found, torch.randn(4, 4, 8, 8), torch.randn(4, 16)).dtype == torch.float32


def test_pixels_without_an_autoencoder(tmp_path: Path) -> None:
    seeded()
    found = load_diffusion(small_diffusion(tmp_path / "toy", pixels=True))
    assert isinstance(found.codec, PixelUnshuffle)
    assert (found.size, found.codec.factor, found.control) == (32, 2, None)


def test_the_text_encoder_of_openclip(tmp_path: Path, folder: Path) -> None:
    """It is read without the encoder of pictures beside it, and hears what the whole model does."""
    import shutil

    torch = seeded()
    place = tmp_path / "clip-words"
    shutil.copytree(folder, place, ignore=shutil.ignore_patterns("text_encoder", "tokenizer"))
    small_clip(place / "text")
    found = load_diffusion(place)
    assert isinstance(found.text_encoder, ClipPromptEncoder)
    whole = TextEncoder(load_clip(ClipName(str(place / "text"))))
    assert torch.equal(found.text_encoder.encode([("a moai",)]), whole.encode([("a moai",)]).penultimate)
    half = load_diffusion(place, dtype=torch.bfloat16).text_encoder.encode(
        [("a ", Slot("z2"))], {"z2": torch.randn(1, 32)}
    )
    assert half.dtype == torch.bfloat16
    assert bool(half.isfinite().all())


def test_names_are_found_on_the_shelf(tmp_path: Path, folder: Path) -> None:
    (tmp_path / "MVDream").symlink_to(folder)
    assert load_multiview(hub=ModelHub(tmp_path, download=False)).name == MULTIVIEW_MODEL


def test_a_model_of_pictures_with_a_control(tmp_path: Path) -> None:
    seeded()
    small_diffusion(tmp_path / "pictures", views=False)
    small_control(small_unet(False)).save_pretrained(tmp_path / DEPTH_CONTROLNET.replace("/", "--"))
    hub = ModelHub(tmp_path, download=False)
    found = load_depth("pictures", hub=hub)
    assert (found.views, found.control.config.cross_attention_dim, found.name) == (1, 32, "pictures")
    small_control(small_unet(False, cross_attention_dim=16)).save_pretrained(tmp_path / "other")
    with pytest.raises(SceneError, match="cross_attention_dim 16, the model 32"):
        load_depth("pictures", "other", hub)
    with pytest.raises(SceneError, match="is not a multi-view model: it denoises single images"):
        load_multiview("pictures", hub)


@pytest.mark.slow
def test_what_the_hub_has_given_before_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Models in the hub's cache, and no network."""

    def cached(name: str) -> Path:
        folder = tmp_path / f"models--{name.replace('/', '--')}"
        (folder / "refs").mkdir(parents=True)
        (folder / "refs" / "main").write_text("a" * 40)
        (folder / "snapshots" / ("a" * 40)).mkdir(parents=True)
        return folder / "snapshots" / ("a" * 40)

    seeded()
    monkeypatch.setattr("huggingface_hub.constants.HF_HUB_CACHE", str(tmp_path))
    small_diffusion(cached("some/views"))
    small_diffusion(cached("some/pictures"), views=False)
    small_control(small_unet(False)).save_pretrained(cached("some/depth"))
    offline = ModelHub(download=False)
    assert load_multiview("some/views", offline).views == 4
    found = load_depth("some/pictures", "some/depth", offline)
    assert (found.views, found.size, found.control is None) == (1, 32, False)


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
    assert torch.equal(
        load_diffusion(place).text_encoder.encode(prompt), load_diffusion(folder).text_encoder.encode(prompt)
    )


# --- what is wrong ---------------------------------------------------------------------------------------------------


def test_code_in_a_folder_is_not_run(tmp_path: Path, folder: Path) -> None:
    import shutil

    torch = seeded()
    evil = Evil(tmp_path / "was-here")
    for file, old in ((UNET_FILE, "unet/diffusion_pytorch_model.bin"), (TEXT_FILE, "text_encoder/pytorch_model.bin")):
        place = tmp_path / old.partition("/")[0]
        shutil.copytree(folder, place)
        (place / file).unlink()
        torch.save({"conv_in.weight": evil}, place / old)
        wrong(place, "cannot load the model")
    pickle.loads(pickle.dumps(Evil(tmp_path / "shown")))
    assert (tmp_path / "shown").exists()  # it would run
    assert not evil.mark.exists()


def _changed(path: Path, change: Any) -> None:
    from safetensors.torch import load_file, save_file

    tensors = load_file(path)
    change(tensors)
    save_file(tensors, path, metadata={"format": "pt"})


UNET_FILE, TEXT_FILE = "unet/diffusion_pytorch_model.safetensors", "text_encoder/model.safetensors"


@pytest.mark.parametrize(
    ("file", "change", "said"),
    [
        (UNET_FILE, lambda t: t.pop("conv_in.weight"), "missing key `conv_in.weight`"),
        (UNET_FILE, lambda t: t.update(foreign=t["conv_in.bias"].clone()), "unexpected key `foreign`"),
        (UNET_FILE, lambda t: t.update({"conv_in.bias": t["conv_in.bias"][:5].clone()}), "conv_in.bias"),
        (TEXT_FILE, lambda t: t.pop(min(t)), "missing key"),
        (TEXT_FILE, lambda t: t.update({min(t): t[min(t)][:5].clone()}), "shape"),
    ],
)
@pytest.mark.sampled(2)
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
        (lambda place: (place / "scheduler" / "scheduler_config.json").write_text("[]"), "expected a JSON object"),
        (lambda place: (place / "scheduler" / "scheduler_config.json").unlink(), "scheduler_config.json"),
        (lambda place: (place / "unet" / "config.json").write_text("{"), "cannot load the model"),
        (lambda place: (place / "unet" / "diffusion_pytorch_model.safetensors").unlink(), "cannot load the model"),
        (_setting("unet/config.json", sample_size=[8, 9]), "the configuration of its `unet` has no `sample_size`"),
        (_setting("unet/config.json", block_out_channels=[32, 10**9]), "cannot load the model"),
    ],
)
@pytest.mark.sampled(2)
def test_broken_folders(tmp_path: Path, folder: Path, change: Any, said: str) -> None:
    import shutil

    shutil.copytree(folder, tmp_path / "other")
    change(tmp_path / "other")
    wrong(tmp_path / "other", said)


def test_networks_with_other_conditions(tmp_path: Path) -> None:
    seeded()
    wrong(
        small_diffusion(tmp_path / "classes", views=False, num_class_embeds=10),
        "its `unet` requires conditions other than cameras",
    )


def test_parts_that_do_not_belong_together(tmp_path: Path, folder: Path) -> None:
    import shutil

    seeded()
    shutil.copytree(folder, tmp_path / "other")
    shutil.rmtree(tmp_path / "other" / "text_encoder")
    small_text(width=64).save_pretrained(tmp_path / "other" / "text_encoder")
    wrong(tmp_path / "other", "expects text states of width 32, got 64")
    shutil.rmtree(tmp_path / "other" / "vae")
    wrong(tmp_path / "other", r"must have 3 n\^2 input channels, not 4")


def test_what_is_not_there(tmp_path: Path) -> None:
    offline = ModelHub(tmp_path, download=False)
    for load in (load_multiview, load_depth):
        with pytest.raises(SceneError) as caught:
            load(hub=offline)
        assert caught.value.name == "weights"
        assert "--models-dir" in (caught.value.hint or "")
    wrong(tmp_path / "nowhere", "no diffusion model at")
    wrong(tmp_path, "expected a folder `unet` or a file")

"""Unknown blocks by meaning, where the neural extra and its weights are there."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from small_models import seeded, small_clip

from scenelang.backends.minecraft.blocks import AIR_STATE, BlockState, Build, load_table
from scenelang.backends.minecraft.connections import settled
from scenelang.backends.minecraft.voxels import Voxels
from scenelang.backends.neural import clip
from scenelang.backends.neural.clip import ClipName, load_clip, nearest_by_meaning

NAMES = ["stone", "oak_planks", "sandstone", "glass", "red_wool"]


@pytest.fixture
def weights(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A hub with a small model in the place of ViT-H-14, and a cache of its own."""
    folder = tmp_path / "models"
    small_clip(folder / "ViT-H-14")
    monkeypatch.setenv("SCENELANG_MODELS", str(folder))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    clip._encoder.cache_clear()
    return folder


def openclip_says(folder: Path, name: str) -> str:
    """The nearest name by OpenCLIP's own functions."""
    torch = seeded()
    model = load_clip(ClipName(str(folder / "ViT-H-14")))
    with torch.no_grad():
        said = [f"a block of {each} in Minecraft" for each in (name, *(n.replace("_", " ") for n in NAMES))]
        found = model.network.encode_text(model.tokenizer(said), normalize=True)
    return NAMES[int((found[1:] @ found[0]).argmax())]


@pytest.mark.parametrize("name", ["lava lamp", "wooden floor", "sea", "a dragon's scale"])
@pytest.mark.sampled(2)
def test_the_nearest_in_meaning(name: str, weights: Path) -> None:
    assert nearest_by_meaning(name, NAMES) == openclip_says(weights, name)


def test_names_are_encoded_once(weights: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = nearest_by_meaning("lava lamp", NAMES)
    counted: list[int] = []
    encoded = clip._embed_names
    monkeypatch.setattr(clip, "_embed_names", lambda e, names: counted.append(len(names)) or encoded(e, names))
    assert nearest_by_meaning("lava lamp", NAMES) == before
    assert counted == [1]


def test_a_build_asks_it(weights: Path) -> None:
    voxels = Voxels(
        Build((0, 0, 0), np.ones((1, 1, 1), np.uint32), (AIR_STATE, BlockState("minecraft:qwxzv"))), (None, None), ()
    )
    found = settled(voxels)
    names = [k.name.removeprefix("minecraft:") for k in load_table().blocks.values() if not k.is_for_operators]
    assert found.build.palette[1].name == f"minecraft:{nearest_by_meaning('qwxzv', names)}"
    assert [warning.name for warning in found.warnings] == ["unknown-block"]


def test_without_weights_letters_decide(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SCENELANG_MODELS", str(tmp_path))
    monkeypatch.setenv("HF_HUB_CACHE", str(tmp_path))
    clip._encoder.cache_clear()
    assert nearest_by_meaning("lava lamp", NAMES) is None
    monkeypatch.setattr(clip, "find_spec", lambda name: None)
    assert nearest_by_meaning("lava lamp", NAMES) is None

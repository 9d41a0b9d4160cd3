"""CLIP similarity is that of OpenCLIP itself."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from small_models import seeded

from scenelang.backends.neural.metrics import ClipScore
from scenelang.backends.neural.weights import ModelHub
from scenelang.grammar.diagnostics import SceneError


def pictures(count: int = 19) -> list[np.ndarray]:
    draws = np.random.default_rng(5)
    return [draws.integers(0, 256, (40, 56, 3), np.uint8) for _ in range(count)]


def test_cosines_are_those_of_open_clip(models: Path) -> None:
    import open_clip
    from PIL import Image

    torch = seeded()
    place = f"local-dir:{models / 'ViT-H-14-378-quickgelu'}"
    network, _, prepare = open_clip.create_model_and_transforms(place)
    network.eval()
    text = "fifteen coke cans, stacked in a pyramid"
    with torch.no_grad():
        rows = torch.stack([prepare(Image.fromarray(picture)) for picture in pictures()])
        seen = network.encode_image(rows, normalize=True)
        said = network.encode_text(open_clip.get_tokenizer(place)([text]), normalize=True)
    expected = (seen @ said[0]).tolist()
    found = ClipScore(hub=ModelHub(models, False)).cosines(text, pictures())
    assert found == pytest.approx(expected, abs=1e-6)
    assert np.std(found) > 1e-3, "pictures differ"


def test_texts_matter(models: Path) -> None:
    seeded()
    judge = ClipScore(hub=ModelHub(models, False))
    one, two = (judge.cosines(text, pictures(2)) for text in ("a red sphere", "a blue cube"))
    assert np.abs(np.subtract(one, two)).min() > 1e-3
    assert judge.name == "ViT-H-14-378-quickgelu/dfn5b"


def test_a_text_that_is_too_long_is_cut(models: Path) -> None:
    seeded()
    judge = ClipScore(hub=ModelHub(models, False))
    long = "cube " * 76
    assert judge.cosines(long, pictures(1)) == pytest.approx(judge.cosines(long + "sphere " * 50, pictures(1)))


def test_absent_weights(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="ViT-H-14-378-quickgelu") as caught:
        ClipScore(hub=ModelHub(tmp_path, False))
    assert caught.value.name == "weights"


def test_a_full_gpu_is_told(models: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    torch = seeded()
    judge = ClipScore(hub=ModelHub(models, False))

    def full(*_: object) -> None:
        raise torch.OutOfMemoryError("CUDA out of memory")

    monkeypatch.setattr("scenelang.backends.neural.metrics.encode_images", full)
    with pytest.raises(SceneError, match="out of GPU memory") as caught:
        judge.cosines("a cube", pictures(1))
    assert caught.value.name == "unsupported"

"""GroundingDINO and SAM at a small size, against what transformers itself makes of their outputs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_grounding import noise_picture, small_detector, small_segmenter

from scenelang.backends.neural.grounding import (
    Grounding,
    crop_masked,
    detect,
    find_object,
    load_detector,
    load_segmenter,
    mask_in,
    normalize_text,
)
from scenelang.backends.neural.weights import ModelHub
from scenelang.grammar.diagnostics import SceneError

BOX = (10.0, 8.0, 60.0, 50.0)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("grounding")
    small_detector(place / "detector")
    small_segmenter(place / "segmenter", seed=1)
    return place


@pytest.fixture(scope="module")
def detector(folder: Path) -> Any:
    return load_detector(str(folder / "detector"))


@pytest.fixture(scope="module")
def segmenter(folder: Path) -> Any:
    return load_segmenter(str(folder / "segmenter"))


@pytest.mark.parametrize(
    ("text", "said"), [("Red  Statue", "red statue."), ("a cube.", "a cube."), (" tower . ", "tower.")]
)
def test_phrases(text: str, said: str) -> None:
    assert normalize_text(text) == said


@pytest.mark.parametrize("text", ["", " . ", "a" * 300])
def test_no_phrases(text: str) -> None:
    with pytest.raises(SceneError, match="200 characters"):
        normalize_text(text)


@pytest.mark.slow
def test_boxes_are_those_of_transformers(detector: Any) -> None:
    import torch

    picture = noise_picture(90, 60)
    given = detector.processor(images=picture, text="red statue.", return_tensors="pt")
    with torch.no_grad():
        output = detector.network(**given)
    wanted = detector.processor.post_process_grounded_object_detection(
        output, given["input_ids"], threshold=0.5, text_threshold=0.5, target_sizes=[(60, 90)]
    )[0]
    found = detect(detector, picture, "Red statue", 0.5)
    assert 0 < len(found) < 10
    assert [each.score for each in found] == pytest.approx(sorted(wanted["scores"].tolist(), reverse=True))
    order = torch.argsort(wanted["scores"], descending=True)
    limits = torch.tensor([90.0, 60.0, 90.0, 60.0])
    boxes = torch.minimum(wanted["boxes"][order].clamp_min(0.0), limits)
    assert np.allclose([each.box for each in found], boxes.numpy(), atol=1e-3)
    assert detect(detector, picture, "red statue", 1.0) == []


def test_the_mask_is_the_best_of_the_offered(segmenter: Any) -> None:
    """Upscaled here by torch alone: the mask of the network's own size, cut to what is not padding, then the picture's."""
    import torch

    picture = noise_picture(90, 60)
    given = segmenter.processor(images=picture, input_boxes=[[list(BOX)]], return_tensors="pt")
    with torch.no_grad():
        output = segmenter.network(pixel_values=given["pixel_values"], input_boxes=given["input_boxes"].float())
    scores, offered = output.iou_scores[0, 0], output.pred_masks[0, 0]
    assert given["input_boxes"][0, 0].tolist() == pytest.approx([x * 64 / 90 for x in BOX], rel=0.02)
    enlarge = lambda mask, size: torch.nn.functional.interpolate(mask[None, None], size, mode="bilinear")[0, 0]
    masks = [enlarge(enlarge(mask, (64, 64))[:43, :64], (60, 90)).numpy() > 0.0 for mask in offered]
    found = mask_in(segmenter, picture, BOX)
    assert found.shape == (60, 90)
    assert np.array_equal(found, masks[int(scores.argmax())])
    assert any(not np.array_equal(found, mask) for mask in masks)


def test_a_thing_is_looked_for_in_all_pictures(detector: Any, segmenter: Any) -> None:
    pictures = [noise_picture(80, 60, seed) for seed in range(3)]
    scores = [detect(detector, picture, "statue", 0.0)[0].score for picture in pictures]
    surest = int(np.argmax(scores))
    best = detect(detector, pictures[surest], "statue", 0.0)[0]
    seen = find_object(Grounding(detector, segmenter, 0.0), pictures, "statue", 40)
    assert seen is not None
    mask = mask_in(segmenter, pictures[surest], best.box)
    assert seen[0] == surest
    assert np.array_equal(seen[1], crop_masked(np.asarray(pictures[surest]), mask, 40))
    assert find_object(Grounding(detector, segmenter, 1.0), pictures, "statue", 40) is None


def test_other_weights(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(
        SceneError, match=r"does not contain the weights of the expected model|cannot load the model"
    ) as caught:
        load_detector(str(folder / "segmenter"))
    assert caught.value.diagnostic.code == "E707"
    (tmp_path / "empty").mkdir()
    with pytest.raises(SceneError) as caught:
        load_segmenter(str(tmp_path / "empty"))
    assert caught.value.diagnostic.code == "E707"


def test_a_missing_tensor_is_named(folder: Path, tmp_path: Path) -> None:
    import shutil

    from safetensors.torch import load_file, save_file

    shutil.copytree(folder / "segmenter", tmp_path / "broken")
    path = tmp_path / "broken" / "model.safetensors"
    tensors = load_file(path)
    del tensors["mask_decoder.iou_token.weight"]
    save_file(tensors, path, metadata={"format": "pt"})
    with pytest.raises(SceneError, match=r"missing key .mask_decoder.iou_token.weight."):
        load_segmenter(str(tmp_path / "broken"))


def test_absent_weights(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("HF_HUB_CACHE", str(tmp_path))
    with pytest.raises(SceneError, match="nobody/nothing") as caught:
        load_detector("nobody/nothing", ModelHub(None, download=False))
    assert caught.value.diagnostic.code == "E707"
    assert "--models-dir" in str(caught.value.hint)

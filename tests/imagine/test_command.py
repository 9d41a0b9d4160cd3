"""`scenelang imagine`, with a small model in the place of Stable Diffusion."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from loaded_once import loaded_once as loaded_once
from small_diffusion import WIDTH, small_control, small_diffusion
from small_models import seeded

from scenelang.cli.main import main
from scenelang.files.zfile import Made, write_vectors

pytestmark = pytest.mark.usefixtures("loaded_once")

PROGRAM = """; A quiet beach. Nobody is there.
(bind "beach" (lambda ()
  (union (call "moai" (embedding <z2> "weathered") :scale [1 2 1])
         (transform (call "moai" (embedding <z3> "mossy") :scale [1 3 1]) (translate [3 0 0]))
         (transform (call "palm") (translate [6 0 0])))))
"""
QUICK = ("--steps", "2", "--size", "64x64", "--device", "cpu")


@pytest.fixture(scope="module")
def models(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("models")
    small_diffusion(folder / "stable-diffusion-2-1")
    small_diffusion(folder / "gligen-1-4-generation-text-box", gated=True)
    small_control(folder / "controlnet-sd21-depth-diffusers", folder / "stable-diffusion-2-1")
    return folder


@pytest.fixture
def place(tmp_path: Path, models: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    seeded()
    monkeypatch.setenv("SCENELANG_MODELS", str(models))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "beach.scene").write_text(PROGRAM, "utf-8")
    return tmp_path


def opened(path: str) -> tuple[Any, dict[str, Any]]:
    from PIL import Image

    with Image.open(path) as image:
        notes = json.loads(image.text["scenelang"])  # type: ignore[attr-defined]
        return np.asarray(image), notes


def drawn(*options: str) -> Any:
    assert main(["imagine", "beach.scene", "-o", "made.png", *QUICK, *options, "-q"]) == 0
    return opened("made.png")[0]


def test_a_picture_and_how_it_was_made(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["imagine", "beach.scene", "-o", "a.png", *QUICK, "--negative", "blurry", "--seed", "5"]) == 0
    assert "wrote a.png" in capsys.readouterr().out
    picture, notes = opened("a.png")
    assert picture.shape == (64, 64, 3)
    assert (notes["model"], notes["method"]) == ("stabilityai/stable-diffusion-2-1", "regional")
    assert (notes["seed"], notes["steps"], notes["negative"]) == (5, 2, "blurry")
    assert notes["layout"]["prompt"] == "A quiet beach"
    assert {one["prompt"] for one in notes["layout"]["instances"]} == {
        "a weathered moai, in the style of beach, 3D model",
        "a mossy moai, in the style of beach, 3D model",
        "a typical palm, in the style of beach, 3D model",
    }


def test_it_repeats_and_counts(place: Path) -> None:
    assert main(["imagine", "beach.scene", "-o", "b.png", *QUICK, "--count", "2", "-q"]) == 0
    (first, one), (second, two) = opened("b-1.png"), opened("b-2.png")
    assert (one["seed"], two["seed"]) == (0, 1)
    assert not np.array_equal(first, second)
    assert np.array_equal(first, drawn())
    assert np.array_equal(second, drawn("--seed", "1"))


@pytest.mark.slow
def test_what_is_asked_for_matters(place: Path) -> None:
    plain = drawn()
    different = [
        drawn("--prompt", "a busy harbour"),
        drawn("--strength", "0"),
        drawn("--entity", "beach"),
        drawn("--camera", "top"),
        drawn("--negative", "blurry"),
        drawn("--guidance", "1"),
    ]
    assert not any(np.array_equal(plain, picture) for picture in different)
    main(["embeddings", "beach.scene", "set", "<z3>", "--text", "golden", "-q"])
    assert not np.array_equal(plain, drawn())


def test_depth_by_a_controlnet(place: Path) -> None:
    """Fresh from its making it changes nothing."""
    assert np.array_equal(drawn("--control"), drawn())
    assert opened("made.png")[1]["control"] is None
    drawn("--control")
    assert opened("made.png")[1]["control"] == "thibaud/controlnet-sd21-depth-diffusers"


def test_gligen(place: Path) -> None:
    drawn("--method", "gligen")
    assert opened("made.png")[1]["model"] == "masterful/gligen-1-4-generation-text-box"


def test_migc(place: Path, models: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from safetensors.torch import save_file

    from imagine.test_migc import MIDDLE, weights
    from scenelang.backends.neural.imagine.migc import Migc, to_checkpoint

    save_file(to_checkpoint(Migc({MIDDLE: weights()})), place / "migc.safetensors")
    sd = str(models / "stable-diffusion-2-1")
    heeding = drawn("--method", "migc", "--model", sd, "--migc", "migc.safetensors")
    assert not np.array_equal(heeding, drawn())
    capsys.readouterr()
    assert main(["imagine", "beach.scene", "-o", "c.png", *QUICK, "--method", "migc", "--model", sd]) == 1
    assert "E707" in capsys.readouterr().err


# --- learned vectors -------------------------------------------------------------------------------------------------


def test_learned_vectors_stand_in_the_sentence(place: Path, models: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Those of a word's own tokens give the picture that the word gives."""
    from scenelang.backends.neural.imagine.sampling import load_checkpoint

    words = load_checkpoint(str(models / "stable-diffusion-2-1")).text_encoder
    main(["embeddings", "beach.scene", "set", "<z3>", "--text", "golden", "-q"])
    written = drawn()
    numbers = words.tokenizer("golden", add_special_tokens=False).input_ids
    vectors = words.network.get_input_embeddings().weight[numbers].detach().numpy().copy()
    made = {"z3": Made("inversion", "photo.png", "small", "2026-11-22")}
    write_vectors(place / "beach.z.safetensors", {"z3": vectors}, made)
    assert np.array_equal(drawn(), written)
    prompts = [one["prompt"] for one in opened("made.png")[1]["layout"]["instances"]]
    assert "a <z3> moai, in the style of beach, 3D model" in prompts
    write_vectors(place / "beach.z.safetensors", {"z3": -vectors}, made)
    assert not np.array_equal(drawn(), written)


def test_vectors_for_another_encoder_give_way_to_texts(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["embeddings", "beach.scene", "set", "<z3>", "--text", "golden", "-q"])
    written = drawn()
    other = np.ones((1, WIDTH * 2), np.float32)
    write_vectors(place / "beach.z.safetensors", {"z3": other}, {"z3": Made("inversion", "a.png", "m", "t")})
    capsys.readouterr()
    assert main(["imagine", "beach.scene", "-o", "a.png", *QUICK]) == 0
    error = capsys.readouterr().err
    assert "W622" in error
    assert "<z3>" in error
    assert np.array_equal(opened("a.png")[0], written)


# --- layouts ---------------------------------------------------------------------------------------------------------


def test_a_layout_alone_needs_no_model(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from PIL import Image

    monkeypatch.delenv("SCENELANG_MODELS")
    common = ["imagine", "beach.scene", "--layout-only", "--size", "96x64", "-q"]
    assert main([*common, "-o", "layout.png"]) == 0
    with Image.open("layout.png") as image:
        assert image.size == (96, 64)
    assert main([*common, "-o", "layout.json"]) == 0
    data = json.loads((place / "layout.json").read_text("utf-8"))
    assert (data["format"], data["width"], data["prompt"]) == ("scenelang-layout", 96, "A quiet beach")
    assert sorted(one["handle"] for one in data["instances"])[:2] == ["<z2>", "<z3>"]
    assert main([*common, "-o", "layout.json", "--depth", "0", "--prompt", "<z2> stones"]) == 0
    data = json.loads((place / "layout.json").read_text("utf-8"))
    assert (len(data["instances"]), data["prompt"]) == (1, "weathered stones")


def test_more_than_thirty_things(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = "".join(f'(transform (call "palm") (translate [{2 * i} 0 0]))' for i in range(33))
    (place / "row.scene").write_text(f'(bind "row" (lambda () (union {rows})))', "utf-8")
    assert main(["imagine", "row.scene", "--layout-only", "--camera", "azimuth=0", "-o", "row.json"]) == 0
    assert len(json.loads((place / "row.json").read_text("utf-8"))["instances"]) == 30
    error = capsys.readouterr().err
    assert "W621" in error
    assert "3 instances are omitted" in error


# --- mistakes --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "code", "text"),
    [
        (["-o", "a.jpg"], 2, ".png"),
        (["-o", "a.json"], 2, "--layout-only"),
        (["-o", "no/a.png"], 1, "the folder no does not exist"),
        (["-o", "a.png", "--count", "0"], 2, "--count"),
        (["-o", "a.png", "--steps", "0"], 2, "--steps"),
        (["-o", "a.png", "--size", "60x64"], 1, "must be multiples of 8"),
        (["-o", "a.png", "--camera", "sideways"], 2, "camera"),
        (["-o", "a.png", "--entity", "castle"], 1, "castle"),
        (["-o", "a.png", "--prompt", "a <q> sea"], 1, "<q> has neither"),
        (["-o", "a.png", "--model", "nowhere/none", "--offline"], 1, "E707"),
        (["-o", "a.png", "--control", "nowhere/none", "--offline"], 1, "E707"),
        (["-o", "a.png", "--method", "gligen", "--model", "stable-diffusion-2-1"], 1, "E707"),
        (["-o", "a.png", "--device", "tpu"], 1, "unknown device `tpu`"),
    ],
)
@pytest.mark.sampled(3)
def test_mistakes(arguments: list[str], code: int, text: str, place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["imagine", "beach.scene", *arguments]) == code
    error = capsys.readouterr().err
    assert text in error
    assert "Traceback" not in error
    assert not list(place.glob("*.png"))

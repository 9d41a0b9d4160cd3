"""`scenelang invert`, `style` and `generate --invert` on the toy model, with small networks that find things."""

from __future__ import annotations

import hashlib
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from later import later
from loaded_once import loaded_once as loaded_once
from PIL import Image
from small_grounding import small_detector, small_segmenter
from support import evaluate
from toy.model import ONE_GREY, unpack

from inversion.support import shown
from scenelang.backends.neural.clip import slots
from scenelang.backends.neural.grounding import crop_masked, random_grey
from scenelang.backends.neural.inversion import InversionSettings, InversionTrainer, load_checkpoint
from scenelang.backends.neural.prompts import Granularity, PromptContext, leaves_of
from scenelang.cli.main import main
from scenelang.files.zfile import Made, read_made, read_z, write_vectors
from scenelang.scene import Scene

torch = later("torch")
pytestmark = pytest.mark.usefixtures("loaded_once")

PROGRAM = """
(bind "yard" (lambda ()
  (union (call "statue") (transform (call "tower") (translate [4 0 0])) (transform (call "tower") (translate [8 0 0])))))
"""
QUICK = ("--steps", "3", "--batch", "1", "--device", "cpu", "--class-word", "sphere", "--style-word", "toy")


@pytest.fixture(scope="module")
def models(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A shelf with the real names."""
    folder = tmp_path_factory.mktemp("models")
    unpack(folder / "MVDream", ONE_GREY)
    small_detector(folder / "grounding-dino-base")
    small_segmenter(folder / "sam-vit-huge", seed=1)
    return folder


@pytest.fixture
def yard(models: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest) -> Path:
    if request.node.get_closest_marker("slow") is None:
        monkeypatch.setattr(InversionTrainer, "mean_loss", roughly)
    monkeypatch.setenv("SCENELANG_MODELS", str(models))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "yard.scene").write_text(PROGRAM, "utf-8")
    save(tmp_path / "photo.png", shown("red", "cube"))
    return tmp_path


mean_loss = InversionTrainer.mean_loss


def roughly(work: InversionTrainer) -> float:
    """The mean loss of a few draws."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(work, "_settings", replace(work._settings, loss_samples=2))
        return mean_loss(work)


def save(path: Path, picture: torch.Tensor) -> None:
    Image.fromarray((picture.permute(1, 2, 0).numpy() * 255).round().astype(np.uint8)).save(path)


def invert(*words: str, entity: str = "statue") -> int:
    return main(["invert", "yard.scene", "--from", "photo.png", "--entity", entity, *QUICK, *words])


Z = Path("yard.z.safetensors")


@pytest.mark.slow
def test_the_whole_picture_becomes_an_entity(yard: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert invert("--no-segment", "--steps", "40") == 0
    out = capsys.readouterr().out
    before, after = map(float, out.partition("loss ")[2].split(" -> "))
    assert "wrote yard.z.safetensors: <z2> <z1>;" in out
    assert after < 0.8 * before
    vectors, made = read_z(Z)[1], read_made(Z)
    assert {name: vector.shape for name, vector in vectors.items()} == {"z1": (1, 64), "z2": (1, 64)}
    assert (made["z2"].how, made["z2"].source, made["z2"].model) == ("inversion", "photo.png", "MVDream/MVDream")
    assert (made["z1"].how, made["z1"].when) == ("style", made["z2"].when)
    assert np.array_equal(np.asarray(Image.open("yard.inversion/z2.png")), np.asarray(Image.open("photo.png")))


def test_the_vectors_stand_in_the_sentences(yard: Path) -> None:
    assert invert("--no-segment", "-q") == 0
    learned = frozenset(read_z(Z)[1])
    leaves = leaves_of(evaluate(PROGRAM), Granularity(), PromptContext(learned))[0]
    assert [slots(leaf.condition.prompt) for leaf in leaves] == [("z2", "z1"), ("z1",), ("z1",)]


def test_entities_of_a_word_are_alike(yard: Path) -> None:
    assert invert("--no-segment", "-q", entity="tower") == 0
    vectors = read_z(Z)[1]
    assert sorted(vectors) == ["z1", "z3", "z4"]
    assert np.array_equal(vectors["z3"], vectors["z4"])


def test_a_mask_says_where_the_thing_is(yard: Path) -> None:
    mask = np.zeros((32, 32), np.bool_)
    mask[10:20, 8:24] = True
    Image.fromarray(mask).save("mask.png")
    assert invert("--mask", "mask.png", "-q", "--seed", "5") == 0
    wanted = crop_masked(np.asarray(Image.open("photo.png")), mask, random_grey(5))
    assert np.array_equal(np.asarray(Image.open("yard.inversion/z2.png")), wanted)


def test_things_are_found_by_words(yard: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The small detector knows nothing, but is sure of some box; what it finds is cut out and learned."""
    assert main(["invert", "yard.scene", "--from", "photo.png", *QUICK[:6], "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["parts"] == [
        {"text": "statue", "handles": ["z2"]}, {"text": "tower", "handles": ["z3", "z4"]},
    ]  # fmt: skip
    assert data["style"] == ["z1"]
    assert sorted(read_z(Z)[1]) == ["z1", "z2", "z3", "z4"]
    assert sorted(path.name for path in Path("yard.inversion").iterdir()) == [
        "inversion.safetensors", "z2.png", "z3.png",
    ]  # fmt: skip


def test_what_is_not_to_be_found(
    yard: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from scenelang.backends.neural import grounding

    detect = grounding.detect
    blind = lambda detector, picture, text, least: [] if "tower" in text else detect(detector, picture, text, least)
    monkeypatch.setattr(grounding, "detect", blind)
    assert invert(entity="tower") == 1
    assert 'no "tower" detected' in capsys.readouterr().err
    assert not Z.exists()
    assert main(["invert", "yard.scene", "--from", "photo.png", *QUICK[:6]]) == 0
    assert 'not found in the image and left unchanged: "tower"' in capsys.readouterr().err
    assert sorted(read_z(Z)[1]) == ["z1", "z2"]


def test_a_broken_run_goes_on(yard: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Ctrl-C after two steps of three; the rest gives what a whole run gives, from the pictures that were kept."""

    assert invert("--no-segment", "-q", "-o", "whole", "--z", "whole.z.safetensors") == 0
    step = InversionTrainer.step

    def interrupted(self: InversionTrainer) -> float:
        import signal

        loss = step(self)
        if self.done == 2:
            signal.raise_signal(signal.SIGINT)
        return loss

    monkeypatch.setattr(InversionTrainer, "step", interrupted)
    assert invert("--no-segment") == 130
    assert "continue with `--resume`" in capsys.readouterr().err
    assert not Z.exists()
    assert load_checkpoint(Path("yard.inversion")).done == 2
    monkeypatch.setattr(InversionTrainer, "step", step)
    assert invert("--no-segment") == 1
    assert "already contains an unfinished run" in capsys.readouterr().err
    Path("photo.png").unlink()
    assert invert("--resume", "-q") == 0
    found, wanted = read_z(Z)[1], read_z(Path("whole.z.safetensors"))[1]
    assert sorted(found) == sorted(wanted)
    assert all(np.array_equal(found[name], wanted[name]) for name in found)


def test_the_weights_of_all_models_stay(yard: Path, models: Path) -> None:
    digest = lambda: {path: hashlib.sha256(path.read_bytes()).digest() for path in models.rglob("*") if path.is_file()}
    before = digest()
    assert invert("-q") == 0
    assert digest() == before


@pytest.mark.parametrize(
    ("words", "code", "text"),
    [
        (["--no-segment", "--text", "a"], 2, "--no-segment"),
        (["--mask", "a.png", "--text", "a"], 2, "cannot be combined with `--text`"),
        (["--mask", "none.png"], 1, "as an image"),
        (["--entity", "tower", "--no-segment"], 2, "requires exactly one"),
        (["--resume"], 1, "no inversion in yard.inversion"),
        (["--resume", "--force"], 2, "`--resume` cannot be combined with `--force`"),
        (["--steps", "0"], 1, "steps"),
        (["--model", "nobody/nothing", "--no-segment", "--offline"], 1, "E707"),
        (["--detector", "nobody/nothing", "--offline"], 1, "E707"),
        (["--device", "tpu"], 1, "unknown device `tpu`"),
    ],
)
def test_mistakes(words: list[str], code: int, text: str, yard: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert invert(*words) == code
    assert text in capsys.readouterr().err
    assert not Z.exists()


def test_names_that_make_no_sense(yard: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for entity, text in (
        ("castle", "no visible entity"),
        ("yard", "style of the scene"),
        ("<z1>", "style of the scene"),
    ):
        assert invert("--no-segment", entity=entity) == 1
        assert text in capsys.readouterr().err
    double = ["invert", "yard.scene", "--from", "photo.png", "--entity", "tower", "--entity", "<z3>"]
    assert main(double) == 1
    assert "two of the entities share an embedding; name only one of them" in capsys.readouterr().err
    assert main(["invert", "-", "--from", "photo.png"]) == 2
    assert "--z" in capsys.readouterr().err


# --- style -------------------------------------------------------------------------------------------------------------


def style(*words: str) -> int:
    return main(["style", "yard.scene", "--from", "photo.png", *QUICK[:6], "--style-word", "toy", *words])


def test_a_style_for_the_scene_or_a_part(yard: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert style() == 0
    assert "<z1>; loss" in capsys.readouterr().out
    assert list(read_z(Z)[1]) == ["z1"]
    assert style("--entity", "tower") == 0
    vectors, made = read_z(Z)[1], read_made(Z)
    assert sorted(vectors) == ["z1", "z3", "z4"]
    assert {made[name].how for name in vectors} == {"style"}
    assert made["z3"].source == "photo.png"
    leaves = leaves_of(evaluate(PROGRAM), Granularity(), PromptContext(frozenset(vectors)))[0]
    assert [slots(leaf.condition.prompt) for leaf in leaves] == [("z1",), ("z3", "z1"), ("z4", "z1")]


def test_a_style_replaces_no_likeness_unasked(yard: Path, capsys: pytest.CaptureFixture[str]) -> None:
    likeness = {"z2": np.ones((1, 64), np.float32)}
    write_vectors(Z, likeness, {"z2": Made("inversion", "statue.png", "MVDream/MVDream", "2026-11-22")})
    assert style("--entity", "statue") == 1
    assert "learned from statue.png" in capsys.readouterr().err
    assert np.array_equal(read_z(Z)[1]["z2"], likeness["z2"])
    assert style("--entity", "statue", "--force") == 0
    assert read_made(Z)["z2"].how == "style"
    assert style("--entity", "statue") == 0


# --- generate ----------------------------------------------------------------------------------------------------------


def test_parts_of_generated_scenes(
    yard: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """What the command does once the program is written, with the picture that the language model saw."""
    from argparse import Namespace

    from scenelang.cli.neural import invert_generated
    from scenelang.inference.steps import read_picture

    asked = Namespace(models_dir=None, offline=True, device="cpu", seed=0, quiet=False, json=False)
    monkeypatch.setattr(InversionSettings.__init__, "__defaults__", (2, 1e-2, 1, 0, 2))
    invert_generated(asked, Scene(evaluate(PROGRAM)), [read_picture("photo.png")], Path("out.scene"))
    assert "wrote out.z.safetensors" in capsys.readouterr().out
    assert sorted(read_z(Path("out.z.safetensors"))[1]) == ["z1", "z2", "z3", "z4"]
    assert read_made(Path("out.z.safetensors"))["z3"].source == "picture 1"


@pytest.mark.parametrize("words", [["a yard", "--invert"], ["--image", "photo.png", "--invert"]])
def test_generate_says_at_once_what_is_missing(
    words: list[str], yard: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["generate", *words]) == 2
    assert "--image and -o" in capsys.readouterr().err

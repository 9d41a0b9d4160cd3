"""Embeddings and neural models from Python: each public function once, on small models, and what goes wrong."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import scenelang as sl

torch = pytest.importorskip("torch")

from loaded_once import loaded_once as loaded_once
from one_thread import one_thread as one_thread
from small_diffusion import small_diffusion
from small_models import seeded, small_clip
from small_models import small_diffusion as small_judge

pytestmark = pytest.mark.usefixtures("loaded_once")

BEACH = """; A quiet beach. Nobody is there.
(bind "beach" (lambda ()
  (union (call "moai" (embedding <z2> "weathered") :scale [1 2 1])
         (transform (call "palm") (translate [3 0 0])))))
"""
CPU = sl.Models(offline=True, device="cpu")


@pytest.fixture(scope="module")
def models(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with small models under the real names."""
    seeded()
    folder = tmp_path_factory.mktemp("models")
    small_clip(folder / "ViT-H-14")
    small_diffusion(folder / "stable-diffusion-2-1")
    small_judge(folder / "figures", pixels=True)
    return folder


@pytest.fixture
def beach(models: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> sl.Scene:
    monkeypatch.setenv("SCENELANG_MODELS", str(models))
    monkeypatch.chdir(tmp_path)
    Path("beach.scene").write_text(BEACH, "utf-8")
    return sl.load("beach.scene")


def photo(path: str = "photo.png") -> str:
    from PIL import Image

    Image.fromarray(np.random.default_rng(0).integers(0, 256, (32, 32, 3), np.uint8)).save(path)
    return path


# --- embeddings ------------------------------------------------------------------------------------------------------


def test_entries_are_set_and_forgotten(beach: sl.Scene) -> None:
    z = sl.Embeddings.beside("beach.scene")
    assert repr(z) == "<Embeddings beach.z.safetensors: no file>"
    z.set("<z3>", text="of plastic", attributes={"color": (0, 0.5, 0), "tall": True})
    assert repr(z) == "<Embeddings beach.z.safetensors: 1 entry, 0 learned vectors>"
    assert z.entries["z3"].attributes == {"color": (0.0, 0.5, 0.0), "tall": True}
    rows = z.table(sl.load("beach.scene"))
    assert [(row.handle, row.word, row.text) for row in rows] == [
        ("z1", "beach", None), ("z2", "moai", "weathered"), ("z3", "palm", "of plastic"),
    ]  # fmt: skip
    assert repr(rows[2]) == """<EmbeddingRow <z3> "palm": 'of plastic'>"""
    assert rows[2].data()["attributes"]["color"] == [0.0, 0.5, 0.0]
    z.set("z3", vectors=np.ones(32))
    assert z.vectors["z3"].shape == (1, 32)
    assert z.table(beach)[2].learned == "1 x 32, array of Python"
    z.swap("<z2>", "<z3>")
    assert z.entries["z2"].text == "of plastic"
    z.remove("<z2>")
    assert list(z.entries) == []
    assert z.vectors == {}
    assert sl.Embeddings.open("beach.z.safetensors") == sl.Embeddings(Path("beach.z.safetensors"))
    assert sl.Embeddings.of(beach).entries == z.entries


def test_sentences_are_encoded_and_compared(beach: sl.Scene, tmp_path: Path) -> None:
    z = sl.Embeddings.of(beach)
    found = z.encode(beach, models=CPU)
    assert found.matrix.shape == (2, 16)
    assert z.encodings is not None
    alike = z.similar("a weathered moai, in the style of beach, 3D model", 1, models=CPU)
    assert alike[0].handles == ("z2",)
    assert alike[0].cosine == pytest.approx(1.0, abs=1e-5)
    assert [row.word for row in z.similar("<z2>")] == ["palm"]
    assert len(z.similar(photo(), models=CPU)) == 2
    with np.load(z.export("beach.npz")) as arrays:
        np.testing.assert_allclose(arrays["encodings"], found.matrix)
    one = z.encode(beach, granularity=sl.Granularity(depth=0), models=CPU)
    assert len(one.rows) == 1


def test_a_picture_becomes_a_vector(beach: sl.Scene) -> None:
    z = sl.Embeddings.of(beach)
    word = z.set("<z2>", image=photo(), start="statue", models=CPU)
    assert word is not None
    assert word.cosine >= word.before
    assert z.made["z2"].source == "photo.png"


def test_words_for_numbers(beach: sl.Scene) -> None:
    z = sl.Embeddings.of(beach)
    found = z.words_of(beach)
    assert repr(found) == "<SceneWording: 2 texts for 2 embeddings>"
    assert not z.exists
    assert z.describe(beach, template="{word}, {embedding}").wording == z.wording
    assert z.describe(beach).known == 2
    asked = z.describe(beach, describe=lambda questions: ["mossy"] * len(questions), force=True)
    assert any("mossy" in text for text in asked.texts)
    with pytest.raises(sl.SceneError, match="is already described"):
        z.describe(beach, describe=lambda questions: [])
    with pytest.raises(sl.SceneError, match=r"the placeholders are \{embedding\}"):
        z.words_of(beach, template="{embedding} {color}")


def test_mistakes_about_embeddings(beach: sl.Scene) -> None:
    z = sl.Embeddings.of(beach)
    beach.export("beach.json")
    wrong: list[tuple[Any, str]] = [
        (lambda: sl.Embeddings.open("none.safetensors"), "No such file"),
        (lambda: sl.Embeddings.beside("none.scene"), "there is no file none.scene"),
        (lambda: sl.Embeddings.beside("beach.json"), "flattened scene"),
        (lambda: sl.Embeddings(None).set("<z2>", text="a"), "expected an embeddings file"),
        (lambda: z.set("<z2>"), "nothing to set"),
        (lambda: z.set("<z 2", text="a"), "invalid handle `<z 2`"),
        (lambda: z.set("<z2>", attributes={"a": object()}), "cannot be stored"),
        (lambda: z.set("<z2>", vectors=[float("nan")]), "finite vectors"),
        (lambda: z.set("<z2>", image="none.png"), "cannot read none.png as an image: No such file"),
        (lambda: z.swap("<z2>", "<z3>"), "nothing to swap"),
        (lambda: z.remove("<z2>"), "nothing to remove"),
        (lambda: z.similar("<z2>"), "has not been encoded"),
        (lambda: z.export("a.png"), "cannot write vectors to"),
        (lambda: z.export("a.npz"), "nothing to export: the embeddings file"),
        (lambda: z.encode(beach, models=sl.Models(device="tpu")), "unknown device"),
        (lambda: z.encode(beach, models=sl.Models("nowhere")), "the model directory nowhere does not exist"),
    ]
    for action, text in wrong:
        with pytest.raises(sl.SceneError, match=text):
            action()
    assert not z.exists


# --- imagine ---------------------------------------------------------------------------------------------------------


def test_pictures_are_imagined(beach: sl.Scene) -> None:
    told: list[float] = []
    settings = sl.ImagineSettings(steps=2)
    pictures = sl.imagine(beach, size=(64, 64), seed=5, count=2, settings=settings, models=CPU, progress=told.append)
    assert repr(pictures) == "<ImaginedPictures: 2 of 64 x 64 by stabilityai/stable-diffusion-2-1>"
    first, second = pictures
    assert repr(first) == "<ImaginedPicture 64 x 64, seed 5>"
    assert first.notes["layout"]["prompt"] == "A quiet beach"
    assert told == sorted(told)
    assert told[-1] == 1.0
    assert not np.array_equal(first.pixels, second.pixels)
    (again,) = sl.imagine(beach, sl.Camera(), size=(64, 64), seed=6, settings=settings, models=CPU)
    np.testing.assert_array_equal(np.asarray(again), second.pixels)
    assert pictures.save("a.png") == [Path("a-1.png"), Path("a-2.png")]
    assert again._repr_png_()[:4] == Path("a-2.png").read_bytes()[:4]


def test_progress_cancels(beach: sl.Scene) -> None:
    def cancel(_: float) -> None:
        raise KeyboardInterrupt

    pictures = sl.imagine(beach, size=(64, 64), settings=sl.ImagineSettings(steps=2), models=CPU, progress=cancel)
    with pytest.raises(KeyboardInterrupt):
        pictures.save("a.png")
    assert not Path("a.png").exists()


def test_a_layout_needs_no_model(beach: sl.Scene) -> None:
    warned: list[sl.Diagnostic] = []
    layout = sl.imagine_layout(beach, size=(96, 64), prompt="<z2> stones", warn=warned.append)
    assert repr(layout) == "<SceneLayout 96 x 64: 2 instances>"
    assert layout.pixels.shape == (64, 96, 3)
    assert layout.data["prompt"] == "weathered stones"
    assert layout.save("layout.json").exists()
    assert layout.save("layout.png").exists()
    assert warned == []
    row = "".join(f'(transform (call "palm") (translate [{2 * i} 0 0]))' for i in range(33))
    sl.imagine_layout(sl.evaluate(f'(bind "row" (lambda () (union {row})))'), sl.Camera(azimuth=0), warn=warned.append)
    assert [diagnostic.name for diagnostic in warned] == ["crowded-layout"]


def test_mistakes_about_pictures(beach: sl.Scene) -> None:
    wrong: list[tuple[Any, str]] = [
        (lambda: sl.ImagineSettings(steps=0), "--steps"),
        (lambda: sl.ImagineSettings(method="magic"), "--method"),
        (lambda: sl.ImagineSettings(strength=-1.0), "--strength"),
        (lambda: sl.imagine(beach, count=0, models=CPU), "--count"),
        (lambda: sl.imagine(beach, size=(60, 64), models=CPU), "must be multiples of 8"),
        (lambda: sl.imagine(beach, frame=3, models=CPU), "frame 3 does not exist"),
        (lambda: sl.imagine(beach, settings=sl.ImagineSettings(model="no/such"), models=CPU), "weights"),
        (lambda: sl.imagine_layout(beach, granularity=sl.Granularity(named=("castle",))), "castle"),
        (lambda: sl.imagine_layout(beach).save("a.gif"), "ending in .png"),
    ]
    for action, text in wrong:
        with pytest.raises(sl.SceneError, match=text):
            action()


# --- invert, learn_style ---------------------------------------------------------------------------------------------

QUICK = sl.InversionSettings(steps=3, batch_size=1, loss_samples=2)


@pytest.fixture
def toy(beach: sl.Scene, tmp_path: Path) -> sl.InversionModels:
    from toy.model import ONE_GREY, unpack

    return sl.InversionModels(str(unpack(tmp_path / "toy", ONE_GREY)))


def test_an_entity_is_learned_from_a_picture(beach: sl.Scene, toy: sl.InversionModels) -> None:
    subject = sl.PictureSubject(whole=True, class_word="sphere", style_word="toy")
    shares, starts, losses = [], [], []
    found = sl.invert(
        beach, photo(), entities=["moai"], subject=subject, settings=QUICK, networks=toy, models=CPU,
        progress=shares.append, on_start=starts.append, on_step=lambda told: losses.append(told.loss),
    )  # fmt: skip
    assert found.finished
    assert found.handles == ("z2", "z1")
    assert repr(found).startswith("<Inversion of <z2> <z1>; loss ")
    assert shares == pytest.approx([1 / 3, 2 / 3, 1.0])
    assert len(losses) == 3
    assert starts[0].parts == found.parts
    assert sorted(found.embeddings.vectors) == ["z1", "z2"]
    assert found.data()["parts"] == [{"text": "moai", "handles": ["z2"]}]


def test_a_stopped_run_goes_on(beach: sl.Scene, toy: sl.InversionModels) -> None:
    subject = sl.PictureSubject(whole=True, class_word="sphere", style_word="toy")
    asked: dict[str, Any] = {
        "entities": ["moai"], "subject": subject, "settings": QUICK, "networks": toy, "models": CPU,
    }  # fmt: skip
    whole = sl.invert(beach, photo(), run=sl.RunFolder("whole"), embeddings="whole.z.safetensors", **asked)
    steps: list[Any] = []
    found = sl.invert(beach, photo(), on_step=steps.append, stop=lambda: len(steps) == 2, **asked)
    assert (found.finished, len(steps)) == (False, 2)
    assert repr(found).endswith(", stopped>")
    assert not found.embeddings.exists
    with pytest.raises(sl.SceneError, match="unfinished run"):
        sl.invert(beach, photo(), **asked)
    found = sl.invert(beach, photo(), run=sl.RunFolder(resume=True), **asked)
    vectors, wanted = found.embeddings.vectors, whole.embeddings.vectors
    assert found.finished
    assert all(np.array_equal(vectors[name], wanted[name]) for name in wanted)


def test_a_style_is_learned_from_a_picture(beach: sl.Scene, toy: sl.InversionModels) -> None:
    from PIL import Image

    subject = sl.PictureSubject(class_word="sphere", style_word="toy")
    with Image.open(photo()) as picture:
        found = sl.learn_style(beach, picture, subject=subject, settings=QUICK, networks=toy, models=CPU)
    assert found.handles == ("z1",)
    assert found.embeddings.made["z1"].source == "picture 1"
    assert found.folder == Path("beach.style")
    found.embeddings.set("<z2>", vectors=np.ones(64))
    with pytest.raises(sl.SceneError, match="<z2> already has an embedding"):
        sl.learn_style(beach, photo(), entity="moai", subject=subject, settings=QUICK, networks=toy, models=CPU)


def test_mistakes_about_inversions(beach: sl.Scene, toy: sl.InversionModels) -> None:
    whole = sl.PictureSubject(whole=True)
    nowhere = sl.evaluate(BEACH)
    wrong: list[tuple[Any, str]] = [
        (lambda: sl.PictureSubject(text="a", mask="m.png"), "cannot be combined with `--text`"),
        (lambda: sl.PictureSubject(whole=True, text="a"), "cannot be combined"),
        (lambda: sl.PictureSubject(class_word=" "), "--class-word"),
        (lambda: sl.InversionSettings(steps=0), "steps"),
        (lambda: sl.RunFolder(resume=True, force=True), "cannot be combined"),
        (lambda: sl.RunFolder(resume=True, start="a"), "cannot be combined"),
        (lambda: sl.invert(beach, photo(), subject=whole, models=CPU), "requires exactly one"),
        (lambda: sl.invert(beach, photo(), entities=["castle"], models=CPU), "castle"),
        (lambda: sl.invert(beach, photo(), entities=["beach"], models=CPU), "style of the scene"),
        (lambda: sl.invert(beach, "none.png", entities=["moai"], subject=whole, models=CPU), "No such file"),
        (lambda: sl.invert(beach, [], entities=["moai"], subject=whole, models=CPU), "at least one image"),
        (lambda: sl.invert(beach, photo(), run=sl.RunFolder(resume=True), models=CPU), "no inversion in"),
        (lambda: sl.invert(nowhere, photo(), models=CPU), "expected a run folder"),
        (lambda: sl.learn_style(nowhere, photo(), run=sl.RunFolder("run"), models=CPU), "expected an embeddings file"),
    ]
    for action, text in wrong:
        with pytest.raises(sl.SceneError, match=text):
            action()
    assert not sl.Embeddings.of(beach).exists


# --- distill ---------------------------------------------------------------------------------------------------------

ALONE = sl.DistillationModels("figures", scene_term=False)


def test_things_are_distilled(beach: sl.Scene, models: Path) -> None:
    digest = hashlib.sha256((models / "figures" / "unet" / "config.json").read_bytes()).hexdigest()
    settings = sl.DistillationSettings.of(steps=3, gaussians=40)
    asked: dict[str, Any] = {"settings": settings, "networks": ALONE, "models": CPU}
    shares, starts, steps = [], [], []
    found = sl.distill(
        beach, sl.RunFolder("run"), progress=shares.append, on_start=starts.append, on_step=steps.append,
        stop=lambda: len(steps) == 2, **asked,
    )  # fmt: skip
    assert not found.finished
    assert str(starts[0]) == "2 objects, 2 to optimize, 6 steps in run"
    assert shares == pytest.approx([1 / 6, 2 / 6])
    with pytest.raises(sl.SceneError, match="already contains a run"):
        sl.distill(beach, sl.RunFolder("run"), **asked)
    found = sl.distill(beach, sl.RunFolder("run", resume=True), **asked)
    assert found.finished
    assert repr(found) == "<Distillation in run: 2 objects, finished>"
    assert [path.name for path in found.files] == ["scene.ply", "poses.json"]
    assert len(found.film(beach, size=(32, 32))) == 48
    image = beach.render(size=(32, 32), quality="splats", settings={"distilled": str(found.folder)})
    assert image.pixels.shape == (32, 32, 4)
    with pytest.raises(sl.SceneError, match="nothing to optimize"):
        sl.distill(beach, sl.RunFolder("again", start="run"), **asked)
    assert digest == hashlib.sha256((models / "figures" / "unet" / "config.json").read_bytes()).hexdigest()


def test_mistakes_about_distillations(beach: sl.Scene) -> None:
    wrong: list[tuple[Any, str]] = [
        (lambda: sl.DistillationSettings.of(steps=0), "at least 1 step"),
        (lambda: sl.DistillationSettings.of(guidance=float("nan")), "--guidance"),
        (lambda: sl.DistillationSettings.of(weighting="none"), "--weighting"),
        (lambda: sl.distill(beach, sl.RunFolder("run", resume=True), networks=ALONE, models=CPU), "no distillation in"),
        (lambda: sl.distill(beach, sl.RunFolder("beach.scene"), networks=ALONE, models=CPU), "cannot be a folder"),
        (lambda: sl.distill(beach, sl.RunFolder("run"), models=CPU), "weights"),
    ]
    for action, text in wrong:
        with pytest.raises(sl.SceneError, match=text):
            action()


def test_docstring_examples_run() -> None:
    import doctest

    from scenelang.backends.neural import inversion as learning_of_words
    from scenelang.backends.neural import prompts, weights
    from scenelang.backends.neural.distillation import training
    from scenelang.learning import embeddings, inversion, neural

    for module in (embeddings, inversion, neural, training, learning_of_words, prompts, weights):
        assert doctest.testmod(module).failed == 0


def test_heavy_packages_wait(tmp_path: Path) -> None:
    """The names can be had without torch and its like."""
    import subprocess
    import sys

    code = "import sys, scenelang as sl; [getattr(sl, name) for name in sl.__all__]; print('torch' in sys.modules)"
    ran = subprocess.run([sys.executable, "-P", "-c", code], capture_output=True, text=True, cwd=tmp_path, check=True)
    assert ran.stdout.strip() == "False"

"""Pseudo-words of pictures, and `embeddings FILE set '<z2>' --image photo.png`."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from small_models import seeded, small_clip

from scenelang.backends.neural.clip import ClipModel, ClipName, load_clip
from scenelang.backends.neural.inversion import PROMPT, learn_picture_word
from scenelang.cli.main import main
from scenelang.files.zfile import read_made, read_z
from scenelang.grammar.diagnostics import SceneError
from scenelang.learning.stored_words import read_encodings

PROGRAM = '(bind "beach" (lambda () (union (call "moai") (transform (call "palm") (translate [6 0 0])))))'
Z = Path("beach.z.safetensors")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return small_clip(tmp_path_factory.mktemp("models") / "ViT-H-14")


@pytest.fixture(scope="module")
def model(folder: Path) -> ClipModel:
    seeded()
    return load_clip(ClipName(str(folder)))


@pytest.fixture
def beach(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("SCENELANG_MODELS", str(folder.parent))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "beach.scene").write_text(PROGRAM, "utf-8")
    photo().save(tmp_path / "photo.png")
    return tmp_path


def photo(seed: int = 0) -> Image.Image:
    return Image.fromarray(np.random.default_rng(seed).integers(0, 256, (40, 50, 3), np.uint8))


def own_cosine(model: ClipModel, vectors: np.ndarray, picture: Image.Image) -> float:
    """By OpenCLIP's own encoders: the token of "thing" is given the learned vector, and the sentence has that word."""
    import torch

    (number,) = model.tokenizer.encode("thing")
    weight = model.network.token_embedding.weight
    kept = weight[number].clone()
    with torch.no_grad():
        weight[number] = torch.from_numpy(vectors[0])
        text = model.network.encode_text(model.tokenizer([PROMPT.replace("<picture>", "thing")]), normalize=True)
        weight[number] = kept
        shown = model.network.encode_image(model.prepare(picture)[None], normalize=True)
    return float(text[0] @ shown[0])


@pytest.mark.slow
def test_the_sentence_meets_the_picture(model: ClipModel) -> None:
    before = hashlib.sha256(b"".join(p.numpy().tobytes() for p in model.network.parameters())).digest()
    found = learn_picture_word(model, photo(), "thing")
    assert found.vectors.shape == (1, 32)
    assert found.vectors.dtype == np.float32
    assert found.cosine > found.before + 0.2
    assert own_cosine(model, found.vectors, photo()) == pytest.approx(found.cosine, abs=1e-4)
    own = model.network.token_embedding.weight[model.tokenizer.encode("thing")].numpy()
    assert own_cosine(model, own, photo()) == pytest.approx(found.before, abs=1e-4)
    assert hashlib.sha256(b"".join(p.numpy().tobytes() for p in model.network.parameters())).digest() == before


def test_pictures_have_words_of_their_own(model: ClipModel) -> None:
    one, same, other = (learn_picture_word(model, photo(seed), steps=5) for seed in (0, 0, 1))
    assert np.array_equal(one.vectors, same.vectors)
    assert not np.array_equal(one.vectors, other.vectors)


def test_no_steps_are_the_start(model: ClipModel) -> None:
    found = learn_picture_word(model, photo(), "stone statue", steps=0)
    own = model.network.token_embedding.weight[model.tokenizer.encode("stone statue")].numpy()
    assert np.allclose(found.vectors[0], own.mean(0))
    assert found.cosine == found.before
    with pytest.raises(SceneError, match="no tokens"):
        learn_picture_word(model, photo(), " ")


def test_a_handle_gets_a_picture(beach: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["embeddings", "beach.scene", "set", "<z2>", "--image", "photo.png", "--start", "moai", "--text", "mossy"]
    assert main([*words, "--device", "cpu"]) == 0
    before, after = map(float, capsys.readouterr().out.partition("cosine ")[2].split(" -> "))
    assert after > before
    entries, vectors = read_z(Z)
    assert entries["z2"].text == "mossy"
    assert vectors["z2"].shape == (1, 32)
    made = read_made(Z)["z2"]
    assert (made.how, made.source, made.model) == ("picture", "photo.png", "ViT-H-14/laion2b_s32b_b79k")
    assert main(["embeddings", "beach.scene", "encode", "-q"]) == 0
    encodings = read_encodings(Z)
    assert encodings is not None
    assert [row.prompt.startswith("a <z2> moai") for row in encodings.rows] == [True, False]


@pytest.mark.slow
def test_other_settings_leave_it_and_clear_forgets_it(beach: Path) -> None:
    main(["embeddings", "beach.scene", "set", "<z2>", "--image", "photo.png", "-q"])
    vectors, made = read_z(Z)[1], read_made(Z)
    assert main(["embeddings", "beach.scene", "set", "<z2>", "--text", "golden", "-q"]) == 0
    assert np.array_equal(read_z(Z)[1]["z2"], vectors["z2"])
    assert read_made(Z) == made
    assert main(["embeddings", "beach.scene", "set", "<z2>", "--clear", "-q"]) == 0
    assert read_z(Z) == ({}, {})
    assert read_made(Z) == {}


@pytest.mark.parametrize(
    ("words", "code", "text"),
    [
        ([], 2, "--image"),
        (["--start", "moai"], 2, "--image"),
        (
            ["--image", "none.png"],
            1,
            "cannot read none.png as an image: No such file or directory",
        ),
        (["--image", "photo.png", "--start", " "], 1, "no tokens"),
        (["--image", "photo.png", "--models-dir", "nowhere"], 1, "the model directory nowhere does not exist"),
    ],
)
def test_mistakes(words: list[str], code: int, text: str, beach: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["embeddings", "beach.scene", "set", "<z2>", *words]) == code
    assert text in capsys.readouterr().err
    assert not Z.exists()

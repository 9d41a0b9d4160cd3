"""`scenelang embeddings`: encode, similar, swap, export, with a small model in the place of ViT-H-14."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_models import seeded, small_clip

from scenelang.backends.neural.clip import ClipName, load_clip
from scenelang.cli.main import main
from scenelang.files.zfile import Made, read_made, read_z, write_vectors
from scenelang.learning.stored_words import read_encodings, read_wording

PROGRAM = """
(bind "beach" (lambda ()
  (union (call "moai" (embedding <z2> "weathered") :scale [1 2 1])
         (transform (call "moai" (embedding <z3> "mossy") :scale [1 3 1]) (translate [3 0 0]))
         (transform (call "palm") (translate [6 0 0])))))
"""


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    small_clip(tmp_path / "models" / "ViT-H-14")
    monkeypatch.setenv("SCENELANG_MODELS", str(tmp_path / "models"))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "beach.scene").write_text(PROGRAM, "utf-8")
    return tmp_path


def z(place: Path) -> Path:
    return place / "beach.z.safetensors"


def said(capsys: pytest.CaptureFixture[str], *arguments: str) -> Any:
    assert main(["embeddings", "beach.scene", *arguments, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_learned_vectors_are_listed(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "learned" not in _listed(capsys)
    write_vectors(z(place), {"z2": np.zeros((1, 32), np.float32)}, {"z2": Made("inversion", "a.png", "m", "2026")})
    assert "1 x 32, inversion of a.png" in _listed(capsys)
    assert [row.get("vectors") for row in said(capsys, "list")][1] == "1 x 32, inversion of a.png"


def _listed(capsys: pytest.CaptureFixture[str]) -> str:
    assert main(["embeddings", "beach.scene", "list"]) == 0
    return capsys.readouterr().out


def test_every_sentence_is_encoded(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    torch = seeded()
    assert main(["embeddings", "beach.scene", "encode", "--device", "cpu"]) == 0
    assert "3 prompts of 3 embeddings encoded with ViT-H-14/laion2b_s32b_b79k" in capsys.readouterr().out
    found = read_encodings(z(place))
    assert found is not None
    assert found.model == "ViT-H-14/laion2b_s32b_b79k"
    assert found.rows[0].prompt == "a weathered moai, in the style of beach, 3D model"
    assert found.rows[0].handles == ("z2",)
    model = load_clip(ClipName(str(place / "models" / "ViT-H-14")))
    with torch.no_grad():
        wanted = model.network.encode_text(model.tokenizer([row.prompt for row in found.rows]), normalize=True)
    assert np.allclose(found.matrix, wanted.numpy(), atol=1e-5)


def test_a_text_in_z_changes_one_sentence(place: Path) -> None:
    main(["embeddings", "beach.scene", "encode", "-q"])
    before = read_encodings(z(place))
    main(["embeddings", "beach.scene", "set", "<z3>", "--text", "golden", "-q"])
    main(["embeddings", "beach.scene", "encode", "-q"])
    after = read_encodings(z(place))
    assert before is not None
    assert after is not None
    assert [a.prompt == b.prompt for a, b in zip(before.rows, after.rows)] == [True, False, True]
    assert (np.abs(before.matrix - after.matrix).max(axis=1) > 1e-4).tolist() == [False, True, False]


def test_the_style_changes_all(place: Path) -> None:
    main(["embeddings", "beach.scene", "encode", "-q"])
    before = read_encodings(z(place))
    main(["embeddings", "beach.scene", "set", "<z1>", "--text", "watercolor", "-q"])
    main(["embeddings", "beach.scene", "encode", "-q"])
    after = read_encodings(z(place))
    assert before is not None
    assert after is not None
    assert all("in the style of watercolor" in row.prompt for row in after.rows)
    assert (np.abs(before.matrix - after.matrix).max(axis=1) > 1e-4).all()


def test_learned_vectors_are_spliced(place: Path) -> None:
    seeded()
    made = {"z3": Made("inversion", "photo.png", "ViT-H-14/laion2b_s32b_b79k", "2026-11-22")}
    write_vectors(z(place), {"z3": np.full((2, 32), 0.3, np.float32)}, made)
    assert main(["embeddings", "beach.scene", "encode", "-q"]) == 0
    found = read_encodings(z(place))
    assert found is not None
    assert found.rows[1].prompt == "a <z3> moai, in the style of beach, 3D model"
    assert read_made(z(place)) == made
    assert list(read_z(z(place))[1]) == ["z3"]


def test_what_is_most_alike(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["embeddings", "beach.scene", "encode", "-q"])
    found = read_encodings(z(place))
    assert found is not None
    rows = said(capsys, "similar", "<z2>")
    cosines = [float(found.matrix[0] @ row) for row in found.matrix[1:]]
    assert [row["cosine"] for row in rows] == pytest.approx(sorted(cosines, reverse=True))
    same = said(capsys, "similar", "a weathered moai, in the style of beach, 3D model", "-n", "1")
    assert same[0]["cosine"] == pytest.approx(1.0, abs=1e-5)
    assert same[0]["handles"] == ["<z2>"]
    from PIL import Image

    Image.new("RGB", (40, 30), "red").save(place / "red.png")
    assert len(said(capsys, "similar", "red.png")) == 3
    assert main(["embeddings", "beach.scene", "similar", "<z2>"]) == 0
    assert "cosine" in capsys.readouterr().out


def test_handles_are_swapped(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["embeddings", "beach.scene", "set", "<z2>", "--text", "golden", "-q"])
    write_vectors(z(place), {"z3": np.ones((1, 32), np.float32)}, {"z3": Made("inversion", "a.png", "m", "t")})
    assert main(["embeddings", "beach.scene", "encode", "-q"]) == 0
    assert main(["embeddings", "beach.scene", "swap", "<z2>", "<z3>"]) == 0
    entries, vectors = read_z(z(place))
    assert entries["z3"].text == "golden"
    assert list(vectors) == ["z2"]
    assert list(read_made(z(place))) == ["z2"]
    assert read_encodings(z(place)) is None
    capsys.readouterr()
    assert main(["embeddings", "beach.scene", "swap", "<z7>", "<z8>"]) == 1
    assert "nothing to swap" in capsys.readouterr().err


@pytest.mark.parametrize("ending", [".npz", ".safetensors", ".json"])
def test_vectors_are_exported(ending: str, place: Path) -> None:
    from safetensors import safe_open

    write_vectors(z(place), {"z3": np.ones((1, 32), np.float32)}, {"z3": Made("inversion", "a.png", "m", "t")})
    main(["embeddings", "beach.scene", "encode", "-q"])
    assert main(["embeddings", "beach.scene", "export", "-o", f"out{ending}", "-q"]) == 0
    path, encodings = place / f"out{ending}", read_encodings(z(place))
    assert encodings is not None
    if ending == ".npz":
        with np.load(path) as arrays:
            matrix, learned, rows = arrays["encodings"], arrays["z3"], json.loads(str(arrays["rows"]))
    elif ending == ".json":
        data = json.loads(path.read_text("utf-8"))
        matrix, learned, rows = np.array(data["vectors"]["encodings"]), np.array(data["vectors"]["z3"]), data["rows"]
    else:
        with safe_open(str(path), framework="numpy") as file:
            matrix, learned, rows = (
                file.get_tensor("encodings"),
                file.get_tensor("z3"),
                json.loads(file.metadata()["rows"]),
            )
    assert np.allclose(matrix, encodings.matrix, atol=1e-6)
    assert np.array_equal(learned, np.ones((1, 32)))
    assert set(rows) == {"z2", "z3", "z4"}


def test_what_z_holds_stays(place: Path) -> None:
    """Each part of the file is written without the others changing."""
    main(["embed", "beach.scene", "-q"])
    wording = read_wording(z(place))
    main(["embeddings", "beach.scene", "encode", "-q"])
    write_vectors(z(place), {"z3": np.ones((1, 32), np.float32)}, {"z3": Made("inversion", "a.png", "m", "t")})
    encodings = read_encodings(z(place))
    main(["embeddings", "beach.scene", "set", "<z2>", "--text", "golden", "-q"])
    assert wording is not None
    assert read_wording(z(place)) == wording
    after = read_encodings(z(place))
    assert encodings is not None
    assert after is not None
    assert np.array_equal(after.matrix, encodings.matrix)
    assert list(read_z(z(place))[1]) == ["z3"]


@pytest.mark.parametrize(
    ("arguments", "code", "text"),
    [
        (["similar", "<z2>"], 1, "has not been encoded"),
        (["export", "-o", "a.npz"], 1, "the embeddings file does not exist"),
        (["export", "-o", "a.png"], 2, ".npz"),
        (["encode", "--models-dir", "nowhere"], 1, "the model directory nowhere does not exist"),
        (["encode", "--model", "ViT-Q/none", "--models-dir", "."], 1, "unknown OpenCLIP model `ViT-Q/none`"),
        (["encode", "--device", "tpu"], 1, "unknown device `tpu`"),
    ],
)
def test_mistakes(arguments: list[str], code: int, text: str, place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["embeddings", "beach.scene", *arguments]) == code
    assert text in capsys.readouterr().err


def test_absent_weights(place: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.delenv("SCENELANG_MODELS")
    monkeypatch.setenv("HF_HUB_CACHE", str(place))
    assert main(["embeddings", "beach.scene", "encode", "--offline"]) == 1
    error = capsys.readouterr().err
    assert "E707" in error
    assert "ViT-H-14" in error
    assert not z(place).exists()

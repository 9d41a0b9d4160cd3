"""`scenelang embed` on the command line."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from scenelang.cli.main import main
from scenelang.files.zfile import read_z
from scenelang.learning.stored_words import read_wording

PAWNS = """(bind "pawn" (lambda ((:color [.9 .9 .9])) (union (call "cone" :color color) (call "sphere" :color color))))
(bind "board" (lambda () (union-loop 4 (lambda (i) (transform (call "pawn") (translate [i 0 0]))))))
"""
Run = Callable[..., str]


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    monkeypatch.chdir(tmp_path)
    Path("a.scene").write_text(PAWNS)

    def command(*words: str, code: int = 0) -> str:
        capsys.readouterr()
        got = main(list(words))
        said = capsys.readouterr()
        assert got == code, said.err
        assert "Traceback" not in said.err
        return said.out if code == 0 else said.err

    return command


def test_writes_beside_the_program_and_evaluation_does_not_notice(run: Run) -> None:
    before = run("tree", "a.scene")
    assert run("embed", "a.scene") == "wrote a.z.safetensors: 1 text for 8 embeddings\n"
    path = Path("a.z.safetensors")
    wording = read_wording(path)
    assert wording is not None
    assert wording.rows[0].text == "ivory"
    assert read_z(path) == ({}, {})
    assert run("tree", "a.scene") == before


def test_the_table_and_its_data(run: Run) -> None:
    shown = run("embed", "a.scene", "--print")
    assert "the style is <z1>, board" in shown
    assert "a <z3> pawn, in the style of <z1>, 3D model" in shown
    data = json.loads(run("embed", "a.scene", "--print", "--json"))
    assert data["rows"][0]["plain"] == "an ivory pawn, 3D model"
    assert data["rows"][0]["handles"][:3] == ["<z3>", "<z4>", "<z6>"]
    assert not Path("a.z.safetensors").exists()


def test_nothing_is_written_over_without_force(run: Run) -> None:
    run("embed", "a.scene")
    Path("a.scene").write_text(PAWNS.replace(".9 .9 .9", "1 0 0").replace("4", "5"))
    assert "1 text" not in run("embed", "a.scene")
    wording = read_wording(Path("a.z.safetensors"))
    assert wording is not None
    assert [(row.text, row.handles) for row in wording.rows][1] == ("red", ("z15", "z16"))
    assert wording.rows[0].text == "ivory"
    assert "1 text for 10 embeddings\n" in run("embed", "a.scene", "--force")


def test_texts_set_by_hand_come_first_and_stay(run: Run) -> None:
    run("embeddings", "a.scene", "set", "<z3>", "--text", "chipped marble")
    run("embed", "a.scene")
    assert read_z(Path("a.z.safetensors"))[0]["z3"].text == "chipped marble"
    wording = read_wording(Path("a.z.safetensors"))
    assert wording is not None
    assert {row.text: row.handles for row in wording.rows}["chipped marble, ivory"] == ("z3",)
    run("embeddings", "a.scene", "set", "<z4>", "--text", "x")
    assert read_wording(Path("a.z.safetensors")) == wording


def test_another_file_and_standard_input(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    import io
    import sys

    run("embed", "a.scene", "--z", "b.safetensors")
    assert sorted(path.name for path in Path().iterdir()) == ["a.scene", "b.safetensors"]
    assert "--z" in run("embed", "-", code=2)
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(PAWNS.encode())))
    assert "wrote c.safetensors" in run("embed", "-", "--z", "c.safetensors")


def test_a_template_of_ones_own(run: Run) -> None:
    assert "pawn, <z3>, <z1>" in run("embed", "a.scene", "--print", "--template", "{word}, {embedding}, {style}")
    assert "{color}" in run("embed", "a.scene", "--template", "{embedding} {color}", code=2)
    assert not Path("a.z.safetensors").exists()


def test_wrong_programs_and_files(run: Run) -> None:
    Path("wrong.scene").write_text('(bind "a" (lambda () (cal "cube")))')
    run("embed", "wrong.scene", code=1)
    Path("a.z.safetensors").write_bytes(b"nonsense")
    assert "E704" in run("embed", "a.scene", code=1)
    assert "E704" in run("embed", "a.scene", "--force", code=1)  # a file that is something else is not replaced


def test_a_finished_scene_has_no_z(run: Run) -> None:
    run("export", "a.scene", "-o", "a.json", "-q")
    assert "a.json is a flattened scene and cannot have embeddings" in run("embed", "a.json", code=1)
    assert "ivory" in run("embed", "a.json", "--print")


def test_too_many_primitives(run: Run) -> None:
    assert "--max-primitives" in run("embed", "a.scene", "--max-primitives", "3", code=1)

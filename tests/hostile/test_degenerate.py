"""Every command with scenes that have nothing to draw, measure or write: an answer or a diagnostic, no internal error."""

from __future__ import annotations

import random
import time
from pathlib import Path

import pytest
from relations.test_degenerate import SCENES

from scenelang.cli.main import main

PROGRAMS = {
    **SCENES,
    "nothing": '(bind "a" (lambda () (list)))',
    "empty film": '(bind "a" (lambda () (frames (list (union) (union)))))',
    "light only": '(light :position [1 2 3] :power 5)(bind "a" (lambda () (union)))',
    "nan": '(bind "a" (lambda () (transform (call "cube") (translate [nan 0 0]))))',
    "mirrored": '(bind "a" (lambda () (transform (call "cube" :texture "brick") (reflect [0 0 0] [1 0 0]))))',
    "line": '(bind "a" (lambda () (call "cube" :scale [1 0 0])))',
    "thin solid": '(bind "a" (lambda () (difference (call "cube") (call "cube" :scale [.9999999 2 2]))))',
    "camera inside": '(camera "c" :eye [0 0 0] :look-at [0 0 .001])(bind "a" (lambda () (call "cube" :scale 5)))',
}
COMMANDS = """
run F | check F --run --geometry | check F --physics | tree F | count F | flatten F | expand F | measure F
render F -o o.png --size 64x48 | render F -o o.png --size 64x48 --quality final --samples 2
render F -o o.gif --size 64x48 --frames 3 | render F -o o.png --size 64x48 --environment sky --ground checker
render F -o o.png --size 64x48 --ground transparent | render F -o o.png --size 64x48 --section z=0
render F -o o.png --size 64x48 --explode 1 | render F -o o.png --size 64x48 --outlines on
render F -o o.png --size 64x48 --dimensions on | export F -o o.glb | export F -o o.obj | export F -o o.stl
export F -o o.ply | export F -o o.usda | export F -o o.usdz | export F -o o.3mf | export F -o o.off | export F -o o.json
export F -o o.xml | export F -o o.schem | export F -o o.mcfunction | export F -o o.scad
export F -o o.py --to python | export F -o o.py --to bpy | export F -o o.xml --to mjcf | export F -o o.glb --solid
export F -o o.stl --solid | export F -o o.glb --draco | labels F -o lab --size 64x48 | graph F -o o.svg --thumbnails
simulate F -o o.glb | settle F -o o.scene | repair F | simplify F | view F --html o.html | diff F F | embeddings F list
"""
CASES = [" ".join(command.split()) for line in COMMANDS.splitlines() for command in line.split("|") if command.strip()]


def _answers(command: str, program: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "f.scene").write_text(program)
    words = [word if word != "F" else "f.scene" for word in command.split()]
    try:
        code = main(words)
    except SystemExit as end:
        code = int(end.code or 0)
    said = capsys.readouterr().err
    assert "internal error" not in said, said
    assert "Traceback" not in said
    assert code in (0, 1, 2)
    assert code == 0 or said or command.startswith("diff"), "a failure says why"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("SCENELANG_TRACEBACK", raising=False)
    return tmp_path


@pytest.mark.parametrize("command", CASES)
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_a_command_has_an_answer(command: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Three of the programs, others each week."""
    drawn = random.Random(f"{command} {int(time.time() // 604_800)}")
    for name in drawn.sample(sorted(PROGRAMS), 3):
        _answers(command, PROGRAMS[name], folder, capsys)


@pytest.mark.slow
@pytest.mark.parametrize("command", CASES)
@pytest.mark.parametrize("name", PROGRAMS)
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_every_command_has_an_answer(name: str, command: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _answers(command, PROGRAMS[name], folder, capsys)

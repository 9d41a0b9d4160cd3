"""Pictures of operands that are no solids, which ``check --run --picture`` writes."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from scenelang.cli.main import main

OPEN = """
(bind "part" (lambda ()
  (difference (call "cube") (mesh [[0 0 0] [1 0 0] [0 1 0] [0 0 1]] [[0 2 1] [0 1 3] [0 3 2]]))))
"""
SEMANTIC = '(bind "part" (lambda () (difference (call "cube") (call "old oak chair" :scale [1 2 1]))))'
BLOCK = '(bind "part" (lambda () (difference (call "cube") (call "set-cuboid" :block-type "stone" :scale [2 3 1]))))'


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def reds(path: Path) -> int:
    """Return the number of red pixels."""
    pixels = np.asarray(Image.open(path).convert("RGB"), np.int64)
    return int(((pixels[:, :, 0] > 120) & (pixels[:, :, 1:].max(axis=2) < 60)).sum())


@pytest.mark.parametrize(("program", "marked"), [(OPEN, True), (SEMANTIC, False), (BLOCK, False)])
@pytest.mark.sampled(3)
def test_the_operand_is_shown(program: str, marked: bool, capsys: pytest.CaptureFixture[str]) -> None:
    Path("a.scene").write_text(program)
    assert main(["check", "--run", "--picture", "a.png", "a.scene"]) == 1
    told = capsys.readouterr().err
    assert "E611" in told
    assert "the operand is shown in a.png" in told
    assert Image.open("a.png").size == (640, 480)
    assert (reds(Path("a.png")) > 200) == marked


def test_there_is_no_picture_without_an_operand() -> None:
    Path("a.scene").write_text('(bind "part" (lambda () (call "cube" :scale (/ 1 0))))')
    assert main(["check", "--run", "--picture", "a.png", "a.scene"]) == 1
    assert not Path("a.png").exists()


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--picture", "a.png"], "--picture requires --run"),
        (["--run", "--picture", "a.jpg"], "--picture writes PNG files"),
        (["--run", "--picture", "none/a.png"], "does not exist"),
    ],
)
def test_wrong_use(arguments: list[str], told: str, capsys: pytest.CaptureFixture[str]) -> None:
    Path("a.scene").write_text(OPEN)
    assert main(["check", *arguments, "a.scene"]) == (1 if "none" in arguments[-1] else 2)
    assert told in capsys.readouterr().err

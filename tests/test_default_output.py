"""`render` and `export` without `-o`: a file beside the program, which replaces none that scenelang did not write."""

from __future__ import annotations

from pathlib import Path

import pytest

from scenelang.cli.main import main

SCENE = '(bind "a" (lambda () (call "cube")))'
SMALL = ["--size", "32x24"]


@pytest.fixture(autouse=True)
def _program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.scene").write_text(SCENE)


@pytest.mark.parametrize(
    ("words", "name"),
    [
        (["render", "a.scene", *SMALL], "a.png"),
        (["render", "a.scene", *SMALL, "--frames", "2"], "a.gif"),
        (["export", "a.scene"], "a.glb"),
    ],
)
def test_it_stands_beside_the_program_and_may_be_written_again(
    words: list[str], name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(words) == 0
    assert capsys.readouterr().out == f"wrote {name}\n"
    first = Path(name).read_bytes()
    assert main(words) == 0
    assert Path(name).read_bytes() == first


@pytest.mark.parametrize(("word", "name"), [("render", "a.png"), ("export", "a.glb")])
@pytest.mark.parametrize("found", [b"", b"mine", b"glTF" + b"\0" * 40])
def test_files_of_others_are_not_replaced(
    word: str, name: str, found: bytes, capsys: pytest.CaptureFixture[str]
) -> None:
    Path(name).write_bytes(found)
    assert main([word, "a.scene"]) == 2
    error = capsys.readouterr().err
    assert f"`{name}` exists and was not written by scenelang" in error
    assert f"`-o {name}`" in error
    assert Path(name).read_bytes() == found
    assert main([word, "a.scene", "-o", name, *(SMALL if word == "render" else ())]) == 0


def test_an_image_of_another_program_is_not_replaced(capsys: pytest.CaptureFixture[str]) -> None:
    from PIL import Image

    Image.new("RGB", (2, 2)).save("a.png")
    assert main(["render", "a.scene", *SMALL]) == 2
    assert "not written by scenelang" in capsys.readouterr().err


@pytest.mark.parametrize("word", ["render", "export"])
def test_standard_input_needs_a_name(word: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([word, "-"]) == 2
    assert "needs `-o`" in capsys.readouterr().err

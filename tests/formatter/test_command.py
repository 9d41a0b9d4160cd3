"""The command fmt."""

from __future__ import annotations

import io
import json
import os
import sys
from pathlib import Path

import pytest

from scenelang.cli.main import main
from scenelang.grammar import formatter

UGLY, FINE, BROKEN = "(define   x 1)\n", "(define x 1)\n", "(define x\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "sub").mkdir()
    (tmp_path / ".hidden").mkdir()
    (tmp_path / "ugly.scene").write_text(UGLY)
    (tmp_path / "sub" / "fine.scene").write_text(FINE)
    (tmp_path / ".hidden" / "no.scene").write_text(UGLY)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def given(monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(text.encode("utf-8"))))


def test_files_are_rewritten(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = os.stat("sub/fine.scene")
    assert main(["fmt", ".", "ugly.scene"]) == 0
    assert capsys.readouterr().out == "formatted ugly.scene\n"
    assert (folder / "ugly.scene").read_text() == FINE
    assert os.stat("sub/fine.scene") == before or os.stat("sub/fine.scene").st_mtime_ns == before.st_mtime_ns
    assert (folder / ".hidden" / "no.scene").read_text() == UGLY
    assert main(["fmt", "."]) == 0
    assert capsys.readouterr().out == ""
    assert [path.name for path in folder.iterdir() if path.name.startswith(".scenelang")] == []


def test_check(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fmt", "--check", "ugly.scene", "sub"]) == 1
    assert capsys.readouterr().out == "would format ugly.scene\n"
    assert (folder / "ugly.scene").read_text() == UGLY
    assert main(["fmt", "--check", "sub"]) == 0


def test_diff(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fmt", "--diff", "ugly.scene", "sub"]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "--- ugly.scene",
        "+++ ugly.scene (formatted)",
        "@@ -1 +1 @@",
        "-(define   x 1)",
        "+(define x 1)",
    ]
    assert main(["fmt", "--diff", "--check", "ugly.scene"]) == 1
    assert (folder / "ugly.scene").read_text() == UGLY


def test_a_file_that_does_not_read_is_left_and_the_others_are_done(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "broken.scene").write_text(BROKEN)
    (folder / "bytes.scene").write_bytes(b"(a\n \xff)")
    assert main(["fmt", "broken.scene", "bytes.scene", "missing.scene", "ugly.scene"]) == 1
    out, err = capsys.readouterr()
    assert out == "formatted ugly.scene\n"
    assert "broken.scene:1:1" in err
    assert "bytes.scene is not UTF-8 text (line 2, byte 5)" in err
    assert "there is no file missing.scene" in err
    assert (folder / "broken.scene").read_text() == BROKEN
    assert (folder / "ugly.scene").read_text() == FINE


@pytest.mark.parametrize("name", ["answer.txt", "program.py", "scene.json"])
def test_what_is_no_program_is_refused(name: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / name).write_text("(a   b)")
    assert main(["fmt", name]) == 1
    assert "E706" in capsys.readouterr().err
    assert (folder / name).read_text() == "(a   b)"


def test_standard_input(monkeypatch: pytest.MonkeyPatch, capfdbinary: pytest.CaptureFixture[bytes]) -> None:
    given(monkeypatch, "\ufeff(a   b)\r\n(c)\r\n")
    assert main(["fmt", "-"]) == 0
    assert capfdbinary.readouterr().out == "\ufeff(a b)\r\n(c)\r\n".encode()
    given(monkeypatch, UGLY)
    assert main(["fmt", "-", "--check"]) == 1
    given(monkeypatch, BROKEN)
    assert main(["fmt", "-"]) == 1
    out, err = capfdbinary.readouterr()
    assert out == b""
    assert b"<stdin>:1:1" in err


def test_lines(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "ugly.scene").write_text(UGLY * 3)
    assert main(["fmt", "ugly.scene", "--lines", "2:2"]) == 0
    assert (folder / "ugly.scene").read_text() == UGLY + FINE + UGLY
    assert main(["fmt", "ugly.scene", "sub", "--lines", "2:2"]) == 2
    for wrong in ("3:2", "0:1", "a:b", "5"):
        with pytest.raises(SystemExit) as caught:
            main(["fmt", "ugly.scene", "--lines", wrong])
        assert caught.value.code == 2
    capsys.readouterr()


def test_permissions_and_links_stay(folder: Path) -> None:
    target = folder / "ugly.scene"
    target.chmod(0o640)
    (folder / "link.scene").symlink_to("ugly.scene")
    assert main(["fmt", "-q", "link.scene"]) == 0
    assert (folder / "link.scene").is_symlink()
    assert target.read_text() == FINE
    assert target.stat().st_mode & 0o777 == 0o640


def test_json(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "broken.scene").write_text(BROKEN)
    assert main(["fmt", "--json", "--check", "ugly.scene", "sub", "broken.scene"]) == 1
    data = json.loads(capsys.readouterr().out)
    assert data["files"] == [
        {"file": "ugly.scene", "changed": True, "formatted": True},
        {"file": "sub/fine.scene", "changed": False, "formatted": True},
        {"file": "broken.scene", "changed": False, "formatted": False},
    ]
    assert [diagnostic["name"] for diagnostic in data["diagnostics"]] == ["unclosed"]


def test_a_folder_without_programs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fmt", str(tmp_path)]) == 1
    assert "no programs (.scene)" in capsys.readouterr().err


def test_a_fault_leaves_the_file_alone(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(formatter, "layout_lines", lambda *_, **__: ["(define y 1)"])
    assert main(["fmt", "ugly.scene"]) == 1
    assert "internal error" in capsys.readouterr().err
    assert (folder / "ugly.scene").read_text() == UGLY

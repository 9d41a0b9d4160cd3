"""Every mistake that has a code, with all that the command line says about it.

``tests/bad/<code>-<slug>.scene`` (a ``.py`` of a language model, or a folder with a ``main.scene``) is the program,
``.txt`` beside it the whole standard error. Comments in its first lines say what differs from ``scenelang run FILE``: ``; command: check --strict``,
``; args: --max-steps 10k``, and ``; before: embeddings set <z9> --text gold`` for a command to run first.
``SCENELANG_UPDATE_GOLDENS=1`` writes the goldens anew: read them before they are committed.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
from pathlib import Path

import pytest

from scenelang.cli.main import main
from scenelang.grammar.diagnostics import CODES

BAD = Path(__file__).parent / "bad"
UPDATE = bool(os.environ.get("SCENELANG_UPDATE_GOLDENS"))
CASES = sorted(p for p in BAD.iterdir() if p.suffix in (".scene", ".py") or (p / "main.scene").exists())

# Codes that no program shows by itself, with the test that does, or the reason.
ELSEWHERE = {
    "E508": "an interruption comes from outside: tests/test_cli.py",
    "E510": "an evaluation is blocked from outside: tests/sandbox",
    "E509": "no program ends its process: tests/sandbox",
    "E707": "weights are no program: tests/clip",
    "E708": "a simulation is needed: tests/physics",
    **{f"E{number}": "a model's service, a run or a prompt is needed: tests/models" for number in range(901, 911)},
    **dict.fromkeys(["E921", "E922"], "a spec and a dataset are needed: tests/datasets"),
    **dict.fromkeys(["W618", "W620"], "a file or a version is needed: tests/minecraft"),
    **dict.fromkeys(["W621", "W622"], "a text-to-image model's layout, its vectors: tests/imagine"),
    **dict.fromkeys(["E811", "E812", "W806"], "an OpenSCAD program is needed: tests/openscad"),
    **dict.fromkeys(["E821", "W807"], "a Blender script is needed: tests/blender"),
    "W644": "reported by exports: tests/blender/test_export.py",
    "N628": "a guess among siblings is needed: tests/geometry_lint/test_intention.py",
    "W643": "the estimate of a large file: tests/exports/test_meshes.py",
    "W625": "a hundred findings are needed: tests/lint/test_caps.py",
    "W619": "it is about looks of the game: tests/deepslate/test_looks.py",
    "W802": "a response is text, as the goldens here are: tests/transpile/test_command.py",
}
_DIRECTIVE = re.compile(r"[;#] (command|args|before): (.*)")


def _directives(program: Path) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    for line in program.read_bytes().decode("utf-8", "replace").splitlines():
        match = _DIRECTIVE.fullmatch(line)
        if match is None:
            break
        found[match[1]] = shlex.split(match[2])
    return found


@pytest.fixture
def place(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder ``project`` of its own that holds the case; commands run in it."""
    case: Path = request.param
    folder = tmp_path / "project"
    if case.is_dir():
        shutil.copytree(case, folder)
    else:
        folder.mkdir()
        shutil.copy(case, folder / case.name)
    monkeypatch.chdir(folder)
    monkeypatch.setenv("COLUMNS", "100")
    return folder


def _command(words: list[str], file: str, arguments: list[str]) -> list[str]:
    return [words[0], file, *words[1:], *arguments]


@pytest.mark.parametrize(("place", "case"), [(c, c) for c in CASES], indirect=["place"], ids=lambda c: c.stem)
def test_what_the_user_sees(place: Path, case: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = "main.scene" if case.is_dir() else case.name
    asked = _directives(place / file)
    if "--physics" in asked.get("command", []):
        pytest.importorskip("mujoco")
    if "before" in asked:
        assert main(_command(asked["before"], file, [])) == 0
        capsys.readouterr()
    exit_code = main(_command(asked.get("command", ["run"]), file, asked.get("args", [])))
    said = capsys.readouterr().err.replace(str(place), "/project")
    if "W501" in case.name:
        said = said[said.index("warning[") :]  # the log itself is 100,000 lines
    golden = case.with_suffix(".txt") if case.is_file() else BAD / f"{case.name}.txt"
    if UPDATE:
        golden.write_text(said, "utf-8")
    code = case.name.partition("-")[0]
    assert f"[{code}]" in said
    wrong = 2 if code == "E705" else 1  # a file ending that no backend writes is wrong usage, whatever the program
    assert exit_code == (wrong if code.startswith("E") else 0)
    assert "Traceback" not in said
    assert said == golden.read_text("utf-8")


def test_every_code_has_a_program() -> None:
    shown = {case.name.partition("-")[0] for case in CASES}
    known = {code.code for code in CODES.values()}
    assert shown <= known
    assert known - shown == set(ELSEWHERE)


def test_no_golden_without_a_program() -> None:
    assert {p.stem for p in BAD.glob("*.txt")} == {c.stem for c in CASES}


def test_codes_are_unique_and_explained() -> None:
    codes = [code.code for code in CODES.values()]
    assert len(set(codes)) == len(codes)
    assert all(re.fullmatch(r"[EWN]\d{3}", code.code) and code.why.endswith(".") for code in CODES.values())

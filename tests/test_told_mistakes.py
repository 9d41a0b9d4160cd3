"""Mistakes on the command line and in files are told by what they are: options given twice, words that do not occur,
keys of specs, meshes where programs are expected, and extras in the report of `doctor`."""

from __future__ import annotations

import json
import re
import tomllib
from collections import Counter
from collections.abc import Callable
from importlib.metadata import distribution
from itertools import product
from pathlib import Path

import pytest

import scenelang as sl
from scenelang.cli.main import main
from scenelang.doctor import doctor

PROGRAM = """
(bind "a" (lambda () (union (call "cube") (transform (call "ball") (translate [2 0 0])))))
(bind "ball" (lambda () (call "sphere")))
"""
FRAMES = '(bind "film" (lambda () (list (call "cube") (call "sphere"))))'
Run = Callable[..., tuple[int, str]]


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """The exit code of a command in a folder with programs, and what it says of mistakes."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.scene").write_text(PROGRAM)
    (tmp_path / "film.scene").write_text(FRAMES)

    def go(*words: str) -> tuple[int, str]:
        try:
            code = main(list(words))
        except SystemExit as end:
            code = int(str(end.code))
        return code, capsys.readouterr().err

    return go


@pytest.mark.parametrize(("old", "today"), [("maps", "labels"), ("lift", "simplify")])
def test_a_command_of_earlier_versions_names_that_of_today(old: str, today: str, run: Run) -> None:
    assert run(old, "a.scene") == (2, f"scenelang: error: use `scenelang {today}`\n")


# --- options given twice ---------------------------------------------------------------------------------------------

VIEWS = ("top", "isometric", "azimuth=40,elevation=20", "azimuth=41")
TWICE = [
    ("render a.scene -o a.png --size 16x16", "--camera", VIEWS),
    ("render film.scene -o a.png --size 16x16", "--frame", ("0", "1")),
    ("bounds a.scene", "--word", ("ball", "cube", "sphere")),
    ("measure a.scene", "--word", ("ball", "cube")),
]


@pytest.mark.parametrize(("command", "option", "values"), TWICE)
def test_two_different_values_are_a_usage_error(command: str, option: str, values: tuple[str, ...], run: Run) -> None:
    for one, other in product(values, repeat=2):
        for words in ([option, one, option, other], [f"{option}={one}", f"{option}={other}"]):
            code, said = run(*command.split(), *words)
            assert code == (0 if one == other else 2), (words, said)
            assert (f"argument {option}: it is given twice" in said) == (one != other)
            assert "Traceback" not in said


def test_the_error_comes_before_all_else(run: Run, tmp_path: Path) -> None:
    (tmp_path / "wrong.scene").write_text("(bind")
    for file in ("wrong.scene", "absent.scene"):
        words = ["-o", "b.png", "--camera", "top", "--camera", "isometric"]
        for command in ("render", "simulate", "imagine"):
            code, said = run(command, file, *words)
        assert code == 2
        assert "given twice" in said
    assert not (tmp_path / "b.png").exists()


def test_maps_take_several_cameras(run: Run, tmp_path: Path) -> None:
    code, said = run("labels", "a.scene", "-o", "m", "--size", "16x16", "--camera", "top", "--camera", "isometric")
    assert (code, said) == (0, said)
    assert sorted(each.name for each in (tmp_path / "m").iterdir() if each.is_dir()) == [
        "camera-000",
        "camera-001",
    ]


# --- words that do not occur -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("command", ["bounds", "measure"])
@pytest.mark.parametrize("word", ["nothing", "bal", "Ball", "", "a b", 'quo"te', "b\u00e4ll"])
def test_a_word_that_does_not_occur(command: str, word: str, run: Run) -> None:
    code, said = run(command, "a.scene", "--word", word)
    assert code == 1
    assert re.match(r"error\[E\d{3}\]: no entity has the word ", said)
    assert word in said.splitlines()[0]
    assert ("did you mean `ball`?" in said) == (word in ("bal", "b\u00e4ll"))
    assert ('the word is "ball": upper and lower case differ' in said) == (word == "Ball")
    code, said = run(command, "a.scene", "--word", word, "--json")
    (told,) = json.loads(said)
    assert (code, told["message"]) == (1, f'no entity has the word "{word}"')


@pytest.mark.parametrize("word", ["a", "ball", "cube", "sphere"])
def test_words_that_occur(word: str, run: Run) -> None:
    assert run("bounds", "a.scene", "--word", word) == (0, "")


# --- keys of specs ---------------------------------------------------------------------------------------------------

SPECS = {
    'program = "a.scene"': "programs", 'programs = ["a.scene"]\ncounts = 3': "count", 'programs = ["a.scene"]\n[param]\nx = 1': "params",
    'programs = ["a.scene"]\n[camera]\nviews = 2': "cameras", 'programs = ["a.scene"]\n[cameras]\nview = 2': "views",
    'programs = ["a.scene"]\n[labels]\nwords = ["a"]\nwrites = ["depth"]': "write", 'programs = ["a.scene"]\n[output]\nformat = ["coco"]': "formats",
    'programs = ["a.scene"]\n[pictures]\nsizes = [9, 9]': "size", 'programs = ["a.scene"]\n[words.ball]\ncolour = ["red"]': "color",
    'programs = ["a.scene"]\n[words.cubee]\ncolor = ["red"]': "cube",
}  # fmt: skip


@pytest.mark.parametrize("spec", SPECS)
def test_keys_of_a_spec(spec: str, run: Run, tmp_path: Path) -> None:
    (tmp_path / "d.toml").write_text(spec)
    code, said = run("dataset", "d.toml", "-o", "out")
    assert code == 1
    assert f"did you mean `{SPECS[spec]}`?" in said
    assert re.search(r"error\[E\d{3}\].*\n +--> d.toml:\d+:\d+", said)
    assert not (tmp_path / "out").exists()


# --- meshes where programs are expected ------------------------------------------------------------------------------

COMMANDS = ["run", "import", "check", "render", "bounds", "count", "tree", "measure", "flatten", "export", "labels", "simplify", "expand", "diff"]  # fmt: skip
OUTPUTS = {"render": "x.png", "export": "x.ply", "labels": "x"}


@pytest.mark.parametrize("ending", ["glb", "gltf", "obj", "stl", "ply", "GLB"])
@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.sampled(3)
def test_a_mesh_is_no_program(command: str, ending: str, run: Run, tmp_path: Path) -> None:
    name = f"a mesh.{ending}"
    sl.evaluate(PROGRAM).export(tmp_path / f"m.{ending.lower()}")
    (tmp_path / f"m.{ending.lower()}").rename(tmp_path / name)
    words = [command, name, *(["a.scene"] if command == "diff" else [])]
    code, said = run(*words, *(["-o", OUTPUTS[command]] if command in OUTPUTS else []))
    assert code == 1
    assert re.search(r"error\[E\d{3}\]: `a mesh.\w+` is a mesh, not a program", said), said
    assert f'(call "mesh" :file "{name}")' in said
    assert (tmp_path / name).stat().st_size > 100


@pytest.mark.parametrize("ending", ["glb", "obj", "stl"])
def test_what_is_named_is_right(ending: str, run: Run, tmp_path: Path) -> None:
    """A program with the call that is named draws the mesh, and importing the mesh names the same call."""
    sl.evaluate(PROGRAM).export(tmp_path / f"m.{ending}")
    (tmp_path / "b.scene").write_text(f'(import "m.{ending}")\n(bind "b" (lambda () (call "cube")))')
    for command in ("check", "run"):
        code, said = run(command, "b.scene")
        assert code == 1
        assert "b.scene:1:" in said
        named = re.search(r"`(\(call .*\))`", said)
        assert named is not None
        (tmp_path / "c.scene").write_text(f'(bind "c" (lambda () {named[1]}))')
        assert run(command, "c.scene") == (0, "")
    assert sl.load(tmp_path / "c.scene").bounds[1][0] == pytest.approx(3.0, abs=1e-3)


# --- doctor ----------------------------------------------------------------------------------------------------------


def test_doctor_prints_every_extra_once(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr("scenelang.doctor.doctor.work_checks", lambda: iter(()))
    main(["doctor"])
    shown = capsys.readouterr().out
    block = shown.partition("\nExtras\n")[2].partition("\nServices\n")[0]
    printed = Counter(line.split()[1] for line in block.splitlines())
    table = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text())["project"][
        "optional-dependencies"
    ]
    packages = {name: [each for each in needed if not each.startswith("scenelang[")] for name, needed in table.items()}
    wanted = {name for name, needed in packages.items() if needed} - {"dev", "blender"}
    assert printed == Counter(wanted)
    assert wanted <= set(distribution("scenelang").metadata.get_all("Provides-Extra") or ())


def test_an_extra_that_is_stated_in_pieces_is_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """As tools write metadata: names in other orders, several markers, extras of extras."""
    stated = ["numpy>=2", 'torch>=2; extra == "neural"', 'ray; extra == "cluster"', 'numba; extra == "neural"', 'scenelang[neural]; extra == "all"', "av ; (sys_platform == 'linux') and extra == 'neural'"]  # fmt: skip
    monkeypatch.setattr(doctor, "requires", lambda name: stated)
    names = [check.name for check in doctor.package_checks() if check.topic == "extras"]
    assert names == ["neural", "cluster"]

"""Every command of the command line: what it prints, its options, exit codes, pipes, folders, interruptions."""

from __future__ import annotations

import io
import json
import os
import shlex
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from searching import many
from support import interruptible, wait_for_work

from scenelang import Limits, Options, Session, Source
from scenelang.cli.main import COMMANDS, main
from scenelang.grammar.diagnostics import render_text, to_json

TABLE = """; a table with four legs
(param height 2 "metres" :min 1 :max 3)
(bind "leg" (lambda (:h) (call "cube" :scale [0.1 h 0.1] :color [0.5 0.25 0])))
(bind "table"
  (lambda ()
    (print "making a table")
    (union
      (transform (call "top") (translate [0 height 0]))
      (union-loop 4 (lambda (i) (transform (call "leg" :h height) (translate [i 0 0])))))))
(bind "top" (lambda () (call "cube" :scale [4 0.1 2])))
(scene "table")
"""
BROKEN = '(bind "a" (lambda () (call "cube" :scale (+ 1 "2"))))\n'
UNPROVEN = '(bind "a" (lambda () (call "cube" :scale (+ 1 (ref (list 1 "2") 1)))))\n'
UNREAD = '(bind "a" (lambda () (call "cube"))\n'
ENDLESS = "(define (f n) (f (+ n 1)))\n(f 0)\n" + '(bind "a" (lambda () (call "cube")))\n'


class Shell:
    """Runs commands in process in a folder of their own."""

    def __init__(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        self.folder = folder
        self.capsys = capsys
        self.err = ""

    def write(self, name: str, text: str | bytes) -> None:
        (self.folder / name).write_bytes(text if isinstance(text, bytes) else text.encode())

    def __call__(self, *words: str, code: int = 0) -> str:
        """What the command prints on standard output; standard error is kept in ``err``."""
        self.capsys.readouterr()
        got = main(list(words))
        captured = self.capsys.readouterr()
        self.err = captured.err
        assert got == code, captured.err
        assert "Traceback" not in captured.err
        return captured.out

    def json(self, *words: str, code: int = 0) -> Any:
        return json.loads(self(*words, "--json", code=code))

    def usage(self, *words: str) -> str:
        """What wrong usage prints."""
        with pytest.raises(SystemExit) as caught:
            main(list(words))
        assert caught.value.code == 2
        return self.capsys.readouterr().err


@pytest.fixture
def shell(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Shell:
    monkeypatch.chdir(tmp_path)
    made = Shell(tmp_path, capsys)
    made.write("table.scene", TABLE)
    made.write("broken.scene", BROKEN)
    made.write("unproven.scene", UNPROVEN)
    made.write("unread.scene", UNREAD)
    return made


def process(*words: str, folder: Path, **more: Any) -> subprocess.CompletedProcess[bytes]:
    command = [sys.executable, "-m", "scenelang", *words]
    return subprocess.run(command, cwd=folder, capture_output=True, check=False, **more)


EVALUATING = ("run", "tree", "flatten", "count", "bounds", "expand")
ROW = """(param height 1 "metres")
(bind "row" (lambda () (union-loop 3 (lambda (i) (transform (call "post" :h height) (translate [(* 4 i) 0 0]))))))
(bind "post" (lambda ((:h 1)) (union (call "cube" :scale [1 h 1] :color [1 0 0]) (call "cylinder" :radius (random)))))
(scene "row")
"""


# --- what commands say ---------------------------------------------------------------------------------------------


def test_check(shell: Shell) -> None:
    assert shell("check", "table.scene") == ""
    assert shell.err == ""
    assert shell("check", "table.scene", "unread.scene", code=1) == ""
    assert "E101" in shell.err
    found = shell.json("check", "unread.scene", code=1)
    assert [d["code"] for d in found] == ["E101"]
    assert found[0]["place"] == {"file": "unread.scene", "line": 1, "column": 1, "end_line": 1, "end_column": 2}
    assert shell.json("check", "table.scene") == []
    assert [d["code"] for d in shell.json("check", "table.scene", "--strict", code=1)] == ["E210"]
    assert shell("check", "broken.scene", code=1) == ""
    assert "E401" in shell.err
    assert shell("check", "unproven.scene") == "", "check does not run the program"
    shell("check", "nothing.scene", code=1)
    assert "E701" in shell.err
    shell("check", "nothing.scene", "unread.scene", code=1)
    assert "E701" in shell.err
    assert "E101" in shell.err, "a file that is missing does not hide the others"


def test_check_and_run(shell: Shell) -> None:
    shell("check", "--run", "unproven.scene", code=1)
    assert "E401" in shell.err
    assert shell("check", "--run", "table.scene") == ""


def test_run(shell: Shell) -> None:
    said = shell("run", "table.scene")
    assert "making a table" in shell.err
    facts = dict(line.split(None, 1) for line in said.splitlines())
    assert facts["root"] == "table"
    assert [facts[name] for name in ("entities", "instances", "primitives")] == ["5", "11", "5"]
    assert (facts["min"], facts["max"]) == ("[-2 -1 -1]", "[3.05 2.05 1]")
    assert facts["time"].endswith(" s")
    assert shell("run", "broken.scene", code=1) == ""
    assert "E401" in shell.err


def test_run_json(shell: Shell) -> None:
    assert shell("run", "broken.scene", "--json", code=1) == ""
    assert [d["code"] for d in json.loads(shell.err)] == ["E401"]
    found = shell.json("run", "table.scene")
    assert (found["root"], found["entities"], found["instances"], found["primitives"]) == ("table", 5, 11, 5)
    assert found["bounds"]["min"] == [-2, -1, -1]


def test_tree(shell: Shell) -> None:
    said = shell("tree", "table.scene")
    lines = said.splitlines()
    assert lines[0] == "table <z1>"
    assert any("4 x leg" in line for line in lines)
    assert len(shell("tree", "table.scene", "--depth", "0").splitlines()) == 2
    assert len(shell("tree", "table.scene", "--depth", "1").splitlines()) == 5
    assert shell("tree", "table.scene", "--all").count("leg") == 4
    assert "2" in shell("tree", "table.scene", "--poses")
    data = shell.json("tree", "table.scene")
    assert data["word"] == "table"
    assert data["handle"] == "<z1>"


def test_flatten(shell: Shell) -> None:
    assert shell("flatten", "table.scene").startswith("5 primitives")
    data = shell.json("flatten", "table.scene")
    assert data["root"] == "table"
    (frame,) = data["frames"]
    first, *legs = frame["primitives"]
    assert first == {
        "word": "cube", "attributes": {"scale": [4, 0.1, 2], "color": [1, 1, 1]}, "handle": "<z3>",
        "matrix": [[1, 0, 0, 0], [0, 1, 0, 2], [0, 0, 1, 0], [0, 0, 0, 1]], "path": ["table", "top"],
    }  # fmt: skip
    assert [leg["matrix"][0][3] for leg in legs] == [0, 1, 2, 3]
    assert [leg["handle"] for leg in legs] == ["<z5>", "<z7>", "<z9>", "<z11>"]


def test_count_and_bounds(shell: Shell) -> None:
    assert shell.json("count", "table.scene") == {"table": 1, "top": 1, "cube": 5, "leg": 4}
    assert "4  leg" in shell("count", "table.scene")
    box = shell.json("bounds", "table.scene")
    assert box["min"] == pytest.approx([-2, -1, -1])
    assert box["max"] == pytest.approx([3.05, 2.05, 1])
    assert box["center"] == pytest.approx([0.525, 0.525, 0])
    assert box["sizes"] == pytest.approx([5.05, 3.05, 2])
    assert shell.json("bounds", "table.scene", "--word", "leg")["max"] == pytest.approx([3.05, 1, 0.05])
    shell("bounds", "table.scene", "--word", "nothing", code=1)
    assert 'no entity has the word "nothing"' in shell.err
    assert "min" in shell("bounds", "table.scene")


def test_diff(shell: Shell) -> None:
    shell.write("row.scene", ROW)
    shell.write("row.json", shell("flatten", "row.scene", "--json"))
    for sides in (("row.scene", "row.scene"), ("row.json", "row.scene"), ("row.json", "row.json")):
        assert shell("diff", *sides) == "equal: 6 primitives\n"
        assert shell.json("diff", *sides) == {
            "equal": True, "frames": {"a": 1, "b": 1}, "matched": 6,
            "moved": 0, "recolored": 0, "missing": 0, "extra": 0, "changes": [],
        }  # fmt: skip
    assert "equal" not in shell("diff", "row.json", "row.scene", "--seed", "1", code=1)
    assert "equal" in shell("diff", "row.json", "row.scene", "--tolerance", "0.9", "--seed", "1")
    assert shell("diff", "row.json", "row.scene", "--define", "height=2", code=1) == (
        "different: 3 matched, 3 missing, 3 extra\ncube\n"
        "  missing row/post[0] at [0 0 0]\n  missing row/post[2] at [4 0 0]\n  missing row/post[4] at [8 0 0]\n"
        "  extra row/post[0] at [0 0 0]\n  extra row/post[2] at [4 0 0]\n  extra row/post[4] at [8 0 0]\n"
    )
    assert shell("diff", "row.json", "row.scene", "--root", "post", code=1).startswith("different")


def test_diff_names_changes(shell: Shell) -> None:
    shell.write("row.scene", ROW)
    before = shell.json("flatten", "row.scene")
    primitives = before["frames"][0]["primitives"]
    primitives[0]["matrix"][1][3] = 0.5
    primitives[2]["attributes"]["color"] = [0, 0, 1]
    primitives[4]["matrix"][0][0] = primitives[4]["matrix"][2][2] = 0.8
    primitives[4]["matrix"][0][2], primitives[4]["matrix"][2][0] = -0.6, 0.6
    del primitives[5]
    primitives.append({"shape": "cone\x1b[2J", "matrix": [[1, 0, 0, 2], [0, 1, 0, 2], [0, 0, 1, 2], [0, 0, 0, 1]]})
    shell.write("changed.json", json.dumps(before))
    assert shell("diff", "row.scene", "changed.json", code=1) == (
        "different: 2 matched, 2 moved, 1 recolored, 1 missing, 1 extra\n"
        "cone\N{REPLACEMENT CHARACTER}[2J\n  extra [0] at [2 2 2]\n"
        "cube\n  moved row/post[0]: [0 0 0] -> [0 0.5 0]\n  moved row/post[4] at [8 0 0]: rotated\n"
        "  recolored row/post[2] at [4 0 0]: [1 0 0] -> [0 0 1]\n"
        "cylinder\n  missing row/post[5] at [8 0.5 0]\n"
    )
    short = shell("diff", "row.scene", "changed.json", "--limit", "2", code=1).splitlines()
    assert len(short) == 6
    assert short[-1] == "... and 3 more"
    found = shell.json("diff", "row.scene", "changed.json", code=1)
    assert [found[name] for name in ("equal", "matched", "moved", "recolored", "missing", "extra")] == [
        False,
        2,
        2,
        1,
        1,
        1,
    ]
    assert found["changes"][0] == {
        "change": "moved", "frame": 0, "word": "cube",
        "a": {"path": "row/post[0]", "at": [0, 0, 0], "color": [1, 0, 0]},
        "b": {"path": "row/post[0]", "at": [0, 0.5, 0], "color": [1, 0, 0]},
    }  # fmt: skip
    assert found["changes"][-1].keys() == {"change", "frame", "word", "b"}


def test_diff_of_frames(shell: Shell) -> None:
    swing = (
        '(bind "a" (lambda () (frames (map (lambda (i) (transform (call "cube") (translate [i 0 0]))) (range {})))))'
    )
    for name, frames in (("three", 3), ("four", 4)):
        shell.write(f"{name}.scene", swing.format(frames))
    assert shell("diff", "three.scene", "three.scene") == "equal: 3 primitives in 3 frames\n"
    said = shell("diff", "three.scene", "four.scene", code=1)
    assert said == "different: 3 matched\nA has 3 frames, B has 4; the first 3 were compared\n"
    assert shell.json("diff", "three.scene", "four.scene", code=1)["frames"] == {"a": 3, "b": 4}
    shell.write("moved.scene", swing.format(3).replace("[i 0 0]", "[(* i i) 0 0]"))
    said = shell("diff", "three.scene", "moved.scene", code=1)
    assert said == "different: 2 matched, 1 moved in 3 frames\ncube\n  frame 2: moved a: [2 0 0] -> [4 0 0]\n"


def test_diff_of_wrong_things(shell: Shell) -> None:
    assert shell("diff", "table.scene", "broken.scene", code=1) == ""
    assert "E401" in shell.err
    assert shell("diff", "unread.scene", "table.scene", code=1) == ""
    assert "E101" in shell.err
    for missing in ("nothing.scene", "nothing.json"):
        shell("diff", "table.scene", missing, code=1)
        assert "E701" in shell.err
    shell.write("wrong.json", '{"frames": [{"primitives": [5]}]}')
    shell("diff", "wrong.json", "table.scene", code=1)
    assert "E701" in shell.err
    assert "frames[0].primitives[0] is not a JSON object" in shell.err
    shell("diff", "table.scene", "wrong.json", "--json", code=1)
    assert [d["code"] for d in json.loads(shell.err.splitlines()[-1])] == ["E701"]
    shell.write("deep.json", "[" * 200_000)
    shell("diff", "deep.json", "table.scene", code=1)
    assert "E701" in shell.err
    shell("diff", "-", "-", code=2)
    for wrong in (
        ["table.scene"],
        ["a", "b", "--tolerance", "x"],
        ["a", "b", "--tolerance", "0"],
        ["a", "b", "--limit", "-1"],
    ):
        shell.usage("diff", *wrong)


def test_expand(shell: Shell) -> None:
    shell.write(
        "m.scene",
        '(define-syntax twice (syntax-rules () ((_ x) (* 2 x))))\n(bind "a" (lambda () (call "cube" :scale (twice 3))))\n(scene "a")\n',
    )
    said = shell("expand", "m.scene")
    assert "(* 2 3)" in said
    assert "define-syntax" not in said
    shell.write("again.scene", said)
    assert shell.json("count", "again.scene") == shell.json("count", "m.scene")
    for name in ("table.scene",):
        shell.write("expanded.scene", shell("expand", name))
        assert shell.json("bounds", "expanded.scene") == shell.json("bounds", name)


def test_embeddings(shell: Shell) -> None:
    listed = shell.json("embeddings", "table.scene", "list")
    assert listed[0] == {"handle": "<z1>", "word": "table", "text": None, "attributes": {}}
    assert len(listed) == 11
    assert "<z4>" in shell("embeddings", "table.scene", "list")
    assert shell("embeddings", "table.scene", "set", "<z6>", "--text", "ivory", "--attribute", "h=5") == (
        "wrote table.z.safetensors: <z6>\n"
    )
    entities = {row["handle"]: row for row in shell.json("embeddings", "table.scene", "list")}
    assert entities["<z6>"]["text"] == "ivory"
    assert entities["<z4>"]["text"] is None
    assert entities["<z6>"]["attributes"]["h"] == 5
    scales = [p["attributes"]["scale"][1] for p in shell.json("flatten", "table.scene")["frames"][0]["primitives"]]
    assert scales == [0.1, 2, 5, 2, 2]
    shell("embeddings", "table.scene", "set", "<z6>", "--attribute", "color=[1,0,0]")
    assert {row["handle"]: row for row in shell.json("embeddings", "table.scene", "list")}["<z6>"]["text"] == "ivory"
    shell("embeddings", "table.scene", "set", "<z6>", "--clear")
    assert {row["handle"]: row for row in shell.json("embeddings", "table.scene", "list")}["<z6>"]["text"] is None
    shell("embeddings", "table.scene", "set", "z7", "--text", "oak", "--z", "other.safetensors")
    assert {row["handle"]: row for row in shell.json("embeddings", "table.scene", "list", "--z", "other.safetensors")}[
        "<z6>"
    ]["text"] is None
    for words in (("set", "3"), ("set", "<z6>"), ("set", "<z6>", "--attribute", "color"), ("set", "<>", "--text", "x")):
        shell("embeddings", "table.scene", *words, code=2)
        assert "error[" in shell.err
    shell("run", "table.scene", "--z", "nothing.safetensors", code=1)
    assert "E701" in shell.err
    shell.write("junk.safetensors", b"\x00\xff junk")
    for command in EVALUATING[:-1]:
        shell(command, "table.scene", "--z", "junk.safetensors", code=1)
        assert "E704" in shell.err


def test_render_export_backends(shell: Shell) -> None:
    assert shell("render", "table.scene", "-o", "t.png", "--size", "64x48") == "wrote t.png\n"
    from PIL import Image

    assert Image.open("t.png").size == (64, 48)
    assert (
        shell(
            "render",
            "table.scene",
            "-o",
            "u.png",
            "--size",
            "32x32",
            "--camera",
            "azimuth=30,elevation=20,fov=40",
            "-q",
        )
        == ""
    )
    assert shell("export", "table.scene", "-o", "t.glb") == "wrote t.glb\n"
    assert (shell.folder / "t.glb").read_bytes()[:4] == b"glTF"
    names = {b["name"] for b in shell.json("backends")}
    assert {"draft", "gltf", "mitsuba", "usd"} <= names
    assert "gltf" in shell("backends")


# --- options -------------------------------------------------------------------------------------------------------


def test_options(shell: Shell) -> None:
    assert shell.json("count", "table.scene", "--root", "top") == {"top": 1, "cube": 1}
    shell("count", "table.scene", "--root", "nothing", code=1)
    assert "E606" in shell.err
    assert shell.json("bounds", "table.scene", "--define", "height=3")["max"][1] == pytest.approx(3.05)
    for wrong, code in (("height=9", 1), ("height=2px", 1), ("nothing=1", 1), ("height", 2)):
        shell("run", "table.scene", "--define", wrong, code=code)
        assert "E305" in shell.err, wrong
    shell.write("random.scene", '(bind "a" (lambda () (call "cube" :scale (+ 1 (uniform)))))')
    assert shell("bounds", "random.scene", "--seed", "1") != shell("bounds", "random.scene", "--seed", "2")
    assert shell("bounds", "random.scene") == shell("bounds", "random.scene", "--seed", "0")


def test_numbers_of_options_are_shown_in_full(shell: Shell) -> None:
    shell("export", "table.scene", "-o", "t.stl", "--segments", "99999999", code=2)
    assert "must be 1,024 or less, not 99,999,999" in shell.err
    shell("export", "table.scene", "-o", "t.stl", "--segments", f"1{'0' * 400}", code=2)
    assert "must be 1,024 or less" in shell.err


def test_quiet_verbose_and_color(shell: Shell) -> None:
    shell.write(
        "warn.scene",
        '(bind "a" (lambda () (print "log") (call "cube"))) (bind "b" (lambda () (print "log") (call "cube")))',
    )
    shell("run", "warn.scene")
    assert "W304" in shell.err
    assert "log" in shell.err
    shell("run", "warn.scene", "-q")
    assert shell.err == ""
    shell("run", "warn.scene", "-v")
    assert "steps" in shell.err
    shell("run", "broken.scene", "-q", code=1)
    assert "E401" in shell.err, "errors are always told"
    assert "\x1b[" not in shell.err, "no colors where there is no terminal"


def test_colors_on_a_terminal(shell: Shell, monkeypatch: pytest.MonkeyPatch) -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    for words, environment, colored in ((), None, True), (("--no-color",), None, False), ((), "1", False):
        terminal = Terminal()
        with monkeypatch.context() as patch:
            patch.setattr(sys, "stderr", terminal)
            patch.delenv("NO_COLOR", raising=False)
            if environment:
                patch.setenv("NO_COLOR", environment)
            assert main(["run", "broken.scene", *words]) == 1
        assert ("\x1b[" in terminal.getvalue()) is colored
        assert "E401" in terminal.getvalue()


def test_standard_input(shell: Shell, monkeypatch: pytest.MonkeyPatch) -> None:
    commands = [command for command in EVALUATING if command != "run"]  # it tells the time
    expected = {command: shell(command, "table.scene") for command in commands}
    for command in commands:
        with monkeypatch.context() as patch:
            patch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(TABLE.encode())))
            assert shell(command, "-") == expected[command]
    with monkeypatch.context() as patch:
        patch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(b"\xff\xfe(")))
        shell("run", "-", code=1)
    assert "E107" in shell.err
    assert "<stdin>" in shell.err


# --- wrong usage -----------------------------------------------------------------------------------------------------

USAGE = [
    ["run"], ["run", "a", "b"], ["run", "table.scene", "--nothing"], ["tree", "table.scene", "--depth", "x"],
    ["render", "table.scene", "-o", "x.png", "--size", "0x5"], ["render", "table.scene", "-o", "x.png", "--size", "big"],
    ["render", "table.scene", "-o", "x.png", "--quality", "best"], ["embeddings", "table.scene"],
    ["run", "table.scene", "--seed", "x"], ["run", "table.scene", "--max-steps", "-1"], ["run", "table.scene", "--max-memory", "many"],
    ["run", "table.scene", "--max-seconds", "nan"], ["run", "table.scene", "--max-depth", "0"], ["check"],
]  # fmt: skip


@pytest.mark.parametrize("words", USAGE, ids=" ".join)
def test_wrong_usage(words: list[str], shell: Shell) -> None:
    assert "usage:" in shell.usage(*words)


# A wrong command line, and what its message says: the user's own words, and what to write.
SAID: list[tuple[str, str]] = [
    ("-o chair.stl table.scene", "a command is missing before `-o`: `scenelang export table.scene -o chair.stl`"),
    ("table.scene", "`table.scene` is a program, and the command before it is missing: `scenelang render table.scene`"),
    ("table.scene render --size 8x8", "the command comes first: `scenelang render table.scene --size 8x8`"),
    ("help render", "`scenelang render --help`"),
    ("render table.scene --imgsize=640,480", "`render` has no option `--imgsize`; did you mean `--size 640x480`?"),
    ("render table.scene --params legs=3", "did you mean `--define legs=3`?"),
    ("bounds table.scene --part leg", "which is an option of `render`, `dataset`; did you mean `--word leg`?"),
    ("view table.scene -o t.html", "did you mean `--html t.html`?"),
    ("render -o t.png", "FILE is missing: name a program, or read standard input by `scenelang render - -o t.png`"),
    ("diff table.scene", "B is missing: `scenelang diff table.scene B`"),
    ("render table.scene more", "unexpected argument `more`; `render` takes one program"),
    (
        "render table.scene --define legs 3",
        "`--define` takes one argument NAME=VALUE, with `=` inside: `--define legs=3`",
    ),
    ("render table.scene --define legs = 3", "leave out the space: `--define legs=3`"),
    ("render table.scene legs=3", "did you mean `--define legs=3`?"),
    ("render table.scene size=8x8", "did you mean `--size 8x8`?"),
    ("render table.scene 8x8", "did you mean `--size 8x8`?"),
    ("render table.scene final", "did you mean `--quality final`?"),
    ("render table.scene --size 80 60", "`--size` takes one argument, without spaces: `--size 80x60`"),
    ("render table.scene --size 80 x 60", "without spaces: `--size 80x60`"),
    ("render table.scene --camera azimuth=4, elevation=2", "leave out the space: `--camera azimuth=4,elevation=2`"),
    ("render table.scene --camera 4 5 6", "`--camera` takes one argument VIEW: preset (three-quarter,"),
    ("render table.scene --quality high", "`--quality` is `draft` or `final`, got `high`"),
    ("render table.scene --json t.json", "`--json` takes no value, got `t.json`"),
    ("render table.scene -o my table.png", '`-o "my table.png"`'),
    ("bounds table.scene --word table leg", 'WORD is one argument: put it in quotes: `--word "table leg"`'),
    ("bounds table.scene --word Leg", 'the word is "leg": upper and lower case differ'),
    ("generate a red chair --dry-run", '`scenelang generate "a red chair" --dry-run`'),
    ("edit table.scene make it red", '`scenelang edit table.scene "make it red"`'),
    ("export table.scene t.obj", "to name the output write `-o t.obj`"),
    ("export table.scene t.png", "`scenelang render table.scene -o t.png` writes such a file"),
    ("render table.scene table.scene", "`render` takes one program: run it once for each"),
    (
        "export table.scene --format stl",
        "has no option `--format`; the format follows the ending of the output: `-o table.stl`",
    ),
    ("export table.scene --glb", "`-o table.glb`"),
    ("export table.scene -o t.schematic", "write `-o t.schem`"),
    ("export table.scene -o t.glv", "did you mean `-o t.glb`?"),
    ("render table.scene -o t.tiff", "write `-o t.png`; pictures are"),
    ("import table.stl", "`table.stl` is a mesh, not a program; `import` reads .scad"),
    ("dataset table.scene -o out", "table.scene is a program, but a spec is expected"),
    ("check table.scene --that on leg top", """`--that '(on "leg" "top")'`"""),
    ("check table.scene --that 'leg on top'", """write `--that '(on "leg" "top")'`"""),
    ("render table.scene --camera azimuth=4 elevation=2", "with commas: `--camera azimuth=4,elevation=2`"),
    ("render table.scene --define legs:3", "write `--define legs=3`"),
    ("render table.scene -D legs=3", "did you mean `--define legs=3`?"),
    ("render table.scene --height 2", "did you mean `--define height=2`?"),
    ("convert table.scene t.stl", "`scenelang export table.scene -o t.stl`"),
    ("render table.scene -quality final", "an option has two dashes: `--quality`"),
    ("view table.scene --html", "`--html` needs a value: `--html OUT.html`"),
    ("bounds table.scene leg", "did you mean `--word leg`?"),
    ("flatten table.scene -o flat.json", "it prints: `scenelang flatten table.scene > flat.json`"),
    ("render tabel.scene", "did you mean `table.scene`?"),
    ("render *.scenes", "no file matches `*.scenes`"),
    ("render table.scene -o t.stl", "`scenelang export table.scene -o t.stl` does"),
    ("export table.scene -o t.png", "`scenelang render table.scene -o t.png` does"),
    ("export table.scene -o t.fbx", "most tools read t.glb"),
    ("export table.scene -o a/b.glb", "create it: `mkdir -p a`"),
    ("render table.scene -o t.gif --frame 3 --frames 9", "`--frame` and `--frames` exclude each other"),
    ("render table.scene -o t.gif --frames 0", "(--frames), got 0"),
    ("render table.scene -o t.png --camera 1,2,3", "write `--camera azimuth=1,elevation=2,distance=3`"),
    ("render table.scene -o t.png --camera eye=1:2:3,azimuth=4", "write `--camera eye=1:2:3,target=0:0:0`"),
    ("transpile table.scene", "`scenelang export table.scene --to python -o table.py`"),
    ("check table.scene --that '(on leg top)'", """write `--that '(on "leg" "top")'`"""),
    ("run table.scene --define legs", "write `--define legs=VALUE`"),
    ("check packed.scene", "packed.scene is compressed by gzip, not text"),
    ("check wide.scene", "wide.scene is encoded as UTF-16"),
    ("run blank.scene", "blank.scene is empty (0 bytes)"),
    ("fmt mill.py", "`scenelang transpile mill.py -o mill.scene`"),
]


@pytest.mark.parametrize(("line", "said"), SAID, ids=[line for line, _ in SAID])
def test_a_wrong_command_line_says_what_to_write(line: str, said: str, shell: Shell) -> None:
    shell.write("packed.scene", b"\x1f\x8b\x08\x00")
    shell.write("wide.scene", TABLE.encode("utf-16"))
    shell.write("blank.scene", "")
    shell.write("mill.py", "x = 1")
    with suppress(SystemExit):
        assert main(shlex.split(line)) in (1, 2)
    assert said in shell.capsys.readouterr().err


def test_without_a_command_help_lists_all_by_what_they_are_for(shell: Shell) -> None:
    text = shell()
    assert "Inspect scenes:\n  render " in text
    assert all(f"  {name} " in text for name in COMMANDS)


@pytest.mark.parametrize(
    ("typed", "meant"), [("rendr", "render"), ("formt", "fmt"), ("bound", "bounds"), ("transpil", "transpile")]
)
def test_an_unknown_command_names_the_nearest(typed: str, meant: str, shell: Shell) -> None:
    shell(typed, code=2)
    assert shell.err == f"scenelang: error: unknown command `{typed}`; did you mean `{meant}`?\n"
    shell("x" * 500, code=2)
    assert len(shell.err) < 200
    assert "see `scenelang --help`" in shell.err


@pytest.mark.parametrize(
    "command",
    ["check", "run", "expand", "tree", "flatten", "count", "bounds", "render", "export", "embeddings", "backends"],
)
def test_help(command: str, shell: Shell) -> None:
    with pytest.raises(SystemExit) as caught:
        main([command, "--help"])
    assert caught.value.code == 0
    said = shell.capsys.readouterr().out
    assert "usage:" in said
    if command not in ("backends", "embeddings"):
        for option in ("--root", "--seed", "--define", "--z", "--json", "-q", "--no-color", "--max-steps", "--max-depth",
                       "--max-entities", "--max-primitives", "--max-size", "--max-memory", "--max-seconds"):  # fmt: skip
            assert option in said


def test_version_and_help(shell: Shell) -> None:
    for words in (["--version"], ["--help"]):
        with pytest.raises(SystemExit) as caught:
            main(words)
        assert caught.value.code == 0
    assert "scenelang" in shell.capsys.readouterr().out


@pytest.mark.parametrize("command", EVALUATING)
def test_failures_of_files(command: str, shell: Shell) -> None:
    (shell.folder / "folder").mkdir()
    shell.write("bytes.scene", b"\xff")
    for file, code in (
        ("nothing.scene", "E701"),
        ("folder", "E701"),
        ("bytes.scene", "E107"),
        ("unread.scene", "E101"),
        ("x\0y", "E701"),
    ):
        assert shell(command, file, code=1) == ""
        assert code in shell.err, file


# --- files that are written ------------------------------------------------------------------------------------------


def test_outputs_that_cannot_be_written(shell: Shell) -> None:
    for code, *words in (
        (1, "render", "-o", "no/x.png"),
        (1, "export", "-o", "no/x.glb"),
        (2, "export", "-o", "x.xyz"),
        (2, "export", "-o", "x.glb", "--backend", "nothing"),
    ):
        shell(words[0], "table.scene", *words[1:], code=code)
        assert "error[E70" in shell.err
    (shell.folder / "taken.glb").mkdir()
    shell("export", "table.scene", "-o", "taken.glb", code=1)
    assert "error[E701]" in shell.err
    (shell.folder / "taken.png").mkdir()
    shell("render", "table.scene", "-o", "taken.png", "--size", "16x16", code=1)
    assert "error[E701]" in shell.err


def test_a_read_only_folder(shell: Shell) -> None:
    locked = shell.folder / "locked"
    locked.mkdir(0o555)
    if os.getuid() == 0:  # root may write anywhere but here
        locked = Path("/proc")
    for words in (
        ["export", "table.scene", "-o", f"{locked}/t.glb"],
        ["render", "table.scene", "-o", f"{locked}/t.png", "--size", "16x16"],
        ["embeddings", "table.scene", "set", "<z3>", "--text", "x", "--z", f"{locked}/t.safetensors"],
    ):
        shell(*words, code=1)
        assert "error[E701]" in shell.err
        assert str(locked) in shell.err, "it says what it could not write"
        assert not list(locked.glob("t.*"))


def test_a_failure_leaves_no_half_written_file(shell: Shell, monkeypatch: pytest.MonkeyPatch) -> None:
    shell.write("t.glb", b"old")
    shell.write("t.png", b"old")
    from scenelang.backends import files

    def refuse(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(files.os, "replace", refuse, raising=False)
    monkeypatch.setattr(Path, "replace", refuse)
    shell("export", "table.scene", "-o", "t.glb", code=1)
    assert "error[E701]" in shell.err
    shell("render", "table.scene", "-o", "t.png", "--size", "16x16", code=1)
    assert "error[E701]" in shell.err
    assert (shell.folder / "t.glb").read_bytes() == b"old"
    assert (shell.folder / "t.png").read_bytes() == b"old"
    assert len(list(shell.folder.iterdir())) == 6, "no temporary file is left"


def test_a_wrong_program_writes_nothing(shell: Shell) -> None:
    for words in (["export", "broken.scene", "-o", "b.glb"], ["render", "broken.scene", "-o", "b.png"]):
        shell(*words, code=1)
    assert not list(shell.folder.glob("b.*"))


# --- pipes and interruptions -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("command", [["tree", "--all"], ["flatten", "--json"], ["count"], ["tree", "--json"]])
@pytest.mark.sampled(2)
def test_broken_pipe(command: list[str], tmp_path: Path) -> None:
    (tmp_path / "long.scene").write_text(
        '(bind "a" (lambda () (union-loop 5000 (lambda (i) (transform (call (format "word{}" i) :scale (+ i 1)) (translate [i 0 0]))))))'
    )
    words = [sys.executable, "-m", "scenelang", command[0], "long.scene", *command[1:]]
    with subprocess.Popen(words, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as running:
        assert running.stdout is not None
        assert running.stderr is not None
        running.stdout.read(10)
        running.stdout.close()
        said = running.stderr.read()
        code = running.wait()
    assert said == b""
    assert code in (0, 141), "0 if all was written before the pipe closed"


def test_a_full_disk() -> None:
    if not Path("/dev/full").exists():
        pytest.skip("no /dev/full here")
    with open("/dev/full", "wb") as full:
        done = subprocess.run(
            [sys.executable, "-m", "scenelang", "backends"],
            stdout=full,
            stderr=subprocess.PIPE,
            check=False,
        )
    assert b"Traceback" not in done.stderr
    assert done.returncode == 1


@pytest.mark.parametrize(
    "program", [ENDLESS, "(sort (iota 10))\n(define (f x) (f x))\n(map f (list 1))"], ids=["loop", "inside map"]
)
def test_interruption(program: str, tmp_path: Path) -> None:
    (tmp_path / "endless.scene").write_text(program)
    words = [sys.executable, "-m", "scenelang", "run", "endless.scene", "--max-steps", "1G"]
    with interruptible(words, tmp_path) as running:
        wait_for_work(running.pid, 0.5)
        running.send_signal(signal.SIGINT)
        _, said = running.communicate()
    assert running.returncode in (1, 130)
    assert b"Traceback" not in said
    assert b"E508" in said or b"interrupted" in said


# --- bytes of any kind ---------------------------------------------------------------------------------------------------

SESSION = Session(Options(limits=Limits(steps=20_000, depth=500, size=100_000, memory=300_000_000, seconds=5.0)))
PIECES = st.sampled_from(
    ["(", ")", "[", "]", "'", "`", ",", ",@", "#;", "#|", "|#", ";", "\n", " ", '"', "\\", ".", "...", "::", ":a", "<z1>", "<", "=>",
     "define", "lambda", "let", "let*", "letrec", "if", "cond", "case", "else", "for/list", "for*", "for/fold", "while", "do", "x", "y",
     "f", "1", "-2.5", "1e400", "999999999999999999999", "#t", "none", "bind", "call", "union", "transform", "union-loop", "scene",
     "param", "import", "define-syntax", "syntax-rules", "define-macro", "define-record", "guard", "let/ec", "set!", "quote",
     "quasiquote", "unquote", "map", "+", "list", "\"cube\"", "\"a\"", "(lambda (x) x)", "(call \"cube\")", "(translate [1 2 3])",
     "(define (f x) (f x))", "(f 1)", "begin", "values", "define-values", "let-values", "assert", "error", "_", "&keys", "std/list",
     "\x00", "\ufeff", "é", "😀", "\u2028", "\t", "\r"],
)  # fmt: skip


def survives(data: bytes) -> None:
    """Whatever the bytes are, there are diagnostics and no exception, and the diagnostics can be printed."""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return
    result = SESSION.evaluate(Source("bytes.scene", text))
    assert (result.scene is None) == any(d.is_error for d in result.diagnostics)
    for diagnostic in result.diagnostics:
        assert render_text(diagnostic)
        assert json.dumps(to_json(diagnostic))


@settings(max_examples=many(300), deadline=None, suppress_health_check=list(HealthCheck))
@given(st.binary(max_size=300))
def test_any_bytes(data: bytes) -> None:
    survives(data)


@settings(max_examples=many(300), deadline=None, suppress_health_check=list(HealthCheck))
@given(st.text(max_size=200))
def test_any_text(text: str) -> None:
    survives(text.encode("utf-8", "surrogatepass"))


@settings(max_examples=many(500), deadline=None, suppress_health_check=list(HealthCheck))
@given(st.lists(PIECES, max_size=40))
def test_any_sequence_of_the_languages_own_words(pieces: list[str]) -> None:
    survives(" ".join(pieces).encode())


FORMS = st.recursive(
    PIECES.filter(lambda piece: not set(piece) & set("()[]\"\\;|`',.#") or piece.startswith(("(", '"c', '"a'))),
    lambda inner: (
        st.lists(inner, max_size=5).map(lambda items: "(" + " ".join(items) + ")")
        | st.lists(inner, max_size=3).map(lambda items: "[" + " ".join(items) + "]")
    ),
    max_leaves=25,
)


@settings(max_examples=many(500), deadline=None, suppress_health_check=list(HealthCheck))
@given(st.lists(FORMS, max_size=6))
def test_any_well_nested_text(forms: list[str]) -> None:
    survives("\n".join(forms).encode())


@pytest.mark.parametrize(
    "data", [b"", b"\xff\xfe", b"\x00", b"\xef\xbb\xbf", b"(\xc3", b"\x80" * 1000, b"; only a comment"]
)
def test_some_bytes_through_the_command_line(data: bytes, shell: Shell) -> None:
    shell.write("bytes.scene", data)
    assert shell("run", "bytes.scene", code=1) == ""
    assert "error[" in shell.err


def test_an_interruption_that_a_library_disguises_is_told_as_one(monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    def interrupted(*_: object) -> None:
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt as error:
            raise RuntimeError("the renderer stopped") from error

    monkeypatch.setattr("scenelang.backends.base.all_backends", interrupted)
    assert main(["backends"]) == 130
    assert capsys.readouterr().err == "interrupted\n"


def test_a_finished_scene_is_read_like_a_program_where_that_makes_sense(tmp_path: Path, capsys: Any) -> None:
    (tmp_path / "a.scene").write_text('(bind "pair" (lambda () (union (call "cube") (call "sphere" :radius .5))))')
    scene = str(tmp_path / "a.json")
    assert main(["export", str(tmp_path / "a.scene"), "-o", scene, "-q"]) == 0
    for command in (
        ["check"],
        ["run"],
        ["tree"],
        ["count"],
        ["bounds"],
        ["flatten"],
        ["diff", str(tmp_path / "a.scene")],
    ):
        assert main([*command, scene]) == 0, command
    capsys.readouterr()
    assert main(["expand", scene]) == 1
    assert main(["embeddings", scene, "set", "z2", "--text", "x"]) == 1
    assert capsys.readouterr().err.count("E706") == 2
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.json", "a.scene"]

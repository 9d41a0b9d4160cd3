"""Responses and Python on the command line: `transpile`, and every other command on a .txt or .py file."""

from __future__ import annotations

import io
import json
import re
import sys
from pathlib import Path
from typing import Any

import pytest

import scenelang
from scenelang.cli.main import main
from transpile.cases import CORPUS, HERE, Case

CAR = """@register()
def wheel(radius: float = 0.5) -> Shape:
    return primitive_call('sphere', shape_kwargs={'radius': radius})

@register()
def car() -> Shape:
    return loop(4, lambda i: transform_shape(library_call('wheel'), translation_matrix((i, 0, 0))))
"""
RESPONSE = f"""Here is a car.

```python
{CAR}```

It has four wheels.
"""
PROGRAM = """(bind "wheel"
  (lambda ((:radius 0.5))
    (call "sphere" :radius radius)))

(bind "car"
  (lambda ()
    (union-loop 4 (lambda (i) (transform (call "wheel") (translate [i 0 0]))))))

(scene "car")
"""
WRONG = CAR.replace("library_call('wheel')", "library_call('wheel', size=3)")
MOVING = """@register_animation()
def cars():
    for i in range(3):
        yield library_call('car')
"""


class Shell:
    """Runs commands in process in a folder of their own."""

    def __init__(self, folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
        self.folder = folder
        self.capsys = capsys
        self.monkeypatch = monkeypatch
        self.err = ""

    def write(self, name: str, text: str | bytes) -> str:
        (self.folder / name).write_bytes(text if isinstance(text, bytes) else text.encode())
        return name

    def __call__(self, *words: str, code: int = 0, stdin: str | None = None) -> str:
        """What the command prints on standard output; standard error is kept in ``err``."""
        if stdin is not None:
            self.monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(stdin.encode())))
        self.capsys.readouterr()
        got = main(list(words))
        out, self.err = self.capsys.readouterr()
        assert got == code, self.err
        assert "Traceback" not in self.err
        return out

    def usage(self, *words: str) -> str:
        """What wrong usage prints."""
        with pytest.raises(SystemExit) as caught:
            main(list(words))
        assert caught.value.code == 2
        return self.capsys.readouterr().err

    def codes(self) -> list[str]:
        """The codes of the diagnostics that the last command gave."""
        lines = self.err.splitlines()
        return [line.split("[")[1][:4] for line in lines if line.startswith(("error[", "warning["))]


@pytest.fixture
def shell(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Shell:
    monkeypatch.chdir(tmp_path)
    made = Shell(tmp_path, capsys, monkeypatch)
    made.write("car.py", CAR)
    made.write("car.txt", RESPONSE)
    made.write("wrong.py", WRONG)
    return made


def corpus(name: str) -> Case:
    return next(case for case in CORPUS if case.name == name)


# --- where the text comes from and goes to -------------------------------------------------------------------------


def test_to_standard_output(shell: Shell) -> None:
    assert shell("transpile", "car.py") == PROGRAM
    assert shell.err == ""


def test_from_standard_input(shell: Shell) -> None:
    assert shell("transpile", "-", stdin=CAR) == PROGRAM
    assert shell("transpile", "-", stdin=RESPONSE).startswith("; Here is a car.\n")


def test_to_a_file(shell: Shell) -> None:
    assert shell("transpile", "car.py", "-o", "car.scene") == ""
    assert (shell.folder / "car.scene").read_text() == PROGRAM
    assert shell("transpile", "car.txt", "--output", "car.scene") == ""
    assert (shell.folder / "car.scene").read_text() != PROGRAM
    assert {path.name for path in shell.folder.iterdir()} == {"car.py", "car.txt", "wrong.py", "car.scene"}


def test_errors_leave_a_file_as_it_was(shell: Shell) -> None:
    shell.write("kept.scene", "; kept\n")
    assert shell("transpile", "wrong.py", "-o", "kept.scene", code=1) == ""
    assert (shell.folder / "kept.scene").read_text() == "; kept\n"
    assert shell("transpile", "wrong.py", "-o", "new.scene", code=1) == ""
    assert not (shell.folder / "new.scene").exists()
    shell("transpile", "nothing.py", "-o", "kept.scene", code=1)
    assert (shell.folder / "kept.scene").read_text() == "; kept\n"


def test_the_python_is_never_replaced(shell: Shell) -> None:
    shell("transpile", "car.py", "-o", str(shell.folder / "car.py"), code=2)
    assert (shell.folder / "car.py").read_text() == CAR


def test_a_folder_that_is_not_there(shell: Shell) -> None:
    shell("transpile", "car.py", "-o", "nowhere/car.scene", code=1)
    assert shell.codes() == ["E701"]
    assert "nowhere" in shell.err


def test_a_missing_file(shell: Shell) -> None:
    assert shell("transpile", "nothing.py", code=1) == ""
    assert shell.codes() == ["E701"]


def test_wrong_usage(shell: Shell) -> None:
    assert "FILE" in shell.usage("transpile")
    assert "--nonsense" in shell.usage("transpile", "car.py", "--nonsense")
    assert "needs a value" in shell.usage("transpile", "car.py", "-o")
    assert "unexpected argument" in shell.usage("transpile", "car.py", "car.txt")


def test_a_wrong_program(shell: Shell) -> None:
    assert shell("transpile", "wrong.py", code=1) == ""
    assert shell.codes() == ["E805"]
    assert "wrong.py:7:68" in shell.err
    assert "`wheel` has no parameter `size`" in shell.err


def test_diagnostics_as_json(shell: Shell) -> None:
    assert shell("transpile", "wrong.py", "--json", code=1) == ""
    (found,) = json.loads(shell.err)
    assert (found["code"], found["place"]["line"]) == ("E805", 7)
    assert shell("transpile", "car.py", "--json") == PROGRAM


# --- what a response may look like ---------------------------------------------------------------------------------


def test_prose_is_kept_around_the_program(shell: Shell) -> None:
    """The prose before becomes the comment that opens the program, the prose after the one that ends it."""
    out = shell("transpile", "car.txt")
    assert out.startswith(f"; Here is a car.\n\n{PROGRAM}")
    assert out.removeprefix(f"; Here is a car.\n\n{PROGRAM}").strip() == "; It has four wheels."


def test_several_blocks(shell: Shell) -> None:
    """The first is read, as the paper's own tool does; a warning says so."""
    shell.write("two.txt", RESPONSE + "\nUse it like this:\n\n```python\ncar()\n```\n")
    assert PROGRAM in shell("transpile", "two.txt")
    assert shell.codes() == ["W802"]
    assert shell("transpile", "two.txt", "-q").count("Use it like this") == 1
    assert shell.err == ""
    assert shell("count", "two.txt", "-q") == shell("count", "car.py")
    shell("check", "two.txt")
    assert shell.codes() == ["W802"]


def test_the_block_that_registers_something(shell: Shell) -> None:
    shell.write("late.txt", "First:\n```python\nx = 1\n```\nThen:\n" + RESPONSE)
    assert PROGRAM in shell("transpile", "late.txt")
    assert shell.codes() == ["W802"]


def test_blocks_of_other_languages(shell: Shell) -> None:
    shell.write("shell.txt", "```bash\npip install helper\n```\n" + RESPONSE)
    assert PROGRAM in shell("transpile", "shell.txt")
    assert shell.err == ""


@pytest.mark.parametrize("fence", ["```py", "```Python", "```python3", "``` python", "```", "~~~python", "````python"])
def test_other_fences(shell: Shell, fence: str) -> None:
    end = "".join(c for c in fence if c in "`~")
    shell.write("fence.txt", f"A car.\n{fence}\n{CAR}{end}\n")
    assert shell("transpile", "fence.txt") == f"; A car.\n\n{PROGRAM}"
    assert shell.err == ""


def test_no_fence(shell: Shell) -> None:
    shell.write("bare.txt", CAR)
    assert shell("transpile", "bare.txt") == PROGRAM


def test_a_fence_that_is_never_closed(shell: Shell) -> None:
    shell.write("cut.txt", f"A car.\n```python\n{CAR}")
    assert shell("transpile", "cut.txt") == f"; A car.\n\n{PROGRAM}"


def test_a_response_that_was_cut_off(shell: Shell) -> None:
    shell.write("cut.txt", f"A car.\n```python\n{CAR[:-20]}")
    assert shell("transpile", "cut.txt", code=1) == ""
    assert shell.codes() == ["E801"]
    assert "cut.txt:9:" in shell.err, "the place is that in the response"


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace("\n", "\r\n"),
        lambda text: "\ufeff" + text,
        lambda text: text.replace("    ", "\t"),
        lambda text: text.rstrip("\n"),
        lambda text: "\n\n\n" + text + "\n\n\n",
        lambda text: "\n".join("    " + line for line in text.split("\n")),
        lambda text: "from helper import *\n\n" + text,
        lambda text: "from typing import *\nimport numpy as np, math, random\n" + text,
        lambda text: '#!/usr/bin/env python3\n"""A car."""\n' + text,
    ],
    ids=["crlf", "bom", "tabs", "no-newline", "blank-lines", "indented", "import", "imports", "docstring"],
)
@pytest.mark.parametrize("fenced", [False, True], ids=["py", "txt"])
def test_the_same_program(shell: Shell, change: Any, fenced: bool) -> None:
    response = f"```python\n{change(CAR)}\n```\n".replace("```python\n\ufeff", "\ufeff```python\n")
    name = shell.write("x.txt", response) if fenced else shell.write("x.py", change(CAR))
    out = shell("transpile", name)
    assert shell.err == ""
    assert "\r" not in out
    bare = "\n".join(line for line in out.split("\n") if not line.startswith(";"))
    assert bare.strip() == PROGRAM.strip()


def test_line_ends_do_not_move_places(shell: Shell) -> None:
    shell.write("wrong.txt", f"A car.\n```python\n{WRONG}```\n".replace("\n", "\r\n"))
    shell("transpile", "wrong.txt", code=1)
    assert "wrong.txt:9:68" in shell.err


@pytest.mark.parametrize("text", ["", "\n", "   \n\t\n", "# nothing\n", "import math\n", "```python\n```\n", "\ufeff"])
@pytest.mark.parametrize("name", ["x.py", "x.txt"])
def test_nothing(shell: Shell, name: str, text: str) -> None:
    shell.write(name, text)
    for command in ("transpile", "run"):
        assert shell(command, name, code=1) == ""
        assert shell.codes() == ["E304"]
        assert "@register()" in shell.err


@pytest.mark.parametrize(
    "prose", ["I cannot help with that.", "Sure! Here's the program you asked for:\n\n- a car\n- a tree\n", "No"]
)
def test_only_prose(shell: Shell, prose: str) -> None:
    shell.write("prose.txt", prose)
    assert shell("transpile", "prose.txt", code=1) == ""
    assert set(shell.codes()) <= {"E801", "E304"}
    assert "```python" in shell.err or "@register()" in shell.err, "a hint says what is missing"


def test_bytes_that_are_no_text(shell: Shell) -> None:
    shell.write("bytes.txt", b"```python\nx = '\xff\xfe'\n```\n")
    shell("transpile", "bytes.txt", code=1)
    assert shell.codes() == ["E107"]
    assert "line 2" in shell.err


def test_warnings(shell: Shell) -> None:
    shell.write("w.py", CAR.replace("'wheel')", "'wheels')"))
    shell("transpile", "w.py")
    assert shell.codes() == ["W801"]
    shell("transpile", "w.py", "-q")
    assert shell.err == ""


@pytest.mark.parametrize("name", ["size", "thickness", "p0"])
def test_arguments_that_a_primitive_does_not_read(shell: Shell, name: str) -> None:
    shell.write("w.py", CAR.replace("'radius'", f"'{name}'"))
    shell("transpile", "w.py")
    assert shell.codes() == ["W608"]


# --- the other commands --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["car.py", "car.txt"])
def test_commands_on_python(shell: Shell, name: str) -> None:
    shell("transpile", "car.py", "-o", "car.scene")
    for command in ("check", "run", "tree", "flatten", "count", "bounds", "expand"):
        expected = _without_time(shell(command, "car.scene")).replace("car.scene", name)
        assert _without_time(shell(command, name)) == expected, command
        assert shell.err == ""


def _without_time(text: str) -> str:
    return re.sub(r"\d\.\d+ s$", "", text, flags=re.M)


@pytest.mark.parametrize("name", ["car.py", "car.txt"])
def test_pictures_of_python(shell: Shell, name: str) -> None:
    shell("render", name, "-o", "car.png", "--quality", "draft", "--size", "32x24")
    assert (shell.folder / "car.png").read_bytes().startswith(b"\x89PNG")


def test_commands_on_standard_input(shell: Shell) -> None:
    """Python there is told from a program by its registered functions."""
    assert shell("count", "-", stdin=CAR) == shell("count", "-", stdin=PROGRAM) == shell("count", "car.py")


def test_options_reach_python(shell: Shell) -> None:
    assert "1" in shell("count", "car.py", "--root", "wheel")
    shell.write("draw.py", CAR.replace("radius})", "radius + np.random.uniform()})"))
    assert shell("flatten", "draw.py", "--json") == shell("flatten", "draw.py", "--json", "--seed", "0")
    assert shell("flatten", "draw.py", "--json") != shell("flatten", "draw.py", "--json", "--seed", "1")
    shell("run", "car.py", "--root", "lorry", code=1)
    shell.write("long.py", CAR.replace("return loop(4", "return loop(100000"))
    shell("run", "long.py", "--max-steps", "10k", code=1)
    assert shell.codes() == ["E501"]


def test_errors_while_running_are_shown_in_the_python(shell: Shell) -> None:
    shell.write("car.txt", RESPONSE.replace("(i, 0, 0)", "(1 / (i - 2), 0, 0)"))
    shell("run", "car.txt", code=1)
    assert shell.codes() == ["E407"]
    assert "car.txt:10:89" in shell.err
    assert 'in "car"' in shell.err


WRONG_WHEN_IT_RUNS = {
    "E406": ("COLORS = {'red': (1, 0, 0)}\n", "primitive_call('cube', color=COLORS[kind])", "COLORS[kind]"),
    "E401": ("", "primitive_call('cube', shape_kwargs={'scale': kind * 2 - 1})", "kind * 2 - 1"),
    "E413": ("def check(x):\n    assert x == 'red', 'no such kind'\n    return x\n", "check(kind)", "assert"),
    "E414": ("def check(x):\n    raise ValueError('no such kind')\n", "check(kind)", "raise"),
    "E405": ("", "primitive_call('cube', color=[(1, 0, 0)][len(kind) - 1])", "[(1, 0, 0)]"),
    "E412": ("def check(x):\n    a, b = x\n    return a\n", "check([kind])", "a, b = x"),
    "E407": (
        "def check(x):\n    return 1 / (len(x) - 5)\n",
        "primitive_call('cube', shape_kwargs={'scale': check(kind)})",
        "1 / (len(x) - 5)",
    ),
    "E502": ("", "library_call('ball', kind=kind) if kind else concat_shapes()", "library_call('ball'"),
}


@pytest.mark.parametrize("code", WRONG_WHEN_IT_RUNS)
@pytest.mark.parametrize("fenced", [False, True], ids=["py", "txt"])
def test_wrong_when_it_runs(shell: Shell, code: str, fenced: bool) -> None:
    """The error points at the Python, and the calls that led there are told with their places in it."""
    before, value, place = WRONG_WHEN_IT_RUNS[code]
    ball = f"@register()\ndef ball(kind: str) -> Shape:\n    return {value}\n"
    balls = "@register()\ndef balls() -> Shape:\n    return concat_shapes(library_call('ball', kind='green'))\n"
    text = f"{before}{ball}{balls}"
    text = f"Some balls.\n```python\n{text}```\n" if fenced else text
    name = shell.write("balls.txt" if fenced else "balls.py", text)
    shell("run", name, *(["--max-depth", "500"] if code == "E502" else []), code=1)
    assert shell.codes() == [code]
    offset = text.index(place)
    line = text.count("\n", 0, offset) + 1
    assert f"--> {name}:{line}:" in shell.err
    assert f'in "ball", called at {name}:' in shell.err
    assert 'in "balls"' in shell.err or code == "E502"


def test_frames(shell: Shell) -> None:
    shell.write("cars.py", CAR + "\n" + MOVING)
    out = json.loads(shell("flatten", "cars.py", "--json"))
    assert [len(frame["primitives"]) for frame in out["frames"]] == [4, 4, 4]


# --- diff ----------------------------------------------------------------------------------------------------------


def test_diff_with_a_golden_file(shell: Shell) -> None:
    case = corpus("t01-chessboard")
    shell.write("golden.json", json.dumps(case.golden_scene()))
    assert shell("diff", str(case.path), "golden.json").startswith("equal: ")
    assert shell("diff", "golden.json", str(case.path)).startswith("equal: ")


def test_diff_of_a_scene_and_its_edit(shell: Shell) -> None:
    """The apple that covered the face is moved aside; nothing else is."""
    before, after = HERE / "responses" / "t06-son-of-man.txt", HERE / "responses" / "t06-son-of-man.edit.txt"
    found = json.loads(shell("diff", str(before), str(after), "--json", code=1))
    assert {kind: found[kind] for kind in ("moved", "recolored", "missing", "extra")} == {
        "moved": 6, "recolored": 0, "missing": 0, "extra": 0,
    }  # fmt: skip
    assert all(change["a"]["path"].startswith("son_of_man/green_apple") for change in found["changes"])
    centre = {side: sum(change[side]["at"][0] for change in found["changes"]) / 6 for side in ("a", "b")}
    assert centre["b"] - centre["a"] == pytest.approx(-0.8)
    assert shell("diff", str(before), str(before)).startswith("equal: 65 ")


def test_diff_with_wrong_python(shell: Shell) -> None:
    assert shell("diff", "car.py", "wrong.py", code=1) == ""
    assert shell.codes() == ["E805"]


# --- the Python API ------------------------------------------------------------------------------------------------


def test_api(shell: Shell) -> None:
    assert scenelang.load("car.txt").word == "car"
    assert scenelang.load(Path("car.py")).word == "car"
    scene = scenelang.evaluate(RESPONSE, "car.txt")
    assert scene.word == "car"
    assert scenelang.check(CAR, "car.py").ok
    assert not scenelang.check(WRONG, "wrong.py").ok
    with pytest.raises(scenelang.SceneError) as caught:
        scenelang.load("wrong.py")
    assert caught.value.diagnostic.code == "E805"
    assert not scenelang.check(CAR, "car.scene").ok, "only .py and .txt are read as Python"
    assert scenelang.Session().transpile(scenelang.Source("car.py", CAR)).text == PROGRAM

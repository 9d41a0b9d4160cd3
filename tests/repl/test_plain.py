"""The REPL driven by a pipe: values, diagnostics, every command, JSON, hostile inputs."""

from __future__ import annotations

import io
import json
import re
import subprocess
import sys
from collections.abc import Callable
from importlib.metadata import packages_distributions
from pathlib import Path
from threading import Thread

import copies
import pytest
from PIL import Image
from sampling import one_in, only
from support import PATIENCE, read_until, rewrite, wait_until, watching

from scenelang.cli.main import main as cli
from scenelang.grammar.datum import Source
from scenelang.grammar.reader import ReadResult, read
from scenelang.repl import plain
from scenelang.repl.evaluation import ReplEvaluation
from scenelang.repl.plain import Plain
from scenelang.session.session import Session

FILE = """; A leg of the table.
(bind "leg" (lambda ((:height 2)) (call "cube" :scale [1 height 1])))
(define-macro (double x) `(* 2 ,x))
; Twice as much.
(define (twice x) (double x))
(bind "table" (lambda () (union-loop 4 (lambda (i) (transform (call "leg") (translate [(* 3 i) 0 0]))))))
(scene "table")
"""


def drive(text: str, *arguments: str, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    return copies.command("repl", *arguments, text=text, folder=cwd)


def started(text: str) -> subprocess.CompletedProcess[str]:
    """The same from nothing."""
    words = [sys.executable, "-m", "scenelang", "repl"]
    return subprocess.run(words, input=text, capture_output=True, text=True)


def lines(text: str, *arguments: str, cwd: Path | None = None) -> list[str]:
    result = drive(text, *arguments, cwd=cwd)
    assert result.returncode == 0, result.stderr
    assert result.stderr == ""
    return result.stdout.splitlines()


@pytest.fixture
def program(tmp_path: Path) -> Path:
    path = tmp_path / "table.scene"
    path.write_text(FILE)
    return path


LONG: dict[str, Callable[[int], str]] = {
    "open brackets": lambda n: "(list\n" * n,
    "one open bracket": lambda n: "(list " + "1 2 3\n" * n,
    "a comment": lambda n: "#|\n" * n,
    "a string": lambda n: '"' + "a\n" * n,
    "quotes": lambda n: "'\n" * n,
}


@pytest.mark.parametrize("name", only(("a comment", "one open bracket"), LONG))
def test_long_inputs_are_not_read_again_at_every_line(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    lengths: list[int] = []

    def noted(source: Source) -> ReadResult:
        lengths.append(len(source.text))
        return read(source)

    def characters_read(text: str) -> int:
        lengths.clear()
        said = io.StringIO()
        repl = Plain(io.StringIO(text), io.StringIO(), said)
        thread = Thread(target=repl.run, args=(ReplEvaluation(Session()),))  # the main thread would take a signal
        thread.start()
        thread.join()
        assert "E101" in said.getvalue()
        return sum(lengths)

    monkeypatch.setattr(plain, "read", noted)
    few, many = (characters_read(LONG[name](n)) for n in (1_000, 2_000))
    assert few > 2_000
    assert many < 2 * few


def test_a_long_input_ends_where_its_brackets_do() -> None:
    text = "(length (list ; )\n" + '1 ")" #| ) |# 2\n' * 1_000 + "))\n"
    assert lines(text + text + "(+ 1 1)\n") == ["3000", "3000", "2"]


# --- forms ---------------------------------------------------------------------------------------------------------


def test_a_session_from_the_start() -> None:
    result = started("(+ 1 1)\n(car 5)\n")
    assert (result.returncode, result.stdout) == (0, "2\n")
    assert "error[" in result.stderr


def test_values_come_form_by_form() -> None:
    assert lines("1 2\n(define (f x)\n  (* x 2))\n\n(f 21) ; note\nnone\n") == ["1", "2", "42"]


def test_errors_go_to_the_other_stream_and_the_session_goes_on() -> None:
    result = drive("(define k 1)\n(car 5)\n)\n(foo)\n(+ k 1)\n(unfinished")
    assert result.returncode == 0
    assert result.stdout == "2\n"
    assert result.stderr.count("error[") == 4
    assert "<repl 2>:1:1" in result.stderr
    assert drive("(car 5)", "--strict-errors").returncode == 1
    assert drive("(+ 1 1)", "--strict-errors").returncode == 0


def test_a_file_loads_first(program: Path) -> None:
    assert lines('(twice 4)\n(call "leg")\n', str(program)) == ["8", "leg", "└─ cube  :scale [1 2 1]"]


def test_options_apply(tmp_path: Path) -> None:
    path = tmp_path / "a.scene"
    path.write_text("(param k 1)")
    assert lines("k", str(path), "--define", "k=7") == ["7"]
    assert drive("(while #t 1)", "--max-steps", "1k").stderr.startswith("error[E501]")
    assert lines("(random)", "--seed", "3") == lines(",seed 3\n(random)")


def test_a_prompt_lets_a_program_wait_for_it() -> None:
    assert drive("1\n(+ 1\n1)\n", "--prompt", "READY ").stdout == "READY 1\nREADY READY 2\nREADY "


def test_json_is_one_object_per_form() -> None:
    result = drive('(print "hi") (+ 1 2)\n(car 5)\n,count (call "cube")\n', "--json")
    objects = [json.loads(line) for line in result.stdout.splitlines()]
    assert [o["ok"] for o in objects] == [True, True, False, True]
    assert objects[0]["log"] == ["hi"]
    assert objects[0]["value"] is None
    assert objects[1]["value"] == "3"
    assert objects[1]["type"]
    assert objects[1]["steps"] >= 0
    assert objects[2]["diagnostics"][0]["place"]["line"] == 1
    assert objects[3]["output"] == "1  cube"
    assert result.stderr == ""


def test_only_what_makes_sense_is_warned_about() -> None:
    text = '(define unused 1)\n(bind "chair" (lambda () (call "cube")))\n(define (f) (let ((x 1)) 2))\n'
    assert drive(text).stderr == ""
    assert 'did you mean "chair"' in drive(text + '(define (g) (call "chiar"))').stderr


# --- commands ------------------------------------------------------------------------------------------------------


def test_help_lists_every_command() -> None:
    wanted = """help doc apropos source tree count bounds expand time trace load reload watch render view export generate
    edit seed transpile reset save quit"""
    found = [line.split()[0].lstrip(",") for line in lines(",help") if line.startswith(",")]
    assert found == wanted.split()
    assert lines(",he ,quit") == [",quit  exit the REPL"]


@pytest.mark.parametrize("asked", ["E401", "e401", "unbound"])
def test_doc_tells_what_explain_tells(asked: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli(["explain", asked]) == 0
    explained = capsys.readouterr().out
    assert " ".join(lines(f",doc {asked}")).split() == explained.split()


def test_doc_of_a_word_of_the_session_comes_before_the_primitive() -> None:
    found = lines('(bind "cube" (lambda ((:size 1)) (primitive "cube" :scale size)))\n,doc "cube"')
    assert found == ['function ("cube" (:size 1))', "  defined in <repl 1>"]


def test_doc_suggests_attributes() -> None:
    assert "did you mean `:radius`?" in drive(",doc :raduis").stderr


def test_beginnings_and_misspellings_of_commands() -> None:
    result = drive(',cou (call "cube")\n,re\n,rendr\n,\n')
    assert result.stdout == "1  cube\n"
    assert "ambiguous command `,re`" in result.stderr
    assert ",reload" in result.stderr
    assert "did you mean `,render`" in result.stderr


COMMANDS = [
    (",doc twice", "function (twice x)|  Twice as much."),
    (",doc leg", '  A leg of the table.'),
    (",doc grid", "(grid object"),
    (",doc if", "(if test then [else])"),
    (",doc double", "macro"),
    (',doc "cube"', '(call "cube" :scale :color :emission|  a box centered|  :scale  side lengths along x, y and z|  :ior  '),
    (",doc cylinder", '(call "cylinder" :radius :p0 :p1 :color|  :p1  end point [x y z] of the axis'),
    (",doc :radius", ":radius|  radius in scene units|  read by sphere, cylinder, cone"),
    (",doc :opacity", "read by cube, sphere, cylinder, cone, capsule, torus, rounded-cube, mesh,"),
    (",apropos twic", "twice"),
    (",apropos mirror", "mirror  "),
    (",source twice", "; Twice as much.|(define (twice x) (double x))"),
    (",source leg", '(bind "leg"'),
    (",source row", "(define (row"),
    (",tree", "table <z1>|└─ 4 x leg"),
    (',tree (call "leg")', "leg <z1>|└─ cube"),
    (",count", "1  table|4  leg|4  cube"),
    (",bounds", "min     [-0.5 -1 -0.5]|max     [9.5 1 0.5]"),
    (',bounds (call "leg")', "sizes   [1 2 1]"),
    (",expand (double 4)", "(* 2 4)"),
    (",time (twice 4)", "8|steps"),
    (",trace twice\n(twice 4)\n,trace\n,trace twice\n(twice 5)", "twice is traced|(twice 4)|=> 8|traced: twice|no longer traced|10"),
    (',trace leg\n(call "table")', '"leg" is traced|("leg" 2)|=> '),
    (",reset\n(bound? \"leg\")", "all definitions removed|#f"),
    (",quit\n(+ 1 1)", ""),
]  # fmt: skip


@pytest.mark.parametrize(("text", "expected"), COMMANDS, ids=[c[0].split("\n")[0] for c in COMMANDS])
@pytest.mark.sampled(2)
def test_commands(program: Path, text: str, expected: str) -> None:
    found = "\n".join(lines(text, str(program)))
    position = 0
    for part in expected.split("|"):
        position = found.find(part, position)
        assert position >= 0, f"{part!r} in {found!r}"
    if not expected:
        assert found == ""


def test_what_commands_cannot_do_is_said(tmp_path: Path) -> None:
    text = (
        ",doc nothng\n,source car\n,expand\n,expand (if)\n,tree\n,tree 5\n,seed x\n,load none.scene\n,reload\n,trace zzz\n"
        ",save\n,save a.scene\n(define k 1)\n,save /nowhere/a.scene\n,save .\n,export a.xyz\n,render -o a.xyz\n,watch\n"
        ",transpile none.py\n,render 5\n,view\n"
    )
    result = drive(text, "--strict-errors", cwd=tmp_path)
    assert result.returncode == 1
    assert result.stderr.count("error[") == 19 + 0, result.stderr
    assert "Traceback" not in result.stderr
    assert list(tmp_path.iterdir()) == []


def test_save_writes_to_files_only(tmp_path: Path) -> None:
    result = drive("(define k 1)\n,save -\n,save! -\n,save ./-\n", cwd=tmp_path)
    assert result.stderr.count("`,save` cannot write to standard output") == 2
    assert [path.name for path in tmp_path.iterdir()] == ["-"]


@pytest.mark.slow
def test_render_and_export(program: Path, tmp_path: Path) -> None:
    out = lines(
        f',render -o {tmp_path}/a.png\n,render (call "sphere") -o "{tmp_path}/b.png"\n,export {tmp_path}/a.glb\n,render\n',
        str(program),
    )
    assert [line for line in out if not line.startswith("wrote")] == ['of the root "table":'] * 3
    out = [line for line in out if line.startswith("wrote")]
    assert len(out) == 4
    assert (tmp_path / "a.glb").read_bytes()[:4] == b"glTF"
    for path in (tmp_path / "a.png", tmp_path / "b.png", Path(out[3].split()[1])):
        image = Image.open(path)
        assert image.size == (640, 480)
        assert len(image.convert("RGB").getcolors(1 << 20)) > 100


def test_save_never_overwrites_unasked(program: Path, tmp_path: Path) -> None:
    saved = tmp_path / "saved.scene"
    assert lines(f",save {saved}", str(program)) == [f"wrote {saved}"]
    before = saved.read_text()
    assert "; A leg of the table." in before
    result = drive(f"(define k 1)\n,save {saved}\n", str(program))
    assert "already exists" in result.stderr
    assert saved.read_text() == before
    lines(f"(define k 1)\n,save! {saved}\n", str(program))
    assert "(define k 1)" in saved.read_text()
    assert lines(",count", str(saved)) == lines(",count", str(program))


def test_transpile(tmp_path: Path) -> None:
    path = tmp_path / "response.txt"
    path.write_text(
        "```python\nfrom helper import *\n\n@register()\ndef brick() -> Shape:\n    return primitive_call('cube', color=(1, 0, 0))\n\n\n"
        "@register()\ndef wall() -> Shape:\n    return loop(3, lambda i: transform_shape(library_call('brick'), translation_matrix((i, 0, 0))))\n```\n"
    )
    out = lines(f',transpile {path}\n(bound? "brick")\n,count\n', cwd=tmp_path)
    assert "2 of them words" in out[0]
    assert out[1] == "#t"
    assert "3  brick" in [line.strip() for line in out]


def test_watch_says_what_changed(program: Path) -> None:
    with watching([sys.executable, "-m", "scenelang", "repl", str(program)], program.parent) as (process, _, stdout):
        rewrite(program, FILE.replace("union-loop 4", "union-loop 6"))
        line = stdout.readline()
        assert "4 -> 6 primitives" in line
        assert "table.scene changed: 4 -> 6 primitives, sizes [16 2 1], 2 added" in line
        assert "sizes [16 2 1]" in line
        rewrite(program, FILE.replace("(scene", "(scenee"))
        assert "error" in stdout.readline()
        out, _ = process.communicate(",watch\n(twice 2)\n")
        assert out.endswith("is no longer watched\n4\n")


@pytest.mark.parametrize("folder", ["", "parts/", "parts/wood/"])
@pytest.mark.sampled(3)
def test_watch_notices_an_import_that_is_created_later(program: Path, folder: str) -> None:
    with watching([sys.executable, "-m", "scenelang", "repl", str(program)], program.parent) as (process, _, stdout):
        rewrite(program, f'(import "{folder}legs.scene")\n(bind "table" (lambda () (call "leg")))')
        read_until(stdout, "E701")
        for made in [*reversed(Path(folder).parents[:-1]), Path(folder)] if folder else []:
            (program.parent / made).mkdir()
            read_until(stdout, "E701")
        rewrite(program.parent / folder / "legs.scene", '(bind "leg" (lambda () (call "cube")))')
        assert "table.scene changed" in read_until(stdout, "primitive")[-1]
        process.communicate(",quit\n")


def test_the_viewer_follows_the_session(program: Path) -> None:
    import urllib.request

    command = [sys.executable, "-m", "scenelang", "repl", str(program)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdin is not None
        assert process.stdout is not None

        def say(text: str) -> str:
            assert process.stdin is not None
            assert process.stdout is not None
            process.stdin.write(text + "\n")
            process.stdin.flush()
            return process.stdout.readline()

        address = say(",view").split()[0]
        get = lambda path: urllib.request.urlopen(address + path, timeout=PATIENCE).read()
        before = json.loads(get("state?file=0"))
        assert before["ok"], before
        say('(bind "leg" (lambda () (call "sphere"))) 1')
        wait_until(lambda: json.loads(get("state?file=0"))["version"] != before["version"])
        assert json.loads(get("state?file=0"))["ok"]
        process.communicate()


# --- hostile -------------------------------------------------------------------------------------------------------

FLOODS = [
    "(iota 1000000)", '(apply mutable-list (iota 100000))', "(ones 1000000)", "(ones '(2000 2000))",
    '(string-join (for/list ((i (iota 100000))) "ab") "")', "(expt 7 4000)", "(for/fold ((l '())) ((i (iota 100000))) (list l))",
    "(for ((i (iota 50000))) (print i))", '(print "a\\nb\\nc" (string-join (for/list ((i (iota 10000))) "x\\n") ""))',
    '(for/union ((i (iota 200000))) (call "cube" :scale (+ 1 i)))',
    "(for/table ((i (iota 1000))) (list i i))",
    '(begin (bind "a" (lambda () (for/union ((i (iota 5000))) (call (if (odd? i) "cube" "cone") :scale 1)))) (call "a"))',
]  # fmt: skip


@pytest.mark.parametrize("text", one_in(2, FLOODS))
@pytest.mark.sampled(2)
def test_no_value_floods_the_screen(text: str) -> None:
    result = drive(text, "--max-depth", "1000")
    found = result.stdout.splitlines()
    assert "error" not in result.stderr, result.stderr
    assert found
    assert len(found) <= 201
    assert max(map(len, found)) <= 100
    if "print" not in text:
        assert len(found) <= 12


def test_control_characters_are_shown_safely() -> None:
    result = drive('"\\x1b;[31m\\a"\n(print "\\x1b;]0;title\\a")\n(call "\\x1b;[2J")\n(error "\\x1b;[31m")\n')
    assert not set(result.stdout + result.stderr) & {"\x1b", "\a", "\x9b"}


def test_deep_nesting_is_an_error_or_a_value() -> None:
    result = drive("(" * 50_000 + ")" * 50_000 + "\n" + "'" * 4_000 + "x\n(+ 1 1)\n")
    assert result.returncode == 0
    assert result.stdout.endswith("2\n")
    assert "Traceback" not in result.stderr


def test_what_is_no_text_does_no_harm() -> None:
    command = [sys.executable, "-m", "scenelang", "repl"]
    result = subprocess.run(command, input=b"\xff\xfe(\n)\n\x00\n(+ 1 1)\n", capture_output=True)
    assert result.returncode == 0
    assert result.stdout.endswith(b"2\n")


def test_it_starts_with_few_modules() -> None:
    """Of other packages only numpy; drawing, exports and models come with the commands that need them."""
    words = [sys.executable, "-X", "importtime", "-m", "scenelang", "repl"]
    done = subprocess.run(words, input="(+ 1 1)\n", capture_output=True, text=True, check=True)
    assert done.stdout == "2\n"
    loaded = {line.rpartition("|")[2].strip() for line in done.stderr.splitlines() if line.startswith("import time:")}
    packages = {name.partition(".")[0] for name in loaded} & packages_distributions().keys()
    assert packages - {"_distutils_hack"} == {"numpy", "scenelang"}  # the first is loaded by every Python that has it
    assert 50 < sum(name.startswith("scenelang") for name in loaded) < 165


# --- the documentation -----------------------------------------------------------------------------------------------

DOCUMENT = (Path(__file__).parents[2] / "docs" / "repl.md").read_text("utf-8")


def test_the_session_in_the_documentation_is_true() -> None:
    shown = DOCUMENT.split("```\n")[1]
    inputs = "".join(
        re.sub(r"^(scene> | {7})", "", line) + "\n" for line in shown.splitlines() if line[:7] in ("scene> ", " " * 7)
    )
    outputs = [line for line in shown.splitlines() if line[:7] not in ("scene> ", " " * 7)]
    assert lines(inputs) == outputs


def test_every_command_is_documented() -> None:
    from scenelang.repl.commands import commands

    for command in commands():
        assert f"`{command.usage}`" in DOCUMENT


def test_commands_say_what_they_are_about() -> None:
    """A value that was given before something else was defined is not taken for the scene."""
    text = '(call "sphere")\n,count\n(bind "a" (lambda () (call "cube")))\n,count\n(call "a")\n(define x 1)\n,count\n'
    assert lines(text) == [
        "sphere",
        'of `(call "sphere")`, the last value:',
        "1  sphere",
        'of the root "a":',
        "1  a",
        "1  cube",
        "a",
        "└─ cube",
        'of the root "a":',
        "1  a",
        "1  cube",
    ]
    assert lines('(call "sphere")\n(define x 1)\n,count\n') == ["sphere", "of `*1`, an earlier value:", "1  sphere"]


def test_json_of_a_command_has_the_errors_of_its_form() -> None:
    result = drive(",time (car 5)\n,time (+ 1 2)\n", "--json")
    wrong, right = [json.loads(line) for line in result.stdout.splitlines()]
    assert [d["code"] for d in wrong["diagnostics"]] == ["E401"]
    assert not wrong["ok"]
    assert (right["ok"], right["value"]) == (True, "3")

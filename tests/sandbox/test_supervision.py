"""Hard limits: whatever an evaluation does, its process ends in time with a diagnostic, and the rest goes on."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from sampling import one_in
from support import interruptible, is_running, rewrite, wait_for_more_work, wait_for_work, wait_until, watching

from scenelang.cli.main import main
from scenelang.sandbox.supervision import is_bounded, is_supported

pytestmark = pytest.mark.skipif(not is_supported(), reason="hard limits need Linux")
ROGUE = str(Path(__file__).with_name("rogue.py"))
BODY = '(define (work) (rogue "{}"))\n(bind "a" (lambda () (work) (call "cube")))\n'
AT_WORK = 0.8  # of the processor: seconds after which a child has begun what holds on for minutes


def command(*words: str) -> list[str]:
    return [sys.executable, "-P", ROGUE, *words]


def run(*words: str, cwd: Path, **options: Any) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command(*words), cwd=cwd, capture_output=True, text=True, check=False, **options)


# What happens to the process that evaluates: the options, the signal that is sent, then code and exit status.
ENDINGS = {
    "time": ("hold", ["--max-seconds", "0.5"], None, "E507", 1),
    "memory": ("grow", ["--max-memory", "300M"], None, "E506", 1),
    "Ctrl-C": ("hold", [], signal.SIGINT, "E508", 130),
    "crash": ("crash", [], None, "E509", 1),
}


@pytest.mark.parametrize("name", ENDINGS)
@pytest.mark.sampled(2)
def test_every_ending_is_one_diagnostic_with_the_place(name: str, tmp_path: Path) -> None:
    what, options, sent, code, status = ENDINGS[name]
    (tmp_path / "prog.scene").write_text(BODY.format(what))
    with interruptible(command("run", "prog.scene", "--json", *options), tmp_path) as running:
        if sent is not None:
            wait_for_work(running.pid, AT_WORK)
            running.send_signal(sent)
        out, err = running.communicate()
    assert running.returncode == status, err
    (found,) = json.loads(err)
    assert found["code"] == code
    assert out == b""
    if name != "crash":  # which is over before anybody looked
        assert found["place"]["line"] in (1, 2)  # a builtin that keeps the lock may hide its own call, not its caller's
        assert found["place"]["file"] == "prog.scene"
        assert '"a"' in [call["word"] for call in found["chain"]]


@pytest.mark.parametrize("word", one_in(5, ["run", "check", "count", "tree", "flatten"]))
def test_every_command_ends_at_the_limit(word: str, tmp_path: Path) -> None:
    program = '(define-macro (m) (rogue "hold"))\n(m)\n' if word == "check" else BODY.format("hold")
    (tmp_path / "prog.scene").write_text(program)
    done = run(word, "prog.scene", "--max-seconds", "0.5", cwd=tmp_path)
    assert "E507" in done.stderr
    assert done.returncode == 1


BOUNDED = {
    "a program": ({}, '(bind "a" (lambda () (call "cube")))', True),
    "an import": ({"b.scene": "(define b 1)"}, '(import "b.scene")', True),
    "a module": ({}, '(import "std/python.scene")', True),
    "imports of each other": ({"b.scene": '(import "a.scene")'}, '(import "b.scene")', True),
    "a syntax rule": ({}, "(define-syntax m (syntax-rules () ((_ x) x)))\n(define b (m 1))", True),
    "a procedural macro": ({}, "(define-macro (m) 1)", False),
    "a procedural macro of an import": ({"b.scene": "(define-macro (m) 1)"}, '(import "b.scene")', False),
    "a symbol in bars": ({}, "(|define\\x2d;macro| (m) 1)", False),
    "a path with an escape": ({"b.scene": "(define-macro (m) 1)"}, '(import "\\x62;.scene")', False),
    "an import that is not understood": ({}, '(import #;"c" "b.scene")', False),
    "a comment about an import": ({}, "; import and | are words\n(define b 1)", True),
    "a comment in a text": ({}, '(define b "\n; " (define-macro (m) 1))', False),
    "a long program": ({}, "(f)\n" * 20_000, False),
    "a missing import": ({}, '(import "b.scene")', False),
}


@pytest.mark.parametrize("name", BOUNDED)
def test_only_programs_without_procedural_macros_are_checked_without_a_monitor(
    tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    files, text, expected = BOUNDED[name]
    for file, content in {**files, "a.scene": text}.items():
        (tmp_path / file).write_text(content)
    assert is_bounded([str(tmp_path / "a.scene")]) is expected
    forked: list[bool] = []
    monkeypatch.setattr("scenelang.cli.main.supervise", lambda *_: forked.append(True) or 0)
    main(["check", str(tmp_path / "a.scene")], supervised=True)
    assert forked == ([] if expected else [True])
    main(["check", "--run", str(tmp_path / "a.scene")], supervised=True)
    assert len(forked) == (1 if expected else 2)


ALONE = {  # what the check does, the limits of the clocks, and what is said
    "CPU time": ("while True: pass", {"GRACE": -59.5}, "E507", "limit of 60 seconds of CPU time", 1),
    "wall clock": ("time.sleep(3600)", {"wall_guard": "lambda seconds: .5"}, "E510", "sleeps or is blocked", 1),
    "Ctrl-C": ("print('checking', flush=True); time.sleep(3600)", {}, "interrupted", "interrupted", 130),
}


@pytest.mark.parametrize("ending", ALONE)
def test_a_check_without_a_monitor_ends(tmp_path: Path, ending: str) -> None:
    (tmp_path / "prog.scene").write_text("(define b 1)")
    body, clocks, code, message, status = ALONE[ending]
    program = (
        "import time, sys, scenelang.session.session, scenelang.cli.main as m, scenelang.sandbox.supervision as supervision\n"
        f"def check(*_):\n    {body}\n"
        "scenelang.session.session.Session.check = check\n"
        + "".join(f"supervision.{name} = {value}\n" for name, value in clocks.items())
        + "sys.exit(m.main(['check', 'prog.scene'], supervised=True))"
    )
    with interruptible([sys.executable, "-c", program], tmp_path) as running:
        if ending == "Ctrl-C":
            assert running.stdout is not None
            assert running.stdout.readline() == b"checking\n"
            running.send_signal(signal.SIGINT)
        _, err = running.communicate()
    assert running.returncode == status, err
    assert code in err.decode()
    assert message in err.decode()


def test_what_sleeps_is_ended_by_the_wall_clock(tmp_path: Path) -> None:
    """The limit of CPU time alone would let it sleep for ever."""
    (tmp_path / "prog.scene").write_text(BODY.format("sleep"))
    program = (
        "import sys, runpy, scenelang.sandbox.supervision as supervision\n"
        "supervision.wall_guard = lambda seconds: 2\n"
        f"sys.argv = [{ROGUE!r}, 'run', 'prog.scene', '--json']\n"
        f"runpy.run_path({ROGUE!r}, run_name='__main__')"
    )
    done = subprocess.run(
        [sys.executable, "-P", "-c", program], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 1, done.stderr
    (problem,) = json.loads(done.stderr)
    assert problem["code"] == "E510"
    assert "sleeps or is blocked" in problem["message"]
    assert problem["place"]["line"] in (1, 2)


def test_the_use_of_a_macro_is_in_the_chain(tmp_path: Path) -> None:
    (tmp_path / "prog.scene").write_text("(define-macro (m) (for ((i 100000000)) (sort (iota 100))))\n(m)\n")
    done = run("check", "prog.scene", "--max-seconds", "0.5", cwd=tmp_path)
    assert "E507" in done.stderr
    assert "in `m`, called at prog.scene:2:1" in done.stderr


def test_memory_is_held_within_a_tenth(tmp_path: Path) -> None:
    (tmp_path / "prog.scene").write_text(BODY.format("grow"))
    with interruptible(command("run", "prog.scene", "--max-memory", "400M"), tmp_path) as running:
        most = 0
        while running.poll() is None:
            most = max(most, *(resident(pid) for pid in children(running.pid)), 0)
    assert most < 400e6 * 1.1 + 120e6  # with what the process had at the start


def children(pid: int) -> list[int]:
    try:
        return [int(child) for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()] or [0]
    except OSError:
        return [0]


def resident(pid: int) -> int:
    try:
        return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except OSError:
        return 0


REFUSED = {
    "write", "append", "delete", "rename", "truncate", "mode", "folder", "link", "read", "read above", "socket", "pair",
    "execute", "replace", "fork", "signal",
}  # fmt: skip


def test_evaluation_may_only_read_the_project(tmp_path: Path) -> None:
    project = tmp_path / "project"
    project.mkdir()
    (tmp_path / "secret.txt").write_text("secret")
    (project / "victim.txt").write_text("victim")
    prints = "\n".join(f'(print "{what}:" (rogue "{what}"))' for what in sorted(REFUSED | {"read here"}))
    (project / "prog.scene").write_text(f'{prints}\n(bind "a" (lambda () (call "cube")))\n')
    done = run("run", "prog.scene", cwd=project)
    told = dict(line.split(": ", 1) for line in done.stderr.splitlines() if ": " in line)
    assert {what for what, said in told.items() if said.startswith("refused")} == REFUSED, done.stderr
    assert told["read here"] == "done"
    assert (project / "victim.txt").read_text() == "victim"
    assert sorted(path.name for path in project.iterdir()) == ["prog.scene", "victim.txt"]
    assert done.returncode == 0


@pytest.mark.slow
def test_what_follows_an_evaluation_may_write(tmp_path: Path) -> None:
    (tmp_path / "prog.scene").write_text(BODY.format("write"))
    done = run("render", "prog.scene", "-o", "a.png", "--size", "32x32", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "a.png").exists()
    assert not (tmp_path / "written.txt").exists()


REPL = """(define x 5)
(rogue "hold")
(+ x 1)
(define y 7)
(rogue "crash")
(+ x y)
"""


@pytest.mark.slow
def test_a_repl_keeps_its_session(tmp_path: Path) -> None:
    done = run("repl", "--json", "--max-seconds", "0.5", cwd=tmp_path, input=REPL)
    answers = [json.loads(line) for line in done.stdout.splitlines()]
    assert [answer["value"] for answer in answers] == [None, None, "6", None, None, "12"]
    assert [[d["code"] for d in answer["diagnostics"]] for answer in answers] == [[], ["E507"], [], [], ["E509"], []]
    assert done.returncode == 0


def test_the_viewer_reads_what_a_program_imports(tmp_path: Path) -> None:
    (tmp_path / "legs.scene").write_text('(bind "leg" (lambda () (call "cube")))')
    (tmp_path / "prog.scene").write_text('(import "legs.scene")\n(bind "a" (lambda () (call "leg")))')
    done = run("view", "prog.scene", "--html", "a.html", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "a.html").exists()


def watched(seconds: str) -> list[str]:
    return command("repl", "--plain", "--max-seconds", seconds, "prog.scene")


@pytest.mark.parametrize("what", ["hold", "crash"])
@pytest.mark.slow
def test_a_repl_keeps_its_session_when_a_watched_file_is_killed(tmp_path: Path, what: str) -> None:
    program = tmp_path / "prog.scene"
    rewrite(program, '(define x 5)\n(bind "a" (lambda () (call "cube")))\n')
    with watching(watched("0.5"), tmp_path, "(define y 7)\n") as (running, stdin, stdout):
        rewrite(program, f'(define x 6)\n(rogue "{what}")\n')
        assert {"hold": "E507", "crash": "E509"}[what] in stdout.readline()
        stdin.write("(+ x y)\n")
        stdin.flush()
        while (line := stdout.readline()) != "12\n":
            assert line.startswith(" ")  # of the diagnostic
        rewrite(program, '(define x 7)\n(bind "a" (lambda () (union (call "cube") (call "cube"))))\n')
        assert "prog.scene changed: 1 -> 2 primitives" in stdout.readline()
        out, _ = running.communicate("(+ x y)\n")
    assert out == "14\n"


@pytest.mark.slow
def test_a_watched_file_that_changes_during_a_killed_evaluation_is_read_again(tmp_path: Path) -> None:
    program = tmp_path / "prog.scene"
    rewrite(program, '(bind "a" (lambda () (call "cube")))\n')
    with watching(watched("1"), tmp_path) as (running, _, stdout):
        rewrite(program, '(bind "a" (lambda () (rogue "hold") (call "cube")))\n')
        wait_for_more_work(running.pid, 0.3)
        rewrite(program, '(bind "a" (lambda () (union (call "cube") (call "cube"))))\n')
        said = [stdout.readline()]
        while "2 primitives" not in said[-1]:
            assert said[-1], said
            said.append(stdout.readline())
        assert "E507" in said[0]
        assert any("no scene" in line for line in said)
        running.communicate(",quit\n")


@pytest.mark.slow
def test_a_repl_survives_ctrl_c_in_a_builtin_that_never_looks(tmp_path: Path) -> None:
    with subprocess.Popen(
        command("repl", "--plain"), cwd=tmp_path, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    ) as running:  # fmt: skip
        assert running.stdin is not None
        assert running.stdout is not None
        running.stdin.write("(define x 5)\n(* x 2)\n")
        running.stdin.flush()
        assert running.stdout.readline() == "10\n"
        running.stdin.write('(rogue "hold")\n(+ x 1)\n')
        running.stdin.flush()
        wait_for_more_work(running.pid, 1.0)
        running.send_signal(signal.SIGINT)
        out, err = running.communicate()
    assert out == "6\n"
    assert "E508" in err


@pytest.mark.slow
def test_the_child_ends_with_its_monitor(tmp_path: Path) -> None:
    (tmp_path / "prog.scene").write_text(BODY.format("hold"))
    with interruptible(command("run", "prog.scene"), tmp_path) as running:
        child = wait_for_work(running.pid, AT_WORK)
        running.kill()
        running.wait()
        wait_until(lambda: not is_running(child))

"""Calls that ask for too much or reach where they may not, and programs that try to."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

CUBE = '(bind "a" (lambda () (call "cube")))'


def text(result: Any) -> str:
    (said,) = (content.text for content in result.content if content.type == "text")
    return said


@pytest.mark.parametrize(
    "path",
    ["../secret.scene", "/etc/passwd", "/dev/zero", "/dev/stdin", "sub/../../secret.scene", "link.scene", "folder",
     "nothing.scene", "-", "a\0b", "x" * 3_000, "x" * 5_000, "loop.scene", "\x1b[31m\n", "pipe.scene", "."],
)  # fmt: skip
def test_paths_that_are_no_files_of_the_project(agent: Any, path: str) -> None:
    (agent.project.parent / "secret.scene").write_text("(secret)")
    (agent.project / "folder").mkdir(exist_ok=True)
    for link, target in (("link.scene", "../secret.scene"), ("loop.scene", "loop.scene")):
        if not os.path.lexists(agent.project / link):
            (agent.project / link).symlink_to(target)
    if not (agent.project / "pipe.scene").exists():
        os.mkfifo(agent.project / "pipe.scene")
    for tool, name in (("check", "path"), ("run", "path"), ("diff", "path_a")):
        said = agent.refused(tool, **{name: path})
        assert "secret)" not in said
        assert said.isprintable()


def test_programs_do_not_reach_outside_either(agent: Any) -> None:
    (agent.project.parent / "outside.scene").write_text(CUBE)
    (agent.project.parent / "outside.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    for program in (
        f'(import "../outside.scene") {CUBE}',
        '(bind "a" (lambda () (call "mesh" :file "../outside.obj")))',
    ):
        found = agent.told("run", program=program)
        assert [d["name"] for d in found["diagnostics"]] == ["import-outside"]


def test_a_camera_file_lies_in_the_project(agent: Any) -> None:
    (agent.project.parent / "camera.json").write_text("{}")
    assert "is outside the project folder" in agent.refused("render", program=CUBE, camera="../camera.json")
    assert "is outside the project folder" in agent.refused("render", program=CUBE, camera=" /etc/camera.JSON ")


def test_embeddings_beside_a_program_are_no_way_out(agent: Any) -> None:
    (agent.project / "z.scene").write_text(CUBE)
    (agent.project / "z.z.safetensors").symlink_to("/dev/zero")
    assert "is outside the project folder" in agent.refused("run", path="z.scene")


@pytest.mark.parametrize(
    ("tool", "arguments", "part"),
    [
        ("check", {}, "expected one of"),
        ("check", {"program": CUBE, "path": "a.scene"}, "expected one of"),
        ("check", {"program": 3}, "`program`"),
        ("check", {"program": "(" * 1_000_001}, "1,000,000"),
        ("render", {"program": CUBE, "width": 1025}, "1024"),
        ("render", {"program": CUBE, "height": 0}, "`height`"),
        ("render", {"program": CUBE, "frame": "[" * 100_000}, "exceeds 4,000 characters"),
        ("render", {"program": CUBE, "camera": "x" * 5_000}, "exceeds 4,000 characters"),
        ("count", {"program": CUBE, "frame": -1}, "`frame`"),
        ("diff", {"program_a": CUBE, "program_b": CUBE, "tolerance": 2}, "`tolerance`"),
        ("help", {"name": "\x1b[2J" * 100}, "unknown name"),
        ("nothing", {}, "nothing"),
        ("check", {"programm": CUBE}, "`check` has no argument `programm`; did you mean `program`?"),
        ("run", {"program": CUBE, "colour": "red"}, "`run` has no argument `colour`; its arguments are "),
        ("help", {"x" * 5_000: 1}, "`help` has no argument `xxx"),
    ],
)
def test_wrong_arguments_are_one_line(agent: Any, tool: str, arguments: dict[str, Any], part: str) -> None:
    said = agent.refused(tool, **arguments)
    assert part in said
    assert len(said) < 1_000
    assert said.isprintable()


@pytest.mark.parametrize("tool", ["check", "run"])
@pytest.mark.parametrize(
    "program", ["(" * 100_000, "[" * 100_000, "'" * 900_000, "\0\0", "\u202e(", "(" * 300 + ")" * 300]
)
@pytest.mark.sampled(2)
def test_texts_that_are_no_programs(agent: Any, tool: str, program: str) -> None:
    found = agent.told(tool, program=program)
    assert not found["ok"]
    assert len(json.dumps(found)) < 60_000


def test_a_huge_file(agent: Any) -> None:
    with (agent.project / "huge.scene").open("wb") as file:
        file.truncate(20_000_000)
    assert [d["name"] for d in agent.told("check", path="huge.scene")["diagnostics"]] == ["file"]


def test_answers_are_short(agent: Any) -> None:
    many = (
        '(bind "a" (lambda () (union-loop 500 (lambda (i) (transform (call (format "w{}" i)) (translate [i 0 0]))))))'
    )
    counted = agent.told("count", program=many)
    assert len(counted["counts"]) + counted["counts_left_out"] == 501
    moved = agent.told("diff", program_a=many, program_b=many.replace("[i 0 0]", "[i 5 0]"))
    assert (moved["moved"], len(moved["changes"]) + moved["changes_left_out"]) == (500, 500)
    printed = agent.told("run", program=f'(for ((i 1000)) (print "{"x" * 50}")) {CUBE}')
    assert len(printed["log"]) + printed["log_left_out"] == 1000
    assert len(agent.told("run", program=f'(print "{"x" * 90_000}") {CUBE}')["log"][0]) < 1_000
    wrong = agent.call("check", program="\n".join(f"(f{i})" for i in range(500)))
    assert len(wrong.structured_content["diagnostics"]) + wrong.structured_content["diagnostics_left_out"] == 500
    long = agent.call("run", program=f'(error "{"x" * 900_000}") {CUBE}')
    for result in (wrong, long):
        assert len(json.dumps(result.structured_content)) + len(text(result).encode()) < 4_096


def test_numbers_that_are_none_in_json(agent: Any) -> None:
    program = '(bind "a" (lambda () (call "cube" :scale 1e308)))'
    assert agent.call("run", program=program).is_error is False
    assert agent.call("diff", program_a=program, program_b=CUBE).is_error is False


def test_calls_at_once_do_not_disturb_one_another(agent: Any) -> None:
    deep = "(define (f n) (if (= n 0) 0 (+ 1 (f (- n 1))))) (f 20000) " + CUBE
    answers = agent.at_once(*[("run", {"program": deep}), ("check", {"program": "("}), ("help", {})] * 4)
    assert [a.structured_content["ok"] for a in answers if a.structured_content] == [True, False] * 4
    assert agent.told("run", program=CUBE)["ok"]


def test_a_loop_without_end_ends(serve: Callable[..., Any]) -> None:
    with serve("--max-seconds", "1", "--max-steps", "1G") as agent:
        found = agent.told("run", program=f"(define (f) (f)) (f) {CUBE}")
        assert [d["name"] for d in found["diagnostics"] if d["severity"] == "error"] == ["time"]


def test_lines_that_are_no_messages(tmp_path: Path) -> None:
    """Whatever comes in, only messages go out, nothing of a traceback, and the end of the input is the end."""
    command = [sys.executable, "-P", "-m", "scenelang", "mcp"]
    sent = b'hello\n{"jsonrpc": "2.0"}\n[[[[\n\xff\xfe\n' + b"[" * 100_000 + b"\n"
    done = subprocess.run(command, input=sent, capture_output=True, cwd=tmp_path)
    assert done.returncode == 0
    assert all(json.loads(line)["jsonrpc"] == "2.0" for line in done.stdout.splitlines())
    assert b"Traceback" not in done.stderr


@pytest.mark.parametrize("options", [["--project", "nothing"], ["--max-steps", "none"]])
def test_wrong_usage(options: list[str], tmp_path: Path) -> None:
    command = [sys.executable, "-P", "-m", "scenelang", "mcp", *options]
    done = subprocess.run(command, capture_output=True, cwd=tmp_path, input=b"")
    assert (done.returncode, done.stdout) == (2, b"")

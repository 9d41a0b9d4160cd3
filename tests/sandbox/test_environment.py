"""An evaluation sees no keys: neither those of its own process nor those of others, in any command or server.

A builtin of ``spy`` looks from inside while the test looks at ``/proc`` from outside.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.request import urlopen

import pytest
from models.server import Said, serving
from sandbox.spy import CANARY
from support import PATIENCE, below, wait_until

from scenelang.sandbox.environment import MORE, named_variables
from scenelang.sandbox.supervision import is_supported

pytestmark = pytest.mark.skipif(not is_supported(), reason="hard limits need Linux")
SPY = str(Path(__file__).with_name("spy.py"))
KEYS = dict.fromkeys(("ANTHROPIC_API_KEY", "OPENAI_API_KEY", "AWS_SECRET_ACCESS_KEY", "MY_TOKEN", "HF_TOKEN", "a", "LC", "PATHS", "PASSWORD_OF_LC_ALL"), CANARY)  # fmt: skip
LOOK = '(spy "{go}")'
PROGRAM = '(bind "a" (lambda () (call "cube" :scale {look})))\n'
FILM = '(bind "film" (lambda () (list (call "cube" :scale {look}) (call "cube"))))\n'


def spies(pid: int) -> list[tuple[str, bytes]]:
    """What the spies below and including a process have found, and the variables that the kernel shows of theirs."""
    found = []
    for each in [pid, *below(pid)]:
        for task in Path(f"/proc/{each}/task").glob("*"):
            try:
                name = (task / "comm").read_text().strip()
                if name.startswith("spy-"):
                    found.append((name.removeprefix("spy-"), Path(f"/proc/{each}/environ").read_bytes()))
            except OSError:
                pass
    return found


@contextmanager
def started(words: Sequence[str], folder: Path, **more: str) -> Iterator[subprocess.Popen[bytes]]:
    """A command with keys in its environment, beside which others run: none is in a pipe that fills up."""
    environment = {**os.environ, **KEYS, "LC_ALL": "C.UTF-8", "XDG_CACHE_HOME": str(folder / "cache"), **more}
    command = [sys.executable, "-P", *(["-m", "scenelang"] if "PYTHONPATH" in more else [SPY]), *words]
    with (
        (folder.parent / "said.txt").open("wb") as said,
        subprocess.Popen(
            command, cwd=folder, env=environment, stdin=subprocess.PIPE, stdout=said, stderr=said
        ) as running,
    ):
        try:
            yield running
        finally:
            running.kill()


def look(running: subprocess.Popen[bytes], go: Path) -> list[tuple[str, bytes]]:
    """What is found while a program is evaluated, which goes on then."""
    wait_until(lambda: spies(running.pid) or running.poll() is not None)
    found = spies(running.pid)
    go.write_text("")
    said = (go.parent.parent / "said.txt").read_text("utf-8", "replace")
    assert found, said
    return found


def check(found: list[tuple[str, bytes]]) -> None:
    for seen, kernel in found:
        assert seen == "", "the evaluation sees keys"
        assert CANARY.encode() not in kernel
        assert not set(KEYS) & {row.partition(b"=")[0].decode() for row in kernel.split(b"\0")}
        assert b"LC_ALL=C.UTF-8" in kernel.split(b"\0")


@pytest.fixture
def project(tmp_path: Path) -> Path:
    folder = tmp_path / "project"
    folder.mkdir()
    return folder


def write(folder: Path, text: str, name: str = "a.scene") -> Path:
    """A program that waits for the file ``go``, whose path is returned."""
    go = folder / "go"
    (folder / name).write_text(text.format(look=LOOK.format(go=go)))
    return go


COMMANDS = {
    "run": PROGRAM, "check --run": PROGRAM, "check --geometry": PROGRAM, "tree": PROGRAM, "flatten": PROGRAM, "count": PROGRAM, "bounds": PROGRAM,
    "measure": PROGRAM, "graph -o g.svg": PROGRAM, "export -o o.glb": PROGRAM, "export --solid -o o.stl": PROGRAM,
    "render -o o.png --size 8x8": PROGRAM, "render -o o.gif --size 8x8": FILM, "labels -o m --size 8x8": PROGRAM,
    "view --html v.html": PROGRAM, "simulate -o s.gif --size 8x8": PROGRAM, "settle -o s.scene": PROGRAM,
    "repair -o r.scene": PROGRAM, "embeddings list": PROGRAM, "imagine -o i.png": PROGRAM, "embed": PROGRAM, "distill -o d": PROGRAM,
    "expand": '(define-macro (m) {look})\n(bind "a" (lambda () (call "cube" :scale (m))))\n',
    "check": '(define-macro (m) {look})\n(bind "a" (lambda () (call "cube" :scale (m))))\n',
    "simplify": '(define-macro (m) {look})\n(bind "a" (lambda () (call "cube" :scale (m))))\n',
}  # fmt: skip


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.sampled(4)
def test_a_command_evaluates_without_keys(command: str, project: Path) -> None:
    go = write(project, COMMANDS[command])
    name, *options = command.split()
    with started([name, "a.scene", *options], project) as running:
        check(look(running, go))


def test_a_diff_evaluates_without_keys(project: Path) -> None:
    go = write(project, PROGRAM)
    with started(["diff", "a.scene", "a.scene"], project) as running:
        check(look(running, go))


def test_workers_of_a_dataset_evaluate_without_keys(project: Path) -> None:
    """They are new processes, which have the builtin because it comes with Python."""
    go = write(project, PROGRAM)
    (project / "d.toml").write_text('programs = ["a.scene"]\ncount = 2\n[pictures]\nsize = [8, 8]\n')
    load = f'import importlib.util as u\ns = u.spec_from_file_location("spy", {SPY!r})\ns.loader.exec_module(u.module_from_spec(s))'
    (project / "sitecustomize.py").write_text(load)
    with started(["dataset", "d.toml", "-o", "out", "--jobs", "2"], project, PYTHONPATH=str(project)) as running:
        check(look(running, go))


def test_the_viewer_evaluates_without_keys(project: Path) -> None:
    go = write(project, PROGRAM)
    with started(["view", "a.scene", "--no-browser"], project) as running, ThreadPoolExecutor(1) as pool:
        said = project.parent / "said.txt"
        wait_until(lambda: b"\n" in said.read_bytes())
        page = pool.submit(urlopen, f"{said.read_text().split()[0]}state?file=0", timeout=PATIENCE)
        check(look(running, go))
        assert json.loads(page.result().read())["ok"]


def test_inputs_of_the_repl_are_evaluated_without_keys(project: Path) -> None:
    go = project / "go"
    with started(["repl"], project) as running:
        assert running.stdin is not None
        running.stdin.write(f"(spy {json.dumps(str(go))})\n".encode())
        running.stdin.flush()
        check(look(running, go))


@pytest.mark.parametrize("command", [["generate", "a cube", "--dsl"], ["edit", "b.scene", "larger"]])
def test_answers_of_models_are_evaluated_without_keys(command: list[str], project: Path) -> None:
    """The service needs a key, and what it answers must not see it."""
    pytest.importorskip("anthropic")
    go = write(project, PROGRAM)
    (project / "b.scene").write_text('(bind "a" (lambda () (call "cube")))\n')
    answer = Said(f"```scene\n{(project / 'a.scene').read_text()}```")
    with (
        serving([answer] * 3) as server,
        started([*command, "-o", "o.scene"], project, ANTHROPIC_BASE_URL=server.url) as running,
    ):
        check(look(running, go))


# --- servers ---------------------------------------------------------------------------------------------------------


def say(running: subprocess.Popen[bytes], framed: bool, *messages: dict[str, Any]) -> None:
    """Send messages of JSON-RPC, each a line or with a header."""
    assert running.stdin is not None
    for message in messages:
        body = json.dumps({"jsonrpc": "2.0", **message}).encode()
        running.stdin.write(b"Content-Length: %d\r\n\r\n%s" % (len(body), body) if framed else body + b"\n")
    running.stdin.flush()


@pytest.mark.parametrize("tool", ["run", "check", "render"])
def test_the_server_of_agents_evaluates_without_keys(tool: str, project: Path) -> None:
    pytest.importorskip("mcp")
    go = write(project, COMMANDS["check"] if tool == "check" else PROGRAM)
    client = {"protocolVersion": "2025-06-18", "capabilities": {}, "clientInfo": {"name": "test", "version": "1"}}
    call = {"name": tool, "arguments": {"program": (project / "a.scene").read_text()}}
    with started(["mcp", "--project", str(project)], project) as running:
        say(
            running, False, {"id": 1, "method": "initialize", "params": client}, {"method": "notifications/initialized"}
        )
        say(running, False, {"id": 2, "method": "tools/call", "params": call})
        check(look(running, go))


def test_the_language_server_evaluates_without_keys(project: Path) -> None:
    pytest.importorskip("pygls")
    go = write(project, COMMANDS["check"])
    document = {
        "uri": (project / "a.scene").as_uri(),
        "languageId": "scene",
        "version": 1,
        "text": (project / "a.scene").read_text(),
    }
    start = {"processId": os.getpid(), "rootUri": project.as_uri(), "capabilities": {}}
    with started(["lsp"], project) as running:
        say(running, True, {"id": 1, "method": "initialize", "params": start}, {"method": "initialized", "params": {}})
        say(running, True, {"method": "textDocument/didOpen", "params": {"textDocument": document}})
        check(look(running, go))


# --- what is kept ----------------------------------------------------------------------------------------------------


def test_variables_that_a_plug_in_needs_can_be_named(project: Path) -> None:
    go = write(project, PROGRAM)
    with started(
        ["run", "a.scene"], project, **{MORE: "MINE, OTHER", "MINE": "5", "OTHER": "6", "THIRD": "7"}
    ) as running:
        found = look(running, go)
        running.wait(PATIENCE)
    check(found)
    rows = found[0][1].split(b"\0")
    assert {b"MINE=5", b"OTHER=6"} <= set(rows)
    assert b"THIRD=7" not in rows


def test_named_variables() -> None:
    kept = {"PATH": "/bin", "HOME": "/root", "LC_TIME": "C", "CUDA_VISIBLE_DEVICES": "0", "SCENELANG_TRACEBACK": "1"}
    assert named_variables({**kept, **KEYS, "MY_PATH": "x", "SSH_AUTH_SOCK": "y", "GITHUB_TOKEN": "z"}) == kept


def test_a_long_environment_is_overwritten(project: Path) -> None:
    """The kept variables take less room than those that are removed, and none is cut off."""
    go = write(project, PROGRAM)
    with started(["run", "a.scene"], project, LONG="x" * 100_000, LC_LONG="y" * 50_000, TERM="dumb") as running:
        found = look(running, go)
        assert running.wait(PATIENCE) == 0
    check(found)
    assert b"LC_LONG=" + b"y" * 50_000 in found[0][1]
    assert b"xxxx" not in found[0][1]

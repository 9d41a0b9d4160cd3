"""Servers answer and go on, whatever an evaluation does: agents, the viewer, language models, the language server."""

from __future__ import annotations

import json
import subprocess
import sys
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import anyio
import pytest
from later import later
from support import PATIENCE, rewrite, wait_until

from scenelang.grammar.datum import Source
from scenelang.inference.brief import Brief, Prompts, Task
from scenelang.inference.steps import AnswerReader
from scenelang.interpreter.values.limits import Limits
from scenelang.sandbox.supervision import is_supported
from scenelang.session.editing import Editing
from scenelang.session.session import Options, Session

mcp, stdio = later("mcp"), later("mcp.client.stdio")

pytestmark = pytest.mark.skipif(not is_supported(), reason="hard limits need Linux")
ROGUE = str(Path(__file__).with_name("rogue.py"))
GOOD = '(bind "a" (lambda () (call "cube")))'


def program(what: str) -> str:
    return f'(bind "a" (lambda () (rogue "{what}") (call "cube")))'


def hold(*_: Any) -> Any:
    """Keep the interpreter's lock for minutes."""
    return sum(range(10**11))


@pytest.mark.slow
def test_an_agent_gets_help_while_programs_run(tmp_path: Path) -> None:
    meanwhile: list[bool] = []

    async def talk() -> list[Any]:
        options = ["--project", str(tmp_path), "--max-seconds", "3", "--max-memory", "300M"]
        parameters = stdio.StdioServerParameters(
            command=sys.executable, args=["-P", ROGUE, "mcp", *options], cwd=tmp_path
        )
        found = []
        async with stdio.stdio_client(parameters) as streams, mcp.ClientSession(*streams) as session:
            await session.initialize()
            await session.call_tool("help", {"name": "cube"})
            for what in ("hold", "grow", "crash"):
                async with anyio.create_task_group() as group:

                    async def run(what: str = what) -> None:
                        found.append(await session.call_tool("run", {"program": program(what)}))

                    group.start_soon(run)
                    await anyio.sleep(0.15)
                    answers = len(found)
                    await session.call_tool("help", {"name": "cube"})
                    meanwhile.append(len(found) == answers)
                found.append(await session.call_tool("run", {"program": GOOD}))
        return found

    results = [result.structured_content for result in anyio.run(talk)]
    assert [result["diagnostics"][0]["code"] for result in results[::2]] == ["E507", "E506", "E509"]
    assert all(result["ok"] for result in results[1::2])
    assert meanwhile[0]  # the others end at once


@pytest.mark.slow
def test_an_agent_that_gives_up_ends_the_evaluation(tmp_path: Path) -> None:
    async def talk() -> None:
        words = ["-P", ROGUE, "mcp", "--max-seconds", "1000000"]
        parameters = stdio.StdioServerParameters(command=sys.executable, args=words, cwd=tmp_path)
        async with stdio.stdio_client(parameters) as streams, mcp.ClientSession(*streams) as session:
            await session.initialize()
            with anyio.move_on_after(1.0):
                await session.call_tool("run", {"program": program("hold")})
            result = await session.call_tool("run", {"program": GOOD})  # waits until the other has ended
            assert result.structured_content is not None
            assert result.structured_content["ok"]

    anyio.run(talk)


@pytest.fixture
def viewer(tmp_path: Path) -> Iterator[tuple[str, Path]]:
    path = tmp_path / "a.scene"
    path.write_text(program("hold"))
    words = [sys.executable, "-P", ROGUE, "view", str(path), "--no-browser", "--max-seconds", "0.5", "-q"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, cwd=tmp_path) as running:
        assert running.stdout is not None
        try:
            yield running.stdout.readline().decode().strip(), path
        finally:
            running.terminate()
            running.wait(PATIENCE)


def state(address: str) -> dict[str, Any]:
    with urllib.request.urlopen(f"{address}state?file=0", timeout=PATIENCE) as answer:
        found: dict[str, Any] = json.loads(answer.read())
        return found


@pytest.mark.slow
def test_the_viewer_shows_why_and_goes_on(viewer: tuple[str, Path]) -> None:
    address, path = viewer
    assert [d["code"] for d in state(address)["diagnostics"]] == ["E507"]
    rewrite(path, GOOD)
    wait_until(lambda: state(address)["ok"])


@pytest.mark.slow
def test_an_answer_of_a_model_that_has_to_be_ended_is_a_verdict(monkeypatch: pytest.MonkeyPatch) -> None:
    reader = AnswerReader(Brief(Task("a cube"), Prompts(None)), Options(limits=Limits(seconds=0.5)))
    monkeypatch.setattr(AnswerReader, "_judged", hold)
    verdict = reader.read("```python\nx = 1\n```")
    assert [d.code for d in verdict.diagnostics] == ["E507"]
    assert not verdict.is_usable


def test_macros_in_an_editor_are_tried_first(monkeypatch: pytest.MonkeyPatch) -> None:
    editing = Editing(Session())
    text = "(define-macro (m) 1)\n(m)\n"
    assert editing.check(Source("a.scene", text)).diagnostics == ()
    monkeypatch.setattr(Editing, "_check", hold)
    monkeypatch.setattr("scenelang.session.editing._TRIAL_LIMITS", Limits(seconds=0.5))
    source = Source("a.scene", text + "; changed\n")
    analysis = editing.check(source)
    (problem,) = analysis.diagnostics
    assert problem.code == "E507"
    assert problem.span is not None
    assert problem.span.source is source
    monkeypatch.undo()
    assert editing.check(Source("a.scene", text)).diagnostics == ()

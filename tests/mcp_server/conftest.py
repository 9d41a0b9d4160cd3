"""The real server in a process of its own, driven over standard input and output by the library's own client."""

from __future__ import annotations

import os
import sys
from collections.abc import AsyncIterator, Callable, Iterator
from concurrent.futures import Future
from contextlib import asynccontextmanager, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from anyio import create_task_group
from anyio.from_thread import BlockingPortal, start_blocking_portal
from later import later

if TYPE_CHECKING:
    from mcp import ClientSession
    from mcp.types import CallToolResult

mcp, stdio = later("mcp"), later("mcp.client.stdio")

Call = tuple[str, dict[str, Any]]

ROOM = """(bind "leg" (lambda () (call "cube" :scale [.1 1 .1])))
(bind "chair"
  (lambda ()
    (union
      (for*/union ((x '(-.4 .4)) (z '(-.4 .4)))
        (transform (call "leg") (translate (vector x .5 z))))
      (transform (call "cube" :scale [1 .1 1]) (translate [0 1.05 0])))))
(bind "cup" (lambda () (call "cylinder" :radius .1 :p1 [0 .2 0] :color [1 0 0])))
(bind "room"
  (lambda ()
    (union (call "chair")
      (transform (call "chair") (translate [3 0 0]))
      (transform (call "cup") (translate [0 1.4 0])))))
"""


@dataclass(frozen=True)
class Agent:
    """What an agent can do; ``project`` is the server's folder."""

    session: ClientSession
    portal: BlockingPortal
    project: Path

    def call(self, tool: str, **arguments: Any) -> CallToolResult:
        return self.portal.call(self.session.call_tool, tool, arguments)

    def begin(self, tool: str, **arguments: Any) -> Future[CallToolResult]:
        """A call whose answer is not awaited."""
        return self.portal.start_task_soon(self.session.call_tool, tool, arguments)

    def told(self, tool: str, **arguments: Any) -> dict[str, Any]:
        """The data of an answer that is no error."""
        result = self.call(tool, **arguments)
        assert not result.is_error, text(result)
        assert result.structured_content is not None
        return result.structured_content

    def refused(self, tool: str, **arguments: Any) -> str:
        """The one line that a call which makes no sense is answered with."""
        result = self.call(tool, **arguments)
        said = text(result)
        assert result.is_error, said
        assert "\n" not in said
        assert "Traceback" not in said
        return said

    def at_once(self, *calls: Call) -> list[CallToolResult]:
        """The answers to calls that are made at the same time."""

        async def every() -> list[CallToolResult]:
            found: dict[int, CallToolResult] = {}

            async def one(number: int, tool: str, arguments: dict[str, Any]) -> None:
                found[number] = await self.session.call_tool(tool, arguments)

            async with create_task_group() as group:
                for number, (tool, arguments) in enumerate(calls):
                    group.start_soon(one, number, tool, arguments)
            return [found[number] for number in range(len(calls))]

        return self.portal.call(every)


def text(result: CallToolResult) -> str:
    (said,) = (content.text for content in result.content if content.type == "text")
    return said


@asynccontextmanager
async def _connected(folder: Path, *options: str) -> AsyncIterator[ClientSession]:
    command = ["-P", "-m", "scenelang", "mcp", "--project", str(folder), *options]
    with (folder.parent / "stderr.txt").open("a") as errors:
        parameters = stdio.StdioServerParameters(
            command=sys.executable,
            args=command,
            cwd=folder.parent,
            env=dict(os.environ),  # the client passes on little, not even PYTHONPATH
        )
        async with stdio.stdio_client(parameters, errlog=errors) as streams, mcp.ClientSession(*streams) as session:
            await session.initialize()
            yield session


@contextmanager
def served(folder: Path, *options: str) -> Iterator[Agent]:
    with start_blocking_portal() as portal, portal.wrap_async_context_manager(_connected(folder, *options)) as session:
        yield Agent(session, portal, folder)


@pytest.fixture(scope="module")
def agent(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Agent]:
    folder = tmp_path_factory.mktemp("agent") / "project"
    folder.mkdir()
    with served(folder) as agent:
        yield agent


@pytest.fixture
def serve(tmp_path: Path) -> Callable[..., Any]:
    """Starts a server with options of its own, in a folder ``project``."""
    folder = tmp_path / "project"
    folder.mkdir()
    return lambda *options: served(folder, *options)

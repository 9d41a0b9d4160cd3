"""The server: the table of tools, and how their answers become results of the protocol.

Every call that evaluates a program runs in a process of its own (``sandbox.worker``), one at a time; the server only
talks to the client, so it answers whatever a program does.
"""

from __future__ import annotations

import base64
import os
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Annotated, Any

import anyio
import anyio.to_thread
from mcp.server.mcpserver import Context, MCPServer
from mcp.server.mcpserver.exceptions import ToolError, UnexpectedToolError
from mcp.types import CallToolResult, ContentBlock, ImageContent, InputRequiredResult, TextContent, ToolAnnotations
from pydantic import Field, ValidationError

from scenelang.interpreter.runtime.limits import Limits
from scenelang.mcp import tools
from scenelang.mcp.tools import Project, ProjectProgram, ToolAnswer, WrongArguments, clipped, primer_text, refused
from scenelang.sandbox.supervision import Ended
from scenelang.sandbox.worker import Worker
from scenelang.scene_changes import TOLERANCE

PRIMER = "scenelang://primer"
_INSTRUCTIONS = (
    "Build 3D and 4D scenes as programs of the Scene Language. Call `help` first: without a name it gives the language "
    "on a few pages. Then write a program, `check` it, mend what is found, `run` it, `render` it from several sides "
    f"and look. `diff` tells what an edit changed. The resource {PRIMER} is the same overview."
)
_READS = ToolAnnotations(read_only_hint=True, destructive_hint=False, idempotent_hint=True, open_world_hint=False)
_LONGEST_ARGUMENT = 4_000  # characters, of all but programs
_PROGRAMS = ("program", "program_a", "program_b")

Result = Callable[..., Awaitable[CallToolResult]]  # (tool, its arguments after the project)
Text = Annotated[
    str, Field(description="the text of a program, or a model's Python; leave it out where a path is given")
]
File = Annotated[str, Field(description="a file in the project folder; leave it out where the text is given")]
Root = Annotated[str, Field(description="the word to evaluate; by default the one that no other word calls")]
Side = Annotated[int, Field(ge=1, le=tools.LARGEST, description="pixels")]
Number = Annotated[int, Field(ge=0, le=1_000_000, description="frame of a 4D scene, from 0")]
Part = Annotated[float, Field(gt=0, lt=1, description="differences up to this part of the scene's size do not count")]
CAMERA = (
    "where it is seen from: turntable, top, isometric, follow; azimuth=40,elevation=20,distance=5,fov=35,target=0:1:0 "
    "or some of these; or a camera's JSON file; what is left out frames the scene"
)


class SceneServer(MCPServer[Any]):
    """The server of one project folder. What a client gets to see of a failure is one line."""

    async def call_tool(
        self, name: str, arguments: dict[str, Any], context: Context[Any, Any] | None = None
    ) -> CallToolResult | InputRequiredResult:
        for key, value in arguments.items():
            if isinstance(value, str) and len(value) > _LONGEST_ARGUMENT and key not in _PROGRAMS:
                raise ToolError(f"`{clipped(key)}` is longer than {_LONGEST_ARGUMENT:,} characters")
        try:
            return await super().call_tool(name, arguments, context)
        except ToolError as error:
            raise ToolError(_line(error)) from None


def _line(error: ToolError) -> str:
    """A failure in one line: wrong arguments as they were told; a fault of ours without its traceback."""
    cause = error.__cause__
    if isinstance(cause, ValidationError):
        wrong = (f"`{'.'.join(map(str, each['loc']))}`: {each['msg']}" for each in cause.errors()[:5])
        return clipped("; ".join(wrong)).replace("\n", " ")
    if isinstance(error, UnexpectedToolError) and cause is not None:
        said = f"{type(cause).__name__}: {cause}"
        return clipped(f"internal error: {said} (please report it)").replace("\n", " ")
    return clipped(str(cause or error)).replace("\n", " ")


def work(tool: Callable[..., ToolAnswer], *arguments: Any) -> ToolAnswer:
    """What a worker's process does."""
    try:
        return tool(*arguments)
    except RecursionError:
        raise WrongArguments("the program is nested too deeply for this tool") from None


def serve(root: Path, limits: Limits, version: str) -> None:
    """Answer on standard input and output until it ends; ``root`` is the only folder that is read."""
    os.chdir(root)  # what programs import and what diagnostics name is relative to it
    _import_ahead()
    worker = Worker(work, (str(root),))
    build_server(Project(root, limits), version, worker).run("stdio")


def _import_ahead() -> None:
    """Modules and tables that every request needs are loaded once, before processes are forked for requests."""
    from scenelang.backends.base import every
    from scenelang.backends.pictures import film  # noqa: F401
    from scenelang.grammar import ast, reader
    from scenelang.stdlib.library import build_library

    reader.prepare()
    ast.prepare()
    build_library()
    every()


def build_server(project: Project, version: str, worker: Worker) -> SceneServer:
    """A server with all that it can do; ``worker`` runs ``work``."""
    server = SceneServer(
        "scenelang",
        title="The Scene Language",
        description="3D and 4D scenes as programs: checked, run, measured, drawn and compared",
        instructions=_INSTRUCTIONS,
        version=version,
        log_level="CRITICAL",
    )
    turns = anyio.Lock()

    async def result(tool: Callable[..., ToolAnswer], *arguments: Any) -> CallToolResult:
        async with turns:
            return await _asked(worker, tool, project, *arguments)

    _add_facts(server, result)
    _add_pictures(server, result)
    _add_help(server)
    return server


def _add_facts(server: SceneServer, result: Result) -> None:
    @server.tool(annotations=_READS)
    async def check(
        program: Text = "",
        path: File = "",
        geometry: Annotated[bool, Field(description="also evaluate, and look for odd overlaps and gaps")] = False,
    ) -> CallToolResult:
        """Find the mistakes of a program, with their places and how to mend them, without running it."""
        return await result(tools.check, ProjectProgram(program, path), geometry)

    @server.tool(annotations=_READS)
    async def run(program: Text = "", path: File = "", root: Root = "") -> CallToolResult:
        """Evaluate a program: root, entities, instances, primitives, bounding box, frames, what it printed."""
        return await result(tools.run, ProjectProgram(program, path, root))

    @server.tool(annotations=_READS)
    async def count(program: Text = "", path: File = "", root: Root = "", frame: Number = 0) -> CallToolResult:
        """Evaluate a program and count the instances of every word."""
        return await result(tools.count, ProjectProgram(program, path, root), frame)

    @server.tool(annotations=_READS)
    async def diff(
        program_a: Text = "",
        path_a: File = "",
        program_b: Text = "",
        path_b: File = "",
        tolerance: Part = TOLERANCE,
    ) -> CallToolResult:
        """Evaluate two programs, A and B: what moved, was recoloured, is missing or new in B."""
        a, b = ProjectProgram(program_a, path_a), ProjectProgram(program_b, path_b)
        return await result(tools.diff, a, b, tolerance)


def _add_pictures(server: SceneServer, result: Result) -> None:
    @server.tool(annotations=_READS)
    async def render(
        program: Text = "",
        path: File = "",
        root: Root = "",
        camera: Annotated[str, Field(description=CAMERA)] = "",
        frame: Number = 0,
        width: Side = tools.SIZE,
        height: Side = tools.SIZE,
    ) -> CallToolResult:
        """Evaluate a program and draw it: a draft picture (PNG)."""
        view = tools.ToolView(camera, frame, width, height)
        return await result(tools.render, ProjectProgram(program, path, root), view)


def _add_help(server: SceneServer) -> None:
    @server.tool(annotations=_READS)
    def help(
        name: Annotated[
            str, Field(description="a name, such as translate, union, cube, :color; a code, such as E401")
        ] = "",
    ) -> CallToolResult:
        """What a form, function, primitive or attribute of the language is, or how to mend a mistake by its code.
        Without a name: the language on a few pages."""
        try:
            return _result(tools.explain(name))
        except WrongArguments as error:
            raise ToolError(str(error)) from None

    @server.resource(PRIMER, title="The Scene Language on a few pages", mime_type="text/markdown")
    def overview() -> str:
        return primer_text()


async def _asked(worker: Worker, tool: Callable[..., ToolAnswer], *arguments: Any) -> CallToolResult:
    """The result of a tool that runs in a worker's process; a client that cancels the call ends it."""
    try:
        return _result(await _in_thread(worker, tool, *arguments))
    except Ended as error:
        return _result(refused([error.problem]))
    except WrongArguments as error:
        raise ToolError(str(error)) from None


async def _in_thread(worker: Worker, *arguments: Any) -> ToolAnswer:
    ask = lambda: worker.ask(*arguments)
    try:
        answer: ToolAnswer = await anyio.to_thread.run_sync(ask, abandon_on_cancel=True)
        return answer
    except anyio.get_cancelled_exc_class():
        worker.interrupt()
        raise


def _result(answer: ToolAnswer) -> CallToolResult:
    content: list[ContentBlock] = [TextContent(text=answer.text)]
    if answer.png is not None:
        content.insert(0, ImageContent(data=base64.b64encode(answer.png).decode("ascii"), mime_type="image/png"))
    return CallToolResult(content=content, structured_content=answer.data)

"""MCP server: registers the tools, and converts their answers to protocol results.

Every call that evaluates a program runs in a separate process (``sandbox.worker``), one at a time; the server process
itself only communicates, so no program can block or crash it.
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
    "Build 3D and 4D scenes as programs of the Scene Language. First call `help` without a name for a language "
    "overview. Then write a program, `check` it, fix the reported errors, `run` it, `render` it from several views "
    f"and inspect the images. `diff` shows the effect of an edit. The resource {PRIMER} contains the same overview."
)
_READS = ToolAnnotations(read_only_hint=True, destructive_hint=False, idempotent_hint=True, open_world_hint=False)
_MAX_ARGUMENT_LENGTH = 4_000  # characters, for arguments other than programs
_PROGRAMS = ("program", "program_a", "program_b")

Result = Callable[..., Awaitable[CallToolResult]]  # (tool, arguments after the project)
Text = Annotated[str, Field(description="text of a program, or a model's Python; omit if path is given")]
File = Annotated[str, Field(description="file in the project folder; omit if program is given")]
Root = Annotated[str, Field(description="word to evaluate; default: the word that no other word calls")]
Side = Annotated[int, Field(ge=1, le=tools.MAX_SIDE, description="pixels")]
Number = Annotated[int, Field(ge=0, le=1_000_000, description="frame of a 4D scene, counted from 0")]
Part = Annotated[float, Field(gt=0, lt=1, description="relative tolerance, as a fraction of the scene's size")]
CAMERA = (
    "viewpoint: preset (turntable, top, isometric, follow), parameters (azimuth=40,elevation=20,distance=5,fov=35,"
    "target=0:1:0), or a JSON file; omitted parameters are chosen to frame the scene"
)


class SceneServer(MCPServer[Any]):
    """Server of one project folder. Failures are reported to the client as one line."""

    async def call_tool(
        self, name: str, arguments: dict[str, Any], context: Context[Any, Any] | None = None
    ) -> CallToolResult | InputRequiredResult:
        for key, value in arguments.items():
            if isinstance(value, str) and len(value) > _MAX_ARGUMENT_LENGTH and key not in _PROGRAMS:
                raise ToolError(f"`{clipped(key)}` exceeds {_MAX_ARGUMENT_LENGTH:,} characters")
        try:
            return await super().call_tool(name, arguments, context)
        except ToolError as error:
            raise ToolError(_line(error)) from None


def _line(error: ToolError) -> str:
    """Format a failure as one line: invalid arguments by name; internal errors without traceback."""
    cause = error.__cause__
    if isinstance(cause, ValidationError):
        wrong = (f"`{'.'.join(map(str, each['loc']))}`: {each['msg']}" for each in cause.errors()[:5])
        return clipped("; ".join(wrong)).replace("\n", " ")
    if isinstance(error, UnexpectedToolError) and cause is not None:
        message = f"{type(cause).__name__}: {cause}"
        return clipped(f"internal error: {message} (please report it)").replace("\n", " ")
    return clipped(str(cause or error)).replace("\n", " ")


def work(tool: Callable[..., ToolAnswer], *arguments: Any) -> ToolAnswer:
    """Handle a request in a worker's process."""
    try:
        return tool(*arguments)
    except RecursionError:
        raise WrongArguments("the program is nested too deeply for this tool") from None


def serve(root: Path, limits: Limits, version: str, writes: bool = True) -> None:
    """Serve on standard input and output until it is closed; ``root`` is the only readable folder."""
    os.chdir(root)  # imports and file names in diagnostics are relative to it
    _import_ahead()
    worker = Worker(work, (str(root),))
    build_server(Project(root, limits), version, worker).run("stdio")


def _import_ahead() -> None:
    """Load modules and tables needed by every request, before worker processes are forked."""
    from scenelang.backends.base import all_backends
    from scenelang.backends.pictures import film  # noqa: F401
    from scenelang.stdlib.library import build_library

    build_library()
    all_backends()


def build_server(project: Project, version: str, worker: Worker) -> SceneServer:
    """Create the server with all tools and resources; ``worker`` runs ``work``."""
    server = SceneServer(
        "scenelang",
        title="The Scene Language",
        description="check, run, measure, render and compare programs of 3D and 4D scenes",
        instructions=_INSTRUCTIONS,
        version=version,
        log_level="CRITICAL",
    )
    turns = anyio.Lock()

    async def result(tool: Callable[..., ToolAnswer], *arguments: Any) -> CallToolResult:
        async with turns:
            return await _call_tool(worker, tool, project, *arguments)

    _add_facts(server, result)
    _add_pictures(server, result)
    _add_help(server)
    return server


def _add_facts(server: SceneServer, result: Result) -> None:
    @server.tool(annotations=_READS)
    async def check(
        program: Text = "",
        path: File = "",
        geometry: Annotated[bool, Field(description="also evaluate, and run the geometry lint")] = False,
        that: Annotated[
            list[str] | None,
            Field(description='also evaluate, and test declarations, such as (on "cup" "table") or (count "chair" 6)'),
        ] = None,
    ) -> CallToolResult:
        """Check a program without running it; returns diagnostics with positions and fixes."""
        return await result(tools.check, ProjectProgram(program, path), geometry, that or ())

    @server.tool(annotations=_READS)
    async def run(program: Text = "", path: File = "", root: Root = "") -> CallToolResult:
        """Evaluate a program; returns root, entities, instances, primitives, bounding box, frames and printed
        output."""
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
        """Evaluate two programs A and B, and list moved, recolored, removed and added primitives."""
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
        """Evaluate a program and render a draft image (PNG)."""
        view = tools.ToolView(camera, frame, width, height)
        return await result(tools.render, ProjectProgram(program, path, root), view)


def _add_help(server: SceneServer) -> None:
    @server.tool(annotations=_READS)
    def help(
        name: Annotated[
            str, Field(description="name, such as translate, union, cube, :color, or code, such as E401")
        ] = "",
    ) -> CallToolResult:
        """Describe a form, function, primitive or attribute of the language, or a diagnostic by its code.
        Without a name: an overview of the language."""
        try:
            return _result(tools.explain(name))
        except WrongArguments as error:
            raise ToolError(str(error)) from None

    @server.resource(PRIMER, title="Overview of the Scene Language", mime_type="text/markdown")
    def overview() -> str:
        return primer_text()


async def _call_tool(worker: Worker, tool: Callable[..., ToolAnswer], *arguments: Any) -> CallToolResult:
    """Run a tool in a worker's process; it is killed if the client cancels the call."""
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

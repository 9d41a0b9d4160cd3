"""MCP server: registers the tools, keeps the sessions, and converts answers to protocol results.

Every call that evaluates a program runs in a separate process (``sandbox.worker``), one at a time; the server process
itself only communicates, edits texts and saves them, so no program can block or crash it.
"""

from __future__ import annotations

import base64
import json
import os
import re
from collections.abc import Awaitable, Callable
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any, Literal

import anyio
import anyio.to_thread
from mcp.server.mcpserver import Context, MCPServer
from mcp.server.mcpserver.exceptions import ToolError, UnexpectedToolError
from mcp.server.stdio import stdio_server
from mcp.shared.message import SessionMessage
from mcp.types import (
    INVALID_REQUEST,
    PARSE_ERROR,
    CallToolResult,
    ContentBlock,
    ErrorData,
    ImageContent,
    InputRequiredResult,
    JSONRPCError,
    TextContent,
    ToolAnnotations,
)
from pydantic import Field, ValidationError

from scenelang.grammar.diagnostics import CODES, Diagnostic, SceneError, suggest, to_json
from scenelang.interpreter.values.limits import Limits
from scenelang.mcp import inspection, tools, workbench
from scenelang.mcp.session_acceptance import BriefCheck, accept, brief_check, checked_texts
from scenelang.mcp.session_files import NO_PROJECT, NO_WRITER, SessionFiles, session_files
from scenelang.mcp.tools import Project, ProjectProgram, ToolAnswer, WrongArguments, clipped, fitted, refused
from scenelang.mcp.workbench import TextSpan, Workbench, WorkingProgram
from scenelang.reference.searching import example_names, example_text, search
from scenelang.repairs.instance_edits import InstanceEdit
from scenelang.sandbox.supervision import Ended
from scenelang.sandbox.worker import Worker
from scenelang.session.scene_changes import TOLERANCE

PRIMER = "scenelang://primer"
EXAMPLES = "scenelang://examples"
_INSTRUCTIONS = (
    "Build 3D and 4D scenes as programs of the Scene Language. First call `help` without a name for an overview of the "
    "language, and `search` for what you need. `open` a session, `accept` what must hold, write with `edit`, "
    "`check`, fix, `run`, and look with `views`. `measure` and `query` give exact numbers; `repair` fixes what floats "
    "or overlaps; `undo` goes back. `save` and `export` write files. Paths such as chair/leg[2] name instances. "
    f"The resource {PRIMER} has the whole overview."
)
_READS = ToolAnnotations(read_only_hint=True, destructive_hint=False, idempotent_hint=True, open_world_hint=False)
_EDITS = ToolAnnotations(read_only_hint=False, destructive_hint=False, idempotent_hint=False, open_world_hint=False)
_WRITES = ToolAnnotations(read_only_hint=False, destructive_hint=True, idempotent_hint=True, open_world_hint=False)
_MAX_ARGUMENT_LENGTH = 4_000  # characters, of arguments other than programs
_PROGRAMS = ("program", "program_a", "program_b", "text", "old", "new")
_MAX_REPAIR_EFFORT = 60.0  # effort of a call

Result = Callable[..., Awaitable[CallToolResult]]  # (tool, arguments after the project)
Ask = Callable[..., Awaitable[Any]]
Text = Annotated[str, Field(description="text of a program, or a model's Python; omit if path or session is given")]
File = Annotated[str, Field(description="file in the project folder; omit if program or session is given")]
Name = Annotated[str, Field(description="session, as `open` names it")]
Root = Annotated[str, Field(description="word to evaluate; default: the word that no other word calls")]
Side = Annotated[int, Field(ge=1, le=tools.MAX_SIDE, description="pixels")]
Number = Annotated[int, Field(ge=0, le=1_000_000, description="frame of a 4D scene, counted from 0")]
Part = Annotated[float, Field(gt=0, lt=1, description="relative tolerance, as a fraction of the scene's size")]
ScenePath = Annotated[
    str, Field(description="path of instances: leg, chair/leg, chair[0]/leg[2], <z3>, * (numbers from 0)")
]
Place = Annotated[int, Field(ge=0, le=10_000_000, description="counted from 1, as in diagnostics; 0: not given")]
Offset = Annotated[
    int, Field(ge=-1, le=10_000_000, description="offset in characters from 0, instead of line and column")
]
Overwrite = Annotated[bool, Field(description="replace a file that exists")]
Declarations = Annotated[
    list[str] | None,
    Field(
        max_length=workbench.MAX_ACCEPTANCE, description='declarations, such as (on "cup" "table") or (count "chair" 6)'
    ),
]
CAMERA = (
    "viewpoint: preset (three-quarter, hero, catalogue, isometric, plan, elevation, front, right, back, left, top, "
    "bottom, turntable, follow), parameters (azimuth=40,elevation=20,distance=5,fov=35,target=0:1:0), position "
    "(eye=1:2:3,target=0:1:0), or a JSON file; omitted parameters are chosen to frame the scene"
)
View = Annotated[str, Field(description=CAMERA)]


class SceneServer(MCPServer[Any]):
    """Server of one project folder. Failures are reported to the client as one line with the code of a diagnostic."""

    async def run_stdio_async(self) -> None:
        """Serve on standard input and output, and answer messages that are no messages, too.

        The library tells its own log about them, so that the client would wait for an answer for ever.
        """
        server = self._lowlevel_server
        async with stdio_server() as (received, answers), anyio.create_task_group() as tasks:
            readable, messages = anyio.create_memory_object_stream[SessionMessage | Exception](0)
            tasks.start_soon(_pass_readable, received, readable, answers)
            await server.run(messages, answers, server.create_initialization_options())
            tasks.cancel_scope.cancel()

    async def call_tool(
        self, name: str, arguments: dict[str, Any], context: Context[Any, Any] | None = None
    ) -> CallToolResult | InputRequiredResult:
        for key, value in arguments.items():
            if isinstance(value, str) and len(value) > _MAX_ARGUMENT_LENGTH and key not in _PROGRAMS:
                return _failed(f"`{clipped(key)}` exceeds {_MAX_ARGUMENT_LENGTH:,} characters", "size")
        names = next(
            (list(tool.input_schema["properties"]) for tool in await self.list_tools() if tool.name == name), None
        )
        unknown = next((key for key in arguments if names is not None and key not in names), None)
        if unknown is not None:
            hint = suggest(unknown, names or ()) or f"its arguments are {', '.join(names or ('none',))}"
            return _failed(f"`{name}` has no argument `{clipped(unknown)}`; {hint}", "value")
        try:
            result = await super().call_tool(name, arguments, context)
        except ToolError as error:
            result = _failed(*_reason(error))
        return _encodable(result) if isinstance(result, CallToolResult) else result


def _encodable(result: CallToolResult) -> CallToolResult:
    """Return a result without lone surrogates, such as in file names that are not UTF-8: JSON cannot encode them."""
    texts = [block.text for block in result.content if isinstance(block, TextContent)]
    if not any(map(_HALF.search, [*texts, json.dumps(result.structured_content, ensure_ascii=False)])):
        return result
    data: Any = json.loads(
        _HALF.sub("\ufffd", json.dumps(result.model_dump(mode="python"), ensure_ascii=False, default=str))
    )
    return CallToolResult.model_validate(data)


_HALF = re.compile(r"[\ud800-\udfff]")


async def _pass_readable(received: Any, readable: Any, answers: Any) -> None:
    """Pass on messages, and answer what is none, such as text with half of a surrogate pair."""
    async with readable:
        async for message in received:
            if isinstance(message, Exception):
                await answers.send(SessionMessage(_unreadable(message)))
            else:
                await readable.send(message)


def _unreadable(error: Exception) -> JSONRPCError:
    """Return the answer to a message that cannot be read."""
    number, code, reason = None, PARSE_ERROR, str(error).partition("\n")[0]
    if isinstance(error, ValidationError):
        first = error.errors()[0]
        reason = str(first["msg"])
        with suppress(ValueError, TypeError, RecursionError):
            data = json.loads(str(first["input"]))
            number, code = data.get("id") if isinstance(data, dict) else None, INVALID_REQUEST
    number = number if isinstance(number, int | str) and not isinstance(number, bool) else None
    number = None if isinstance(number, str) and _HALF.search(number) else number
    return JSONRPCError(jsonrpc="2.0", id=number, error=ErrorData(code=code, message=clipped(reason)))


def _reason(error: ToolError) -> tuple[str, str]:
    """Return a failure as one line, and the name of its diagnostic: invalid arguments by name, no tracebacks."""
    cause = error.__cause__
    if isinstance(cause, ValidationError):
        problems = (f"`{'.'.join(map(str, problem['loc']))}`: {problem['msg']}" for problem in cause.errors()[:5])
        return "; ".join(problems), "value"
    if isinstance(cause, WrongArguments):
        return str(cause), cause.name
    if isinstance(cause, SceneError):
        return "; ".join(part for part in (cause.message, cause.hint) if part), cause.name
    if isinstance(error, UnexpectedToolError) and cause is not None:
        return f"internal error: {type(cause).__name__}: {cause} (please report it)", "crash"
    return str(cause or error), "value"


def _failed(message: str, name: str) -> CallToolResult:
    """Return the result of an invalid call: one line with its code, and the diagnostic as data."""
    line = clipped(message).replace("\n", " ")
    diagnostic = Diagnostic(name if name in CODES else "value", line)
    data = {key: value for key, value in to_json(diagnostic).items() if value not in (None, [], "")}
    text = f"error[{diagnostic.code}]: {line}"
    return CallToolResult(
        content=[TextContent(text=text)], structured_content={"ok": False, "diagnostics": [data]}, is_error=True
    )


def work(tool: Callable[..., Any], *arguments: Any) -> Any:
    """Handle a request in a worker's process."""
    try:
        return tool(*arguments)
    except RecursionError:
        raise WrongArguments("the program is nested too deeply for this tool", "nesting") from None


def serve(root: Path, limits: Limits, version: str, writes: bool = True, keeps: bool = False) -> None:
    """Serve on standard input and output until it is closed.

    ``root`` is the only folder that is read, and written with ``writes``. With ``keeps`` too, sessions are kept in it.
    """
    os.chdir(root)  # imports and file names in diagnostics are relative to it
    _import_ahead()
    worker = Worker(work, (str(root),))
    writer = Worker(work) if writes else None
    # After the workers are forked: a lock that they inherited would outlive this process.
    files = session_files(root) if writes and keeps else SessionFiles(root, NO_PROJECT if writes else NO_WRITER)
    build_server(Project(root, limits), version, files, worker, writer).run("stdio")


def _import_ahead() -> None:
    """Load modules and tables needed by every request, before worker processes are forked."""
    from scenelang.backends.base import all_backends
    from scenelang.backends.pictures import film  # noqa: F401
    from scenelang.stdlib.library import build_library

    build_library()
    all_backends()


def build_server(
    project: Project, version: str, files: SessionFiles, worker: Worker, writer: Worker | None = None
) -> SceneServer:
    """Create the server with all tools and resources; the workers run ``work``, ``files`` keep the sessions.

    ``worker`` cannot write files; without ``writer``, which exports, there are no tools that write.
    """
    server = SceneServer(
        "scenelang",
        title="The Scene Language",
        description="write, check, run, measure, render, repair and compare programs of 3D and 4D scenes",
        instructions=_INSTRUCTIONS,
        version=version,
        log_level="CRITICAL",
    )
    bench = Bench(project, files, worker, writer)
    _add_facts(server, bench)
    _add_pictures(server, bench)
    _add_help(server)
    _add_sessions(server, bench)
    _add_text_edits(server, bench)
    _add_object_edits(server, bench)
    _add_history(server, bench)
    _add_inspection(server, bench)
    if writer is not None:
        _add_files(server, bench)
    _add_resources(server, bench)
    _add_prompts(server)
    return server


class Bench:
    """Shared state of a server's tools: the project, the workers, of which one runs at a time, and the sessions."""

    def __init__(self, project: Project, files: SessionFiles, worker: Worker, writer: Worker | None) -> None:
        """Start with the sessions that an earlier server kept."""
        self.project = project
        self.files = files
        earlier = files.read()
        self.sessions = Workbench(earlier.drafts, earlier.number)
        self.notes = [*earlier.notes, *([files.problem] if files.problem else [])]
        self._worker, self._writer = worker, writer
        self._turns = anyio.Lock()

    async def ask(self, tool: Callable[..., Any], *arguments: Any, writes: bool = False) -> Any:
        """Run a tool in a worker's process and return its value, or an answer that says why it was killed.

        It is killed if the client cancels the call.
        """
        worker = self._writer if writes and self._writer is not None else self._worker
        async with self._turns:
            try:
                return await _in_thread(worker, tool, self.project, *arguments)
            except Ended as error:
                return refused([error.problem])

    async def result(self, tool: Callable[..., ToolAnswer], *arguments: Any, writes: bool = False) -> CallToolResult:
        return _result(await self.ask(tool, *arguments, writes=writes))

    def program(self, program: str, path: str, session: str, root: str = "") -> ProjectProgram:
        """Return the program of a call, given in one of three ways."""
        if not session:
            return ProjectProgram(program, path, root)
        if program or path:
            raise WrongArguments("expected one of `session`, `program` (text) and `path` (file of the project folder)")
        return self.sessions[session].program(root)

    async def changed(
        self, draft: WorkingProgram, lines: list[str], data: dict[str, Any] | None = None
    ) -> CallToolResult:
        """Keep a session that changed, and return the answer about it, with what a check finds."""
        is_open = draft.name in self.sessions.names()  # it may have been closed while a worker edited it
        unkept = self.files.keep(draft) if is_open else ""
        lines = [*lines, *([unkept] if unkept else [])]
        is_empty = not draft.text.strip() and not draft.acceptance
        checked = BriefCheck(0, ()) if is_empty else await self.ask(brief_check, draft.program(), draft.acceptance)
        if isinstance(checked, ToolAnswer):
            return _result(checked)
        finding_lines, _ = tools.diagnosed(checked.findings[:3])
        omitted = [f"... and {len(checked.findings) - 3} more findings"] if len(checked.findings) > 3 else []
        errors, warnings = checked.errors, len(checked.findings) - checked.errors
        counted = f"{errors} error{'s' * (errors != 1)}, {warnings} warning{'s' * (warnings != 1)}"
        state = {"ok": True, **draft.state(), "errors": errors, "warnings": warnings, **(data or {})}
        if checked.findings:
            state["findings"] = workbench.findings_data(checked.findings)
        told = [] if checked.acceptance is None else checked.acceptance.lines()
        if checked.acceptance is not None:
            state["acceptance"] = checked.acceptance.data()
        return _result(tools.answer([*lines, *told, f"check: {counted}", *finding_lines, *omitted], state))

    async def rewrite(self, draft: WorkingProgram, tool: Callable[..., ToolAnswer], *arguments: Any) -> CallToolResult:
        """Run a tool that returns a new program, put that into the session, and return the answer about it.

        Raises WrongArguments if another call has changed the session meanwhile.
        """
        base = draft.text
        rewritten = await self.ask(tool, draft.program(), *arguments)
        if rewritten.program is None:
            return _result(rewritten)
        if draft.text != base:
            raise WrongArguments(f"`{draft.name}` was changed while the program was edited; call again")
        draft.set(rewritten.program)
        return await self.changed(draft, rewritten.text.splitlines(), {**(rewritten.data or {}), **draft.state()})


# --- tools that inspect ----------------------------------------------------------------------------------------------


def _add_facts(server: SceneServer, bench: Bench) -> None:
    """Add the tools that check, evaluate, count and compare programs."""

    @server.tool(annotations=_READS)
    async def check(
        program: Text = "",
        path: File = "",
        session: Name = "",
        geometry: Annotated[bool, Field(description="also evaluate, and run the geometry lint")] = False,
        that: Declarations = None,
        physics: Annotated[bool, Field(description="also evaluate, and report what moves under gravity")] = False,
    ) -> CallToolResult:
        """Check a program without running it; returns diagnostics with positions and fixes. A session with acceptance
        is also evaluated and tested against that."""
        declared = (*(that or ()), *(bench.sessions[session].acceptance if session else ()))
        return await bench.result(tools.check, bench.program(program, path, session), geometry, declared, physics)

    @server.tool(annotations=_READS)
    async def run(program: Text = "", path: File = "", session: Name = "", root: Root = "") -> CallToolResult:
        """Evaluate a program; returns root, entities, instances, primitives, bounding box, frames and printed
        output."""
        return await bench.result(tools.run, bench.program(program, path, session, root))

    @server.tool(annotations=_READS)
    async def count(
        program: Text = "", path: File = "", session: Name = "", root: Root = "", frame: Number = 0
    ) -> CallToolResult:
        """Evaluate a program and count the instances of every word."""
        return await bench.result(tools.count, bench.program(program, path, session, root), frame)

    @server.tool(annotations=_READS)
    async def diff(
        program_a: Text = "",
        path_a: File = "",
        program_b: Text = "",
        path_b: File = "",
        session: Annotated[str, Field(description="session to take as B; A is its saved file unless given")] = "",
        tolerance: Part = TOLERANCE,
    ) -> CallToolResult:
        """Evaluate two programs A and B, and list moved, recolored, removed and added primitives. For a session, also
        the changed lines since it was saved."""
        if not session:
            a, b = ProjectProgram(program_a, path_a), ProjectProgram(program_b, path_b)
            return await bench.result(tools.diff, a, b, tolerance)
        draft = bench.sessions[session]
        if program_b or path_b:
            raise WrongArguments("with `session`, B is the session; give only A")
        if program_a or path_a:
            return await bench.result(tools.diff, ProjectProgram(program_a, path_a), draft.program(), tolerance)
        names = draft.path or "nothing", draft.name
        lines = await bench.ask(workbench.changed_lines, draft.saved or "", draft.file_text, names)
        if not draft.saved or not lines.text:
            return _result(ToolAnswer(lines.text or "nothing changed", {**lines.data, **draft.state()}))
        before = ProjectProgram(draft.saved, "", "", draft.path)
        changes = await bench.ask(tools.diff, before, draft.program(), tolerance)
        return _result(ToolAnswer(f"{lines.text}\n{changes.text}", {**(changes.data or {}), **draft.state()}))


def _add_pictures(server: SceneServer, bench: Bench) -> None:
    """Add the tools that render."""

    @server.tool(annotations=_READS)
    async def render(
        program: Text = "",
        path: File = "",
        session: Name = "",
        root: Root = "",
        camera: View = "",
        frame: Number = 0,
        width: Side = tools.SIZE,
        height: Side = tools.SIZE,
        part: ScenePath = "",
    ) -> CallToolResult:
        """Evaluate a program and render a draft image (PNG), of everything or of one part."""
        view = tools.ToolView(camera, frame, width, height, part)
        return await bench.result(tools.render, bench.program(program, path, session, root), view)

    @server.tool(annotations=_READS)
    async def views(
        session: Name,
        cameras: Annotated[list[str] | None, Field(max_length=inspection.MAX_CAMERAS, description=CAMERA)] = None,
        overlay: Annotated[
            Literal["none", "word", "instance", "depth"], Field(description="color by word or instance, or show depth")
        ] = "none",
        frame: Number = 0,
        part: ScenePath = "",
        side: Annotated[int, Field(ge=32, le=512, description="pixels of each picture")] = 384,
    ) -> CallToolResult:
        """Render a contact sheet (PNG) from several cameras; default: isometric, front, right and top."""
        view = inspection.SheetView(tuple(cameras or inspection.CAMERAS), overlay, frame, part, side)
        return await bench.result(inspection.views, bench.sessions[session].program(), view)

    @server.tool(annotations=_READS)
    async def strip(
        session: Name,
        count: Annotated[
            int, Field(ge=inspection.STRIP_FRAMES[0], le=inspection.STRIP_FRAMES[1], description="number of frames")
        ] = 5,
        frames: Annotated[
            list[Number] | None,
            Field(
                min_length=inspection.STRIP_FRAMES[0],
                max_length=inspection.STRIP_FRAMES[1],
                description="their numbers; default: evenly apart",
            ),
        ] = None,
        camera: View = "",
        part: ScenePath = "",
        side: Annotated[int, Field(ge=32, le=512, description="pixels of each picture")] = 256,
    ) -> CallToolResult:
        """Render 3 to 8 frames of a film side by side (PNG), with their numbers."""
        view = inspection.StripView(tuple(frames or ()), count, camera, part, side)
        return await bench.result(inspection.strip, bench.sessions[session].program(), view)

    @server.tool(annotations=_READS)
    async def compare(
        session: Name,
        reference: Annotated[str, Field(description="picture in the project folder: .png, .jpg or .webp")],
        camera: View = "",
        frame: Number = 0,
        score: Annotated[bool, Field(description="also the CLIP similarity, if installed; takes seconds")] = False,
    ) -> CallToolResult:
        """Render the scene (right) beside a reference picture (left), PNG."""
        program = bench.sessions[session].program()
        return await bench.result(inspection.compare, program, reference, camera, frame, score, writes=score)


def _add_help(server: SceneServer) -> None:
    """Add the tools that describe the language."""

    @server.tool(annotations=_READS)
    def help(
        name: Annotated[
            str, Field(description="name, such as translate, union, cube, :color, or code, such as E401")
        ] = "",
    ) -> CallToolResult:
        """Describe a form, function, primitive or attribute of the language, or a diagnostic by its code.
        Without a name: an overview of the language."""
        return _result(tools.explain(name))

    @server.tool(name="search", annotations=_READS)
    def find(
        query: Annotated[str, Field(min_length=1, max_length=500, description="such as: copies in a circle")],
        limit: Annotated[int, Field(ge=1, le=20, description="number of results")] = 6,
    ) -> CallToolResult:
        """Search forms, functions, combinators, primitives, attributes, relations, diagnostics and examples by
        meaning."""
        entries = search(query, limit)
        data = {"ok": True, "results": [[entry.kind, entry.name] for entry in entries]}
        return _result(tools.answer([entry.text() for entry in entries] or ["nothing was found"], data))


def _add_inspection(server: SceneServer, bench: Bench) -> None:
    """Add the tools that measure a session's scene."""

    @server.tool(annotations=_READS)
    async def query(session: Name, path: ScenePath = "*", frame: Number = 0) -> CallToolResult:
        """List the instances that a path means: their own paths, handles, places, boxes, attributes and lines."""
        return await bench.result(inspection.query, bench.sessions[session].program(), path, frame)

    @server.tool(annotations=_READS)
    async def measure(
        session: Name,
        a: ScenePath = "",
        b: ScenePath = "",
        that: Declarations = None,
        frame: Number = 0,
    ) -> CallToolResult:
        """Measure exactly. Nothing: the scene's box. `a`: boxes, volume, support, symmetry. `a` and `b`: distance or
        overlap, clearance, and which relations hold. `that`: declarations, with the move that would fix them."""
        program = bench.sessions[session].program()
        return await bench.result(inspection.measure, program, a, b, tuple(that or ()), frame)

    @server.tool(annotations=_READS)
    async def relations(
        session: Name,
        words: Annotated[list[str] | None, Field(max_length=50, description="words to compare; default: all")] = None,
        frame: Number = 0,
    ) -> CallToolResult:
        """List what is on, inside of, touching or overlapping what."""
        return await bench.result(inspection.related, bench.sessions[session].program(), tuple(words or ()), frame)


# --- tools that work -------------------------------------------------------------------------------------------------


def _add_sessions(server: SceneServer, bench: Bench) -> None:
    """Add the tools that open, read, list and close sessions."""

    @server.tool(name="open", annotations=_EDITS)
    async def open_session(program: Text = "", path: File = "") -> CallToolResult:
        """Open a session: a file of the project, a given text, or an empty program. Python is translated."""
        if not program and not path:
            draft = bench.sessions.open("")
            return await bench.changed(draft, [f"session {draft.name}, an empty program", *bench.notes])
        opened = await bench.ask(workbench.opened_text, ProjectProgram(program, path))
        if opened.program is None:
            return _result(opened)
        is_file = bool(path) and not opened.data["translated"]
        file_path = str(bench.project.file(path).relative_to(bench.project.root)) if is_file else ""
        draft = bench.sessions.open(opened.program, file_path, opened.program if is_file else None)
        count = workbench.line_count(draft.text)
        lines = [f"session {draft.name}, {count:,} lines", *bench.notes, *opened.text.splitlines()]
        return await bench.changed(draft, lines)

    @server.tool(annotations=_EDITS)
    async def transpile(program: Text = "", path: File = "") -> CallToolResult:
        """Translate a model's Python to a program of the language, and open it as a session. It is never executed."""
        opened = await bench.ask(workbench.opened_text, ProjectProgram(program, path))
        if opened.program is None:
            return _result(opened)
        draft = bench.sessions.open(opened.program)
        lines = [f"session {draft.name}", *bench.notes, *workbench.numbered(draft.text, 1, 60)]
        return await bench.changed(draft, lines)

    @server.tool(annotations=_READS)
    def read(session: Name, first: Place = 1, last: Place = 0) -> CallToolResult:
        """Show lines of a session with their numbers, at most 60 at a time."""
        draft = bench.sessions[session]
        count = workbench.line_count(draft.text)
        if first > max(count, 1):
            raise WrongArguments(f"line {first} does not exist; the program has {count:,}")
        lines = workbench.numbered(draft.text, first or 1, last or count)
        shown = max(first, 1) + len(lines) - 1
        more = [f"... and {count - shown:,} more lines; go on at line {shown + 1}"] if shown < (last or count) else []
        return _result(tools.answer([*lines, *more], {"ok": True, **draft.state(), "lines": count}))

    @server.tool(annotations=_READS)
    def sessions() -> CallToolResult:
        """List the open sessions, also those of an earlier server, their files and whether they are saved."""
        drafts = [bench.sessions[name] for name in bench.sessions.names()]
        rows = [
            f"{d.name}  {d.path or 'no file'}  {'unsaved' if d.state()['unsaved'] else 'saved'}"
            f"{f'  {len(d.acceptance)} declarations' if d.acceptance else ''}"
            for d in drafts
        ]
        data = {"ok": True, "sessions": [d.state() | {"path": d.path, "declared": len(d.acceptance)} for d in drafts]}
        return _result(tools.answer([*(rows or ["no session is open"]), *bench.notes], data))

    @server.tool(name="accept", annotations=_EDITS)
    async def accept_scene(
        session: Name,
        that: Annotated[
            list[str],
            Field(
                max_length=workbench.MAX_ACCEPTANCE,
                description='all declarations that the scene must fulfill, such as (count "chair" 6); none: no more',
            ),
        ],
    ) -> CallToolResult:
        """Set what a session's scene must fulfill: every later change is answered with how many hold and which fail.
        Refused if declarations contradict each other, or would also accept a wrong scene."""
        draft, declared = bench.sessions[session], checked_texts(that)
        verdict = await bench.ask(accept, draft.program(), declared)
        if not verdict.data["ok"]:
            return _result(verdict)
        draft.acceptance = declared
        return await bench.changed(draft, [verdict.text])

    @server.tool(annotations=_EDITS)
    def close(
        session: Name, discard: Annotated[bool, Field(description="close it although it is not saved")] = False
    ) -> CallToolResult:
        """Close a session."""
        draft = bench.sessions[session]
        if draft.state()["unsaved"] and not discard:
            raise WrongArguments(f"`{session}` is not saved; call `save`, or pass `discard`")
        bench.sessions.close(session)
        left = bench.files.remove(session)
        return _result(tools.answer([f"closed {session}", *([left] if left else [])], {"ok": True}))


def _add_text_edits(server: SceneServer, bench: Bench) -> None:
    """Add the tools that edit the text of a session."""

    @server.tool(annotations=_EDITS)
    async def edit(
        session: Name,
        text: Annotated[str, Field(description="new text of the span; empty: delete it")],
        line: Place = 0,
        column: Place = 1,
        end_line: Place = 0,
        end_column: Place = 0,
        start: Offset = -1,
        end: Offset = -1,
        old: Annotated[str | None, Field(description="text that must be there; its length is the default end")] = None,
    ) -> CallToolResult:
        """Replace a span of a session: line and column to the excluded end, as in diagnostics, or offsets. Without an
        end the text is inserted. Undoable."""
        draft = bench.sessions[session]
        span = TextSpan(line, column, end_line, end_column, start, end, old)
        changed, at = workbench.spliced(draft.text, span, text)
        draft.set(changed)
        return await bench.changed(draft, workbench.around(draft.text, at, len(text)))

    @server.tool(annotations=_EDITS)
    async def replace(
        session: Name,
        old: Annotated[str, Field(description="exact text; it must occur once, unless `every`")],
        new: Annotated[str, Field(description="text in its place")],
        every: Annotated[bool, Field(description="replace all occurrences")] = False,
    ) -> CallToolResult:
        """Search and replace in a session. Undoable."""
        draft = bench.sessions[session]
        changed, at, count = workbench.substituted(draft.text, old, new, every)
        draft.set(changed)
        return await bench.changed(draft, workbench.around(draft.text, at, len(new)), {"replaced": count})


def _add_object_edits(server: SceneServer, bench: Bench) -> None:
    """Add the tools that edit the program of a session by its objects: one of them, what is wrong, or all that fall."""

    @server.tool(annotations=_EDITS)
    async def edit_part(
        session: Name,
        path: ScenePath,
        move: Annotated[
            list[float] | None, Field(min_length=3, max_length=3, description="translation along the scene's axes")
        ] = None,
        attribute: Annotated[str, Field(description="attribute to set, such as color")] = "",
        value: Annotated[str, Field(description="its value, an expression, such as [1 0 0]")] = "",
        form: Annotated[str, Field(description='form in its place, such as (call "cone")')] = "",
        remove: Annotated[bool, Field(description="remove it")] = False,
        recolor: Annotated[
            str, Field(description="color of all its primitives, such as ivory, #ffcc00 or [1 0 0]")
        ] = "",
        scale: Annotated[
            float | list[float] | None,
            Field(description="factor, or three along x, y, z; its underside stays"),
        ] = None,
        rotate: Annotated[float | None, Field(description="degrees about its middle")] = None,
        axis: Annotated[Literal["x", "y", "z"], Field(description="axis of the scene for `rotate`")] = "y",
        shared: Annotated[bool, Field(description="also change others that share the number or form")] = False,
    ) -> CallToolResult:
        """Change the whole objects of a path: move, recolor, scale or rotate them, set an attribute, replace or remove
        them. Refused if anything else would change. Undoable."""
        draft = bench.sessions[session]
        change = InstanceEdit(
            path,
            None if move is None else _triple("move", move),
            (attribute, value) if attribute else None,
            form or None,
            remove,
            recolor or None,
            None if scale is None else _triple("scale", _factors(scale)),
            None if rotate is None else (axis, rotate),
            shared=shared,
        )
        return await bench.rewrite(draft, workbench.edit_part, change)

    @server.tool(annotations=_EDITS)
    async def repair(
        session: Name,
        that: Declarations = None,
        geometry: Annotated[bool, Field(description="also resolve overlaps and gaps")] = True,
        effort: Annotated[
            float, Field(gt=0, le=_MAX_REPAIR_EFFORT, description="search effort, about a second each")
        ] = 20.0,
    ) -> CallToolResult:
        """Edit numbers of a session so that failed declarations, also of its acceptance, and findings of the geometry
        are resolved; one line for each edit. Undoable."""
        draft = bench.sessions[session]
        declared = (*(that or ()), *draft.acceptance)
        return await bench.rewrite(draft, workbench.repair, declared, geometry, effort)

    @server.tool(annotations=_EDITS)
    async def settle(
        session: Name,
        seconds: Annotated[float, Field(gt=0, le=30, description="simulated seconds until it is taken to rest")] = 5.0,
    ) -> CallToolResult:
        """Let the scene come to rest under gravity, and put the new poses into the program; one line for each body.
        Undoable."""
        return await bench.rewrite(bench.sessions[session], workbench.settle, seconds)


def _add_history(server: SceneServer, bench: Bench) -> None:
    """Add the tools that go back and forth among the edits of a session."""

    @server.tool(annotations=_EDITS)
    async def undo(
        session: Name, steps: Annotated[int, Field(ge=1, le=200, description="number of edits")] = 1
    ) -> CallToolResult:
        """Undo edits of a session."""
        draft = bench.sessions[session]
        taken = draft.step(steps, back=True)
        return await bench.changed(
            draft, [f"undid {taken} of {steps}" if taken else "nothing to undo"], {"steps": taken}
        )

    @server.tool(annotations=_EDITS)
    async def redo(
        session: Name, steps: Annotated[int, Field(ge=1, le=200, description="number of edits")] = 1
    ) -> CallToolResult:
        """Redo edits that were undone."""
        draft = bench.sessions[session]
        taken = draft.step(steps, back=False)
        return await bench.changed(
            draft, [f"redid {taken} of {steps}" if taken else "nothing to redo"], {"steps": taken}
        )


def _factors(scale: float | list[float]) -> list[float]:
    """Return factors along the axes of a factor, or of a list of one or three."""
    factors = scale if isinstance(scale, list) else [scale]
    return factors * 3 if len(factors) == 1 else factors


def _triple(name: str, numbers: list[float]) -> tuple[float, float, float]:
    """Return three numbers of an argument."""
    if len(numbers) != 3:
        raise WrongArguments(f"`{name}`: expected three numbers, got {len(numbers)}")
    return numbers[0], numbers[1], numbers[2]


def _add_files(server: SceneServer, bench: Bench) -> None:
    """Add the tools that write files of the project."""

    @server.tool(annotations=_WRITES)
    def save(
        session: Name,
        path: Annotated[
            str, Field(description=".scene file in an existing folder of the project; default: its own")
        ] = "",
        overwrite: Overwrite = False,
    ) -> CallToolResult:
        """Write a session to a file of the project, atomically; the program states the acceptance at its end."""
        draft = bench.sessions[session]
        target = workbench.save(bench.project, draft, path, overwrite)
        size = target.stat().st_size
        data = {"ok": True, **draft.state(), "path": draft.path, "bytes": size}
        unkept = bench.files.keep(draft)
        return _result(tools.answer([f"saved {draft.path}, {size:,} bytes", *([unkept] if unkept else [])], data))

    @server.tool(annotations=_WRITES)
    async def export(
        session: Name,
        path: Annotated[str, Field(description="file in the project: .glb .usda .obj .stl .ply .json and others")],
        frame: Annotated[
            int | None, Field(ge=0, description="frame of a 4D scene; default: as the format has it")
        ] = None,
        overwrite: Overwrite = False,
    ) -> CallToolResult:
        """Export the scene of a session to another format, in the project folder."""
        program = bench.sessions[session].program()
        return await bench.result(workbench.export, program, path, frame, overwrite, writes=True)


# --- resources and prompts -------------------------------------------------------------------------------------------


def _add_resources(server: SceneServer, bench: Bench) -> None:
    """Add the primer, the examples and the sessions as resources."""

    @server.resource(PRIMER, title="Overview of the Scene Language", mime_type="text/markdown")
    def overview() -> str:
        return tools.primer_text()

    @server.resource(EXAMPLES, title="Names of example programs", mime_type="text/plain")
    def examples() -> str:
        return "\n".join(f"{EXAMPLES}/{name}" for name in example_names())

    @server.resource(EXAMPLES + "/{name}", title="Example program", mime_type="text/plain")
    def example(name: str) -> str:
        text = example_text(name)
        if text is None:
            raise ValueError(f"no example `{clipped(name[:40])}`")
        return text

    @server.resource("scenelang://sessions/{session}", title="Current program of a session", mime_type="text/plain")
    def current(session: str) -> str:
        try:
            return bench.sessions[session].text
        except WrongArguments as error:
            raise ValueError(str(error)) from None


def _add_prompts(server: SceneServer) -> None:
    """Add the prompts for common tasks."""

    @server.prompt(description="Build a scene from a description, step by step, with acceptance")
    def build(task: str) -> str:
        """Return the steps for building a scene, with the sections of the reference that fit the task."""
        return (
            f"Build this scene as a program of the Scene Language: {task[:_MAX_ARGUMENT_LENGTH]}\n"
            "1. Learn: call `help`, then `search` for the forms, combinators and relations that you need.\n"
            "2. Plan: list the parts, one word with a size each. `open` an empty session and call `accept` with "
            "what must hold: counts, a size in scene units, what is on, beside or inside what, directions; in a "
            "film what moves where. Correct what it refuses. Do not weaken the acceptance later to make a scene "
            "pass.\n"
            "3. Parts: write one word after the other with `edit`. After each, read what the check finds, fix "
            "it, and look at it alone with `render` and its `part`.\n"
            "4. Whole: write the word that places the parts. `accept` the same declarations again: now it also "
            "refuses those that say nothing about the scene.\n"
            "5. Check: `check` with `geometry`; `repair` or `edit_part` what fails, `settle` what should rest.\n"
            "6. Look: `views`, once with the overlay `word`, of a film `strip`. List what is wrong by the task "
            "alone, not by the program; `measure` what you are not sure of.\n"
            "7. Revise one fault at a time, and compare the answer with the one before. If a declaration fails "
            "that held, or `check` with `geometry` warns of more, call `undo` at once and try it another way; "
            "after two failures in a row leave that fault.\n"
            "8. Repeat 5 to 7 until nothing is wrong or nothing gets better, then `save`. Report what holds and "
            f"what does not.\n\n{tools.sections_for(task[:_MAX_ARGUMENT_LENGTH])}"
        ).strip()

    @server.prompt(description="Change a program of the project")
    def edit(path: str, instruction: str) -> str:
        return (
            f"Change `{path[:200]}`: {instruction[:_MAX_ARGUMENT_LENGTH]}\n"
            "`open` and `read` it, find the parts with `query`, and change as little as possible with `edit_part`, "
            "`replace` or `edit`. `diff` with the session must show only what was asked. `check` with `geometry`, look "
            "at `views`, then `save`."
        )

    @server.prompt(description="Report what a program shows and what is wrong with it")
    def inspect(path: str) -> str:
        return (
            f"Inspect `{path[:200]}` and change nothing. `open` it; `run`, `check` with `geometry` and `physics`, list "
            "`relations`, and look at `views` with the overlays `none` and `instance`. Report what is there, with "
            "counts and sizes, and every finding with its line and a fix."
        )

    @server.prompt(description="Reconstruct a scene from an image of the project")
    def reconstruct(image: str) -> str:
        return (
            f"Reconstruct `{image[:200]}` as a program of the Scene Language. `open` an empty session and `compare` it "
            "with the image early and often, from a camera that fits. First get the layout and the counts right, then "
            "proportions, then colors and materials. `check` with `geometry`, `repair`, and `save` the program."
        )


async def _in_thread(worker: Worker, *arguments: Any) -> Any:
    ask = lambda: worker.ask(*arguments)
    try:
        return await anyio.to_thread.run_sync(ask, abandon_on_cancel=True)
    except anyio.get_cancelled_exc_class():
        worker.interrupt()
        raise


def _result(answer: ToolAnswer) -> CallToolResult:
    """Return an answer as a protocol result, within the limit of size."""
    short = fitted(answer)
    content: list[ContentBlock] = [TextContent(text=short.text)]
    if short.png is not None:
        content.insert(0, ImageContent(data=base64.b64encode(short.png).decode("ascii"), mime_type="image/png"))
    return CallToolResult(content=content, structured_content=short.data)

"""Acceptance of a session: declarations that its scene is tested against after every change. Runs in a worker."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from scenelang.backends.geometry.acceptance import contradictions, undecided
from scenelang.backends.geometry.relations import reasons
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.mcp.tools import Project, ProjectProgram, ToolAnswer, WrongArguments, clipped, refused
from scenelang.mcp.workbench import MAX_DECLARATION_LENGTH
from scenelang.sandbox.supervision import limited
from scenelang.session.declarations import declaration_source

if TYPE_CHECKING:
    from scenelang.interpreter.scene.declarations import Declaration
    from scenelang.session.session import Session

_MAX_FAILURES = 3  # declarations that fail, which an answer shows
_MAX_LINE_LENGTH = 200  # characters
_HINT = "correct the declarations and call `accept` again; the session keeps those that it has"


@dataclass(frozen=True, slots=True)
class AcceptanceState:
    """How many declarations of a session there are and hold, and why the first ones fail.

    ``is_tested`` is False while the program makes no scene.
    """

    count: int
    held: int = 0
    failures: tuple[str, ...] = ()
    is_tested: bool = True

    def lines(self) -> list[str]:
        """Return the state as lines of an answer."""
        if not self.is_tested:
            return [f"acceptance: none of {self.count:,} can be tested, the program makes no scene"]
        left = self.count - self.held - len(self.failures)
        more = [f"... and {left:,} more fail"] if left else []
        return [f"acceptance: {self.held:,} of {self.count:,} hold", *(f"fails: {f}" for f in self.failures), *more]

    def data(self) -> dict[str, Any]:
        """Return the state as JSON data."""
        return {"declared": self.count, "hold": self.held, "tested": self.is_tested, "fails": list(self.failures)}


@dataclass(frozen=True, slots=True)
class BriefCheck:
    """Number of errors of a program, its findings, errors first, and the state of its acceptance if it has one."""

    errors: int
    findings: tuple[Diagnostic, ...]
    acceptance: AcceptanceState | None = None


def declarations_in_texts(session: Session, texts: Sequence[str]) -> list[Declaration]:
    """Return the declarations of texts such as ``(on "cup" "table")``; raises SceneError with the first mistake."""
    return [declaration for text in texts for declaration in session.declarations(declaration_source(text))]


def accept(project: Project, program: ProjectProgram, texts: Sequence[str]) -> ToolAnswer:
    """Test whether declarations can be the acceptance of a program.

    They are refused if they cannot be read or contradict each other, and if they say nothing about the scene that the
    program makes, if it makes one.
    """
    try:
        with limited(project.limits):
            session, source = project.opened(program)
            declarations = declarations_in_texts(session, texts)
            problems = contradictions(declarations)
            scene = session.evaluate(source).scene if source.text.strip() and not problems else None
            problems += undecided(scene, declarations) if scene is not None and declarations else []
    except SceneError as error:
        return refused([error.diagnostic])
    if problems:
        return refused([Diagnostic("value", problem, None, _HINT) for problem in problems])
    return ToolAnswer(f"accepted {len(declarations):,} declarations", {"ok": True, "declared": len(declarations)})


def checked_texts(texts: Sequence[str]) -> tuple[str, ...]:
    """Return declarations of a call; raises WrongArguments if one is too long."""
    for number, text in enumerate(texts):
        if len(text) > MAX_DECLARATION_LENGTH:
            raise WrongArguments(f"`that.{number}` exceeds {MAX_DECLARATION_LENGTH:,} characters", "size")
    return tuple(texts)


def brief_check(project: Project, program: ProjectProgram, texts: Sequence[str] = ()) -> BriefCheck:
    """Return what a check of a program finds; with declarations, also evaluate it and test them."""
    state: AcceptanceState | None = None
    try:
        with limited(project.limits):
            session, source = project.opened(program)
            diagnostics = list(session.check(source).diagnostics)
            if texts and not any(diagnostic.is_error for diagnostic in diagnostics):
                result = session.evaluate(source)
                known = {diagnostic.message for diagnostic in diagnostics}
                diagnostics += [each for each in result.diagnostics if each.message not in known]
                if result.scene is not None:
                    declarations = declarations_in_texts(session, texts)
                    state = _state(declarations, reasons(result.scene, declarations))
    except SceneError as error:
        diagnostics = [error.diagnostic]
    if texts and state is None:
        state = AcceptanceState(len(texts), is_tested=False)
    ordered = tuple(sorted(diagnostics, key=lambda diagnostic: not diagnostic.is_error))
    return BriefCheck(sum(diagnostic.is_error for diagnostic in ordered), ordered, state)


def _state(declarations: Sequence[Declaration], failed: Sequence[str | None]) -> AcceptanceState:
    """Return the state of declarations, with the reason of each that fails."""
    messages = [
        reason if str(declaration) in reason else f"{declaration}: {reason}"
        for declaration, reason in zip(declarations, failed, strict=True)
        if reason is not None
    ]
    shown = tuple(_line(message) for message in messages[:_MAX_FAILURES])
    return AcceptanceState(len(declarations), len(declarations) - len(messages), shown)


def _line(text: str) -> str:
    """Return a text as one line."""
    line = clipped(" ".join(text.split()))
    return line if len(line) <= _MAX_LINE_LENGTH else f"{line[: _MAX_LINE_LENGTH - 3]}..."

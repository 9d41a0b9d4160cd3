"""Front end for Blender scripts: check, run and translate them as programs; the service "blender" (``session``)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from scenelang.backends.blender.importing import converted
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.sandbox.supervision import limited
from scenelang.session.session import EXPANSION_DEPTH, Checked, Evaluated, Session, run_with_room


@dataclass(frozen=True, slots=True)
class ConvertedProgram:
    """Program converted from a script; ``text`` is empty if there are errors."""

    text: str
    diagnostics: tuple[Diagnostic, ...]

    @property
    def ok(self) -> bool:
        """Whether there are no errors."""
        return not any(d.is_error for d in self.diagnostics)


def check(session: Session, source: Source) -> Checked:
    """Convert a script and check the program; errors are returned as diagnostics and never raised."""
    program = _converted(source)
    if not program.ok:
        return Checked(None, program.diagnostics)
    checked = session.check_forms(_text_of(source, program.text))
    return replace(checked, diagnostics=(*program.diagnostics, *checked.diagnostics))


def evaluate(session: Session, source: Source) -> Evaluated:
    """Convert a script, then check and run the program."""
    checked = run_with_room(lambda: check(session, source), EXPANSION_DEPTH, folders=session.folders(source))
    return session.evaluate_checked(source, checked)


def transpile(session: Session, source: Source, literal: bool) -> ConvertedProgram:
    """Convert a script, or a response that contains one; ``literal`` changes nothing."""
    with limited(session.options.limits):
        return run_with_room(lambda: _converted(source), EXPANSION_DEPTH, folders=session.folders(source))


def lift(session: Session, source: Source) -> tuple[str | None, Sequence[Diagnostic]]:
    """Return that a script cannot be lifted."""
    hint = "`scenelang import` writes a program, which can be lifted"
    return None, (Diagnostic("unsupported", "only programs can be lifted, not Blender scripts", None, hint),)


def _text_of(source: Source, text: str) -> Source:
    return Source(f"{source.name}.scene", text)


def _converted(source: Source) -> ConvertedProgram:
    try:
        text, warnings = converted(source, Path(source.name).stem.strip("<>") or "scene")
    except SceneError as error:
        return ConvertedProgram("", (error.diagnostic,))
    except RecursionError:
        from scenelang.grammar.datum import Span

        return ConvertedProgram("", (Diagnostic("nesting", "the script is nested too deeply", Span(source, 0, 1)),))
    return ConvertedProgram(text, tuple(warnings))

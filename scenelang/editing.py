"""A program while somebody edits it: every version checked, only what changed looked at again."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from scenelang.grammar.diagnostics import Diagnostic
from scenelang.grammar.source import Source, Span
from scenelang.interpreter.evaluate import macro_runner
from scenelang.interpreter.incremental import Version, Versions
from scenelang.interpreter.prelude import prelude_of
from scenelang.sandbox.supervision import limited
from scenelang.sandbox.worker import trial
from scenelang.session import EXPANSION_DEPTH, IMPORT_FORM, MACRO_LIMITS, Session, run_with_room, settled

_MACRO_LIMITS = replace(MACRO_LIMITS, seconds=2.0, memory=1_000_000_000)  # somebody waits
_TRIAL_LIMITS = replace(_MACRO_LIMITS, seconds=4.0)  # with what is checked beside the macros
_PROCEDURAL = "define-macro"


@dataclass(frozen=True, slots=True, eq=False)
class Analysis:
    """A version of a text and what ``Session.check`` says of it. ``version`` is None when it is nested too deeply."""

    source: Source
    version: Version | None
    diagnostics: tuple[Diagnostic, ...]


class Editing:
    """One file that is open in an editor. ``texts`` holds what other open files say, by resolved path."""

    def __init__(self, session: Session, texts: dict[Path, str] | None = None) -> None:
        self.session = session
        self.texts = texts if texts is not None else {}
        self._versions = Versions(prelude_of(session.library))
        self._imported: tuple[str, ...] | None = None  # the texts of imported files, None when not known

    def check(self, source: Source) -> Analysis:
        """Analyse the next version; never raises for a mistake in the program. Macros that are procedures run in a copy
        of this process first, which can be ended."""
        problem = trial(lambda: self._try(source)) if self._may_run_macros(source) else None
        if problem is not None:
            return Analysis(source, None, (_in_source(problem, source),))
        try:
            return run_with_room(lambda: self._check(source), EXPANSION_DEPTH)
        except RecursionError:
            self._versions = Versions(prelude_of(self.session.library))
            problem = Diagnostic("nesting", "the program is nested too deeply", Span(source, 0, 1))
            return Analysis(source, None, (problem,))

    def _may_run_macros(self, source: Source) -> bool:
        """Whether the text, or a file that it imports, may define macros by procedures."""
        if _PROCEDURAL in source.text:
            return True
        if IMPORT_FORM.search(source.text) is None:
            return False
        return self._imported is None or any(_PROCEDURAL in text for text in self._imported)

    def _try(self, source: Source) -> None:
        with limited(_TRIAL_LIMITS):
            run_with_room(lambda: self._check(source), EXPANSION_DEPTH, folders=self.session.folders(source))

    def _check(self, source: Source) -> Analysis:
        runner = macro_runner(self.session.library, _MACRO_LIMITS)
        version = self._versions.analyse(source, self.session.importer(source, self.texts), runner)
        program = version.program
        found = [*program.diagnostics, *self.session.warnings(program)]
        sources = (source, *program.sources[1:])
        self._imported = tuple(each.text for each in program.sources[1:])
        return Analysis(source, version, settled((version.diagnostic(d) for d in found), sources))


def _in_source(problem: Diagnostic, source: Source) -> Diagnostic:
    """A problem of another process at its place in our text, or at the beginning of it."""
    span = problem.span
    if span is None or span.source.name != source.name:
        return replace(problem, span=Span(source, 0, 1), chain=())
    line, column = span.source.position(span.start)
    start = min(source.line_start(line) + column - 1, len(source.text))
    return replace(problem, span=Span(source, start, start + max(1, span.end - span.start)), chain=())

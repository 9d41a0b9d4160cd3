"""A program while somebody edits it: every version checked, only what changed looked at again."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from scenelang.grammar.diagnostics import Diagnostic
from scenelang.grammar.source import Source, Span
from scenelang.interpreter.evaluate import macro_runner
from scenelang.interpreter.incremental import Version, Versions
from scenelang.interpreter.prelude import prelude_of
from scenelang.session import EXPANSION_DEPTH, MACRO_LIMITS, Session, run_with_room, settled

_MACRO_LIMITS = replace(MACRO_LIMITS, seconds=2.0)  # somebody waits


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

    def check(self, source: Source) -> Analysis:
        """Analyse the next version; never raises for a mistake in the program."""
        try:
            return run_with_room(lambda: self._check(source), EXPANSION_DEPTH)
        except RecursionError:
            self._versions = Versions(prelude_of(self.session.library))
            problem = Diagnostic("nesting", "the program is nested too deeply", Span(source, 0, 1))
            return Analysis(source, None, (problem,))

    def _check(self, source: Source) -> Analysis:
        runner = macro_runner(self.session.library, _MACRO_LIMITS)
        version = self._versions.analyse(source, self.session.importer(source, self.texts), runner)
        program = version.program
        found = [*program.diagnostics, *self.session.warnings(program)]
        sources = (source, *program.sources[1:])
        return Analysis(source, version, settled((version.diagnostic(d) for d in found), sources))

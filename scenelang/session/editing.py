"""Incremental checking and evaluation of a file that is open in an editor.

Only the forms that an edit reaches are checked and evaluated again (``interpreter/evaluation/interactive``). Results
equal those of ``Session``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from scenelang.grammar.datum import Source, Span, dataclass, rare_collection, replace
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.interpreter.checker.lint import confirmed, without_suppressed
from scenelang.interpreter.checker.program import Program, prelude_of
from scenelang.interpreter.scene.setup import is_panorama
from scenelang.sandbox.supervision import limited, spent_seconds
from scenelang.session.session import (
    EXPANSION_DEPTH,
    IMPORT_FORM,
    MACRO_LIMITS,
    Evaluated,
    Session,
    is_python,
    is_scene_file,
    macro_runner,
    may_run,
    run_with_room,
    settled,
    value_datum,
)

if TYPE_CHECKING:
    from scenelang.interpreter.evaluation.evaluate import IncrementalRun
    from scenelang.interpreter.evaluation.interactive import Version, Versions
    from scenelang.interpreter.runtime.runtime import Runtime
    from scenelang.interpreter.scene.entity import Entity, Scene

T = TypeVar("T")

_MACRO_LIMITS = replace(MACRO_LIMITS, memory=1_000_000_000)
_TRIAL_LIMITS = replace(_MACRO_LIMITS, seconds=_MACRO_LIMITS.seconds + 2.0)  # two seconds for the rest of the check
_PROCEDURAL_MACRO = "define-macro"  # its expansion runs code of the program


@dataclass(frozen=True, slots=True, eq=False)
class VersionAnalysis:
    """Diagnostics of a version of a text. ``version`` is None if the program is nested too deeply to analyze."""

    source: Source
    version: Version | None
    diagnostics: tuple[Diagnostic, ...]


@dataclass(frozen=True, slots=True, eq=False)
class _LastRun:
    """Result of the last evaluation, which a version with the same forms has as well.

    Attributes
    ----------
    scene
        Its scene, None if it failed.
    conditions
        Word of the root, seed and most steps.
    call_sites
        Primitives with the places of their calls in the pieces of the text, which each version moves.
    """

    scene: Scene | None
    conditions: tuple[str, int, int | None]
    call_sites: Sequence[tuple[Entity, tuple[Span, ...]]]


class Editing:
    """Incremental checker of a file open in an editor.

    Parameters
    ----------
    session
        Session whose options apply.
    texts
        Unsaved texts of other open files, by resolved path.
    """

    def __init__(self, session: Session, texts: dict[Path, str] | None = None) -> None:
        self.session = session
        self.texts = texts if texts is not None else {}
        self._versions = self._no_versions()
        self.most_steps: int | None = None  # of a version, if fewer than those of the session's limits
        self._imported: tuple[str, ...] | None = None  # texts of imported files, None if unknown
        self._run: IncrementalRun | None = None
        self._name = ""
        self._kind_errors: Sequence[Diagnostic] | None = None  # of the last version
        self._evaluated: _LastRun | None = None
        self._reads_files = False  # whether a run has asked for a mesh, a font or an image, which may change

    def check(self, source: Source) -> VersionAnalysis:
        """Analyze the next version; errors are never raised.

        Procedural macros are first run in a forked process, which can be killed if they do not terminate: the thread of
        the editor cannot.
        """
        from scenelang.sandbox.worker import trial

        problem = trial(lambda: self._try(source)) if self._may_run_macros(source) else None
        if problem is not None:
            return VersionAnalysis(source, None, (_in_source(problem, source),))
        try:
            with rare_collection():
                return run_with_room(lambda: self._check(source), EXPANSION_DEPTH, folders=self.session.folders(source))
        except RecursionError:
            self._versions = self._no_versions()
            problem = Diagnostic("nesting", "the program is nested too deeply", Span(source, 0, 1))
            return VersionAnalysis(source, None, (problem,))

    def evaluate(self, source: Source) -> Evaluated:
        """Evaluate the next version with the result of ``Session.evaluate``, but only what the edit affects."""
        if is_scene_file(source) or is_python(source) or self.session.options.z_entries:
            return self.session.evaluate(source)
        with limited(self.session.options.limits):
            analysis = self.check(source)
            version = analysis.version
            if version is None or not (version.program.ok and may_run(version.program, analysis.diagnostics)):
                program = _placed_program(version) if version is not None else None
                return Evaluated(program, None, analysis.diagnostics)
            try:
                word, _ = self.session.root_of(version.program)
            except SceneError:
                return self.session.evaluate(source)
            return self._evaluate(version, word, analysis.diagnostics)

    def _evaluate(self, version: Version, word: str, checked: Sequence[Diagnostic]) -> Evaluated:
        """Evaluate a checked version, reusing the run of the version before it."""
        from scenelang.interpreter.evaluation.evaluate import IncrementalRun

        session, program, source = self.session, version.program, version.source
        if self._run is None or self._name != source.name:
            self._run, self._name = IncrementalRun(session.library, lambda: self._new_runtime(source)), source.name
        run, problem = self._run, None
        last, conditions = self._evaluated, (word, session.options.seed, self.most_steps)
        if last is None or last.conditions != conditions:
            run.most_steps = self.most_steps
            scene = None
            try:
                with rare_collection():
                    scene = run_with_room(
                        lambda: run.run(program, word, session.options.seed, version.place, spent_seconds()),
                        session.options.limits.depth,
                        lambda: run.rt.meter.cancel(),  # of the runtime that runs then: a run may create another
                        session.folders(source),
                    )
            except (SceneError, RecursionError, MemoryError) as error:
                problem = session.problem_of(error)
            last = _LastRun(scene, conditions, [(entity, entity.call_sites) for entity in run.rt.live_primitives])
            self._evaluated = last if scene is not None and self._is_of_text(scene, run) else None
        for entity, sites in last.call_sites:
            entity.call_sites = tuple(map(version.place, sites))
        rt, sources = run.rt, (source, *program.sources[1:])
        warnings = without_suppressed(map(version.diagnostic, rt.warnings.values()), sources)
        diagnostics = confirmed(checked, problem and version.diagnostic(problem), warnings)
        return Evaluated(_placed_program(version), last.scene, tuple(diagnostics), tuple(rt.log), rt.meter.total)

    def _new_runtime(self, source: Source) -> Runtime:
        """Return a runtime that notes whether the program reads files."""
        runtime = self.session.runtime_of(source)
        self._reads_files = False

        def noting(read: Callable[..., T] | None) -> Callable[..., T] | None:
            """Return a reader that notes its use."""
            if read is None:
                return None

            def noted(*values: Any) -> T:
                """Read a file."""
                self._reads_files = True
                return read(*values)

            return noted

        runtime.asset, runtime.font, runtime.image = noting(runtime.asset), noting(runtime.font), noting(runtime.image)
        return runtime

    def _is_of_text(self, scene: Scene, run: IncrementalRun) -> bool:
        """Return whether a scene depends on the forms of the text alone: on no places in it, and on no other files."""
        return not (run.reads_places or self._reads_files or any(is_panorama(item.name) for item in scene.setup))

    def _no_versions(self) -> Versions:
        """Return an empty history of versions."""
        from scenelang.interpreter.evaluation.interactive import Versions

        return Versions(prelude_of(self.session.library))

    def _may_run_macros(self, source: Source) -> bool:
        """Return whether the text or a file that it imports may define procedural macros."""
        if _PROCEDURAL_MACRO in source.text:
            return True
        if IMPORT_FORM.search(source.text) is None:
            return False
        return self._imported is None or any(_PROCEDURAL_MACRO in text for text in self._imported)

    def _try(self, source: Source) -> None:
        """Check a version within the limits of a trial."""
        with limited(_TRIAL_LIMITS):
            run_with_room(lambda: self._check(source), EXPANSION_DEPTH, folders=self.session.folders(source))

    def _check(self, source: Source) -> VersionAnalysis:
        """Analyze the next version on the current stack."""
        runner = macro_runner(self.session.library, _MACRO_LIMITS)
        overrides = {name: value_datum(name, text) for name, text in self.session.options.defines.items()}
        version = self._versions.analyze(source, self.session.importer(source, self.texts), runner, overrides)
        program = version.program
        if not version.is_moved:
            self._kind_errors, self._evaluated = None, None
        if self._kind_errors is None:
            self._kind_errors = self.session.kind_errors(program)
        diagnostics = [*program.diagnostics, *self.session.warnings(program, kind_errors=self._kind_errors)]
        sources = (source, *program.sources[1:])
        self._imported = tuple(imported.text for imported in program.sources[1:])
        return VersionAnalysis(source, version, settled((version.diagnostic(d) for d in diagnostics), sources))


def _placed_program(version: Version) -> Program:
    """Return the program of a version with spans in its current text; those of reused forms are older."""
    program = version.program
    return replace(
        program, main=version.source, sources=(version.source, *program.sources[1:]),
        words=_placed(version, program.words), all_words=_placed(version, program.all_words),
        params=tuple(replace(param, span=version.place(param.span)) for param in program.params),
    )  # fmt: skip


def _placed(version: Version, words: Mapping[str, Span]) -> dict[str, Span]:
    """Return the spans of words in the current text of a version."""
    return {word: version.place(span) for word, span in words.items()}


def _in_source(problem: Diagnostic, source: Source) -> Diagnostic:
    """Map a diagnostic from another process to its position in our text, or to the start of the text."""
    span = problem.span
    if span is None or span.source.name != source.name:
        return replace(problem, span=Span(source, 0, 1), chain=())
    line, column = span.source.position(span.start)
    start = min(source.line_start(line) + column - 1, len(source.text))
    return replace(problem, span=Span(source, start, start + max(1, span.end - span.start)), chain=())

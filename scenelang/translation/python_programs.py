"""Front end for a language model's Python: check, evaluate, transpile and lift.

If the checker or a run finds an error in a translated part, the transpiler's own interpreter of Python evaluates that
part, and the result takes its place. The functions are those of ``FrontEnd`` in ``session/session``, which finds this
module as the service "python".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

from scenelang.grammar.datum import Source, Span
from scenelang.grammar.diagnostics import CODES, Diagnostic
from scenelang.interpreter.checker.book import findings
from scenelang.interpreter.checker.lint import unread_attributes
from scenelang.interpreter.lift.lift import lift as lift_forms
from scenelang.interpreter.lift.lift import lift_text
from scenelang.interpreter.transpile.analysis.python_text import notebook_code as notebook_code
from scenelang.interpreter.transpile.translate import Translation, in_python, translate, with_evaluated_parts
from scenelang.interpreter.transpile.writing.code import Finish
from scenelang.sandbox.supervision import limited
from scenelang.session.session import (
    EXPANSION_DEPTH,
    Checked,
    Evaluated,
    Session,
    is_python,
    may_run,
    run_with_room,
    settled,
)

# Steps of the run that finds out whether a translated program works: enough for the corpus, a tenth of a second.
_TRIAL_STEPS = 200_000


def check(session: Session, source: Source) -> Checked:
    """Translate and check Python on the current stack; errors are returned as diagnostics and never raised."""
    return _translated(session, source, None, with_text=False)[1]


def evaluate(session: Session, source: Source) -> Evaluated:
    """Check and run Python; a part in which the run ends with an error is evaluated, and the program run again."""
    checked = session.check(source)
    result = session.evaluate_checked(source, checked)
    if result.scene is not None or result.program is None:
        return result
    problem = _mistake_of(result)
    if problem is None or not (checked.ok or may_run(result.program, checked.diagnostics)):
        return result
    return _evaluated_in_part(session, source, problem) or replace(
        result, diagnostics=tuple(in_python(d) if d.is_error else d for d in result.diagnostics)
    )


def transpile(session: Session, source: Source, literal: bool) -> Translation:
    """Translate a response, or its Python, and check the program; it is lifted unless ``literal`` is true."""
    names = session.library.names
    finish: Finish | None = None if literal else lambda forms, notes, texts: lift_forms(forms, notes, texts, names)

    def work() -> Translation:
        """Translate on a large stack."""
        translation, checked = _translated(session, source, finish, with_text=True)
        return translation.with_diagnostics(checked.diagnostics)

    try:
        with limited(session.options.limits):
            return run_with_room(work, EXPANSION_DEPTH, folders=session.folders(source))
    except RecursionError:
        problem = Diagnostic("nesting", "the Python is nested too deeply", Span(source, 0, 1))
        return Translation((), "", (problem,))


def lift(session: Session, source: Source) -> tuple[str | None, Sequence[Diagnostic]]:
    """Return the text of an equal program that is easier to read, or None, and the diagnostics of the program."""
    if is_python(source):
        hint = "`scenelang transpile` lifts what it translates"
        return None, (Diagnostic("unsupported", "only programs can be lifted, not Python", None, hint),)
    checked = session.check(source)
    if checked.ok and checked.program is None:
        return None, (Diagnostic("unsupported", "only programs can be lifted, not scenes in JSON", None),)
    return (lift_text(source, session.library.names) if checked.ok else None), checked.diagnostics


def _translated(
    session: Session, source: Source, finish: Finish | None, *, with_text: bool
) -> tuple[Translation, Checked]:
    """Translate Python and check the program.

    Parts in which the checker finds errors are evaluated if that leaves none. A program whose text is wanted and that
    changes data is run briefly as well, because the checker does not follow data.
    """
    translation = translate(source, with_text, finish)
    checked = _check(session, source, translation)
    made = _working(session, source, finish, translation, checked, with_text=with_text)
    return made or (translation, checked)


def _working(
    session: Session,
    source: Source,
    finish: Finish | None,
    translation: Translation,
    checked: Checked,
    *,
    with_text: bool,
) -> tuple[Translation, Checked] | None:
    """Return the first translation without errors: as it is, with its data evaluated, and with its functions."""
    while translation.ok:
        errors = [d for d in checked.diagnostics if d.is_error]
        if translation.way == "evaluated":
            return None if errors else (translation, checked)
        if not errors and with_text and (translation.changes_data or translation.way != "translated"):
            errors = _trial_error(session, source, checked)
        if not errors:
            return translation, checked
        other = with_evaluated_parts(source, translation, errors, with_text, finish)
        if other is translation:
            break
        translation, checked = other, _check(session, source, other)
    return None


def _check(session: Session, source: Source, translation: Translation) -> Checked:
    """Check a translated program, or the parts of it that could be translated."""
    if translation.ok:
        return session.check_forms(source, translation.forms, translation.diagnostics)
    findings_in_parts = _partial_findings(session, source, translation)
    return Checked(None, settled([*translation.diagnostics, *findings_in_parts], (source,)))


def _trial_error(session: Session, source: Source, checked: Checked) -> list[Diagnostic]:
    """Return the error that ends a short run of a translated program, at its place in the Python."""
    limits = replace(session.options.limits, steps=min(session.options.limits.steps, _TRIAL_STEPS))
    trial = Session(replace(session.options, limits=limits))
    problem = _mistake_of(trial.evaluate_checked(source, checked))
    place = _place_in(source, problem) if problem is not None else None
    return [replace(problem, span=place)] if problem is not None and place is not None else []


def _partial_findings(session: Session, source: Source, translation: Translation) -> list[Diagnostic]:
    """Return the mistakes in the parts of a program that were translated, though others were not."""
    program = session.load(source, translation.partial)
    known = [d.span for d in translation.diagnostics if d.is_error and d.span is not None]
    candidates = [*findings(program, None, is_written=False), *unread_attributes(program)]
    return [in_python(d) for d in candidates if d.span is not None and not any(map(d.span.overlaps, known))]


def _evaluated_in_part(session: Session, source: Source, problem: Diagnostic) -> Evaluated | None:
    """Evaluate a program again whose run has ended with an error, with the part evaluated in which the error is.

    Returns the scene, or the exception in Python's words; None if there is neither.
    """
    place = _place_in(source, problem)
    if place is None or session.options.seed:
        return None
    error = replace(problem, span=place)
    room = partial(run_with_room, depth=EXPANSION_DEPTH, folders=session.folders(source))
    translation = room(partial(translate, source, False))
    for _ in range(2):  # with its data evaluated, and with its functions
        translation = room(partial(with_evaluated_parts, source, translation, [error], False))
        exception = next((d for d in translation.diagnostics if d.name == "python-exception"), None)
        if exception is not None:
            if exception.span is not None and exception.span.overlaps(place):  # whose place is more exact
                exception = replace(in_python(problem), message=exception.message, hint=None)
            return Evaluated(None, None, (exception,))
        if not translation.ok:
            return None
        checked = room(partial(_check, session, source, translation))
        result = session.evaluate_checked(source, checked)
        if result.scene is not None:
            return result
    return None


def _mistake_of(result: Evaluated) -> Diagnostic | None:
    """Return the first error of a run, unless it is a limit."""
    problem = next((d for d in result.diagnostics if d.is_error), None)
    return problem if problem is not None and not CODES[problem.name].code.startswith("E5") else None


def _place_in(source: Source, problem: Diagnostic) -> Span | None:
    """Return where in a source an error is, or the innermost call in it that led there."""
    places = (problem.span, *(span for _, span in problem.chain))
    place = next((span for span in places if span is not None and span.source.name == source.name), None)
    return Span(source, place.start, place.end) if place is not None else None

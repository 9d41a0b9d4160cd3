"""Scenes built step by step: a plan with acceptance, parts, the whole, a critic, and revisions that make nothing worse.

Like ``steps``, it is a generator of requests, so that the conductor records, resumes and replays it. `generate` with
acceptance is its first half: the plan and one draft.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Generator, Sequence
from dataclasses import dataclass, replace

from scenelang.backends.language_models.catalogue import Message, Reply
from scenelang.grammar.datum import ListDatum, Source
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.grammar.reader import read
from scenelang.inference.brief import Brief, Notation, TaskKind, fenced
from scenelang.inference.steps import (
    EVALUATING,
    AnswerReader,
    Purpose,
    SampleOutcome,
    SamplePlan,
    SampleProgress,
    Speaker,
    Step,
    Steps,
    Verdict,
    close_ups,
    complete,
    criticized,
    facts_of,
    noticed,
    program_text,
    shown_answer,
    views,
    wants_nothing,
    with_repairs,
)
from scenelang.interpreter.scene.declarations import RELATIONS, Declaration
from scenelang.sandbox.worker import trial
from scenelang.session.declarations import declaration_source
from scenelang.session.session import Options, Session

_PART = re.compile(r"^\s*[-*]\s*[\"'`]?([a-z][a-z0-9_-]{0,60})[\"'`]?\s*:\s*(\S.*)$", re.M)
_MAX_PARTS = 16  # functions that are asked for one by one
_MAX_STATED = 60  # declarations of a plan
_MAX_PLAN = 50_000  # characters of an answer
_PLAN_ROUNDS = 2  # plans that are sent back because the first scene shows that they decide nothing
_MAX_REJECTED = 2  # revisions in a row that make the scene worse, after which the best one is kept
_MAX_DIFF = 1_500  # characters of a rejected revision that the model is shown
_LINES_AROUND = 1  # unchanged lines around those that a rejected revision changed


@dataclass(frozen=True, slots=True)
class ScenePlan:
    """Plan of a scene: its parts, each a word with a description, and the declarations that it must fulfill."""

    parts: tuple[tuple[str, str], ...]
    declarations: tuple[Declaration, ...]
    problems: tuple[str, ...] = ()


def plan_of(answer: str, options: Options) -> ScenePlan:
    """Read a plan from an answer; ``problems`` are what is wrong with its declarations.

    A declaration is an `assert-that` form with literal operands, or a relation; nothing else of the answer is
    evaluated.
    """
    from scenelang.backends.geometry.acceptance import contradictions

    if len(answer) > _MAX_PLAN:
        return ScenePlan((), (), (f"the plan exceeds {_MAX_PLAN:,} characters",))
    fence = answer.find("```")
    listed = answer if fence < 0 else answer[:fence]
    parts = tuple({match[1]: match[2].strip() for match in _PART.finditer(listed)}.items())[:_MAX_PARTS]
    source, problem = _stated(answer if fence < 0 else answer[fence:])
    if problem is not None:
        return ScenePlan(parts, (), (problem,))
    try:
        # In a forked process first, as answers are: expressions of options may not end.
        with EVALUATING:
            failure = trial(lambda: _declared(source, options))
            declarations = _declared(source, options) if failure is None else ()
        problems = (failure.message,) if failure is not None else ()
    except SceneError as error:
        return ScenePlan(parts, (), (f"{error.message}{f'; {error.hint}' if error.hint else ''}",))
    if len(declarations) > _MAX_STATED:
        problems = (f"{len(declarations)} statements, expected at most {_MAX_STATED}",)
    if not declarations and not problems:
        problems = ('there are no statements; write (assert-that (count "word" 1) ...)',)
    return ScenePlan(parts, declarations, (*problems, *contradictions(declarations)))


def _declared(source: Source, options: Options) -> tuple[Declaration, ...]:
    """Return the declarations of a source; raises SceneError with the first mistake."""
    return Session(options).declarations(source)


def _stated(answer: str) -> tuple[Source, str | None]:
    """Return the declarations of an answer as a source, and why it has other forms than these."""
    text = program_text(answer)
    source = Source("acceptance.scene", text)
    result = read(source)
    error = next((d for d in result.diagnostics if d.is_error), None)
    if error is not None:
        return source, error.message
    heads = [_head(form) for form in result.forms]
    if heads and all(head in {*RELATIONS, "not"} for head in heads):
        return Source(source.name, declaration_source(f"{text}\n").text), None
    others = [head for head in heads if head != "assert-that"]
    if others:
        return source, f"expected only `assert-that` forms, got `{others[0]}`"
    return source, None


def _head(form: object) -> str:
    """Return the name that a form begins with, empty for an atom."""
    first = form.items[0] if isinstance(form, ListDatum) and form.items else None
    return str(getattr(first, "value", ""))


# --- the plan --------------------------------------------------------------------------------------------------------

Planned = Generator[Step, Reply | None, ScenePlan]


def plan_steps(
    brief: Brief, options: Options, speaker: Speaker, repairs: int, problems: Sequence[str] = (), answer: str = ""
) -> Planned:
    """Ask for a plan until its declarations are sound; with ``problems``, for one in place of an answer's.

    Raises SceneError if the model states nothing that can be read.
    """
    system, turn = brief.planning
    plain = replace(speaker, grammar=None)
    turns: tuple[Message, ...] = (turn,)
    if problems:
        turns = (turn, *shown_answer(answer), brief.replanning(problems))
    plan = ScenePlan((), ())
    for _ in range(repairs + 1):
        reply, plain = yield from complete(plain, system, Purpose.PLAN, turns)
        plan = plan_of(reply.text, options)
        yield SampleProgress(_plan_verdict(plan), _plan_note(plan))
        if not plan.problems:
            return plan
        turns = (turn, *shown_answer(reply.text), brief.replanning(plan.problems))
    if plan.declarations:
        return plan
    raise SceneError("model-answer", f"no plan states what must hold: {plan.problems[0]}")


def _plan_verdict(plan: ScenePlan) -> Verdict:
    """Return a plan as a verdict, for the records."""
    text = "".join(f"(assert-that {declaration})\n" for declaration in plan.declarations)
    return Verdict(text, None, tuple(Diagnostic("model-answer", problem, None) for problem in plan.problems))


def _plan_note(plan: ScenePlan) -> str:
    if plan.problems:
        return f"plan: sent back, {plan.problems[0]}"
    return f"plan: {len(plan.parts)} parts, {len(plan.declarations)} statements"


def _with_plan(brief: Brief, reader: AnswerReader, plan: ScenePlan) -> tuple[Brief, AnswerReader]:
    """Return brief and reader whose scenes must fulfill a plan."""
    accepted = replace(brief, acceptance=plan.declarations)
    return accepted, replace(reader, brief=accepted)


def accepted_steps(brief: Brief, reader: AnswerReader, speaker: Speaker, plan: SamplePlan) -> Steps:
    """Generate one sample after its acceptance. Raises SceneError as ``sample_steps`` does."""
    stated = yield from plan_steps(brief, reader.options, speaker, plan.repairs)
    draft = yield from _draft(brief, reader, speaker, plan, stated, ())
    log, brief, reader = draft.log, draft.brief, draft.reader
    outcome = yield from criticized(brief, reader, speaker, plan, draft.verdict, draft.answer)
    return replace(outcome, acceptance=brief.acceptance, log=tuple(log))


# --- the draft -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Draft:
    """Scene with its answer, the plan it was tested against, the turns that asked for it, and what was done so far."""

    verdict: Verdict
    answer: str
    stated: ScenePlan
    brief: Brief
    reader: AnswerReader
    asked: tuple[Message, ...]
    log: tuple[str, ...]

    def noted(self, line: str) -> _Draft:
        """Return the draft with a line of its log."""
        return replace(self, log=(*self.log, line))

    def tested(self, stated: ScenePlan) -> _Draft:
        """Return the same answer, tested against another plan."""
        brief, reader = _with_plan(self.brief, self.reader, stated)
        return replace(self, verdict=reader.read(self.answer), stated=stated, brief=brief, reader=reader)


Drafted = Generator[Step, Reply | None, _Draft]


def _draft(
    brief: Brief,
    reader: AnswerReader,
    speaker: Speaker,
    plan: SamplePlan,
    stated: ScenePlan,
    turns: tuple[Message, ...],
) -> Drafted:
    """Ask for a scene, for a plan that decides, for repairs, and at last whether a statement that fails is right."""
    planned, testing = _with_plan(brief, reader, stated)
    asked, once = (planned.first, *turns), replace(plan, repairs=0)
    verdict, answer = yield from with_repairs(planned, testing, speaker, once, Purpose.DRAFT, asked)
    draft = _Draft(verdict, answer, stated, planned, testing, asked, (_plan_note(stated),))
    draft = yield from _decided(draft, brief, speaker, plan)
    draft = yield from _repaired(draft, speaker, plan)
    draft = yield from _reconsidered(draft, speaker, plan)
    return draft.noted(f"draft: {_summary(draft.verdict)}")


def _decided(draft: _Draft, brief: Brief, speaker: Speaker, plan: SamplePlan) -> Drafted:
    """Ask for another plan while the scene shows that the statements decide nothing; ``brief`` has no acceptance."""
    for _ in range(_PLAN_ROUNDS):
        problems = _undecided(draft.verdict, draft.reader)
        if not problems:
            return draft
        draft = draft.noted(f"plan: decides too little, {problems[0]}")
        options, written = draft.reader.options, _plan_text(draft.stated)
        try:
            stated = yield from plan_steps(brief, options, speaker, plan.repairs, problems, written)
        except SceneError as error:
            if error.name != "model-answer":
                raise
            break  # the statements there are, without those that say nothing, are better than none
        draft = draft.tested(stated)
        draft = replace(draft, asked=(draft.brief.first, *draft.asked[1:]))
        yield SampleProgress(draft.verdict, _plan_note(stated))
    empty = _silent(draft.verdict, draft.reader)
    if not empty:
        return draft
    kept = tuple(d for d in draft.stated.declarations if str(d) not in empty)
    if not kept:
        raise SceneError("model-answer", f"no plan states what must hold: {empty[0]} says nothing")
    draft = draft.tested(replace(draft.stated, declarations=kept))
    draft = draft.noted(f"plan: left out since they say nothing, {', '.join(empty)}")
    yield SampleProgress(draft.verdict, draft.log[-1])
    return draft


def _silent(verdict: Verdict, reader: AnswerReader) -> list[str]:
    """Return the declarations that say nothing about a scene, as they are written; empty without a complete scene."""
    from scenelang.backends.geometry.acceptance import silent_statements

    if verdict.scene is None:
        return []
    with EVALUATING:
        return silent_statements(verdict.scene, reader.acceptance(verdict.scene))


def _repaired(draft: _Draft, speaker: Speaker, plan: SamplePlan) -> Drafted:
    """Ask for repairs of a scene that has errors or does not fulfill its statements."""
    if draft.verdict.is_usable or not plan.repairs:
        return draft
    again = (*draft.asked, *shown_answer(draft.answer), draft.brief.repair(draft.verdict.report_text()))
    left = replace(plan, repairs=plan.repairs - 1)
    verdict, answer = yield from with_repairs(draft.brief, draft.reader, speaker, left, Purpose.REPAIR, again)
    return replace(draft, verdict=verdict, answer=answer)


def _reconsidered(draft: _Draft, speaker: Speaker, plan: SamplePlan) -> Drafted:
    """Ask once whether the statements that no repair fulfilled are what the task says.

    Of 20 builds with answers of a model three failed since it had stated a relation that means something else, such as
    balls to the right of the table on which they lie, and nothing could correct it. All other statements must stay.
    """
    failed = [d for d in draft.verdict.diagnostics if d.name == "declaration"]
    if not failed or not plan.repairs or len(failed) < sum(d.is_error for d in draft.verdict.diagnostics):
        return draft
    system, turn = draft.brief.planning
    turns = (turn, *shown_answer(_plan_text(draft.stated)), draft.brief.reconsidering([d.message for d in failed]))
    reply, _ = yield from complete(replace(speaker, grammar=None), system, Purpose.PLAN, turns)
    stated = plan_of(reply.text, draft.reader.options)
    if wants_nothing(reply.text) or stated.problems or not _keeps_others(draft.stated, stated, failed):
        yield SampleProgress(draft.verdict, "plan: the statements that fail are kept")
        return draft
    changed = draft.tested(stated).noted(f"plan: {len(failed)} statements that failed are corrected")
    if _undecided(changed.verdict, changed.reader):
        return draft
    yield SampleProgress(changed.verdict, _plan_note(stated))
    return changed


def _keeps_others(before: ScenePlan, after: ScenePlan, failed: Sequence[Diagnostic]) -> bool:
    """Return whether a plan has all statements of another one except those that failed."""
    wrong = {_statement(d) for d in failed}
    return {str(d) for d in before.declarations} - wrong <= {str(d) for d in after.declarations}


def _plan_text(plan: ScenePlan) -> str:
    """Return a plan as an answer would state it."""
    parts = "\n".join(f'- "{word}": {described}' for word, described in plan.parts)
    stated = "\n".join(f"  {declaration}" for declaration in plan.declarations)
    return f"{parts}\n\n```scene\n(assert-that\n{stated})\n```"


def _undecided(verdict: Verdict, reader: AnswerReader) -> list[str]:
    """Return why declarations do not decide whether a scene is right; empty without a scene that has all objects."""
    from scenelang.backends.geometry.acceptance import undecided

    if verdict.scene is None:
        return []
    with EVALUATING:
        return undecided(verdict.scene, reader.acceptance(verdict.scene))


# --- building --------------------------------------------------------------------------------------------------------


def build_steps(brief: Brief, reader: AnswerReader, speaker: Speaker, plan: SamplePlan) -> Steps:
    """Build one scene: plan, parts, whole, then revisions until the critic finds nothing or the budget is used up.

    A revision is kept only if no declaration fails that held and the geometry warns of no more; otherwise it is rolled
    back, and the model is told that it was tried. An error of the service after the first scene ends the building with
    the best one.
    """
    stated = yield from plan_steps(brief, reader.options, speaker, plan.repairs)
    written = yield from _parts(brief, reader, speaker, plan, stated)
    turns = (brief.whole(written),) if written else ()
    draft = yield from _draft(brief, replace(reader, prefix=written), speaker, plan, stated, turns)
    best, log, brief, reader = draft.verdict, list(draft.log), draft.brief, replace(draft.reader, base=None)
    tried: list[str] = []
    rejected = 0
    stopped: SceneError | None = None
    measured = True  # whether the next report is what is measured, as far as that shows faults
    for number in range(plan.revisions or 0):
        try:
            measured = measured and _has_faults(best)
            report = yield from _faults(brief, speaker, plan, best, measured=measured)
            if report is None or best.scene is None:
                break
            candidate = yield from _revised(brief, reader, speaker, plan, best, report, tried)
        except SceneError as error:
            stopped = error
            break
        if candidate.code == best.code:  # the model stands by it: what is measured may be meant, so the critic decides
            log.append(f"revision {number + 1}: unchanged")
            yield SampleProgress(best, log[-1])
            if not measured:
                break
            measured = False
            continue
        measured = True
        worse = why_worse(best, candidate)
        log.append(f"revision {number + 1}: {f'rolled back, {worse}' if worse else _summary(candidate)}")
        yield SampleProgress(best if worse else candidate, log[-1])
        if worse is None:
            best, rejected = candidate, 0
            continue
        tried.append(_attempted(best, candidate, worse))
        rejected += 1
        if rejected == _MAX_REJECTED:
            break
    return SampleOutcome(best, stopped, brief.acceptance, tuple(log))


def _parts(
    brief: Brief, reader: AnswerReader, speaker: Speaker, plan: SamplePlan, stated: ScenePlan
) -> Generator[Step, Reply | None, str]:
    """Ask for the function of each part; return those that work as one text, empty for fewer than two parts."""
    if len(stated.parts) < 2 or brief.task.notation is Notation.LIST:
        return ""
    written, words = "", list[str]()
    for word, described in stated.parts:
        turns = (brief.first, brief.part(word, described, words))
        root = word.replace("-", "_") if brief.task.notation is Notation.PYTHON else word
        still = replace(brief.task, kind=TaskKind.STILL) if brief.task.kind is TaskKind.FILM else brief.task
        alone = replace(
            reader, brief=replace(brief, task=still), options=replace(reader.options, root=root), prefix=written
        )
        verdict, _ = yield from with_repairs(brief, alone, speaker, plan, Purpose.PART, turns)
        if verdict.is_usable:
            written = verdict.code
            words.append(word)
    return written


def _has_faults(best: Verdict) -> bool:
    """Return whether measurement shows what has to be revised. Notes are no faults: what they say may be meant."""
    return best.scene is None or bool(best.diagnostics) or any(d.severity == "warning" for d in best.findings)


def _faults(
    brief: Brief, speaker: Speaker, plan: SamplePlan, best: Verdict, *, measured: bool
) -> Generator[Step, Reply | None, str | None]:
    """Return what is wrong with a scene: by measurement, else by a critic who sees only task, facts and images."""
    if measured or best.scene is None:
        errors = best.report_text() if best.diagnostics else ""
        return "\n\n".join(text for text in (errors, noticed(best)) if text)
    scene = best.scene
    system, turn = brief.critic(plan.shown(lambda: views(scene)), facts_of(best))
    reply, _ = yield from complete(replace(speaker, grammar=None), system, Purpose.CRITIC, (turn,))
    yield SampleProgress(best, "critic: nothing to change" if wants_nothing(reply.text) else "critic: faults")
    return None if wants_nothing(reply.text) else reply.text.strip()


def _revised(
    brief: Brief,
    reader: AnswerReader,
    speaker: Speaker,
    plan: SamplePlan,
    best: Verdict,
    report: str,
    tried: Sequence[str],
) -> Generator[Step, Reply | None, Verdict]:
    """Ask for a revision of a program, as a whole or in pieces."""
    scene, findings = best.scene, best.findings
    shown = plan.shown(lambda: close_ups(scene, findings)) if scene is not None and findings else []
    turns = (brief.first, brief.revision(best.code, report, facts_of(best), tried, shown))
    once = replace(plan, repairs=min(plan.repairs, 1))
    reader = replace(reader, base=best.code)
    verdict, _ = yield from with_repairs(brief, reader, speaker, once, Purpose.REVISE, turns, kept=best)
    return verdict


def why_worse(best: Verdict, candidate: Verdict) -> str | None:
    """Return why a scene is worse than another by what is measured, None if it is not."""
    if candidate.scene is None:
        return "it is no scene"
    errors = [d for d in candidate.diagnostics if d.is_error and d.name != "declaration"]
    if errors and not [d for d in best.diagnostics if d.is_error and d.name != "declaration"]:
        return errors[0].message
    known = {_statement(d) for d in best.diagnostics if d.name == "declaration"}
    broken = [d for d in candidate.diagnostics if d.name == "declaration" and _statement(d) not in known]
    if broken:
        return broken[0].message
    counts = [sum(d.severity == "warning" for d in verdict.findings) for verdict in (best, candidate)]
    if counts[1] > counts[0]:
        known_findings = {d.message for d in best.findings}
        return next((d.message for d in candidate.findings if d.message not in known_findings), "more warnings")
    return None


def _statement(failed: Diagnostic) -> str:
    """Return the declaration that a diagnostic says does not hold."""
    return failed.message.partition(" does not hold")[0]


def _attempted(best: Verdict, candidate: Verdict, worse: str) -> str:
    """Return a rolled-back revision as the model is shown it: what it changed, and why it was worse."""
    before, after = best.code.splitlines(), (candidate.code or candidate.program).splitlines()
    lines = list(difflib.unified_diff(before, after, lineterm="", n=_LINES_AROUND))[2:]
    return f"{fenced(chr(10).join(lines)[:_MAX_DIFF], Notation.LANGUAGE)}\n{worse}"


def _summary(verdict: Verdict) -> str:
    """Return how far a scene fulfills its acceptance, in one line."""
    if verdict.scene is None:
        return "no scene"
    failed = sum(d.name == "declaration" for d in verdict.diagnostics)
    others = sum(d.is_error for d in verdict.diagnostics) - failed
    warnings = sum(d.severity == "warning" for d in verdict.findings)
    counted = [(others, "error", ""), (failed, "statement", " not fulfilled"), (warnings, "warning", "")]
    parts = [f"{count} {noun}{'s' * (count > 1)}{rest}" for count, noun, rest in counted if count]
    return ", ".join(parts) or "all statements hold"

"""The loop of one sample as a conversation: a draft, repairs, critiques. Whoever drives it sends what it yields.

Written as generators, so that the same loop runs with single requests, with batches, and from a run's records.
"""

from __future__ import annotations

import re
from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum

from scenelang.backends.language_models.catalogue import Reply, Request, Stop, TextContent, Turn, said
from scenelang.grammar.diagnostics import Diagnostic, SceneError, render_text
from scenelang.inference.answers import AnswerReader, Verdict, contact_sheet, views
from scenelang.inference.brief import NO_CHANGES, Brief, Prompts, Task

_MOST_BROKEN = 2  # answers in a row that may break off before a sample is given up
_MOST_FINDINGS = 6


class Purpose(Enum):
    """Why something is asked."""

    DRAFT = "draft"
    REPAIR = "repair"
    CRITIQUE = "critique"
    JUDGE = "judge"


@dataclass(frozen=True, slots=True)
class Ask:
    """A question to send; its answer comes back into the generator."""

    purpose: Purpose
    request: Request


@dataclass(frozen=True, slots=True)
class SampleProgress:
    """What became of the last answer, for the records."""

    verdict: Verdict


@dataclass(frozen=True, slots=True)
class SampleOutcome:
    """The best that a sample came to, usable or not. ``stopped`` says what kept it from being improved further."""

    verdict: Verdict
    stopped: SceneError | None = None


Step = Ask | SampleProgress
Steps = Generator[Step, Reply | None, SampleOutcome]


@dataclass(frozen=True, slots=True)
class Speaker:
    """How requests are made: the model and its settings. ``most_tokens`` is as long as its answers can be."""

    model: str
    max_tokens: int
    most_tokens: int
    thinking: str | None = None
    effort: str | None = None
    grammar: str | None = None

    def request(self, system: str, turns: tuple[Turn, ...]) -> Request:
        fixed = TextContent(system, is_fixed=True)
        return Request(self.model, fixed, turns, self.max_tokens, self.thinking, self.effort, self.grammar)


@dataclass(frozen=True, slots=True)
class SamplePlan:
    """How often a sample is mended and improved."""

    repairs: int = 3
    critiques: int = 0


def sample_steps(brief: Brief, reader: AnswerReader, speaker: Speaker, plan: SamplePlan) -> Steps:
    """One sample. Raises SceneError, such as ``model-refusal`` and what is thrown in for a request that cannot be
    answered, where that leaves it without a program that works."""
    best, answer = yield from _mended(brief, reader, speaker, plan, Purpose.DRAFT, (brief.first,))
    for _ in range(plan.critiques):
        shown = views(best.scene) if best.is_usable and best.scene is not None else []
        if not shown:
            break
        turns = (brief.first, said("assistant", answer), brief.critique(shown, _noticed(best)))
        try:
            better, improved = yield from _mended(brief, reader, speaker, plan, Purpose.CRITIQUE, turns, best)
        except SceneError as error:
            return SampleOutcome(best, error)
        if better is best or not better.is_usable or len(better.findings) > len(best.findings):
            break
        best, answer = better, improved
    return SampleOutcome(best)


def _noticed(verdict: Verdict) -> str:
    return "\n\n".join(render_text(d, color=False) for d in verdict.findings[:_MOST_FINDINGS])


def _mended(
    brief: Brief,
    reader: AnswerReader,
    speaker: Speaker,
    plan: SamplePlan,
    purpose: Purpose,
    turns: tuple[Turn, ...],
    kept: Verdict | None = None,
) -> Generator[Step, Reply | None, tuple[Verdict, str]]:
    """Ask, then have what is wrong mended; the last verdict and its answer. ``kept`` is the verdict that stays where
    the model says that nothing needs to change."""
    asked = turns
    for repair in range(plan.repairs + 1):
        reply, speaker = yield from _complete(speaker, brief.system, purpose if repair == 0 else Purpose.REPAIR, asked)
        if reply.stop is Stop.CUT:
            verdict = Verdict("", None, (_cut(speaker),))
            yield SampleProgress(verdict)
            asked = (*turns, *_shown(reply.text), brief.cut(speaker.max_tokens))
            continue
        if kept is not None and repair == 0 and _wants_nothing(reply.text):
            yield SampleProgress(kept)
            return kept, reply.text
        verdict = reader.read(reply.text)
        yield SampleProgress(verdict)
        if verdict.is_usable:
            return verdict, reply.text
        asked = (*turns, *_shown(reply.text), brief.repair(verdict.told()))
    return verdict, reply.text


def _shown(answer: str) -> tuple[Turn, ...]:
    """An answer as a turn; services take no empty ones."""
    return (said("assistant", answer),) if answer.strip() else (said("assistant", "(no text)"),)


def _wants_nothing(answer: str) -> bool:
    return answer.strip().strip(".*`\"'").upper() == NO_CHANGES


def _complete(
    speaker: Speaker, system: str, purpose: Purpose, turns: tuple[Turn, ...]
) -> Generator[Step, Reply | None, tuple[Reply, Speaker]]:
    """An answer that is complete, or cut at the greatest length that the model has; and the speaker that got it. One
    that broke off is asked for anew, one that was cut is asked for with more room."""
    broken = 0
    while True:
        reply = yield Ask(purpose, speaker.request(system, turns))
        assert reply is not None
        if reply.stop is Stop.REFUSED:
            note = f": {' '.join(reply.note.split())}" if reply.note else ""
            raise SceneError("model-refusal", f"the model declines to answer{note}", "word the task differently")
        if reply.stop is Stop.FULL:
            raise SceneError("model-answer", "the model's context is full", "give fewer pictures or a smaller program")
        if reply.stop is Stop.BROKEN:
            broken += 1
            if broken > _MOST_BROKEN:
                why = f": {reply.note}" if reply.note else ""
                raise SceneError("model-answer", f"the answer broke off {broken} times{why}")
            continue
        if reply.stop is Stop.CUT and speaker.max_tokens < speaker.most_tokens:
            speaker = replace(speaker, max_tokens=min(speaker.most_tokens, 2 * speaker.max_tokens))
            continue
        return reply, speaker


def _cut(speaker: Speaker) -> Diagnostic:
    return Diagnostic("model-answer", f"the answer was cut off after {speaker.max_tokens:,} tokens", None)


# The best of several samples: no errors, then the fewest findings in its geometry, then the model's eye.


_MOST_JUDGED = 9
_ANSWER = re.compile(r"BEST:\s*#?(\d+)", re.I)


def candidates(outcomes: Mapping[int, SampleOutcome]) -> list[int]:
    """The samples that are equally good by what can be counted."""
    usable = {sample: outcome.verdict for sample, outcome in outcomes.items() if outcome.verdict.is_usable}
    if not usable:
        return []
    fewest = min(len(verdict.findings) for verdict in usable.values())
    return [sample for sample, verdict in usable.items() if len(verdict.findings) == fewest]


def judge_steps(prompts: Prompts, speaker: Speaker, task: Task, verdicts: Sequence[Verdict]) -> Steps:
    """Asks the model which scene fulfils a task best, as a sample of its own, with the task's pictures; the outcome has
    the verdict that it chose, the first where it names none."""
    judged = verdicts[:_MOST_JUDGED]
    scenes = [verdict.scene for verdict in judged if verdict.scene is not None]
    try:
        sheet = contact_sheet(scenes)
    except SceneError:
        return SampleOutcome(judged[0])  # what cannot be drawn cannot be judged
    wanted = f"Reconstruct the scene of the pictures before. {task.text}".strip() if task.pictures else task.text
    text = prompts.text("judge.md", count=str(len(scenes)), task=wanted)
    turn = Turn("user", (*task.pictures, sheet, TextContent(text)))
    request = replace(speaker, grammar=None).request(prompts.text("judge.system.md"), (turn,))
    reply = yield Ask(Purpose.JUDGE, request)
    match = _ANSWER.search(reply.text) if reply is not None else None
    number = int(match[1]) if match is not None and len(match[1]) < 4 else 1
    return SampleOutcome(judged[number - 1 if 1 <= number <= len(judged) else 0])

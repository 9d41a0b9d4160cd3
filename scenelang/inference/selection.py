"""The best of several samples: no errors, then the fewest findings in its geometry, then the model's eye."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

from scenelang.backends.language_models.conversation import Text, Turn
from scenelang.grammar.diagnostics import SceneError
from scenelang.inference.answers import Verdict
from scenelang.inference.prompts import Prompts
from scenelang.inference.steps import Ask, Outcome, Purpose, Speaker, Steps
from scenelang.inference.task import Task
from scenelang.inference.views import contact_sheet

_MOST_JUDGED = 9
_ANSWER = re.compile(r"BEST:\s*#?(\d+)", re.I)


def candidates(outcomes: Mapping[int, Outcome]) -> list[int]:
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
        return Outcome(judged[0])  # what cannot be drawn cannot be judged
    wanted = f"Reconstruct the scene of the pictures before. {task.text}".strip() if task.pictures else task.text
    text = prompts.text("judge.md", count=str(len(scenes)), task=wanted)
    turn = Turn("user", (*task.pictures, sheet, Text(text)))
    request = replace(speaker, grammar=None).request(prompts.text("judge.system.md"), (turn,))
    reply = yield Ask(Purpose.JUDGE, request)
    match = _ANSWER.search(reply.text) if reply is not None else None
    number = int(match[1]) if match is not None and len(match[1]) < 4 else 1
    return Outcome(judged[number - 1 if 1 <= number <= len(judged) else 0])

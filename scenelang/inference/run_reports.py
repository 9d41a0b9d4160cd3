"""Runs as people read them: a list of all, and every attempt of one."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from scenelang.grammar.diagnostics import SceneError
from scenelang.inference.records import Attempt, Run
from scenelang.reports import table

_LONGEST_TASK = 60


def list_of_runs(summaries: Iterable[Mapping[str, Any]]) -> str:
    """A table of what ``Run.summary`` says of each run."""
    rows = [
        (f["name"], f["command"], f["state"], str(f["attempts"]), f"${f['cost']:.4f}", _short(f["task"]))
        for f in summaries
    ]
    header = ("run", "command", "state", "attempts", "cost", "task")
    return table([header, *rows], (False, False, False, True, True, False))


def run_facts(run: Run) -> tuple[dict[str, Any], list[Attempt]]:
    """What a run says of itself, and its attempts; raises SceneError for one that is damaged."""
    facts = run.summary()
    if facts["state"] == "damaged":
        raise SceneError("run", f"the run {run.name} is damaged")
    return facts, list(run.attempts())


def run_report(run: Run, facts: Mapping[str, Any], attempts: Sequence[Attempt]) -> str:
    """A run and its attempts."""
    header = ("sample", "attempt", "why", "ended", "sent", "answered", "cost", "came to")
    rows = [header, *map(_attempt_row, attempts)]
    return "\n".join((
        f"{facts['name']}: {facts['command']}, {facts['state']}, ${facts['cost']:.4f}",
        _short(facts["task"]),
        str(run.path),
        table(rows, (True, True, False, False, True, True, True, False)),
    ))  # fmt: skip


def _short(text: str) -> str:
    return text if len(text) <= _LONGEST_TASK else text[: _LONGEST_TASK - 3] + "..."


def _attempt_row(attempt: Attempt) -> tuple[str, ...]:
    data = attempt.data()
    cost = "kept" if data["was_kept"] else f"${data['cost']:.4f}"
    sample = str(attempt.sample) if attempt.sample else "-"
    sent, answered = f"{data['tokens']['sent']:,}", f"{data['tokens']['answered']:,}"
    return sample, str(attempt.number), attempt.purpose, data["ended"], sent, answered, cost, _came_to(data)


def _came_to(data: Mapping[str, Any]) -> str:
    if data["usable"] is None:
        return ""
    if data["usable"]:
        return f"a scene, {data['findings']} findings" if data["findings"] else "a scene"
    return f"{data['errors']} error{'' if data['errors'] == 1 else 's'}"

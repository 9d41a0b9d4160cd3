"""The command runs: what language models were asked, what came of it and what it cost."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from scenelang.cli.options import add_output
from scenelang.cli.output import print_json, say, table
from scenelang.grammar.diagnostics import SceneError, printable

if TYPE_CHECKING:
    from scenelang.inference.records import Attempt, Run

_LONGEST_TASK = 60


def add_runs(subparsers: Any) -> None:
    parser = subparsers.add_parser(
        "runs",
        help="list the runs of generate and edit, or the attempts of one",
        description="List the runs of generate and edit, with how they ended and what they cost; of one run every "
        "attempt. `generate --resume RUN` and `edit --resume RUN` continue one.",
    )
    parser.add_argument("run_name", metavar="RUN", nargs="?", help="a run: its name, `last`, or its folder")
    parser.add_argument("--runs", metavar="DIR", help="where runs are kept (default: the user's state folder)")
    add_output(parser)
    parser.set_defaults(evaluates=False, run=runs)


def runs(arguments: argparse.Namespace) -> int:
    from scenelang.inference.records import all_runs, find_run, runs_folder

    folder = runs_folder(arguments.runs)
    if arguments.run_name is not None:
        _show_run(arguments, find_run(folder, arguments.run_name))
        return 0
    found = [_facts(run) or _damaged(run) for run in all_runs(folder)]
    if arguments.json:
        print_json(found)
        return 0
    if not found:
        say(f"there are no runs in {folder}")
        return 0
    rows = [(f["name"], f["command"], f["state"], str(f["attempts"]), f"${f['cost']:.4f}", f["task"]) for f in found]
    header = ("run", "command", "state", "attempts", "cost", "task")
    say(table([header, *rows], (False, False, False, True, True, False)))
    return 0


def _facts(run: Run) -> dict[str, Any] | None:
    """A run in a line; None for a folder that is damaged."""
    try:
        facts = run.facts
        task = facts["task"]["text"] or "a reconstruction"
        command, state = str(facts["command"]), run.state
    except (SceneError, KeyError, TypeError):
        return None
    attempts = list(run.attempts())
    shown = printable(" ".join(str(task).split()))
    return {
        "name": run.name,
        "path": str(run.path),
        "command": command,
        "state": state,
        "attempts": len(attempts),
        "cost": run.spent,
        "task": shown if len(shown) <= _LONGEST_TASK else shown[: _LONGEST_TASK - 3] + "...",
    }


def _damaged(run: Run) -> dict[str, Any]:
    nothing = {"command": "", "state": "damaged", "attempts": 0, "cost": 0.0, "task": ""}
    return {"name": run.name, "path": str(run.path), **nothing}


def _show_run(arguments: argparse.Namespace, run: Run) -> None:
    facts = _facts(run)
    if facts is None:
        raise SceneError("run", f"the run {run.name} is damaged")
    attempts = list(run.attempts())
    if arguments.json:
        print_json(facts | {"attempts": [_attempt_data(attempt) for attempt in attempts]})
        return
    say(f"{facts['name']}: {facts['command']}, {facts['state']}, ${facts['cost']:.4f}")
    say(f"{facts['task']}\n{run.path}")
    rows = [_attempt_row(attempt) for attempt in attempts]
    header = ("sample", "attempt", "why", "ended", "sent", "answered", "cost", "came to")
    say(table([header, *rows], (True, True, False, False, True, True, True, False)))


def _attempt_row(attempt: Attempt) -> tuple[str, ...]:
    data = _attempt_data(attempt)
    tokens = data["tokens"]
    cost = "kept" if data["was_kept"] else f"${data['cost']:.4f}"
    sample = str(attempt.sample) if attempt.sample else "-"
    sent, answered = f"{tokens['sent']:,}", f"{tokens['answered']:,}"
    return sample, str(attempt.number), attempt.purpose, data["ended"], sent, answered, cost, _came_to(data)


def _came_to(data: dict[str, Any]) -> str:
    if data["usable"] is None:
        return ""
    if data["usable"]:
        return f"a scene, {data['findings']} findings" if data["findings"] else "a scene"
    return f"{data['errors']} error{'' if data['errors'] == 1 else 's'}"


def _attempt_data(attempt: Attempt) -> dict[str, Any]:
    facts = attempt.facts
    usage = facts.get("usage", {})
    diagnostics = facts.get("diagnostics", [])
    return {
        "sample": attempt.sample,
        "number": attempt.number,
        "purpose": attempt.purpose,
        "ended": str(facts.get("stop", "")),
        "tokens": {
            "sent": sum(int(usage.get(name, 0)) for name in ("sent", "cache_read", "cache_written")),
            "answered": int(usage.get("answered", 0)),
        },
        "cost": attempt.cost,
        "was_kept": bool(facts.get("was_kept")),
        "usable": facts.get("usable"),
        "errors": sum(d.get("severity") == "error" for d in diagnostics),
        "findings": len(facts.get("findings", [])),
    }


COMMANDS = (add_runs,)

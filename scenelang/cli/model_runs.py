"""What commands that ask a language model do with a run: begin it, play it, note how it ends, say what it came to."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.cli.model_options import live_stream, with_limits
from scenelang.cli.options import UsageError, usage_errors
from scenelang.cli.output import print_json, report, say
from scenelang.cli.pictures import done
from scenelang.grammar.diagnostics import SceneError, to_json

if TYPE_CHECKING:
    from scenelang.inference.conductor import Inference, Result
    from scenelang.inference.records import Run

# What a run has once and for all.
_SETTLED = {
    "the task": "task", "FILE": "file", "--image": "image", "--animate": "animate", "--minecraft": "minecraft",
    "--dsl": "dsl", "--ablate": "ablate", "--model": "model", "--effort": "effort", "--price": "price",
    "--max-tokens": "max_tokens", "--prompt-dir": "prompt_dir", "--batch": "batch", "--no-cache": "no_cache",
    "--dry-run": "dry_run",
}  # fmt: skip


def show_dry_run(arguments: argparse.Namespace, inference: Inference) -> int:
    """Print the first request and what it costs at most; needs neither key nor network."""
    from scenelang.backends.language_models.openai_chat import upper_estimate
    from scenelang.backends.language_models.provider import unconnected
    from scenelang.inference.conductor import payload_text

    settings = inference.settings
    with usage_errors():
        provider = unconnected(settings.provider)
        model = settings.known_model(provider)
        speaker = settings.speaker(model, inference.task.notation)
    request = inference.first_request(speaker)
    payload = provider.payload(replace(request, grammar=None))
    tokens = upper_estimate(request)
    cost = settings.samples * model.highest_cost(tokens, request.max_tokens, settings.is_batch)
    if arguments.json:
        print_json({"address": provider.address, "request": payload, "tokens": tokens, "cost": cost})
        return 0
    say(payload_text(payload))
    if request.grammar is not None:
        say(f"\ngrammar: {len(request.grammar):,} characters, where the server takes one")
    say(f"\nto {provider.address}: at most {tokens:,} tokens and ${cost:.4f} before repairs and critiques")
    return 0


def begun(arguments: argparse.Namespace, inference: Inference, name: str, **facts: Any) -> Run:
    """A new run's folder. What the model or the provider cannot do is wrong usage, and is said before."""
    from scenelang.inference.records import new_run, runs_folder

    client = inference.settings.client()
    with usage_errors():
        inference.settings.speaker(client.model, inference.task.notation)
        if inference.settings.is_batch:
            client.batches()
    run = new_run(runs_folder(arguments.runs), name, client.clean)
    inference.begin(run, arguments.command, **facts)
    return run


def resumed(arguments: argparse.Namespace, command: str) -> tuple[Inference, Run]:
    """The run to continue, with new limits where options give some. Raises UsageError for one of another command."""
    from scenelang.inference.conductor import inference_of
    from scenelang.inference.records import find_run, runs_folder

    given = [option for option, name in _SETTLED.items() if getattr(arguments, name, None)]
    if given:
        raise UsageError("value", f"{given[0]} cannot be changed when a run goes on", "begin a new run for that")
    folder = runs_folder(arguments.runs)
    run = find_run(folder, arguments.resume)
    if run.path.resolve().parent != folder.resolve():
        hint = f"--runs {run.path.parent} says that you trust it"
        raise UsageError("run", f"{run.path} is not among your runs; it may overwrite files and spend money", hint)
    made_by = run.facts.get("command")
    if made_by == "repl":
        hint = f"what it came to is in {run.path / 'best.scene'}"
        raise UsageError("run", f"the run {run.name} was made in the REPL, which alone could go on with it", hint)
    if made_by != command:
        hint = f"scenelang {made_by} --resume {run.name}"
        raise UsageError("run", f"the run {run.name} was made by `{made_by}`", hint)
    inference = inference_of(run)
    return replace(inference, settings=with_limits(arguments, inference.settings)), run


def played(arguments: argparse.Namespace, inference: Inference, run: Run) -> tuple[Run, Result]:
    """Ask until the run is done; what its records hold is not asked again. Raises SceneError."""
    from scenelang.inference.records import Run

    client = inference.settings.client(run.spent)
    run = Run(run.path, client.clean)
    run.note(settings=inference.settings.data())
    result = inference.run(run, client, live_stream(arguments))
    run.keep_text("best.scene", result.best.program)
    run.note(state="done", sample=result.sample, cost=result.spent)
    return run, result


@contextmanager
def recorded(arguments: argparse.Namespace, run: Run) -> Iterator[None]:
    """Holds a run, and notes in its folder how it ends."""
    from scenelang.inference.conductor import NoProgram

    with run.claimed():
        try:
            run.note(state="running")
            yield
        except KeyboardInterrupt:
            run.note(state="interrupted")
            print(f"interrupted{_continuation(arguments, run)}", file=sys.stderr)
            raise
        except SceneError as error:
            run.note(state="failed", error=error.message)
            if isinstance(error, NoProgram) and not arguments.json:
                report(arguments, error.verdict.diagnostics)
            if not arguments.quiet and not arguments.json:
                print(f"the run is kept in {run.path}{_continuation(arguments, run)}", file=sys.stderr)
            raise


def _continuation(arguments: argparse.Namespace, run: Run) -> str:
    """How a run goes on; those of the REPL do not."""
    if arguments.command == "repl":
        return ""
    runs = f" --runs {arguments.runs}" if arguments.runs else ""
    return f"; to continue: scenelang {arguments.command} --resume {run.name}{runs}"


def report_result(arguments: argparse.Namespace, run: Run, result: Result) -> None:
    """Say what the run came to: warnings, errors of other samples, tokens and money."""
    if arguments.quiet or arguments.json:
        return
    report(arguments, [*result.best.diagnostics, *result.best.findings])
    for error in result.stopped:
        print(f"a sample ended early: {error.message}", file=sys.stderr)
    usage = result.usage
    print(
        f"sample {result.sample}; {usage.prompt:,} tokens sent, {usage.answered:,} answered, "
        f"${result.spent:.4f}; kept in {run.path}",
        file=sys.stderr,
    )  # fmt: skip


def say_written(arguments: argparse.Namespace, path: Path) -> None:
    """Say what was written; with ``--json`` standard output is one document."""
    if not arguments.json:
        done(arguments, path)


def result_data(run: Run, result: Result) -> dict[str, Any]:
    """What ``--json`` says of a run."""
    return {
        "run": str(run.path),
        "sample": result.sample,
        "program": result.best.program,
        "diagnostics": [to_json(d) for d in (*result.best.diagnostics, *result.best.findings)],
        "stopped": [error.message for error in result.stopped],
        "tokens": {"sent": result.usage.prompt, "answered": result.usage.answered},
        "cost": result.spent,
    }

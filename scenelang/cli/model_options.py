"""Options of the commands that ask a language model, and how they become settings."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TextIO

from scenelang.cli.options import UsageError, add_limits, add_output, limits_of, usage_errors, whole
from scenelang.cli.output import print_json, report
from scenelang.grammar.diagnostics import SceneError
from scenelang.session import Options

if TYPE_CHECKING:
    from scenelang.inference.describing import Describer
    from scenelang.inference.inference import Inference, Result
    from scenelang.inference.records import Run
    from scenelang.inference.settings import Settings
    from scenelang.inference.task import Ablation

_PROVIDER_HELP = "anthropic (default), or openai: any server of chat completions"
_PRICE_HELP = "dollars per million tokens, for a model whose price is not known"
_PROMPTS_HELP = "prompts that replace the package's, file by file"
_TOKENS_OF_WORDS = 8_000
_MOST_SAMPLES = 64
_MOST_ROUNDS = 20


def add_model_options(parser: argparse.ArgumentParser) -> None:
    """What every command that asks a model understands."""
    model = parser.add_argument_group("language model")
    model.add_argument(
        "--provider",
        default="anthropic",
        metavar="NAME",
        help=_PROVIDER_HELP,
    )
    model.add_argument("--model", metavar="NAME", help="the model (default: the provider's)")
    model.add_argument(
        "--effort", metavar="LEVEL", help="how much the model works: low, medium, high, xhigh, max, as it allows"
    )
    model.add_argument(
        "--max-tokens", type=whole, metavar="N", help="tokens of one answer (default 32,000, or what the model has)"
    )
    model.add_argument(
        "--max-cost", type=dollars, default=5.0, metavar="DOLLARS", help="what the run may cost (default 5)"
    )
    model.add_argument("--price", metavar="IN,OUT", help=_PRICE_HELP)
    model.add_argument("--prompt-dir", metavar="DIR", help=_PROMPTS_HELP)
    model.add_argument("--no-cache", action="store_true", help="ask anew what was asked before")
    loop = parser.add_argument_group("tries")
    loop.add_argument(
        "-n", "--samples", type=whole, default=1, metavar="N", help="samples, of which the best is taken (default 1)"
    )
    loop.add_argument(
        "--repair", type=whole, default=3, metavar="N", help="times that mistakes go back to the model (default 3)"
    )
    loop.add_argument(
        "--critique", type=whole, default=0, metavar="N", help="times that pictures go back to it (default 0)"
    )
    loop.add_argument("--jobs", type=whole, default=4, metavar="N", help="samples side by side (default 4)")
    loop.add_argument("--batch", action="store_true", help="by batches: half the price, within a day")
    loop.add_argument(
        "--ablate", choices=("P", "W", "PW"), help="without programs, words or both, as the paper's ablations"
    )
    runs = parser.add_argument_group("runs")
    runs.add_argument("--dry-run", action="store_true", help="print what would be sent, and send nothing")
    runs.add_argument(
        "--resume", metavar="RUN", help="continue a run that was interrupted: its name, `last` for the last one"
    )
    runs.add_argument("--runs", metavar="DIR", help="where runs are kept (default: the user's state folder)")
    evaluation = parser.add_argument_group("evaluation")
    evaluation.add_argument("--seed", type=int, default=0, metavar="N", help="seed of the random streams (default 0)")
    add_output(parser)
    add_limits(parser)


def add_spending(parser: argparse.ArgumentParser) -> None:
    """What a command that may ask a model on the side understands."""
    group = parser.add_argument_group("language model")
    group.add_argument("--provider", default="anthropic", metavar="NAME", help=_PROVIDER_HELP)
    group.add_argument("--max-cost", type=dollars, default=1.0, metavar="DOLLARS", help="what it may cost (default 1)")
    group.add_argument("--price", metavar="IN,OUT", help=_PRICE_HELP)
    group.add_argument("--prompt-dir", metavar="DIR", help=_PROMPTS_HELP)


def describer(arguments: argparse.Namespace) -> Describer:
    """What asks a model how things look, as a command's options say. Raises SceneError."""
    from scenelang.inference.describing import Describer
    from scenelang.inference.live_count import LiveCount
    from scenelang.inference.prompts import Prompts
    from scenelang.inference.settings import Settings
    from scenelang.inference.task import Notation

    settings = Settings(
        provider=arguments.provider,
        model=arguments.model or None,
        price=arguments.price,
        max_tokens=_TOKENS_OF_WORDS,
        max_cost=arguments.max_cost,
        prompt_dir=arguments.prompt_dir,
    )
    client = settings.client()
    speaker = settings.speaker(client.model, Notation.PYTHON)
    return Describer(client, Prompts(settings.prompts_folder), speaker, LiveCount(live_stream(arguments)))


def dollars(text: str) -> float:
    """A positive amount of money."""
    try:
        value = float(text.removeprefix("$"))
    except ValueError:
        value = 0.0
    if not 0 < value < 1e9:
        raise argparse.ArgumentTypeError(f"`{text}` is no amount of dollars")
    return value


def settings_from(arguments: argparse.Namespace) -> Settings:
    """The settings that a command's options give. Raises UsageError for those that make no sense."""
    from scenelang.backends.language_models.provider import family
    from scenelang.inference.settings import Settings

    _check_numbers(arguments)
    with usage_errors():
        family(arguments.provider)
    return Settings(
        arguments.provider,
        arguments.model,
        arguments.price,
        arguments.effort,
        arguments.max_tokens,
        arguments.max_cost,
        arguments.samples,
        arguments.repair,
        arguments.critique,
        arguments.jobs,
        arguments.batch,
        not arguments.no_cache,
        arguments.prompt_dir,
    )


def _check_numbers(arguments: argparse.Namespace) -> None:
    for name, value, low, high in (
        ("-n", arguments.samples, 1, _MOST_SAMPLES),
        ("--repair", arguments.repair, 0, _MOST_ROUNDS),
        ("--critique", arguments.critique, 0, _MOST_ROUNDS),
        ("--jobs", arguments.jobs, 1, _MOST_SAMPLES),
        ("--max-tokens", arguments.max_tokens or 1, 1, 10_000_000),
    ):
        if not low <= value <= high:
            raise UsageError("value", f"{name} may be {low:,} to {high:,}, not {value:,}")


def ablation_of(arguments: argparse.Namespace) -> Ablation:
    from scenelang.inference.task import Ablation

    return Ablation(arguments.ablate or "")


def evaluation_options(arguments: argparse.Namespace) -> Options:
    """How answers are evaluated."""
    return Options(seed=arguments.seed % (1 << 32), limits=limits_of(arguments))


def live_stream(arguments: argparse.Namespace) -> TextIO | None:
    """Where answers are counted as they arrive: a terminal, unless quiet."""
    return sys.stderr if sys.stderr.isatty() and not arguments.quiet and not arguments.json else None


# --- a run ---------------------------------------------------------------------------------------------------------


def show_dry_run(arguments: argparse.Namespace, inference: Inference) -> int:
    """Print the first request and what it costs at most; needs neither key nor network."""
    from dataclasses import replace

    from scenelang.backends.language_models.estimate import upper_estimate
    from scenelang.backends.language_models.provider import unconnected
    from scenelang.inference.dry_run import payload_text

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
    print(payload_text(payload))
    if request.grammar is not None:
        print(f"\ngrammar: {len(request.grammar):,} characters, where the server takes one")
    print(f"\nto {provider.address}: at most {tokens:,} tokens and ${cost:.4f} before repairs and critiques")
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


def resumed(arguments: argparse.Namespace, command: str) -> Run:
    """The run to continue. Raises UsageError for one of another command."""
    from scenelang.inference.records import find_run, runs_folder

    run = find_run(runs_folder(arguments.runs), arguments.resume)
    made_by = run.facts.get("command")
    if made_by != command:
        hint = f"scenelang {made_by} --resume {run.name}"
        raise UsageError("run", f"the run {run.name} was made by `{made_by}`", hint)
    return run


def played(arguments: argparse.Namespace, inference: Inference, run: Run) -> tuple[Run, Result]:
    """Ask until the run is done; what its records hold is not asked again. Raises SceneError."""
    from scenelang.inference.records import Run

    client = inference.settings.client(run.spent)
    run = Run(run.path, client.clean)
    result = inference.run(run, client, live_stream(arguments))
    run.keep_text("best.scene", result.best.program)
    run.note(state="done", sample=result.sample, cost=result.spent)
    return run, result


@contextmanager
def recorded(arguments: argparse.Namespace, run: Run) -> Iterator[None]:
    """Holds a run, and notes in its folder how it ends."""
    from scenelang.inference.inference import NoProgram

    with run.claimed():
        try:
            run.note(state="running")
            yield
        except KeyboardInterrupt:
            run.note(state="interrupted")
            print(f"interrupted; to continue: {_continuation(arguments, run)}", file=sys.stderr)
            raise
        except SceneError as error:
            run.note(state="failed", error=error.message)
            if isinstance(error, NoProgram) and not arguments.json:
                report(arguments, error.verdict.diagnostics)
            if not arguments.quiet and not arguments.json:
                print(f"the run is kept in {run.path}; to continue: {_continuation(arguments, run)}", file=sys.stderr)
            raise


def _continuation(arguments: argparse.Namespace, run: Run) -> str:
    runs = f" --runs {arguments.runs}" if arguments.runs else ""
    return f"scenelang {arguments.command} --resume {run.name}{runs}"


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


def result_data(run: Run, result: Result) -> dict[str, Any]:
    """What ``--json`` says of a run."""
    from scenelang.grammar.diagnostics import to_json

    return {
        "run": str(run.path),
        "sample": result.sample,
        "program": result.best.program,
        "diagnostics": [to_json(d) for d in (*result.best.diagnostics, *result.best.findings)],
        "stopped": [error.message for error in result.stopped],
        "tokens": {"sent": result.usage.prompt, "answered": result.usage.answered},
        "cost": result.spent,
    }

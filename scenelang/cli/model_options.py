"""Options of the commands that ask a language model, and how they become settings."""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TextIO

from scenelang.cli.options import UsageError, add_limits, add_output, limits_of, usage_errors, whole
from scenelang.session import Options

if TYPE_CHECKING:
    from scenelang.inference.brief import Ablation
    from scenelang.inference.conductor import Describer
    from scenelang.inference.records import InferenceSettings

_PROVIDER_HELP = "anthropic (default), or openai: any server of chat completions"
_PRICE_HELP = "dollars per million tokens, for a model whose price is not known"
_TIMEOUT_HELP = "seconds without a word from the service, at each of three tries (default 120)"
_PROMPTS_HELP = "prompts that replace the package's, file by file"
_TOKENS_OF_WORDS = 8_000


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
    model.add_argument("--max-cost", type=dollars, metavar="DOLLARS", help="what the run may cost (default 5)")
    model.add_argument("--price", metavar="IN,OUT", help=_PRICE_HELP)
    model.add_argument("--prompt-dir", metavar="DIR", help=_PROMPTS_HELP)
    model.add_argument("--timeout", type=_seconds, metavar="SECONDS", help=_TIMEOUT_HELP)
    model.add_argument("--no-cache", action="store_true", help="ask anew what was asked before")
    loop = parser.add_argument_group("tries")
    loop.add_argument(
        "-n", "--samples", type=whole, metavar="N", help="samples, of which the best is taken (default 1)"
    )
    loop.add_argument("--repair", type=whole, metavar="N", help="times that mistakes go back to the model (default 3)")
    loop.add_argument("--critique", type=whole, metavar="N", help="times that pictures go back to it (default 0)")
    loop.add_argument("--jobs", type=whole, metavar="N", help="samples side by side (default 4)")
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
    group.add_argument("--timeout", type=_seconds, metavar="SECONDS", help=_TIMEOUT_HELP)


def describer(arguments: argparse.Namespace) -> Describer:
    """What asks a model how things look, as a command's options say. Raises SceneError."""
    from scenelang.backends.language_models.catalogue import TIMEOUT
    from scenelang.inference.brief import Notation, Prompts
    from scenelang.inference.conductor import Describer, LiveCount
    from scenelang.inference.records import InferenceSettings

    settings = InferenceSettings(
        provider=arguments.provider,
        model=arguments.model or None,
        price=arguments.price,
        max_tokens=_TOKENS_OF_WORDS,
        max_cost=arguments.max_cost,
        prompt_dir=arguments.prompt_dir,
        timeout=arguments.timeout or TIMEOUT,
    )
    client = settings.client()
    speaker = settings.speaker(client.model, Notation.PYTHON)
    return Describer(client, Prompts(settings.prompts_folder), speaker, LiveCount(live_stream(arguments)))


def _seconds(text: str) -> float:
    """A time to wait."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.1 <= value <= 86_400:
        raise argparse.ArgumentTypeError(f"`{text}` is not a number of seconds between 0.1 and 86,400")
    return value


def dollars(text: str) -> float:
    """A positive amount of money."""
    try:
        value = float(text.removeprefix("$"))
    except ValueError:
        value = 0.0
    if not 0 < value < 1e9:
        raise argparse.ArgumentTypeError(f"`{text}` is no amount of dollars")
    return value


def settings_from(arguments: argparse.Namespace) -> InferenceSettings:
    """The settings that a command's options give. Raises UsageError for those that make no sense."""
    from scenelang.backends.language_models.catalogue import TIMEOUT
    from scenelang.backends.language_models.provider import family
    from scenelang.inference.records import InferenceSettings

    with usage_errors():
        family(arguments.provider)
    settings = InferenceSettings(
        provider=arguments.provider,
        model=arguments.model,
        price=arguments.price,
        effort=arguments.effort,
        max_tokens=arguments.max_tokens,
        is_batch=arguments.batch,
        uses_replies=not arguments.no_cache,
        prompt_dir=arguments.prompt_dir,
        timeout=arguments.timeout or TIMEOUT,
    )
    return with_limits(arguments, settings)


def with_limits(arguments: argparse.Namespace, settings: InferenceSettings) -> InferenceSettings:
    """Settings with those limits that a command's options give; a run that is continued may have new ones. Raises
    UsageError for those that make no sense."""
    _check_numbers(arguments)
    given: dict[str, Any] = {
        "max_cost": arguments.max_cost,
        "samples": arguments.samples,
        "repairs": arguments.repair,
        "critiques": arguments.critique,
        "side_by_side": arguments.jobs,
    }
    return replace(settings, **{name: value for name, value in given.items() if value is not None})


def _check_numbers(arguments: argparse.Namespace) -> None:
    from scenelang.inference.records import LIMITS

    for option, name, value in (
        ("-n", "samples", arguments.samples),
        ("--repair", "repairs", arguments.repair),
        ("--critique", "critiques", arguments.critique),
        ("--jobs", "side_by_side", arguments.jobs),
        ("--max-tokens", "max_tokens", arguments.max_tokens),
    ):
        low, high = LIMITS[name]
        if value is not None and not low <= value <= high:
            raise UsageError("value", f"{option} may be {low:,} to {high:,}, not {value:,}")


def ablation_of(arguments: argparse.Namespace) -> Ablation:
    from scenelang.inference.brief import Ablation

    return Ablation(arguments.ablate or "")


def evaluation_options(arguments: argparse.Namespace) -> Options:
    """How answers are evaluated."""
    return Options(seed=arguments.seed % (1 << 32), limits=limits_of(arguments))


def live_stream(arguments: argparse.Namespace) -> TextIO | None:
    """Where answers are counted as they arrive: a terminal, unless quiet."""
    return sys.stderr if sys.stderr.isatty() and not arguments.quiet and not arguments.json else None

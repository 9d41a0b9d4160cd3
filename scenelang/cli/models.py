"""Commands that ask language models: generate, edit, runs."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn, TextIO

from scenelang.cli.options import UsageError, add_limits, add_output, limits_of, usage_errors, whole
from scenelang.cli.output import check_folder, done, print_json, progress, report, report_run, say, table, use_color
from scenelang.grammar.diagnostics import SceneError, printable
from scenelang.session import Options

if TYPE_CHECKING:
    from scenelang.inference.brief import Task
    from scenelang.inference.conductor import Inference
    from scenelang.inference.generation import Edited, Generated
    from scenelang.inference.records import Attempt, InferenceSettings, Run
    from scenelang.repl.loop import ModelRequest

_LONGEST_TASK = 60
_PICTURE_SIZE = 768
_COLORS = {"+": "32", "-": "31", "@": "36"}
# What a run has once and for all.
_SETTLED = {
    "the task": "task", "FILE": "file", "--image": "image", "--animate": "animate", "--minecraft": "minecraft",
    "--dsl": "dsl", "--ablate": "ablate", "--model": "model", "--effort": "effort", "--price": "price",
    "--max-tokens": "max_tokens", "--prompt-dir": "prompt_dir", "--batch": "batch", "--no-cache": "no_cache",
    "--dry-run": "dry_run",
}  # fmt: skip


# --- options ---------------------------------------------------------------------------------------------------------


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


def _add_service(group: Any, cost: float | None, cost_help: str) -> None:
    group.add_argument(
        "--provider", default="anthropic", metavar="NAME",
        help="anthropic (default), openai: any server of chat completions, or a package's own",
    )  # fmt: skip
    group.add_argument("--max-cost", type=dollars, default=cost, metavar="DOLLARS", help=cost_help)
    group.add_argument(
        "--price", metavar="IN,OUT", help="dollars per million tokens, for a model whose price is not known"
    )
    group.add_argument("--prompt-dir", metavar="DIR", help="prompts that replace the package's, file by file")
    group.add_argument(
        "--timeout", type=_seconds, metavar="SECONDS",
        help="seconds without a word from the service, at each of three tries (default 120)",
    )  # fmt: skip


def add_model_options(parser: argparse.ArgumentParser) -> None:
    """What every command that asks a model understands."""
    model = parser.add_argument_group("language model")
    model.add_argument("--model", metavar="NAME", help="the model (default: the provider's)")
    model.add_argument(
        "--effort", metavar="LEVEL", help="how much the model works: low, medium, high, xhigh, max, as it allows"
    )
    model.add_argument(
        "--max-tokens", type=whole, metavar="N", help="tokens of one answer (default 32,000, or what the model has)"
    )
    _add_service(model, None, "what the run may cost (default 5)")
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
    _add_service(parser.add_argument_group("language model"), 1.0, "what it may cost (default 1)")


def service_of(arguments: argparse.Namespace) -> InferenceSettings:
    """The service that ``add_spending`` names, and the model."""
    from scenelang.backends.language_models.catalogue import TIMEOUT
    from scenelang.inference.records import InferenceSettings

    settings = InferenceSettings(
        provider=arguments.provider,
        model=arguments.model or None,
        price=arguments.price,
        prompt_dir=arguments.prompt_dir,
        timeout=arguments.timeout or TIMEOUT,
    )
    return settings if arguments.max_cost is None else replace(settings, max_cost=arguments.max_cost)


def settings_from(arguments: argparse.Namespace) -> InferenceSettings:
    """The settings that a command's options give. Raises UsageError for those that make no sense."""
    from scenelang.backends.language_models.provider import family

    with usage_errors():
        family(arguments.provider)
    settings = replace(
        service_of(arguments),
        effort=arguments.effort,
        max_tokens=arguments.max_tokens,
        is_batch=arguments.batch,
        uses_replies=not arguments.no_cache,
    )
    return _with_limits(arguments, settings)


def _with_limits(arguments: argparse.Namespace, settings: InferenceSettings) -> InferenceSettings:
    """Settings with those limits that options give; a run that is continued may have new ones. Raises UsageError."""
    from scenelang.inference.records import LIMITS

    given: dict[str, Any] = {}
    for option, name, value in (
        ("-n", "samples", arguments.samples),
        ("--repair", "repairs", arguments.repair),
        ("--critique", "critiques", arguments.critique),
        ("--jobs", "side_by_side", arguments.jobs),
        ("--max-tokens", "max_tokens", arguments.max_tokens),
        ("--max-cost", "max_cost", arguments.max_cost),
    ):
        low, high = LIMITS[name]
        if value is not None and not low <= value <= high:
            raise UsageError("value", f"{option} may be {low:,} to {high:,}, not {value:,}")
        if value is not None and name != "max_tokens":
            given[name] = value
    return replace(settings, **given)


def _options_of(arguments: argparse.Namespace) -> Options:
    """How answers are evaluated."""
    return Options(seed=arguments.seed % (1 << 32), limits=limits_of(arguments))


def live_stream(arguments: argparse.Namespace) -> TextIO | None:
    """Where answers are counted as they arrive: a terminal, unless quiet."""
    return sys.stderr if sys.stderr.isatty() and not arguments.quiet and not arguments.json else None


def _add_kind(parser: argparse.ArgumentParser) -> None:
    """What sort of scene is asked for, and in what notation."""
    parser.add_argument(
        "--image", action="append", default=[], metavar="FILE",
        help="a picture to reconstruct; may be given several times",
    )  # fmt: skip
    kind = parser.add_mutually_exclusive_group()
    kind.add_argument("--animate", action="store_true", help="a scene that moves")
    kind.add_argument("--minecraft", action="store_true", help="a build of Minecraft's blocks")
    parser.add_argument("--dsl", action="store_true", help="ask for the language itself in place of Python")


def _task_of(arguments: argparse.Namespace) -> Task:
    from scenelang.inference.brief import Ablation, Notation, TaskKind
    from scenelang.inference.generation import task_of

    kind = TaskKind.FILM if arguments.animate else TaskKind.BLOCKS if arguments.minecraft else TaskKind.STILL
    notation = Notation.LANGUAGE if arguments.dsl else Notation.PYTHON
    ablation = Ablation(arguments.ablate or "")
    return task_of(arguments.task or "", arguments.image, kind, notation, ablation, arguments.seed)


class _LineParser(argparse.ArgumentParser):
    """Says what is wrong with options as every other mistake is said."""

    def error(self, message: str) -> NoReturn:
        raise SceneError("value", message, f"`,help {self.prog}` says how it is used")


def model_request(command: str, line: str) -> ModelRequest:
    """The options of a REPL command, which are those of the command line, and the text behind them."""
    from scenelang.inference.brief import Ablation
    from scenelang.repl.loop import ModelRequest

    parser = _LineParser(prog=command, add_help=False, allow_abbrev=False)
    if command == "generate":
        _add_kind(parser)
    add_model_options(parser)
    parser.add_argument("text", nargs="*")
    try:
        words = shlex.split(line)
    except ValueError:  # an apostrophe
        words = line.split()
    arguments = parser.parse_args(words)
    arguments.task = " ".join(arguments.text)
    for name in ("resume", "dry_run", "json"):
        if getattr(arguments, name):
            raise SceneError("value", f"`--{name.replace('_', '-')}` is for the command line")
    task = _task_of(arguments) if command == "generate" and arguments.task else None
    return ModelRequest(
        arguments.task, settings_from(arguments), task, Ablation(arguments.ablate or ""), arguments.seed,
        arguments.runs, live_stream(arguments),
    )  # fmt: skip


# --- runs that go on -------------------------------------------------------------------------------------------------


def _resumed(arguments: argparse.Namespace) -> tuple[Inference, Run]:
    """The run to continue, with new limits where options give some."""
    from scenelang.inference.generation import resume

    given = [option for option, name in _SETTLED.items() if getattr(arguments, name, None)]
    if given:
        raise UsageError("value", f"{given[0]} cannot be changed when a run goes on", "begin a new run for that")
    inference, run = resume(arguments.resume, arguments.command, arguments.runs)
    return replace(inference, settings=_with_limits(arguments, inference.settings)), run


@contextmanager
def _told(arguments: argparse.Namespace, run: Run) -> Iterator[None]:
    """Says how a run that ends early goes on."""
    from scenelang.inference.generation import NoProgram, recorded

    runs = f" --runs {arguments.runs}" if arguments.runs else ""
    continuation = f"; to continue: scenelang {arguments.command} --resume {run.name}{runs}"
    try:
        with recorded(run):
            yield
    except KeyboardInterrupt:
        print(f"interrupted{continuation}", file=sys.stderr)
        raise
    except SceneError as error:
        if isinstance(error, NoProgram) and not arguments.json:
            report(arguments, error.verdict.diagnostics)
        if run.facts.get("state") == "failed" and not arguments.quiet and not arguments.json:
            print(f"the run is kept in {run.path}{continuation}", file=sys.stderr)
        raise


def _show_estimate(arguments: argparse.Namespace, inference: Inference) -> int:
    """Print the first request and what it costs at most."""
    from scenelang.inference.conductor import payload_text
    from scenelang.inference.generation import estimate

    found = estimate(inference)
    if arguments.json:
        facts = {"address": found.address, "request": found.payload, "tokens": found.tokens, "cost": found.cost}
        print_json(facts)
        return 0
    say(payload_text(found.payload))
    if found.grammar is not None:
        say(f"\ngrammar: {len(found.grammar):,} characters, where the server takes one")
    say(f"\nto {found.address}: at most {found.tokens:,} tokens and ${found.cost:.4f} before repairs and critiques")
    return 0


def _report_result(arguments: argparse.Namespace, result: Generated) -> None:
    """Say what the run came to: warnings, errors of other samples, tokens and money."""
    if arguments.quiet or arguments.json:
        return
    report(arguments, result.warnings)
    for error in result.stopped:
        print(f"a sample ended early: {error.message}", file=sys.stderr)
    print(
        f"sample {result.sample}; {result.usage.prompt:,} tokens sent, {result.usage.answered:,} answered, "
        f"${result.cost:.4f}; kept in {result.run}",
        file=sys.stderr,
    )


def _say_written(arguments: argparse.Namespace, path: Path) -> None:
    """Say what was written; with ``--json`` standard output is one document."""
    if not arguments.json:
        done(arguments, path)


# --- generate --------------------------------------------------------------------------------------------------------


def add_generate(parser: argparse.ArgumentParser) -> None:
    from scenelang.cli.neural import add_models

    parser.description = (
        "Ask a language model for a scene, check and evaluate its program, have mistakes mended, and "
        "write the program. What the model answers is never executed as Python."
    )
    parser.add_argument(
        "task", metavar="TASK", nargs="?", help='what the scene shows, such as "a chessboard at game start"'
    )
    parser.add_argument(
        "-o", "--output", metavar="OUT.scene", help="where to write the program (default: standard output)"
    )
    _add_kind(parser)
    parser.add_argument("--render", action="store_true", help="also draw it, beside the program")
    parser.add_argument(
        "--invert", action="store_true",
        help="also learn the embeddings of its parts from the pictures, into Z beside it",
    )  # fmt: skip
    add_model_options(parser)
    add_models(parser)
    parser.set_defaults(run=generate)


def generate(arguments: argparse.Namespace) -> int:
    from scenelang.inference.conductor import Inference
    from scenelang.inference.generation import begin

    if arguments.output is not None:
        check_folder(Path(arguments.output))
        if Path(arguments.output).suffix != ".scene":
            raise UsageError("file", f"{arguments.output} is to hold a program of the language: name it .scene")
    if arguments.resume is not None:
        return _finish(arguments, *_resumed(arguments))
    if arguments.invert:
        _check_inversion(arguments)
    inference = Inference(_task_of(arguments), settings_from(arguments), _options_of(arguments))
    if arguments.render and arguments.output is None:
        raise UsageError("value", "--render draws beside the program: say where that is with -o")
    if arguments.dry_run:
        return _show_estimate(arguments, inference)
    output = str(Path(arguments.output).resolve()) if arguments.output else None
    facts = {"output": output, "render": arguments.render, "invert": arguments.invert}
    name = arguments.task or "reconstruction"
    return _finish(arguments, inference, begin(inference, arguments.command, name, arguments.runs, **facts))


def _check_inversion(arguments: argparse.Namespace) -> None:
    """Raises UsageError where there is nothing to learn from or no place for it, and SceneError without the packages:
    before the language model costs money."""
    from scenelang.backends.base import need
    from scenelang.backends.neural.weights import INSTALL

    if not arguments.image or arguments.output is None:
        raise UsageError("value", "--invert learns from a picture, beside the program: give --image and -o")
    for package in ("torch", "diffusers", "transformers"):
        need(package, INSTALL)


def _finish(arguments: argparse.Namespace, inference: Inference, run: Run) -> int:
    """Run to the end, write the program and draw it."""
    from scenelang.cli.neural import invert_generated
    from scenelang.inference.generation import generated, play

    with _told(arguments, run):
        result = generated(run, play(inference, run, live_stream(arguments)), inference.options)
    facts = run.facts
    chosen = arguments.output or facts.get("output")
    if arguments.json:
        print_json(result.data())
    _report_result(arguments, result)
    if chosen is None:
        if not arguments.json:
            sys.stdout.write(result.program)
        return 0
    output = result.save(chosen)
    _say_written(arguments, output)
    if arguments.render or facts.get("render"):
        _say_written(arguments, _draw(arguments, result, output))
    if arguments.invert or facts.get("invert"):
        invert_generated(arguments, result.scene, inference.task.pictures, output)
    return 0


def _draw(arguments: argparse.Namespace, result: Generated, output: Path) -> Path:
    """A draft beside the program: a picture, of a film a GIF."""
    shown, size = progress(arguments, "rendering"), _PICTURE_SIZE
    if result.scene.animated:
        return result.scene.film(size=(size // 2, size // 2)).save(output.with_suffix(".gif"), progress=shown)
    return result.scene.render(size=(size, size), progress=shown).save(output.with_suffix(".png"))


# --- edit ------------------------------------------------------------------------------------------------------------


def add_edit(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Send a program and an instruction to a language model, check and evaluate what comes back, and "
        "show what the edit did: to the text, to the things of the scene, in pictures. Nothing is overwritten without "
        "--apply."
    )
    parser.add_argument("file", metavar="FILE", nargs="?", help="the program: .scene, or a model's .txt or .py")
    parser.add_argument(
        "instruction", metavar="INSTRUCTION", nargs="?", help='such as "shrink the staircase radius by 80%%"'
    )
    parser.add_argument("-o", "--output", metavar="NEW", help="where to write the edited program")
    parser.add_argument("--apply", action="store_true", help="write it over FILE")
    parser.add_argument(
        "--picture", metavar="OUT.png", help="where to draw the scene before and after (default: in the run's folder)"
    )
    parser.add_argument(
        "--limit", type=whole, default=20, metavar="N", help="changes of the scene to print (default 20)"
    )
    add_model_options(parser)
    parser.set_defaults(run=edit)


def edit(arguments: argparse.Namespace) -> int:
    from scenelang.inference.brief import Ablation
    from scenelang.inference.generation import begin, digest_of, editing

    _check_outputs(arguments)
    if arguments.resume is not None:
        inference, run = _resumed(arguments)
        return _finish_edit(arguments, inference, run, Path(str(run.facts["file"])))
    if arguments.file is None or not (arguments.instruction or "").strip():
        raise UsageError("value", "say which program is to be edited, and how")
    path = Path(arguments.file)
    settings, ablation = settings_from(arguments), Ablation(arguments.ablate or "")
    result, found = editing(path, arguments.instruction, settings, _options_of(arguments), ablation)
    report_run(arguments, result)
    if found is None:
        return 1
    if arguments.dry_run:
        return _show_estimate(arguments, found)
    name = f"{path.stem} {arguments.instruction}"
    facts = {"file": str(path.resolve()), "digest": digest_of(path)}
    return _finish_edit(arguments, found, begin(found, arguments.command, name, arguments.runs, **facts), path)


def _check_outputs(arguments: argparse.Namespace) -> None:
    """Raises UsageError or SceneError for places that cannot be written: before the work, so that typos are cheap."""
    if arguments.apply and arguments.output:
        raise UsageError("value", "--apply writes over the file; leave -o out")
    if arguments.file == "-":
        raise UsageError("file", "edit wants a file: what it holds is compared with what comes back")
    for chosen in (arguments.output, arguments.picture):
        if chosen is not None:
            check_folder(Path(chosen))
    if arguments.picture is not None and Path(arguments.picture).suffix.lower() not in (".png", ".jpg", ".webp"):
        raise UsageError("backend", f"no picture can be written to `{arguments.picture}`", "it can be a .png")


def _finish_edit(arguments: argparse.Namespace, inference: Inference, run: Run, path: Path) -> int:
    """Run to the end, show what the edit did, and write it where that is asked for."""
    from scenelang.inference.generation import edited

    with _told(arguments, run):
        found = edited(inference, run, path, live_stream(arguments))
    picture = _pictured(found, Path(arguments.picture) if arguments.picture else run.path / "before-after.png")
    if arguments.json:
        print_json(found.data() | {"picture": str(picture) if picture is not None else None})
    else:
        _show_edit(arguments, found)
    _report_result(arguments, found.result)
    if picture is not None:
        _say_written(arguments, picture)
    if arguments.apply or arguments.output:
        _say_written(arguments, found.apply() if arguments.apply else found.save(arguments.output))
    elif not arguments.quiet and not arguments.json:
        print(f"nothing is overwritten; to take it: scenelang edit --resume {run.name} --apply", file=sys.stderr)
    return 0


def _pictured(found: Edited, path: Path) -> Path | None:
    """The picture of before and after; None where a scene cannot be drawn."""
    try:
        return found.picture().save(path)
    except SceneError:
        return None


def _show_edit(arguments: argparse.Namespace, found: Edited) -> None:
    from scenelang.scene_changes import OF_AN_EDIT, change_lines

    colored = use_color(arguments, sys.stdout)
    for line in found.diff.splitlines():
        color = _COLORS.get(line[:1])
        shown = printable(line)
        print(f"\033[{color}m{shown}\033[0m" if colored and color else shown)
    say("\n".join(change_lines(found.changes, arguments.limit, OF_AN_EDIT)))


# --- runs ------------------------------------------------------------------------------------------------------------


def add_runs(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "List the runs of generate and edit, with how they ended and what they cost; of one run every "
        "attempt. `generate --resume RUN` and `edit --resume RUN` continue one."
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
    found = [run.summary() for run in all_runs(folder)]
    if arguments.json:
        print_json(found)
        return 0
    if not found:
        say(f"there are no runs in {folder}")
        return 0
    rows = [
        (f["name"], f["command"], f["state"], str(f["attempts"]), f"${f['cost']:.4f}", _short(f["task"]))
        for f in found
    ]  # fmt: skip
    header = ("run", "command", "state", "attempts", "cost", "task")
    say(table([header, *rows], (False, False, False, True, True, False)))
    return 0


def _short(text: str) -> str:
    return text if len(text) <= _LONGEST_TASK else text[: _LONGEST_TASK - 3] + "..."


def _show_run(arguments: argparse.Namespace, run: Run) -> None:
    facts = run.summary()
    if facts["state"] == "damaged":
        raise SceneError("run", f"the run {run.name} is damaged")
    attempts = list(run.attempts())
    if arguments.json:
        print_json(facts | {"attempts": [attempt.data() for attempt in attempts]})
        return
    say(f"{facts['name']}: {facts['command']}, {facts['state']}, ${facts['cost']:.4f}")
    say(f"{_short(facts['task'])}\n{run.path}")
    header = ("sample", "attempt", "why", "ended", "sent", "answered", "cost", "came to")
    rows = [header, *(_attempt_row(attempt) for attempt in attempts)]
    say(table(rows, (True, True, False, False, True, True, True, False)))


def _attempt_row(attempt: Attempt) -> tuple[str, ...]:
    data = attempt.data()
    cost = "kept" if data["was_kept"] else f"${data['cost']:.4f}"
    sample = str(attempt.sample) if attempt.sample else "-"
    sent, answered = f"{data['tokens']['sent']:,}", f"{data['tokens']['answered']:,}"
    return sample, str(attempt.number), attempt.purpose, data["ended"], sent, answered, cost, _came_to(data)


def _came_to(data: dict[str, Any]) -> str:
    if data["usable"] is None:
        return ""
    if data["usable"]:
        return f"a scene, {data['findings']} findings" if data["findings"] else "a scene"
    return f"{data['errors']} error{'' if data['errors'] == 1 else 's'}"

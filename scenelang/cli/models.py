"""Commands that ask language models: generate, edit, runs."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn, TextIO

from scenelang.backends.language_models.provider import family
from scenelang.backends.neural.wording import DEFAULT, LIMIT, check_template
from scenelang.cli.neural import invert_generated, z_of
from scenelang.cli.options import (
    UsageError,
    add_fields,
    add_limits,
    add_models,
    add_output,
    add_seed,
    fields_of,
    given,
    limits_of,
    scene_of,
    usage_errors,
    whole,
    z_path,
)
from scenelang.cli.output import check_folder, done, progress, report, report_run, tell, use_color
from scenelang.embeddings import (
    Embeddings,
    check_program,
    wording_table,
)
from scenelang.grammar.diagnostics import SceneError, printable
from scenelang.inference import generation
from scenelang.inference.brief import Ablation, Notation, TaskKind
from scenelang.inference.conductor import Inference, NoProgram
from scenelang.inference.generation import describer
from scenelang.inference.records import RENEWABLE, InferenceSettings, all_runs, check_limits, find_run, runs_folder
from scenelang.reports import painted, print_json, say
from scenelang.session import Options

if TYPE_CHECKING:
    from scenelang.inference.brief import Task
    from scenelang.inference.generation import Edited, Generated
    from scenelang.inference.records import Run
    from scenelang.repl.loop import ModelRequest

_SERVICE = ("provider", "max_cost", "price", "prompt_dir", "timeout")
# What a run has once and for all.
_SETTLED = {
    "the task": "task", "FILE": "file", "--image": "image", "--animate": "animate", "--minecraft": "minecraft",
    "--dsl": "dsl", "--ablate": "ablate", "--model": "model", "--effort": "effort", "--price": "price",
    "--max-tokens": "max_tokens", "--prompt-dir": "prompt_dir", "--batch": "batch", "--no-cache": "no_cache",
    "--dry-run": "dry_run",
}  # fmt: skip


# --- options ---------------------------------------------------------------------------------------------------------


def add_model_options(parser: argparse.ArgumentParser) -> None:
    """What every command that asks a model understands."""
    model = parser.add_argument_group("language model")
    add_fields(model, InferenceSettings, ("model", "effort", "max_tokens", *_SERVICE, "uses_replies"))
    loop = parser.add_argument_group("tries")
    add_fields(loop, InferenceSettings, ("samples", "repairs", "critiques", "side_by_side", "is_batch"))
    ablated = "without programs, words or both, as the paper's ablations"
    loop.add_argument("--ablate", choices=("P", "W", "PW"), help=ablated)
    runs = parser.add_argument_group("runs")
    runs.add_argument("--dry-run", action="store_true", help="print what would be sent, and send nothing")
    runs.add_argument(
        "--resume", metavar="RUN", help="continue a run that was interrupted: its name, `last` for the last one"
    )
    _add_runs_folder(runs)
    add_seed(parser.add_argument_group("evaluation"))
    add_output(parser)
    add_limits(parser)


def _add_runs_folder(group: Any) -> None:
    group.add_argument("--runs", metavar="DIR", help="where runs are kept (default: the user's state folder)")


def add_spending(parser: argparse.ArgumentParser) -> None:
    """What a command that may ask a model on the side understands."""
    group = parser.add_argument_group("language model")
    add_fields(group, InferenceSettings, _SERVICE, max_cost="what it may cost (default 1)")
    parser.set_defaults(max_cost=1.0)


def service_of(arguments: argparse.Namespace) -> InferenceSettings:
    """The service that options name, and the model."""
    return fields_of(arguments, InferenceSettings, model=arguments.model or None)


def settings_from(arguments: argparse.Namespace) -> InferenceSettings:
    """The settings that a command's options give. Raises UsageError for those that make no sense."""
    settings = service_of(arguments)
    with usage_errors():
        family(settings.provider)
    check_limits(given(arguments, InferenceSettings), as_flags=True)
    return settings


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
    kind = TaskKind.FILM if arguments.animate else TaskKind.BLOCKS if arguments.minecraft else TaskKind.STILL
    notation = Notation.LANGUAGE if arguments.dsl else Notation.PYTHON
    ablation = Ablation(arguments.ablate or "")
    return generation.task_of(arguments.task or "", arguments.image, kind, notation, ablation, arguments.seed)


class _LineParser(argparse.ArgumentParser):
    """Says what is wrong with options as every other mistake is said."""

    def error(self, message: str) -> NoReturn:
        raise SceneError("value", message, f"`,help {self.prog}` says how it is used")


def model_request(command: str, line: str) -> ModelRequest:
    """The options of a REPL command, which are those of the command line, and the text behind them."""
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
    settled = [option for option, name in _SETTLED.items() if getattr(arguments, name, None)]
    if settled:
        raise UsageError("value", f"{settled[0]} cannot be changed when a run goes on", "begin a new run for that")
    inference, run = generation.resumed(arguments.resume, arguments.command, arguments.runs)
    asked = given(arguments, InferenceSettings)
    return generation.renewed(inference, {name: asked[name] for name in RENEWABLE if name in asked}, as_flags=True), run


@contextmanager
def _told(arguments: argparse.Namespace, run: Run) -> Iterator[None]:
    """Says how a run that ends early goes on."""
    runs = f" --runs {arguments.runs}" if arguments.runs else ""
    continuation = f"; to continue: scenelang {arguments.command} --resume {run.name}{runs}"
    try:
        with generation.recorded(run):
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
    found = generation.first_estimate(inference)
    return tell(arguments, found.data(), found)


def _report_result(arguments: argparse.Namespace, result: Generated) -> None:
    """Say what the run came to: warnings, errors of other samples, tokens and money."""
    if arguments.quiet or arguments.json:
        return
    report(arguments, result.warnings)
    for error in result.stopped:
        print(f"a sample ended early: {error.message}", file=sys.stderr)
    print(result, file=sys.stderr)


def _say_written(arguments: argparse.Namespace, path: Path) -> None:
    """Say what was written; with ``--json`` standard output is one document."""
    if not arguments.json:
        done(arguments, path)


# --- generate --------------------------------------------------------------------------------------------------------


def add_generate(parser: argparse.ArgumentParser) -> None:
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


def run_generate(arguments: argparse.Namespace) -> int:
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
    return _finish(arguments, inference, generation.begin(inference, arguments.command, name, arguments.runs, **facts))


def _check_inversion(arguments: argparse.Namespace) -> None:
    """Raises UsageError where there is nothing to learn from or no place for it, and SceneError without the packages:
    before the language model costs money."""
    from scenelang.inversion import check_installed

    if not arguments.image or arguments.output is None:
        raise UsageError("value", "--invert learns from a picture, beside the program: give --image and -o")
    check_installed()


def _finish(arguments: argparse.Namespace, inference: Inference, run: Run) -> int:
    """Run to the end, write the program and draw it."""

    with _told(arguments, run):
        result = generation.generated(run, generation.play(inference, run, live_stream(arguments)), inference.options)
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
        _say_written(arguments, generation.draw_draft(result.scene, output, progress(arguments, "rendering")))
    if arguments.invert or facts.get("invert"):
        invert_generated(arguments, result.scene, inference.task.pictures, output)
    return 0


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


def run_edit(arguments: argparse.Namespace) -> int:
    _check_outputs(arguments)
    if arguments.resume is not None:
        inference, run = _resumed(arguments)
        return _finish_edit(arguments, inference, run, Path(str(run.facts["file"])))
    if arguments.file is None or not (arguments.instruction or "").strip():
        raise UsageError("value", "say which program is to be edited, and how")
    path = Path(arguments.file)
    settings, ablation = settings_from(arguments), Ablation(arguments.ablate or "")
    result, found = generation.editing(path, arguments.instruction, settings, _options_of(arguments), ablation)
    report_run(arguments, result)
    if found is None:
        return 1
    if arguments.dry_run:
        return _show_estimate(arguments, found)
    name = f"{path.stem} {arguments.instruction}"
    facts = {"file": str(path.resolve()), "digest": generation.digest_of(path)}
    return _finish_edit(
        arguments, found, generation.begin(found, arguments.command, name, arguments.runs, **facts), path
    )


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
    with _told(arguments, run):
        found = generation.edited(inference, run, path, live_stream(arguments))
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

    sys.stdout.writelines(painted(map(printable, found.diff.splitlines()), use_color(arguments, sys.stdout)))
    say("\n".join(change_lines(found.changes, arguments.limit, OF_AN_EDIT)))


# --- runs ------------------------------------------------------------------------------------------------------------


def add_runs(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "List the runs of generate and edit, with how they ended and what they cost; of one run every "
        "attempt. `generate --resume RUN` and `edit --resume RUN` continue one."
    )
    parser.add_argument("run_name", metavar="RUN", nargs="?", help="a run: its name, `last`, or its folder")
    _add_runs_folder(parser)


def run_runs(arguments: argparse.Namespace) -> int:
    from scenelang.inference.records import list_of_runs, run_facts, run_report

    folder = runs_folder(arguments.runs)
    if arguments.run_name is not None:
        run = find_run(folder, arguments.run_name)
        facts, attempts = run_facts(run)
        data: Any = facts | {"attempts": [attempt.data() for attempt in attempts]}
        text = run_report(run, facts, attempts)
    else:
        data = [each.summary() for each in all_runs(folder)]
        text = list_of_runs(data) if data else f"there are no runs in {folder}"
    return tell(arguments, data, text)


def add_embed(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Turn colours, surfaces, proportions and other numbers of every primitive into words, and store "
        "these texts, with the templates that use them, in Z beside the program."
    )
    parser.add_argument(
        "--template", metavar="TEXT",
        help="the sentence about a primitive; {embedding}, {word} and {style} stand for its handle, what it is and the "
        "root's handle (default: a {embedding} {word}, in the style of {style}, 3D model)",
    )  # fmt: skip
    words = "let a language model find the words (default: a table)"
    parser.add_argument("--model", nargs="?", const="", metavar="NAME", help=words)
    add_spending(parser)
    parser.add_argument("--force", action="store_true", help="describe anew what Z describes already")
    parser.add_argument("--print", action="store_true", dest="only_print", help="show the words, write nothing")


def run_embed(arguments: argparse.Namespace) -> int:
    with usage_errors():
        check_template(DEFAULT if arguments.template is None else arguments.template)
    if not arguments.only_print and arguments.file != "-":
        check_program(arguments.file, "embed the program that made it, or look at the words with --print")
    if not arguments.only_print and z_path(arguments) is None and arguments.file == "-":
        raise UsageError("file", "say where Z is: --z FILE", "or look at the words with --print")
    z = Embeddings(z_path(arguments)) if arguments.only_print else z_of(arguments)
    scene = scene_of(arguments, fresh=not arguments.only_print and not z.exists)
    if arguments.model is not None and not arguments.force:
        with usage_errors():
            z.check_undescribed()
    describe = None if arguments.model is None else describer(service_of(arguments), live_stream(arguments))
    work = z.words_of if arguments.only_print else z.describe
    limit = int(arguments.max_primitives or LIMIT)
    found = work(scene, template=arguments.template, describe=describe, force=arguments.force, limit=limit)
    if arguments.json:
        print_json(found.data())
    elif arguments.only_print:
        say(wording_table(found.wording))
    elif not arguments.quiet:
        before = f"; {found.known:,} were there before (--force describes them anew)" if found.known else ""
        say(f"wrote {z.path}: {found}{before}")
    if describe is not None and not arguments.quiet:
        print(f"asking cost ${describe.spent:.4f}", file=sys.stderr)
    return 0

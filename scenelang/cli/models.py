"""Commands that use language models: generate, edit, runs; and the options of others that do."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn, TextIO

from scenelang.backends.language_models.provider import find_family
from scenelang.cli.options import (
    UsageError,
    add_fields,
    add_limits,
    add_models,
    add_output,
    add_seed,
    check_folder,
    done,
    fields_of,
    given,
    limits_of,
    print_result,
    progress,
    report,
    report_run,
    usage_errors,
    use_color,
    whole,
)
from scenelang.console.reports import painted, print_json, say
from scenelang.grammar.diagnostics import SceneError, printable
from scenelang.inference import generation
from scenelang.inference.brief import Ablation, Notation, TaskKind
from scenelang.inference.conductor import Inference, NoProgram
from scenelang.inference.records import (
    RENEWABLE,
    REVISIONS,
    InferenceSettings,
    all_runs,
    check_limits,
    find_run,
    runs_folder,
)
from scenelang.session.loaded import LoadedScene
from scenelang.session.session import Options

if TYPE_CHECKING:
    from scenelang.inference.brief import Task
    from scenelang.inference.generation import Edited, Generated
    from scenelang.inference.records import Run
    from scenelang.repl.loop import ModelRequest

_SERVICE = ("provider", "max_cost", "price", "prompt_dir", "timeout")
# Properties of a run that cannot change when it is resumed: option -> attribute.
_SETTLED = {
    "the task": "task", "FILE": "file", "--image": "image", "--animate": "animate", "--minecraft": "minecraft",
    "--dsl": "dsl", "--ablate": "ablate", "--model": "model", "--effort": "effort", "--price": "price",
    "--max-tokens": "max_tokens", "--prompt-dir": "prompt_dir", "--batch": "batch", "--no-cache": "no_cache",
    "--no-images": "no_images", "--dry-run": "dry_run",
}  # fmt: skip


# --- options ---------------------------------------------------------------------------------------------------------


def add_model_options(
    parser: argparse.ArgumentParser, looped: Sequence[str] = ("samples", "repairs", "critiques")
) -> None:
    """Add the options shared by all commands that call a language model; ``looped`` are settings of its loop."""
    model = parser.add_argument_group("language model")
    add_fields(model, InferenceSettings, ("model", "effort", "max_tokens", *_SERVICE, "uses_replies", "sends_images"))
    loop = parser.add_argument_group("sampling and repair")
    add_fields(loop, InferenceSettings, (*looped, "side_by_side", "is_batch"))
    ablated = "ablation of the paper: without programs (P), words (W) or both (PW)"
    loop.add_argument("--ablate", choices=("P", "W", "PW"), help=ablated)
    runs = parser.add_argument_group("runs")
    runs.add_argument(
        "--dry-run", action="store_true", help="print the first request and its maximum cost without sending it"
    )
    runs.add_argument("--resume", metavar="RUN", help="name of an interrupted run to resume, or `last`")
    _add_runs_folder(runs)
    add_seed(parser.add_argument_group("evaluation"))
    add_output(parser)
    add_limits(parser)


def _add_runs_folder(group: Any) -> None:
    """Add the option for the folder of the runs."""
    group.add_argument("--runs", metavar="DIR", help="folder of the runs (default: in the user's state folder)")


def add_spending(parser: argparse.ArgumentParser) -> None:
    """Add the options of a command that calls a language model as a secondary step."""
    group = parser.add_argument_group("language model")
    add_fields(group, InferenceSettings, _SERVICE, max_cost="maximum cost in US dollars (default 1)")
    parser.set_defaults(max_cost=1.0)


def service_of(arguments: argparse.Namespace) -> InferenceSettings:
    """Return the provider settings and the model that the options select."""
    return fields_of(arguments, InferenceSettings, model=arguments.model or None)


def settings_from(arguments: argparse.Namespace) -> InferenceSettings:
    """Return the settings that a command's options give; raises UsageError for invalid values."""
    settings = service_of(arguments)
    with usage_errors():
        find_family(settings.provider)
    check_limits(given(arguments, InferenceSettings), as_flags=True)
    return settings


def _options_of(arguments: argparse.Namespace) -> Options:
    """Return the evaluation options for the model's programs."""
    return Options(seed=arguments.seed, limits=limits_of(arguments))


def live_stream(arguments: argparse.Namespace) -> TextIO | None:
    """Return the stream for live token counts: standard error on a terminal, else None."""
    return sys.stderr if sys.stderr.isatty() and not arguments.quiet and not arguments.json else None


def _add_kind(parser: argparse.ArgumentParser) -> None:
    """Add the options for the kind of scene and its notation."""
    parser.add_argument(
        "--image", action="append", default=[], metavar="FILE",
        help="input image to reconstruct; may be repeated",
    )  # fmt: skip
    kind = parser.add_mutually_exclusive_group()
    kind.add_argument("--animate", action="store_true", help="generate an animated (4D) scene")
    kind.add_argument("--minecraft", action="store_true", help="generate a Minecraft build")
    parser.add_argument("--dsl", action="store_true", help="prompt for Scene Language code instead of Python")


def _task_of(arguments: argparse.Namespace) -> Task:
    """Return the task that the options describe."""
    kind = TaskKind.FILM if arguments.animate else TaskKind.BLOCKS if arguments.minecraft else TaskKind.STILL
    notation = Notation.LANGUAGE if arguments.dsl else Notation.PYTHON
    ablation = Ablation(arguments.ablate or "")
    return generation.task_of(arguments.task or "", arguments.image, kind, notation, ablation, arguments.seed)


class _LineParser(argparse.ArgumentParser):
    """Argument parser that raises SceneError instead of exiting, for use in the REPL."""

    def error(self, message: str) -> NoReturn:
        """Raise the error that argparse would exit with."""
        raise SceneError("value", message, f"see `,help {self.prog}` for its usage")


def model_request(command: str, line: str) -> ModelRequest:
    """Parse a REPL command's line: the options of the command-line command, then free text."""
    from scenelang.repl.loop import ModelRequest

    parser = _LineParser(prog=command, add_help=False, allow_abbrev=False)
    if command == "generate":
        _add_kind(parser)
    add_model_options(parser)
    parser.add_argument("text", nargs="*")
    try:
        words = shlex.split(line)
    except ValueError:  # an unbalanced quote, such as an apostrophe
        words = line.split()
    arguments = parser.parse_args(words)
    arguments.task = " ".join(arguments.text)
    for name in ("resume", "dry_run", "json"):
        if getattr(arguments, name):
            raise SceneError("value", f"`--{name.replace('_', '-')}` is only supported on the command line")
    task = _task_of(arguments) if command == "generate" and arguments.task else None
    return ModelRequest(
        arguments.task, settings_from(arguments), task, Ablation(arguments.ablate or ""), arguments.seed,
        arguments.runs, live_stream(arguments),
    )  # fmt: skip


# --- resuming runs ---------------------------------------------------------------------------------------------------


def _resumed(arguments: argparse.Namespace) -> tuple[Inference, Run]:
    """Load the run to resume, with the limits that the options change."""
    settled = [option for option, name in _SETTLED.items() if getattr(arguments, name, None)]
    if settled:
        raise UsageError("value", f"{settled[0]} cannot be changed for a resumed run", "start a new run instead")
    inference, run = generation.resumed(arguments.resume, arguments.command, arguments.runs)
    given_settings = given(arguments, InferenceSettings)
    return generation.renewed(
        inference, {name: given_settings[name] for name in RENEWABLE if name in given_settings}, as_flags=True
    ), run


@contextmanager
def _resume_hint(arguments: argparse.Namespace, run: Run) -> Iterator[None]:
    """Print how to resume the run if it ends early."""
    runs = f" --runs {arguments.runs}" if arguments.runs else ""
    continuation = f"; to resume: scenelang {arguments.command} --resume {run.name}{runs}"
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
            print(f"the run is saved in {run.path}{continuation}", file=sys.stderr)
        raise


def _show_estimate(arguments: argparse.Namespace, inference: Inference) -> int:
    """Print the first request and an upper bound of its cost."""
    estimate = generation.first_estimate(inference)
    return print_result(arguments, estimate.data(), estimate)


def _report_result(arguments: argparse.Namespace, result: Generated[LoadedScene]) -> None:
    """Report the result of a run: warnings, errors of other samples, tokens and cost."""
    if arguments.quiet or arguments.json:
        return
    report(arguments, result.warnings)
    for error in result.stopped:
        print(f"a sample ended early: {error.message}", file=sys.stderr)
    print(result, file=sys.stderr)


def _say_written(arguments: argparse.Namespace, path: Path) -> None:
    """Report the file that was written; with ``--json`` standard output is reserved for one document."""
    if not arguments.json:
        done(arguments, path)


# --- generate --------------------------------------------------------------------------------------------------------


def _add_task(parser: argparse.ArgumentParser, example: str) -> None:
    """Add the task, the kind of the scene, and the files to write."""
    parser.add_argument("task", metavar="TASK", nargs="?", help=f'text prompt, such as "{example}"')
    parser.add_argument("-o", "--output", metavar="OUT.scene", help="output program (default: standard output)")
    _add_kind(parser)
    parser.add_argument("--render", action="store_true", help="also render the scene to an image beside the program")


def add_generate(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``generate``."""
    parser.description = (
        "Generate a scene with a language model: sample programs, check and evaluate them, repair errors, and "
        "write the program. Generated Python is translated, never executed."
    )
    _add_task(parser, "a chessboard at game start")
    parser.add_argument(
        "--invert", action="store_true",
        help="also learn embeddings of its parts from the input images (textual inversion)",
    )  # fmt: skip
    add_model_options(parser, ("samples", "repairs", "critiques", "acceptance", "max_run_tokens", "max_run_seconds"))
    add_models(parser)


def add_build(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``build``."""
    parser.description = (
        "Build a scene with a language model step by step: plan its parts and what must hold, write part by part, "
        "measure, let a critic look, and revise. A revision that makes anything worse is rolled back. Generated Python "
        "is translated, never executed."
    )
    _add_task(parser, "a kitchen for two")
    parser.add_argument(
        "--ask", action="store_true", help="ask three questions about the task before the first request"
    )
    add_model_options(parser, ("samples", "repairs", "revisions", "max_run_tokens", "max_run_seconds"))
    parser.set_defaults(invert=False)


_QUESTIONS = (
    "How large is it, in metres?",
    "What must be there, and how many of each?",
    "What must not happen?",
)  # what most tasks leave open, and what acceptance is about


def run_build(arguments: argparse.Namespace) -> int:
    """Build a scene, or resume a run."""
    if arguments.ask and arguments.resume is None:
        arguments.task = _asked(arguments.task or "")
    if arguments.turns is None and arguments.resume is None:
        arguments.turns = REVISIONS
    return run_generate(arguments)


def _asked(task: str) -> str:
    """Return a task with the answers to questions about it; an empty answer leaves a question open.

    Raises
    ------
    UsageError
        If nobody can answer: standard input ends.
    """
    for question in _QUESTIONS:
        try:
            print(f"{question} ", end="", file=sys.stderr, flush=True)
            answer = input().strip()
        except EOFError:
            raise UsageError("value", "--ask expects answers on standard input, which has ended") from None
        if answer:
            task = f"{task.rstrip()}\n{question} {answer}"
    return task


def run_generate(arguments: argparse.Namespace) -> int:
    """Generate a scene, or resume a run."""
    if arguments.output is not None:
        check_folder(Path(arguments.output))
        if Path(arguments.output).suffix != ".scene":
            raise UsageError("file", f"expected a .scene file for the output, got {arguments.output}")
    if arguments.resume is not None:
        return _finish(arguments, *_resumed(arguments))
    if arguments.invert:
        _check_inversion(arguments)
    inference = Inference(_task_of(arguments), settings_from(arguments), _options_of(arguments))
    if arguments.render and arguments.output is None:
        raise UsageError("value", "--render writes the image beside the program and requires -o")
    if arguments.dry_run:
        return _show_estimate(arguments, inference)
    output = str(Path(arguments.output).resolve()) if arguments.output else None
    facts = {"output": output, "render": arguments.render, "invert": arguments.invert}
    name = arguments.task or "reconstruction"
    return _finish(arguments, inference, generation.begin(inference, arguments.command, name, arguments.runs, **facts))


def _check_inversion(arguments: argparse.Namespace) -> None:
    """Check the prerequisites of ``--invert`` before the language model costs money.

    Raises
    ------
    UsageError
        Without an input image or output.
    SceneError
        Without the packages.
    """
    from scenelang.learning.inversion import check_installed

    if not arguments.image or arguments.output is None:
        raise UsageError("value", "--invert requires an input image and an output program: give --image and -o")
    check_installed()


def _finish(arguments: argparse.Namespace, inference: Inference, run: Run) -> int:
    """Run to completion, write the program and render it."""

    with _resume_hint(arguments, run):
        result = generation.generated(
            run, generation.play(inference, run, live_stream(arguments)), inference.options, LoadedScene
        )
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
        from scenelang.cli.neural import invert_generated

        invert_generated(arguments, result.scene, inference.task.pictures, output)
    return 0


# --- edit ------------------------------------------------------------------------------------------------------------


def add_edit(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``edit``."""
    parser.description = (
        "Edit a program by an instruction with a language model: check and evaluate the edited program, and "
        "show the differences in the text, in the scene and in pictures. Nothing is overwritten without "
        "--apply."
    )
    parser.add_argument(
        "file", metavar="FILE", nargs="?", help="program to edit: .scene, or a model's response (.txt, .py)"
    )
    parser.add_argument(
        "instruction",
        metavar="INSTRUCTION",
        nargs="?",
        help='edit instruction, such as "shrink the staircase radius by 80%%"',
    )
    parser.add_argument("-o", "--output", metavar="NEW", help="output file of the edited program")
    parser.add_argument("--apply", action="store_true", help="overwrite FILE with the edited program")
    parser.add_argument("--picture", metavar="OUT.png", help="before-and-after image (default: in the run's folder)")
    parser.add_argument(
        "--limit", type=whole, default=20, metavar="N", help="maximum number of scene changes to print (default 20)"
    )
    add_model_options(parser)


def run_edit(arguments: argparse.Namespace) -> int:
    """Edit a program, or resume a run."""
    _check_outputs(arguments)
    if arguments.resume is not None:
        inference, run = _resumed(arguments)
        return _finish_edit(arguments, inference, run, Path(str(run.facts["file"])))
    if arguments.file is None or not (arguments.instruction or "").strip():
        raise UsageError("value", "expected a program and an instruction")
    path = Path(arguments.file)
    if not path.exists() and Path(arguments.instruction).is_file():
        raise UsageError("value", "the program comes first, then the instruction")
    settings, ablation = settings_from(arguments), Ablation(arguments.ablate or "")
    result, edit = generation.editing(path, arguments.instruction, settings, _options_of(arguments), ablation)
    report_run(arguments, result)
    if edit is None:
        return 1
    if arguments.dry_run:
        return _show_estimate(arguments, edit)
    name = f"{path.stem} {arguments.instruction}"
    facts = {"file": str(path.resolve()), "digest": generation.digest_of(path)}
    return _finish_edit(arguments, edit, generation.begin(edit, arguments.command, name, arguments.runs, **facts), path)


def _check_outputs(arguments: argparse.Namespace) -> None:
    """Check the outputs before the expensive work; raises UsageError or SceneError if one cannot be written."""
    if arguments.apply and arguments.output:
        raise UsageError("value", "--apply overwrites FILE and cannot be combined with -o")
    if arguments.file == "-":
        raise UsageError("file", "cannot edit standard input; expected a file")
    for chosen in (arguments.output, arguments.picture):
        if chosen is not None:
            check_folder(Path(chosen))
    if arguments.picture is not None and Path(arguments.picture).suffix.lower() not in (".png", ".jpg", ".webp"):
        raise UsageError("backend", f"cannot write an image to `{arguments.picture}`", "use .png, .jpg or .webp")


def _finish_edit(arguments: argparse.Namespace, inference: Inference, run: Run, path: Path) -> int:
    """Run to completion, show the effect of the edit, and write the program if requested."""
    with _resume_hint(arguments, run):
        edited = generation.edited(inference, run, path, LoadedScene, live_stream(arguments))
    picture = _pictured(edited, Path(arguments.picture) if arguments.picture else run.path / "before-after.png")
    if arguments.json:
        print_json(edited.data() | {"picture": str(picture) if picture is not None else None})
    else:
        _show_edit(arguments, edited)
    _report_result(arguments, edited.result)
    if picture is not None:
        _say_written(arguments, picture)
    if arguments.apply or arguments.output:
        _say_written(arguments, edited.apply() if arguments.apply else edited.save(arguments.output))
    elif not arguments.quiet and not arguments.json:
        print(
            f"nothing was overwritten; to apply the edit: scenelang edit --resume {run.name} --apply", file=sys.stderr
        )
    return 0


def _pictured(edited: Edited[LoadedScene], path: Path) -> Path | None:
    """Save the before-and-after image; returns None if a scene cannot be rendered."""
    try:
        return edited.picture().save(path)
    except SceneError:
        return None


def _show_edit(arguments: argparse.Namespace, edited: Edited[LoadedScene]) -> None:
    """Print the diff of the text and the changes of the scene."""
    from scenelang.session.scene_changes import OF_AN_EDIT, change_lines

    sys.stdout.writelines(painted(map(printable, edited.diff.splitlines()), use_color(arguments, sys.stdout)))
    say("\n".join(change_lines(edited.changes, arguments.limit, OF_AN_EDIT)))


# --- runs ------------------------------------------------------------------------------------------------------------


def add_runs(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``runs``."""
    parser.description = (
        "List the runs of generate, build and edit with their state and cost, or all attempts of one run. "
        "`--resume RUN` of generate, build and edit continues a run."
    )
    parser.add_argument("run_name", metavar="RUN", nargs="?", help="name or folder of a run, or `last`")
    _add_runs_folder(parser)


def run_runs(arguments: argparse.Namespace) -> int:
    """List the runs, or the attempts of one."""
    from scenelang.inference.records import list_of_runs, run_facts, run_report

    folder = runs_folder(arguments.runs)
    if arguments.run_name is not None:
        run = find_run(folder, arguments.run_name)
        facts, attempts = run_facts(run)
        data: Any = facts | {"attempts": [attempt.data() for attempt in attempts]}
        text = run_report(run, facts, attempts)
    else:
        data = [run.summary() for run in all_runs(folder)]
        text = list_of_runs(data) if data else f"no runs in {folder}"
    return print_result(arguments, data, text)

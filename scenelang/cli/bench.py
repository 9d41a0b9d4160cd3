"""The command `bench`: language models on tasks that are judged by the geometry of the scene."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from scenelang.bench import benchmark as api
from scenelang.bench.results import comparison_markdown
from scenelang.bench.tasks import load_tasks
from scenelang.bench.trials import MODES, applicable
from scenelang.cli.models import settings_from
from scenelang.cli.options import UsageError, add_fields, done, print_result, progress
from scenelang.console.reports import say, table
from scenelang.inference.records import InferenceSettings

_MODEL = ("model", "effort", "max_tokens", "provider", "max_cost", "price", "prompt_dir", "timeout", "uses_replies")


def add_bench(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``bench``."""
    parser.description = (
        "Measure a language model: run tasks in several modes, judge the scenes by their geometry, and write tables. "
        "Answers are recorded and can be replayed without a model."
    )
    parser.add_argument("-o", "--output", metavar="DIR", help="folder of the run; an interrupted run goes on there")
    chosen = parser.add_argument_group("tasks")
    chosen.add_argument(
        "--mode", metavar="M,...", help=f"modes: {', '.join(MODES)} (default: python,dsl, or those of the recording)"
    )
    chosen.add_argument("--task", action="append", default=[], metavar="NAME", help="run this task; may be repeated")
    chosen.add_argument("--group", action="append", default=[], metavar="NAME", help="run the tasks of this group")
    chosen.add_argument("--hard", action="store_true", help="run the hard split, which other runs leave out")
    chosen.add_argument(
        "--tasks", metavar="PATH", help="TOML file with tasks, or a folder of these (default: the package's)"
    )
    chosen.add_argument("--list", action="store_true", help="list the tasks and exit")
    chosen.add_argument("--physics", action="store_true", help="simulate static scenes, for the share of stable ones")
    source = parser.add_argument_group("without a model")
    source.add_argument("--replay", metavar="RUN", help="use the answers of a run, or of an answers.jsonl")
    source.add_argument(
        "--any-prompt", action="store_true", help="also replay answers to another wording of their request"
    )
    source.add_argument(
        "--mutations", type=int, metavar="SEED",
        help="use the mutation model: it plants mistakes in programs that pass, and repairs them by `check --json`",
    )  # fmt: skip
    source.add_argument(
        "--mistakes", type=int, metavar="N",
        help="measure the checker: repair N programs with each kind of mistake by `check --json`, and exit",
    )  # fmt: skip
    source.add_argument("--report", metavar="RUN", help="print the tables of a run so far and exit")
    source.add_argument("--compare", nargs=2, metavar="RUN", help="compare two runs and exit")
    model = parser.add_argument_group("language model")
    add_fields(model, InferenceSettings, _MODEL)
    add_fields(model, InferenceSettings, ("samples", "repairs", "side_by_side"), samples="samples per task (default 1)")


def run_bench(arguments: argparse.Namespace) -> int:
    """Run a benchmark, or list, report or compare."""
    asked = [name for name in ("list", "report", "compare", "mistakes") if getattr(arguments, name)]
    others = [name for name in ("replay", "output") if getattr(arguments, name)] if asked else []
    if len(asked + others) > 1:
        raise UsageError("value", f"--{asked[0]} and --{(asked + others)[1]} cannot be combined")
    if arguments.list:
        return _list(arguments)
    if arguments.report:
        report = api.benchmark_report(arguments.report)
        return print_result(arguments, report.data(), report)
    if arguments.compare:
        comparison = api.compare_benchmarks(*arguments.compare)
        return print_result(arguments, api.comparison_data(comparison), comparison_markdown(comparison))
    if arguments.mistakes is not None:
        measured = api.measure_diagnostics(
            arguments.mistakes, tasks=arguments.task, groups=arguments.group, hard=arguments.hard,
            task_folder=arguments.tasks, seed=arguments.mutations or 0,
        )  # fmt: skip
        return print_result(arguments, measured.data(), measured.markdown())
    return _run(arguments)


def _list(arguments: argparse.Namespace) -> int:
    """Print the tasks that the options select."""
    tasks = load_tasks(Path(arguments.tasks) if arguments.tasks else None)
    chosen = applicable(tasks, arguments.task, arguments.group, arguments.hard)
    rows = [(t.group, t.name, t.kind.value, len(t.that) + bool(t.keep), t.prompt) for t in chosen]
    data = [dict(zip(("group", "name", "kind", "predicates", "prompt"), row)) for row in rows]
    header = ("group", "task", "kind", "predicates", "prompt")
    short = [(*row[:3], str(row[3]), f"{row[4][:60]}..." if len(row[4]) > 60 else row[4]) for row in rows]
    return print_result(arguments, data, table([header, *short], (False, False, False, True, False)))


def _run(arguments: argparse.Namespace) -> int:
    """Run tasks with a model or a recording, and write the tables."""
    if arguments.output is None:
        raise UsageError("value", "expected a folder for the run: give -o")
    settings = settings_from(arguments)
    try:
        report = api.benchmark(
            arguments.output, modes=arguments.mode.split(",") if arguments.mode else (), tasks=arguments.task,
            groups=arguments.group, hard=arguments.hard, task_folder=arguments.tasks, settings=settings,
            replay=arguments.replay, any_prompt=arguments.any_prompt, mutations=arguments.mutations,
            simulates=arguments.physics, progress=progress(arguments, "trials"),
        )  # fmt: skip
    except KeyboardInterrupt:
        print(f"interrupted; the same command goes on with {arguments.output}", file=sys.stderr)
        raise
    written = report.save()
    if arguments.json:
        return print_result(arguments, report.data(), "")
    say(str(report))
    if report.outdated and not arguments.quiet:
        print(f"{report.outdated} answers were given to another wording of their request", file=sys.stderr)
    if report.missing:
        print(f"warning: {report.missing} requests have no answer in the recording (--any-prompt?)", file=sys.stderr)
    for path in written:
        done(arguments, path)
    return 0

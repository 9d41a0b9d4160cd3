"""The command `eval`: computes metrics in the layout of the paper's tables, and runs its user study."""

from __future__ import annotations

import argparse
import sys
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.backends.files import make_folder
from scenelang.cli.options import (
    UsageError,
    add_fields,
    add_models,
    check_folder,
    done,
    fields_of,
    models_of,
    opened,
    print_result,
    progress,
    report,
    session_limit,
    warnings,
)
from scenelang.evaluation.running import entries_of
from scenelang.evaluation.study import preferences
from scenelang.evaluation.subjects import MetricOptions, measured, study_of, subjects_of
from scenelang.evaluation.tables import LAYOUTS, as_data
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.settings import settings_in
from scenelang.reports import deliver, print_json, say

if TYPE_CHECKING:
    from scenelang.evaluation.running import EvaluationEntry, Measure, Subject
    from scenelang.evaluation.subjects import MetricReport, Opened


def add_eval(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "files", metavar="FILE", nargs="*",
        help='programs, or a JSON manifest: a list of {"scene" or "film": FILE, "prompt": TEXT, "method": NAME, '
        '"image": FILE, "count": {WORD: N}, "distilled": DIR}',
    )  # fmt: skip
    parser.add_argument("-o", "--output", metavar="DIR", help="results folder; results already in it are reused")
    add_fields(parser, MetricOptions, ("metrics",))
    drawing = [name for name in settings_in(MetricOptions) if name != "metrics"]
    add_fields(parser.add_argument_group("rendering"), MetricOptions, drawing)
    layout = parser.add_mutually_exclusive_group()
    layout.add_argument(
        "--markdown", dest="layout", action="store_const", const="markdown", help="print tables as Markdown"
    )
    layout.add_argument("--latex", dest="layout", action="store_const", const="latex", help="print tables as LaTeX")
    study = parser.add_argument_group("user study")
    study.add_argument(
        "--study", metavar="PAGE", help="write a questionnaire that compares results with their prompts (.html)"
    )
    study.add_argument(
        "--study-results",
        nargs="+",
        metavar="ANSWERS",
        help="answer files of the user study to evaluate and add to the tables",
    )
    add_models(parser)
    parser.set_defaults(layout="text")


def run_eval(arguments: argparse.Namespace) -> int:
    options = _checked(arguments)
    if not arguments.files:
        answered = preferences([Path(name) for name in arguments.study_results])
        return print_result(arguments, answered.data(), answered)
    drawings = options.drawings()
    failed: list[str] = []
    subjects = subjects_of(entries_of(arguments.files), drawings, lambda entry: _opened(arguments, entry, failed))
    if arguments.study is not None:
        check_folder(Path(arguments.study))
        evaluated_subjects = list(subjects)
        if failed:
            return 1
        page = study_of(
            evaluated_subjects, arguments.seed, lambda each: progress(arguments, f"drawing {each.entry.place}")
        )
        deliver(page, arguments.study)
        done(arguments, Path(arguments.study))
        return 0

    def fail(error: SceneError, about: str) -> None:
        report(arguments, [replace(error.diagnostic, message=f"{about}: {error.message}")])

    def show(subject: Subject, measure: Measure) -> Any:
        return progress(arguments, f"{subject.entry.place} {measure.name}")

    folder = None if arguments.output is None else make_folder(Path(arguments.output))
    measures = options.measures(models_of(arguments))
    answers = [Path(name) for name in arguments.study_results or ()]
    found = measured(subjects, measures, folder, answers, fail, show)
    _show(arguments, found)
    return 1 if failed or found.failures else 0


def _checked(arguments: argparse.Namespace) -> MetricOptions:
    """Check the options and return those of the metrics; raises UsageError for invalid combinations."""
    if not arguments.files and not arguments.study_results:
        raise UsageError("value", "expected programs to evaluate, or `--study-results`")
    if arguments.study is not None and Path(arguments.study).suffix.lower() not in (".html", ".htm"):
        raise UsageError("backend", f"expected an .html file for `--study`, got `{arguments.study}`")
    if arguments.study is not None and (arguments.study_results or not arguments.files):
        raise UsageError("value", "`--study` requires programs or films, and cannot be combined with `--study-results`")
    options = fields_of(
        arguments, MetricOptions, seed=arguments.seed, limit=session_limit(arguments), warn=warnings(arguments)
    )
    options.check()
    return options


def _opened(arguments: argparse.Namespace, entry: EvaluationEntry, failed: list[str]) -> Opened | None:
    """Return the scene and the source text of an entry. If the program has errors, report them, add the entry to
    ``failed`` and return None."""
    own = argparse.Namespace(**{**vars(arguments), "file": str(entry.scene)})
    try:
        result, source, _ = opened(own)
    except SceneError as error:
        report(arguments, [error.diagnostic])
    else:
        if result.scene is not None:
            return result.scene, source.text
    failed.append(entry.place)
    return None


def _show(arguments: argparse.Namespace, found: MetricReport) -> None:
    """Print the tables, or all records as JSON."""
    tables = found.tables
    if arguments.json:
        records = [asdict(record) for record in found.records]
        print_json({"tables": [as_data(t) for t in tables], "records": records, "left_out": list(found.left_out)})
        return
    say("\n\n".join(LAYOUTS[arguments.layout](each) for each in tables))
    if not tables:
        print("nothing was measured", file=sys.stderr)

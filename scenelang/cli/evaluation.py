"""The command eval: metrics of scenes in the paper's tables, and its user study."""

from __future__ import annotations

import argparse
import sys
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.backends.files import made_folder
from scenelang.cli.options import UsageError, add_fields, add_models, fields_of, models_of, opened, session_limit
from scenelang.cli.output import check_folder, done, progress, report, tell, warnings
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
        help='programs, or a JSON list of {"scene" or "film": FILE, "prompt": TEXT, "method": NAME, "image": FILE, '
        '"count": {WORD: N}, "distilled": DIR}',
    )  # fmt: skip
    parser.add_argument("-o", "--output", metavar="DIR", help="keep results here, and go on with those that are there")
    add_fields(parser, MetricOptions, ("metrics",))
    drawing = [name for name in settings_in(MetricOptions) if name != "metrics"]
    add_fields(parser.add_argument_group("drawing"), MetricOptions, drawing)
    layout = parser.add_mutually_exclusive_group()
    layout.add_argument("--markdown", dest="layout", action="store_const", const="markdown", help="tables as Markdown")
    layout.add_argument("--latex", dest="layout", action="store_const", const="latex", help="tables for LaTeX")
    study = parser.add_argument_group("user study")
    study.add_argument("--study", metavar="PAGE", help="write a page that asks which result fits its text best: .html")
    study.add_argument(
        "--study-results", nargs="+", metavar="ANSWERS", help="what files of answers say, also in the tables"
    )
    add_models(parser)
    parser.set_defaults(layout="text")


def run_eval(arguments: argparse.Namespace) -> int:
    options = _checked(arguments)
    if not arguments.files:
        answered = preferences([Path(name) for name in arguments.study_results])
        return tell(arguments, answered.data(), answered)
    drawings = options.drawings()
    failed: list[str] = []
    subjects = subjects_of(entries_of(arguments.files), drawings, lambda entry: _opened(arguments, entry, failed))
    if arguments.study is not None:
        check_folder(Path(arguments.study))
        told = list(subjects)
        if failed:
            return 1
        page = study_of(told, arguments.seed, lambda each: progress(arguments, f"drawing {each.entry.place}"))
        deliver(page, arguments.study)
        done(arguments, Path(arguments.study))
        return 0

    def fail(error: SceneError, about: str) -> None:
        report(arguments, [replace(error.diagnostic, message=f"{about}: {error.message}")])

    def show(subject: Subject, measure: Measure) -> Any:
        return progress(arguments, f"{subject.entry.place} {measure.name}")

    folder = None if arguments.output is None else made_folder(Path(arguments.output))
    measures = options.measures(models_of(arguments))
    answers = [Path(name) for name in arguments.study_results or ()]
    found = measured(subjects, measures, folder, answers, fail, show)
    _show(arguments, found)
    return 1 if failed or found.failures else 0


def _checked(arguments: argparse.Namespace) -> MetricOptions:
    """What is to be measured; raises UsageError for what makes no sense, whatever the scenes."""
    if not arguments.files and not arguments.study_results:
        raise UsageError("value", "name the programs to evaluate, or `--study-results`")
    if arguments.study is not None and Path(arguments.study).suffix.lower() not in (".html", ".htm"):
        raise UsageError("backend", f"`{arguments.study}` is no .html file")
    if arguments.study is not None and (arguments.study_results or not arguments.files):
        raise UsageError("value", "`--study` wants programs or films, and comes before `--study-results`")
    options = fields_of(
        arguments, MetricOptions, seed=arguments.seed, limit=session_limit(arguments), warn=warnings(arguments)
    )
    options.check()
    return options


def _opened(arguments: argparse.Namespace, entry: EvaluationEntry, failed: list[str]) -> Opened | None:
    """The scene of an entry and its text; None where the program is wrong, which is told and added to ``failed``."""
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
    """The tables, or all that is known as JSON."""
    tables = found.tables
    if arguments.json:
        told = [asdict(record) for record in found.records]
        print_json({"tables": [as_data(t) for t in tables], "records": told, "left_out": list(found.left_out)})
        return
    say("\n\n".join(LAYOUTS[arguments.layout](each) for each in tables))
    if not tables:
        print("nothing was measured", file=sys.stderr)

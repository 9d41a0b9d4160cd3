"""The command eval: metrics of scenes in the paper's tables, and its user study."""

from __future__ import annotations

import argparse
import sys
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.cli.neural import add_models, models_of
from scenelang.cli.options import UsageError, add_common, evaluated_text, picture_size, session_limit, whole
from scenelang.cli.output import check_folder, deliver, done, print_json, progress, report, say, table, warnings
from scenelang.grammar.diagnostics import SceneError

if TYPE_CHECKING:
    from scenelang.evaluation.running import EvaluationEntry, Measure, Subject
    from scenelang.evaluation.study import Preferences
    from scenelang.evaluation.subjects import MetricOptions, MetricReport, Opened
    from scenelang.evaluation.tables import ResultTable


def add_eval(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "files", metavar="FILE", nargs="*",
        help='programs, or a JSON list of {"scene" or "film": FILE, "prompt": TEXT, "method": NAME, "image": FILE, '
        '"count": {WORD: N}, "distilled": DIR}',
    )  # fmt: skip
    parser.add_argument("-o", "--output", metavar="DIR", help="keep results here, and go on with those that are there")
    parser.add_argument(
        "--metric", default="clip,lpips,count,dynamic", metavar="NAME,...", help="clip, lpips, count, dynamic (all)"
    )
    group = parser.add_argument_group("drawing")
    group.add_argument("--backend", default="draft", metavar="NAME,...", help="draft (the default), final, splats")
    group.add_argument("--size", type=picture_size, default=(512, 512), metavar="WxH", help="pixels (default 512x512)")
    group.add_argument("--environment", default="studio", metavar="NAME", help="the light, as in `render`")
    group.add_argument("--clip-views", type=whole, default=120, metavar="N", help="views for CLIP (120)")
    group.add_argument("--lpips-views", type=whole, default=20, metavar="N", help="views for LPIPS (20)")
    group.add_argument("--fps", type=float, default=24.0, metavar="X", help="frames of 4D scenes per second (24)")
    group.add_argument("--clip-model", metavar="NAME", help="architecture/weights of OpenCLIP, or a folder")
    layout = parser.add_mutually_exclusive_group()
    layout.add_argument("--markdown", dest="layout", action="store_const", const="markdown", help="tables as Markdown")
    layout.add_argument("--latex", dest="layout", action="store_const", const="latex", help="tables for LaTeX")
    study = parser.add_argument_group("user study")
    study.add_argument("--study", metavar="PAGE", help="write a page that asks which result fits its text best: .html")
    study.add_argument(
        "--study-results", nargs="+", metavar="ANSWERS", help="what files of answers say, also in the tables"
    )
    add_models(parser)
    add_common(parser)
    parser.set_defaults(run=evaluate, layout="text")


def evaluate(arguments: argparse.Namespace) -> int:
    from scenelang.backends.files import made_folder
    from scenelang.evaluation.running import entries_of
    from scenelang.evaluation.study import preferences
    from scenelang.evaluation.subjects import measured, study_of, subjects_of

    options = _checked(arguments)
    if not arguments.files:
        return _answered(arguments, preferences([Path(name) for name in arguments.study_results]))
    drawings = options.drawings()
    failed: list[str] = []
    subjects = subjects_of(entries_of(arguments.files), drawings, lambda entry: _opened(arguments, entry, failed))
    if arguments.study is not None:
        check_folder(Path(arguments.study))
        told = list(subjects)
        if failed:
            return 1
        page = study_of(told, arguments.seed, lambda each: progress(arguments, f"drawing {each.entry.place}"))
        deliver(arguments, page, arguments.study)
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
    from scenelang.evaluation.subjects import MetricOptions

    if not arguments.files and not arguments.study_results:
        raise UsageError("value", "name the programs to evaluate, or `--study-results`")
    if arguments.study is not None and Path(arguments.study).suffix.lower() not in (".html", ".htm"):
        raise UsageError("backend", f"`{arguments.study}` is no .html file")
    if arguments.study is not None and (arguments.study_results or not arguments.files):
        raise UsageError("value", "`--study` wants programs or films, and comes before `--study-results`")
    options = MetricOptions(
        tuple(name.strip() for name in arguments.metric.split(",")),
        tuple(name.strip() for name in arguments.backend.split(",")),
        arguments.size, arguments.environment, arguments.clip_views, arguments.lpips_views, arguments.fps,
        arguments.clip_model, arguments.seed, session_limit(arguments), warnings(arguments),
    )  # fmt: skip
    options.check()
    return options


def _opened(arguments: argparse.Namespace, entry: EvaluationEntry, failed: list[str]) -> Opened | None:
    """The scene of an entry and its text; None where the program is wrong, which is told and added to ``failed``."""
    own = argparse.Namespace(**{**vars(arguments), "file": str(entry.scene)})
    try:
        result, text = evaluated_text(own)
    except SceneError as error:
        report(arguments, [error.diagnostic])
    else:
        if result.scene is not None:
            return result.scene, text
    failed.append(entry.place)
    return None


def _show(arguments: argparse.Namespace, found: MetricReport) -> None:
    """The tables, or all that is known as JSON."""
    from scenelang.evaluation.tables import as_data

    tables = found.tables
    if arguments.json:
        told = [asdict(record) for record in found.records]
        print_json({"tables": [as_data(t) for t in tables], "records": told, "left_out": list(found.left_out)})
        return
    say("\n\n".join(_written(each, arguments.layout) for each in tables))
    if not tables:
        print("nothing was measured", file=sys.stderr)


def _written(each: ResultTable, layout: str) -> str:
    from scenelang.evaluation.tables import as_latex, as_markdown, as_text

    return {"text": as_text, "markdown": as_markdown, "latex": as_latex}[layout](each)


def _answered(arguments: argparse.Namespace, found: Preferences) -> int:
    """Print what the files of answers amount to."""
    methods = found.methods
    if arguments.json:
        means = {method: dict(zip(("mean", "deviation"), found.of(method), strict=True)) for method in methods}
        prompts = [{"prompt": prompt, "percentages": dict(p)} for prompt, p in found.percentages.items()]
        print_json({"participants": found.participants, "methods": means, "prompts": prompts})
        return 0
    rows = [("preferred, %", *methods)]
    for prompt, shares in found.percentages.items():
        cells = (f"{shares[method]:.2f}" if method in shares else "-" for method in methods)
        rows.append((prompt if len(prompt) <= 60 else f"{prompt[:57]}...", *cells))
    rows.append(("all", *("{:.2f} ± {:.2f}".format(*found.of(method)) for method in methods)))
    say(table(rows, (False, *(True for _ in methods))))
    say(f"{found.participants:,} {'participant' if found.participants == 1 else 'participants'}")
    return 0

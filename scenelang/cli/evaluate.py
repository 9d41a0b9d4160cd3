"""The command eval: metrics of scenes in the paper's tables, and its user study."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.cli.neural_options import add_models, device_of, shelf_of
from scenelang.cli.neural_scene import folder_of
from scenelang.cli.options import UsageError, add_common, session_of, usage_errors, whole
from scenelang.cli.output import print_json, progress, report, report_run, say, warnings
from scenelang.cli.pictures import picture_size
from scenelang.cli.programs import session_limit
from scenelang.cli.study import alignment, answered, make_study
from scenelang.grammar.diagnostics import SceneError, suggest

if TYPE_CHECKING:
    from scenelang.backends.pictures.film import PictureOptions
    from scenelang.evaluation.running import Drawing, Evaluation, EvaluationEntry, Measure, MetricRecord, Subject
    from scenelang.evaluation.tables import ResultTable
    from scenelang.interpreter.scene.entity import Scene

_SIZE = (512, 512)
_NEURAL = ("clip", "lpips", "dynamic")
_MOST_VIEWS = 10_000


def add_eval(subparsers: Any) -> None:
    parser = subparsers.add_parser("eval", help="metrics of scenes in the paper's tables, and its user study")
    parser.add_argument(
        "files", metavar="FILE", nargs="*",
        help='programs, or a JSON list of {"scene" or "film": FILE, "prompt": TEXT, "method": NAME, "image": FILE, '
        '"count": {WORD: N}, "distilled": DIR}',
    )  # fmt: skip
    parser.add_argument("-o", "--output", metavar="DIR", help="keep results here, and go on with those that are there")
    parser.add_argument(
        "--metric", default="clip,lpips,count,dynamic", metavar="NAME,...", help="clip, lpips, count, dynamic (all)"
    )
    _add_drawing(parser.add_argument_group("drawing"))
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


def _add_drawing(group: Any) -> None:
    group.add_argument("--backend", default="draft", metavar="NAME,...", help="draft (the default), final, splats")
    group.add_argument("--size", type=picture_size, default=_SIZE, metavar="WxH", help="pixels (default 512x512)")
    group.add_argument("--environment", default="studio", metavar="NAME", help="the light, as in `render`")
    group.add_argument("--clip-views", type=whole, default=120, metavar="N", help="views for CLIP (120)")
    group.add_argument("--lpips-views", type=whole, default=20, metavar="N", help="views for LPIPS (20)")
    group.add_argument("--fps", type=float, default=24.0, metavar="X", help="frames of 4D scenes per second (24)")
    group.add_argument("--clip-model", metavar="NAME", help="architecture/weights of OpenCLIP, or a folder")


def evaluate(arguments: argparse.Namespace) -> int:
    from scenelang.evaluation.running import entries_of

    names = _checked(arguments)
    if not arguments.files:
        return answered(arguments)
    drawings = _drawings(arguments)
    entries = entries_of(arguments.files)
    if arguments.study is not None:
        failed: list[str] = []
        subjects = list(_subjects(arguments, entries, drawings, failed))
        if not failed:
            make_study(arguments, subjects, Path(arguments.study))
        return 1 if failed else 0
    return _measure(arguments, entries, drawings, names)


def _checked(arguments: argparse.Namespace) -> list[str]:
    """The names of the metrics; raises UsageError for what makes no sense, whatever the scenes."""
    from scenelang.backends.pictures.film import HIGHEST_FPS
    from scenelang.evaluation.running import METRICS

    if not arguments.files and not arguments.study_results:
        raise UsageError("value", "name the programs to evaluate, or `--study-results`")
    if arguments.study is not None and Path(arguments.study).suffix.lower() not in (".html", ".htm"):
        raise UsageError("backend", f"`{arguments.study}` is no .html file")
    if arguments.study is not None and (arguments.study_results or not arguments.files):
        raise UsageError("value", "`--study` wants programs or films, and comes before `--study-results`")
    names = [name.strip() for name in arguments.metric.split(",")]
    for name in names:
        if name not in METRICS:
            raise UsageError("value", f"there is no metric `{name}`", suggest(name, METRICS) or ", ".join(METRICS))
    for option, count in (("--clip-views", arguments.clip_views), ("--lpips-views", arguments.lpips_views)):
        if not 1 <= count <= _MOST_VIEWS:
            raise UsageError("value", f"`{option}` must be 1 to {_MOST_VIEWS:,}, not {count:,}")
    if not 0.0 < arguments.fps <= HIGHEST_FPS:
        raise UsageError("value", f"`--fps` must be above 0 and up to {HIGHEST_FPS:g}, not {arguments.fps:g}")
    return list(dict.fromkeys(names))


# --- subjects --------------------------------------------------------------------------------------------------------


def _drawings(arguments: argparse.Namespace) -> list[Drawing]:
    """One for each backend; raises UsageError for options that make no sense."""
    from scenelang.backends.pictures.film import PictureOptions, check, picture_backend
    from scenelang.evaluation.running import Drawing

    width, height = arguments.size
    options = PictureOptions(
        limit=session_limit(arguments), warn=warnings(arguments), width=width, height=height,
        environment=arguments.environment, seed=arguments.seed, labels=False,
    )  # fmt: skip
    names = list(dict.fromkeys(name.strip() for name in arguments.backend.split(",")))
    with usage_errors():
        check(options, [picture_backend(name) for name in names])
    return [Drawing(name, options, arguments.fps) for name in names]


def _subjects(
    arguments: argparse.Namespace, entries: list[EvaluationEntry], drawings: list[Drawing], failed: list[str]
) -> Iterator[Subject]:
    """Entries as scenes and films, one after the other; those that have none are told and added to ``failed``."""
    from scenelang.evaluation.running import Subject

    for entry in entries:
        if entry.scene is None:
            yield Subject(entry, entry.method or "film", entry.prompt, None, drawings[0])
            continue
        try:
            found = _evaluated(arguments, entry)
        except SceneError as error:
            report(arguments, [error.diagnostic])
            found = None
        if found is None:
            failed.append(entry.place)
            continue
        scene, prompt = found
        for drawing in drawings:
            yield Subject(entry, _method(entry, drawing, drawings), prompt, scene, _own(entry, drawing))


def _evaluated(arguments: argparse.Namespace, entry: EvaluationEntry) -> tuple[Scene, str] | None:
    """The scene of an entry and the text that it was made for; None where the program is wrong, which is told."""
    from scenelang.backends.neural.describing import thing
    from scenelang.primer import stated_task

    own = argparse.Namespace(**{**vars(arguments), "file": str(entry.scene)})
    session = session_of(own)
    source = session.source(own.file)
    result = session.evaluate(source)
    report_run(own, result)
    if result.scene is None:
        return None
    return result.scene, entry.prompt or stated_task(source.text) or thing(result.scene.root)


def _method(entry: EvaluationEntry, drawing: Drawing, drawings: list[Drawing]) -> str:
    """What made a scene: the entry's own name for it, the backend's where there is none or several draw."""
    if entry.method is None:
        return drawing.backend
    return entry.method if len(drawings) == 1 else f"{entry.method}, {drawing.backend}"


def _own(entry: EvaluationEntry, drawing: Drawing) -> Drawing:
    """The drawing with what the entry itself says: a distilled scene is drawn by Gaussians."""
    if entry.distilled is None:
        return drawing
    options: PictureOptions = replace(drawing.options, settings={"distilled": str(entry.distilled)})
    return replace(drawing, backend="splats", options=options)


# --- metrics ---------------------------------------------------------------------------------------------------------


def _measure(
    arguments: argparse.Namespace, entries: list[EvaluationEntry], drawings: list[Drawing], names: list[str]
) -> int:
    from scenelang.evaluation.running import Evaluation, Results, Tellers, read_results, write_results

    folder = None if arguments.output is None else folder_of(arguments.output)
    answers = alignment(arguments)  # read first, so that typos are cheap
    evaluation = Evaluation(Results() if folder is None else read_results(folder))
    measures = _measures(arguments, names)

    def fail(error: SceneError, about: str) -> None:
        report(arguments, [replace(error.diagnostic, message=f"{about}: {error.message}")])

    def show(subject: Subject, measure: Measure) -> Any:
        return progress(arguments, f"{subject.entry.place} {measure.name}")

    keep = (lambda _: None) if folder is None else (lambda results: write_results(folder, results))
    failed: list[str] = []
    evaluation.measure(_subjects(arguments, entries, drawings, failed), measures, Tellers(keep, fail, show))
    _show(arguments, [*evaluation.records, *answers(evaluation.records)], evaluation)
    return 1 if failed or evaluation.failures else 0


def _measures(arguments: argparse.Namespace, names: list[str]) -> list[Measure]:
    from scenelang.backends.neural.clip import JUDGE, ClipName
    from scenelang.evaluation.running import Models, measure_called

    device = _device(arguments) if any(name in _NEURAL for name in names) else "cpu"
    judge = ClipName.parse(arguments.clip_model) if arguments.clip_model else JUDGE
    models = Models(shelf_of(arguments), device, judge)
    views = {"clip": arguments.clip_views, "lpips": arguments.lpips_views}
    return [measure_called(name, models, views) for name in names]


def _device(arguments: argparse.Namespace) -> str:
    """What computes; without torch any metric that needs it says so itself."""
    try:
        return device_of(arguments)
    except SceneError as error:
        if error.name != "backend":
            raise
        return "cpu"


def _show(arguments: argparse.Namespace, records: list[MetricRecord], evaluation: Evaluation) -> None:
    """The tables, or all that is known as JSON."""
    from scenelang.evaluation.tables import as_data, tables_of

    tables = tables_of(records)
    if arguments.json:
        left_out = sorted(evaluation.left_out)
        told = [asdict(record) for record in records]
        print_json({"tables": [as_data(table) for table in tables], "records": told, "left_out": left_out})
        return
    say("\n\n".join(_written(table, arguments.layout) for table in tables))
    if not tables:
        print("nothing was measured", file=sys.stderr)


def _written(table: ResultTable, layout: str) -> str:
    from scenelang.evaluation.tables import as_latex, as_markdown, as_text

    return {"text": as_text, "markdown": as_markdown, "latex": as_latex}[layout](table)


COMMANDS = (add_eval,)

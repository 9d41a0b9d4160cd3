"""Commands that describe scenes in words and measure what models make of them: embed, eval."""

from __future__ import annotations

import argparse
import sys
from contextlib import nullcontext
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.backends.files import new_folder
from scenelang.backends.neural.wording import DEFAULT_LIMIT, DEFAULT_TEMPLATE, check_template
from scenelang.cli.neural import z_of
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
    scene_of,
    session_limit,
    usage_errors,
    warnings,
    z_path,
)
from scenelang.console.reports import deliver, print_json, say
from scenelang.evaluation.running import entries_of
from scenelang.evaluation.study import preferences
from scenelang.evaluation.subjects import MetricOptions, measured, study_of, subjects_of
from scenelang.evaluation.tables import LAYOUTS, as_data
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.settings import settings_in
from scenelang.interpreter.loading import is_present
from scenelang.learning.embeddings import Embeddings, check_program, wording_table

if TYPE_CHECKING:
    from scenelang.evaluation.running import EvaluationEntry, Measure, Subject
    from scenelang.evaluation.subjects import MetricReport, Opened
    from scenelang.inference.conductor import Describer


def add_embed(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``embed``."""
    parser.description = (
        "Describe the color, material, proportions and other attributes of every primitive in words, and store "
        "the texts and their prompt templates in the embeddings file beside the program."
    )
    parser.add_argument(
        "--template", metavar="TEXT",
        help="prompt template of a primitive; {embedding}, {word} and {style} are its handle, its word and the "
        "root's handle (default: a {embedding} {word}, in the style of {style}, 3D model)",
    )  # fmt: skip
    words = "let a language model choose the words (default: a fixed table)"
    parser.add_argument("--model", nargs="?", const="", metavar="NAME", help=words)
    if is_present("scenelang.inference"):
        from scenelang.cli.models import add_spending

        add_spending(parser)
    parser.add_argument("--force", action="store_true", help="overwrite existing descriptions")
    parser.add_argument(
        "--print", action="store_true", dest="only_print", help="print the descriptions without writing them"
    )


def run_embed(arguments: argparse.Namespace) -> int:
    """Describe the primitives of a scene in words, and store or print them."""
    with usage_errors():
        check_template(DEFAULT_TEMPLATE if arguments.template is None else arguments.template)
    if not arguments.only_print and arguments.file != "-":
        check_program(arguments.file, "embed the source program instead, or use --print")
    if not arguments.only_print and z_path(arguments) is None and arguments.file == "-":
        raise UsageError(
            "file", "a program from standard input requires --z FILE", "or use --print to only show the words"
        )
    z = Embeddings(z_path(arguments)) if arguments.only_print else z_of(arguments)
    scene = scene_of(arguments, fresh=not arguments.only_print and not z.exists)
    if arguments.model is not None and not arguments.force:
        with usage_errors():
            z.check_undescribed()
    describe = None if arguments.model is None else _describer(arguments)
    work = z.words_of if arguments.only_print else z.describe
    limit = int(arguments.max_primitives or DEFAULT_LIMIT)
    described = work(scene, template=arguments.template, describe=describe, force=arguments.force, limit=limit)
    if arguments.json:
        print_json(described.data())
    elif arguments.only_print:
        say(wording_table(described.wording))
    elif not arguments.quiet:
        before = f"; {described.known:,} already described (--force overwrites them)" if described.known else ""
        say(f"wrote {z.path}: {described}{before}")
    if describe is not None and not arguments.quiet:
        print(f"language model cost: ${describe.spent:.4f}", file=sys.stderr)
    return 0


def _describer(arguments: argparse.Namespace) -> Describer:
    """Return the function that lets a language model describe primitives."""
    from scenelang.cli.models import live_stream, service_of
    from scenelang.inference.generation import describer

    return describer(service_of(arguments), live_stream(arguments))


# The command `eval`: metrics in the layout of the tables of the paper, and its user study.


def add_eval(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``eval``."""
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
    """Measure scenes, evaluate a user study, or write its questionnaire."""
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
            evaluated_subjects, arguments.seed, lambda subject: progress(arguments, f"drawing {subject.entry.place}")
        )
        deliver(page, arguments.study)
        done(arguments, Path(arguments.study))
        return 0

    def fail(error: SceneError, about: str) -> None:
        """Report an error that concerns one measure or subject."""
        report(arguments, [replace(error.diagnostic, message=f"{about}: {error.message}")])

    def show(subject: Subject, measure: Measure) -> Any:
        """Return the progress line of a measure."""
        return progress(arguments, f"{subject.entry.place} {measure.name}")

    folder = None if arguments.output is None else Path(arguments.output)
    measures = options.measures(models_of(arguments))
    answers = [Path(name) for name in arguments.study_results or ()]
    with new_folder(folder) if folder is not None else nullcontext():
        metrics = measured(subjects, measures, folder, answers, fail, show)
    _show(arguments, metrics)
    return 1 if failed or metrics.failures else 0


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
    """Return scene and source text of an entry; None if the program has errors, which are reported and recorded."""
    entry_arguments = argparse.Namespace(**{**vars(arguments), "file": str(entry.scene)})
    try:
        result, source, _ = opened(entry_arguments)
    except SceneError as error:
        report(arguments, [error.diagnostic])
    else:
        if result.scene is not None:
            return result.scene, source.text
    failed.append(entry.place)
    return None


def _show(arguments: argparse.Namespace, metrics: MetricReport) -> None:
    """Print the tables, or all records as JSON."""
    tables = metrics.tables
    if arguments.json:
        records = [asdict(record) for record in metrics.records]
        print_json({"tables": [as_data(t) for t in tables], "records": records, "left_out": list(metrics.left_out)})
        return
    say("\n\n".join(LAYOUTS[arguments.layout](table) for table in tables))
    if not tables:
        print("nothing was measured", file=sys.stderr)

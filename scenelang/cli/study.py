"""The user study of the command eval: its page, and what the answers amount to."""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from scenelang.cli.output import print_json, progress, say, table
from scenelang.cli.pictures import check_folder, done
from scenelang.grammar.diagnostics import SceneError

if TYPE_CHECKING:
    from scenelang.backends.base import Progress
    from scenelang.evaluation.running import MetricRecord, Subject
    from scenelang.evaluation.study import Preferences, StudyResult

_TURN = 36  # pictures of a turntable on the page
_FPS = 12.0


# --- the page --------------------------------------------------------------------------------------------------------


def make_study(arguments: argparse.Namespace, subjects: Sequence[Subject], page: Path) -> None:
    """Write the page with a film of every subject; raises SceneError where one cannot be made."""
    from scenelang.backends.files import written_whole
    from scenelang.evaluation.study import StudyQuestion, questions_of, study_page

    check_folder(page)
    tasks: dict[str, list[StudyResult]] = {}
    for subject in subjects:
        if subject.prompt is None:
            raise SceneError("value", f"{subject.entry.place} is for no text", hint='its entry needs a "prompt"')
        shown = progress(arguments, f"drawing {subject.entry.place}")
        tasks.setdefault(subject.prompt, []).append(_result(subject, shown))
    questions = questions_of([StudyQuestion(prompt, tuple(found)) for prompt, found in tasks.items()], arguments.seed)
    text = study_page(questions)
    with written_whole(page) as temporary:
        temporary.write_text(text, "utf-8")
    done(arguments, page)


def _result(subject: Subject, shown: Progress | None) -> StudyResult:
    """The film of others as it is; of a scene a turn around it, or its frames."""
    from scenelang.backends.neural.metrics import around, read_film, steady
    from scenelang.backends.pictures.film import painters, picture_backend, save_film
    from scenelang.evaluation.study import StudyResult

    if subject.scene is None:
        assert subject.entry.film is not None
        read_film(subject.entry.film)  # so that the page has no file that is none
        return StudyResult(subject.method, subject.entry.film.read_bytes(), subject.entry.film.suffix.lower())
    scene, options, drawing = subject.scene, subject.drawing.options, subject.drawing
    width, height = options.width, options.height
    shots = steady(scene, width, height) if scene.animated else around(scene, _TURN, width, height)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "film.webp"
        drawers = painters(scene, options, [picture_backend(drawing.backend)], shots)
        save_film(drawers, shots, path, drawing.fps if scene.animated else _FPS, shown)
        return StudyResult(subject.method, path.read_bytes(), ".webp")


# --- answers ---------------------------------------------------------------------------------------------------------


def answered(arguments: argparse.Namespace) -> int:
    """Print what the files of answers amount to."""
    found = _preferences(arguments.study_results)
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


def alignment(arguments: argparse.Namespace) -> Callable[[Sequence[MetricRecord]], list[MetricRecord]]:
    """What gives the records of preference for the methods and prompts of other records; raises SceneError where the
    files of answers cannot be read."""
    from scenelang.evaluation.running import MetricRecord

    if not arguments.study_results:
        return lambda _: []
    found = _preferences(arguments.study_results)

    def records(others: Sequence[MetricRecord]) -> list[MetricRecord]:
        groups = {record.prompt: record.group for record in others if record.prompt is not None}
        return [
            MetricRecord("", method, "alignment", "", groups[prompt], prompt, {"value": percentage})
            for prompt, shares in found.percentages.items()
            for method, percentage in shares.items()
            if prompt in groups
        ]

    return records


def _preferences(names: Sequence[str]) -> Preferences:
    from scenelang.evaluation.study import preferences

    return preferences([Path(name) for name in names])

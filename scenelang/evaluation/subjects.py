"""Programs and films as subjects of an evaluation: ``scenelang.evaluate_metrics`` and the page of the user study."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

from scenelang.backends.base import Progress
from scenelang.backends.files import new_folder
from scenelang.backends.neural.clip import SCORE_MODEL, ClipName
from scenelang.backends.neural.descriptions import noun_of
from scenelang.backends.neural.weights import Models
from scenelang.backends.pictures.film import PictureOptions, check, picture_backend
from scenelang.evaluation.running import (
    METRICS,
    Callbacks,
    Drawing,
    Evaluation,
    EvaluationEntry,
    Measure,
    MetricModels,
    MetricRecord,
    Results,
    Subject,
    entries_of,
    measure_called,
    read_results,
    write_results,
)
from scenelang.evaluation.study import Preferences, StudyQuestion, StudyResult, preferences, questions_of, study_page
from scenelang.evaluation.tables import ResultTable, tables_of
from scenelang.grammar.datum import dataclass, field, replace
from scenelang.grammar.diagnostics import Diagnostic, SceneError, UsageError, suggest, usage_errors
from scenelang.grammar.settings import FRAME_RATES, frame_rate, names, picture_size, setting, typed, whole
from scenelang.interpreter.scene.entity import Scene
from scenelang.reference.primer import stated_task
from scenelang.session.session import Options, Session

if TYPE_CHECKING:
    from scenelang.backends.pictures.stage import Shot

_NEURAL = ("clip", "lpips", "dynamic")
_MAX_VIEWS = 10_000
_TURN = 36  # frames of a turntable on the study's page
_FPS = 12.0
Opened = tuple[Scene, str]  # scene and program text


@dataclass(frozen=True, slots=True)
class MetricOptions:
    """Metrics, and how scenes are rendered for them.

    ``metrics`` are names in METRICS; each of ``backends`` renders the scenes as a separate method; ``size`` is in
    pixels; ``clip_views`` and ``lpips_views`` are numbers of views around the scene, ``fps`` is the frame rate of 4D
    scenes, ``clip_model`` is an OpenCLIP model (architecture/weights, or a folder), ``limit`` is the maximum number of
    primitives.
    """

    metrics: tuple[str, ...] = setting(
        METRICS, "metrics: clip, lpips, count, dynamic (default all)", "--metric", metavar="NAME,...", read=names
    )
    backends: tuple[str, ...] = setting(
        ("draft",), "rendering backends: draft (default), final, splats", "--backend", metavar="NAME,...", read=names
    )
    size: tuple[int, int] = setting(
        (512, 512), "image size in pixels (default 512x512)", metavar="WxH", read=picture_size
    )
    environment: str = setting("studio", "environment light, as in `render`", metavar="NAME")
    clip_views: int = setting(120, "number of views for CLIP (default 120)", metavar="N", read=whole)
    lpips_views: int = setting(20, "number of views for LPIPS (default 20)", metavar="N", read=whole)
    fps: float = setting(24.0, "frame rate of 4D scenes (default 24)", metavar="X", read=frame_rate)
    clip_model: str | None = setting(None, "OpenCLIP model: architecture/weights, or a folder", metavar="NAME")
    seed: int = 0
    limit: int = 2_000_000
    warn: Callable[[Diagnostic], None] | None = None

    def check(self) -> None:
        """Check the options independently of scenes; raises UsageError."""
        for name in self.metrics:
            if name not in METRICS:
                raise UsageError("value", f"unknown metric `{name}`", suggest(name, METRICS) or ", ".join(METRICS))
        for option, count in (("--clip-views", self.clip_views), ("--lpips-views", self.lpips_views)):
            if not 1 <= count <= _MAX_VIEWS:
                raise UsageError("value", f"expected `{option}` between 1 and {_MAX_VIEWS:,}, got {count:,}")
        low, high = FRAME_RATES
        if not low <= self.fps <= high:
            raise UsageError("value", f"expected `--fps` from {low:g} to {high:g}, got {self.fps:g}")

    def drawings(self) -> list[Drawing]:
        """Return the rendering of each backend. Raises UsageError."""
        width, height = self.size
        options = PictureOptions(
            limit=self.limit, warn=self.warn, width=width, height=height, environment=self.environment,
            seed=self.seed, labels=False,
        )  # fmt: skip
        names = list(dict.fromkeys(self.backends))
        with usage_errors():
            check(options, [picture_backend(name) for name in names])
        return [Drawing(name, options, self.fps) for name in names]

    @typed
    def measures(self, models: Models | None = None) -> list[Measure]:
        """Create the metrics with their models."""
        models = models or Models()
        score_model = ClipName.parse(self.clip_model) if self.clip_model else SCORE_MODEL
        names = list(dict.fromkeys(self.metrics))
        device = _device(models) if any(name in _NEURAL for name in names) else "cpu"
        known = MetricModels(models.hub(), device, score_model)
        views = {"clip": self.clip_views, "lpips": self.lpips_views}
        return [measure_called(name, known, views) for name in names]


def _device(models: Models) -> str:
    """Return the compute device; without torch, the metrics that need it report that themselves."""
    try:
        return models.resolve_device()
    except SceneError as error:
        if error.name != "backend":
            raise
        return "cpu"


@dataclass(frozen=True, slots=True)
class MetricReport:
    """Result of an evaluation: one record per scene, method and metric; ``left_out`` are metrics with unavailable
    models, ``failures`` counts failed measurements."""

    records: tuple[MetricRecord, ...] = field(repr=False)
    left_out: tuple[str, ...] = ()
    failures: int = 0

    @property
    def tables(self) -> list[ResultTable]:
        """The paper's tables with these results added."""
        return tables_of(self.records)


# --- subjects --------------------------------------------------------------------------------------------------------


def subjects_of(
    entries: Iterable[EvaluationEntry],
    drawings: Sequence[Drawing],
    opened: Callable[[EvaluationEntry], Opened | None],
) -> Iterator[Subject]:
    """Yield entries as scenes and films in order; those for which ``opened`` returns None are skipped."""
    for entry in entries:
        if entry.scene is None:
            yield Subject(entry, entry.method or "film", entry.prompt, None, drawings[0])
            continue
        pair = opened(entry)
        if pair is None:
            continue
        scene, text = pair
        prompt = entry.prompt or stated_task(text) or noun_of(scene.root)
        for drawing in drawings:
            yield Subject(entry, _method(entry, drawing, drawings), prompt, scene, _own(entry, drawing))


def _method(entry: EvaluationEntry, drawing: Drawing, drawings: Sequence[Drawing]) -> str:
    """Return the method's name: that of the entry, or the backend's if there is none or several backends render."""
    if entry.method is None:
        return drawing.backend
    return entry.method if len(drawings) == 1 else f"{entry.method}, {drawing.backend}"


def _own(entry: EvaluationEntry, drawing: Drawing) -> Drawing:
    """Return the rendering of an entry: distilled scenes are rendered as Gaussians."""
    if entry.distilled is None:
        return drawing
    options = replace(drawing.options, settings={"distilled": str(entry.distilled)})
    return replace(drawing, backend="splats", options=options)


def _silent(subject: Subject, measure: Measure) -> None:
    """Show no progress."""


# --- metrics ---------------------------------------------------------------------------------------------------------


def measured(
    subjects: Iterable[Subject],
    measures: Sequence[Measure],
    folder: Path | None,
    answers: Sequence[Path] = (),
    fail: Callable[[SceneError, str], None] = lambda _, __: None,
    show: Callable[[Subject, Measure], Progress | None] = lambda _, __: None,
) -> MetricReport:
    """Measure the subjects in order; each result is stored in ``folder`` immediately. ``answers`` are files of a user
    study; ``fail`` is called with errors, ``show`` returns the progress callback of a measurement."""
    preferred = preferences(answers) if answers else None  # read first to fail early
    evaluation = Evaluation(Results() if folder is None else read_results(folder))
    keep = (lambda _: None) if folder is None else (lambda results: write_results(folder, results))
    evaluation.measure(subjects, measures, Callbacks(keep, fail, show))
    records = evaluation.records
    records = [*records, *(alignment(preferred, records) if preferred is not None else ())]
    return MetricReport(tuple(records), tuple(sorted(evaluation.left_out)), evaluation.failures)


def alignment(preferred: Preferences, others: Sequence[MetricRecord]) -> list[MetricRecord]:
    """Return preference records for the methods and prompts of other records."""
    groups = {record.prompt: record.group for record in others if record.prompt is not None}
    return [
        MetricRecord("", method, "alignment", "", groups[prompt], prompt, {"value": percentage})
        for prompt, shares in preferred.percentages.items()
        for method, percentage in shares.items()
        if prompt in groups
    ]


@typed
def evaluate_metrics(
    files: Sequence[str | Path],
    options: MetricOptions | None = None,
    *,
    evaluation: Options | None = None,
    folder: str | Path | None = None,
    answers: Sequence[str | Path] = (),
    models: Models | None = None,
    progress: Callable[[Subject, Measure], Progress | None] | None = None,
) -> MetricReport:
    """Measure scenes and films as the paper does: CLIP similarity, LPIPS between views, counts, dynamic degree.

    Parameters
    ----------
    files : sequence of path
        Programs, or JSON lists of programs and films with their prompts (docs/evaluation.md).
    options : MetricOptions, optional
        Metrics, and how scenes are rendered.
    evaluation : Options, optional
        Options for evaluating programs.
    folder : path, optional
        Results folder; results already in it are reused.
    answers : sequence of path
        Answer files of a user study, whose preferences are added to the tables.
    models : Models, optional
        Location of the weights, and compute device.
    progress : callable, optional
        Returns, for each measurement, a callback for a fraction from 0 to 1, or None.

    Raises
    ------
    UsageError
        If an option is invalid.
    SceneError
        If a program has errors, or a file cannot be read.

    Examples
    --------
    >>> report = evaluate_metrics(["examples/menger-sponge.scene"], MetricOptions(metrics=("count",)))
    >>> report.failures
    0
    """
    chosen = options or MetricOptions()
    chosen.check()
    drawings = chosen.drawings()
    session = Session(evaluation)

    def opened(entry: EvaluationEntry) -> Opened:
        source = session.source(str(entry.scene))
        return session.evaluate(source).require(), source.text

    measures = chosen.measures(models)
    subjects = subjects_of(entries_of([str(file) for file in files]), drawings, opened)
    results = Path(folder) if folder is not None else None
    with new_folder(results) if results is not None else nullcontext():
        return measured(subjects, measures, results, [Path(path) for path in answers], show=progress or _silent)


# --- the user study --------------------------------------------------------------------------------------------------


def study_of(
    subjects: Iterable[Subject], seed: int, progress: Callable[[Subject], Progress | None] = lambda _: None
) -> str:
    """Create the study's page, with a video of every subject; raises SceneError if one cannot be rendered."""
    tasks: dict[str, list[StudyResult]] = {}
    for subject in subjects:
        if subject.prompt is None:
            raise SceneError("value", f"{subject.entry.place} has no prompt", hint='add a "prompt" to its entry')
        tasks.setdefault(subject.prompt, []).append(_filmed(subject, progress(subject)))
    return study_page(questions_of([StudyQuestion(prompt, tuple(drawn)) for prompt, drawn in tasks.items()], seed))


def _filmed(subject: Subject, shown: Progress | None) -> StudyResult:
    """Return the video of a film entry unchanged, or render a turntable or the frames of a scene."""
    from scenelang.backends.neural.metrics import fixed_shots, read_film, turntable_shots
    from scenelang.backends.pictures.film import painters, save_film

    if subject.scene is None:
        assert subject.entry.film is not None
        read_film(subject.entry.film)  # checks that the file is valid
        return StudyResult(subject.method, subject.entry.film.read_bytes(), subject.entry.film.suffix.lower())
    scene, options, drawing = subject.scene, subject.drawing.options, subject.drawing
    width, height = options.width, options.height
    shots: list[Shot] = (
        fixed_shots(scene, width, height) if scene.animated else turntable_shots(scene, _TURN, width, height)
    )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "film.webp"
        drawers = painters(scene, options, [picture_backend(drawing.backend)], shots)
        save_film(drawers, shots, path, drawing.fps if scene.animated else _FPS, shown)
        return StudyResult(subject.method, path.read_bytes(), ".webp")

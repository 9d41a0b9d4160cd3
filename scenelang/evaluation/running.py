"""Measurement of all subjects with all metrics; each result is stored as soon as it is available."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from scenelang.backends.base import Progress
from scenelang.backends.files import read_regular, write_json
from scenelang.backends.neural.clip import SCORE_MODEL, ClipName
from scenelang.backends.neural.metrics import (
    ALEXNET,
    CLIP_VIEWS,
    ITERATIONS,
    LPIPS_VIEWS,
    RAFT_LARGE,
    ClipScore,
    CountQuery,
    Lpips,
    Raft,
    count_entities,
    count_queries,
    film_dynamic_degree,
    fixed_shots,
    is_accurate,
    parse_counts,
    read_film,
    render_shots,
    turntable_shots,
)
from scenelang.backends.neural.weights import ModelHub
from scenelang.backends.pictures.film import Picture, PictureOptions, open_image
from scenelang.grammar.diagnostics import SceneError, suggest
from scenelang.interpreter.runtime.show import primitive_attributes
from scenelang.interpreter.scene.entity import Scene, count_words
from scenelang.interpreter.scene.flatten import flatten

# Entries of an evaluation: programs, or a JSON list of programs and films with their prompts.


_MAX_LIST_BYTES, _MAX_ENTRIES, _MAX_LENGTH = 16_000_000, 10_000, 10_000
_KEYS = ("scene", "film", "prompt", "method", "image", "count", "distilled", "dynamic")


@dataclass(frozen=True, slots=True)
class EvaluationEntry:
    """A ``scene`` or a ``film`` to evaluate, with its ``prompt`` (None: the comment at the program's head).

    ``method`` is the name of the method (None: the rendering backend). ``image`` is the reference image, ``count`` the
    expected number of each word (None: parsed from the prompt), ``distilled`` the folder of a `distill` run;
    ``is_dynamic`` means that a film shows an animated scene rather than a turntable.
    """

    scene: Path | None = None
    film: Path | None = None
    prompt: str | None = None
    method: str | None = None
    image: Path | None = None
    count: tuple[tuple[str, int], ...] | None = None
    distilled: Path | None = None
    is_dynamic: bool = False

    @property
    def place(self) -> str:
        """File of the scene or film."""
        return str(self.scene or self.film)


def entries_of(files: Sequence[str]) -> list[EvaluationEntry]:
    """Convert programs and lists to entries without duplicates; raises SceneError: "file" for an unreadable list,
    "value" for an invalid entry."""
    entries = [entry for file in files for entry in _read(Path(file))]
    if len(entries) > _MAX_ENTRIES:
        raise SceneError("value", f"expected at most {_MAX_ENTRIES:,} scenes, got {len(entries):,}")
    return list(dict.fromkeys(entries))


def _read(path: Path) -> list[EvaluationEntry]:
    if path.suffix.lower() != ".json":
        return [EvaluationEntry(scene=path)]
    try:
        if path.stat().st_size > _MAX_LIST_BYTES:
            raise SceneError("file", f"{path} exceeds the maximum size of a list of scenes")
        data = json.loads(read_regular(path))
    except (OSError, ValueError, RecursionError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise SceneError("file", f"cannot read {path}: {reason}") from None
    if not isinstance(data, list):  # scenes may be JSON files, too
        return [EvaluationEntry(scene=path)]
    return [_entry(item, path, number) for number, item in enumerate(data, 1)]


def _entry(item: Any, path: Path, number: int) -> EvaluationEntry:
    where = f"{path}, entry {number}"
    if not isinstance(item, dict):
        raise SceneError("value", f'{where}: expected an object such as {{"scene": "a.scene", "prompt": "..."}}')
    for key in item:
        if key not in _KEYS:
            hint = suggest(key, _KEYS) or f"known keys: {', '.join(_KEYS)}"
            raise SceneError("value", f"{where}: unknown key `{key[:40]}`", hint=hint)
    if ("scene" in item) == ("film" in item):
        raise SceneError("value", f"{where}: expected either `scene` or `film`")
    is_dynamic = item.get("dynamic", False)
    if not isinstance(is_dynamic, bool):
        raise SceneError("value", f"{where}: `dynamic` must be true or false")
    texts = {key: _text(item, key, where) for key in ("scene", "film", "prompt", "method", "image", "distilled")}
    files = {key: _beside(path, texts[key]) for key in ("scene", "film", "image", "distilled")}
    return EvaluationEntry(
        **files, prompt=texts["prompt"], method=texts["method"], count=_counts(item.get("count"), where),
        is_dynamic=is_dynamic,
    )  # fmt: skip


def _text(item: Mapping[str, Any], key: str, where: str) -> str | None:
    value = item.get(key)
    if value is None:
        return None
    if not isinstance(value, str) or not value.strip() or len(value) > _MAX_LENGTH or "\0" in value:
        raise SceneError("value", f"{where}: `{key}` must be a string")
    return value if key in ("scene", "film", "image", "distilled") else " ".join(value.split())


def _beside(path: Path, name: str | None) -> Path | None:
    return None if name is None else path.parent / name


def _counts(value: Any, where: str) -> tuple[tuple[str, int], ...] | None:
    if value is None:
        return None
    if not isinstance(value, dict) or not all(type(count) is int and count >= 0 for count in value.values()):
        raise SceneError("value", f'{where}: `count` must be an object of integers, such as {{"can": 15}}')
    return tuple(value.items())


# Results file: one record per scene, method and metric, appended during the evaluation.


FILE = "results.json"
_FORMAT, _VERSION = "scenelang-evaluation", 1
_MAX_BYTES = 256_000_000

Key = tuple[str, str, str]


@dataclass(frozen=True, slots=True)
class MetricRecord:
    """One measurement: ``place`` is the scene's file, ``made`` the fingerprint of the inputs, ``group`` the group in
    the paper's tables, ``values`` the metric's result as JSON data."""

    place: str
    method: str
    metric: str
    made: str
    group: str
    prompt: str | None
    values: Mapping[str, Any]

    @property
    def key(self) -> Key:
        return self.place, self.method, self.metric

    @property
    def value(self) -> float:
        return float(self.values["value"])


@dataclass(frozen=True, slots=True)
class Results:
    """Records by scene, method and metric."""

    records: Mapping[Key, MetricRecord] = field(default_factory=dict)

    def known(self, key: Key, made: str) -> MetricRecord | None:
        """Return the record of this measurement, or None if it is missing or outdated."""
        record = self.records.get(key)
        return record if record is not None and record.made == made else None

    def and_also(self, record: MetricRecord) -> Results:
        """Return the results with one record added or replaced."""
        return Results({**self.records, record.key: record})


def read_results(folder: Path) -> Results:
    """Read the results in ``folder``, empty if there are none; raises SceneError("file") for an invalid file."""
    path = folder / FILE
    try:
        if not path.exists():
            return Results()
        if path.stat().st_size > _MAX_BYTES:
            raise ValueError("file too large")
        data = json.loads(path.read_text("utf-8"))
        if data["format"] != _FORMAT:
            raise ValueError("not a results file")
        if data["version"] != _VERSION:
            raise ValueError(f"unsupported version {str(data['version'])[:20]}; expected {_VERSION}")
        records = [_record(item) for item in data["records"]]
    except KeyError as error:
        raise _damaged(path, f"missing {error}") from None
    except (OSError, ValueError, TypeError, AttributeError, RecursionError) as error:
        raise _damaged(path, str(error)[:120]) from None
    return Results({record.key: record for record in records})


def write_results(folder: Path, results: Results) -> None:
    """Write the results atomically; raises SceneError("file")."""
    records = [asdict(record) for record in results.records.values()]
    write_json(folder / FILE, {"format": _FORMAT, "version": _VERSION, "records": records})


def _record(item: Any) -> MetricRecord:
    record = MetricRecord(**item)
    texts = (record.place, record.method, record.metric, record.made, record.group, record.prompt or "")
    if not all(isinstance(text, str) for text in texts) or not math.isfinite(record.value):
        raise ValueError("malformed record")
    return record


def _damaged(path: Path, reason: str) -> SceneError:
    hint = "move it away, or choose another folder with -o"
    return SceneError("file", f"cannot read the results in {path}: {reason}", hint=hint)


# Subjects: a scene rendered by a backend, or a film, with its prompt.


NUMERIC, GENERIC, DYNAMIC = "numeric", "generic", "4d"  # the paper's groups of tasks


@dataclass(frozen=True, slots=True)
class Drawing:
    """Rendering of scenes: backend and ``options``; ``fps`` is the frame rate of 4D scenes."""

    backend: str
    options: PictureOptions
    fps: float


@dataclass(frozen=True, slots=True, eq=False)
class Subject:
    """A subject of evaluation. ``scene`` is None for a film, ``prompt`` if unknown."""

    entry: EvaluationEntry
    method: str
    prompt: str | None
    scene: Scene | None
    drawing: Drawing

    @property
    def expected_counts(self) -> tuple[CountQuery, ...]:
        """Expected counts."""
        if self.entry.count is not None:
            return count_queries(dict(self.entry.count))
        return parse_counts(self.prompt or "")

    @property
    def is_dynamic(self) -> bool:
        return self.entry.is_dynamic if self.scene is None else self.scene.animated

    @property
    def group(self) -> str:
        """Group of the subject in the paper's tables."""
        return DYNAMIC if self.is_dynamic else NUMERIC if self.expected_counts else GENERIC

    def around(self, count: int, progress: Progress | None = None) -> list[Picture]:
        """Render ``count`` views around the scene, or sample at most as many frames of a film; raises SceneError."""
        if self.scene is None:
            pictures = self._film()
            least = min(count, len(pictures))
            return [pictures[i * len(pictures) // least] for i in range(least)]
        options = self.drawing.options
        shots = turntable_shots(self.scene, count, options.width, options.height)
        return render_shots(self.scene, shots, options, self.drawing.backend, progress)

    def steady(self, progress: Progress | None = None) -> list[Picture]:
        """Render every frame from a fixed camera; raises SceneError."""
        if self.scene is None:
            return self._film()
        options = self.drawing.options
        shots = fixed_shots(self.scene, options.width, options.height)
        return render_shots(self.scene, shots, options, self.drawing.backend, progress)

    def fingerprint(self, asks: Mapping[str, Any]) -> str:
        """Return the fingerprint of a measurement: evaluated scene, prompt, rendering, and the metric's parameters
        ``asks``; raises SceneError."""
        options = self.drawing.options
        inputs = {
            "content": self._content(),
            "prompt": self.prompt,
            "backend": None if self.scene is None else self.drawing.backend,
            "size": None if self.scene is None else [options.width, options.height],
            "environment": [options.environment, options.ground, options.seed],
            "settings": {key: str(value) for key, value in sorted(options.settings.items()) if value is not None},
            "image": None if self.entry.image is None else file_digest(self.entry.image),
            "asks": dict(asks),
        }
        return hashlib.sha256(json.dumps(inputs, sort_keys=True).encode()).hexdigest()

    def _content(self) -> str:
        if self.scene is None:
            assert self.entry.film is not None
            return file_digest(self.entry.film)
        content = scene_digest(self.scene, self.drawing.options.limit)
        run = self.entry.distilled
        return content if run is None else f"{content} {file_digest(run / 'state.safetensors')}"

    def _film(self) -> list[Picture]:
        assert self.entry.film is not None
        return read_film(self.entry.film)


def scene_digest(scene: Scene, limit: int) -> str:
    """Return a hash of everything that determines images and counts of a scene; raises SceneError for too many
    primitives."""
    digest = hashlib.sha256()
    for frame in flatten(scene, limit).frames:
        for array in (frame.index, frame.matrices):
            digest.update(array.tobytes())
        for entity in frame.primitives:
            digest.update(repr((entity.word, sorted(primitive_attributes(entity).items()))).encode())
    for root in scene.frames:
        digest.update(repr(sorted(count_words(root).items())).encode())
    return digest.hexdigest()


def file_digest(path: Path) -> str:
    """Return the hash of a file; raises SceneError("file")."""
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise SceneError("file", f"cannot read {path}: {error.strerror or error}") from None


# Metrics as measurements of subjects.


METRICS = ("clip", "lpips", "count", "dynamic")
Values = dict[str, Any]


class Measure(Protocol):
    """A metric; its model is loaded by ``ready``."""

    @property
    def name(self) -> str: ...

    def asks(self, subject: Subject) -> Values | None:
        """Return the parameters that determine the result besides the subject, or None if the metric does not apply."""

    def ready(self) -> None:
        """Load the required models; raises SceneError if they are unavailable."""

    def measure(self, subject: Subject, progress: Progress | None) -> Values:
        """Return the result as JSON data; ``value`` is shown in tables. Raises SceneError."""


@dataclass(frozen=True, slots=True)
class MetricModels:
    """Location of the models and compute device; ``score_model`` is the model for CLIP similarity."""

    hub: ModelHub
    device: str = "cpu"
    score_model: ClipName = SCORE_MODEL


class ClipMeasure:
    """Mean cosine similarity of the prompt and the rendered views (paper, section 6)."""

    name = "clip"

    def __init__(self, models: MetricModels, views: int = CLIP_VIEWS) -> None:
        self._models, self._views = models, views
        self._scorer: ClipScore | None = None

    def asks(self, subject: Subject) -> Values | None:
        return None if subject.prompt is None else {"model": str(self._models.score_model), "views": self._views}

    def ready(self) -> None:
        if self._scorer is None:
            self._scorer = ClipScore(self._models.score_model, self._models.hub, self._models.device)

    def measure(self, subject: Subject, progress: Progress | None) -> Values:
        assert self._scorer is not None
        assert subject.prompt is not None
        return _mean(self._scorer.cosines(subject.prompt, subject.around(self._views, progress)))


class LpipsMeasure:
    """Mean LPIPS distance of the rendered views from the reference image."""

    name = "lpips"

    def __init__(self, models: MetricModels, views: int = LPIPS_VIEWS) -> None:
        self._models, self._views = models, views
        self._network: Lpips | None = None

    def asks(self, subject: Subject) -> Values | None:
        return None if subject.entry.image is None else {"model": ALEXNET.file, "views": self._views}

    def ready(self) -> None:
        if self._network is None:
            self._network = Lpips(self._models.hub, self._models.device)

    def measure(self, subject: Subject, progress: Progress | None) -> Values:
        assert self._network is not None
        assert subject.entry.image is not None
        reference = np.asarray(open_image(subject.entry.image), np.uint8)
        return _mean(self._network.distances(reference, subject.around(self._views, progress)))


class CountMeasure:
    """Count accuracy: 1 if all counts equal the expected ones, else 0."""

    name = "count"

    def asks(self, subject: Subject) -> Values | None:
        if subject.scene is None or not subject.expected_counts:
            return None
        return {"counts": [[" ".join(one.words), one.count] for one in subject.expected_counts]}

    def ready(self) -> None:
        """Do nothing, since no model is required."""

    def measure(self, subject: Subject, progress: Progress | None) -> Values:
        assert subject.scene is not None
        counts = count_entities(subject.scene, subject.expected_counts)
        things = [
            {"asked": " ".join(one.query.words), "count": one.query.count, "words": list(one.words), "found": one.found}
            for one in counts
        ]
        return {"value": float(is_accurate(counts)), "things": things}


class DynamicMeasure:
    """Dynamic degree of a 4D scene from optical flow; ``value`` is relative to the image size."""

    name = "dynamic"

    def __init__(self, models: MetricModels) -> None:
        self._models = models
        self._network: Raft | None = None

    def asks(self, subject: Subject) -> Values | None:
        if not subject.is_dynamic:
            return None
        return {"model": RAFT_LARGE.file, "iterations": ITERATIONS, "fps": subject.drawing.fps}

    def ready(self) -> None:
        if self._network is None:
            self._network = Raft(self._models.hub, self._models.device)

    def measure(self, subject: Subject, progress: Progress | None) -> Values:
        assert self._network is not None
        degree = film_dynamic_degree(subject.steady(progress), subject.drawing.fps, self._network.flow)
        return {"value": degree.relative, "pixels": degree.pixels, "is_dynamic": degree.is_dynamic}


def measure_called(name: str, models: MetricModels, views: Mapping[str, int]) -> Measure:
    """Create the metric ``name``, one of METRICS; ``views`` sets the number of views for "clip" and "lpips"."""
    if name == "clip":
        return ClipMeasure(models, views.get(name, CLIP_VIEWS))
    if name == "lpips":
        return LpipsMeasure(models, views.get(name, LPIPS_VIEWS))
    return CountMeasure() if name == "count" else DynamicMeasure(models)


def _mean(numbers: list[float]) -> Values:
    return {"value": float(np.mean(numbers)), "views": numbers}


_ABSENT = ("weights", "backend")  # errors of a metric's requirements, not of a scene


@dataclass(frozen=True, slots=True)
class Callbacks:
    """Callbacks of an evaluation: ``keep`` each state of the results, ``fail`` each error with its context, ``show``
    the progress of a measurement."""

    keep: Callable[[Results], None] = lambda _: None
    fail: Callable[[SceneError, str], None] = lambda _, __: None
    show: Callable[[Subject, Measure], Progress | None] = lambda _, __: None


@dataclass(slots=True)
class Evaluation:
    """``records`` are those of this evaluation, in order; ``results`` also contains those read from the file."""

    results: Results
    records: list[MetricRecord] = field(default_factory=list)
    left_out: set[str] = field(default_factory=set)
    failures: int = 0

    def measure(self, subjects: Iterable[Subject], measures: Sequence[Measure], callbacks: Callbacks) -> None:
        """Measure everything that is not stored yet. Unavailable metrics and scenes that cannot be rendered are skipped
        and reported."""
        for subject in subjects:
            for measure in measures:
                if measure.name in self.left_out:
                    continue
                try:
                    self._one(subject, measure, callbacks)
                except SceneError as error:
                    self.failures += 1
                    callbacks.fail(error, subject.entry.place)

    def _one(self, subject: Subject, measure: Measure, callbacks: Callbacks) -> None:
        asks = measure.asks(subject)
        if asks is None:
            return
        key = (subject.entry.place, subject.method, measure.name)
        made = subject.fingerprint(asks)
        record = self.results.known(key, made)
        if record is None:
            if not self._is_ready(measure, callbacks):
                return
            values = measure.measure(subject, callbacks.show(subject, measure))
            record = MetricRecord(*key, made, subject.group, subject.prompt, values)
            self.results = self.results.and_also(record)
            callbacks.keep(self.results)
        self.records.append(record)

    def _is_ready(self, measure: Measure, callbacks: Callbacks) -> bool:
        try:
            measure.ready()
        except SceneError as error:
            if error.name not in _ABSENT:
                raise
            self.failures += 1
            self.left_out.add(measure.name)
            callbacks.fail(error, f"the metric `{measure.name}` is skipped")
            return False
        return True

"""The metrics as measurements of subjects: what each needs, and the numbers that it gives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from scenelang.backends.base import Progress
from scenelang.backends.clip.models import JUDGE, ClipName
from scenelang.backends.metrics.clip_score import ClipScore
from scenelang.backends.metrics.counting import counted, is_accurate
from scenelang.backends.metrics.dynamic_degree import degree_of_film
from scenelang.backends.metrics.lpips_distance import Lpips
from scenelang.backends.metrics.optical_flow import ITERATIONS, Raft
from scenelang.backends.metrics.torchvision_weights import ALEXNET, RAFT_LARGE
from scenelang.backends.metrics.views import CLIP_VIEWS, LPIPS_VIEWS
from scenelang.backends.weights import Shelf
from scenelang.evaluation.subject import Subject

METRICS = ("clip", "lpips", "count", "dynamic")
Values = dict[str, Any]


class Measure(Protocol):
    """One metric; its model is loaded by ``ready``."""

    @property
    def name(self) -> str: ...

    def asks(self, subject: Subject) -> Values | None:
        """What the numbers depend on besides the subject, as JSON data; None where the metric says nothing of it."""

    def ready(self) -> None:
        """Load what is needed; raises SceneError where it is not to be had."""

    def measure(self, subject: Subject, progress: Progress | None) -> Values:
        """The numbers, as JSON data; ``value`` is the one that tables have. Raises SceneError."""


@dataclass(frozen=True, slots=True)
class Models:
    """Where models are and what computes; ``judge`` is the one of CLIP similarity."""

    shelf: Shelf
    device: str = "cpu"
    judge: ClipName = JUDGE


class ClipMeasure:
    """The mean cosine of the prompt and the views, as the paper's."""

    name = "clip"

    def __init__(self, models: Models, views: int = CLIP_VIEWS) -> None:
        self._models, self._views = models, views
        self._judge: ClipScore | None = None

    def asks(self, subject: Subject) -> Values | None:
        return None if subject.prompt is None else {"model": str(self._models.judge), "views": self._views}

    def ready(self) -> None:
        if self._judge is None:
            self._judge = ClipScore(self._models.judge, self._models.shelf, self._models.device)

    def measure(self, subject: Subject, progress: Progress | None) -> Values:
        assert self._judge is not None
        assert subject.prompt is not None
        return _mean(self._judge.cosines(subject.prompt, subject.around(self._views, progress)))


class LpipsMeasure:
    """The mean distance of the views from the picture that the scene is to look like, as the paper's."""

    name = "lpips"

    def __init__(self, models: Models, views: int = LPIPS_VIEWS) -> None:
        self._models, self._views = models, views
        self._network: Lpips | None = None

    def asks(self, subject: Subject) -> Values | None:
        return None if subject.entry.image is None else {"model": ALEXNET.file, "views": self._views}

    def ready(self) -> None:
        if self._network is None:
            self._network = Lpips(self._models.shelf, self._models.device)

    def measure(self, subject: Subject, progress: Progress | None) -> Values:
        from scenelang.backends.clip.images import open_picture

        assert self._network is not None
        assert subject.entry.image is not None
        wanted = np.asarray(open_picture(subject.entry.image), np.uint8)
        return _mean(self._network.distances(wanted, subject.around(self._views, progress)))


class CountMeasure:
    """1 where there are as many of everything as asked for, else 0."""

    name = "count"

    def asks(self, subject: Subject) -> Values | None:
        if subject.scene is None or not subject.asked:
            return None
        return {"counts": [[" ".join(one.words), one.count] for one in subject.asked]}

    def ready(self) -> None:
        """Nothing is needed."""

    def measure(self, subject: Subject, progress: Progress | None) -> Values:
        assert subject.scene is not None
        found = counted(subject.scene, subject.asked)
        things = [
            {"asked": " ".join(one.asked.words), "count": one.asked.count, "words": list(one.words), "found": one.found}
            for one in found
        ]
        return {"value": float(is_accurate(found)), "things": things}


class DynamicMeasure:
    """How much a 4D scene moves; ``value`` is the share of the picture's size."""

    name = "dynamic"

    def __init__(self, models: Models) -> None:
        self._models = models
        self._network: Raft | None = None

    def asks(self, subject: Subject) -> Values | None:
        if not subject.is_dynamic:
            return None
        return {"model": RAFT_LARGE.file, "iterations": ITERATIONS, "fps": subject.drawing.fps}

    def ready(self) -> None:
        if self._network is None:
            self._network = Raft(self._models.shelf, self._models.device)

    def measure(self, subject: Subject, progress: Progress | None) -> Values:
        assert self._network is not None
        found = degree_of_film(subject.steady(progress), subject.drawing.fps, self._network.flow)
        return {"value": found.share, "pixels": found.pixels, "is_dynamic": found.is_dynamic}


def measure_called(name: str, models: Models, views: Mapping[str, int]) -> Measure:
    """The metric ``name``, one of METRICS; ``views`` may have numbers of views for "clip" and "lpips"."""
    if name == "clip":
        return ClipMeasure(models, views.get(name, CLIP_VIEWS))
    if name == "lpips":
        return LpipsMeasure(models, views.get(name, LPIPS_VIEWS))
    return CountMeasure() if name == "count" else DynamicMeasure(models)


def _mean(numbers: list[float]) -> Values:
    return {"value": float(np.mean(numbers)), "views": numbers}

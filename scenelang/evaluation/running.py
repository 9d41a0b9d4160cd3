"""One evaluation: every subject under every metric, each number kept as soon as it is there."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

from scenelang.backends.base import Progress
from scenelang.evaluation.measures import Measure
from scenelang.evaluation.results import Record, Results
from scenelang.evaluation.subject import Subject
from scenelang.grammar.diagnostics import SceneError

_ABSENT = ("weights", "backend")  # faults of what a metric needs, not of a scene


@dataclass(frozen=True, slots=True)
class Tellers:
    """What is told while it goes on: ``keep`` each state of the results, ``fail`` each fault with what it is about,
    ``show`` how far one measurement is."""

    keep: Callable[[Results], None] = lambda _: None
    fail: Callable[[SceneError, str], None] = lambda _, __: None
    show: Callable[[Subject, Measure], Progress | None] = lambda _, __: None


@dataclass(slots=True)
class Evaluation:
    """``records`` are those of this evaluation, in order; ``results`` also hold what the file had before."""

    results: Results
    records: list[Record] = field(default_factory=list)
    left_out: set[str] = field(default_factory=set)
    failures: int = 0

    def measure(self, subjects: Iterable[Subject], measures: Sequence[Measure], tellers: Tellers) -> None:
        """Measure what is not known yet. A metric that is not to be had is left out, a scene that cannot be drawn goes
        without the number; both are told."""
        for subject in subjects:
            for measure in measures:
                if measure.name in self.left_out:
                    continue
                try:
                    self._one(subject, measure, tellers)
                except SceneError as error:
                    self.failures += 1
                    tellers.fail(error, subject.entry.place)

    def _one(self, subject: Subject, measure: Measure, tellers: Tellers) -> None:
        asks = measure.asks(subject)
        if asks is None:
            return
        key = (subject.entry.place, subject.method, measure.name)
        made = subject.fingerprint(asks)
        record = self.results.known(key, made)
        if record is None:
            if not self._is_ready(measure, tellers):
                return
            values = measure.measure(subject, tellers.show(subject, measure))
            record = Record(*key, made, subject.group, subject.prompt, values)
            self.results = self.results.and_also(record)
            tellers.keep(self.results)
        self.records.append(record)

    def _is_ready(self, measure: Measure, tellers: Tellers) -> bool:
        try:
            measure.ready()
        except SceneError as error:
            if error.name not in _ABSENT:
                raise
            self.failures += 1
            self.left_out.add(measure.name)
            tellers.fail(error, f"the metric `{measure.name}` is left out")
            return False
        return True

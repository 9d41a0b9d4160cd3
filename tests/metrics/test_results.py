"""Results are kept as they come, and an evaluation goes on after a break."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from support import evaluate

from scenelang.backends.base import Progress
from scenelang.backends.pictures.film import PictureOptions
from scenelang.evaluation.running import (
    Callbacks,
    Drawing,
    Evaluation,
    EvaluationEntry,
    MetricRecord,
    Results,
    Subject,
    entries_of,
    read_results,
    write_results,
)
from scenelang.grammar.diagnostics import SceneError

CUBE = '(bind "a" (lambda () (call "cube" :color [1 0 0])))'


def subject(name: str, program: str = CUBE, prompt: str = "a cube", **more: Any) -> Subject:
    options = PictureOptions(**more)
    return Subject(
        EvaluationEntry(scene=Path(name)), "draft", prompt, evaluate(program), Drawing("draft", options, 24.0)
    )


class Measuring:
    """A metric that notes what it measured, and fails where it is told to."""

    def __init__(self, name: str = "length", asks: Any = None, fault: dict[str, BaseException] | None = None) -> None:
        self.name, self._asks, self._fault = name, asks, fault or {}
        self.measured: list[str] = []
        self.loads = 0

    def asks(self, subject: Subject) -> dict[str, Any] | None:
        return {"model": 1} if self._asks is None else self._asks

    def ready(self) -> None:
        self.loads += 1
        if "ready" in self._fault:
            raise self._fault["ready"]

    def measure(self, subject: Subject, progress: Progress | None) -> dict[str, Any]:
        if subject.entry.place in self._fault:
            raise self._fault[subject.entry.place]
        self.measured.append(subject.entry.place)
        return {"value": float(len(subject.entry.place))}


def run(folder: Path, subjects: list[Subject], *measures: Measuring) -> tuple[Evaluation, list[tuple[str, str]]]:
    told: list[tuple[str, str]] = []
    evaluation = Evaluation(read_results(folder))
    tellers = Callbacks(lambda results: write_results(folder, results), lambda e, about: told.append((e.name, about)))
    evaluation.measure(subjects, measures, tellers)
    return evaluation, told


def test_it_goes_on_after_a_kill(tmp_path: Path) -> None:
    subjects = [subject(name) for name in ("a", "bb", "ccc")]
    first = Measuring(fault={"ccc": KeyboardInterrupt()})
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path, subjects, first)
    assert first.measured == ["a", "bb"]
    assert [key[0] for key in read_results(tmp_path).records] == ["a", "bb"]
    second = Measuring()
    evaluation, _ = run(tmp_path, subjects, second)
    assert second.measured == ["ccc"], "what is known is not measured again"
    assert [record.value for record in evaluation.records] == [1.0, 2.0, 3.0]
    third = Measuring()
    run(tmp_path, subjects, third)
    assert (third.measured, third.loads) == ([], 0), "no model is loaded where nothing is to be measured"
    assert [path.name for path in tmp_path.iterdir()] == ["results.json"]


@pytest.mark.parametrize(
    "changed",
    [
        {"program": CUBE.replace("[1 0 0]", "[1 0 .1]")},
        {"program": CUBE.replace('(call "cube"', '(transform (call "cube"').replace(")))", ") (translate [1 0 0]))))")},
        {"prompt": "a red cube"},
        {"width": 300},
        {"environment": "night"},
        {"seed": 3},
    ],
)
def test_what_has_changed_is_measured_again(tmp_path: Path, changed: dict[str, Any]) -> None:
    run(tmp_path, [subject("a"), subject("bb")], Measuring())
    again = Measuring()
    run(tmp_path, [subject("a", **changed), subject("bb")], again)
    assert again.measured == ["a"]
    assert len(read_results(tmp_path).records) == 2
    model = Measuring(asks={"model": 2})
    run(tmp_path, [subject("bb")], model)
    assert model.measured == ["bb"], "another model gives other numbers"


def test_a_comment_changes_nothing(tmp_path: Path) -> None:
    run(tmp_path, [subject("a")], Measuring())
    again = Measuring()
    run(tmp_path, [subject("a", "; a cube\n" + CUBE)], again)
    assert again.measured == []


def test_a_metric_without_weights_is_left_out_once(tmp_path: Path) -> None:
    absent = Measuring("clip", fault={"ready": SceneError("weights", "not here")})
    other = Measuring()
    evaluation, told = run(tmp_path, [subject("a"), subject("bb")], absent, other)
    assert told == [("weights", "the metric `clip` is skipped")]
    assert absent.loads == 1
    assert other.measured == ["a", "bb"]
    assert (evaluation.left_out, evaluation.failures) == ({"clip"}, 1)


def test_a_scene_that_cannot_be_measured_stops_no_other(tmp_path: Path) -> None:
    measure = Measuring(fault={"a": SceneError("empty-scene", "nothing")})
    evaluation, told = run(tmp_path, [subject("a"), subject("bb")], measure)
    assert told == [("empty-scene", "a")]
    assert measure.measured == ["bb"]
    assert evaluation.failures == 1


RECORD = {
    "place": "a",
    "method": "m",
    "metric": "clip",
    "made": "f",
    "group": "numeric",
    "prompt": None,
    "values": {"value": 1},
}
WHOLE = {"format": "scenelang-evaluation", "version": 1, "records": [RECORD]}


def test_files_of_results_read_back(tmp_path: Path) -> None:
    assert read_results(tmp_path) == Results()
    record = MetricRecord("a", "m", "clip", "f", "numeric", "ä", {"value": 0.5, "views": [0.4, 0.6]})
    write_results(tmp_path, Results().and_also(record))
    assert read_results(tmp_path).records == {("a", "m", "clip"): record}


@pytest.mark.parametrize(
    "text",
    ["", "[]", "{}", "null", '{"format": "other"}', json.dumps(WHOLE)[:-3],
     json.dumps(WHOLE | {"version": 2}), json.dumps(WHOLE | {"records": [{}]}), json.dumps(WHOLE | {"records": 3}),
     json.dumps(WHOLE | {"records": [RECORD | {"place": 3}]}), json.dumps(WHOLE | {"records": [RECORD | {"values": {}}]}),
     json.dumps(WHOLE | {"records": [RECORD | {"values": {"value": float("nan")}}]}),
     json.dumps(WHOLE | {"records": [RECORD | {"more": 1}]}), "[" * 100_000],
)  # fmt: skip
def test_damaged_and_foreign_files_are_told(tmp_path: Path, text: str) -> None:
    (tmp_path / "results.json").write_text(text)
    with pytest.raises(SceneError, match="cannot read the results") as caught:
        read_results(tmp_path)
    assert caught.value.name == "file"
    assert (tmp_path / "results.json").read_text() == text, "it stays as it is"


# --- lists -----------------------------------------------------------------------------------------------------------


@pytest.fixture
def listed(tmp_path: Path) -> Any:
    def read(data: Any) -> list[EvaluationEntry]:
        (tmp_path / "list.json").write_text(data if isinstance(data, str) else json.dumps(data))
        return entries_of([str(tmp_path / "list.json")])

    return read


def test_lists(tmp_path: Path, listed: Any) -> None:
    one = {"scene": "a.scene", "prompt": " a  cube ", "count": {"can": 3}, "image": "i.png", "method": "m"}
    two = {"film": "f.mp4", "prompt": "p", "dynamic": True}
    assert listed([one, two, one]) == [
        EvaluationEntry(tmp_path / "a.scene", None, "a cube", "m", tmp_path / "i.png", (("can", 3),)),
        EvaluationEntry(None, tmp_path / "f.mp4", "p", is_dynamic=True),
    ]
    assert listed({"format": "scene"}) == [EvaluationEntry(tmp_path / "list.json")], "a scene may be JSON too"
    assert entries_of(["a.scene", "a.scene"]) == [EvaluationEntry(Path("a.scene"))]


@pytest.mark.parametrize(
    ("item", "text"),
    [
        ("a.scene", "expected an object"),
        ({}, "either `scene` or `film`"),
        ({"scene": "a", "film": "b"}, "either `scene` or `film`"),
        ({"scene": "a", "promt": "b"}, "`promt`"),
        ({"scene": 3}, "`scene` must be a string"),
        ({"scene": "a\0"}, "`scene` must be a string"),
        ({"scene": "a", "prompt": " "}, "`prompt` must be a string"),
        ({"scene": "a", "count": [3]}, "`count`"),
        ({"scene": "a", "count": {"a": True}}, "`count`"),
        ({"scene": "a", "count": {"a": -1}}, "`count`"),
        ({"film": "a", "dynamic": 1}, "`dynamic`"),
    ],
)
def test_entries_that_make_no_sense(listed: Any, item: Any, text: str) -> None:
    with pytest.raises(SceneError, match=text) as caught:
        listed([{"scene": "ok.scene"}, item])
    assert caught.value.name == "value"
    assert "entry 2" in caught.value.message


def test_lists_that_cannot_be_read(tmp_path: Path, listed: Any) -> None:
    for text, reason in (
        ("[", "Expecting value"),
        ("[" * 100_000, "maximum recursion"),
        ('{"a": NaN', "Expecting ','"),
    ):
        with pytest.raises(SceneError, match=f"cannot read .*{reason}"):
            listed(text)
    with pytest.raises(SceneError, match=r"none\.json: No such file"):
        entries_of([str(tmp_path / "none.json")])

"""Answers that were written from nothing but the prompts, replayed: the two notations, before and after the rework of
the prompt of the language."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
import searching

from scenelang.bench.benchmark import BenchReport, benchmark, compare_benchmarks
from scenelang.inference import steps

ANSWERS = Path(__file__).parents[2] / "benchmarks" / "answers"
MODES = ("python", "dsl")
pytestmark = pytest.mark.search


@pytest.fixture(scope="module")
def tasks() -> list[str]:
    """Every third task that was answered; all of them under ``nightly``."""
    lines = (ANSWERS / "after.jsonl").read_text("utf-8").splitlines()
    names = sorted({json.loads(line)["task"] for line in lines})
    assert len(names) == 30
    return [names[i] for i in searching.places(len(names))]


@pytest.fixture(scope="module")
def runs(tasks: list[str], tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, BenchReport]]:
    folder = tmp_path_factory.mktemp("runs")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(steps, "trial", lambda work: None)  # these answers do no harm
        yield {
            name: benchmark(folder / name, tasks=tasks, replay=ANSWERS / f"{name}.jsonl", any_prompt=True)
            for name in ("before", "after")
        }


def figure(report: BenchReport, mode: str, name: str) -> float:
    (result,) = (each for each in report.results if each.mode == mode)
    found = result.figures[name]
    assert found is not None
    return found.value


@pytest.mark.slow
def test_the_language_succeeds_at_least_as_often_as_python(tasks: list[str], runs: dict[str, BenchReport]) -> None:
    shares = {mode: figure(runs["after"], mode, "passes at the first answer") for mode in MODES}
    assert shares["dsl"] >= shares["python"] >= 0.95
    assert [figure(runs["after"], mode, "valid first answers") for mode in MODES] == [1.0, 1.0]
    counts = [result.figures["pass@1"].count for result in runs["after"].results if result.figures["pass@1"]]
    assert counts == [len(tasks)] * 2


@pytest.mark.slow
def test_the_rework_kept_success_at_half_the_tokens(runs: dict[str, BenchReport]) -> None:
    before, after = runs["before"], runs["after"]
    (compared,) = compare_benchmarks(before.folder, after.folder)
    assert compared.lost == ()
    assert figure(after, "dsl", "input tokens") < 0.5 * figure(before, "dsl", "input tokens")
    assert figure(after, "dsl", "output tokens") < figure(after, "python", "output tokens")

"""The benchmark: what its modules import, how figures come about, and what fails beside the last entry of its history."""

from __future__ import annotations

import ast
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

FOLDER = Path(__file__).parents[1] / "benchmarks"


def module(name: str) -> ModuleType:
    """A module of the benchmark, whose folder is searched only while it is imported."""
    sys.path.insert(0, str(FOLDER))
    try:
        return __import__(name)
    finally:
        sys.path.remove(str(FOLDER))


measuring, history = module("measuring"), module("history")
Goal, Pair, Row, Figures = measuring.Goal, measuring.Pair, measuring.Row, measuring.Figures


def environment(*folders: Path) -> dict[str, str]:
    """What scripts of the benchmark run in, which are found in their own folder."""
    known = [os.environ["PYTHONPATH"]] if "PYTHONPATH" in os.environ else []
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONSAFEPATH"}
    return {**kept, "PYTHONPATH": os.pathsep.join([*map(str, folders), *known])}


def probe(name: str, values: list[float], calls: list[str]) -> Any:
    """What gives these values one after another, and notes each call."""
    given = iter(values)

    def measure() -> float:
        calls.append(name)
        return next(given)

    return measure


def test_ours_and_the_other_are_measured_in_turns_and_medians_are_kept() -> None:
    calls: list[str] = []
    pair = Pair(probe("ours", [9.0, 2.0, 3.0], calls), probe("other", [1.0, 1.0, 8.0], calls))
    figures = measuring.figures_of(Row("a", lambda: [pair], rounds=3))
    assert calls == ["ours", "other"] * 3
    assert (figures.ours, figures.other, figures.ratio) == (3.0, 1.0, 3.0)


def test_a_row_of_many_programs_has_the_median_of_their_ratios_or_the_worst() -> None:
    pairs = lambda: [Pair(lambda: 4.0, lambda: 1.0), Pair(lambda: 2.0, lambda: 2.0), Pair(lambda: 6.0, lambda: 1.0)]
    assert measuring.figures_of(Row("a", pairs, rounds=1)).ratio == 4.0
    assert measuring.figures_of(Row("a", pairs, rounds=1, summary=max)).ratio == 6.0


def test_the_collector_is_off_while_an_action_is_measured_unless_it_belongs_to_it() -> None:
    import gc

    seen: list[bool] = []
    measuring.timed(lambda: seen.append(gc.isenabled()))()
    measuring.timed(lambda: seen.append(gc.isenabled()), collecting=True)()
    assert (seen, gc.isenabled()) == ([False, True], True)


@pytest.mark.parametrize(
    ("goal", "reached"),
    [(("ratio", 3.0), False), (("ratio", 4.0), True), (("ours", 2.0), True), (("ours", 1.9), False),
     (("instructions", 3.5), None), (("memory", 200), None)],
)  # fmt: skip
def test_a_goal_is_reached_or_not_or_not_measured(goal: tuple[str, float], reached: bool | None) -> None:
    assert Figures(2.0, 0.5, 4.0).reached(Goal(goal[1], goal[0])) is reached


def test_a_peer_that_is_absent_is_told_in_a_line(tmp_path: Path) -> None:
    """By the Python of the peers, which may be missing, and by the package that a task imports."""
    (tmp_path / "hy.py").write_text("raise ImportError('no hy')")
    words = [sys.executable, str(FOLDER / "peers.py"), "hy", "fib"]
    done = subprocess.run(words, capture_output=True, text=True, env=environment(tmp_path))
    assert (done.returncode, done.stderr) == (measuring.NOT_INSTALLED, "hy is not installed (no hy)\n")
    run = module("run")
    row = Row("fib beside Hy", list, "Hy")
    assert run.line_of(row, "absent: hy is not installed").split("  ")[-1].strip() == "absent: hy is not installed"


def test_a_missing_environment_of_peers_is_absent_too(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(measuring, "PEERS", measuring.ROOT / ".venv" / "nothing" / "bin" / "python")
    with pytest.raises(measuring.Absent, match="make bench"):
        measuring.peer("hy", "fib")


def test_strangers_may_be_absent_and_have_the_goals_of_their_relatives(tmp_path: Path) -> None:
    language = module("language")
    assert list(language.strangers(tmp_path / "nothing")) == []
    for name in ("hanoi", "sums"):
        (tmp_path / f"{name}.scene").write_text("(define (f) 1)\n(+ (f) 1)\n")
        (tmp_path / f"{name}.py").write_text("def run():\n    return 2\n")
    (tmp_path / "relatives.toml").write_text('hanoi = "tak"\n')
    rows = list(language.strangers(tmp_path))
    assert [(row.name, row.goals) for row in rows] == [("stranger: hanoi", (Goal(4.5),)), ("stranger: sums", ())]
    (pair,) = rows[0].pairs()
    assert min(pair.ours(), pair.other()) > 0


# --- the history --------------------------------------------------------------------------------------------------


def entry(commit: str = "b", python: str = "3.11.7", control: float = 1.0, **rows: dict[str, float]) -> dict[str, Any]:
    machine = {"cpu": "x", "python": python}
    return {"commit": commit, "machine": machine, "control": {"seconds": control, "spread": 0.01}, "rows": rows}


def reported(tmp_path: Path, before: list[dict[str, Any]], now: dict[str, Any]) -> int:
    path = tmp_path / "history.jsonl"
    path.write_text("".join(json.dumps(each) + "\n" for each in before))
    return history.report(now, [], keeps=False, path=path)


@pytest.mark.parametrize(("count", "status"), [(1_049, 0), (1_051, 1)])
def test_five_per_cent_more_instructions_fail(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], count: int, status: int
) -> None:
    known, now = [entry("a", fib={"instructions": 1_000})], entry(fib={"instructions": count}, control=9.0)
    assert reported(tmp_path, known, now) == status
    assert ("FAILED fib: instructions rose by 5 %" in capsys.readouterr().out) == bool(status)


def test_other_versions_of_python_and_the_same_commit_are_not_compared(tmp_path: Path) -> None:
    now = entry(fib={"instructions": 2_000})
    assert reported(tmp_path, [entry("a", "3.12.1", fib={"instructions": 1_000})], now) == 0
    assert reported(tmp_path, [entry("b", fib={"instructions": 1_000})], now) == 0
    known = [entry("a", fib={"instructions": 1_000}), entry("b", fib={"instructions": 2_000})]
    assert reported(tmp_path, known, now) == 1, "measured a second time, it fails again"


@pytest.mark.parametrize(("control", "status"), [(1.04, 1), (1.06, 0)])
def test_times_fail_only_beside_a_steady_control(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], control: float, status: int
) -> None:
    known = [entry("a", fib={"ours": 1.0, "ratio": 3.0})]
    assert reported(tmp_path, known, entry(control=control, fib={"ours": 1.0, "ratio": 4.0})) == status
    assert "fib: ratio rose by 33 %" in capsys.readouterr().out


def test_an_entry_replaces_that_of_its_commit(tmp_path: Path) -> None:
    path = tmp_path / "history.jsonl"
    for name, ratio in (("a", 1.0), ("b", 2.0), ("a", 3.0)):
        history.record(entry(name, fib={"ratio": ratio}), path)
    assert [(each["commit"], each["rows"]["fib"]["ratio"]) for each in history.entries(path)] == [
        ("b", 2.0),
        ("a", 3.0),
    ]


def test_a_row_that_fails_is_named_and_fails_the_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert history.report(entry(), ["fib: ended with 1"], keeps=False, path=tmp_path / "none") == 1
    assert "FAILED fib: ended with 1" in capsys.readouterr().out


def test_an_entry_has_the_figures_with_their_goals() -> None:
    row = Row("fib", list, "Python", (Goal(3.0), Goal(0.02, "ours")))
    figures = replace(Figures(0.0123456, 0.004, 3.0864), instructions=123_456)
    kept = history.entry_of({"fib": row, "gone": row}, {"fib": figures, "gone": "absent: x"}, [1.0, 1.0, 1.1])
    assert kept["unmeasured"] == {"gone": "absent: x"}
    assert kept["rows"] == {
        "fib": {"ours": 0.0123, "other": 0.004, "beside": "Python", "ratio": 3.09, "instructions": 123_456,
                "goals": {"<= x3": False, "<= 20 ms": True}}
    }  # fmt: skip


# --- what the modules import --------------------------------------------------------------------------------------


def imported_names() -> Iterator[tuple[str, str, str]]:
    """What the benchmarks import of the package: file, module, name."""
    for path in sorted(FOLDER.glob("*.py")):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("scenelang."):
                yield from ((path.name, str(node.module), each.name) for each in node.names)


def names_in(module: str) -> set[str]:
    """What a module of the package defines or imports, by its text."""
    parts = module.split(".")[1:]
    places = [folder.joinpath(*parts) for folder in (FOLDER.parent, FOLDER.parent / "scenelang")]
    folder = next((place for place in places if (place / "__init__.py").exists()), None)
    path = folder / "__init__.py" if folder else next(p for p in places if p.with_suffix(".py").exists())
    names = {each.stem for each in folder.glob("*.py")} if folder else set()
    for node in ast.parse(path.with_suffix(".py").read_text("utf-8")).body:
        names |= {name.id for name in ast.walk(node) if isinstance(name, ast.Name) and isinstance(name.ctx, ast.Store)}
        names |= {each.asname or each.name for each in getattr(node, "names", ())} | {getattr(node, "name", "")}
    return names


def test_benchmarks_import_what_there_is() -> None:
    found = list(imported_names())
    assert len(found) > 50
    known = {module: names_in(module) for module in {row[1] for row in found}}
    assert [row for row in found if row[2] not in known[row[1]]] == []


def test_every_row_has_its_own_name_and_goals_that_can_be_reached() -> None:
    """In a process of its own: some modules have the names of packages of the tests."""
    text = (
        "import json, run; print(json.dumps([(r.name, r.counts, [g.of for g in r.goals]) for _, r in run.chosen('')]))"
    )
    words = [sys.executable, "-c", text]
    done = subprocess.run(words, capture_output=True, text=True, env=environment(FOLDER), check=True)
    rows = json.loads(done.stdout)
    assert len(rows) == len({name for name, _, _ in rows}) > 50
    assert {of for _, _, goals in rows for of in goals} <= {"ratio", "instructions", "ours", "memory"}
    assert [name for name, counts, goals in rows if "instructions" in goals and not counts] == []

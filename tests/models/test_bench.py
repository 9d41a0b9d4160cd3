"""`scenelang bench` with a model that answers from a script: every figure moves as it should."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import scenelang as sl
from models.chat_server import Chat, chatting
from models.conftest import WRONG, Place, cubes, python, texts
from models.server import Said
from models.tiny_model import trained
from scenelang.bench.benchmark import BenchReport, benchmark, benchmark_report, compare_benchmarks
from scenelang.bench.results import mcnemar, pass_at, wilson
from scenelang.grammar.diagnostics import SceneError, UsageError
from scenelang.inference.records import InferenceSettings

pytestmark = pytest.mark.usefixtures("untried", "small_pictures")

PASSES = """
(bind "pile" (lambda () (for/union ((i 2)) (transform (call "cube" :color (color "red")) (translate (vector (* 2 i) .5 0))))))
(scene "pile")
"""
TASKS = f"""
[[task]]
name = "two-cubes"
passes = '''{PASSES}'''
[[task.clause]]
says = "Two red cubes of edge 1 beside each other on the ground."
that = ['(count "cube" 2)', '(has-color "cube" "red")', '(supported "cube")']

[[task]]
name = "three-cubes"
passes = '''{PASSES.replace("(i 2)", "(i 3)")}'''
[[task.clause]]
says = "Three cubes in a row."
that = ['(count "cube" 3)', '(aligned "cube" :along "x")']
"""
EDITS = f"""
[[task]]
name = "third-cube"
program = '''{PASSES}'''
passes = '''
(bind "pile" (lambda () (for/union ((i 2)) (transform (call "cube" :color (color "red")) (translate (vector (* 2 i) .5 0))))))
(bind "new" (lambda () (call "cube")))
(bind "all" (lambda () (union (call "pile") (transform (call "new") (translate [4 .5 0])))))
(scene "all")
'''
[[task.clause]]
says = "Add a third cube, word \\"new\\", beside them."
keep = ["pile"]
that = ['(count "new" 1)']
"""
USAGE = {"input_tokens": 1000, "output_tokens": 100}


@pytest.fixture
def tasks(place: Place) -> Path:
    folder = place.work / "tasks"
    folder.mkdir()
    (folder / "cubes.toml").write_text(TASKS)
    return folder


def said(*answers: str) -> list[Said]:
    return [Said(text, usage=dict(USAGE)) for text in answers]


def settings(**changed: Any) -> InferenceSettings:
    return InferenceSettings(**{"side_by_side": 1, "uses_replies": False, **changed})


def run(place: Place, tasks: Path, name: str, answers: list[str], **changed: Any) -> BenchReport:
    place.serve(said(*answers))
    asked = changed.pop("settings", settings())
    return benchmark(place.work / name, **{"task_folder": tasks, "modes": ["python"], "settings": asked, **changed})


def values(report: BenchReport, mode: int = 0) -> dict[str, float | None]:
    return {name: None if f is None else f.value for name, f in report.results[mode].figures.items()}


def test_all_pass_at_once(place: Place, tasks: Path) -> None:
    report = run(place, tasks, "run", [cubes(2), cubes(3)])
    found = values(report)
    assert {found[name] for name in ("valid first answers", "passes at the first answer", "pass@1")} == {1.0}
    assert (found["repairs"], found["input tokens"], found["output tokens"]) == (0.0, 1000.0, 100.0)
    assert found["dollars"] == pytest.approx(report.trials[0].attempts[0].cost)
    assert report.trials[0].attempts[0].cost > 0
    assert (found["scenes with collisions"], found["scenes with floating parts"]) == (0.0, 0.0)
    assert (found["stable scenes"], found["edit locality"]) == (None, None)
    assert set(report.results[0].predicates) == {"aligned", "count", "geometry", "has-color", "supported"}
    assert report.results[0].diagnostics == ()
    figure = report.results[0].figures["pass@1"]
    assert figure is not None
    assert (figure.low, figure.high) == pytest.approx((0.342, 1.0), abs=1e-3)


def test_a_repair_counts_as_one(place: Place, tasks: Path) -> None:
    report = run(place, tasks, "run", [WRONG, cubes(2), cubes(3)])
    found = values(report)
    assert (found["valid first answers"], found["passes at the first answer"], found["pass@1"]) == (0.5, 0.5, 1.0)
    assert (found["repairs"], found["input tokens"]) == (0.5, 1500.0)
    (record,) = report.results[0].diagnostics
    assert (record.code, record.occurred, record.repaired, record.failed) == ("E607", 1, 1, 0)
    assert "| E607" in str(report)


def test_errors_that_stay_are_ranked_first(place: Place, tasks: Path) -> None:
    asked = settings(repairs=1)
    report = run(place, tasks, "run", [WRONG, WRONG, "no program", cubes(3)], settings=asked)
    assert values(report)["pass@1"] == 0.5
    assert [(r.code, r.failed) for r in report.results[0].diagnostics] == [("E607", 1), ("E801", 0)]
    assert report.trials[0].error
    assert report.results[0].predicates["has-color"].value == 0.0  # without a scene no predicate holds


def test_scenes_that_fail_predicates(place: Place, tasks: Path) -> None:
    report = run(place, tasks, "run", [cubes(3), cubes(3)])
    assert [trial.failed for trial in report.trials] == [('(count "cube" 2)',), ()]
    found = values(report)
    assert (found["pass@1"], found["valid first answers"]) == (0.5, 1.0)
    assert report.results[0].predicates["count"].value == 0.5
    floating = cubes(2).replace("0.5, 0))", "0.5 + 0.2 * i, 0))")
    report = run(place, tasks, "floating", [floating, cubes(3)])
    assert values(report)["scenes with floating parts"] == 0.5
    assert report.trials[0].failed == ('(supported "cube")', "geometry")
    overlap = cubes(3).replace("2 * i", "0 * i")
    assert values(run(place, tasks, "overlap", [overlap, overlap]))["scenes with collisions"] == 1.0


def test_several_samples(place: Place, tasks: Path) -> None:
    answers = [cubes(2), cubes(1), cubes(1), cubes(2), *[cubes(3)] * 4]
    found = values(run(place, tasks, "run", answers, settings=settings(samples=4)))
    assert (found["pass@1"], found["pass@4"]) == (0.75, 1.0)


def test_stability_is_simulated(place: Place, tasks: Path) -> None:
    pytest.importorskip("mujoco")
    leaning = python("""
@register()
def pile() -> Shape:
    top = transform_shape(primitive_call("cube", shape_kwargs={"scale": (3, 1, 1)}), translation_matrix((1.2, 1.5, 0)))
    return concat_shapes(top, transform_shape(primitive_call("cube", shape_kwargs={"scale": (1, 1, 1)}), translation_matrix((0, .5, 0))))
""")
    found = values(run(place, tasks, "run", [cubes(2), leaning], simulates=True))
    assert found["stable scenes"] == 0.5


def test_edits_must_keep_the_rest(place: Place, tasks: Path) -> None:
    (tasks / "edits.toml").write_text(EDITS)
    good = EDITS.split("passes = '''")[1].split("'''")[0]
    moved = good.replace("(* 2 i)", "(* 3 i)")
    one = good.replace("(i 2)", "(i 1)")
    scores = []
    for number, answer in enumerate((good, moved, one)):
        report = run(place, tasks, f"run{number}", [f"```scene\n{answer}```"], modes=["dsl"], groups=["edits"])
        scores.append((values(report)["edit locality"], report.trials[0].failed))
    assert scores == [(1.0, ()), (0.5, ("keep",)), (0.5, ("keep",))]


def test_modes_differ_in_what_is_asked(place: Place, tasks: Path) -> None:
    server = place.serve(said(cubes(2), f"```scene\n{PASSES}```", cubes(2), "NO CHANGES"))
    report = benchmark(
        place.work / "run", task_folder=tasks, tasks=["two-cubes"], modes=["python", "dsl", "python+critique"],
        settings=settings(),
    )  # fmt: skip
    assert [result.mode for result in report.results] == ["python", "dsl", "python+critique"]
    assert [values(report, k)["pass@1"] for k in range(3)] == [1.0, 1.0, 1.0]
    assert [len(trial.attempts) for trial in report.trials] == [1, 1, 2]
    first = [texts(request["messages"][0]) for request in server.requests]
    assert "Two red cubes" in first[0]
    assert "Name the things" not in first[0]  # its declarations are about primitives only
    assert first[0] == first[2]
    assert first[0] != first[1]


def test_words_of_python_have_underscores_for_hyphens(place: Place, tasks: Path) -> None:
    named = TASKS.split("[[task]]")[1].replace('"cube" 2', '"red-cubes" 1').replace('"pile"', '"red-cubes"')
    (tasks / "cubes.toml").write_text(f"[[task]]{named}")
    report = run(place, tasks, "run", [cubes(2, word="red_cubes")])
    assert values(report)["pass@1"] == 1.0
    in_the_language = PASSES.replace("pile", "red_cubes")
    report = run(place, tasks, "dsl", [f"```scene{in_the_language}```"], modes=["dsl"])
    assert report.trials[0].failed == ('(count "red-cubes" 1)',)


@pytest.mark.parametrize(("mode", "is_sent"), [("dsl", False), ("dsl-grammar", True)])
def test_a_grammar_is_a_mode(
    mode: str, is_sent: bool, place: Place, tasks: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with chatting([Chat(PASSES)], "llama.cpp") as server:
        monkeypatch.setenv("OPENAI_BASE_URL", server.url)
        asked = settings(provider="openai", model="local")
        report = benchmark(place.work / "run", task_folder=tasks, tasks=["two-cubes"], modes=[mode], settings=asked)
    assert ("grammar" in server.requests[0]) is is_sent
    assert values(report)["pass@1"] == 1.0
    with pytest.raises(UsageError, match="no grammars"):
        benchmark(place.work / "other", task_folder=tasks, modes=["dsl-grammar"], settings=settings())


def test_a_tiny_local_model_under_the_grammar(place: Place, tasks: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A real model, of bytes, makes mistakes of brackets and tokens without the grammar, and none with it."""
    model = trained()
    seeds = iter(range(100))
    answer = lambda body: Chat(model.answer(body.get("grammar"), next(seeds)))
    with chatting(answer, "llama.cpp") as server:
        monkeypatch.setenv("OPENAI_BASE_URL", server.url)
        asked = settings(provider="openai", model="tiny", samples=2, repairs=0)
        modes = ["dsl", "dsl-grammar"]
        report = benchmark(place.work / "run", task_folder=tasks, modes=modes, settings=asked)
    found = {mode: [a.codes for t in report.trials if t.mode == mode for a in t.attempts] for mode in modes}
    malformed = {mode: [any(c.startswith("E1") for c in each) for each in found[mode]] for mode in modes}
    assert len(found["dsl"]) == len(found["dsl-grammar"]) == 4
    assert all(malformed["dsl"])
    assert not any(malformed["dsl-grammar"])


def test_an_interrupted_run_goes_on(place: Place, tasks: Path) -> None:
    place.serve([*said(cubes(2)), Said("overloaded", status=400)])
    with pytest.raises(SceneError, match="overloaded"):
        benchmark(place.work / "run", task_folder=tasks, modes=["python"], settings=settings())
    trials = place.work / "run" / "trials.jsonl"
    assert len(trials.read_text().splitlines()) == 1
    trials.write_text(trials.read_text() + '{"task": "thr')  # a line that was not written to its end
    assert len(benchmark_report(place.work / "run").trials) == 1
    server = place.serve(said(cubes(3)))
    report = benchmark(place.work / "run", task_folder=tasks, modes=["python"], settings=settings())
    assert values(report)["pass@1"] == 1.0
    assert len(server.requests) == 1
    with pytest.raises(UsageError, match="other settings"):
        benchmark(place.work / "run", task_folder=tasks, modes=["dsl"], settings=settings())
    (place.work / "full").mkdir()
    (place.work / "full" / "mine.txt").touch()
    with pytest.raises(UsageError, match="not empty"):
        benchmark(place.work / "full", task_folder=tasks, modes=["python"], settings=settings())


def test_the_cost_limit_ends_a_run(place: Place, tasks: Path) -> None:
    place.serve(said(cubes(2)))
    with pytest.raises(SceneError) as caught:
        benchmark(place.work / "run", task_folder=tasks, modes=["python"], settings=settings(max_cost=0.0001))
    assert caught.value.name == "model-cost"
    assert not (place.work / "run" / "trials.jsonl").exists()


def test_a_run_is_replayed(place: Place, tasks: Path) -> None:
    run(place, tasks, "run", [WRONG, cubes(2), cubes(1)])
    server = place.serve([])
    again = benchmark(place.work / "again", task_folder=tasks, replay=place.work / "run")
    assert server.requests == []
    once = benchmark_report(place.work / "run")
    assert again.results == once.results
    assert str(again) == str(once)


def test_another_prompt_is_another_request(place: Place, tasks: Path) -> None:
    run(place, tasks, "run", [cubes(2), cubes(3)])
    (tasks / "cubes.toml").write_text(TASKS.replace("in a row", "in one row"))
    strict = benchmark(place.work / "strict", task_folder=tasks, replay=place.work / "run")
    assert [trial.passed for trial in strict.trials] == [True, False]
    assert "no answer to request 1 of `three-cubes`" in str(strict.trials[1].error)
    loose = benchmark(place.work / "loose", task_folder=tasks, replay=place.work / "run", any_prompt=True)
    assert ([trial.passed for trial in loose.trials], loose.outdated) == ([True, True], 1)


def test_runs_are_compared(place: Place, tasks: Path) -> None:
    run(place, tasks, "a", [cubes(1), cubes(3)])
    run(place, tasks, "b", [cubes(2), cubes(2)])
    (found,) = compare_benchmarks(place.work / "a", place.work / "b")
    assert (found.gained, found.lost, found.p_value) == (("two-cubes",), ("three-cubes",), 1.0)
    done = place.run("bench", "--compare", "a", "b")
    assert "gained: two-cubes" in done.out
    assert "+0.0 points" in done.out
    assert json.loads(place.run("bench", "--compare", "a", "b", "--json").out)[0]["lost"] == ["three-cubes"]


def test_the_command(place: Place, tasks: Path) -> None:
    place.serve(said(cubes(2), cubes(1)))
    words = ["bench", "--tasks", str(tasks), "--mode", "python", "-o", "run", "--jobs", "1", "--no-cache"]
    done = place.run(*words)
    assert done.code == 0, done.err
    assert "| pass@1 | 50.0 % [9, 91] |" in done.out
    folder = place.work / "run"
    assert {path.name for path in folder.iterdir()} >= {"results.md", "results.json", "sheet.png", "answers.jsonl"}
    assert json.loads((folder / "results.json").read_text())["modes"]["python"]["figures"]["pass@1"]["value"] == 0.5
    assert len(list((folder / "programs").iterdir())) == 2
    replayed = place.run("bench", "--tasks", str(tasks), "--replay", "run", "-o", "again")
    assert replayed.out.replace("again/", "run/") == done.out
    assert place.run("bench", "--report", "run").out == done.out[: done.out.index("wrote")]
    from PIL import Image

    with Image.open(folder / "sheet.png") as sheet:
        colors = {sheet.convert("RGB").getpixel((x, 1)) for x in (2, sheet.width - 2)}
    assert colors == {(0x1A, 0x7F, 0x37), (0xCF, 0x22, 0x2E)}


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        ((), "expected a folder"),
        (("-o", "run", "--mode", "lisp"), "unknown mode `lisp`"),
        (("-o", "run", "--task", "two-cube"), "did you mean `two-cubes`"),
        (("-o", "run", "--group", "cube"), "did you mean `cubes`"),
        (("-o", "run", "--replay", "nowhere"), "no recorded answers"),
        (("--report", "nowhere"), "not a run"),
        (("--list", "--report", "run"), "cannot be combined"),
        (("-o", "run", "--mode", "python", "--jobs", "0"), "--jobs"),
    ],
)
def test_wrong_usage(words: tuple[str, ...], problem: str, place: Place, tasks: Path) -> None:
    done = place.run("bench", "--tasks", str(tasks), *words)
    assert done.code in (1, 2)
    assert problem in done.err


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ('name = "two-cubes"', 'name = "Two Cubes"', "small letters"),
        ('(count "cube" 2)', '(counts "cube" 2)', "unknown relation `counts`"),
        ('says = "Three', 'sais = "Three', "`says` is missing"),
        ('that = [\'(count "cube" 3)\', \'(aligned "cube" :along "x")\']', "", "a clause without predicates"),
        ('name = "three-cubes"', 'name = "two-cubes"', "two tasks are named"),
        (
            "that = ['(count \"cube\" 3)'",
            "keep = ['a']\nthat = ['(count \"cube\" 3)'",
            "no meaning without a `program`",
        ),
    ],
)
def test_tasks_with_mistakes(old: str, new: str, problem: str, place: Place, tasks: Path) -> None:
    assert old in TASKS
    (tasks / "cubes.toml").write_text(TASKS.replace(old, new))
    done = place.run("bench", "--tasks", str(tasks), "--list")
    assert done.code == 1
    assert problem in done.err


def test_a_suite_may_be_one_file(place: Place, tasks: Path) -> None:
    listed = [place.run("bench", "--tasks", str(path), "--list").out for path in (tasks, tasks / "cubes.toml")]
    assert listed[0] == listed[1]
    assert "three-cubes" in listed[0]
    assert place.run("bench", "--tasks", str(tasks / "none.toml"), "--list").code == 1


def test_statistics() -> None:
    assert wilson(0.5, 10) == pytest.approx((0.2366, 0.7634), abs=1e-4)  # as in statsmodels
    assert wilson(0.0, 0) == (0.0, 1.0)
    assert [pass_at(k, 5, 2) for k in (1, 2, 4)] == pytest.approx([0.4, 0.7, 1.0])
    assert mcnemar(0, 0) == 1.0
    assert mcnemar(8, 1) == pytest.approx(0.0390625)  # 2 * (1 + 9) / 512


def test_it_is_in_the_api() -> None:
    assert sl.benchmark is benchmark
    assert sl.compare_benchmarks is compare_benchmarks


def test_the_mutation_model_runs_offline(place: Place, tasks: Path) -> None:
    asked = settings(samples=8)
    report = benchmark(place.work / "run", task_folder=tasks, mutations=1, settings=asked)
    found = values(report)
    assert [result.mode for result in report.results] == ["dsl"]
    assert 0 <= (found["valid first answers"] or 0) < 0.8  # mistakes are planted
    assert (found["pass@1"] or 0) > (found["passes at the first answer"] or 0)  # and repaired
    assert found["dollars"] == 0.0
    again = benchmark(place.work / "again", task_folder=tasks, mutations=1, settings=asked)
    assert [t.failed for t in again.trials] == [t.failed for t in report.trials]
    with pytest.raises(UsageError, match="writes the language only"):
        benchmark(place.work / "other", task_folder=tasks, mutations=1, modes=["python"])


def test_the_checker_is_measured(place: Place, tasks: Path) -> None:
    done = place.run("bench", "--tasks", str(tasks), "--mistakes", "1")
    assert done.code == 0
    assert "| **all** | tuned |" in done.out
    data = json.loads(place.run("bench", "--tasks", str(tasks), "--mistakes", "1", "--json").out)
    assert {row["split"] for row in data["rows"]} == {"tuned", "untouched"}
    assert place.run("bench", "--mistakes", "0").code == 2

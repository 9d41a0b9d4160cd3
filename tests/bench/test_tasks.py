"""Every task of the benchmark has a program that passes, and wrong scenes by other authors that do not."""

from __future__ import annotations

import tomllib
from collections import Counter
from pathlib import Path

import pytest

import scenelang as sl
from scenelang.backends.geometry.relations import reasons
from scenelang.bench import tasks
from scenelang.bench.scoring import kept_share, scene_of, score_of
from scenelang.bench.tasks import KEEP, BenchTask, load_tasks, tasks_of
from scenelang.bench.trials import applicable
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import SceneError
from scenelang.inference.brief import TaskKind
from scenelang.inference.steps import has_blocks

FOLDER = Path(tasks.__file__).parent / "tasks"
# Names alone, so that only the process that runs these tests parses the declarations, which takes 5 s.
FILES = [tomllib.loads(path.read_text("utf-8")) for path in sorted(FOLDER.glob("*.toml"))]
NAMES = [table["name"] for file in FILES for table in file["task"]]
HARD = [table["name"] for file in FILES if file.get("hard") for table in file["task"]]
IMAGES = [table["name"] for file in FILES for table in file["task"] if table.get("image")]
EDITS = [table["name"] for file in FILES for table in file["task"] if "program" in table]
PROGRAMS = {table["program"]: table.get("python") for file in FILES for table in file["task"] if "program" in table}
# Wrong scenes that pass, by task, and why they are wrong: what the predicates cannot tell yet.
MISSED: dict[str, tuple[str, ...]] = {
    "balanced-scale": ("pans hang half way along the beam",),
    "hydra": ("heads half way down the necks",),
    "ladder-against-wall": ("foot at the wall, top leans away",),
    "menger-sponge": ("half sunk into the ground",),
    "paper-bramante-staircase": ("a cylinder fills the shaft",),
    "rubiks-cube": ("every face has three stripes of colors",),
    "stonehenge": ("each lintel lies on one stone only",),
}


@pytest.fixture
def task(name: str) -> BenchTask:
    return next(task for task in load_tasks() if task.name == name)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.sampled(8)
def test_a_program_passes(task: BenchTask) -> None:
    scene = scene_of(task.passes)
    score = score_of(task, scene)
    assert score.failed(task) == [], score.reasons
    assert scene.animated == (task.kind is TaskKind.FILM)
    assert has_blocks(scene) == (task.kind is TaskKind.BLOCKS)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.sampled(24)
def test_wrong_scenes_do_not_pass(task: BenchTask) -> None:
    missed = [wrong.why for wrong in task.wrong if passes(task, wrong.program)]
    assert missed == list(MISSED.get(task.name, ()))


def passes(task: BenchTask, program: str) -> bool:
    """Whether a program is accepted; one without a scene is not."""
    try:
        scene = scene_of(program)
        if any(reasons(scene, task.declarations)):  # which is enough, and spares the checks of the geometry
            return False
        return score_of(task, scene).passed
    except SceneError:
        return False


def test_a_scene_in_which_an_edit_moved_what_it_must_keep_does_not_pass() -> None:
    task, wrong = next((task, wrong) for task in load_tasks() for wrong in task.wrong if wrong.breaks in keeping(task))
    assert KEEP in score_of(task, scene_of(wrong.program)).failed(task)


def keeping(task: BenchTask) -> str:
    """Return the words of a task that say what its edit leaves alone."""
    return " ".join(clause.says for clause in task.clauses if clause.keep)


@pytest.mark.parametrize("name", NAMES)
def test_wrong_scenes_are_at_least_five_with_a_reason_each(task: BenchTask) -> None:
    assert len(task.wrong) == len({wrong.program for wrong in task.wrong}) >= 5
    assert all(wrong.breaks and wrong.why for wrong in task.wrong)


@pytest.mark.parametrize("name", [name for name in NAMES if name not in IMAGES])
def test_wrong_scenes_name_words_of_every_clause(task: BenchTask) -> None:
    named = [wrong.breaks for wrong in task.wrong]
    checked = [clause.says for clause in task.clauses if clause.is_checked]
    assert [says for says in checked if not any(words in says for words in named)] == []


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.sampled(40)
def test_every_clause_is_broken_by_a_wrong_scene(task: BenchTask) -> None:
    broken = {text for wrong in task.wrong for text in failed_of(task, wrong.program)}
    predicates = [(clause.says, {*clause.that, *([KEEP] if clause.keep else [])}) for clause in task.clauses]
    assert [says for says, stated in predicates if stated and not broken & stated] == []


def failed_of(task: BenchTask, program: str) -> list[str]:
    """Return the predicates that a program breaks; all declarations where they cannot be tested."""
    try:
        return score_of(task, scene_of(program)).failed(task)
    except SceneError:
        return list(task.that)


def test_the_hard_split_runs_only_when_it_is_asked_for() -> None:
    every = load_tasks()
    hard = [task for task in every if task.is_hard]
    assert [task.name for task in hard] == HARD
    assert len(hard) == 40
    assert {task.group for task in hard} == {"hard"}
    assert Counter(task.kind for task in hard) == {TaskKind.STILL: 35, TaskKind.FILM: 3, TaskKind.BLOCKS: 2}
    assert applicable(every, (), (), is_hard=True) == applicable(every, (), ["hard"]) == hard
    assert applicable(every, ["bicycle"], ()) == [task for task in hard if task.name == "bicycle"]
    assert not any(task.is_hard for task in applicable(every, (), ()))
    both = applicable(every, ["abacus"], (), is_hard=True)
    assert [task.name for task in both if not task.is_hard] == ["abacus"]
    assert len(both) == 41


def test_nearly_all_wrong_scenes_are_rejected() -> None:
    count = sum(len(task.wrong) for task in load_tasks())
    assert count > 1_000
    assert sum(map(len, MISSED.values())) <= 0.01 * count


@pytest.mark.parametrize("name", EDITS)
@pytest.mark.sampled(3)
def test_programs_to_edit_do_not_pass(task: BenchTask) -> None:
    assert task.program is not None
    assert not score_of(task, scene_of(task.program)).passed


@pytest.mark.parametrize("program", PROGRAMS, ids=range(len(PROGRAMS)))
def test_programs_to_edit_are_the_same_in_python(program: str) -> None:
    python = PROGRAMS[program]
    assert python is not None
    assert sl.diff(sl.evaluate(program), sl.evaluate(sl.transpile(python).text)).equal


def test_the_tasks_are_many_and_of_all_kinds() -> None:
    every = load_tasks()
    assert [task.name for task in every] == NAMES
    assert {task.program: task.python for task in every if task.program is not None} == PROGRAMS
    assert len(every) >= 180
    assert min(Counter(task.group for task in every).values()) >= 10
    assert {task.kind for task in every} == set(TaskKind)


def test_the_task_of_the_documentation() -> None:
    text = (Path(__file__).parents[2] / "docs" / "bench.md").read_text("utf-8")
    (task,) = tasks_of(Source("docs.toml", text.split("```toml\n")[1].split("```")[0]))
    assert score_of(task, scene_of(task.passes)).passed
    assert task.prompt == "Two red cups stand on a table, not touching each other."
    assert score_of(task, scene_of(task.wrong[0].program)).failed(task) == ['(on "cup" "table")', "geometry"]


def test_blocks_must_be_kept_as_well() -> None:
    build = """(bind "tower" (lambda () (call "set-cuboid" :block-type "minecraft:stone" :scale [2 5 2])))
    (bind "scene" (lambda () (call "tower")))(scene "scene")"""
    shares = [
        kept_share(scene_of(build), scene_of(after), ["tower"])
        for after in (build, build.replace("5", "6"), build.replace("stone", "dirt"))
    ]
    assert shares == [1.0, 0.0, 0.0]

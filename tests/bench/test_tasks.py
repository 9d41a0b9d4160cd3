"""Every task of the benchmark has a program that passes, and near misses that fail one of its predicates."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

import scenelang as sl
from scenelang.backends.geometry.relations import reasons
from scenelang.bench.scoring import kept_share, scene_of, score_of
from scenelang.bench.tasks import KEEP, BenchTask, load_tasks, tasks_of
from scenelang.grammar.datum import Source
from scenelang.inference.brief import TaskKind
from scenelang.inference.steps import has_blocks
from scenelang.interpreter.scene.entity import count_words

TASKS = load_tasks()


@pytest.mark.parametrize("task", TASKS, ids=lambda task: task.name)
@pytest.mark.sampled(8)
def test_a_program_passes(task: BenchTask) -> None:
    scene = scene_of(task.passes)
    score = score_of(task, scene)
    assert score.failed(task) == [], score.reasons
    assert scene.animated == (task.kind is TaskKind.FILM)
    assert has_blocks(scene) == (task.kind is TaskKind.BLOCKS)


@pytest.mark.parametrize("task", TASKS, ids=lambda task: task.name)
@pytest.mark.sampled(8)
def test_near_misses_fail(task: BenchTask) -> None:
    for near in task.near:
        assert near.program != task.passes
        scene = scene_of(near.program)
        if near.fails == KEEP:
            assert kept_share(scene_of(str(task.program)), scene, task.keep) < 1.0, near
        else:
            stated = task.declarations[task.that.index(near.fails)]
            assert reasons(scene, [stated]) != [None], near


@pytest.mark.parametrize("task", TASKS, ids=lambda task: task.name)
def test_every_predicate_has_a_near_miss(task: BenchTask) -> None:
    missed = {near.fails for near in task.near}
    assert {*task.that, *(["keep"] if task.keep else [])} <= missed


@pytest.mark.parametrize("task", [task for task in TASKS if task.program is not None], ids=lambda task: task.name)
@pytest.mark.sampled(3)
def test_programs_to_edit_do_not_pass(task: BenchTask) -> None:
    assert task.program is not None
    assert not score_of(task, scene_of(task.program)).passed


PROGRAMS = {task.program: task.python for task in TASKS if task.program is not None}


@pytest.mark.parametrize("program", PROGRAMS, ids=range(len(PROGRAMS)))
def test_programs_to_edit_are_the_same_in_python(program: str) -> None:
    python = PROGRAMS[program]
    assert python is not None
    assert sl.diff(sl.evaluate(program), sl.evaluate(sl.transpile(python).text)).equal


@pytest.mark.slow
def test_near_misses_have_no_instance_one_or_too_many_and_the_wrong_side() -> None:
    found: Counter[str] = Counter()
    for task, near in [(each, near) for each in TASKS for near in each.near if near.fails != KEEP]:
        stated = task.declarations[task.that.index(near.fails)]
        if stated.relation == "count" and stated.number is not None:
            count = count_words(scene_of(near.program).root).get(stated.things[0], 0)
            found["none" if not count else "many" if count > stated.number else "one" if count == 1 else "fewer"] += 1
        elif stated.relation in {"left-of", "right-of", "in-front-of", "behind", "facing", "symmetric"}:
            found["side"] += 1
    assert min(found[kind] for kind in ("none", "one", "many", "fewer", "side")) >= 15, found


def test_the_tasks_are_many_and_of_all_kinds() -> None:
    assert len(TASKS) >= 180
    assert min(Counter(task.group for task in TASKS).values()) >= 10
    assert {task.kind for task in TASKS} == set(TaskKind)


def test_the_task_of_the_documentation() -> None:
    text = (Path(__file__).parents[2] / "docs" / "bench.md").read_text("utf-8")
    (task,) = tasks_of(Source("docs.toml", text.split("```toml\n")[1].split("```")[0]))
    assert score_of(task, scene_of(task.passes)).passed
    assert score_of(task, scene_of(task.near[0].program)).failed(task) == [task.near[0].fails]


def test_blocks_must_be_kept_as_well() -> None:
    build = """(bind "tower" (lambda () (call "set-cuboid" :block-type "minecraft:stone" :scale [2 5 2])))
    (bind "scene" (lambda () (call "tower")))(scene "scene")"""
    shares = [
        kept_share(scene_of(build), scene_of(after), ["tower"])
        for after in (build, build.replace("5", "6"), build.replace("stone", "dirt"))
    ]
    assert shares == [1.0, 0.0, 0.0]

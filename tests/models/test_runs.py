"""`scenelang runs`: the list of runs, the attempts of one, damaged folders."""

from __future__ import annotations

import json

import pytest

from models.conftest import Place, cubes
from models.server import Said

pytestmark = pytest.mark.usefixtures("untried")


def test_no_runs(place: Place) -> None:
    done = place.run("runs")
    assert (done.code, done.out) == (0, f"no runs in {place.runs}\n")


def test_the_list_and_the_attempts_of_one(place: Place) -> None:
    place.serve([Said("nothing at all"), Said(cubes(2)), Said(cubes(1))])
    place.generate("two cubes", "-o", "a.scene")
    place.generate("one cube,\n\x1b[31mred", "-o", "b.scene")
    done = place.run("runs")
    header, first, second = done.out.splitlines()
    assert header.split() == ["run", "command", "state", "attempts", "cost", "task"]
    assert first.split()[1:4] == ["generate", "done", "2"]
    assert first.endswith("two cubes")
    assert "\x1b" not in second
    name = first.split()[0]
    done = place.run("runs", name)
    rows = [line.split() for line in done.out.splitlines()[4:]]
    assert [row[2] for row in rows] == ["draft", "repair"]
    assert rows[0][-2:] == ["1", "error"]
    assert rows[1][-2:] == ["a", "scene"]
    data = json.loads(place.run("runs", name, "--json").out)
    costs = [attempt["cost"] for attempt in data["attempts"]]
    assert data["cost"] == sum(costs)
    assert all(cost > 0 for cost in costs)
    listed = json.loads(place.run("runs", "--json").out)
    assert [run["attempts"] for run in listed] == [2, 1]


def test_what_was_kept_from_an_earlier_run_costs_nothing(place: Place) -> None:
    place.serve([Said(cubes())])
    place.generate("a cube", "-o", "a.scene")
    place.generate("a cube", "-o", "b.scene")
    assert "cached" in place.run("runs", "last").out.splitlines()[-1]
    first, second = json.loads(place.run("runs", "--json").out)
    assert (first["cost"] > 0, second["cost"]) == (True, 0.0)


def test_a_killed_run_reads_interrupted(place: Place) -> None:
    place.serve([Said(cubes())])
    place.generate("a cube", "-o", "a.scene")
    path = place.run_folder() / "run.json"
    path.write_text(path.read_text().replace('"done"', '"running"'))
    assert place.run("runs").out.splitlines()[1].split()[2] == "interrupted"


def test_damaged_folders_are_told(place: Place) -> None:
    place.serve([Said(cubes())])
    place.generate("a cube", "-o", "a.scene")
    for name, text in (("x", "{"), ("y", "[]"), ("z", '{"version": 1}')):
        (place.runs / name).mkdir()
        (place.runs / name / "run.json").write_text(text)
    rows = [line.split() for line in place.run("runs").out.splitlines()]
    assert [row[:2] for row in rows[2:]] == [[name, "damaged"] for name in "xyz"]
    done = place.run("runs", "z")
    assert (done.code, "is damaged" in done.err) == (1, True)


def test_a_run_is_found_by_beginning_and_by_path(place: Place) -> None:
    place.serve([Said(cubes()), Said(cubes(2))])
    place.generate("a cube", "-o", "a.scene")
    place.generate("b cube", "-o", "b.scene")
    first, second = sorted(path.name for path in place.runs.iterdir())
    assert first in place.run("runs", first[:-1]).out
    assert second in place.run("runs", str(place.runs / second)).out
    done = place.run("runs", "20")
    assert (done.code, "ambiguous run name" in done.err) == (1, True)

"""`sl.generate`, `sl.edit`, `sl.estimate`, `sl.resume` and `sl.runs`, against a server that answers from a script."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

import scenelang as sl
from models.conftest import WRONG, Place, answers, cubes
from models.server import Said

pytestmark = pytest.mark.usefixtures("untried")

TOWER = """
(bind "tower" (lambda () (union-loop 3 (lambda (i) (transform (call "cube") (translate [0 (+ i .5) 0]))))))
"""


def test_generate_gives_scene_program_and_cost(place: Place) -> None:
    server = place.serve(answers(WRONG, cubes(2)))
    made = sl.generate("two cubes", model="claude-sonnet-5-5", runs="runs")
    assert [request["model"] for request in server.requests] == ["claude-sonnet-5-5"] * 2
    assert made.scene.count()["cube"] == 2
    assert sl.evaluate(made.program).count() == made.scene.count()
    assert made.save("pile.scene").read_text() == made.program
    assert 0 < made.cost < 1
    (run,) = sl.runs("runs")
    assert run.path.resolve() == made.run.resolve()
    assert repr(run).startswith("<Run ")
    assert "\n" not in repr(made)


@pytest.mark.usefixtures("small_pictures")
def test_settings_and_their_limits(place: Place) -> None:
    place.serve(answers(*[cubes(n) for n in (1, 2)]))
    made = sl.generate("cubes", settings=sl.InferenceSettings(samples=2, uses_replies=False))
    assert made.sample in (1, 2)
    with pytest.raises(sl.UsageError, match="expected `samples` between 1 and 64, got 0"):
        sl.generate("a cube", settings=sl.InferenceSettings(samples=0))
    with pytest.raises(sl.UsageError, match="expected a text prompt, or an image with --image"):
        sl.generate("")


def test_an_estimate_sends_nothing(place: Place) -> None:
    server = place.serve(answers(cubes()))
    found = sl.estimate("a chess board", model="claude-opus-5-5", settings=sl.InferenceSettings(samples=4))
    once = sl.estimate("a chess board", model="claude-opus-5-5")
    assert found.cost == pytest.approx(4 * once.cost)
    assert found.payload["model"] == "claude-opus-5-5"
    Path("tower.scene").write_text(TOWER)
    assert "union-loop 3" in str(sl.estimate("make it taller", "tower.scene"))
    assert server.requests == []


def test_edit_shows_what_it_did_and_overwrites_on_demand(place: Place) -> None:
    path = Path("tower.scene")
    path.write_text(TOWER)
    place.serve([Said(f"```scene\n{TOWER.replace('loop 3', 'loop 5')}```")])
    done = sl.edit(path, "two more floors")
    assert (done.before.count()["cube"], done.scene.count()["cube"]) == (3, 5)
    assert "-(bind" in done.diff
    assert not done.changes.equal
    assert path.read_text() == TOWER
    done.apply()
    assert sl.load(path).count()["cube"] == 5


def test_a_failed_run_goes_on_with_another_limit(place: Place) -> None:
    place.serve(answers(WRONG))
    with pytest.raises(sl.SceneError):
        sl.generate("a cube", settings=sl.InferenceSettings(repairs=0))
    place.serve(answers(cubes()))
    with pytest.raises(sl.UsageError, match="`model` cannot be changed for a resumed run"):
        sl.resume(settings={"model": "another"})
    done = sl.resume(settings={"repairs": 2})
    assert isinstance(done, sl.Generated)
    assert done.scene.count()["cube"] == 1


def test_a_wrong_program_is_not_sent(place: Place) -> None:
    server = place.serve(answers(cubes()))
    Path("wrong.scene").write_text('(bind "a" (lambda () (call "cub" :scale)))')
    with pytest.raises(sl.SceneError):
        sl.edit("wrong.scene", "make it red")
    assert server.requests == []


@pytest.mark.parametrize("provider", ["anthropic", "openai"])
def test_an_estimate_needs_no_package_and_asking_names_it(
    provider: str, place: Place, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, provider, None)
    settings = sl.InferenceSettings(provider=provider, model="m", price="1,2")
    assert sl.estimate("a cube", settings=settings).payload["model"] == "m"
    with pytest.raises(sl.SceneError, match=f"requires the package `{provider}`"):
        sl.generate("a cube", settings=settings)

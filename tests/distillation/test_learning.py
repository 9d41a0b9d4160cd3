"""The optimisation on small random models: it goes on after a break as it would have, figures learn alone, the scene's
term moves poses, Gaussians come and go."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from later import later
from sampling import one_in
from small_models import seeded, small_diffusion
from support import evaluate

from scenelang.backends.neural.diffusion_loading import load_diffusion
from scenelang.backends.neural.distillation.run import (
    check_same,
    load_checkpoint,
    run_config,
    save_checkpoint,
    unchanged_groups,
)
from scenelang.backends.neural.distillation.terms import Theta, densify_and_prune, initial_theta
from scenelang.backends.neural.distillation.training import (
    DistillationSettings,
    DistillationTrainer,
    SceneGroups,
    Teachers,
    group_leaves,
)
from scenelang.backends.neural.prompts import Granularity, PromptContext, leaves_of
from scenelang.grammar.diagnostics import SceneError

torch = later("torch")

TWO = """
(bind "toys" (lambda () (union (call "sphere" :text "red") (transform (call "cube" :color [0 0 1]) (translate [3 0 0])))))
"""
SETTINGS = DistillationSettings(
    steps=12, initial_gaussians=60, max_gaussians=90, densify_interval=4, depth_gaussians=100
)


@pytest.fixture(scope="module")
def models(tmp_path_factory: pytest.TempPathFactory) -> tuple[Any, Any]:
    seeded()
    folder = tmp_path_factory.mktemp("models")
    figures = load_diffusion(small_diffusion(folder / "figures", pixels=True))
    return figures, load_diffusion(small_diffusion(folder / "scene", views=False, control=True))


def cast(text: str = TWO) -> SceneGroups:
    return group_leaves(leaves_of(evaluate(text), Granularity(), PromptContext()))


def learning(
    models: Any, text: str = TWO, scene: bool = False, frozen: Any = None, **settings: Any
) -> DistillationTrainer:
    teachers = Teachers(models[0], models[1] if scene else None, {}, ("toys",))
    return DistillationTrainer(cast(text), teachers, replace(SETTINGS, **settings), "cpu", frozen or {})


def steps(one: DistillationTrainer, count: int) -> DistillationTrainer:
    for _ in range(count):
        one.step()
    return one


@pytest.mark.parametrize("scene", [False, True])
@pytest.mark.slow
def test_a_run_goes_on_as_it_would_have(models: Any, scene: bool, tmp_path: Path) -> None:
    whole = steps(learning(models, scene=scene), 10)
    first = steps(learning(models, scene=scene), 6)
    asked = run_config(SETTINGS, ["m"], "toys")
    save_checkpoint(tmp_path, first.state(), first.scene, asked, 1.5)
    kept = load_checkpoint(tmp_path)
    check_same(kept, first.scene, asked)
    again = learning(models, scene=scene)
    again.restore(kept.tensors)
    steps(again, 4)
    one, other = whole.state(), again.state()
    assert one.keys() == other.keys()
    for name in one:
        assert one[name].equal(other[name]), name
    assert len(whole.groups[0].theta) != SETTINGS.initial_gaussians  # densification was part of it


def test_a_seed_is_a_result(models: Any) -> None:
    one, same, other = (steps(learning(models, seed=seed), 4).state() for seed in (1, 1, 2))
    assert all(one[name].equal(same[name]) for name in one)
    assert not one["figure/0/theta/means"].equal(other["figure/0/theta/means"])


def test_what_one_thing_is_told_changes_no_other(models: Any) -> None:
    one = steps(learning(models), 8).state()
    other = steps(learning(models, TWO.replace("red", "green and mossy")), 8).state()
    assert not one["figure/0/theta/colors"].equal(other["figure/0/theta/colors"])
    assert one["figure/1/theta/colors"].equal(other["figure/1/theta/colors"])


def test_poses_move_by_the_term_of_the_scene_only(models: Any) -> None:
    alone, together = (steps(learning(models, scene=scene), 3) for scene in (False, True))
    assert float(alone.offsets.translations.detach().abs().max()) == 0.0
    assert float(together.offsets.translations.detach().abs().max()) > 0.0
    assert float(together.offsets.log_scales.detach().abs().max()) > 0.0


def test_the_scene_counts_once_where_each_thing_counts_once(models: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """The paper's sum: one term of the scene and one of each of N things."""
    three = TWO.replace("(union ", '(union (call "cone" :text "tree") ')
    one = learning(models, three, scene=True)
    asked: list[int] = []
    for number, model in enumerate(models):
        predict = type(model).predict
        monkeypatch.setattr(
            type(model), "predict", lambda self, *a, p=predict: (asked.append(self.views), p(self, *a))[1]
        )
        if number == 0 and type(models[1]) is type(model):
            break
    steps(one, 6)
    assert [asked.count(views) for views in (4, 1)] == [6, 2]


def test_a_thing_follows_the_scene_at_its_own_turn(models: Any) -> None:
    """A round makes one step of each thing's optimiser, by the sum of its own terms and the scene's."""
    one = learning(models, scene=True)
    before = one.groups[1].theta.means.detach().clone()
    one.step()
    waiting = one.groups[1].theta.means.grad
    assert waiting is not None
    assert float(waiting.abs().max()) > 0.0
    assert one.groups[1].theta.means.detach().equal(before)
    assert one.groups[0].theta.means.grad is None
    one.step()
    assert one.groups[1].theta.means.grad is None
    assert not one.groups[1].theta.means.detach().equal(before)
    counts = {int(each.state()["adam/means/step"]) for each in one.groups}
    assert counts == {1}


def test_a_grey_thing_has_gradients_by_its_opacities(models: Any) -> None:
    one = learning(models)
    theta = one.groups[0].theta
    with torch.no_grad():
        theta.colors.zero_()  # the grey of 0.5
    told, _, _ = one._group_terms(0, 0.0, torch.Generator().manual_seed(0))
    told.backward()
    assert theta.opacities.grad is not None
    assert float(theta.opacities.grad.abs().max()) > 1e-6


@pytest.mark.parametrize("most", one_in(4, [700, 60, 90, 200]))
@pytest.mark.sampled(2)
def test_a_thing_grows_to_as_many_gaussians_as_are_asked_for(models: Any, most: int) -> None:
    one = steps(
        learning(models, '(bind "ball" (lambda () (call "sphere")))', max_gaussians=most, densify_interval=2), 12
    )
    assert len(one.groups[0].theta) == most


def test_the_growth_reaches_any_number_in_any_number_of_steps() -> None:
    for count in (1, 60, 2000, 5000):
        for most in (16, 1000, 20_000, 300_000):
            plan = DistillationSettings(steps=count, max_gaussians=most)
            assert plan.start_gaussians <= most <= plan.start_gaussians * 2**plan.densifications
            assert plan.start_gaussians >= min(plan.initial_gaussians, most)


def test_what_is_taken_over_stays(models: Any, tmp_path: Path) -> None:
    before = steps(learning(models), 6)
    save_checkpoint(tmp_path, before.state(), before.scene, {}, 0.0)
    text = TWO.replace("red", "golden")
    frozen = unchanged_groups(load_checkpoint(tmp_path), cast(text))
    assert list(frozen) == [1]
    for scene in (False, True):
        after = steps(learning(models, text, scene, frozen), 4)
        assert after.steps == SETTINGS.steps
        assert after.state()["figure/1/theta/means"].equal(before.state()["figure/1/theta/means"])
        assert not after.state()["figure/0/theta/means"].equal(before.state()["figure/0/theta/means"])


def test_another_scene_or_other_settings_do_not_go_on(models: Any, tmp_path: Path) -> None:
    one = learning(models)
    save_checkpoint(tmp_path, one.state(), one.scene, run_config(SETTINGS, ["m"], "toys"), 0.0)
    kept = load_checkpoint(tmp_path)
    check_same(kept, cast(), run_config(replace(SETTINGS, steps=99), ["m"], "toys"))
    with pytest.raises(SceneError, match="other settings: seed"):
        check_same(kept, cast(), run_config(replace(SETTINGS, seed=5), ["m"], "toys"))
    with pytest.raises(SceneError, match="another scene"):
        check_same(kept, cast(TWO.replace("red", "green")), run_config(SETTINGS, ["m"], "toys"))


@pytest.mark.parametrize("damage", ["cut", "text", "other", "shapes"])
def test_damaged_runs_are_told(models: Any, tmp_path: Path, damage: str) -> None:
    from safetensors.torch import save_file

    one = learning(models)
    save_checkpoint(tmp_path, one.state(), one.scene, {}, 0.0)
    path = tmp_path / "state.safetensors"
    if damage == "cut":
        path.write_bytes(path.read_bytes()[:-900])
    elif damage == "text":
        path.write_text("no")
    elif damage == "other":
        save_file({"a": torch.zeros(2)}, path)
    else:
        save_checkpoint(tmp_path, one.state() | {"figure/0/theta/means": torch.zeros(5, 2)}, one.scene, {}, 0.0)
    with pytest.raises(SceneError, match="is not a readable distillation checkpoint"):
        load_checkpoint(tmp_path)
    path.unlink()
    with pytest.raises(SceneError, match="no distillation in"):
        load_checkpoint(tmp_path)


# --- density -------------------------------------------------------------------------------------------------------


def theta(count: int = 40) -> Theta:
    return initial_theta(torch.ones(3), count, torch.Generator().manual_seed(0))


def test_the_unseen_and_the_far_go() -> None:
    one = theta()
    one.opacities[:5] = -9.0
    one.means[5] = torch.tensor([0.0, 3.0, 0.0])
    found = densify_and_prune(one, torch.ones(3), torch.zeros(40), 34, torch.Generator())
    assert found.source.tolist() == list(range(6, 40))
    assert not found.is_new.any()


def test_some_always_stay() -> None:
    one = theta()
    one.opacities[:] = -9.0
    assert len(densify_and_prune(one, torch.ones(3), torch.zeros(40), 99, torch.Generator()).theta) >= 16


def test_what_is_pulled_becomes_more() -> None:
    one = theta()
    one.log_scales[:] = -4.0
    one.log_scales[7] = 0.0
    pull = torch.zeros(40)
    pull[[3, 7, 9]] = torch.tensor([5.0, 9.0, 1.0])
    found = densify_and_prune(one, torch.full((3,), 9.0), pull, 43, torch.Generator().manual_seed(1))
    assert len(found.theta) == 43
    assert sorted(found.source[40:].tolist()) == [3, 7, 9]
    assert found.is_new.nonzero()[:, 0].tolist() == [7, 40, 41, 42]  # a large one is split, so both halves are new
    halves = (found.source == 7).nonzero()[:, 0]
    assert float(found.theta.log_scales[halves].exp().max()) == pytest.approx(1 / 1.6)
    assert not found.theta.means[halves[0]].equal(found.theta.means[halves[1]])
    assert len(densify_and_prune(one, torch.full((3,), 9.0), pull, 41, torch.Generator().manual_seed(1)).theta) == 41

"""Textual Inversion on the toy model: what it minimises, what moves, and that a break changes nothing."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from later import later
from small_models import seeded, small_diffusion

from inversion.support import shown, starts, subject, toy
from scenelang.backends.neural.clip import Slot
from scenelang.backends.neural.diffusion import ClipPromptEncoder, DiffusionModel
from scenelang.backends.neural.diffusion_loading import load_any
from scenelang.backends.neural.inversion import (
    CHECKPOINT,
    STYLE,
    InversionSettings,
    InversionTrainer,
    LearnedSubject,
    denoising_loss,
    entity_prompt,
    initial_vector,
    load_checkpoint,
    run,
    run_config,
    style_prompt,
)
from scenelang.grammar.diagnostics import SceneError

torch = later("torch")


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> DiffusionModel:
    return toy(tmp_path_factory.mktemp("models") / "toy")


def learning(model: DiffusionModel, **settings: Any) -> InversionTrainer:
    return InversionTrainer(
        model, [subject("z2", "red", "cube")], starts(model, "z2"), InversionSettings(**{"batch_size": 1, **settings})
    )


def weights(model: DiffusionModel) -> str:
    """What tells all weights of a model, to the bit."""
    found = hashlib.sha256()
    words = model.text_encoder
    text = words._encoder._text if isinstance(words, ClipPromptEncoder) else words.network  # type: ignore[attr-defined]
    for network in (model.network, text):
        for name, tensor in network.state_dict().items():
            found.update(name.encode() + tensor.numpy().tobytes())
    return found.hexdigest()


def test_the_sentence_is_the_papers() -> None:
    assert entity_prompt("z2") == (Slot("z2"), ", 3d model, in the style of ", Slot(STYLE))
    assert style_prompt("stone moai") == ("stone moai, 3d model, in the style of ", Slot(STYLE))


def test_the_loss_is_lower_and_only_two_vectors_move(model: DiffusionModel) -> None:
    before, begun = weights(model), starts(model, "z2")
    work = learning(model)
    assert {name: vector.tolist() for name, vector in work.vectors().items()} == {
        name: vector.tolist() for name, vector in begun.items()
    }
    first = work.mean_loss()
    assert work.mean_loss() == first, "the same noise every time"
    for _ in range(50):
        work.step()
    assert work.mean_loss() < 0.5 * first
    assert weights(model) == before
    after = work.vectors()
    assert sorted(after) == [STYLE, "z2"]
    assert all(np.abs(after[name] - begun[name].numpy()).max() > 0.05 for name in after)
    assert all(parameter.grad is None for parameter in model.network.parameters())


@pytest.mark.slow
def test_the_model_knows_the_thing_again(model: DiffusionModel) -> None:
    """The learned sentence fits its own picture better than that of another thing, and the other way round."""
    found = {}
    pictures = {"z2": ("red", "cube"), "z3": ("blue", "sphere")}
    for name, (color, shape) in pictures.items():
        work = InversionTrainer(
            model, [subject(name, color, shape)], starts(model, name), InversionSettings(batch_size=1)
        )
        for _ in range(40):
            work.step()
        found[name] = {key: torch.from_numpy(vector) for key, vector in work.vectors().items()}
    loss = lambda name, shown_as: InversionTrainer(
        model, [LearnedSubject(shown(*pictures[shown_as]), entity_prompt(name))], found[name], InversionSettings()
    ).mean_loss()
    assert loss("z2", "z2") < 0.85 * loss("z3", "z2")
    assert loss("z3", "z3") < 0.85 * loss("z2", "z3")


@pytest.mark.slow
def test_several_things_share_a_style(model: DiffusionModel) -> None:
    subjects = [subject("z2", "red", "cube"), subject("z3", "blue", "sphere")]
    work = InversionTrainer(model, subjects, starts(model, "z2", "z3"), InversionSettings(batch_size=1))
    first = work.mean_loss()
    alone = [
        InversionTrainer(model, [each], starts(model, "z2", "z3"), InversionSettings(loss_samples=32)).mean_loss()
        for each in subjects
    ]
    assert first == pytest.approx(float(np.mean(alone)), rel=0.2), "the mean of both"
    for _ in range(25):
        work.step()
    assert work.mean_loss() < 0.75 * first
    assert sorted(work.vectors()) == [STYLE, "z2", "z3"]


@pytest.mark.slow
def test_the_style_alone(model: DiffusionModel) -> None:
    about = LearnedSubject(shown("green", "cube"), style_prompt("cube"))
    work = InversionTrainer(
        model, [about], {STYLE: initial_vector(model.text_encoder, "toy")}, InversionSettings(batch_size=1)
    )
    first = work.mean_loss()
    for _ in range(40):
        work.step()
    assert work.mean_loss() < first, "little, since the toy was taught to heed no style"
    assert list(work.vectors()) == [STYLE]


# --- the objective ---------------------------------------------------------------------------------------------------


def _scheduler(kind: str) -> Any:
    from diffusers import DDPMScheduler

    return DDPMScheduler(
        num_train_timesteps=1000, beta_start=0.00085, beta_end=0.012, beta_schedule="scaled_linear", prediction_type=kind
    )  # fmt: skip


def test_the_loss_is_that_of_diffusers_training(model: DiffusionModel) -> None:
    """Noise and velocity by diffusers, the network without views or cameras by its own call."""
    generator = torch.Generator().manual_seed(1)
    latents = model.codec.encode(shown("red", "cube")[None]).expand(3, -1, -1, -1)
    noise, steps = torch.randn(latents.shape, generator=generator), torch.tensor([5, 400, 990])
    states = model.text_encoder.encode([("a red cube, 3D model",)]).expand(3, -1, -1)
    scheduler = _scheduler("v_prediction")
    noisy = scheduler.add_noise(latents, noise, steps)
    with torch.no_grad():
        found = denoising_loss(model, latents, states, steps, noise)
        rows = [
            model.network(noisy[i : i + 1], steps[i : i + 1], encoder_hidden_states=states[i : i + 1],
                          class_labels=torch.zeros(1, 16)).sample
            for i in range(3)
        ]  # fmt: skip
    wanted = ((torch.cat(rows) - scheduler.get_velocity(latents, noise, steps)) ** 2).mean()
    assert float(found) == pytest.approx(float(wanted), rel=1e-4)


def test_what_networks_are_trained_to_say(model: DiffusionModel) -> None:
    from dataclasses import replace

    clean, noise = torch.randn(2, 3, 4, 4), torch.randn(2, 3, 4, 4)
    steps = torch.tensor([10, 700])
    schedule = model.schedule
    assert torch.equal(replace(schedule, prediction_type="epsilon").training_target(clean, noise, steps), noise)
    assert torch.equal(replace(schedule, prediction_type="sample").training_target(clean, noise, steps), clean)
    velocity = replace(schedule, prediction_type="v_prediction").training_target(clean, noise, steps)
    assert torch.allclose(velocity, _scheduler("v_prediction").get_velocity(clean, noise, steps), atol=1e-5)


def test_a_step_is_adamws(model: DiffusionModel) -> None:
    """The second step too, by the formulas of its paper: momentum, bias corrected, decay of a hundredth."""
    work = learning(model)
    begun = {name: vector.astype(np.float64) for name, vector in work.vectors().items()}
    gradients = []
    for _ in range(2):
        work.step()
        gradients.append({name: v.grad.double().numpy().copy() for name, v in work._vectors.items()})
    for name, after in work.vectors().items():
        value, mean, square = begun[name], 0.0, 0.0
        for number, gradient in enumerate((g[name] for g in gradients), start=1):
            value = value * (1.0 - 0.01 * 0.01)
            mean, square = 0.9 * mean + 0.1 * gradient, 0.999 * square + 0.001 * gradient**2
            value = value - 0.01 * (mean / (1 - 0.9**number)) / (np.sqrt(square / (1 - 0.999**number)) + 1e-8)
        assert np.allclose(after, value, atol=1e-6)


def test_the_seed_decides(model: DiffusionModel) -> None:
    one, same, other = (learning(model, seed=seed) for seed in (3, 3, 4))
    losses = [[work.step() for _ in range(3)] for work in (one, same, other)]
    assert losses[0] == losses[1]
    assert losses[0] != losses[2]
    assert all(np.array_equal(one.vectors()[name], same.vectors()[name]) for name in one.vectors())


def test_models_of_single_pictures(tmp_path: Path) -> None:
    """Stable Diffusion's layout, with an autoencoder and predicted noise."""
    seeded()
    model = load_any(str(small_diffusion(tmp_path / "sd", views=False)))
    assert model.views == 1
    picture = torch.rand(3, model.size, model.size)
    begun = {
        "z2": initial_vector(model.text_encoder, "stone statue"),
        STYLE: initial_vector(model.text_encoder, "photo"),
    }
    assert torch.allclose(begun["z2"], model.text_encoder.token_embeddings("stone statue").mean(0, keepdim=True))
    work = InversionTrainer(
        model, [LearnedSubject(picture, entity_prompt("z2"))], begun, InversionSettings(batch_size=2)
    )
    with torch.no_grad():
        latents, states = model.codec.encode(picture[None]), model.text_encoder.encode([entity_prompt("z2")], begun)
        noise, steps = torch.randn(latents.shape), torch.tensor([300])
        noisy = _scheduler("epsilon").add_noise(latents, noise, steps)
        wanted = ((model.network(noisy, steps, encoder_hidden_states=states).sample - noise) ** 2).mean()
        assert float(denoising_loss(model, latents, states, steps, noise)) == pytest.approx(float(wanted), rel=1e-4)
    before = weights(model)
    work.step()
    assert weights(model) == before
    assert all(not np.array_equal(work.vectors()[name], begun[name].numpy()) for name in begun)


def test_a_start_without_tokens(model: DiffusionModel) -> None:
    with pytest.raises(SceneError, match="no tokens"):
        initial_vector(model.text_encoder, "  ")


@pytest.mark.parametrize(
    "wrong",
    [{"steps": 0}, {"learning_rate": 0.0}, {"learning_rate": float("nan")}, {"batch_size": 0}, {"batch_size": 1000}],
)
def test_settings_that_make_no_sense(wrong: dict[str, Any]) -> None:
    with pytest.raises(SceneError) as caught:
        InversionSettings(**wrong)
    assert caught.value.name == "value"


# --- breaks ----------------------------------------------------------------------------------------------------------


def asked(model: DiffusionModel, steps: int = 12, **settings: Any) -> dict[str, Any]:
    shown_things = [subject("z2", "red", "cube")]
    return run_config(
        InversionSettings(steps=steps, batch_size=1, **settings), model.name, shown_things, {"z2": "sphere"}
    )


@pytest.mark.slow
def test_a_run_that_was_broken_off_ends_as_if_it_had_not(model: DiffusionModel, tmp_path: Path) -> None:
    for name in ("whole", "broken"):
        (tmp_path / name).mkdir()
    whole = learning(model, steps=12)
    outcome = run(whole, tmp_path / "whole", asked(model))
    told: list[int] = []
    half = learning(model, steps=12)
    stopped = run(
        half, tmp_path / "broken", asked(model), None, lambda now: told.append(now.done), lambda: len(told) == 5
    )
    assert not stopped.finished
    assert told == [1, 2, 3, 4, 5]
    kept = load_checkpoint(tmp_path / "broken")
    assert (kept.done, kept.finished) == (5, False)
    rest = learning(model, steps=12)
    again = run(rest, tmp_path / "broken", asked(model), kept)
    assert again == outcome
    assert all(np.array_equal(rest.vectors()[name], whole.vectors()[name]) for name in whole.vectors())
    assert load_checkpoint(tmp_path / "broken").losses == load_checkpoint(tmp_path / "whole").losses
    assert load_checkpoint(tmp_path / "broken").finished
    more = learning(model, steps=14)
    assert run(more, tmp_path / "broken", asked(model, 14), load_checkpoint(tmp_path / "broken")).finished


def test_only_the_same_run_goes_on(model: DiffusionModel, tmp_path: Path) -> None:
    run(learning(model, steps=2, loss_samples=2), tmp_path, asked(model, 2))
    kept = load_checkpoint(tmp_path)
    for other, text in (
        ({"seed": 1}, "other settings: seed"),
        ({"learning_rate": 0.5}, "other settings: learning_rate"),
    ):
        with pytest.raises(SceneError, match=text):
            run(learning(model, steps=2, **other), tmp_path, asked(model, 2, **other), kept)
    with pytest.raises(SceneError, match="2 steps already"):
        run(learning(model, steps=1), tmp_path, asked(model, 1), kept)
    elsewhere = {**asked(model, 2), "pictures": [["another", "picture"]]}
    with pytest.raises(SceneError, match="other settings: pictures"):
        run(learning(model, steps=2), tmp_path, elsewhere, kept)


@pytest.fixture(scope="module")
def short_run(model: DiffusionModel, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("short")
    run(learning(model, steps=2, loss_samples=2), folder, asked(model, 2))
    return folder / CHECKPOINT


@pytest.mark.parametrize("damage", ["none", "text", "cut", "steps", "shape"])
def test_files_that_are_no_runs(model: DiffusionModel, short_run: Path, tmp_path: Path, damage: str) -> None:
    from safetensors import safe_open
    from safetensors.torch import save_file

    path = tmp_path / CHECKPOINT
    if damage != "none":
        path.write_bytes(short_run.read_bytes())
    if damage == "text":
        path.write_text("hello")
    if damage == "cut":
        path.write_bytes(path.read_bytes()[:-100])
    if damage in ("steps", "shape"):
        with safe_open(str(path), "pt") as file:
            told = file.metadata()
            tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
        if damage == "steps":
            told = {name: text.replace('"done": 2', '"done": 1') for name, text in told.items()}
        else:
            tensors = {name: tensor[:, :5].contiguous() for name, tensor in tensors.items()}
        save_file(tensors, path, metadata=told)
    with pytest.raises(SceneError) as caught:
        run(learning(model, steps=2), tmp_path, asked(model, 2), load_checkpoint(tmp_path))
    assert caught.value.name == "file"

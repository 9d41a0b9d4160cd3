"""Noise against diffusers' own schedulers."""

from __future__ import annotations

from typing import Any

import pytest
from small_models import seeded

from scenelang.backends.neural.diffusion import PREDICTION_TYPES, schedule_of
from scenelang.grammar.diagnostics import SceneError

CONFIGS: list[dict[str, Any]] = [
    {},
    {"beta_schedule": "scaled_linear", "beta_start": 0.00085, "beta_end": 0.012},
    {"beta_schedule": "linear", "num_train_timesteps": 300, "beta_end": 0.03},
    {"beta_schedule": "squaredcos_cap_v2"},
    {"beta_schedule": "scaled_linear", "beta_start": 0.00085, "beta_end": 0.012, "rescale_betas_zero_snr": True},
    {"trained_betas": [0.01, 0.02, 0.5]},
]


@pytest.mark.parametrize("config", CONFIGS)
def test_alphas_are_those_of_diffusers(config: dict[str, Any]) -> None:
    from diffusers import DDPMScheduler

    torch = seeded()
    expected = DDPMScheduler(**config)
    found = schedule_of({**expected.config})
    assert found.num_timesteps == len(expected.alphas_cumprod)
    assert torch.allclose(found.alphas_cumprod, expected.alphas_cumprod, rtol=1e-4, atol=1e-7)


@pytest.mark.parametrize("prediction", PREDICTION_TYPES)
def test_outputs_mean_what_they_do_in_diffusers(prediction: str) -> None:
    from diffusers import DDIMScheduler

    torch = seeded()
    other = DDIMScheduler(prediction_type=prediction, clip_sample=False, set_alpha_to_one=True)
    other.set_timesteps(1000)
    schedule = schedule_of({"prediction_type": prediction})
    clean, noise, output = torch.randn(3, 2, 4, 4).unbind(0)
    steps = torch.tensor([30, 800])
    noisy = schedule.add_noise(clean, noise, steps)
    assert torch.allclose(noisy, other.add_noise(clean, noise, steps), atol=1e-6)
    for row, step in enumerate(steps.tolist()):
        expected = other.step(output[row], step, noisy[row]).pred_original_sample
        assert torch.allclose(schedule.predicted_original(output, noisy, steps)[row], expected, rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("prediction", PREDICTION_TYPES)
def test_the_true_output_gives_back_picture_and_noise(prediction: str) -> None:
    torch = seeded()
    schedule = schedule_of({"prediction_type": prediction})
    clean, noise = torch.randn(2, 3, 4, 8, 8, dtype=torch.float64).unbind(0)
    steps = torch.tensor([0, 500, 999])
    alphas = schedule.alphas_cumprod.double()[steps][:, None, None, None]
    output = {
        "epsilon": noise,
        "v_prediction": alphas.sqrt() * noise - (1 - alphas).sqrt() * clean,
        "sample": clean,
    }[prediction]
    noisy = schedule.add_noise(clean, noise, steps)
    assert torch.allclose(schedule.predicted_original(output, noisy, steps), clean, atol=1e-4)
    assert torch.allclose(schedule.predicted_noise(output, noisy, steps), noise, atol=1e-4)


@pytest.mark.parametrize(
    ("config", "said"),
    [
        ({"prediction_type": "flow"}, "unsupported prediction type 'flow'"),
        ({"beta_schedule": "magic"}, "unsupported beta schedule 'magic'"),
        ({"num_train_timesteps": 10**9}, "10,000 timesteps"),
        ({"num_train_timesteps": "many"}, "'many'"),
        ({"beta_end": 4.0}, "not between 0 and 1"),
        ({"trained_betas": [2.0, 3.0]}, "not between 0 and 1"),
    ],
)
def test_schedules_that_are_none(config: dict[str, Any], said: str) -> None:
    with pytest.raises(SceneError, match=said) as caught:
        schedule_of(config)
    assert caught.value.name == "weights"

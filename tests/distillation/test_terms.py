"""The terms of the loss by themselves: SDS, L_reg, L_layout, where noise steps come from."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest
from later import later

from scenelang.backends.neural.diffusion import NoiseSchedule, PixelUnshuffle
from scenelang.backends.neural.distillation.terms import (
    MAX_AXIS_RATIO,
    Conditioning,
    Guidance,
    Theta,
    annealed_range,
    axis_ratio_loss,
    guided_loss,
    initial_theta,
    layout_loss,
    sds_loss,
)
from scenelang.backends.neural.splats.gaussians import rotations

torch = later("torch")


def model(predict: Any = None, views: int = 1) -> Any:
    schedule = NoiseSchedule(torch.linspace(0.999, 0.01, 100, dtype=torch.float64), "epsilon")
    return SimpleNamespace(schedule=schedule, codec=PixelUnshuffle(2), views=views, predict=predict)


def random(*shape: int, seed: int = 0) -> Any:
    return torch.randn(*shape, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)


@pytest.mark.parametrize(("weighting", "power"), [("sds", 1.0), ("uniform", 0.0)])
def test_the_gradient_is_that_of_dreamfusion(weighting: str, power: float) -> None:
    z, eps, said, unsaid = (random(3, 12, 4, 4, seed=i) for i in range(4))
    z.requires_grad_(True)
    steps, one = torch.tensor([5, 40, 90]), model()
    a = one.schedule.alphas_cumprod[steps][:, None, None, None]
    noisy = one.schedule.add_noise(z.detach(), eps, steps)
    guided_loss(one, z, eps, noisy, steps, said, unsaid, Guidance(7.5, weighting)).backward()
    wanted = (1.0 - a) ** power * (unsaid + 7.5 * (said - unsaid) - eps) / 3
    torch.testing.assert_close(z.grad, wanted)


def test_reconstruction_without_rescale_is_weighted_sds() -> None:
    """Its gradient is that of SDS times sqrt((1 - a) / a), for the guided noise."""
    z, eps, said, unsaid = (random(2, 12, 4, 4, seed=i) for i in range(4))
    z.requires_grad_(True)
    steps, one = torch.tensor([20, 60]), model()
    a = one.schedule.alphas_cumprod[steps][:, None, None, None]
    noisy = one.schedule.add_noise(z.detach(), eps, steps)
    guided_loss(one, z, eps, noisy, steps, said, unsaid, Guidance(3.0, "reconstruction", rescale=0.0)).backward()
    wanted = ((1.0 - a) / a).sqrt() * (unsaid + 3.0 * (said - unsaid) - eps) / 2
    torch.testing.assert_close(z.grad, wanted)


def test_rescaling_brings_the_contrast_back() -> None:
    z, eps, said, unsaid = (random(4, 12, 4, 4, seed=i) for i in range(4))
    steps, one = torch.full((4,), 80), model(views=4)
    a = one.schedule.alphas_cumprod[80]
    noisy = one.schedule.add_noise(z, eps, steps)
    z.requires_grad_(True)
    guided_loss(one, z, eps, noisy, steps, said, unsaid, Guidance(50.0, "reconstruction", rescale=1.0)).backward()
    target = z.detach() - 4 * z.grad
    calm = (noisy - (1.0 - a).sqrt() * said) / a.sqrt()
    torch.testing.assert_close(target.std(), calm.std())


def test_the_true_picture_is_where_it_settles() -> None:
    """A denoiser that knows the picture pulls another one to it, through the pixels."""
    wanted = torch.rand(4, 3, 8, 8, generator=torch.Generator().manual_seed(1), dtype=torch.float64)
    one = model(views=4)
    clean = one.codec.encode(wanted)

    def predict(noisy: Any, steps: Any, *_: Any) -> Any:
        a = one.schedule.alphas_cumprod[steps][:, None, None, None]
        return (noisy - a.sqrt() * clean.repeat(2, 1, 1, 1)) / (1.0 - a).sqrt()

    one.predict = predict
    pictures = torch.full_like(wanted, 0.5).requires_grad_(True)
    adam = torch.optim.Adam([pictures], lr=0.05)
    states = torch.zeros(4, 5, 8)
    for number in range(120):
        adam.zero_grad()
        heard = Conditioning(states, states, cameras=torch.zeros(4, 16))
        sds_loss(one, pictures, heard, Guidance(1.0), annealed_range(number / 120), _generator(number)).backward()
        adam.step()
    assert float((pictures.detach() - wanted).abs().max()) < 0.05


def _generator(seed: int) -> Any:
    return torch.Generator().manual_seed(seed)


def test_views_of_one_thing_have_one_step_of_noise() -> None:
    seen = []

    def predict(noisy: Any, steps: Any, states: Any, cameras: Any, depth: Any) -> Any:
        seen.append(steps)
        return torch.zeros_like(noisy)

    pictures, states = torch.zeros(8, 3, 8, 8), torch.zeros(8, 5, 8)
    heard = Conditioning(states, states, torch.zeros(8, 16))
    sds_loss(model(predict, views=4), pictures, heard, Guidance(), annealed_range(1.0), _generator(3))
    (steps,) = seen
    assert len(steps) == 16
    assert [len(set(part.tolist())) for part in steps[:8].split(4)] == [1, 1]
    assert steps[:8].equal(steps[8:])
    assert steps.min() >= 2
    assert steps.max() <= 50


def test_the_window_closes_as_mvdreams() -> None:
    assert annealed_range(0.0).low == pytest.approx(0.98)
    assert annealed_range(0.8).low == pytest.approx(0.02)
    assert annealed_range(0.8).high == pytest.approx(0.5)
    assert annealed_range(1.0) == annealed_range(0.9)


# --- regularisers --------------------------------------------------------------------------------------------------


def axes(scales: list[list[float]], seed: int = 0) -> Any:
    turns = rotations(random(len(scales), 4, seed=seed))
    return turns * torch.tensor(scales, dtype=torch.float64)[:, None, :]


def test_only_long_ellipsoids_cost() -> None:
    identity = torch.eye(3, dtype=torch.float64)[None]
    assert float(axis_ratio_loss(axes([[1, 1, 1], [1, 0.2, 0.2], [MAX_AXIS_RATIO, 1, 1]]), identity)) == pytest.approx(
        0.0
    )
    assert float(axis_ratio_loss(axes([[2 * MAX_AXIS_RATIO, 1, 3], [1, 1, 1]]), identity)) == pytest.approx(
        MAX_AXIS_RATIO / 2
    )


def test_what_is_long_is_measured_after_the_pose() -> None:
    round_ = axes([[1, 1, 1]])
    stretched = torch.diag(torch.tensor([3 * MAX_AXIS_RATIO, 1.0, 1.0], dtype=torch.float64))[None]
    assert float(axis_ratio_loss(round_, stretched)) == pytest.approx(2 * MAX_AXIS_RATIO)


def test_the_gradient_of_l_reg_is_that_of_the_ratio_and_stops_at_the_pose() -> None:
    log_scales = torch.tensor([[3.0, 0.1, 0.4]], dtype=torch.float64, requires_grad=True)
    turn = rotations(random(1, 4, seed=5))
    pose = torch.eye(3, dtype=torch.float64)[None].clone().requires_grad_(True)
    axis_ratio_loss(turn * log_scales.exp()[:, None, :], pose).backward()
    ratio = math.exp(2.9)
    torch.testing.assert_close(log_scales.grad, torch.tensor([[ratio, -ratio, 0.0]], dtype=torch.float64))
    assert pose.grad is None


def test_l_layout_is_the_manhattan_distance_to_the_box() -> None:
    box = torch.tensor([0.5, 0.6, 0.7])
    start = initial_theta(box, 3, _generator(0))
    means = torch.tensor([[0.4, -0.6, 0.7], [0.8, 0.0, 0.0], [-0.6, 1.6, -0.9]], requires_grad=True)
    theta = Theta(means, start.opacities, start.log_scales, start.quaternions, start.colors)
    found = layout_loss(theta, box)
    assert float(found.detach()) == pytest.approx((0.0 + 0.3 + (0.1 + 1.0 + 0.2)) / 3)
    found.backward()
    assert means.grad is not None
    assert means.grad[0].abs().max() == 0.0
    assert means.grad[2].sign().tolist() == [-1.0, 1.0, -1.0]

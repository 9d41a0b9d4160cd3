"""Pictures to latents and back; depth through a ControlNet."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from small_models import seeded, small_control, small_unet, small_vae

from scenelang.backends.neural.diffusion import (
    Autoencoder,
    DiffusionModel,
    PixelUnshuffle,
    schedule_of,
    translate_out_of_memory,
)
from scenelang.grammar.diagnostics import SceneError


def test_an_autoencoder_is_that_of_diffusers() -> None:
    torch = seeded()
    network = small_vae()
    pixels = Autoencoder(network)
    pictures = torch.rand(2, 3, 32, 32, requires_grad=True)
    latents = pixels.encode(pictures)
    assert pixels.factor == 4
    assert torch.allclose(latents, network.encode(pictures * 2 - 1).latent_dist.mode() * 0.18215, atol=1e-6)
    expected = network.decode(latents / 0.18215).sample * 0.5 + 0.5
    assert torch.allclose(pixels.decode(latents), expected, atol=1e-6)
    latents.sum().backward()
    assert float(pictures.grad.abs().min()) >= 0
    assert float(pictures.grad.abs().max()) > 0


def test_pixels_as_channels() -> None:
    torch = seeded()
    pictures = torch.rand(2, 3, 8, 8)
    latents = PixelUnshuffle(2).encode(pictures)
    assert latents.shape == (2, 12, 4, 4)
    assert torch.equal(latents[1, 4 * 2 + 3], pictures[1, 2, 1::2, 1::2] * 2 - 1)
    assert torch.allclose(PixelUnshuffle(2).decode(latents), pictures, atol=1e-6)


# --- depth -----------------------------------------------------------------------------------------------------------


def controlled(views: bool) -> tuple[DiffusionModel, Any]:
    seeded()
    network = small_unet(views)
    control = small_control(network)
    schedule = schedule_of({})
    return DiffusionModel("small", network, schedule, PixelUnshuffle(2), None, 16, 4 if views else 1, control), control  # type: ignore[arg-type]


@pytest.mark.parametrize("views", [False, True])
def test_a_control_that_knows_nothing_changes_nothing(views: bool) -> None:
    torch = seeded(1)
    diffusion, control = controlled(views)
    latents, states = torch.randn(4, 4, 8, 8), torch.randn(4, 77, 32)
    cameras = torch.randn(4, 16) if views else None
    steps, depth = torch.full((4,), 500), torch.rand(4, 3, 32, 32)
    with torch.no_grad():
        free = diffusion.predict(latents, steps, states, cameras)
        assert torch.equal(diffusion.predict(latents, steps, states, cameras, depth), free)
        for parameter in control.parameters():
            parameter.add_(torch.randn_like(parameter) * 0.05)
        bound = diffusion.predict(latents, steps, states, cameras, depth)
        other = diffusion.predict(latents, steps, states, cameras, 1 - depth)
        assert float((bound - free).abs().max()) > 1e-3
        assert float((bound - other).abs().max()) > 1e-5


def test_a_control_is_that_of_diffusers() -> None:
    torch = seeded(2)
    diffusion, control = controlled(False)
    latents, states = torch.randn(2, 4, 8, 8), torch.randn(2, 77, 32)
    steps, depth = torch.full((2,), 100), torch.rand(2, 3, 32, 32)
    with torch.no_grad():
        for parameter in control.parameters():
            parameter.add_(torch.randn_like(parameter) * 0.05)
        parts = control(latents, steps, states, depth)
        expected = diffusion.network(
            latents, steps, states,
            down_block_additional_residuals=parts.down_block_res_samples,
            mid_block_additional_residual=parts.mid_block_res_sample,
        ).sample  # fmt: skip
        assert torch.allclose(diffusion.predict(latents, steps, states, None, depth), expected, atol=1e-6)


def test_depth_needs_a_control() -> None:
    torch = seeded()
    diffusion = replace(controlled(False)[0], control=None)
    with pytest.raises(SceneError, match="`small` has no ControlNet") as caught:
        diffusion.predict(
            torch.zeros(1, 4, 8, 8), torch.tensor([1]), torch.zeros(1, 77, 32), None, torch.zeros(1, 3, 32, 32)
        )
    assert caught.value.name == "value"


def test_a_full_gpu_is_one_line() -> None:
    torch = seeded()
    with pytest.raises(SceneError, match="out of GPU memory") as caught, translate_out_of_memory():
        raise torch.cuda.OutOfMemoryError("CUDA out of memory. Tried to allocate 2.00 GiB")
    assert caught.value.name == "unsupported"
    assert "--device cpu" in (caught.value.hint or "")
    with pytest.raises(ZeroDivisionError), translate_out_of_memory():
        raise ZeroDivisionError

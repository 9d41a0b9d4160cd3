"""The multi-view UNet on diffusers against one in plain torch; cameras against MVDream's own way to make them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from small_models import seeded, small_unet

from scenelang.backends.neural.diffusion import (
    DiffusionModel,
    FoldedAttention,
    PixelUnshuffle,
    camera_row,
    camera_rows,
    fold_views,
    schedule_of,
)
from scenelang.backends.neural.mvdream import ORIGINAL, UNET, empty_networks, to_checkpoint, unet_names
from scenelang.backends.pictures.camera import Viewpoint, camera_at, place
from scenelang.grammar.diagnostics import SceneError

if TYPE_CHECKING:
    from diffusion.original import OriginalUNet


def model(network: Any, views: int = 4, control: Any = None) -> DiffusionModel:
    return DiffusionModel("small", network, schedule_of({}), PixelUnshuffle(2), None, 16, views, control)  # type: ignore[arg-type]


def inputs(torch: Any, rows: int = 8) -> tuple[Any, Any, Any, Any]:
    steps = torch.randint(0, 1000, (rows // 4,)).repeat_interleave(4)
    return torch.randn(rows, 4, 8, 8), steps, torch.randn(rows, 77, 32), torch.randn(rows, 16)


@pytest.fixture(scope="module")
def pair() -> tuple[DiffusionModel, OriginalUNet]:
    """The same random weights in both forms."""
    from diffusion.original import OriginalUNet

    seeded()
    network = small_unet()
    plain = OriginalUNet((32, 64), (True, False), (2, 4), 1, 32).eval()
    own = to_checkpoint(network.state_dict(), unet_names(network.state_dict()))
    plain.load_state_dict({key.removeprefix(UNET): tensor for key, tensor in own.items()})
    return model(network), plain


def test_views_attend_to_one_another_as_in_the_original(pair: tuple[DiffusionModel, OriginalUNet]) -> None:
    torch = seeded(1)
    diffusion, plain = pair
    latents, steps, states, cameras = inputs(torch)
    with torch.no_grad():
        found = diffusion.predict(latents, steps, states, cameras)
        expected = plain(latents, steps, states, cameras, views=4)
        alone = plain(latents, steps, states, cameras, views=1)
    assert float((found - expected).abs().max()) < 2e-5
    assert float((found - alone).abs().max()) > 1e-2


def test_without_cameras_pictures_are_alone(pair: tuple[DiffusionModel, OriginalUNet]) -> None:
    torch = seeded(2)
    diffusion, plain = pair
    latents, steps, states, _ = inputs(torch)
    with torch.no_grad():
        found = diffusion.predict(latents[:3], steps[:3], states[:3])
        expected = plain(latents[:3], steps[:3], states[:3], None, views=1)
        with_zero = plain(latents[:3], steps[:3], states[:3], torch.zeros(3, 16), views=1)
    assert float((found - expected).abs().max()) < 2e-5
    assert float((found - with_zero).abs().max()) > 1e-2  # the layers' own biases are left out too


def test_groups_do_not_mix(pair: tuple[DiffusionModel, OriginalUNet]) -> None:
    torch = seeded(3)
    diffusion, _ = pair
    latents, steps, states, cameras = inputs(torch)
    with torch.no_grad():
        both = diffusion.predict(latents, steps, states, cameras)
        first = diffusion.predict(latents[:4], steps[:4], states[:4], cameras[:4])
    assert torch.allclose(both[:4], first, atol=1e-5)


def test_gradients_flow_through(pair: tuple[DiffusionModel, OriginalUNet]) -> None:
    torch = seeded(4)
    diffusion, _ = pair
    latents, steps, states, cameras = inputs(torch, 4)
    latents.requires_grad_(True)
    states.requires_grad_(True)
    diffusion.predict(latents, steps, states, cameras)[0].sum().backward()
    assert float(latents.grad[3].abs().max()) > 0  # the first view's output depends on the last view
    assert float(states.grad.abs().max()) > 0


def test_weights_in_half(pair: tuple[DiffusionModel, OriginalUNet]) -> None:
    torch = seeded(5)
    network = small_unet().to(torch.bfloat16)
    latents, steps, states, cameras = inputs(torch, 4)
    with torch.no_grad():
        assert model(network).predict(latents, steps, states, cameras).dtype == torch.float32


def test_folding_twice_is_folding_once() -> None:
    seeded()
    network = small_unet()
    fold_views(network)
    fold_views(network)
    assert len(network.class_embedding._forward_hooks) == 1
    assert all(isinstance(processor, FoldedAttention) for processor in network.attn_processors.values())


def test_cameras_that_do_not_fit() -> None:
    torch = seeded()
    latents, steps, states, cameras = inputs(torch)
    with pytest.raises(SceneError, match="B a multiple of 4"):
        model(small_unet()).predict(latents[:6], steps[:6], states[:6], cameras[:6])
    with pytest.raises(SceneError, match="has no camera conditioning"):
        model(small_unet(views=False), views=1).predict(latents, steps, states, cameras)


# --- names -----------------------------------------------------------------------------------------------------------


def test_all_names_and_shapes_of_the_full_size_network() -> None:
    from diffusion.original import OriginalUNet

    torch = seeded()
    with torch.device("meta"):
        plain = OriginalUNet((320, 640, 1280, 1280), (True, True, True, False), (5, 10, 20, 20), 2, 1024)
    unet = empty_networks(ORIGINAL).unet.state_dict()
    ours = {theirs: unet[key].shape for key, theirs in unet_names(unet).items()}
    assert ours == {UNET + key: tensor.shape for key, tensor in plain.state_dict().items()}
    assert len(ours) == 690


# --- cameras ---------------------------------------------------------------------------------------------------------


def mvdreams_camera(elevation: float, azimuth: float) -> np.ndarray:
    """As its code makes them: OpenGL's camera-to-world on the unit sphere, the world turned to +z up, row by row."""
    up, around = math.radians(elevation), math.radians(azimuth)
    eye = np.array([math.cos(up) * math.sin(around), math.sin(up), math.cos(up) * math.cos(around)])
    right = np.cross(-eye, [0.0, 1.0, 0.0])
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3] = np.stack([right, np.cross(right, -eye), eye, eye], axis=1)
    turn = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1.0]])
    return (turn @ pose).reshape(16)


@pytest.mark.parametrize(
    ("elevation", "azimuth", "distance"), [(15, 0, 1), (15, 90, 3.5), (-20, 200, 0.2), (60, 315, 8)]
)
def test_cameras_are_mvdreams(elevation: float, azimuth: float, distance: float) -> None:
    """MVDream's azimuth 90 is our 0: the front of a thing."""
    up, around = math.radians(elevation), math.radians(azimuth)
    eye = distance * np.array([math.cos(up) * math.sin(around), math.sin(up), math.cos(up) * math.cos(around)])
    forward = -eye / distance
    right = np.cross(forward, [0.0, 1.0, 0.0])
    right /= np.linalg.norm(right)
    camera = camera_at(eye, (right, np.cross(right, forward), forward), 300.0, 256, 256)
    assert np.allclose(camera_row(camera.world_to_camera), mvdreams_camera(elevation, azimuth + 90), atol=1e-12)
    assert camera_rows([camera, camera]).shape == (2, 16)


def test_the_front_of_a_thing_is_mvdreams_front() -> None:
    """A picture from our azimuth 0 is what its sampling script asks for first, at +x in Blender's world."""
    camera = place(Viewpoint(0.0, 0.0, distance=3.0, target=(0.0, 0.0, 0.0)), np.full(3, -1.0), np.ones(3), 64, 64)
    row = camera_row(camera.world_to_camera).reshape(4, 4)
    assert row[:3, 3] == pytest.approx([1, 0, 0], abs=1e-12)  # the eye
    assert row[:3, 0] == pytest.approx([0, 1, 0], abs=1e-12)  # right of the picture
    assert row[:3, 1] == pytest.approx([0, 0, 1], abs=1e-12)  # up

"""RAFT is torchvision's, and finds a known shift where its parts are made by hand; dynamic degree is VBench's."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_models import seeded

from scenelang.backends.neural.metrics import Raft, dynamic_degree, film_dynamic_degree, motion, sample_frames
from scenelang.backends.neural.weights import ModelHub
from scenelang.grammar.diagnostics import SceneError


def noise(height: int, width: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, 256, (height, width, 3), np.uint8)


# --- RAFT ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("size", [(128, 136), (101, 139)])
def test_flow_is_torchvisions(models: Path, size: tuple[int, int]) -> None:
    """Called directly with torchvision's own transform, the edges repeated by numpy up to multiples of 8."""
    from PIL import Image
    from torchvision.models.optical_flow import raft_large
    from torchvision.transforms._presets import OpticalFlow

    torch = seeded()
    height, width = size
    before, after = noise(*size, seed=1), noise(*size, seed=2)
    top, left = (-height % 8 if height > 128 else 128 - height) // 2, (-width % 8) // 2
    bottom, right = max(128, height + -height % 8) - height - top, -width % 8 - left
    network = raft_large(weights=None).eval()
    network.load_state_dict(torch.load(models / "raft_large" / "raft_large_C_T_V1-22a6c225.pth", weights_only=True))
    padded = [
        Image.fromarray(np.pad(one, ((top, bottom), (left, right), (0, 0)), mode="edge")) for one in (before, after)
    ]
    one, two = OpticalFlow()(*padded)
    with torch.no_grad():
        expected = network(one[None], two[None], num_flow_updates=3)[-1][0].permute(1, 2, 0).numpy()
    found = Raft(ModelHub(models, False)).flow(before, after, iterations=3)
    assert found.shape == (height, width, 2)
    np.testing.assert_allclose(found, expected[top : top + height, left : left + width], atol=1e-4)
    assert np.abs(found).max() > 1e-3


def matching_raft() -> Any:
    """torchvision's RAFT (its correlations, their lookup, its upsampling) with an encoder and an update made by hand: a
    patch of 8 x 8 pixels is its own feature, the flow goes where the correlation around it is strongest."""
    import torch
    from torchvision.models.optical_flow.raft import RAFT, CorrBlock

    class Patches(torch.nn.Module):
        def forward(self, pictures: Any) -> Any:
            rows = torch.nn.functional.pixel_unshuffle(pictures, 8)
            return torch.nn.functional.normalize(rows - rows.mean(1, keepdim=True), dim=1) * 14.0

    class Strongest(torch.nn.Module):
        hidden_state_size = 1
        radius = 4

        def forward(self, hidden: Any, _: Any, correlations: Any, __: Any) -> Any:
            reach = torch.arange(-self.radius, self.radius + 1.0)
            steps = torch.stack(torch.meshgrid(reach, reach, indexing="ij"), -1).reshape(-1, 2)
            share = torch.softmax(50.0 * correlations, 1)
            down, right = (torch.einsum("bkhw,k->bhw", share, steps[:, n]) for n in (1, 0))
            return hidden, torch.stack([right, down], 1)

    strongest = Strongest()
    return RAFT(
        feature_encoder=Patches(), context_encoder=Patches(), corr_block=CorrBlock(num_levels=1, radius=4),
        update_block=strongest, mask_predictor=None,
    )  # fmt: skip


@pytest.mark.parametrize("shift", [(16, 0), (0, -24), (-8, 16)])
def test_a_known_shift_is_found(shift: tuple[int, int]) -> None:
    """Right and down, in pixels of the picture that came in, also where its size is no multiple of 8."""
    seeded()
    right, down = shift
    large = noise(260, 300, seed=3)
    before, after = large[40:216, 40:240], large[40 - down : 216 - down, 40 - right : 240 - right]
    found = Raft(network=matching_raft()).flow(before, after, iterations=4)
    inner = found[40:-40, 40:-40].reshape(-1, 2)
    np.testing.assert_allclose(inner, np.broadcast_to([right, down], inner.shape), atol=0.05)
    assert np.abs(Raft(network=matching_raft()).flow(before, before)).max() < 0.05


def test_the_degree_of_a_film_whose_motion_is_known() -> None:
    """A patch of an eighth of the picture moves 16 pixels from one picture to the next."""
    seeded()
    film = []
    for n in range(5):
        picture = np.full((176, 200, 3), 128, np.uint8)
        picture[56:120, 16 + 16 * n : 80 + 16 * n] = noise(64, 64, seed=4)
        film.append(picture)
    found = film_dynamic_degree(film, 8.0, Raft(network=matching_raft()).flow)
    assert found.pixels == pytest.approx(16.0, abs=0.1)
    assert found.relative == found.pixels / 176
    assert found.is_dynamic
    still = film_dynamic_degree([film[0]] * 5, 8.0, Raft(network=matching_raft()).flow)
    assert still.pixels < 0.1
    assert not still.is_dynamic


def test_other_weights_are_told(tmp_path: Path) -> None:
    torch = seeded()
    with pytest.raises(SceneError, match="raft_large") as caught:
        Raft(ModelHub(tmp_path, False))
    assert caught.value.name == "weights"
    (tmp_path / "raft_large").mkdir()
    torch.save({"a": torch.zeros(1)}, tmp_path / "raft_large" / "a.pth")
    with pytest.raises(SceneError, match="not the weights of torchvision's RAFT large") as caught:
        Raft(ModelHub(tmp_path, False))
    assert caught.value.name == "weights"


# --- dynamic degree --------------------------------------------------------------------------------------------------


def test_motion_is_the_mean_of_the_fastest_twentieth() -> None:
    flow = np.zeros((20, 10, 2))
    flow[0, :5] = [3.0, 4.0]  # five pixels of 200 are 5 long, five are 10
    flow[1, :5] = [0.0, -10.0]
    assert motion(flow) == 7.5
    flow[2:] = [0.0, 1.0]
    assert motion(flow) == 7.5, "the others do not count"
    assert motion(np.full((2, 2, 2), 3.0)) == pytest.approx(np.sqrt(18.0)), "of few pixels the fastest"


def test_motion_is_vbenchs_on_random_flows() -> None:
    """Written as VBench does it."""
    flow = np.random.default_rng(6).normal(size=(37, 53, 2))
    lengths = np.sqrt(np.square(flow[..., 0]) + np.square(flow[..., 1])).flatten()
    expected = np.mean(abs(np.sort(-lengths))[: int(37 * 53 * 0.05)])
    assert motion(flow) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("motions", "fps", "width", "height", "is_dynamic"),
    [
        ([6.0] * 15, 8.0, 256, 256, False),  # must be above 6 pixels at 256
        ([6.01] * 4 + [0.0] * 11, 8.0, 256, 256, True),  # 16 pictures: 4 pairs
        ([6.01] * 3 + [0.0] * 12, 8.0, 256, 256, False),
        ([12.01] * 4 + [0.0] * 11, 8.0, 512, 700, True),  # the shorter side counts
        ([11.9] * 15, 8.0, 512, 700, False),
        ([11.9] * 15, 4.0, 256, 256, False),  # half as many pictures per second: twice as far
        ([12.1] * 15, 4.0, 256, 256, True),
        ([6.01] * 2 + [0.0] * 5, 8.0, 256, 256, True),  # 8 pictures: 2 pairs
        ([6.01] + [0.0] * 6, 8.0, 256, 256, False),
        ([0.0], 8.0, 256, 256, False),  # VBench would ask for no pair of two pictures
        ([], 8.0, 256, 256, False),
    ],
)
def test_what_is_dynamic(motions: list[float], fps: float, width: int, height: int, is_dynamic: bool) -> None:
    found = dynamic_degree(motions, fps, width, height)
    assert found.is_dynamic is is_dynamic
    assert found.pixels == pytest.approx(sum(motions) / max(1, len(motions)))
    assert found.relative == pytest.approx(found.pixels / min(width, height))


def test_about_eight_pictures_per_second_are_looked_at() -> None:
    assert sample_frames(10, 24.0) == [0, 3, 6, 9]
    assert sample_frames(5, 8.0) == [0, 1, 2, 3, 4]
    assert sample_frames(3, 2.0) == [0, 1, 2]
    seen: list[tuple[int, int]] = []

    def flow(one: np.ndarray, two: np.ndarray) -> np.ndarray:
        seen.append((int(one[0, 0, 0]), int(two[0, 0, 0])))
        return np.full((8, 8, 2), 3.0)

    film = [np.full((8, 8, 3), n, np.uint8) for n in range(10)]
    assert film_dynamic_degree(film, 24.0, flow).pixels == pytest.approx(np.sqrt(18.0))
    assert seen == [(0, 3), (3, 6), (6, 9)]


def test_a_4d_scene_is_seen_frame_by_frame_from_one_place() -> None:
    from support import evaluate

    from scenelang.backends.neural.metrics import fixed_shots, turntable_shots

    moving = """(bind "ball" (lambda (:x) (transform (call "sphere" :radius .3) (translate (list x 0 0)))))
    (bind "way" (lambda () (frames (for/list ((i (iota 6))) (call "ball" :x (* i .2))))))"""
    scene = evaluate(moving, root="way")
    shots = fixed_shots(scene, 200, 160)
    assert [shot.frame for shot in shots] == list(range(6))
    assert len({shot.camera.world_to_camera.tobytes() for shot in shots}) == 1
    turn = turntable_shots(scene, 12, 200, 160)
    assert [shot.frame for shot in turn] == [0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5]
    places = np.array([shot.camera.eye for shot in turn])
    middle = places.mean(axis=0)
    radii = np.hypot(*(places - middle)[:, [0, 2]].T)
    np.testing.assert_allclose(radii, radii[0])
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    np.testing.assert_allclose(steps, steps[0])
    np.testing.assert_allclose(places[:, 1], places[0, 1])

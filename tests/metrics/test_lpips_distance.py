"""LPIPS is the package's, with AlexNet from a file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from small_models import seeded

from scenelang.backends.neural.metrics import Lpips, resize_and_crop
from scenelang.backends.neural.weights import ModelHub
from scenelang.grammar.diagnostics import SceneError


def picture(seed: int, height: int = 64, width: int = 80) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, 256, (height, width, 3), np.uint8)


def test_distances_are_the_packages(models: Path) -> None:
    """The reference's slices are made of torchvision's own layers, so no names are translated."""
    import lpips
    from torchvision.models import AlexNet

    torch = seeded()
    with torch.device("meta"):
        network = AlexNet()
    state = torch.load(models / "alexnet" / "alexnet-owt-7be5be79.pth", weights_only=True)
    features = network.features.to_empty(device="cpu")
    features.load_state_dict({key.removeprefix("features."): tensor for key, tensor in state.items()})
    reference = lpips.LPIPS(net="alex", pnet_rand=True, verbose=False)
    for number, (start, end) in enumerate([(0, 2), (2, 5), (5, 8), (8, 10), (10, 12)], 1):
        setattr(reference.net, f"slice{number}", features[start:end])
    wanted, others = picture(0), [picture(n) for n in range(1, 13)]

    def tensor(one: np.ndarray) -> object:
        return torch.from_numpy(one / 255.0).permute(2, 0, 1)[None].float()

    with torch.no_grad():
        expected = [reference(tensor(wanted), tensor(other), normalize=True).item() for other in others]
    found = Lpips(ModelHub(models, False)).distances(wanted, others)
    assert found == pytest.approx(expected, rel=1e-5)
    assert min(found) > 0.01


def test_the_same_picture_is_no_distance_away(models: Path) -> None:
    seeded()
    network = Lpips(ModelHub(models, False))
    one = picture(1)
    noisy = np.clip(one.astype(int) + np.random.default_rng(2).integers(-20, 21, one.shape), 0, 255).astype(np.uint8)
    same, near, far = network.distances(one, [one, noisy, picture(9)])
    assert same == 0.0
    assert 0.0 < near < far
    with pytest.raises(SceneError, match="32 pixels"):
        network.distances(one, [picture(1, 20, 20)])


def test_a_picture_is_brought_to_size_by_its_middle() -> None:
    wide = np.zeros((40, 120, 3), np.uint8)
    wide[:, 40:80] = 255
    found = resize_and_crop(wide, 20, 20)
    assert found.shape == (20, 20, 3)
    assert found.min() > 200, "what is at the sides is cut"
    assert found[:, 1:-1].min() == 255
    assert resize_and_crop(wide, 120, 40) is wide


@pytest.mark.parametrize("damage", ["shape", "name", "kind", "none"])
@pytest.mark.sampled(2)
def test_other_weights_are_told(models: Path, tmp_path: Path, damage: str) -> None:
    torch = seeded()
    state = torch.load(models / "alexnet" / "alexnet-owt-7be5be79.pth", weights_only=True)
    if damage == "shape":
        state["features.3.weight"] = torch.zeros(1)
    elif damage == "name":
        state["other.3.weight"] = state.pop("features.3.weight")
    (tmp_path / "alexnet").mkdir()
    if damage == "kind":
        torch.save([1, 2], tmp_path / "alexnet" / "a.pth")
    elif damage != "none":
        torch.save(state, tmp_path / "alexnet" / "a.pth")
    with pytest.raises(SceneError) as caught:
        Lpips(ModelHub(tmp_path, False))
    assert caught.value.name == "weights"
    assert "alexnet" in caught.value.message.lower()


def test_nothing_in_a_file_of_weights_is_executed(tmp_path: Path) -> None:
    import os
    import pickle

    class Trap:
        def __reduce__(self) -> object:
            return os.mkdir, (str(tmp_path / "sprung"),)

    (tmp_path / "alexnet").mkdir()
    (tmp_path / "alexnet" / "a.pth").write_bytes(pickle.dumps(Trap()))
    with pytest.raises(SceneError) as caught:
        Lpips(ModelHub(tmp_path, False))
    assert caught.value.name == "weights"
    assert not (tmp_path / "sprung").exists()


@pytest.mark.slow
def test_weights_in_torchs_own_cache_are_found(models: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    torch = seeded()
    monkeypatch.setattr(torch.hub, "get_dir", lambda: str(tmp_path))
    with pytest.raises(SceneError, match="are not available"):
        Lpips(ModelHub(None, False))
    (tmp_path / "checkpoints").mkdir()
    (tmp_path / "checkpoints" / "alexnet-owt-7be5be79.pth").write_bytes(
        (models / "alexnet" / "alexnet-owt-7be5be79.pth").read_bytes()
    )
    here, there = Lpips(ModelHub(None, False)), Lpips(ModelHub(models, False))
    assert here.distances(picture(1), [picture(2)]) == there.distances(picture(1), [picture(2)])

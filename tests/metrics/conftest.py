"""Small or random models in the places where large ones are looked for."""

from __future__ import annotations

from pathlib import Path

import pytest
from small_models import seeded, small_clip

JUDGE = "ViT-H-14-378-quickgelu"


def save_alexnet(folder: Path) -> Path:
    """AlexNet's features with random weights, named as torchvision's file has them."""
    import torch
    from torchvision.models import AlexNet

    seeded(3)
    folder.mkdir(parents=True)
    with torch.device("meta"):
        network = AlexNet()
    features = network.features.to_empty(device="cpu")
    for parameter in features.parameters():
        torch.nn.init.normal_(parameter, std=0.05)
    state = {f"features.{key}": tensor for key, tensor in features.state_dict().items()}
    torch.save(state, folder / "alexnet-owt-7be5be79.pth")
    return folder


def save_raft(folder: Path) -> Path:
    """RAFT, large, with random weights."""
    from torchvision.models.optical_flow import raft_large

    torch = seeded(4)
    folder.mkdir(parents=True)
    torch.save(raft_large(weights=None).state_dict(), folder / "raft_large_C_T_V1-22a6c225.pth")
    return folder


@pytest.fixture(scope="session")
def models(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("models")
    small_clip(folder / JUDGE)
    save_alexnet(folder / "alexnet")
    save_raft(folder / "raft_large")
    return folder

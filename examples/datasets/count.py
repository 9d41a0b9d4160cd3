"""Trains a tiny network to count the objects of a dataset made from clevr.toml, for two minutes on a processor.

    scenelang dataset examples/datasets/clevr.toml -o clevr --jobs 2
    python examples/datasets/count.py clevr

The network sees pictures of 64 x 64 pixels and learns a map of density whose sum is the count, from the boxes
of the labels. It needs torch and webdataset.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import torch
import webdataset
from torch import nn
from torch.utils.data import DataLoader

OBJECTS = ("block", "ball", "drum")
SIDE = 32  # of the map of density
LOWEST, HIGHEST = 3, 10  # objects in a picture


def example(sample: dict) -> tuple[torch.Tensor, torch.Tensor, int]:
    """Return the picture (3, 64, 64), the density (SIDE, SIDE) and the number of objects of a decoded sample."""
    picture = torch.tensor(sample["color.png"]).permute(2, 0, 1).float() / 255.0
    picture = nn.functional.interpolate(picture[None], (64, 64), mode="area")[0]
    density = torch.zeros(SIDE, SIDE)
    height, width = sample["color.png"].shape[:2]
    for thing in sample["json"]["things"]:
        x, y, w, h = thing["bbox"]
        if thing["word"] in OBJECTS and w and h:
            row, column = int((y + h / 2) * SIDE / height), int((x + w / 2) * SIDE / width)
            density[min(row, SIDE - 1), min(column, SIDE - 1)] += 1.0
    kernel = torch.tensor([[1.0, 2.0, 1.0], [2.0, 4.0, 2.0], [1.0, 2.0, 1.0]]) / 16.0
    blurred = nn.functional.conv2d(density[None, None], kernel[None, None], padding=1)[0, 0]
    return picture, blurred, int(sample["json"]["values"]["param.objects"])


def is_used(name: str) -> bool:
    """Return whether the network learns from a file of a sample; the others are not decoded."""
    return name.endswith((".color.png", ".json"))


def loader(folder: Path, split: str) -> list[tuple[torch.Tensor, torch.Tensor, torch.Tensor]]:
    """Return the batches of a split, read once by a DataLoader."""
    urls = [str(path) for path in sorted(folder.glob(f"{split}-*.tar"))]
    reader = webdataset.WebDataset(urls, shardshuffle=False, select_files=is_used).decode("rgb8").map(example)
    return list(DataLoader(reader, batch_size=32))


def network() -> nn.Module:
    """Return a network of four convolutions that gives a density (N, 1, SIDE, SIDE)."""
    net = nn.Sequential(
        nn.Conv2d(3, 24, 5, padding=2), nn.ReLU(), nn.MaxPool2d(2),
        nn.Conv2d(24, 32, 3, padding=1), nn.ReLU(), nn.Conv2d(32, 32, 3, padding=2, dilation=2), nn.ReLU(),
        nn.Conv2d(32, 1, 1), nn.Softplus(),
    )  # fmt: skip
    nn.init.constant_(net[-2].bias, -5.0)  # of about seven objects in a picture
    return net


def trained(batches: list, seconds: float) -> nn.Module:
    """Train a network for so many seconds."""
    torch.manual_seed(0)
    net = network()
    optimiser = torch.optim.Adam(net.parameters(), 2e-3)
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        for pictures, densities, _ in batches:
            if torch.rand(()) < 0.5:
                pictures, densities = pictures.flip(3), densities.flip(2)
            found = net(pictures)[:, 0]
            loss = nn.functional.poisson_nll_loss(found, densities, log_input=False, eps=1e-6)
            optimiser.zero_grad()
            loss.backward()
            optimiser.step()
    return net


def accuracy(net: nn.Module, batches: list) -> tuple[float, float]:
    """Return the share of pictures that are counted exactly, and the mean error."""
    with torch.no_grad():
        found = torch.cat([net(pictures).sum((1, 2, 3)) for pictures, _, _ in batches])
    truth = torch.cat([counts for _, _, counts in batches])
    counted = found.round().clamp(LOWEST, HIGHEST)
    return float((counted == truth).float().mean()), float((counted - truth).abs().mean())


def main() -> None:
    folder, seconds = Path(sys.argv[1]), float(sys.argv[2]) if len(sys.argv) > 2 else 120.0
    train, test = loader(folder, "train"), loader(folder, "test")
    exact, error = accuracy(trained(train, seconds), test)
    print(f"counted exactly: {exact:.1%} (chance {1 / (HIGHEST - LOWEST + 1):.1%}), mean error {error:.2f}")


if __name__ == "__main__":
    main()

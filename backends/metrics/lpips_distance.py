"""LPIPS: how unlike pictures are to the features of AlexNet (Zhang et al. 2018), by the package `lpips`."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np

from scenelang.backends.base import need
from scenelang.backends.diffusion.memory import memory_told
from scenelang.backends.metrics.torchvision_weights import ALEXNET, state_of
from scenelang.backends.picture import Picture
from scenelang.backends.weights import INSTALL, Shelf
from scenelang.grammar.diagnostics import SceneError

_LEAST = 32  # pixels: below, AlexNet has nothing left in its last layers
_BATCH = 10


class Lpips:
    """The network: its linear heads come with the package, AlexNet's weights from the shelf.

    Raises SceneError: "weights" where AlexNet's weights are not to be had or are another model's, "backend" without
    the packages.
    """

    name = "alexnet"

    def __init__(self, shelf: Shelf | None = None, device: str = "cpu") -> None:
        self._torch = need("torch", INSTALL)
        package = need("lpips", INSTALL)
        with warnings.catch_warnings():  # it calls torchvision in an old way
            warnings.simplefilter("ignore")
            network = package.LPIPS(net="alex", pnet_rand=True, verbose=False)  # pnet_rand: without a download
        _fill(network.net, state_of(ALEXNET, shelf or Shelf()))
        self._network = network.to(device).eval().requires_grad_(False)
        self._device = device

    def distances(self, wanted: Picture, pictures: Sequence[Picture]) -> list[float]:
        """How far each of ``pictures`` (H, W, 3), which have one size, is from ``wanted``, which is brought to that
        size, cut where its shape is another. Raises SceneError("value") for pictures below 32 pixels."""
        height, width = pictures[0].shape[:2]
        if min(height, width) < _LEAST:
            raise SceneError("value", f"LPIPS needs pictures of {_LEAST} pixels or more, not {width} x {height}")
        target = self._tensor([fitted(wanted, width, height)])
        found: list[float] = []
        with self._torch.no_grad(), memory_told():
            for start in range(0, len(pictures), _BATCH):
                batch = self._tensor(pictures[start : start + _BATCH])
                found += self._network(target.expand(len(batch), -1, -1, -1), batch).flatten().tolist()
        return found

    def _tensor(self, pictures: Sequence[Picture]) -> Any:
        """(N, 3, H, W) from -1 to 1."""
        rows = self._torch.from_numpy(np.stack(list(pictures))).to(self._device)
        return rows.permute(0, 3, 1, 2).float() / 127.5 - 1.0


def fitted(picture: Picture, width: int, height: int) -> Picture:
    """``picture`` at another size, cut to its middle where its shape is another."""
    image = need("PIL.Image", "pillow")
    if picture.shape[:2] == (height, width):
        return picture
    made = need("PIL.ImageOps", "pillow").fit(image.fromarray(picture), (width, height), image.Resampling.BICUBIC)
    return np.asarray(made, np.uint8)


def _fill(backbone: Any, state: dict[str, Any]) -> None:
    """Give the slices of AlexNet's features their weights: ``features.N.*`` is ``sliceK.N.*``."""
    wanted = backbone.state_dict()
    filled = {}
    for key, tensor in wanted.items():
        part = key.partition(".")[2]
        found = state.get(f"features.{part}", state.get(key))
        if getattr(found, "shape", None) != tensor.shape:
            raise SceneError("weights", f"these are no weights of AlexNet: `features.{part}` is not as it should be")
        filled[key] = found
    backbone.load_state_dict(filled)

"""Optical flow by RAFT (Teed and Deng 2020), as torchvision has it: where the pixels of a picture go in the next."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import need
from scenelang.backends.diffusion.memory import memory_told
from scenelang.backends.metrics.torchvision_weights import RAFT_LARGE, state_of
from scenelang.backends.picture import Picture
from scenelang.backends.weights import INSTALL, Shelf
from scenelang.grammar.diagnostics import SceneError

Flow = npt.NDArray[np.float32]

ITERATIONS = 20  # as VBench's
_UNIT, _LEAST = 8, 128  # pixels: sides are whole multiples, the pyramid of correlations needs so many


class Raft:
    """RAFT, large, of torchvision's architecture; ``network`` may be one of the same interface that is there.

    Raises SceneError: "weights" where the weights are not to be had or are another model's, "backend" without the
    packages.
    """

    name = RAFT_LARGE.file

    def __init__(self, shelf: Shelf | None = None, device: str = "cpu", network: Any = None) -> None:
        self._torch = need("torch", INSTALL)
        self._network = (_loaded(shelf or Shelf()) if network is None else network).to(device).eval()
        self._device = device

    def flow(self, before: Picture, after: Picture, iterations: int = ITERATIONS) -> Flow:
        """How far each pixel of ``before`` (H, W, 3) moves to ``after``: (H, W, 2), right and down, in pixels."""
        height, width = before.shape[:2]
        top, bottom = _margins(height)
        left, right = _margins(width)
        with self._torch.no_grad(), memory_told():
            pair = self._torch.from_numpy(np.stack([before, after])).to(self._device)
            rows = pair.permute(0, 3, 1, 2).float() / 127.5 - 1.0
            rows = self._torch.nn.functional.pad(rows, (left, right, top, bottom), mode="replicate")
            found = self._network(rows[:1], rows[1:], num_flow_updates=iterations)[-1][0]
        flow: Flow = found[:, top : top + height, left : left + width].permute(1, 2, 0).float().cpu().numpy()
        return flow


def _margins(size: int) -> tuple[int, int]:
    """Pixels before and after, as RAFT's own code pads: the edge repeated, half on each side."""
    missing = max(_LEAST, -(-size // _UNIT) * _UNIT) - size
    return missing // 2, missing - missing // 2


def _loaded(shelf: Shelf) -> Any:
    flow = need("torchvision.models.optical_flow", INSTALL)
    network = flow.raft_large(weights=None)
    state = state_of(RAFT_LARGE, shelf)
    try:
        network.load_state_dict(state)
    except (RuntimeError, AttributeError, TypeError) as error:
        raise SceneError("weights", "these are no weights of RAFT, large, as torchvision names them") from error
    return network

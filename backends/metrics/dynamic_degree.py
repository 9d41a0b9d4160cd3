"""Dynamic degree: how much moves in a film, from optical flow (VBench, Huang et al. 2024)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from scenelang.backends.picture import Picture

SAMPLED_FPS = 8.0  # pictures per second that are looked at
_FASTEST = 0.05  # the share of pixels that counts, the fastest
_THRESHOLD, _AT = 6.0, 256.0  # pixels, in pictures of that size
_PAIRS, _OF = 4, 16  # so many pairs must move, of so many pictures


@dataclass(frozen=True, slots=True)
class DynamicDegree:
    """``pixels``: how far the fastest twentieth of the pixels goes from one picture to the next, on average;
    ``share``: the same over the shorter side of the picture; ``is_dynamic``: what VBench says of the film."""

    pixels: float
    share: float
    is_dynamic: bool


def sampled(count: int, fps: float) -> list[int]:
    """The numbers of the pictures of a film of ``count`` that are looked at: about 8 per second."""
    return list(range(0, count, max(1, round(fps / SAMPLED_FPS))))


def motion(flow: npt.NDArray[np.floating]) -> float:
    """The mean length of the fastest twentieth of a flow (H, W, 2), in pixels."""
    lengths = np.hypot(flow[..., 0], flow[..., 1]).ravel().astype(np.float64)
    count = max(1, int(lengths.size * _FASTEST))
    return float(np.partition(lengths, lengths.size - count)[lengths.size - count :].mean())


def degree(motions: Sequence[float], fps: float, width: int, height: int) -> DynamicDegree:
    """From the motion of each pair of neighbours among the pictures that are looked at, ``fps`` of them per second."""
    if not motions:
        return DynamicDegree(0.0, 0.0, False)
    size = min(width, height)
    threshold = max(1.0, SAMPLED_FPS / fps) * _THRESHOLD * size / _AT
    wanted = max(1, round(_PAIRS * (len(motions) + 1) / _OF))
    pixels = float(np.mean(motions))
    return DynamicDegree(pixels, pixels / size, sum(one > threshold for one in motions) >= wanted)


def degree_of_film(
    pictures: Sequence[Picture], fps: float, flow: Callable[[Picture, Picture], npt.NDArray[np.floating]]
) -> DynamicDegree:
    """The degree of a film of ``fps`` pictures (H, W, 3) per second, by a function that gives the flow of two."""
    chosen = [pictures[number] for number in sampled(len(pictures), fps)]
    step = max(1, round(fps / SAMPLED_FPS))
    height, width = pictures[0].shape[:2]
    return degree([motion(flow(one, two)) for one, two in pairwise(chosen)], fps / step, width, height)

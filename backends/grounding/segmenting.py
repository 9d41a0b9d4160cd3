"""The part of a picture that words name: boxes by the detector, the best one's mask by the segmenter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from scenelang.backends.grounding.cutting import Bytes, cut_out
from scenelang.backends.grounding.detector import LEAST, detect
from scenelang.backends.grounding.loading import Loaded
from scenelang.backends.grounding.masks import mask_in


@dataclass(frozen=True, slots=True, eq=False)
class Grounding:
    """Both networks, and the score that a box must have at least."""

    detector: Loaded
    segmenter: Loaded
    least: float = LEAST


def found_in(grounding: Grounding, pictures: Sequence[Any], text: str, grey: int) -> tuple[int, Bytes] | None:
    """The number of the PIL picture (RGB) in which ``text`` is found most surely, and that part of it cut out on
    ``grey`` (S, S, 3); None where it is in none of them."""
    best: tuple[float, int, Any] | None = None
    for number, picture in enumerate(pictures):
        for found in detect(grounding.detector, picture, text, grounding.least)[:1]:
            if best is None or found.score > best[0]:
                best = (found.score, number, found.box)
    if best is None:
        return None
    _, number, box = best
    mask = mask_in(grounding.segmenter, pictures[number], box)
    return (number, cut_out(np.asarray(pictures[number]), mask, grey)) if mask.any() else None

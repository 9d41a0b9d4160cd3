"""Where in a picture the thing is that words name: GroundingDINO."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from scenelang.backends.base import need
from scenelang.backends.diffusion.memory import memory_told
from scenelang.backends.grounding.loading import Loaded, load_network
from scenelang.backends.weights import INSTALL, Shelf
from scenelang.grammar.diagnostics import SceneError

DETECTOR = "IDEA-Research/grounding-dino-base"
LEAST = 0.25  # score of a box that counts
_LONGEST = 200  # characters of what is looked for
Box = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class Found:
    """A ``box`` in pixels (left, top, right, bottom), and how surely it holds what was looked for, from 0 to 1."""

    box: Box
    score: float


def load_detector(name: str = DETECTOR, shelf: Shelf | None = None, device: str = "cpu") -> Loaded:
    """The detector ``name``; raises SceneError as ``load_network`` does."""
    return load_network(name, "GroundingDinoForObjectDetection", "GroundingDinoProcessor", shelf, device)


def phrase(text: str) -> str:
    """A text as the detector reads one: lower-case, ending in a full stop; raises SceneError("value") for none."""
    said = " ".join(text.lower().split()).strip(" .")
    if not said or len(said) > _LONGEST:
        raise SceneError("value", f"what is looked for in a picture has 1 to {_LONGEST} characters")
    return f"{said}."


def detect(detector: Loaded, picture: Any, text: str, least: float = LEAST) -> list[Found]:
    """The boxes in the PIL ``picture`` (RGB) whose score for ``text`` is above ``least``, the surest first."""
    torch = need("torch", INSTALL)
    given = detector.processor(images=picture, text=phrase(text), return_tensors="pt").to(detector.network.device)
    with torch.no_grad(), memory_told():
        output = detector.network(**given)
    scores = output.logits[0].sigmoid().amax(-1).float().cpu()  # of the likeliest of the words
    middles, sizes = output.pred_boxes[0].float().cpu().split(2, dim=-1)
    scale = torch.tensor([picture.width, picture.height] * 2)
    limits = torch.cat([middles - sizes / 2.0, middles + sizes / 2.0], -1).clamp(0.0, 1.0) * scale
    order = torch.argsort(scores, descending=True, stable=True).tolist()
    return [_found(limits[i], scores[i]) for i in order if float(scores[i]) > least]


def _found(limits: Any, score: Any) -> Found:
    left, top, right, bottom = limits.tolist()
    return Found((left, top, right, bottom), float(score))

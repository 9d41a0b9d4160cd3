"""A pseudo-word for a picture: the token vector with which a sentence comes nearest to the picture in Z_CLIP.

A picture's own embedding lies where sentences end, not where their tokens begin, so it cannot stand in a sentence. The
vector is looked for that makes the sentence's embedding point the way of the picture's.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import need
from scenelang.backends.clip.images import encode_images
from scenelang.backends.clip.models import ClipModel
from scenelang.backends.clip.prompts import parse_prompt
from scenelang.backends.clip.text import TextEncoder
from scenelang.backends.diffusion.memory import memory_told
from scenelang.backends.weights import INSTALL
from scenelang.grammar.diagnostics import SceneError

SENTENCE = "a photo of <picture>"
START = "object"
STEPS = 300
_RATE = 1e-2


@dataclass(frozen=True, slots=True, eq=False)
class PictureWord:
    """``vectors`` (1, width), and the cosine of the sentence to the picture with them and at the start."""

    vectors: npt.NDArray[np.float32]
    cosine: float
    before: float


def picture_word(model: ClipModel, picture: Any, start: str = START, steps: int = STEPS) -> PictureWord:
    """The pseudo-word of a PIL picture, begun at the mean of the tokens of ``start``; the best of all ``steps``, so
    never worse than the start. The same every time.

    Raises SceneError("value") for a text without tokens.
    """
    torch = need("torch", INSTALL)
    encoder, prompt = TextEncoder(model), [parse_prompt(SENTENCE)]
    tokens = encoder.vectors_of(start).detach().float()
    if not len(tokens):
        raise SceneError("value", f'a pseudo-word cannot start from "{start}", which has no tokens')
    with memory_told():
        wanted = encode_images(model, [picture])[0].detach().float()
        vector = tokens.mean(0, keepdim=True).clone().requires_grad_(True)
        optimiser = torch.optim.Adam([vector], lr=_RATE)
        best, found, first = -2.0, vector.detach().clone(), 0.0
        for number in range(steps + 1):
            pooled = encoder.encode(prompt, {"picture": vector}).pooled[0].float()
            cosine = torch.nn.functional.cosine_similarity(pooled, wanted, dim=0)
            now = float(cosine.detach())
            first = now if number == 0 else first
            if now > best:
                best, found = now, vector.detach().clone()
            if number < steps:
                optimiser.zero_grad()
                (-cosine).backward()
                optimiser.step()
    return PictureWord(found.cpu().numpy().astype(np.float32), best, first)

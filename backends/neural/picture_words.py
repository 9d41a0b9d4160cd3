"""A pseudo-word for a picture: the token vector with which a sentence comes nearest to the picture in Z_CLIP.

A picture's own embedding lies where sentences end, not where their tokens begin, so it cannot stand in a sentence. The
vector is looked for that makes the sentence's embedding point the way of the picture's.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import need
from scenelang.backends.files import user_folder, written_whole
from scenelang.backends.neural.clip import TEXT_SPACE, ClipModel, TextEncoder, encode_images, load_clip, parse_prompt
from scenelang.backends.neural.diffusion import memory_told
from scenelang.backends.neural.weights import INSTALL, shelf
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


# Blocks of Minecraft by meaning: the name that says most nearly what an unknown one does (the paper, appendix
# "Minecraft Renderer").


_SENTENCE = "a block of {} in Minecraft"
_BATCH = 32


def by_meaning(name: str, candidates: Sequence[str]) -> str | None:
    """The candidate nearest to ``name`` in OpenCLIP's text space; None where the extra `neural` or the weights are not
    on this machine: none are fetched for this."""
    if find_spec("open_clip") is None or find_spec("torch") is None:
        return None
    try:
        encoder = _encoder(str(shelf().folder or ""))
    except SceneError:
        return None
    known = _known(encoder, tuple(candidates))
    (wanted,) = _encoded(encoder, [name])
    return candidates[int(np.argmax(known @ wanted))]


@lru_cache(maxsize=1)
def _encoder(folder: str) -> TextEncoder:
    """The encoder of the paper's text space from the shelf at ``folder``, or the hub's cache."""
    return TextEncoder(load_clip(TEXT_SPACE, shelf(folder or None, fetch=False)))


def _known(encoder: TextEncoder, names: tuple[str, ...]) -> npt.NDArray[np.float32]:
    """The embeddings of all blocks' names (N, D), worked out once and kept in the user's cache."""
    told = "\n".join([str(TEXT_SPACE), encoder.fingerprint, *names])
    path = user_folder("CACHE") / f"blocks-{hashlib.sha256(told.encode()).hexdigest()[:16]}.npy"
    kept = _kept(path, len(names))
    if kept is not None:
        return kept
    made = _encoded(encoder, names)
    _keep(path, made)
    return made


def _encoded(encoder: TextEncoder, names: Sequence[str]) -> npt.NDArray[np.float32]:
    """Of length 1 each."""
    rows = []
    for start in range(0, len(names), _BATCH):
        said = [(_SENTENCE.format(name.replace("_", " ")),) for name in names[start : start + _BATCH]]
        rows.append(encoder.encode(said).pooled.float().cpu().numpy())
    matrix: npt.NDArray[np.float32] = np.concatenate(rows, dtype=np.float32)
    matrix /= np.maximum(np.linalg.norm(matrix, axis=1, keepdims=True), 1e-12)
    return matrix


def _kept(path: Path, count: int) -> npt.NDArray[np.float32] | None:
    try:
        found: npt.NDArray[np.float32] = np.load(path, allow_pickle=False)
    except (OSError, ValueError):
        return None
    return found if found.ndim == 2 and len(found) == count else None


def _keep(path: Path, matrix: npt.NDArray[np.float32]) -> None:
    """Written for the next time; where that cannot be, it is worked out again then."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with written_whole(path) as temporary, temporary.open("wb") as file:
            np.save(file, matrix)
    except (OSError, SceneError):
        return

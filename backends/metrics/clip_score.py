"""CLIP similarity: how much pictures of a scene are like a text (the paper's metric of alignment)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from scenelang.backends.base import need
from scenelang.backends.clip.images import encode_images
from scenelang.backends.clip.models import JUDGE, ClipModel, ClipName, load_clip
from scenelang.backends.diffusion.memory import memory_told
from scenelang.backends.picture import Picture
from scenelang.backends.weights import INSTALL, Shelf


class ClipScore:
    """The judge, a CLIP model; by default that of the paper. Raises SceneError("weights") where it is not to be had."""

    def __init__(self, name: ClipName = JUDGE, shelf: Shelf | None = None, device: str = "cpu") -> None:
        self._model = load_clip(name, shelf, device)

    @property
    def name(self) -> str:
        return str(self._model.name)

    def cosines(self, text: str, pictures: Sequence[Picture]) -> list[float]:
        """The cosine of the text's embedding with that of each picture (H, W, 3), from -1 to 1. A text of more than
        the model's 77 tokens is cut, as CLIP does."""
        return cosines(self._model, text, pictures)


def cosines(model: ClipModel, text: str, pictures: Sequence[Picture]) -> list[float]:
    """As ``ClipScore.cosines``, by a model that is there."""
    torch = need("torch", INSTALL)
    image = need("PIL.Image", "pillow")
    device = next(model.network.parameters()).device
    with torch.no_grad(), memory_told():
        said: Any = model.network.encode_text(model.tokenizer([text]).to(device)).float()
        seen = encode_images(model, [image.fromarray(picture) for picture in pictures]).float()
    found = torch.nn.functional.normalize(seen, dim=-1) @ torch.nn.functional.normalize(said, dim=-1)[0]
    return [float(cosine) for cosine in found.tolist()]

"""The image encoder of a CLIP model."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

from scenelang.backends.base import need
from scenelang.backends.clip.models import ClipModel
from scenelang.backends.weights import INSTALL
from scenelang.grammar.diagnostics import SceneError

_LARGEST = 64_000_000  # pixels


def encode_images(model: ClipModel, pictures: Sequence[Any], batch: int = 16) -> Any:
    """The embeddings (N, D) of PIL pictures, not normalised; gradients stop here."""
    torch = need("torch", INSTALL)
    device = next(model.network.parameters()).device
    found = []
    with torch.no_grad():
        for start in range(0, len(pictures), batch):
            rows = [model.prepare(picture.convert("RGB")) for picture in pictures[start : start + batch]]
            found.append(model.network.encode_image(torch.stack(rows).to(device)))
    return torch.cat(found)


def open_picture(path: Path | str | BytesIO) -> Any:
    """A picture file as RGB; raises SceneError("file") where it is none, or too large."""
    image = need("PIL.Image", "pillow")
    try:
        with image.open(path) as picture:
            if picture.width * picture.height > _LARGEST:
                raise SceneError("file", f"{path} has more than {_LARGEST:,} pixels")
            return need("PIL.ImageOps", "pillow").exif_transpose(picture).convert("RGB")
    except (OSError, ValueError, SyntaxError, image.DecompressionBombError) as error:
        raise SceneError("file", f"{path} is no picture that can be read: {str(error)[:120]}") from None

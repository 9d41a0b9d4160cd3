"""A GPU whose memory is full, told in one line."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from scenelang.backends.base import need
from scenelang.backends.weights import INSTALL
from scenelang.grammar.diagnostics import SceneError


@contextmanager
def memory_told() -> Iterator[None]:
    """Raises SceneError("unsupported") in place of torch's error where the block runs out of the GPU's memory."""
    torch = need("torch", INSTALL)
    try:
        yield
    except torch.OutOfMemoryError as error:
        hint = "smaller pictures or models, fewer Gaussians or steps at once, or --device cpu"
        raise SceneError("unsupported", "the memory of the GPU is full", hint=hint) from error

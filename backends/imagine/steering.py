"""What methods that make a model heed a layout have in common."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Protocol

from scenelang.backends.imagine.layout import Box


@dataclass(frozen=True, slots=True, eq=False)
class Region:
    """A ``box`` as shares of the picture x0, y0, x1, y1, and what belongs there: ``words`` (1, T, D) of its sentence,
    ``pooled`` (1, D)."""

    box: Box
    words: Any
    pooled: Any


class Steering(Protocol):
    """One method at work on one picture: its context manager changes the model and puts it back."""

    def __enter__(self) -> Steering: ...

    def __exit__(self, *_: object) -> None: ...

    def step(self, number: int, steps: int) -> dict[str, Any] | None:
        """Called before each of ``steps`` steps, from 0: what attention is to be given there besides the words."""


class Unsteered:
    """The model as it is."""

    def __enter__(self) -> Steering:
        return self

    def __exit__(self, *_: object) -> None:
        return None

    def step(self, number: int, steps: int) -> dict[str, Any] | None:
        return None


@contextmanager
def processors(unet: Any, chosen: Mapping[str, Any]) -> Iterator[None]:
    """Inside the block the attention layers named in ``chosen`` work by other processors."""
    before = dict(unet.attn_processors)
    unet.set_attn_processor({**before, **chosen})
    try:
        yield
    finally:
        unet.set_attn_processor(before)


def shape_of(places: int, latent: tuple[int, int]) -> tuple[int, int]:
    """Height and width of a layer whose sequence has ``places``, in a model that works on ``latent`` (height, width):
    each level halves both, rounded up."""
    height, width = latent
    while height * width > places and height * width > 1:
        height, width = (height + 1) // 2, (width + 1) // 2
    if height * width != places:
        raise ValueError(f"no level of a {latent[0]} x {latent[1]} latent has {places} places")
    return height, width


def inside(box: Box, shape: tuple[int, int]) -> list[int]:
    """The places, row by row, of the cells of a grid ``shape`` (height, width) whose centres lie in ``box``; the cell
    nearest to its middle where there is none."""
    height, width = shape
    columns = _between(box[0], box[2], width)
    rows = _between(box[1], box[3], height)
    return [row * width + column for row in rows for column in columns]


def _between(low: float, high: float, cells: int) -> Sequence[int]:
    found = [i for i in range(cells) if low <= (i + 0.5) / cells <= high]
    return found or [min(cells - 1, max(0, int(0.5 * (low + high) * cells)))]

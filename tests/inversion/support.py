"""Subjects of the toy model, and what its pictures show."""

from __future__ import annotations

import math
from pathlib import Path

from later import later
from toy.model import ONE_GREY, unpack
from toy.pictures import COLORS, Orbit, picture

from scenelang.backends.neural.diffusion import DiffusionModel
from scenelang.backends.neural.diffusion_loading import load_diffusion
from scenelang.backends.neural.inversion import STYLE, LearnedSubject, entity_prompt, initial_vector

torch = later("torch")

VIEW = Orbit(0.6, 0.3, 3.2, math.radians(20.0))


def toy(folder: Path) -> DiffusionModel:
    """The committed toy model, unpacked."""
    return load_diffusion(unpack(folder, ONE_GREY))


def shown(color: str, shape: str) -> torch.Tensor:
    """A picture (3, 32, 32) of one solid."""
    return picture(shape, COLORS[color], VIEW)


def subject(name: str, color: str, shape: str) -> LearnedSubject:
    return LearnedSubject(shown(color, shape), entity_prompt(name))


def starts(model: DiffusionModel, *names: str) -> dict[str, torch.Tensor]:
    """Pseudo-words that begin as "sphere", and the style as "toy"."""
    words = {name: initial_vector(model.text_encoder, "sphere") for name in names}
    return {**words, STYLE: initial_vector(model.text_encoder, "toy")}

"""Placeholder for a word that is neither bound nor a primitive: a box that a neural renderer may interpret."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from scenelang.interpreter.scene.primitives.base import Symmetry
from scenelang.interpreter.scene.primitives.cube import Cube


@dataclass(frozen=True, slots=True)
class Semantic(Cube):
    """Box of ``size`` centred at the origin, with a default colour derived from its word."""

    word = ""
    doc = "a semantic primitive: a box of its `:scale`, centred at the origin"
    is_solid = False
    is_semantic = True
    symmetry = Symmetry(unknown=True)

    def color_seed(self, word: str, attributes: Mapping[str, Any]) -> tuple[str, float, float] | None:
        return word, 0.34, 0.93

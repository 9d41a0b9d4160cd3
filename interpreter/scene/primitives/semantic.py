"""The stand-in for a word that nothing binds and no primitive has: a box that a renderer may make something of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from scenelang.interpreter.scene.primitives.base import Symmetry
from scenelang.interpreter.scene.primitives.cube import Cube


@dataclass(frozen=True, slots=True)
class Semantic(Cube):
    """A box of ``size``, centred at the origin, in a stable tint of its word."""

    word = ""
    doc = "a semantic primitive: a box of its `:scale`, centred at the origin"
    is_solid = False
    is_semantic = True
    turn = Symmetry(whole=True)

    def own_color(self, word: str, attributes: Mapping[str, Any]) -> tuple[str, float, float] | None:
        return word, 0.34, 0.93

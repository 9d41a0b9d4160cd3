"""Scenes built directly from entities."""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import Any

import pytest

from scenelang.interpreter.scene import pose
from scenelang.interpreter.scene.entity import Entity, Scene
from scenelang.interpreter.scene.primitives import shape_of
from scenelang.interpreter.values.values import ANONYMOUS, IDENTITY, Embedding, Matrix, Pair, Vector

SHEAR = Matrix((1, 0.7, 0, 0, 0, 1, 0.2, 0, 0, 0, 1, 0))
MIRROR = pose.reflection((0, 0, 0), (1, 0.3, 0.2))


class Make:
    """Builders of entities, poses and scenes."""

    def vector(self, *numbers: float) -> Vector:
        return Vector(float(number) for number in numbers)

    def primitive(self, word: str, **attributes: Any) -> Entity:
        given = {name.replace("_", "-"): value for name, value in attributes.items()}
        given = {n: self.vector(*v) if isinstance(v, (list, tuple)) else v for n, v in given.items()}
        return Entity(word, Embedding(attributes=given), (), shape_of(word, given))

    def group(self, word: str, *parts: Any) -> Entity:
        pairs = [Pair(*part) if isinstance(part, tuple) else Pair(part, IDENTITY) for part in parts]
        return Entity(word, ANONYMOUS, tuple(pairs))

    def scene(self, *parts: Any) -> Scene:
        return Scene("scene", [self.group("scene", *parts)], False)

    def chain(self, *matrices: Sequence[float]) -> Matrix:
        result = IDENTITY
        for matrix in matrices:
            result = pose.compose(result, matrix)
        return result

    def odd(self) -> Scene:
        """Every solid: plain, sheared, mirrored and stretched; a flat cube."""
        parts = []
        for i, word in enumerate(("cube", "sphere", "cylinder", "cone")):
            color = ((0.8, 0.15, 0.1), (0.1, 0.5, 0.15), (0.1, 0.2, 0.7), (0.8, 0.6, 0.1))[i]
            entity = self.primitive(word, color=color)
            stretched = self.chain(
                MIRROR, pose.rotation(0.7, (0, 0, 1), (0, 0, 0)), pose.scaling(0.4, 1.2, 0.8, (0, 0, 0))
            )
            parts.append((entity, pose.translation(3 * i - 4.5, 0, 3)))
            parts.append((entity, self.chain(pose.translation(3 * i - 4.5, 0, 0), SHEAR)))
            parts.append((entity, self.chain(pose.translation(3 * i - 4.5, 0, -3), stretched)))
        parts.append((self.primitive("cube", scale=(1.5, 0, 1.5), color=(0.9, 0.2, 0.6)), pose.translation(0, 2.5, 3)))
        return self.scene(*parts)

    def random(self, count: int, seed: int = 1) -> Scene:
        rng = random.Random(seed)
        parts = []
        size = 2.0 * (1 / count) ** (1 / 3)
        kinds = ("cube", "sphere", "cylinder", "cone")
        entities = [self.primitive(word, color=(rng.random(), rng.random(), rng.random())) for word in kinds]
        for _ in range(count):
            place = pose.translation(*(rng.uniform(-5, 5) for _ in range(3)))
            turn = pose.rotation(rng.uniform(0, 6), [rng.gauss(0, 1) for _ in range(3)], (0, 0, 0))
            grow = pose.scaling(*(size * rng.uniform(0.5, 1.3) for _ in range(3)), (0, 0, 0))
            parts.append((rng.choice(entities), self.chain(place, turn, grow)))
        return self.scene(*parts)


@pytest.fixture(scope="session")
def make() -> Make:
    return Make()

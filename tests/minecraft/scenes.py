"""Scenes of blocks for property tests, built without the language."""

from __future__ import annotations

from typing import Any

from hypothesis import strategies as st

from minecraft.oracle import Cuboid
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.scene.pose import translation
from scenelang.interpreter.scene.primitives import shape_of
from scenelang.interpreter.values.values import Embedding, Matrix, Pair, Vector

BLOCKS = ["minecraft:stone", "minecraft:oak_planks", "minecraft:air", None]
STATES = st.sampled_from(BLOCKS)
CUBOIDS = st.builds(
    Cuboid,
    st.tuples(*[st.integers(-6, 6)] * 3),
    st.tuples(*[st.integers(0, 5)] * 3),
    STATES,
    st.booleans(),
)


def primitive(cuboid: Cuboid) -> Entity:
    if cuboid.state is None:
        attributes: dict[str, Any] = {"scale": _array(cuboid.size)}
        return Entity("delete-blocks", Embedding(None, None, attributes), (), shape_of("delete-blocks", attributes))
    attributes = {"block-type": cuboid.state, "scale": _array(cuboid.size), "fill": cuboid.fill}
    return Entity("set-cuboid", Embedding(None, None, attributes), (), shape_of("set-cuboid", attributes))


def _array(numbers: tuple[int, ...]) -> Vector:
    return Vector([float(n) for n in numbers])


def group(*parts: tuple[Entity, Matrix]) -> Entity:
    return Entity("group", Embedding(None, None, {}), tuple(Pair(entity, matrix) for entity, matrix in parts))


def placed(cuboids: list[Cuboid]) -> Entity:
    return group(*[(primitive(c), translation(*c.position)) for c in cuboids])


STEPS = st.tuples(*[st.integers(-9, 9)] * 3)

"""What the geometry of an export must be: worked out from ``flatten`` alone, one primitive after the other."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import assume
from hypothesis import strategies as st

from scenelang.backends.exports.plan import SEGMENTS, surface_of
from scenelang.backends.surfaces.appearance import look_of
from scenelang.backends.surfaces.stand_ins import drawn_scene
from scenelang.grammar.datum import Source
from scenelang.interpreter.scene import pose
from scenelang.interpreter.scene.entity import Entity, Scene, descendants
from scenelang.interpreter.scene.flatten import flatten
from scenelang.interpreter.scene.primitives import shape_of
from scenelang.interpreter.values.values import ANONYMOUS, Embedding, Matrix, Pair, Vector
from scenelang.session.session import Options, Session

EXAMPLES = Path(__file__).parent.parent.parent / "examples"
_LARGE = ("fractal-tree.scene", "menger-sponge.scene")  # a hundred thousand primitives and more


def on_examples(*endings: str) -> list[Any]:
    """Parameters of a test for every example, its name and each of ``endings``; the large ones are slow tests."""
    names = sorted(path.name for path in EXAMPLES.glob("*.scene"))
    rows = [(name, *ending) for name in names for ending in ([(each,) for each in endings] or [()])]
    return [pytest.param(*row, marks=pytest.mark.slow) if row[0] in _LARGE else pytest.param(*row) for row in rows]


@dataclass(frozen=True)
class Expected:
    """One visible primitive: the words down to it, world ``vertices`` (V, 3), linear ``color``."""

    path: tuple[str, ...]
    vertices: np.ndarray
    color: tuple[float, float, float]
    matrix: np.ndarray
    entity: Entity


def expected(scene: Scene, frame: int = 0, segments: int = SEGMENTS) -> Iterator[Expected]:
    """The visible primitives of a frame in depth-first order."""
    flat = flatten(scene).frames[frame]
    for i in range(len(flat)):
        entity = flat.primitives[flat.index[i]]
        look = look_of(entity)
        surface = surface_of(entity, segments)
        if surface is None or look.opacity == 0.0:
            continue
        matrix = flat.matrices[i]
        vertices = surface.vertices @ matrix[:, :3].T + matrix[:, 3]
        yield Expected((*flat.paths[flat.path_index[i]], entity.word), vertices, look.color, matrix, entity)


def corners_of(one: Expected, segments: int = SEGMENTS) -> np.ndarray:
    """The corners of a primitive's triangles (3 F, 3) in the world."""
    surface = surface_of(one.entity, segments)
    assert surface is not None
    return one.vertices[surface.faces.ravel()]


def obj_corners(path: Path) -> np.ndarray:
    """The corners of the triangles of an OBJ file, one a row: position, color if all have one, and normal."""
    lines = [line.split() for line in path.read_text().splitlines()]
    found = [line[1:] for line in lines if line[:1] == ["v"]]
    width = min(map(len, found))
    points = np.array([row[:width] for row in found], float)
    normals = np.array([line[1:] for line in lines if line[:1] == ["vn"]], float)
    pairs = np.array([corner.split("//") for line in lines if line[:1] == ["f"] for corner in line[1:]], int) - 1
    return np.hstack([points[pairs[:, 0]], normals[pairs[:, 1]]])


@cache
def example(name: str, **defines: Any) -> Scene:
    path = EXAMPLES / name
    options = Options(defines={key: str(value) for key, value in defines.items()})
    result = Session(options).evaluate(Source(str(path), path.read_text()))
    assert result.scene is not None, result.diagnostics
    return drawn_scene(result.scene)


def same_points(a: np.ndarray, b: np.ndarray, tolerance: float) -> bool:
    """True when both hold the same points in any order: every sorted coordinate sum agrees, to ``tolerance``."""
    if len(a) != len(b):
        return False
    probes = np.random.default_rng(0).normal(size=(a.shape[1], 7))
    scale = max(1.0, float(np.abs(b).max(initial=0.0)))
    return bool(np.allclose(np.sort(a @ probes, axis=0), np.sort(b @ probes, axis=0), atol=10 * tolerance * scale))


# --- small scenes with any pose --------------------------------------------------------------------------------

_NUMBERS = st.sampled_from([-2.0, -1.0, -0.5, 0.3, 0.5, 1.0, 1.5, 3.0])
_LINEAR = st.lists(_NUMBERS, min_size=9, max_size=9)


@st.composite
def poses(draw: Any) -> Matrix:
    """Moves, turns, mirrors, shears and stretches."""
    place = pose.translation(draw(_NUMBERS), draw(_NUMBERS), draw(_NUMBERS))
    turn = pose.rotation(draw(st.floats(-3, 3)), (1.0, draw(_NUMBERS), 0.5), (0.0, 0.0, 0.0))
    kind = draw(st.integers(0, 4))
    if kind == 0:
        return place
    if kind == 1:
        return pose.compose(place, turn)
    if kind == 2:
        return pose.compose(pose.compose(place, turn), pose.scaling(draw(_NUMBERS), draw(_NUMBERS), 0.7, (0, 0, 0)))
    if kind == 3:
        return pose.compose(place, pose.reflection((0, 0, 0), (1, draw(_NUMBERS), 0.2)))
    a, b, c, d, e, f, g, h, i = draw(_LINEAR)
    return Matrix((a, b, c, place[3], d, e, f, place[7], g, h, i, place[11]))


@st.composite
def primitives(draw: Any) -> Entity:
    """One of every kind of primitive, with every attribute of its geometry."""
    word = draw(st.sampled_from(["cube", "sphere", "cylinder", "cone", "lamp post"]))
    given: dict[str, Any] = {}
    if word in ("cube", "lamp post"):
        given["scale"] = Vector((abs(draw(_NUMBERS)), abs(draw(_NUMBERS)), draw(st.sampled_from([0.0, 0.4, 2.0]))))
    elif draw(st.booleans()):
        given["radius"] = abs(draw(_NUMBERS))
    if word in ("cylinder", "cone"):
        given["p0"] = Vector((draw(_NUMBERS), 0.0, 0.0))
        given["p1"] = Vector((0.1, draw(_NUMBERS), draw(_NUMBERS)))
    if draw(st.booleans()):
        given["color"] = Vector(draw(st.sampled_from([(1.0, 0.2, 0.0), (0.002, 0.03, 0.5), (0.0, 0.0, 0.0)])))
    if draw(st.integers(0, 3)) == 0:
        given["opacity"] = draw(st.sampled_from([0.0, 0.5]))
    return Entity(word, Embedding(attributes=given), (), shape_of(word, given))


@st.composite
def entities(draw: Any) -> Entity:
    """Three levels of shared groups."""
    level = draw(st.lists(primitives(), min_size=1, max_size=3))
    for word in ("arm", "été", "arm"):
        groups = []
        for _ in range(draw(st.integers(1, 2))):
            parts = draw(st.lists(st.tuples(st.sampled_from(level), poses()), min_size=1, max_size=3))
            groups.append(Entity(word, ANONYMOUS, tuple(Pair(*part) for part in parts)))
        level = [*groups, draw(st.sampled_from(level))]
    return level[0]


@st.composite
def scenes(draw: Any, frames: int = 1) -> Scene:
    """A scene of one or several frames, whose later frames share some of the first's entities; not all of opacity 0."""
    pool = [draw(entities()) for _ in range(frames)]
    roots = []
    for _ in range(frames):
        parts = draw(st.lists(st.tuples(st.sampled_from(pool), poses()), min_size=1, max_size=3))
        roots.append(Entity("root", ANONYMOUS, tuple(Pair(*part) for part in parts)))
    clear = (e.embedding.attributes.get("opacity") == 0.0 for e in descendants(*roots) if e.is_primitive)
    assume(not all(clear))
    return Scene("root", roots, frames > 1)

"""Exact boxes and flattening against brute force; the size of a scene does not matter to them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from searching import many
from support import calls, evaluate, peak_bytes

from scenelang.grammar.diagnostics import LimitError
from scenelang.interpreter.inspection.numbering import instances, number_scene, primitive_handles
from scenelang.interpreter.scene import pose
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.entity import Entity, Scene, count_words, primitive_count
from scenelang.interpreter.scene.flatten import flatten, flatten_entity
from scenelang.interpreter.scene.primitives import shape_of
from scenelang.interpreter.values.values import ANONYMOUS, Embedding, Matrix, Pair, Vector

SEGMENTS = 720


def primitive(word: str, handle: str | None = None, **attributes: object) -> Entity:
    return Entity(word, Embedding(handle, None, attributes), (), shape_of(word, attributes))


def group(word: str, *parts: tuple[Entity, Matrix]) -> Entity:
    return Entity(word, ANONYMOUS, tuple(Pair(entity, matrix) for entity, matrix in parts))


def surface(shape: Any) -> npt.NDArray[np.float64]:
    """Points whose hull is the shape (within the error of its segments)."""
    name = shape.word
    if name in ("cube", ""):
        corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
        return corners * np.array(shape.size)
    if name == "sphere":
        u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 240), np.linspace(0, np.pi, 121))
        points = np.stack([np.cos(u) * np.sin(v), np.cos(v), np.sin(u) * np.sin(v)], -1).reshape(-1, 3)
        return points * shape.radius
    p0, p1 = np.array(shape.p0), np.array(shape.p1)
    axis = (p1 - p0) / np.linalg.norm(p1 - p0)
    side = np.cross(axis, [1.0, 0, 0] if abs(axis[0]) < 0.9 else [0, 1.0, 0])
    side /= np.linalg.norm(side)
    angles = np.linspace(0, 2 * np.pi, SEGMENTS)[:, None]
    circle = shape.radius * (np.cos(angles) * side + np.sin(angles) * np.cross(axis, side))
    return np.concatenate([p0 + circle, [p1] if name == "cone" else p1 + circle])


floats = st.floats(-2, 2, allow_nan=False)
sizes = st.floats(0.05, 3)
points = st.tuples(floats, floats, floats)


@st.composite
def poses(draw: st.DrawFn) -> Matrix:
    """Rotations, reflections, shears and uneven scales, composed."""
    matrix = pose.translation(*draw(points))
    for _ in range(draw(st.integers(0, 3))):
        kind = draw(st.sampled_from(["rotate", "scale", "reflect", "shear"]))
        axis = draw(points.filter(lambda p: sum(x * x for x in p) > 0.01))
        if kind == "rotate":
            step = pose.rotation(draw(floats) * 3, axis, draw(points))
        elif kind == "scale":
            step = pose.scaling(draw(sizes), draw(sizes), -draw(sizes), draw(points))
        elif kind == "reflect":
            step = pose.reflection(draw(points), axis)
        else:
            step = Matrix((1.0, draw(floats), 0.0, 0.0, 0.0, 1.0, draw(floats), 0.0, 0.0, 0.0, 1.0, 0.0))
        matrix = pose.compose(matrix, step)
    return matrix


@st.composite
def primitives(draw: st.DrawFn) -> Entity:
    word = draw(st.sampled_from(["cube", "sphere", "cylinder", "cone", "moai"]))
    if word in ("cube", "moai"):
        return primitive(word, scale=Vector([draw(sizes) for _ in range(3)]))
    if word == "sphere":
        return primitive(word, radius=draw(sizes))
    p0 = draw(points)
    p1 = draw(points.filter(lambda p: math.dist(p, p0) > 0.1))
    return primitive(word, radius=draw(sizes), p0=Vector(p0), p1=Vector(p1))


trees = st.recursive(
    primitives(),
    lambda inner: st.lists(st.tuples(inner, poses()), max_size=4).map(lambda parts: group("group", *parts)),
    max_leaves=12,
)


def naive(root: Entity) -> list[tuple[Entity, npt.NDArray[np.float64]]]:
    """Flattening by plain recursion with 4x4 arrays."""
    if root.is_primitive:
        return [(root, np.eye(4))]
    return [(e, pose.to_array(part.cdr) @ m) for part in root.children for e, m in naive(part.car)]


@settings(max_examples=many(150), deadline=None)
@given(trees)
def test_boxes_are_exact(root: Entity) -> None:
    clouds = []
    for entity, matrix in naive(root):
        assert entity.shape is not None
        clouds.append(surface(entity.shape) @ matrix[:3, :3].T + matrix[:3, 3])
    box = entity_box(root)
    if not clouds:
        assert box is None
        return
    cloud = np.concatenate(clouds)
    assert box is not None
    low, high = cloud.min(0), cloud.max(0)
    size = max(float(np.ptp(cloud, axis=0).max()), 1e-6) * 40  # shears make flat disks, whose segments are coarser
    assert np.all(np.array(box[:3]) <= low + 1e-9 * size)
    assert np.all(np.array(box[3:]) >= high - 1e-9 * size)
    assert np.allclose(box[:3], low, atol=1e-4 * size)
    assert np.allclose(box[3:], high, atol=1e-4 * size)


@settings(max_examples=many(150), deadline=None)
@given(trees)
def test_flattening_is_the_product_of_matrices(root: Entity) -> None:
    expected = naive(root)
    frame = flatten_entity(root)
    assert len(frame) == len(expected) == primitive_count(root)
    for i, (entity, matrix) in enumerate(expected):
        assert frame.primitives[frame.index[i]] is entity
        assert np.allclose(frame.matrices[i], matrix[:3], atol=1e-9)


@settings(max_examples=many(100), deadline=None)
@given(trees)
def test_numbers_follow_depth_first_order(root: Entity) -> None:
    scene = Scene("root", [root], animated=False)
    numbering = number_scene(scene)
    order = list(instances(root))
    for number, (path, _) in enumerate(order, start=1):
        assert numbering.path(number) == path
    (handles,) = primitive_handles(scene, flatten(scene))
    assert handles == [f"z{i}" for i, (_, e) in enumerate(order, start=1) if e.is_primitive]


def test_numbers_skip_handles_of_the_program() -> None:
    scene = evaluate(
        '(bind "t" (lambda (z) (union (call "a") (call "b" <z2>) (call "c") (call "d" <z4*>) (call "e" <z5>) '
        '(call "f"))))'
    )
    (handles,) = primitive_handles(scene, flatten(scene))
    assert handles == ["z3", "z2", "z4", "z4*", "z5", "z6"]


SPONGE = """
(bind "sponge"
  (lambda (:level)
    (if (= level 0)
      (call "cube")
      (for*/union ((x '(-1 0 1)) (y '(-1 0 1)) (z '(-1 0 1)))
        (if (> (+ (if (= x 0) 1 0) (if (= y 0) 1 0) (if (= z 0) 1 0)) 1)
          (union)
          (transform (call "sponge" :level (- level 1))
            (@ (translate [(/ x 3) (/ y 3) (/ z 3)]) (scale (/ 1 3)))))))))
"""


def test_a_level_8_sponge_is_counted_and_measured_without_its_cubes() -> None:
    def measured() -> Scene:
        scene = evaluate(SPONGE + '(scene "sponge" :level 8)')
        assert count_words(scene.root)["cube"] == 20**8
        box = entity_box(scene.root)
        assert box is not None
        assert np.allclose(box, [-0.5, -0.5, -0.5, 0.5, 0.5, 0.5])
        return scene

    with pytest.raises(LimitError, match="25,600,000,000 primitives"):
        flatten(measured())
    assert calls(measured) < 300_000
    assert peak_bytes(measured) < 10_000_000


def test_a_level_4_sponge_flattens() -> None:
    scene = evaluate(SPONGE + '(scene "sponge" :level 4)')
    (frame,) = flatten(scene).frames
    assert len(frame) == 160_000
    assert len(frame.primitives) == 1
    determinants = np.linalg.det(frame.matrices[::1000, :, :3])
    assert np.allclose(determinants, 81.0**-3)


@pytest.mark.slow
def test_a_rotated_fractal_of_a_million_leaves_is_measured_without_them() -> None:
    text = """
    (bind "twig"
      (lambda (:n)
        (if (= n 0)
          (call "cone" :radius .1)
          (for/union ((i (range 4)))
            (transform (call "twig" :n (- n 1))
              (@ (rotate (* i 1.7) [0 1 .3]) (translate [.2 1 0]) (rotate .6 [1 .2 0]) (scale .7)))))))
    (scene "twig" :n 10)
    """
    scene = evaluate(text)
    assert primitive_count(scene.root) == 4**10
    box = entity_box(scene.root)
    assert calls(lambda: entity_box(evaluate(text).root)) < 400_000
    flat = flatten_entity(scene.root)
    shape = flat.primitives[0].shape
    assert shape is not None
    cloud = surface(shape)[:: SEGMENTS // 24]
    low = np.min([(flat.matrices[:, :, :3] @ p + flat.matrices[:, :, 3]).min(0) for p in cloud], axis=0)
    assert box is not None
    assert np.allclose(box[:3], low, atol=2e-3)


def test_deep_chains_are_no_deep_recursion() -> None:
    root = primitive("cube")
    for _ in range(10_000):
        root = group("link", (root, pose.translation(0.0, 0.001, 0.0)))
    assert entity_box(root) is not None
    assert len(flatten_entity(root)) == 1
    assert number_scene(Scene("link", [root], animated=False)).path(10_001) == (0,) * 10_000

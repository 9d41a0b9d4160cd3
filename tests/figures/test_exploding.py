"""Exploded views against closed forms: the centers of parts, by hierarchy, along an axis, to a depth."""

from __future__ import annotations

import numpy as np
import pytest
from support import evaluate

from scenelang.interpreter.scene.exploding import exploded
from scenelang.interpreter.scene.flatten import flatten

PAIRS = """
(bind "pair" (lambda () (union (transform (call "cube") (translate [-1 0 0])) (transform (call "cube") (translate [1 0 0])))))
(bind "it" (lambda () (union (transform (call "pair") (translate [0 3 0])) (transform (call "pair") (translate [0 -3 0])))))
"""


def centers(scene: object) -> np.ndarray:
    (frame,) = flatten(scene).frames  # type: ignore[arg-type]
    return frame.matrices[:, :3, 3]


def test_each_level_moves_apart() -> None:
    moved = centers(exploded(evaluate(PAIRS), 0.5))
    assert moved == pytest.approx(np.array([[-1.5, 4.5, 0], [1.5, 4.5, 0], [-1.5, -4.5, 0], [1.5, -4.5, 0]]))


@pytest.mark.parametrize(("axis", "x", "y"), [("x", 2.0, 3.0), ("y", 1.0, 6.0), ("z", 1.0, 3.0)])
def test_along_an_axis(axis: str, x: float, y: float) -> None:
    moved = centers(exploded(evaluate(PAIRS), 1.0, axis))
    assert np.abs(moved) == pytest.approx(np.tile([x, y, 0.0], (4, 1)))


def test_the_axis_is_that_of_the_world() -> None:
    turned = '(bind "it" (lambda () (transform (call "pair") (rotate (/ pi 3) [0 0 1]))))'
    program = PAIRS.partition('(bind "it"')[0] + turned
    before, moved = centers(evaluate(program)), centers(exploded(evaluate(program), 1.0, "y"))
    assert moved[:, 0] == pytest.approx(before[:, 0])
    assert moved[:, 1] == pytest.approx(2.0 * before[:, 1])


def test_a_mirrored_and_scaled_part_follows_the_world() -> None:
    program = PAIRS.partition('(bind "it"')[0]
    program += '(bind "it" (lambda () (transform (call "pair") (@ (rotate 1 [0 0 1]) (scale [-2 3 .5])))))'
    before, moved = centers(evaluate(program)), centers(exploded(evaluate(program), 1.0, "x"))
    assert moved[:, 0] == pytest.approx(2.0 * before[:, 0])
    assert moved[:, 1] == pytest.approx(before[:, 1])


def test_the_depth_is_limited() -> None:
    moved = centers(exploded(evaluate(PAIRS), 0.5, depth=1))
    assert np.abs(moved) == pytest.approx(np.tile([1.0, 4.5, 0.0], (4, 1)))


def test_sharing_is_kept() -> None:
    scene = exploded(evaluate(PAIRS), 0.5)
    one, other = scene.root.children
    assert one.car is other.car


def test_nothing_moves_by_nothing() -> None:
    scene = evaluate(PAIRS)
    assert centers(exploded(scene, 0.0)) == pytest.approx(centers(scene))

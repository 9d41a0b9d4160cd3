"""Solids thinner than the contact tolerance lie on the ground."""

from __future__ import annotations

import pytest

import scenelang as sl


@pytest.mark.parametrize("thickness", [0.05, 0.02, 0.005, 0.0])
def test_thin_solids_on_the_bare_ground_are_supported(thickness: float) -> None:
    """In a large scene the tolerance is above the thickness of a parking spot, which "floated 0"."""
    scene = sl.evaluate(f"""
    (bind "spot" (lambda () (transform (call "cube" :scale [2.5 {thickness} 5]) (translate [0 {thickness / 2} 0]))))
    (bind "car" (lambda () (transform (call "cube" :scale [1.7 1.2 4]) (translate [0 {thickness + 0.6} 0]))))
    (bind "all" (lambda () (union
      (for*/union ((x (iota 8)) (z (iota 3))) (transform (call "spot") (translate (vector (* 2.6 x) 0 (* 7 z)))))
      (for/union ((x (iota 7))) (transform (call "car") (translate (vector (* 2.6 x) 0 0)))))))
    (scene "all")""")
    assert scene.violations('(supported "spot")', '(supported "car")') == []

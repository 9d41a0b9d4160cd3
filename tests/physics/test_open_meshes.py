"""Open meshes are surfaces of thin pieces with the mass of their boxes, and what is in them is not hidden."""

from __future__ import annotations

from pathlib import Path

import pytest

from scenelang.backends.geometry.lint import check_geometry
from scenelang.backends.physics.grouping import bodies_of
from scenelang.backends.physics.verdicts import check_physics
from scenelang.grammar.datum import Source
from scenelang.session.session import Session

BASKET = """OFF
8 5 0
-.2 0 -.2
.2 0 -.2
.2 0 .2
-.2 0 .2
-.25 .25 -.25
.25 .25 -.25
.25 .25 .25
-.25 .25 .25
4 0 1 2 3
4 0 4 5 1
4 1 5 6 2
4 2 6 7 3
4 3 7 4 0
"""
PROGRAM = """
(bind "floor" (lambda () (transform (call "cube" :scale [6 .1 6]) (translate [0 -.05 0]))))
(bind "basket" (lambda () (call "mesh" :file "basket.off")))
(bind "apple" (lambda () (transform (call "sphere" :radius .05) (translate [0 .052 0]))))
(bind "s" (lambda () (union (call "floor") (call "basket") (call "apple"))))
"""


def test_an_apple_rests_in_an_open_basket(tmp_path: Path) -> None:
    (tmp_path / "basket.off").write_text(BASKET, "utf-8")
    scene = Session().evaluate(Source(str(tmp_path / "a.scene"), PROGRAM)).require()
    bodies = bodies_of(scene.frames[0])
    (basket,) = [body for body in bodies.bodies if "basket" in body.words]
    assert basket.moments.center == pytest.approx([0.0, 0.125, 0.0])  # that of the box, without the lid
    assert [d.name for d in check_physics(scene) if not d.name.endswith("note")] == []
    assert [d.name for d in check_geometry(scene) if not d.name.endswith("note")] == []

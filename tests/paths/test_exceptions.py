"""Edits of one of many equal instances, and of the numbers that place them, in programs of different shapes.

Each edit is checked by evaluating the program again: the chosen instance moves as asked, and no other ("this"), or
others with it ("all").
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import scenelang as sl
from scenelang.grammar.datum import Source
from scenelang.repairs.instance_edits import EditedText, InstanceEdit, edited
from scenelang.session.session import Session

LAMPS = """(bind "lamp" (lambda () (union (call "cylinder" :radius .1)
  (transform (call "sphere" :radius .3) (translate [0 1 0])))))
"""


@dataclass(frozen=True)
class Shape:
    """A program, an instance and a motion; what the edited texts contain, and how many primitives "all" moves."""

    text: str
    path: str
    move: tuple[float, float, float]
    this: str
    all: str
    moved: int
    chosen: int = 1


SHAPES = {
    "index arithmetic": Shape(
        '(bind "a" (lambda () (union-loop 5 (lambda (i) (transform (call "cube") (translate (vector (* 2 i) 0 0)))))))',
        "cube[3]", (0, 1, 0), "(= i 3)", "(vector (* 2 i) 1 0)", 5,
    ),
    "for/list over vectors": Shape(
        '(bind "a" (lambda () (for/list ((p (list [0 0 0] [2 0 0] [4 0 1]))) (transform (call "cone") (translate p)))))',
        "cone[1]", (0, 0, 3), "[2 0 3]", "(translate [0 0 3])", 3,
    ),
    "map with lambda": Shape(
        '(bind "a" (lambda () (map (lambda (x) (transform (call "sphere" :radius .3) (translate (vector x (* x x) 0)))) '
        "(list 1 2 3))))",
        "sphere[2]", (0, 0, 1), "(= x 3)", "(vector x (* x x) 1)", 3,
    ),
    "nested loops": Shape(
        """(bind "table" (lambda () (union (call "cube" :scale [2 .1 2])
          (for*/union ((x '(-1 1)) (z '(-1 1))) (transform (call "cylinder" :radius .1) (translate (vector x .5 z)))))))
        (bind "hall" (lambda () (union (call "table") (transform (call "table") (translate [5 0 0])))))""",
        "table/cylinder[2]", (0, 0.25, 0), "(= x 1)", "(vector x .75 z)", 8, chosen=2,
    ),
    "ring": Shape(
        """(bind "pawn" (lambda () (union (call "cone") (transform (call "sphere" :radius .2) (translate [0 1 0])))))
        (bind "a" (lambda () (ring 6 (call "pawn") :radius 3)))""",
        "pawn[2]", (0.5, 1, 0), "(= i 2)", '(transform (call "pawn")', 12, chosen=2,
    ),
    "along": Shape(
        '(bind "a" (lambda () (along (call "cube" :scale .2) [[0 0 0] [4 0 0]] :count 5)))',
        "cube[4]", (0, 0.5, 0), "(= i 4)", "(translate [0 0.5 0])", 5,
    ),
    "recursion": Shape(
        """(bind "branch" (lambda ((:n 3)) (union (call "cylinder" :radius .1)
          (if (> n 0) (transform (call "branch" :n (- n 1)) (translate [0 1 0])) (union)))))""",
        "cylinder[2]", (1, 0, 0), "(= n 1)", "(translate [0.5 1 0])", 3,
    ),
    "let": Shape(
        '(bind "a" (lambda () (let ((h 2)) (union (transform (call "cube") (translate (vector 0 h 0))) (call "cone")))))',
        "cube", (0, 1, 0), "(h 3)", "", 1,
    ),
    "macro": Shape(
        """(define-syntax at (syntax-rules () ((_ w x) (transform (call w) (translate (vector x 0 0))))))
        (bind "a" (lambda () (union (at "cube" 3) (at "cone" 5))))""",
        "cube", (1, 0, 0), '(at "cube" 4)', "(translate [1 0 0])", 2,
    ),
    "param": Shape(
        """(param gap 2)
        (bind "a" (lambda () (union (transform (call "cube") (translate (vector gap 0 0)))
          (transform (call "cone") (translate (vector (* 2 gap) 0 0))))))""",
        "cube", (1, 0, 0), "(translate [1 0 0])", "(param gap 3)", 2,
    ),
    "solid": Shape(
        """(bind "a" (lambda () (union-loop 3 (lambda (i)
          (transform (difference (call "cube" :scale 2) (call "sphere" :radius 1.2)) (translate (vector (* 3 i) 0 0)))))))""",
        "difference[1]", (0, 0, 2), "(= i 1)", "(vector (* 3 i) 0 2)", 3,
    ),
    "imported word": Shape(
        '(import "lamps.scene")\n(bind "a" (lambda () (union-loop 3 (lambda (i) '
        '(transform (call "lamp") (translate (vector i 0 0)))))))\n',
        "lamp[1]/sphere", (0, 0.5, 0), "(= i 1)", "(vector i 0.5 0)", 6,
    ),
}  # fmt: skip


def _edit(tmp_path: Path, text: str, path: str, **change: Any) -> EditedText:
    (tmp_path / "lamps.scene").write_text(LAMPS)
    return edited(Session(), Source(str(tmp_path / "a.scene"), text), InstanceEdit(path, **change))


def _motions(tmp_path: Path, shape: Shape, text: str) -> tuple[Any, set[int], Any]:
    """The motion of every primitive, the rows of the chosen instances, and how much they are turned."""
    scenes = []
    for each in (shape.text, text):
        (tmp_path / "a.scene").write_text(each)
        scenes.append(sl.load(tmp_path / "a.scene"))
    before, after = (scene.flatten().matrix for scene in scenes)
    assert len(before) == len(after)
    places = [each.pose[:3, 3] for each in scenes[0].instances(shape.path)]
    chosen = {
        row
        for part in scenes[0].instances(shape.path)
        for row, each in enumerate(before)
        if _is_inside(scenes[0], part, each)
    }
    assert places
    return after[:, :3, 3] - before[:, :3, 3], chosen, np.abs(after[:, :, :3] - before[:, :, :3]).max()


def _is_inside(scene: sl.Scene, part: Any, pose: Any) -> bool:
    """Whether a primitive's origin is in the box of an instance."""
    low, high = part.box
    return bool((pose[:3, 3] >= low - 1e-6).all() and (pose[:3, 3] <= high + 1e-6).all())


@pytest.mark.parametrize("name", SHAPES)
def test_only_the_chosen_instance_moves(tmp_path: Path, name: str) -> None:
    shape = SHAPES[name]
    found = _edit(tmp_path, shape.text, shape.path, move=shape.move)
    motions, chosen, turn = _motions(tmp_path, shape, found.text)
    assert turn < 1e-9
    moved = np.flatnonzero(np.abs(motions).max(axis=1) > 1e-9)
    assert len(moved) == shape.chosen
    assert set(moved.tolist()) <= chosen
    assert motions[moved] == pytest.approx(np.tile(shape.move, (len(moved), 1)), abs=1e-6)
    assert shape.this in found.text


@pytest.mark.parametrize("name", [name for name, shape in SHAPES.items() if shape.all])
def test_others_that_share_the_form_move_too(tmp_path: Path, name: str) -> None:
    shape = SHAPES[name]
    if shape.path == "table/cylinder[2]":  # two instances are chosen, which move alike
        assert shape.chosen == 2
    found = _edit(tmp_path, shape.text, shape.path, move=shape.move, shared=True)
    motions, chosen, _ = _motions(tmp_path, shape, found.text)
    moved = np.flatnonzero(np.abs(motions).max(axis=1) > 1e-9)
    assert len(moved) == shape.moved
    asked = np.abs(motions - np.array(shape.move)).max(axis=1) < 1e-6
    assert sum(asked[row] for row in chosen) >= shape.chosen
    assert shape.all in found.text
    assert found.others == shape.moved - shape.chosen


def test_numbers_that_nothing_shares_leave_no_choice(tmp_path: Path) -> None:
    shape = SHAPES["let"]
    with pytest.raises(sl.SceneError, match="nothing else"):
        _edit(tmp_path, '(bind "a" (lambda () (call "cube")))', "a", move=(0, 1, 0), shared=True)
    assert _edit(tmp_path, shape.text, shape.path, move=shape.move).others == 0

"""The columns of ``Scene.flatten``, equal bit for bit to a recursion over the instances, one at a time."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import count
from typing import Any

import numpy as np
import pytest

import scenelang as sl
from scenelang.interpreter.scene import flatten as flattening
from scenelang.interpreter.scene.pose import compose, to_array
from scenelang.interpreter.values.values import IDENTITY

SPONGE = """
(bind "sponge"
  (lambda (:level)
    (if (= level 0)
      (call "cube" :color [.1 .2 .3])
      (for*/union ((x '(-1 0 1)) (y '(-1 0 1)) (z '(-1 0 1)) :when (< (count (list x y z) 0) 2))
        (transform (call "sponge" :level (- level 1))
          (@ (translate [(/ x 3) (/ y 3) (/ z 3)]) (rotate .3 [1 2 3]) (scale (/ 1 3))))))))
(scene "sponge" :level 3)
"""
UNEVEN = """
(bind "nothing" (lambda () (union)))
(bind "tree"
  (lambda (:level)
    (if (= level 0)
      (call "nothing")
      (union
        (call "nothing")
        (call "sphere" :radius (+ 1 (% level 3)))
        (transform (call "tree" :level (- level 1)) (@ (translate [1 -0. 2]) (rotate .4 [0 1 0])))
        (call "cylinder")
        (if (< level 8) (transform (call "tree" :level (- level 1)) (scale -1)) (union))))))
(scene "tree" :level 30)
"""
HANDLES = """
(bind "peg" (lambda (z) (call "cylinder" <z3> :radius .25)))
(bind "row" (lambda () (union-loop 7 (lambda (i) (transform (call "peg") (translate [i 0 0]))))))
(bind "board"
  (lambda () (union (call "row") (call "cube" <top> :color [1 0 0]) (call "row") (call "sphere" <z7>) (call "chair"))))
(scene "board")
"""
BLOCKS = """
(bind "wall"
  (lambda ()
    (union
      (union-loop 5 (lambda (i) (transform (call "cube") (translate [(* -.3 i) .5 i]))))
      (union-loop 5 (lambda (i) (transform (call "set-cuboid" :block-type "stone" :scale [2 1 1]) (translate [(* -.7 i) 3.9 i])))))))
(scene "wall")
"""
ANIMATED = """
(bind "dance"
  (lambda ()
    (for/list ((t (range 4)))
      (union-loop (+ 1 t) (lambda (i) (transform (if (odd? i) (call "cube" <z2>) (call "sphere")) (translate [t i 0])))))))
(scene "dance")
"""
ONE = '(bind "it" (lambda () (call "cube")))'
EMPTY = '(bind "it" (lambda () (union)))'
SCENES = {
    "shared": SPONGE, "uneven": UNEVEN, "handles": HANDLES, "blocks": BLOCKS, "animated": ANIMATED, "one": ONE,
    "empty": EMPTY,
}  # fmt: skip
COLUMNS = ("word", "path", "handle", "shape")


def walk(entity: Any, pose: Any, words: tuple[str, ...], path: tuple[int, ...]) -> Iterator[tuple[Any, Any, Any, Any]]:
    """Every instance in depth-first pre-order, with its pose, and the words and the positions from the root to it."""
    yield entity, pose, words, path
    for i, part in enumerate(entity.children):
        yield from walk(part.car, compose(pose, part.cdr), (*words, entity.word), (*path, i))


def expected(scene: sl.Scene, frame: int) -> list[dict[str, Any]]:
    """The rows of the columns, by the definitions of docs/language.md."""
    numbers: dict[tuple[int, ...], str] = {}
    instances = [list(walk(root, IDENTITY, (), ())) for root in scene.frames]
    taken = {entity.embedding.handle for rows in instances for entity, *_ in rows}
    free = (f"z{i}" for i in count(1) if f"z{i}" not in taken)
    for rows in instances:
        for entity, _, _, path in rows:
            if entity.embedding.handle is None and path not in numbers:
                numbers[path] = next(free)
    return [
        {
            "matrix": snapped(to_array(pose), entity.is_block),
            "word": entity.word,
            "path": words,
            "handle": f"<{entity.embedding.handle or numbers[path]}>",
            "shape": entity.shape.word or "box",
            "color": entity.shape.color,
            "entity": entity,
        }
        for entity, pose, words, path in instances[frame]
        if entity.is_primitive
    ]


def snapped(matrix: Any, is_block: bool) -> Any:
    """The matrix of a primitive: Minecraft blocks start at whole cells."""
    if is_block:
        matrix[:3, 3] = [math.trunc(x) + 0.0 for x in matrix[:3, 3]]
    return matrix


def assert_rows(flat: sl.Primitives, rows: list[dict[str, Any]]) -> None:
    """All columns equal the rows, bit for bit."""
    assert len(flat) == len(rows)
    assert flat.matrix.shape == (len(rows), 4, 4)
    assert flat.color.shape == (len(rows), 3)
    assert flat.matrix.tobytes() == b"".join(row["matrix"].tobytes() for row in rows)
    assert flat.color.tobytes() == b"".join(np.array(row["color"], float).tobytes() for row in rows)
    for name in COLUMNS:
        assert list(getattr(flat, name)) == [row[name] for row in rows], name
    assert list(map(id, flat.entity)) == [id(row["entity"]) for row in rows]


@pytest.mark.parametrize("piece", [3, 1 << 12])
@pytest.mark.parametrize("name", SCENES)
def test_columns_equal_a_recursion(name: str, piece: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(flattening, "_PIECE", piece)
    scene = sl.evaluate(SCENES[name])
    for frame in range(len(scene.frames)):
        rows = expected(scene, frame)
        assert_rows(scene.flatten(frame), rows)
        assert_rows(scene.flatten(frame)[1::3], rows[1::3])
        internal = flattening.flatten_entity(scene.frames[frame])
        assert internal.matrices.tobytes() == scene.flatten(frame).matrix[:, :3].tobytes()


def test_the_scenes_have_what_they_are_for() -> None:
    """Else the comparison above says nothing: several levels and pieces, blocks, handles, frames, nothing."""
    sizes = {name: len(sl.evaluate(text).flatten()) for name, text in SCENES.items()}
    assert sizes["shared"] == 8_000
    assert sizes["uneven"] >= 300
    assert (sizes["one"], sizes["empty"]) == (1, 0)
    assert any(entity.is_block for entity in sl.evaluate(BLOCKS).flatten().entity)
    assert {"<z3>", "<top>", "<z7>"} <= set(sl.evaluate(HANDLES).flatten().handle)
    assert len(sl.evaluate(ANIMATED).frames) == 4


def test_columns_are_fresh_and_writable() -> None:
    scene = sl.evaluate(HANDLES)
    flat = scene.flatten()
    before = flat[:]
    flat.matrix[:], flat.color[:], flat.word[:] = 7.0, 0.5, "other"
    assert flat.word is flat.word
    assert set(flat[2:].word) == {"other"}
    assert (flat[2:].matrix == 7.0).all()
    rows = expected(scene, 0)
    assert_rows(scene.flatten(), rows)
    assert_rows(before, rows)

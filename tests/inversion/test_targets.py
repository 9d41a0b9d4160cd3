"""Entities by word, path and handle; the parts of a scene that have names."""

from __future__ import annotations

import pytest
from support import evaluate

from scenelang.backends.neural.inversion import named_parts, targets_named
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.scene.entity import Scene

TOWN = """
(bind "pillar" (lambda () (call "cube" :scale [1 3 1])))
(bind "tower" (lambda () (union (call "pillar") (transform (call "red_roof") (translate [0 2 0])))))
(bind "town" (lambda () (union (call "tower") (transform (call "tower") (translate [5 0 0]))
                               (transform (call "pillar") (translate [9 0 0])))))
"""


def handles(scene: Scene, name: str) -> tuple[str, ...]:
    (target,) = targets_named(scene, [name])
    return target.handles


def test_entities_by_name() -> None:
    """Numbered down the tree: town 1, tower 2, pillar 3, its cube 4, roof 5, tower 6, pillar 7, cube 8, roof 9, ..."""
    scene = evaluate(TOWN)
    assert handles(scene, "tower") == ("z2", "z6")
    assert set(handles(scene, "pillar")) == {"z3", "z7", "z10"}
    assert set(handles(scene, "tower/pillar")) == {"z3", "z7"}
    assert handles(scene, "town/pillar") == ("z10",)
    assert handles(scene, "town/tower/red_roof") == ("z5", "z9")
    assert handles(scene, "<z9>") == handles(scene, "1/1") == ("z9",)
    (roof,) = targets_named(scene, ["<z9>"])
    assert (roof.text, roof.name, roof.whole) == ("red roof", "z9", False)
    (root,) = targets_named(scene, ["town"])
    assert (root.handles, root.whole) == (("z1",), True)


@pytest.mark.parametrize("name", ["castle", "<z99>", "roof/tower", "pillar/tower", "/"])
def test_names_that_nothing_has(name: str) -> None:
    with pytest.raises(SceneError, match="no visible entity") as caught:
        targets_named(evaluate(TOWN), [name])
    assert caught.value.name == "value"


def test_parts_are_the_nearest_things_with_names() -> None:
    parts = named_parts(evaluate(TOWN))
    assert {part.text: set(part.handles) for part in parts} == {
        "pillar": {"z3", "z7", "z10"}, "red roof": {"z5", "z9"},
    }  # fmt: skip


def test_a_scene_of_primitives() -> None:
    parts = named_parts(evaluate('(bind "pile" (lambda () (union (call "cube") (call "sphere"))))'))
    assert [(part.text, part.handles) for part in parts] == [("cube", ("z2",)), ("sphere", ("z3",))]


def test_handles_of_the_program_and_of_all_frames() -> None:
    ball = '(transform (call "ball_body" (embedding <z7> "red")) (translate [{} 0 0]))'
    roots = " ".join(f'(union {ball.format(k)} (call "floor"))' for k in range(2))
    film = evaluate(f'(bind "film" (lambda () (list {roots})))')
    assert len(film.frames) == 2
    assert handles(film, "ball_body") == ("z7",)
    assert len(handles(film, "floor")) == 1, "the same thing in both frames"


def test_limits() -> None:
    many = '(bind "pile" (lambda () (union-loop 2100 (lambda (i) (transform (call "stone") (translate [i 0 0]))))))'
    with pytest.raises(LimitError, match="2,100 embeddings"):
        targets_named(evaluate(many), ["stone"])
    words = " ".join(f'(call "word{i}")' for i in range(51))
    with pytest.raises(LimitError, match="51 words"):
        named_parts(evaluate(f'(bind "pile" (lambda () (union {words})))'))

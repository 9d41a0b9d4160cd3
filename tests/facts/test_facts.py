"""Bodies, ground and verdicts of small scenes, whose words mean nothing."""

from __future__ import annotations

import numpy as np
import pytest

from scenelang.backends.facts.frame import FrameFacts, facts_of
from scenelang.backends.facts.tolerances import Tolerance
from scenelang.backends.facts.words import flies, is_soft
from scenelang.backends.geometry.arrangement import Arrangement
from scenelang.backends.geometry.lint import CheckedFrame
from scenelang.grammar.datum import Source
from scenelang.session.session import Session

session = Session()
TABLE = """(union (transform (call "cube" :scale [1 .04 .6]) (translate [0 .7 0]))
  (for*/union ((x '(-.45 .45)) (z '(-.25 .25))) (transform (call "cube" :scale [.05 .68 .05]) (translate (vector x .34 z)))))"""


def facts(text: str) -> FrameFacts:
    return FrameFacts(session.evaluate(Source("a.scene", text)).require().frames[0])


def room(*parts: str, words: str = "") -> FrameFacts:
    return facts(
        f'(bind "plim" (lambda () {TABLE})) {words} (bind "room" (lambda () (union {" ".join(parts)}))) (scene "room")'
    )


def kinds(frame: FrameFacts) -> list[str]:
    return [verdict.kind for verdict in frame.verdicts]


@pytest.mark.parametrize("word", ["mug", "zorb"])
def test_a_part_that_can_be_lifted_is_a_body_whatever_its_word(word: str) -> None:
    cup = f'(bind "{word}" (lambda () (call "cylinder" :radius .05 :p0 [0 .72 0] :p1 [0 .82 0])))'
    desk = f'{cup} (bind "desk" (lambda () (union {TABLE} (call "{word}"))))'
    frame = room('(call "desk")', words=desk)
    assert len(frame.bodies) == 2
    assert len(set(frame.bodies.joined.tolist())) == 1  # one in the other reading
    assert len(room('(call "plim")').bodies) == 1


def test_attributes_decide_first() -> None:
    assert len(room('(call "plim" :body #f)').bodies) == 5
    assert kinds(room('(transform (call "plim" :floating #t) (translate [0 2 0]))', '(call "plim")')) == [
        "fixed",
        "supported",
    ]
    assert kinds(room('(transform (call "plim" :fixed #t) (translate [0 2 0]))', '(call "plim")')) == [
        "fixed",
        "supported",
    ]


@pytest.mark.parametrize(
    ("parts", "height", "reason"),
    [
        (['(call "plim")'], 0.0, "the scene reaches y = 0"),
        (['(transform (call "plim") (translate [0 2 0]))'], 2.0, "the lowest point"),
        (['(transform (call "cube" :scale [4 .2 4]) (translate [0 4.9 0]))', '(transform (call "plim") (translate [0 5 0]))'], 4.8,
         "a broad body lies under the rest"),
        # posts that are planted at different depths reach the plane
        ([f'(transform (call "cube" :scale [.1 2 .1]) (translate [{x} {y} 0]))' for x, y in ((0, 0.8), (1, 0.7))], 0.0,
         "the scene reaches y = 0"),
    ],
)  # fmt: skip
def test_ground(parts: list[str], height: float, reason: str) -> None:
    ground = room(*parts).ground
    assert ground.height == pytest.approx(height)
    assert ground.reason == reason


@pytest.mark.parametrize("gap", [0.03, 0.3, 3.0])
def test_a_cluster_without_a_path_to_the_ground_floats_at_any_height(gap: float) -> None:
    """Two that hover together do not silence each other; what is far above everything is a note."""
    pair = "".join(f'(transform (call "zorb") (translate [{x} {0.72 + gap} 0]))' for x in (-0.1, 0.1))
    frame = room(
        '(call "plim")',
        pair,
        words='(bind "zorb" (lambda () (transform (call "cube" :scale .2) (translate [0 .1 0]))))',
    )
    assert kinds(frame) == ["supported", "floating", "floating"]
    assert {verdict.note for verdict in frame.verdicts[1:]} == ({"above everything that stands"} if gap > 1.0 else {""})


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e4])
def test_facts_are_scale_free(scale: float) -> None:
    words = '(bind "zorb" (lambda () (call "cube" :scale .2)))'
    parts = [
        '(call "plim")',
        '(transform (call "zorb") (translate [.45 .82 0]))',
        '(transform (call "zorb") (translate [.55 1.02 0]))',
    ]
    text = f'(bind "plim" (lambda () {TABLE})) {words} (bind "a" (lambda () (union {" ".join(parts)})))'
    scaled = f'{text} (bind "b" (lambda () (transform (call "a") (scale {scale})))) (scene "b")'
    # "a" is one object in "b": its parts are told apart as in the root, by what can be lifted.
    assert kinds(facts(scaled)) == kinds(
        facts(f'{text} (bind "b" (lambda () (transform (call "a") (scale 1)))) (scene "b")')
    )


def test_moving_solids_computes_the_same_as_a_new_frame() -> None:
    words = '(bind "zorb" (lambda () (call "cube" :scale .2)))'
    frame = room('(call "plim")', '(transform (call "zorb") (translate [0 1.5 0]))', words=words)
    rows = np.flatnonzero(frame.bodies.body == 1)
    assert kinds(frame.moved(rows, (0.0, -0.68, 0.0))) == ["supported", "supported"]
    assert kinds(frame) == ["supported", "floating"]


def test_words_soften_by_their_head_only() -> None:
    assert flies("rain cloud")
    assert flies("Schwalben")
    assert not flies("reading light")
    assert not flies("bird house")
    assert not is_soft("chair")
    assert is_soft("Kletterpflanze")


def test_a_tolerance_is_a_number_with_a_reason() -> None:
    width = Tolerance(0.05, "of the breadth", "thinner feet are edges")
    assert 2.0 * width == pytest.approx(0.1)
    assert (width.unit, width.reason) == ("of the breadth", "thinner feet are edges")


def test_checks_of_one_frame_share_its_facts() -> None:
    scene = session.evaluate(Source("a.scene", f'(bind "plim" (lambda () {TABLE}))')).require()
    assert Arrangement(scene).facts is CheckedFrame(scene.root).facts is facts_of(scene.root)
    many = '(bind "a" (lambda () (union-loop 2001 (lambda (i) (transform (call "cube") (translate [(* 2 i) 0 0]))))))'
    large = session.evaluate(Source("a.scene", many)).require().root
    assert facts_of(large) is not facts_of(large), "tables of many megabytes are not kept"

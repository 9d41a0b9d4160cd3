"""What a finding names, and the translation that it proposes: falls, balance, near twins and overlaps on two sides."""

from __future__ import annotations

import pytest

from scenelang.backends.geometry.lint import check_geometry
from scenelang.grammar.datum import Source
from scenelang.session.session import Session

session = Session()
PARTS = """
(bind "floor" (lambda () (transform (call "cube" :scale [8 .1 8]) (translate [0 -.05 0]))))
(bind "table" (lambda () (union
  (transform (call "cube" :scale [1.6 .1 1]) (translate [0 .65 0]))
  (for*/union ((x '(-.7 .7)) (z '(-.4 .4))) (transform (call "cube" :scale [.1 .6 .1]) (translate (vector x .3 z)))))))
(bind "plate" (lambda () (call "cylinder" :radius .12 :p0 [0 0 0] :p1 [0 .02 0])))
(bind "glass" (lambda () (call "cylinder" :radius .04 :p0 [0 0 0] :p1 [0 .12 0])))
(bind "easel" (lambda () (union
  (call "cylinder" :radius .3 :p0 [0 0 0] :p1 [0 .05 0])
  (call "cylinder" :radius .03 :p0 [0 0 0] :p1 [0 2 0])
  (transform (call "cube" :scale [1.2 .8 .05]) (translate [.6 1.6 0])))))
(bind "stool" (lambda () (union
  (transform (call "cube" :scale [.4 .05 .4]) (translate [0 .425 0]))
  (call "cylinder" :radius .15 :p0 [0 0 0] :p1 [0 .4 0]))))
(bind "sheet" (lambda () (call "cube" :scale [.3 .002 .2])))
"""


def found(*parts: str) -> list[tuple[str, str | None]]:
    text = f'{PARTS} (bind "room" (lambda () (union (call "floor") (call "table") {" ".join(parts)}))) (scene "room")'
    return [(d.message, d.hint) for d in check_geometry(session.evaluate(Source("room.scene", text)).require())]


def at(word: str, place: str) -> str:
    return f'(transform (call "{word}") (translate [{place}]))'


def test_what_floats_is_measured_to_what_lies_below() -> None:
    assert found(at("plate", ".2 .7 0"), at("glass", ".4 .78 0")) == [
        (
            '"room/glass" floats: it touches nothing that stands, and is 0.08 from "room/table"',
            "`(translate [0 -0.08 0])` would fix it",
        )
    ]


def test_a_round_thing_falls_until_it_meets_what_is_below() -> None:
    words = '(bind "orange" (lambda () (call "sphere" :radius .1)))'
    text = f"""{PARTS} {words} (bind "room" (lambda () (union (call "floor") (call "table") {at("orange", ".3 .8 0")}
      {at("orange", ".36 1.05 0")})))"""  # 0.0908 above the other one, at an angle
    messages = [d.message for d in check_geometry(session.evaluate(Source("room.scene", text)).require())]
    assert any(message.startswith('"room/orange" floats') for message in messages)


def test_moving_what_is_top_heavy_on_flat_ground_is_not_proposed() -> None:
    ((message, hint),) = found(at("easel", "2 0 2"))
    assert "its center of mass is 0.1" in message
    assert hint is not None
    assert hint.startswith("move its center of mass by `[-0.")


@pytest.mark.parametrize("place", ["2 0 2", "2.008 0 2"])
def test_a_twin_is_one_finding(place: str) -> None:
    assert found(at("stool", "2 0 2"), at("stool", place)) == [('"room/stool" occurs twice in the same place', None)]


def test_layers_are_no_twins() -> None:
    sheets = "".join(at("sheet", f".2 {0.701 + 0.002 * k} 0") for k in range(5))
    assert found(sheets) == []


def test_what_is_pushed_into_from_two_sides_is_not_the_subject() -> None:
    words = '(bind "chest" (lambda () (call "cube" :scale [.6 .5 .5])))'
    text = f"""{PARTS} {words} (bind "sofa" (lambda () (call "cube" :scale [1.6 .5 .7])))
    (bind "room" (lambda () (union (call "floor") {at("sofa", "0 .25 0")}
      {at("chest", ".95 .25 0")} {at("chest", "-.95 .25 0")})))"""
    (finding,) = check_geometry(session.evaluate(Source("room.scene", text)).require())
    assert finding.message == '"room/chest" is 0.15 deep in "room/sofa" (2 times)'


def test_a_knob_beside_its_wall_is_not_dropped_to_the_floor() -> None:
    words = """(bind "wall" (lambda () (transform (call "cube" :scale [4 2.6 .1]) (translate [0 1.3 -3]))))
    (bind "knob" (lambda () (call "sphere" :radius .04)))"""
    text = f'{PARTS} {words} (bind "room" (lambda () (union (call "floor") (call "wall") {at("knob", ".4 1 -2.85")})))'
    (finding,) = check_geometry(session.evaluate(Source("room.scene", text)).require())
    assert finding.message.endswith('is 0.06 from "room/wall"')
    assert finding.hint is None


def test_a_book_that_leans_is_no_outlier() -> None:
    """The fourth of a row of books leans on the third."""
    upright = "".join(at("book", f"{x} 0 0") for x in (-0.46, -0.42, -0.38))
    leaning = '(transform (call "book") (@ (translate [-.31232 0 0]) (rotate .2 [0 0 1]) (translate [.02 0 0])))'
    words = '(bind "book" (lambda () (transform (call "cube" :scale [.04 .24 .17]) (translate [0 .12 0]))))'
    text = f'{PARTS} {words} (bind "room" (lambda () (union (call "floor") {upright} {leaning})))'
    assert [
        d for d in check_geometry(session.evaluate(Source("room.scene", text)).require()) if d.name == "outlier"
    ] == []


def test_an_object_that_floats_as_before_does_not_forbid_a_move() -> None:
    text = """(bind "ball" (lambda ((:r .5)) (call "sphere" :radius r)))
(bind "balls" (lambda () (union (call "cube" :scale [4 .2 4])
  (transform (call "ball") (translate [0 1.5 0])) (transform (call "ball" :r .3) (translate [1.5 1.2 0])))))"""
    scene = session.evaluate(Source("balls.scene", text)).require()
    # the second ball "may fly" only while nothing that stands is as high
    assert [d.hint for d in check_geometry(scene)] == ["`(translate [0 -0.9 0])` would fix it", None]


@pytest.mark.parametrize(
    ("first", "second", "hint"),
    [
        (".3", ".3", "`(translate [0 -0.3 0])` of each would fix it"),
        (".1", ".3", "`(translate [0 -0.3 0])` would fix one of them; the others need moves of their own"),
    ],
)
def test_one_hint_for_equal_objects_holds_for_each(first: str, second: str, hint: str) -> None:
    (diagnostic,) = found(at("stool", f"-3 {first} 0"), at("stool", f"3 {second} 0"))
    assert diagnostic[1] == hint

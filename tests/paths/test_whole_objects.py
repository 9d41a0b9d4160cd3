"""Edits of whole objects: all primitives below the instances of a path, and nothing else."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import scenelang as sl
from scenelang.grammar.datum import Source
from scenelang.repairs.instance_edits import EditedText, InstanceEdit, edited
from scenelang.session.session import Session

ROOM = """; a room
(bind "leg" (lambda () (call "cube" :scale [.1 1 .1] :color [.5 .3 .1])))
(bind "chair" (lambda () (union
  (for*/union ((x '(-.4 .4)) (z '(-.4 .4))) (transform (call "leg") (translate (vector x .5 z))))
  (transform (call "cube" :scale [1 .1 1]) (translate [0 1.05 0])))))
(bind "ball" (lambda ((:color [1 0 0])) (call "sphere" :radius .2 :color color)))
(bind "room" (lambda () (union
  (call "chair")
  (transform (union (transform (call "chair") (translate [3 0 0])) (transform (call "ball") (translate [1.5 .2 0])))
    (rotate 1.5707963267948966 [0 1 0])))))
"""
FILM = """(bind "pair" (lambda () (union (call "cube" :color [1 0 0])
  (transform (call "cone") (translate [0 2 0])))))
(bind "film" (lambda () (frames (for/list ((i 3)) (union (transform (call "pair") (translate [i 0 0])) (call "sphere"))))))
"""


def edit(text: str, path: str, **change: Any) -> EditedText:
    return edited(Session(), Source("room.scene", text), InstanceEdit(path, **change))


def looks(text: str) -> list[tuple[tuple[float, ...], Any]]:
    """The pose and the color of every primitive."""
    return [
        (tuple(np.round(part.pose, 6).ravel().tolist()), part.attributes.get("color"))
        for frame in range(len(sl.evaluate(text).graph.frames))
        for word in ("cube", "sphere", "cone")
        for part in _instances(sl.evaluate(text), word, frame)
    ]


def _instances(scene: sl.Scene, word: str, frame: int) -> list[Any]:
    try:
        return list(scene.instances(word, frame))
    except sl.SceneError:
        return []


@pytest.mark.parametrize(
    ("path", "count"), [("chair", 10), ("chair[0]", 5), ("chair[1]", 5), ("leg", 8), ("ball", 1), ("room", 11)]
)
@pytest.mark.parametrize("color", ["[0 0 1]", '(color "blue")'])
def test_all_primitives_of_an_object_get_a_color(path: str, count: int, color: str) -> None:
    found = edit(ROOM, path, recolor=color)
    before, after = looks(ROOM), looks(found.text)
    assert [pose for pose, _ in before] == [pose for pose, _ in after]
    changed = [new for old, new in zip(before, after, strict=True) if old != new]
    assert len(changed) == count
    assert {tuple(map(float, color)) for _, color in changed} == {(0.0, 0.0, 1.0)}


def test_the_function_that_recolors_is_added_once_and_under_a_free_name() -> None:
    once = edit(ROOM, "chair[0]", recolor="[0 0 1]").text
    assert once.startswith("; a room\n(define (recolored part color)")
    copies = once.replace('(transform (call "ball")', '(call "chair") (transform (call "ball")')
    twice = edit(copies, "chair[2]", recolor="[0 1 0]").text
    assert twice.count("(define (recolored") == 1
    other = edit(f"(define (recolored x) x)\n{ROOM}", "chair[0]", recolor="[0 0 1]").text
    assert '(recolored-2 (call "chair") [0 0 1])' in other


def test_solids_are_recolored_where_their_literals_stand() -> None:
    text = """(bind "block" (lambda () (union
      (difference (call "cube" :color [1 0 0]) (call "sphere" :radius .6 :color [0 1 0]) :color [.2 .2 .2])
      (transform (call "cube" :color [1 1 0]) (translate [3 0 0])))))"""
    new = edit(text, "block", recolor="[0 0 1]").text
    colors = [part.attributes["color"] for word in ("difference", "cube") for part in sl.evaluate(new).instances(word)]
    assert [tuple(map(float, color)) for color in colors] == [(0.0, 0.0, 1.0)] * 2


@pytest.mark.parametrize("path", ["chair[0]", "chair[1]", "ball", "room"])
def test_an_object_is_scaled_about_its_underside(path: str) -> None:
    before = sl.evaluate(ROOM).instances(path)[0].box
    new = sl.evaluate(edit(ROOM, path, scale=(2.0, 3.0, 1.5)).text)
    after = new.instances(path)[0].box
    assert before is not None
    assert after is not None
    assert after[1] - after[0] == pytest.approx((before[1] - before[0]) * [2, 3, 1.5])
    assert after[0][1] == pytest.approx(before[0][1])
    assert (after[0] + after[1])[[0, 2]] == pytest.approx((before[0] + before[1])[[0, 2]])


@pytest.mark.parametrize(("axis", "degrees"), [("y", 30.0), ("y", -90.0), ("x", 180.0), ("z", 45.0), ("y", 720.0)])
@pytest.mark.parametrize("path", ["chair[0]", "chair[1]"])
def test_an_object_is_rotated_about_its_middle(path: str, axis: str, degrees: float) -> None:
    scene = sl.evaluate(ROOM)
    box = scene.instances(path)[0].box
    assert box is not None
    middle = (box[0] + box[1]) / 2
    new = sl.evaluate(edit(ROOM, path, rotate=(axis, degrees)).text)
    x, y, z = np.eye(3)["xyz".index(axis)]
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    turn = np.eye(3) + math.sin(math.radians(degrees)) * cross + (1 - math.cos(math.radians(degrees))) * cross @ cross
    for old, part in zip(scene.instances(f"{path}/leg"), new.instances(f"{path}/leg"), strict=True):
        assert part.pose[:3, 3] == pytest.approx(turn @ (old.pose[:3, 3] - middle) + middle, abs=1e-6)
        assert part.pose[:3, :3] == pytest.approx(turn @ old.pose[:3, :3], abs=1e-6)


def test_every_frame_of_a_film_changes() -> None:
    blue = looks(edit(FILM, "pair", recolor="[0 0 1]").text)
    assert sum(color == [0, 0, 1] for _, color in blue) == 6
    scaled = sl.evaluate(edit(FILM, "pair", scale=(2.0, 2.0, 2.0)).text)
    for frame in range(3):
        box = scaled.instances("pair", frame)[0].box
        assert box is not None
        assert box[0][1] == pytest.approx(-0.5)
        assert (box[0] + box[1])[0] / 2 == pytest.approx(frame)


@pytest.mark.parametrize(
    ("path", "change", "part"),
    [
        ("chair[0]/leg", {"recolor": "[0 0 1]"}, "no form of the program makes only"),
        ("chair[0]/leg", {"scale": (2.0, 2.0, 2.0)}, "no form of the program makes only"),
        ("chair", {"recolor": '"blue sky"'}, ""),
        ("chair", {"recolor": "[1 2"}, "must be one form"),
        ("chair", {"recolor": "wood"}, "unknown col"),
        ("chair", {"scale": (0.0, 1.0, 1.0)}, "`scale`"),
        ("chair", {"scale": (math.inf, 1.0, 1.0)}, "`scale`"),
        ("chair", {"rotate": ("w", 3.0)}, "`rotate`"),
        ("chair", {"rotate": ("y", math.nan)}, "`rotate`"),
        ("chair", {"rotate": ("y", 3.0), "remove": True}, "expected one of"),
        ("stool", {"scale": (2.0, 2.0, 2.0)}, "no part `stool`"),
    ],
)
def test_what_is_refused(path: str, change: dict[str, Any], part: str) -> None:
    with pytest.raises(sl.SceneError) as error:
        edit(ROOM, path, **change)
    assert part in error.value.message


@pytest.mark.parametrize("written", ["steelblue", "#4682b4"])
def test_a_color_may_be_its_name_alone(written: str) -> None:
    changed = edit(ROOM, "chair[0]", recolor=written)
    assert f'(color "{written}")' in changed.text


def test_a_path_to_nothing_names_the_words_there_are() -> None:
    with pytest.raises(sl.SceneError) as error:
        sl.evaluate(ROOM).part("zzz")
    assert error.value.hint is not None
    assert error.value.hint == "its words are ball, chair, cube, leg, room, sphere"


def test_a_flat_instance_has_no_axes() -> None:
    flat = '(bind "a" (lambda () (union (call "sphere") (transform (call "cube") (scale [1 0 1])))))'
    with pytest.raises(sl.SceneError, match="is flat"):
        edit(flat, "cube", rotate=("y", 30.0))


def _poses(text: str, word: str) -> list[Any]:
    """The poses of the primitives of a word, in order."""
    return [part.pose for part in sl.evaluate(text).instances(word)]


@pytest.mark.parametrize("path", ["chair[0]", "chair[1]", "ball"])
def test_a_copy_is_added_beside_an_object(path: str) -> None:
    """The box of the copy is that of the object, moved; all others stay, in turned unions too."""
    before = sl.evaluate(ROOM)
    after = sl.evaluate(edit(ROOM, path, duplicate=(0.5, 1.0, 2.0)).text)
    word = path.partition("[")[0]
    old, new = before.instances(word), after.instances(word)
    assert len(new) == len(old) + 1
    at = int(path.partition("[")[2].rstrip("]") or 0)
    for box, same in zip(
        [each.box for each in old], [each.box for k, each in enumerate(new) if k != at + 1], strict=True
    ):
        assert same == pytest.approx(box)
    assert new[at + 1].box == pytest.approx(old[at].box + np.array([0.5, 1.0, 2.0]))
    others = {"chair": "ball", "ball": "chair"}[word]
    assert [each.box for each in after.instances(others)] == [
        pytest.approx(each.box) for each in before.instances(others)
    ]


def test_a_copy_has_a_line_of_its_own_where_its_object_has_one() -> None:
    text = '(bind "a" (lambda ()\n  (union\n    (transform (call "cube") (translate [1 0 0]))\n    (call "sphere"))))\n'
    line = '    (transform (call "cube") (translate [1 0 0]))\n'
    assert edit(text, "cube", duplicate=(2, 0, 0)).text == text.replace(line, line + line.replace("[1", "[3"))


def test_a_word_is_renamed_everywhere() -> None:
    new = edit(ROOM, "chair[1]", rename="stool").text
    assert new == ROOM.replace('"chair"', '"stool"')
    assert edit(ROOM, "room", rename="hall").text == ROOM.replace('"room"', '"hall"')
    held = ROOM + '(assert-that (count "chair" 2))\n'
    assert edit(held, "chair[0]", rename="stool").text == held.replace('"chair"', '"stool"')


def test_another_word_takes_the_place_of_one_object() -> None:
    new = edit(ROOM, "chair[1]", word="ball").text
    assert new == ROOM.replace('(transform (call "chair")', '(transform (call "ball")')
    assert len(sl.evaluate(new).instances("chair")) == 1


def test_a_translation_in_a_turned_form_changes_its_literal() -> None:
    text = '(bind "a" (lambda () (union (call "cube") (transform (transform (call "cone") (translate [2 0 0])) (rotate (deg 90) [0 0 1])))))'
    assert edit(text, "cone", move=(0, 0.5, 0)).text == text.replace("[2 0 0]", "[2.5 0 0]")


def test_a_solid_is_moved_by_its_own_form() -> None:
    text = (
        '(bind "a" (lambda () (transform (difference (call "cube") (call "sphere" :radius .6)) (translate [2 0 0]))))'
    )
    new = edit(text, "difference", move=(0, 1, 0)).text
    assert new == text.replace("[2 0 0]", "[2 1 0]")
    assert (_poses(new, "difference")[0] - _poses(text, "difference")[0])[:3, 3] == pytest.approx([0, 1, 0])


@pytest.mark.parametrize(
    ("path", "change", "part"),
    [
        ("room", {"duplicate": (1.0, 0.0, 0.0)}, "no form of the program makes only"),
        ("chair[0]", {"duplicate": (1.0, 0.0)}, "`duplicate`"),
        ("chair[0]", {"duplicate": (1.0, math.nan, 0.0)}, "`duplicate`"),
        ("chair[0]", {"rename": "leg"}, "already"),
        ("chair[0]", {"rename": "cube"}, "already"),
        ("sphere", {"rename": "ball 2"}, "not bound"),
        ("chair[0]", {"rename": 'a"b'}, "expected a word"),
        ("chair[0]", {"word": "a\nb"}, "expected a word"),
        ("chair[0]", {"word": " "}, "expected a word"),
    ],
)
def test_a_copy_or_another_word_is_refused(path: str, change: dict[str, Any], part: str) -> None:
    with pytest.raises(sl.SceneError, match=part):
        edit(ROOM, path, **change)


BALLS = """(define-syntax ball (syntax-rules () ((_ x r c) (transform (call "sphere" :radius r :color c) (translate [x 0 0])))))
(define-syntax box (syntax-rules () ((_ x size turn) (transform (transform (call "cube" :scale size) (rotate (deg turn) [0 1 0])) (translate [x .5 0])))))
(define (post x height) (transform (call "cylinder" :radius .1 :p1 [0 height 0] :color (color "tan")) (translate [x 0 0])))
(bind "a" (lambda () (union
  (ball 2 .5 (color "red")) (ball 4 .5 (color "red")) (box 6 [1 1 2] 30) (box 9 [1 1 2] 30) (post 12 1) (post 14 1))))
"""


@pytest.mark.parametrize(
    ("path", "change", "old", "new"),
    [
        ("sphere[0]", {"scale": (1.5, 1.5, 1.5)}, "(ball 2 .5 ", "(ball 2 .75 "),
        ("sphere[1]", {"recolor": '(color "blue")'}, '(ball 4 .5 (color "red"))', '(ball 4 .5 (color "blue"))'),
        ("cube[0]", {"scale": (1.0, 1.5, 1.0)}, "(box 6 [1 1 2] 30)", "(box 6 [1 1.5 2] 30)"),
        ("cube[1]", {"rotate": ("y", 15.0)}, "(box 9 [1 1 2] 30)", "(box 9 [1 1 2] 45)"),
        ("cube[1]", {"move": (0.0, 0.0, 0.0625)}, "(box 9 [1 1 2] 30)", "(transform (box 9 [1 1 2] 30) (translate [0 0 0.0625]))"),
        ("cylinder[1]", {"scale": (1.0, 2.0, 1.0)}, "(post 14 1)", "(post 14 2)"),
    ],
)  # fmt: skip
def test_an_argument_of_a_macro_or_function_is_edited_in_place(
    path: str, change: dict[str, Any], old: str, new: str
) -> None:
    assert edit(BALLS, path, **change).text == BALLS.replace(old, new)


def test_sizes_and_the_height_above_the_ground_are_edited_together() -> None:
    text = '(bind "a" (lambda () (union (call "sphere") (transform (call "cube" :scale [1 2 3]) (translate [4 1 0])))))'
    scaled = edit(text, "cube", scale=(2.0, 2.0, 2.0)).text
    assert scaled == text.replace("[1 2 3]", "[2 4 6]").replace("[4 1 0]", "[4 2 0]")


def test_a_size_that_others_share_is_not_edited() -> None:
    text = '(define r .5)\n(bind "a" (lambda () (union (call "sphere" :radius r) (transform (call "sphere" :radius r) (translate [3 0 0])))))'
    scaled = edit(text, "sphere[1]", scale=(2.0, 2.0, 2.0)).text
    assert "(define r .5)" in scaled
    assert [np.round(part.box, 6).tolist() for part in sl.evaluate(scaled).instances("sphere")] == [
        [[-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]],
        [[2.0, -0.5, -1.0], [4.0, 1.5, 1.0]],
    ]


@pytest.mark.parametrize(
    ("program", "change", "new"),
    [
        # a number that has a small effect gets long before it is exact
        ('(define (at u) (translate [(* .003 u) 0 0]))\n(bind "a" (lambda () (union (call "cube") (transform (call "sphere") (at 700)))))', {"move": (0.37, 0.0, 0.0)}, "(at 823.3)"),
        # parts of a move along the axes of a turned form
        ('(bind "a" (lambda () (union (call "cube") (transform (transform (call "sphere") (translate [2 0 0])) (rotate (deg 30) [0 1 0])))))', {"move": (0.5, 0.0, 0.0)}, "[2.433 0 0.25]"),
        ('(bind "a" (lambda () (union (call "cube") (transform (call "sphere") (translate [.1234567 0 0])))))', {"move": (0.5, 0.0, 0.0)}, "[.623 0 0]"),
        ('(bind "a" (lambda () (union (call "cube") (transform (call "sphere") (translate [.1234567 0 0])))))', {"move": (0.0, 0.5, 0.0)}, "[.1234567 .5 0]"),
    ],
)  # fmt: skip
def test_numbers_are_as_short_as_the_precision_allows(program: str, change: dict[str, Any], new: str) -> None:
    exact = edit(program, "sphere", **change).text
    short = edit(program, "sphere", precision=0.001, **change).text
    assert new in short
    moved = [sl.evaluate(text).instances("sphere")[0].pose[:3, 3] for text in (exact, short)]
    assert moved[1] == pytest.approx(moved[0], abs=1.5e-3)


@pytest.mark.parametrize("precision", [-1.0, math.inf, math.nan, "1"])
def test_a_wrong_precision_is_refused(precision: Any) -> None:
    with pytest.raises(sl.SceneError, match="`precision`"):
        edit(ROOM, "ball", move=(1.0, 0.0, 0.0), precision=precision)

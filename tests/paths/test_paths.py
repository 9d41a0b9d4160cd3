"""Paths to instances: what they mean, everywhere where a word is accepted, and edits of the program at them."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

import scenelang as sl
from scenelang.cli.main import main
from scenelang.interpreter.inspection.instance_paths import escaped, read_path

ROOM = """
(bind "leg" (lambda () (call "cube" :scale [.1 1 .1])))
(bind "chair" (lambda () (union
  (for*/union ((x '(-.4 .4)) (z '(-.4 .4))) (transform (call "leg") (translate (vector x .5 z))))
  (transform (call "cube" :scale [1 .1 1]) (translate [0 1.05 0])))))
(bind "a/b [1]" (lambda () (call "sphere" :radius .2)))
(bind "room" (lambda () (union
  (call "chair")
  (transform (union (transform (call "chair") (translate [3 0 0])) (transform (call "a/b [1]") (translate [1.5 .2 0])))
    (rotate 1.5707963267948966 [0 1 0])))))
"""
TREE = '(bind "t" (lambda ((:n 2)) (if (= n 0) (call "cube") (union (call "t" :n (- n 1)) (call "sphere")))))'


@pytest.fixture(scope="module")
def room() -> sl.Scene:
    return sl.evaluate(ROOM)


@pytest.mark.parametrize(
    ("path", "found"),
    [
        ("chair", ["chair[0]", "chair[1]"]),
        ("chair/leg[2]", ["chair[0]/leg[2]", "chair[1]/leg[2]"]),
        ("chair[1]/leg[3]", ["chair[1]/leg[3]"]),
        ("leg[7]", ["chair[1]/leg[3]"]),
        ("room/chair[0]", ["chair[0]"]),
        ("room", ["room"]),
        ("<z3>", ["chair[0]/leg[0]"]),
        ("chair[1]/<z3>", []),
        ("*", ["chair[0]", "chair[1]", r"a\/b \[1\]"]),
        ("*[1]/*[4]", ["chair[1]/cube[4]"]),
        (r"a\/b \[1\]", [r"a\/b \[1\]"]),
        ("a/b [1]", [r"a\/b \[1\]"]),
    ],
)
def test_what_a_path_means(room: sl.Scene, path: str, found: list[str]) -> None:
    if not found:
        with pytest.raises(sl.SceneError, match="no part"):
            room.instances(path)
        return
    assert [each.path for each in room.instances(path)] == found


def test_every_instance_has_a_path_of_its_own(room: sl.Scene) -> None:
    for scene in (room, sl.evaluate(TREE)):
        every = [each for path in ("*", "*/*", "*/*/*") for each in _found(scene, path)]
        assert len({each.path for each in every}) == len(every)
        for each in every:
            (again,) = scene.instances(each.path)
            assert again.handle == each.handle
            assert (again.pose == each.pose).all()


def _found(scene: sl.Scene, path: str) -> list[object]:
    try:
        return list(scene.instances(path))
    except sl.SceneError:
        return []


@pytest.mark.parametrize(
    ("path", "part"),
    [
        ("chair[2]", "there are 2 `chair`"), ("chair[0]/cube[5]", "there are 5 `cube`"), ("chiar", "did you mean `chair`?"),
        ("", "a step is empty"), ("a//b", "a step is empty"), ("chair[", "expected a number"), ("chair[-1]", "expected a n"),
        ("chair[1]x", "expected a number"), ("chair]", "`]` has no `[`"), ("x\\", "escapes nothing"), ("x" * 3000, "at most"),
        ("chair[99999999999]", "expected a number"),
    ],
)  # fmt: skip
def test_a_wrong_path_is_explained(room: sl.Scene, path: str, part: str) -> None:
    with pytest.raises(sl.SceneError) as error:
        room.instances(path)
    assert part in str(error.value)
    assert "E409" in str(error.value)


@pytest.mark.parametrize("word", ["leg", "a/b", "[", "\\", "*", "<z1>", "]x[", "ü/[3]\\"])
def test_an_escaped_word_is_one_step(word: str) -> None:
    (step,) = read_path(escaped(word))
    assert (step.name, step.kind, step.index) == (word, "word", None)


def test_a_path_is_accepted_where_a_word_is(room: sl.Scene, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    box = room.bounds_of("chair[0]/leg[0]")
    assert box is not None
    assert box.ravel() == pytest.approx([-0.45, 0, -0.45, -0.35, 1, -0.35])
    assert room.measure("chair[1]/leg[0]").volume == pytest.approx(0.01)
    assert room.violations('(distance "chair[0]" "chair[1]" 2)', '(on "chair[0]/cube[4]" "chair[0]/leg" :any)') == []
    assert len(room.violations('(distance "chair[0]/leg[0]" "chair[0]/leg[1]" 5)')) == 1
    assert room.part("chair[1]/leg").count()["leg"] == 4
    file = tmp_path / "room.scene"
    file.write_text(ROOM)
    for command in ("bounds", "measure"):
        assert main([command, str(file), "--word", "chair[0]/leg[0]", "--json"]) == 0
        assert '"volume"' in (said := capsys.readouterr().out) or '"min"' in said
        assert main([command, str(file), "--word", "chair[7]"]) == 1
        assert "there are 2 `chair`" in capsys.readouterr().err
    assert (
        main(["render", str(file), "--part", "chair[1]/leg[0]", "--size", "32x32", "-o", str(tmp_path / "a.png")]) == 0
    )
    assert main(["check", str(file), "--that", '(distance "chair[0]" "chair[1]" 2)']) == 0


def test_paths_in_a_film() -> None:
    film = sl.evaluate('(bind "a" (lambda () (frames (for/list ((i 3)) (union (call "cube") (call "cone" "c"))))))')
    assert [each.path for each in film.instances("cone", 2)] == ["cone"]
    assert film.instances("<z2>", 1)[0].word == "cube"
    assert film.part("cone").count(2)["cone"] >= 1


# --- edits -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("path", "edit", "new"),
    [
        ("chair[0]", {"move": (0, 0, -1)}, '(transform (call "chair") (translate [0 0 -1]))'),
        ("sphere", {"move": (0, 1, 0)}, '(transform (call "sphere" :radius .2) (translate [0 1 0]))'),
        (r"a\/b \[1\]", {"move": (0, 1, 0)}, '(transform (call "a/b [1]") (translate [1.5 1.2 0]))'),
        ("chair/cube[4]", {"attribute": ("color", "[1 0 0]")}, '(call "cube" :scale [1 .1 1] :color [1 0 0])'),
        ("leg/cube", {"attribute": ("scale", ".2")}, '(call "cube" :scale .2)'),
        (r"a\/b \[1\]", {"form": '(call "cone")'}, '(call "cone")'),
        (r"a\/b \[1\]", {"remove": True}, ""),
        ("chair[0]/leg[0]", {"remove": True}, '(part-changed (call "chair") \'(0) (lambda (part) (union)))'),
        ("room", {"move": (1, 0, 0)}, "(translate [1 0 0]))"),
    ],
)
def test_an_edit_changes_these_instances_only(path: str, edit: dict[str, object], new: str) -> None:
    found = sl.edit_instance(ROOM, path, **edit)  # type: ignore[arg-type]
    assert found.new.endswith(new)
    before, after = sl.evaluate(ROOM), sl.evaluate(found.text)
    others = len(before.flatten()) - len(before.part(path).flatten())
    changes = before.diff(after)
    assert changes.matched == others
    assert not changes.equal


def test_a_move_is_along_the_axes_of_the_scene() -> None:
    found = sl.edit_instance(ROOM, "chair[1]", move=(0, 0, 1))
    before, after = (sl.evaluate(text).bounds_of("chair[1]") for text in (ROOM, found.text))
    assert before is not None
    assert after is not None
    assert (after - before).ravel() == pytest.approx([0, 0, 1, 0, 0, 1])


@pytest.mark.parametrize(
    ("path", "edit", "part"),
    [
        ("chair/leg[2]", {"move": (0, 0, 1)}, "turned differently"),
        ("chair/leg", {"move": (0, 0, 1)}, "turned differently"),
        ("chair", {"attribute": ("color", "[1 0 0]")}, "nothing that is seen depends on it"),
        ("chair[0]", {"form": "(call"}, "must be one form"),
        ("chair[0]", {"attribute": ("a b", "1")}, "no name of an attribute"),
        ("chair[0]", {"attribute": ("color", "1 2")}, "must be one form"),
        ("chair[0]", {"move": (0, math.inf, 0)}, "finite"),
        ("chair[0]", {"move": (0, 1)}, "three numbers"),
        ("chair[0]", {}, "expected one of"),
        ("stool", {"remove": True}, "no part `stool`"),
    ],
)  # fmt: skip
def test_an_edit_that_would_change_more_is_refused(path: str, edit: dict[str, object], part: str) -> None:
    with pytest.raises(sl.SceneError) as error:
        sl.edit_instance(ROOM, path, **edit)  # type: ignore[arg-type]
    assert part in str(error.value)


def test_an_edit_changes_all_frames_of_a_film_and_draws_the_same_numbers() -> None:
    film = """
(bind "ball" (lambda () (call "sphere" :radius (uniform .1 .2))))
(bind "film" (lambda () (frames (for/list ((i 3))
  (union (transform (call "ball") (translate (vector i 0 0))) (transform (call "cube") (translate [0 5 0])))))))
"""
    found = sl.edit_instance(film, "cube", move=(0, 1, 0))
    assert found.new == '(transform (call "cube") (translate [0 6 0]))'
    changes = sl.evaluate(film).diff(sl.evaluate(found.text))
    assert (changes.counts, changes.matched) == ({"moved": 3}, 3)
    drawn = '(bind "dot" (lambda () (call "cube" :scale (uniform 1 2))))'
    pair = f'{drawn} (bind "two" (lambda () (union (call "cone" :scale (uniform 1 2)) (transform (call "dot") (translate [4 0 0])))))'
    found = sl.edit_instance(pair, "cone", form='(call "torus")')
    assert found.new.startswith("(part-changed (union")  # without the cone's call, the dot would draw another number
    assert (sl.evaluate(found.text).bounds_of("dot") == sl.evaluate(pair).bounds_of("dot")).all()  # type: ignore[union-attr]


def test_many_instances_are_found_quickly() -> None:
    many = sl.evaluate(
        '(bind "a" (lambda () (union-loop 5000 (lambda (i) (transform (call "cube") (translate [i 0 0]))))))'
    )
    assert many.instances("*")[-1].path == "cube[4999]"
    assert many.instances("cube[4321]")[0].pose[0, 3] == 4321


# --- search ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("query", "name"),
    [
        ("copies in a circle", "ring"), ("repeat along a curve", "along"), ("mirror a wing", "mirror"),
        ("cut a hole in a plate", "difference"), ("make glass transparent", ":opacity"), ("random seed", "set-seed!"),
        ("vase as a surface of revolution", "lathe"), ("name is not defined", "unbound"), ("translate", "translate"),
        ("animation over time", "frames"), ("round the edges of a box", "rounded"), ("spiral staircase", "spiral-staircase"),
        ("things that must not collide", "clear-of"), ("shiny metal", ":metallic"), ("tower of blocks", "jenga"),
        (":color", ":color"),
    ],
)  # fmt: skip
def test_search_by_meaning(query: str, name: str) -> None:
    assert name in [found.name for found in sl.search(query, 6)]


def test_a_name_itself_comes_first_and_nothing_is_found_for_nothing() -> None:
    assert sl.search("ring")[0].name == "ring"
    assert sl.search("chairs in a circle")[0].name == "ring"
    assert sl.search("a circle")[0].name == "circle"
    assert sl.search("") == sl.search("qqxyzzy") == []
    with pytest.raises(sl.SceneError, match="at most 500"):
        sl.search("x" * 501)


def test_search_on_the_command_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["search", "copies", "in", "a", "circle", "--limit", "4"]) == 0
    assert "(ring count" in capsys.readouterr().out
    assert main(["search", "qqxyzzy", "--json"]) == 0
    assert capsys.readouterr().out.strip() == "[]"

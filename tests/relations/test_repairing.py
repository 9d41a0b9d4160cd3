"""Repair of programs: what is found is resolved by small edits, and sound programs stay as they are."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from scenelang.cli.main import main
from scenelang.grammar.datum import Source
from scenelang.grammar.reader import read
from scenelang.repairs.repairing import Repair, repaired
from scenelang.repairs.slips import patterns_of
from scenelang.session.declarations import declarations_of
from scenelang.session.session import Session

ROOM = """
(bind "table"
  (lambda ()
    (union
      (transform (call "cube" :scale [2 .1 1]) (translate [0 .95 0]))
      (for*/union ((x '(-.9 .9)) (z '(-.4 .4)))
        (transform (call "cube" :scale [.1 .9 .1]) (translate (vector x .45 z)))))))
(bind "cup" (lambda () (call "cylinder" :radius .1 :p0 [0 0 0] :p1 [0 .2 0])))
(bind "chair"
  (lambda ()
    (union
      (transform (call "cube" :scale [.5 .5 .5]) (translate [0 .25 0]))
      (transform (call "cube" :scale [.5 .5 .1]) (translate [0 .75 -.2])))))
(bind "room" (lambda () (union THINGS)))
(scene "room")
"""
TABLE = '(call "table")'


def repair(things: str, *stated: str, geometry: bool = False, effort: float = 60.0) -> Repair:
    session = Session()
    extra = [each for text in stated for each in declarations_of(session, text)]
    source = Source("room.scene", ROOM.replace("THINGS", things))
    return repaired(session, source, extra, geometry=geometry, effort=effort)


FAULTS = [
    # what is repaired, the declaration, and what the program has afterwards
    (TABLE + '(transform (call "cup") (translate [.3 1.5 0]))', '(on "cup" "table")', "(translate [.3 1 0])"),
    (TABLE + '(transform (call "cup") (translate [.3 .8 0]))', '(on "cup" "table")', "(translate [.3 1 0])"),
    (TABLE + '(call "cup")', '(on "cup" "table")', '(transform (call "cup") (translate [0 1 0]))'),
    (TABLE + '(transform (call "chair") (translate [0 0 -2]))', '(distance "chair" "table" .5)', "-1.05]"),
    (TABLE + '(transform (call "chair") (translate [0 0 1.5]))', '(facing "chair" "table")', "(rotate 3.14 [0 1 0])"),
    (
        '(for/union ((i 3)) (transform (call "chair") (translate (vector (* .4 i) 0 0))))',
        '(clear-of "chair" "chair")',
        "(* .5 i)",
    ),
    ('(for/union ((i 3)) (transform (call "chair") (translate (vector i 0 0))))', '(count "chair" 5)', "((i 5))"),
    (  # the number of a loop, rather than what decides whether there is another
        '(if (> 1 0) (call "chair") (union)) (for/union ((i 4)) (transform (call "chair") (translate (vector 0 0 i))))',
        '(count "chair" 4)',
        "((i 3))",
    ),
    (TABLE, '(size "table" 1.2 :axis "y")', ""),
    (
        '(for/union ((x \'(-1 0 1.3))) (transform (call "chair") (translate (vector x 0 0))))',
        '(evenly-spaced "chair" :along "x")',
        "",
    ),
    (
        '(for/union ((x \'(-1 0 1))) (transform (call "chair") (translate (vector x 0 (if (= x 0) .2 0)))))',
        '(aligned "chair" :along "x")',
        "(if (= x 0) 0 0)",
    ),
]


@pytest.mark.parametrize(("things", "stated", "text"), FAULTS)
@pytest.mark.sampled(5)
def test_a_declaration_is_made_to_hold(things: str, stated: str, text: str) -> None:
    found = repair(things, stated)
    assert len(found.before) > 0
    assert found.left == ()
    assert text in found.text
    assert repair(things, stated).text == found.text  # the search is deterministic
    session = Session()
    scene = session.evaluate(Source("room.scene", found.text)).require()
    from scenelang.backends.geometry.relations import violations

    assert violations(scene, declarations_of(session, stated)) == []


def test_one_literal_moves_all_instances() -> None:
    row = '(for/union ((x \'(-.6 -.2 .2 .6))) (transform (call "cup") (translate (vector x 1.3 0))))'
    found = repair(TABLE + row, '(on "cup" "table")')
    assert [(edit.old, edit.new) for edit in found.edits] == [("1.3", "1")]
    assert found.displacement == pytest.approx(4 * 0.3 / 9, rel=1e-3)  # of nine primitives


def test_findings_of_the_lint_are_resolved() -> None:
    found = repair(TABLE + '(transform (call "cup") (translate [.3 1.3 0]))', geometry=True)
    assert found.left == ()
    assert "(translate [.3 1 0])" in found.text


def test_a_part_that_is_there_twice_is_removed() -> None:
    cup = '(transform (call "cup") (translate [.3 1 0]))'
    found = repair(TABLE + cup + cup, geometry=True)
    assert found.left == ()
    assert found.text.count('(call "cup")') == 1


def test_sound_programs_stay() -> None:
    found = repair(TABLE + '(transform (call "cup") (translate [.3 1 0]))', '(on "cup" "table")', geometry=True)
    assert not found.changed
    assert found.before == found.left == ()
    assert found.diff() == ""


def test_what_cannot_be_repaired_is_told() -> None:
    both = ('(on "cup" "table")', '(not (on "cup" "table"))')
    found = repair(TABLE + '(transform (call "cup") (translate [.3 1.5 0]))', *both, effort=1.5)
    assert found.left
    assert not found.changed  # nothing gets better by breaking the other


FLOOR = '(transform (call "cube" :scale [8 .2 8]) (translate [0 -.1 0]))'
WALL = '(transform (call "cube" :scale [8 3 .2]) (translate [0 1.5 -4]))'
CABINET = """
(bind "cabinet" (lambda () (union
  (transform (call "cube" :scale [1 2 .6]) (translate [0 1 0]))
  (for/union ((x '(-.25 .25))) (transform (call "cube" :scale [.48 1.9 .02]) (translate (vector x 1 .305)))))))
"""
SIGN = """
(bind "easel" (lambda () (union
  (call "cylinder" :radius .3 :p0 [0 0 0] :p1 [0 .05 0])
  (call "cylinder" :radius .03 :p0 [0 0 0] :p1 [0 2 0])
  (transform (call "cube" :scale [1.2 .8 .05]) (translate [.6 1.6 0])))))
"""
CART = """
(bind "cart" (lambda () (union
  (transform (call "cube" :scale [1 .4 .8]) (translate [0 .5 0]))
  (for*/union ((x '(-.4 .4)) (z '(-.4 .4)))
    (transform (call "cylinder" :radius .2 :p0 [0 0 -.05] :p1 [0 0 .05]) (translate (vector x .2 z)))))))
"""
RACK = """
(bind "rack" (lambda () (union
  (for/union ((x '(-.55 .55))) (transform (call "cube" :scale [.1 2 .4]) (translate (vector x 1 0))))
  (for/union ((k (iota 4))) (transform (call "cube" :scale [1 .04 .4]) (translate (vector 0 (+ .1 (* k .5)) 0)))))))
"""
SOFA = """
(bind "sofa" (lambda () (union
  (transform (call "cube" :scale [1.6 .4 .7]) (translate [0 .2 0]))
  (transform (call "cube" :scale [1.6 .5 .2]) (translate [0 .6 -.25])))))
"""
BOX = """
(bind "box" (lambda () (transform (call "cube" :scale [.8 .4 .6]) (translate [0 .2 0]))))
"""
MUG = """
(bind "mug" (lambda () (union
  (call "cylinder" :radius .05 :p1 [0 .1 0])
  (transform (call "torus" :radius .03 :tube .006) (@ (translate [.07 .05 .07]) (rotate (/ tau 4) [1 0 0]))))))
"""
JAR = """
(bind "jar" (lambda () (lathe '([0 0] [.07 0] [.07 .2] [.065 .2] [.065 .005] [0 .005]))))
"""
LAMP = """
(bind "ceiling" (lambda () (transform (call "cube" :scale [8 .2 8]) (translate [0 3.1 0]))))
(bind "lamp" (lambda () (union
  (call "cylinder" :radius .006 :p0 [0 2 0] :p1 [0 2.7 0]) (call "cone" :radius .2 :p0 [0 1.8 0] :p1 [0 2 0]))))
"""
CUP = '(transform (call "cup") (translate [X 1 0]))'
PLACES = [
    # words, what is in the room, and the edits: what a person would change
    (CABINET, WALL + '(transform (call "cabinet") (translate [0 0 -3.8]))', [("-3.8", "-3.6")]),  # all of it
    (CART, TABLE + '(transform (call "cart") (translate [0 .15 3]))', [(".15", "0")]),  # with its wheels
    (SIGN, '(call "easel")', [(".6", None)]),  # not without the pose
    ("", TABLE + CUP.replace("X", "1.02"), [("1.02", None)]),  # it stands with room
    ("", TABLE + WALL + CUP.replace("X", ".3").replace("1 0]", ".998 0]"), []),  # a little deep is no finding
    (SOFA, '(call "sofa")' + "".join(f'(transform (call "chair") (translate [{x} 0 .1]))' for x in ("-.9", ".9")),
     [("-.9", "-1.05"), (".9", "1.05")]),  # one from each side of it
    (SOFA, '(call "sofa")(transform (call "chair") (translate [.9 0 .1]))', [(".9", "1.05")]),  # not its seat alone
    (BOX, "(for/union ((x '(-.9 0 .3 1.8))) (transform (call \"box\") (translate [x 0 2])))", [(".3", ".9")]),
    (BOX, "(for/union ((x '(-.9 .2))) (transform (call \"box\") (translate [(* .6 x) 0 2])))", [(".2", ".9")]),
    (MUG, TABLE + '(transform (call "mug") (translate [.3 1 0]))', [(".07", "0")]),  # the handle, in its middle plane
    (JAR, TABLE + '(transform (call "jar") (translate [.3 .92 0]))', [(".92", "1")]),  # by its whole height
    (LAMP, '(call "ceiling" :fixed #t)(transform (call "lamp") (translate [0 0 0]))', [("0", ".3")]),  # it hangs
    ("", TABLE + '(transform (call "cup") (translate [1.3 1 .1]))', [("1.3", ".9")]),  # onto the table that it missed
    (RACK, '(call "rack")(for*/union ((k (iota 3)) (i (iota 4))) (transform (call "cup") (translate (vector (- (* i .22) '
     ".33) (+ .12 (* k .55)) 0))))", [(".55", ".5")]),  # once for the loop
]  # fmt: skip


@pytest.mark.parametrize(("words", "things", "edits"), PLACES)
@pytest.mark.sampled(3)
def test_edits_are_those_that_a_person_would_make(words: str, things: str, edits: list[tuple[str, str | None]]) -> None:
    text = words + ROOM.replace("THINGS", FLOOR + things)
    found = repaired(Session(), Source("room.scene", text), effort=60.0)
    assert found.left == ()
    assert [edit.old for edit in found.edits] == [old for old, _ in edits]
    for edit, (_, new) in zip(found.edits, edits, strict=True):
        assert new is None or float(edit.new) == pytest.approx(float(new), abs=1e-3)


def test_what_is_top_heavy_moves_only_its_weight() -> None:
    found = repaired(Session(), Source("room.scene", SIGN + ROOM.replace("THINGS", FLOOR + '(call "easel")')))
    (edit,) = found.edits
    assert 0.1 < float(edit.new) < 0.42


def test_what_is_at_an_edge_stands_with_room() -> None:
    (edit,) = repair(FLOOR + TABLE + CUP.replace("X", "1.02"), geometry=True).edits
    assert 0.9 < float(edit.new) < 0.99  # its middle is over the table, which ends at 1


def test_an_almost_equal_thing_is_a_twin() -> None:
    chairs = '(transform (call "chair") (translate [1 0 2])) (transform (call "chair") (translate [1.002 0 2]))'
    found = repair(FLOOR + TABLE + chairs, geometry=True)
    assert found.before == ('"room/chair" occurs twice in the same place',)
    assert found.left == ()
    assert found.text.count('(call "chair")') == 1
    assert "(translate [1 0 2])))" in found.text  # the first one stays, and no blank


def test_a_painting_reaches_its_wall() -> None:
    painting = '(bind "painting" (lambda () (call "cube" :scale [.8 .6 .03])))'
    text = painting + ROOM.replace("THINGS", FLOOR + WALL + '(transform (call "painting") (translate [1 1.5 -3.7]))')
    (edit,) = repaired(Session(), Source("room.scene", text)).edits
    assert float(edit.new) == pytest.approx(-3.885)


@pytest.mark.slow
def test_a_tilted_thing_is_turned_and_put_down() -> None:
    chair = '(transform (call "chair") (@ (translate [0 .15 2]) (rotate .2 [1 0 0])))'
    found = repair(FLOOR + TABLE + chair, geometry=True)
    assert found.left == ()
    assert "(@ (translate [0 0 2]) (rotate 0 [1 0 0]))" in found.text


@pytest.mark.slow
def test_facing_changes_the_angle_that_is_there() -> None:
    chair = '(transform (call "chair") (@ (translate [0 0 1.5]) (rotate .5 [0 1 0])))'
    found = repair(TABLE + chair, '(facing "chair" "table")')
    assert [(edit.old, edit.new) for edit in found.edits] == [(".5", "3.14")]


def test_a_diff_can_be_applied_without_a_last_line_feed() -> None:
    found = Repair("(a)\n(b)", "(a)\n(c)", (), (), (), 0.0)
    assert found.diff("x").splitlines()[3:] == [
        " (a)", "-(b)", "\\ No newline at end of file", "+(c)", "\\ No newline at end of file",
    ]  # fmt: skip


def test_outputs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    program, link, other = tmp_path / "room.scene", tmp_path / "link.scene", tmp_path / "other.scene"
    text = ROOM.replace("THINGS", TABLE + '(transform (call "cup") (translate [.3 1.3 0]))')
    program.write_text(text)
    program.chmod(0o755)
    link.symlink_to(program)
    assert main(["repair", str(link), "-o", str(link)]) == 0
    assert link.is_symlink()
    assert program.read_text() != text
    assert program.stat().st_mode & 0o777 == 0o755
    capsys.readouterr()
    assert main(["repair", str(program), "-o", str(link)]) == 0
    assert "wrote" not in capsys.readouterr().err  # nothing has changed
    assert main(["repair", str(program), "-o", str(tmp_path / "room.json")]) == 2
    assert not (tmp_path / "room.json").exists()
    other.write_text(text)
    other.chmod(0o444)
    assert main(["repair", str(other), "-o", str(other)]) == 1
    assert "read-only" in capsys.readouterr().err
    assert other.read_text() == text


def test_what_imported_files_make_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "lib.scene").write_text(
        '(bind "stool" (lambda () (union (transform (call "cube" :scale [.4 .05 .4]) (translate [0 .5 0]))'
        ' (call "cylinder" :radius .15 :p0 [0 0 0] :p1 [0 .4 0]))))'
    )
    program = tmp_path / "room.scene"
    program.write_text('(import "lib.scene")\n(bind "room" (lambda () (union (call "stool"))))\n(scene "room")\n')
    assert main(["repair", str(program)]) == 1
    told = capsys.readouterr()
    assert told.out == ""
    assert 'not repaired: "room/stool" floats' in told.err
    assert "imported files" in told.err


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    program = tmp_path / "room.scene"
    text = ROOM.replace("THINGS", TABLE + '(transform (call "cup") (translate [.3 1.5 0]))')
    program.write_text(text)
    asked = ["repair", str(program), "--that", '(on "cup" "table")', "--only-declarations"]
    assert main(asked) == 0
    told = capsys.readouterr()
    assert "(translate [.3 1 0])" in told.out
    assert "1 edit;" in told.out
    assert program.read_text() == text
    assert main([*asked, "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["ok"]
    assert [edit["new"] for edit in data["edits"]] == ["1"]
    assert main([*asked, "-o", str(program)]) == 0
    assert "(translate [.3 1 0])" in program.read_text()
    assert main(asked) == 0
    assert "nothing to repair" in capsys.readouterr().out
    answer = tmp_path / "answer.py"
    answer.write_text("@register()\ndef room():\n    return primitive_call('cube')\n")
    assert main(["repair", str(answer)]) == 2


def test_every_frame_of_a_film_is_repaired() -> None:
    program = """(bind "ball" (lambda () (call "sphere" :radius .2)))
(bind "board" (lambda () (call "cube" :scale [4 .2 1])))
(bind "film" (lambda (z gamma)
  (frames (for/list ((i 5))
    (union (call "board") (transform (call "ball") (translate (vector (* i .05) (if (= i 3) .5 .3) 0))))))))
(scene "film")"""
    session = Session()
    stated = declarations_of(session, '(on "ball" "board")')
    found = repaired(session, Source("film.scene", program), stated, geometry=False)
    assert len(found.before) == 1
    assert found.left == ()
    assert "(if (= i 3) .3 .3)" in found.text


def test_what_moves_in_few_frames_of_a_film_stays() -> None:
    program = """(bind "b" (lambda () (transform (call "cube") (translate [0 .5 0]))))
(bind "floor" (lambda () (transform (call "cube" :scale [6 .1 6]) (translate [0 -.05 0]))))
(bind "film" (lambda () (frames (for/list ((i 6))
  (union (call "floor") (transform (call "b") (translate (vector 0 (if (> i 3) .6 0) 0))))))))
(scene "film")"""
    result = repaired(Session(), Source("film.scene", program), (), geometry=True)
    assert (result.text, result.left) == (program, ())


TEA = """
(define (at e x y z) (transform e (translate [x y z])))
(bind "board" (lambda () (at (call "cube" :scale [1.6 .1 1]) 0 .05 0)))
(bind "tray" (lambda () (at (call "cube" :scale [.6 .03 .4]) 0 .015 0)))
(bind "pot" (lambda () (union (call "cylinder" :radius .08 :p0 [0 0 0] :p1 [0 .2 0]) (at (call "sphere" :radius .03) 0 .21 0))))
(bind "cup" (lambda () (lathe [[0 0] [.04 0] [.04 .09] [.035 .09] [.035 .01] [0 .01]])))
(bind "tea" (lambda () (union (call "board") PARTS)))
(scene "tea")
"""


def test_a_pot_that_is_sunk_through_its_tray_stands_on_it() -> None:
    text = TEA.replace("PARTS", '(at (call "tray") 0 .1 0) (at (call "pot") 0 .095 0)')
    assert '(at (call "pot") 0 .13 0)' in repaired(Session(), Source("tea.scene", text), (), geometry=True).text


def test_a_pot_is_not_torn_to_make_room() -> None:
    text = TEA.replace("PARTS", '(at (call "pot") 0 .1 0) (at (call "cup") .09 .1 0)')
    result = repaired(Session(), Source("tea.scene", text), (), geometry=True)
    assert (
        '(call "cylinder" :radius .08 :p0 [0 0 0] :p1 [0 .2 0]) (at (call "sphere" :radius .03) 0 .21 0)' in result.text
    )


@pytest.mark.parametrize(
    ("text", "fits"),
    [
        ("(-1 0 .4)", {-1: -0.4, 0: -0.3, 0.4: 1}),
        ("(-2 -1.4 0 1 2)", {-1.4: -1, 1: 1.4}),
        ("(0 1 2 3 4.5)", {4.5: 4}),
        ("(list 0 .5 1 1.7 2)", {1.7: 1.5}),
        ("(1 2 3)", {}),
        ("(-1 1)", {}),
        ("(0 1 5 2 9)", {}),
        ("[.03 .11]", {}),  # a point of a profile
    ],
)
def test_numbers_that_break_a_pattern(text: str, fits: dict[float, float]) -> None:
    found = {atom.value: value for atom, value in patterns_of(read(Source("a", text)).forms[0])}
    assert found == pytest.approx(fits)


def test_no_shape_is_made_flat() -> None:
    lamp = LAMP.replace("[0 1.8 0] :p1 [0 2 0]", "[0 1.45 0] :p1 [0 1.75 0]").replace(":p1 [0 2.7 0]", ":p1 [0 3 0]")
    found = repaired(
        Session(), Source("room.scene", lamp + ROOM.replace("THINGS", '(call "ceiling" :fixed #t)(call "lamp")'))
    )
    assert all(edit.new != "1.75" or edit.old != "1.45" for edit in found.edits)
    assert "[0 1.75 0] :p1 [0 1.75 0]" not in found.text

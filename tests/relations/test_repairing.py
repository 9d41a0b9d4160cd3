"""Repair of programs: what is found is resolved by small edits, and sound programs stay as they are."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from scenelang.cli.main import main
from scenelang.grammar.datum import Source
from scenelang.repairing import Repair, repaired
from scenelang.scene_relations import declarations_of
from scenelang.session import Session

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


def repair(things: str, *stated: str, geometry: bool = False, seconds: float = 60.0) -> Repair:
    session = Session()
    extra = [each for text in stated for each in declarations_of(session, text)]
    source = Source("room.scene", ROOM.replace("THINGS", things))
    return repaired(session, source, extra, geometry=geometry, seconds=seconds)


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
    found = repair(TABLE + '(transform (call "cup") (translate [.3 1.5 0]))', *both, seconds=1.5)
    assert found.left
    assert not found.changed  # nothing gets better by breaking the other


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

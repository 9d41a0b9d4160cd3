"""The model of mistakes: what it plants is a mistake, and it repairs by nothing but what `check --json` says."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from scenelang.bench import mutations
from scenelang.bench.mistake_kinds import KINDS, tuned_kinds, untouched_kinds
from scenelang.bench.mutations import (
    Mutated,
    PlantedMistake,
    check_documents,
    is_repaired,
    measure,
    mutated,
    repaired_by_check,
    repaired_mistakes,
)
from scenelang.cli.main import main

ROOM = """; a table with a lamp, and posts around it

(define post-height 1.5)
(define greens (list "green" "olive" "teal"))

(define (shade-of index)
  (color (ref greens (% index (length greens)))))

(define (post side)
  (transform (call "cylinder" :radius .1 :p1 [0 post-height 0] :color [.6 .4 .2])
             (translate [side 0 2])))

(bind "lamp"
  (lambda ((:glow 1))
    (define bulb (call "sphere" :radius .2 :color (shade-of 2) :emission glow))
    (union
      (call "cylinder" :radius .1 :p1 [0 .5 0] :color (color "ivory"))
      (transform bulb (translate [0 .65 0])))))

(bind "leg" (lambda (:height) (call "cube" :scale [.1 height .1])))

(bind "table"
  (lambda ()
    (define-values (width height) '(2 .8))
    (union
      (transform (call "cube" :scale [width .1 1] :color [.5 .4 .3])
                 (translate [0 (+ height .05) 0]))
      (union-loop 4
        (lambda (i)
          (define along (if (> i 1) .8 -.8))
          (transform (call "leg" :height height)
                     (translate [along (/ height 2) (if (odd? i) .4 -.4)])))))))

(bind "plank" (lambda () (call "cube" :scale [.3 .3 2])))

(bind "garden"
  (lambda ()
    (union
      (call "table")
      (transform (call "lamp") (translate [0 .9 0]))
      (transform (call "plank")
                 (@ (translate [3 1 0]) (rotate (/ pi 2) [1 0 0])))
      (for/union ((side '(-1.5 1.5))) (post side))
      (map post (list -2.5 2.5)))))
"""


STACK = """(bind "stack"
  (lambda ()
    (union
      (transform (call "cube" :color [1 0 0]) (translate [0 .5 0]))
      (transform (call "cube" :color [0 0 1]) (translate [0 1.5 0])))))
"""


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.sampled(3)
def test_every_kind_plants_a_mistake(kind: str) -> None:
    """The text differs where the mistake says, and the program fails, or makes another scene."""
    sound = STACK if kind == "sunken part" else ROOM
    made = mutated(sound, 1, 1, [kind])
    assert made is not None
    (mistake,) = made.mistakes
    assert mistake.kind == kind
    assert mistake.old == sound[mistake.start : mistake.end] != mistake.new
    assert made.text.startswith(sound[: mistake.start] + mistake.new)
    assert not is_repaired(made, made.text)
    assert is_repaired(made, made.sound)


def test_the_kinds_are_split_within_families() -> None:
    families = {kind.family for kind in KINDS.values()}
    tuned, untouched = tuned_kinds(), untouched_kinds()
    assert set(tuned).isdisjoint(untouched)
    assert min(len(tuned), len(untouched)) >= 15
    assert {KINDS[name].family for name in tuned} == families == {KINDS[name].family for name in untouched}


def test_a_seed_plants_the_same_mistakes() -> None:
    one = [mutated(ROOM, seed, 3) for seed in range(4)]
    assert one == [mutated(ROOM, seed, 3) for seed in range(4)]
    assert len({made.text for made in one if made is not None}) == 4
    assert any(made is not None and len(made.mistakes) == 3 for made in one)


def test_mistakes_are_at_different_places() -> None:
    made = mutated(ROOM, 2, 3)
    assert made is not None
    places = sorted((each.start, each.end) for each in made.mistakes)
    assert all(end < start for (_, end), (start, _) in pairwise(places))


def test_nothing_is_planted_where_there_is_no_place_or_scene() -> None:
    assert mutated('(bind "a" (lambda () (call "cube")))', 1, 1, ["degrees"]) is None
    assert mutated("(nothing)", 1) is None


def test_the_documents_are_those_of_the_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    made = mutated(ROOM, 1, 2, ["floating part", "misspelled builtin"])
    assert made is not None
    monkeypatch.chdir(tmp_path)
    Path("program.scene").write_text(made.text, "utf-8")
    main(["check", "--run", "--geometry", "--json", "program.scene"])
    printed: list[dict[str, Any]] = json.loads(capsys.readouterr().out)
    assert printed == check_documents(made.text)
    assert {d["name"] for d in printed} == {"unbound", "floating"}


def _document(**fields: Any) -> dict[str, Any]:
    place = {"file": "program.scene", "line": 1, "column": 2, "end_line": 1, "end_column": 5}
    return {"severity": "error", "name": "unbound", "hint": None, "fixes": [], "near": [], "place": place} | fields


@pytest.mark.parametrize(
    ("document", "text"),
    [
        (_document(), "(foo x)"),  # nothing is known about what was meant
        (_document(near=["for", "fob"]), "(for x)"),
        (_document(hint="did you mean `food`?"), "(food x)"),
        (
            _document(near=["for"], fixes=[{"edits": [{"place": _document()["place"], "text": "bar"}]}]),
            "(bar x)",
        ),
        (_document(near=["for"], place=None), "(foo x)"),
        (_document(near=["for"], place={**_document()["place"], "file": "other.scene"}), "(foo x)"),
    ],
)
def test_it_knows_nothing_but_the_documents(
    document: dict[str, Any], text: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(mutations, "check_documents", lambda _: [document])
    assert repaired_by_check("(foo x)") == text


def test_of_edits_that_overlap_the_first_is_made(monkeypatch: pytest.MonkeyPatch) -> None:
    warning = _document(severity="warning", near=["fob"])
    monkeypatch.setattr(mutations, "check_documents", lambda _: [warning, _document(near=["for"])])
    assert repaired_by_check("(foo x)") == "(for x)"


def test_what_an_error_leaves_unused_is_not_removed(monkeypatch: pytest.MonkeyPatch) -> None:
    unused = _document(
        severity="warning", name="unused", fixes=[{"edits": [{"place": _document()["place"], "text": ""}]}]
    )
    monkeypatch.setattr(mutations, "check_documents", lambda _: [unused, _document(place=None)])
    assert repaired_by_check("(foo x)") == "(foo x)"
    monkeypatch.setattr(mutations, "check_documents", lambda _: [unused])
    assert repaired_by_check("(foo x)") == "( x)"


def test_several_mistakes_are_repaired_in_one_turn() -> None:
    made = mutated(ROOM, 3, 3, ["missing bracket", "misspelled builtin", "length of a vector"])
    assert made is not None
    assert len(made.mistakes) == 3
    assert repaired_mistakes(made, repaired_by_check(made.text)) == [True, True, True]


def test_mistakes_count_one_by_one() -> None:
    """A repaired mistake beside one that is left counts; a change of white space is none."""
    sound = '(bind "a" (lambda () (call "cube" :scale [1 2 3])))'
    scale, word = sound.index(":scale"), sound.index('"cube"')
    mistakes = (
        PlantedMistake("misspelled option", scale, scale + 6, ":scale", ":scael"),
        PlantedMistake("misspelled word", word, word + 6, '"cube"', '"cbue"'),
    )
    made = Mutated(sound.replace(":scale", ":scael").replace("cube", "cbue"), mistakes, sound)
    assert repaired_mistakes(made, made.text) == [False, False]
    assert repaired_mistakes(made, made.text.replace(":scael", " :scale")) == [True, False]
    assert repaired_mistakes(made, sound.replace("[1 2 3]", "[1 2 3.]")) == [True, True]
    assert repaired_mistakes(made, made.text.replace(":scael", ":color")) == [False, False]
    assert repaired_mistakes(made, made.text.replace(":scael [1 2 3]", ":scale (list 1 2 (+ 1 2))")) == [True, False]


QUICK = ("misspelled builtin", "misspelled word", "name of CAD", "missing bracket", "commas", "order of transform")


def test_a_report_of_a_sample() -> None:
    report = measure({"room": ROOM}, 2, 1, QUICK)
    assert report.share(True) >= 0.9
    assert report.share(False) == 0.0
    assert {row.kind for row in report.rows} == set(QUICK)
    assert all(row.planted >= 2 and row.one_turn <= row.all_turns <= row.planted for row in report.rows)
    assert report == measure({"room": ROOM}, 2, 1, QUICK)
    data = json.loads(json.dumps(report.data()))
    assert data["share"]["tuned"] == round(report.share(True), 4)
    assert data["rows"][0] | {"planted": 0} == report.rows[0].data() | {"planted": 0}
    assert report.markdown().splitlines()[-2].startswith("| **all** | tuned | ")


def test_most_mistakes_of_a_sample_are_repaired() -> None:
    """One mistake of each kind that costs no search in the scene, but for the missing argument, which few programs
    tell."""
    sample = [name for name, kind in KINDS.items() if kind.evidence != "geometry" and name not in SEARCHED]
    report = measure({"room": ROOM}, 1, 8, sample[::2])
    assert sum(row.planted for row in report.rows) >= 15
    assert min(report.share(True), report.share(False)) >= 0.85


SEARCHED = ("count off by one", "missing argument")


@pytest.mark.slow
def test_both_halves_are_repaired() -> None:
    """The table of docs/bench.md, on fewer programs."""
    report = measure({"room": ROOM}, 4, 1)
    assert report.share(True) >= 0.85
    assert report.share(False) >= 0.85

"""Slips of an author: what the rest of a program says about one of its numbers, and repairs that follow it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import pytest

from scenelang.backends.geometry.lint import CheckedFrame
from scenelang.grammar.datum import Source
from scenelang.repairs.edit_trials import edited
from scenelang.repairs.repairing import _is_thinned, repaired
from scenelang.repairs.slips import (
    attributes_left_out,
    changed_numbers,
    changed_orders,
    completed_grids,
    completed_lists,
    pattern_values,
    sibling_values,
)
from scenelang.session.session import Session


def source(text: str) -> Source:
    return Source("a.scene", text)


def texts(program: Source, find: Callable[[Source], Iterable[Any]]) -> set[str]:
    return {edited(program.text, edit if isinstance(edit, tuple) else (edit,)) for edit in find(program)}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("'(0 0 .9 0)", {".9": 0.0}),  # all others are equal
        ("'((-1 2) (0 2.5) (1 2))", {"2.5": 2.0}),  # of a column
        ("'((-2.9 .3) (-1.5 .6) (0 .4) (.5 .7) (2.9 .2))", {"-1.5": -0.5, ".5": 1.5}),
        ("'((0 .4) (1 .95))", {}),  # a place and a size have no pattern
    ],
)
def test_numbers_that_differ_from_the_rest_of_their_list(text: str, expected: dict[str, float]) -> None:
    values = pattern_values(source(text))
    assert {text[at:].split(")")[0].split()[0]: value for at, value in values.items()} == pytest.approx(expected)


def test_lists_get_what_they_lack() -> None:
    assert "'(0 1 2)" in texts(source("'(1 2)"), completed_lists)
    assert texts(source("'(-.6)"), completed_lists) == {"'(-.6 .6)"}
    assert "'(0 1 2 3)" in texts(source("'(0 1 3)"), completed_lists)
    grid = "(for/union ((x '(-1 1 -1)) (z '(-2 -2 2))) x)"
    assert texts(source(grid), completed_grids) == {"(for/union ((x '(-1 1 -1 1)) (z '(-2 -2 2 2))) x)"}


def test_attributes_that_other_calls_do_without() -> None:
    program = source(
        '(union (transform (call "stool" :legs \'(0 1)) (translate [0 0 0]))'
        ' (transform (call "stool") (translate [1 0 0])))'
    )
    assert texts(program, attributes_left_out) == {program.text.replace(" :legs '(0 1)", "")}


def test_numbers_of_siblings_and_by_themselves() -> None:
    program = source(
        '(union (transform (call "pot") (translate [-.45 .9 .2])) (transform (call "pot") (translate [.85 y .2])))'
    )
    found = {(slip.edit.span.text, slip.edit.text) for slip in sibling_values(program)}
    assert {(".85", ".45"), (".85", "-.45"), (".9", "y")} <= found
    assert {slip.edit.text for slip in changed_numbers(source(".105"))} == {"-.105", "1.05"}
    assert {slip.edit.text for slip in changed_numbers(source("(rotate lean [0 0 0])"))} == {"(- lean)"}
    assert {slip.edit.text for slip in changed_numbers(source("(- gap board)"))} == {"+"}
    assert {slip.edit.text for slip in changed_orders(source("[.75 0 0]"))} == {"[0 .75 0]", "[0 0 .75]"}
    assert {slip.edit.text for slip in changed_orders(source("(@ a (rotate 1 z))"))} == {"(@ (rotate 1 z) a)"}


PLACES = """
(bind "post" (lambda () (call "cube" :scale [.2 1 .2])))
(bind "plank" (lambda () (call "cube" :scale [3 .1 .4])))
(bind "jar" (lambda () (call "cylinder" :radius .1 :p1 [0 .3 0])))
(bind "bracket" (lambda () (call "cube" :scale [.2 .1 .2])))
(bind "yard"
  (lambda ()
    (union
      (transform (call "cube" :scale [8 .2 8]) (translate [0 -.1 0]))
      PARTS)))
(scene "yard")
"""
BRIDGE = """(for/union ((x 'XS)) (transform (call "post") (translate [x .5 0])))
      (transform (call "plank") (translate [0 1.05 0]))"""
JARS = """(for/union ((x '(-1.2 1.2))) (transform (call "post") (translate [x .5 0])))
      (transform (call "plank") (translate [0 1.05 0]))
      (transform (call "jar") (translate [-1 1.1 0]))
      (transform (call "jar") (translate [.1 1.1 0]))
      (transform (call "jar") (translate [1 PLACE]))"""


@pytest.mark.parametrize(
    ("parts", "wrong", "right"),
    [
        (BRIDGE, "(-1.2)", "(-1.2 1.2)"),  # a post that was forgotten
        (JARS.replace("PLACE", "1.1 XS"), ".7", "0"),  # beside the plank, where its siblings are not
    ],
)
def test_what_an_author_meant_is_found(parts: str, wrong: str, right: str) -> None:
    text = PLACES.replace("PARTS", parts)
    found = repaired(Session(), source(text.replace("XS", wrong)), effort=60.0)
    assert found.left == ()
    assert found.text == text.replace("XS", right)


@pytest.mark.parametrize(("height", "is_thinned"), [(0.2, False), (0.1, False), (0.005, True)])
def test_slabs_that_tip_are_not_made_as_thin_as_paper(height: float, is_thinned: bool) -> None:
    def frame(height: float) -> CheckedFrame:
        text = f'(bind "slab" (lambda () (call "cube" :scale [2 {height} 1])))(scene "slab")'
        return CheckedFrame(Session().evaluate(source(text)).require().frames[0])

    assert _is_thinned(frame(0.2), frame(height)) == is_thinned

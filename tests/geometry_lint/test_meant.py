"""What may be meant is a note: what all equals do, seams of buildings, edges of boards, and what only settles."""

from __future__ import annotations

import pytest

from scenelang.grammar.datum import Source
from scenelang.session.session import Session

FLOOR = '(transform (call "cube" "floor" :scale [20 1 20]) (translate [0 -.5 0]))'
STONE = '(bind "stone" (lambda () (call "cube" "slab" :scale [.6 1.3 .3])))'


def codes(parts: str, words: str = "") -> list[str]:
    """Return the codes of what the check finds in a scene of parts on a floor."""
    program = f'{words}(bind "yard" (lambda () (union {FLOOR} {parts})))'
    return sorted(d.code for d in Session().check_geometry(Source("yard.scene", program)))


def stones(*heights: float) -> str:
    """Return stones in a row, whose centers are at some heights."""
    return "".join(f'(transform (call "stone") (translate [{2 * i} {y} 0]))' for i, y in enumerate(heights))


def posts(*heights: float) -> str:
    """Return slim posts in a row, whose centers are at some heights."""
    return stones(*heights).replace('"stone"', '"post"')


POST = '(bind "post" (lambda () (call "cylinder" :radius .1 :p0 [0 -2 0] :p1 [0 2 0])))'


@pytest.mark.parametrize(
    ("parts", "words", "expected"),
    [
        (stones(0.45, 0.45, 0.45), STONE, ["N613"]),  # foundations
        (stones(0.45, 0.65, 0.65), STONE, ["W613"]),
        (posts(1.8, 1.8, 1.8, 1.8), POST, ["N613"]),
        (posts(1.8, 1.8, 1.8, 0.9), POST, ["N613", "W613"]),  # deeper than all its equals, and than the floor is thick
    ],
)
def test_a_slip_sinks_one_of_several_equals(parts: str, words: str, expected: list[str]) -> None:
    assert codes(parts, words) == expected


@pytest.mark.parametrize(("gap", "code"), [(0.25, "N611"), (1.5, "W611")])
def test_buildings_run_a_little_into_each_other(gap: float, code: str) -> None:
    words = (
        '(bind "hall" (lambda () (transform (call "cube" :scale [4 3 6]) (translate [0 1.5 0]))))'
        '(bind "tower" (lambda () (transform (call "cube" :scale [3 8 3]) (translate [0 4 0]))))'
    )
    parts = f'(call "hall") (transform (call "tower") (translate [0 0 {4.5 - gap}]))'
    assert codes(parts, words) == [code]


def test_boats_that_float_may_be_in_their_harbour() -> None:
    boat = '(bind "boat" (lambda () (call "cube" :scale [2 1 1])))'
    parts = '(transform (call "boat" :floating {}) (translate [0 .1 0]))'
    assert codes(parts.format("#t"), boat) == []
    assert codes(parts.format("#f"), boat) == ["W613"]


def test_a_part_of_an_airplane_that_stands_does_not_fly() -> None:
    words = (
        '(bind "airplane" (lambda () (union (transform (call "cube" :scale [1 1 4]) (translate [0 .5 0])){}))) '
        '(bind "propeller" (lambda () (call "cube" :scale [1 .1 .1])))'
    )
    away = '(transform (call "propeller") (translate [0 .5 3]))'
    assert codes('(call "airplane")', words.format(away)) == ["W612"]


@pytest.mark.parametrize(("gap", "code"), [(0.05, "N626"), (0.4, "W626")])
def test_what_comes_to_rest_within_ten_degrees_is_a_note(gap: float, code: str) -> None:
    swan = (
        '(bind "swan" (lambda () (union (transform (call "cube" :scale [.4 1 .4]) (translate [0 .5 0]))'
        f'(transform (call "cube" :scale [2 1 1]) (translate [1.2 {gap + 0.5} 0])))))'
    )
    assert codes('(call "swan")', swan) == [code]

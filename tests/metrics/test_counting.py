"""How many of what a text asks for, and how many of it a program has."""

from __future__ import annotations

import pytest
from support import evaluate

from scenelang.backends.neural.metrics import (
    CountQuery,
    count_entities,
    count_queries,
    is_accurate,
    parse_counts,
    singular,
)

CANS = """
(bind "coke-can" (lambda () (call "cylinder" :color [.8 .1 .1])))
(bind "coke-cans" (lambda (:n) (union-loop n (lambda (i) (transform (call "coke-can") (translate (list (* 2 i) 0 0)))))))
(bind "table" (lambda () (union (call "cube") (union-loop 4 (lambda (i) (transform (call "leg") (translate [0 i 0])))))))
(bind "pyramid" (lambda () (union (call "coke-cans" :n 5) (transform (call "coke-cans" :n 10) (translate [0 3 0])) (call "table"))))
"""


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("15 coke cans on a table", [(15, "coke can")]),
        ("Fifteen Coke cans, and three chairs.", [(15, "coke can"), (3, "chair")]),
        ("a dozen eggs in a box", [(12, "egg")]),
        ("two dozen red knights", [(24, "red knight")]),
        ("a pair of shoes and 3 buses", [(2, "shoe"), (3, "bus")]),
        ("twenty-five dominoes falling", [(25, "domino falling")]),
        ("twenty five leaves", [(5, "leaf")]),
        ("a chessboard with 8 x 8 squares", []),
        ("an 8x8 chessboard", []),
        ("a grid of 5 by 5 pawns", []),
        ("two metres of rope, 1.5 apples", []),
        ("a three-legged stool", []),
        ("one tree", [(1, "tree")]),
        ("a tree", []),
        ("", []),
        ("9" * 400, []),
        ("two", []),
    ],
)
def test_what_a_text_asks_for(text: str, expected: list[tuple[int, str]]) -> None:
    assert [(one.count, " ".join(one.words)) for one in parse_counts(text)] == expected


@pytest.mark.parametrize(
    ("plural", "word"),
    [("cans", "can"), ("boxes", "box"), ("benches", "bench"), ("cherries", "cherry"), ("glass", "glass"),
     ("houses", "house"), ("trees", "tree"), ("cactus", "cactus"), ("dishes", "dish"), ("people", "person"),
     ("potatoes", "potato"), ("as", "as"), ("pies", "pie")],
)  # fmt: skip
def test_singulars(plural: str, word: str) -> None:
    assert singular(plural) == word


@pytest.mark.parametrize(
    ("text", "words", "found", "is_right"),
    [
        ("15 coke cans", ("coke-can",), 15, True),
        ("15 red coke cans stacked", ("coke-can",), 15, True),
        ("14 coke cans", ("coke-can",), 15, False),
        ("15 cans", ("coke-can",), 15, True),  # the end of a name is the kind of thing
        ("fifteen soda cans", ("coke-can",), 15, True),
        ("4 legs", ("leg",), 4, True),
        ("1 table", ("table",), 1, True),
        ("3 chairs", (), 0, False),
        ("0 chairs", (), 0, True),
    ],
)
def test_what_a_program_has(text: str, words: tuple[str, ...], found: int, is_right: bool) -> None:
    (one,) = count_entities(evaluate(CANS, root="pyramid"), parse_counts(text))
    assert (one.words, one.found, one.is_correct) == (words, found, is_right)


def test_all_counts_must_be_right() -> None:
    scene = evaluate(CANS, root="pyramid")
    assert is_accurate(count_entities(scene, parse_counts("15 coke cans and a table with 4 legs")))
    assert not is_accurate(count_entities(scene, parse_counts("15 coke cans and a table with 3 legs")))


def test_a_table_of_counts_is_taken_as_it_is() -> None:
    assert count_queries({"coke-can": 15, "Legs": 4}) == (CountQuery(15, ("coke", "can")), CountQuery(4, ("leg",)))


def test_of_a_name_and_its_plural_the_name_counts() -> None:
    """Where a program has only the plural, that is what there is."""
    only = '(bind "cans" (lambda () (union (call "cube") (transform (call "cube") (translate [2 0 0])))))'
    (one,) = count_entities(evaluate(only), parse_counts("2 cans"))
    assert (one.words, one.found) == (("cans",), 1)
    several = '(bind "b" (lambda () (union (call "red-can") (call "green-can"))))'
    (one,) = count_entities(evaluate(several), parse_counts("2 cans"))
    assert (one.words, one.found) == (("red-can", "green-can"), 2)

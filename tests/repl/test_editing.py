"""What helps while typing: indentation as the formatter has it, completion, brackets; and how values look."""

from __future__ import annotations

from pathlib import Path

import pytest
from prompt_toolkit.completion import CompleteEvent
from prompt_toolkit.document import Document

from scenelang.grammar.datum import Source
from scenelang.grammar.reader import read
from scenelang.interpreter.expand.forms import INDENTS
from scenelang.repl.console import SceneCompleter, indentation, is_finished, scan
from scenelang.repl.display import displayed
from scenelang.repl.evaluation import ReplEvaluation
from scenelang.session.formatting import indents_of
from scenelang.session.session import Session

ROOT = Path(__file__).parents[2]

INDENTED = [
    ("(define (f x)", 2), ("(lambda (x)", 2), ("(lambda", 4), ("(let ((x 1)", 6), ("(let ((x 1))", 2),
    ("(let loop ((i 0))", 2), ("(let loop", 4), ("(if test", 2), ("(+ 1", 3), ("(list", 2), ('(call "cube"', 6),
    ("(bind \"a\"", 2), ("[1 2", 1), ("(cond (a", 7), ("(define x (list 1", 16), ("1 2", 0), ('(f "a ( b"', 3),
    ("(f ; a ( comment", 2), ("(f #| ( |# 1", 3), ("(for/list ((x xs))", 2), ("(union (f)\n       (g", 9),
]  # fmt: skip


@pytest.mark.parametrize(("text", "columns"), INDENTED)
def test_indentation(text: str, columns: int) -> None:
    assert indentation(text, INDENTS) == columns


def test_indentation_is_nearly_always_the_formatters() -> None:
    same = other = 0
    for path in sorted([*(ROOT / "examples").glob("*.scene"), *(ROOT / "stdlib").glob("*.scene")]):
        text = path.read_text("utf-8")
        indents = indents_of(text, path.parent)
        for form in read(Source(path.name, text)).forms:
            lines = form.span.text.split("\n")
            for number, line in enumerate(lines[1:], 1):
                found = indentation("\n".join(lines[:number]), indents)
                same, other = (same + 1, other) if found == len(line) - len(line.lstrip()) else (same, other + 1)
    assert same > 500
    assert same / (same + other) > 0.94


@pytest.mark.parametrize(
    ("text", "openers", "wrong"),
    [("(a [b", (0, 3), ()), ("(a])", (), (2,)), (")", (), (0,)), ('("(" ; (\n', (0,), ()), ("#| ( |# (", (8,), ())],
)
def test_brackets(text: str, openers: tuple[int, ...], wrong: tuple[int, ...]) -> None:
    found = scan(text)
    assert (found.openers, found.wrong) == (openers, wrong)


@pytest.mark.parametrize(
    ("text", "finished"),
    [
        ("(a", False),
        ("(a)", True),
        ('"a', False),
        ("(a]", True),
        ("a b", True),
        ("'", False),
        (",doc (", True),
        ("", True),
    ],
)
def test_enter_sends_what_is_finished(text: str, finished: bool) -> None:
    assert is_finished(text) is finished


# --- completion ----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def evaluation() -> ReplEvaluation:
    found = ReplEvaluation(Session())
    for text in (
        '(bind "chess board" (lambda (:squares (:tint [1 1 1])) (call "cube")))',
        "(define (my-function a b) a)",
        "(define (place-it thing :far (:near 1)) thing)",
        "(define-macro (my-macro x) x)",
    ):
        assert found.evaluate(found.source(text)).ok
    return found


COMPLETIONS = [
    ("(my-f", "my-function", "function (my-function a b)"),
    ("(my-m", "my-macro", "macro"),
    ("(compute-shape-c", "compute-shape-center", ""),
    ("(for/un", "for/union", ""),
    ('(call "che', "chess board", "function"),
    ('(call "cyl', "cylinder", "a solid cylinder"),
    ('(call "chess board" :sq', ":squares", ""),
    ('(call "chess board" :squares 1 :', ":tint", ""),
    ('(call "sphere" :ra', ":radius", "radius in scene units"),
    ('(call "set-cuboid" :f', ":fill", "whether to fill the whole cuboid"),
    ('(call "my own thing" :io', ":ior", "index of refraction"),
    (",doc :rou", ":roughness", "from 0, polished, to 1, rough"),
    ("(place-it x :n", ":near", ""),
    ("(grid x :sp", ":spacing", ""),
    (",rel", ",reload", "evaluate the file again"),
    (",doc my-f", "my-function", ""),
    (",help wat", "watch", ""),
    ("*", "*1", ""),
]


@pytest.mark.parametrize(("text", "completion", "meta"), COMPLETIONS)
def test_completion(evaluation: ReplEvaluation, text: str, completion: str, meta: str) -> None:
    found = {
        c.text: c.display_meta_text for c in SceneCompleter(evaluation).get_completions(Document(text), CompleteEvent())
    }
    assert completion in found
    assert meta in found[completion]


@pytest.mark.parametrize("text", ['(print "che', "; my-f", '(call "x" "my-f', "#| my-f"])
def test_nothing_is_completed_where_nothing_is_meant(evaluation: ReplEvaluation, text: str) -> None:
    assert list(SceneCompleter(evaluation).get_completions(Document(text), CompleteEvent())) == []


def test_files_are_completed(evaluation: ReplEvaluation, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "garden.scene").write_text("1")
    monkeypatch.chdir(tmp_path)
    found = SceneCompleter(evaluation).get_completions(Document(",load gar"), CompleteEvent())
    assert [c.text for c in found] == ["den.scene"]


# --- values --------------------------------------------------------------------------------------------------------

SHOWN = [
    ("none", ""),
    ("1.5", "1.5"),
    ('"a\\tb"', '"a\\tb"'),
    ("(translate [1 2.5 -3])", "[[1 0 0   1]\n [0 1 0 2.5]\n [0 0 1  -3]\n [0 0 0   1]]"),
    ("[1 2.5 1e-9]", "[1.0 2.5 1e-09]"),
    ("(lambda (x (y 2)) x)", "function (lambda x (y 2))"),
    ("my-function", "function (my-function a b)"),
    ("(table 'a 1 'bcd \"x\")", 'table of 2:\n  a    1\n  bcd  "x"'),
    ("[[1 2] [30 4]]", "[[ 1 2]\n [30 4]]"),
    ('(list (call "cube") (call "cube") (call "cone"))', "3 parts\n├─ 2 x cube\n└─ cone"),
    ('(transform (call "cube") (translate [1 0 0]))', "1 part\n└─ cube"),
    ('(frames (list (call "cube") (call "cone")))', "2 frames; the first:\nparts\n└─ cube"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "shown"), SHOWN)
def test_values(evaluation: ReplEvaluation, text: str, shown: str) -> None:
    outcome = evaluation.evaluate(evaluation.source(text))
    values = outcome.values
    assert outcome.ok
    assert (displayed(values[0]) if values else "") == shown


def test_a_deep_tree_stays_short(evaluation: ReplEvaluation) -> None:
    text = '(bind "d" (lambda (:n) (if (= n 0) (call "cube") (union (call "d" :n (- n 1)) (call "cone"))))) (call "d" :n 500)'
    outcome = evaluation.evaluate(evaluation.source(text))
    shown = displayed(outcome.values[-1], 60).splitlines()
    assert len(shown) == 12
    assert sum("... 2 parts" in line for line in shown) == 1
    assert max(map(len, shown)) <= 60

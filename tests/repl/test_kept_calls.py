"""A session that uses calls and functions again, where no definition reaches them, against one that forgets them all."""

from __future__ import annotations

from pathlib import Path
from random import Random
from typing import Any

import pytest
from searching import many
from support import geometry
from test_incremental import LIMITS, History

from scenelang import Options, Session, Source
from scenelang.grammar.diagnostics import SceneError, render_text
from scenelang.interpreter.runtime.runtime import Runtime
from scenelang.interpreter.runtime.show import show
from scenelang.repl.evaluation import ReplEvaluation
from scenelang.session.editing import Editing


class PureHistory(History):
    """Versions of a program that changes no state."""

    def value(self, depth: int) -> str:
        return self._without(super().value(depth), lambda: self.value(depth - 1), "(set")

    def body(self, depth: int) -> str:
        return self._without(super().body(depth), lambda: self.body(depth - 1), "(set", "(begin (bind")

    def form(self, old: str = "") -> str:
        return self._without(super().form(old), lambda: self.form(old), "(set", "string-append")

    def _without(self, text: str, other: Any, *parts: str) -> str:
        return other() if any(part in text for part in parts) else text


def plain(session: Session, path: Path) -> ReplEvaluation:
    """A session that uses nothing again."""
    made = ReplEvaluation(session, str(path))
    made.top._calls.is_tracked = False
    made.top._unchanged = lambda source: {}  # type: ignore[method-assign]
    return made


def observed(evaluation: ReplEvaluation, action: Any) -> Any:
    """What an input shows, and the scene after it."""
    outcome = action(evaluation)
    said = [render_text(d, color=False) for d in outcome.diagnostics]
    shown = [show(value, 200) for value in outcome.values]
    try:
        scene: Any = geometry(evaluation.root())
    except (SceneError, RecursionError) as error:
        scene = evaluation.session.problem_of(error).message  # type: ignore[union-attr]
    return said, shown, outcome.log, scene, tuple(evaluation.top.rt.log)


def compare(random: Random, path: Path) -> tuple[str | None, int]:
    """Compare the two over a history; return what differs, and how many times there was a scene."""
    history = random.choice((History, PureHistory, PureHistory))(random)
    session = Session(Options(limits=LIMITS))
    ours, theirs = ReplEvaluation(session, str(path)), plain(session, path)
    scenes = 0
    told = []
    for _ in range(8):
        if random.random() < 0.6:
            history.edit()
            told.append(history.text)
            path.write_text(history.text, "utf-8")
            action = lambda evaluation: evaluation.reload(str(path))
        else:
            text = history.form()
            told.append(text)
            action = lambda evaluation, text=text: evaluation.evaluate(evaluation.source(text))
        found = observed(ours, action), observed(theirs, action)
        scenes += type(found[1][3]) is list
        if found[0] != found[1]:
            return "\n---\n".join([*told, *map(repr, found)]), scenes
    return None, scenes


def search(count: int, seed: int, folder: Path) -> tuple[list[str], int]:
    random = Random(seed)
    found = [compare(random, folder / "a.scene") for _ in range(count)]
    return [text for text, _ in found if text is not None], sum(scenes for _, scenes in found)


def test_random_sessions(tmp_path: Path) -> None:
    count = many(60)
    different, scenes = search(count, 3, tmp_path)
    assert different == []
    assert scenes > 2 * count


TOWN = """; a town
(define (wide k) (* 2 k))
(define step 1)
(define height (* 3 step))
(bind "tower" (lambda () (call "cube" :scale [1 height 1])))
(bind "house" (lambda () (call "cube" :scale [(wide 1) 1 1])))
(bind "town" (lambda () (union (call "tower") (call "house"))))
"""
EDITS = [
    ("", "", []),
    ("; a town", "; the town", []),
    ('(bind "town"', '\n(bind "town"', []),
    ("(define step 1)", "(define step 1)\n(define other 2)", []),
    ("(* 2 k)", "(* 3 k)", ["house"]),
    ("(define step 1)", "(define step 2)", ["tower"]),
    ("(define step 1)", "(define step (- 2 1))", []),
    ('"house" (lambda () (call', '"house" (lambda () (call ', ["house"]),
    ("(define (wide k) (* 2 k))\n", "(define-syntax wide (syntax-rules () ((_ k) k)))\n", ["house"]),
]


@pytest.fixture
def called(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The words of the calls that are evaluated."""
    words: list[str] = []
    run = Runtime._run_call
    noted = lambda rt, word, *rest: words.append(word) or run(rt, word, *rest)
    monkeypatch.setattr(Runtime, "_run_call", noted)
    return words


@pytest.mark.parametrize(("old", "new", "reached"), EDITS)
def test_an_edit_evaluates_what_it_reaches(
    tmp_path: Path, called: list[str], old: str, new: str, reached: list[str]
) -> None:
    path = tmp_path / "town.scene"
    evaluation = ReplEvaluation(Session(Options()), str(path))
    for text in (TOWN, TOWN.replace(old, new, 1)):
        path.write_text(text, "utf-8")
        assert evaluation.reload(str(path)).ok
        called.clear()
        evaluation.root()
    assert called == reached


def test_an_input_evaluates_what_it_reaches(tmp_path: Path, called: list[str]) -> None:
    path = tmp_path / "town.scene"
    path.write_text(TOWN, "utf-8")
    evaluation = ReplEvaluation(Session(Options()), str(path))
    evaluation.load(str(path))
    for text, reached in [
        ("1", ["tower", "house"]),
        ("(define step 1)", []),
        ("(define other 5)", []),
        ("(define height 5)", ["tower"]),
        ('(bind "house" (lambda () (call "sphere")))', ["house"]),
        ('(bind "town" (lambda () (call "house")))', []),
    ]:
        assert evaluation.evaluate(evaluation.source(text)).ok
        called.clear()
        evaluation.root()
        assert called == reached, text


def test_an_error_in_a_kept_function_is_where_it_is_now(tmp_path: Path) -> None:
    path = tmp_path / "a.scene"
    text = '(define (f x)\n  (car x))\n(bind "a" (lambda () (f 1)))\n'
    evaluation = ReplEvaluation(Session(Options()), str(path))
    for above in ("", "; a line\n(define k 1)\n"):
        path.write_text(above + text, "utf-8")
        assert evaluation.reload(str(path)).ok
    outcome = evaluation.evaluate(evaluation.source("(f 2)"))
    shown = render_text(outcome.diagnostics[-1], color=False)
    assert f"{path}:4:3" in shown
    assert "  (car x))" in shown


def test_a_reload_notices_names_that_are_gone(tmp_path: Path) -> None:
    path = tmp_path / "a.scene"
    text = '(define (f x) x)\n(bind "a" (lambda () (call "cube" :scale (f 1))))\n'
    evaluation = ReplEvaluation(Session(Options()), str(path))
    path.write_text(text, "utf-8")
    assert evaluation.reload(str(path)).ok
    path.write_text(text.split("\n", 1)[1], "utf-8")
    assert [d.name for d in evaluation.reload(str(path)).diagnostics] == ["unbound"]


def test_an_import_binds_a_word_that_was_a_primitive(tmp_path: Path, called: list[str]) -> None:
    (tmp_path / "legs.scene").write_text('(bind "leg" (lambda () (call "sphere")))', "utf-8")
    path = tmp_path / "a.scene"
    text = '(bind "stool" (lambda () (call "leg")))\n(bind "lamp" (lambda () (call "cube")))\n'
    path.write_text(f'{text}(bind "room" (lambda () (union (call "stool") (call "lamp"))))', "utf-8")
    evaluation = ReplEvaluation(Session(Options()), str(path))
    evaluation.load(str(path))
    assert [row[0] for row in geometry(evaluation.root())[0]] == ["leg", "cube"]
    called.clear()
    assert evaluation.evaluate(evaluation.source('(import "legs.scene")')).ok
    assert [row[0] for row in geometry(evaluation.root())[0]] == ["sphere", "cube"]
    assert called == ["stool", "leg"]


A, B = '(bind "a" (lambda () (call "cube")))\n', '(bind "b" (lambda () (call "sphere")))\n'
RELOADS = {
    "words in another order": (A + B, B + A),
    "a word above the root": (A, B + A),
    "a function that was assigned": ("(define (f) 1)\n(define old f)\n(set! f (lambda () (+ 1 (old))))\n" + A,) * 2,
    "an assignment that is gone": ("(define (f) 1)\n(set! f (lambda () 3))\n" + A, "(define (f) 1)\n" + A),
    "a call that prints": ('(bind "c" (lambda () (print "c") (call "cube")))\n(call "c")\n',) * 2,
    "an import that is gone": (
        '(import "i.scene")\n(bind "r" (lambda () (call "w")))\n',
        '(bind "r" (lambda () (call "w")))',
    ),
    "an empty file": ('(import "i.scene")\n', ""),
    "a word over that of an import": (
        '(import "i.scene")\n(bind "w" (lambda () (call "torus")))\n(bind "r" (lambda () (call "w")))\n',
        '(import "i.scene")\n(bind "r" (lambda () (call "w")))\n',
    ),
    "an assignment above a function": (
        "(define (f) 1)\n" + A,
        "(set! f (lambda () 3))\n(define (f) 1)\n(define k 1)\n" + A + "(f)",
    ),
    "a word bound by code above its definition": (A, '(begin (bind "a" (lambda () (call "cone"))))\n' + A),
    "code above the word that it calls": (
        '(define size (compute-shape-sizes (call "leg")))\n(bind "leg" (lambda () (call "cube" :scale 5)))\n'
        '(bind "r" (lambda () (call "cube" :scale size)))\n(scene "r")',
    )
    * 2,
    "code above the import that it needs": (
        '(import "i.scene")\n(define k (compute-shape-sizes (call "w")))\n' + A,
        '(define k (compute-shape-sizes (call "w")))\n(import "i.scene")\n(print k)\n' + A,
    ),
    "code above the function that it calls": (
        "(define (f) 1)\n(define k (f))\n" + A,
        "(define k (f))\n(define (f) 1)\n" + A,
    ),
    "an error in a kept function": (
        '(define (f x) (error "bad" x))\n(bind "r" (lambda () (call "cube" :scale (f 1))))\n',
        '\n; more\n(define (f x) (error "bad" x))\n(bind "r" (lambda () (call "cube" :scale (f 1))))\n',
    ),
}


def told(evaluation: ReplEvaluation) -> object:
    """The scene of a session, or the error with its place, and what was printed."""
    try:
        scene: object = geometry(evaluation.root())
    except SceneError as error:
        scene = render_text(error.diagnostic, color=False)
    return scene, [show(value) for value in evaluation.evaluate(evaluation.source('(bound? "w")')).values]


@pytest.mark.parametrize("name", RELOADS)
def test_a_reload_is_as_a_new_session(tmp_path: Path, name: str) -> None:
    (tmp_path / "i.scene").write_text('(bind "w" (lambda () (call "cone")))', "utf-8")
    path = tmp_path / "a.scene"
    evaluation = ReplEvaluation(Session(Options()), str(path))
    for text in RELOADS[name]:
        path.write_text(text, "utf-8")
        outcome = evaluation.reload(str(path))
        found = told(evaluation)
    new = ReplEvaluation(Session(Options()), str(path))
    loaded = new.load(str(path))
    assert outcome.log == loaded.log
    assert outcome.ok == loaded.ok
    assert not loaded.ok or found == told(new)


def test_an_import_is_edited(tmp_path: Path) -> None:
    other, path = tmp_path / "i.scene", tmp_path / "a.scene"
    path.write_text('(import "i.scene")\n(bind "r" (lambda () (call "w")))\n(scene "r")', "utf-8")
    evaluation = ReplEvaluation(Session(Options()), str(path))
    for primitive in ("cube", "cone", None):
        other.write_text(f'(bind "w" (lambda () (call "{primitive}")))' if primitive else "", "utf-8")
        assert evaluation.reload(str(path)).ok
        assert [row[0] for row in geometry(evaluation.root())[0]] == [primitive or "w"]


def test_an_import_takes_the_file_as_it_is_now(tmp_path: Path) -> None:
    other, main = tmp_path / "i.scene", tmp_path / "a.scene"
    (tmp_path / "j.scene").write_text('(bind "w" (lambda () (call "torus")))', "utf-8")
    main.write_text('(import "j.scene")\n(bind "r" (lambda () (call "w")))\n(scene "r")', "utf-8")
    evaluation = ReplEvaluation(Session(Options()), str(main))
    evaluation.load(str(main))
    for text, word in [
        ('(bind "w" (lambda () (call "cone")))', "cone"),
        ("(define k 1)", "torus"),
        ('(import "j.scene")(bind "v" (lambda () (call "w")))', "torus"),
    ]:
        other.write_text(text, "utf-8")
        assert evaluation.evaluate(evaluation.source('(import "i.scene")')).ok
        assert [row[0] for row in geometry(evaluation.root())[0]] == [word]


def test_a_missing_import_of_an_import_is_found_later(tmp_path: Path) -> None:
    text = '(import "i.scene")\n(bind "r" (lambda () (call "w")))\n(scene "r")'
    source = Source(str(tmp_path / "a.scene"), text)
    (tmp_path / "i.scene").write_text('(import "j.scene")', "utf-8")
    editing = Editing(Session(Options()))
    assert editing.evaluate(source).scene is None
    (tmp_path / "j.scene").write_text('(bind "w" (lambda () (call "torus")))', "utf-8")
    scene = editing.evaluate(source).scene
    assert scene is not None
    assert [row[0] for row in geometry(scene)[0]] == ["torus"]


def test_a_replaced_function_does_not_come_back(tmp_path: Path) -> None:
    path = tmp_path / "a.scene"
    text = '(define c (+ 1 1))\n(define d (+ 1 0))\n(bind "a" (lambda () (call "cube" :scale c)))\n'
    path.write_text(text, "utf-8")
    evaluation = ReplEvaluation(Session(Options()), str(path))
    evaluation.load(str(path))
    evaluation.evaluate(evaluation.source("(define (c x) (car c))"))
    path.write_text('(bind "b" (lambda () (call "cube")))\n' + text, "utf-8")
    assert evaluation.reload(str(path)).ok
    assert show(evaluation.top.value_of("c")) == "2"


def test_a_reload_starts_with_the_first_state_of_its_imports(tmp_path: Path) -> None:
    (tmp_path / "i.scene").write_text("(define count 0)\n(define (next) (set! count (+ count 1)) count)", "utf-8")
    path = tmp_path / "a.scene"
    path.write_text('(import "i.scene")\n(bind "a" (lambda () (call "cube" :scale (next))))\n(print (next))', "utf-8")
    evaluation = ReplEvaluation(Session(Options()), str(path))
    assert evaluation.load(str(path)).log == ("1",)
    for _ in range(3):
        evaluation.root()
        assert evaluation.reload(str(path)).log == ("1",)


def test_a_reload_does_not_use_a_value_above_its_definition(tmp_path: Path) -> None:
    path = tmp_path / "a.scene"
    evaluation = ReplEvaluation(Session(Options()), str(path))
    a = '(bind "a" (lambda () (call "cube" :scale m)))\n'
    path.write_text(f"(define k 1)\n(define m (+ k 1))\n{a}", "utf-8")
    assert evaluation.reload(str(path)).ok
    path.write_text(f"(define m (+ k 1))\n(define k 5)\n{a}", "utf-8")
    assert [d.name for d in evaluation.reload(str(path)).diagnostics] == ["undefined-yet"]
    assert show(evaluation.top.value_of("k")) == "1"
    path.write_text(f"(define k 5)\n(define m (+ k 1))\n{a}", "utf-8")
    assert evaluation.reload(str(path)).ok
    assert show(evaluation.top.value_of("m")) == "6"


@pytest.mark.parametrize(
    ("old", "new"), [("(cons 1 2)", "(cons 1 3)"), ("(list 1 (cons 1 2))", "(list 1 (cons 1 3))"), ("0.0", "-0.0")]
)
def test_values_that_print_differently_are_not_the_same(tmp_path: Path, old: str, new: str) -> None:
    path = tmp_path / "a.scene"
    path.write_text(f'(define p {old})\n(bind "x" (lambda () (call "cube" :name (string p))))', "utf-8")
    evaluation = ReplEvaluation(Session(Options()), str(path))
    evaluation.load(str(path))
    before = evaluation.root()
    assert evaluation.evaluate(evaluation.source(f"(define p {new})")).ok
    assert geometry(evaluation.root()) != geometry(before)


def test_a_library_function_outlives_the_error_of_its_first_call(tmp_path: Path) -> None:
    evaluation = ReplEvaluation(Session(Options()))
    for text in ('(bind "w" (lambda () (grid (call "cube") :nx 2) (car 1)))', '(call "w")'):
        evaluation.evaluate(evaluation.source(text))
    assert evaluation.evaluate(evaluation.source('(grid (call "cube") :nx 2)')).ok


def test_the_first_call_of_a_library_function_is_shared() -> None:
    text = """(bind "w" (lambda () (print "once") (grid (call "cube") :nx 2)))
(bind "r" (lambda () (union (call "w") (call "w") (call "w"))))"""
    assert Session().evaluate(Source("a.scene", text)).log == ("once",)

"""The evaluation of an edit against a run from scratch: equal scenes, places, logs and diagnostics. Searches by hand:

PYTHONPATH=tests python -m test_incremental 10000 [seed]
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import Any

import pytest
from support import geometry

from scenelang import Options, Session, Source
from scenelang.grammar.diagnostics import render_text
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.entity import descendants
from scenelang.interpreter.values.limits import Limits
from scenelang.session.editing import Editing
from scenelang.session.session import Evaluated

LIMITS = Limits(steps=200_000, depth=2_000)  # programs without end take little time
WORDS = ("leg", "top", "table", "room", "lamp", "hall")
NAMES = ("a", "b", "c", "d")


class History:
    """Versions of a program: forms that are drawn, changed, moved, removed and put back."""

    def __init__(self, random: Random) -> None:
        self.random = random
        self.words, self.names = WORDS, NAMES  # those that the form being drawn may use
        self.forms = ["(define count 0)", "(define seen (table))", "(define-record rec p q)",
                      "(define-syntax twice (syntax-rules () ((_ x) (union x x))))", '(scene "hall")',
                      *map(self.function, "ab"), *map(self.definition, "cd"), *map(self.bind, WORDS)]  # fmt: skip
        self.removed: list[str] = []

    @property
    def text(self) -> str:
        return "\n".join(self.forms) + "\n"

    def edit(self) -> None:
        pick, forms = self.random, self.forms
        at = pick.randrange(len(forms)) if forms else 0
        kind = pick.choice(("new", "new", "change", "change", "change", "remove", "back", "move", "none", "blank"))
        if kind == "new" or not forms:
            forms.insert(at, self.form())
        elif kind == "change":
            forms[at] = self.form(forms[at])
        elif kind == "remove":
            self.removed.append(forms.pop(at))
        elif kind == "back" and self.removed:
            forms.insert(at, pick.choice(self.removed))
        elif kind == "move":
            forms.insert(pick.randrange(len(forms)), forms.pop(at))
        elif kind == "blank":
            forms[at] = pick.choice(("; a comment\n", "\n", "  ")) + forms[at]

    def form(self, old: str = "") -> str:
        """A form; one that replaces ``old`` often defines the same."""
        pick = self.random
        if old.startswith("(bind") and pick.random() < 0.8:
            return self.bind(old.split('"')[1])
        if old.startswith("(define (") and pick.random() < 0.8:
            return self.function(old[9])
        if old.startswith(("(define c ", "(define d ", "(param ")) and pick.random() < 0.8:
            return self.definition(old.split()[1])
        draw = pick.random()
        if draw < 0.5:
            return self.bind(pick.choice(WORDS))
        if draw < 0.68:
            return self.function(pick.choice(NAMES))
        return pick.choice((
            lambda: self.definition(pick.choice("cd")),
            lambda: self.definition(pick.choice("cd")),
            lambda: f"(set! {pick.choice(NAMES)} {self.value(1)})",
            lambda: "(define count 0)",
            lambda: "(define seen (table))",
            lambda: f"(print {self.value(1)})",
            lambda: f"(define-record rec {pick.choice(('p q', 'q p'))})",
            lambda: f"(define-syntax twice (syntax-rules () ((_ x) (union x {pick.choice(('x', '(list)'))}))))",
            lambda: f'(scene "{pick.choice(WORDS)}")',
            lambda: f'(for-each (lambda (i) (print (bound? "{pick.choice(WORDS)}"))) (list 1))',
        ))()  # fmt: skip

    def function(self, name: str) -> str:
        self.names = NAMES[: NAMES.index(name)] if self.random.random() < 0.95 else NAMES
        return f"(define ({name} x) {self.value(2)})"

    def definition(self, name: str) -> str:
        self.names = NAMES[:2]
        value = self.random.choice((self.value(2), "(uniform 1 2)", "(rec 1 2)", "(list 1 2)", "3", "(vector 1 2)"))
        return self.random.choice((f"(define {name} {value})", f"(param {name} {self.random.randint(1, 5)})"))

    def bind(self, word: str) -> str:
        self.words = WORDS[: WORDS.index(word)] if self.random.random() < 0.95 else WORDS
        self.names = NAMES
        parameters = self.random.choice(("(:size 1)", "(:size 1)", "(:size 1)", "z", "z gamma", ""))
        return f'(bind "{word}" (lambda ({parameters}) {self.body(3)}))'

    def name(self) -> str:
        return self.random.choice([name for name in self.names if name in "ab"] or ["abs"])

    def word(self) -> str:
        return self.random.choice(self.words or ("unbound",))

    def value(self, depth: int) -> str:
        pick = self.random
        if depth == 0 or pick.random() < 0.3:
            return str(pick.choice((0, 1, 2, 0.5, "a", "b", "c", "d", "count", "3", "4", "(car c)")))
        return pick.choice((
            lambda: f"(+ {self.value(depth - 1)} {self.value(depth - 1)})",
            lambda: f"(* 2 {self.value(depth - 1)})",
            lambda: f"({self.name()} {self.value(depth - 1)})",
            lambda: f"(if (< {self.value(depth - 1)} 1) {self.value(depth - 1)} 2)",
            lambda: "(begin (set! count (+ count 1)) count)",
            lambda: '(begin (set-ref! seen "k" (+ 1 (ref seen "k" 0))) (ref seen "k"))',
            lambda: "(uniform 0 1)",
            lambda: f"(guard (e (else 2)) (rec-p {pick.choice('cd')}))",
            lambda: f"(guard (e (else 1)) {self.value(depth - 1)})",
        ))()  # fmt: skip

    def body(self, depth: int) -> str:
        pick = self.random
        if depth == 0 or pick.random() < 0.15:
            return pick.choice((
                lambda: '(call "cube")',
                lambda: f'(call "sphere" :radius {self.value(1)})',
                lambda: f'(call "cube" :scale [1 {self.value(1)} {self.value(0)}])',
            ))()  # fmt: skip
        return pick.choice((
            lambda: f"(union {self.body(depth - 1)} {self.body(depth - 1)})",
            lambda: f'(call "{self.word()}")',
            lambda: f'(call "{self.word()}")',
            lambda: f'(call "{self.word()}" :size {self.value(1)})',
            lambda: f'(call "{self.word()}" "{self.word()}")',
            lambda: f"(transform {self.body(depth - 1)} (translate [{self.value(1)} 0 1]))",
            lambda: f"(union-loop 3 (lambda (i) {self.body(depth - 1)}))",
            lambda: f"(twice {self.body(depth - 1)})",
            lambda: f"(begin (print {self.value(1)}) {self.body(depth - 1)})",
            lambda: f'(call (string-append "{pick.choice(("le", "to"))}" "{pick.choice(("g", "p"))}"))',
            lambda: f'(begin (bind "{self.word()}" (lambda () {self.body(1)})) {self.body(depth - 1)})',
            lambda: f'(begin (set! count {self.value(1)}) (call "{self.word()}"))',
            lambda: f'(let ((f (lambda () {self.body(depth - 1)}))) (call "{self.word()}" :size f) (f))',
        ))()  # fmt: skip


def places(evaluated: Evaluated) -> list[Any]:
    """The call sites of the primitives, in the order of the tree."""
    assert evaluated.scene is not None
    found = []
    for root in evaluated.scene.frames:
        for entity in descendants(root):
            if entity.is_primitive and len(entity.call_sites) < 16:
                found.append((entity.word, sorted({(s.start, s.end) for s in entity.call_sites})))
    return found


def observed(evaluated: Evaluated) -> Any:
    said = [render_text(d, color=False) for d in evaluated.diagnostics]
    # how deep calls are when they are too deep, and so which is the last, depends on the stack of Python around them
    said = [text.split("\n")[0] if text.startswith("error[E502]") else text for text in said]
    if any(text.startswith("error[E502]") for text in said):
        return said
    if evaluated.scene is None:
        return said, evaluated.log
    return geometry(evaluated.scene), places(evaluated), said, evaluated.log


def histories(random: Random, length: int = 8) -> Iterator[str]:
    history = History(random)
    for _ in range(length):
        yield history.text
        history.edit()


def search(count: int, seed: int) -> tuple[int, int, int]:
    """Compare ``count`` histories; return the numbers of differences, of versions and of those with a scene."""
    random, session = Random(seed), Session(Options(limits=LIMITS))
    wrong = versions = scenes = 0
    for _ in range(count):
        editing = Editing(session)
        texts = []
        for text in histories(random):
            source = Source("<test>", text)
            ours, theirs = observed(editing.evaluate(source)), observed(session.evaluate(source))
            versions += 1
            scenes += len(theirs) == 4
            texts.append(text)
            if ours != theirs:
                wrong += 1
                print("\n---\n".join(texts[-3:]), ours, theirs, sep="\n", flush=True)
                break
    return wrong, versions, scenes


@pytest.mark.parametrize("count", [15, pytest.param(400, marks=[pytest.mark.search, pytest.mark.slow])])
def test_random_histories(count: int) -> None:
    wrong, versions, scenes = search(count, 5)
    assert wrong == 0
    assert scenes > versions / 4


def test_a_function_that_is_assigned_later_is_defined_again() -> None:
    function, changed, words = "(define (a x) 1)\n", "(set! a (a 2))\n", '(bind "b" (lambda () (call "cube")))\n'
    editing, session = Editing(Session(Options())), Session(Options())
    for text in (function + words, function + changed + words, function + changed + words.replace("cube", "sphere")):
        source = Source("<test>", text)
        assert observed(editing.evaluate(source)) == observed(session.evaluate(source))


def test_a_call_that_finds_what_another_printed_is_evaluated_again() -> None:
    words = '(bind "a" (lambda () (print "a") (call "cube")))\n(bind "b" (lambda () (call "a")))\n'
    editing, session = Editing(Session(Options())), Session(Options())
    for parts in ('(call "a") (call "b")', '(call "b")'):
        source = Source("<test>", f'{words}(bind "c" (lambda () (union {parts})))')
        assert observed(editing.evaluate(source)) == observed(session.evaluate(source))


def test_call_as_a_value_may_call_any_word() -> None:
    words = (
        '(bind "b" (lambda () (union (apply call (list (string-append "" "a"))))))\n(bind "c" (lambda () (call "b")))'
    )
    editing, session = Editing(Session(Options())), Session(Options())
    for primitive in ("cube", "sphere"):
        source = Source("<test>", f'(bind "a" (lambda () (call "{primitive}")))\n{words}')
        assert observed(editing.evaluate(source)) == observed(session.evaluate(source))


def test_a_variable_that_is_no_longer_changed_has_a_kind_again() -> None:
    rest = '(define c 2)\n(bind "a" (lambda () (if (> (random) 2) (call "cube" :scale (car c)) (call "cube"))))'
    editing, session = Editing(Session(Options())), Session(Options())
    for text in (f"(set! c (list 1))\n{rest}", rest):
        source = Source("<test>", text)
        assert observed(editing.evaluate(source)) == observed(session.evaluate(source))


EXAMPLES = sorted((Path(__file__).parent.parent / "examples").glob("*.scene"))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
@pytest.mark.sampled(3)
def test_an_example_while_numbers_change(path: Path) -> None:
    text, random = path.read_text("utf-8"), Random(7)
    session = Session(Options())
    editing = Editing(session)
    for _ in range(3):
        source = Source(str(path), text)
        assert observed(editing.evaluate(source)) == observed(session.evaluate(source))
        at = random.randrange(text.count("1"))
        parts = text.split("1")
        text = "1".join(parts[: at + 1]) + random.choice(("2", "1.5")) + "1".join(parts[at + 1 :])


if __name__ == "__main__":
    print(*search(int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 1))


CUBE, SPHERE = '(call "cube")', '(call "sphere")'
ROOT = '(bind "r" (lambda () (call "x")))'
BOUND_BY_CODE = [
    (f'(define (make) (bind "x" (lambda () {CUBE})))\n(make)\n{ROOT}', CUBE, SPHERE),
    (f'(define (make) (bind "x" (lambda () {CUBE})))\n(make)\n{ROOT}', "(make)\n", ""),
    (
        f'(bind (string-append "x" "") (lambda () {CUBE}))\n{ROOT}',
        f'(bind (string-append "x" "") (lambda () {CUBE}))',
        "",
    ),
    (f'(bind "x" (lambda () {SPHERE}))\n(if #t (bind "x" (lambda () {CUBE})) 1)\n{ROOT}', "#t", "#f"),
    (
        f'(bind "x" (lambda () {SPHERE}))\n(define (f) (bind "x" (lambda () {CUBE})))\n(f)\n{ROOT}',
        "(f)\n(bind",
        "(bind",
    ),
]


@pytest.mark.parametrize(("text", "old", "new"), BOUND_BY_CODE)
def test_words_that_are_bound_by_other_code(text: str, old: str, new: str) -> None:
    editing, session = Editing(Session(Options())), Session(Options())
    for version in (text, text.replace(old, new), text):
        source = Source("<test>", version)
        assert observed(editing.evaluate(source)) == observed(session.evaluate(source))


def test_an_edit_of_a_comment_runs_nothing_again() -> None:
    text = '(define (f x) (print "f") x)\n(define unused 2)\n(bind "a" (lambda () (call "cube" :scale (f 2))))\n'
    editing, session = Editing(Session(Options())), Session(Options())
    first = editing.evaluate(Source("a.scene", text))
    for head in ("; more\n\n", "\n", "; unused\n", "; lint: allow-file unused\n"):
        source = Source("a.scene", head + text)
        ours, theirs = editing.evaluate(source), session.evaluate(source)
        assert ours.scene is first.scene
        assert list(map(render_text, ours.diagnostics)) == list(map(render_text, theirs.diagnostics))
        assert (ours.log, ours.steps) == (theirs.log, theirs.steps)
        places = [
            [[span.start for span in entity.call_sites] for entity in descendants(result.require().root)]
            for result in (ours, theirs)
        ]
        assert places[0] == places[1]


def test_files_that_change_beside_the_same_text_are_read_again(tmp_path: Path) -> None:
    mesh, name = tmp_path / "a.obj", str(tmp_path / "a.scene")
    text = '(bind "a" (lambda () (on-top-of (call "cube") (call "mesh" :file "a.obj"))))\n'
    editing = Editing(Session(Options()))
    heights = []
    for size in (1, 2):
        mesh.write_text(f"v 0 0 0\nv {size} 0 0\nv 0 {size} 0\nv 0 0 {size}\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n")
        scene = editing.evaluate(Source(name, text)).scene
        assert scene is not None
        box = entity_box(scene.root)
        assert box is not None
        heights.append(box[4])
    assert heights[1] > heights[0]
    mesh.unlink()
    assert editing.evaluate(Source(name, f"; a comment\n{text}")).scene is None


def test_a_version_whose_analysis_fails_is_none_to_be_equal_to(monkeypatch: pytest.MonkeyPatch) -> None:
    cube, ball = (Source("a.scene", f'(bind "a" (lambda () (call "{word}")))') for word in ("cube", "sphere"))
    session = Session(Options())
    editing = Editing(session)
    editing.evaluate(cube)
    with monkeypatch.context() as patch:
        patch.setattr(Session, "kind_errors", lambda *rest: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            editing.evaluate(ball)
    result = editing.evaluate(ball)
    assert geometry(result.require()) == geometry(session.evaluate(ball).require())


def test_places_are_in_the_text() -> None:
    text = (
        '(define (f x) (guard (e (else (error-place e))) (car x)))\n(print (f 1))\n(bind "a" (lambda () (call "cube")))'
    )
    editing, session = Editing(Session(Options())), Session(Options())
    for version in (text, "\n\n" + text, text + "\n(define (g) (h))"):
        source = Source("<test>", version)
        ours, theirs = editing.evaluate(source), session.evaluate(source)
        assert ours.log == theirs.log
        assert ours.program is not None
        assert theirs.program is not None
        assert ours.program.words == theirs.program.words

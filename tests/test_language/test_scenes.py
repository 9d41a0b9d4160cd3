"""Entities, embeddings, numbers, Z, frames (docs/language.md, sections 4 to 6)."""

from __future__ import annotations

import re

import pytest

from scenelang.interpreter.inspection.numbering import primitive_handles
from scenelang.interpreter.inspection.outline import outline
from scenelang.interpreter.runtime.runtime import ZEntry
from scenelang.interpreter.scene.entity import Entity, count_words
from scenelang.interpreter.scene.flatten import flatten

from .conftest import error, log, refused, run, scene, shown, warned


def handles(program: str, **options: object) -> dict[str, str]:
    """Every instance's handle and word, in order, as `tree` prints them."""
    found: dict[str, str] = {}
    for line in outline(scene(program, **options), None, False, True):
        match = re.search(r"([^\s│├└─]\S*(?: \S+)*?) <(\S+)>", line)
        if match is not None:
            found[match[2]] = match[1]
    return found


# --- the paper's functions -------------------------------------------------------------------------------------------

PROGRAM = '(define c (call "cube" :scale 2)) (define s (call "sphere")) (define m (translate [1 2 3]))'

VALUES = {
    '(entity? c)': "#t", "(entity-word c)": '"cube"', "(entity-children c)": "()", "(primitive? c)": "#t",
    "(car c)": '("cube" . (embedding :scale 2))', "(cdr c)": "()", "(pair? c)": "#f", "(list? c)": "#f",
    "(length (parts c))": "1", "(length (parts (list c (list s (list c)))))": "3", "(length (parts '()))": "0",
    "(length (parts (mutable-list c s)))": "2", "(eq? (car (first (parts c))) c)": "#t", "(cdr (first (parts c)))": "[[1.0 0.0 0.0 0.0] [0.0 1.0 0.0 0.0] [0.0 0.0 1.0 0.0] [0.0 0.0 0.0 1.0]]",
    "(pair? (transform c m))": "#t", "(eq? (car (transform c m)) c)": "#t", "(cdr (transform (transform c m) m))": "[[1.0 0.0 0.0 2.0] [0.0 1.0 0.0 4.0] [0.0 0.0 1.0 6.0] [0.0 0.0 0.0 1.0]]",
    "(length (transform (list c s) m))": "2", "(pair? (first (transform (list c s) m)))": "#t",
    "(length (union c s (list c s)))": "4", "(union)": "()", "(length (union-loop 3 (lambda (i) c)))": "3",
    "(length (union-loop 2 (lambda (i) (union c s))))": "4", "(union-loop 0 (lambda (i) c))": "()",
    "(length (union-loop 3.0 (lambda (i) c)))": "3", "(map-parts (lambda (p) (entity-word (car p))) (list c s))": '("cube" "sphere")',
    "(map-parts (lambda (p) 1) (transform c m))": "1", "(bound? \"w\")": "#f", "((retrieve \"w\") 1 2 3)": "()",
    "(compute-shape-sizes c)": "[2.0 2.0 2.0]", "(compute-shape-center (transform c m))": "[1.0 2.0 3.0]",
    "(compute-shape-min (list c s))": "[-1.0 -1.0 -1.0]", "(compute-shape-max (union c (transform s m)))": "[2.0 3.0 4.0]",
    "(ref (entity-embedding c) :scale)": "2", "(embedding? (entity-embedding s))": "#t", "(eq? (call \"cube\" :scale 2) c)": "#t",
    "(equal? (embedding) (embedding))": "#t", "(embedding-handle <z3>)": '"z3"', '(embedding-text (embedding "a" :b 1))': '"a"',
    "(embedding <z3> \"t\" :a 1)": '(embedding <z3> "t" :a 1)', "(ref (embedding :a 1) :b 7)": "7",
    "(entity-word (primitive \"cube\" :scale 3))": '"cube"',
}  # fmt: skip


@pytest.mark.parametrize("expression", VALUES)
def test_values(expression: str) -> None:
    assert shown(expression, PROGRAM) == VALUES[expression]


REFUSED = {
    "(parts none)": "parts", "(parts 5)": "parts", '(parts "cube")': "parts", "(union c 5)": "parts", "(union #f)": "parts",
    "(transform 5 m)": "parts", "(transform c 5)": "pose", "(transform c [1 2 3])": "pose", "(transform c (eye 3))": "pose",
    "(transform c (translate [inf 0 0]))": "pose", "(union-loop -1.5 (lambda (i) c))": "type", "(union-loop 3 c)": "not-a-procedure",
    "(length c)": "type", "(map (lambda (x) x) c)": "type", '(call "cube" 3)': "embedding", "(call 5)": "word",
    '(call "cube" :scale)': "keyword", '(call "cube" :scale 1 :scale 2)': "keyword", '(call "cube" :scale "x")': "attribute",
    '(call "sphere" :radius [1 2])': "attribute", '(call "cylinder" :p0 3)': "attribute", '(call "cube" :color 3)': "attribute",
    "(frames '())": "frames", "(translate 3)": "type", "(translate [1 2])": "value", "(rotate 1 [0 0 0])": "value",
    "(scale \"x\")": "type", '(bind 5 (lambda () c))': "word", '(bind "w" 5)': "type", "(ref (embedding :a 1) :b)": "key",
    "(choice '(1 2) :p 3)": "value", "(choice '(1 2) :p [[.5 .5]])": "value", "(choice '(1 2) :p '(1 2 3))": "value",
}  # fmt: skip


@pytest.mark.parametrize("expression", REFUSED)
def test_refused(expression: str) -> None:
    program = f"{PROGRAM} {expression}"
    assert refused(program + '(bind "dot" (lambda () (call "cube"))) (scene "dot")') == REFUSED[expression]


def test_a_number_for_a_word_is_hinted_as_an_attribute() -> None:
    hint = error('(bind "tree" (lambda () (call "cube"))) (bind "r" (lambda () (call "tree" 3)))(scene "r")').hint
    assert ":size 3" in str(hint)


def test_a_word_that_returned_nothing_is_no_primitive() -> None:
    assert log(
        '(bind "w" (lambda () (union))) (bind "r" (lambda () (print (primitive? (call "w"))) (union)))(scene "r")'
    ) == ["#f"]


def test_a_program_binds_its_own_cube_on_top_of_the_real_one() -> None:
    made = scene(
        '(bind "cube" (lambda (:scale) (primitive "cube" :scale (* 2 scale)))) (bind "r" (lambda () (call "cube" :scale 3)))'
    )
    assert made.word == "r"
    assert count_words(made.root) == {"r": 1, "cube": 2}


# --- numbers -----------------------------------------------------------------------------------------------------


def test_numbers_run_depth_first_in_pre_order() -> None:
    program = """(bind "a" (lambda () (union (call "b") (call "c"))))
    (bind "b" (lambda () (union (call "d") (call "d")))) (scene "a")"""
    assert handles(program) == {"z1": "a", "z2": "b", "z3": "d", "z4": "d", "z5": "c"}


def test_written_handles_take_no_number() -> None:
    program = '(bind "a" (lambda () (union (call "b" <z3>) (call "c") (call "d") (call "e" <style>)))) (scene "a")'
    assert handles(program) == {"z1": "a", "z3": "b", "z2": "c", "z4": "d", "style": "e"}


def test_shared_entities_have_a_number_for_every_instance() -> None:
    program = (
        '(bind "a" (lambda () (union-loop 3 (lambda (i) (call "b"))))) (bind "b" (lambda () (call "c"))) (scene "a")'
    )
    assert list(handles(program)) == ["z1", "z2", "z3", "z4", "z5", "z6", "z7"]


def test_an_embedding_that_is_passed_on_keeps_its_handle() -> None:
    program = '(bind "a" (lambda (z more) (union (call "b" z) (call "c" (car more)) (call "d")))) (scene "a")'
    made = scene(program)
    assert [part.car.embedding.handle for part in made.root.children] == ["z1", "z2", None]
    assert list(handles(program)) == ["z1", "z2", "z3"]


def test_gamma_of_the_root_has_no_end() -> None:
    for use, expected in (
        ("(first g)", '"z2"'), ("(ref g 3)", '"z5"'), ("(list-ref g 1)", '"z3"'), ("(car (rest g))", '"z3"'),
        ("(car (list-tail g 5))", '"z7"'), ("(last (list-head g 4))", '"z5"'),
    ):  # fmt: skip
        assert log(f'(bind "a" (lambda (z g) (print (embedding-handle {use})) (union)))') == [expected.strip('"')]
    assert log('(bind "a" (lambda (z g) (print (pair? g) (null? g)) (union)))') == ["#t #f"]
    for use in ("(length g)", "(apply list g)", "(map embedding-handle g)", "(reverse g)", "(for ((x g)) x)"):
        found = error(f'(bind "a" (lambda (z g) {use} (union)))')
        assert found.name == "endless", use
        assert "list-head" in str(found.hint)


def test_gamma_of_other_words_is_finite() -> None:
    program = (
        '(bind "b" (lambda (z g) (print (length g)) (union))) (bind "a" (lambda () (call "b" "x" "y" "z"))) (scene "a")'
    )
    assert log(program) == ["2"]


# --- the file Z ----------------------------------------------------------------------------------------------------

BOARD = """
(bind "board" (lambda () (union-loop 64 (lambda (i) (transform (call "square") (translate [i 0 0]))))))
(bind "square" (lambda ((:color [1 1 1]) (:size 1)) (call "cube" :scale size :color color)))
(scene "board")
"""


def cubes(program: str, **options: object) -> list[object]:
    made = scene(program, **options)
    flat = flatten(made)
    frame = flat.frames[0]
    return [frame.primitives[frame.index[i]].embedding.attributes["color"] for i in range(len(frame))]


def test_an_entry_restyles_one_of_64_shared_squares() -> None:
    plain = scene(BOARD)
    made = scene(BOARD, z_entries={"z8": ZEntry(None, {"color": (1.0, 0.0, 0.0)})})
    red = [
        i
        for i, color in enumerate(cubes(BOARD, z_entries={"z8": ZEntry(None, {"color": (1.0, 0.0, 0.0)})}))
        if list(color) == [1, 0, 0]
    ]
    assert red == [3], "z2 is the first square, z3 its cube"
    assert count_words(made.root) == count_words(plain.root)
    assert len({id(part.car) for part in made.root.children}) == 2, "all else stays shared"
    assert list(handles(BOARD)) == list(handles(BOARD, z_entries={"z8": ZEntry(None, {"color": (1.0, 0.0, 0.0)})}))


def test_what_an_entry_does_not_name_stays() -> None:
    program = """(bind "a" (lambda () (call "b" (embedding "old" :m 5))))
    (bind "b" (lambda (z :m (:n 1)) (call (embedding-text z) :m m :n n))) (scene "a")"""

    def leaf(**options: object) -> tuple[str, object]:
        entity = scene(program, **options).root.children[0].car.children[0].car
        return entity.word, entity.embedding.attributes

    assert leaf() == ("old", {"m": 5, "n": 1})
    assert leaf(z_entries={"z2": ZEntry(None, {"n": 2})}) == ("old", {"m": 5, "n": 2})
    assert leaf(z_entries={"z2": ZEntry("new", {})}) == ("new", {"m": 5, "n": 1})


def test_an_entry_for_a_written_handle_is_there_from_the_start() -> None:
    program = '(bind "a" (lambda () (print (ref <z9> :k 0)) (call "b" <z9> :m 1))) (bind "b" (lambda (:m (:k 0)) (print m k) (union))) (scene "a")'
    assert log(program, z_entries={"z9": ZEntry(None, {"k": 7, "m": 8})}) == ["7", "1 7"], "the call's own :name wins"


def test_a_random_instance_keeps_its_draws() -> None:
    program = """
    (bind "row" (lambda () (union-loop 5 (lambda (i) (call "stone" :place i)))))
    (bind "stone" (lambda (:place (:color [1 1 1])) (call "cube" :scale (list (uniform) (py-random) 1) :color color)))
    (scene "row")"""

    def sizes(**options: object) -> list[list[float]]:
        frame = flatten(scene(program, **options)).frames[0]
        return [_numbers(frame.primitives[frame.index[i]]) for i in range(len(frame))]

    plain = sizes()
    assert len({tuple(s) for s in plain}) == 5
    assert sizes(z_entries={"z6": ZEntry(None, {"color": (1.0, 0.0, 0.0)})}) == plain


def _numbers(entity: Entity) -> list[float]:
    pair, out = entity.embedding.attributes["scale"], []
    while hasattr(pair, "car"):
        out.append(pair.car)
        pair = pair.cdr
    return out


def test_the_roots_own_entry() -> None:
    program = '(bind "a" (lambda ((:n 1)) (union-loop n (lambda (i) (call "b"))))) (scene "a")'
    assert len(scene(program, z_entries={"z1": ZEntry(None, {"n": 4})}).root.children) == 4


def test_entries_outermost_first() -> None:
    program = """(bind "a" (lambda () (call "b"))) (bind "b" (lambda ((:n 1)) (union-loop n (lambda (i) (call "c")))))
    (bind "c" (lambda ((:k 0)) (call "cube" :color [k 0 0]))) (scene "a")"""
    entries = {"z3": ZEntry(None, {"k": 1}), "z2": ZEntry(None, {"n": 3})}
    made = scene(program, z_entries=entries)
    assert [list(part.car.children[0].car.embedding.attributes["color"]) for part in made.root.children[0].car.children] == [
        [1, 0, 0], [0, 0, 0], [0, 0, 0],
    ]  # fmt: skip


def test_entries_that_fit_nothing_are_warned_of() -> None:
    for name in ("z99", "style", "z0", "z2x"):
        assert warned('(bind "a" (lambda () (call "b"))) (scene "a")', z_entries={name: ZEntry("x", {})}) == [
            "unused-entry"
        ]


def test_a_call_with_effects_gets_only_the_embedding() -> None:
    program = '(define n 0) (bind "a" (lambda () (union (call "b") (call "b")))) (bind "b" (lambda () (set! n (+ n 1)) (print n) (union))) (scene "a")'
    result = run(program, z_entries={"z2": ZEntry("gold", {})})
    assert [d.name for d in result.diagnostics] == ["embedding-only"]
    assert result.scene is not None
    assert [part.car.embedding.text for part in result.scene.root.children] == ["gold", None]


# --- 4D --------------------------------------------------------------------------------------------------------------

TWO = '(list (call "a") (call "b"))'


@pytest.mark.parametrize(
    ("function", "frames"),
    [
        (f"(lambda () {TWO})", 2),
        (f"(lambda () (frames {TWO}))", 2),
        (f"(lambda (z) (frames {TWO}))", 2),
        (f"(lambda (z) {TWO})", 1),
        ('(lambda () (union (call "a") (call "b")))', 1),
        ('(lambda () (list (transform (call "a") (scale 2)) (transform (call "b") (scale 2))))', 1),
        ('(lambda () (list (union (call "a") (call "b")) (call "b")))', 2),
        ('(lambda () (list (list (call "a")) (list)))', 2),
        ('(lambda () (mutable-list (call "a") (call "b") (call "a")))', 3),
        ('(lambda () (call "a"))', 1),
        ("(lambda () (list))", 1),
        ('(lambda () (frames (for/list ((i 5)) (transform (call "a") (translate [i 0 0])))))', 5),
    ],
)
def test_frames(function: str, frames: int) -> None:
    made = scene(f'(bind "film" {function}) (scene "film")')
    assert (len(made.frames), made.animated) == (frames, frames > 1 or "frames" in function)
    assert all(frame.word == "film" for frame in made.frames)
    assert all(frame.embedding.handle == "z1" for frame in made.frames)


def test_frames_belong_to_the_root() -> None:
    assert (
        refused('(bind "a" (lambda () (frames (list (call "c"))))) (bind "r" (lambda () (call "a"))) (scene "r")')
        == "frames"
    )
    lists = scene('(bind "a" (lambda () (list (call "c") (call "d")))) (bind "r" (lambda (z) (call "a"))) (scene "r")')
    assert len(lists.frames) == 1
    assert refused('(bind "r" (lambda () (frames 5))) (scene "r")') == "type"
    assert refused('(bind "r" (lambda () (frames (list 5)))) (scene "r")') == "parts"


def test_corresponding_entities_of_frames_share_a_number() -> None:
    program = """(bind "film" (lambda () (frames (list (list (call "a") (call "b")) (list (call "a") (call "b") (call "c"))))))
    (bind "a" (lambda () (call "cube"))) (scene "film")"""
    made = scene(program)
    names = primitive_handles(made, flatten(made))
    assert [list(frame) for frame in names] == [["z3", "z4"], ["z3", "z4", "z5"]]


# --- sharing -----------------------------------------------------------------------------------------------------


def shares(body: str, before: str = "", arguments: str = "") -> bool:
    program = f'{before} (bind "w" {body}) (bind "r" (lambda () (union (call "w" {arguments}) (call "w" {arguments})))) (scene "r")'
    first, second = scene(program).root.children
    return first.car is second.car


@pytest.mark.parametrize(
    ("body", "before", "arguments", "shared"),
    [
        ('(lambda () (call "cube"))', "", "", True),
        ('(lambda (:n) (call "cube" :scale n))', "", ":n 2", True),
        ('(lambda () (call "cube" :scale (+ 1 (uniform))))', "", "", False),
        ('(lambda () (call "cube" :scale (+ 1 (py-random))))', "", "", False),
        ("(lambda () (set! n (+ n 1)) (union))", "(define n 0)", "", False),
        ("(lambda () (print n) (union))", "(define n 0) (set! n 1)", "", True),
        ("(lambda () (push! xs 1) (union))", "(define xs (mutable-list))", "", False),
        ("(lambda () (print (length xs)) (union))", "(define xs (mutable-list))", "", True),
        ("(lambda () (define xs (mutable-list)) (push! xs 1) (union))", "", "", True),
        ('(lambda () (define s (default-rng 1)) (call "cube" :scale (+ 1 (uniform :stream s))))', "", "", True),
        ('(lambda () (call "cube" :scale (+ 1 (uniform :stream s))))', "(define s (default-rng 1))", "", False),
        ('(lambda () (guard (e (#t 1)) (uniform) (error "x")) (union))', "", "", False),
        ("(lambda (:t) (print (ref t 1)) (union))", "", ":t (table 1 2)", True),
    ],
)
def test_what_is_shared(body: str, before: str, arguments: str, shared: bool) -> None:
    assert shares(body, before, arguments) is shared


def test_a_shared_call_prints_once() -> None:
    assert log(
        '(bind "w" (lambda () (print "once") (union))) (bind "r" (lambda () (union-loop 5 (lambda (i) (call "w"))))) (scene "r")'
    ) == ["once"]


def test_numbers_are_told_apart_by_type() -> None:
    program = '(bind "w" (lambda (:n) (print n) (union))) (bind "r" (lambda () (union (call "w" :n 1) (call "w" :n 1.0) (call "w" :n 0.0) (call "w" :n -0.0) (call "w" :n #t) (call "w" :n 1)))) (scene "r")'
    assert log(program) == ["1", "1.0", "0.0", "-0.0", "#t"]


def test_a_change_begins_a_new_epoch() -> None:
    program = """(define n 1) (bind "w" (lambda () (print n) (union)))
    (bind "r" (lambda () (call "w") (call "w") (set! n 2) (call "w") (call "w") (union))) (scene "r")"""
    assert log(program) == ["1", "2"]
    bound = """(bind "v" (lambda () (print "old") (union))) (bind "w" (lambda () (call "v")))
    (bind "r" (lambda () (call "w") (bind "v" (lambda () (print "new") (union))) (call "w") (call "w"))) (scene "r")"""
    assert log(bound) == ["old", "new"]


def test_counters_of_calls_count_every_call() -> None:
    program = '(define n 0) (bind "w" (lambda () (set! n (+ n 1)) (union))) (bind "r" (lambda () (for ((i 5)) (call "w")) (print n) (union))) (scene "r")'
    assert log(program) == ["5"]


def test_cost_follows_distinct_calls() -> None:
    program = '(bind "s" (lambda (:n) (if (= n 0) (call "cube") (union-loop 20 (lambda (i) (call "s" :n (- n 1))))))) (scene "s" :n 30)'
    result = run(program)
    assert result.steps < 10_000
    assert result.scene is not None
    assert count_words(result.scene.root)["cube"] == 20**30


# --- warnings of words and geometry --------------------------------------------------------------------------------


def test_warnings() -> None:
    assert warned(
        '(bind "lantern" (lambda () (call "cube"))) (bind "r" (lambda () (union (call "lantern") (call "lantren"))))'
    ) == ["near-word"]
    assert warned('(bind "a" (lambda () (union))) (bind "a" (lambda () (union)))') == ["bound-twice"]
    assert warned('(define _x (call "a")) (bind "a" (lambda () (call "cube")))') == ["undefined-word"]
    assert warned('(define (_f) (call "a")) (bind "a" (lambda () (call "cube")))') == []
    assert warned("(compute-shape-sizes (union))") == ["empty-box"]
    assert warned('(bind "a" (lambda () (call "sphere" :radius 0)))') == ["no-extent"]
    assert warned('(for ((x (set "a" "b"))) x)') == ["set-order"]
    assert warned("(for ((x (set 1 2))) x)") == []

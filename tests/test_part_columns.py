"""Many parts are columns: programs behave as with pairs, to the last bit, step and place of an error."""

from __future__ import annotations

import math
from array import array
from random import Random
from typing import Any

import pytest
from differential import checked, observed, published
from fuzz.scene_programs import Programs
from support import evaluate, peak_bytes

import scenelang as sl
from scenelang.interpreter.compile import calls
from scenelang.interpreter.runtime import parts
from scenelang.interpreter.scene import part_columns
from scenelang.interpreter.scene.entity import Entity, count_words, primitive_count
from scenelang.interpreter.scene.part_columns import PartColumns
from scenelang.interpreter.values.values import ANONYMOUS, IDENTITY, Matrix, Pair

PIECE = '(transform (call "cube") (translate [i (/ i 7) -0.]))'
PROGRAMS = {
    "a loop": f'(bind "w" (lambda () (union-loop 9 (lambda (i) {PIECE})))) (call "w")',
    "entities": '(bind "w" (lambda () (union-loop 9 (lambda (i) (call "cube" :scale (+ 1 (% i 3))))))) (call "w")',
    "lists": f'(bind "w" (lambda () (union-loop 4 (lambda (i) (union {PIECE} (call "sphere"))))))',
    "rows of rows": f"""
(bind "w" (lambda ()
  (union-loop 4 (lambda (k) (transform (union-loop 5 (lambda (i) {PIECE})) (rotate k [0 1 0]))))))""",
    "comprehensions": f"""
(bind "w" (lambda () (for/union ((i 6)) {PIECE})))
(bind "v" (lambda () (for*/union ((i 6) (j 3) :when (odd? (+ i j))) (transform (call "w") (translate [0 j i])))))
(call "v") (call "w")""",
    "read": f"""
(define row (union-loop 9 (lambda (i) {PIECE})))
(length row) (length row) (car row) (list-ref row 7) (cdr (cdr row)) (reverse row) (for/list ((p row)) (cdr p))
(eq? row row) (equal? row (union-loop 9 (lambda (i) {PIECE}))) (append row row) (parts row) (null? row) (list? row)
(bind "w" (lambda () row))""",
    "kept": f"""
(define row (union-loop 9 (lambda (i) {PIECE})))
(bind "w" (lambda () (union row (call "sphere") row)))
(bind "v" (lambda () (list row (transform row (scale 2)) (transform row (@ (translate [1 2 3]) (rotate 2 [1 1 0]))))))
(call "w") (call "v") (length row)""",
    "something else among the parts": f"""
(bind "w" (lambda () (union-loop 9 (lambda (i) (print i) (if (= i 5) 5 {PIECE})))))
(bind "v" (lambda () (for/union ((i 9)) (print i) (if (= i 5) 5 {PIECE}))))
(bind "u" (lambda () (union (union-loop 9 (lambda (i) {PIECE})) (if (> (random) 2) (union) #t))))
(guard (e (#t e)) (call "w")) (guard (e (#t e)) (call "v")) (guard (e (#t e)) (call "u"))
(union-loop 9 (lambda (i) (if (= i 5) (list (list (call "cube")) (cons (call "cube") (eye 4))) {PIECE})))""",
    "an infinite pose": f"""
(bind "w" (lambda () (transform (union-loop 9 (lambda (i) {PIECE})) (scale 1e308))))
(bind "v" (lambda () (transform (call "w") (scale 1e308))))
(guard (e (#t e)) (transform (union-loop 9 (lambda (i) {PIECE})) (scale 1e308)))
(guard (e (#t e)) (transform (transform (union-loop 9 (lambda (i) {PIECE})) (scale 1e300)) (scale 1e300)))""",
    "frames": f'(bind "w" (lambda () (for/list ((t 3)) (union-loop 5 (lambda (i) {PIECE}))))) (scene "w")',
    "one frame": f'(bind "w" (lambda () (list (union-loop 5 (lambda (i) {PIECE}))))) (scene "w")',
    "random": """
(bind "w" (lambda () (union-loop 9 (lambda (i) (transform (call "cube" :scale (uniform 1 2)) (translate [(random) 0 0]))))))
(bind "v" (lambda () (union (call "w") (call "w")))) (call "v") (scene "v")""",
    "solids": f"""
(bind "w" (lambda () (solid-union (union-loop 4 (lambda (i) (transform (call "cube") (translate [(/ i 2) 0 0])))))))
(compute-shape-max (union-loop 5 (lambda (i) {PIECE}))) (primitives (union-loop 5 (lambda (i) {PIECE})))""",
    "rebound": """
(bind "w" (lambda () (union-loop 5 (lambda (i) (transform (call "peg") (translate [i 0 0]))))))
(call "w")
(bind "peg" (lambda () (call "cylinder")))
(call "w")""",
    "retrieved": f"""
(bind "w" (lambda () (let ((n 6)) (if (> n 5) (union-loop n (lambda (i) {PIECE})) (union)))))
(call "w")
(define w (retrieve "w"))
(list (length (w)) (car (w)) (map cdr (w)) (append (w) (w)))
(bind "v" (lambda () (union (w) (call "w")))) (call "v") (w)
(bind "w" w) (call "w") (w)""",
    "applied": f"""
(bind "w" (lambda (z gamma) (for/union ((i 6)) {PIECE})))
(define (parts-of-w) (apply-entity-function (retrieve "w") (embedding "a") (list)))
(call "w" (embedding "a"))
(length (parts-of-w)) (parts-of-w) (eq? (parts-of-w) (parts-of-w)) (call "w" (embedding "a"))
(bind "v" (lambda () (union (parts-of-w) (transform (parts-of-w) (scale 2))))) (call "v")""",
    "retrieved in its own body": f"""
(define depth 0)
(bind "w" (lambda ()
  (set! depth (+ depth 1))
  (if (< depth 3) (print (length ((retrieve "w")))))
  (union (union-loop 6 (lambda (i) {PIECE})) (call "sphere"))))
(call "w")""",
    "retrieved of a function that is compiled again": f"""
(define (make)
  (guard (e (#t e)) (bind "w" (lambda () (union-loop 6 (lambda (i) {PIECE}))))))
(make)
(define row (retrieve "w"))
(for ((k 9)) (make))
(list (list? (row)) (length (row)) (equal? (row) (row)) (map cdr (row)))
(for ((k 9)) (row)) (row)
(call "w")""",
    "bodies": f"""
(bind "w" (lambda ((:n 4))
  (define row (union-loop n (lambda (i) {PIECE})))
  (cond ((= n 1) (union)) ((= n 2) (call "sphere")) ((= n 3) row)
        ((= n 4) (transform row (scale 2))) ((= n 5) (union row row)) (else (for/union ((p row)) p)))))
(for/list ((n 8)) (call "w" :n n)) (scene "w" :n 5)""",
    "inner functions": f"""
(bind "w" (lambda ()
  (define (row n) (union-loop n (lambda (i) {PIECE})))
  (define rows (map row '(2 3 4)))
  (print (map length rows))
  (union (row 5) rows (union-loop 4 (lambda (k) (let ((r (row k))) (if (odd? k) r (transform r (scale 2)))))))))
(call "w")""",
    "a broken loop": f"""
(define seen 0)
(bind "w" (lambda () (for/union ((i 99) :break (> i 6)) (set! seen i) {PIECE}))) (call "w") seen""",
}


def both(monkeypatch: pytest.MonkeyPatch, text: str, few: int, steps: int = 20_000, hot: int | None = 2) -> list[Any]:
    """What is observed of a program with columns of ``few`` parts or more, and with pairs alone."""
    program = checked(text)
    assert program is not None, text
    seen = []
    for fewest in (few, 1 << 40):
        monkeypatch.setattr(calls, "MIN_COLUMNS", min(fewest, 1 << 20))
        monkeypatch.setattr(parts, "MIN_COLUMNS", fewest)
        seen.append(observed(program, hot, steps))
    return seen


@pytest.mark.parametrize("hot", [None, 1, 2])
@pytest.mark.parametrize("few", [1, 2, 3])
@pytest.mark.parametrize("name", PROGRAMS)
def test_programs(monkeypatch: pytest.MonkeyPatch, name: str, few: int, hot: int | None) -> None:
    columns, pairs = both(monkeypatch, PROGRAMS[name], few, hot=hot)
    assert columns == pairs


@pytest.mark.parametrize("steps", range(20, 420, 13))
def test_the_same_step_is_the_last(monkeypatch: pytest.MonkeyPatch, steps: int) -> None:
    columns, pairs = both(monkeypatch, PROGRAMS["kept"], 2, steps)
    assert columns == pairs


def test_the_place_of_a_translation_that_fails() -> None:
    text = '(define (f x)\n (translate\n  [1.5 x 2]))\n(for ((k 9)) (f k))\n(f (expt 10 400)) (bind "w" (lambda () (call "cube")))'
    program = checked(text)
    assert program is not None
    assert observed(program, None) == observed(program, 2)


@pytest.mark.parametrize("count", [200, 254, 255, 256, 257, 511, 512, 513, 767, 768, 1_100])
def test_long_lists_cost_the_same_steps(monkeypatch: pytest.MonkeyPatch, count: int) -> None:
    text = (
        f'(bind "w" (lambda () (union-loop {count} (lambda (i) {PIECE})))) (call "w") (transform (call "w") (scale 2))'
    )
    columns, pairs = both(monkeypatch, text, 100)
    assert columns == pairs


@pytest.mark.parametrize("first", range(0, 60, 20))
@pytest.mark.sampled(2)
def test_random_programs(monkeypatch: pytest.MonkeyPatch, first: int) -> None:
    for seed in range(first, first + 20):
        text = Programs(seed).program()
        if checked(text) is not None:
            columns, pairs = both(monkeypatch, text, 1 + seed % 3)
            assert columns == pairs, f"seed {seed}"


@pytest.mark.sampled(12)
@pytest.mark.parametrize("number", range(len(published())))
def test_published_programs(monkeypatch: pytest.MonkeyPatch, number: int) -> None:
    text = published()[number]
    if checked(text) is not None:
        columns, pairs = both(monkeypatch, text, 2, 300_000)
        assert columns == pairs


def columns_of(count: int, seed: int = 1) -> tuple[list[Pair], PartColumns]:
    """Parts of three entities in poses of all sizes and signs of zero, as pairs and as columns."""
    pick = Random(seed)
    numbers = (0.0, -0.0, 1.0, -1.0, 1e-310, 3.7, -1e200, math.pi)
    entities = [Entity(word, ANONYMOUS, ()) for word in ("a", "b", "c")]
    pairs = [Pair(pick.choice(entities), Matrix([pick.choice(numbers) for _ in range(12)])) for _ in range(count)]
    return pairs, PartColumns.of(pairs)


def bits(sequence: Any) -> list[Any]:
    return [(part.car.word, array("d", part.cdr).tobytes()) for part in sequence]


def test_a_sequence() -> None:
    pairs, columns = columns_of(40)
    assert bits(columns) == bits(pairs)
    assert len(columns) == 40
    assert bits([columns[0], columns[-1], columns[17]]) == bits([pairs[0], pairs[-1], pairs[17]])
    assert bits(columns[3:9]) == bits(pairs[3:9])
    assert bits(reversed(columns)) == bits(reversed(pairs))
    assert bits((*columns, *columns[:2])) == bits((*pairs, *pairs[:2]))
    for index in (40, -41):
        with pytest.raises(IndexError):
            columns[index]


@pytest.mark.parametrize("count", [1, 7, 300])
def test_products_are_equal_with_and_without_numpy(monkeypatch: pytest.MonkeyPatch, count: int) -> None:
    _, columns = columns_of(count)
    pose = Matrix([0.3, -0.0, 2.0, 1e10, 0.1, 0.7, -3.0, -0.0, 1e-5, 0.9, 0.2, 7.0])
    rows = columns.moved(pose)
    monkeypatch.setattr(part_columns, "_MIN_ARRAY", 0)
    arrays = columns.moved(pose)
    assert rows is not None
    assert arrays is not None
    assert rows.poses.tobytes() == arrays.poses.tobytes()


@pytest.mark.parametrize("fewest", [0, 10**9])
def test_a_product_that_overflows(monkeypatch: pytest.MonkeyPatch, fewest: int) -> None:
    monkeypatch.setattr(part_columns, "_MIN_ARRAY", fewest)
    columns = PartColumns.of([Pair(Entity("a", ANONYMOUS, ()), IDENTITY)] * 3)
    assert columns.moved([1e308, *IDENTITY[1:]]) is not None
    assert columns.moved([math.inf, *IDENTITY[1:]]) is None
    large = PartColumns.of([Pair(Entity("a", ANONYMOUS, ()), Matrix([9e307] * 12))] * 3)  # whose sum overflows
    assert large.moved(IDENTITY) is not None


LOOP = '(bind "w" (lambda () (union (call "sphere") (union-loop 3000 (lambda (i) {})))))'.format(
    '(transform (call (if (odd? i) "cube" "lid") <h> :color [.1 .2 .3]) (translate [i 0 0]))'
)


def test_a_scene_of_columns_is_that_of_pairs(monkeypatch: pytest.MonkeyPatch) -> None:
    columns = evaluate(LOOP)
    monkeypatch.setattr(calls, "MIN_COLUMNS", 1 << 20)
    monkeypatch.setattr(parts, "MIN_COLUMNS", 1 << 20)
    pairs = evaluate(LOOP)
    assert type(columns.root.children) is PartColumns
    assert type(pairs.root.children) is tuple
    assert primitive_count(columns.root) == primitive_count(pairs.root) == 3001
    assert count_words(columns.root) == count_words(pairs.root)


def test_the_facade_of_a_scene_of_columns(monkeypatch: pytest.MonkeyPatch) -> None:
    columns = sl.evaluate(LOOP)
    monkeypatch.setattr(calls, "MIN_COLUMNS", 1 << 20)
    monkeypatch.setattr(parts, "MIN_COLUMNS", 1 << 20)
    pairs = sl.evaluate(LOOP)
    one, two = columns.flatten(), pairs.flatten()
    assert one.matrix.tobytes() == two.matrix.tobytes()
    assert one.color.tobytes() == two.color.tobytes()
    assert list(one.handle) == list(two.handle)
    assert list(one.path) == list(two.path)
    assert columns.to_json() == pairs.to_json()
    assert columns.bounds.tolist() == pairs.bounds.tolist()
    assert columns.count() == pairs.count()
    assert columns.tree() == pairs.tree()
    assert columns.part("w/cube[7]").root.word == pairs.part("w/cube[7]").root.word


def test_a_part_of_a_loop_takes_little_memory() -> None:
    text = f'(bind "w" (lambda () (union-loop 40000 (lambda (i) {PIECE}))))'
    evaluate(text)
    assert peak_bytes(lambda: evaluate(text)) < 40_000 * 150  # 360 bytes as pairs


def test_calls_of_literals_record_each_place_once() -> None:
    scene = evaluate("""
(bind "w" (lambda () (union
  (union-loop 5 (lambda (i) (union (call "cube") (call  "cube"))))
  (union-loop 5 (lambda (i) (call   "cube"))))))""")
    sites = [site.text for site in scene.root.children[0].car.call_sites]
    assert sites == ['(call "cube")', '(call  "cube")', '(call   "cube")']


def words_below(scene: Any) -> list[list[str]]:
    return [[part.car.word for part in peg.car.children] for peg in scene.root.children]


def test_a_word_that_is_bound_after_calls_of_its_primitive() -> None:
    scene = evaluate("""
(define (piece i)
  (if (= i 3) (bind "peg" (lambda () (call "cylinder"))))
  (if (= i 6) (bind "peg" (lambda () (call "sphere"))))
  (call "peg"))
(bind "w" (lambda () (for/union ((i 9)) (transform (piece i) (translate [i 0 0])))))""")
    assert words_below(scene) == [[]] * 3 + [["cylinder"]] * 3 + [["sphere"]] * 3


def test_a_shared_call_ends_with_the_binding_of_its_primitive() -> None:
    scene = evaluate("""
(bind "row" (lambda () (union-loop 400 (lambda (i) (transform (call "peg") (translate [i 0 0]))))))
(define before (call "row"))
(bind "peg" (lambda () (call "cylinder")))
(bind "w" (lambda () (union before (call "row"))))""")
    before, after = (row.car.children[0].car for row in scene.root.children)
    assert before.is_primitive
    assert [part.car.word for part in after.children] == ["cylinder"]

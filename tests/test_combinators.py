"""The combinators of the standard library, by the boxes and counts of what they make."""

from __future__ import annotations

import pytest

from scenelang import Diagnostic, Evaluated, Options, Session, Source
from scenelang.grammar.diagnostics import render_text
from scenelang.interpreter.scene.bounds import parts_box
from scenelang.stdlib.reference import ReferenceRecord, combinators

NAMES = ["grid", "ring", "row", "stack", "mirror", "on-top-of", "align", "attach", "along", "scatter-on", "jitter",
         "scatter"]  # fmt: skip
CUBE = '(call "cube")'
BALL = '(call "sphere")'
Boxes = list[tuple[float, ...]]


def run(expression: str, seed: int = 0) -> Evaluated:
    text = f'(bind "test" (lambda () {expression}))'
    return Session(Options(seed=seed)).evaluate(Source("<test>", text))


def boxes(expression: str, seed: int = 0) -> Boxes:
    """The box of every part that the expression makes."""
    result = run(expression, seed)
    assert [render_text(d) for d in result.diagnostics] == []
    assert result.scene is not None
    found = [parts_box([part]) for part in result.scene.root.children]
    return [box for box in found if box is not None]


def whole(expression: str, seed: int = 0) -> tuple[float, ...]:
    every = boxes(expression, seed)
    return (*(min(b[i] for b in every) for i in range(3)), *(max(b[i] for b in every) for i in range(3, 6)))


def center(box: tuple[float, ...]) -> tuple[float, ...]:
    return tuple((box[i] + box[i + 3]) / 2 for i in range(3))


def problem(expression: str) -> Diagnostic:
    result = run(expression)
    assert result.scene is None
    (error,) = (d for d in result.diagnostics if d.is_error)
    return error


# --- documentation ---------------------------------------------------------------------------------------------------


def test_all_are_there_and_documented() -> None:
    assert [record.name for record in combinators()] == NAMES


@pytest.mark.parametrize("record", combinators(), ids=lambda record: record.name)
def test_examples_print_what_they_say(record: ReferenceRecord) -> None:
    assert record.examples
    for example in record.examples:
        result = run(f"(print (list {example.expression})) {CUBE}")
        assert result.log == (f"({example.value})",), [render_text(d) for d in result.diagnostics]


@pytest.mark.parametrize("record", combinators(), ids=lambda record: record.name)
def test_docs_name_every_keyword(record: ReferenceRecord) -> None:
    keywords = {word.strip("()").partition("::")[0] for word in record.signature.split() if word.startswith("(:")}
    assert [keyword for keyword in sorted(keywords) if f"`{keyword}" not in record.doc] == []


# --- grid and ring ---------------------------------------------------------------------------------------------------


def test_grid_is_centered() -> None:
    assert whole(f"(grid {CUBE} :nx 3 :ny 2 :nz 4 :spacing [2 3 4])") == (-2.5, -2, -6.5, 2.5, 2, 6.5)
    assert len(boxes(f"(grid {CUBE} :nx 3 :ny 2 :nz 4)")) == 24
    assert boxes(f"(grid {CUBE})") == [(-0.5, -0.5, -0.5, 0.5, 0.5, 0.5)]
    assert whole(f"(grid {CUBE} :nx 2 :nz 2 :spacing 3)") == (-2, -0.5, -2, 2, 0.5, 2)


def test_grid_calls_a_function_with_its_indices() -> None:
    found = boxes('(grid (lambda (i j k) (call "cube" :scale (+ 1 i (* 2 k)))) :nx 2 :nz 2 :spacing 10)')
    assert [box[3] - box[0] for box in found] == [1, 2, 3, 4]
    assert [center(box)[0] for box in found] == [-5, 5, -5, 5]
    assert [center(box)[2] for box in found] == [-5, -5, 5, 5]


def test_grid_of_nothing() -> None:
    assert boxes(f"(grid {CUBE} :nx 0)") == []
    assert boxes("(grid (union) :nx 3)") == []


def test_grid_copies_are_shared() -> None:
    result = run(f"(grid {CUBE} :nx 5)")
    assert result.scene is not None
    assert len({id(part.car) for part in result.scene.root.children}) == 1


def test_ring_turns_its_copies_outwards() -> None:
    found = boxes('(ring 4 (call "cube" :scale [1 1 .2]) :radius 3)')
    places = [(0, 0, 3), (3, 0, 0), (0, 0, -3), (-3, 0, 0)]
    for box, place in zip(found, places):
        assert center(box) == pytest.approx(place, abs=1e-9)
    assert found[1][3] - found[1][0] == pytest.approx(0.2)
    assert found[1][5] - found[1][2] == pytest.approx(1)


def test_ring_keeps_orientation_and_sweep() -> None:
    found = boxes('(ring 4 (call "cube" :scale [1 1 .2]) :radius 3 :turn #f)')
    assert all(box[3] - box[0] == pytest.approx(1) for box in found)
    half = boxes(f"(ring 2 {CUBE} :radius 2 :start (/ pi 2) :sweep pi)")
    assert center(half[0]) == pytest.approx((2, 0, 0), abs=1e-9)
    assert center(half[1]) == pytest.approx((0, 0, -2), abs=1e-9)
    sizes = [box[4] - box[1] for box in boxes('(ring 3 (lambda (i) (call "cube" :scale (+ i 1))))')]
    assert sizes == pytest.approx([1, 2, 3])


# --- row and stack ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("axis", "k"), [("x", 0), ("y", 1), ("z", 2)])
def test_row_is_centered_with_gaps(axis: str, k: int) -> None:
    found = boxes(f"(row (list {CUBE} {BALL} {CUBE}) :gap .5 :axis :{axis})")
    assert [box[k] for box in found] == pytest.approx([-2.5, -1, 1.5])
    assert [box[k + 3] for box in found] == pytest.approx([-1.5, 1, 2.5])
    across = (k + 1) % 3
    assert [center(box)[across] for box in found] == [0, 0, 0]


def test_row_takes_parts_as_one_thing_and_skips_empty_ones() -> None:
    pair = f"(list {CUBE} (transform {CUBE} (translate [0 3 0])))"
    found = boxes(f"(row (list {pair} (union) {CUBE}))")
    assert [box[0] for box in found] == [-1, -1, 0]
    assert [box[1] for box in found] == [-0.5, 2.5, -0.5]
    assert boxes("(row '())") == []
    assert boxes("(row (list (union) '()))") == []


def test_stack_piles_up() -> None:
    found = boxes(f"(stack (list {CUBE} {BALL} (union) {CUBE}) :gap .25)")
    assert [box[1] for box in found] == pytest.approx([-0.5, 0.75, 3])
    assert [box[4] for box in found] == pytest.approx([0.5, 2.75, 4])


def test_stack_leaves_the_first_where_it_is() -> None:
    lifted = f"(transform {CUBE} (translate [7 2 0]))"
    found = boxes(f"(stack (list {lifted} {CUBE}))")
    assert found == [(6.5, 1.5, -0.5, 7.5, 2.5, 0.5), (-0.5, 2.5, -0.5, 0.5, 3.5, 0.5)]
    along = boxes(f"(stack (list {CUBE} {CUBE}) :axis :z)")
    assert [box[2] for box in along] == [-0.5, 0.5]
    assert boxes("(stack '())") == []


def test_stack_uses_exact_boxes() -> None:
    tilted = f"(transform {BALL} (@ (rotate .7 [0 0 1]) (scale [2 1 1])))"
    found = boxes(f"(stack (list {tilted} {CUBE}))")
    assert found[1][1] == pytest.approx(found[0][4])


def test_stack_of_arrays() -> None:
    result = run(f"(print (stack (list [1 2] [3 4])) (stack (list [1 2] [3 4]) :axis 1)) {CUBE}")
    assert result.log == ("[[1 2] [3 4]] [[1 3] [2 4]]",)


# --- mirror, on-top-of, align, attach --------------------------------------------------------------------------------


def test_mirror() -> None:
    thing = f"(transform {CUBE} (translate [3 0 0]))"
    assert boxes(f"(mirror {thing})") == [(2.5, -0.5, -0.5, 3.5, 0.5, 0.5), (-3.5, -0.5, -0.5, -2.5, 0.5, 0.5)]
    assert boxes(f"(mirror {thing} :at 1 :keep #f)") == [(-1.5, -0.5, -0.5, -0.5, 0.5, 0.5)]
    assert center(boxes(f"(mirror {CUBE} :axis :z :at 2 :keep #f)")[0]) == (0, 0, 4)
    assert boxes("(mirror (union))") == []


def test_on_top_of() -> None:
    base = '(transform (call "cube" :scale [4 2 6]) (translate [10 0 5]))'
    (found,) = boxes(f"(on-top-of {BALL} {base} :gap .5)")
    assert found == pytest.approx((9, 1.5, 4, 11, 3.5, 6))
    assert boxes(f"(on-top-of (union) {base})") == []


@pytest.mark.parametrize(
    ("how", "low"), [("min", -1), ("max", 0), ("center", -0.5), ("before", -2), ("after", 1)]
)  # fmt: skip
def test_align(how: str, low: float) -> None:
    thing = f"(transform {CUBE} (translate [20 30 40]))"
    (found,) = boxes(f"(align {thing} {BALL} :x :{how})")
    assert found == pytest.approx((low, 29.5, 39.5, low + 1, 30.5, 40.5))
    (found,) = boxes(f"(align {thing} {BALL} :y :{how} :z :{how})")
    assert found[1:3] == pytest.approx((low, low))


def test_align_of_nothing_named() -> None:
    assert boxes(f"(align {CUBE} {BALL})") == [(-0.5, -0.5, -0.5, 0.5, 0.5, 0.5)]
    assert boxes(f"(align (union) {BALL} :x :min)") == []


def test_attach_joins_faces() -> None:
    (found,) = boxes(f"(attach {CUBE} {BALL} :at [-1 0 0])")
    assert found == pytest.approx((-2, -0.5, -0.5, -1, 0.5, 0.5))
    (found,) = boxes(f"(attach {CUBE} {BALL} :at [1 1 1] :from [1 1 1] :offset [0 .5 0])")
    assert found == pytest.approx((0, 0.5, 0, 1, 1.5, 1))
    (found,) = boxes(f"(attach {CUBE} {BALL})")
    assert found[1] == pytest.approx(1)
    assert boxes(f"(attach (union) {BALL})") == []


# --- jitter and scatter ----------------------------------------------------------------------------------------------


def test_jitter_stays_within_its_bounds() -> None:
    still = boxes(f"(grid {CUBE} :nx 20 :spacing 3)")
    moved = boxes(f"(jitter (grid {CUBE} :nx 20 :spacing 3) :move [.3 0 .1])")
    shifts = [[b - a for a, b in zip(center(x), center(y))] for x, y in zip(still, moved)]
    assert all(abs(x) <= 0.3 and abs(y) < 1e-9 and abs(z) <= 0.1 for x, y, z in shifts)
    assert len({round(x, 9) for x, _, _ in shifts}) == 20


def test_jitter_scales_and_turns_about_the_foot() -> None:
    found = boxes(f"(jitter (grid {CUBE} :nx 20 :spacing 3) :scale .5 :turn 1)")
    assert all(box[1] == pytest.approx(-0.5) for box in found)
    heights = [box[4] - box[1] for box in found]
    assert 0.5 <= min(heights) < 0.8
    assert 1.2 < max(heights) <= 1.5
    assert any(box[3] - box[0] > 1.2 * (box[4] - box[1]) for box in found)


def test_jitter_draws_the_same_whatever_it_does() -> None:
    place = f"(grid {CUBE} :nx 3 :spacing 3)"
    assert boxes(f"(jitter {place} :move 1)")[2] == pytest.approx(boxes(f"(jitter {place} :move 1 :axis [1 0 0])")[2])
    first = run(f"(jitter {place}) (print (random)) {CUBE}").log
    second = run(f"(jitter {place} :move 1 :turn 2 :scale .1) (print (random)) {CUBE}").log
    assert first == second
    assert boxes("(jitter (union) :move 1)") == []


def test_scatter_keeps_apart() -> None:
    found = boxes(f"(scatter 30 {BALL} :size [20 0 30] :apart 2)")
    centers = [center(box) for box in found]
    assert len(centers) == 30
    assert all(abs(x) <= 10 and abs(y) < 1e-9 and abs(z) <= 15 for x, y, z in centers)
    for i, a in enumerate(centers):
        for b in centers[:i]:
            assert sum((p - q) ** 2 for p, q in zip(a, b)) >= 2**2 - 1e-9


def test_scatter_follows_the_seed_and_streams() -> None:
    program = f"(scatter 5 {CUBE} :size 8)"
    assert boxes(program) == boxes(program)
    assert boxes(program, seed=1) != boxes(program)
    own = f"(scatter 5 {CUBE} :size 8 :stream (random-stream 3))"
    assert boxes(own, seed=1) == boxes(own)


def test_scatter_turns_and_functions() -> None:
    upright = boxes(f"(scatter 6 {CUBE} :turn 0)")
    assert all(box[3] - box[0] == pytest.approx(1) for box in upright)
    turned = boxes(f"(scatter 6 {CUBE})")
    assert any(box[3] - box[0] > 1.05 for box in turned)
    sizes = [box[4] - box[1] for box in boxes('(scatter 3 (lambda (i) (call "cube" :scale (+ i 1))))')]
    assert sizes == pytest.approx([1, 2, 3])
    assert boxes(f"(scatter 0 {CUBE})") == []


# --- mistakes --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("expression", "name", "words"),
    [
        (f'(ring "a" {CUBE})', "type", "`count` of `ring` expects an Integer"),
        (f"(ring {CUBE} 3)", "type", "swapped"),
        ("(ring 3 3)", "type", "an Integer: 3"),
        (f"(grid {CUBE} :nx -1)", "value", "-1"),
        (f"(grid {CUBE} :spacing [1 2])", "type", "one number or three"),
        (f"(row {CUBE})", "type", "expects a list of entities"),
        (f"(row (list {CUBE}) :axis 'x)", "type", "`:x`, `:y` or `:z`"),
        ("(stack (list 1 2))", "parts", "(list 1 2)"),
        (f"(align {CUBE} {BALL} :x :left)", "type", "`:min`, `:center`, `:max`, `:before` or `:after`"),
        (f"(mirror {CUBE} :axes :x)", "keyword", "axes"),
        (f"(attach {CUBE} {BALL} :at [1 0])", "type", "three numbers"),
        (f"(scatter 100 {CUBE} :size 1 :apart 1)", "user", "of 100 copies"),
        ("(jitter 3)", "type", "an Integer: 3"),
        (f"(on-top-of 3 {CUBE})", "type", "an Integer: 3"),
    ],
)
def test_mistakes_are_named(expression: str, name: str, words: str) -> None:
    error = problem(expression)
    assert error.name == name
    assert words in error.message

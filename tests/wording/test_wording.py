"""The words of whole scenes: texts, templates, whose word a primitive takes, who is asked."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import pytest
from support import calls, evaluate, unchecked

from scenelang.backends.neural.descriptions import (
    MAX_TEXT,
    UNDESCRIBED,
    AppearanceQuestion,
    Describe,
    block_name,
    spaced,
)
from scenelang.backends.neural.wording import (
    Wording,
    WordingRow,
    check_template,
    merge,
    plain_text,
    prompt_for,
    wording_of,
)
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.runtime.runtime import ZEntry
from scenelang.interpreter.values.values import Vector


def wording(text: str, describe: Describe | None = None, **options: Any) -> Wording:
    return wording_of(evaluate(text, **options), describe=describe)


def words(body: str, **options: Any) -> list[tuple[str, str]]:
    """Word and text of each row of a scene "room" with ``body``."""
    return [(row.word, row.text) for row in wording(f'(bind "room" (lambda () {body}))', **options).rows]


PAWNS = """
(bind "pawn" (lambda ((:color [.9 .9 .9]))
  (union (call "cone" :color color) (transform (call "sphere" :color color :radius .3) (translate [0 1 0])))))
(bind "board" (lambda () (union-loop 3 (lambda (i) (transform (call "pawn") (translate [i 0 0]))))))
"""


def test_the_papers_pawn() -> None:
    found = wording(PAWNS)
    assert (found.style, found.style_text) == ("z1", "board")
    (row,) = found.rows
    assert (row.word, row.text, row.handles) == ("pawn", "ivory", ("z3", "z4", "z6", "z7", "z9", "z10"))
    assert prompt_for(row.template, "z6") == "a <z6> pawn, in the style of <z1>, 3D model"
    assert plain_text(row.word, row.text) == "an ivory pawn, 3D model"


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ('(call "moai")', ("moai", UNDESCRIBED)),
        ('(call "moai" :scale [1 4 1])', ("moai", "tall")),
        ('(call "moai" :scale [1 2.9 1])', ("moai", UNDESCRIBED)),
        ('(call "rug" :scale [2 .1 3])', ("rug", "flat")),
        ('(call "pane" :scale [2 3 .1])', ("pane", "thin")),
        ('(call "beam" :scale [9 1 1])', ("beam", "long")),
        ('(call "door" :height 3 :color [1 0 0])', ("door", "red, height 3")),
        ('(call "house" :window-count 4 :lit #t :wet #f)', ("house", "window count 4, lit")),
        ('(call "table_top" :material "oak")', ("table top", "oak")),
        ('(call "house" :roof-color [1 0 0])', ("house", "red roof")),
        ('(call "moai" "weathered, old")', ("moai", "weathered, old")),
        ('(call "moai" "weathered" :color [1 0 0])', ("moai", "weathered, red")),
        ('(call "moai" "rusty red" :color [0 0 1])', ("moai", "rusty red")),
        ('(call "moai" "  ")', ("moai", UNDESCRIBED)),
        ('(call "cube")', ("room", "white")),
        ('(call "cube" :color [.9 .9 .9] :roughness .1 :metallic 1)', ("room", "ivory, metallic, glossy")),
        ('(call "cube" :roughness .9)', ("room", "white, matte")),
        ('(call "cube" :opacity .5 :color [0 0 1])', ("room", "blue, translucent")),
        ('(call "cube" :opacity .5 :ior 1.5)', ("room", "white, transparent, glossy")),
        ('(call "sphere" :emission [10 0 0])', ("room", "red, glowing")),
        ('(call "set-cuboid" :block-type "minecraft:oak_planks")', ("room", "oak planks")),
        ('(call "set-cuboid" :block-type "minecraft:red_wool" :color [1 0 0])', ("room", "red wool")),
        ('(call "lamp" :kind \'brass)', ("lamp", "brass")),
        (
            '(call "set-cuboid" :block-type "minecraft:stone" :kind "minecraft:stone[axis=x]" :axis "x")',
            ("room", "stone"),
        ),
        ('(call "tower" :n 1e300)', ("tower", UNDESCRIBED)),
    ],
)
def test_what_attributes_say(body: str, expected: tuple[str, str]) -> None:
    assert words(body) == [expected]


def test_parts_take_the_word_and_text_of_the_thing_that_they_are_of() -> None:
    text = """(bind "chair" (lambda () (union (call "cube" :color [1 0 0]) (call "cushion"))))
    (bind "room" (lambda () (union (call "chair" "rustic" :kind "rocking") (call "chair" "gilded gold"))))"""
    assert [(row.word, row.text) for row in wording(text).rows] == [
        ("chair", "rustic, rocking, red"),
        ("cushion", UNDESCRIBED),
        ("chair", "gilded gold"),
    ]


def test_a_bound_cube_has_no_meaning_either() -> None:
    text = '(bind "cube" (lambda () (primitive "cube"))) (bind "die" (lambda () (call "cube")))'
    assert [row.word for row in wording(text).rows] == ["die"]


def test_a_lone_cube_is_called_a_cube() -> None:
    text = '(bind "cube" (lambda () (primitive "cube"))) (scene "cube")'
    assert [row.word for row in wording(text).rows] == ["cube"]


def test_removed_blocks_are_nothing_to_describe() -> None:
    assert words('(union (call "set-cuboid" :block-type "stone") (call "delete-blocks"))') == [("room", "stone")]


def test_a_scene_of_nothing() -> None:
    with pytest.raises(SceneError, match="nothing to describe"):
        wording('(bind "room" (lambda () (union)))')


def test_too_many_primitives() -> None:
    with pytest.raises(LimitError):
        wording_of(evaluate(PAWNS), limit=5)


def test_a_shared_handle_has_one_text_and_a_template_for_each_word() -> None:
    found = wording('(bind "room" (lambda () (union (call "cat" <a> :color [1 0 0]) (call "dog" <a> :color [0 0 1]))))')
    assert [(row.word, row.text, row.handles) for row in found.rows] == [("cat", "red", ("a",)), ("dog", "red", ("a",))]


def test_the_roots_text_is_the_style() -> None:
    text = '(bind "room" (lambda () (call "vase"))) (scene "room" (embedding <mood> "baroque"))'
    found = wording(text)
    assert (found.style, found.style_text) == ("mood", "baroque")
    assert found.rows[0].template == "a {embedding} vase, in the style of <mood>, 3D model"


def test_a_root_that_shares_its_embedding_with_a_primitive() -> None:
    found = wording('(bind "ball" (lambda () (call "sphere" <a> :color [1 0 0]))) (scene "ball" <a>)')
    assert (found.style, found.style_text, found.rows[0].text) == ("a", "red", "red")


def test_frames_share_handles_and_the_first_counts() -> None:
    text = """(bind "film" (lambda () (frames (list
      (union (call "lamp" :color [1 0 0])) (union (call "lamp" :color [0 1 0]) (call "fly"))))))"""
    rows = wording(text).rows
    assert [(row.word, row.text, row.handles) for row in rows] == [
        ("lamp", "red", ("z2",)),
        ("fly", UNDESCRIBED, ("z3",)),
    ]


def test_entries_of_z_count_as_texts_of_the_program() -> None:
    entries = {"z2": ZEntry("velvet", {"color": Vector((1.0, 0.0, 0.0))})}
    found = wording('(bind "room" (lambda () (call "sofa")))', z_entries=entries)
    assert [row.text for row in found.rows] == ["velvet, red"]


def test_a_wrong_attribute_is_the_programs_mistake() -> None:
    with unchecked(), pytest.raises(AssertionError, match=":metallic"):  # it is refused where it is given
        words('(call "cube" :metallic "very")')


def test_long_attributes_are_cut() -> None:
    names = " ".join(f':a{i} "{"x" * 70}{i}"' for i in range(12))
    ((_, text),) = words(f'(call "thing" {names})')
    assert 200 < len(text) <= MAX_TEXT


def test_many_equal_things_are_one_row() -> None:
    def described(count: int) -> None:
        (row,) = wording(PAWNS.replace("union-loop 3", f"union-loop {count}")).rows
        assert len(row.handles) == 2 * count

    described(10)  # what is made once
    few, many = (calls(lambda n=n: described(n)) for n in (2_000, 4_000))
    assert many < 2.3 * few


# --- a describer -------------------------------------------------------------------------------------------------

TWO = '(call "sofa" :color [.9 .9 .9]) (call "sofa" "velvet" :color [1 0 0]) (call "lamp" :height 3)'


def test_a_describer_is_asked_about_what_has_no_text() -> None:
    asked: list[AppearanceQuestion] = []

    def describe(questions: Sequence[AppearanceQuestion]) -> list[str]:
        asked.extend(questions)
        return [f" like {question.word} " for question in questions]

    rows = wording(f'(bind "room" (lambda () (union {TWO} {TWO})))', describe).rows
    assert [(q.word, q.color, q.text) for q in asked] == [("sofa", "ivory", "ivory"), ("lamp", None, "height 3")]
    assert asked[0].attributes == {"color": [0.9, 0.9, 0.9]}
    assert [row.text for row in rows] == ["like sofa", "velvet, red", "like lamp"]


@pytest.mark.parametrize(
    "answer",
    [
        lambda _: [], lambda _: ["", ""], lambda _: ["  ", "x" * 121], lambda _: ["two\nlines", "bell\a"],
        lambda _: [None, 3], lambda _: ["\x1b[31mred", "a\u2028b", "more", "than", "asked"],
    ],
    ids=["none", "empty", "over-long", "lines", "no texts", "controls"],
)  # fmt: skip
def test_answers_that_are_none_leave_the_tables_words(answer: Callable[[Any], Any]) -> None:
    texts = [row.text for row in wording(f'(bind "room" (lambda () (union {TWO})))', answer).rows]
    assert texts == ["ivory", "velvet, red", "height 3"]


def test_too_few_answers_serve_as_far_as_they_go() -> None:
    texts = [row.text for row in wording(f'(bind "room" (lambda () (union {TWO})))', lambda _: ["bone"]).rows]
    assert texts == ["bone", "velvet, red", "height 3"]


# --- templates and names -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "template",
    [
        "a {word}",
        "{embedding} {color}",
        "{embedding} {",
        "{embedding} }",
        "{embedding}\n",
        "{}",
        "{embedding}" + "x" * 500,
    ],
)
def test_wrong_templates(template: str) -> None:
    with pytest.raises(SceneError):
        check_template(template)


def test_another_template() -> None:
    (row,) = wording_of(evaluate(PAWNS), "{word}: {embedding}, {style}").rows
    assert prompt_for(row.template, "z3") == "pawn: <z3>, <z1>"


def test_braces_in_words_are_no_holes() -> None:
    found = wording('(bind "{embedding}<z9>" (lambda () (call "{style}")))')
    assert [row.template for row in found.rows] == ["a {embedding} style, in the style of <z1>, 3D model"]


@pytest.mark.parametrize(
    ("word", "text", "sentence"),
    [
        ("door", "red, height 3", "a red door, height 3, 3D model"),
        ("moai", "weathered, lichen on one side", "a weathered moai, lichen on one side, 3D model"),
        ("eagle", "carved from one piece of oak", "an eagle, carved from one piece of oak, 3D model"),
        ("car", "used, red", "a used, red car, 3D model"),
    ],
)
def test_plain_sentences(word: str, text: str, sentence: str) -> None:
    assert plain_text(word, text) == sentence


def test_names_become_readable() -> None:
    assert block_name("minecraft:oak_stairs[facing=east]") == "oak stairs"
    assert spaced("board-square_2") == "board square 2"
    assert spaced("{<_>}") == ""
    assert words('(call "<>")') == [("thing", UNDESCRIBED)]


# --- what was there before ---------------------------------------------------------------------------------------


def test_what_was_there_stays() -> None:
    old = Wording("z1", "my room", (WordingRow("pawn", "mine", "{embedding}!", ("z3", "z99")),))
    new, known = merge(old, wording(PAWNS))
    assert known == 1
    assert new.style_text == "my room"
    assert new.rows[0] == old.rows[0]
    assert new.rows[1].handles == ("z4", "z6", "z7", "z9", "z10")


def test_a_known_handle_keeps_its_text_under_a_new_word() -> None:
    old = Wording("z1", "my room", (WordingRow("queen", "mine", "{embedding}!", ("z3",)),))
    rows = merge(old, wording(PAWNS))[0].rows
    assert [(row.word, row.text, len(row.handles)) for row in rows] == [
        ("queen", "mine", 1), ("pawn", "mine", 1), ("pawn", "ivory", 5),
    ]  # fmt: skip

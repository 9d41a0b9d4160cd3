"""Declarations about scenes without geometry, without extent, of blocks, of films and of extreme sizes: no internal
error, whatever the relation says about them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import suppress

import pytest

from scenelang import Session, Source
from scenelang.backends.geometry.acceptance import undecided
from scenelang.grammar.datum import ListDatum
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.reader import read
from scenelang.interpreter.scene.declarations import OBJECT, RELATIONS, Relation
from scenelang.session.checking import Examination

WORDS = ("b", "c", "d")


def scene(*bodies: str, root: str = '(union (call "b") (call "c") (transform (call "d") (translate [3 0 0])))') -> str:
    binds = "".join(f'(bind "{word}" (lambda () {body}))\n' for word, body in zip(WORDS, bodies, strict=False))
    return f'(bind "a" (lambda () {root}))\n{binds}'


SCENES = {
    "empty": scene("(union)", "(union)", "(union)"),
    "one is empty": scene("(union)", '(call "cube")', '(call "cube")'),
    "flat and invisible": scene(
        '(transform (call "cube") (scale [1 0 1]))', '(call "cube" :scale [0 0 0])', '(call "sphere" :opacity 0)'
    ),
    "words": scene(),
    "blocks": scene(
        '(call "set-cuboid" :block-type "stone")', '(call "delete-blocks")', '(call "set-cuboid" :block-type "air")'
    ),
    "film": scene(
        '(call "cube")', '(call "sphere")', "(union)",
        root='(frames (list (union (call "b")) (union) (union (call "c") (call "d"))))',
    ),
    "extreme": scene(
        '(call "cube" :scale 1e100)', '(call "cube")', '(call "cube")',
        root='(union (call "b") (transform (call "c") (translate [1e300 0 0])) (transform (call "d") (scale 1e-200)))',
    ),
}  # fmt: skip


def declarations(relation: Relation) -> Iterator[str]:
    """An example with the words of the scenes, the same with its words exchanged, of one word, and negated."""
    form = read(Source("example", relation.example)).forms[0]
    assert isinstance(form, ListDatum)
    strings = [item.span.text for item in form.items if item.span.text.startswith('"')]
    count = len(strings) if relation.is_open else relation.operands.count(OBJECT)
    named = {old: f'"{word}"' for old, word in zip(strings[:count], WORDS, strict=False)}
    text = re.sub(r'"[^"]+"', lambda match: named.get(match[0], match[0]), relation.example)
    yield text
    yield text.replace('"b"', '"?"').replace('"c"', '"b"').replace('"?"', '"c"')
    yield re.sub(r'"[bcd]"', '"a"', text)
    yield f"{text[:-1]} :never #t)"


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("relation", RELATIONS)
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_no_internal_error(relation: str, name: str) -> None:
    tested = 0
    for text in declarations(RELATIONS[relation]):
        source = Source("a.scene", f"{SCENES[name]}(assert-that {text})\n")
        Examination(Session(), run=True).of(source)
        scene = Session().evaluate(source).scene
        if scene is not None:
            tested += 1
            with suppress(SceneError):
                undecided(scene, scene.declarations)
    assert tested

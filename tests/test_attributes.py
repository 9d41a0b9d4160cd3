"""What is said of primitives and their attributes is what they read."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from support import evaluate

from scenelang.backends.surfaces.appearance import MATERIALS, look_of
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.scene.primitives import (
    PHYSICS,
    all_primitives,
    attributes_read,
    docs_of_attributes,
    docs_of_words,
    shape_of,
    words,
)
from scenelang.reference.primer import attribute_doc, attribute_names, attributes_of

DOCS = Path(__file__).parents[1] / "docs"
OTHER = {
    "scale": 3.0,
    "radius": 3.0,
    "tube": 0.4,
    "p0": (1.0, 2.0, 3.0),
    "p1": (4.0, 2.0, 3.0),
    "color": (0.1, 0.2, 0.3),
    "file": "a.glb",
}
GEOMETRIC = [(word, name) for word in (*words(), "chair") for name in attributes_of(word) if name in OTHER]


@pytest.mark.parametrize(("word", "name"), GEOMETRIC)
def test_what_a_primitive_is_said_to_read_changes_it(word: str, name: str) -> None:
    assert shape_of(word, {name: OTHER[name]}) != shape_of(word, {})


@pytest.mark.parametrize("word", [*words(), "chair"])
def test_what_a_primitive_reads_is_said(word: str) -> None:
    assert set(shape_of(word, {}).defining_attributes()) <= set(attributes_of(word))
    unread = {name: value for name, value in OTHER.items() if name not in attributes_of(word)}
    if word != "delete-blocks":  # a color is taken, and there is nothing to show it
        assert shape_of(word, unread) == shape_of(word, {})


@pytest.mark.parametrize("name", MATERIALS)
def test_every_attribute_of_the_material_changes_the_look(name: str) -> None:
    value: Any = {"ior": 1.5, "material": '"oak"', "texture": '"brick"'}.get(name, 0.25)
    assert look_of(_cube(f":{name} {value}")) != look_of(_cube(""))


def _cube(attributes: str) -> Entity:
    scene = evaluate(f'(bind "a" (lambda () (call "cube" {attributes})))')
    cube = scene.root.children[0].car
    assert isinstance(cube, Entity)
    return cube


def test_docs_of_attributes() -> None:
    assert tuple(docs_of_words()) == words()
    assert all(
        each.doc and attribute.doc and attribute.type for each in all_primitives() for attribute in each.attributes
    )
    meanings = docs_of_attributes()
    assert {name for word in words() for name in attributes_read(word)} == set(meanings)
    assert attribute_doc("cube", "radius") is None
    assert attribute_doc("cube", "size") is attribute_doc(None, "size") is None
    assert attribute_doc("delete-blocks", "opacity") is None
    assert attribute_doc("chair", "scale") == attribute_doc(None, "scale") == meanings["scale"]
    assert attribute_doc("sphere", "ior") == MATERIALS["ior"]
    assert set(attribute_names()) == {*meanings, *MATERIALS, *(each.name for each in PHYSICS)}


def test_the_page_on_pictures_has_the_same_attributes() -> None:
    section = (DOCS / "pictures.md").read_text("utf-8").split("## Materials")[1].split("##")[0]
    assert set(re.findall(r"^\| `:([\w-]+)", section, re.M)) == {"color", *MATERIALS}


def test_the_page_on_the_language_has_the_same_primitives() -> None:
    rows = re.findall(r'^\| `"([\w-]+)"` \| (.*?) \|', (DOCS / "language.md").read_text("utf-8"), re.M)
    for word, attributes in rows:
        assert {*re.findall(r":([a-z][\w-]*)", attributes)} == {*attributes_read(word)} - {"color"}
    assert {word for word, _ in rows} == set(words())

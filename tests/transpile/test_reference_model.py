"""The model of the reference implementation reproduces the golden files of the corpus and of the programs here."""

from __future__ import annotations

from pathlib import Path

import pytest
from corpus.compare import compare

from transpile.reference_model import extract, find_root, flatten, load_golden

HERE = Path(__file__).parent
RESPONSES = sorted((HERE / "responses").glob("*.txt"))
PROGRAMS = sorted((HERE / "programs").glob("*.txt"))


@pytest.mark.parametrize("path", RESPONSES, ids=lambda p: p.stem)
@pytest.mark.sampled(3)
def test_response_gives_its_golden(path: Path) -> None:
    golden = load_golden(HERE / "golden", path.stem)
    scene = flatten(extract(path.read_text()))
    assert (scene["kind"], scene["root"]) == (golden["kind"], golden["root"])
    assert compare(scene, golden)["equal"]


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda p: p.stem)
@pytest.mark.sampled(6)
def test_program_gives_its_golden(path: Path) -> None:
    golden = load_golden(HERE / "golden_programs", path.stem)
    scene = flatten(extract(path.read_text()))
    assert (scene["kind"], scene["root"]) == (golden["kind"], golden["root"])
    assert compare(scene, golden)["equal"]


def test_fence_rule() -> None:
    assert extract("a\n```python\nx = 1\n```\nb\n```python\ny = 2\n```\n") == "x = 1\n"
    assert extract("x = 1\n") == "x = 1\n"
    assert extract("```python\nx = 1\n") == "x = 1\n"


def test_root_rules() -> None:
    assert find_root({"a": set(), "b": {"a"}, "c": {"b"}}) == "c"
    assert find_root({"top": {"a", "b"}, "a": set(), "b": {"a"}}) == "top"
    assert find_root({"a": set(), "b": {"a"}, "c": {"a"}, "unused": set()}) == "c"
    assert find_root({"a": set(), "b": set()}) == "b"
    assert find_root({"tree": {"tree"}}) == "tree"


def test_random_streams_are_left_alone() -> None:
    import random

    random.seed(5)
    expected = random.random()
    random.seed(5)
    flatten(
        "from helper import *\n@register()\ndef f():\n    return primitive_call('cube', {'scale': random.random()})\n"
    )
    assert random.random() == expected

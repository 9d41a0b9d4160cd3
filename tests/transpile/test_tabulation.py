"""Data that Python computes by what does not translate becomes constants and tables; what makes shapes is translated."""

from __future__ import annotations

import pytest

from scenelang.grammar.datum import Source
from scenelang.session.session import Session
from transpile.cases import first_difference, flattened, told
from transpile.reference_model import flatten

SESSION = Session()
HEAD = """import json, re, zlib, random
from dataclasses import dataclass
from fractions import Fraction
from helper import *

def box(x, y=0.0):
    return transform_shape(primitive_call('cube'), translation_matrix((x, y, 0)))

class Part:  # a class with a hook does not translate
    def __init_subclass__(cls):
        pass

class Beam(Part):
    def __init__(self, size):
        self.size = size
    def half(self):
        return self.size / 2

def code(text):
    return zlib.crc32(text.encode()) % 10
"""
ROOT = "\n@register()\ndef root(n: int = 4, size: float = 1.0) -> Shape:\n"


def translated(before: str, body: str) -> str:
    """Return the program, after a comparison of its scene with CPython's; no function that makes shapes is evaluated."""
    python = HEAD + before + ROOT + body
    translation = SESSION.transpile(Source("data.py", python))
    assert translation.ok, told(translation.diagnostics)
    assert "Evaluated from Python" not in translation.text
    scene = SESSION.evaluate(Source("data.scene", translation.text)).scene
    assert scene is not None
    assert first_difference(flattened(scene), flatten(python)) is None
    return translation.text


CASES = {
    "a constant at the top": (
        "ROWS = json.loads('[[1, 2], [3, 4]]')\n",
        "    return concat_shapes(*[box(x * size, y) for x, y in ROWS])",
        ["(define rows '((1 2) (3 4)))", "size"],
    ),
    "a part of an expression": ("", "    return box(code('ab') * size, n)", ["size", "n"]),
    "a pattern that is no data": (
        "PATTERN = re.compile(r'(\\w)=(\\d+)')\n",
        "    return concat_shapes(*[box(int(v), size) for k, v in PATTERN.findall('a=1 b=22')])",
        ["""'(("a" "1") ("b" "22"))"""],
    ),
    "statements": (
        "",
        "    total = 0\n    for letter in 'abc':\n        total += code(letter)\n    return box(total, size)",
        ["(define total"],
    ),
    "a loop over objects": (
        "def beams():\n    return [Beam(1.5), Beam(2.0), Beam(4.0)]\n",
        "    return concat_shapes(*[box(b.half(), size) for b in beams()])",
        ["(range 3)"],
    ),
    "a table by a parameter": (
        "def seed_of(k):\n    return code(str(k))\n\n@register()\ndef stone(k: int = 1, h: float = 1.0) -> Shape:\n"
        "    return box(seed_of(k), h)\n",
        "    return concat_shapes(*[library_call('stone', k=i, h=size) for i in range(n)])",
        [":h", "(table"],
    ),
    "objects of a data class": (
        "@dataclass\nclass Spot:\n    x: float\n    y: float = 0.0\n\n"
        "def spots():\n    return [Spot(code(c), i) for i, c in enumerate('abc')]\n",
        "    return concat_shapes(*[box(s.x, s.y * size) for s in spots()])",
        ["(spot "],
    ),
    "computed numbers as keys": (
        "def odd(x):\n    return code(f'{x:.3f}')\n",
        "    return concat_shapes(*[box(odd(x), size) for x in [0.1 * i for i in range(4)]])",
        ["(round "],
    ),
    "a fraction": (
        "",
        "    return concat_shapes(*[box(p * 2, size) for p in (Fraction(1, 3), Fraction(2, 3))])",
        ["0.333"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_data_is_written_down(name: str) -> None:
    before, body, texts = CASES[name]
    text = translated(before, body)
    for each in texts:
        assert each in text


STONE = """
def weight(k):
    return code(str(k))

@register()
def stone(k: int = 7, h: float = 1.0) -> Shape:
    return box(weight(k), h)
"""
STONES = "    return concat_shapes(library_call('stone', k=2, h=size), library_call('stone', k=3))"


def called(text: str, call: str) -> str | None:
    """Return the error of a call of a word, None if there is none."""
    result = SESSION.evaluate(Source("data.scene", text.replace('(scene "root")', f"(scene {call})")))
    return None if result.scene is not None else told(result.diagnostics)


def test_other_values_are_errors_with_the_line() -> None:
    text = translated(STONE, STONES)
    assert called(text, '"stone" :k 3 :h 9.5') is None
    assert called(text, '"stone"') is None  # the default, which the scene does not use
    line = (HEAD + STONE).split("\n").index("    return box(weight(k), h)") + 1
    assert f"line {line} of the Python" in (called(text, '"stone" :k 4') or "")


def test_a_parameter_with_these_values_only_is_told() -> None:
    translation = SESSION.transpile(Source("data.py", HEAD + STONE + ROOT + STONES))
    warnings = told(translation.diagnostics)
    assert "`k` of `stone` has only the values" in warnings
    assert "`h` of" not in warnings


@pytest.mark.parametrize(
    ("before", "body"),
    [
        # What is not the same whenever it is evaluated.
        ("LOG = []\ndef note(x):\n    LOG.append(x)\n    return code(str(len(LOG)))\n",
         "    return concat_shapes(box(note(1)), box(note(1)))"),
        ("", "    items = iter([Beam(1.0), Beam(2.0)])\n"
         "    return concat_shapes(*[box(next(items).size) for i in range(2)])"),
        # Data that the program changes.
        ("def row():\n    return [code('a'), code('b')]\n",
         "    r = row()\n    r.append(n)\n"
         "    return concat_shapes(*[box(x, i) for i, x in enumerate(r)], box(len(row()), 9))"),
        # Random numbers that are drawn.
        ("def jump():\n    return random.random() + code('a')\n",
         "    return concat_shapes(*[box(jump()) for _ in range(3)])"),
    ],
)  # fmt: skip
def test_what_is_no_data_gives_the_scene_of_cpython(before: str, body: str) -> None:
    python = HEAD + before + ROOT + body
    result = SESSION.evaluate(Source("data.py", python))
    assert result.scene is not None, told(result.diagnostics)
    assert first_difference(flattened(result.scene), flatten(python)) is None
    text = SESSION.transpile(Source("data.py", python)).text
    scene = SESSION.evaluate(Source("data.scene", text))
    assert scene.scene is not None, told(scene.diagnostics)
    assert first_difference(flattened(scene.scene), flatten(python)) is None


def test_an_iteration_more_is_no_silent_repetition() -> None:
    """With one turn, `next` gives one value; it must not become a constant for all turns."""
    body = (
        "    items = iter([Beam(1.0), Beam(2.0)])\n    return concat_shapes(*[box(next(items).size) for i in range(n)])"
    )
    python = HEAD + ROOT.replace("= 4", "= 1") + body
    text = SESSION.transpile(Source("data.py", python)).text
    text = text.replace("(param n 1", "(param n 2").replace('(scene "root")', '(scene "root" :n 2)')
    result = SESSION.evaluate(Source("data.scene", text))
    if result.scene is not None:
        assert first_difference(flattened(result.scene), flatten(python.replace("n: int = 1", "n: int = 2"))) is None


def test_seeds_and_cached_properties_change_no_data() -> None:
    before = """from functools import cached_property
class Row:
    def __init__(self, text): self.text = text
    @cached_property
    def size(self): return code(self.text)
ROWS = [Row('a'), Row('bc')]
"""
    body = "    random.seed(3)\n    return concat_shapes(*[box(r.size, random.random()) for r in ROWS + ROWS])"
    assert "Evaluated from Python" not in translated(before, body)

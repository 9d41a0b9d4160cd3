"""Loops, functions and conditions of evaluated Python remain, and give the geometry that CPython gives."""

from __future__ import annotations

import contextlib
import io
import os

import pytest
from searching import many

from scenelang.grammar.datum import Source
from scenelang.session.session import Session
from transpile.cases import first_difference, flattened, told
from transpile.loop_generator import LoopPrograms
from transpile.reference_model import flatten

PROGRAMS = int(os.environ.get("SCENELANG_EXAMPLES", many(40)))  # by hand: 5,000
START = int(os.environ.get("SCENELANG_SEED", "0"))
SESSION = Session()
HEAD = """
from dataclasses import dataclass
from enum import Enum
import itertools
import random
from helper import *

class Kind(Enum):
    LOW = 1
    HIGH = 2

@dataclass
class Leg:
    x: float
    height: float
    def top(self):
        return self.height * 2

LEGS = [Leg(0, 1), Leg(1, 1.5), Leg(2.5, 2)]

class Part:  # a class with a hook that makes shapes is evaluated, and with it what uses it
    def __init_subclass__(cls):
        pass

class Block(Part):
    def shape(self):
        return primitive_call("cube")

def cube(x, y=0.0):
    return transform_shape(Block().shape(), translation_matrix((x, y, Kind.LOW.value - 1)))

@register()
def scene() -> Shape:
    parts = []
"""


def translated(body: str) -> str:
    """Return the program of a function body, after a comparison of its scene with CPython's."""
    code = (
        HEAD + "\n".join(f"    {line}" for line in body.strip().splitlines()) + "\n    return concat_shapes(*parts)\n"
    )
    translation = SESSION.transpile(Source("loops.py", code))
    assert translation.ok, told(translation.diagnostics)
    evaluated = SESSION.evaluate(Source("loops.scene", translation.text))
    assert evaluated.scene is not None, told(evaluated.diagnostics)
    with contextlib.redirect_stdout(io.StringIO()):
        assert first_difference(flattened(evaluated.scene), flatten(code)) is None, translation.text
    return translation.text


@pytest.mark.parametrize(
    ("body", "texts"),
    [
        ("for leg in LEGS:\n    parts.append(cube(leg.x, leg.top()))", ["(* height 2)", "(x height)"]),
        ("for i in range(9):\n    parts.append(cube(i * i, Kind.HIGH.value))", ["((i (range 9)))", "(* i i)"]),
        ("parts += [cube(i * i / Kind.HIGH.value) for i in range(7)]", ["((i (range 7)))", "(* i i)"]),
        ("parts.append(loop(5, lambda i: cube(i ** 3, LEGS[0].top())))", ["((i (range 5)))", "(expt i 3)"]),
        (
            "for i in range(6):\n    if i * i > 7:\n        parts.append(cube(i, LEGS[0].x))\n"
            "    else:\n        parts.append(cube(-i, 1))",
            ["((i (range 6)))", "(> (* i i) 7)"],
        ),
        ("y = LEGS[0].x\nfor leg in LEGS:\n    parts.append(cube(y))\n    y += leg.height\nparts.append(cube(y, 9))", ["4.5"]),
        (
            "for i in range(8):\n    if i % 3 == 1:\n        continue\n    parts.append(cube(i * i))",
            [":unless (= (% i 3) 1)"],
        ),
        (
            "for i in range(6):\n    match i:\n        case 1 | 3:\n            parts.append(cube(i * i))\n"
            "        case 2:\n            parts.append(cube(0, i))\n        case _:\n            parts.append(cube(-i))",
            ["for/union ((i (range 6)))", "(* i i)"],
        ),
        (
            "for kind in [Kind.LOW, Kind.HIGH, Kind.LOW]:\n    match kind:\n        case Kind.LOW:\n"
            "            parts.append(cube(1))\n        case Kind.HIGH:\n            parts.append(cube(2, 2))",
            ["for/union"],
        ),
        ("for leg in LEGS:\n    parts.append(cube(random.random(), leg.x))", ["for/union", "(py-random)"]),
        (
            "for i in range(3):\n    row = []\n    for leg in LEGS:\n        row.append(cube(leg.x * i, i))\n"
            "    parts.append(concat_shapes(*row))",
            ["(i (range 3))", "(* x i)"],
        ),
    ],
)  # fmt: skip
def test_what_remains(body: str, texts: list[str]) -> None:
    text = translated(body)
    assert [each for each in texts if each not in text] == [], text


@pytest.mark.parametrize(
    "body",
    [
        "seen = set()\nfor i in range(5):\n    seen.add(i % 2)\n    parts.append(cube(len(seen)))",
        "for leg in LEGS:\n    leg.x += 1\n    parts.append(cube(leg.x))",
        "for i in range(4):\n    parts.append(cube(i))\nparts.append(cube(len(parts), LEGS[0].x))",
        "turns = iter(LEGS)\nfor i in range(2):\n    parts.append(cube(next(turns).x))\nparts.append(cube(next(turns).x))",
        "for i in range(4):\n    parts.append(cube(i, LEGS[0].x))\nparts.append(cube(i))",
        "for i, leg in enumerate(LEGS):\n    parts.append(cube([5, 6, 7][i] if leg is LEGS[1] else 0))",
        "last = LEGS[0]\nfor leg in LEGS:\n    parts.append(cube(last.x, leg.x))\n    last = leg",
        "for i in range(4):\n    try:\n        parts.append(cube([1, 2][i], LEGS[0].x))\n    except IndexError:\n        pass",
        "try:\n    for i in range(3):\n        parts.append(cube(1 / (i - 2), LEGS[0].x))\nexcept ZeroDivisionError:\n    pass",
        "for i in range(4):\n    parts.insert(0, cube(i, LEGS[0].x))",
        "names = []\nfor leg in LEGS:\n    names.append(leg.height)\n    parts.append(cube(sum(names)))",
        "for kind in Kind:\n    parts.append(cube(kind.value, len(kind.name)))",
        "for leg in LEGS:\n    top = compute_shape_max(concat_shapes(cube(0), *parts))[1]\n    parts.append(cube(leg.x, top))",
        "for leg in LEGS:\n    parts.append(transform_shape(concat_shapes(cube(0), *parts), translation_matrix((leg.x, 1, 0))))",
        "def all_of():\n    return concat_shapes(cube(9), *parts)\nfor leg in LEGS:\n    parts.append(cube(leg.x))\n    parts.append(all_of())",
        "y = 0\nfor r in (leg.x + y for leg in LEGS):\n    parts.append(cube(r))\n    y += 10",
        "y = 0\nfor r in map(lambda leg: leg.x + y, LEGS):\n    parts.append(cube(r))\n    y += 10",
        "tick = itertools.count(5).__next__\nfor leg in LEGS:\n    parts.append(cube(tick(), leg.x))",
        "take = [1, 2, 3].pop\nfor leg in LEGS:\n    parts.append(cube(take(), leg.x))",
        "roll = random.Random(11).uniform\nfor leg in LEGS:\n    parts.append(cube(roll(0, 1), leg.x))",
        "class Look(Enum):\n    LOW = 1\n    BIG = 2\nfor kind in Kind:\n    for look in Look:\n        if kind != look:\n            parts.append(cube(look.value, kind.value))",
        "class Bag:\n    n = 0\n    def __getitem__(self, k):\n        self.n += 1\n        if k > 2:\n            raise IndexError\n        return k\nbag = Bag()\nfor v in bag:\n    parts.append(cube(v, bag.n))",
        "for kind in reversed(Kind):\n    parts.append(cube(kind.value))",
        "queue = [3, 2]\ndef take():\n    while queue:\n        yield queue.pop(0)\nfor r in take():\n    parts.append(cube(r))\n    if r > 1:\n        queue.append(r - 1)",
        "for value_0, value_1, value_2 in [(1, 2, 3), (4, 5, 6)]:\n    parts.append(cube(value_0 * value_1, value_0 * value_1 + value_2))",
        "for flag in [True, False, 2]:\n    parts.append(cube(flag + 1, LEGS[0].x))",
    ],
)
def test_what_is_unrolled_gives_the_same_scene(body: str) -> None:
    translated(body)


@pytest.mark.parametrize(
    "body",
    [
        "for leg in LEGS:\n    for t in range(3):\n        yield cube(leg.x, t * Kind.HIGH.value)",
        "for leg in LEGS:\n    yield cube(leg.x)\n    yield cube(leg.x, Kind.HIGH.value)",
        "frames = []\nfor leg in LEGS:\n    for t in range(2):\n        frames.append(cube(leg.x, t * Kind.HIGH.value))\nreturn frames",
        "frames = []\nfor leg in LEGS:\n    frames.append(cube(leg.x))\n    frames.append(cube(Kind.HIGH.value))\nreturn frames",
        "frames = []\nfor leg in LEGS:\n    frames.extend([cube(leg.x), cube(leg.x, Kind.HIGH.value)])\nreturn frames",
        "frames = []\nfor leg in LEGS:\n    if leg.x > 0:\n        frames.append(cube(leg.x, Kind.HIGH.value))\nreturn frames",
        "return [cube(leg.x, t * Kind.HIGH.value) for leg in LEGS for t in range(2)]",
        "parts = []\nfor leg in LEGS:\n    parts.append(cube(leg.x, Kind.HIGH.value))\n    yield concat_shapes(*parts)",
    ],
)
def test_frames(body: str) -> None:
    lines = "\n".join(f"    {line}" for line in body.splitlines())
    head = HEAD[: HEAD.index("@register()")]
    code = f"{head}@register_animation()\ndef scene() -> Generator[Shape, None, None]:\n{lines}\n"
    translation = SESSION.transpile(Source("frames.py", code))
    assert translation.ok, told(translation.diagnostics)
    evaluated = SESSION.evaluate(Source("frames.scene", translation.text))
    assert evaluated.scene is not None, told(evaluated.diagnostics)
    assert first_difference(flattened(evaluated.scene), flatten(code)) is None, translation.text


@pytest.mark.parametrize("value", ["i % 2", "i % Kind.HIGH.value"])
def test_words_may_be_computed(value: str) -> None:
    code = HEAD + (
        f"    return concat_shapes(*[library_call(f'leg_{{{value}}}') for i in range(4)])\n\n"
        "@register()\ndef leg_0() -> Shape:\n    return cube(Kind.HIGH.value)\n\n"
        "@register()\ndef leg_1() -> Shape:\n    return primitive_call('sphere')\n"
    )
    translation = SESSION.transpile(Source("words.py", code))
    evaluated = SESSION.evaluate(Source("words.scene", translation.text))
    assert evaluated.scene is not None, told(evaluated.diagnostics)
    assert first_difference(flattened(evaluated.scene), flatten(code)) is None, translation.text


def test_functions_are_not_specialised_for_numbers() -> None:
    code = HEAD + (
        "    for leg in LEGS:\n        parts.append(library_call('post', height=leg.top(), at=(leg.x, 1)))\n"
        "    return concat_shapes(*parts)\n\n@register()\ndef post(height: float, at=(0, 0)) -> Shape:\n"
        "    return cube(at[0], height * Kind.HIGH.value + at[1])\n"
    )
    translation = SESSION.transpile(Source("functions.py", code))
    assert "(* height 2)" in translation.text
    assert "(cond" not in translation.text


def test_random_programs() -> None:
    for seed in range(START, START + PROGRAMS):
        code = LoopPrograms(seed).program()
        translation = SESSION.transpile(Source("drawn.py", code))
        assert translation.ok, f"seed {seed}: {told(translation.diagnostics)}"
        result = SESSION.evaluate(Source("drawn.scene", translation.text))
        assert result.scene is not None, f"seed {seed}: {told(result.diagnostics)}"
        with contextlib.redirect_stdout(io.StringIO()):
            difference = first_difference(flattened(result.scene), flatten(code))
        assert difference is None, f"seed {seed}: {difference}"


def test_long_sums_are_refused_before_they_start() -> None:
    code = HEAD + (
        "    a = np.ones((90, 90))\n    parts.append(cube(np.einsum('ij,kl,mn->', a, a, a), Kind.HIGH.value))\n"
        "    return concat_shapes(*parts)\n"
    )
    translation = SESSION.transpile(Source("sums.py", "import numpy as np\n" + code))
    assert "this sum of products is too long" in told(translation.diagnostics)

"""Random programs give the same primitives in CPython, with a model of the helper library, and translated."""

from __future__ import annotations

import json
import os

import pytest
from hypothesis import HealthCheck, given, settings
from searching import many

from scenelang.grammar.datum import Source, print_datum
from scenelang.session.session import Session
from transpile.cases import first_difference, flattened, printed, told
from transpile.generator import programs
from transpile.reassignments import reassigning
from transpile.reference_model import flatten

EXAMPLES = int(os.environ.get("SCENELANG_EXAMPLES", many(60)))  # by hand: 2,000
SESSION = Session()


FEW = settings(max_examples=EXAMPLES, deadline=None, derandomize=EXAMPLES <= 250, database=None,
               suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])  # fmt: skip


@FEW
@given(programs())
def test_the_same_primitives(code: str) -> None:
    _compare(code)


@FEW
@given(reassigning())
def test_the_same_primitives_after_reassignments(code: str) -> None:
    _compare(code)


ORDERS = {
    "a name read by what is collected": """
    parts = []
    y = 0.5
    parts.append(at(y))
    y += 1
    parts.append(at(y))
    y = y * 2
    parts.append(at(y))
    return concat_shapes(*parts)
""",
    "a value that reads what changes": """
    w = 1
    x = w * 2
    w = 5
    x = x + 1
    return at(x + w)
""",
    "a draw before another draw": """
    x = random.random()
    x = random.random() * 2 - x
    y = random.random()
    y = [random.random(), y][0]
    return at(x + y)
""",
    "a branch that does things": """
    a = 2
    parts = []
    shape = at(0)
    if a > 0:
        shape = at(5)
        parts.append(at(a))
    else:
        parts.append(at(a - len(parts)))
    if a > 2:
        parts += [at(a), at(random.random())]
    else:
        shape = at(1)
    for j in range(1):
        parts = [*parts, shape]
        parts.append(at(len(parts)))
    return concat_shapes(*parts, shape)
""",
    "a list remade after its names changed": """
    parts = []
    a = 3
    for i in range(2):
        parts.append(at(a + i))
    a -= 1
    parts = [*parts, at(a)]
    return concat_shapes(*parts)
""",
    "a function defined again": """
    def make(v):
        return at(v)
    shape = make(0)
    for i in range(2):
        shape = concat_shapes(shape, shape)
    def make(v, w=len(shape) * 2):
        return at(v + w)
    return concat_shapes(shape, make(1))
""",
    "arguments of primitives in a table": """
    def part(kind, **kw):
        return primitive_call(kind, **kw)
    kw = {'shape_kwargs': {'scale': (1, 2, 3)}, 'color': (1, 0, 0)}
    return concat_shapes(primitive_call('cube', **kw), part('sphere', shape_kwargs={'radius': 2}), part('cube'))
""",
    "blocks between cells": """
    blocks = primitive_call('set_cuboid', block_type='minecraft:stone', scale=(2, 2, 2))
    return transform_shape(blocks, translation_matrix((1.7, 2, -1.5)))
""",
}
FRAMES = """
@register_animation()
def show():
    return [at(i) for i in range(5)]
"""


@pytest.mark.parametrize("name", ORDERS)
def test_orders(name: str) -> None:
    _compare(f"{_AT}\n@register()\ndef root():{ORDERS[name]}")


def test_an_animation_may_return_its_frames() -> None:
    _compare(_AT + FRAMES)


def test_nested_functions_compile_in_time() -> None:
    depth = 40
    opening = [f"{'    ' * i}def f{i}():" for i in range(1, depth)]
    closing = [f"{'    ' * (i + 1)}return f{i + 1}()" for i in reversed(range(depth - 1))]
    lines = [*opening, f"{'    ' * depth}return at(1)", *closing]
    _compare(f"{_AT}\n@register()\ndef root():\n" + "\n".join(lines) + "\n")


_AT = """from helper import *
import random

def at(x):
    return transform_shape(primitive_call('cube'), translation_matrix((x, 0, 0)))
"""


def _compare(code: str) -> None:
    golden = json.loads(json.dumps(flatten(code)))
    translation = SESSION.transpile(Source("drawn.py", code), literal=True)
    assert translation.ok, f"{told(translation.diagnostics)}\n{code}"
    assert printed(translation.text) == [print_datum(form) for form in translation.forms]
    for text in (translation.text, SESSION.transpile(Source("drawn.py", code)).text):
        result = SESSION.evaluate(Source("drawn.scene", text))
        assert result.scene is not None, f"{told(result.diagnostics)}\n{code}\n{text}"
        difference = first_difference(flattened(result.scene), golden)
        assert difference is None, f"{difference}\n{code}\n{text}"

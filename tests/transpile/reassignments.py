"""Random straight-line code that grows lists and shapes while the names they read change: `reassigning()` draws it.

Orders of evaluation are what this is after: nearly every statement reads names that a neighbour assigns.
"""

from __future__ import annotations

from random import Random

from hypothesis import strategies as st

_HEADER = "from helper import *\nimport random\n\n@register()\ndef root():\n"
_START = """
def make(v):
    return transform_shape(primitive_call('cube'), translation_matrix((v, v, v)))
parts = []
shape = primitive_call('cube')
"""
_END = "return concat_shapes(*parts, shape, transform_shape(shape, translation_matrix((a, b, 99))))"


def reassigning() -> st.SearchStrategy[str]:
    """Programs' text."""
    return st.randoms(use_true_random=False).map(_program)


def _program(random: Random) -> str:
    start = [f"a = {random.randint(0, 5)}", f"b = {random.choice(['2', '0.5', 'random.random()', '3'])}"]
    lines = [*_START.strip().splitlines(), *start, *_block(random, 0, random.randint(3, 9)), _END]
    return _HEADER + "".join(f"    {line}\n" for line in lines)


def _number(random: Random, depth: int = 0) -> str:
    kind = random.random()
    if depth > 1 or kind < 0.5:
        return random.choice(["a", "a", "b", "1", "2", "len(parts)" if random.random() < 0.3 else "b"])
    left, right = _number(random, depth + 1), _number(random, depth + 1)
    if kind < 0.6:
        return f"({left} if {right} > {_number(random, depth + 1)} else {right})"
    if kind < 0.65:
        return "random.random()"
    return f"({left} {random.choice('+-*')} {right})"


def _shape(random: Random) -> str:
    kind = random.random()
    if kind < 0.6:
        made = "primitive_call('cube')" if kind < 0.4 else "shape"
        pose = ", ".join(_number(random) for _ in range(3))
        return f"transform_shape({made}, translation_matrix(({pose})))"
    return f"make({_number(random)})" if kind < 0.7 else "shape"


def _block(random: Random, depth: int, count: int) -> list[str]:
    return [line for _ in range(count) for line in _statement(random, depth)]


def _statement(random: Random, depth: int) -> list[str]:
    kind = random.random()
    if kind > 0.72 and depth < 2:
        return _compound(random, depth, kind)
    simple = (
        lambda: f"parts.append({_shape(random)})",
        lambda: f"{random.choice('ab')} {random.choice(['+=', '-=', '='])} {_number(random)}",
        lambda: f"shape = {_shape(random)}",
        lambda: f"a, b = {_number(random)}, {_number(random)}",
        lambda: f"parts += [{_shape(random)}, {_shape(random)}]",
        lambda: f"parts = [*parts, {_shape(random)}]",
        lambda: f"shape = concat_shapes(shape, {_shape(random)})",
    )
    return [random.choices(simple, (6, 3, 1, 1, 1, 1, 1))[0]()]


def _compound(random: Random, depth: int, kind: float) -> list[str]:
    inner = _block(random, depth + 1, random.randint(1, 3))
    if kind < 0.82:
        lines = [f"if {_number(random)} > {_number(random)}:", *_indented(inner)]
        if random.random() < 0.5:
            lines += ["else:", *_indented(_block(random, depth + 1, random.randint(1, 2)))]
        return lines
    if kind < 0.92 or depth > 0:
        return [f"for {'ij'[depth]} in range({random.randint(1, 3)}):", *_indented(inner)]
    pose = f"(v + w, {_number(random)}, 1)"
    body = f"return transform_shape(primitive_call('cube'), translation_matrix({pose}))"
    return [f"def make(v, w={_number(random)}):", *_indented([body])]


def _indented(lines: list[str]) -> list[str]:
    return ["    " + line for line in lines]

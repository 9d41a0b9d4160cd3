"""Words made of evaluated functions keep their parameters and defaults; an argument that nobody knows is an error."""

from __future__ import annotations

import pytest

from scenelang.grammar.datum import Source
from scenelang.session.session import Evaluated, Session
from transpile.cases import first_difference, flattened, scene_of, told
from transpile.reference_model import flatten

SESSION = Session()
# A class with a hook that makes shapes is evaluated, and with it what uses it.
HEAD = """from helper import *
from fractions import Fraction
import math

class Part:
    def __init_subclass__(cls):
        pass
class Beam(Part):
    def __init__(self, size):
        self.size = size
    def shape(self):
        return primitive_call('cube', shape_kwargs={'scale': (self.size, self.size, 1)})

def bar(x, y, size):
    return transform_shape(Beam(size).shape(), translation_matrix((x, y, 0)))

@register()
"""
LINE = HEAD.count("\n") + 1
FOOT = "\n\n@register()\ndef scene() -> Shape:\n    return {}\n"


def text_of(word: str, root: str) -> str:
    translation = SESSION.transpile(Source("words.py", HEAD + word + FOOT.format(root)))
    assert translation.ok, told(translation.diagnostics)
    return translation.text


def called(text: str, call: str) -> Evaluated:
    """Evaluate a program with another root, which is a call of one of its words."""
    return SESSION.evaluate(Source("words.scene", text.replace('(scene "scene")', f"(scene {call})")))


POST = """def post(h: float = 1.0, n: int = 3, r: float = 0.5, m: int = 4) -> Shape:
    beam = Beam(2)
    share = Fraction(m, 3)
    parts = []
    for i in range(n):
        if r > 0.3:
            parts.append(bar(i, r, h * float(share)))
    return concat_shapes(*parts, bar(0, 0, beam.size))"""
POSTS = text_of(POST, "concat_shapes(library_call('post', h=2.0), library_call('post', h=3.0, n=5))")


@pytest.mark.parametrize(
    "arguments",
    ["", "h=2.5", "n=1", "n=7", "r=0.1", "h=3.5, n=2, r=0.4", "m=4"],
)
def test_arguments_that_the_python_never_passes(arguments: str) -> None:
    keywords = "".join(
        f" :{name} {value}" for name, value in (each.split("=") for each in arguments.split(", ") if each)
    )
    result = called(POSTS, f'"post"{keywords}')
    assert result.scene is not None, told(result.diagnostics)
    given = f"library_call('post', {arguments})" if arguments else "library_call('post')"
    expected = flatten(HEAD + POST + FOOT.format(given))
    assert first_difference(flattened(result.scene), expected) is None


def test_a_case_that_was_never_evaluated_is_an_error_with_the_line() -> None:
    result = called(POSTS, '"post" :m 5')
    assert result.scene is None
    assert f"`post` (line {LINE} of the Python)" in told(result.diagnostics)


def test_only_the_parameter_that_decides_is_a_case() -> None:
    text = text_of(POST, "concat_shapes(library_call('post', h=2.0), library_call('post', m=5, n=5))")
    assert text.count("(= m ") == 2
    assert not any(f"(= {name} " in text for name in "nrh")


def test_the_only_case_is_an_error_for_other_arguments() -> None:
    text = text_of(POST, "library_call('post', m=5)")
    assert called(text, '"post" :m 6').scene is None
    assert called(text, '"post" :m 5').scene is not None


def test_the_defaults_are_a_case_of_their_own() -> None:
    word = """def sign(text: str = "ab", size: float = 1.0) -> Shape:
    beam = Beam(size)
    parts = [bar(i, ord(c) - 96, beam.size) for i, c in enumerate(text)]
    return concat_shapes(*parts)"""
    text = text_of(word, "library_call('sign', text='abc', size=2.0)")
    result = called(text, '"sign"')
    assert result.scene is not None, told(result.diagnostics)
    expected = flatten(HEAD + word + FOOT.format("library_call('sign')"))
    assert first_difference(flattened(result.scene), expected) is None
    assert called(text, '"sign" :text "b"').scene is None


def test_defaults_that_fail_are_no_case() -> None:
    word = """def row(names: tuple = (), size: float = 1.0) -> Shape:
    beam = Beam(size)
    first = names[0]
    return bar(len(first), 0, beam.size)"""
    text = text_of(word, "library_call('row', names=('a', 'b'))")
    assert called(text, '"row"').scene is None


def test_a_word_that_depends_on_what_has_happened_has_no_case_for_later() -> None:
    word = """def step(size: float = 1.0) -> Shape:
    HEIGHTS.append(Beam(size).size)
    return bar(0, sum(HEIGHTS), size)"""
    text = text_of("def none() -> Shape:\n    return bar(0, 0, 1)\n\nHEIGHTS = []\n@register()\n" + word,
        "concat_shapes(library_call('step', size=2.0), library_call('step', size=3.0))")  # fmt: skip
    assert called(text, '"step" :size 4.0').scene is None or ":state" in text


SPECS = """class Spec(NamedTuple):
    start: tuple
    size: float
class Counted(Part):
    def __init__(self, x):
        self.x = x
        self.times = 0

@register()
def limb(spec: Spec) -> Shape:
    beam = Beam(spec.size)
    return transform_shape(primitive_call('cube', shape_kwargs={'scale': beam.size}), translation_matrix(spec.start))

@register()
def counted(thing: Counted) -> Shape:
    thing.times += 1
    return bar(thing.x, thing.times, 1)"""


def transpiled(body: str) -> str:
    code = HEAD.replace("@register()\n", "from typing import NamedTuple\n") + SPECS + FOOT.format(body)
    translation = SESSION.transpile(Source("words.py", code))
    assert translation.ok, told(translation.diagnostics)
    result = SESSION.evaluate(Source("words.scene", translation.text))
    assert result.scene is not None, told(result.diagnostics)
    assert first_difference(flattened(result.scene), flatten(code)) is None
    return translation.text


def test_objects_of_numbers_are_passed_as_their_numbers() -> None:
    calls = ", ".join(f"library_call('limb', spec=Spec(({i}, {i * i}, 0), {1 + i / 3}))" for i in range(1, 4))
    text = transpiled(f"concat_shapes({calls})")
    assert "cond" not in text
    assert "(ref spec 0)" in text


def test_objects_that_a_word_changes_are_not() -> None:
    transpiled(
        "(lambda t: concat_shapes(*[library_call('counted', thing=t) for _ in range(2)], bar(t.times, 0, 1)))(Counted(2))"
    )


def test_a_seed_that_a_loop_computes_unrolls_the_loop_only() -> None:
    word = """def cloud(seed: int, size: float = 1.0) -> Shape:
    stream = random.Random(seed)
    return concat_shapes(*[bar(stream.uniform(0, 9), i, size) for i in range(Beam(3).size)])"""
    text = text_of("def none() -> Shape:\n    return bar(0, 0, 1)\n\nimport random\n@register()\n" + word,
        "concat_shapes(*[library_call('cloud', seed=10 + i, size=2.0) for i in range(3)])")  # fmt: skip
    assert "size" in text
    assert "(= size" not in text


SEEDED = """
from helper import *
import random
import numpy as np
{before}
class Walk:
    def __init__(self, n):
        self.steps = [random.choice([1, 2, 3]) for _ in range(n)]
        self.noise = np.random.rand(n)

walk = Walk(4)
{after}
@register()
def w() -> Shape:
    heights = [*walk.steps, *[1 + float(x) for x in walk.noise], 1 + random.random()]
    return concat_shapes(*[primitive_call('cube', shape_kwargs={{'scale': (1, h, 1)}}, color=(1, 0, 0)) for h in heights])
"""


@pytest.mark.parametrize("before", ["", "random.seed(7)", "np.random.seed(3)", "random.seed(7)\nnp.random.seed(3)"])
@pytest.mark.parametrize("after", ["", "random.seed(9)", "np.random.seed(1)\nextra = Walk(2)"])
def test_seeds_of_the_module_decide_what_it_draws(before: str, after: str) -> None:
    text = SEEDED.format(before=before, after=after)
    assert first_difference(flattened(scene_of("w.py", text)), flatten(text)) is None


DRAWN_AT_IMPORT = {
    "a condition": "SEED = 7\nif SEED is not None:\n    random.seed(SEED)\nX = [random.random()]",
    "a loop": "X = []\nfor i in range(3):\n    random.seed(i)\n    X.append(random.random())",
    "no draw": "if True:\n    random.seed(5)\nX = [1.5]",
    "a class": "random.seed(1)\nclass A:\n    x = random.random()\nX = [A.x]",
    "a field": "random.seed(1)\n@dataclass\nclass A:\n    x: float = random.random()\nX = [A().x]",
    "a default": "random.seed(1)\ndef f(x=random.random()):\n    return x\nX = [f()]",
    "a text": "random.seed('abc')\nX = [random.random()]",
    "bytes": "random.seed(b'abc')\nX = [random.random()]",
    "a float": "random.seed(-1.5)\nX = [random.random()]",
    "a boolean": "random.seed(True)\nX = [random.random()]",
    "a keyword": "random.seed(a=7)\nX = [random.random()]",
}


@pytest.mark.parametrize("name", DRAWN_AT_IMPORT)
def test_draws_of_the_module_are_those_of_its_seed(name: str) -> None:
    word = "return concat_shapes(*[primitive_call('cube', shape_kwargs={'scale': (1, 1 + x, 1)}, color=(1, 0, 0)) for x in X])"
    head = "from helper import *\nimport random\nfrom dataclasses import dataclass\n"
    text = f"{head}{DRAWN_AT_IMPORT[name]}\n\n@register()\ndef w() -> Shape:\n    {word}\n"
    assert first_difference(flattened(scene_of("w.py", text)), flatten(text)) is None

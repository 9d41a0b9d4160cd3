"""Draws must be those of the real generators, one after the other, so that transpiled programs draw alike."""

from __future__ import annotations

import random
from typing import Any

import numpy as np
import pytest

from scenelang import Options, Session, Source
from scenelang.grammar.diagnostics import LimitError
from scenelang.interpreter.runtime.runtime import Runtime
from scenelang.interpreter.scene.flatten import flatten_entity
from scenelang.interpreter.values.values import Keyword, Vector

from .conftest import Caller, new_runtime, python, scheme

WORDS = ["oak", "ash", "elm", "fir", "yew", "box", "ivy"]
CHANCES = [0.1, 0.2, 0.1, 0.1, 0.2, 0.2, 0.1]


def option(**given: Any) -> list[Any]:
    return [part for name, value in given.items() for part in (Keyword(name), value)]


def plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray) else python(value)


NUMPY: list[tuple[str, list[Any], Any]] = [
    ("random", [], lambda r: r.random()),
    ("random", option(size=3), lambda r: r.random(3)),
    ("uniform", [], lambda r: r.uniform()),
    ("uniform", [-2, 5], lambda r: r.uniform(-2, 5)),
    ("uniform", [0.7, 1.3, *option(size=4)], lambda r: r.uniform(0.7, 1.3, 4)),
    ("uniform", [Vector((0, 1)), Vector((1, 9))], lambda r: r.uniform([0, 1], [1, 9])),
    ("normal", [2, 0.5], lambda r: r.normal(2, 0.5)),
    ("normal", option(size=scheme([5])), lambda r: r.normal(size=5)),
    ("shuffle", [WORDS], lambda r: shuffled(r, list(WORDS))),
    ("shuffle", [Vector(range(9))], lambda r: shuffled(r, np.arange(9))),
    ("permutation", [6], lambda r: r.permutation(6)),
    ("permutation", [WORDS], lambda r: r.permutation(np.array(WORDS))),
    ("choice", [WORDS], lambda r: r.choice(WORDS)),
    ("choice", [10], lambda r: r.choice(10)),
    ("choice", [WORDS, *option(p=scheme(CHANCES))], lambda r: r.choice(WORDS, p=CHANCES)),
    ("choice", [WORDS, *option(size=4)], lambda r: r.choice(WORDS, 4)),
    ("choice", [WORDS, *option(size=4, replace=False)], lambda r: r.choice(WORDS, 4, replace=False)),
    ("choice", [Vector((5, 6, 7)), *option(size=5)], lambda r: r.choice([5, 6, 7], 5)),
]  # fmt: skip
LEGACY: list[tuple[str, list[Any], Any]] = [
    ("randint", [10], lambda r: r.randint(10)),
    ("randint", [-5, 5], lambda r: r.randint(-5, 5)),
    ("randint", [0, 3, *option(size=6)], lambda r: r.randint(0, 3, 6)),
    ("randint", [0, 2**40], lambda r: r.randint(0, 2**40)),
    ("rand", [], lambda r: r.rand()),
    ("rand", [3], lambda r: r.rand(3)),
    ("randn", [], lambda r: r.randn()),
    ("randn", [4], lambda r: r.randn(4)),
]  # fmt: skip
MODERN: list[tuple[str, list[Any], Any]] = [
    ("randint", [10], lambda r: r.integers(10)),
    ("randint", [0, 3, *option(size=6)], lambda r: r.integers(0, 3, 6)),
    ("rand", [3], lambda r: r.random(3)),
    ("randn", [4], lambda r: r.standard_normal(4)),
]  # fmt: skip
PYTHON: list[tuple[str, list[Any], Any]] = [
    ("py-random", [], lambda r: r.random()),
    ("py-uniform", [-2, 5], lambda r: r.uniform(-2, 5)),
    ("py-gauss", [1, 2], lambda r: r.gauss(1, 2)),
    ("py-gauss", [], lambda r: r.gauss(0.0, 1.0)),
    ("py-randint", [1, 6], lambda r: r.randint(1, 6)),
    ("py-randrange", [0, 50, 5], lambda r: r.randrange(0, 50, 5)),
    ("py-choice", [WORDS], lambda r: r.choice(WORDS)),
    ("py-choices", [WORDS, *option(k=4)], lambda r: r.choices(WORDS, k=4)),
    ("py-choices", [WORDS, *option(weights=scheme(CHANCES), k=3)], lambda r: r.choices(WORDS, CHANCES, k=3)),
    ("py-sample", [WORDS, 4], lambda r: r.sample(WORDS, 4)),
    ("py-shuffle", [WORDS], lambda r: shuffled(r, list(WORDS))),
]  # fmt: skip


def shuffled(generator: Any, xs: Any) -> Any:
    generator.shuffle(xs)
    return xs


@pytest.mark.parametrize("seed", [0, 1, 12345])
def test_draws_are_numpys(seed: int) -> None:
    call, real = Caller(Runtime(new_runtime().library, seed=seed)), np.random.RandomState(seed)
    for name, arguments, draw in [*NUMPY, *LEGACY, *NUMPY]:
        assert plain(call(name, *arguments)) == plain(draw(real)), name


@pytest.mark.parametrize("seed", [0, 1, 12345])
def test_draws_are_pythons(seed: int) -> None:
    call, real = Caller(Runtime(new_runtime().library, seed=seed)), random.Random(seed)
    for name, arguments, draw in PYTHON * 2:
        assert plain(call(name, *arguments)) == draw(real), name


@pytest.mark.parametrize(
    ("maker", "real", "draws"),
    [
        ("random-stream", np.random.RandomState, NUMPY + LEGACY),
        ("default-rng", np.random.default_rng, NUMPY + MODERN),
        ("py-random-stream", random.Random, PYTHON),
    ],
)
def test_streams_of_ones_own(call: Caller, maker: str, real: Any, draws: Any) -> None:
    stream, generator = call(maker, 7), real(7)
    for name, arguments, draw in draws * 2:
        assert plain(call(name, *arguments, *option(stream=stream))) == plain(draw(generator)), name
    assert not call.rt.drew_random


def test_seeds(call: Caller) -> None:
    call("set-seed!", 42)
    call("py-set-seed!", 42)
    assert call("random") == np.random.RandomState(42).random_sample()
    assert call("py-random") == random.Random(42).random()
    call.refuses("value", "set-seed!", -1)
    call.refuses("value", "random-stream", 1 << 32)
    call.refuses("type", "set-seed!", 1.5)


@pytest.mark.parametrize("name", ["shuffle!", "py-shuffle!"])
def test_shuffling_in_place(name: str) -> None:
    call = Caller(new_runtime())
    xs, array = call("mutable", WORDS), call("mutable-array", list(range(9)))
    real: Any = np.random.RandomState(0) if name == "shuffle!" else random.Random(0)
    call(name, xs)
    call(name, array)
    assert python(xs) == shuffled(real, list(WORDS))
    assert array.data.tolist() == plain(shuffled(real, list(range(9))))


def test_shapes(call: Caller) -> None:
    assert call.python("array-shape", call("uniform", *option(size=scheme([2, 3])))) == [2, 3]
    assert call.python("array-shape", call("choice", Vector((1, 2)), *option(size=scheme([2, 3])))) == [2, 3]
    rows = call.python("choice", WORDS, *option(size=scheme([2, 3])))
    assert [len(row) for row in rows] == [3, 3]
    with pytest.raises(LimitError):
        call("random", *option(size=10**9))
    with pytest.raises(LimitError):
        call("py-choices", WORDS, *option(k=10**9))
    with pytest.raises(LimitError):
        call("choice", 10**9, *option(replace=False))


def test_draws_are_noted(rt: Runtime) -> None:
    call = Caller(rt)
    for name, *arguments in (("random",), ("py-random",), ("set-seed!", 1), ("py-set-seed!", 1), ("shuffle", [1, 2])):
        rt.drew_random = False
        call(name, *arguments)
        assert rt.drew_random, name
    rt.drew_random = False
    stream = call("random-stream", 1)
    rt.serial = rt.clock = stream.birth + 5
    call("random", *option(stream=stream))
    assert not rt.drew_random
    assert rt.oldest_write == stream.birth


def test_draws_that_cannot_be(call: Caller) -> None:
    call.refuses("value", "randint", 5, 5)
    call.refuses("value", "randint", 0, 1 << 70)
    call.refuses("value", "py-randint", 5, 4)
    call.refuses("value", "py-sample", WORDS, 9)
    call.refuses("index", "choice", scheme([]))
    call.refuses("value", "choice", 0)
    call.refuses("value", "choice", WORDS, *option(p=scheme([1])))
    call.refuses("value", "choice", WORDS, *option(size=9, replace=False))
    call.refuses("value", "normal", 0, -1)
    call.refuses("value", "uniform", 0, float("inf"))
    call.refuses("value", "py-choices", WORDS, *option(weights=scheme([1])))
    call.refuses("type", "choice", 5.5)
    assert "py-random" in call.refuses("type", "random", *option(stream=call("py-random-stream")))
    assert "`random`" in call.refuses("type", "py-random", *option(stream=call("default-rng")))


@pytest.mark.parametrize(("draw", "first"), [("(py-random)", random.Random(5).random()), ("(random)", None)])
def test_the_root_draws_anew_whatever_was_drawn_before(draw: str, first: float | None) -> None:
    root = f'(bind "a" (lambda () (transform (call "cube") (translate [{draw} 0 0]))))'
    places = []
    for before in ("", f"(define x {draw}) (define y {draw})\n"):
        result = Session(Options(seed=5)).evaluate(Source("a.scene", before + root))
        assert result.scene is not None
        places.append(float(flatten_entity(result.scene.root).matrices[0, 0, 3]))
    assert places[0] == places[1]
    assert first is None or places[0] == pytest.approx(first)

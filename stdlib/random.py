"""Builtins for random numbers: numpy's generators, and with the prefix ``py-`` Python's, bit for bit; and for noise."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from itertools import accumulate
from typing import TYPE_CHECKING, Any

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.loading import np
from scenelang.interpreter.runtime.show import show
from scenelang.interpreter.runtime.types import Registry
from scenelang.interpreter.values.values import NIL, Stream, Vector, make_list
from scenelang.stdlib.numbers import charge_digits
from scenelang.stdlib.operands import (
    Numpy,
    empty_sequence,
    from_numpy,
    items,
    rebuild,
    reorder,
    shape_argument,
    to_numpy,
    wrong_type,
)
from scenelang.stdlib.sequences import rebuild_template

if TYPE_CHECKING:
    from scenelang.interpreter.runtime.runtime import Runtime

registry = Registry("random")

_INT64 = 1 << 63
_NUMBERS = frozenset((int, float))
_MAX_EXTENT = 1e300  # of the range of a draw that cannot overflow
_BLOCK_DRAWS = 4096  # between two checks of the limits
_MAX_NOISE_COORDINATE = 1e15  # beyond, floats have no fraction for the noise to interpolate
_NOISE_BYTES_PER_POINT = 512  # of temporary arrays, which the memory limit counts


# --- streams ---------------------------------------------------------------------------------------------------


def numpy_source(rt: Runtime, name: str, stream: Stream | None) -> Any:
    """Return the generator to draw from, and record the draw."""
    if stream is None:
        rt.draw()
        return rt.streams.numpy
    if stream.kind == "py-random-stream":
        hint = f"for this stream, use `py-{name}`"
        raise wrong_type(name, "a stream of `random-stream` or `default-rng`", stream, hint)
    rt.draw(stream)
    return stream.generator


def _python_source(rt: Runtime, name: str, stream: Stream | None) -> Any:
    """Return Python's generator to draw from, and record the draw."""
    if stream is None:
        rt.draw()
        return rt.streams.python
    if stream.kind != "py-random-stream":
        raise wrong_type(name, "a stream of `py-random-stream`", stream, f"for this stream, use `{name[3:]}`")
    rt.draw(stream)
    return stream.generator


def _check_seed(name: str, seed: int) -> int:
    """Return a seed that numpy accepts."""
    if not 0 <= seed < 1 << 32:
        raise SceneError("value", f"`{name}` expects a seed from 0 to 2^32 - 1, got {show(seed, 30)}")
    return seed


@registry.define("random-state", "", "Stream",
                 "Return a copy of the state of the stream of `random`, `uniform`, `randint` and related functions, "
                 "for `set-random-state!`.",
                 ("(let ((s (random-state))) (let ((a (random))) (set-random-state! s) (= a (random))))",
                  "#t"))  # fmt: skip
def random_state(rt: Runtime) -> Stream:
    rt.draw()
    rt.charge(8)
    generator = np.random.RandomState()
    generator.set_state(rt.streams.numpy.get_state())
    return Stream("random-stream", generator, rt.clock)


@registry.define("set-random-state!", "saved::Stream", "Any",
                 "Restore the stream of `random`, `uniform`, `randint` and related functions to the state that "
                 "`random-state` returned.",
                 ("(let ((s (random-state))) (random) (set-random-state! s))", "none"))  # fmt: skip
def set_random_state(rt: Runtime, saved: Stream) -> None:
    rt.charge(8)
    rt.streams.numpy.set_state(numpy_source(rt, "set-random-state!", saved).get_state())
    rt.draw()


@registry.define("set-seed!", "seed::Integer", "Any",
                 "Reseed the stream of `random`, `uniform`, `randint` and related functions.",
                 ("(begin (set-seed! 7) (let ((a (random))) (set-seed! 7) (= a (random))))", "#t"))  # fmt: skip
def set_seed(rt: Runtime, seed: int) -> None:
    rt.draw()
    rt.streams.seed_numpy(_check_seed("set-seed!", seed))


@registry.define("py-set-seed!", "seed::Any", "Any",
                 "Reseed the stream of `py-random` and related functions, by an Integer, another number or a String.",
                 ("(begin (py-set-seed! 7) (let ((a (py-random))) (py-set-seed! 7) (= a (py-random))))",
                  "#t"))  # fmt: skip
def py_set_seed(rt: Runtime, seed: Any) -> None:
    rt.draw()
    rt.streams.seed_python(_python_seed(rt, "py-set-seed!", seed))


def _python_seed(rt: Runtime, name: str, seed: Any) -> int | float | str:
    """Return a seed that Python's ``random`` accepts and that gives the same numbers in every run."""
    if not isinstance(seed, (int, float, str)):
        raise wrong_type(name, "a number or a String as the seed", seed)
    if seed != seed:  # Python's hash of nan is another one in every run
        raise SceneError("value", f"`{name}` expects a seed that is equal to itself, got nan")
    if isinstance(seed, str):
        rt.charge(len(seed))
    elif isinstance(seed, int):
        charge_digits(rt, seed)
    return seed


@registry.define("random-stream", "[seed::Integer]", "Stream",
                 "Create a separate stream for `:stream`, as numpy's `RandomState(seed)`; the default seed is 0.",
                 ("(let ((a (random-stream 3)) (b (random-stream 3))) (= (random :stream a) (random :stream b)))",
                  "#t"))  # fmt: skip
def random_stream(rt: Runtime, seed: int = 0) -> Stream:
    rt.charge(8)
    return Stream("random-stream", np.random.RandomState(_check_seed("random-stream", seed)), rt.clock)


@registry.define("default-rng", "[seed::Integer]", "Stream",
                 "Create a separate stream for `:stream`, as numpy's `default_rng(seed)`; the default seed is 0.",
                 ("(randint 5 6 :stream (default-rng 3))", "5"))  # fmt: skip
def default_rng(rt: Runtime, seed: int = 0) -> Stream:
    rt.charge(8)
    charge_digits(rt, seed)
    if seed < 0:
        raise SceneError("value", f"`default-rng` expects a seed that is not negative, got {show(seed, 30)}")
    return Stream("default-rng", np.random.default_rng(seed), rt.clock)


@registry.define("py-random-stream", "[seed::Any]", "Stream",
                 "Create a separate stream for the `:stream` of `py-random`, as Python's `random.Random(seed)`, by an "
                 "Integer, another number or a String; the default seed is 0.",
                 ("(py-randint 5 5 :stream (py-random-stream 3))", "5"))  # fmt: skip
def py_random_stream(rt: Runtime, seed: Any = 0) -> Stream:
    import random

    rt.charge(4)
    return Stream("py-random-stream", random.Random(_python_seed(rt, "py-random-stream", seed)), rt.clock)


# --- numpy's draws ---------------------------------------------------------------------------------------------


def _sample(name: str, draw: Callable[[], Any]) -> Any:
    """Return the value of a draw; an error of numpy or Python becomes a diagnostic."""
    try:
        value = draw()
    except (ValueError, OverflowError, IndexError) as error:
        raise SceneError("value", f"`{name}` cannot draw: {error}") from None
    return value if type(value) in (int, float) else from_numpy(value)


def _shape(rt: Runtime, name: str, size: Any) -> Any:
    """Return the shape of ``:size``, or None for a single draw."""
    return None if size is None else shape_argument(rt, size, name)


@registry.define("random", "[:size::Any] [:stream::Stream]", "Number",
                 "Return a uniform random number from 0 up to but excluding 1; with `:size`, an array of that shape.",
                 ("(let ((x (random))) (and (<= 0 x) (< x 1)))", "#t"))  # fmt: skip
def random(rt: Runtime, *, size: Any = None, stream: Any = None) -> Any:
    if size is None:
        value: float = numpy_source(rt, "random", stream).random()
        return value
    shape = _shape(rt, "random", size)
    source = numpy_source(rt, "random", stream)
    return _sample("random", lambda: source.random(shape))


@registry.define("uniform", "[low::ArrayLike] [high::ArrayLike] [:size::Any] [:stream::Stream]", "Number",
                 "Return a uniform random number from `low` (default 0) up to `high` (default 1); with `:size`, an "
                 "array of that shape.",
                 ("(array-shape (uniform -1 1 :size '(2 3)))", "(2 3)"))  # fmt: skip
def uniform(rt: Runtime, low: Any = 0.0, high: Any = 1.0, *, size: Any = None, stream: Any = None) -> Any:
    if size is None and type(low) in _NUMBERS and type(high) in _NUMBERS:
        extent = high - low
        if -_MAX_EXTENT < extent < _MAX_EXTENT:
            # what numpy's ``uniform`` does, for which it converts its arguments to arrays
            value: float = low + extent * numpy_source(rt, "uniform", stream).random()
            return value
    shape = _shape(rt, "uniform", size)
    bounds = [_parameter(rt, "uniform", bound) for bound in (low, high)]
    source = numpy_source(rt, "uniform", stream)
    return _sample("uniform", lambda: source.uniform(*bounds, shape))


def _parameter(rt: Runtime, name: str, value: Any) -> Any:
    """Return a parameter of a distribution: a number, or an array with one value per draw."""
    if type(value) is int or type(value) is float:
        return float(value)
    return to_numpy(rt, value, name)


@registry.define("normal", "[mean::ArrayLike] [deviation::ArrayLike] [:size::Any] [:stream::Stream]", "Number",
                 "Return a number from the normal distribution with `mean` (default 0) and standard `deviation` "
                 "(default 1); with `:size`, an array of that shape; with an array for one of them, a number for each "
                 "item.",
                 ("(length (normal 0 2 :size 3))", "3"))  # fmt: skip
def normal(rt: Runtime, mean: Any = 0.0, deviation: Any = 1.0, *, size: Any = None, stream: Any = None) -> Any:
    shape = _shape(rt, "normal", size)
    parameters = [_parameter(rt, "normal", value) for value in (mean, deviation)]
    source = numpy_source(rt, "normal", stream)
    return _sample("normal", lambda: source.normal(*parameters, shape))


@registry.define("randint", "low::Integer [high::Integer] [:size::Any] [:stream::Stream]", "Integer",
                 "Return a random Integer from `low` up to but excluding `high`; `(randint n)` starts at 0.",
                 ("(randint 5 6)", "5"))  # fmt: skip
def randint(rt: Runtime, low: int, high: int | None = None, *, size: Any = None, stream: Any = None) -> Any:
    first, end = (0, low) if high is None else (low, high)
    if first >= end:
        raise SceneError("value", f"`randint` expects a range that is not empty, got {show(first)} up to {show(end)}")
    if first < -_INT64 or end > _INT64:
        raise SceneError("value", f"`randint` expects bounds of 64 bits, got {show(first, 30)} up to {show(end, 30)}")
    shape = _shape(rt, "randint", size)
    source = numpy_source(rt, "randint", stream)
    draw = source.integers if stream is not None and stream.kind == "default-rng" else source.randint
    return _sample("randint", lambda: draw(first, end, shape))


@registry.define("rand", "sides::Integer ... [:stream::Stream]", "Number",
                 "Return an array of this shape of uniform random numbers from 0 up to 1; without arguments, one "
                 "number.",
                 ("(array-shape (rand 2 3))", "(2 3)"))  # fmt: skip
def rand(rt: Runtime, *sides: int, stream: Any = None) -> Any:
    return random(rt, size=make_list(sides) if sides else None, stream=stream)


@registry.define("randn", "sides::Integer ... [:stream::Stream]", "Number",
                 "Return an array of this shape from the standard normal distribution; without arguments, one number.",
                 ("(length (randn 4))", "4"))  # fmt: skip
def randn(rt: Runtime, *sides: int, stream: Any = None) -> Any:
    shape = _shape(rt, "randn", make_list(sides) if sides else None)
    source = numpy_source(rt, "randn", stream)
    return _sample("randn", lambda: source.standard_normal(shape))


def _pool(rt: Runtime, name: str, xs: Any) -> tuple[list[Any] | range, bool]:
    """Return the items to choose from, and whether multiple choices are an array."""
    if type(xs) is float and xs.is_integer():
        xs = int(xs)
    if type(xs) is int:
        if not 0 < xs < _INT64:
            raise SceneError("value", f"`{name}` expects a count above 0, got {show(xs, 30)}")
        return range(xs), True
    members = items(rt, xs, name)
    if not members:
        raise empty_sequence(name)
    return members, rebuild_template(xs) is not NIL


@registry.define("choice", "xs::Any [:size::Any] [:replace::Boolean] [:p::Any] [:stream::Stream]", "Any",
                 "Return a random item of a sequence, or a number from 0 to n-1 for an Integer n. `:size` draws "
                 "several, `:replace #f` each at most once; `:p` are the probabilities of the items.",
                 ("(choice '(a b c) :p '(0 1 0))", "b"))  # fmt: skip
def choice(rt: Runtime, xs: Any, *, size: Any = None, replace: bool = True, p: Any = None, stream: Any = None) -> Any:
    pool, as_array = _pool(rt, "choice", xs)
    shape = _shape(rt, "choice", size)
    probabilities = None if p is None else to_numpy(rt, p, "choice").astype(float)
    if probabilities is not None and probabilities.ndim != 1:
        raise SceneError("value", f"`choice` expects one probability for each item, got {show(p, 40)}")
    if probabilities is not None or not replace:
        rt.meter.check_size(len(pool), "an array")
        rt.charge(len(pool) >> 3)
    # Indices are drawn rather than items, so that the draws are numpy's whatever the items are.
    source = numpy_source(rt, "choice", stream)
    sample = _sample("choice", lambda: source.choice(len(pool), shape, replace, probabilities))
    if type(sample) is int:
        return pool[sample]
    if isinstance(pool, range):
        return sample
    indices = to_numpy(rt, sample)
    rt.charge(indices.size >> 4)
    chosen = [pool[index] for index in indices.ravel().tolist()]
    if as_array:
        return from_numpy(np.array(chosen).reshape(indices.shape))
    return _nested_list(chosen, indices.shape)


def _nested_list(members: list[Any], shape: tuple[int, ...]) -> Any:
    """Return items as nested lists of a shape."""
    for side in reversed(shape[1:]):
        members = [make_list(members[start : start + side]) for start in range(0, len(members), max(1, side))]
    return make_list(members)


def _shuffled(rt: Runtime, name: str, members: list[Any], stream: Any) -> list[Any]:
    """Return the items in the order of numpy's ``shuffle`` of a list."""
    rt.charge(len(members) >> 3)
    order = np.arange(len(members))
    numpy_source(rt, name, stream).shuffle(order)
    return [members[index] for index in order.tolist()]


@registry.define("shuffle", "xs::Sequence [:stream::Stream]", "Sequence",
                 "Return a new list of the items in random order; of a vector, a vector. `shuffle!` works in place.",
                 ("(sort (shuffle '(3 1 2)))", "(1 2 3)"))  # fmt: skip
def shuffle(rt: Runtime, xs: Any, *, stream: Any = None) -> Any:
    return rebuild(rt, rebuild_template(xs), _shuffled(rt, "shuffle", items(rt, xs, "shuffle"), stream))


@registry.define("shuffle!", "xs::Any [:stream::Stream]", "Any", "Shuffle a mutable list or a mutable array in place.",
                 ("(let ((xs (mutable-list 3 1 2))) (shuffle! xs) (length xs))", "3"))  # fmt: skip
def shuffle_in_place(rt: Runtime, xs: Any, *, stream: Any = None) -> None:
    reorder(rt, "shuffle!", xs, lambda members: _shuffled(rt, "shuffle!", members, stream))


@registry.define("permutation", "xs::Any [:stream::Stream]", "Sequence",
                 "Return the numbers from 0 to n-1, or the items of a sequence, in random order.",
                 ("(sort (permutation 4))", "[0 1 2 3]"))  # fmt: skip
def permutation(rt: Runtime, xs: Any, *, stream: Any = None) -> Any:
    is_count = type(xs) is int or type(xs) is float
    if is_count:
        (count,) = shape_argument(rt, xs, "permutation")
        members, kind = list(range(count)), Vector()
        rt.charge(count >> 3)
    else:
        members, kind = items(rt, xs, "permutation"), rebuild_template(xs)
    rt.charge(len(members) >> 3)
    order = numpy_source(rt, "permutation", stream).permutation(len(members)).tolist()
    return rebuild(rt, kind, [members[index] for index in order])


# --- Python's draws --------------------------------------------------------------------------------------------


@registry.define("py-random", "[:stream::Stream]", "Float",
                 "Return a number from 0 up to but excluding 1, as Python's `random.random()`.",
                 ("(let ((x (py-random))) (and (<= 0 x) (< x 1)))", "#t"))  # fmt: skip
def py_random(rt: Runtime, *, stream: Any = None) -> Any:
    return _python_source(rt, "py-random", stream).random()


@registry.define("py-uniform", "low::Number high::Number [:stream::Stream]", "Float",
                 "Return a number between `low` and `high`, as Python's `random.uniform`.",
                 ("(let ((x (py-uniform 2 3))) (and (<= 2 x) (<= x 3)))", "#t"))  # fmt: skip
def py_uniform(rt: Runtime, low: Any, high: Any, *, stream: Any = None) -> Any:
    return _python_source(rt, "py-uniform", stream).uniform(low, high)


@registry.define("py-gauss", "[mean::Number] [deviation::Number] [:stream::Stream]", "Float",
                 "Return a number from the normal distribution, as Python's `random.gauss`.",
                 ("(py-gauss 5 0)", "5.0"))  # fmt: skip
def py_gauss(rt: Runtime, mean: Any = 0.0, deviation: Any = 1.0, *, stream: Any = None) -> Any:
    return float(_python_source(rt, "py-gauss", stream).gauss(mean, deviation))


@registry.define("py-randint", "low::Integer high::Integer [:stream::Stream]", "Integer",
                 "Return an Integer from `low` to `high`, both included, as Python's `random.randint`.",
                 ("(py-randint 5 5)", "5"))  # fmt: skip
def py_randint(rt: Runtime, low: int, high: int, *, stream: Any = None) -> Any:
    source = _python_source(rt, "py-randint", stream)
    return _sample("py-randint", lambda: source.randint(low, high))


@registry.define("py-randrange", "start::Integer [end::Integer] [step::Integer] [:stream::Stream]", "Integer",
                 "Return a random number of `(range start end step)`, as Python's `random.randrange`.",
                 ("(py-randrange 5 6)", "5"))  # fmt: skip
def py_randrange(rt: Runtime, *bounds: int, stream: Any = None) -> Any:
    source = _python_source(rt, "py-randrange", stream)
    return _sample("py-randrange", lambda: source.randrange(*bounds))


@registry.define("py-choice", "xs::Sequence [:stream::Stream]", "Any",
                 "Return a random item, as Python's `random.choice`.",
                 ("(py-choice '(a))", "a"))  # fmt: skip
def py_choice(rt: Runtime, xs: Any, *, stream: Any = None) -> Any:
    members, _ = _pool(rt, "py-choice", xs)
    return _python_source(rt, "py-choice", stream).choice(members)


@registry.define("py-choices", "xs::Sequence [:weights::Any] [:k::Integer] [:stream::Stream]", "List",
                 "Return a list of `:k` (default 1) random items, drawn with replacement, as Python's "
                 "`random.choices`.",
                 ("(py-choices '(a b) :weights '(0 1) :k 3)", "(b b b)"))  # fmt: skip
def py_choices(rt: Runtime, xs: Any, *, weights: Any = None, k: int = 1, stream: Any = None) -> Any:
    members, _ = _pool(rt, "py-choices", xs)
    rt.meter.check_size(max(0, k), "a list")
    cumulative = None
    if weights is not None:
        flat = to_numpy(rt, weights, "py-choices").ravel().tolist()
        cumulative = list(accumulate(flat, initial=0))[1:]
        total = cumulative[-1] if cumulative else 0.0
        if len(cumulative) != len(members) or not math.isfinite(total) or total <= 0:
            raise SceneError("value", "`py-choices` expects a weight for every item, with a sum above 0")
    # Python draws one number for each item, so blocks give the same draws as a single call.
    source = _python_source(rt, "py-choices", stream)
    chosen: list[Any] = []
    for start in range(0, k, _BLOCK_DRAWS):
        count = min(_BLOCK_DRAWS, k - start)
        rt.charge(count >> 3)
        chosen += source.choices(members, cum_weights=cumulative, k=count)
    return make_list(chosen)


@registry.define("py-sample", "xs::Sequence count::Integer [:stream::Stream]", "List",
                 "Return a list of `count` random items, drawn without replacement, as Python's `random.sample`.",
                 ("(sort (py-sample '(3 1 2) 3))", "(1 2 3)"))  # fmt: skip
def py_sample(rt: Runtime, xs: Any, count: int, *, stream: Any = None) -> Any:
    members = items(rt, xs, "py-sample")
    if not 0 <= count <= len(members):
        message = f"`py-sample` expects a count from 0 to {len(members)}, the number of items, got {show(count, 30)}"
        raise SceneError("value", message)
    rt.charge(count >> 2)
    return make_list(_python_source(rt, "py-sample", stream).sample(members, count))


def _py_shuffled(rt: Runtime, name: str, members: list[Any], stream: Any) -> list[Any]:
    """Return the items in the order of Python's ``shuffle``.

    Fisher-Yates as in ``random.shuffle``, which would run for seconds without a check of the limits.
    """
    source = _python_source(rt, name, stream)
    for index in range(len(members) - 1, 0, -1):
        if not index & 1023:
            rt.charge(1024 >> 3)
        other = _below(source, index + 1)
        members[index], members[other] = members[other], members[index]
    return members


def _below(source: Any, limit: int) -> int:
    """Return an integer from 0 up to but excluding ``limit``, as ``random.Random`` does: rejection sampling of bits."""
    bits = limit.bit_length()
    number: int = source.getrandbits(bits)
    while number >= limit:
        number = source.getrandbits(bits)
    return number


@registry.define("py-shuffle", "xs::Sequence [:stream::Stream]", "Sequence",
                 "Return a new list of the items in the order of Python's `random.shuffle`.",
                 ("(sort (py-shuffle '(3 1 2)))", "(1 2 3)"))  # fmt: skip
def py_shuffle(rt: Runtime, xs: Any, *, stream: Any = None) -> Any:
    return rebuild(rt, rebuild_template(xs), _py_shuffled(rt, "py-shuffle", items(rt, xs, "py-shuffle"), stream))


@registry.define("py-shuffle!", "xs::Any [:stream::Stream]", "Any",
                 "Shuffle a mutable list or array in place, as Python's `random.shuffle`.",
                 ("(let ((xs (mutable-list 3 1 2))) (py-shuffle! xs) (length xs))", "3"))  # fmt: skip
def py_shuffle_in_place(rt: Runtime, xs: Any, *, stream: Any = None) -> None:
    reorder(rt, "py-shuffle!", xs, lambda members: _py_shuffled(rt, "py-shuffle!", members, stream))


# --- noise ------------------------------------------------------------------------------------------------------


_MAX_OCTAVES = 32  # of `fbm`


@lru_cache(maxsize=64)
def _lattice(seed: int) -> Numpy:
    """Return a permutation of 0 to 255, twice; numpy guarantees that this generator never changes."""
    from numpy.random import RandomState

    return np.tile(RandomState(seed).permutation(256).astype(np.int64), 2)


def _gradient_noise(points: Numpy, seed: int) -> Numpy:
    """Return the noise (N,) of points (N, 3) by Perlin, "Improving noise" (2002), with a permutation from the seed."""
    table = _lattice(seed)
    cell = np.floor(points)
    x, y, z = (points - cell).T
    i, j, k = (np.mod(cell, 256.0).astype(np.int64)).T
    u, v, w = (t * t * t * (t * (t * 6.0 - 15.0) + 10.0) for t in (x, y, z))

    def corner(a: int, b: int, c: int) -> Numpy:
        """Return the dot product of the gradient at a corner of the cell with the offset from it."""
        bits = table[table[table[(i + a) & 255] + ((j + b) & 255)] + ((k + c) & 255)] & 15
        dx, dy, dz = x - a, y - b, z - c
        first = np.where(bits < 8, dx, dy)
        second = np.where(bits < 4, dy, np.where((bits == 12) | (bits == 14), dx, dz))
        return np.asarray(np.where(bits & 1, -first, first) + np.where(bits & 2, -second, second))

    # trilinear interpolation with the fade curve u, v, w
    rows = [corner(0, b, c) + u * (corner(1, b, c) - corner(0, b, c)) for c in (0, 1) for b in (0, 1)]
    low, high = rows[0] + v * (rows[1] - rows[0]), rows[2] + v * (rows[3] - rows[2])
    return np.asarray(low + w * (high - low))


def _summed(rt: Runtime, points: Numpy, seed: int, octaves: int, gain: float, lacunarity: float) -> Numpy:
    """Return the weighted mean (N,) of ``octaves`` noises at points (N, 3).

    Each octave is ``lacunarity`` times as fine as the one before and has ``gain`` times its weight; each has a seed of
    its own, so that the lattices do not coincide.
    """
    sums = np.empty(len(points))
    for start in range(0, len(points), _BLOCK_DRAWS):
        block, total = points[start : start + _BLOCK_DRAWS], np.zeros(len(points[start : start + _BLOCK_DRAWS]))
        rt.charge(1 + (len(block) * octaves >> (5 if len(block) > 1 else 1)))
        weight, weights = 1.0, 0.0
        for octave in range(octaves):
            number = (seed + octave) % (1 << 31)
            is_one = len(block) == 1
            total += weight * (_noise_at(block[0].tolist(), number) if is_one else _gradient_noise(block, number))
            weights += weight
            block, weight = block * lacunarity, weight * gain
        sums[start : start + _BLOCK_DRAWS] = total / weights
    return sums


def _noise_points(rt: Runtime, name: str, value: Any, seed: int) -> tuple[Numpy, tuple[int, ...]]:
    """Return points (N, 3) and the shape of their result; a number is a point on the x axis."""
    points = np.asarray(to_numpy(rt, value, name), np.float64)
    if points.ndim and not 1 <= points.shape[-1] <= 3:
        raise SceneError("value", f"`{name}` expects a point of one to three numbers, or an array of points")
    if not (np.abs(points) < _MAX_NOISE_COORDINATE).all():
        raise SceneError("value", f"`{name}` expects finite coordinates below 1e15")
    if not 0 <= seed < 1 << 31:
        raise SceneError("value", f"`{name}` expects a :seed of at least 0 and below 2^31, got {seed}")
    width, shape = (points.shape[-1], points.shape[:-1]) if points.ndim else (1, ())
    flat = points.reshape(-1, width)
    rt.meter.reserve(flat.shape[0] * _NOISE_BYTES_PER_POINT)
    return np.pad(flat, ((0, 0), (0, 3 - width))), shape


def _noise_at(point: list[float], seed: int) -> float:
    """Return ``_gradient_noise`` of one point; plain Python is faster than numpy for few numbers."""
    table = _lattice_list(seed)
    i, j, k = map(math.floor, point)
    x, y, z = point[0] - i, point[1] - j, point[2] - k
    u, v, w = (t * t * t * (t * (t * 6.0 - 15.0) + 10.0) for t in (x, y, z))
    i, j, k = i & 255, j & 255, k & 255

    def corner(a: int, b: int, c: int) -> float:
        """Return the dot product of the gradient at a corner of the cell with the offset from it."""
        bits = table[table[table[(i + a) & 255] + ((j + b) & 255)] + ((k + c) & 255)] & 15
        first = x - a if bits < 8 else y - b
        second = y - b if bits < 4 else x - a if bits in (12, 14) else z - c
        return (-first if bits & 1 else first) + (-second if bits & 2 else second)

    def row(b: int, c: int) -> float:
        """Interpolate along x."""
        low = corner(0, b, c)
        return low + u * (corner(1, b, c) - low)

    def layer(c: int) -> float:
        """Interpolate along x and y in the plane z = ``c`` of the cell, 0 or 1."""
        low = row(0, c)
        return low + v * (row(1, c) - low)

    low = layer(0)
    return low + w * (layer(1) - low)


@lru_cache(maxsize=64)
def _lattice_list(seed: int) -> list[int]:
    """Return ``_lattice`` as Python integers."""
    return [int(number) for number in _lattice(seed)]


@registry.define(
    "noise",
    "point::ArrayLike [:seed::Integer]",
    "Any",
    "Return the gradient noise of a point [x], [x y] or [x y z], a smooth function between about -1 and 1 that is 0 at "
    "whole numbers; of an array of points, the array of their noise. `:seed` chooses the function. It is Perlin's of "
    "2002, equal on all machines.",
    ("(round (noise [.5 .25]) 6)", "0.456787"),
)
def noise(rt: Runtime, point: Any, *, seed: int = 0) -> Any:
    points, shape = _noise_points(rt, "noise", point, seed)
    return from_numpy(_summed(rt, points, seed, 1, 1.0, 1.0).reshape(shape))


@registry.define(
    "fbm",
    "point::ArrayLike [:octaves::Integer] [:gain::Number] [:lacunarity::Number] [:seed::Integer]",
    "Any",
    "Return fractal noise, for terrain and textures: a mean of `:octaves` noises, 5 by default. Each is `:lacunarity` "
    "times as fine as the one before, 2 by default, and has `:gain` times its weight, .5 by default.",
    ("(round (fbm [.5 .25 0]) 6)", "0.171245"),
)
def fbm(
    rt: Runtime, point: Any, *, octaves: int = 5, gain: Any = 0.5, lacunarity: Any = 2.0, seed: int = 0
) -> Any:  # fmt: skip
    if not 1 <= octaves <= _MAX_OCTAVES:
        raise SceneError("value", f"`fbm` expects 1 to {_MAX_OCTAVES} :octaves, got {octaves}")
    if not 0.0 < gain <= 1e3 or not 0.0 < lacunarity <= 1e3:
        raise SceneError("value", "`fbm` expects a :gain and a :lacunarity above 0 and up to 1,000")
    points, shape = _noise_points(rt, "fbm", point, seed)
    return from_numpy(_summed(rt, points, seed, octaves, float(gain), float(lacunarity)).reshape(shape))

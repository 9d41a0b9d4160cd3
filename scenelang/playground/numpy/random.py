"""Random numbers of numpy's legacy generator, bit for bit: Python's ``random`` has the same Mersenne Twister inside."""

from __future__ import annotations

import math
import random as _random
from collections.abc import Callable
from typing import Any

from scenelang.playground import MissingError

from . import _F8, _I8, _extents, _finished, arange, asarray, int64, ndarray, searchsorted, take

_STATE = 624  # words of the generator's state


class RandomState:
    """Mersenne Twister with the seeding and the draws of ``numpy.random.RandomState``."""

    def __init__(self, seed: int | None = None) -> None:
        self._source = _random.Random()
        self._spare: float | None = None
        if seed is not None:
            self.seed(seed)

    def seed(self, seed: int) -> None:
        """Start from a number below 2**32, by the generator's first way of seeding."""
        word = int(seed) & 0xFFFFFFFF
        words = []
        for i in range(_STATE):
            words.append(word)
            word = (1812433253 * (word ^ (word >> 30)) + i + 1) & 0xFFFFFFFF
        self._source.setstate((3, (*words, _STATE), None))
        self._spare = None

    def get_state(self) -> Any:
        """Return a state for ``set_state``."""
        return self._source.getstate(), self._spare

    def set_state(self, state: Any) -> None:
        """Go on from a state of ``get_state``."""
        self._source.setstate(state[0])
        self._spare = state[1]

    def _word(self) -> int:
        return self._source.getrandbits(32)

    def _below(self, top: int) -> int:
        """Return an integer from 0 to ``top``: bits under a mask, drawn again while they are above."""
        if top == 0:
            return 0
        mask = (1 << top.bit_length()) - 1
        while True:
            value = self._word() & mask if top <= 0xFFFFFFFF else ((self._word() << 32) | self._word()) & mask
            if value <= top:
                return value

    def _gauss(self) -> float:
        """Return a normal number by the polar method, which makes two at once."""
        if self._spare is not None:
            value, self._spare = self._spare, None
            return value
        while True:
            x = 2.0 * self._source.random() - 1.0
            y = 2.0 * self._source.random() - 1.0
            square = x * x + y * y
            if 0.0 < square < 1.0:
                break
        factor = math.sqrt(-2.0 * math.log(square) / square)
        self._spare = factor * x
        return factor * y

    def _drawn(self, draw: Callable[[], Any], size: Any, kind: Any) -> Any:
        if size is None:
            return draw()
        shape = _extents(size)
        return _finished([draw() for _ in range(math.prod(shape))], shape, kind)

    def random_sample(self, size: Any = None) -> Any:
        """Return numbers from 0 to 1."""
        return self._drawn(self._source.random, size, _F8)

    random = random_sample

    def rand(self, *shape: int) -> Any:
        """Return numbers from 0 to 1 in a shape."""
        return self.random_sample(shape or None)

    def uniform(self, low: Any = 0.0, high: Any = 1.0, size: Any = None) -> Any:
        """Return numbers of a range."""
        a, b = asarray(low, float), asarray(high, float)
        if a.shape or b.shape:
            shape = (a + b).shape if size is None else size
            return a + (b - a) * self.random_sample(shape)
        start, extent = float(a), float(b) - float(a)
        return self._drawn(lambda: start + extent * self._source.random(), size, _F8)

    def normal(self, loc: Any = 0.0, scale: Any = 1.0, size: Any = None) -> Any:
        """Return normal numbers."""
        a, b = asarray(loc, float), asarray(scale, float)
        if (b < 0).any():
            raise ValueError("scale < 0")
        if a.shape or b.shape:
            shape = (a + b).shape if size is None else size
            return a + b * self.standard_normal(shape)
        return self._drawn(lambda: float(a) + float(b) * self._gauss(), size, _F8)

    def standard_normal(self, size: Any = None) -> Any:
        """Return normal numbers of mean 0 and deviation 1."""
        return self._drawn(self._gauss, size, _F8)

    def randn(self, *shape: int) -> Any:
        """Return standard normal numbers in a shape."""
        return self.standard_normal(shape or None)

    def randint(self, low: int, high: int | None = None, size: Any = None, dtype: Any = None) -> Any:
        """Return integers of a half-open range."""
        start, stop = (0, int(low)) if high is None else (int(low), int(high))
        if start >= stop:
            raise ValueError("low >= high")
        return self._drawn(lambda: start + self._below(stop - 1 - start), size, _I8)

    def choice(self, among: Any, size: Any = None, replace: bool = True, p: Any = None) -> Any:
        """Return members of an array, or numbers below an integer."""
        pool = arange(among) if isinstance(among, int) else asarray(among)
        index = self._chosen(len(pool), size, p, replace=replace)
        return pool[index] if size is None else take(pool, index, 0)

    def _chosen(self, count: int, size: Any, p: Any, *, replace: bool) -> Any:
        if not count:
            raise ValueError("'a' cannot be empty unless no samples are taken")
        number = 1 if size is None else math.prod(_extents(size))
        if p is not None and replace:
            cumulated = asarray(p, float).cumsum()
            return searchsorted(cumulated / cumulated[-1], self.random_sample(size), "right")
        if p is not None:
            return self._chosen_once(asarray(p, float), number, size)
        if replace:
            return self.randint(0, count, size)
        if number > count:
            raise ValueError("Cannot take a larger sample than population when 'replace=False'")
        order = self.permutation(count)[:number]
        return order[0] if size is None else order.reshape(size)

    def _chosen_once(self, p: ndarray, number: int, size: Any) -> Any:
        """Return distinct indices with probabilities: draws together, and again for those that occur twice."""
        if (p > 0).sum() < number:
            raise ValueError("Fewer non-zero entries in p than size")
        left = p.copy()
        chosen: list[int] = []
        while len(chosen) < number:
            draws = asarray(self.rand(number - len(chosen)))
            for index in chosen:
                left[index] = 0.0
            cumulated = left.cumsum()
            places = searchsorted(cumulated / cumulated[-1], draws, "right").tolist()
            chosen += list(dict.fromkeys(places))
        return int64(chosen[0]) if size is None else _finished(chosen, (number,), _I8).reshape(size)

    def shuffle(self, items: Any) -> None:
        """Put items in random order, in place."""
        for i in range(len(items) - 1, 0, -1):
            j = self._below(i)
            if i != j:
                first, second = items[i], items[j]
                if isinstance(first, ndarray):
                    first, second = first.copy(), second.copy()
                items[i], items[j] = second, first

    def permutation(self, items: Any) -> Any:
        """Return numbers below an integer, or the rows of an array, in random order."""
        order = arange(items if isinstance(items, int) else len(items))
        self.shuffle(order)
        return order if isinstance(items, int) else asarray(items)[order]


class Generator:
    """Numpy's newer generator, which these arrays do not have."""


def default_rng(seed: Any = None) -> Any:
    """Raise: the newer generator is in the desktop version only."""
    raise MissingError("`numpy.random.default_rng`")

"""The two random streams of a run: numpy's legacy generator and Python's, so that transpiled programs draw alike."""

from __future__ import annotations

import random
from typing import Any


class Streams:
    """Made when first drawn from; ``seed`` sets both."""

    def __init__(self, seed: int) -> None:
        self._seeds: list[int] = [seed, seed]
        self._numpy: Any = None
        self._python: random.Random | None = None

    @property
    def numpy(self) -> Any:
        """A ``numpy.random.RandomState`` (MT19937)."""
        if self._numpy is None:
            from numpy.random import RandomState

            self._numpy = RandomState(self._seeds[0])
        return self._numpy

    @property
    def python(self) -> random.Random:
        if self._python is None:
            self._python = random.Random(self._seeds[1])
        return self._python

    def seed_numpy(self, seed: int) -> None:
        self._seeds[0], self._numpy = seed, None

    def seed_python(self, seed: int) -> None:
        self._seeds[1], self._python = seed, None

    def seed(self, seed: int) -> None:
        """Set both streams, as is done just before the root is evaluated."""
        self.seed_numpy(seed)
        self.seed_python(seed)

    def snapshot(self) -> Any:
        """The state of both streams, for ``restore``."""
        numpy_state = self._numpy.get_state() if self._numpy is not None else None
        python_state = self._python.getstate() if self._python is not None else None
        return tuple(self._seeds), numpy_state, python_state

    def restore(self, snapshot: Any) -> None:
        seeds, numpy_state, python_state = snapshot
        self._seeds, self._numpy, self._python = list(seeds), None, None
        if numpy_state is not None:
            self.numpy.set_state(numpy_state)
        if python_state is not None:
            self.python.setstate(python_state)

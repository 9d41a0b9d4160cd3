"""A run whose changes can be taken back: what an evaluation that fails has changed is put back as it was before."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np

from scenelang.interpreter.runtime import Runtime
from scenelang.interpreter.values import Mutable, Stream

_OWN = ("birth", "observed")
_CONTAINERS = (list, dict, np.ndarray)


class JournaledRuntime(Runtime):
    """Keeps, from ``begin`` on, the first state of every older thing that is about to change."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._journal: dict[int, tuple[Mutable, dict[str, Any]]] = {}
        self._start = 0
        self._streams = self.streams.snapshot()

    def begin(self) -> None:
        """Start a journal: from here on changes can be taken back."""
        self._journal = {}
        self.clock += 1
        self._start = self.clock
        self._streams = self.streams.snapshot()
        self.drew = False

    @property
    def has_changed(self) -> bool:
        """Whether anything older than the journal has changed, or a random number was drawn."""
        return bool(self._journal) or self.drew

    @property
    def has_written(self) -> bool:
        """Whether anything older than the journal has changed."""
        return bool(self._journal)

    def take_back(self) -> None:
        """Put everything back as it was when the journal was begun."""
        for thing, state in self._journal.values():
            for name, value in state.items():
                setattr(thing, name, value)
        self._journal = {}
        self.streams.restore(self._streams)
        self.forget_calls()

    def write(self, thing: Mutable) -> None:
        if 0 <= thing.birth < self._start and id(thing) not in self._journal:
            self._journal[id(thing)] = thing, _state(thing)
        super().write(thing)


def _state(thing: Mutable) -> dict[str, Any]:
    """What a mutable thing holds: containers and generators copied, values as they are, for they have an identity."""
    state = {name: getattr(thing, name) for name in type(thing).__slots__ if name not in _OWN}
    if isinstance(thing, Stream):
        return {name: copy.deepcopy(value) for name, value in state.items()}
    return {name: copy.copy(value) if isinstance(value, _CONTAINERS) else value for name, value in state.items()}

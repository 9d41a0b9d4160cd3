"""Which entities of a scene neural backends take as one: primitives, or intermediate nodes as new leaves (the paper,
appendix "SDS-Based Renderer")."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.ancestry import Ancestry

IntArray = npt.NDArray[np.int64]

_PATH = re.compile(r"\d+(/\d+)*\Z")


@dataclass(frozen=True, slots=True)
class Granularity:
    """Which entities count as one: those ``depth`` below the root (None: only primitives), and the ``named`` ones, each
    by a handle ``<z5>``, by the places of children from the root ``0/2``, or by a word."""

    depth: int | None = None
    named: tuple[str, ...] = ()


def units_of(ancestry: Ancestry, handles: Sequence[str], granularity: Granularity) -> IntArray:
    """For every instance (M,) the one that it counts as: the highest around it that ``granularity`` takes as one, or
    itself. ``handles`` are those of all instances."""
    units = np.arange(len(ancestry)) if granularity.depth is None else ancestry.at_depth(granularity.depth)
    chosen = np.zeros(len(ancestry), bool)
    for name in granularity.named:
        chosen[_called(ancestry, handles, name)] = True
    if chosen.any():
        units = units.copy()
        for level in range(ancestry.deepest + 1):  # from the root, so that what is highest counts
            rows = np.flatnonzero(ancestry.depth == level)
            above = np.where(ancestry.parent[rows] >= 0, ancestry.parent[rows], rows)
            inside = chosen[units[above]] & (above != rows)
            units[rows] = np.where(inside, units[above], np.where(chosen[rows], rows, units[rows]))
    return units


def check_named(frames: Sequence[tuple[Ancestry, Sequence[str]]], granularity: Granularity) -> None:
    """Raises SceneError("value") for a name that nothing has in any of the frames, each with all its handles."""
    for name in granularity.named:
        if not any(_called(ancestry, handles, name) for ancestry, handles in frames):
            hint = "a handle '<z5>', places of children from the root 0/2, or a word; `scenelang tree` shows them"
            raise SceneError("value", f"nothing in the scene is called `{name}`", hint=hint)


def _called(ancestry: Ancestry, handles: Sequence[str], name: str) -> list[int]:
    """The instances that a name of the user's means."""
    if _PATH.match(name):
        wanted = tuple(map(int, name.split("/")))
        level = np.flatnonzero(ancestry.depth == len(wanted)).tolist()
        return [i for i in level if ancestry.path(i) == wanted]
    if name.startswith("<") and name.endswith(">"):
        return [i for i, handle in enumerate(handles) if handle == name[1:-1]]
    of_word = np.array([entity.word == name for entity in ancestry.nodes], bool)
    found: list[int] = np.flatnonzero(of_word[ancestry.node]).tolist()
    return found

"""From what a program asks for to block states that the game has, each with all of its properties."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from scenelang.backends.clip.blocks import by_meaning
from scenelang.backends.minecraft.blocks import AIR_STATE, BlockState, Build, Cells
from scenelang.backends.minecraft.connections import CONNECTED, Choices, IntArray, Surroundings, Traits, connected
from scenelang.backends.minecraft.knowledge import Resolved, Similar, resolve
from scenelang.backends.minecraft.palettes import unified
from scenelang.backends.minecraft.table import Table, load_table
from scenelang.backends.minecraft.voxels import Voxels, ignored
from scenelang.grammar.diagnostics import Diagnostic

_SLAB = 1 << 22  # cells that are looked at together


@dataclass(frozen=True, slots=True, eq=False)
class Settled:
    """A build of whole block states; what was replaced on the way, one warning for each block, and what lays none."""

    build: Build
    warnings: tuple[Diagnostic, ...]


def settled(voxels: Voxels, table: Table | None = None, similar: Similar | None = by_meaning) -> Settled:
    """``voxels`` with states that the version of ``table`` has: unknown blocks replaced (see ``knowledge``), arms and
    corners from the neighbours where the program does not set them, defaults for the rest."""
    table = table or load_table()
    asked = voxels.build
    found = [Resolved(AIR_STATE)] + [
        resolve(state.name, dict(state.properties), table, similar, place)
        for state, place in zip(asked.palette[1:], voxels.places[1:])
    ]
    warnings = {warning.message: warning for each in found for warning in each.warnings}
    build = unified(asked.origin, *_with_neighbours(asked.cells, found, table))
    left_out = ignored(voxels)
    more = (each for each in (left_out, voxels.off_cells) if each is not None)
    return Settled(build, (*warnings.values(), *more))


def _with_neighbours(cells: Cells, found: Sequence[Resolved], table: Table) -> tuple[Cells, list[BlockState]]:
    """The cells, and the states that their numbers mean, where neighbours have had their say."""
    states = [each.state for each in found]
    kinds = [table.blocks[state.name] for state in states]
    traits = Traits.of(states, kinds)
    fresh = cells
    for shape in CONNECTED:
        numbers = np.flatnonzero(traits.shape == shape)
        if not len(numbers):
            continue
        around = Surroundings(cells, _standing(cells, numbers, len(states)))
        own = around.beside((0, 0, 0))
        choices = connected(shape, around, traits)
        if fresh is cells:
            fresh = cells.copy()
        x, y, z = around.at
        fresh[x, y, z] = _numbered(own, choices, found, states)
    return fresh, states


def _standing(cells: Cells, numbers: IntArray, count: int) -> IntArray:
    """The cells (3, N) in which one of ``numbers`` stands."""
    wanted = np.zeros(count, np.bool_)
    wanted[numbers] = True
    slab = max(1, _SLAB // max(1, cells[:1].size))
    parts = []
    for start in range(0, len(cells), slab):
        at = np.array(np.nonzero(wanted[cells[start : start + slab]]), np.int64)
        at[0] += start
        parts.append(at)
    return np.concatenate(parts, axis=1)


def _numbered(own: IntArray, choices: Choices, found: Sequence[Resolved], states: list[BlockState]) -> IntArray:
    """The number of each cell's state, given what its neighbours make of it; new states are added to ``states``."""
    code = own.copy()
    for places, values in choices.values():
        code = code * len(values) + places
    _, first, inverse = np.unique(code, return_index=True, return_inverse=True)
    fresh = []
    for row in first.tolist():
        before = found[int(own[row])]
        made = {name: values[int(places[row])] for name, (places, values) in choices.items()}
        chosen = {name: value for name, value in made.items() if name not in before.given}
        fresh.append(len(states))
        states.append(BlockState(before.state.name, tuple(sorted({**dict(before.state.properties), **chosen}.items()))))
    return np.array(fresh, np.int64)[inverse]

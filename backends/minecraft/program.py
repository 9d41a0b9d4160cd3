"""A build as the text of a program: a word for each block state, which lays merged cuboids.

The program gives the same blocks when it is evaluated and voxelised. Properties that the version does not have, which
older files may name, are left out; those that neighbours would set are written, so that they stay as they are.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import chain, count

import numpy as np

from scenelang.backends.minecraft.asked import NAMESPACE
from scenelang.backends.minecraft.block_names import renamed
from scenelang.backends.minecraft.blocks import BlockState, Build
from scenelang.backends.minecraft.connections import CONNECTED
from scenelang.backends.minecraft.files.written import with_blocks
from scenelang.backends.minecraft.merging import Cuboids, merged
from scenelang.backends.minecraft.table import BlockKind, load_table
from scenelang.grammar.formatter import format_text
from scenelang.grammar.printer import string_text
from scenelang.interpreter.forms import INDENTS
from scenelang.interpreter.shapes import PRIMITIVES

_FEW = 3  # single blocks that stand among the cuboids
_LISTED = 1_000  # cuboids; the numbers of more stand in strings, which are read forty times as fast as lists

Rows = Sequence[Sequence[int]]

_HELPERS = {
    "rows": """; The numbers of a text in rows of `count`.
(define (rows count text)
  (reshape (array (map string->number (string-split text))) [-1 count]))
""",
    "laid": """; Cuboids of one block: the first cell along x, y and z, then how many cells along each.
(define (laid block properties cuboids)
  (for/union (((x y z width height depth) cuboids))
    (transform (call "set-cuboid" :block-type block :block-kwargs properties :scale [width height depth])
               (translate [x y z]))))
""",
    "laid-singly": """; Single blocks: the cell along x, y and z.
(define (laid-singly block properties cells)
  (define one (call "set-cuboid" :block-type block :block-kwargs properties))
  (for/union (((x y z) cells))
    (transform one (translate [x y z]))))
""",
}


def program_text(build: Build, name: str) -> str:
    """The program whose root is the word ``name`` and lays ``build``; raises SceneError("empty-scene") where there is
    no block."""
    cuboids = merged(with_blocks(build).cells)
    words = _words(build.palette, name)
    rows, ends = _by_number(build, cuboids)
    written = _listed if len(cuboids) <= _LISTED else _in_a_string
    shown = zip(words[1:], build.palette[1:], [0, *ends], ends)
    bound = [_bound(word, state, rows[start:end], written) for word, state, start, end in shown]
    calls = " ".join(f"(call {string_text(word)})" for word in words[1:])
    root = string_text(words[0])
    helpers = [text for name, text in _HELPERS.items() if any(f"({name} " in piece for piece in bound)]
    whole = f"(bind {root} (lambda () (union {calls})))\n\n(scene {root})\n"
    return format_text("\n".join([_head(build, name, len(cuboids)), *helpers, *bound, whole]), INDENTS)


def forgotten(build: Build) -> list[str]:
    """The states, sorted, of which the program keeps less than they say: blocks or properties that the version does
    not have."""
    states = build.palette[1:]
    kinds = ((state, _kind(state.name)) for state in states)
    return sorted(
        str(state)
        for state, kind in kinds
        if kind is None or any(value not in kind.values.get(name, ()) for name, value in state.properties)
    )


def _by_number(build: Build, cuboids: Cuboids) -> tuple[list[list[int]], list[int]]:
    """The cuboids as rows of six numbers, sorted by their block, and where the rows of each block but air end."""
    order = np.argsort(cuboids.number, kind="stable")
    rows = np.concatenate([cuboids.low + np.array(build.origin), cuboids.size], axis=1)[order]
    ends = np.searchsorted(cuboids.number[order], np.arange(1, len(build.palette)), side="right")
    return rows.tolist(), ends.tolist()


def _head(build: Build, name: str, count: int) -> str:
    """The comment at the beginning."""
    size, origin = " x ".join(map(str, build.size)), " ".join(map(str, build.origin))
    shown = " ".join(name.split())
    return f"; {shown}: Minecraft blocks in a box of {size} cells from {origin} on, as {count:,} cuboids.\n"


# --- one block state -------------------------------------------------------------------------------------------------


def _bound(word: str, state: BlockState, rows: Rows, written: Callable[[Rows], str]) -> str:
    """The word of a block state, which lays it in the boxes of ``rows``, ``written`` as the program holds them."""
    single = [row[:3] for row in rows if row[3:] == [1, 1, 1]]
    larger = [row for row in rows if row[3:] != [1, 1, 1]]
    if larger and len(single) <= _FEW:
        single, larger = [], list(rows)
    said = [f"({string_text(key)} {string_text(value)})" for key, value in _said(state).items()]
    block = f"{string_text(state.name.removeprefix(NAMESPACE))} {_quoted(said) if said else 'none'}"
    parts = (("laid", larger), ("laid-singly", single))
    calls = [f"({function} {block} {written(part)})" for function, part in parts if part]
    body = calls[0] if len(calls) == 1 else f"(union {' '.join(calls)})"
    return f"(bind {string_text(word)} (lambda () {body}))\n"


def _quoted(items: Iterable[str]) -> str:
    return f"'({' '.join(items)})"


def _listed(rows: Rows) -> str:
    return _quoted(f"({' '.join(map(str, row))})" for row in rows)


def _in_a_string(rows: Rows) -> str:
    lines = "\n".join(" ".join(map(str, row)) for row in rows)
    return f'(rows {len(rows[0])} "\n{lines}")'


def _said(state: BlockState) -> Mapping[str, str]:
    """The properties that have to be said: not what the block has by itself anyway."""
    kind = _kind(state.name)
    given = dict(state.properties)
    if kind is None:
        return given
    possible = {key: value for key, value in given.items() if value in kind.values.get(key, ())}
    if kind.shape in CONNECTED:
        return possible
    return {key: value for key, value in possible.items() if value != kind.defaults[key]}


def _kind(name: str) -> BlockKind | None:
    """What the block is that the game calls ``name`` or called so once."""
    blocks = load_table().blocks
    if name in blocks:
        return blocks[name]
    newer = renamed(name.removeprefix(NAMESPACE), {known.removeprefix(NAMESPACE) for known in blocks})
    return None if newer is None else blocks[NAMESPACE + newer]


# --- words -----------------------------------------------------------------------------------------------------------


def _words(palette: Sequence[BlockState], name: str) -> list[str]:
    """The word of each state of the palette, and in the place of air that of the whole build."""
    taken = set(PRIMITIVES)
    names = Counter(state.name for state in palette)
    differing = {
        block: _differing([state for state in palette if state.name == block])
        for block, count in names.items()
        if count > 1
    }
    words = [_untaken(" ".join(name.split()) or "build", taken)]
    for state in palette[1:]:
        pairs = [pair for pair in state.properties if pair[0] in differing.get(state.name, ())]
        plain = re.sub(r"[_:/]+", " ", state.name.removeprefix(NAMESPACE))
        words.append(_untaken(" ".join([plain, *(_phrase(key, value) for key, value in pairs)]), taken))
    return words


def _differing(states: Sequence[BlockState]) -> set[str]:
    """The properties that tell the states of one block apart."""
    pairs = Counter(pair for state in states for pair in state.properties)
    return {key for (key, _), count in pairs.items() if count < len(states)}


def _phrase(key: str, value: str) -> str:
    """``facing north``, ``not lit``."""
    plain = key.replace("_", " ")
    return {"true": plain, "false": f"not {plain}"}.get(value, f"{plain} {value.replace('_', ' ')}")


def _untaken(word: str, taken: set[str]) -> str:
    """``word``, with a number behind it where it is taken; it is taken then."""
    free = next(each for each in chain([word], (f"{word} {n}" for n in count(2))) if each not in taken)
    taken.add(free)
    return free

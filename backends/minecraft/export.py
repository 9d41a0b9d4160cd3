"""Exports of builds: the blocks that a scene lays, or those that its shapes are filled with, as the game's files."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain, count
from pathlib import Path
from typing import Any

import numpy as np

from scenelang.backends.base import Accepts, Backend, BackendOptions, Option, Work, check_settings, frame_of
from scenelang.backends.files import write_text, written_together, written_whole
from scenelang.backends.minecraft.blocks import BlockState, Build, Cuboids, merged
from scenelang.backends.minecraft.build_files import (
    DEFAULT,
    GameVersion,
    LoadedBuild,
    Lost,
    as_written,
    fitted,
    game_version,
    loaded_litematic,
    loaded_schematic,
    loaded_structure,
    too_new,
    with_blocks,
    write_datapack,
    write_function,
    write_litematic,
    write_schematic,
    write_structure,
)
from scenelang.backends.minecraft.connections import CONNECTED, settled
from scenelang.backends.minecraft.filling import USUAL, filled, in_blocks, palette_of
from scenelang.backends.minecraft.nbt import LARGEST, Damaged, read_nbt
from scenelang.backends.minecraft.table import BlockKind, load_table, renamed
from scenelang.backends.minecraft.voxels import NAMESPACE, voxelised
from scenelang.grammar.datum import string_text
from scenelang.grammar.diagnostics import Diagnostic, LimitError, SceneError
from scenelang.grammar.formatter import format_text
from scenelang.interpreter.expand.forms import INDENTS
from scenelang.interpreter.scene.entity import Entity, Scene
from scenelang.interpreter.scene.primitives import block_words
from scenelang.interpreter.scene.primitives import words as primitive_words

# The JSON of the paper's own renderer of Minecraft scenes, as its published results have it.
#
# ``width``, ``height`` and ``depth`` are the cells along x, y and z of the box around all frames. Each of ``frames``
# is a
# list of cuboids: ``start`` and ``end`` (the cell after the last one) count from the lowest corner of that box,
# ``type``
# is the block, ``properties`` its states, ``fill`` true, ``stack`` the names of the functions that laid it. The
# reference
# writes what its programs lay, one upon the other; here the cuboids are those of the finished build, merged, so they
# do
# not overlap, and ``stack`` is empty.


def write(build: Build, path: Path, version: GameVersion) -> list[Path]:
    """Write ``build`` for ``version`` as the only frame, whole or not at all; the path that was written. Raises
    SceneError: "empty-scene", "file"."""
    return write_frames([build], path, version)


def write_frames(builds: Sequence[Build], path: Path, version: GameVersion) -> list[Path]:
    """Write one or more frames as ``write`` writes one; each of them must lay blocks."""
    named = [as_written(build, version) for build in builds]
    low = np.min([build.origin for build in named], axis=0)
    high = np.max([np.add(build.origin, build.size) for build in named], axis=0)
    sides = dict(zip(("width", "height", "depth"), (high - low).tolist()))
    frames = ("[\n" + ",\n".join(map(json.dumps, _cuboids(build, low))) + "\n]" for build in named)
    head = ", ".join(f"{json.dumps(name)}: {side}" for name, side in sides.items())
    with written_whole(path) as temporary, temporary.open("w", encoding="utf-8") as file:
        file.write("{" + head + ', "frames": [' + ",\n".join(frames) + "]}\n")
    return [path]


def _cuboids(build: Build, corner: np.ndarray[Any, Any]) -> Iterator[dict[str, Any]]:
    cuboids = merged(build.cells)
    low = cuboids.low + (np.array(build.origin) - corner)
    for start, end, number in zip(low.tolist(), (low + cuboids.size).tolist(), cuboids.number.tolist()):
        state = build.palette[number]
        properties = dict(state.properties)
        yield {"start": start, "end": end, "fill": True, "type": state.name, "properties": properties, "stack": []}


# A build as the text of a program: a word for each block state, which lays merged cuboids.
#
# The program gives the same blocks when it is evaluated and voxelised. Properties that the version does not have,
# which older files may name, are left out; those that neighbours would set are written, so that they stay as they
# are.


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
    taken = set(primitive_words())
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


VOXELIZE = Option(
    "voxelize", "fill primitives and meshes with blocks, N of them along the longest side", None, least=1, most=1000
)
PALETTE = Option(
    "palette",
    "the blocks that --voxelize takes, by colour: families (wool, concrete, terracotta, glass, planks, ..., all) and "
    "names of blocks, with commas between",
    USUAL,
    check=palette_of,
)
VERSION = Option(
    "mc-version", "the version of Minecraft that the file is for, from 1.13 on", DEFAULT, check=game_version
)
MOST_FILES = 10_000

Write = Callable[[Build, Path, GameVersion], list[Path]]


def build_of(root: Entity, options: BackendOptions, backend: Backend) -> Build:
    """The blocks of one frame, in whole states; ``options.warn`` is told of what is replaced or left out.

    Raises SceneError: "empty-scene" where nothing is laid, and what ``voxelised``, ``settled`` and ``filled`` raise.
    """
    longest = backend.setting(options, "voxelize")
    if longest is not None:
        return in_blocks(filled(root, longest, options.limit), palette_of(backend.setting(options, "palette")))
    voxels = voxelised(root, options.limit)
    if not voxels.build.cells.any():
        raise SceneError(
            "empty-scene",
            f'the scene "{root.word}" lays no blocks, so there is nothing to export',
            hint="fill its shapes with blocks: --voxelize 64" if voxels.others else None,
        )
    found = settled(voxels)
    for warning in found.warnings:
        _warn(options, warning)
    return found.build


def _warn(options: BackendOptions, warning: Diagnostic | None) -> None:
    if warning is not None and options.warn is not None:
        options.warn(warning)


def _exported(backend: Backend, write: Write, scene: Scene, path: Path, options: BackendOptions) -> list[Path]:
    """Write one file, or, for several frames, one each: OUT-001.schem and so on; all of them or none."""
    version = _version(backend, options)
    roots = _roots(scene, options.frame)
    if len(roots) > MOST_FILES:
        raise LimitError("size", f"there are {len(roots):,} frames, more than the {MOST_FILES:,} files of an export")
    digits = max(3, len(str(len(roots))))
    written: list[Path] = []
    with written_together(path.parent) as folder:
        for number, build in enumerate(_builds(backend, roots, options, version), start=1):
            name = path.name if len(roots) == 1 else f"{path.stem}-{number:0{digits}d}{path.suffix}"
            written += write(build, folder / name, version)
    return [path.parent / one.name for one in written]


def _version(backend: Backend, options: BackendOptions) -> GameVersion:
    check_settings(options, [backend])
    return game_version(backend.setting(options, "mc-version"))


def _builds(
    backend: Backend, roots: Sequence[Entity], options: BackendOptions, version: GameVersion
) -> Iterator[Build]:
    """The build of each frame in the blocks of ``version``; what these lack is told, and how far the work is."""
    for number, root in enumerate(roots, start=1):
        found = fitted(build_of(root, options, backend), version)
        _warn(options, too_new(found.missing, version))
        yield found.build
        if options.progress is not None:
            options.progress(number / len(roots))


def _roots(scene: Scene, frame: int | None) -> Sequence[Entity]:
    return scene.frames if frame is None else (scene.frames[frame_of(scene, frame)],)


def _backend(name: str, doc: str, ending: str, write: Write) -> Backend:
    def run(scene: Scene, path: Path, options: BackendOptions) -> list[Path]:
        return _exported(made, write, scene, Path(path), options)

    made = Backend(name, doc, Work.EXPORT, (ending,), run, (VOXELIZE, PALETTE, VERSION), _ACCEPTS)
    return made


def _write_program(build: Build, path: Path, _: GameVersion) -> list[Path]:
    write_text(path, program_text(build, path.stem))
    return [path]


def _run_json(scene: Scene, path: Path, options: BackendOptions) -> list[Path]:
    """One file for all frames."""
    version = _version(REFERENCE_JSON, options)
    builds = list(_builds(REFERENCE_JSON, _roots(scene, options.frame), options, version))
    return write_frames(builds, Path(path), version)


_ACCEPTS = Accepts(words=block_words(), any_word=False, attributes=("block-type", "block-kwargs", "fill"))

SCHEM = _backend("schem", "Minecraft: Sponge schematic, for WorldEdit and others", ".schem", write_schematic)
LITEMATIC = _backend("litematic", "Minecraft: Litematica schematic", ".litematic", write_litematic)
STRUCTURE = _backend(
    "structure", "Minecraft: structure of structure blocks, pieces of 48 cells", ".nbt", write_structure
)
DATAPACK = _backend("datapack", "Minecraft: data pack whose function lays the build", ".zip", write_datapack)
MCFUNCTION = _backend("mcfunction", "Minecraft: one function that lays the build", ".mcfunction", write_function)
BLOCKS = _backend("blocks", "a program of merged cuboids of blocks", ".scene", _write_program)
REFERENCE_JSON = Backend(
    "minecraft-json",
    "Minecraft: the JSON of the paper's renderer, all frames in one file",
    Work.EXPORT,
    (".json",),
    _run_json,
    (VOXELIZE, PALETTE, VERSION),
    replace(_ACCEPTS, animated=True),
)


# Files of builds read, whatever made them.


_READERS: Mapping[str, tuple[str, Callable[[Mapping[str, Any]], LoadedBuild]]] = {
    ".schem": ("Sponge schematic", loaded_schematic),
    ".litematic": ("Litematica schematic", loaded_litematic),
    ".nbt": ("structure", loaded_structure),
}
ENDINGS = tuple(_READERS)


def read(path: Path, largest: int = LARGEST) -> LoadedBuild:
    """The build in a file, by the ending of its name: ``.schem``, ``.litematic`` or ``.nbt``.

    Block states are taken as they stand: the version need not have them. Raises SceneError("file") for other endings,
    for a file that cannot be read, and where it is damaged or larger, or unpacks to more, than ``largest`` bytes.
    """
    if path.suffix.lower() not in _READERS:
        raise SceneError("file", f"`{path.name}` is no file of blocks that can be read; those are {', '.join(ENDINGS)}")
    name, loaded = _READERS[path.suffix.lower()]
    try:
        return loaded(read_nbt(path, largest))
    except OSError as error:
        raise SceneError("file", f"`{path}` cannot be read: {error.strerror or error}") from error
    except Damaged as problem:
        raise SceneError("file", f"`{path}` is no {name} that can be read: {problem}") from problem


def imported(path: Path) -> tuple[str, list[Diagnostic]]:
    """The program of a file of blocks, and warnings of what it does not have. Raises SceneError."""
    loaded = read(path)
    if not loaded.build.cells.any():
        raise SceneError("empty-scene", f"`{path}` holds no blocks")
    found = (_lost(loaded.lost, path), _forgotten(loaded.build, path))
    return program_text(loaded.build, path.stem), [warning for warning in found if warning is not None]


def _lost(lost: Lost, path: Path) -> Diagnostic | None:
    """The warning that says what of a file the program does not have."""
    blocks, entities = lost.block_entities, lost.entities
    parts = []
    if blocks:
        parts.append(f"what {blocks:,} {'block' if blocks == 1 else 'blocks'} held, such as items or text")
    if entities:
        parts.append(f"{entities:,} {'entity' if entities == 1 else 'entities'}, such as animals or item frames")
    return Diagnostic("lost-contents", f"`{path}` loses {' and '.join(parts)}") if parts else None


def _forgotten(build: Build, path: Path) -> Diagnostic | None:
    """The warning that names the blocks whose states this version does not have."""
    found = forgotten(build)
    if not found:
        return None
    shown = ", ".join(f"`{state}`" for state in found[:8]) + (", .." if len(found) > 8 else "")
    said = f"`{path}` holds states that Minecraft {load_table().version} does not have: {shown}"
    return Diagnostic("lost-contents", said)

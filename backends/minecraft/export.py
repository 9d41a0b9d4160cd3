"""Export and import of builds: blocks placed by a scene, or voxelized shapes, in the game's file formats."""

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
from scenelang.backends.files import atomic_write, atomic_write_all, write_text
from scenelang.backends.minecraft.blocks import BlockKind, BlockState, Build, Cuboids, load_table, merged, renamed
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
from scenelang.backends.minecraft.voxels import NAMESPACE, voxelised
from scenelang.grammar.datum import string_text
from scenelang.grammar.diagnostics import Diagnostic, LimitError, SceneError
from scenelang.grammar.formatter import format_text
from scenelang.interpreter.expand.forms import INDENTS
from scenelang.interpreter.scene.entity import Entity, Scene
from scenelang.interpreter.scene.primitives import block_words
from scenelang.interpreter.scene.primitives import words as primitive_words

# The JSON format of the paper's renderer of Minecraft scenes, as in its published results. ``width``, ``height`` and
# ``depth`` are the numbers of cells along x, y and z of the box around all frames. Each of ``frames`` is a list of
# cuboids: ``start`` and ``end`` (exclusive) are relative to the lowest corner of that box, ``type`` is the block,
# ``properties`` its states, ``fill`` true, ``stack`` the names of the functions that placed it. The reference
# implementation writes all placed cuboids, which may overlap; here they are the merged cuboids of the finished build,
# disjoint, and ``stack`` is empty.


def write(build: Build, path: Path, version: GameVersion) -> list[Path]:
    """Write ``build`` for ``version`` as a single frame, atomically, and return the path.

    Raises SceneError: "empty-scene", "file".
    """
    return write_frames([build], path, version)


def write_frames(builds: Sequence[Build], path: Path, version: GameVersion) -> list[Path]:
    """Write one or more frames like ``write``; none may be empty."""
    named = [as_written(build, version) for build in builds]
    low = np.min([build.origin for build in named], axis=0)
    high = np.max([np.add(build.origin, build.size) for build in named], axis=0)
    sides = dict(zip(("width", "height", "depth"), (high - low).tolist()))
    frames = ("[\n" + ",\n".join(map(json.dumps, _cuboids(build, low))) + "\n]" for build in named)
    head = ", ".join(f"{json.dumps(name)}: {side}" for name, side in sides.items())
    with atomic_write(path) as temporary, temporary.open("w", encoding="utf-8") as file:
        file.write("{" + head + ', "frames": [' + ",\n".join(frames) + "]}\n")
    return [path]


def _cuboids(build: Build, corner: np.ndarray[Any, Any]) -> Iterator[dict[str, Any]]:
    """Yield the merged cuboids of a build as the reference's JSON, relative to ``corner``."""
    cuboids = merged(build.cells)
    low = cuboids.low + (np.array(build.origin) - corner)
    for start, end, number in zip(low.tolist(), (low + cuboids.size).tolist(), cuboids.number.tolist()):
        state = build.palette[number]
        properties = dict(state.properties)
        yield {"start": start, "end": end, "fill": True, "type": state.name, "properties": properties, "stack": []}


# A build as program text: a word for each block state, which places merged cuboids. Evaluating and voxelizing the
# program gives the same blocks. Properties that the current version lacks, which older files may contain, are dropped;
# neighbor-dependent ones are written, so that they are preserved.


_MAX_MIXED_SINGLES = 3  # single blocks to write among the cuboids, instead of in a list of their own
_MAX_LISTED_CUBOIDS = 1_000  # cuboids to write as lists; beyond, strings of numbers, which are read forty times as fast

Rows = Sequence[Sequence[int]]

_HELPERS = {
    "rows": """; Parse a string of numbers into rows of `count`.
(define (rows count text)
  (reshape (array (map string->number (string-split text))) [-1 count]))
""",
    "laid": """; Cuboids of one block: the first cell along x, y and z, then the number of cells along each.
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
    """Return a program that places ``build``, with the root word ``name``.

    Raises SceneError("empty-scene") for an empty build.
    """
    cuboids = merged(with_blocks(build).cells)
    words = _words(build.palette, name)
    rows, ends = _by_number(build, cuboids)
    written = _listed if len(cuboids) <= _MAX_LISTED_CUBOIDS else _in_a_string
    pieces = zip(words[1:], build.palette[1:], [0, *ends], ends)
    bindings = [_bound(word, state, rows[start:end], written) for word, state, start, end in pieces]
    calls = " ".join(f"(call {string_text(word)})" for word in words[1:])
    root = string_text(words[0])
    helpers = [text for name, text in _HELPERS.items() if any(f"({name} " in piece for piece in bindings)]
    root_text = f"(bind {root} (lambda () (union {calls})))\n\n(scene {root})\n"
    return format_text("\n".join([_head(build, name, len(cuboids)), *helpers, *bindings, root_text]), INDENTS)


def forgotten(build: Build) -> list[str]:
    """Return the states, sorted, that the program reproduces incompletely: unknown blocks or properties."""
    states = build.palette[1:]
    kinds = ((state, _kind(state.name)) for state in states)
    return sorted(
        str(state)
        for state, kind in kinds
        if kind is None or any(value not in kind.values.get(name, ()) for name, value in state.properties)
    )


def _by_number(build: Build, cuboids: Cuboids) -> tuple[list[list[int]], list[int]]:
    """Return the cuboids as rows of six numbers, sorted by block, and the end of each block's rows."""
    order = np.argsort(cuboids.number, kind="stable")
    rows = np.concatenate([cuboids.low + np.array(build.origin), cuboids.size], axis=1)[order]
    ends = np.searchsorted(cuboids.number[order], np.arange(1, len(build.palette)), side="right")
    return rows.tolist(), ends.tolist()


def _head(build: Build, name: str, count: int) -> str:
    """Return the comment at the beginning of the program."""
    size, origin = " x ".join(map(str, build.size)), " ".join(map(str, build.origin))
    shown = " ".join(name.split())
    return (
        f"; {shown}: Minecraft blocks in a box of {size} cells with the lowest corner {origin}, as {count:,} cuboids.\n"
    )


# --- one block state -------------------------------------------------------------------------------------------------


def _bound(word: str, state: BlockState, rows: Rows, written: Callable[[Rows], str]) -> str:
    """Return the binding of a block state's word, which places it in ``rows``, serialized with ``written``."""
    single = [row[:3] for row in rows if row[3:] == [1, 1, 1]]
    larger = [row for row in rows if row[3:] != [1, 1, 1]]
    if larger and len(single) <= _MAX_MIXED_SINGLES:
        single, larger = [], list(rows)
    message = [f"({string_text(key)} {string_text(value)})" for key, value in _explicit_properties(state).items()]
    block = f"{string_text(state.name.removeprefix(NAMESPACE))} {_quoted(message) if message else 'none'}"
    parts = (("laid", larger), ("laid-singly", single))
    calls = [f"({function} {block} {written(part)})" for function, part in parts if part]
    body = calls[0] if len(calls) == 1 else f"(union {' '.join(calls)})"
    return f"(bind {string_text(word)} (lambda () {body}))\n"


def _quoted(items: Iterable[str]) -> str:
    """Return items as a quoted list."""
    return f"'({' '.join(items)})"


def _listed(rows: Rows) -> str:
    """Return rows as a quoted list of lists."""
    return _quoted(f"({' '.join(map(str, row))})" for row in rows)


def _in_a_string(rows: Rows) -> str:
    """Return rows as a string of numbers, which the helper `rows` parses."""
    lines = "\n".join(" ".join(map(str, row)) for row in rows)
    return f'(rows {len(rows[0])} "\n{lines}")'


def _explicit_properties(state: BlockState) -> Mapping[str, str]:
    """Return the properties that must be written: those that differ from the defaults or depend on neighbors."""
    kind = _kind(state.name)
    given = dict(state.properties)
    if kind is None:
        return given
    possible = {key: value for key, value in given.items() if value in kind.values.get(key, ())}
    if kind.shape in CONNECTED:
        return possible
    return {key: value for key, value in possible.items() if value != kind.defaults[key]}


def _kind(name: str) -> BlockKind | None:
    """Return the block with the current or former name ``name``, None if unknown."""
    blocks = load_table().blocks
    if name in blocks:
        return blocks[name]
    newer = renamed(name.removeprefix(NAMESPACE), {known.removeprefix(NAMESPACE) for known in blocks})
    return None if newer is None else blocks[NAMESPACE + newer]


# --- words -----------------------------------------------------------------------------------------------------------


def _words(palette: Sequence[BlockState], name: str) -> list[str]:
    """Return the word of each state of the palette; that of air is the root word."""
    taken = set(primitive_words())
    names = Counter(state.name for state in palette)
    differing = {
        block: _differing([state for state in palette if state.name == block])
        for block, count in names.items()
        if count > 1
    }
    words = [_unique(" ".join(name.split()) or "build", taken)]
    for state in palette[1:]:
        pairs = [pair for pair in state.properties if pair[0] in differing.get(state.name, ())]
        plain = re.sub(r"[_:/]+", " ", state.name.removeprefix(NAMESPACE))
        words.append(_unique(" ".join([plain, *(_phrase(key, value) for key, value in pairs)]), taken))
    return words


def _differing(states: Sequence[BlockState]) -> set[str]:
    """Return the properties that distinguish the states of one block."""
    pairs = Counter(pair for state in states for pair in state.properties)
    return {key for (key, _), count in pairs.items() if count < len(states)}


def _phrase(key: str, value: str) -> str:
    """Return a property in words: ``facing north``, ``not lit``."""
    plain = key.replace("_", " ")
    return {"true": plain, "false": f"not {plain}"}.get(value, f"{plain} {value.replace('_', ' ')}")


def _unique(word: str, taken: set[str]) -> str:
    """Return ``word``, with a number appended if necessary to be unique, and record it in ``taken``."""
    free_word = next(name for name in chain([word], (f"{word} {n}" for n in count(2))) if name not in taken)
    taken.add(free_word)
    return free_word


VOXELIZE = Option(
    "voxelize", "voxelise primitives and meshes into blocks, N along the longest side", None, minimum=1, maximum=1000
)
PALETTE = Option(
    "palette",
    "blocks for --voxelize, matched by color: families (wool, concrete, terracotta, glass, planks, ..., all) and "
    "block names, separated by commas",
    USUAL,
    check=palette_of,
)
VERSION = Option("mc-version", "target version of Minecraft, 1.13 or later", DEFAULT, check=game_version)
MAX_FILES = 10_000  # frames of an export, each in its file

Write = Callable[[Build, Path, GameVersion], list[Path]]


def build_of(root: Entity, options: BackendOptions, backend: Backend) -> Build:
    """Return the blocks of one frame, in complete states; ``options.warn`` receives warnings about replacements.

    Raises SceneError: "empty-scene" if nothing is placed, and those of ``voxelised``, ``settled`` and ``filled``.
    """
    longest = backend.setting(options, "voxelize")
    if longest is not None:
        return in_blocks(filled(root, longest, options.limit), palette_of(backend.setting(options, "palette")))
    voxels = voxelised(root, options.limit)
    if not voxels.build.cells.any():
        raise SceneError(
            "empty-scene",
            f'the scene "{root.word}" places no blocks, so there is nothing to export',
            hint="voxelise its shapes with --voxelize 64" if voxels.others else None,
        )
    complete = settled(voxels)
    for warning in complete.warnings:
        _warn(options, warning)
    return complete.build


def _warn(options: BackendOptions, warning: Diagnostic | None) -> None:
    """Report a warning if there is one and a receiver."""
    if warning is not None and options.warn is not None:
        options.warn(warning)


def _exported(backend: Backend, write: Write, scene: Scene, path: Path, options: BackendOptions) -> list[Path]:
    """Write one file, or one per frame (OUT-001.schem, ...), atomically."""
    version = _version(backend, options)
    roots = _roots(scene, options.frame)
    if len(roots) > MAX_FILES:
        raise LimitError(
            "size", f"the scene has {len(roots):,} frames, more than the limit of {MAX_FILES:,} files of an export"
        )
    digits = max(3, len(str(len(roots))))
    written: list[Path] = []
    with atomic_write_all(path.parent, path) as folder:
        for number, build in enumerate(_builds(backend, roots, options, version), start=1):
            name = path.name if len(roots) == 1 else f"{path.stem}-{number:0{digits}d}{path.suffix}"
            written += write(build, folder / name, version)
    return [path.parent / file.name for file in written]


def _version(backend: Backend, options: BackendOptions) -> GameVersion:
    """Return the target version, after checking the settings."""
    check_settings(options, [backend])
    return game_version(backend.setting(options, "mc-version"))


def _builds(
    backend: Backend, roots: Sequence[Entity], options: BackendOptions, version: GameVersion
) -> Iterator[Build]:
    """Yield the build of each frame converted to ``version``; reports missing blocks and progress."""
    for number, root in enumerate(roots, start=1):
        converted = fitted(build_of(root, options, backend), version)
        _warn(options, too_new(converted.missing, version))
        yield converted.build
        if options.progress is not None:
            options.progress(number / len(roots))


def _roots(scene: Scene, frame: int | None) -> Sequence[Entity]:
    """Return the roots of all frames, or of the chosen one."""
    return scene.frames if frame is None else (scene.frames[frame_of(scene, frame)],)


def _backend(name: str, doc: str, ending: str, write: Write) -> Backend:
    """Return a backend that writes one file per frame."""

    def run(scene: Scene, path: Path, options: BackendOptions) -> list[Path]:
        return _exported(backend, write, scene, Path(path), options)

    backend = Backend(name, doc, Work.EXPORT, (ending,), run, (VOXELIZE, PALETTE, VERSION), _ACCEPTS)
    return backend


def _write_program(build: Build, path: Path, _: GameVersion) -> list[Path]:
    """Write the program text of a build, which no version changes."""
    write_text(path, program_text(build, path.stem))
    return [path]


def _run_json(scene: Scene, path: Path, options: BackendOptions) -> list[Path]:
    """Write one file for all frames."""
    version = _version(REFERENCE_JSON, options)
    builds = list(_builds(REFERENCE_JSON, _roots(scene, options.frame), options, version))
    return write_frames(builds, Path(path), version)


_ACCEPTS = Accepts(words=block_words(), any_word=False, attributes=("block-type", "block-kwargs", "fill"))

SCHEM = _backend("schem", "Minecraft: Sponge schematic, for WorldEdit and others", ".schem", write_schematic)
LITEMATIC = _backend("litematic", "Minecraft: Litematica schematic", ".litematic", write_litematic)
STRUCTURE = _backend(
    "structure", "Minecraft: structure for structure blocks, in pieces of 48 cells", ".nbt", write_structure
)
DATAPACK = _backend("datapack", "Minecraft: data pack with a function that places the build", ".zip", write_datapack)
MCFUNCTION = _backend("mcfunction", "Minecraft: single function that places the build", ".mcfunction", write_function)
BLOCKS = _backend("blocks", "program that places the blocks as merged cuboids", ".scene", _write_program)
REFERENCE_JSON = Backend(
    "minecraft-json",
    "Minecraft: the JSON of the paper's renderer, all frames in one file",
    Work.EXPORT,
    (".json",),
    _run_json,
    (VOXELIZE, PALETTE, VERSION),
    replace(_ACCEPTS, animated=True),
)


# Import of build files, also from other programs.


_READERS: Mapping[str, tuple[str, Callable[[Mapping[str, Any]], LoadedBuild]]] = {
    ".schem": ("Sponge schematic", loaded_schematic),
    ".litematic": ("Litematica schematic", loaded_litematic),
    ".nbt": ("structure", loaded_structure),
}
ENDINGS = tuple(_READERS)


def read(path: Path, largest: int = LARGEST) -> LoadedBuild:
    """Read a build file by its extension: ``.schem``, ``.litematic`` or ``.nbt``.

    Block states are not validated against the current version. Raises SceneError("file") for other extensions, for
    files that cannot be read or are damaged, and for more than ``largest`` bytes, compressed or not.
    """
    if path.suffix.lower() not in _READERS:
        raise SceneError("file", f"`{path.name}` is not a supported build file; expected {', '.join(ENDINGS)}")
    name, loaded = _READERS[path.suffix.lower()]
    try:
        return loaded(read_nbt(path, largest))
    except OSError as error:
        raise SceneError("file", f"cannot read `{path}`: {error.strerror or error}") from error
    except Damaged as problem:
        raise SceneError("file", f"`{path}` is not a valid {name}: {problem}") from problem


def imported(path: Path) -> tuple[str, list[Diagnostic]]:
    """Convert a build file to a program; returns its text and warnings about dropped contents. Raises SceneError."""
    loaded = read(path)
    if not loaded.build.cells.any():
        raise SceneError("empty-scene", f"`{path}` contains no blocks")
    warnings = (_lost(loaded.lost, path), _forgotten(loaded.build, path))
    return program_text(loaded.build, path.stem), [warning for warning in warnings if warning is not None]


def _lost(lost: Lost, path: Path) -> Diagnostic | None:
    """Return the warning about contents of a file that the program does not reproduce."""
    blocks, entities = lost.block_entities, lost.entities
    parts = []
    if blocks:
        parts.append(f"the contents of {blocks:,} {'block' if blocks == 1 else 'blocks'}, such as items or text")
    if entities:
        parts.append(f"{entities:,} {'entity' if entities == 1 else 'entities'}, such as animals or item frames")
    return Diagnostic("lost-contents", f"importing `{path}` drops {' and '.join(parts)}") if parts else None


def _forgotten(build: Build, path: Path) -> Diagnostic | None:
    """Return the warning that lists block states unknown to the current version."""
    states = forgotten(build)
    if not states:
        return None
    shown = ", ".join(f"`{state}`" for state in states[:8]) + (", .." if len(states) > 8 else "")
    message = f"`{path}` contains block states that Minecraft {load_table().version} does not have: {shown}"
    return Diagnostic("lost-contents", message)

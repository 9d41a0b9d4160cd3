"""Exports of builds: the blocks that a scene lays, or those that its shapes are filled with, as the game's files."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from scenelang.backends.base import Accepts, Backend, Option, Options, Work, check_settings, frame_of
from scenelang.backends.files import written_together, written_whole
from scenelang.backends.minecraft.blocks import Build
from scenelang.backends.minecraft.color_matching import USUAL, in_blocks, palette_of
from scenelang.backends.minecraft.files import datapack, litematic, reference_json, sponge, structure
from scenelang.backends.minecraft.files.history import fitted, too_new
from scenelang.backends.minecraft.files.versions import DEFAULT, GameVersion, game_version
from scenelang.backends.minecraft.filling import filled
from scenelang.backends.minecraft.program import program_text
from scenelang.backends.minecraft.settle import settled
from scenelang.backends.minecraft.voxels import voxelised
from scenelang.grammar.diagnostics import Diagnostic, LimitError, SceneError
from scenelang.interpreter.entity import Entity, Scene
from scenelang.interpreter.shapes import BLOCK_WORDS

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


def build_of(root: Entity, options: Options, backend: Backend) -> Build:
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


def _warn(options: Options, warning: Diagnostic | None) -> None:
    if warning is not None and options.warn is not None:
        options.warn(warning)


def _exported(backend: Backend, write: Write, scene: Scene, path: Path, options: Options) -> list[Path]:
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


def _version(backend: Backend, options: Options) -> GameVersion:
    check_settings(options, [backend])
    return game_version(backend.setting(options, "mc-version"))


def _builds(backend: Backend, roots: Sequence[Entity], options: Options, version: GameVersion) -> Iterator[Build]:
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
    def run(scene: Scene, path: Path, options: Options) -> list[Path]:
        return _exported(made, write, scene, Path(path), options)

    made = Backend(name, doc, Work.EXPORT, (ending,), run, (VOXELIZE, PALETTE, VERSION), _ACCEPTS)
    return made


def _write_program(build: Build, path: Path, _: GameVersion) -> list[Path]:
    with written_whole(path) as temporary:
        temporary.write_text(program_text(build, path.stem), "utf-8")
    return [path]


def _run_json(scene: Scene, path: Path, options: Options) -> list[Path]:
    """One file for all frames."""
    version = _version(REFERENCE_JSON, options)
    builds = list(_builds(REFERENCE_JSON, _roots(scene, options.frame), options, version))
    return reference_json.write_frames(builds, Path(path), version)


_ACCEPTS = Accepts(words=BLOCK_WORDS, any_word=False, attributes=("block-type", "block-kwargs", "fill"))

SCHEM = _backend("schem", "Minecraft: Sponge schematic, for WorldEdit and others", ".schem", sponge.write)
LITEMATIC = _backend("litematic", "Minecraft: Litematica schematic", ".litematic", litematic.write)
STRUCTURE = _backend(
    "structure", "Minecraft: structure of structure blocks, pieces of 48 cells", ".nbt", structure.write
)
DATAPACK = _backend("datapack", "Minecraft: data pack whose function lays the build", ".zip", datapack.write)
MCFUNCTION = _backend(
    "mcfunction", "Minecraft: one function that lays the build", ".mcfunction", datapack.write_function
)
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

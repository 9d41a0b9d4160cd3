"""Data packs, ``.zip``, and single functions, ``.mcfunction``: the build as commands that the game runs.

A pack called ``house.zip`` goes into the folder ``datapacks`` of a world; ``/function house:build`` then lays the
build around the player, the program's origin in the player's own cell. The game runs at most 65,536 commands for one,
those of called functions counted in, so a larger build is laid part by part, each in a tick of its own; a marker keeps
the place, since functions that are scheduled know of none.
"""

from __future__ import annotations

import json
import re
import zipfile
from collections.abc import Iterator, Sequence
from itertools import product
from pathlib import Path

import numpy as np

from scenelang.backends.files import write_text, written_whole
from scenelang.backends.minecraft.blocks import Build, merged
from scenelang.backends.minecraft.build_files import GameVersion, as_written
from scenelang.backends.minecraft.table import load_table
from scenelang.grammar.diagnostics import SceneError

# A build as the game's commands, places relative to where they run.


MOST_FILLED = 32_768  # cells of one `fill`
_FIRST_STRICT = "1.21.5"

Triple = tuple[int, int, int]


def commands(build: Build, version: GameVersion) -> Iterator[str]:
    """Commands that lay ``build``, which is in the blocks of ``version``, and whose cell c they put at ``~c``.

    Whole cubes come first, and each kind from the ground up, so that torches find the wall that they hang on. From
    1.21.5 on they are ``strict``: the game leaves the states as they are written.
    """
    cuboids = merged(build.cells)
    states = [str(state) for state in build.palette]
    ending = "" if version.is_before(_FIRST_STRICT) else " strict"
    order = np.argsort(_is_late(build)[cuboids.number], kind="stable")
    lows = (cuboids.low[order] + np.array(build.origin)).tolist()
    for low, size, number in zip(lows, cuboids.size[order].tolist(), cuboids.number[order].tolist()):
        block = states[number] + ending
        for a, b in _cuts(low, size):
            if a == b:
                yield f"setblock {_place(a)} {block}"
            else:
                yield f"fill {_place(a)} {_place(b)} {block}"


def _is_late(build: Build) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """For each number of the palette: whether it is laid after the whole cubes."""
    blocks = load_table().blocks
    kinds = [blocks.get(state.name) for state in build.palette]
    return np.array([kind is None or kind.shape != "cube" for kind in kinds])


def _cuts(low: Triple, size: Triple) -> Iterator[tuple[Triple, Triple]]:
    """The first and the last cell of pieces of a cuboid that one ``fill`` may fill."""
    width = min(size[0], MOST_FILLED)
    depth = min(size[2], MOST_FILLED // width)
    height = min(size[1], MOST_FILLED // (width * depth))
    most = (width, height, depth)
    for corner in product(*(range(0, n, step) for n, step in zip(size, most))):
        x, y, z = (a + b for a, b in zip(low, corner))
        w, h, d = (min(step, n - b) for step, n, b in zip(most, size, corner))
        yield (x, y, z), (x + w - 1, y + h - 1, z + d - 1)


def _place(cell: Triple) -> str:
    x, y, z = cell
    return f"~{x} ~{y} ~{z}"


MOST_COMMANDS = 60_000  # of a function, some way below what the game allows
_FIRST_TO_SCHEDULE = "1.14"
_FIRST_WITH_MARKERS = "1.17"
_FIRST_SINGULAR = "1.21"  # its folder is `function`, and was `functions` before
_DATE = (1980, 1, 1, 0, 0, 0)  # the same build gives the same file


def write(build: Build, path: Path, version: GameVersion) -> list[Path]:
    """Write ``build`` as a data pack for ``version``, whole or not at all; the path that was written.

    Raises SceneError: "empty-scene", "unsupported" for too many commands before 1.14, "file".
    """
    name = _namespace(path)
    lines = list(commands(as_written(build, version), version))
    folder = f"data/{name}/{'functions' if version.is_before(_FIRST_SINGULAR) else 'function'}"
    with written_whole(path) as temporary, zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED) as pack:
        _add(pack, "pack.mcmeta", json.dumps({"pack": _about(name, version)}, indent=2))
        for function, body in _functions(name, lines, version):
            _add(pack, f"{folder}/{function}.mcfunction", "\n".join([*body, ""]))
    return [path]


def write_function(build: Build, path: Path, version: GameVersion) -> list[Path]:
    """Write ``build`` as one function for ``version``, whole or not at all; the path that was written.

    Raises SceneError: "empty-scene", "unsupported" for more than MOST_COMMANDS commands, "file".
    """
    lines = list(commands(as_written(build, version), version))
    if len(lines) > MOST_COMMANDS:
        message = f"the build takes {len(lines):,} commands, and one function runs {MOST_COMMANDS:,}"
        raise SceneError("unsupported", message, hint="write a data pack, `.zip`, which lays it part by part")
    write_text(path, "\n".join([*lines, ""]))
    return [path]


def _namespace(path: Path) -> str:
    """The file's name in the letters that names of functions may have."""
    return re.sub(r"[^a-z0-9_.-]+", "_", path.stem.lower()).strip("_") or "scene"


def _about(name: str, version: GameVersion) -> dict[str, object]:
    """What ``pack.mcmeta`` says. Since 1.21.9 the game wants the first and the last format that fit, each with its
    minor number (https://minecraft.wiki/w/Pack.mcmeta)."""
    major, minor = version.pack_format
    described = {"description": f"{name}: /function {name}:build"}
    if minor is None:
        return {"pack_format": major, **described}
    return {"min_format": [major, minor], "max_format": [major, minor], **described}


def _functions(name: str, lines: Sequence[str], version: GameVersion) -> Iterator[tuple[str, list[str]]]:
    """The functions of the pack and their commands, ``build`` first."""
    if len(lines) <= MOST_COMMANDS:
        yield "build", list(lines)
        return
    if version.is_before(_FIRST_TO_SCHEDULE):
        message = (
            f"the build takes {len(lines):,} commands, and Minecraft {version.name} runs {MOST_COMMANDS:,} of a pack"
        )
        raise SceneError("unsupported", message, hint="write a `.schem` or `.nbt`, or choose version 1.14 or later")
    marker = f"@e[tag=scenelang.{name},limit=1]"
    forget = f"kill @e[tag=scenelang.{name}]"
    yield "build", [forget, f"summon {_marker(name, version)}", f"schedule function {name}:step/1 1t"]
    starts = range(0, len(lines), MOST_COMMANDS)
    for part, start in enumerate(starts, 1):
        then = f"schedule function {name}:step/{part + 1} 1t" if part < len(starts) else forget
        yield f"step/{part}", [f"execute at {marker} run function {name}:part/{part}", then]
        yield f"part/{part}", list(lines[start : start + MOST_COMMANDS])


def _marker(name: str, version: GameVersion) -> str:
    """What is summoned where ``build`` runs, without body or look."""
    if version.is_before(_FIRST_WITH_MARKERS):
        return f'minecraft:armor_stand ~ ~ ~ {{Tags:["scenelang.{name}"],Marker:1b,Invisible:1b,NoGravity:1b}}'
    return f'minecraft:marker ~ ~ ~ {{Tags:["scenelang.{name}"]}}'


def _add(pack: zipfile.ZipFile, name: str, text: str) -> None:
    info = zipfile.ZipInfo(name, _DATE)
    info.compress_type = zipfile.ZIP_DEFLATED
    pack.writestr(info, text)

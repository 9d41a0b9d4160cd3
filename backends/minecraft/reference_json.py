"""The JSON of the paper's own renderer of Minecraft scenes, as its published results have it.

``width``, ``height`` and ``depth`` are the cells along x, y and z of the box around all frames. Each of ``frames`` is a
list of cuboids: ``start`` and ``end`` (the cell after the last one) count from the lowest corner of that box, ``type``
is the block, ``properties`` its states, ``fill`` true, ``stack`` the names of the functions that laid it. The reference
writes what its programs lay, one upon the other; here the cuboids are those of the finished build, merged, so they do
not overlap, and ``stack`` is empty.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from scenelang.backends.files import written_whole
from scenelang.backends.minecraft.blocks import Build, merged
from scenelang.backends.minecraft.build_files import GameVersion, as_written


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

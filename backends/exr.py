"""OpenEXR files of several named layers, written by Mitsuba's bitmaps (no variant is needed)."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import need
from scenelang.backends.files import written_whole

_CHANNELS = {1: ("Y",), 2: ("X", "Y"), 3: ("R", "G", "B"), 4: ("R", "G", "B", "A")}


def write_exr(layers: Mapping[str, npt.NDArray[np.float32]], path: Path, xyz: frozenset[str] = frozenset()) -> None:
    """Write ``layers``, each (H, W) or (H, W, C) with C <= 4, as one file of 32-bit floats, whole or not at all.

    The layer called "" has the channels R G B; others ``name.R`` and so on, ``name.X`` ... where named in ``xyz``.
    Raises SceneError: "backend" without Mitsuba, "file" when the file cannot be written.
    """
    mi = need("mitsuba", "mitsuba")
    names: list[str] = []
    columns: list[npt.NDArray[np.float32]] = []
    for name, values in layers.items():
        grid = np.asarray(values, np.float32).reshape(*values.shape[:2], -1)
        channels = ("X", "Y", "Z", "W") if name in xyz else _CHANNELS[grid.shape[2]]
        names += [f"{name}.{channel}" if name else channel for channel in channels[: grid.shape[2]]]
        columns.append(grid)
    joined = np.ascontiguousarray(np.concatenate(columns, axis=2))
    bitmap = mi.Bitmap(joined, pixel_format=mi.Bitmap.PixelFormat.MultiChannel, channel_names=names)
    with written_whole(path) as temporary:
        bitmap.write(str(temporary))

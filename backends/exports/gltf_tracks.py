"""The animation of a glTF file: one sampler and channel for each property that changes over the frames."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.exports.gltf_document import Document

FloatArray = npt.NDArray[np.float64]

_SAME = 2e-7  # the part of a value that single precision does not hold


@dataclass(slots=True)
class Tracks:
    """Frame ``i`` is at ``i / fps`` seconds, where the values are the frame's own, in single precision."""

    document: Document
    fps: float
    samplers: list[dict[str, Any]] = field(default_factory=list)
    channels: list[dict[str, Any]] = field(default_factory=list)
    _times: dict[tuple[int, ...], int] = field(default_factory=dict)

    def add(self, node: int, path: str, values: FloatArray, jumps: bool = False) -> None:
        """Animate ``path`` of a node through ``values`` (F, K), straight between frames or in ``jumps``.

        What never changes gets no track. Of equal values in a row the ends are kept, or the first where it jumps.
        """
        if (np.abs(values - values[0]) <= _SAME * np.abs(values[0]).max()).all():
            return
        same = (values[1:] == values[:-1]).all(axis=1)
        before = np.concatenate([[False], same])
        after = np.concatenate([same, [False]])
        keep = ~before if jumps else ~(before & after)
        keep[-1] = True  # all tracks are equally long
        frames = np.flatnonzero(keep)
        output = self.document.add_array(
            np.ascontiguousarray(values[frames], np.float32), "VEC4" if path == "rotation" else "VEC3"
        )
        self.samplers.append(
            {"input": self._input(frames), "output": output, "interpolation": "STEP" if jumps else "LINEAR"}
        )
        self.channels.append({"sampler": len(self.samplers) - 1, "target": {"node": node, "path": path}})

    def _input(self, frames: npt.NDArray[np.int64]) -> int:
        key = tuple(frames.tolist())
        if key not in self._times:
            self._times[key] = self.document.add_array((frames / self.fps).astype(np.float32), "SCALAR")
        return self._times[key]

    def finish(self, name: str) -> None:
        """Put the animation into the document, where anything moves."""
        if self.channels:
            self.document.animations.append({"name": name, "samplers": self.samplers, "channels": self.channels})

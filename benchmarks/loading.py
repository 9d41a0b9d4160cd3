"""Loads a Menger sponge into Mitsuba and prints seconds and peak memory: ``loading.py placed|plain LEVEL``.

``placed`` is what `render --quality final` does; ``plain`` builds one shape per cube.
"""

from __future__ import annotations

import json
import re
import resource
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from programs import SPONGE

from scenelang.backends.pictures.camera import Viewpoint
from scenelang.backends.pictures.film import PictureOptions
from scenelang.backends.pictures.mitsuba import MITSUBA, MitsubaPainter
from scenelang.backends.pictures.mitsuba_scene import surroundings
from scenelang.backends.pictures.stage import staging_of, still
from scenelang.grammar.datum import Source
from scenelang.session.session import Session


def main(way: str, level: int) -> None:
    scene = Session().evaluate(Source("<bench>", SPONGE.format(level=level))).scene
    assert scene is not None
    options = PictureOptions(width=128, height=128, settings={"samples": 1})
    shot = still(scene, Viewpoint(), 0, 128, 128)
    started = time.perf_counter()
    staging = staging_of(scene, [0], 5_000_000)
    painter = MitsubaPainter(staging, options, 1)
    mi, stage = painter.mitsuba, staging.stage(shot)
    shapes = painter.shapes_of(0, stage) if way == "placed" else plain(mi, stage.solids.matrices)
    loaded = mi.load_dict(surroundings(mi, stage, 8) | shapes)
    seconds = time.perf_counter() - started
    np.array(mi.render(loaded, spp=4))
    print(json.dumps({"backend": MITSUBA.name, "seconds": seconds, "bytes": peak_memory()}))


def peak_memory() -> int:
    """The most bytes that this process held; what ``getrusage`` tells begins with the parent's."""
    status = Path("/proc/self/status")
    if status.exists():
        return int(re.search(r"VmHWM:\s*(\d+)", status.read_text())[1]) * 1024  # type: ignore[index]
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def plain(mi: Any, matrices: np.ndarray) -> dict[str, Any]:
    """One cube for every primitive."""
    bsdf = mi.load_dict({"type": "diffuse"})
    poses = [np.concatenate([matrix, [[0.0, 0.0, 0.0, 1.0]]]) for matrix in matrices]
    return {f"s{i}": {"type": "cube", "bsdf": bsdf, "to_world": mi.ScalarTransform4f(p)} for i, p in enumerate(poses)}


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))

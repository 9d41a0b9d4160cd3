"""Solids: drafts of booleans beside cubes, unions by level beside flat ones, surfaces on disk beside computed ones."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

EXAMPLES = Path(__file__).parent.parent / "examples"
CUBE = '(call "cube" :color [.8 .3 .2])'
BOOLEAN = f'(difference {CUBE} (call "sphere" :radius .6 :color [.2 .4 .9]))'
FIELD = '(bind "field" (lambda () (grid {part} :nx 5 :nz 5 :spacing 1.3)))'
ROUNDED = '(bind "part" (lambda () (rounded (difference (call "cube") (call "cylinder" :radius .2 :p1 [0 2 0])) .1)))'
SIDES = 16


def seconds_of_draft(part: str, rounds: int = 4) -> float:
    """Seconds of one processor for a draft (640 x 480) of 25 copies, the solid being computed."""
    import scenelang as sl

    scene = sl.evaluate(FIELD.format(part=part))
    camera = sl.Camera(azimuth=30, elevation=35)
    times = []
    for _ in range(1 + rounds):
        started = time.process_time()
        scene.render(camera=camera, size=(640, 480))
        times.append(time.process_time() - started)
    return min(times[1:])


def seconds_of_unions(levels: int) -> tuple[int, float, float]:
    """Primitives of the fractal tree, and the seconds to join them level by level and all at once."""
    import manifold3d

    import scenelang as sl
    from scenelang.interpreter.scene.flatten import flatten_entity
    from scenelang.interpreter.scene.modelling.computing import leaf_mesh, manifold_of, manifold_of_mesh
    from scenelang.interpreter.scene.modelling.solid import joined

    root = sl.load(EXAMPLES / "fractal-tree.scene", defines={"levels": levels}).graph.frames[0]
    expression = joined(root, lambda _: SIDES)
    assert expression is not None
    started = time.perf_counter()
    manifold_of(expression).manifold.num_tri()
    by_level = time.perf_counter() - started
    flat = flatten_entity(root)
    made = [manifold_of_mesh(leaf_mesh(entity.shape, SIDES), entity.word) for entity in flat.primitives if entity.shape]
    started = time.perf_counter()
    pieces = [made[which].transform(pose) for which, pose in zip(flat.index, flat.matrices, strict=True)]
    manifold3d.Manifold.batch_boolean(pieces, manifold3d.OpType.Add).num_tri()
    return len(pieces), by_level, time.perf_counter() - started


def seconds_of_surfaces() -> tuple[float, float]:
    """Seconds to read the surface of a rounded part from disk, and to compute it."""
    import scenelang as sl
    from scenelang.interpreter.scene.modelling import stored
    from scenelang.interpreter.scene.modelling.computing import computed
    from scenelang.interpreter.scene.modelling.solid import SolidShape

    shape = sl.evaluate(ROUNDED).graph.root.children[0].car.shape
    assert isinstance(shape, SolidShape)
    started = time.perf_counter()
    computed(shape.expression)
    taken = time.perf_counter() - started
    started = time.perf_counter()
    assert stored.load(shape.expression.digest) is not None
    return time.perf_counter() - started, taken


def bench_solids(row: Callable[[str, float, float, str, str], None]) -> None:
    """Report the rates by ``row(name, ours, other, other_name, target)``, in seconds."""
    with tempfile.TemporaryDirectory() as folder:
        before = os.environ.get("XDG_CACHE_HOME")
        os.environ["XDG_CACHE_HOME"] = folder
        try:
            row("draft of 25 booleans", seconds_of_draft(BOOLEAN), seconds_of_draft(CUBE), "25 cubes", "< 1.3")
            count, by_level, flat = seconds_of_unions(6)
            row(f"union of {count:,} primitives", by_level, flat, "all at once", "< 0.5")
            read, taken = seconds_of_surfaces()
            row("surface of a rounded part, stored", read, taken, "computed", "< 0.2")
        finally:
            del os.environ["XDG_CACHE_HOME"]
            if before is not None:
                os.environ["XDG_CACHE_HOME"] = before


if __name__ == "__main__":
    bench_solids(lambda *cells: print(*cells, flush=True))

"""Rates of datasets: samples per second and core, scaling to two processes, and growth with the number of instances."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

from measuring import HERE, ROOT, Absent, Child, Goal, Pair, Probe, Row, children_seconds, clocked

CHESS = """
programs = ["chessboard.scene"]
count = {count}
[labels]
write = ["instance", "semantic", "depth", "normals"]
[output]
shard = 8
"""
GRID = """
(param n 10)
(bind "dot" (lambda () (call "cube" :scale .8)))
(bind "row" (lambda () (for/union ((i (iota n))) (transform (call "dot") (translate [i 0 0])))))
(bind "sheet" (lambda () (for/union ((i (iota n))) (transform (call "row") (translate [0 0 i])))))
(bind "block" (lambda () (for/union ((i (iota n))) (transform (call "sheet") (translate [0 i 0])))))
"""
BLENDER = ROOT / ".venv" / "blender" / "bin" / "python"


def samples() -> Probe:
    """A sample of the chess set at 256 x 256 after warm-up."""
    from scenelang.datasets.making import Maker
    from scenelang.datasets.spec import spec_of

    maker, numbers = Maker(spec_of(CHESS.format(count=100), "bench", ROOT / "examples")), iter(range(100))
    maker.make(next(numbers))
    return lambda: clocked(lambda: maker.make(next(numbers)))


def seconds_of_maps(views: int = 3) -> float:
    """Seconds of one processor for a picture of `maps` of the chess set, with its other maps and the full shading."""
    command = [sys.executable, "-m", "scenelang", "labels", str(ROOT / "examples" / "chessboard.scene"), "-q"]
    times = []
    with tempfile.TemporaryDirectory() as folder:
        for count in (1, 1 + views):
            started = children_seconds()
            words = [*command, "-o", f"{folder}/{count}", "--views", str(count), "--size", "256x256"]
            subprocess.run(words, check=True, env={**os.environ, "OMP_NUM_THREADS": "1"})
            times.append(children_seconds() - started)
    return (times[1] - times[0]) / views


def seconds_of_processes(jobs: int, count: int = 32) -> float:
    """Seconds of a sample of the chess set with so many processes, without the start of the processes."""
    from scenelang.datasets.running import DatasetProgress, dataset

    seen: list[tuple[float, int]] = []

    def note(progress: DatasetProgress) -> None:
        seen.append((time.perf_counter(), progress.done))

    with tempfile.TemporaryDirectory() as folder:
        spec = Path(folder) / "chess.toml"
        spec.write_text(CHESS.format(count=count).replace('"chess', f'"{ROOT}/examples/chess'))
        dataset(spec, Path(folder) / "out", jobs=jobs, progress=note)
    warm = [each for each in seen if each[1] > 2 * jobs]
    return (warm[-1][0] - warm[0][0]) / (warm[-1][1] - warm[0][1])


def grid(side: int) -> float:
    """Seconds of a warm sample at 256 x 256 of ``side``³ instances."""
    from scenelang.datasets.making import Maker
    from scenelang.datasets.spec import spec_of

    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "grid.scene").write_text(GRID)
        text = f'programs = "grid.scene"\n[params]\nn = {side}\n' + CHESS.split("\n", 3)[3].format(count=2)
        maker = Maker(spec_of(text, "bench", Path(folder)))
        maker.make(0)
        return clocked(lambda: maker.make(1))


def seconds_of_blender() -> float:
    """Seconds of a picture with BlenderProc's passes, where bpy is installed (`make test-blender`)."""
    if not BLENDER.exists():
        raise Absent("bpy is not installed (`make test-blender`)")
    with tempfile.TemporaryDirectory() as folder:
        scene = f"{folder}/chess.glb"
        export = [sys.executable, "-m", "scenelang", "export", str(ROOT / "examples" / "chessboard.scene"), "-o", scene]
        subprocess.run([*export, "-q"], check=True)
        words = [str(BLENDER), str(HERE / "blender_passes.py"), scene, "3", "256"]
        return float(subprocess.run(words, capture_output=True, text=True, check=True).stdout.split()[-1])


def sample_beside(other: Callable[[], float]) -> Iterator[Pair]:
    yield Pair(samples(), other)


def grown(side: int) -> list[Pair]:
    return [Pair(*(Child("labeled.py", (str(each),)) for each in (side, 10)))]


_SAMPLE = "a labeled sample, chess, 256 x 256"
ROWS = (
    Row(_SAMPLE, lambda: [Pair(samples())], goals=(Goal(0.2, "ours"),), rounds=12),
    Row(f"{_SAMPLE}, beside `maps`", partial(sample_beside, seconds_of_maps), "`maps`", rounds=1),
    Row(f"{_SAMPLE}, beside bpy", partial(sample_beside, seconds_of_blender), "BlenderProc's passes", rounds=1),
    Row(
        "a labeled sample, two processes, by the clock",
        lambda: [Pair(partial(seconds_of_processes, 2), partial(seconds_of_processes, 1))], "one process",
        (Goal(0.6),), rounds=1,
    ),
    *(
        Row(f"a labeled sample, {side**3:,} instances", partial(grown, side), "1,000 instances", rounds=1)
        for side in (22, 46)
    ),
)  # fmt: skip


if __name__ == "__main__":
    print(json.dumps({"seconds": grid(int(sys.argv[1]))}))

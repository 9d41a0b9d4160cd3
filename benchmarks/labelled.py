"""Rates of datasets: samples per second and core, scaling to two processes, and growth with the number of instances."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).parent.parent
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


def seconds_per_sample(rounds: int = 12) -> float:
    """Seconds of one processor for a sample of the chess set at 256 x 256 after warm-up, whatever else runs."""
    from scenelang.datasets.making import Maker
    from scenelang.datasets.spec import spec_of

    maker = Maker(spec_of(CHESS.format(count=100), "bench", ROOT / "examples"))
    maker.make(0)
    started = time.process_time()
    for index in range(1, rounds + 1):
        maker.make(index)
    return (time.process_time() - started) / rounds


def seconds_of_maps(views: int = 3) -> float:
    """Seconds of one processor for a picture of `maps` of the chess set, with its other maps and the full shading."""
    command = [sys.executable, "-m", "scenelang", "maps", str(ROOT / "examples" / "chessboard.scene"), "-q"]
    times = []
    with tempfile.TemporaryDirectory() as folder:
        for count in (1, 1 + views):
            started = _of_children()
            words = [*command, "-o", f"{folder}/{count}", "--views", str(count), "--size", "256x256"]
            subprocess.run(words, check=True, env={**os.environ, "OMP_NUM_THREADS": "1"})
            times.append(_of_children() - started)
    return (times[1] - times[0]) / views


def _of_children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


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


def growth() -> list[tuple[int, float]]:
    """Seconds of one processor for a warm sample at 256 x 256 by the number of instances."""
    from scenelang.datasets.making import Maker
    from scenelang.datasets.spec import spec_of

    found = []
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "grid.scene").write_text(GRID)
        for n in (10, 22, 46, 100):
            text = f'programs = "grid.scene"\n[params]\nn = {n}\n' + CHESS.split("\n", 3)[3].format(count=2)
            maker = Maker(spec_of(text, "bench", Path(folder)))
            maker.make(0)
            started = time.process_time()
            maker.make(1)
            found.append((n**3, time.process_time() - started))
    return found


def seconds_of_blender() -> float | None:
    """Seconds of a picture with BlenderProc's passes, None where bpy is not installed (`make test-blender`)."""
    if not BLENDER.exists():
        return None
    with tempfile.TemporaryDirectory() as folder:
        scene = f"{folder}/chess.glb"
        command = [
            sys.executable,
            "-m",
            "scenelang",
            "export",
            str(ROOT / "examples" / "chessboard.scene"),
            "-o",
            scene,
        ]
        subprocess.run([*command, "-q"], check=True)
        script = str(Path(__file__).parent / "blender_passes.py")
        done = subprocess.run([str(BLENDER), script, scene, "3", "256"], capture_output=True, text=True)
    lines = done.stdout.split()
    return float(lines[-1]) if done.returncode == 0 and lines else None


def bench_datasets(row: Callable[[str, float, float, str, str], None]) -> None:
    """Report the rates by ``row(name, ours, other, other_name, target)``, in seconds."""
    one = seconds_per_sample()
    row("a labelled sample, chess, 256 x 256", one, seconds_of_maps(), "`maps`", "< 200 ms")
    blender = seconds_of_blender()
    if blender is not None:
        row("a labelled sample, chess, 256 x 256", one, blender, "bpy, BlenderProc's passes", "(no target)")
    row("a labelled sample, two processes", seconds_of_processes(2), seconds_of_processes(1), "one process", "< 0.6")
    times = growth()
    for count, seconds in times:
        row(
            f"a labelled sample, {count:,} instances", seconds, times[0][1], f"{times[0][0]:,} instances", "(no target)"
        )


if __name__ == "__main__":
    bench_datasets(lambda *cells: print(*cells, flush=True))

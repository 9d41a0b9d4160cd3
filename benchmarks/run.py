"""Side-by-side timings: `make bench`. Every row is a ratio within this run; targets are in the last column.

Native rows are the same computation written as plain Python functions and objects.
"""

from __future__ import annotations

import gc
import json
import os
import resource
import statistics
import subprocess
import sys
import sysconfig
import tempfile
import time
from collections.abc import Callable, Sequence
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import history
import other_lisps
from blocks import cuboids, entities, looped, read_in_a_loop, written_in_a_loop
from exports import bench_exports
from labelled import bench_datasets
from native import chessboard, fib, loop, nested, placed, queens, strings, tak, tree, vectors
from programs import (
    CHESSBOARD,
    FIB,
    LOOP,
    NESTED,
    PLACED,
    QUEENS,
    SPONGE,
    STRINGS,
    TAK,
    TREE,
    VECTORS,
    reader_text,
)
from solids import bench_solids

from scenelang.backends.minecraft.build_files import game_version, write_schematic
from scenelang.backends.minecraft.export import read as read_build
from scenelang.backends.minecraft.voxels import voxelised
from scenelang.backends.pictures.film import PictureOptions, render
from scenelang.grammar.datum import Source
from scenelang.grammar.formatter import format_text
from scenelang.grammar.reader import read
from scenelang.interpreter.evaluation.evaluate import ProgramRun
from scenelang.interpreter.expand.forms import INDENTS
from scenelang.interpreter.runtime.runtime import Runtime
from scenelang.interpreter.scene.entity import Scene
from scenelang.interpreter.scene.flatten import flatten_entity
from scenelang.interpreter.transpile.translate import translate
from scenelang.interpreter.values.limits import Limits
from scenelang.repl.evaluation import ReplEvaluation
from scenelang.sandbox.supervision import limited
from scenelang.sandbox.worker import Worker
from scenelang.session.editing import Editing
from scenelang.session.session import Session, run_with_room
from scenelang.viewer import workspace

ROUNDS = 5
RESPONSES = sorted((Path(__file__).parent.parent / "tests" / "transpile" / "responses").glob("*.txt"))
FIGURE = Path(__file__).parent.parent / "examples" / "paper" / "chessboard.scene"
PUBLISHED = Path(__file__).parent.parent / "tests" / "corpus" / "n16-newtons-cradle.scene"
EXAMPLE = Path(__file__).parent.parent / "examples" / "chessboard.scene"
REFERENCE_IMPORT = 1.0  # seconds that the reference implementation takes to import itself


def best(action: Callable[[], Any], rounds: int = ROUNDS, collecting: bool = False) -> float:
    """Seconds of the fastest of several runs; with ``collecting``, collections of garbage are part of them."""
    fastest = float("inf")
    for _ in range(rounds):
        gc.collect()
        if not collecting:
            gc.disable()
        started = time.perf_counter()
        action()
        fastest = min(fastest, time.perf_counter() - started)
        gc.enable()
    return fastest


def timed_last_form(session: Session, text: str, collecting: bool = False) -> float:
    """Seconds that the last form of a program takes, the others having run."""
    program = session.check(Source("<bench>", text)).program
    assert program is not None

    def once() -> float:
        run = ProgramRun(session.library, Runtime(session.library))
        for form in program.forms[:-1]:
            run.run_form(form)
        return best(lambda: run.run_form(program.forms[-1]), 1, collecting)

    return min(run_with_room(once, 100_000) for _ in range(ROUNDS))


def root_of(session: Session, text: str) -> Scene:
    scene = session.evaluate(Source("<bench>", text)).scene
    assert scene is not None
    return scene


def naive_flatten(entity: Any, matrix: Any, out: list[Any]) -> None:
    """Flattening as a plain recursion over 4x4 arrays."""
    if entity.is_primitive:
        out.append((entity, matrix))
    for part in entity.children:
        m = part.cdr
        naive_flatten(part.car, matrix @ [[*m[0:4]], [*m[4:8]], [*m[8:12]], [0, 0, 0, 1]], out)


RATIOS: dict[str, float] = {}


def row(name: str, ours: float, other: float, other_name: str, target: str) -> None:
    if other_name != "the reference's import":  # a constant: the ratio would tell how fast the machine is
        RATIOS[name] = ours / other
    print(f"{name:34} {ours * 1e3:9.1f} ms   {other_name:28} {other * 1e3:9.1f} ms   x{ours / other:6.2f}   {target}")


def bench_reader() -> None:
    text = reader_text(100_000)
    ours = best(lambda: read(Source("<bench>", text)), 3)
    table = {ord("("): "[", ord(")"): "],"}
    other = best(lambda: json.loads(json.dumps(text.translate(table))), 3)
    row("read 100 KB of text", ours, other, "json of the same bytes", "(no target)")


def bench_front_end(session: Session) -> None:
    """Reading and checking in this process, where the whole is to stay linear."""
    text = reader_text(10_000)
    print(f"{'read 10 KB':34} {best(lambda: read(Source('<bench>', text))) * 1e3:9.1f} ms   {'':45}<= 4 ms")
    program = PUBLISHED.read_text("utf-8")
    checking = best(lambda: session.check(Source("<bench>", program)))
    print(f"{'check a program of 4 KB':34} {checking * 1e3:9.1f} ms   {'':45}<= 3 ms")
    literals = "\n".join(f"{number:09d}" for number in range(100_000))
    checking = best(lambda: session.check(Source("<bench>", literals)), 1)
    print(f"{'check 100,000 literal lines':34} {checking * 1e3:9.1f} ms   {'':45}<= 5,000 ms")


def bench_check(session: Session) -> None:
    text = reader_text(20_000)
    reading = best(lambda: read(Source("<bench>", text)), 3)
    checking = best(lambda: session.check(Source("<bench>", text)), 3)
    row("check 20 KB (expand, analyse)", checking, reading, "reading it", "(no target)")


def bench_programs(session: Session) -> None:
    rows: tuple[tuple[str, str, Callable[[], Any], str], ...] = (
        ("fib 22", FIB, lambda: fib(22), "<= 3"),
        ("loop of 1e6 turns", LOOP, loop, "<= 1.8"),
        ("tak 14 8 2", TAK, lambda: tak(14, 8, 2), "<= 3"),
        ("7 queens with lists", QUEENS, lambda: queens(7), "<= 6"),
        ("string building", STRINGS, strings, "<= 8"),
        ("vector arithmetic", VECTORS, vectors, "<= 8"),
    )
    lisps = other_lisps.seconds()
    for name, text, native, target in rows:
        ours = timed_last_form(session, text)
        row(name, ours, best(native), "native CPython", target)
        for lisp, times in lisps.items():
            if name in times:
                row(f"  {name}, {lisp}", ours, times[name], lisp, "")
    row("chessboard", timed_last_form(session, CHESSBOARD), best(chessboard, 20), "native Python objects", "<= 3")
    scenes: tuple[tuple[str, str, Callable[[], Any], str], ...] = (
        ("1e5 placed entities", PLACED, placed, "<= 1.0"),
        ("random tree of depth 14", TREE, lambda: tree(14), "<= 1.5"),
        ("30 x 1000 poses in nested loops", NESTED, nested, "<= 1.3"),
    )
    for name, text, native, target in scenes:
        ours = timed_last_form(session, text, collecting=True)
        row(name, ours, best(native, collecting=True), "native Python objects, gc on", target)


def bench_flatten(session: Session) -> None:
    import numpy as np

    root = root_of(session, SPONGE.format(level=3)).root
    ours = best(lambda: flatten_entity(root))
    out: list[Any] = []
    other = best(lambda: naive_flatten(root, np.eye(4), out), 1)
    row("flatten 8,000 cubes", ours, other, "recursion over 4x4 arrays", "< 1")
    root = root_of(session, SPONGE.format(level=4)).root
    print(f"{'flatten 160,000 cubes':34} {best(lambda: flatten_entity(root)) * 1e3:9.1f} ms   {'':45}< 100 ms")
    root = root_of(session, SPONGE.format(level=5)).root
    print(f"{'flatten 3,200,000 cubes':34} {best(lambda: flatten_entity(root), 1) * 1e3:9.1f} ms")


def cpu_of(arguments: Sequence[str]) -> float:
    """Seconds of processor time that a process and its children take, the median of ten."""
    taken = []
    for _ in range(10):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(arguments, check=True, capture_output=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        taken.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return statistics.median(taken)


def bench_start() -> None:
    """Processor time of whole processes."""
    command = str(Path(sysconfig.get_path("scripts")) / "scenelang")
    bare = cpu_of([sys.executable, "-c", "pass"])
    row("start-up of `check`, Figure 2", cpu_of([command, "check", str(FIGURE)]), bare, "a bare Python", "<= 11")
    row("start-up of `--help`", cpu_of([command, "--help"]), bare, "a bare Python", "<= 11")
    row("`run`, a program of 4 KB", cpu_of([command, "run", str(PUBLISHED)]), bare, "a bare Python", "")
    row("`import scenelang`", cpu_of([sys.executable, "-c", "import scenelang"]), bare, "a bare Python", "< 15 ms")


def bench_transpile() -> None:
    """Responses of a language model: translated in this process, and by whole processes."""
    texts = {path.stem: path.read_text("utf-8") for path in RESPONSES}
    times = {name: best(partial(translate, Source(name, text)), 3) for name, text in texts.items()}
    slowest = max(times, key=times.__getitem__)
    middle, most = statistics.median(times.values()) * 1e3, times[slowest] * 1e3
    print(f"{f'transpile {len(times)} responses, median':34} {middle:9.1f} ms   {'':45}< 50 ms")
    print(f"{f'  the slowest, {slowest}':34} {most:9.1f} ms")
    command = str(Path(sysconfig.get_path("scripts")) / "scenelang")
    run = lambda *words: subprocess.run([command, *words], check=True, capture_output=True)
    path = str(next(path for path in RESPONSES if path.stem == slowest))
    with tempfile.TemporaryDirectory() as folder:
        out = str(Path(folder) / "out.scene")
        transpiling = best(lambda: run("transpile", path, "-o", out), 3)
        running = best(lambda: run("run", out), 3)
    direct = best(lambda: run("run", path), 3)
    other = "the reference's import"
    row("process `transpile`, the slowest", transpiling, REFERENCE_IMPORT, other, "")
    row("processes `transpile` and `run`", transpiling + running, REFERENCE_IMPORT, other, "< 1")
    row("process `run RESPONSE.txt`", direct, REFERENCE_IMPORT, other, "< 1")


def bench_published(session: Session) -> None:
    """Responses of language models, translated: their check and their evaluation in this process."""
    translations = ((path.stem, translate(Source(path.name, path.read_text("utf-8")))) for path in RESPONSES)
    sources = [Source(name, translation.text) for name, translation in translations if translation.text]
    for name, action in (("check", session.check), ("evaluate", session.evaluate)):
        times = sorted(best(partial(action, source), 2) * 1e3 for source in sources)
        told = f"median {statistics.median(times):.1f}, p90 {times[len(times) * 9 // 10]:.1f}, max {times[-1]:.1f} ms"
        print(f"{f'{name} {len(times)} programs':34} {told}")


def town(size: int) -> str:
    """A scene of 60 words, which takes half a second; ``size`` is of one of them."""
    houses = [
        f"(define (offset{i} k)\n  [(* 3 k) {i} (sin (* k {i}))])\n"
        f'(bind "house{i}"\n  (lambda ()\n    (for*/union ((k (range 60)) (j (range 8)))\n'
        f'      (transform (call "cube" :scale [{size if i == 7 else 1} 1 (+ 1 (* .1 j))])\n'
        f"        (translate (+ (offset{i} k) [0 j 0]))))))\n"
        for i in range(60)
    ]
    calls = "".join(f'\n    (transform (call "house{i}") (translate [0 0 {10 * i}]))' for i in range(60))
    return f'{"".join(houses)}(bind "town"\n  (lambda () (union{calls})))\n(scene "town")\n'


def bench_edits(session: Session) -> None:
    """The new scene after an edit, from the arrival of the changed text, and evaluated from scratch."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "town.scene"
        sizes = iter(range(1, 1_000))
        editing, evaluation = Editing(session), ReplEvaluation(session, str(path))

        def change() -> Source:
            path.write_text(town(next(sizes)), "utf-8")
            return session.source(str(path))

        def reload() -> Scene:
            evaluation.reload(str(path))
            return evaluation.root()

        scratch = best(lambda: session.evaluate(change()), 2)
        editing.evaluate(change())
        reload()
        ours = best(lambda: editing.evaluate(change()))
        row("edit of a word, 430 lines", ours, scratch, "from scratch", "< 50 ms")
        text, unused = town(1), iter(range(1_000))
        editing.evaluate(Source(str(path), text))
        ours = best(lambda: editing.evaluate(Source(str(path), f"(define unused {next(unused)})\n{text}")))
        row("edit of an unrelated definition", ours, scratch, "from scratch", "< 50 ms")
        ours = best(lambda: (change(), reload()))
        row("edit of a word, `,watch`", ours, scratch, "from scratch", "< 50 ms")
        typed = iter(range(1_000))
        define = lambda: evaluation.evaluate(evaluation.source(f'(bind "house3" (lambda () (call "w{next(typed)}")))'))
        row("a word bound in the REPL", best(lambda: (define(), evaluation.root())), scratch, "from scratch", "< 50 ms")
        view = workspace.evaluator(lambda _, __: session, session.options.limits.primitives)
        view(str(path), {})
        ours = best(lambda: (change(), view(str(path), {})))
        row("edit of a word, `view`, its picture", ours, scratch, "from scratch", "(no target)")


def bench_editing(session: Session) -> None:
    """One change in a program of 3,000 lines: only what it concerns, and everything from scratch."""
    forms = [
        f'(define (f{i} x)\n  (* x {i}))\n(bind "w{i}"\n  (lambda ()\n    (call "cube" :scale (f{i} 1))))\n'
        for i in range(600)
    ]
    editing, changes = Editing(session), iter(range(1_000))

    def changed() -> Source:
        return Source("<bench>", "".join([*forms[:300], f"(define (g x) {next(changes)})\n", *forms[300:]]))

    editing.check(changed())
    ours = best(lambda: editing.check(changed()))
    row("check after an edit, 3,000 lines", ours, best(lambda: session.check(changed()), 2), "from scratch", "< 0.1")
    text = changed().text
    shaping = best(lambda: format_text(text, INDENTS), 2)
    row("format 3,000 lines", shaping, best(lambda: session.check(changed()), 2), "check", "< 2")


def bench_loading() -> None:
    """A sponge in Mitsuba: placed prototypes, and one shape per cube, each in a process of its own."""

    def load(way: str, level: int) -> tuple[float, float]:
        command = [sys.executable, str(Path(__file__).with_name("loading.py")), way, str(level)]
        found = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
        return found["seconds"], found["bytes"] / 1e9

    (ours, _), (other, _) = load("placed", 3), load("plain", 3)
    row("load 8,000 cubes into Mitsuba", ours, other, "one shape per cube", "< 1")
    seconds, memory = load("placed", 4)
    told = f"peak {memory:.2f} GB"
    print(f"{'load 160,000 cubes into Mitsuba':34} {seconds * 1e3:9.1f} ms   {told:45}< 5000 ms, < 1.5 GB")


def bench_blocks() -> None:
    """Ten million blocks in cubes of a thousand, and a tenth of them in a plain Python loop."""
    root, tenth = entities(cuboids(10_000, 10)), cuboids(1_000, 10)
    ours = best(lambda: voxelised(root), 2)
    other = best(lambda: looped(tenth), 2)
    row("lay 10,000,000 blocks", ours, 10.0 * other, "10 x a loop over 1,000,000", "< 0.1, < 5000 ms")


def bench_build_files() -> None:
    """A million blocks written as a schematic and read, and their numbers alone in a plain Python loop."""
    build = voxelised(entities(cuboids(1_000, 10))).build
    version = game_version()
    with tempfile.TemporaryDirectory() as folder:
        path, plain = Path(folder) / "a.schem", Path(folder) / "a.gz"
        ours = best(lambda: write_schematic(build, path, version), 3)
        other = best(lambda: written_in_a_loop(build, plain), 1)
        row("write 1,000,000 blocks, .schem", ours, other, "a loop over their box", "< 0.3")
        ours = best(lambda: read_build(path), 3)
        other = best(lambda: read_in_a_loop(plain, build.size), 1)
        row("read them", ours, other, "a loop over their box", "< 0.5")


def bench_pictures(session: Session) -> None:
    """The default picture beside a path traced one."""
    scene = session.evaluate(session.source(str(EXAMPLE))).scene
    assert scene is not None
    still_ = best(lambda: render(scene, PictureOptions()), 2)
    final = best(lambda: render(scene, PictureOptions(settings={"samples": 16}), "final"), 1)
    row("draft picture, 512 x 512", still_, final, "final, 16 samples", "< 1")


def bench_splats() -> None:
    """10,000 Gaussians at 128 x 128, forward and backward; needs torch and numba."""
    if find_spec("torch") is None or find_spec("numba") is None:
        print("splats: torch or numba is not installed")
        return
    from splats import steps

    made = steps(10_000, 128)
    ours, other = (best(made[name]) for name in ("numba", "torch"))
    row("10,000 Gaussians and derivatives", ours, other, "torch, < 1500 ms", "< 300 ms")


def bench_monitor() -> None:
    """What a process of its own costs a call: a fork with the modules loaded, the monitor, the answer's way back."""
    worker = Worker(_nothing)
    ours = best(worker.ask, 20)
    print(f"{'a request in a process of its own':34} {ours * 1e3:9.1f} ms   {'':45}< 5 ms")
    worker.close()


def _nothing() -> None:
    with limited(Limits()):
        pass


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        # whole processes are timed with their bytecode, wherever the package is installed
        os.environ["PYTHONPYCACHEPREFIX"] = folder
        os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
        bench()


def bench() -> None:
    session = Session()
    print(f"{'ours':>47}   {'other':>41}   ratio    target")
    bench_reader()
    bench_front_end(session)
    bench_check(session)
    bench_programs(session)
    bench_flatten(session)
    bench_start()
    bench_monitor()
    bench_transpile()
    bench_published(session)
    bench_editing(session)
    bench_edits(session)
    bench_loading()
    bench_blocks()
    bench_build_files()
    bench_pictures(session)
    bench_splats()
    bench_exports(row)
    bench_datasets(row)
    bench_solids(row)
    history.report(RATIOS)


if __name__ == "__main__":
    main()

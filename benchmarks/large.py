"""Large programs and scenes: 100,000 lines checked, millions of primitives flattened.

``large.py TASK COUNT`` runs one, in a process of its own, since the peak of memory never falls: it prints seconds, and
the bytes by which the peak rose, in all and for each line or primitive.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from functools import partial
from typing import Any

from measuring import Child, Goal, Pair, Row, clocked, peak_memory, timed
from programs import CUBES, SPONGE, binds, python_functions, python_lines, union_of_lines

SIDES = [(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if (x, y, z).count(0) < 2]


def checked(text_of: Callable[[int], str], count: int) -> Callable[[], Any]:
    """The check of a program of as many lines."""
    from scenelang.grammar.datum import Source
    from scenelang.session.session import Session

    session, text = Session(), text_of(count)
    return lambda: session.check(Source("<bench>", text))


def compiled(text_of: Callable[[int], str], count: int) -> Callable[[], Any]:
    """CPython's compile of a program that says the same in as many lines."""
    text = text_of(count)
    return lambda: compile(text, "<bench>", "exec")


def flattened(level: int) -> Callable[[], Any]:
    """`Scene.flatten` of a sponge, with its matrices and colours."""
    import scenelang as sl

    scene = sl.evaluate(SPONGE.format(level=level))

    def arrays() -> Any:
        flat = scene.flatten()
        return flat, flat.matrix, flat.color

    return arrays


def multiplied(level: int) -> Callable[[], Any]:
    """The same arrays by numpy alone: a product a level, and a colour each."""
    import numpy as np

    cell = np.tile(np.eye(4), (len(SIDES), 1, 1))
    cell[:, :3, :3] /= 3.0
    cell[:, :3, 3] = np.array(SIDES) / 3.0

    def arrays() -> Any:
        poses = np.eye(4)[None]
        for _ in range(level):
            poses = (poses[:, None] @ cell).reshape(-1, 4, 4)
        return poses, np.tile([1.0, 1.0, 1.0], (len(poses), 1))

    return arrays


def recursive(level: int) -> Callable[[], Any]:
    """Flattening of the same entities as a plain recursion over 4 x 4 arrays."""
    import numpy as np

    import scenelang as sl

    root = sl.evaluate(SPONGE.format(level=level)).root

    def flatten(entity: Any, matrix: Any, out: list[Any]) -> None:
        if entity.is_primitive:
            out.append((entity, matrix))
        for part in entity.children:
            m = part.cdr
            flatten(part.car, matrix @ [[*m[0:4]], [*m[4:8]], [*m[8:12]], [0, 0, 0, 1]], out)

    return lambda: flatten(root, np.eye(4), [])


def placed(count: int) -> Callable[[], Any]:
    """The evaluation of a loop that places as many cubes."""
    import scenelang as sl

    text = CUBES.format(count=count)
    return lambda: sl.evaluate(text)


def placed_flat(count: int) -> Callable[[], Any]:
    """The arrays of such a scene."""
    scene = placed(count)()
    return lambda: scene.flatten()


TASKS: dict[str, Callable[[int], Callable[[], Any]]] = {
    "members": partial(checked, union_of_lines),
    "binds": partial(checked, binds),
    "Python members": partial(compiled, python_lines),
    "Python functions": partial(compiled, python_functions),
    "flatten": flattened,
    "numpy": multiplied,
    "recursion": recursive,
    "placed": placed,
    "placed, flat": placed_flat,
}


def main(task: str, count: str) -> None:
    TASKS[task](1)()  # loads what is needed
    before = peak_memory()
    seconds = clocked(TASKS[task](int(count)))
    rise = peak_memory() - before
    print(json.dumps({"seconds": seconds, "memory": rise, "each": rise / int(count)}))


def of(task: str, count: int, memory: str = "each") -> Child:
    """Return the probe of a task in a process of its own."""
    return Child("large.py", (task, str(count)), memory)


def here(task: str, other: str, count: int) -> list[Pair]:
    """Return the pair of two tasks in this process."""
    return [Pair(timed(TASKS[task](count)), timed(TASKS[other](count)))]


def _checks(task: str, python: str) -> tuple[Row, ...]:
    return (
        Row(
            f"check of 100,000 lines, {task}", lambda: [Pair(of(task, 100_000), of(task, 10_000))], "10,000 lines",
            (Goal(4.0, "ours"), Goal(11.0), Goal(2_000, "memory")), rounds=1,
        ),
        Row(f"check of 10,000 lines, {task}", partial(here, task, python, 10_000), "CPython's compile", rounds=1),
        Row(f"check of 300 lines, {task}", partial(here, task, python, 300), "CPython's compile", counts=True),
    )  # fmt: skip


ROWS = (
    *_checks("members", "Python members"),
    *_checks("binds", "Python functions"),
    Row("flatten 8,000 cubes", partial(here, "flatten", "recursion", 3), "recursion over 4 x 4 arrays", rounds=3),
    Row("flatten 160,000 cubes", partial(here, "flatten", "numpy", 4), "numpy alone", (Goal(0.07, "ours"),)),
    Row(
        "flatten 3,200,000 cubes", lambda: [Pair(of("flatten", 5, "memory"), of("numpy", 5))], "numpy alone",
        (Goal(2.0, "ours"), Goal(600e6, "memory")), rounds=3,
    ),
    Row(
        "1,000,000 cubes placed by a loop", lambda: [Pair(of("placed", 1_000_000))], goals=(Goal(2.0, "ours"),),
        rounds=2,
    ),
    Row(
        "1,000,000 placed cubes, flattened", lambda: [Pair(of("placed, flat", 1_000_000))],
        goals=(Goal(0.3, "ours"), Goal(200, "memory")), rounds=2,
    ),
)  # fmt: skip


if __name__ == "__main__":
    main(*sys.argv[1:])

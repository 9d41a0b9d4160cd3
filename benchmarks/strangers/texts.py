# Long programs of literal lines, as exporters and language models write them; made when they are needed; 2026-11-29.
from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import Any

import things

LINES = 100_000
WORD_LINES = 1000  # lines of each word of the program "mixed"

# The same line in the language and in Python; "#" is a number.
BLOCK = (
    '(transform (call "cube" :scale [# # #] :color [# # #]) (translate [# # #]))',
    '(Thing("cube", scale=(#, #, #), color=(#, #, #)), translate(#, #, #)),',
)
ROD = (
    '(call "cylinder" :radius # :p0 [# # #] :p1 [# # 2])',
    '(Thing("cylinder", radius=#, p0=(#, #, #), p1=(#, #, 2)), AT_HOME),',
)
CONE = (
    '(transform (call "cone" :radius # :p1 [0 # 0]) (@ (translate [# # #]) (rotate # [0 1 0])))',
    '(Thing("cone", radius=#, p1=(0, #, 0)), product(translate(#, #, #), turn_y(#))),',
)
ROW = ('("oak" [# # #] # "of the north side")', '("oak", (#, #, #), #, "of the north side"),')

PROGRAMS = {"blocks": [BLOCK], "rods": [ROD], "table": [ROW], "mixed": [BLOCK, ROD, CONE]}


def filled(name: str, language: int, count: int) -> Iterator[str]:
    """The lines of a program with their numbers, which are the same for both languages."""
    source = Random(7)
    shapes = [shape[language].replace("#", "{:.3f}") for shape in PROGRAMS[name]]
    sizes = [shape.count("{") for shape in shapes]
    for i in range(count):
        k = i % len(shapes)
        yield shapes[k].format(*(0.01 + source.random() for _ in range(sizes[k])))


def scene_text(name: str, count: int = LINES) -> str:
    """The program: its last form is what is timed."""
    lines = list(filled(name, 0, count))
    if name == "table":
        return "(define rows '(\n" + "\n".join(lines) + "\n))\n\n(round (for/sum ((row rows)) (third row)) 3)\n"
    if name != "mixed":
        return f'(bind "{name}" (lambda () (union\n' + "\n".join(lines) + f')))\n\n(scene "{name}")\n'
    groups = [lines[i : i + WORD_LINES] for i in range(0, count, WORD_LINES)]
    words = [f'(bind "part {i}" (lambda () (union\n' + "\n".join(g) + ")))\n" for i, g in enumerate(groups)]
    calls = "\n".join(f'(transform (call "part {i}") (translate [{2 * i} 0 0]))' for i in range(len(groups)))
    return "\n".join([*words, f'(bind "mixed" (lambda () (union\n{calls})))\n\n(scene "mixed")\n'])


def python_text(name: str, count: int = LINES) -> str:
    """The same in Python: the text sets ``result``."""
    lines = list(filled(name, 1, count))
    if name == "table":
        return "rows = [\n" + "\n".join(lines) + "\n]\nresult = round(sum(row[2] for row in rows), 3)\n"
    if name != "mixed":
        return f'result = count(Thing("{name}", [\n' + "\n".join(lines) + "\n]))\n"
    groups = [lines[i : i + WORD_LINES] for i in range(0, count, WORD_LINES)]
    words = [f'def part_{i}():\n    return Thing("part {i}", [\n' + "\n".join(g) + "\n])" for i, g in enumerate(groups)]
    calls = "\n".join(f"(part_{i}(), translate({2 * i}, 0, 0))," for i in range(len(groups)))
    return "\n".join([*words, f'result = count(Thing("mixed", [\n{calls}\n]))\n'])


def write(name: str, folder: Path, count: int = LINES) -> Path:
    """Write the program into a folder."""
    path = folder / f"{name}.scene"
    path.write_text(scene_text(name, count), "utf-8")
    return path


def run(name: str, count: int = LINES) -> Any:
    """Compile and run the Python text, as the language reads, checks and runs its own."""
    names = dict(vars(things))
    exec(compile(python_text(name, count), f"{name}.py", "exec"), names)  # noqa: S102 (the text is made above)
    return names["result"]

"""Searches for programs that lifting changes: generated ones, and those of the tests and examples.

``python -m tests.lift.searching 5000`` tries that many generated programs.
"""

from __future__ import annotations

import math
import re
import sys
from pathlib import Path
from random import Random
from typing import Any

TESTS = Path(__file__).parent.parent
sys.path.insert(0, str(TESTS))

from differential import HotPrograms
from fuzz.scene_programs import Programs
from support import session

from lift.equality import scene_difference
from scenelang import Source
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.checker.lint import find_root
from scenelang.interpreter.evaluation.evaluate import ProgramRun
from scenelang.interpreter.lift.lift import lift_text
from scenelang.interpreter.runtime.runtime import Runtime
from scenelang.interpreter.values.limits import Limits
from scenelang.session.session import run_with_room

SESSION = session()


def outcome(text: str, steps: int = 50_000) -> Any:
    """Return the scene of a program, what it printed, and the next random numbers; None if it has errors."""
    checked = SESSION.check(Source("<test>", text))
    program = checked.program
    if program is None or not checked.ok:
        return None
    rt = Runtime(SESSION.library, Limits(steps=steps, seconds=20.0))
    run = ProgramRun(SESSION.library, rt)

    def go() -> Any:
        for form in program.forms:
            run.run_form(form)
        return run.run_root(program, find_root(program)[0], 0)

    try:
        scene = run_with_room(go, 2_000)
    except (SceneError, RecursionError):
        return None
    return scene, list(rt.log), repr(rt.streams.python.random()), repr(rt.streams.numpy.random_sample())


def difference(text: str) -> str | None:
    """Return what lifting changes in a program, besides its text."""
    before = outcome(text)
    if before is None:
        return None
    lifted = lift_text(Source("<test>", text), SESSION.library.names)
    if lifted == text:
        return None
    after = outcome(lifted, 500_000)
    if after is None:
        errors = SESSION.evaluate(Source("<test>", lifted)).diagnostics
        return f"the lifted program has errors: {[d.message for d in errors if d.is_error]}\n{lifted}"
    found = scene_difference(before[0], after[0])
    if found is None and before[1:] != after[1:]:
        found = f"{before[1:]} and {after[1:]}"
    return f"{found}\n{lifted}" if found is not None else None


class ShapePrograms:
    """Draws programs of the kind that lifting is for: parts with poses, loops over indices, tables, draws, state."""

    def __init__(self, seed: int) -> None:
        self.random = Random(seed)
        self.count = 0

    def program(self) -> str:
        pick = self.random
        forms = [f"(define size {self.number()})"] if pick.random() < 0.5 else []
        if pick.random() < 0.3:
            forms.append("(define total 0)")
        forms.append(f'(bind "part" (lambda ((:n 2) (:w 1)) {self.body(["n", "w"], 2)}))')
        if pick.random() < 0.5:
            forms.append(f'(bind "other" (lambda () {self.body([], 1)}))')
        else:
            forms.append('(bind "other" (lambda () (call "sphere" :radius (uniform .1 .5))))')
        default = f"(:size {self.number()})" if pick.random() < 0.4 else ""
        forms.append(f'(bind "root" (lambda ({default}) {self.body(["size"] if default else [], 3)}))')
        if "size" in "".join(forms) and not any(form.startswith("(define size") for form in forms):
            forms.insert(0, "(define size 2)")
        if "total" in "".join(forms) and not any(form.startswith("(define total") for form in forms):
            forms.insert(0, "(define total 0)")
        forms.append('(scene "root")')
        return "\n".join(forms) + "\n"

    def number(self) -> str:
        return self.random.choice(["1", "2", "3", ".5", "1.5", "-1", "4", "0.25"])

    def name(self) -> str:
        self.count += 1
        return self.random.choice(["a", "b", "x", "leg", "top", "angle", "ring", "grid", "p"]) + str(self.count % 4)

    def body(self, names: list[str], depth: int) -> str:
        pick, names = self.random, list(names)
        statements: list[str] = []
        shapes: list[str] = []
        used: set[str] = set()
        for _ in range(pick.randint(0, 4)):
            name = self.name()
            if name in used or name in names:
                continue
            used.add(name)
            kind = pick.random()
            note = pick.choice(["", "", "", "  ; why\n"])
            if kind < 0.35:
                statements.append(f"(define {name} {self.scalar(names)}){note}")
                names.append(name)
            elif kind < 0.8:
                statements.append(f"(define {name} {self.shape(names, shapes, depth)}){note}")
                shapes.append(name)
            elif kind < 0.9 and shapes:
                shape = pick.choice(shapes)
                statements.append(f"(define-values (_ {name} _) (compute-shape-{pick.choice(['min', 'max'])} {shape}))")
                names.append(name)
            else:
                statements.append(f"(set! total (+ total {self.scalar(names)}))")
        members = [self.shape(names, shapes, depth) for _ in range(pick.randint(1, 4))]
        members += [pick.choice(shapes)] if shapes else []
        last = pick.choice([f"(union {' '.join(members)})", members[-1]])
        return " ".join([*statements, last])

    def scalar(self, names: list[str]) -> str:
        pick = self.random
        kind = pick.random()
        if names and kind < 0.45:
            return pick.choice(names)
        if kind < 0.65:
            return self.number()
        if kind < 0.7:
            return "(uniform 0 1)"
        if kind < 0.75:
            return "total"
        a, b = self.scalar(names), self.scalar(names)
        return pick.choice(
            [f"(+ {a} {b})", f"(* {a} {b})", f"(- {a})", f"(/ (- {a}) 2)", f"(* 2 pi {a})", f"(if (> {a} 1) {a} {b})"]
        )

    def vector(self, names: list[str]) -> str:
        return f"[{self.scalar(names)} {self.scalar(names)} {self.random.choice(['0', self.scalar(names)])}]"

    def matrix(self, names: list[str]) -> str:
        pick = self.random
        one = pick.choice(
            [
                f"(translate {self.vector(names)})",
                f"(translate [{self.number()} 0 {self.number()}])",
                f"(rotate {self.scalar(names)} [0 1 0])",
                f"(rotate {self.number()} [1 0 0] [0 {self.number()} 0])",
                "(scale 2)",
            ]
        )
        return f"(@ {one} {self.matrix(names)})" if pick.random() < 0.2 else one

    def shape(self, names: list[str], shapes: list[str], depth: int) -> str:
        pick = self.random
        kind = pick.random()
        if shapes and kind < 0.2:
            return pick.choice(shapes)
        if depth and kind < 0.55:
            return self.loop(names, shapes, depth - 1)
        if kind < 0.75:
            return f"(transform {self.shape(names, shapes, depth)} {self.matrix(names)})"
        if kind < 0.85:
            rows = [f'(transform (call "cube" :scale {self.number()}) (translate [{self.number()} 0 {self.number()}]))']
            rows *= pick.randint(2, 3)
            return "(union " + " ".join(row.replace("1", self.number(), 1) for row in rows) + ")"
        words = ['"cube"', '"sphere"', '"other"', '"part" :n ' + self.scalar(names)]
        return f"(call {pick.choice(words)})"

    def loop(self, names: list[str], shapes: list[str], depth: int) -> str:
        pick = self.random
        n, i = pick.choice(["3", "4", "6"]), "i" + str(depth)
        inner = [*names, i]
        part = self.shape(pick.choice([names, inner]), shapes, depth)
        angle = pick.choice(
            [
                f"(* {i} (/ tau {n}))",
                f"(/ (* 2 pi {i}) {n})",
                f"(/ (* {i} pi) {n})",
                f"(+ 1 (* {i} .5))",
                self.scalar(inner),
            ]
        )
        radius = pick.choice([self.number(), self.scalar(names)])
        pose = pick.choice(
            [
                f"(rotate {angle} [0 1 0])",
                f"(@ (rotate {angle} [0 1 0]) (translate [0 {self.number()} {radius}]))",
                f"(translate [(* {radius} (cos {angle})) {self.scalar(inner)} (* {radius} (sin {angle}))])",
                f"(translate [(* {radius} (sin {angle})) 0 (* {radius} (cos {angle}))])",
                f"(translate [(* (- {i} (/ (- {n} 1) 2)) {radius}) 0 {self.scalar(names)}])",
                f"(@ (translate [(* {radius} (cos {angle})) 0 (* {radius} (sin {angle}))]) (rotate (- {angle}) [0 1 0]))",
                self.matrix(inner),
            ]
        )
        body = f"(transform {part} {pose})"
        if pick.random() < 0.3:
            body = f"(define a9 {angle}) {body.replace(angle, 'a9')}"
        if pick.random() < 0.3:
            return self.table(part.replace(i, "x"))
        if pick.random() < 0.2:
            return (
                f"(union-loop 12 (lambda (k) (define-values (row col) (floor/ k 4)) (transform {part.replace(i, 'row')} "
                f"(translate [(* (- col 1.5) {radius}) 0 (* (- row 1) {self.number()})]))))"
            )
        return pick.choice(
            [
                f"(union-loop {n} (lambda ({i}) {body}))",
                f"(for/union (({i} (range {n}))) {body})",
                f"(for/union (({i} '(-1 1))) {body})",
                f"(for/union (({i} '(0 1 2))) {body})",
            ]
        )

    def table(self, part: str) -> str:
        """Loop over a table, or similar parts, with columns that may follow a formula."""
        pick, n = self.random, self.random.randint(3, 7)
        start, step = pick.choice([0, 1, 0.5, -2.0, 1.25]), pick.choice([1, 2, 0.1, -0.3, 1 / 3, 0.125])
        turn = pick.choice([math.tau / n, 0.4, -math.tau / n])
        columns = {
            "x": [start + step * k for k in range(n)],
            "y": [pick.choice([0, 1, 0.5]) for _ in range(n)],
            "u": [2 * math.sin(start + turn * k) for k in range(n)],
            "v": [2 * math.cos(start + turn * k) for k in range(n)],
        }
        pose = pick.choice(["(translate [u y v])", "(translate [x 0 y])", "(rotate x [0 1 0])", "(translate [u x v])"])
        pose = pick.choice([pose, f"(@ {pose} (rotate x [0 1 0]))"])
        shape = pick.choice([part, '(call "cube" :scale x)', '(call "sphere" :color [.1 .2 y])'])
        body = f"(transform {shape} {pose})"
        rows = list(zip(*columns.values()))
        if pick.random() < 0.5:
            table = " ".join(f"({' '.join(map(repr, row))})" for row in rows)
            return f"(for/union (((x y u v) '({table}))) {body})"
        members = []
        for row in rows:
            text = body
            for name, value in zip(columns, row):
                text = re.sub(rf"(?<![\w.-]){name}(?![\w-])", repr(value), text)
            members.append(text)
        return f"(union {' '.join(members)})"


def main(count: int, first: int = 0) -> None:
    differing = tried = 0
    for seed in range(first, first + count):
        kind = (ShapePrograms, ShapePrograms, HotPrograms, Programs)[seed % 4]
        text = kind(seed).program()
        tried += outcome(text) is not None
        try:
            found = difference(text)
        except Exception as error:
            import traceback

            found = "".join(traceback.format_exception(error)[-3:])
        if found is not None:
            differing += 1
            print(f"--- seed {seed}\n{text}\n{found}", flush=True)
            if differing > 5:
                break
    print(f"{count} programs, {tried} of them valid, {differing} differ")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))

"""Runs programs by closures alone and by generated code, and compares all that can be observed.

``python -m tests.differential 20000`` runs that many generated programs, besides those of the tests, the examples and the
corpus.
"""

from __future__ import annotations

import sys
from functools import cache
from pathlib import Path
from random import Random
from typing import Any

from fuzz.scene_programs import Programs
from support import geometry, session

from scenelang import Source
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.checker.lint import find_root
from scenelang.interpreter.checker.program import Program
from scenelang.interpreter.evaluation.evaluate import ProgramRun
from scenelang.interpreter.runtime.runtime import Runtime
from scenelang.interpreter.runtime.show import show
from scenelang.interpreter.values.limits import Limits
from scenelang.session.session import run_with_room

TESTS = Path(__file__).parent
import warnings

warnings.simplefilter("error", SyntaxWarning)
SESSION = session()
DEPTH = 400  # of calls; how deep a recursion gets before this limit is the only difference


def checked(text: str) -> Program | None:
    """Return the program, if it can be run; Python of a language model is translated."""
    result = SESSION.check(Source("<test>", text))
    return result.program if result.ok else None


def observed(program: Program, hot: int | None, steps: int = 20_000, deep: int = 4_000) -> Any:
    """Return what a program does: values of its forms, log, scene, errors with their places, draws and steps."""
    rt = Runtime(SESSION.library, Limits(steps=steps, seconds=60.0), hot=hot)
    run = ProgramRun(SESSION.library, rt)
    seen: list[Any] = []

    def go() -> None:
        for form in program.forms:
            try:
                seen.append(show(run.run_form(form), 400))
            except SceneError as error:
                seen.append(_described(error))
                if error.name in ("steps", "time"):
                    return
            seen.append(rt.meter.total)
        try:
            seen.append(geometry(run.run_root(program, find_root(program)[0], 0)))
        except SceneError as error:
            seen.append(_described(error))

    try:
        run_with_room(go, deep)
    except RecursionError:
        return ["depth"]
    warnings = [(d.name, d.message, d.span) for d in rt.warnings.values()]
    draws = [repr(rt.streams.python.random()), repr(rt.streams.numpy.random_sample())]
    return [*seen, rt.log, warnings, draws, rt.meter.total, rt.entities]


def _described(error: SceneError) -> Any:
    d = error.diagnostic
    return d.name, d.message, d.hint, d.span, d.calls if hasattr(d, "calls") else tuple(error.chain)


def difference(text: str, hot: int = 2) -> str | None:
    """Return the first difference between the two evaluations of a program, or None."""
    program = checked(text)
    if program is None:
        return None
    one, two = observed(program, None), observed(program, hot)
    if one == two or ["depth"] in (one, two):
        return None
    for a, b in zip(one, two):
        if a != b:
            return f"closures: {a}\ngenerated: {b}"
    return f"{len(one)} and {len(two)} observations"


class HotPrograms:
    """Draws programs whose functions and loops become hot, with all kinds of parameters, jumps and mistakes."""

    def __init__(self, seed: int) -> None:
        self.random = Random(seed)
        self.count = 0
        self.functions: list[tuple[str, int]] = []

    def program(self) -> str:
        pick = self.random
        self.count, self.functions = 0, []
        forms = ["(define total 0)", "(define fixed 3)"]
        for _ in range(pick.randint(1, 3)):
            forms.append(self._function())
        if pick.random() < 0.3:
            level = self._value(["level"], 2)
            forms.append(
                f'(bind "w" (lambda ((:level 1)) (if (< level 1) (call "cube" :scale 1)'
                f' (union (call "w" :level (- level 1)) (transform (call "sphere" :radius 1)'
                f" (@ (translate [level 0 (random)]) (rotate level [0 0 1]))) (begin {level} (union))))))"
            )
            forms.append('(call "w" :level 3)')
        for _ in range(pick.randint(1, 3)):
            forms.append(self._use())
        return "\n".join(forms) + "\n"

    def fresh(self, letter: str = "x") -> str:
        self.count += 1
        return f"{letter}{self.count}"

    def _function(self) -> str:
        pick, name = self.random, self.fresh("f")
        arity = pick.choice((0, 1, 1, 2, 2, 3))
        names = [self.fresh() for _ in range(arity)]
        parameters = list(names)
        kind = pick.random()
        extra = self.fresh("o")
        if kind < 0.1:
            parameters.append(f"({extra} {pick.choice(('1', '2.5', *names))})")
        elif kind < 0.2:
            parameters += [".", extra]
        elif kind < 0.3:
            parameters.append(f"(:{extra} {self._literal()})")
        elif kind < 0.35 and names:
            parameters[0] = f"{names[0]}::Integer"
        if len(parameters) > arity:
            names.append(extra)
        self.functions.append((name, arity))
        return f"(define ({name} {' '.join(parameters)}) {self._body(names, pick.choice((2, 3, 3)))})"

    def _use(self) -> str:
        pick = self.random
        name, arity = pick.choice(self.functions)
        arguments = " ".join(pick.choice(("i", "i", self._literal())) for _ in range(arity))
        use = f"({name} {arguments})"
        turns = pick.choice((3, 5, 7))
        return pick.choice((
            f"(for/list ((i {turns})) (guard (e (#t (list 'caught (error-message e)))) {use}))",
            f"(for ((i {turns})) {use})",
            f"(map (lambda (i) {use}) (iota {turns}))",
            f"(let loop ((i {turns}) (out '())) (if (= i 0) out (loop (- i 1) (cons {use} out))))",
            f"(print (for/sum ((i {turns})) {use}))",
            f"(define {self.fresh('g')} (for/list ((i {turns})) {use}))",
        ))  # fmt: skip

    def _literal(self) -> str:
        return self.random.choice((
            "0", "1", "2", "3", "-1", "1.5", "0.25", "#t", "#f", "none", '"s"', "'()", "'(1 2 3)", "[1. 2. 3.]",
            "[1 2 3]", "[1. 0.]", "'sym", "1000000007", "4611686018427387904", "(expt 2 3990)", "-0.5", "1e300", "car",
        ))  # fmt: skip

    def _body(self, names: list[str], depth: int) -> str:
        pick, names, forms = self.random, list(names), []
        for _ in range(pick.choice((0, 0, 1, 2))):
            if pick.random() < 0.6:
                name = self.fresh()
                if pick.random() < 0.3:
                    arguments = [self.fresh() for _ in range(pick.choice((0, 1, 2)))]
                    forms.append(
                        f"(define ({name} {' '.join(arguments)}) {self._body([*names, *arguments], depth - 1)})"
                    )
                else:
                    forms.append(f"(define {name} {self._value(names, depth - 1)})")
                names.append(name)
            else:
                forms.append(self._effect(names, depth - 1))
        forms.append(self._value(names, depth))
        return " ".join(forms)

    def _effect(self, names: list[str], depth: int) -> str:
        pick = self.random
        down = lambda: self._value(names, depth - 1)
        choices = ["(print 1)", "(random)", f"(print {down()})", f"(set! total {down()})"]
        if names:
            choices += [f"(set! {pick.choice(names)} {down()})"] * 2
        return pick.choice(choices)

    def _test(self, names: list[str], depth: int) -> str:
        pick = self.random
        down = lambda: self._value(names, depth - 1)
        if depth > 0 and pick.random() < 0.2:
            return f"({pick.choice(('and', 'or'))} {self._test(names, depth - 1)} {self._test(names, depth - 1)})"
        return pick.choice((
            lambda: f"({pick.choice(('<', '>', '=', '<=', '>='))} {down()} {down()})",
            lambda: f"(not {self._test(names, depth - 1)})",
            lambda: f"(null? {down()})",
            lambda: f"(pair? {down()})",
            lambda: f"(number? {down()})",
            down,
        ))()  # fmt: skip

    def _value(self, names: list[str], depth: int) -> str:
        pick = self.random
        if depth <= 0 or pick.random() < 0.15:
            if names and pick.random() < 0.75:
                return pick.choice(names)
            return pick.choice((self._literal(), "total", "fixed", "1", "2"))
        down = lambda: self._value(names, depth - 1)
        test = lambda: self._test(names, depth - 1)
        inner, other = self.fresh(), self.fresh()
        operator = pick.choice(("+", "+", "-", "-", "*", "*", "/", "//", "%", "@"))
        forms = [
            lambda: f"({operator} {down()} {down()})",
            lambda: f"({operator} {down()} {pick.choice(('1', '2', '0.5', '3'))})",
            lambda: f"(+ {down()} {down()} {down()})",
            lambda: f"(if {test()} {down()} {down()})",
            lambda: f"(when {test()} {down()})",
            lambda: f"(cond ({test()} {down()}) ({test()} {down()}) (else {down()}))",
            lambda: f"(and {down()} {test()} {down()})",
            lambda: f"(or {test()} {down()})",
            lambda: f"(let (({inner} {down()}) ({other} {down()})) {self._body([*names, inner, other], depth - 1)})",
            lambda: f"(let (({inner} {down()})) (set! {inner} {down()}) (lambda () {inner}))",
            lambda: f"((let (({inner} {down()})) (lambda ({other}) (set! {inner} (list {other} {inner})) {inner})) 1)",
            lambda: f"(begin {self._effect(names, depth - 1)} {down()})",
            lambda: f"(car {down()})",
            lambda: f"(cdr {down()})",
            lambda: f"(cons {down()} {down()})",
            lambda: f"(list {down()} {down()})",
            lambda: f"[{down()} {down()} {down()}]",
            lambda: f'(string-append "a" (format "{{}}" {down()}))',
            lambda: f"(length {down()})",
            lambda: f"(max {down()} {down()})",
            lambda: f"(apply + (list {down()} {down()}))",
            lambda: f"(round {down()} {down()})",
            lambda: self._loop(names, depth),
            lambda: self._loop(names, depth),
            lambda: self._nested_loop(names, depth),
            lambda: (
                f"(do (({inner} 0 (+ {inner} 1)) ({other} {down()} {down()})) ((> {inner} 3) {other}) "
                f"{self._effect([*names, inner, other], depth - 1)})"
            ),
            lambda: f"(let (({inner} 0)) (while (< {inner} 3) (set! {inner} (+ {inner} 1)) {down()}) {inner})",
            lambda: (
                f"({pick.choice(('for/list', 'for/sum', 'for/and', 'for/first', 'for'))} (({inner} {pick.choice(('3', down()))})) "
                f"{self._value([*names, inner], depth - 1)})"
            ),
            lambda: f"(for/fold (({other} {down()})) (({inner} 3)) {self._value([*names, inner, other], depth - 1)})",
            lambda: f"(let/ec {inner} (begin (if {test()} ({inner} {down()}) 1) {down()}))",
            lambda: f"(guard (e (#t (list 'caught {down()}))) {down()})",
            lambda: f'(begin (if {test()} (error "no" {down()}) 1) {down()})',
            lambda: (
                f"(let-values ((({inner} {other}) (list {down()} {down()}))) {self._value([*names, inner, other], depth - 1)})"
            ),
            lambda: f"((lambda ({inner}) {self._body([*names, inner], depth - 1)}) {down()})",
            lambda: f"(map (lambda ({inner}) {self._value([*names, inner], depth - 1)}) (list 1 2.5 {down()}))",
            lambda: "(random)",
            lambda: f"({pick.choice(names)} {down()})" if names else down(),
        ]
        if self.functions:
            forms += [lambda: self._call(names, depth)] * 4
        return pick.choice(forms)()

    def _call(self, names: list[str], depth: int) -> str:
        name, arity = self.random.choice(self.functions)
        if self.random.random() < 0.1:
            arity += self.random.choice((-1, 1))
        arguments = " ".join(self._value(names, depth - 1) for _ in range(max(0, arity)))
        guard = self.random.choice(names) if names and self.random.random() < 0.8 else None
        call = f"({name} {arguments})"
        return f"(if (and (number? {guard}) (> {guard} 0) (< {guard} 9)) {call} 0)" if guard else call

    def _loop(self, names: list[str], depth: int) -> str:
        pick = self.random
        loop, i, value = self.fresh("loop"), self.fresh("i"), self.fresh()
        bound = [*names, i, value]
        again = f"({loop} (+ {i} 1) {self._value(bound, depth - 1)})"
        if pick.random() < 0.3:
            again = f"(if {self._test(bound, depth - 1)} {again} ({loop} (+ {i} 2) {value}))"
        if pick.random() < 0.2:
            again = f"(let (({value}f (lambda () {value}))) ({loop} (+ {i} 1) ({value}f)))"
        end = self._value(bound, depth - 1)
        return f"(let {loop} (({i} 0) ({value} {self._value(names, depth - 1)})) (if (>= {i} 5) {end} {again}))"

    def _nested_loop(self, names: list[str], depth: int) -> str:
        outer, inner, i, j, k = (self.fresh(letter) for letter in ("outer", "inner", "i", "j", "k"))
        value = self._value([*names, i, j, k], depth - 1)
        end = self._value([*names, i, k], depth - 1)
        wrap = self.random.choice(("{}", "(list {})", "(+ 1 {})"))
        return wrap.format(
            f"(let {outer} (({i} 0) ({k} 0)) (if (= {i} 3) {end} (let {inner} (({j} 0)) "
            f"(cond ((= {j} 2) ({outer} (+ {i} 1) {value})) ((> {j} {i}) {value}) (else ({inner} (+ {j} 1)))))))"
        )


@cache
def published() -> list[str]:
    """Return the programs of the examples, the tests and the corpus."""
    root = TESTS.parent
    paths = sorted([*root.glob("examples/**/*.scene"), *TESTS.glob("**/*.scene")])
    corpus = Path("/work/shared/corpus")
    paths += [*sorted(corpus.glob("**/*.scene")), *sorted(corpus.glob("**/*.txt"))]
    paths += sorted(TESTS.glob("transpile/responses/*.txt"))
    return [path.read_text("utf-8", "replace") for path in paths]


def main(count: int) -> None:
    """Compare that many generated programs; print each that differs."""
    for text in published():
        found = difference(text)
        if found is not None:
            print(found, text[:300], sep="\n")
    differing = 0
    for seed in range(count):
        text = HotPrograms(seed).program() if seed % 4 else Programs(seed).program()
        found = difference(text, hot=1 + seed % 3)
        if found is not None:
            differing += 1
            print(f"--- seed {seed}\n{text}\n{found}", flush=True)
            if differing > 20:
                break
    print(f"{count} programs, {differing} differ")


if __name__ == "__main__":
    main(int(sys.argv[1]))

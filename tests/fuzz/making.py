"""Inputs from a random stream: programs over all builtins, odd texts, Python, and files that are almost right."""

from __future__ import annotations

import json
import random
import struct
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

Rng = random.Random

ODD_NUMBERS = (
    "0", "1", "-1", "2", "3", "0.5", "-0.0", "1e300", "-1e300", "1e-320", "9007199254740993", "1000000000000",
    "99999999999999999999999999", "2305843009213693951", "inf", "nan", "(- inf)", "200000", "4294967296", "65536", "255",
)  # fmt: skip
ODD_TEXTS = (
    '""', '"a"', '"x y"', '"\\n"', '"\\u{1b}[31m"', '"{}"', '"{:>10}"', '"{:.3f}"', '"{"', '"}"', '"cube"', '"red"', '"#fff"',
    '"../a.obj"', '"a\\u{0}b"', '"é\\u{301}"', '"\\u{1f600}"', '"12"', '"1e5"', '"z1"', '"dot"', '"' + "ab" * 2000 + '"',
)  # fmt: skip
ODD_VALUES = (
    "(list)", "(list 1 2 3)", "(list 1 (list 2 (list 3)))", "[1 2 3]", "[[1 0] [0 1]]", "(eye 4)", "(zeros 0)",
    "(zeros 2 0 3)", "(array 5)", "(table)", '(table "a" 1 2 3)', "(set)", "(set 1 2.0)", "(mutable-list 1 2)", "(mutable-array [1 2])",
    "#t", "#f", "none", "'a", ":k", "'(1 . 2)", '(call "cube")', '(call "sphere" :radius 2)', '(union (call "cube") (call "cone"))',
    '(cons (call "cube") (translate [1 2 3]))', '(embedding "old" :a 1)', "(random-stream 3)", "car", "+", "(lambda (x) x)", "(lambda _ 1)",
    "(lambda (a b) (< a b))", "(iota 1000)", "(iota 200000)", '(make-list 100000 "a")', "(expt 7 3000)", "(translate [1 2 3])", "(rotate 1 [0 1 0])",
    "(list (list 1 2) (list 3 4))", "(->list \"abc\")", "(list 3 1 2 \"a\" #t)", "shared", "cyclic", "(values 1 2)", "(string->symbol \"a b\")",
)  # fmt: skip
PRELUDE = (
    "(define shared (list 1)) (for ((i 24)) (set! shared (list shared shared)))\n"
    "(define cyclic (mutable-list 1)) (push! cyclic cyclic)\n"
)


@cache
def builtins() -> tuple[tuple[str, tuple[str, ...]], ...]:
    """Every builtin, with its keywords."""
    from scenelang.session.session import Options, Session

    found = []
    for name, function in sorted(Session(Options()).library.builtins.items()):
        names = getattr(getattr(function, "signature", None), "keywords", ()) or ()
        found.append((name, tuple(str(getattr(each, "name", each)) for each in names)))
    return tuple(found)


def expression(rng: Rng, depth: int = 3) -> str:
    choice = rng.random()
    if depth <= 0 or choice < 0.25:
        return rng.choice(
            (rng.choice(ODD_NUMBERS), rng.choice(ODD_TEXTS), rng.choice(ODD_VALUES), rng.choice(("x", "y", "f", "i")))
        )
    if choice < 0.8:
        name, keywords = rng.choice(builtins())
        parts = [expression(rng, depth - 1) for _ in range(rng.choice((0, 1, 1, 2, 2, 2, 3, 4)))]
        if rng.random() < 0.15:
            parts += [
                f":{rng.choice(keywords or ('key', 'axis', 'size', 'reverse', 'stream'))}",
                expression(rng, depth - 1),
            ]
        return f"({' '.join([name, *parts])})"
    one, two, three = (expression(rng, depth - 1) for _ in range(3))
    return rng.choice((
        f"(if {one} {two} {three})", f"(let ((x {one}) (y {two})) {three})", f"(for/list ((i {one})) {two})",
        f"(guard (e (#t (error-message e))) {one})", f"(begin (set! x {one}) {two})", f"(map (lambda (i) {one}) {two})",
        f"(for ((i {one})) {two})", f"`(,{one} ,@{two})", f"(let loop ((i {one})) (if {two} {three} (loop (+ i 1))))",
        f"(cond ({one} {two}) (else {three}))", f"(case {one} ((1 a) {two}) (else {three}))", f"(f {one} {two})",
        f"((lambda (i (y 1)) {one}) {two})", f"(let (((a b) {one})) {two})", f"(let/ec k (k {one}))", f"(while {one} {two})",
        f"(for/fold ((y {one})) ((i {two})) {three})", f'(call "w" :a {one} :b {two})', f"(print {one} {two})", f"({one} {two})",
    ))  # fmt: skip


def program(rng: Rng) -> bytes:
    forms = [
        PRELUDE,
        f"(define x {expression(rng, 1)})",
        f"(define y {expression(rng, 2)})",
        f"(define (f i (y 2)) {expression(rng, 2)})",
    ]
    forms += [expression(rng, rng.choice((2, 3, 4))) for _ in range(rng.choice((1, 1, 2, 3)))]
    if rng.random() < 0.3:
        forms.append(
            f"(define-syntax m (syntax-rules () ((_ a b ...) {expression(rng, 2)}) ((_ a ...) (list a ...)))) (m {expression(rng, 1)} 2)"
        )
    if rng.random() < 0.1:
        forms.append(f"(define-macro (n a) {expression(rng, 2)}) (n {expression(rng, 1)})")
    if rng.random() < 0.1:
        forms.append(f"(define-record r (a {expression(rng, 1)}) b) (print (r :a {expression(rng, 1)} :b 2))")
    forms.append(f'(bind "w" (lambda (:a :b) (union (call "cube") {expression(rng, 3)})))')
    forms.append(
        rng.choice(('(bind "top" (lambda () (call "w" :a 1 :b 2)))', f'(bind "top" (lambda () {expression(rng, 3)}))'))
    )
    return mutated_text("\n".join(forms), rng).encode() if rng.random() < 0.1 else "\n".join(forms).encode()


TOKENS = (
    "(", ")", "[", "]", "{", "}", "'", "`", ",", ",@", "#;", "#|", "|#", ";", "\n", " ", '"', "\\", "#t", "#f", "#\\", ".", "...", ":", ":a", "a", "λ", "1",
    "-", "+", "1.5", "1e9999", "0x1f", "1/2", "\t", "\r", "\0", "\x1b", "\ufeff", "\u202e", "\u2028", "😀", "define", "lambda", "bind", "let", "if",
    "define-syntax", "syntax-rules", "import", "quote", "scene", "call", '"cube"', "::", "::Float", "_", "else", "=>", "|a b|", "#(1 2)", "```", "|", "#!",
)  # fmt: skip


def tokens(rng: Rng) -> bytes:
    count = rng.choice((1, 3, 10, 40, 200))
    repeated = rng.choice(TOKENS) * rng.choice((1, 1, 1, 50, 5000)) if rng.random() < 0.2 else ""
    glue = rng.choice(("", " ", "", "\n"))
    return (repeated + glue.join(rng.choice(TOKENS) for _ in range(count))).encode()


def mutated_text(text: str, rng: Rng) -> str:
    for _ in range(rng.choice((1, 1, 2, 5))):
        at = rng.randrange(len(text) + 1)
        end = min(len(text), at + rng.choice((0, 1, 1, 3, 20)))
        text = text[:at] + rng.choice((rng.choice(TOKENS), "", text[at:end] * rng.choice((2, 50)))) + text[end:]
    return text


def mutated(data: bytes, rng: Rng) -> bytes:
    """A file that is almost right: bytes changed, cut, doubled, numbers replaced by large ones."""
    out = bytearray(data)
    for _ in range(rng.choice((1, 1, 2, 4, 10))):
        at = rng.randrange(len(out) + 1)
        kind = rng.randrange(7)
        if kind == 0 and out:
            out[min(at, len(out) - 1)] = rng.randrange(256)
        elif kind == 1:
            del out[at : at + rng.choice((1, 2, 4, 100))]
        elif kind == 2:
            out[at:at] = rng.randbytes(rng.choice((1, 2, 4, 30)))
        elif kind == 3:
            number = rng.choice((0, 1, -1, 2**31 - 1, -(2**31), 2**30, 2**16))
            out[at : at + 4] = struct.pack(rng.choice(("<i", ">i")), number)
        elif kind == 4:
            out[at : at + 8] = struct.pack(
                rng.choice(("<d", ">d", "<q")), rng.choice((0, 1, -1)) if rng.random() < 0.5 else 2**62
            )
        elif kind == 5:
            out[at:at] = out[at : at + rng.choice((4, 16, 200))] * rng.choice((1, 2, 30))
        else:
            del out[at:]
    return bytes(out)


ODD_JSON: Sequence[Any] = (
    None, True, False, 0, 1, -1, 3, 2**31, 2**53, 2**64, 10**30, -(10**30), 0.5, 1e308, -1e308, 1e-320, "", "a", "\x1b[31m", "../x", "\ud800", "x" * 2000,
    [], {}, [1], [[]], [0, 0, 0], [None], {"a": 1}, [1e308] * 3, [[1, 0], [0]], [[[[]]]], "1", "cube", "nan", [10**400],
)  # fmt: skip


def changed(value: Any, rng: Rng, depth: int = 0) -> Any:
    """JSON with one place of it replaced, removed or doubled."""
    if (depth > 1 and rng.random() < 0.25) or not isinstance(value, list | dict) or not value:
        return rng.choice(ODD_JSON)
    if isinstance(value, list):
        at = rng.randrange(len(value))
        kind = rng.random()
        if kind < 0.1:
            return value[:at] + value[at + 1 :]
        if kind < 0.2:
            return value[:at] + [value[at]] * rng.choice((2, 40)) + value[at + 1 :]
        return [*value[:at], changed(value[at], rng, depth + 1), *value[at + 1 :]]
    key = rng.choice(list(value))
    kind = rng.random()
    if kind < 0.1:
        return {name: each for name, each in value.items() if name != key}
    if kind < 0.2:
        return {**value, rng.choice(("", "\x1b", "a", "format", "extra")): rng.choice(ODD_JSON)}
    return {**value, key: changed(value[key], rng, depth + 1)}


def json_like(seeds: Callable[[], Sequence[Any]]) -> Callable[[Rng], bytes]:
    def make(rng: Rng) -> bytes:
        value = rng.choice(seeds())
        for _ in range(rng.choice((1, 1, 2, 4))):
            value = changed(value, rng)
        text = json.dumps(value)
        if rng.random() < 0.1:
            text = text.replace("1", rng.choice(("NaN", "Infinity", "1" * 5000)), 1)
        data = text.encode()
        return mutated(data, rng) if rng.random() < 0.15 else data

    return make


def file_like(seeds: Callable[[], Sequence[bytes]]) -> Callable[[Rng], bytes]:
    return lambda rng: mutated(rng.choice(seeds()), rng)


# --- Python ----------------------------------------------------------------------------------------------------------

NAMES = ("a", "b", "xs", "shape", "scene", "i", "primitive_call", "library_call", "loop", "concat_shapes", "transform_shape", "np", "math",
         "rotation_matrix", "translation_matrix", "scale_matrix", "print", "range", "len", "sorted", "lambda_", "self", "P", "random")  # fmt: skip


def python_expression(rng: Rng, depth: int) -> str:
    if depth <= 0 or rng.random() < 0.2:
        return rng.choice(
            (
                *NAMES,
                "1",
                "0.5",
                "-3",
                "'cube'",
                "'x 1) (print'",
                "None",
                "True",
                "()",
                "[]",
                "{}",
                "1e400",
                "10**100",
                "b'x'",
                "'\\ud800'",
                "...",
                "1j",
                "f'{a}'",
            )
        )
    one, two, three = (python_expression(rng, depth - 1) for _ in range(3))
    return rng.choice((
        f"{one} {rng.choice(('+', '-', '*', '/', '//', '%', '**', '@', '<', '==', 'in', 'and', 'or', 'is not', '<<', '|', '^'))} {two}",
        f"{rng.choice(NAMES)}({one}, {two})", f"{rng.choice(NAMES)}({one}, k={two}, **{three})", f"[{one}, {two}, *{three}]", f"({one}, {two})",
        f"{{{one}: {two}, **{three}}}", f"[{one} for {rng.choice(NAMES)} in {two} if {three}]", f"{one}[{two}:{three}]", f"({one}).{rng.choice(NAMES)}",
        f"(lambda a, *b, c={one}: {two})", f"({one} if {two} else {three})", f"primitive_call('cube', shape_kwargs={{'scale': {one}, 'x y': {two}}}, color=({three}))",
        f"library_call('{rng.choice(NAMES)}', {one}, k={two})", f"loop({one}, lambda i: {two})", f"transform_shape({one}, {two})", f"np.{rng.choice(('array', 'linalg.norm', 'pi', 'zeros'))}({one})",
        f"f'{{{rng.choice(NAMES)}!r:>{{b}}}} {{{rng.choice(NAMES)}}}'", f"(a := {one})", f"not {one}", f"{one} < {two} <= {three}", f"{{{one} for a in {two}}}", f"sum({one} for a, b in {two})",
    ))  # fmt: skip


def python_statements(rng: Rng, indent: int, depth: int) -> str:
    lines = []
    space = "    " * indent
    for _ in range(rng.choice((1, 1, 2, 3))):
        one, two = python_expression(rng, 2), python_expression(rng, 2)
        name = rng.choice(NAMES)
        kinds = [f"{name} = {one}", f"{name} {rng.choice(('+=', '-=', '*='))} {one}", f"{name}, b = {one}, {two}", f"return {one}", one, f"{name}[{one}] = {two}", "pass", f"assert {one}, {two}", f"del {name}", f"global {name}", f"{name}: int = {one}", f"a, *{name} = {one}", f"raise ValueError({one})", "break", "continue", f"yield {one}", f"import {name}", "from math import *", f"print({one}, sep={two})"]  # fmt: skip
        if depth > 0 and rng.random() < 0.4:
            head = rng.choice(
                (
                    f"for {name} in {one}:",
                    f"if {one}:",
                    f"while {one}:",
                    f"def {name}(a, b={one}, *c, **d):",
                    f"with {one} as {name}:",
                    "try:",
                    f"for {name}, b in enumerate({one}):",
                    f"class {name}:",
                    f"match {one}:\n{space}  case {two}:",
                )
            )
            lines.append(space + head + "\n" + python_statements(rng, indent + 1, depth - 1))
            if head == "try:":
                lines.append(f"{space}except {rng.choice(('Exception', 'ValueError as b', ''))}:\n{space}    pass")
            elif head.startswith(("if", "for", "while")) and rng.random() < 0.3:
                lines.append(f"{space}else:\n" + python_statements(rng, indent + 1, depth - 1))
        else:
            lines.append(space + rng.choice(kinds))
    return "\n".join(lines)


def python(rng: Rng) -> bytes:
    parts = ["from helper import *"] if rng.random() < 0.8 else []
    for _ in range(rng.choice((1, 1, 2, 3))):
        head = rng.choice(("@register()\n", "@register('a b')\n", "", '@register("doc")\n'))
        parts.append(
            f"{head}def {rng.choice(NAMES)}({rng.choice(('', 'a', 'a: int, b=1', '*a', 'a, *, b'))}) -> Shape:\n{python_statements(rng, 1, 2)}"
        )
    text = "\n\n".join(parts)
    kind = rng.random()
    if kind < 0.2:
        text = f"Here is it:\n```{rng.choice(('python', '', 'py'))}\n{text}\n```\nDone."
    return mutated_text(text, rng).encode() if kind > 0.7 else text.encode()

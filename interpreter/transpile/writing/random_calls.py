"""Draws from `random` and `numpy.random`."""

from __future__ import annotations

import ast
from typing import TYPE_CHECKING

from scenelang.interpreter.transpile.analysis.domain import (
    ARRAY,
    INT,
    NUMBERS,
)
from scenelang.interpreter.transpile.analysis.syntax import is_none
from scenelang.interpreter.transpile.writing.arguments import arguments_of
from scenelang.interpreter.transpile.writing.call_basics import CallWriter, only_positional
from scenelang.interpreter.transpile.writing.code import (
    Code,
    Key,
    form,
    number,
)
from scenelang.interpreter.transpile.writing.operators import numeric

if TYPE_CHECKING:
    from scenelang.interpreter.transpile.writing.expressions import ExpressionWriter

DRAWS: dict[str, tuple[str, str]] = {
    # path: (builtin, parameters in order; after ":" the keyword of the builtin)
    "numpy.random.uniform": ("uniform", "low? high? size?:size"),
    "numpy.random.normal": ("normal", "loc? scale? size?:size"),
    "numpy.random.standard_normal": ("normal", "size?:size"),
    "numpy.random.randint": ("randint", "low high? size?:size dtype?"),
    "numpy.random.random": ("random", "size?:size"),
    "numpy.random.random_sample": ("random", "size?:size"),
    "numpy.random.choice": ("choice", "a size?:size replace?:replace p?:p"),
    "numpy.random.permutation": ("permutation", "x"),
    "random.random": ("py-random", ""),
    "random.uniform": ("py-uniform", "a b"),
    "random.gauss": ("py-gauss", "mu? sigma?"),
    "random.randint": ("py-randint", "a b"),
    "random.randrange": ("py-randrange", "start stop? step?"),
    "random.choice": ("py-choice", "seq"),
    "random.choices": ("py-choices", "population weights?:weights k?:k"),
    "random.sample": ("py-sample", "population k"),
}
_SEQUENCE_PARAMETERS = ("a", "seq", "population", "x")
_NO_KEYWORD_VALUES = ("dtype",)


def draw(w: ExpressionWriter, node: ast.Call, path: str, stream: Code | None = None) -> Code:
    """A draw from a stream: the common one, or ``stream``."""
    head, signature = DRAWS[path]
    parameters = [p.partition(":") for p in signature.split()]
    given = arguments_of(w, node, " ".join(p[0] for p in parameters), path)
    items: list[Code] = []
    options: list[Code] = []
    waiting: list[ast.expr] = []
    for name, _, keyword in parameters:
        name = name.rstrip("?")
        value = given.get(name)
        if value is None or name in _NO_KEYWORD_VALUES or (keyword and is_none(value)):
            continue
        if keyword:
            options += [Key(keyword), w.test(value) if keyword == "replace" else w.expr(value)]
            continue
        items += [_draw_argument(w, v, name) for v in (*waiting, value)]
        waiting = []
    items = _fill_gaps(path, given, items)
    if stream is not None:
        options += [Key("stream"), stream]
    code = form(head, *items, *options)
    if path == "numpy.random.permutation" and not w.type(node.args[0]).only(INT) and w.type(node).kinds & ARRAY:
        code = form("permutation", w.array(node.args[0]), *options)
    return form("mutable", code) if w.is_mutated(node) else code


def _draw_argument(w: ExpressionWriter, value: ast.expr, name: str) -> Code:
    if name in _SEQUENCE_PARAMETERS and not w.type(value).only(NUMBERS):
        return w.iterable(value)
    return numeric(w, value)


def _fill_gaps(path: str, given: dict[str, ast.expr], items: list[Code]) -> list[Code]:
    """Optional arguments before one that is given: ``np.random.normal(scale=.1)``."""
    first = {
        "numpy.random.normal": ("loc", "scale", 0),
        "numpy.random.uniform": ("low", "high", 0),
        "random.gauss": ("mu", "sigma", 0),
    }
    rule = first.get(path)
    if rule is not None and rule[1] in given and rule[0] not in given:
        return [number(rule[2]), *items]
    if path == "numpy.random.uniform" and "low" in given and "high" not in given:
        return [*items, number(1)]
    return items


def write_draw(path: str) -> CallWriter:
    return lambda w, node: draw(w, node, path)


def write_sides(head: str) -> CallWriter:
    def write(w: ExpressionWriter, node: ast.Call) -> Code:
        only_positional(w, node)
        return form(head if node.args else ("random" if head == "rand" else "normal"), *(w.expr(a) for a in node.args))

    return write


def write_shuffle(head: str) -> CallWriter:
    def write(w: ExpressionWriter, node: ast.Call) -> Code:
        return form(head, w.expr(arguments_of(w, node, "x", "shuffle")["x"]))

    return write


def write_seed(head: str) -> CallWriter:
    def write(w: ExpressionWriter, node: ast.Call) -> Code:
        if not node.args or is_none(node.args[0]):
            raise w.unsupported("seeding from the clock", node, "give the seed a number")
        return form(head, w.expr(node.args[0]))

    return write


def write_stream(head: str) -> CallWriter:
    def write(w: ExpressionWriter, node: ast.Call) -> Code:
        return form(head, *(w.expr(a) for a in (*node.args, *(k.value for k in node.keywords)) if not is_none(a)))

    return write

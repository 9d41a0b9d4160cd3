"""Calls of `math`."""

from __future__ import annotations

import ast
from typing import TYPE_CHECKING

from scenelang.interpreter.transpile.writing.arguments import arguments_of
from scenelang.interpreter.transpile.writing.code import (
    Code,
    Literal,
    form,
    number,
)
from scenelang.interpreter.transpile.writing.operators import numeric

if TYPE_CHECKING:
    from scenelang.interpreter.transpile.writing.expressions import ExpressionWriter


def write_fmod(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "x y", "math.fmod")
    return form("inexact", form("remainder", numeric(w, given["x"]), numeric(w, given["y"])))


def write_dist(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "p q", "math.dist")
    return form("distance", w.array(given["p"]), w.array(given["q"]))


def write_isclose(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "a b rel_tol? abs_tol? rtol? atol?", "isclose")
    relative = given.get("rel_tol", given.get("rtol"))
    absolute = given.get("abs_tol", given.get("atol"))
    a, b = numeric(w, given["a"]), numeric(w, given["b"])
    largest = form("max", form("abs", numeric(w, given["a"])), form("abs", numeric(w, given["b"])))
    tolerance: Code = form("*", w.expr(relative) if relative is not None else Literal(1e-9, None, "1e-9"), largest)
    if absolute is not None:
        tolerance = form("max", tolerance, w.expr(absolute))
    return form("<=", form("abs", form("-", a, b)), tolerance)


def write_factorial(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "n", "math.factorial")
    return form("product", form("range", number(1), form("+", w.expr(given["n"]), number(1))))


def write_copysign(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "x y", "math.copysign")
    test = form("<", numeric(w, given["y"]), number(0))
    return form(
        "*", form("abs", numeric(w, given["x"])), form("if", test, Literal(-1.0, None, "-1."), Literal(1.0, None, "1."))
    )


def write_cbrt(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "x", "cbrt")
    return form(
        "*",
        form("sign", w.expr(given["x"])),
        form("expt", form("abs", w.expr(given["x"])), form("/", number(1), number(3))),
    )


def write_isqrt(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "n", "math.isqrt")
    return form("floor", form("sqrt", w.expr(given["n"])))


def write_prod(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "iterable", "prod")
    return form("product", w.iterable(given["iterable"]))

"""Grids of numpy, and its sums over subscripts, in terms of what the translation knows of arrays."""

from __future__ import annotations

import ast
import copy
from collections.abc import Callable
from typing import Any

from scenelang.interpreter.transpile.analysis.rewriting import is_repeatable, placed

PATHS = ("numpy.mgrid", "numpy.indices", "numpy.einsum")


class Grids(ast.NodeTransformer):
    """Writes `np.mgrid`, `np.indices` as `np.meshgrid`, and `np.einsum` as nested comprehensions."""

    def __init__(self, path_of: Callable[[ast.expr], str | None]) -> None:
        self._path_of = path_of

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        """Write ``np.mgrid[0:h, 0:w]`` as the grid of two ranges, and a new first axis with the others behind it."""
        self.generic_visit(node)
        if isinstance(node.slice, ast.Constant) and node.slice.value is None and isinstance(node.ctx, ast.Load):
            node.slice = placed(ast.Tuple([node.slice, ast.Constant(...)], ast.Load()), node)
        parts = node.slice.elts if isinstance(node.slice, ast.Tuple) else []
        if self._path_of(node.value) != "numpy.mgrid" or len(parts) != 2:
            return node
        axes = [_axis(self._module(node.value), each) for each in parts]
        known = [each for each in axes if each is not None]
        return self._grid(node, node.value, known) if len(known) == 2 else node

    def visit_Call(self, node: ast.Call) -> ast.expr:
        """Write the indices of a grid as the grid, and sums over subscripts as sums."""
        self.generic_visit(node)
        path = self._path_of(node.func)
        if path == "numpy.indices" and len(node.args) == 1 and not node.keywords:
            shape = node.args[0]
            sides: list[ast.expr] = (
                shape.elts if isinstance(shape, ast.Tuple)
                else [ast.Subscript(copy.deepcopy(shape), ast.Constant(n), ast.Load()) for n in range(2)]
                if is_repeatable(shape) else []
            )  # fmt: skip
            if len(sides) != 2:
                return node
            module = self._module(node.func)
            return self._grid(node, node.func, [_call(module, "arange", [each]) for each in sides])
        if path == "numpy.einsum" and not node.keywords and len(node.args) > 1:
            return _sum_of_products(node, self._module(node.func)) or node
        return node

    @staticmethod
    def _module(function: Any) -> ast.expr:
        module: ast.expr = function.value
        return module

    def _grid(self, node: ast.expr, function: Any, axes: list[ast.expr]) -> ast.expr:
        made = _call(self._module(function), "meshgrid", axes)
        made.keywords = [ast.keyword("indexing", ast.Constant("ij"))]
        return placed(made, node)


def _call(module: ast.expr, name: str, arguments: list[ast.expr]) -> ast.Call:
    return ast.Call(ast.Attribute(copy.deepcopy(module), name, ast.Load()), arguments, [])


def _axis(module: ast.expr, part: ast.expr) -> ast.expr | None:
    """Return the coordinates of a slice: with an imaginary step that many, both ends included."""
    if not isinstance(part, ast.Slice) or part.upper is None:
        return None
    start = part.lower or ast.Constant(0)
    if isinstance(part.step, ast.Constant) and type(part.step.value) is complex:
        return _call(module, "linspace", [start, part.upper, ast.Constant(int(abs(part.step.value)))])
    return _call(module, "arange", [start, part.upper, *([part.step] if part.step is not None else [])])


def _sum_of_products(node: ast.Call, module: ast.expr) -> ast.expr | None:
    """Return ``np.einsum`` with subscripts that are written out as sums in comprehensions over the others."""
    text = node.args[0].value if isinstance(node.args[0], ast.Constant) else None
    operands = node.args[1:]
    if not isinstance(text, str) or "." in text or not all(map(is_repeatable, operands)):
        return None
    given, arrow, kept = text.replace(" ", "").partition("->")
    inputs = given.split(",")
    letters = "".join(dict.fromkeys(given.replace(",", "")))
    if len(inputs) != len(operands) or not letters.isalpha() or not all(inputs):
        return None
    kept = kept if arrow else "".join(sorted(c for c in letters if given.count(c) == 1))
    factors: list[ast.expr] = []
    sizes: dict[str, ast.expr] = {}
    for subscripts, operand in zip(inputs, operands):
        names: list[ast.expr] = [ast.Name(f"index_{c}", ast.Load()) for c in subscripts]
        index = names[0] if len(names) == 1 else ast.Tuple(names, ast.Load())
        factors.append(ast.Subscript(copy.deepcopy(operand), index, ast.Load()))
        for n, c in enumerate(subscripts):
            shape = ast.Attribute(copy.deepcopy(operand), "shape", ast.Load())
            sizes[c] = ast.Subscript(shape, ast.Constant(n), ast.Load())
    value = factors[0]
    for each in factors[1:]:
        value = ast.BinOp(value, ast.Mult(), each)
    summed = [c for c in letters if c not in kept]
    if summed:
        clauses = [_clause(c, sizes[c]) for c in summed]
        value = ast.Call(ast.Name("sum", ast.Load()), [ast.GeneratorExp(value, clauses)], [])
    for c in reversed(kept):
        value = ast.ListComp(value, [_clause(c, sizes[c])])
    return placed(_call(module, "array", [value]) if kept else value, node)


def _clause(letter: str, size: ast.expr) -> ast.comprehension:
    numbers = ast.Call(ast.Name("range", ast.Load()), [size], [])
    return ast.comprehension(ast.Name(f"index_{letter}", ast.Store()), numbers, [], 0)

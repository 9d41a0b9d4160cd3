"""Arguments of evaluated functions that are not specialised: numbers, and what is made of numbers.

A point, a named tuple, an instance of a class and a small array are passed as nested tuples of their numbers, so that
one residual function stands for all of them.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from scenelang.interpreter.transpile.evaluation.objects import NamedTuple, PythonObject
from scenelang.interpreter.transpile.evaluation.residue import Residual, node_of

_MAX_LEAVES, _MAX_DEPTH = 24, 4  # of a value that a general function may take
_LEAVES = (int, float, bool, str, np.integer, np.floating)


def parts_of(value: Any) -> list[Any] | None:
    """Return the parts of a value that is made of others, in order; None for one that is not, such as a number."""
    if type(value) in (tuple, list, NamedTuple):
        return list(value)
    if type(value) is np.ndarray and value.ndim == 1:
        return value.tolist()  # type: ignore[no-any-return]
    if type(value) is PythonObject and value.cls.members is None and not value.is_general:
        return list(value.fields.values())
    return None


def is_general(value: Any) -> bool:
    """Return whether a function may be the same for all values like this."""
    parts = parts_of(value)
    if parts is None:
        return _is_number(value)
    if type(value) in (tuple, list):
        return 2 <= len(parts) <= 4 and all(map(_is_number, parts))
    leaves = list(_leaves(value, 0))
    return 0 < len(leaves) <= _MAX_LEAVES and all(map(_is_leaf, leaves))


def _is_number(value: Any) -> bool:
    return type(value) in (int, float) or (type(value) is Residual and value.kind in ("int", "float", "number"))


def _is_leaf(value: Any) -> bool:
    return type(value) in _LEAVES or (type(value) is Residual and value.kind in ("int", "float", "number", "bool"))


def _leaves(value: Any, depth: int) -> Iterator[Any]:
    parts = parts_of(value) if depth < _MAX_DEPTH else None
    if parts is None:
        yield value
    else:
        for each in parts:
            yield from _leaves(each, depth + 1)


def form_of(value: Any) -> Any:
    """Return a description of how a value is made, without its numbers: values of one form share a function."""
    parts = parts_of(value)
    if parts is None:
        return None
    own = id(value.cls) if type(value) in (NamedTuple, PythonObject) else type(value).__name__
    names = tuple(value.fields) if type(value) is PythonObject else ()
    return own, names, tuple(map(form_of, parts))


def leaves_of(value: Any, path: tuple[int, ...] = ()) -> Iterator[tuple[tuple[int, ...], Any]]:
    """Iterate over the numbers of a value, with their places in it."""
    parts = parts_of(value)
    if parts is None:
        yield path, value
    else:
        for number, each in enumerate(parts):
            yield from leaves_of(each, (*path, number))


def generalised(value: Any, path: tuple[int, ...], leaf: Callable[[tuple[int, ...]], Any]) -> Any:
    """Return a value of the same form with other leaves."""
    parts = parts_of(value)
    if parts is None:
        return leaf(path)
    made = [generalised(each, (*path, number), leaf) for number, each in enumerate(parts)]
    if type(value) is NamedTuple:
        result = NamedTuple(made)
        result.cls, result.fields = value.cls, dict(value.fields)
        return result
    if type(value) is PythonObject:
        return PythonObject(value.cls, dict(zip(value.fields, made)), is_general=True)
    return np.array(made, dtype=object) if type(value) is np.ndarray else type(value)(made)


def as_argument(value: Any) -> ast.expr:
    """Return the expression that a caller passes: a nested tuple of the numbers."""
    parts = parts_of(value)
    return node_of(value) if parts is None else ast.Tuple([as_argument(each) for each in parts], ast.Load())


def part_of(name: str, path: tuple[int, ...]) -> ast.expr:
    """Return the expression of a part of a parameter."""
    node: ast.expr = ast.Name(name, ast.Load())
    for number in path:
        node = ast.Subscript(node, ast.Constant(number), ast.Load())
    return node


def lengths_in(name: str, value: Any) -> dict[str, int]:
    """Return the lengths of the tuples that a parameter is and contains, by their expressions."""
    lengths: dict[str, int] = {}

    def walk(each: Any, path: tuple[int, ...]) -> None:
        parts = parts_of(each)
        if parts is not None:
            lengths[ast.dump(part_of(name, path))] = len(parts)
            for number, part in enumerate(parts):
                walk(part, (*path, number))

    walk(value, ())
    return lengths

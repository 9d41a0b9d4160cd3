"""Operators whose methods ask for the type of their operand: a method for each type.

``v * 2`` and ``v * w`` of vectors have results of different types, and one method has one type of result for the
translation. So ``__mul__`` with ``if isinstance(other, Vec)`` becomes ``mul_vec`` and ``mul_rest``, and where the type
of an operand is known, its method is called.
"""

from __future__ import annotations

import ast
import copy
from collections.abc import Callable, Set
from dataclasses import dataclass

from scenelang.interpreter.transpile.analysis.inference import (
    ARRAY,
    BOOL,
    DICT,
    FLOAT,
    INT,
    LIST,
    NUMBERS,
    POSE,
    RECORD,
    SET,
    SHAPE,
    STR,
    TUPLE,
    UNKNOWN,
)
from scenelang.interpreter.transpile.analysis.python_text import walk_tree
from scenelang.interpreter.transpile.analysis.rewriting import OPERATOR_METHODS, is_repeatable, is_test_of_class, placed
from scenelang.interpreter.transpile.analysis.scopes import Class

_RIGHT = frozenset([*OPERATOR_METHODS.values(), *(f"r{name}" for name in OPERATOR_METHODS.values())])
_KINDS_OF_TYPES = {
    "bool": BOOL, "dict": DICT, "float": FLOAT, "list": LIST | SHAPE, "np.ndarray": ARRAY | POSE,
    "numbers.Number": NUMBERS, "numbers.Real": NUMBERS, "numpy.ndarray": ARRAY | POSE,
    "set": SET, "str": STR, "tuple": TUPLE,
}  # fmt: skip
_SUFFIXES = {"np.ndarray": "array", "numpy.ndarray": "array", "numbers.Number": "number", "numbers.Real": "number"}


@dataclass(frozen=True, slots=True)
class OperatorCase:
    """What an operator method does with operands of some types: ``name`` is the method for these alone.

    ``kinds`` and ``classes`` are those of the types; None for all that are left.
    """

    name: str
    kinds: int | None
    classes: frozenset[str] = frozenset()

    def takes(self, kinds: int, classes: Set[str]) -> bool | None:
        """Return whether it takes operands of some kinds and classes: all of them, none, or None for some of them."""
        if self.kinds is None:
            return True
        if kinds & RECORD and self.kinds & TUPLE:  # a named tuple is one
            return None
        plain = kinds & ~RECORD
        if not plain & ~self.kinds and classes <= self.classes:
            return True
        return False if not plain & self.kinds and not classes & self.classes else None


def split_operators(node: ast.ClassDef, classes: Set[str]) -> None:
    """Give operator methods that ask for the type of their operand a method for each type.

    ``v * 2`` and ``v * w`` of vectors have results of different types, which one method has not.
    """
    own = {each.name for each in node.body if isinstance(each, ast.FunctionDef)}
    for method in [each for each in node.body if isinstance(each, ast.FunctionDef) and each.name in _RIGHT]:
        names = [each.arg for each in method.args.args]
        if len(names) != 2 or method.decorator_list:
            continue
        bodies = _bodies_by_type(method, names[1], classes)
        if len(bodies) < 2 or own & {case.name for case, _ in bodies}:
            continue
        for case, body in bodies:
            if ast.unparse(body[-1]) != "return NotImplemented":
                made = ast.FunctionDef(case.name, copy.deepcopy(method.args), copy.deepcopy(body), [])
                node.body.append(placed(made, method))
        method.__dict__["cases"] = tuple(case for case, _ in bodies)


def _bodies_by_type(
    method: ast.FunctionDef, operand: str, classes: Set[str]
) -> list[tuple[OperatorCase, list[ast.stmt]]]:
    """Return the cases of an operator method with their statements, if its first statements only choose by the type."""
    bodies: list[tuple[OperatorCase, list[ast.stmt]]] = []
    rest = method.body[1:] if ast.get_docstring(method) is not None else method.body
    while rest and isinstance(rest[0], ast.If):
        test, is_not = rest[0].test, False
        if isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not):
            test, is_not = test.operand, True
        body, others = rest[0].body, rest[0].orelse or rest[1:]
        if isinstance(test, ast.BoolOp) and isinstance(test.op, ast.And) and not is_not:
            further = ast.BoolOp(ast.And(), test.values[1:]) if len(test.values) > 2 else test.values[1]
            body = [ast.copy_location(ast.If(placed(further, test), body, []), rest[0]), *others]
            test = test.values[0]
        case = _case_of(test, operand, method.name, classes)
        if (
            case is None
            or not body
            or not isinstance(body[-1], (ast.Return, ast.Raise))
            or (rest[0].orelse and rest[1:])
        ):
            break
        if is_not:
            body, others = others, body
        bodies.append((case, body))
        rest = others
    ends = [body[-1] for _, body in bodies] + rest[-1:]
    if not rest or not all(isinstance(end, (ast.Return, ast.Raise)) for end in ends):
        return []
    return [*bodies, (OperatorCase(f"{method.name}_rest", None), rest)]


def _case_of(test: ast.expr, operand: str, method: str, classes: Set[str]) -> OperatorCase | None:
    """Return the case of ``isinstance(other, Vec)`` or ``isinstance(other, (int, float))``."""
    if not is_test_of_class(test) or ast.unparse(test.args[0]) != operand:
        return None
    named = test.args[1].elts if isinstance(test.args[1], ast.Tuple) else [test.args[1]]
    if isinstance(test.args[1], ast.BinOp):
        named = [each for each in walk_tree(test.args[1]) if isinstance(each, (ast.Name, ast.Attribute))]
    types = {ast.unparse(each) for each in named}
    numbers = INT if {"int", "float"} <= types else 0  # an integer alone is told from no float
    plain = types - classes - {"int"}
    if not plain <= {*_KINDS_OF_TYPES} or ("int" in types) != bool(numbers):
        return None
    kinds = numbers
    for each in plain:
        kinds |= _KINDS_OF_TYPES[each]
    own = types & classes
    suffix = "number" if numbers else "_".join(sorted(own)).lower() or _SUFFIXES.get(min(plain), min(plain))
    return OperatorCase(f"{method}_{suffix}", kinds, frozenset(own))


def method_for(cls: Class, method: str, kinds: int, classes: Set[str]) -> str:
    """Return the name of the method of ``cls`` that an operator calls for an operand.

    Parameters
    ----------
    cls
        Class of the owner, which has ``method``.
    kinds, classes
        Kinds of the operand, and the names of its classes; ``method`` itself is returned if they decide no case.
    """
    if not kinds or kinds & UNKNOWN or bool(classes) != bool(kinds & RECORD):
        return method
    for case in getattr(cls.methods[method].node, "cases", ()):
        is_taken = case.takes(kinds, classes)
        if is_taken is not False:
            return str(case.name) if is_taken and case.name in cls.methods else method
    return method


class KnownTests(ast.NodeTransformer):
    """Leaves out branches for types that a value never has, such as ``isinstance(x, np.ndarray)`` of a shape.

    ``count`` says how many; the types must be final, since what is left out does not come back.
    """

    def __init__(self, kinds_of: Callable[[ast.expr], int], classes_of: Callable[[ast.expr], list[Class]]) -> None:
        self._kinds_of, self._classes_of = kinds_of, classes_of
        self.count = 0

    def _is_false(self, test: ast.expr) -> bool:
        if isinstance(test, ast.BoolOp):
            return any(map(self._is_false, test.values)) if isinstance(test.op, ast.And) else False
        if not is_test_of_class(test) or not is_repeatable(test.args[0]):
            return False
        case = _case_of(test, ast.unparse(test.args[0]), "", frozenset())
        kinds = self._kinds_of(test.args[0])
        classes = {each.name for each in self._classes_of(test.args[0])}
        if case is None or not kinds or kinds & UNKNOWN or bool(classes) != bool(kinds & RECORD):
            return False
        return case.takes(kinds, classes) is False

    def visit_If(self, node: ast.If) -> ast.stmt | list[ast.stmt]:
        self.generic_visit(node)
        if not self._is_false(node.test):
            return node
        self.count += 1
        return node.orelse or ast.copy_location(ast.Pass(), node)

    def visit_IfExp(self, node: ast.IfExp) -> ast.expr:
        self.generic_visit(node)
        if not self._is_false(node.test):
            return node
        self.count += 1
        return node.orelse

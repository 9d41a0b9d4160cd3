"""Fast paths for arithmetic and comparison where nothing shadows the builtin; anything unusual goes to the builtin.

Each factory gets compiled operands and ``slow``, which calls the builtin itself. Results that are integers are kept
within a bound, so that no program can grow them without end.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from scenelang.interpreter.procedures import Frame, Node
from scenelang.interpreter.values import NIL, Pair

Slow = Callable[[Any, Any], Any]
_LIMIT = 1 << 4000  # beyond this the builtin checks the size


def add(a: Node, b: Node, slow: Slow) -> Node:
    limit, floor = _LIMIT, -_LIMIT

    def node(f: Frame) -> Any:
        x = a(f)
        y = b(f)
        if type(x) is float and type(y) is float:
            return x + y
        if type(x) is int and type(y) is int:
            r = x + y
            if floor < r < limit:
                return r
        return slow(x, y)

    return node


def add_slot_constant(slot: int, y: Any, slow: Slow) -> Node:
    limit, floor = _LIMIT, -_LIMIT
    kind = type(y)

    def node(f: Frame) -> Any:
        x = f[slot]
        if type(x) is kind:
            r = x + y
            if floor < r < limit:
                return r
        return slow(x, y)

    return node


def add_slots(i: int, j: int, slow: Slow) -> Node:
    limit, floor = _LIMIT, -_LIMIT

    def node(f: Frame) -> Any:
        x = f[i]
        y = f[j]
        if type(x) is float and type(y) is float:
            return x + y
        if type(x) is int and type(y) is int:
            r = x + y
            if floor < r < limit:
                return r
        return slow(x, y)

    return node


def sub(a: Node, b: Node, slow: Slow) -> Node:
    limit, floor = _LIMIT, -_LIMIT

    def node(f: Frame) -> Any:
        x = a(f)
        y = b(f)
        if type(x) is float and type(y) is float:
            return x - y
        if type(x) is int and type(y) is int:
            r = x - y
            if floor < r < limit:
                return r
        return slow(x, y)

    return node


def sub_slot_constant(slot: int, y: Any, slow: Slow) -> Node:
    limit, floor = _LIMIT, -_LIMIT
    kind = type(y)

    def node(f: Frame) -> Any:
        x = f[slot]
        if type(x) is kind:
            r = x - y
            if floor < r < limit:
                return r
        return slow(x, y)

    return node


def mul(a: Node, b: Node, slow: Slow) -> Node:
    limit, floor = _LIMIT, -_LIMIT

    def node(f: Frame) -> Any:
        x = a(f)
        y = b(f)
        if type(x) is float:
            if type(y) is float:
                return x * y
        elif type(x) is int and type(y) is int and floor < x < limit and floor < y < limit:
            r = x * y
            if floor < r < limit:
                return r
        return slow(x, y)

    return node


def div(a: Node, b: Node, slow: Slow) -> Node:
    def node(f: Frame) -> Any:
        x = a(f)
        y = b(f)
        if type(x) is float and type(y) is float and y != 0.0:
            return x / y
        return slow(x, y)

    return node


def lt(a: Node, b: Node, slow: Slow) -> Node:
    def node(f: Frame) -> Any:
        x = a(f)
        y = b(f)
        if type(x) is int and type(y) is int:
            return x < y
        if type(x) is float and type(y) is float:
            return x < y
        return slow(x, y)

    return node


def lt_slot_constant(slot: int, y: Any, slow: Slow) -> Node:
    kind = type(y)

    def node(f: Frame) -> Any:
        x = f[slot]
        if type(x) is kind:
            return x < y
        return slow(x, y)

    return node


def gt(a: Node, b: Node, slow: Slow) -> Node:
    return _swapped(lt, a, b, slow)


def _swapped(factory: Callable[[Node, Node, Slow], Node], a: Node, b: Node, slow: Slow) -> Node:
    """``(> a b)`` as ``(< b a)``, operands still evaluated left to right."""

    def node(f: Frame) -> Any:
        x = a(f)
        y = b(f)
        if type(x) is int and type(y) is int:
            return x > y
        if type(x) is float and type(y) is float:
            return x > y
        return slow(x, y)

    return node


def le(a: Node, b: Node, slow: Slow) -> Node:
    def node(f: Frame) -> Any:
        x = a(f)
        y = b(f)
        if type(x) is int and type(y) is int:
            return x <= y
        if type(x) is float and type(y) is float:
            return x <= y
        return slow(x, y)

    return node


def ge(a: Node, b: Node, slow: Slow) -> Node:
    def node(f: Frame) -> Any:
        x = a(f)
        y = b(f)
        if type(x) is int and type(y) is int:
            return x >= y
        if type(x) is float and type(y) is float:
            return x >= y
        return slow(x, y)

    return node


def eq(a: Node, b: Node, slow: Slow) -> Node:
    def node(f: Frame) -> Any:
        x = a(f)
        y = b(f)
        if type(x) is int and type(y) is int:
            return x == y
        if type(x) is float and type(y) is float:
            return x == y
        return slow(x, y)

    return node


def eq_slot_constant(slot: int, y: Any, slow: Slow) -> Node:
    kind = type(y)

    def node(f: Frame) -> Any:
        x = f[slot]
        if type(x) is kind:
            return x == y
        return slow(x, y)

    return node


BINARY: dict[str, Callable[[Node, Node, Slow], Node]] = {
    "add": add, "sub": sub, "mul": mul, "div": div, "lt": lt, "gt": gt, "le": le, "ge": ge, "eq": eq,
}  # fmt: skip
SLOT_CONSTANT: dict[str, Callable[[int, Any, Slow], Node]] = {
    "add": add_slot_constant, "sub": sub_slot_constant, "lt": lt_slot_constant, "eq": eq_slot_constant,
}  # fmt: skip
SLOTS: dict[str, Callable[[int, int, Slow], Node]] = {"add": add_slots}


def negation(a: Node, slow: Callable[[Any], Any]) -> Node:
    def node(f: Frame) -> Any:
        x = a(f)
        return x is False or x is None

    return node


def car(a: Node, slow: Callable[[Any], Any]) -> Node:
    def node(f: Frame) -> Any:
        x = a(f)
        return x.car if type(x) is Pair else slow(x)

    return node


def cdr(a: Node, slow: Callable[[Any], Any]) -> Node:
    def node(f: Frame) -> Any:
        x = a(f)
        return x.cdr if type(x) is Pair else slow(x)

    return node


def is_null(a: Node, slow: Callable[[Any], Any]) -> Node:
    def node(f: Frame) -> Any:
        x = a(f)
        return True if x is NIL else (False if type(x) is Pair else slow(x))

    return node


UNARY: dict[str, Callable[[Node, Callable[[Any], Any]], Node]] = {
    "not": negation, "car": car, "cdr": cdr, "null?": is_null,
}  # fmt: skip
PREDICATES = frozenset({"lt", "gt", "le", "ge", "eq", "not", "null?", "pair?"})  # always give a boolean

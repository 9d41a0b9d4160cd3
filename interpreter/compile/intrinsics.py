"""Fast paths for arithmetic, comparison and list builtins that are not shadowed.

Each factory takes compiled operands and ``slow``, which calls the builtin itself and handles all unusual cases. Each
operator has its own factory, because an operator that is passed as a function would cost a Python call at every
evaluation. The names of the operations are those of ``Builtin.intrinsic``; generated code inlines the same ones
(``generated.OPERATORS``).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from scenelang.interpreter.runtime.procedures import Frame, Node
from scenelang.interpreter.scene.pose import compose
from scenelang.interpreter.values.values import NIL, Matrix, Pair, Vector

Slow = Callable[[Any, Any], Any]
_NUMBERS = frozenset((int, float))
_LIMIT = 1 << 4000  # of Integers on fast paths; the builtin checks larger results, so that they cannot grow forever


def add(a: Node, b: Node, slow: Slow) -> Node:
    """Return a node for ``(+ a b)``."""
    limit, floor = _LIMIT, -_LIMIT

    def node(f: Frame) -> Any:
        x = a(f)
        y = b(f)
        kind = type(x)
        if kind is type(y):
            if kind is float:
                return x + y
            if kind is int:
                r = x + y
                if floor < r < limit:
                    return r
        elif kind in _NUMBERS and type(y) in _NUMBERS:
            r = _mixed_add(x, y)
            if r is not None:
                return r
        return slow(x, y)

    return node


def add_slot_constant(slot: int, y: Any, slow: Slow) -> Node:
    """Return a node for ``(+ variable number)``, such as the step of a counter."""
    kind = type(y)

    def node(f: Frame) -> Any:
        x = f[slot]
        if type(x) is kind:
            return x + y  # unchecked: it grows by a constant per step, so the step limit bounds it
        return slow(x, y)

    return node


def add_slots(i: int, j: int, slow: Slow) -> Node:
    """Return a node for ``(+ variable variable)``."""
    limit, floor = _LIMIT, -_LIMIT

    def node(f: Frame) -> Any:
        x = f[i]
        y = f[j]
        kind = type(x)
        if kind is type(y):
            if kind is float:
                return x + y
            if kind is int:
                r = x + y
                if floor < r < limit:
                    return r
        return slow(x, y)

    return node


def lt_slots(i: int, j: int, slow: Slow) -> Node:
    """Return a node for ``(< variable variable)``."""

    def node(f: Frame) -> Any:
        x = f[i]
        y = f[j]
        if type(x) is type(y) and type(x) in _NUMBERS:
            return x < y
        return slow(x, y)

    return node


def sub(a: Node, b: Node, slow: Slow) -> Node:
    """Return a node for ``(- a b)``."""
    limit, floor = _LIMIT, -_LIMIT

    def node(f: Frame) -> Any:
        x = a(f)
        y = b(f)
        kind = type(x)
        if kind is type(y):
            if kind is float:
                return x - y
            if kind is int:
                r = x - y
                if floor < r < limit:
                    return r
        elif kind in _NUMBERS and type(y) in _NUMBERS:
            r = _mixed_sub(x, y)
            if r is not None:
                return r
        return slow(x, y)

    return node


def sub_slot_constant(slot: int, y: Any, slow: Slow) -> Node:
    """Return a node for ``(- variable number)``."""
    kind = type(y)

    def node(f: Frame) -> Any:
        x = f[slot]
        if type(x) is kind:
            return x - y  # unchecked: it grows by a constant per step, so the step limit bounds it
        return slow(x, y)

    return node


def mul(a: Node, b: Node, slow: Slow) -> Node:
    """Return a node for ``(* a b)``.

    Operands are bounded too, because a product of unbounded ones would take long before its size is known.
    """
    limit, floor = _LIMIT, -_LIMIT

    def node(f: Frame) -> Any:
        x = a(f)
        y = b(f)
        kind = type(x)
        if kind is type(y):
            if kind is float:
                return x * y
            if kind is int and floor < x < limit and floor < y < limit:
                r = x * y
                if floor < r < limit:
                    return r
        elif kind in _NUMBERS and type(y) in _NUMBERS:
            r = _mixed_mul(x, y)
            if r is not None:
                return r
        return slow(x, y)

    return node


def _mixed_add(x: Any, y: Any) -> Any:
    """Return the sum of an Integer and a Float, or None if the Integer is too large to convert."""
    try:
        return x + y
    except OverflowError:
        return None


def _mixed_sub(x: Any, y: Any) -> Any:
    """Return the difference of an Integer and a Float, or None if the Integer is too large to convert."""
    try:
        return x - y
    except OverflowError:
        return None


def _mixed_mul(x: Any, y: Any) -> Any:
    """Return the product of an Integer and a Float, or None if the Integer is too large to convert."""
    try:
        return x * y
    except OverflowError:
        return None


def div(a: Node, b: Node, slow: Slow) -> Node:
    """Return a node for ``(/ a b)``."""

    def node(f: Frame) -> Any:
        x = a(f)
        y = b(f)
        if type(x) in _NUMBERS and type(y) in _NUMBERS and y:
            try:
                return x / y
            except OverflowError:
                return slow(x, y)
        return slow(x, y)

    return node


def floordiv(a: Node, b: Node, slow: Slow) -> Node:
    """Return a node for ``(// a b)`` of Integers."""

    def node(f: Frame) -> Any:
        x = a(f)
        y = b(f)
        if type(x) is int and type(y) is int and y:
            return x // y
        return slow(x, y)

    return node


def mod(a: Node, b: Node, slow: Slow) -> Node:
    """Return a node for ``(% a b)`` of Integers."""

    def node(f: Frame) -> Any:
        x = a(f)
        y = b(f)
        if type(x) is int and type(y) is int and y:
            return x % y
        return slow(x, y)

    return node


def matmul(a: Node, b: Node, slow: Slow) -> Node:
    """Return a node for ``(@ a b)`` of two poses."""

    def node(f: Frame) -> Any:
        x = a(f)
        y = b(f)
        if type(x) is Matrix and type(y) is Matrix:
            return compose(x, y)
        return slow(x, y)

    return node


def lt(a: Node, b: Node, slow: Slow) -> Node:
    """Return a node for ``(< a b)``."""

    def node(f: Frame) -> Any:
        x = a(f)
        y = b(f)
        if type(x) in _NUMBERS and type(y) in _NUMBERS:
            return x < y
        return slow(x, y)

    return node


def lt_slot_constant(slot: int, y: Any, slow: Slow) -> Node:
    """Return a node for ``(< variable number)``."""
    kind = type(y)

    def node(f: Frame) -> Any:
        x = f[slot]
        if type(x) is kind:
            return x < y
        return slow(x, y)

    return node


def gt(a: Node, b: Node, slow: Slow) -> Node:
    """Return a node for ``(> a b)``."""

    def node(f: Frame) -> Any:
        x = a(f)
        y = b(f)
        if type(x) in _NUMBERS and type(y) in _NUMBERS:
            return x > y
        return slow(x, y)

    return node


def le(a: Node, b: Node, slow: Slow) -> Node:
    """Return a node for ``(<= a b)``."""

    def node(f: Frame) -> Any:
        x = a(f)
        y = b(f)
        if type(x) in _NUMBERS and type(y) in _NUMBERS:
            return x <= y
        return slow(x, y)

    return node


def ge(a: Node, b: Node, slow: Slow) -> Node:
    """Return a node for ``(>= a b)``."""

    def node(f: Frame) -> Any:
        x = a(f)
        y = b(f)
        if type(x) in _NUMBERS and type(y) in _NUMBERS:
            return x >= y
        return slow(x, y)

    return node


def eq(a: Node, b: Node, slow: Slow) -> Node:
    """Return a node for ``(= a b)``."""

    def node(f: Frame) -> Any:
        x = a(f)
        y = b(f)
        if type(x) in _NUMBERS and type(y) in _NUMBERS:
            return x == y
        return slow(x, y)

    return node


def eq_slot_constant(slot: int, y: Any, slow: Slow) -> Node:
    """Return a node for ``(= variable number)``."""
    kind = type(y)

    def node(f: Frame) -> Any:
        x = f[slot]
        if type(x) is kind:
            return x == y
        return slow(x, y)

    return node


BINARY: dict[str, Callable[[Node, Node, Slow], Node]] = {
    "add": add, "sub": sub, "mul": mul, "div": div, "lt": lt, "gt": gt, "le": le, "ge": ge, "eq": eq,
    "floordiv": floordiv, "mod": mod, "matmul": matmul,
}  # fmt: skip
SLOT_CONSTANT: dict[str, Callable[[int, Any, Slow], Node]] = {
    "add": add_slot_constant, "sub": sub_slot_constant, "lt": lt_slot_constant, "eq": eq_slot_constant,
}  # fmt: skip


def negation(a: Node, slow: Callable[[Any], Any]) -> Node:
    """Return a node for ``(not a)``."""

    def node(f: Frame) -> Any:
        x = a(f)
        return x is False or x is None

    return node


def car(a: Node, slow: Callable[[Any], Any]) -> Node:
    """Return a node for ``(car a)``."""

    def node(f: Frame) -> Any:
        x = a(f)
        return x.car if type(x) is Pair else slow(x)

    return node


def cdr(a: Node, slow: Callable[[Any], Any]) -> Node:
    """Return a node for ``(cdr a)``."""

    def node(f: Frame) -> Any:
        x = a(f)
        return x.cdr if type(x) is Pair else slow(x)

    return node


def is_null(a: Node, slow: Callable[[Any], Any]) -> Node:
    """Return a node for ``(null? a)``."""

    def node(f: Frame) -> Any:
        x = a(f)
        return True if x is NIL else (False if type(x) is Pair else slow(x))

    return node


SLOTS: dict[str, Callable[[int, int, Slow], Node]] = {"add": add_slots, "lt": lt_slots}


def if_slot_equals(slot: int, y: Any, slow: Slow, then: Node, otherwise: Node) -> Node:
    """Combine ``(if (= variable number) then otherwise)`` into one node."""
    kind = type(y)

    def node(f: Frame) -> Any:
        x = f[slot]
        if (x == y) if type(x) is kind else slow(x, y):
            return then(f)
        return otherwise(f)

    return node


def if_slot_less(slot: int, y: Any, slow: Slow, then: Node, otherwise: Node) -> Node:
    """Combine ``(if (< variable number) then otherwise)`` into one node."""
    kind = type(y)

    def node(f: Frame) -> Any:
        x = f[slot]
        if (x < y) if type(x) is kind else slow(x, y):
            return then(f)
        return otherwise(f)

    return node


TESTS: dict[str, Callable[[int, Any, Slow, Node, Node], Node]] = {"eq": if_slot_equals, "lt": if_slot_less}
UNARY: dict[str, Callable[[Node, Callable[[Any], Any]], Node]] = {
    "not": negation, "car": car, "cdr": cdr, "null?": is_null,
}  # fmt: skip
PREDICATES = frozenset({"lt", "gt", "le", "ge", "eq", "not", "null?", "pair?"})  # these always return a boolean


# --- arithmetic of generated code outside its inlined paths: mixed numbers, long Integers, vectors of three Floats ---


def adder(slow: Slow) -> Slow:
    """Return a function that adds two values."""

    def add(x: Any, y: Any) -> Any:
        s, t = type(x), type(y)
        if s is Vector and t is Vector and len(x) == 3 and len(y) == 3:
            a, b, c = x
            d, e, f = y
            if type(a) is float and type(d) is float:
                return Vector((a + d, b + e, c + f))
        elif s in _NUMBERS and t in _NUMBERS:
            try:
                r = x + y
            except OverflowError:
                return slow(x, y)
            if type(r) is float or -_LIMIT < r < _LIMIT:
                return r
        return slow(x, y)

    return add


def subtracter(slow: Slow) -> Slow:
    """Return a function that subtracts two values."""

    def subtract(x: Any, y: Any) -> Any:
        s, t = type(x), type(y)
        if s is Vector and t is Vector and len(x) == 3 and len(y) == 3:
            a, b, c = x
            d, e, f = y
            if type(a) is float and type(d) is float:
                return Vector((a - d, b - e, c - f))
        elif s in _NUMBERS and t in _NUMBERS:
            try:
                r = x - y
            except OverflowError:
                return slow(x, y)
            if type(r) is float or -_LIMIT < r < _LIMIT:
                return r
        return slow(x, y)

    return subtract


def multiplier(slow: Slow) -> Slow:
    """Return a function that multiplies two values."""

    def multiply(x: Any, y: Any) -> Any:
        s, t = type(x), type(y)
        if s is Vector and t is float and len(x) == 3:
            a, b, c = x
            if type(a) is float:
                return Vector((a * y, b * y, c * y))
        elif t is Vector and s is float and len(y) == 3:
            a, b, c = y
            if type(a) is float:
                return Vector((x * a, x * b, x * c))
        elif s is Vector and t is Vector and len(x) == 3 and len(y) == 3:
            a, b, c = x
            d, e, f = y
            if type(a) is float and type(d) is float:
                return Vector((a * d, b * e, c * f))
        elif s in _NUMBERS and t in _NUMBERS:
            if s is int and t is int and not (-_LIMIT < x < _LIMIT and -_LIMIT < y < _LIMIT):
                return slow(x, y)
            try:
                r = x * y
            except OverflowError:
                return slow(x, y)
            if type(r) is float or -_LIMIT < r < _LIMIT:
                return r
        return slow(x, y)

    return multiply


def divider(slow: Slow) -> Slow:
    """Return a function that divides two values."""

    def divide(x: Any, y: Any) -> Any:
        if type(x) in _NUMBERS and type(y) in _NUMBERS and y:
            try:
                return x / y
            except OverflowError:
                return slow(x, y)
        if type(x) is Vector and type(y) is float and y and len(x) == 3 and type(x[0]) is float:
            a, b, c = x
            return Vector((a / y, b / y, c / y))
        return slow(x, y)

    return divide


ARITHMETIC: Mapping[str, Callable[[Slow], Slow]] = {
    "add": adder,
    "sub": subtracter,
    "mul": multiplier,
    "div": divider,
}

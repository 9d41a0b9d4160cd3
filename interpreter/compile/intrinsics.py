"""Fast paths for arithmetic, comparison and list builtins that are not shadowed.

Each factory takes compiled operands and ``slow``, which calls the builtin itself and handles all unusual cases. Each
operator has its own factory, because an operator that is passed as a function would cost a Python call at every
evaluation. The names of the operations are those of ``Builtin.intrinsic``; generated code inlines the same ones
(``generated.OPERATORS``).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from scenelang.interpreter.runtime.procedures import Frame, Node
from scenelang.interpreter.scene.pose import compose
from scenelang.interpreter.values.values import NIL, Matrix, MutableList, Pair, Table, Vector, is_short_atom

if TYPE_CHECKING:
    from scenelang.interpreter.runtime.runtime import Runtime

Slow = Callable[[Any, Any], Any]
_NUMBERS = frozenset((int, float))
_INT64 = 1 << 63  # bound of Integers in arrays
_LIMIT = 1 << 4000  # of Integers on fast paths; the builtin checks larger results, so that they cannot grow forever


def add(a: Node, b: Node, slow: Slow) -> Node:
    """Return a node for ``(+ a b)``."""
    limit, floor = _LIMIT, -_LIMIT

    def node(frame: Frame) -> Any:
        x = a(frame)
        y = b(frame)
        kind = type(x)
        if kind is type(y):
            if kind is float:
                return x + y
            if kind is int:
                result = x + y
                if floor < result < limit:
                    return result
        elif kind in _NUMBERS and type(y) in _NUMBERS:
            result = _mixed_add(x, y)
            if result is not None:
                return result
        return slow(x, y)

    return node


def add_slot_constant(slot: int, y: Any, slow: Slow) -> Node:
    """Return a node for ``(+ variable number)``, such as the step of a counter."""
    kind = type(y)

    def node(frame: Frame) -> Any:
        x = frame[slot]
        if type(x) is kind:
            return x + y  # unchecked: it grows by a constant per step, so the step limit bounds it
        return slow(x, y)

    return node


def add_slots(i: int, j: int, slow: Slow) -> Node:
    """Return a node for ``(+ variable variable)``."""
    limit, floor = _LIMIT, -_LIMIT

    def node(frame: Frame) -> Any:
        x = frame[i]
        y = frame[j]
        kind = type(x)
        if kind is type(y):
            if kind is float:
                return x + y
            if kind is int:
                result = x + y
                if floor < result < limit:
                    return result
        return slow(x, y)

    return node


def lt_slots(i: int, j: int, slow: Slow) -> Node:
    """Return a node for ``(< variable variable)``."""

    def node(frame: Frame) -> Any:
        x = frame[i]
        y = frame[j]
        if type(x) is type(y) and type(x) in _NUMBERS:
            return x < y
        return slow(x, y)

    return node


def sub(a: Node, b: Node, slow: Slow) -> Node:
    """Return a node for ``(- a b)``."""
    limit, floor = _LIMIT, -_LIMIT

    def node(frame: Frame) -> Any:
        x = a(frame)
        y = b(frame)
        kind = type(x)
        if kind is type(y):
            if kind is float:
                return x - y
            if kind is int:
                result = x - y
                if floor < result < limit:
                    return result
        elif kind in _NUMBERS and type(y) in _NUMBERS:
            result = _mixed_sub(x, y)
            if result is not None:
                return result
        return slow(x, y)

    return node


def sub_slot_constant(slot: int, y: Any, slow: Slow) -> Node:
    """Return a node for ``(- variable number)``."""
    kind = type(y)

    def node(frame: Frame) -> Any:
        x = frame[slot]
        if type(x) is kind:
            return x - y  # unchecked: it grows by a constant per step, so the step limit bounds it
        return slow(x, y)

    return node


def mul(a: Node, b: Node, slow: Slow) -> Node:
    """Return a node for ``(* a b)``.

    Operands are bounded too, because a product of unbounded ones would take long before its size is known.
    """
    limit, floor = _LIMIT, -_LIMIT

    def node(frame: Frame) -> Any:
        x = a(frame)
        y = b(frame)
        kind = type(x)
        if kind is type(y):
            if kind is float:
                return x * y
            if kind is int and floor < x < limit and floor < y < limit:
                result = x * y
                if floor < result < limit:
                    return result
        elif kind in _NUMBERS and type(y) in _NUMBERS:
            result = _mixed_mul(x, y)
            if result is not None:
                return result
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

    def node(frame: Frame) -> Any:
        x = a(frame)
        y = b(frame)
        if type(x) in _NUMBERS and type(y) in _NUMBERS and y:
            try:
                return x / y
            except OverflowError:
                return slow(x, y)
        return slow(x, y)

    return node


def floordiv(a: Node, b: Node, slow: Slow) -> Node:
    """Return a node for ``(// a b)`` of Integers."""

    def node(frame: Frame) -> Any:
        x = a(frame)
        y = b(frame)
        if type(x) is int and type(y) is int and y:
            return x // y
        return slow(x, y)

    return node


def mod(a: Node, b: Node, slow: Slow) -> Node:
    """Return a node for ``(% a b)`` of Integers."""

    def node(frame: Frame) -> Any:
        x = a(frame)
        y = b(frame)
        if type(x) is int and type(y) is int and y:
            return x % y
        return slow(x, y)

    return node


def matmul(a: Node, b: Node, slow: Slow) -> Node:
    """Return a node for ``(@ a b)`` of two poses."""

    def node(frame: Frame) -> Any:
        x = a(frame)
        y = b(frame)
        if type(x) is Matrix and type(y) is Matrix:
            return compose(x, y)
        return slow(x, y)

    return node


def lt(a: Node, b: Node, slow: Slow) -> Node:
    """Return a node for ``(< a b)``."""

    def node(frame: Frame) -> Any:
        x = a(frame)
        y = b(frame)
        if type(x) in _NUMBERS and type(y) in _NUMBERS:
            return x < y
        return slow(x, y)

    return node


def lt_slot_constant(slot: int, y: Any, slow: Slow) -> Node:
    """Return a node for ``(< variable number)``."""
    kind = type(y)

    def node(frame: Frame) -> Any:
        x = frame[slot]
        if type(x) is kind:
            return x < y
        return slow(x, y)

    return node


def gt(a: Node, b: Node, slow: Slow) -> Node:
    """Return a node for ``(> a b)``."""

    def node(frame: Frame) -> Any:
        x = a(frame)
        y = b(frame)
        if type(x) in _NUMBERS and type(y) in _NUMBERS:
            return x > y
        return slow(x, y)

    return node


def le(a: Node, b: Node, slow: Slow) -> Node:
    """Return a node for ``(<= a b)``."""

    def node(frame: Frame) -> Any:
        x = a(frame)
        y = b(frame)
        if type(x) in _NUMBERS and type(y) in _NUMBERS:
            return x <= y
        return slow(x, y)

    return node


def ge(a: Node, b: Node, slow: Slow) -> Node:
    """Return a node for ``(>= a b)``."""

    def node(frame: Frame) -> Any:
        x = a(frame)
        y = b(frame)
        if type(x) in _NUMBERS and type(y) in _NUMBERS:
            return x >= y
        return slow(x, y)

    return node


def eq(a: Node, b: Node, slow: Slow) -> Node:
    """Return a node for ``(= a b)``."""

    def node(frame: Frame) -> Any:
        x = a(frame)
        y = b(frame)
        if type(x) in _NUMBERS and type(y) in _NUMBERS:
            return x == y
        return slow(x, y)

    return node


def eq_slot_constant(slot: int, y: Any, slow: Slow) -> Node:
    """Return a node for ``(= variable number)``."""
    kind = type(y)

    def node(frame: Frame) -> Any:
        x = frame[slot]
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

    def node(frame: Frame) -> Any:
        x = a(frame)
        return x is False or x is None

    return node


def car(a: Node, slow: Callable[[Any], Any]) -> Node:
    """Return a node for ``(car a)``."""

    def node(frame: Frame) -> Any:
        x = a(frame)
        return x.car if type(x) is Pair else slow(x)

    return node


def cdr(a: Node, slow: Callable[[Any], Any]) -> Node:
    """Return a node for ``(cdr a)``."""

    def node(frame: Frame) -> Any:
        x = a(frame)
        return x.cdr if type(x) is Pair else slow(x)

    return node


def is_null(a: Node, slow: Callable[[Any], Any]) -> Node:
    """Return a node for ``(null? a)``."""

    def node(frame: Frame) -> Any:
        x = a(frame)
        return True if x is NIL else (False if type(x) is Pair else slow(x))

    return node


SLOTS: dict[str, Callable[[int, int, Slow], Node]] = {"add": add_slots, "lt": lt_slots}


def if_slot_equals(slot: int, y: Any, slow: Slow, then: Node, otherwise: Node) -> Node:
    """Combine ``(if (= variable number) then otherwise)`` into one node."""
    kind = type(y)

    def node(frame: Frame) -> Any:
        x = frame[slot]
        if (x == y) if type(x) is kind else slow(x, y):
            return then(frame)
        return otherwise(frame)

    return node


def if_slot_less(slot: int, y: Any, slow: Slow, then: Node, otherwise: Node) -> Node:
    """Combine ``(if (< variable number) then otherwise)`` into one node."""
    kind = type(y)

    def node(frame: Frame) -> Any:
        x = frame[slot]
        if (x < y) if type(x) is kind else slow(x, y):
            return then(frame)
        return otherwise(frame)

    return node


TESTS: dict[str, Callable[[int, Any, Slow, Node, Node], Node]] = {"eq": if_slot_equals, "lt": if_slot_less}
UNARY: dict[str, Callable[[Node, Callable[[Any], Any]], Node]] = {
    "not": negation, "car": car, "cdr": cdr, "null?": is_null,
}  # fmt: skip
PREDICATES = frozenset({"lt", "gt", "le", "ge", "eq", "not", "null?", "pair?"})  # these always return a boolean


# --- arithmetic beyond numbers of one type: mixed numbers, long Integers, vectors of three numbers ---
#
# These cases are computed here, without a call of the builtin; a ``try`` that does not fail costs less than ``len``.
# ``slow`` is the builtin: it computes all others, and reports errors and results that exceed the limit.


def _are_of_arrays(a: int, b: int, c: int) -> bool:
    """Return whether an array may have these Integers."""
    return -_INT64 <= a < _INT64 and -_INT64 <= b < _INT64 and -_INT64 <= c < _INT64


def adder(slow: Slow) -> Slow:
    """Return a function that adds two values; the builtin ``slow`` adds what has no fast path."""

    def add(x: Any, y: Any) -> Any:
        kind_x, kind_y = type(x), type(y)
        if kind_x is Vector and kind_y is Vector:
            try:
                (x0, x1, x2), (y0, y1, y2) = x, y
                a, b, c = x0 + y0, x1 + y1, x2 + y2
            except (ValueError, OverflowError):  # other lengths; a long Integer and a Float
                return slow(x, y)
            if type(a) is float or _are_of_arrays(a, b, c):
                return Vector((a, b, c))
        elif kind_x in _NUMBERS and kind_y in _NUMBERS:
            try:
                result = x + y
            except OverflowError:  # a long Integer and a Float
                return slow(x, y)
            if type(result) is float or -_LIMIT < result < _LIMIT:
                return result
        return slow(x, y)

    return add


def subtracter(slow: Slow) -> Slow:
    """Return a function that subtracts two values; the builtin ``slow`` subtracts values without a fast path."""

    def subtract(x: Any, y: Any) -> Any:
        kind_x, kind_y = type(x), type(y)
        if kind_x is Vector and kind_y is Vector:
            try:
                (x0, x1, x2), (y0, y1, y2) = x, y
                a, b, c = x0 - y0, x1 - y1, x2 - y2
            except (ValueError, OverflowError):  # other lengths; a long Integer and a Float
                return slow(x, y)
            if type(a) is float or _are_of_arrays(a, b, c):
                return Vector((a, b, c))
        elif kind_x in _NUMBERS and kind_y in _NUMBERS:
            try:
                result = x - y
            except OverflowError:  # a long Integer and a Float
                return slow(x, y)
            if type(result) is float or -_LIMIT < result < _LIMIT:
                return result
        return slow(x, y)

    return subtract


def multiplier(slow: Slow) -> Slow:
    """Return a function that multiplies two values; the builtin ``slow`` multiplies what has no fast path."""

    def multiply(x: Any, y: Any) -> Any:
        kind_x, kind_y = type(x), type(y)
        if kind_x is Vector and kind_y in _NUMBERS:
            try:
                x0, x1, x2 = x
                a, b, c = x0 * y, x1 * y, x2 * y
            except (ValueError, OverflowError):  # another length; a long Integer and a Float
                return slow(x, y)
            if type(a) is float or _are_of_arrays(a, b, c):
                return Vector((a, b, c))
        elif kind_y is Vector and kind_x in _NUMBERS:
            return multiply(y, x)  # which is the same for numbers
        elif kind_x is Vector and kind_y is Vector:
            try:
                (x0, x1, x2), (y0, y1, y2) = x, y
                a, b, c = x0 * y0, x1 * y1, x2 * y2
            except (ValueError, OverflowError):  # other lengths; a long Integer and a Float
                return slow(x, y)
            if type(a) is float or _are_of_arrays(a, b, c):
                return Vector((a, b, c))
        elif kind_x in _NUMBERS and kind_y in _NUMBERS:
            # Unlike a sum, a product of long Integers takes long itself, so the operands are tested before.
            if kind_x is int and kind_y is int and not (-_LIMIT < x < _LIMIT and -_LIMIT < y < _LIMIT):
                return slow(x, y)
            try:
                result = x * y
            except OverflowError:  # a long Integer and a Float
                return slow(x, y)
            if type(result) is float or -_LIMIT < result < _LIMIT:
                return result
        return slow(x, y)

    return multiply


def divider(slow: Slow) -> Slow:
    """Return a function that divides two values; the builtin ``slow`` divides what has no fast path."""

    def divide(x: Any, y: Any) -> Any:
        if type(x) in _NUMBERS and type(y) in _NUMBERS and y:
            try:
                return x / y
            except OverflowError:  # long Integers
                return slow(x, y)
        if type(x) is Vector and type(y) is float and y and len(x) == 3 and type(x[0]) is float:
            x0, x1, x2 = x
            return Vector((x0 / y, x1 / y, x2 / y))
        return slow(x, y)

    return divide


ARITHMETIC: Mapping[str, Callable[[Slow], Slow]] = {
    "add": adder,
    "sub": subtracter,
    "mul": multiplier,
    "div": divider,
}


# --- items of collections ----------------------------------------------------------------------------------------
#
# Functions of evaluated operands, which closures and generated code call alike.


def item_reader(rt: Runtime, slow: Slow) -> Slow:
    """Return a function for ``(ref collection key)``: items of mutable lists, vectors and strings, values of tables."""
    read, charge = rt.read, rt.charge

    def item(collection: Any, key: Any) -> Any:
        kind = type(collection)
        if type(key) is int:
            if kind is MutableList:
                items = collection.items
                if -1 < key < len(items):
                    read(collection)
                    return items[key]
            elif kind is Vector or kind is str:
                if -1 < key < len(collection):
                    return collection[key]
            elif kind is Pair and -1 < key < _LONG:
                if key >= _SHORT:
                    charge(key >> 4)
                rest = collection
                try:
                    for _ in range(key):
                        rest = rest.cdr
                    return rest.car
                except AttributeError:  # the list is shorter, which the builtin reports
                    pass
        elif kind is Table and type(key) is str:  # a text is its own key
            entry = collection.entries.get(key)
            if entry is not None:
                read(collection)
                return entry[1]
        return slow(collection, key)

    return item


def item_writer(rt: Runtime, slow: Callable[[Any, Any, Any], Any]) -> Callable[[Any, Any, Any], Any]:
    """Return a function for ``(set-ref! collection key value)``: items of mutable lists."""
    write = rt.write

    def assign(collection: Any, key: Any, value: Any) -> Any:
        if type(key) is int and type(collection) is MutableList:
            items = collection.items
            if -1 < key < len(items):
                write(collection)
                items[key] = value
                return None
        return slow(collection, key, value)

    return assign


def equality_tester(rt: Runtime, slow: Slow) -> Slow:
    """Return a function for ``(equal? a b)`` of two atoms."""

    def is_equal(a: Any, b: Any) -> Any:
        return a == b if type(a) is type(b) and is_short_atom(a) else slow(a, b)

    return is_equal


def member_finder(rt: Runtime, slow: Callable[[Any, Any, Any], Any]) -> Callable[[Any, Any, Any], Any]:
    """Return a function for ``(member x list equal?)``, as ``case`` compares: an atom in a short list."""
    charge, is_equal = rt.charge, rt.library.builtins["equal?"]

    def member(x: Any, items: Any, same: Any) -> Any:
        kind = type(x)
        if same is not is_equal or not is_short_atom(x):
            return slow(x, items, same)
        tail: Any = False
        rest, count = items, 0
        while type(rest) is Pair and count < _SHORT:
            count += tail is False
            if tail is False and type(rest.car) is kind and rest.car == x:
                tail = rest
            rest = rest.cdr
        if rest is not NIL:  # an improper or a long list
            return slow(x, items, same)
        charge(count)
        return tail

    return member


_SHORT = 16  # items of a list that are passed without a charge, as in the builtins
_LONG = 4096  # items of a list that are passed between two charges

# By the names of intrinsics: the number of operands, and the function above.
ITEMS: Mapping[str, tuple[int, Callable[[Runtime, Any], Callable[..., Any]]]] = {
    "ref": (2, item_reader),
    "set-ref!": (3, item_writer),
    "member": (3, member_finder),
    "equal?": (2, equality_tester),
}

"""Builtins with Python's semantics for values whose type a transpiler cannot infer.

They are imported with ``(import "std/python.scene")``. In other programs types decide, and the plain operators report
mistakes more precisely.

Booleans are the numbers 1 and 0. Lists stand for Python's tuples and lists, arrays for numpy's; a tuple of numbers may
have become a vector, so an array is treated as a tuple where numpy raises an error (the truth of several items).
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.lazy_patterns import lazy_pattern
from scenelang.interpreter.loading import np
from scenelang.interpreter.runtime import parts
from scenelang.interpreter.runtime.show import described, show
from scenelang.interpreter.runtime.types import Registry, type_name, vector_of
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.values import values
from scenelang.interpreter.values.values import (
    NIL,
    Keyword,
    Matrix,
    MutableList,
    Pair,
    Procedure,
    Record,
    Set,
    Symbol,
    Table,
    Vector,
    list_items,
    make_list,
    table_key,
)
from scenelang.stdlib import numbers, sequences
from scenelang.stdlib.numbers import charge_digits
from scenelang.stdlib.operands import (
    ARRAYS,
    flat_items,
    from_numpy,
    is_array,
    items,
    rows,
    shape_of,
    to_numpy,
    wrong_type,
)

if TYPE_CHECKING:
    from scenelang.interpreter.runtime.runtime import Runtime

# Equality, order and membership as in Python. Tuples and lists are both lists here, and a tuple may have become an
# array, so lists, mutable lists and arrays with equal items are equal. As in Python's containers, an item is equal to
# itself, even `nan`. Data can be nested to any depth: all functions are iterative.

_NUMBERS = (int, float, bool)
_MISSING = object()
_MIN_CHARGED_CHARACTERS = 1024  # the comparison of longer strings is charged


def members_of(rt: Runtime, value: Any) -> list[Any] | None:
    """Return the items of a value that is a list, tuple or array in Python.

    None for other values, and for improper lists.
    """
    kind = type(value)
    if kind is MutableList or kind is Vector or value is NIL:
        return items(rt, value)
    if kind in ARRAYS:
        return rows(rt, value) if shape_of(value) else None
    if kind is not Pair:
        return None
    members = []
    while type(value) is Pair:
        members.append(value.car)
        value = value.cdr
    rt.charge(1 + (len(members) >> 2))
    return members if value is NIL else None


# --- equality --------------------------------------------------------------------------------------------------


def python_equal(rt: Runtime, a: Any, b: Any) -> bool:
    """Return ``a == b`` as in Python.

    Two objects whose comparison has begun count as equal where they meet again, so that the comparison of shared and
    circular data ends.
    """
    if type(a) in _NUMBERS and type(b) in _NUMBERS:
        return bool(a == b)
    stack = [(a, b)]
    compared: set[tuple[int, int]] = set()
    while stack:
        a, b = stack.pop()
        if a is b:
            continue
        if isinstance(a, (Pair, MutableList, Table, Record)):
            if (id(a), id(b)) in compared:
                continue
            compared.add((id(a), id(b)))
            rt.charge(1)
        inner = _inner_pairs(rt, a, b)
        if inner is None:
            return False
        stack += inner
    return True


def _inner_pairs(rt: Runtime, a: Any, b: Any) -> list[tuple[Any, Any]] | None:
    """Return the pairs that must be equal for ``a`` and ``b`` to be equal; None if they differ."""
    kind = type(a)
    if kind is str and len(a) > _MIN_CHARGED_CHARACTERS:
        rt.charge(len(a) >> 10)
    if kind in _NUMBERS or kind is str or a is None:
        same_kind = type(b) in _NUMBERS if kind in _NUMBERS else type(b) is kind
        return [] if same_kind and a == b else None
    if kind is Pair and type(b) is Pair:
        return [(a.cdr, b.cdr), (a.car, b.car)]
    if kind in ARRAYS and type(b) in ARRAYS:
        same = shape_of(a) == shape_of(b) and flat_items(rt, a) == flat_items(rt, b)
        return [] if same else None
    left = members_of(rt, a)
    right = members_of(rt, b) if left is not None else None
    if left is not None and right is not None:
        return list(zip(left, right)) if len(left) == len(right) else None
    if kind is Table or kind is Set:
        return _entry_pairs(rt, a, b)
    if kind is Record and type(b) is Record:
        rt.read(a)
        rt.read(b)
        return list(zip(a.values, b.values)) if a.type is b.type else None
    return [] if values.equal(rt, a, b, typed=False) else None


def _entry_pairs(rt: Runtime, a: Any, b: Any) -> list[tuple[Any, Any]] | None:
    """Return the pairs of values of two tables with equal keys; an empty list for equal sets; None if keys differ."""
    if type(a) is not type(b):
        return None
    rt.read(a)
    rt.read(b)
    if len(a.entries) != len(b.entries):
        return None
    rt.charge(len(a.entries))
    pairs = []
    for entry in a.entries.values():
        other = find_entry(rt, b, entry[0] if type(a) is Table else entry)
        if other is _MISSING:
            return None
        if type(a) is Table:
            pairs.append((entry[1], other[1]))
    return pairs


def find_entry(rt: Runtime, collection: Table | Set, key: Any) -> Any:
    """Return the entry ``(key, value)`` of a table, or the member of a set, that Python finds for ``key``.

    ``_MISSING`` if there is none (``is_missing``). The caller must record the read.
    """
    for form in _equal_keys(rt, key):
        entry = collection.entries.get(form, _MISSING)
        if entry is not _MISSING:
            return entry
    return _MISSING


def is_missing(entry: Any) -> bool:
    """Return whether ``find_entry`` found nothing."""
    return entry is _MISSING


def _equal_keys(rt: Runtime, key: Any) -> Iterator[Any]:
    """Yield the canonical keys that are one key in Python.

    These are a boolean and its number, and a tuple as a list and as a vector.
    """
    charge = rt.charge
    yield table_key(key, charge)
    kind = type(key)
    if kind is bool:
        yield int(key)
    elif kind in (int, float) and (key == 0 or key == 1):
        yield table_key(bool(key))
    elif kind is Vector:
        yield table_key(make_list(key), charge)
    elif kind is Pair:
        numbers = [int(item) if type(item) is bool else item for item in list_items(key)]
        yield table_key(make_list(numbers), charge)
        if all(type(item) in (int, float) for item in numbers):
            yield table_key(vector_of(numbers), charge)


# --- order -----------------------------------------------------------------------------------------------------


def python_less(rt: Runtime, a: Any, b: Any) -> bool:
    """Return ``a < b``: the first different items decide, at any depth; if there are none, the shorter list is less."""
    stack: list[tuple[Iterator[tuple[Any, Any]], int]] = [(iter([(a, b)]), 0)]
    while stack:
        pairs, excess = stack[-1]
        for x, y in pairs:
            rt.charge(1)
            left, right = members_of(rt, x), members_of(rt, y)
            if left is not None and right is not None:
                stack.append((zip(left, right), len(left) - len(right)))
                break
            if len(stack) == 1 or not (x is y or python_equal(rt, x, y)):
                return _leaf_less(rt, x, y)
        else:
            stack.pop()
            if excess:
                return excess < 0
    return False


def _leaf_less(rt: Runtime, a: Any, b: Any) -> bool:
    """Return ``a < b`` for values other than lists; sets are ordered by inclusion."""
    if (type(a) in _NUMBERS and type(b) in _NUMBERS) or (type(a) is str and type(b) is str):
        return bool(a < b)
    if type(a) is Set and type(b) is Set:
        return len(a.entries) < len(b.entries) and _is_subset(rt, a, b)
    message = f"`py-<` cannot compare {type_name(a)} and {type_name(b)}"
    raise SceneError("type", message, hint="as in Python, only numbers, strings and lists of these can be compared")


def _is_subset(rt: Runtime, a: Set, b: Set) -> bool:
    """Return whether all members of ``a`` are members of ``b``, as Python compares them."""
    rt.read(a)
    rt.read(b)
    rt.charge(len(a.entries))
    return all(find_entry(rt, b, member) is not _MISSING for member in a.entries.values())


# --- membership ------------------------------------------------------------------------------------------------


def python_member(rt: Runtime, item: Any, members: list[Any]) -> bool:
    """Return ``item in members``."""
    rt.charge(len(members) >> 2)
    kind = type(item)
    if kind is str:
        return any(type(member) is str and member == item for member in members)
    if kind in _NUMBERS:
        return any(member is item or (type(member) in _NUMBERS and member == item) for member in members)
    return any(member is item or python_equal(rt, member, item) for member in members)


# --- text ------------------------------------------------------------------------------------------------------

_MAX_LEAF_CHARACTERS = 10_000  # of a value that is not a collection
_MAX_PRINTED_NUMBERS = 2_000  # of an array, whose middle numpy abbreviates


class _Text:
    """Piece of output on the stack; ``closes`` is the id of the collection that ends with it."""

    __slots__ = ("closes", "text")

    def __init__(self, text: str, closes: int | None = None) -> None:
        self.text = text
        self.closes = closes


_COMMA = _Text(", ")
_COLON = _Text(": ")


def python_str(rt: Runtime, value: Any) -> str:
    """Return ``str(value)``."""
    if type(value) is str:
        return value
    if type(value) in ARRAYS:
        return _array_text(rt, value, str)
    return python_repr(rt, value)


def python_repr(rt: Runtime, value: Any) -> str:
    """Return ``repr(value)``; types that Python does not have are printed as in the language.

    Iterative, because data may be nested to any depth. A collection inside itself prints as ``[...]``.
    """
    out: list[str] = []
    size = 0
    open_now: set[int] = set()
    stack: list[Any] = [value]
    while stack:
        item = stack.pop()
        if type(item) is _Text:
            if item.closes is not None:
                open_now.discard(item.closes)
            text = item.text
        else:
            text = _piece(rt, item, stack, open_now)
        out.append(text)
        size += len(text)
        if not len(out) & 0xFF:
            rt.charge(0x100)
        rt.meter.check_growth(size, "a string")
    rt.meter.check_size(size, "a string")
    return "".join(out)


def _piece(rt: Runtime, item: Any, stack: list[Any], open_now: set[int]) -> str:
    """Return the opening text of ``item``; the pieces that follow are pushed on ``stack``."""
    kind = type(item)
    if kind is Set and not item.entries:
        rt.read(item)
        return "set()"
    if kind is Table:
        rt.read(item)
        rows: list[list[Any]] | None = [[key, _COLON, entry] for key, entry in item.entries.values()]
    elif kind is Set:
        rows = [[member] for member in items(rt, item)]
    elif kind is Pair or item is NIL or kind is MutableList:
        members = members_of(rt, item)
        rows = None if members is None else [[member] for member in members]
    else:
        rows = None
    if rows is None:
        return _leaf(rt, item)
    opening, closing = ("{", "}") if kind in (Table, Set) else ("[", "]")
    if id(item) in open_now:
        return f"{opening}...{closing}"
    rt.charge(len(rows))
    if item is not NIL:
        open_now.add(id(item))
    stack.append(_Text(closing, id(item)))
    for position in range(len(rows) - 1, -1, -1):
        stack += reversed(rows[position])
        if position:
            stack.append(_COMMA)
    return opening


def _leaf(rt: Runtime, item: Any) -> str:
    """Return the text of a value that is not a collection."""
    kind = type(item)
    if kind is str:
        rt.charge(len(item) >> 4)
    if kind in (int, float, bool, str) or item is None:
        charge_digits(rt, item)
        return repr(item)
    if kind is Symbol or kind is Keyword:
        return repr(str(item))
    if kind in ARRAYS:
        return _array_text(rt, item, repr)
    return rt.show(item, _MAX_LEAF_CHARACTERS)


def _array_text(rt: Runtime, value: Any, text: Callable[[Any], str]) -> str:
    """Return the text of an array as numpy prints it, which abbreviates the middle of a long one."""
    data = np.asarray(to_numpy(rt, value))
    rt.charge(min(data.size, _MAX_PRINTED_NUMBERS))
    return text(data)


# --- the operator % on strings ---------------------------------------------------------------------------------

# Python's library reference, "printf-style String Formatting".
_FIELD = lazy_pattern(
    r"%(?:\((?P<key>[^()]*)\))?(?P<flags>[-+ #0]*)(?P<width>\*|\d+)?(?:\.(?P<precision>\*|\d+)?)?[hlL]?(?P<kind>.?)",
    re.S,
)


def format_percent(rt: Runtime, template: str, values: Any) -> str:
    """Return ``template % values``."""
    rt.charge(len(template) >> 3)
    arguments = _Arguments(rt, template, values)
    size = 0

    def fill(match: re.Match[str]) -> str:
        """Return the text of a field, after checking the total size."""
        nonlocal size
        text = _field(rt, template, match, arguments)
        size += len(text)
        rt.charge(1 + (len(text) >> 4))
        rt.meter.check_growth(size, "a string")
        return text

    text = _FIELD.sub(fill, template)
    arguments.check_all_used()
    rt.meter.check_size(len(text), "a string")
    return text


class _Arguments:
    """The right operand of ``%``: the items of a list in order, the values of a table by key, or a single value."""

    def __init__(self, rt: Runtime, template: str, values: Any) -> None:
        """Decide whether ``values`` was a tuple in Python, from its type and the number of fields."""
        self.rt = rt
        self.template = template
        self.table = values if type(values) is Table else None
        # a mutable list was certainly a Python list, a single value; other lists and vectors are treated as tuples
        members = None if type(values) is MutableList else members_of(rt, values)
        fields = [match for match in _FIELD.finditer(template) if match["kind"] != "%"]
        one_field = len(fields) == 1 and "*" not in fields[0][0]
        is_tuple = members is not None and not (one_field and len(members) != 1)
        self.values: list[Any] = members if is_tuple and members is not None else [values]
        self.must_use = is_tuple or type(values) not in (Table, MutableList)
        self.next = 0

    def take(self) -> Any:
        """Return the next value."""
        if self.next >= len(self.values):
            raise _bad_template(self.template, "it has more fields than values")
        self.next += 1
        return self.values[self.next - 1]

    def lookup(self, key: str) -> Any:
        """Return the value of a field with a name."""
        if self.table is None:
            raise _bad_template(self.template, "%(name) expects a table on the right")
        self.rt.read(self.table)
        entry = find_entry(self.rt, self.table, key)
        if is_missing(entry):
            raise SceneError("key", f"the table does not contain {show(key, 60)}")
        return entry[1]

    def check_all_used(self) -> None:
        """Raise SceneError for values without a field, as Python does."""
        if self.must_use and self.next < len(self.values):
            raise _bad_template(self.template, "it has fewer fields than values")


def _bad_template(template: str, reason: str) -> SceneError:
    """Return the error for a template that cannot be filled."""
    return SceneError("format", f"`py-%` cannot fill {show(template, 60)}: {reason}")


def _field(rt: Runtime, template: str, match: re.Match[str], arguments: _Arguments) -> str:
    """Return the text of one field: its value, converted as Python would, formatted by Python's own ``%``."""
    kind = match["kind"]
    if kind == "%":
        return "%"
    if match["key"] is not None and "*" in (match["width"], match["precision"]):
        raise _bad_template(template, "* is not allowed in a field with a name")
    width = _size(rt, template, match["width"], arguments)
    precision = _size(rt, template, match["precision"], arguments)
    precision = "0" if precision.startswith("-") else precision  # as in Python, a negative argument means 0
    point = "." in match[0][max(0, match.end("key") - match.start()) :]  # a point in the key does not count
    value = arguments.take() if match["key"] is None else arguments.lookup(match["key"])
    convert = _CONVERSIONS.get(kind)
    spec = f"%{match['flags']}{width}{'.' + precision if point else ''}{'s' if convert in _TEXTS else kind}"
    if convert is None:
        raise _bad_template(template, f"unknown conversion {show('%' + kind, 10)}")
    try:
        converted = convert(rt, value)
        charge_digits(rt, converted)
        text: str = spec % (converted,)
        return text
    except (TypeError, ValueError, OverflowError):
        reason = f"{spec} does not accept {described(value, 40)}"
        raise _bad_template(template, reason) from None


def _size(rt: Runtime, template: str, digits: str | None, arguments: _Arguments) -> str:
    """Return a width or precision, literal or taken from the values, as text; empty if there is none."""
    if digits == "*":
        value = arguments.take()
        if type(value) not in (int, bool):
            raise _bad_template(template, f"* expects an Integer, got {type_name(value)}")
        digits = str(int(value)) if abs(value) < 10**17 else "9" * 18
    if digits:
        rt.meter.check_size(abs(int(digits[:18])), "a string")
    return digits or ""


def _number(rt: Runtime, value: Any) -> Any:
    """Return the value of %d or %f."""
    if type(value) in (int, float, bool):
        return value
    raise TypeError


def _integer(rt: Runtime, value: Any) -> int:
    """Return the value of %o or %x."""
    if type(value) in (int, bool):
        return int(value)
    raise TypeError


def _character(rt: Runtime, value: Any) -> Any:
    """Return the value of %c: a character or its code point."""
    if type(value) is str and len(value) == 1:
        return value
    return _integer(rt, value)


def _ascii(rt: Runtime, value: Any) -> str:
    """Return the value of %a."""
    return python_repr(rt, value).encode("ascii", "backslashreplace").decode("ascii")


_TEXTS = (python_str, python_repr, _ascii)
_CONVERSIONS: dict[str, Callable[[Runtime, Any], Any]] = {
    **dict.fromkeys("diueEfFgG", _number),
    **dict.fromkeys("oxX", _integer),
    "c": _character,
    "s": python_str,
    "r": python_repr,
    "a": _ascii,
}


registry = Registry("python")

_LISTS = (Pair, type(NIL), MutableList)


def _as_number(value: Any) -> Any:
    """Return a boolean as the number 1 or 0, and other values unchanged."""
    return int(value) if type(value) is bool else value


def _is_part(value: Any) -> bool:
    """Return whether ``value`` is an entity, or a pair (entity . matrix) rather than a list."""
    return type(value) is Entity or (type(value) is Pair and type(value.car) is Entity and type(value.cdr) is Matrix)


def _unsupported(name: str, a: Any, b: Any, hint: str | None = None) -> SceneError:
    """Return the error for operands that an operator does not take."""
    message = f"unsupported operand types for `{name}`: {type_name(a)} and {type_name(b)}"
    return SceneError("type", message, hint=hint)


def _as_array(rt: Runtime, value: Any) -> Any:
    """Return a list as an array, as numpy does for an operand of an array."""
    return from_numpy(to_numpy(rt, value)) if type(value) in _LISTS else value


# --- truth -----------------------------------------------------------------------------------------------------


def is_truthy(rt: Runtime, value: Any) -> bool:
    """Return ``bool(value)``.

    An array is true unless it is empty, where numpy raises an error for several items: a tuple of numbers may have
    become a vector. For the same reason ``python_equal`` compares arrays as a whole.
    """
    kind = type(value)
    if kind in (bool, int, float, str):
        return bool(value)
    if value is None or value is NIL:
        return False
    if kind is MutableList:
        rt.read(value)
        return bool(value.items)
    if kind is Table or kind is Set:
        rt.read(value)
        return bool(value.entries)
    if kind in ARRAYS:
        numbers = 1
        for side in shape_of(value):
            numbers *= side
        return bool(flat_items(rt, value)[0]) if numbers == 1 else numbers > 1
    return value.is_primitive or bool(value.children) if kind is Entity else True


@registry.define("py-truthy?", "value::Any", "Boolean",
                 "Return the truth value of Python: #f, none, 0 and empty strings, lists, tables and sets are false. "
                 "An array of one number has the truth value of the number.",
                 ("(map py-truthy? '(0 \"\" () (0)))", "(#f #f #f #t)"))  # fmt: skip
def truthy(rt: Runtime, value: Any) -> bool:
    return is_truthy(rt, value)


@registry.define("py-bool-or", "value::Any otherwise::Function", "Any",
                 "Python's `or`: return the value if it is true, otherwise the result of the function of no arguments.",
                 ("(py-bool-or 0 (lambda () 5))", "5"))  # fmt: skip
def bool_or(rt: Runtime, value: Any, otherwise: Procedure) -> Any:
    return value if is_truthy(rt, value) else rt.apply(otherwise, ())


@registry.define("py-bool-and", "value::Any then::Function", "Any",
                 "Python's `and`: return the value if it is false, otherwise the result of the function of no "
                 "arguments.",
                 ("(py-bool-and 0 (lambda () 5))", "0"))  # fmt: skip
def bool_and(rt: Runtime, value: Any, then: Procedure) -> Any:
    return rt.apply(then, ()) if is_truthy(rt, value) else value


# --- arithmetic ------------------------------------------------------------------------------------------------


@registry.define("py-+", "a::Any b::Any", "Any",
                 "Python's `+`: add numbers, concatenate strings, concatenate lists or parts, add arrays elementwise, "
                 "also to a list.",
                 ("(list (py-+ 1 #t) (py-+ \"a\" \"b\") (py-+ '(1) '(2)) (py-+ [1 2] '(3 4)))",
                  '(2 "ab" (1 2) [4 6])'))  # fmt: skip
def plus(rt: Runtime, a: Any, b: Any) -> Any:
    a, b = _as_number(a), _as_number(b)
    if type(a) is str and type(b) is str:
        rt.meter.check_size(len(a) + len(b), "a string")
        return a + b
    if is_array(a) or is_array(b):
        return numbers.add(rt, _as_array(rt, a), _as_array(rt, b))
    if _is_part(a) or _is_part(b):  # shapes are lists in the reference implementation
        return make_list([*parts.parts_of(rt, a), *parts.parts_of(rt, b)])
    if type(a) in _LISTS and type(b) in _LISTS:
        return _concatenate(rt, a, b)
    if type(a) in (int, float) and type(b) in (int, float):
        return numbers.add(rt, a, b)
    hint = "to convert a value to text, write `(py-str value)`" if str in (type(a), type(b)) else None
    raise _unsupported("py-+", a, b, hint)


def _concatenate(rt: Runtime, a: Any, b: Any) -> Any:
    """Return the list of the items of two lists."""
    left, right = items(rt, a, "py-+"), items(rt, b, "py-+")
    rt.meter.check_size(len(left) + len(right), "a list")
    return make_list(left, make_list(right) if type(b) is MutableList else b)  # share an immutable tail


@registry.define("py-*", "a::Any b::Any", "Any",
                 "Python's `*`: multiply numbers, or arrays elementwise; a list or string times an Integer repeats it.",
                 ("(list (py-* 2 1.5) (py-* \"ab\" 2) (py-* 2 '(1 2)) (py-* [1 2] '(3 4)))",
                  '(3.0 "abab" (1 2 1 2) [3 8])'))  # fmt: skip
def times(rt: Runtime, a: Any, b: Any) -> Any:
    a, b = _as_number(a), _as_number(b)
    if is_array(a) or is_array(b):
        return numbers.multiply(rt, _as_array(rt, a), _as_array(rt, b))
    if type(a) in (int, float) and type(b) in (int, float):
        return numbers.multiply(rt, a, b)
    if type(a) is int:
        a, b = b, a
    if type(b) is int:
        return _repeat(rt, a, max(0, b))
    raise _unsupported("py-*", a, b)


def _repeat(rt: Runtime, value: Any, count: int) -> Any:
    """Return a string, list or shape repeated ``count`` times."""
    if type(value) is str:
        rt.meter.check_size(len(value) * count, "a string")
        return value * count
    if _is_part(value):
        members: list[Any] = list(parts.primitives_of(rt, value))
    elif type(value) in _LISTS:
        members = items(rt, value, "py-*")
    else:
        raise _unsupported("py-*", value, count)
    rt.meter.check_size(len(members) * count, "a list")
    return make_list(members * count)


@registry.define("py-%", "a::Any b::Any", "Any",
                 "Python's `%`: return the remainder of `//`, elementwise on arrays; for a string, the text with its "
                 "fields %d, %s, %.2f filled with a value, or with the items of an immutable list, as of a tuple.",
                 ("(list (py-% -1 12) (py-% \"%d of %s\" '(3 \"oak\")))", '(11 "3 of oak")'))  # fmt: skip
def percent(rt: Runtime, a: Any, b: Any) -> Any:
    if type(a) is str:
        return format_percent(rt, a, b)
    a, b = _as_number(a), _as_number(b)
    if is_array(a) or is_array(b):
        return numbers.modulo(rt, _as_array(rt, a), _as_array(rt, b))
    if type(a) in (int, float) and type(b) in (int, float):
        return operator.mod(a, b)
    raise _unsupported("py-%", a, b)


# --- comparison ------------------------------------------------------------------------------------------------


@registry.define("py-==", "a::Any b::Any", "Boolean",
                 "Python's `==`: compare numbers by value (#t is 1), also inside lists, tables and sets. A mutable "
                 "list or an array equals a list of equal items.",
                 ("(list (py-== '(1 2.) '(1. 2)) (py-== #t 1) (py-== \"1\" 1))", "(#t #t #f)"))  # fmt: skip
def equals(rt: Runtime, a: Any, b: Any) -> bool:
    return python_equal(rt, a, b)


@registry.define("py-<", "a::Any b::Any", "Boolean",
                 "Python's `<`: compare numbers, strings, or lists by their first different items.",
                 ("(list (py-< 1 2.) (py-< \"b\" \"a\") (py-< '(1 2) '(1 2 0)))", "(#t #f #t)"))  # fmt: skip
def less(rt: Runtime, a: Any, b: Any) -> bool:
    return python_less(rt, a, b)


@registry.define("py-in", "x::Any xs::Any", "Boolean",
                 "Python's `in`: return whether `x` is an item of a list, array, set or parts, a key of a table, or a "
                 "part of a string.",
                 ("(list (py-in 1. '(1 2)) (py-in \"a\" (table \"a\" 1)) (py-in \"leg\" \"chair leg\"))",
                  "(#t #t #t)"))  # fmt: skip
def is_in(rt: Runtime, x: Any, xs: Any) -> bool:
    if type(xs) is str:
        if type(x) is not str:
            raise wrong_type("py-in", "a string to search for in a string", x)
        rt.charge(len(xs) >> 5)
        return x in xs
    if type(xs) is Table or type(xs) is Set:
        _check_hashable(rt, x)
        rt.read(xs)
        return not is_missing(find_entry(rt, xs, x))
    if type(x) in (int, float, bool) and len(shape_of(xs)) > 1:  # numpy looks through all axes
        return python_member(rt, x, flat_items(rt, xs))
    return python_member(rt, x, _members(rt, xs, "py-in"))


def _check_hashable(rt: Runtime, key: Any) -> None:
    """Raise an error for a key that Python cannot hash; an immutable list may have been a tuple."""
    members = members_of(rt, key) if type(key) is Pair else None
    for item in (key, *(members or ())):
        if type(item) in (MutableList, Table, Set):
            hint = "use an immutable list as the key: `(list ...)`"
            raise SceneError("type", f"`py-in` expects a key that Python can hash, got {type_name(item)}", hint=hint)


# --- items -----------------------------------------------------------------------------------------------------


def _members(rt: Runtime, value: Any, name: str) -> list[Any]:
    """Return the items over which Python would iterate.

    Of a shape these are its primitives and not its parts: in the reference implementation a shape is the flat list of
    its primitives, so only these give the same counts and items.
    """
    if _is_part(value):
        return list(parts.primitives_of(rt, value))
    members = members_of(rt, value)
    if members is not None:
        return members
    return items(rt, value, name)


@registry.define("py-iter", "xs::Any", "List",
                 "Return the list that Python would iterate over: items of a list, set or array, characters, keys of "
                 "a table, primitives of an entity.",
                 ('(list (py-iter "ab") (py-iter (table "x" 1)) (py-iter [1 2]))', '(("a" "b") ("x") (1 2))'),
                 )  # fmt: skip
def iter_(rt: Runtime, xs: Any) -> Any:
    return make_list(_members(rt, xs, "py-iter"))


@registry.define("py-ref", "collection::Any key::Any more::Any ...", "Any",
                 "Python's `collection[key]`: as `ref`, but #t and #f are the indices 1 and 0, an entity or a pair "
                 "(entity . matrix) is the list of its primitives, and a missing key of a table is an error. Further "
                 "keys select in the item.",
                 ("(list (py-ref '(a b) #t) (py-ref (table 1 'x) #t) (py-ref [[1 2] [3 4]] 1 0))",
                  "(b x 3)"))  # fmt: skip
def ref(rt: Runtime, collection: Any, key: Any, *more: Any) -> Any:
    if is_array(collection):
        return sequences.array_ref(rt, collection, tuple(map(_as_number, (key, *more))))
    for item_key in (key, *more):
        collection = _item(rt, collection, item_key)
    return collection


def _item(rt: Runtime, collection: Any, key: Any) -> Any:
    """Return ``collection[key]`` for one key; raise the error of ``ref`` if there is no such item."""
    if type(collection) is Table:
        rt.read(collection)
        entry = find_entry(rt, collection, key)
        if is_missing(entry):
            return sequences.table_ref(rt, collection, key, ())  # without a default: raises the error
        _, value = entry
        return value
    if _is_part(collection):
        collection = make_list(parts.primitives_of(rt, collection))
    return sequences.ref(rt, collection, _as_number(key))


@registry.define("py-str", "value::Any", "String",
                 "Python's `str`: numbers as Python prints them, True, False and None, strings unchanged, lists as "
                 "[1, 'a'].",
                 ("(list (py-str 1.) (py-str #t) (py-str '(1 \"a\")))", '("1.0" "True" "[1, \'a\']")'))  # fmt: skip
def str_(rt: Runtime, value: Any) -> str:
    return python_str(rt, value)

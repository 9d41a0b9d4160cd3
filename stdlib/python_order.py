"""Equality, order and membership as Python has them: for the dynamic operators of transpiled programs (``python``).

Booleans are the numbers 1 and 0. Tuples and lists are both lists here, and a tuple may have become an array, so lists,
mutable lists and arrays with equal items are equal. As in Python, an item is equal to itself, even ``nan``. Data may be
nested as deep as memory allows.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.runtime import values
from scenelang.interpreter.runtime.runtime import Runtime
from scenelang.interpreter.runtime.types import type_name, vector_of
from scenelang.interpreter.runtime.values import (
    NIL,
    MutableList,
    Pair,
    Record,
    Set,
    Table,
    Vector,
    list_items,
    make_list,
    table_key,
)
from scenelang.stdlib.arraydata import ARRAYS, flat_items, shape_of
from scenelang.stdlib.lists import items, rows

_NUMBERS = (int, float, bool)
_MISSING = object()
_LONG = 1024  # characters: the comparison of longer strings is charged


def members_of(rt: Runtime, value: Any) -> list[Any] | None:
    """The items of what Python has as a list, tuple or array; None for anything else, improper lists included."""
    kind = type(value)
    if kind is MutableList or kind is Vector or value is NIL:
        return items(rt, value)
    if kind in ARRAYS:
        return rows(rt, value) if shape_of(value) else None
    if kind is not Pair:
        return None
    found = []
    while type(value) is Pair:
        found.append(value.car)
        value = value.cdr
    rt.charge(1 + (len(found) >> 2))
    return found if value is NIL else None


# --- equality --------------------------------------------------------------------------------------------------


def python_equal(rt: Runtime, a: Any, b: Any) -> bool:
    """``a == b``. Pairs that were compared before are not compared again, so shared and circular data end."""
    if type(a) in _NUMBERS and type(b) in _NUMBERS:
        return bool(a == b)
    stack = [(a, b)]
    seen: set[tuple[int, int]] = set()
    while stack:
        a, b = stack.pop()
        if a is b:
            continue
        if isinstance(a, (Pair, MutableList, Table, Record)):
            if (id(a), id(b)) in seen:
                continue
            seen.add((id(a), id(b)))
            rt.charge(1)
        inner = _inner_pairs(rt, a, b)
        if inner is None:
            return False
        stack += inner
    return True


def _inner_pairs(rt: Runtime, a: Any, b: Any) -> list[tuple[Any, Any]] | None:
    """What must be equal for ``a`` and ``b`` to be; None when they differ."""
    kind = type(a)
    if kind is str and len(a) > _LONG:
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
    """The values of two tables under equal keys; nothing for two sets of equal members."""
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
    """The entry of a table ``(key, value)`` or the member of a set that Python would find under ``key``, else
    ``_MISSING``. The caller notes the read."""
    for form in _forms_of_key(rt, key):
        entry = collection.entries.get(form, _MISSING)
        if entry is not _MISSING:
            return entry
    return _MISSING


def is_missing(entry: Any) -> bool:
    return entry is _MISSING


def _forms_of_key(rt: Runtime, key: Any) -> Iterator[Any]:
    """The canonical keys under which tables may hold what Python calls one key: a boolean or its number, a tuple as a
    list or as a vector."""
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
    """``a < b``: the first items that differ decide, at any depth; else the shorter list is less."""
    waiting: list[tuple[Iterator[tuple[Any, Any]], int]] = [(iter([(a, b)]), 0)]
    while waiting:
        pairs, longer = waiting[-1]
        for x, y in pairs:
            rt.charge(1)
            left, right = members_of(rt, x), members_of(rt, y)
            if left is not None and right is not None:
                waiting.append((zip(left, right), len(left) - len(right)))
                break
            if len(waiting) == 1 or not (x is y or python_equal(rt, x, y)):
                return _leaf_less(rt, x, y)
        else:
            waiting.pop()
            if longer:
                return longer < 0
    return False


def _leaf_less(rt: Runtime, a: Any, b: Any) -> bool:
    if (type(a) in _NUMBERS and type(b) in _NUMBERS) or (type(a) is str and type(b) is str):
        return bool(a < b)
    if type(a) is Set and type(b) is Set:
        return len(a.entries) < len(b.entries) and _is_subset(rt, a, b)
    message = f"Python has no order between {type_name(a)} and {type_name(b)}"
    raise SceneError("type", message, hint="numbers, strings and lists of these have one")


def _is_subset(rt: Runtime, a: Set, b: Set) -> bool:
    rt.read(a)
    rt.read(b)
    rt.charge(len(a.entries))
    return all(find_entry(rt, b, member) is not _MISSING for member in a.entries.values())


# --- membership ------------------------------------------------------------------------------------------------


def python_member(rt: Runtime, item: Any, members: list[Any]) -> bool:
    """``item in members``."""
    rt.charge(len(members) >> 2)
    kind = type(item)
    if kind is str:
        return any(type(member) is str and member == item for member in members)
    if kind in _NUMBERS:
        return any(member is item or (type(member) in _NUMBERS and member == item) for member in members)
    return any(member is item or python_equal(rt, member, item) for member in members)

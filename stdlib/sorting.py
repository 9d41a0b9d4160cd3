"""Order: sorting, smallest and largest, by natural order, by keys, or by a function of the program."""

from __future__ import annotations

from typing import Any

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.library import Registry
from scenelang.interpreter.runtime import Runtime
from scenelang.interpreter.show import show
from scenelang.interpreter.types import type_name
from scenelang.interpreter.values import NIL, MutableArray, MutableList, Pair, Vector
from scenelang.stdlib.errors import empty_sequence
from scenelang.stdlib.higher_order import is_true
from scenelang.stdlib.items import items, iterate, rebuild

registry = Registry("sequences")

_DEEPEST = 30
_BLOCK = 1 << 16  # items that are sorted between two checks


def sort_key(rt: Runtime, value: Any, depth: int = 0) -> Any:
    """``value`` as Python data whose order is the language's; the depth is bounded, so recursion is safe."""
    kind = type(value)
    if kind is int or kind is float or kind is str or kind is bool:
        return value
    if kind is Pair or value is NIL or kind is MutableList or kind is Vector:
        if depth == _DEEPEST:
            raise SceneError("value", f"lists nested deeper than {_DEEPEST} levels have no order")
        rt.charge(1)
        return [sort_key(rt, item, depth + 1) for item in items(rt, value, "sort")]
    if depth:
        return value  # has no order itself; the items before it may decide
    message = f"only numbers, strings and lists of these have an order, not {type_name(value)}: {show(value, 60)}"
    raise SceneError("type", message, hint="say what to compare: `:key` or a function like `<`")


def keys_of(rt: Runtime, members: list[Any], key: Any) -> list[Any]:
    """What the items are ordered by."""
    if key is None:
        return [sort_key(rt, item) for item in members]
    return [sort_key(rt, rt.call1(key, item)) for item in members]


def no_order(members: list[Any]) -> SceneError:
    kinds = list(dict.fromkeys(type_name(item) for item in members))
    mixed = " and ".join(kinds[:2]) if len(kinds) > 1 else "items of different types"
    return SceneError("type", f"there is no order between {mixed}", hint="say what to compare: `:key`")


def sorted_items(rt: Runtime, members: list[Any], less: Any, key: Any, reverse: bool) -> list[Any]:
    """``members`` in order; equal ones keep theirs, also when reversed."""
    if less is not None:
        wrapped = [(member, member if key is None else rt.call1(key, member)) for member in members]
        if reverse:
            wrapped.reverse()
        ordered = [member for member, _ in _merge_sort(rt, wrapped, less)]
        return ordered[::-1] if reverse else ordered
    keys = keys_of(rt, members, key)
    try:
        order = _order(rt, keys, reverse)
    except TypeError:
        raise no_order(members) from None
    return [members[index] for index in order]


def _order(rt: Runtime, keys: list[Any], reverse: bool) -> list[int]:
    """The indices of ``keys`` in order: blocks are sorted, then pairs of them, which Python merges in one go."""
    order = list(range(len(keys)))
    width = _BLOCK
    while True:
        for start in range(0, len(order), width):
            rt.charge(min(width, len(order) - start) >> 3)
            order[start : start + width] = sorted(order[start : start + width], key=keys.__getitem__, reverse=reverse)
        if width >= len(order):
            return order
        width *= 2


def _merge_sort(rt: Runtime, pairs: list[Any], less: Any) -> list[Any]:
    """Stable, bottom-up; ``less`` is a function of the program, so Python's own sort must not call it."""
    width = 1
    while width < len(pairs):
        merged: list[Any] = []
        for start in range(0, len(pairs), 2 * width):
            left, right = pairs[start : start + width], pairs[start + width : start + 2 * width]
            merged += _merge(rt, left, right, less)
        pairs = merged
        width *= 2
    return pairs


def _merge(rt: Runtime, left: list[Any], right: list[Any], less: Any) -> list[Any]:
    out = []
    i = j = 0
    while i < len(left) and j < len(right):
        if is_true(rt.call2(less, right[j][1], left[i][1])):
            out.append(right[j])
            j += 1
        else:
            out.append(left[i])
            i += 1
    return out + left[i:] + right[j:]


def plain_kind(value: Any) -> Any:
    """What a sorted or shuffled ``value`` is built like: arrays of numbers stay arrays, all else becomes a list."""
    if type(value) is Vector or (type(value) is MutableArray and value.data.ndim == 1):
        return value
    return NIL


@registry.define(
    "sort",
    "xs::Sequence [less::Function] [:key::Function] [:reverse::Boolean]",
    "Sequence",
    "The items in rising order, equal ones as they stood: numbers, strings, or lists item by item. `:key` says what of "
    "an item to compare, `:reverse #t` puts the largest first; `less` replaces `<`.",
    ("(list (sort '(3 1 2)) (sort '((a 2) (b 1)) :key second) (sort '(1 2 3) >))", "((1 2 3) ((b 1) (a 2)) (3 2 1))"),
)
def sort(rt: Runtime, xs: Any, less: Any = None, *, key: Any = None, reverse: bool = False) -> Any:
    ordered = sorted_items(rt, list(iterate(rt, xs, "sort")), less, key, reverse)
    return rebuild(rt, plain_kind(xs), ordered)


def _extreme(rt: Runtime, name: str, xs: Any, key: Any, largest: bool) -> Any:
    members = list(iterate(rt, xs, name))
    if not members:
        raise empty_sequence(name)
    keys = keys_of(rt, members, key)
    best = 0
    try:
        for index in range(1, len(keys)):
            if not index & 63:
                rt.charge(4)
            if keys[index] > keys[best] if largest else keys[index] < keys[best]:
                best = index
    except TypeError:
        raise no_order(members) from None
    return members[best]


@registry.define(
    "min-of",
    "xs::Sequence [:key::Function]",
    "Any",
    "The smallest item, by natural order or by `:key`; the first of several.",
    ("(min-of '((a 3) (b 1)) :key second)", "(b 1)"),
)
def min_of(rt: Runtime, xs: Any, *, key: Any = None) -> Any:
    return _extreme(rt, "min-of", xs, key, largest=False)


@registry.define(
    "max-of",
    "xs::Sequence [:key::Function]",
    "Any",
    "The largest item, by natural order or by `:key`; the first of several.",
    ('(max-of \'("oak" "birch" "ash") :key length)', '"birch"'),
)
def max_of(rt: Runtime, xs: Any, *, key: Any = None) -> Any:
    return _extreme(rt, "max-of", xs, key, largest=True)

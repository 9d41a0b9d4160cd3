"""The errors that several topics raise, in one wording."""

from __future__ import annotations

from typing import Any

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.entity import Entity
from scenelang.interpreter.show import show
from scenelang.interpreter.types import type_name
from scenelang.interpreter.values import NIL, HandleList, Matrix, MutableArray, MutableList, Pair, Vector


def wrong_type(name: str, wanted: str, value: Any, hint: str | None = None) -> SceneError:
    """``value`` is not what the function ``name`` wants."""
    return SceneError("type", f"`{name}` wants {wanted}, got {type_name(value)}: {show(value, 60)}", hint=hint)


def not_a_sequence(name: str, value: Any) -> SceneError:
    """``value`` cannot be taken apart into items."""
    if type(value) is HandleList:
        return endless(name)
    hint = "the list of its parts is `(cdr entity)`" if type(value) is Entity else None
    return wrong_type(name, "a list or another sequence", value, hint)


def endless(name: str) -> SceneError:
    message = f"`{name}` would need the end of the root's list of handles, which has none"
    return SceneError("endless", message, hint="take as many as you need: `(list-head gamma n)`")


def improper(name: str, tail: Any) -> SceneError:
    """A chain of pairs does not end in the empty list."""
    if type(tail) is Matrix:
        hint = "a pair `(entity . matrix)` is no list: put it into one with `(list pair)` or `(union pair)`"
    else:
        hint = "only a chain of pairs that ends in '() is a list"
    return SceneError("type", f"`{name}` wants a proper list, but this one ends in {show(tail, 40)}", hint=hint)


def kind_of(value: Any) -> str:
    """What an index error calls a sequence."""
    if type(value) is str:
        return "string"
    if type(value) is Pair or value is NIL or type(value) is MutableList:
        return "list"
    if type(value) is Vector or (type(value) is MutableArray and value.data.ndim == 1):
        return "vector"
    return "array"


def bad_index(index: Any, length: int, what: str) -> SceneError:
    """``index`` is outside a sequence of ``length``."""
    hint = None
    if length and index == length:
        hint = f"the first index is 0, the last {length - 1}"
    return SceneError("index", f"index {show(index, 20)} is outside the {what} of length {length}", hint=hint)


def empty_sequence(name: str, what: str = "sequence") -> SceneError:
    return SceneError("index", f"`{name}` wants a {what} with at least one item, but this one has length 0")

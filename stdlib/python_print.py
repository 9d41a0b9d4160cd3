"""Text as Python makes it: ``str`` of any value, and ``"%d of %s" % values``, without recursion."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import numpy as np

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.runtime import Runtime
from scenelang.interpreter.show import show
from scenelang.interpreter.types import type_name
from scenelang.interpreter.values import NIL, Keyword, MutableList, Pair, Set, Symbol, Table
from scenelang.stdlib.arithmetic import charge_digits
from scenelang.stdlib.arraydata import ARRAYS, to_numpy
from scenelang.stdlib.items import items
from scenelang.stdlib.python_order import find_entry, is_missing, members_of

_LONGEST_LEAF = 10_000
_MOST_PRINTED = 2_000  # numbers of an array


class _Text:
    """A piece of output waiting on the stack. ``closes``: the id of the collection that ends with it."""

    __slots__ = ("closes", "text")

    def __init__(self, text: str, closes: int | None = None) -> None:
        self.text = text
        self.closes = closes


_COMMA = _Text(", ")
_COLON = _Text(": ")


def python_str(rt: Runtime, value: Any) -> str:
    """``str(value)``."""
    if type(value) is str:
        return value
    if type(value) in ARRAYS:
        return _array_text(rt, value, str)
    return python_repr(rt, value)


def python_repr(rt: Runtime, value: Any) -> str:
    """``repr(value)``; what Python does not have prints as it does elsewhere in the language."""
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
    """The text that begins ``item``; what follows is pushed on ``stack``."""
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
    return rt.show(item, _LONGEST_LEAF)


def _array_text(rt: Runtime, value: Any, text: Callable[[Any], str]) -> str:
    """The text of an array as numpy makes it, which leaves out the middle of a long one."""
    data = np.asarray(to_numpy(rt, value))
    rt.charge(min(data.size, _MOST_PRINTED))
    return text(data)


# --- the operator % on strings ---------------------------------------------------------------------------------

_FIELD = re.compile(
    r"%(?:\((?P<key>[^()]*)\))?(?P<flags>[-+ #0]*)(?P<width>\*|\d+)?(?:\.(?P<precision>\*|\d+)?)?[hlL]?(?P<kind>.?)",
    re.S,
)


def format_percent(rt: Runtime, template: str, values: Any) -> str:
    """``template % values``."""
    rt.charge(len(template) >> 3)
    arguments = _Arguments(rt, template, values)
    size = 0

    def fill(match: re.Match[str]) -> str:
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
    """What stands right of ``%``: a list gives its items one by one, a table by key, anything else itself."""

    def __init__(self, rt: Runtime, template: str, values: Any) -> None:
        self.rt = rt
        self.template = template
        self.table = values if type(values) is Table else None
        # a mutable list was a Python list for sure, which is one value; other lists and vectors are taken as tuples
        members = None if type(values) is MutableList else members_of(rt, values)
        fields = [match for match in _FIELD.finditer(template) if match["kind"] != "%"]
        one_field = len(fields) == 1 and "*" not in fields[0][0]
        is_tuple = members is not None and not (one_field and len(members) != 1)
        self.values: list[Any] = members if is_tuple and members is not None else [values]
        self.must_use = is_tuple or type(values) not in (Table, MutableList)
        self.next = 0

    def take(self) -> Any:
        if self.next >= len(self.values):
            raise _bad_template(self.template, "it has more fields than values")
        self.next += 1
        return self.values[self.next - 1]

    def under(self, key: str) -> Any:
        if self.table is None:
            raise _bad_template(self.template, "%(name) wants a table on the right")
        self.rt.read(self.table)
        entry = find_entry(self.rt, self.table, key)
        if is_missing(entry):
            raise SceneError("key", f"the table has no {show(key, 60)}")
        return entry[1]

    def check_all_used(self) -> None:
        if self.must_use and self.next < len(self.values):
            raise _bad_template(self.template, "it has fewer fields than values")


def _bad_template(template: str, why: str) -> SceneError:
    return SceneError("format", f"`py-%` cannot fill {show(template, 60)}: {why}")


def _field(rt: Runtime, template: str, match: re.Match[str], arguments: _Arguments) -> str:
    kind = match["kind"]
    if kind == "%":
        return "%"
    if match["key"] is not None and "*" in (match["width"], match["precision"]):
        raise _bad_template(template, "* has no place in a field with a name")
    width = _size(rt, template, match["width"], arguments)
    precision = _size(rt, template, match["precision"], arguments)
    precision = "0" if precision.startswith("-") else precision  # a negative one from the values counts as none at all
    point = "." in match[0][max(0, match.end("key") - match.start()) :]  # a key may hold one of its own
    value = arguments.take() if match["key"] is None else arguments.under(match["key"])
    convert = _CONVERSIONS.get(kind)
    spec = f"%{match['flags']}{width}{'.' + precision if point else ''}{'s' if convert in _TEXTS else kind}"
    if convert is None:
        raise _bad_template(template, f"it has no conversion {show('%' + kind, 10)}")
    try:
        converted = convert(rt, value)
        charge_digits(rt, converted)
        text: str = spec % (converted,)
        return text
    except (TypeError, ValueError, OverflowError):
        why = f"{spec} does not fit {type_name(value)}: {show(value, 40)}"
        raise _bad_template(template, why) from None


def _size(rt: Runtime, template: str, digits: str | None, arguments: _Arguments) -> str:
    """A width or precision, written or taken from the values; as text, empty when there is none."""
    if digits == "*":
        value = arguments.take()
        if type(value) not in (int, bool):
            raise _bad_template(template, f"* wants an Integer, got {type_name(value)}")
        digits = str(int(value)) if abs(value) < 10**17 else "9" * 18
    if digits:
        rt.meter.check_size(abs(int(digits[:18])), "a string")
    return digits or ""


def _number(rt: Runtime, value: Any) -> Any:
    if type(value) in (int, float, bool):
        return value
    raise TypeError


def _integer(rt: Runtime, value: Any) -> int:
    if type(value) in (int, bool):
        return int(value)
    raise TypeError


def _character(rt: Runtime, value: Any) -> Any:
    if type(value) is str and len(value) == 1:
        return value
    return _integer(rt, value)


def _ascii(rt: Runtime, value: Any) -> str:
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

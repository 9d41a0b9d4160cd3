"""Kinds in checks: which kinds a type of the registry accepts, and hints and fixes that several checks share.

The lattice of kinds itself is ``interpreter/compile/kinds``.
"""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Iterator
from typing import Any

from scenelang.grammar import ast
from scenelang.grammar.datum import ListDatum, Source, Span
from scenelang.grammar.diagnostics import Edit, Fix, SceneError, near_names
from scenelang.grammar.lazy_patterns import lazy_pattern
from scenelang.grammar.reader import piece_at, read
from scenelang.interpreter.compile.kinds import (
    ANY,
    ARRAYS,
    BOOLEAN,
    EMBEDDING,
    ENTITY,
    FUNCTION,
    INTEGER,
    KEYWORD,
    MATRIX,
    MUTABLE_ARRAY,
    MUTABLE_LIST,
    NEVER,
    NUMBER,
    SET,
    STREAM,
    STRING,
    SYMBOL,
    TABLE,
    VECTOR,
    Kind,
    describe,
    item_of,
    length_of,
    vector_of,
)
from scenelang.interpreter.runtime.types import Builtin, Mismatch, Type
from scenelang.interpreter.values.values import Keyword, Pair, Symbol

# --- types of the registry --------------------------------------------------------------------------------------------

_VECTORS = frozenset(("Vector", "List", "MutableList", "MutableArray"))
_SEQUENCES = frozenset((
    "List", "Part", "Pair", "MutableList", "Vector", "Matrix", "Array", "MutableArray", "Table", "Set", "Handles",
    "String",
))  # fmt: skip

ACCEPTED: dict[str, frozenset[str]] = {
    "Word": frozenset(("String",)),
    "String": frozenset(("String",)),
    "Embedding": frozenset(("Embedding", "String")),
    "Matrix": frozenset(("Matrix", "Array", "MutableArray", "List", "MutableList")),
    "Vector": _VECTORS,
    "Point": _VECTORS,
    "Triple": _VECTORS | {"Array"},
    "Color": _VECTORS | {"Array"},
    "Array": frozenset(("Vector", "Matrix", "Array", "MutableArray")),
    "Entity": frozenset(("Entity",)),
    "Parts": frozenset(("Entity", "Part", "Pair", "List", "MutableList")),
    "ArrayItem": frozenset(
        ("Integer", "Float", "Vector", "Matrix", "Array", "MutableArray", "List", "Pair", "Part", "MutableList")
    ),
    "Integer": frozenset(("Integer", "Float")),
    "Float": frozenset(("Integer", "Float")),
    "Number": frozenset(("Integer", "Float")),
    "Numeric": frozenset(("Integer", "Float", "Vector", "Matrix", "Array", "MutableArray")),
    "ArrayLike": frozenset(
        ("Integer", "Float", "Vector", "Matrix", "Array", "MutableArray", "List", "MutableList", "Pair", "Part")
    ),
    "Boolean": frozenset(("Boolean",)),
    "None": frozenset(("None",)),  # of an attribute, which is then as if it were not given
    "Function": frozenset(("Function",)),
    "List": frozenset(("List", "Part", "Pair", "MutableList", "Handles")),
    "Sequence": _SEQUENCES,
    "Symbol": frozenset(("Symbol",)),
    "Keyword": frozenset(("Keyword",)),
    "Pair": frozenset(("List", "Part", "Pair", "Handles")),
    "MutableList": frozenset(("MutableList",)),
    "MutableArray": frozenset(("MutableArray",)),
    "Table": frozenset(("Table",)),
    "Set": frozenset(("Set",)),
    "Stream": frozenset(("Stream",)),
    "Record": frozenset(("Record",)),
    "Axis": frozenset(("Keyword",)),
    "Alignment": frozenset(("Keyword", "None")),
    "Extent": _VECTORS | {"Integer", "Float"},
    "Template": frozenset(("Entity", "Part", "Pair", "List", "MutableList", "Function")),
}
_VECTOR_TYPES = frozenset(("Vector", "Point", "Triple", "Color", "Extent"))


def accepts(type_: Type | str, kind: Kind) -> bool:
    """Return whether a parameter of a registry type may accept a value of this kind; False if it never does."""
    if kind is ANY or kind is NEVER:
        return True
    name = type_ if isinstance(type_, str) else type_.name
    if name == "Any":
        return True
    tags = ACCEPTED.get(name)
    if tags is None:
        return _accepts_generic(name, kind)
    return any(option.tag in tags and _fits(name, option) for option in kind.options)


def _fits(name: str, kind: Kind) -> bool:
    """Return whether a kind with an accepted tag may fit the type ``name`` by its items."""
    if name in _VECTOR_TYPES and kind.tag in _VECTORS:
        length = length_of(kind)
        if kind.tag == "List" and (length == 0 or not all_may_be(kind, "Number")):
            return False
        return name == "Vector" or length is None or length == 3 or (name == "Color" and length > 3)
    if name == "Matrix" and kind.tag == "List":
        return length_of(kind) in (None, 4) and all_may_be(kind, "Vector")
    if name == "Pair":
        return kind.items != ()
    return True


def all_may_be(kind: Kind, name: str) -> bool:
    """Return whether every item of a sequence may have the type ``name``."""
    if kind.items is not None:
        return all(accepts(name, item) for item in kind.items)
    item = item_of(kind)
    return item is NEVER or accepts(name, item)


def _accepts_generic(name: str, kind: Kind) -> bool:
    """Check ``List[...]``, ``Tuple[...]`` and ``Array[...]`` by their outer type, records by their name."""
    outer = name.partition("[")[0]
    if outer == name:
        return any(option.tag == "Record" and option.code in (None, name) for option in kind.options)
    if outer == "List":
        inner = name[len("List[") : -1]
        return any(
            option.tag in ACCEPTED["List"] and (option.tag != "List" or all_may_be(option, inner))
            for option in kind.options
        )
    return any(option.tag in ACCEPTED["List" if outer == "Tuple" else "Array"] for option in kind.options)


def kind_of_type(name: str) -> Kind:
    """Return the kind of a value that a parameter of the type ``name`` holds, after conversion."""
    return _HELD.get(name, ANY)


_HELD: dict[str, Kind] = {
    "Word": STRING, "String": STRING, "Embedding": EMBEDDING, "Matrix": MATRIX, "Vector": VECTOR,
    "Point": vector_of(3), "Array": ARRAYS, "Entity": ENTITY, "Integer": INTEGER, "Float": NUMBER, "Number": NUMBER,
    "Boolean": BOOLEAN, "Symbol": SYMBOL, "Keyword": KEYWORD, "Function": FUNCTION, "MutableList": MUTABLE_LIST,
    "MutableArray": MUTABLE_ARRAY, "Table": TABLE, "Set": SET, "Stream": STREAM,
}  # fmt: skip


def may_be_parts(kind: Kind) -> bool:
    """Return whether a value may be parts: an entity, a posed entity, or a list of these."""
    if kind is ANY or kind is NEVER:
        return True
    return any(_may_be_parts(option) for option in kind.options)


def _may_be_parts(kind: Kind) -> bool:
    """Return whether a value of one tag may be parts."""
    if kind.tag == "List":
        return kind.items is None or all(map(may_be_parts, kind.items))  # a list of unknown length may be empty
    if kind.tag == "Pair" and kind.items is not None:
        return may_be_parts(kind.items[0]) and accepts("Matrix", kind.items[1])
    return kind.tag in ("Entity", "Part", "Pair", "MutableList")


# --- messages ---------------------------------------------------------------------------------------------------------

A_PART = "an Entity, a posed entity or a list of these"  # expected value of parts, for messages

MAX_SHOWN = 40  # characters of source text in a message


def shown(node: Any, kind: Kind) -> str:
    """Return a value for error messages: its kind, and its source text if that is short."""
    text = node.span.text
    if node.span.expansion is None and len(text) <= MAX_SHOWN and "\n" not in text:
        return f"{describe(kind)}: {text}"
    return describe(kind)


def plural(count: int, noun: str) -> str:
    """Return ``1 item`` or ``2 items``."""
    return f"{count} {noun}{'s' * (count != 1)}"


def is_keyword(node: Any) -> bool:
    """Return whether an expression is a literal keyword."""
    return type(node) is ast.Constant and type(node.value) is Keyword


def number_of(node: Any) -> float | None:
    """Return the value of a literal number as a float; None for other expressions, and for too large a number."""
    if type(node) is ast.Constant and type(node.value) in (int, float) and abs(node.value) <= sys.float_info.max:
        return float(node.value)
    return None


def wrap_fix(node: Any, head: str) -> Fix:
    """Return the fix that makes an expression the argument of a call: ``(head node)``."""
    return Fix(f"Write `({head} ...)`", (Edit(node.span, f"({head} {node.span.text})"),), safe=True)


_OPERATORS = frozenset("+-*/%") | {"//", "expt", "<", ">", "<=", ">=", "="}


def infix_fix(span: Span) -> Fix | None:
    """Return the fix for a call in infix notation, such as ``(height * 2)``."""
    text = span.source.text
    if span.expansion is None and text[span.start - 1 : span.start] == "(" and not span.text.startswith("("):
        span = Span(span.source, *piece_at(text, span.start - 1))  # the call around the head
    if span.expansion is not None or not span.text.startswith("("):
        return None
    try:
        forms = read(Source("<call>", span.text)).forms
    except SceneError:
        return None
    items = forms[0].items if len(forms) == 1 and isinstance(forms[0], ListDatum) else ()
    if len(items) != 3 or items[1].span.text not in _OPERATORS:
        return None
    left, operator, right = (item.span.text for item in items)
    return Fix("Write the operator first", (Edit(span, f"({operator} {left} {right})"),))


def brief(text: str) -> str:
    """Return code on one line, a long call by its head and its word, such as ``(call "sphere" ...)``."""
    text = " ".join(text.split())
    head = re.match(r'\([^\s()\[\]"]+(?: "[^"]*")?(?= )', text)
    return text if len(text) <= MAX_SHOWN or head is None else f"{head[0]} ...)"


def swap_fix(node: Any, first: Any, second: Any) -> tuple[str, tuple[Fix, ...]]:
    """Return the hint and fix that exchange the arguments ``first`` and ``second`` of the call ``node``.

    There is no fix in the expansion of a macro.
    """
    hint = "the arguments are in the wrong order"
    if any(part.span.expansion is not None for part in (node, first, second)):
        return hint, ()
    edits = (Edit(first.span, second.span.text), Edit(second.span, first.span.text))
    text, start = node.span.text, node.span.start
    between = text[first.span.end - start : second.span.start - start]
    if between.strip() == "":
        before, after = text[: first.span.start - start], text[second.span.end - start :]
        written = " ".join(f"{before}{brief(second.span.text)} {brief(first.span.text)}{after}".split())
        hint = f"{hint}: write `{written}`"
    return hint, (Fix("Swap the arguments", edits, safe=True),)


def triple_fix(node: Any, role: str = "place") -> tuple[str | None, tuple[Fix, ...]]:
    """Return the hint and fix for a point with two components, or with a fourth one that is 0 or 1.

    A fourth component is common in homogeneous points and in colors with opacity. ``role`` is what the numbers are: a
    "place", a "size" or a "color".
    """
    if type(node) is not ast.ArrayLiteral or node.span.expansion is not None or not node.span.text.startswith("["):
        return None, ()
    items = node.items
    end = items[-1].span.end if items else node.span.end
    if len(items) == 2:
        edit = Edit(Span(node.span.source, end, end), " 0")
        first, second = (item.span.text for item in items)
        hint = f"x, y and z are needed, y is up: `[{first} 0 {second}]` on the ground, `[{first} {second} 0]` upright"
        if role != "place":
            needed = (
                "red, green and blue are needed" if role == "color" else "the sizes along x, y (up) and z are needed"
            )
            hint = f"{needed}: `[{first} {second} ...]`"
        return hint, (Fix("Write three components", (edit,)),)
    elif len(items) == 4 and number_of(items[-1]) in (0, 1):
        edit = Edit(Span(node.span.source, items[2].span.end, end), "")
        hint = "there is no fourth component"
    else:
        return None, ()
    start = node.span.start
    text = node.span.text
    written = text[: edit.span.start - start] + edit.text + text[edit.span.end - start :]
    shown_text = f": `{written}`" if len(written) <= MAX_SHOWN else ""
    return hint + shown_text, (Fix("Write three components", (edit,)),)


_QUOTED_NUMBER = lazy_pattern(r'"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([a-zA-Z%°]*)\s*"')
# Metres in the units of length of other tools, and the shares of 1 in per cent.
_UNITS = {"m": 1.0, "mm": 0.001, "cm": 0.01, "dm": 0.1, "km": 1000.0, "in": 0.0254, "ft": 0.3048, "%": 0.01}
_DEGREES = ("deg", "degree", "degrees", "°")


def unquoted_number(node: Any) -> tuple[str | None, tuple[Fix, ...]]:
    """Return the hint and fix for a number that is written as a string, alone or with a unit."""
    match = _QUOTED_NUMBER.fullmatch(node.span.text) if node.span.expansion is None else None
    if match is None:
        return None, ()
    number, unit = match.groups()
    if not unit:
        fix = Fix(f"Change to `{number}`", (Edit(node.span, number),), safe=True)
        return f"write the number without quotes: `{number}`", (fix,)
    if unit.lower() in _DEGREES:
        written = f"(deg {number})"
        fix = Fix(f"Change to `{written}`", (Edit(node.span, written),))
        return f"degrees are converted by `deg`: `{written}`", (fix,)
    factor = _UNITS.get(unit.lower())
    if factor is None:
        return f"there are no units: write the number alone, `{number}`", ()
    written = f"{float(number) * factor:.12g}".replace("0.", ".", 1) if factor < 1 else f"{float(number) * factor:g}"
    if unit == "%":
        return f"write the share of 1: `{written}`", (Fix(f"Change to `{written}`", (Edit(node.span, written),)),)
    return f"there are no units: write a number alone; if a unit of the scene is a metre, it is `{written}`", ()


def advice_on_value(node: Any, wants: str) -> tuple[str | None, tuple[Fix, ...]]:
    """Return the hint and fix for an expression that has a value of the wrong type because of how it is written.

    It is a number in quotes, a quoted list of names, or an ``if`` that has no value in one case. ``wants`` is the name
    of the type that is expected.
    """
    if wants in _NUMBERS and type(node) is ast.Constant and type(node.value) is str:
        return unquoted_number(node)
    if type(node) is ast.Constant and type(node.value) is Pair and node.span.expansion is None:
        return _evaluated_list(node, wants)
    return None, ()


_NUMBERS = ("Number", "Float", "Integer", "Numeric", "Extent")
_OF_NUMBERS = frozenset((*_NUMBERS, "Vector", "Point", "Triple", "Color", "Array", "ArrayLike", "ArrayItem"))


def _evaluated_list(node: Any, wants: str) -> tuple[str | None, tuple[Fix, ...]]:
    """Return the hint and fix for ``'(x 0 0)``, a quoted list whose names were meant as variables."""
    text = node.span.text
    inside = text[2:-1].strip() if text.startswith("'(") else ""
    names = _NAMES.findall(inside)
    if not names or not any(type(item) is Symbol or type(item) is Pair for item in items_of(node.value)):
        return None, ()
    written = f"[{inside}]" if wants in _OF_NUMBERS else f"(list {inside})"
    hint = f"nothing in a quoted list is evaluated, so that `{names[0]}` is a symbol: write `{written}`"
    return hint, (Fix(f"Change to `{written[:MAX_SHOWN]}`", (Edit(node.span, written),)),)


_NAMES = lazy_pattern(r"(?<![^\s()\[])[A-Za-z_][^\s()\[\]]*")


def items_of(value: Any) -> Iterator[Any]:
    """Iterate over the items of a quoted list."""
    while type(value) is Pair:
        yield value.car
        value = value.cdr


# Functions for solids that have a counterpart for profiles.
_OF_PROFILES = frozenset(("union", "difference", "intersection", "hull", "minkowski"))


def is_profile(node: Any) -> bool:
    """Return whether an expression is a call that makes a flat profile, such as ``(circle 1)``."""
    target = getattr(node.function, "target", None) if type(node) is ast.Application else None
    return isinstance(target, Builtin) and target.topic == "profiles"


def profile_hint(function: str, node: Any) -> str:
    """Return the hint for a profile in place of a solid, an argument of ``function``."""
    text = node.span.text if len(node.span.text) <= MAX_SHOWN else "profile"
    if function in _OF_PROFILES:
        instead = f"(extrude (profile-{function} ...) height)"
        return f"`{text}` is a flat profile; profiles are combined and made solid by `{instead}`"
    return f"`{text}` is a flat profile, of which `(extrude {text} 1)` makes a solid"


# Values that change nothing, by the type that is expected: for the branch that an `if` lacks.
_NEUTRAL = {
    **dict.fromkeys(("Number", "Float", "Integer", "Numeric", "Extent"), "0"),
    **dict.fromkeys(("Vector", "Point", "Triple"), "[0 0 0]"),
    "Matrix": "(translate [0 0 0])", "Parts": "(union)", "Entity": "(union)", "String": '""', "Boolean": "#f",
    "List": "'()", "Sequence": "'()",
}  # fmt: skip


def missing_branch(node: Any, wants: str) -> tuple[Any, str, str, tuple[Fix, ...]] | None:
    """Return the ``if`` without a second branch that an expression is, with a message, a hint and a fix; or None."""
    if type(node) is not ast.If or node.otherwise is not None or node.span.expansion is not None:
        return None
    head = _head_of_conditional(node.span.text)
    if head is None:
        return None
    test, when = node.test.span.text, " in one case"
    if head == "if" and len(test) <= MAX_SHOWN and node.test.span.expansion is None:
        when = f" when `{test}` is false"
    message = f"this `{head}` has no second branch, so it is `none`{when}"
    neutral = _NEUTRAL.get(wants)
    if neutral is None or head != "if":
        return node, message, "use `if` with both values: `(if test value other)`", ()
    written = f"{node.span.text[:-1]} {neutral})"
    end = node.span.end - 1
    fix = Fix("Add a branch", (Edit(Span(node.span.source, end, end), f" {neutral}"),))
    return node, message, f"write `{written}`" if len(written) <= MAX_SHOWN else f"add `{neutral}` at its end", (fix,)


def _head_of_conditional(text: str) -> str | None:
    """Return the head of a conditional with one branch."""
    match = _ONE_BRANCH.match(text)
    return match[1] if match is not None else None


_ONE_BRANCH = lazy_pattern(r"\((if|when|unless)\b")


# --- functions -----------------------------------------------------------------------------------------------------


def name_of(code: ast.Lambda) -> str:
    """Return the name of a function for error messages; the name of a word's function has quotes already."""
    if code.name in ("lambda", "do"):
        return "this function"
    return code.name if code.name.startswith('"') else f"`{code.name}`"


def arity_of(code: Any) -> tuple[int | None, float, str, str]:
    """Return the least and greatest number of positional arguments, the function's name and its usage."""
    if isinstance(code, Builtin):
        signature = code.signature
        low = len(signature.required)
        high = math.inf if signature.rest is not None else low + len(signature.optional)
        return low, high, f"`{code.name}`", code.usage
    if isinstance(code, ast.Lambda):
        kinds = [parameter.kind for parameter in code.parameters]
        low = kinds.count("required")
        high = math.inf if "rest" in kinds else low + kinds.count("optional")
        return low, high, name_of(code), code.usage
    return None, 0, "", ""


# Names in other languages of the keywords for axes and alignments.
_MEANT = {
    "left": "min", "right": "max", "bottom": "min", "top": "max", "back": "min", "front": "max", "start": "min",
    "end": "max", "centre": "center", "middle": "center", "mid": "center", "low": "min", "high": "max",
    "above": "after", "below": "before", "X": "x", "Y": "y", "Z": "z",
}  # fmt: skip


_VALUES_OF = {"Alignment": ("min", "center", "max", "before", "after"), "Axis": ("x", "y", "z")}


def meant_keyword(type_: Type, value: Any) -> tuple[str | None, tuple[Fix, ...]]:
    """Return the hint and fix for an axis or alignment that is written as a string or with another name.

    Parameters
    ----------
    type_
        Type of the parameter.
    value
        Expression of the argument.

    Returns
    -------
    tuple
        ``(None, ())`` for other types, and for values that are not similar to a keyword.
    """
    if (
        type(value) is not ast.Constant
        or type(value.value) not in (str, Keyword, Symbol)
        or value.span.expansion is not None
    ):
        return None, ()
    text = str(value.value)
    for name in (text, _MEANT.get(text, "")):
        keyword = ast.Constant(Keyword(name), value.span)
        if name and type_.name in ("Axis", "Alignment") and literal_fits(type_, keyword):
            return f"write `:{name}`", (
                Fix(f"Change to `:{name}`", (Edit(value.span, f":{name}"),), safe=name == text),
            )
    near = near_names(text, _VALUES_OF.get(type_.name, ()))
    if near:
        return f"did you mean `:{near[0]}`?", (Fix(f"Change to `:{near[0]}`", (Edit(value.span, f":{near[0]}"),)),)
    return None, ()


def literal_fits(type_: Type, value: Any) -> bool:
    """Return whether a literal has the type of a parameter; True for types that need a run to decide."""
    if type(value) is not ast.Constant or value.value is None or type_.walk is not None:
        return True
    try:
        type_.convert(value.value)
    except Mismatch:
        return False
    return True


def turned(node: Any, angles: Any) -> tuple[str | None, tuple[Fix, ...]]:
    """Return a hint and a fix for ``(rotate [0 45 0])``: the angles about the three axes."""
    hint = "`rotate` takes an angle in radians and an axis: `(rotate (deg 90) [0 1 0])`"
    numbers = [number_of(item) for item in angles.items] if type(angles) is ast.ArrayLiteral else []
    turning = [i for i, number in enumerate(numbers) if number != 0]
    if len(numbers) != len(AXES) or len(turning) != 1 or node.span.expansion is not None:
        return hint, ()
    (index,) = turning
    text, angle = angles.items[index].span.text, numbers[index]
    is_radians = angle is not None and not float(angle).is_integer() and abs(angle) <= math.tau  # (rotate [0 0 .785])
    written = f"(rotate {text if is_radians else f'(deg {text})'} {AXES[index]})"
    return f"write `{written}`", (Fix("Write an angle and an axis", (Edit(node.span, written),), safe=True),)


AXES = ("[1 0 0]", "[0 1 0]", "[0 0 1]")

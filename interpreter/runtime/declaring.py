"""Declarations from the operands and options of ``assert-that``, which are checked here."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import SceneError, suggest
from scenelang.interpreter.runtime.types import type_name
from scenelang.interpreter.scene.declarations import (
    AXES,
    COLOR,
    COLORS,
    FLAGS,
    NUMBER,
    RELATIONS,
    THING,
    Declaration,
    Relation,
    basic_color,
)
from scenelang.interpreter.values.values import Embedding

_MOST = 1e100
_LENGTHS = ("within", "min", "max")
_DEGREES = frozenset({"angle", "facing"})  # relations whose `:within` is an angle
_ONE_AXIS = frozenset({"moves"})  # relations whose `:along` is one axis


def declared(name: str, operands: Sequence[Any], options: Mapping[str, Any], span: Span | None) -> Declaration:
    """Return a declaration from values of a program; raises SceneError for those that it does not take."""
    relation = RELATIONS.get(name)
    if relation is None:
        raise SceneError("value", f"unknown relation `{name}`; expected one of {', '.join(RELATIONS)}")
    most, least = len(relation.operands), len(relation.operands) - relation.optional
    if not least <= len(operands) <= most:
        expected = f"{most}" if least == most else f"{least} or {most}"
        raise SceneError(
            "arity", f"`{name}` expects {expected} operands, got {len(operands)}", f"write `{relation.usage}`"
        )
    things = tuple(_thing(name, value) for value, kind in zip(operands, relation.operands) if kind is THING)
    numbers = [_number(name, "a number", v) for v, kind in zip(operands, relation.operands) if kind is NUMBER]
    colors = [_color(value) for value, kind in zip(operands, relation.operands) if kind is COLOR]
    kept = {key: _option(relation, key, value) for key, value in options.items() if value is not None}
    made = Declaration(
        name,
        things,
        numbers[0] if numbers else None,
        {k: v for k, v in kept.items() if v is not False},
        span,
        colors[0] if colors else None,
    )
    _check_amount(relation, made)
    return made


def _check_amount(relation: Relation, made: Declaration) -> None:
    if relation.optional and made.number is None and not {"min", "max"} & set(made.options):
        raise SceneError("value", f"`{made.relation}` expects a number, `:min` or `:max`", f"write `{relation.usage}`")
    if made.number is not None and {"min", "max"} & set(made.options):
        raise SceneError("value", f"`{made.relation}` expects a number or a range, got both")
    least, most = made.options.get("min"), made.options.get("max")
    if least is not None and most is not None and least > most:
        raise SceneError("value", f"`{made.relation}` expects `:min` to be at most `:max`, got {least:g} and {most:g}")
    if made.relation in _DEGREES and made.options.get("within", 0.0) > 180.0:
        raise SceneError("value", f"`:within` of `{made.relation}` expects degrees from 0 to 180")
    if made.relation == "count" and made.number is not None and made.number != int(made.number):
        raise SceneError("value", f"`count` expects a whole number, got {made.number:g}")
    if made.relation == "size" and "axis" not in made.options:
        raise SceneError("value", "`size` expects `:axis`", f"write `{relation.usage}`")


def _thing(name: str, value: Any) -> str:
    if type(value) is Embedding and value.handle is not None:
        return value.handle if value.handle.startswith("<") else f"<{value.handle}>"
    if type(value) is str and value:
        return value
    raise SceneError("type", f"`{name}` expects a word or a handle, got {type_name(value)}")


def _color(value: Any) -> str:
    """Return the basic color term of an operand."""
    if isinstance(value, str):
        if value not in COLORS:
            raise SceneError("value", f'unknown color "{value}"', suggest(value, COLORS) or f"expected {_listed()}")
        return value
    try:
        r, g, b = (float(x) for x in value)
    except (TypeError, ValueError):
        raise SceneError("type", f"expected a color, got {type_name(value)}", f"expected {_listed()}") from None
    if not all(0.0 <= x <= 1.0 for x in (r, g, b)):
        raise SceneError("value", f"expected a color with components from 0 to 1, got [{r:g} {g:g} {b:g}]")
    return basic_color((r, g, b))


def _listed() -> str:
    return f"a color vector or one of {', '.join(COLORS)}"


def _number(name: str, expected: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise SceneError("type", f"`{name}` expects {expected}, got {type_name(value)}")
    if not 0.0 <= value < _MOST:
        raise SceneError("value", f"`{name}` expects {expected} from 0 to {_MOST:g}, got {min(value, _MOST):.6g}")
    return float(value)


def _option(relation: Relation, key: str, value: Any) -> Any:
    if key not in (*relation.options, "message", "negated"):
        takes = ", ".join(f"`:{each}`" for each in relation.options)
        raise SceneError("keyword", f"`{relation.name}` has no option `:{key}`; it takes {takes}")
    if key in FLAGS:
        return bool(value)
    if key in _LENGTHS:
        return _number(relation.name, f"a number for `:{key}`", value)
    if key == "share":
        share = _number(relation.name, "a number for `:share`", value)
        if not 0.0 < share <= 1.0:
            raise SceneError("value", f"`:share` expects a number above 0 and at most 1, got {share:g}")
        return share
    if key == "about":
        return _thing(relation.name, value)
    if key == "message":
        return str(value)[:1000]
    return _axes(key, value, 2 if key == "along" and relation.name not in _ONE_AXIS else 1)


def _axes(key: str, value: Any, most: int) -> str:
    is_known = type(value) is str and value and set(value) <= set(AXES) and len(set(value)) == len(value)
    if not is_known or len(value) > most:
        several = ', or two of them such as "xz"' if most > 1 else ""
        raise SceneError("value", f'`:{key}` expects "x", "y" or "z"{several}, got {value!r}'.replace("'", '"'))
    return str(value)

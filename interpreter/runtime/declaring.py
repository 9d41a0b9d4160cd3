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
    FRAME_FLAGS,
    IN_DEGREES,
    MATERIAL,
    NUMBER,
    OBJECT,
    OUTLINE,
    OUTLINES,
    PATH,
    PATHS,
    RELATIONS,
    Declaration,
    Relation,
    basic_color,
)
from scenelang.interpreter.values.values import Embedding, list_items

_MAX_NUMBER = 1e100  # its square, which the geometry computes, is a float
_MAX_MESSAGE_CHARACTERS = 1000  # of a declaration's own message, which is cut
_LENGTHS = ("within", "min", "max")
# Options that may be several axes, and how many.
_SEVERAL_AXES = {
    ("aligned", "along"): 2, ("evenly-spaced", "along"): 2, ("size", "axis"): 3, ("proportion", "axis"): 3,
    ("aspect", "axis"): 3, ("aspect", "to"): 3, ("distance", "axis"): 2,
}  # fmt: skip
# Options that may be a direction such as "+x".
_SIGNED = frozenset({("moves", "along"), ("turns", "axis"), ("rising", "along"), ("rows", "along")})
_TERMS = {OUTLINE: OUTLINES, PATH: PATHS}
_MAX_MATERIAL_CHARACTERS = 100  # of a material's name, which is cut


def declared(name: str, operands: Sequence[Any], options: Mapping[str, Any], span: Span | None) -> Declaration:
    """Return a declaration from values of a program.

    Parameters
    ----------
    name
        Relation.
    operands
        Words, handles, numbers and colors.
    options
        Options by name; None and false ones are left out.
    span
        Where the program states it.

    Raises
    ------
    SceneError
        For an unknown relation, or operands and options that it does not take.
    """
    relation = RELATIONS.get(name)
    if relation is None:
        raise SceneError("value", f"unknown relation `{name}`; expected one of {', '.join(RELATIONS)}")
    problem = relation.wrong_count(len(operands))
    if problem is not None:
        raise SceneError("arity", problem, f"write `{relation.usage}`")
    kinds = [(value, relation.kind_of(position)) for position, value in enumerate(operands)]
    subjects = tuple(_subject(name, value) for value, kind in kinds if kind is OBJECT)
    numbers = [_number(name, "a number", value) for value, kind in kinds if kind is NUMBER]
    terms = [_term(kind, value) for value, kind in kinds if kind not in (OBJECT, NUMBER)]
    checked = {key: _option(relation, key, value) for key, value in options.items() if value is not None}
    if checked.pop("never", False):
        checked["negated"] = not checked.get("negated", False)
    declaration = Declaration(
        name,
        subjects,
        numbers[0] if numbers else None,
        {k: v for k, v in checked.items() if v is not False},
        span,
        terms[0] if terms else None,
    )
    _check_amount(relation, declaration)
    return declaration


def _check_amount(relation: Relation, declaration: Declaration) -> None:
    """Raise SceneError unless a declaration has the number or range that its relation needs."""
    name, options = declaration.relation, declaration.options
    has_range = bool({"min", "max"} & set(options))
    if relation.optional and name != "encircles" and declaration.number is None and not has_range:
        raise SceneError("value", f"`{name}` expects a number, `:min` or `:max`", f"write `{relation.usage}`")
    if declaration.number is not None and has_range:
        raise SceneError("value", f"`{name}` expects a number or a range, got both")
    least, most = options.get("min"), options.get("max")
    if least is not None and most is not None and least > most:
        raise SceneError("value", f"`{name}` expects `:min` to be at most `:max`, got {least:g} and {most:g}")
    if name in IN_DEGREES and options.get("within", 0.0) > 180.0:
        raise SceneError("value", f"`:within` of `{name}` expects degrees from 0 to 180")
    if name in ("count", "rows") and declaration.number is not None and declaration.number != int(declaration.number):
        raise SceneError("value", f"`{name}` expects a whole number, got {declaration.number:g}")
    if name == "rows" and "along" not in options:
        raise SceneError("value", "`rows` expects `:along`", f"write `{relation.usage}`")
    if name == "aspect" and "to" not in options:
        raise SceneError("value", "`aspect` expects `:to`", f"write `{relation.usage}`")
    if name in ("size", "proportion", "aspect") and "axis" not in options:
        raise SceneError("value", f"`{name}` expects `:axis`", f"write `{relation.usage}`")
    if name in ("order", "rising") and ("along" in options) == ("around" in options):
        raise SceneError("value", f"`{name}` expects `:along` or `:around`", f"write `{relation.usage}`")
    if name == "evenly-spaced" and "along" in options and "around" in options:
        raise SceneError("value", "`evenly-spaced` expects `:along` or `:around`, got both")
    if len({*FRAME_FLAGS} & {*options}) > 1:
        raise SceneError("value", f"`{name}` expects one of `:first`, `:last`, `:sometime` and `:never`")


def _subject(name: str, value: Any) -> str:
    """Return the word or handle that an operand names."""
    if type(value) is Embedding and value.handle is not None:
        return value.handle if value.handle.startswith("<") else f"<{value.handle}>"
    if type(value) is str and value:
        return value
    hint = 'relations name words: bind the object to a word, as in `(bind "lid" ...)`, and write `"lid"`'
    raise SceneError("type", f"`{name}` expects a word or a handle, got {type_name(value)}", hint)


def _term(kind: str, value: Any) -> str:
    """Return a checked operand that is a text."""
    if kind is COLOR:
        return _color(value)
    if type(value) is not str or not value:
        raise SceneError("type", f"expected {_article(kind)}, got {type_name(value)}")
    known = _TERMS.get(kind)
    if known is not None and value not in known:
        hint = suggest(value, known) or f"expected {_quoted(known)}"
        raise SceneError("value", f'unknown {kind} "{value}"', hint)
    return value[:_MAX_MATERIAL_CHARACTERS] if kind is MATERIAL else value


def _article(kind: str) -> str:
    """Return the kind of an operand with its article."""
    return f"an {kind}" if kind[0] in "aeiou" else f"a {kind}"


def _quoted(names: Sequence[str]) -> str:
    """Return names as quoted alternatives."""
    *others, last = (f'"{name}"' for name in names)
    return f"{', '.join(others)} or {last}"


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
    """Return the values that are colors, for error messages."""
    return f"a color vector or one of {', '.join(COLORS)}"


def _number(name: str, expected: str, value: Any) -> float:
    """Return a non-negative number; ``expected`` describes it in messages."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise SceneError("type", f"`{name}` expects {expected}, got {type_name(value)}")
    if not 0.0 <= value < _MAX_NUMBER:
        raise SceneError(
            "value", f"`{name}` expects {expected} from 0 to {_MAX_NUMBER:g}, got {min(value, _MAX_NUMBER):.6g}"
        )
    return float(value)


def _option(relation: Relation, key: str, value: Any) -> Any:
    """Return the checked value of an option of a relation."""
    if key not in (*relation.keywords, "message", "negated"):
        takes = ", ".join(f"`:{option}`" for option in relation.keywords)
        raise SceneError("keyword", f"`{relation.name}` has no option `:{key}`; it takes {takes}")
    if key in FLAGS:
        return bool(value)
    if key in _LENGTHS:
        return _number(relation.name, f"a number for `:{key}`", value)
    if key == "each":
        return _counts(relation.name, value)
    if key == "share":
        share = _number(relation.name, "a number for `:share`", value)
        if not 0.0 < share <= 1.0:
            raise SceneError("value", f"`:share` expects a number above 0 and at most 1, got {share:g}")
        return share
    if key in ("about", "around"):
        return _subject(relation.name, value)
    if key == "message":
        return str(value)[:_MAX_MESSAGE_CHARACTERS]
    if (relation.name, key) in _SIGNED and type(value) is str and value[:1] in ("+", "-"):
        return value[0] + _axes(key, value[1:], 1)
    return _axes(key, value, _SEVERAL_AXES.get((relation.name, key), 1))


def _counts(name: str, value: Any) -> float | tuple[float, ...]:
    """Return a whole number, or a list of them."""
    is_single = type(value) in (int, float)
    counts = [_number(name, "numbers for `:each`", count) for count in ([value] if is_single else list_items(value))]
    if not counts or any(count != int(count) for count in counts):
        raise SceneError("value", "`:each` expects whole numbers")
    return counts[0] if is_single else tuple(counts)


def _axes(key: str, value: Any, most: int) -> str:
    """Return an axis, or up to ``most`` different ones, as their letters."""
    is_known = type(value) is str and value and set(value) <= set(AXES) and len(set(value)) == len(value)
    if not is_known or len(value) > most:
        several = ', or two of them such as "xz"' if most > 1 else ""
        raise SceneError("value", f'`:{key}` expects "x", "y" or "z"{several}, got {value!r}'.replace("'", '"'))
    return str(value)

"""``format``: Python's templates and format mini-language, without access to attributes or items."""

from __future__ import annotations

import re
from collections.abc import Iterator
from string import Formatter
from typing import Any

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.library import Registry
from scenelang.interpreter.runtime import Runtime
from scenelang.interpreter.show import show
from scenelang.stdlib.arithmetic import charge_digits

registry = Registry("strings")

_SPEC = re.compile(r"(?:.?[<>=^])?[-+ ]?z?#?0?(?P<width>\d*)[_,]?(?:\.(?P<precision>\d+))?(?P<kind>.?)\Z", re.S)


class _Fields:
    """The values of a template: by position, or one after the other."""

    def __init__(self, values: tuple[Any, ...]) -> None:
        self.values = values
        self.next: int | None = None

    def take(self, name: str) -> Any:
        if name == "":
            if self.next is None:
                self.next = 0
            index, self.next = self.next, self.next + 1
        elif name.isascii() and name.isdigit() and len(name) < 10:
            index = int(name)
        else:
            message = f"a field of `format` is {{}} or a position such as {{0}}, got {{{name[:40]}}}"
            raise SceneError("format", message, hint="items and attributes are looked up outside: `(ref x i)`")
        if index >= len(self.values):
            raise SceneError("format", f"`format` has no value for field {index}: it got {len(self.values)}")
        return self.values[index]


def _parse(template: str) -> Iterator[tuple[str, str | None, str | None, str | None]]:
    try:
        yield from Formatter().parse(template)
    except ValueError as error:
        hint = "a brace itself is written {{ or }}"
        raise SceneError("format", f"`format` cannot read {show(template, 60)}: {error}", hint=hint) from None


def format_template(rt: Runtime, template: str, values: tuple[Any, ...]) -> str:
    """The template with its fields filled."""
    fields = _Fields(values)
    out: list[str] = []
    size = 0
    for literal, name, spec, conversion in _parse(template):
        pieces = [literal]
        if name is not None:
            value = fields.take(name)
            pieces.append(format_value(rt, _converted(rt, value, conversion), _filled_spec(rt, spec or "", fields)))
        out += pieces
        length = sum(map(len, pieces))
        size += length
        rt.charge(1 + (length >> 4))
        rt.meter.check_growth(size, "a string")
    return "".join(out)


def _converted(rt: Runtime, value: Any, conversion: str | None) -> Any:
    if conversion is None:
        return value
    if conversion == "s":
        return rt.display(value)
    if conversion in ("r", "a"):
        return rt.show(value)
    raise SceneError("format", f"`format` knows the conversions !s and !r, got !{conversion}")


def _filled_spec(rt: Runtime, spec: str, fields: _Fields) -> str:
    """The format of a field, whose own fields (``{:{}}``) are filled in."""
    if "{" not in spec:
        return spec
    out = []
    for literal, name, inner, conversion in _parse(spec):
        out.append(literal)
        if name is not None:
            if inner or conversion:
                raise SceneError("format", f"the format {show(spec, 40)} is nested too deep")
            value = fields.take(name)
            out.append(value if type(value) is str else rt.show(value, 100))
    return "".join(out)


def format_value(rt: Runtime, value: Any, spec: str) -> str:
    """One value by a format such as ``.2f`` or ``>8``."""
    match = _SPEC.match(spec)
    if match is None or match["kind"] == "n":
        raise _bad_format(value, spec, "it is malformed")
    for digits in (match["width"], match["precision"]):
        if digits:
            rt.meter.check_size(int(digits[:18]), "a string")
    plain = value if type(value) in (int, float, str) else rt.display(value)
    charge_digits(rt, plain)
    try:
        return format(plain, spec)
    except (ValueError, OverflowError) as error:
        raise _bad_format(value, spec, str(error)) from None


def _bad_format(value: Any, spec: str, why: str) -> SceneError:
    return SceneError("format", f"`format` cannot write {show(value, 40)} as {show(spec, 40)}: {why}")


@registry.define(
    "format",
    "template::String values::Any ...",
    "String",
    "The template with its fields {} filled by the values, one after the other or by position {0}. After a colon "
    "stands a format as in Python: {:.2f}, {:>8}, {:03d}.",
    ('(format "{:.2f} m, {:03d}, {}" 1.5 7 "oak")', '"1.50 m, 007, oak"'),
)
def format_(rt: Runtime, template: str, *values: Any) -> str:
    return format_template(rt, template, values)

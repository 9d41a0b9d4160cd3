"""Params of a program for people to move: their kinds and values, literals for them, writing one back to its file."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from scenelang.backends.files import read_regular, written_whole
from scenelang.backends.studio import from_srgb, to_srgb
from scenelang.grammar.datum import ArrayDatum, Atom, Datum, Handle, Keyword, ListDatum, Symbol
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.printer import atom_text
from scenelang.grammar.reader import read
from scenelang.grammar.source import Source, Span
from scenelang.interpreter.library import STD
from scenelang.interpreter.params import Param
from scenelang.stdlib.colors import color_of

_HEX = re.compile(r"#[0-9a-fA-F]{6}")
_BOM = b"\xef\xbb\xbf"
_DIGITS = 4  # of a colour's linear channels: finer than 8-bit sRGB


@dataclass(frozen=True, slots=True, eq=False)
class Control:
    """A param as a control. ``kind``: integer, number, boolean, text, color, literal (as it is written) or computed.

    ``value`` is the file's own: a number, a truth value, a text, or ``#rrggbb``. ``place`` is where it is written, None
    where it cannot be written back; then ``reason`` says why.
    """

    param: Param
    kind: str
    value: Any
    place: Span | None
    reason: str | None

    def literal(self, value: Any) -> str:
        """``value``, as the page sends it, as a literal of the language; raises SceneError("param")."""
        text = _literal(self.kind, value)
        if text is not None and self.kind == "number" and type(self.value) is int and value == int(value):
            return str(int(value))
        if text is not None and self.kind == "color" and self.param.default.startswith('"'):
            return atom_text(value)
        if text is None:
            raise SceneError("param", f"`{self.param.name}` cannot be {str(value)[:60]!r}")
        return text

    def written(self, value: Any) -> str:
        """The literal for the file, in the manner of what stands there: `(color "#c08040")` stays one."""
        text = self.literal(value)
        return f'(color "{value}")' if self.kind == "color" and self.param.default.startswith("(") else text


def controls_of(params: tuple[Param, ...]) -> tuple[Control, ...]:
    """The controls of a program's params, in reading order."""
    return tuple(_control(param) for param in params)


def _control(param: Param) -> Control:
    datum = _value_datum(param.span)
    kind, value = _kind(datum) if datum is not None else ("computed", param.default)
    if kind == "integer" and not all(
        limit is None or float(limit).is_integer() for limit in (param.minimum, param.maximum)
    ):
        kind = "number"
    name = param.span.source.name
    reason = None
    if datum is None or param.span.expansion is not None:
        reason = "A macro made it, so it can be tried out, not saved."
    elif kind == "computed":
        reason = "Its value is computed, so it is changed in the program."
    elif name.startswith(("<", STD)) or not Path(name).is_file():
        reason = "It does not come from a file, so it can be tried out, not saved."
    return Control(param, kind, value, datum.span if datum is not None and reason is None else None, reason)


def _value_datum(span: Span) -> Datum | None:
    """The datum of the value in `(param name value ...)`, read anew where ``span`` lies."""
    forms = read(Source(span.source.name, span.text)).forms
    if len(forms) != 1 or not isinstance(forms[0], ListDatum) or len(forms[0].items) < 3:
        return None
    datum: Datum = forms[0].items[2]
    start, end = datum.span.start + span.start, datum.span.end + span.start
    place = Span(span.source, start, end)
    if isinstance(datum, Atom):
        return Atom(datum.value, place)
    if isinstance(datum, ArrayDatum):
        return ArrayDatum(datum.items, place)
    return ListDatum(datum.items, datum.tail, place)


def _kind(datum: Datum) -> tuple[str, Any]:
    text = " ".join(datum.span.text.split())
    if isinstance(datum, Atom):
        return _atom_kind(datum.value, text)
    if isinstance(datum, ArrayDatum):
        channels = _channels(datum)
        return ("color", _hex(channels)) if channels is not None else ("literal", text)
    named = _named_color(datum)
    return ("color", named) if named is not None else ("computed", text)


def _atom_kind(value: Any, text: str) -> tuple[str, Any]:
    if isinstance(value, bool):
        return "boolean", value
    if type(value) is int:
        return ("integer", value) if abs(value) < 2**53 else ("literal", text)
    if type(value) is float:
        return ("number", value) if math.isfinite(value) else ("literal", text)
    if type(value) is str:
        return ("color", value.lower()) if _HEX.fullmatch(value) else ("text", value)
    return ("computed", text) if isinstance(value, (Symbol, Keyword, Handle)) else ("literal", text)


def _channels(datum: ArrayDatum) -> tuple[float, ...] | None:
    """The numbers of an array that can be a colour: three from 0 to 1."""
    values = [item.value for item in datum.items if isinstance(item, Atom) and type(item.value) in (int, float)]
    if len(values) != 3 or len(datum.items) != 3 or not all(0.0 <= value <= 1.0 for value in values):
        return None
    return tuple(float(value) for value in values)


def _named_color(datum: ListDatum) -> str | None:
    """The hexadecimal form of `(color "...")`, None where it is something else."""
    items = datum.items
    if len(items) != 2 or datum.tail is not None or not all(isinstance(item, Atom) for item in items):
        return None
    head, name = items[0].value, items[1].value
    if head != "color" or not isinstance(head, Symbol) or type(name) is not str:
        return None
    try:
        linear = color_of(name)
    except SceneError:
        return None
    return _hex(tuple(linear))


def _hex(linear: tuple[float, ...]) -> str:
    channels = np.rint(to_srgb(np.array(linear)) * 255.0).astype(int).tolist()
    return "#" + "".join(f"{channel:02x}" for channel in channels)


def _literal(kind: str, value: Any) -> str | None:
    if kind == "boolean":
        return ("#t" if value else "#f") if isinstance(value, bool) else None
    if kind in ("integer", "number"):
        return _number_literal(kind, value)
    if not isinstance(value, str) or len(value) > 10_000:
        return None
    if kind == "text":
        return atom_text(value)
    if kind == "color":
        return _color_literal(value) if _HEX.fullmatch(value) else None
    if kind == "literal":
        forms = read(Source("<param>", value))
        fits = len(forms.forms) == 1 and not forms.diagnostics and not isinstance(forms.forms[0], ListDatum)
        return value.strip() if fits and ";" not in value and "|" not in value else None
    return None


def _number_literal(kind: str, value: Any) -> str | None:
    if type(value) not in (int, float) or not math.isfinite(value):
        return None
    if kind == "integer":
        return str(int(value)) if value == int(value) else None
    return atom_text(float(value))


def _color_literal(value: str) -> str:
    encoded = np.array([int(value[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0
    return "[" + " ".join(f"{round(channel, _DIGITS):g}" for channel in from_srgb(encoded).tolist()) + "]"


def write_back(controls: Mapping[str, Control], name: str, value: Any) -> None:
    """Put ``value`` in the place of the param's own in its file; all else in the file stays as it is.

    Raises SceneError: "param" for a value or a param that does not fit, "file" when the file was changed since it was
    read, or cannot be written.
    """
    control = controls.get(name)
    if control is None:
        raise SceneError("param", f"the program has no `param` named `{name}`")
    if control.place is None:
        raise SceneError("param", f"`{name}` cannot be saved", control.reason)
    source, text = control.place.source, control.written(value)
    path = Path(source.name).resolve()  # a link stays one
    before = _bytes(path)
    bom = _BOM if before.startswith(_BOM) else b""
    if before != bom + source.text.encode():
        raise SceneError("file", f"{source.name} has changed since it was read, so `{name}` was not saved")
    after = source.text[: control.place.start] + text + source.text[control.place.end :]
    mode = path.stat().st_mode & 0o7777
    with written_whole(path) as temporary:
        temporary.write_bytes(bom + after.encode())
        if _bytes(path) != before:
            raise SceneError("file", f"{source.name} changed meanwhile, so `{name}` was not saved")
    os.chmod(path, mode)


def _bytes(path: Path) -> bytes:
    try:
        return read_regular(path)
    except OSError as error:
        raise SceneError("file", f"cannot read {path.name}: {error.strerror or error}") from None

"""Strings. A character is a String of length 1."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.lazy_patterns import lazy_pattern
from scenelang.interpreter.runtime.show import show
from scenelang.interpreter.runtime.types import Registry
from scenelang.interpreter.values.values import Symbol, make_list
from scenelang.stdlib.numbers import charge_digits
from scenelang.stdlib.operands import bad_index, items, wrong_type

if TYPE_CHECKING:
    from scenelang.interpreter.runtime.runtime import Runtime

registry = Registry("strings")

_MAX_CUTSET = 16  # characters up to which `str.strip`, which scans them at each step, is faster than a set
_MAX_UNCHECKED = 1_000  # characters of a text that needs no check of the memory
_MAX_JOINED = 4  # texts that are joined before their size is checked, each within the limit


def _check_text(rt: Runtime, size: int) -> None:
    """Check that a text may have ``size`` characters, and charge for it."""
    rt.meter.check_size(size, "a string")


def _texts(name: str, values: Any) -> list[str]:
    """Return values that must be strings as a list."""
    for value in values:
        if type(value) is not str:
            hint = "to convert a value, write `(string value)`"
            raise wrong_type(name, "strings", value, hint)
    return list(values)


@registry.define("string", "values::Any ...", "String", "Concatenate the texts of all values, as `print` writes them.",
                 ('(string "leg" 2 \'(a "b"))', '"leg2(a \\"b\\")"'))  # fmt: skip
def string(rt: Runtime, *values: Any) -> str:
    texts = [rt.display(value) for value in values]
    size = sum(map(len, texts))
    if size > _MAX_UNCHECKED or size > rt.limits.size:
        _check_text(rt, size)
    else:
        rt.charge(size >> 3)
    return "".join(texts)


@registry.define("string-append", "texts::String ...", "String", "Concatenate strings.",
                 ('(string-append "chair" "/" "leg")', '"chair/leg"'))  # fmt: skip
def string_append(rt: Runtime, *texts: str) -> str:
    if len(texts) <= _MAX_JOINED:
        text = "".join(texts)
        size = len(text)
        if size <= _MAX_UNCHECKED and size <= rt.limits.size:
            rt.charge(size >> 3)
            return text
    size = sum(map(len, texts))
    if size > _MAX_UNCHECKED or size > rt.limits.size:
        _check_text(rt, size)
    else:
        rt.charge(size >> 3)
    return "".join(texts)


@registry.define("string-join", "texts::Sequence [separator::String]", "String",
                 "Concatenate the strings of a list with a separator (default: a space) between them.",
                 ("(string-join '(\"a\" \"b\" \"c\") \", \")", '"a, b, c"'))  # fmt: skip
def string_join(rt: Runtime, texts: Any, separator: str = " ") -> str:
    members = _texts("string-join", items(rt, texts, "string-join"))
    _check_text(rt, sum(map(len, members)) + len(separator) * len(members))
    return separator.join(members)


@registry.define("list->string", "texts::Sequence", "String", "Concatenate the characters of a list.",
                 ('(list->string (reverse (string->list "abc")))', '"cba"'))  # fmt: skip
def list_to_string(rt: Runtime, texts: Any) -> str:
    joined: str = string_join(rt, texts, "")
    return joined


@registry.define("string-split", "text::String [separator::String]", "List",
                 "Split a text at a separator; without one, at white space.",
                 ('(list (string-split "a,b,,c" ",") (string-split " two  words "))',
                  '(("a" "b" "" "c") ("two" "words"))'))  # fmt: skip
def string_split(rt: Runtime, text: str, separator: str | None = None) -> Any:
    if separator == "":
        hint = "to get the characters, write `(string->list text)`"
        raise SceneError("value", "`string-split` expects a separator that is not empty", hint=hint)
    rt.charge(len(text) >> 2)
    return make_list(text.split(separator))


@registry.define(
    "string-upcase", "text::String", "String", "Convert a text to upper case.", ('(string-upcase "Oak")', '"OAK"')
)
def string_upcase(rt: Runtime, text: str) -> str:
    rt.charge(len(text) >> 4)
    return text.upper()


@registry.define("string-downcase", "text::String", "String", "Convert a text to lower case.",
                 ('(string-downcase "Oak")', '"oak"'))  # fmt: skip
def string_downcase(rt: Runtime, text: str) -> str:
    rt.charge(len(text) >> 4)
    return text.lower()


@registry.define("string-trim", "text::String [characters::String]", "String",
                 "Remove white space, or the given characters, at both ends of a text.",
                 ('(list (string-trim "  oak ") (string-trim "--oak-" "-"))', '("oak" "oak")'))  # fmt: skip
def string_trim(rt: Runtime, text: str, characters: str | None = None) -> str:
    return _trimmed(rt, text, characters, left=True, right=True)


@registry.define("string-trim-left", "text::String [characters::String]", "String",
                 "Remove white space, or the given characters, at the start of a text.",
                 ('(string-trim-left "#ff8000" "#")', '"ff8000"'))  # fmt: skip
def string_trim_left(rt: Runtime, text: str, characters: str | None = None) -> str:
    return _trimmed(rt, text, characters, left=True)


@registry.define("string-trim-right", "text::String [characters::String]", "String",
                 "Remove white space, or the given characters, at the end of a text.",
                 ('(string-trim-right "oak--" "-")', '"oak"'))  # fmt: skip
def string_trim_right(rt: Runtime, text: str, characters: str | None = None) -> str:
    return _trimmed(rt, text, characters, right=True)


def _trimmed(rt: Runtime, text: str, characters: str | None, *, left: bool = False, right: bool = False) -> str:
    """Return ``text`` without ``characters`` at its ends, in linear time."""
    if characters is None or len(characters) <= _MAX_CUTSET:
        rt.charge(len(text) >> 5)
        return text.strip(characters) if left and right else (text.lstrip if left else text.rstrip)(characters)
    rt.charge((len(text) + len(characters)) >> 4)
    cut = frozenset(characters)
    start, end = 0, len(text)
    while left and start < end and text[start] in cut:
        start += 1
    while right and end > start and text[end - 1] in cut:
        end -= 1
    return text[start:end]


@registry.define("string-contains?", "text::String part::String", "Boolean", "Return whether `text` contains `part`.",
                 ('(string-contains? "chair leg" "leg")', "#t"))  # fmt: skip
def string_contains(rt: Runtime, text: str, part: str) -> bool:
    rt.charge(len(text) >> 4)
    return part in text


@registry.define("string-prefix?", "text::String prefix::String", "Boolean",
                 "Return whether a text starts with `prefix`.",
                 ('(string-prefix? "chair leg" "chair")', "#t"))  # fmt: skip
def string_prefix(rt: Runtime, text: str, prefix: str) -> bool:
    rt.charge(len(prefix) >> 10)
    return text.startswith(prefix)


@registry.define("string-suffix?", "text::String suffix::String", "Boolean",
                 "Return whether a text ends with `suffix`.",
                 ('(string-suffix? "chair leg" "leg")', "#t"))  # fmt: skip
def string_suffix(rt: Runtime, text: str, suffix: str) -> bool:
    rt.charge(len(suffix) >> 10)
    return text.endswith(suffix)


@registry.define("string-index", "text::String part::String [start::Integer]", "Any",
                 "Return the index of the first `part` in a text from `start` on, or #f.",
                 ('(list (string-index "chair leg" "leg") (string-index "chair" "x"))', "(6 #f)"))  # fmt: skip
def string_index(rt: Runtime, text: str, part: str, start: int = 0) -> Any:
    if not 0 <= start <= len(text):
        raise bad_index(start, len(text), "string")
    rt.charge(len(text) >> 4)
    position = text.find(part, start)
    return False if position < 0 else position


@registry.define("string-replace", "text::String old::String new::String [count::Integer]", "String",
                 "Replace every `old`, or the first `count` of them, by `new`.",
                 ('(string-replace "oak leg" "oak" "ash")', '"ash leg"'))  # fmt: skip
def string_replace(rt: Runtime, text: str, old: str, new: str, count: int = -1) -> str:
    rt.charge(len(text) >> 4)
    replaced = text.count(old)
    if count >= 0:
        replaced = min(replaced, count)
    _check_text(rt, len(text) + replaced * max(0, len(new) - len(old)))
    return text.replace(old, new, replaced)


def _padding(rt: Runtime, text: str, width: int, fill: str) -> str:
    """Return the characters that pad a text to a width."""
    if len(fill) != 1:
        raise SceneError("value", f"expected one character to pad with, got {show(fill, 30)}")
    _check_text(rt, max(width, len(text)))
    return fill * (width - len(text))


@registry.define("string-pad", "text::String width::Integer [fill::String]", "String",
                 "Pad a text at the start to `width` characters, with spaces by default.",
                 ('(string-pad "7" 3 "0")', '"007"'))  # fmt: skip
def string_pad(rt: Runtime, text: str, width: int, fill: str = " ") -> str:
    return _padding(rt, text, width, fill) + text


@registry.define("string-pad-right", "text::String width::Integer [fill::String]", "String",
                 "Pad a text at the end to `width` characters, with spaces by default.",
                 ('(string-pad-right "oak" 5 ".")', '"oak.."'))  # fmt: skip
def string_pad_right(rt: Runtime, text: str, width: int, fill: str = " ") -> str:
    return text + _padding(rt, text, width, fill)


@registry.define(
    "ord", "character::String", "Integer", "Return the Unicode code point of a character.", ('(ord "A")', "65")
)
def ord_(rt: Runtime, character: str) -> int:
    if len(character) != 1:
        raise SceneError("value", f"`ord` expects one character, got {show(character, 30)}")
    return ord(character)


@registry.define(
    "chr", "number::Integer", "String", "Return the character with a Unicode code point.", ("(chr 65)", '"A"')
)
def chr_(rt: Runtime, number: int) -> str:
    if not 0 <= number <= 0x10FFFF or 0xD800 <= number <= 0xDFFF:
        raise SceneError("value", f"{show(number, 30)} is not the code point of a character")
    return chr(number)


@registry.define(
    "symbol->string", "symbol::Symbol", "String", "Return the name of a symbol.", ("(symbol->string 'oak)", '"oak"')
)
def symbol_to_string(rt: Runtime, symbol: Any) -> str:
    rt.charge(len(symbol) >> 8)
    return str(symbol)


@registry.define(
    "string->symbol", "text::String", "Symbol", "Return the symbol with a name.", ('(string->symbol "oak")', "oak")
)
def string_to_symbol(rt: Runtime, text: str) -> Any:
    rt.charge(len(text) >> 8)
    return Symbol(text)


# --- order -----------------------------------------------------------------------------------------------------


def _define_comparison(sign: str, holds: Callable[[str, str], bool], doc: str, example: tuple[str, str]) -> None:
    """Register a comparison of neighboring strings."""

    @registry.define(f"string{sign}?", "text::String more::String ...", "Boolean", doc, example)
    def entry(rt: Runtime, *texts: str) -> bool:
        """Return whether all neighbors compare."""
        rt.charge(len(texts[0]) * len(texts) >> 10)
        return all(holds(a, b) for a, b in pairwise(texts))


_define_comparison("=", operator.eq, "Return whether all strings are equal.", ('(string=? "a" "a")', "#t"))
_define_comparison(
    "<", operator.lt, "Return whether every string is before the next.", ('(string<? "a" "b" "c")', "#t")
)
_define_comparison(">", operator.gt, "Return whether every string is after the next.", ('(string>? "a" "b")', "#f"))
_define_comparison(
    "<=",
    operator.le,
    "Return whether every string is before the next or equal to it.",
    ('(string<=? "a" "a")', "#t"),
)
_define_comparison(
    ">=",
    operator.ge,
    "Return whether every string is after the next or equal to it.",
    ('(string>=? "a" "b")', "#f"),
)


@registry.define(
    "string-ci=?",
    "text::String more::String ...",
    "Boolean",
    "Return whether all strings are equal, ignoring case.",
    ('(string-ci=? "Oak" "oak")', "#t"),
)
def string_ci_equal(rt: Runtime, *texts: str) -> bool:
    rt.charge(sum(map(len, texts)) >> 6)
    return all(a.casefold() == b.casefold() for a, b in pairwise(texts))


# --- format ----------------------------------------------------------------------------------------------------

# Python's format strings (library reference, "Format String Syntax"), without attribute or item access in fields.


_SPEC = lazy_pattern(r"(?:.?[<>=^])?[-+ ]?z?#?0?(?P<width>\d*)[_,]?(?:\.(?P<precision>\d+))?(?P<kind>.?)\Z", re.S)


class _Fields:
    """Arguments of a template, by position or consumed in order."""

    def __init__(self, values: tuple[Any, ...]) -> None:
        self.values = values
        self.next: int | None = None

    def take(self, name: str) -> Any:
        """Return the argument of a field; an empty name means the next one."""
        if name == "":
            if self.next is None:
                self.next = 0
            index, self.next = self.next, self.next + 1
        elif name.isascii() and name.isdigit() and len(name) < 10:
            index = int(name)
        else:
            message = f"a field of `format` must be {{}} or a position such as {{0}}, got {{{name[:40]}}}"
            raise SceneError("format", message, hint="to select an item, write `(ref x i)` as the argument")
        if index >= len(self.values):
            count = f"{len(self.values)} value{'' if len(self.values) == 1 else 's'}"
            raise SceneError("format", f"`format` has no value for field {index}: got {count}")
        return self.values[index]


def _parse(template: str) -> Iterator[tuple[str, str | None, str | None, str | None]]:
    """Iterate over the fields of a template: literal text before it, name, specification and conversion."""
    try:
        from string import Formatter  # compiles patterns of its own

        yield from Formatter().parse(template)
    except ValueError as error:
        hint = "write {{ or }} for a literal brace"
        raise SceneError("format", f"invalid template {show(template, 60)}: {error}", hint=hint) from None


def format_template(rt: Runtime, template: str, values: tuple[Any, ...]) -> str:
    """Return the template with its fields filled."""
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
    """Apply the conversion ``!s`` or ``!r`` of a field."""
    if conversion is None:
        return value
    if conversion == "s":
        return rt.display(value)
    if conversion in ("r", "a"):
        return rt.show(value)
    raise SceneError("format", f"unknown conversion !{conversion} in `format`, expected !s or !r")


def _filled_spec(rt: Runtime, spec: str, fields: _Fields) -> str:
    """Return the specification of a field with its own nested fields (``{:{}}``) filled."""
    if "{" not in spec:
        return spec
    out = []
    for literal, name, inner, conversion in _parse(spec):
        out.append(literal)
        if name is not None:
            if inner or conversion:
                raise SceneError("format", f"the format {show(spec, 40)} is nested too deeply")
            value = fields.take(name)
            out.append(value if type(value) is str else rt.show(value, 100))
    return "".join(out)


def format_value(rt: Runtime, value: Any, spec: str) -> str:
    """Return one value formatted by a specification such as ``.2f`` or ``>8``."""
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


def _bad_format(value: Any, spec: str, reason: str) -> SceneError:
    """Return the error for a value that a specification cannot format."""
    return SceneError("format", f"`format` cannot format {show(value, 40)} as {show(spec, 40)}: {reason}")


@registry.define(
    "format",
    "template::String values::Any ...",
    "String",
    "Fill the fields {} of a template with the values in order, or by position {0}. A colon is followed by a format "
    "specification as in Python: {:.2f}, {:>8}, {:03d}.",
    ('(format "{:.2f} m, {:03d}, {}" 1.5 7 "oak")', '"1.50 m, 007, oak"'),
)
def format_(rt: Runtime, template: str, *values: Any) -> str:
    return format_template(rt, template, values)

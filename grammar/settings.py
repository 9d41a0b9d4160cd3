"""Declarative settings: dataclass fields that become command-line options.

Settings classes declare each option once, with ``setting`` as the default of a field; the command line generates its
options from these declarations. The parsing functions convert text to a value and raise ``ValueError`` with a message
for users.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import wraps
from typing import Any, TypeVar, cast

from scenelang.grammar.datum import dataclass, field, fields, replace
from scenelang.grammar.diagnostics import SceneError, missing_part

_SUFFIXES = {"k": 10**3, "m": 10**6, "g": 10**9}
_MAX_SIDE = 16_384  # pixels of an image
# images per second: a GIF shows an image for at most 655 s, and screens show at most 240 images per second
FRAME_RATES = (0.01, 240.0)


@dataclass(frozen=True, slots=True)
class Setting:
    """Command-line option of a settings field. The flag of a boolean field inverts its default.

    Attributes
    ----------
    default, help
        Default value and help text.
    flags
        Flags of the option, such as ``--size``; derived from the field's name if empty.
    metavar
        Placeholder of the value in the help text.
    read
        Function that parses the text of the value.
    choices
        Allowed texts.
    alone
        Value of the flag without an argument; None if the argument is required.
    repeated
        Whether the option may be given several times.
    """

    default: Any
    help: str
    flags: tuple[str, ...]
    metavar: str | None = None
    read: Callable[[str], Any] | None = None
    choices: Sequence[str] | None = None
    alone: str | None = None
    repeated: bool = False


def setting(default: Any, help: str, *flags: str, **more: Any) -> Any:
    """Declare a dataclass field as an option, once for the command line and the Python API.

    ``flags`` default to ``--`` and the name of the field; ``more`` are further attributes of ``Setting``.
    """
    return field(default=default, metadata={"setting": Setting(default, help, flags, **more)})


def settings_in(kind: type) -> dict[str, Setting]:
    """Return the options declared by a dataclass, by field name."""
    options: dict[str, Setting] = {}
    for entry in fields(kind):
        if "setting" in entry.metadata:
            option: Setting = entry.metadata["setting"]
            flags = option.flags or (f"--{entry.name.replace('_', '-')}",)
            options[entry.name] = replace(option, flags=flags)
    return options


def amount(text: str) -> float:
    """Parse a positive number with an optional suffix k, M or G."""
    scale = _SUFFIXES.get(text[-1:].lower(), 1)
    try:
        value = float(text[:-1] if scale > 1 else text) * scale
    except ValueError:
        raise ValueError(f"invalid number `{text}`") from None
    if not 0 < value < 1e18:
        raise ValueError(f"expected a positive number, got `{text}`")
    return value


def whole_amount(text: str) -> int:
    """Parse a positive number as ``amount`` does, and truncate it to an integer."""
    return int(amount(text))


def whole(text: str) -> int:
    """Parse a non-negative integer."""
    if not text.isdecimal() or len(text) > 9:
        raise ValueError(f"expected a non-negative integer, got `{text}`")
    return int(text)


def seed(text: str) -> int:
    """Parse a seed of random numbers, from 0 to 4,294,967,295, as NumPy takes them."""
    if not text.isdecimal() or len(text) > 10 or int(text) >= 1 << 32:
        raise ValueError(f"expected a whole number from 0 to {(1 << 32) - 1:,}, got `{text}`")
    return int(text)


def part_of_one(text: str) -> float:
    """Parse a number strictly between 0 and 1."""
    value = _number(text)
    if not 0 < value < 1:
        raise ValueError(f"expected a number between 0 and 1, got `{text}`")
    return value


def within(low: float, high: float) -> Callable[[str], float]:
    """Return a parser of the numbers from ``low`` to ``high``, both inclusive.

    >>> within(0.01, 240)("24")
    24.0
    """

    def read(text: str) -> float:
        """Parse a number of the range."""
        value = _number(text)
        if not low <= value <= high:
            raise ValueError(f"expected a number from {low:,g} to {high:,g}, got `{text}`")
        return value

    return read


seconds = within(0.1, 86_400)
metres = within(1e-9, 1e9)  # per scene unit
frame_rate = within(*FRAME_RATES)


def dollars(text: str) -> float:
    """Parse a positive amount in US dollars, with an optional ``$``."""
    value = _number(text.removeprefix("$"))
    if not 0 < value < 1e9:
        raise ValueError(f"expected a positive amount of dollars, got `{text}`")
    return value


def _number(text: str) -> float:
    """Parse a number; return NaN, which the callers reject, if ``text`` is not one."""
    try:
        return float(text)
    except ValueError:
        return math.nan


def picture_size(text: str) -> tuple[int, int]:
    """Parse an image size ``WIDTHxHEIGHT`` in pixels."""
    match = re.fullmatch(r"(\d+)x(\d+)", text)
    if match is None or not all(1 <= int(side) <= _MAX_SIDE for side in match.groups()):
        numbers = [int(digits) for digits in re.findall(r"\d+", text)[:2] if 1 <= int(digits) <= _MAX_SIDE]
        example = f"{numbers[0]}x{numbers[-1]}" if numbers else "800x600"
        raise ValueError(f"invalid size `{text}`; expected WIDTHxHEIGHT, such as {example}")
    return int(match[1]), int(match[2])


def line_range(text: str) -> tuple[int, int]:
    """Parse a range of lines ``FIRST:LAST``, both inclusive and counted from 1."""
    match = re.fullmatch(r"(\d{1,9}):(\d{1,9})", text)
    if match is None or not 0 < int(match[1]) <= int(match[2]):
        raise ValueError(f"invalid line range `{text}`; expected FIRST:LAST, such as 3:10")
    return int(match[1]), int(match[2])


def port(text: str) -> int:
    """Parse a TCP port number."""
    if not text.isdecimal() or not 0 <= int(text) <= 65_535:
        raise ValueError(f"invalid port `{text}`; expected a number from 0 to 65535")
    return int(text)


def names(text: str) -> tuple[str, ...]:
    """Parse a comma-separated list of names."""
    return tuple(name.strip() for name in text.split(","))


# --- arguments of the Python API -------------------------------------------------------------------------------------

_Function = TypeVar("_Function", bound=Callable[..., Any])


def typed(function: _Function) -> _Function:
    """Decorate a public function so that it checks its arguments by their annotations before it does anything.

    The decorated function raises SceneError("value") for an argument of another type, so that a mistake is reported in
    the caller's terms, SceneError("file") in place of OSError, and SceneError("backend") for a part of the package that
    this installation lacks. Classes are compared by name, because importing them all would make the import of the
    package slow.
    """
    annotations = {name: str(annotation) for name, annotation in function.__annotations__.items()}

    @wraps(function)
    def checked(*arguments: Any, **named: Any) -> Any:
        """Check the arguments, call the function, and convert the errors of Python that a user can cause."""
        for name, value in _bound(function, arguments, named):
            annotation = annotations.get(name, "Any")
            if not fits(value, annotation):
                raise SceneError("value", f"`{name}`: expected {_expected(annotation)}, got {_shown(value)}")
        try:
            return function(*arguments, **named)
        except BrokenPipeError:
            raise
        except OSError as error:  # such as a file name that is too long, from whatever opens it
            raise SceneError("file", f"{error.strerror or error}: {error.filename or 'output'}") from error
        except OverflowError as error:  # an integer that is too large for a float
            raise SceneError("value", f"a number is too large: {error}") from error
        except ModuleNotFoundError as error:
            part = missing_part(error)
            if part is None:
                raise
            raise part from error
        except UnicodeEncodeError as error:  # a lone surrogate in a file name
            raise SceneError("value", f"a name cannot be written: {error.reason}") from error

    return cast(_Function, checked)


def _bound(
    function: Callable[..., Any], arguments: Sequence[Any], named: Mapping[str, Any]
) -> Iterable[tuple[str, Any]]:
    """Return the arguments of a call with the names of their parameters; raises SceneError if the call has no meaning.

    ``inspect`` decides where a call is not plain, because importing it takes a twentieth of ``check``.
    """
    code = function.__code__
    names = code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]
    is_plain = not (hasattr(function, "__wrapped__") or code.co_flags & _TAKES_MORE or code.co_posonlyargcount)
    given = dict(zip(names[: code.co_argcount], arguments))
    has_default = names[code.co_argcount - len(function.__defaults__ or ()) : code.co_argcount]
    optional = {*has_default, *(function.__kwdefaults__ or ())}
    is_complete = len(given) == len(arguments) and given.keys() | named.keys() | optional >= set(names)
    if is_plain and is_complete and named.keys() <= set(names) - given.keys():
        given |= named
        return [(name, given[name]) for name in names if name in given]
    import inspect

    signature = inspect.signature(function)
    try:
        bound = signature.bind(*arguments, **named).arguments
    except TypeError as error:
        raise SceneError("value", f"`{function.__name__}`: {error}") from None
    several = {p.name for p in signature.parameters.values() if p.kind is inspect.Parameter.VAR_POSITIONAL}
    return [(name, value) for name in bound for value in (bound[name] if name in several else (bound[name],))]


_TAKES_MORE = 0x04 | 0x08  # flags of functions with ``*arguments`` and ``**named``, as in ``inspect``

_EXPECTED = {
    "int": "a whole number", "float": "a finite number", "str": "a string", "bool": "True or False", "bytes": "bytes",
    "str | Path": "a path", "Size": "a size (width, height) in pixels, such as (640, 480)",
    "str | Sequence[str]": "a name or several", "Sequence[str]": "several strings",
    "Sequence[float]": "several finite numbers",
    "LoadedScene": "a Scene",  # the class of the kernel, of which users see the one of the API
    "View": "a camera, such as `Camera(azimuth=40)`, or the name of one of the program",
    "Progress": "a function of one number", "Warn": "a function",
    "str | Path | Sequence[str | Path]": "a path or several", "Sequence[str | Path]": "several paths",
}  # fmt: skip


def _expected(annotation: str) -> str:
    """Return the description of an annotation for error messages, with an article."""
    kind = annotation.removesuffix(" | None")
    if kind in _EXPECTED:
        return _EXPECTED[kind]
    if kind.startswith("Literal["):
        return kind.removeprefix("Literal[").rstrip("]").replace("', '", "' or '")
    if kind.startswith("Mapping["):
        return "a mapping from names to values"
    if kind.startswith("Callable["):
        return "a function"
    return f"{kind}(...)" if kind.isidentifier() and kind not in ("Scene", "Entity") else f"a {kind}"


def fits(value: Any, annotation: str) -> bool:
    """Return whether a value fits an annotation, given as text.

    A name that is not in ``_KINDS`` is that of a class of the value.
    """
    kinds = _parts(annotation, "|")
    if "Path" in kinds and isinstance(value, str | os.PathLike) and "\0" in os.fsdecode(value):
        return False  # no file name contains NUL
    if len(kinds) > 1:
        return any(fits(value, kind) for kind in kinds)
    name, _, inner = annotation.partition("[")
    if inner:
        return _FORMS[name](value, inner.removesuffix("]")) if name in _FORMS else True
    if name in _KINDS:
        return _KINDS[name](value)
    return name.rpartition(".")[2] in _classes(value)


def _parts(annotation: str, separator: str) -> list[str]:
    """Split an annotation at a separator, outside brackets."""
    parts, depth = [""], 0
    for letter in annotation:
        depth += (letter == "[") - (letter == "]")
        if letter == separator and not depth:
            parts.append("")
        else:
            parts[-1] += letter
    return [part.strip() for part in parts]


def _is_real(value: Any) -> bool:
    """Return whether a value is a real number; ``numbers`` is only imported for those of other libraries."""
    if isinstance(value, int | float):
        return True
    from numbers import Real

    return isinstance(value, Real)


def _is_finite(value: Any) -> bool:
    """Return whether a number has a finite value as a float."""
    try:
        return math.isfinite(value)
    except OverflowError:  # an integer that is too large for a float
        return False


def _is_several(value: Any) -> bool:
    """Return whether a value is an array or a sequence other than a string."""
    return hasattr(value, "__array__") or (isinstance(value, Sequence) and not isinstance(value, str | bytes))


def _is_size(value: Any) -> bool:
    """Return whether a value is a size of an image in pixels, width and height."""
    return _is_several(value) and len(value) == 2 and all(fits(side, "int") and 0 < side <= _MAX_SIDE for side in value)


def _is_tuple(value: Any, inner: str) -> bool:
    """Return whether a value fits ``tuple[inner]``; arrays and lists do too."""
    kinds = _parts(inner, ",")
    if not _is_several(value) or (kinds[-1] != "..." and len(value) != len(kinds)):
        return False
    if kinds[-1] == "...":
        kinds = kinds * len(value)
    return all(fits(item, kind) for item, kind in zip(value, kinds))


def _is_mapping(value: Any, inner: str) -> bool:
    """Return whether a value fits ``Mapping[inner]``."""
    keys, values = _parts(inner, ",")
    return isinstance(value, Mapping) and all(fits(k, keys) and fits(v, values) for k, v in value.items())


def _is_literal(value: Any, inner: str) -> bool:
    """Return whether a value is one of those of ``Literal[inner]``."""
    import ast

    return isinstance(value, str | int) and value in ast.literal_eval(f"[{inner}]")


_KINDS: Mapping[str, Callable[[Any], bool]] = {
    "Any": lambda value: True,
    "None": lambda value: value is None,
    "int": lambda value: hasattr(type(value), "__index__") and not isinstance(value, bool),
    "float": lambda value: _is_real(value) and not isinstance(value, bool) and _is_finite(value),
    "str": lambda value: isinstance(value, str),
    "bytes": lambda value: isinstance(value, bytes),
    "bool": lambda value: isinstance(value, bool) or type(value).__name__ == "bool_",
    "Path": lambda value: isinstance(value, str | os.PathLike),
    "Size": _is_size,
    "Progress": callable,
    "Warn": callable,
    "Describe": callable,
    "View": lambda value: bool({"Viewpoint", "Camera", "PlacedCamera", "ProgramView", "str"} & _classes(value)),
    "TextIO": lambda value: hasattr(value, "write"),
    "PictureSource": lambda value: True,
    "npt.ArrayLike": lambda value: _is_several(value) or _is_real(value),
}
_FORMS: Mapping[str, Callable[[Any, str], bool]] = {
    "Literal": _is_literal,
    "Sequence": lambda value, inner: _is_several(value) and all(fits(item, inner) for item in value),
    "Mapping": _is_mapping,
    "tuple": _is_tuple,
    "Callable": lambda value, inner: callable(value),
}


def _classes(value: Any) -> set[str]:
    """Return the names of a value's classes; the classes themselves would have to be imported."""
    return {cls.__name__ for cls in type(value).__mro__}


_MAX_SHOWN_CHARACTERS = 60  # of a value in a message


def _shown(value: Any) -> str:
    """Return a value as Python writes it, shortened for a message."""
    text = repr(value)
    return text if len(text) <= _MAX_SHOWN_CHARACTERS else f"{text[: _MAX_SHOWN_CHARACTERS - 3]}..."

"""Fields of settings that users may give: what each means in one line, and how its value is written as text.

Classes of settings declare this once, with ``setting`` as a field's default; the command line derives its options from
it. Each reader makes a value of a text and raises ValueError with a message for people.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any

_SUFFIXES = {"k": 10**3, "m": 10**6, "g": 10**9}
_LONGEST_SIDE = 16_384


@dataclass(frozen=True, slots=True)
class Setting:
    """One field as an option: ``flags`` as users write them, how the value is shown (``metavar``) and ``read``, the
    texts that are allowed (``choices``), what the flag alone means (``alone``, None: a value must follow), whether it
    may be ``repeated``. The flag of a field that is true or false turns its default round."""

    default: Any
    help: str
    flags: tuple[str, ...]
    metavar: str | None = None
    read: Callable[[str], Any] | None = None
    choices: Sequence[str] | None = None
    alone: str | None = None
    repeated: bool = False


def setting(default: Any, help: str, *flags: str, **more: Any) -> Any:
    """A field that users may give: its default, its help, its flags where they differ from its name, and whatever else
    ``Setting`` knows of it."""
    return field(default=default, metadata={"setting": Setting(default, help, flags, **more)})


def settings_in(kind: type) -> dict[str, Setting]:
    """The fields of a data class that users may give, by name."""
    found = {each.name: each.metadata["setting"] for each in fields(kind) if "setting" in each.metadata}
    return {name: replace(each, flags=each.flags or (f"--{name.replace('_', '-')}",)) for name, each in found.items()}


def amount(text: str) -> float:
    """A positive number, with an optional suffix k, M or G."""
    scale = _SUFFIXES.get(text[-1:].lower(), 1)
    try:
        value = float(text[:-1] if scale > 1 else text) * scale
    except ValueError:
        raise ValueError(f"`{text}` is no number") from None
    if not 0 < value < 1e18:
        raise ValueError(f"`{text}` is no positive number")
    return value


def whole_amount(text: str) -> int:
    """The whole part of an amount."""
    return int(amount(text))


def whole(text: str) -> int:
    """A number of things: 0, 1, 2, ..."""
    if not text.isdecimal() or len(text) > 9:
        raise ValueError(f"`{text}` is no number of things")
    return int(text)


def part_of_one(text: str) -> float:
    """A number above 0 and below 1."""
    try:
        value = float(text)
    except ValueError:
        raise ValueError(f"`{text}` is no number") from None
    if not 0 < value < 1:
        raise ValueError(f"`{text}` is not between 0 and 1")
    return value


def seconds(text: str) -> float:
    """A time to wait."""
    value = _number(text)
    if not 0.1 <= value <= 86_400:
        raise ValueError(f"`{text}` is not a number of seconds between 0.1 and 86,400")
    return value


def dollars(text: str) -> float:
    """A positive amount of money."""
    value = _number(text.removeprefix("$"))
    if not 0 < value < 1e9:
        raise ValueError(f"`{text}` is no amount of dollars")
    return value


def _number(text: str) -> float:
    """The number, 0 where there is none."""
    try:
        return float(text)
    except ValueError:
        return 0.0


def picture_size(text: str) -> tuple[int, int]:
    """``WIDTHxHEIGHT`` in pixels."""
    match = re.fullmatch(r"(\d+)x(\d+)", text)
    if match is None or not all(1 <= int(side) <= _LONGEST_SIDE for side in match.groups()):
        raise ValueError(f"`{text}` is no size; write WIDTHxHEIGHT, such as 800x600")
    return int(match[1]), int(match[2])


def line_range(text: str) -> tuple[int, int]:
    """``A:B``, the first and the last of a range of lines."""
    match = re.fullmatch(r"(\d{1,9}):(\d{1,9})", text)
    if match is None or not 0 < int(match[1]) <= int(match[2]):
        raise ValueError(f"`{text}` is no range of lines such as 3:10")
    return int(match[1]), int(match[2])


def port(text: str) -> int:
    """The number of a port."""
    if not text.isdecimal() or not 0 <= int(text) <= 65_535:
        raise ValueError(f"`{text}` is no port; it is a number from 0 to 65535")
    return int(text)


def names(text: str) -> tuple[str, ...]:
    """Names with commas between them."""
    return tuple(name.strip() for name in text.split(","))

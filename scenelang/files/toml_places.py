"""Settings in TOML files, with the position of every key, so that errors have a line and a column.

``tomllib`` parses the text but keeps no positions, so a scanner walks over what it has accepted.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import date, time
from typing import Any, NoReturn

from scenelang.grammar.datum import Source, Span
from scenelang.grammar.diagnostics import SceneError, suggest

KeyPath = tuple[str, ...]
Places = Mapping[KeyPath, tuple[int, int]]

_SPACE = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
_BLANK = re.compile(r"[ \t]*")
_KEY = re.compile(r'[A-Za-z0-9_-]+|"(?:[^"\\\n]|\\.)*"|\'[^\'\n]*\'')
_STRING = re.compile(r'"""(?:[^\\]|\\.)*?"{3,5}|\'\'\'.*?\'{3,5}|"(?:[^"\\\n]|\\.)*"|\'[^\'\n]*\'', re.DOTALL)
_PLAIN = re.compile(r"[^,\]}#\n]+")
_AT_LINE = re.compile(r"\s*\(at line (\d+), column (\d+)\)")
_DIGITS = re.compile(r"[0-9_]{2000,}")
_INTEGERS = "integers have 64 bits: from -2^63 to 2^63 - 1"
_MAX_SHOWN_ITEMS = 8  # of a list in a message
_MAX_SHOWN_LENGTH = 60  # characters of a value in a message
_MAX_SIZE = 1_000_000  # characters of a file


def _places(text: str) -> dict[KeyPath, tuple[int, int]]:
    """Return the offsets of each key of a valid TOML text, by its path; items of arrays have their index as a key."""
    scanner = _Scanner(text)
    scanner.document()
    return scanner.places


class _Scanner:
    """Walks over a text that ``tomllib`` has accepted, and records where its keys are."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.at = 0
        self.places: dict[KeyPath, tuple[int, int]] = {}

    def document(self) -> None:
        """Read the whole text."""
        table: KeyPath = ()
        self._skip(_SPACE)
        while self.at < len(self.text):
            if self.text[self.at] == "[":
                table = self._header()
            else:
                self._pair(table)
            self._skip(_SPACE)

    def _header(self) -> KeyPath:
        """Read the header of a table or of an item of an array of tables; return its path."""
        start = self.at
        is_array = self.text.startswith("[[", start)
        self.at += 2 if is_array else 1
        path = self._path(())
        self.at += 2 if is_array else 1
        if is_array:
            number = sum(1 for known in self.places if known[:-1] == path and known[-1].isdecimal())
            path = (*path, str(number))
        self.places[path] = start, self.at
        return path

    def _path(self, table: KeyPath) -> KeyPath:
        """Read a dotted key."""
        while True:
            self._skip(_BLANK)
            match = _KEY.match(self.text, self.at)
            if match is None:
                raise ValueError
            table = (*table, _plain_key(match[0]))
            self.places.setdefault(table, match.span())
            self.at = match.end()
            self._skip(_BLANK)
            if not self.text.startswith(".", self.at):
                return table
            self.at += 1

    def _pair(self, table: KeyPath) -> None:
        """Read a key and its value."""
        path = self._path(table)
        self.at += 1  # the equals sign
        self._value(path)

    def _value(self, path: KeyPath) -> None:
        """Read a value, and the keys in it."""
        self._skip(_SPACE)
        if self.text.startswith("{", self.at):
            self._items("}", lambda _: self._pair(path))
        elif self.text.startswith("[", self.at):
            self._items("]", lambda number: self._item((*path, str(number))))
        else:
            match = _STRING.match(self.text, self.at) or _PLAIN.match(self.text, self.at)
            self.at = match.end() if match is not None else self.at + 1

    def _item(self, path: KeyPath) -> None:
        """Read an item of an array."""
        self._skip(_SPACE)
        start = self.at
        self._value(path)
        self.places.setdefault(path, (start, max(self.at, start + 1)))

    def _items(self, end: str, read: Any) -> None:
        """Read items up to the closing bracket; ``read`` is called with the index of each."""
        self.at += 1
        number = 0
        while True:
            self._skip(_SPACE)
            if self.text.startswith(end, self.at):
                self.at += 1
                return
            if self.text.startswith(",", self.at):
                self.at += 1
                continue
            read(number)
            number += 1

    def _skip(self, pattern: re.Pattern[str]) -> None:
        """Advance past a match of a pattern."""
        match = pattern.match(self.text, self.at)
        assert match is not None
        self.at = match.end()


def _plain_key(text: str) -> str:
    """Return a key without its quotes."""
    if text[0] not in "\"'":
        return text
    return next(iter(tomllib.loads(f"{text} = 0")))


def parsed(source: Source, code: str) -> TomlTable:
    """Parse TOML; raises SceneError ``code`` with the position of an error."""
    if len(source.text) > _MAX_SIZE:
        raise SceneError(code, f"{source.name} has more than {_MAX_SIZE:,} characters")
    try:
        data = tomllib.loads(source.text)
    except tomllib.TOMLDecodeError as error:
        raise _syntax_error(source, code, str(error)) from None
    except RecursionError:
        raise SceneError(code, f"{source.name} is nested too deeply", span=Span(source, 0, 1)) from None
    except ValueError:  # Python reads no integers of thousands of digits
        digits = _DIGITS.search(source.text)
        span = Span(source, *digits.span()) if digits is not None else Span(source, 0, 1)
        raise SceneError(code, "an integer has thousands of digits", _INTEGERS, span) from None
    try:
        places = _places(source.text)
    except (ValueError, IndexError, RecursionError):  # a rare spelling: mistakes are reported without their place
        places = {}
    document = TomlDocument(source, code, places)
    _check_integers(document, data)
    return TomlTable(data, (), document)


def _check_integers(document: TomlDocument, data: Any) -> None:
    """Raise an error for an integer of more than 64 bits, at any depth of the data."""
    waiting: list[tuple[KeyPath, Any]] = [((), data)]
    while waiting:
        path, value = waiting.pop()
        if isinstance(value, dict):
            waiting += [((*path, key), item) for key, item in value.items()]
        elif isinstance(value, list):
            waiting += [((*path, str(i)), item) for i, item in enumerate(value)]
        elif isinstance(value, int) and not -(1 << 63) <= value < 1 << 63:
            name = next((key for key in reversed(path) if not key.isdecimal()), path[-1])
            document.fail(path, f"`{name[:60]}`: the integer is too large", _INTEGERS)


def _syntax_error(source: Source, code: str, message: str) -> SceneError:
    """Convert an error of ``tomllib`` to one with a span.

    A program of the language, which users pass where a spec of datasets is expected, has an error of its own.
    """
    if source.name.endswith(".scene") or source.text.lstrip().startswith(("(", ";")):
        message = f"{source.name} is a program, but a spec is expected, which is TOML and names programs"
        name = source.name.rpartition("/")[2]
        hint = f'write a file such as spec.toml with `programs = ["{name}"]` and `count = 10`, and name that'
        return SceneError(code, message, hint)
    place = _AT_LINE.search(message)
    end = len(source.text)
    offset = end if place is None else source.line_start(int(place[1])) + int(place[2]) - 1
    start = max(0, min(offset, end - 1))  # an error at the end of the text is shown at its last character
    text = _AT_LINE.sub("", message).removesuffix(" (at end of document)")
    return SceneError(code, f"this is not TOML: {text[:1].lower()}{text[1:]}", span=Span(source, start, start + 1))


@dataclass(frozen=True, slots=True)
class TomlDocument:
    """A TOML file: its text, the code of its errors, and the places of its keys."""

    source: Source
    code: str
    places: Places = field(repr=False)

    def fail(self, path: KeyPath, message: str, hint: str | None = None) -> NoReturn:
        """Raise the error ``message`` with the place of the key ``path``, or of the nearest key around it."""
        while path and path not in self.places:
            path = path[:-1]
        start, end = self.places.get(path, (0, 1))
        raise SceneError(self.code, message, hint, Span(self.source, start, end))


class TomlTable:
    """A table of a TOML file. Keys are read one after the other; ``finish`` reports those that were not."""

    def __init__(self, data: Mapping[str, Any], path: KeyPath, document: TomlDocument) -> None:
        self._data = data
        self._read: set[str] = set()
        self.path = path
        self.document = document

    def __contains__(self, key: str) -> bool:
        return key in self._data

    def __iter__(self) -> Iterator[str]:
        return iter(list(self._data))

    def fail(self, key: str | None, message: str, hint: str | None = None) -> NoReturn:
        """Raise an error at a key of this table, or at the table."""
        self.document.fail(self.path if key is None else (*self.path, key), message, hint)

    def fail_missing(self, key: str, message: str) -> NoReturn:
        """Raise an error for a missing key: at an unread one with a similar name, or at the table."""
        near = next((name for name in self._data if name not in self._read and suggest(name, [key])), None)
        if near is not None:
            self._read.add(key)
            self._fail_unknown(near)
        self.fail(None, message)

    def take(self, key: str, default: Any = None) -> Any:
        """Return the value of ``key``, of any type, or ``default`` if it is missing; ``finish`` will accept the key."""
        self._read.add(key)
        return self._data.get(key, default)

    def number(self, key: str, default: float | None, low: float, high: float) -> Any:
        """Return a number.

        Parameters
        ----------
        key
            Key of the number.
        default
            Result if the key is missing.
        low, high
            Range of the number, which must be whole if ``low`` is an int.

        Raises
        ------
        SceneError
            At the place of the key, if the value is something else.
        """
        value = self.take(key, default)
        if value is None and key not in self._data:
            return value
        kind = (int,) if isinstance(low, int) else (int, float)
        if isinstance(value, bool) or not isinstance(value, kind):
            what = "a whole number" if kind == (int,) else "a number"
            self.fail(key, f"`{key}`: expected {what}, got {shown(value)}")
        if not low <= value <= high:
            self.fail(key, f"`{key}`: expected {low:,} to {high:,}, got {value:,}")
        return value

    def flag(self, key: str, default: bool) -> bool:
        """Return the boolean at ``key``, or ``default`` if it is missing."""
        value = self.take(key, default)
        if not isinstance(value, bool):
            self.fail(key, f"`{key}`: expected true or false, got {shown(value)}")
        return value

    def text(self, key: str, default: str | None, choices: Iterable[str] = ()) -> Any:
        """Return the string at ``key``, or ``default`` if it is missing.

        It is an error if the string is not one of ``choices``, if these are given.
        """
        value = self.take(key, default)
        if value is None and key not in self._data:
            return None
        if not isinstance(value, str):
            self.fail(key, f"`{key}`: expected a string, got {shown(value)}")
        self.check_choice(key, value, tuple(choices))
        return value

    def texts(self, key: str, default: Sequence[str] = (), choices: Iterable[str] = ()) -> tuple[str, ...]:
        """Return the strings at ``key``, or ``default`` if it is missing; a single string is a list of one.

        It is an error if one of them is not in ``choices``, if these are given.
        """
        value = self.take(key, list(default))
        value = [value] if isinstance(value, str) else value
        if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
            self.fail(key, f"`{key}`: expected strings, got {shown(value)}")
        for item in value:
            self.check_choice(key, item, tuple(choices))
        return tuple(value)

    def check_choice(self, key: str, value: str, choices: Sequence[str]) -> None:
        """Raise an error for a value that is not one of ``choices``, if there are any."""
        if choices and value not in choices:
            near = suggest(value, choices)
            self.fail(key, f"`{key}`: unknown `{value[:60]}`", near or f"expected one of {', '.join(choices)}")

    def table(self, key: str) -> TomlTable:
        """Return a table, an empty one if it is missing."""
        value = self.take(key, {})
        if not isinstance(value, dict):
            self.fail(key, f"`{key}`: expected a table, got {shown(value)}")
        return TomlTable(value, (*self.path, key), self.document)

    def tables(self, key: str) -> list[TomlTable]:
        """Return an array of tables, an empty one if it is missing."""
        value = self.take(key, [])
        if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
            self.fail(key, f"`{key}`: expected an array of tables, got {shown(value)}")
        return [TomlTable(item, (*self.path, key, str(i)), self.document) for i, item in enumerate(value)]

    def finish(self) -> None:
        """Raise an error for the first key that nothing has read."""
        for key in self._data:
            if key not in self._read:
                self._fail_unknown(key)

    def _fail_unknown(self, key: str) -> NoReturn:
        where = f" in [{'.'.join(self.path)}]" if self.path else ""
        known = sorted(self._read)
        self.fail(key, f"unknown key `{key[:60]}`{where}", suggest(key, known) or f"known are {', '.join(known)}")


def shown(value: Any) -> str:
    """Return a value for a message, in at most sixty characters."""
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, list | tuple):
        is_short = len(value) <= _MAX_SHOWN_ITEMS and not any(isinstance(item, dict | list | tuple) for item in value)
        text = f"[{', '.join(map(shown, value))}]" if is_short else ""
        return text if 2 < len(text) <= _MAX_SHOWN_LENGTH else "an empty list" if not value else "a list"
    if isinstance(value, bool):
        return str(value).lower()
    return value.isoformat() if isinstance(value, date | time) else repr(value)[:_MAX_SHOWN_LENGTH]

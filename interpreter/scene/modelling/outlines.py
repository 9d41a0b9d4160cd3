"""Outlines of text: glyphs of TrueType and OpenType fonts as contours, one em high, with kerning.

Font files are untrusted. fontTools reads their glyphs within limits; the tables that it would expand in memory, those
of characters and of kerning, are looked up in place here: it would make lists of what a few bytes of a hostile file
declare.
"""

from __future__ import annotations

import io
import os
import struct
import unicodedata
from collections.abc import Callable, Iterator
from functools import cache, lru_cache
from threading import Lock
from typing import TYPE_CHECKING, Any

from scenelang.grammar.datum import dataclass
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.loading import require
from scenelang.interpreter.scene.modelling.contours import TEXT_EXTRA, Contours, OutlinePen, Unreadable, normalized
from scenelang.interpreter.scene.primitives.mesh_file import located

if TYPE_CHECKING:
    from pathlib import Path

    from fontTools.ttLib import TTFont

MAX_FONT_BYTES = 32_000_000  # of a font file, which is read as a whole
MAX_TEXT = 10_000  # characters of a text whose outlines are made
_MAX_PIECES = 20_000  # points and components of one glyph
_MAX_PROGRAM_BYTES = 1_000_000  # of one CFF glyph, with its subroutines
_MAX_SUBROUTINE_DEPTH = 32  # nested calls in a CFF glyph: an untrusted font may nest them without end
_MAX_SUBTABLES = 1_000  # of kerning
_TOLERANCE_EMS = 1.0 / 2000.0  # distance of flattened curves from the outline
_STEPS_PER_FONT = 1024  # charged before a font is read, so that the meter checks the clock
_MAX_LISTED_CHARACTERS = 8  # that a font lacks, in a message
BUNDLED = os.path.join(os.path.dirname(__file__), "fonts", "DejaVuSans.ttf")


@dataclass(frozen=True, slots=True)
class Glyph:
    """Contours of a character and its advance, in ems."""

    contours: Contours
    advance: float


# --- tables ----------------------------------------------------------------------------------------------------------


class _Table:
    """Big-endian numbers of a font's table."""

    def __init__(self, data: bytes) -> None:
        self._data = data

    def u16(self, at: int) -> int:
        """Return an unsigned 16-bit number."""
        return int(struct.unpack_from(">H", self._data, at)[0])

    def i16(self, at: int) -> int:
        """Return a signed 16-bit number."""
        return int(struct.unpack_from(">h", self._data, at)[0])

    def u32(self, at: int) -> int:
        """Return an unsigned 32-bit number."""
        return int(struct.unpack_from(">I", self._data, at)[0])

    def first_at_least(self, value: int, at: int, count: int, step: int) -> int:
        """Return the index of the first of sorted 16-bit numbers that is at least ``value``."""
        low, high = 0, count
        while low < high:
            middle = (low + high) // 2
            if self.u16(at + middle * step) < value:
                low = middle + 1
            else:
                high = middle
        return low


class _Characters(_Table):
    """The table `cmap`: glyphs of characters, in its formats 4 and 12."""

    def __init__(self, data: bytes) -> None:
        super().__init__(data)
        offsets = {}  # by platform and encoding
        for number in range(self.u16(2)):
            at = 4 + 8 * number
            offsets[self.u16(at), self.u16(at + 2)] = self.u32(at + 4)
        best_first = [(3, 10), (0, 6), (0, 4), (3, 1), (0, 3), (0, 2), (0, 1), (0, 0), (3, 0)]
        tables = [offsets[key] for key in best_first if key in offsets and self.u16(offsets[key]) in (4, 12)]
        if not tables:
            raise Unreadable("it has no table of Unicode characters")
        self._at = tables[0]

    def glyph(self, code: int) -> int:
        """Return the number of a character's glyph; 0 if there is none."""
        return self._in_groups(code) if self.u16(self._at) == 12 else self._in_segments(code)

    def _in_groups(self, code: int) -> int:
        """Look a character up in format 12: sorted groups of first character, last character and first glyph."""
        low, high = 0, self.u32(self._at + 12)
        while low < high:
            middle = (low + high) // 2
            group = self._at + 16 + 12 * middle
            if code > self.u32(group + 4):
                low = middle + 1
            elif code < self.u32(group):
                high = middle
            else:
                return self.u32(group + 8) + code - self.u32(group)
        return 0

    def _in_segments(self, code: int) -> int:
        """Look a character up in format 4: sorted segments with a delta, or an offset into a list of glyphs."""
        if code > 0xFFFF:
            return 0
        count = self.u16(self._at + 6) // 2
        ends = self._at + 14
        segment = self.first_at_least(code, ends, count, 2)
        if segment == count:
            return 0
        start = ends + 2 + 2 * (count + segment)
        delta, offset = start + 2 * count, start + 4 * count
        if self.u16(start) > code:
            return 0
        shift = self.u16(offset)
        if shift == 0:
            return (code + self.u16(delta)) & 0xFFFF
        glyph = self.u16(offset + shift + 2 * (code - self.u16(start)))
        return (glyph + self.u16(delta)) & 0xFFFF if glyph else 0


class _Kerning(_Table):
    """The pairs of the feature `kern` of the table `GPOS` (OpenType 1.9, "Pair adjustment positioning")."""

    def __init__(self, data: bytes) -> None:
        super().__init__(data)
        self._lookups = [list(self._subtables(lookup)) for lookup in self._kerning()]

    def _kerning(self) -> list[int]:
        """Return the lookups of the feature."""
        features, lookups = self.u16(6), self.u16(8)
        numbers = set()
        for number in range(self.u16(features)):
            record = features + 2 + 6 * number
            if self._data[record : record + 4] == b"kern":
                feature = features + self.u16(record + 4)
                numbers |= {self.u16(feature + 4 + 2 * i) for i in range(self.u16(feature + 2))}
        return [lookups + self.u16(lookups + 2 + 2 * number) for number in sorted(numbers)][:_MAX_SUBTABLES]

    def _subtables(self, lookup: int) -> Iterator[int]:
        kind = self.u16(lookup)
        for number in range(min(self.u16(lookup + 4), _MAX_SUBTABLES)):
            at = lookup + self.u16(lookup + 6 + 2 * number)
            if kind == 9 and self.u16(at + 2) == 2:  # an extension, for offsets of 32 bits
                yield at + self.u32(at + 4)
            elif kind == 2:
                yield at

    def between(self, left: int, right: int) -> int:
        """Return how much further the glyph after ``left`` is, in units of the font."""
        return sum(self._of_lookup(subtables, left, right) for subtables in self._lookups)

    def _of_lookup(self, subtables: list[int], left: int, right: int) -> int:
        """Return the advance of a pair by the first subtable that covers it."""
        for at in subtables:
            index = self._covered(at + self.u16(at + 2), left)
            if index is None:
                continue
            advance = self._in_set(at, index, right) if self.u16(at) == 1 else self._in_classes(at, left, right)
            if advance is not None:
                return advance
        return 0

    def _sizes(self, at: int) -> tuple[int, int, bool]:
        """Return the size of a subtable's pair of values, the place of the advance, and whether there is one."""
        first, second = self.u16(at + 4), self.u16(at + 6)
        return 2 * (first.bit_count() + second.bit_count()), 2 * (first & 3).bit_count(), bool(first & 4)

    def _in_set(self, at: int, index: int, right: int) -> int | None:
        """Look a pair up in format 1: a sorted set of second glyphs for each first one."""
        size, place, is_given = self._sizes(at)
        pairs = at + self.u16(at + 10 + 2 * index)
        count = self.u16(pairs)
        number = self.first_at_least(right, pairs + 2, count, size + 2)
        record = pairs + 2 + number * (size + 2)
        if number == count or self.u16(record) != right:
            return None
        return self.i16(record + 2 + place) if is_given else 0

    def _in_classes(self, at: int, left: int, right: int) -> int:
        """Look a pair up in format 2: a matrix over classes of glyphs."""
        size, place, is_given = self._sizes(at)
        first, second = self._class(at + self.u16(at + 8), left), self._class(at + self.u16(at + 10), right)
        record = at + 16 + (first * self.u16(at + 14) + second) * size
        return self.i16(record + place) if is_given else 0

    def _covered(self, at: int, glyph: int) -> int | None:
        """Return the index of a glyph in a coverage table, or None if the subtable does not cover it."""
        count = self.u16(at + 2)
        if self.u16(at) == 1:
            index = self.first_at_least(glyph, at + 4, count, 2)
            return index if index < count and self.u16(at + 4 + 2 * index) == glyph else None
        record = self._range(at + 4, count, glyph)
        return None if record is None else self.u16(record + 4) + glyph - self.u16(record)

    def _class(self, at: int, glyph: int) -> int:
        """Return the class of a glyph by a class definition table; 0 for all that it does not list."""
        if self.u16(at) == 1:
            number = glyph - self.u16(at + 2)
            return self.u16(at + 6 + 2 * number) if 0 <= number < self.u16(at + 4) else 0
        record = self._range(at + 4, self.u16(at + 2), glyph)
        return 0 if record is None else self.u16(record + 4)

    def _range(self, at: int, count: int, glyph: int) -> int | None:
        """Return the place of the range (first, last, number) that contains a glyph."""
        number = self.first_at_least(glyph, at + 2, count, 6)
        record = at + 6 * number
        return record if number < count and self.u16(record) <= glyph else None


class _OldKerning(_Table):
    """The pairs of the table `kern`, in its format 0, which older fonts have."""

    def between(self, left: int, right: int) -> int:
        """Return how much further the glyph after ``left`` is, in units of the font."""
        if self.u16(0) != 0 or self.u16(2) == 0 or self.u16(8) & 0xFF01 != 1:
            return 0  # Apple's version, or no horizontal pairs
        low, high, key = 0, self.u16(10), left << 16 | right
        while low < high:
            middle = (low + high) // 2
            pair = self.u32(18 + 6 * middle)
            if pair == key:
                return self.i16(22 + 6 * middle)
            low, high = (middle + 1, high) if pair < key else (low, middle)
        return 0


# --- fonts -----------------------------------------------------------------------------------------------------------


@cache
def _silence() -> None:
    """Keep fontTools from printing its log: it reports errors of a font there and reads on."""
    import logging

    logging.getLogger("fontTools").addHandler(logging.NullHandler())


@cache
def _extractor() -> Any:
    """Return the class that runs the programs of CFF glyphs, with a limit."""
    from fontTools.misc.psCharStrings import T2OutlineExtractor

    class Limited(T2OutlineExtractor):  # type: ignore[misc, unused-ignore]
        """Extractor that counts the bytes that it executes."""

        work = 0

        def execute(self, charString: Any) -> None:
            """Run a program or subroutine, unless the glyph has run too much."""
            self.work += 64 + len(charString.bytecode or charString.program or ())
            if self.work > _MAX_PROGRAM_BYTES or self.subrLevel > _MAX_SUBROUTINE_DEPTH:
                raise Unreadable("the program of the glyph is too long")
            super().execute(charString)

    return Limited


class _Drawings:
    """Glyphs of a font by name, as fontTools draws them."""

    def __init__(self, font: TTFont) -> None:
        self._glyphs = font.getGlyphSet()

    def __getitem__(self, name: str) -> Any:
        programs = getattr(self._glyphs, "charStrings", None)
        if programs is not None:
            programs[name].outlineExtractor = _extractor()
        return self._glyphs[name]


class Typeface:
    """Font with the outlines of its characters. Safe to use from several threads.

    Parameters
    ----------
    data : bytes
        A TrueType or OpenType file.
    name : str
        For messages.
    """

    def __init__(self, data: bytes, name: str) -> None:
        self.name = name
        self._lock = Lock()
        self._glyphs: dict[int, Glyph] = {}
        self._pairs: dict[tuple[int, int], float] = {}
        if data[:4] not in (b"\x00\x01\x00\x00", b"OTTO", b"true"):
            hint = "convert collections (.ttc) and web fonts (.woff) to .ttf or .otf"
            raise SceneError("file", f"the font {name} is no TrueType or OpenType font", hint)
        self._guarded(lambda: self._open(data))

    def _guarded(self, read: Callable[[], Any]) -> Any:
        """Run ``read``; an untrusted font may make fontTools raise any exception."""
        try:
            return read()
        except SceneError:
            raise
        except Unreadable as error:
            reason = str(error)
        except Exception:  # messages of fontTools are about its own tables
            reason = "it is damaged, or lacks what TrueType and OpenType fonts have"
        raise SceneError("file", f"cannot read the font {self.name}: {reason}")

    def _open(self, data: bytes) -> None:
        """Read the tables of a font; glyphs are drawn when they are used."""
        open_font = require("fontTools.ttLib", TEXT_EXTRA).TTFont
        _silence()
        self._font = open_font(io.BytesIO(data), lazy=True, recalcBBoxes=False)
        reader: Any = self._font.reader
        self._em = float(self._font["head"].unitsPerEm)
        if not 16.0 <= self._em <= 16_384.0:
            raise Unreadable(f"it has {self._em:g} units per em, not 16 to 16,384")
        self._characters = _Characters(reader["cmap"])
        self._names = self._font.getGlyphOrder()
        self._advances = self._font["hmtx"].metrics
        self._drawings = _Drawings(self._font)
        kerning = _Kerning(reader["GPOS"]) if "GPOS" in reader else None
        if (kerning is None or not kerning._lookups) and "kern" in reader:
            self._kerning: _Kerning | _OldKerning | None = _OldKerning(reader["kern"])
        else:
            self._kerning = kerning

    def number(self, character: str) -> int:
        """Return the number of a character's glyph; 0 if the font has none."""
        number = self._guarded(lambda: self._characters.glyph(ord(character)))
        return int(number) if number < len(self._names) else 0

    def glyph(self, number: int) -> Glyph:
        """Return the glyph of a number."""
        with self._lock:
            if number not in self._glyphs:
                self._glyphs[number] = self._guarded(lambda: self._drawn(self._names[number]))
            return self._glyphs[number]

    def _drawn(self, name: str) -> Glyph:
        """Return the contours of a glyph, without overlaps and scaled to one em."""
        pen = OutlinePen(_MAX_PIECES, self._drawings)
        self._drawings[name].draw(pen)
        contours = [contour / self._em for contour in pen.contours(_TOLERANCE_EMS * self._em)]
        return Glyph(normalized(contours) if contours else (), self._advances[name][0] / self._em)

    def kerning(self, left: int, right: int) -> float:
        """Return the kerning of two glyphs, given by number: the space that is added between them, in ems."""
        if self._kerning is None:
            return 0.0
        pair = (left, right)
        if pair not in self._pairs:
            kerning = self._kerning
            self._pairs[pair] = self._guarded(lambda: kerning.between(left, right)) / self._em
        return self._pairs[pair]


@cache
def bundled() -> Typeface:
    """Return DejaVu Sans, with Latin, Greek and Cyrillic letters, punctuation, arrows and signs of mathematics."""
    with open(BUNDLED, "rb") as file:
        return Typeface(file.read(), "DejaVu Sans")


@lru_cache(maxsize=16)
def _loaded(path: str, version: int, size: int) -> Typeface:
    """Load a font file; ``version`` and ``size`` are part of the cache key."""
    from pathlib import Path

    with open(path, "rb") as file:
        return Typeface(file.read(MAX_FONT_BYTES + 1), Path(path).name)


class FontFiles:
    """Finds the font files of a scene, which must be inside ``project``, like its mesh files.

    ``folder`` is the directory of the scene's file.
    """

    def __init__(self, folder: Path, project: Path, allow_outside: bool) -> None:
        self._folder = folder
        self._project = project
        self._allow_outside = allow_outside

    def load(self, file: str, charge: Callable[[int], None]) -> Typeface:
        """Return the font of a file; raises SceneError if it cannot be read."""
        target = located(file, "font", self._folder, self._project, self._allow_outside)
        try:
            state = target.stat()
            if state.st_size > MAX_FONT_BYTES:
                message = (
                    f"the font {target.name} has {state.st_size:,} bytes, more than the limit of {MAX_FONT_BYTES:,}"
                )
                raise SceneError("file", message)
            charge(_STEPS_PER_FONT + (state.st_size >> 10))
            return _loaded(str(target), state.st_mtime_ns, state.st_size)
        except OSError as error:
            raise SceneError("file", f"cannot read the font {target.name}: {error.strerror or error}") from None


# --- text ------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class TextStyle:
    """Typesetting of a text.

    Attributes
    ----------
    size
        Size of an em in scene units.
    align
        Share of a line's width that is left of x = 0: 0, 1/2 or 1.
    spacing
        Space added to the advance of every character, in ems.
    line_height
        Distance of baselines, in ems.
    """

    size: float = 1.0
    align: float = 0.0
    spacing: float = 0.0
    line_height: float = 1.2


def text_outline(face: Typeface, text: str, style: TextStyle, charge: Callable[[int], None]) -> Contours:
    """Return the outlines of text, with the baseline of its first line at y = 0.

    Parameters
    ----------
    face
        Font in which the text is set.
    text
        Text of one or several lines.
    style
        Size, alignment and spacing.
    charge
        Function that counts steps of work.

    Returns
    -------
    tuple of (K, 2)
        Closed contours in scene units, each a polygon.

    Raises
    ------
    SceneError
        "value" for characters that the font lacks.
    LimitError
        "size" for too long a text.
    """
    if len(text) > MAX_TEXT:
        raise LimitError("size", f"a text of {len(text):,} characters exceeds the limit of {MAX_TEXT:,}")
    composed = unicodedata.normalize("NFC", text.replace("\r\n", "\n"))
    _check_characters(face, composed)
    contours = []
    for number, line in enumerate(composed.split("\n")):
        placed, width = _set_line(face, line, style.spacing, charge)
        for glyph, x in placed:
            charge(1 + (sum(map(len, glyph.contours)) >> 6))
            corner = (x - style.align * width, -number * style.line_height)
            contours += [(contour + corner) * style.size for contour in glyph.contours]
    return tuple(contours)


def _check_characters(face: Typeface, text: str) -> None:
    """Raise SceneError("value") for characters without a glyph."""
    missing = [c for c in dict.fromkeys(text) if c != "\n" and not face.number(c)]
    if missing:
        shown = ", ".join(map(_shown, missing[:_MAX_LISTED_CHARACTERS]))
        shown += ", ..." if len(missing) > _MAX_LISTED_CHARACTERS else ""
        hint = "give a font that has it by :font, such as a .ttf file in the project folder"
        raise SceneError("value", f"the font {face.name} has no glyph for {shown}", hint)


def _shown(character: str) -> str:
    """Return a character with its code point, which alone tells invisible ones apart."""
    code = f"U+{ord(character):04X}"
    return f'"{character}" ({code})' if character.isprintable() else code


def _set_line(
    face: Typeface, line: str, spacing: float, charge: Callable[[int], None]
) -> tuple[list[tuple[Glyph, float]], float]:  # fmt: skip
    """Return the glyphs of a line with their places, and its width, in ems."""
    placed: list[tuple[Glyph, float]] = []
    x, before = 0.0, None
    for character in line:
        charge(1)
        number = face.number(character)
        if before is not None:
            x += face.kerning(before, number) + spacing
        glyph = face.glyph(number)
        placed.append((glyph, x))
        x, before = x + glyph.advance, number
    return placed, x

"""Diagnostics: every mistake of a user is one of these, never a Python traceback (docs/language.md, "Diagnostics")."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from typing import Any

from scenelang.grammar.codes import CODES
from scenelang.grammar.source import Span


@dataclass(frozen=True, slots=True)
class Note:
    """A second place or remark that belongs to a diagnostic, such as the definition of a macro."""

    message: str
    span: Span | None = None


@dataclass(frozen=True, slots=True)
class Edit:
    """``text`` in place of what stands at ``span``."""

    span: Span
    text: str


@dataclass(frozen=True, slots=True)
class Fix:
    """A way to mend what a diagnostic tells. ``safe``: what a right program does stays the same, so that the fix may be
    applied without asking."""

    title: str
    edits: tuple[Edit, ...]
    safe: bool = False


_LONGEST_MESSAGE = 2_000  # characters
_LONGEST_NAME = 100


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One error or warning. ``chain`` holds the running calls, innermost first: (word or name, place of the call)."""

    name: str
    message: str
    span: Span | None = None
    hint: str | None = None
    notes: tuple[Note, ...] = ()
    chain: tuple[tuple[str, Span | None], ...] = ()
    fixes: tuple[Fix, ...] = ()

    def __post_init__(self) -> None:
        """Cut what is too long to read: a name or a value of the program may have millions of characters."""
        object.__setattr__(self, "message", _cut(self.message, _LONGEST_MESSAGE))
        if self.hint is not None:
            object.__setattr__(self, "hint", _cut(self.hint, _LONGEST_MESSAGE))
        if any(len(name) > _LONGEST_NAME for name, _ in self.chain):
            object.__setattr__(self, "chain", tuple((_cut(name, _LONGEST_NAME), span) for name, span in self.chain))

    @property
    def code(self) -> str:
        return CODES[self.name].code

    @property
    def is_error(self) -> bool:
        return self.code.startswith("E")


_LONGEST_KEPT = 200


def _cut(text: str, longest: int) -> str:
    """``text``, or its beginning and end where it is longer."""
    return text if len(text) <= longest else f"{text[: longest * 3 // 4]} ... {text[-longest // 4 :]}"


@dataclass(eq=False)
class SceneError(Exception):
    """A mistake in a program. Builtins raise it without a place; the call that ran them adds its own."""

    name: str
    message: str
    hint: str | None = None
    span: Span | None = None
    notes: tuple[Note, ...] = ()
    chain: list[tuple[str, Span | None]] = field(default_factory=list)
    value: Any = None
    fixes: tuple[Fix, ...] = ()

    def called(self, name: str, span: Span | None) -> None:
        """Add a running call to the chain, outward; of a very long chain the middle is dropped."""
        if len(self.chain) < _LONGEST_KEPT:
            self.chain.append((name, span))
        else:
            self.chain[-1] = (name, span)

    @property
    def diagnostic(self) -> Diagnostic:
        return Diagnostic(self.name, self.message, self.span, self.hint, self.notes, tuple(self.chain), self.fixes)

    def __str__(self) -> str:
        return f"{CODES[self.name].code}: {self.message}"


class LimitError(SceneError):
    """A limit was reached. No ``guard`` catches it."""


def near_names(name: str, candidates: Iterable[str]) -> list[str]:
    """The one or two candidates that ``name`` may be a misspelling of; names of a human length have such."""
    if len(name) > _LONGEST_NAME:
        return []
    lowered = {
        candidate.lower(): candidate
        for candidate in candidates
        if candidate != name and len(candidate) <= _LONGEST_NAME
    }
    cutoff = 0.72 if len(name) > 3 else 0.8  # of a short name, two letters out of three say nothing
    return [lowered[match] for match in get_close_matches(name.lower(), lowered, n=2, cutoff=cutoff)]


def suggest(name: str, candidates: Iterable[str]) -> str | None:
    """The hint "did you mean ...?" with the nearest candidates, or None when none is near."""
    return did_you_mean(near_names(name, candidates))


def did_you_mean(near: Sequence[str]) -> str | None:
    """The hint that offers near names; None when there are none."""
    return f"did you mean {' or '.join(f'`{other}`' for other in near)}?" if near else None


def renamings(span: Span | None, name: str, near: Iterable[str]) -> tuple[Fix, ...]:
    """Fixes that put a near name where ``name`` stands."""
    if span is None or span.expansion is not None or span.text != name:
        return ()
    return tuple(Fix(f"Change to `{other}`", (Edit(span, other),)) for other in near)


# --- rendering -------------------------------------------------------------------------------------------------

_STYLES = {"error": "\x1b[1;31m", "warning": "\x1b[1;33m", "place": "\x1b[36m", "hint": "\x1b[32m", "off": "\x1b[0m"}
_TAB = "    "
_WIDEST = 160
_LONGEST_CHAIN = 8


def printable(text: str) -> str:
    """``text`` without characters that a terminal would act on; lines stay lines."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c == "\n" else _TAB if c == "\t" else f"\\x{ord(c):x};" for c in text)


def _place(span: Span) -> str:
    line, column = span.source.position(span.start)
    return f"{printable(span.source.name)}:{line}:{column}"


def _excerpt(span: Span, marker: str) -> list[str]:
    """The source line with ``marker`` under the span, cut to a window around it when it is very long."""
    line_number, column = span.source.position(span.start)
    line = span.source.line(line_number)
    first = column - 1
    last = max(min(first + span.end - span.start, len(line)), first + 1)
    offset = max(0, first - _WIDEST // 2) if len(line) > _WIDEST else 0
    shown = line[offset : offset + _WIDEST]
    before = line[offset:first].replace("\t", _TAB)
    width = max(1, len(line[first : min(last, offset + _WIDEST)].replace("\t", _TAB)))
    shown = "".join(c if c.isprintable() else "�" for c in shown.replace("\t", _TAB))
    gutter = " " * len(str(line_number))
    return [f" {line_number} | {shown}", f" {gutter} | {' ' * len(before)}{marker * width}"]


def _expansion_notes(span: Span | None) -> list[Note]:
    notes: list[Note] = []
    expansion = span.expansion if span else None
    while expansion is not None and len(notes) < 4:
        notes.append(Note(f"in the expansion of the macro `{expansion.macro}`", expansion.definition))
        expansion = expansion.outer
    return notes


def _chain_lines(chain: Sequence[tuple[str, Span | None]]) -> list[str]:
    lines: list[str] = []
    index = 0
    while index < len(chain):
        name, span = chain[index]
        repeats = 1
        while index + repeats < len(chain) and chain[index + repeats][0] == name:
            repeats += 1
        place = f", called at {_place(span)}" if span else ""
        times = f" (and {repeats - 1} more)" if repeats > 1 else ""
        lines.append(f"   in {printable(name)}{place}{times}")
        index += repeats
    if len(lines) > _LONGEST_CHAIN:
        half = _LONGEST_CHAIN // 2
        lines = [*lines[:half], f"   ... {len(lines) - 2 * half} more calls", *lines[-half:]]
    return lines


def render_text(diagnostic: Diagnostic, color: bool = False) -> str:
    """The diagnostic as people read it: code, message, place, marked source line, hint, notes, chain of calls."""
    style = _STYLES if color else dict.fromkeys(_STYLES, "")
    severity = "error" if diagnostic.is_error else "warning"
    lines = [f"{style[severity]}{severity}[{diagnostic.code}]{style['off']}: {printable(diagnostic.message)}"]
    if diagnostic.span:
        lines.append(f"{style['place']}  --> {_place(diagnostic.span)}{style['off']}")
        excerpt, mark = _excerpt(diagnostic.span, "^")
        lines += [excerpt, f"{style[severity]}{mark}{style['off']}"]
    if diagnostic.hint:
        lines.append(f"{style['hint']}  hint: {printable(diagnostic.hint)}{style['off']}")
    for note in (*diagnostic.notes, *_expansion_notes(diagnostic.span)):
        lines.append(f"  note: {printable(note.message)}" + (f" ({_place(note.span)})" if note.span else ""))
        if note.span:
            lines += _excerpt(note.span, "-")
    lines += _chain_lines(diagnostic.chain)
    return "\n".join(lines)


_MOST_SHOWN = 100
_LONGEST_SHOWN = 64_000  # characters of all that is shown


def capped(diagnostics: Sequence[Diagnostic]) -> list[Diagnostic]:
    """As many diagnostics as a person or a program will read, errors before warnings where not all fit, in their order;
    at the end how many were left out."""
    if len(diagnostics) <= _MOST_SHOWN and sum(map(_length, diagnostics)) <= _LONGEST_SHOWN:
        return list(diagnostics)
    kept: set[int] = set()
    left = _LONGEST_SHOWN
    for number in sorted(range(len(diagnostics)), key=lambda n: not diagnostics[n].is_error):
        left -= _length(diagnostics[number])
        if kept and (len(kept) >= _MOST_SHOWN or left < 0):
            break
        kept.add(number)
    shown = [diagnostics[number] for number in sorted(kept)]
    errors = sum(diagnostic.is_error for diagnostic in diagnostics) - sum(d.is_error for d in shown)
    more = len(diagnostics) - len(shown)
    return [*shown, Diagnostic("not-shown", f"{more:,} more findings are not shown, {errors:,} errors among them")]


def _length(diagnostic: Diagnostic) -> int:
    """About how many characters a diagnostic has when it is shown."""
    notes = sum(len(note.message) + _WIDEST for note in diagnostic.notes)
    return len(diagnostic.message) + len(diagnostic.hint or "") + 2 * _WIDEST + notes


def _json_place(span: Span | None) -> dict[str, Any] | None:
    if span is None:
        return None
    line, column = span.source.position(span.start)
    end_line, end_column = span.source.position(span.end)
    return {"file": span.source.name, "line": line, "column": column, "end_line": end_line, "end_column": end_column}


def to_json(diagnostic: Diagnostic) -> dict[str, Any]:
    """The diagnostic as plain data, for ``--json``."""
    return {
        "code": diagnostic.code,
        "name": diagnostic.name,
        "severity": "error" if diagnostic.is_error else "warning",
        "message": diagnostic.message,
        "place": _json_place(diagnostic.span),
        "hint": diagnostic.hint,
        "notes": [
            {"message": note.message, "place": _json_place(note.span)}
            for note in (*diagnostic.notes, *_expansion_notes(diagnostic.span))
        ],
        "fixes": [
            {
                "title": fix.title,
                "safe": fix.safe,
                "edits": [{"place": _json_place(edit.span), "text": edit.text} for edit in fix.edits],
            }
            for fix in diagnostic.fixes
        ],
        "chain": [{"word": name, "place": _json_place(span)} for name, span in diagnostic.chain],
    }

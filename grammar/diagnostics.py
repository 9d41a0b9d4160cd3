"""Diagnostics: every mistake of a user is one of these, never a Python traceback (docs/language.md, "Diagnostics")."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from difflib import get_close_matches
from typing import Any, NamedTuple

from scenelang.grammar.datum import Span

# The table of diagnostic codes. Programs test errors by name (``(error-is? e "index")``), people quote the code.


class DiagnosticCode(NamedTuple):
    """``code`` is stable for ever; ``why`` says what went wrong and how to mend it."""

    code: str
    why: str


CODES: dict[str, DiagnosticCode] = {
    # E1xx: reading
    "unclosed": DiagnosticCode("E101", "A parenthesis, bracket, string or comment was opened and never closed."),
    "extra-close": DiagnosticCode(
        "E102", "A closing parenthesis or bracket has no opener, or closes one of the other kind."
    ),
    "bad-atom": DiagnosticCode("E103", "Something begins like a number, keyword, handle or `#` literal and is none."),
    "bad-string": DiagnosticCode("E104", "A string holds an escape that does not exist."),
    "bad-dot": DiagnosticCode("E105", "A dot stands where no pair can be: write `(a . b)`."),
    "nesting": DiagnosticCode("E106", "Parentheses are nested deeper than the reader allows."),
    "encoding": DiagnosticCode("E107", "The file is not UTF-8 text."),
    # E2xx: forms
    "syntax": DiagnosticCode("E201", "A form does not have the shape that its head asks for."),
    "lambda-list": DiagnosticCode("E202", "A list of parameters is malformed."),
    "misplaced": DiagnosticCode(
        "E203", "A form stands where it may not: `scene` inside a body, `else` outside `cond`, and so on."
    ),
    "reserved": DiagnosticCode("E204", "The name is reserved and cannot be bound."),
    "duplicate": DiagnosticCode("E205", "The same name is bound twice in one place."),
    "absent": DiagnosticCode("E206", "A Scheme feature that this language leaves out on purpose."),
    "macro": DiagnosticCode("E207", "A macro is malformed, or no rule of it matches its use."),
    "expansion": DiagnosticCode("E208", "Expanding a macro failed or did not end."),
    "bracket": DiagnosticCode("E209", "Square brackets are array literals; here the language wants parentheses."),
    "strict": DiagnosticCode("E210", "The program is outside the paper's grammar, which `--strict` asks for."),
    "empty-application": DiagnosticCode("E211", "`()` cannot be evaluated; the empty list is `'()` or `(list)`."),
    # E3xx: names
    "unbound": DiagnosticCode("E301", "The name has no definition."),
    "undefined-yet": DiagnosticCode("E302", "The name is read before its definition has run."),
    "type-name": DiagnosticCode("E303", "The annotation names no type."),
    "no-root": DiagnosticCode("E304", "The program binds no word that could be the root of a scene."),
    "param": DiagnosticCode("E305", "A `--define` or `:min`/`:max` does not fit the program's `param`."),
    # E4xx: running
    "type": DiagnosticCode("E401", "A value has another type than the operation needs."),
    "arity": DiagnosticCode("E402", "A function was called with too few or too many arguments."),
    "not-a-procedure": DiagnosticCode("E403", "Something that is no function stands at the head of a call."),
    "keyword": DiagnosticCode("E404", "A keyword argument is missing, unknown or repeated."),
    "index": DiagnosticCode("E405", "An index is outside the sequence."),
    "key": DiagnosticCode("E406", "A table, record or embedding does not hold the key."),
    "zero-division": DiagnosticCode("E407", "A division by zero."),
    "domain": DiagnosticCode(
        "E408", "A number is outside the domain of the function, or the result is too large for a float."
    ),
    "value": DiagnosticCode("E409", "A value has the right type but cannot be used here."),
    "immutable": DiagnosticCode("E410", "An immutable value cannot be changed; make a mutable twin of it."),
    "changed": DiagnosticCode("E411", "A table or set was changed while it was being iterated."),
    "pattern": DiagnosticCode("E412", "A sequence does not have the length that the pattern takes apart."),
    "assert": DiagnosticCode("E413", "An assertion does not hold."),
    "user": DiagnosticCode("E414", "The program raised an error itself."),
    "escape": DiagnosticCode("E415", "An escape procedure was called after its `let/ec` had ended."),
    "format": DiagnosticCode("E416", "A format string is malformed."),
    # E5xx: limits
    "steps": DiagnosticCode("E501", "The program ran more steps than allowed (--max-steps)."),
    "depth": DiagnosticCode("E502", "Calls were nested deeper than allowed (--max-depth)."),
    "entities": DiagnosticCode("E503", "The scene has more distinct entities than allowed (--max-entities)."),
    "primitives": DiagnosticCode("E504", "The scene expands to more primitives than allowed (--max-primitives)."),
    "size": DiagnosticCode(
        "E505", "A list or string grew larger than allowed (--max-size), or an integer past 4,000 digits."
    ),
    "memory": DiagnosticCode("E506", "The program used more memory than allowed (--max-memory)."),
    "time": DiagnosticCode("E507", "The program ran longer than allowed (--max-seconds)."),
    "interrupted": DiagnosticCode("E508", "The evaluation was interrupted."),
    "crash": DiagnosticCode("E509", "The process that worked on the program ended without a result."),
    # E6xx: scenes
    "parts": DiagnosticCode("E601", "A function's value is no entity, pair of entity and matrix, or list of these."),
    "pose": DiagnosticCode("E602", "A pose must be a finite 4x4 matrix whose last row is 0 0 0 1."),
    "attribute": DiagnosticCode("E603", "An attribute of a primitive has a value that its geometry cannot use."),
    "embedding": DiagnosticCode("E604", "Something that is no embedding was passed where `call` wants one."),
    "frames": DiagnosticCode("E605", "`frames` may only be the value of the root, and needs at least one frame."),
    "root": DiagnosticCode("E606", "The root word is not bound, or its value cannot be a scene."),
    "empty-scene": DiagnosticCode("E607", "The scene has no primitives, so there is nothing to draw or export."),
    "endless": DiagnosticCode("E608", "The root's list of handles has no end, and this operation would need it."),
    "word": DiagnosticCode("E609", "A word must be a string."),
    "blocks": DiagnosticCode("E610", "A pose or size of Minecraft blocks does not come to whole cells."),
    # E7xx: files
    "file": DiagnosticCode("E701", "A file cannot be read or written."),
    "import-cycle": DiagnosticCode("E702", "Files import one another in a circle."),
    "import-outside": DiagnosticCode("E703", "A path leaves the project folder."),
    "z-file": DiagnosticCode("E704", "The file of embeddings is malformed."),
    "backend": DiagnosticCode("E705", "No backend can write this file, or the one that can is not installed."),
    "unsupported": DiagnosticCode("E706", "The backend cannot draw this scene."),
    "weights": DiagnosticCode(
        "E707", "The weights of a neural model are not on this machine, or are those of another model."
    ),
    # E8xx: a language model's Python
    "python-syntax": DiagnosticCode("E801", "The Python does not parse."),
    "python-forbidden": DiagnosticCode(
        "E802", "Python that has no meaning for a scene: files, network, `eval`, Python's insides."
    ),
    "python-unsupported": DiagnosticCode("E803", "A feature of Python that the translation does not know."),
    "python-name": DiagnosticCode("E804", "A name of the Python has no definition."),
    "python-call": DiagnosticCode("E805", "A call in the Python does not fit what it calls."),
    # E9xx: language models
    "model-key": DiagnosticCode(
        "E901", "There is no key for a language model's service, or the service does not accept it."
    ),
    "model-offline": DiagnosticCode("E902", "A language model's service cannot be reached."),
    "model-request": DiagnosticCode("E903", "A language model's service does not accept a request, or fails."),
    "model-cost": DiagnosticCode("E904", "The next request could cost more than is left of --max-cost."),
    "model-price": DiagnosticCode("E905", "The price of a model is not known."),
    "model-refusal": DiagnosticCode("E906", "The model declines to answer."),
    "model-answer": DiagnosticCode("E907", "The model's answers came to no program that works."),
    "listing": DiagnosticCode("E908", "The list of primitives in a model's answer is malformed."),
    "prompt": DiagnosticCode("E909", "A prompt's file is missing, or has a place for which there is no text."),
    "run": DiagnosticCode("E910", "There is no such run, or its folder is damaged or in use."),
    # W
    "undefined-word": DiagnosticCode("W301", "A word is called at top level before its `bind`."),
    "shadowed-macro": DiagnosticCode("W302", "One of the paper's four macros is shadowed."),
    "bound-twice": DiagnosticCode("W303", "A word is bound twice in one file; the last binding wins."),
    "ambiguous-root": DiagnosticCode("W304", "Several words could be the root; the last bound was taken."),
    "optional-embedding": DiagnosticCode(
        "W305", "A `call` never fills optional positional parameters; their defaults are used."
    ),
    "unused": DiagnosticCode("W306", "A definition, local or parameter is never used."),
    "shadowed-builtin": DiagnosticCode(
        "W307", "Something that is no function is called by the name of a builtin that it hides."
    ),
    "unreachable-word": DiagnosticCode("W308", "The root of the scene never reaches a word of its file."),
    "constant-condition": DiagnosticCode("W309", "A condition is always true or always false."),
    "turned-after-moved": DiagnosticCode("W609", "A thing is turned about the origin after it was moved away from it."),
    "overlap": DiagnosticCode(
        "W611", "Things are where others are: twice in one place, hidden inside, or deep in one another."
    ),
    "floating": DiagnosticCode(
        "W612", "Something touches nothing, a little off the ground or off the thing that it belongs to."
    ),
    "below-ground": DiagnosticCode("W613", "Something reaches far below y = 0, on which the scene stands."),
    "coincident-faces": DiagnosticCode(
        "W614", "Two faces of different colours lie in one plane, so either may be drawn."
    ),
    "geometry-limit": DiagnosticCode(
        "W615", "The scene is larger than `check --geometry` looks at, or has too many findings."
    ),
    "empty-box": DiagnosticCode("W601", "The bounding box of nothing is the unit box."),
    "no-extent": DiagnosticCode("W602", "A primitive has no extent in some direction."),
    "unused-entry": DiagnosticCode("W603", "An entry of the file of embeddings names nothing in the scene."),
    "embedding-only": DiagnosticCode("W604", "The call changed things outside it, so only its embedding was replaced."),
    "near-word": DiagnosticCode("W605", "A word is never bound, but one close to it is: perhaps a misspelling."),
    "idle-attribute": DiagnosticCode(
        "W608", "A primitive's geometry does not read an attribute: perhaps a misspelling."
    ),
    "set-order": DiagnosticCode("W607", "The order of a set's strings is not that of Python."),
    "unknown-block": DiagnosticCode("W616", "Minecraft has no block of this name, so another one is laid instead."),
    "block-property": DiagnosticCode("W623", "A Minecraft block takes no such property or value, so it is left out."),
    "off-cells": DiagnosticCode(
        "W624", "Blocks stand between cells, and moving them to cells changes the distances between them."
    ),
    "no-block": DiagnosticCode("W617", "Something lays no blocks, so it is missing from the build."),
    "too-new": DiagnosticCode("W620", "The version of Minecraft that a file is for does not have a block."),
    "lost-contents": DiagnosticCode("W618", "A file of a Minecraft build holds things that blocks alone do not."),
    "plain-look": DiagnosticCode(
        "W619", "The game's looks have no model for a block, so boxes of its average colour stand for it."
    ),
    "not-shown": DiagnosticCode("W625", "More was found than is shown at once."),
    "crowded-layout": DiagnosticCode("W621", "More things are seen than a text-to-image model is told of at once."),
    "unread-vectors": DiagnosticCode(
        "W622", "Learned vectors are for another text encoder than the model's, so texts serve."
    ),
    "unknown-function": DiagnosticCode(
        "W801", "`library_call` names no registered function; the call gives an empty shape."
    ),
    "ignored-block": DiagnosticCode("W802", "Only one block of Python in a response is read."),
    "python-ignored": DiagnosticCode("W803", "A statement of the Python has no effect on the scene and was left out."),
    "draw-order": DiagnosticCode(
        "W804", "A generator and the loop over it both draw random numbers; the generator draws first."
    ),
    "print-limit": DiagnosticCode("W501", "The log is full; the rest of what the program prints is dropped."),
}


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
        """Code, message, place, source line and hint, as the command line shows them."""
        return render_text(self.diagnostic)


def error_of(diagnostic: Diagnostic) -> SceneError:
    """The exception of a diagnostic."""
    d = diagnostic
    return SceneError(d.name, d.message, d.hint, d.span, d.notes, list(d.chain), fixes=d.fixes)


class LimitError(SceneError):
    """A limit was reached. No ``guard`` catches it."""


class UsageError(SceneError):
    """An argument that makes no sense, whatever the program; the command line exits with 2."""


@contextmanager
def usage_errors() -> Iterator[None]:
    """What is wrong in this block is an argument, not the program."""
    try:
        yield
    except SceneError as error:
        raise UsageError(error.name, error.message, error.hint) from None


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


# How to fix each mistake, by its name: for the command ``explain`` and the reference of diagnostics.


_READING = {
    "unclosed": 'Close what the message points at: add the missing `)`, `]`, `"` or `|#` where the form is to end.',
    "extra-close": "Remove the closer, close with the one that fits the opener, or find the opener that is missing.",
    "bad-atom": 'Write a number that is one, put text in `"..."`, and index with `(ref xs 0)` instead of `xs[0]`.',
    "bad-string": "Double a backslash that is meant as one, `\\\\`, or use one of the escapes that the hint lists.",
    "bad-dot": "Put something before the dot and one datum after it, or write `.5` without a blank.",
    "nesting": "Break the program into definitions, or make deep data by a loop.",
    "encoding": "Save the file as UTF-8 in your editor.",
}

_FORMS = {
    "syntax": "Give the form the shape that the hint shows; `docs/reference/forms.md` has an example of each.",
    "lambda-list": "Write each parameter as `name`, `(name default)`, `:name` or `(:name default)`, a rest one last.",
    "misplaced": "Move the form to where it belongs: `scene` and `param` to the top level, `else` into `cond`.",
    "reserved": "Choose another name.",
    "duplicate": "Rename one of the two, or remove it.",
    "absent": "Do it the way that the hint names.",
    "macro": "Compare the macro's patterns with its use; the first element of a pattern is the macro's name.",
    "expansion": "Look for a macro that expands into itself, or for a loop in the body of a `define-macro`.",
    "bracket": "Write round parentheses: only arrays of numbers stand in `[...]`; lists of others are `(list ...)`.",
    "strict": "Use only what the rule allows, or check without `--strict`: the full language allows more.",
    "empty-application": "Write `'()` or `(list)` for the empty list, `(union)` for no parts.",
}

_NAMES = {
    "unbound": "Correct the spelling, define the name, or import the file that does.",
    "undefined-yet": "Move the definition above its first use, or use the name in a function that is called later.",
    "type-name": "Use a type of the list in `docs/reference/stdlib.md`, or the name of a record.",
    "no-root": 'Bind a word: `(bind "word" (lambda () (call "cube")))`.',
    "param": "Give a value of the param's own kind within its `:min` and `:max`, under the name that the program has.",
}

_RUNNING = {
    "type": "Pass a value of the type that the message names, or convert it first.",
    "arity": "Pass as many arguments as the signature in the hint has.",
    "not-a-procedure": "Put a function at the head; a value alone stands without parentheses. A name of the library "
    "that a parameter hides is still there as `std/name`.",
    "keyword": "Name the attributes that the function has, each once, and give those that have no default.",
    "index": "Count from 0 to one less than the length, or from -1 backwards; test with `length` before.",
    "key": "Ask for a key that is there, or give a default: `(ref table key default)`.",
    "zero-division": "Test the divisor before, or keep it away from 0 with `max`.",
    "domain": "Keep the number inside the function's domain, with `clamp`, `max` or a test.",
    "value": "Pass a value that the message allows.",
    "immutable": "Make the mutable twin, `(mutable-list ...)` or `(mutable-array ...)`, or build a new value.",
    "changed": "Collect the keys first, `(table-keys table)`, and change the table while running over that list.",
    "pattern": "Make the pattern as long as the sequence, or take the rest with `(a b . more)`.",
    "assert": "The program says that this must hold: correct what it tests, or the values that lead there.",
    "user": "The message is the program's own: look at the call that it points at, or catch it with `guard`.",
    "escape": "Call the escape procedure inside the body of its `let/ec` only.",
    "format": "Write one `{}` for each value, and a format behind the colon that the value has: `{:.2f}`.",
}

_LIMITS = {
    "steps": "Look for a loop or recursion without end; else raise `--max-steps`.",
    "depth": "Give the recursion an end, or make it a loop; else raise `--max-depth`.",
    "entities": "Let copies share one call with equal attributes; else raise `--max-entities`.",
    "primitives": "Make fewer levels or copies, look with `count` and `bounds`, which never expand, or raise "
    "`--max-primitives`.",
    "size": "Look for a list, string or number that grows without end; else raise `--max-size`.",
    "memory": "Keep less at a time; else raise `--max-memory`.",
    "time": "Look for a loop or recursion without end; else raise `--max-seconds`.",
    "crash": "Lower --max-memory where the system ran out of memory; otherwise a library failed: please report it.",
    "interrupted": "Run it again, with smaller numbers or limits if it took too long.",
}

_SCENES = {
    "parts": "Return entities, pairs that `transform` makes, or lists of these; `(union)` stands for nothing at all.",
    "pose": "Make the matrix with `translate`, `rotate`, `scale`, `reflect` and `@`, from finite numbers.",
    "attribute": "Give the attribute the kind of value that the message names.",
    "embedding": "Name the attribute, `:height 3`, or write a text, a handle or `(embedding ...)`.",
    "frames": "Return `(frames list)` from the root itself, with one member or more.",
    "root": "Name a word that the program binds, and let its function return parts.",
    "empty-scene": 'Return at least one primitive, such as `(call "cube")`.',
    "endless": "Take as many handles as you need: `(list-head gamma n)`.",
    "word": 'Put the word in quotes: `"park"`.',
    "blocks": "Compose blocks with `translate` and whole numbers in `scale` only.",
}

_FILES = {
    "file": "Check the path and the permissions; paths are relative to the file that names them.",
    "import-cycle": "Move what both files need into a third one that imports neither.",
    "import-outside": "Move the file into the project folder, or allow it with `--allow-outside`.",
    "z-file": "Write the file anew with `scenelang embeddings`, or remove it.",
    "backend": "Choose an ending or backend that `scenelang backends` lists, and install what the hint names.",
    "unsupported": "Bring the scene to a size that can be drawn, or take another backend (`scenelang backends`).",
    "weights": "Connect once so that they are fetched, or name the folder that holds them: `--models-dir DIR`.",
}

_PYTHON = {
    "python-syntax": "Correct the Python at the place shown, or ask the model for its program again.",
    "python-forbidden": "Remove it: a scene needs shapes, numbers and random draws, and nothing of the computer.",
    "python-unsupported": "Write it with plain functions, loops and lists; `docs/transpiler.md` lists what is known.",
    "python-name": "Correct the spelling, or define the name before it is used.",
    "python-call": "Pass the arguments that the function has.",
}

_MODELS = {
    "model-key": "Set the key in the environment, or write it into the configuration file, which only you may read.",
    "model-offline": "Connect the machine, or check the base URL; `--dry-run` needs no network.",
    "model-request": "Read what the service says; wait and continue with `--resume` where it has too much to do.",
    "model-cost": "Raise `--max-cost`, or ask for less: `--max-tokens`, `-n`, `--critique`.",
    "model-price": "Give it with `--price INPUT,OUTPUT`, or in the configuration file, or take a model that is known.",
    "model-refusal": "Word the task differently.",
    "model-answer": "Allow more tries with `--repair`, take another model or more `--effort`, or ask for less.",
    "listing": "Ask again: items want `shape`, `attributes` and `pose`.",
    "prompt": "Correct the place's name, or remove the file so that the package's own prompt is used.",
    "run": "Take one that `scenelang runs` lists, and wait until no other process is at work on it.",
}

_WARNINGS = {
    "undefined-word": "Move the `bind` above the call, or call the word inside a function.",
    "shadowed-macro": "Choose another name, or write `std/union` for the paper's.",
    "bound-twice": "Remove one of the two bindings, or rename one word.",
    "ambiguous-root": 'Say which word is the scene: `(scene "word")`, or `--root WORD`.',
    "optional-embedding": "Make it a keyword parameter, `(:height 2)`, and pass `:height` in the `call`.",
    "unused": "Remove it, use it, or begin its name with `_`.",
    "shadowed-builtin": "Rename the parameter or local, or call the library's function as `std/name`.",
    "unreachable-word": "Call the word somewhere, remove its `bind`, or name another root.",
    "constant-condition": "Test what can differ, or keep only the branch that is taken.",
    "turned-after-moved": "Turn first, then move, `(@ (translate v) (rotate a axis))`, or give `rotate` the point to "
    "turn about.",
    "empty-box": "Measure something that has a primitive in it.",
    "no-extent": "Give the primitive a size, or two different end points.",
    "unused-entry": "Look at the handles with `scenelang tree`, then rename or remove the entry with `scenelang "
    "embeddings`.",
    "embedding-only": "Let the call change nothing outside itself, or write the attribute in the program.",
    "near-word": "Correct the spelling, or leave it if a word of its own is meant.",
    "idle-attribute": "Correct the spelling, or remove the attribute.",
    "set-order": "Keep them in a list where the order matters; in Python, loop over `sorted(names)`.",
    "overlap": "Move one of the two, or remove what is there twice; `; lint: allow overlap` allows what is meant.",
    "floating": "Set it down with `on-top-of`, `align` or `attach`, or allow it: `; lint: allow floating`.",
    "below-ground": "Lift it by what is below 0: `compute-shape-min` tells how much.",
    "coincident-faces": "Move one of the faces by a thousandth, or make one of the things a little smaller.",
    "geometry-limit": "Check a part of the scene by itself: `--root WORD`.",
    "unknown-block": "Name the block that is laid instead, or another one that the game has.",
    "block-property": "Take one of those that the message lists, or leave the property out: it has a default.",
    "off-cells": "Move blocks by whole numbers: distances and gaps of combinators too.",
    "no-block": "Lay blocks with `set-cuboid`, or turn the scene into blocks with `export --voxelize`.",
    "too-new": "Name a newer version with `--mc-version`, or lay a block that the older one has.",
    "lost-contents": "Nothing need be done; fill chests and write signs in the game.",
    "plain-look": "Give the looks of the whole game with `--textures`; a resource pack may hold a part of them only.",
    "not-shown": "Fix what is shown first; one mistake often has many consequences.",
    "crowded-layout": "Take whole entities as one: `--depth N`, `--entity NAME`; or come nearer with `--camera`.",
    "unread-vectors": "Name a model whose text encoder they were learned for: `--model NAME`.",
    "unknown-function": "Register a function of that name, or correct the name.",
    "ignored-block": "Keep one block with the whole program.",
    "python-ignored": "Nothing need be done; `--seed N` sets the seed.",
    "draw-order": "Compare the picture with the model's; draw in one place only if the order matters.",
    "print-limit": "Print less, or run with `--quiet`.",
}

MENDS: Mapping[str, str] = {
    **_READING, **_FORMS, **_NAMES, **_RUNNING, **_LIMITS, **_SCENES, **_FILES, **_PYTHON, **_MODELS, **_WARNINGS
}  # fmt: skip


def diagnostic_named(asked: str) -> str | None:
    """The name of the diagnostic that a code or name means; None where there is none."""
    by_code = {entry.code: name for name, entry in CODES.items()}
    name = by_code.get(asked.upper(), asked.lower())
    return name if name in CODES else None


def diagnostic_asked(asked: str) -> str:
    """The name of the diagnostic that a code or name means; raises UsageError for one that there is not."""
    name = diagnostic_named(asked)
    if name is None:
        known = [*(entry.code for entry in CODES.values()), *CODES]
        hint = suggest(asked, known) or "`scenelang explain` lists all of them"
        raise UsageError("value", f"there is no code or name `{asked[:80]}`", hint)
    return name


def explanation_data(name: str) -> dict[str, str]:
    """A diagnostic as JSON data."""
    return {"code": CODES[name].code, "name": name, "why": CODES[name].why, "mend": MENDS[name]}


def explanation(name: str) -> tuple[str, str, str]:
    """A diagnostic for people: code and name, why it arises, how it is mended."""
    return f"{CODES[name].code} {name}", f"  {CODES[name].why}", f"  {MENDS[name]}"


def by_code() -> list[str]:
    """The names of all diagnostics, in the order of their codes."""
    return sorted(CODES, key=lambda name: CODES[name].code)


def explained(names: Sequence[str]) -> str:
    """Diagnostics for people; without any a list of all."""
    if not names:
        return "\n".join(f"{CODES[name].code} {name}: {CODES[name].why}" for name in by_code())
    return "\n\n".join("\n".join(explanation(name)) for name in names)

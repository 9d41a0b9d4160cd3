"""Diagnostics: errors and warnings with a stable code, a source location, hints and fixes.

Every mistake in a user's program is reported as a diagnostic, never as a Python traceback (docs/language.md,
"Diagnostics").
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

from scenelang.grammar.datum import Expansion, Source, Span, TextEdit, dataclass, field, replace

# The table of diagnostic codes. Programs test errors by name, ``(error-is? e "index")``; people quote the code.


class DiagnosticCode(NamedTuple):
    """Entry of the table of codes: the stable ``code``, and ``why`` the diagnostic is reported."""

    code: str
    why: str


CODES: dict[str, DiagnosticCode] = {
    # E1xx: reading
    "unclosed": DiagnosticCode("E101", "A parenthesis, bracket, string or comment is never closed."),
    "extra-close": DiagnosticCode("E102", "A closing parenthesis or bracket has no matching opening one."),
    "bad-atom": DiagnosticCode("E103", "A number, keyword, handle or `#` literal is malformed."),
    "bad-string": DiagnosticCode("E104", "A string contains an unknown escape sequence."),
    "bad-dot": DiagnosticCode("E105", "A dot is not part of a dotted pair `(a . b)`."),
    "nesting": DiagnosticCode("E106", "Parentheses are nested too deeply."),
    "encoding": DiagnosticCode("E107", "The file is not valid UTF-8."),
    # E2xx: forms
    "syntax": DiagnosticCode("E201", "A special form has the wrong syntax."),
    "lambda-list": DiagnosticCode("E202", "A parameter list is malformed."),
    "misplaced": DiagnosticCode(
        "E203", "A form is not allowed in this position, such as `scene` inside a body or `else` outside `cond`."
    ),
    "reserved": DiagnosticCode("E204", "A reserved name cannot be bound."),
    "duplicate": DiagnosticCode("E205", "The same name is bound twice in one scope."),
    "absent": DiagnosticCode("E206", "The language deliberately does not support this Scheme feature."),
    "macro": DiagnosticCode("E207", "A macro definition is malformed, or none of the macro's rules matches its use."),
    "expansion": DiagnosticCode("E208", "The expansion of a macro failed or does not terminate."),
    "bracket": DiagnosticCode("E209", "Square brackets, which denote an array, are used instead of parentheses."),
    "strict": DiagnosticCode("E210", "The program is outside the paper's grammar, which `--strict` requires."),
    "empty-application": DiagnosticCode("E211", "`()` cannot be evaluated; the empty list is `'()` or `(list)`."),
    "foreign-syntax": DiagnosticCode("E212", "A construct of another language is used."),
    # E3xx: names
    "unbound": DiagnosticCode("E301", "The name is not defined."),
    "undefined-yet": DiagnosticCode("E302", "A variable is read before its definition has been evaluated."),
    "type-name": DiagnosticCode("E303", "A type annotation does not name a known type."),
    "no-root": DiagnosticCode("E304", "The program binds no word that can be the root of the scene."),
    "param": DiagnosticCode(
        "E305", "A `--define` option or a `:min`/`:max` bound is invalid for the program's `param`."
    ),
    # E4xx: running
    "type": DiagnosticCode("E401", "A value has the wrong type for the operation."),
    "arity": DiagnosticCode("E402", "A function was called with the wrong number of arguments."),
    "not-a-procedure": DiagnosticCode("E403", "The called value is not a function."),
    "keyword": DiagnosticCode("E404", "A keyword argument is missing, unknown or repeated."),
    "index": DiagnosticCode("E405", "An index is out of range."),
    "key": DiagnosticCode("E406", "A table, record or embedding does not contain the key."),
    "zero-division": DiagnosticCode("E407", "A number was divided by zero."),
    "domain": DiagnosticCode(
        "E408", "An argument is outside the domain of the function, or the result overflows a float."
    ),
    "value": DiagnosticCode("E409", "A value has the right type but is not valid here."),
    "immutable": DiagnosticCode("E410", "An immutable value cannot be modified."),
    "changed": DiagnosticCode("E411", "A table or set was modified during iteration."),
    "pattern": DiagnosticCode("E412", "A destructuring pattern and its value have different lengths."),
    "assert": DiagnosticCode("E413", "An assertion failed."),
    "user": DiagnosticCode("E414", "The program raised an error itself, with `error` or `raise`."),
    "escape": DiagnosticCode("E415", "An escape procedure was called after its `let/ec` returned."),
    "format": DiagnosticCode("E416", "A format string is malformed."),
    # E5xx: limits
    "steps": DiagnosticCode("E501", "The program exceeded the step limit (`--max-steps`)."),
    "depth": DiagnosticCode("E502", "The program exceeded the recursion limit (`--max-depth`)."),
    "entities": DiagnosticCode("E503", "The scene exceeds the limit of distinct entities (`--max-entities`)."),
    "primitives": DiagnosticCode("E504", "The expanded scene exceeds the limit of primitives (`--max-primitives`)."),
    "size": DiagnosticCode(
        "E505", "A list or string exceeds the size limit (`--max-size`), or an integer has more than 4,000 digits."
    ),
    "memory": DiagnosticCode("E506", "The program exceeded the memory limit (`--max-memory`)."),
    "time": DiagnosticCode("E507", "The program exceeded the time limit (`--max-seconds`)."),
    "interrupted": DiagnosticCode("E508", "The evaluation was interrupted."),
    "blocked": DiagnosticCode(
        "E510", "The evaluation gave no result for far longer than `--max-seconds`, and used no CPU time."
    ),
    "crash": DiagnosticCode("E509", "The worker process that ran the program exited without a result."),
    # E6xx: scenes
    "parts": DiagnosticCode("E601", "A function returned something other than an entity, a posed entity or a list."),
    "pose": DiagnosticCode("E602", "A pose is not a finite 4x4 matrix with the last row 0 0 0 1."),
    "attribute": DiagnosticCode("E603", "A primitive's attribute has an invalid value."),
    "embedding": DiagnosticCode("E604", "An argument of `call` is not an embedding."),
    "frames": DiagnosticCode("E605", "`frames` is not the value of the root, or has no frames."),
    "root": DiagnosticCode("E606", "The root word is not bound, or its value is not a scene."),
    "empty-scene": DiagnosticCode("E607", "The scene has no primitives, so there is nothing to draw or export."),
    "endless": DiagnosticCode("E608", "The operation requires a finite list of handles, but the root's is infinite."),
    "word": DiagnosticCode("E609", "A word is not a string."),
    "blocks": DiagnosticCode("E610", "The pose or size of Minecraft blocks is not aligned to the block grid."),
    "solid": DiagnosticCode(
        "E611", "A solid cannot be computed: an operand is open, flat, semantic or made of blocks, or nothing is left."
    ),
    "declaration": DiagnosticCode("E612", "A declaration of `assert-that` does not hold."),
    "declaration-subject": DiagnosticCode(
        "E613", "A declaration names a word or handle that does not occur, or for which the relation has no meaning."
    ),
    # E7xx: files
    "file": DiagnosticCode("E701", "A file cannot be read or written."),
    "import-cycle": DiagnosticCode("E702", "Files import each other in a cycle."),
    "import-outside": DiagnosticCode("E703", "A path is outside the project folder."),
    "z-file": DiagnosticCode("E704", "The embeddings file is malformed."),
    "backend": DiagnosticCode("E705", "No installed backend can write this file format."),
    "physics": DiagnosticCode(
        "E708", "The scene cannot be simulated: its masses or sizes are beyond the solver's range."
    ),
    "unsupported": DiagnosticCode("E706", "The backend does not support this scene."),
    "weights": DiagnosticCode(
        "E707", "The weights of a neural model are missing on this machine, or belong to a different model."
    ),
    # E8xx: a language model's Python
    "python-syntax": DiagnosticCode("E801", "The Python code has a syntax error."),
    "python-forbidden": DiagnosticCode(
        "E802", "The Python code uses files, the network, `eval` or interpreter internals, which are not allowed."
    ),
    "python-unsupported": DiagnosticCode("E803", "The transpiler does not support this Python feature."),
    "python-name": DiagnosticCode("E804", "A name in the Python code is not defined."),
    "python-call": DiagnosticCode("E805", "A call in the Python code does not match the function's signature."),
    "python-exception": DiagnosticCode("E806", "The Python code raises an exception."),
    # E81x: OpenSCAD
    "openscad-syntax": DiagnosticCode("E811", "The OpenSCAD program has a mistake."),
    "openscad-unsupported": DiagnosticCode("E812", "This part of OpenSCAD cannot be converted."),
    # E82x: Blender
    "blender-unsupported": DiagnosticCode("E821", "This part of a Blender script has no counterpart in a scene."),
    # E9xx: language models
    "model-key": DiagnosticCode("E901", "The API key for the language model provider is missing or invalid."),
    "model-offline": DiagnosticCode("E902", "The language model API cannot be reached."),
    "model-request": DiagnosticCode("E903", "The language model API rejected the request or failed."),
    "model-cost": DiagnosticCode(
        "E904", "The next request could exceed the remaining budget of dollars, tokens or seconds."
    ),
    "model-price": DiagnosticCode("E905", "The price of the model is unknown."),
    "model-refusal": DiagnosticCode("E906", "The language model refused to answer."),
    "model-answer": DiagnosticCode("E907", "The language model did not produce a working program."),
    "listing": DiagnosticCode("E908", "The list of primitives in the model's response is malformed."),
    "prompt": DiagnosticCode("E909", "A prompt template is missing, or contains an unknown placeholder."),
    "run": DiagnosticCode("E910", "The run does not exist, is damaged, or is in use by another process."),
    # E92x: datasets
    "dataset": DiagnosticCode("E921", "The spec of a dataset is wrong, or the dataset is damaged."),
    "sample": DiagnosticCode("E922", "A sample of a dataset cannot be made."),
    # W
    "undefined-word": DiagnosticCode("W301", "A word is called at top level before its `bind`."),
    "shadowed-macro": DiagnosticCode("W302", "A definition shadows one of the paper's four macros."),
    "bound-twice": DiagnosticCode("W303", "A word is bound twice in one file; the last binding is used."),
    "ambiguous-root": DiagnosticCode("W304", "Several words could be the root; the last one bound is used."),
    "optional-embedding": DiagnosticCode(
        "W305", "`call` never passes optional positional parameters; their defaults are always used."
    ),
    "unused": DiagnosticCode("W306", "A definition, local variable or keyword parameter is never used."),
    "shadowed-builtin": DiagnosticCode(
        "W307", "The called variable shadows a builtin function, but its value is not a function."
    ),
    "unreachable-word": DiagnosticCode("W308", "A word of the file is never reached from the root of the scene."),
    "constant-condition": DiagnosticCode("W309", "A condition is always true or always false."),
    "conditional-failure": DiagnosticCode(
        "W401", "An expression always fails, but it may not be evaluated: it is in a branch or inside `guard`."
    ),
    "out-of-range": DiagnosticCode("W402", "A literal value is outside the range that makes sense here."),
    "dropped-value": DiagnosticCode("W403", "An entity is created, but its value is not used."),
    "unreachable-code": DiagnosticCode("W404", "Code follows an expression that never returns."),
    "plain-parameter": DiagnosticCode(
        "W405", "A word is called with an attribute that its function takes as a positional parameter."
    ),
    "endless-recursion": DiagnosticCode("W406", "A function calls itself whenever it is called, so it never returns."),
    "elementwise-poses": DiagnosticCode("W407", "Two matrices are multiplied item by item instead of composed."),
    "unused-value": DiagnosticCode("W408", "A value of `format` fills no field of its template."),
    "turned-after-moved": DiagnosticCode(
        "W609", "A part is rotated about the origin after it was translated, so it swings to another place."
    ),
    "overlap": DiagnosticCode(
        "W611", "Parts of the scene overlap: duplicates, one hidden inside another, or a deep intersection."
    ),
    "floating": DiagnosticCode("W612", "An object has no support: no contacts lead from it to the ground."),
    "unstable": DiagnosticCode("W626", "An object would tip over, slide or fall: nothing holds it where it is."),
    "below-ground": DiagnosticCode("W613", "An object is sunk into the ground, or into what it stands on."),
    "coincident-faces": DiagnosticCode(
        "W614", "Two faces of different colors are coplanar and overlap, so either may be drawn (z-fighting)."
    ),
    "outlier": DiagnosticCode(
        "W628", "An object differs from its siblings: turned, out of its row, larger, or missing."
    ),
    "outlier-note": DiagnosticCode("N628", "An object differs from its siblings, and may be meant to."),
    "overlap-note": DiagnosticCode("N611", "Two objects are in each other, and may be meant to be."),
    "floating-note": DiagnosticCode("N612", "An object has no support, and may be meant to fly."),
    "unstable-note": DiagnosticCode("N626", "An object stands only if something that no contact shows holds it."),
    "coincident-faces-note": DiagnosticCode("N614", "Small coplanar faces of different colors overlap (z-fighting)."),
    "below-ground-note": DiagnosticCode("N613", "An object is in the ground, and may be planted there."),
    "geometry-limit": DiagnosticCode(
        "W615", "The scene is too large for `check --geometry` to check completely, or has too many findings."
    ),
    "body-moves": DiagnosticCode("W631", "A body slides, sinks or is pushed when gravity acts on the scene."),
    "body-note": DiagnosticCode("N631", "A body moves in a simulation, and may be meant to."),
    "body-tips": DiagnosticCode("W632", "A body tips over when gravity acts on the scene."),
    "body-falls": DiagnosticCode("W633", "A body falls when gravity acts on the scene."),
    "body-explodes": DiagnosticCode(
        "W634", "A body starts inside another one, and flies apart from it when the scene is simulated."
    ),
    "not-simulated": DiagnosticCode(
        "W635", "Nothing is simulated: the scene, or its first frame, has no solid objects."
    ),
    "empty-box": DiagnosticCode("W601", "The bounding box of an empty shape defaults to the unit box."),
    "no-extent": DiagnosticCode("W602", "A primitive has zero extent along some axis."),
    "unused-entry": DiagnosticCode("W603", "An entry of the embeddings file matches no handle of the scene."),
    "embedding-only": DiagnosticCode(
        "W604", "The call has side effects, so only its embedding was replaced and its body did not run again."
    ),
    "near-word": DiagnosticCode("W605", "A word that is never bound is close to a bound one: perhaps a misspelling."),
    "idle-attribute": DiagnosticCode("W608", "The primitive does not use this attribute: perhaps a misspelling."),
    "set-order": DiagnosticCode("W607", "The iteration order of a set of strings differs from Python's."),
    "unknown-block": DiagnosticCode("W616", "Minecraft has no block of this name, so another block is used instead."),
    "block-property": DiagnosticCode(
        "W623", "The Minecraft block does not have this property or value, so it is ignored."
    ),
    "off-cells": DiagnosticCode(
        "W624", "Blocks are not aligned to the block grid, and rounding changes the distances between them."
    ),
    "no-block": DiagnosticCode("W617", "A part of the scene has no blocks, so it is missing from the build."),
    "crossing-profile": DiagnosticCode("W627", "A contour of a profile crosses itself."),
    "single-precision": DiagnosticCode(
        "W641",
        "The file format stores single-precision numbers, which change the volume of a body far from the origin.",
    ),
    "crowded-edge": DiagnosticCode(
        "W642", "Bodies touch along an edge, which has four faces for readers that join points at one place."
    ),
    "lost-attribute": DiagnosticCode("W644", "The exported file lacks attributes that its format does not have."),
    "large-file": DiagnosticCode("W643", "The exported file will be larger than 200 MB."),
    "too-new": DiagnosticCode("W620", "The block does not exist in the target version of Minecraft."),
    "lost-contents": DiagnosticCode(
        "W618", "A Minecraft build file contains data other than blocks, which is dropped."
    ),
    "plain-look": DiagnosticCode(
        "W619", "The resource pack has no model for a block, so it is drawn as a box of the block's average color."
    ),
    "not-shown": DiagnosticCode("W625", "There are more findings than can be shown at once."),
    "crowded-layout": DiagnosticCode(
        "W621", "The view contains more objects than a text-to-image model accepts in one layout."
    ),
    "unread-vectors": DiagnosticCode(
        "W622", "The learned embeddings belong to another text encoder, so the plain text prompt is used."
    ),
    "unknown-function": DiagnosticCode(
        "W801", "`library_call` does not name a registered function, so the call returns an empty shape."
    ),
    "fixed-draws": DiagnosticCode(
        "W805", "Random numbers decide what a program builds, and were drawn when it was translated."
    ),
    "ignored-block": DiagnosticCode("W802", "The response has Python code blocks that are not part of the program."),
    "python-ignored": DiagnosticCode("W803", "A Python statement has no effect on the scene and was ignored."),
    "draw-order": DiagnosticCode(
        "W804", "A generator and the loop over it both draw random numbers; the generator now draws first."
    ),
    "openscad-ignored": DiagnosticCode(
        "W806", "A part of an OpenSCAD program was left out of the conversion, or replaced."
    ),
    "fixed-parameter": DiagnosticCode(
        "W808", "A parameter may only have the values for which the Python was evaluated; others are errors."
    ),
    "blender-ignored": DiagnosticCode("W807", "A part of a Blender script was left out of the scene, or replaced."),
    "print-limit": DiagnosticCode("W501", "The log is full; further output of the program is discarded."),
}


# Findings about positions of objects, which may be consequences of other mistakes: repairs handle them last.
ABOUT_GEOMETRY = ("overlap", "floating", "unstable", "below-ground", "coincident-faces", "outlier")
ABOUT_SCENES = ("declaration", *ABOUT_GEOMETRY)


@dataclass(frozen=True, slots=True)
class Note:
    """Additional remark of a diagnostic, such as the location of a macro's definition."""

    message: str
    span: Span | None = None


@dataclass(frozen=True, slots=True)
class Edit:
    """Text edit: replace the source text at ``span`` with ``text``."""

    span: Span
    text: str

    @property
    def text_edit(self) -> TextEdit:
        """The edit by its offsets."""
        return TextEdit(self.span.start, self.span.end, self.text)


@dataclass(frozen=True, slots=True)
class Fix:
    """Code fix for a diagnostic (a "code action" in LSP).

    Attributes
    ----------
    title
        What the fix does, in the imperative.
    edits
        Replacements of text.
    safe
        Whether it preserves the behavior of correct programs, so that it may be applied automatically.
    """

    title: str
    edits: tuple[Edit, ...]
    safe: bool = False

    @property
    def text_edits(self) -> list[TextEdit]:
        """Edits by offsets; all are in one source."""
        return [edit.text_edit for edit in self.edits]


_MAX_MESSAGE = 2_000  # characters of a message or hint; cut in the middle, because values are quoted there
_MAX_NAME = 100  # characters of a name in a call stack, and of one that is compared with others


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One error or warning.

    Attributes
    ----------
    name
        Name of the diagnostic in ``CODES``.
    message, hint
        What is wrong, and what to do.
    span
        Location in the text, if it is known.
    notes
        Additional remarks with their locations.
    chain
        Call stack, innermost call first, as pairs of a word or function name and the location of the call.
    fixes
        Edits that correct the mistake; the first one is the most probable.
    expected, found
        What was expected and what was found, for programs that read diagnostics.
    signature
        Signature of the function that is called.
    near
        Names that may have been meant.
    """

    name: str
    message: str
    span: Span | None = None
    hint: str | None = None
    notes: tuple[Note, ...] = ()
    chain: tuple[tuple[str, Span | None], ...] = ()
    fixes: tuple[Fix, ...] = ()
    expected: str | None = None
    found: str | None = None
    signature: str | None = None
    near: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Truncate texts that are too long to read: a name or value of the program may have millions of characters."""
        object.__setattr__(self, "message", _cut(self.message, _MAX_MESSAGE))
        if self.hint is not None:
            object.__setattr__(self, "hint", _cut(self.hint, _MAX_MESSAGE))
        if any(len(name) > _MAX_NAME for name, _ in self.chain):
            object.__setattr__(self, "chain", tuple((_cut(name, _MAX_NAME), span) for name, span in self.chain))

    @property
    def code(self) -> str:
        """Code such as ``E101``, which users see; errors start with E, warnings with W, notes with N."""
        return CODES[self.name].code

    @property
    def severity(self) -> str:
        """Whether it is an "error", a "warning", or a "note": a finding that may be meant."""
        return {"E": "error", "W": "warning", "N": "note"}[self.code[0]]

    @property
    def is_error(self) -> bool:
        """Whether the program is rejected; otherwise this is a warning or a note."""
        return self.code.startswith("E")


_MAX_CALLS = 200  # of a call stack: output shows 8, and an infinite recursion would keep thousands


def _cut(text: str, longest: int) -> str:
    """Return ``text``, shortened to its beginning and end if it exceeds ``longest`` characters."""
    return text if len(text) <= longest else f"{text[: longest * 3 // 4]} ... {text[-longest // 4 :]}"


@dataclass(eq=False)
class SceneError(Exception):
    """Error in a user's program, the exception form of a diagnostic.

    Builtins raise it without a span; the call that invoked them adds its own.

    Attributes
    ----------
    name, message, hint, span, notes, chain, fixes, near, expected, found, signature
        As in ``Diagnostic``.
    value
        Value that the program raised.
    subject
        Entity or mesh that the error is about, where an image of it helps.
    """

    name: str
    message: str
    hint: str | None = None
    span: Span | None = None
    notes: tuple[Note, ...] = ()
    chain: list[tuple[str, Span | None]] = field(default_factory=list)
    value: Any = None
    fixes: tuple[Fix, ...] = ()
    near: tuple[str, ...] = ()
    expected: str | None = None
    found: str | None = None
    signature: str | None = None
    subject: Any = None

    def called(self, name: str, span: Span | None) -> None:
        """Append the next outer call to the call stack: the function ``name``, called at ``span``.

        Beyond a maximum length, only the outermost call is updated.
        """
        if len(self.chain) < _MAX_CALLS:
            self.chain.append((name, span))
        else:
            self.chain[-1] = (name, span)

    @property
    def diagnostic(self) -> Diagnostic:
        """The same error as plain data, without ``value`` and ``subject``."""
        return Diagnostic(
            self.name, self.message, self.span, self.hint, self.notes, tuple(self.chain), self.fixes, self.expected,
            self.found, self.signature, self.near,
        )  # fmt: skip

    def __str__(self) -> str:
        """Return the diagnostic as the command line prints it: code, message, location, source line and hint."""
        return render_text(self.diagnostic)


def error_of(diagnostic: Diagnostic) -> SceneError:
    """Return the exception that represents a diagnostic."""
    d = diagnostic
    return SceneError(
        d.name, d.message, d.hint, d.span, d.notes, list(d.chain), None, d.fixes, d.near, d.expected, d.found,
        d.signature,
    )  # fmt: skip


REINSTALL = "--force-reinstall scenelang"  # arguments of `pip install` that restore what was deleted of the package


def missing_part(error: ModuleNotFoundError) -> MissingPart | None:
    """Return the error for a part of the package that this installation lacks; None for a module of another package."""
    from scenelang.grammar.domains import domain_of_module

    module = str(error.name)
    domain = domain_of_module(module)
    if domain is None:  # of another package, or one that a plugin of another version expects
        return None
    message = f"this installation lacks the part {domain}, which is needed here (`{module}`)"
    return MissingPart("backend", message, f"reinstall it: `pip install {REINSTALL}`")


class MissingPart(SceneError):
    """This installation lacks a domain of the package, as one that was made smaller does."""


class LimitError(SceneError):
    """A resource limit was exceeded. Programs cannot catch it with ``guard``."""


class UsageError(SceneError):
    """Invalid argument of a command or API call, independent of the program; the command line exits with 2."""


@contextmanager
def usage_errors() -> Iterator[None]:
    """Convert any ``SceneError`` raised in this block to ``UsageError``: its cause is an argument, not the program.

    What the installation lacks is the fault of neither, and has one exit code in all commands.
    """
    try:
        yield
    except MissingPart:
        raise
    except SceneError as error:
        raise UsageError(error.name, error.message, error.hint) from None


# Ratios of ``SequenceMatcher``: of names of more than three letters, and of shorter ones, where two that match are a
# coincidence.
_MIN_RATIO, _MIN_SHORT_RATIO = 0.72, 0.8


def near_names(name: str, candidates: Iterable[str]) -> list[str]:
    """Return at most two candidates that ``name`` may be a misspelling of; overlong names have none.

    Names with two neighboring letters swapped come first, because ``difflib`` rates a swap like two wrong letters.
    """
    if len(name) > _MAX_NAME:
        return []
    cutoff = _MIN_RATIO if len(name) > 3 else _MIN_SHORT_RATIO
    lowered = {
        candidate.lower(): candidate for candidate in candidates if candidate != name and len(candidate) <= _MAX_NAME
    }
    anagrams = [lowered[other] for other in lowered if len(other) == len(name) > 2 and _is_swap(other, name.lower())]
    if anagrams:
        return anagrams[:2]
    return [lowered[match] for match in close_matches(name.lower(), lowered, 2, cutoff)]


def close_matches(word: str, others: Iterable[str], most: int, ratio: float) -> list[str]:
    """Return at most ``most`` similar words, the most similar first, as ``difflib.get_close_matches`` does."""
    candidates = [other for other in others if may_resemble(word, other, ratio)]
    if not candidates:  # importing `difflib` takes as long as comparing the letters of a thousand words
        return []
    from difflib import get_close_matches

    return get_close_matches(word, candidates, most, ratio)


def may_resemble(a: str, b: str, ratio: float) -> bool:
    """Return False if so few letters are the same that the ratio of ``difflib`` is below ``ratio``."""
    shared = sum(min(a.count(letter), b.count(letter)) for letter in set(a))
    return 2 * shared >= ratio * (len(a) + len(b))


def _is_swap(a: str, b: str) -> bool:
    """Return whether two names differ by two neighboring letters in the wrong order."""
    i = next((i for i, (x, y) in enumerate(zip(a, b)) if x != y), None)
    return i is not None and a[i : i + 2] == b[i : i + 2][::-1] and a[i + 2 :] == b[i + 2 :]


_KEYBOARD_ROWS = ("qwertyuiop", "asdfghjkl", "zxcvbnm")
_KEY_PLACES = {
    letter: (row, column) for row, letters in enumerate(_KEYBOARD_ROWS) for column, letter in enumerate(letters)
}
_MIN_SLIP_LETTERS = 4  # in shorter names, one other letter makes another word, such as "car" and "cat"


def is_typo(written: str, meant: str) -> bool:
    """Return whether a name is another one with one typing error: a neighboring key, a letter twice, or two exchanged.

    The keyboard distinguishes a typing error from another word: "cune" is "cube", but "tube" is a word of its own,
    because its first letter is not next to "c". Assumes a QWERTY layout.
    """
    if min(len(written), len(meant)) < _MIN_SLIP_LETTERS or written == meant:
        return False
    if len(written) == len(meant) + 1:
        return any(written == meant[:i] + meant[i] + meant[i:] for i in range(len(meant)))
    if len(written) != len(meant):
        return False
    wrong = [(a, b) for a, b in zip(written, meant) if a != b]
    return _is_swap(written, meant) or (len(wrong) == 1 and _are_neighbors(*wrong[0]))


def _are_neighbors(a: str, b: str) -> bool:
    """Return whether two letters are adjacent on the keyboard, in one row or in two."""
    if a not in _KEY_PLACES or b not in _KEY_PLACES:
        return False
    (row_a, column_a), (row_b, column_b) = _KEY_PLACES[a], _KEY_PLACES[b]
    return abs(row_a - row_b) <= 1 and abs(column_a - column_b) <= 1


def suggest(name: str, candidates: Iterable[str]) -> str | None:
    """Return the hint "did you mean ...?" for the candidates closest to ``name``, or None if none is close."""
    return did_you_mean(near_names(name, candidates))


def suggest_text(name: str, candidates: Iterable[str]) -> str | None:
    """Return the hint for a text of a program, whose candidates are shown in quotes: ``did you mean "brick"?``."""
    near = near_names(name, candidates)
    return did_you_mean([f'"{other}"' for other in near])


def did_you_mean(near: Sequence[str]) -> str | None:
    """Return a hint that suggests the names in ``near``, or None if there are none."""
    return f"did you mean {' or '.join(f'`{other}`' for other in near)}?" if near else None


def rename_fixes(span: Span | None, name: str, near: Iterable[str]) -> tuple[Fix, ...]:
    """Return fixes that replace the misspelled ``name`` at ``span`` with each of the names in ``near``.

    A fix is safe if there is one name, and it differs by one letter: the program fails without it.
    """
    if span is None or span.expansion is not None or span.text != name:
        return ()
    names = tuple(near)
    is_sure = len(names) == 1 and len(name) >= _MIN_SURE_LETTERS and is_one_letter_off(name, names[0])
    is_sure = is_sure and name.endswith("!") == names[0].endswith("!")  # `reverse!` is not a misspelled `reverse`
    return tuple(Fix(f"Change to `{other}`", (Edit(span, other),), is_sure) for other in names)


_MIN_SURE_LETTERS = 5  # shorter names are one letter away from too many others


def is_one_letter_off(a: str, b: str) -> bool:
    """Return whether one letter is missing, added or different, or two neighboring ones are swapped.

    That is an edit distance of 1 (Damerau-Levenshtein): both names are compared from their first difference on.
    """
    start = next((i for i, (x, y) in enumerate(zip(a, b)) if x != y), min(len(a), len(b)))
    x, y = a[start:], b[start:]
    swapped = len(x) > 1 and len(y) > 1 and x[0] == y[1] and x[1] == y[0] and x[2:] == y[2:]
    return x[1:] == y or x == y[1:] or x[1:] == y[1:] or swapped


# --- rendering -------------------------------------------------------------------------------------------------

_STYLES = {
    "error": "\x1b[1;31m", "warning": "\x1b[1;33m", "note": "\x1b[1;36m", "place": "\x1b[36m", "hint": "\x1b[32m",
    "off": "\x1b[0m",
}  # fmt: skip
_TAB = "    "
_MAX_WIDTH = 160  # columns of an excerpt: about two lines of a terminal
_MAX_CHAIN_LINES = 8  # of a call stack: the four innermost and the four outermost calls
_MAX_EXPANSION_NOTES = 4  # levels of macros, the innermost first


def printable(text: str) -> str:
    """Escape control characters in ``text`` that a terminal would interpret; line breaks are preserved."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c == "\n" else _TAB if c == "\t" else f"\\x{ord(c):x};" for c in text)


def _place(span: Span) -> str:
    """Return a location as ``file:line:column``, which terminals and editors link."""
    line, column = span.source.position(span.start)
    return f"{printable(span.source.name)}:{line}:{column}"


def _excerpt(span: Span, marker: str) -> list[str]:
    """Return the source line and a line that underlines the span with ``marker``.

    A very long line is cut to a window around the span.
    """
    line_number, column = span.source.position(span.start)
    line = span.source.line(line_number)
    first = column - 1
    last = max(min(first + span.end - span.start, len(line)), first + 1)
    offset = max(0, first - _MAX_WIDTH // 2) if len(line) > _MAX_WIDTH else 0  # start of the window
    shown = line[offset : offset + _MAX_WIDTH]
    before = line[offset:first].replace("\t", _TAB)  # tabs are expanded everywhere, so that the marker lines up
    width = max(1, len(line[first : min(last, offset + _MAX_WIDTH)].replace("\t", _TAB)))
    shown = "".join(c if c.isprintable() else "�" for c in shown.replace("\t", _TAB))
    gutter = " " * len(str(line_number))
    return [f" {line_number} | {shown}", f" {gutter} | {' ' * len(before)}{marker * width}"]


def _expansion_notes(span: Span | None) -> list[Note]:
    """Return a note for each macro whose expansion made the code at ``span``, innermost first."""
    notes: list[Note] = []
    expansion = span.expansion if span else None
    while expansion is not None and len(notes) < _MAX_EXPANSION_NOTES:
        notes.append(Note(f"in the expansion of the macro `{expansion.macro}`", expansion.definition))
        expansion = expansion.outer
    return notes


def _chain_lines(chain: Sequence[tuple[str, Span | None]]) -> list[str]:
    """Render a call stack: consecutive calls of one function share a line, and a long stack lacks its middle."""
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
    if len(lines) > _MAX_CHAIN_LINES:
        half = _MAX_CHAIN_LINES // 2
        lines = [*lines[:half], f"   ... {len(lines) - 2 * half} more calls", *lines[-half:]]
    return lines


_MAX_PLACES = 5  # lines in a note


def also_in(lines: Iterable[int]) -> Note | None:
    """Return the note that lists the other lines in which a mistake occurs, or None if there are none."""
    others = sorted(set(lines))
    if not others:
        return None
    listed = ", ".join(map(str, others[:_MAX_PLACES])) + (" and others" if len(others) > _MAX_PLACES else "")
    return Note(f"also in line{'s' * (len(others) > 1)} {listed}")


def folded(diagnostics: Sequence[Diagnostic]) -> list[Diagnostic]:
    """Return diagnostics for people, in which a mistake that is made in several places is told once, with their lines.

    These are findings of one file with the same message and hint, or constructs of another language of one kind.
    """
    firsts: dict[tuple[str, str, str, str | None], int] = {}
    lines: dict[int, list[int]] = {}
    kept: list[Diagnostic] = []
    for d in diagnostics:
        if d.span is None or d.chain:
            kept.append(d)
            continue
        hint = None if d.name == "foreign-syntax" else d.hint
        number = firsts.setdefault((d.span.source.name, d.code, d.message, hint), len(kept))
        if number == len(kept):
            kept.append(d)
        else:
            lines.setdefault(number, []).append(d.span.source.position(d.span.start)[0])
    for number, places in lines.items():
        span = kept[number].span
        own = span.source.position(span.start)[0] if span is not None else 0
        note = also_in(line for line in places if line != own)
        if note is not None:
            kept[number] = replace(kept[number], notes=(*kept[number].notes, note))
    return kept


def render_text(diagnostic: Diagnostic, color: bool = False) -> str:
    """Render a diagnostic as text: code, message, location, underlined source line, hint, notes and call stack."""
    style = _STYLES if color else dict.fromkeys(_STYLES, "")
    severity = diagnostic.severity
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


# One mistake, such as a misspelled name in a large generated program, can cause thousands of findings.
_MAX_SHOWN = 100  # findings
_MAX_SHOWN_CHARACTERS = 64_000


def capped(diagnostics: Sequence[Diagnostic]) -> list[Diagnostic]:
    """Limit the number and total length of diagnostics.

    Errors take precedence over warnings; the order is preserved. If any are omitted, a final diagnostic counts them.
    """
    if len(diagnostics) <= _MAX_SHOWN and sum(map(_length, diagnostics)) <= _MAX_SHOWN_CHARACTERS:
        return list(diagnostics)
    selected: set[int] = set()
    left = _MAX_SHOWN_CHARACTERS
    for number in sorted(range(len(diagnostics)), key=lambda n: not diagnostics[n].is_error):
        left -= _length(diagnostics[number])
        if selected and (len(selected) >= _MAX_SHOWN or left < 0):
            break
        selected.add(number)
    shown = [diagnostics[number] for number in sorted(selected)]
    errors = sum(diagnostic.is_error for diagnostic in diagnostics) - sum(d.is_error for d in shown)
    more = len(diagnostics) - len(shown)
    return [*shown, Diagnostic("not-shown", f"{more:,} more findings are not shown, {errors:,} errors among them")]


def _length(diagnostic: Diagnostic) -> int:
    """Estimate the number of characters of a rendered diagnostic."""
    notes = sum(len(note.message) + _MAX_WIDTH for note in diagnostic.notes)
    return len(diagnostic.message) + len(diagnostic.hint or "") + 2 * _MAX_WIDTH + notes


def _json_place(span: Span | None) -> dict[str, Any] | None:
    """Return a location as JSON; lines and columns count from 1, and the end is exclusive."""
    if span is None:
        return None
    line, column = span.source.position(span.start)
    end_line, end_column = span.source.position(span.end)
    return {"file": span.source.name, "line": line, "column": column, "end_line": end_line, "end_column": end_column}


def to_json(diagnostic: Diagnostic) -> dict[str, Any]:
    """Return the diagnostic as JSON-serializable data, for ``--json``."""
    return {
        "code": diagnostic.code,
        "name": diagnostic.name,
        "severity": diagnostic.severity,
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
        "expected": diagnostic.expected,
        "found": diagnostic.found,
        "signature": diagnostic.signature,
        "near": list(diagnostic.near),
        "chain": [{"word": name, "place": _json_place(span)} for name, span in diagnostic.chain],
    }


# How to fix each diagnostic, by name: for the command `explain` and the reference of diagnostics.


_READING = {
    "unclosed": 'Add the missing `)`, `]`, `"` or `|#` at the end of the form that the message points at.',
    "extra-close": "Remove the extra closing character, replace it with the matching kind, or add the missing opening "
    "one.",
    "bad-atom": "Correct the number; put text in double quotes; index with `(ref xs 0)` instead of `xs[0]`.",
    "bad-string": "Write a literal backslash as `\\\\`, or use one of the escape sequences listed in the hint.",
    "bad-dot": "Write a pair as `(a . b)`, with exactly one element after the dot, and a decimal as `.5` or `0.5`.",
    "nesting": "Split the program into several definitions, or build deeply nested data with a loop.",
    "encoding": "Save the file as UTF-8 in your editor.",
}

_FORMS = {
    "foreign-syntax": "Write the form that the hint shows; `check --fix` does so where the change is mechanical.",
    "syntax": "Follow the syntax shown in the hint; `docs/reference/forms.md` has an example of each form.",
    "lambda-list": "Write each parameter as `name`, `(name default)`, `:name` or `(:name default)`, and the rest "
    "parameter last.",
    "misplaced": "Move the form to where it is allowed: `scene` and `param` to the top level, `else` into `cond`.",
    "reserved": "Choose another name.",
    "duplicate": "Rename or remove one of the two.",
    "absent": "Use the alternative named in the hint.",
    "macro": "Compare the patterns of the macro with its use; each pattern starts with the name of the macro.",
    "expansion": "Look for a macro that expands to itself, or an infinite loop in the body of a `define-macro`.",
    "bracket": "Use parentheses. `[...]` is only for arrays of numbers; write other lists as `(list ...)`.",
    "strict": "Use only what the paper's grammar allows, or check without `--strict`.",
    "empty-application": "Write `'()` or `(list)` for the empty list, and `(union)` for an empty shape.",
}

_NAMES = {
    "unbound": "Correct the spelling, define the name, or import the file that defines it.",
    "undefined-yet": "Move the definition before its first use, or use the name only inside a function called later.",
    "type-name": "Use a type listed in `docs/reference/types.md`, or the name of a record.",
    "no-root": 'Bind a word, for example `(bind "word" (lambda () (call "cube")))`.',
    "param": "Pass a value of the param's type, between its `:min` and `:max`, under the name used in the program.",
}

_RUNNING = {
    "type": "Pass a value of the type named in the message, or convert it first.",
    "arity": "Pass the number of arguments shown by the signature in the hint.",
    "not-a-procedure": "Put a function first in the parentheses, or remove the parentheses around a plain value. A "
    "builtin that a parameter shadows is still available as `std/name`.",
    "keyword": "Use the keyword arguments that the function declares, each once, and pass every one without a default.",
    "index": "Use an index from 0 to the length minus one, or a negative index that counts from the end.",
    "key": "Use an existing key, or pass a default: `(ref table key default)`.",
    "zero-division": "Check that the divisor is not 0, or bound it with `max`.",
    "domain": "Restrict the argument to the function's domain, for example with `clamp` or `max`.",
    "value": "Pass one of the values that the message allows.",
    "immutable": "Create a mutable copy with `(mutable-list ...)` or `(mutable-array ...)`, or build a new value.",
    "changed": "Collect the keys first with `(table-keys table)`, and iterate over that list.",
    "pattern": "Make the pattern as long as the sequence, or bind the remaining elements with `(a b . rest)`.",
    "assert": "Correct the asserted condition, or the values that make it false.",
    "user": "Read the message, which the program itself supplies, and the call it points at; catch it with `guard`.",
    "escape": "Call the escape procedure only inside the body of its `let/ec`.",
    "format": "Write one `{}` for each value, with a format specification that fits the value, such as `{:.2f}`.",
}

_LIMITS = {
    "steps": "Look for an infinite loop or recursion; otherwise raise `--max-steps`.",
    "depth": "Add a base case to the recursion, or use a loop; otherwise raise `--max-depth`.",
    "entities": "Let copies share one call with equal attributes; otherwise raise `--max-entities`.",
    "primitives": "Reduce the number of levels or copies, inspect the scene with `count` and `bounds`, which never "
    "expand it, or raise `--max-primitives`.",
    "size": "Look for a list, string or number that grows without bound; otherwise raise `--max-size`.",
    "memory": "Keep fewer values in memory at the same time; otherwise raise `--max-memory`.",
    "blocked": "Try it again on a machine that is less busy; the guard is 10 times `--max-seconds`, plus 60 seconds.",
    "time": "Look for an infinite loop or recursion; otherwise raise `--max-seconds`.",
    "crash": "If the system ran out of memory, lower `--max-memory`; otherwise please report it as a bug.",
    "interrupted": "Run the program again, with smaller numbers or lower limits if it takes too long.",
}

_SCENES = {
    "parts": "Return entities, the results of `transform`, or lists of these; return `(union)` for an empty shape.",
    "pose": "Build the matrix with `translate`, `rotate`, `scale`, `reflect` and `@` from finite numbers.",
    "attribute": "Pass a value of the type named in the message.",
    "declaration": "Move the object as the hint says, or correct the declaration.",
    "declaration-subject": "Name a word or handle that occurs in the entity that states the declaration.",
    "solid": "Use closed solids as operands: cubes, spheres and other primitives, closed mesh files, or other solids.",
    "embedding": "Pass an attribute by keyword, such as `:height 3`, or a text, a handle or `(embedding ...)`.",
    "frames": "Return `(frames list)` directly from the root, with at least one frame.",
    "root": "Name a word that the program binds, and make sure its function returns parts.",
    "empty-scene": 'Return at least one primitive, such as `(call "cube")`.',
    "endless": "Take a finite number of handles, for example `(list-head gamma n)`.",
    "word": 'Put the word in double quotes: `"park"`.',
    "blocks": "Transform blocks only with `translate` by whole numbers and `scale` by whole factors.",
}

_FILES = {
    "file": "Check the path and its permissions; relative paths start at the folder of the file that names them.",
    "import-cycle": "Move the definitions that both files need into a third file that imports neither.",
    "import-outside": "Move the file into the project folder, or pass `--allow-outside`.",
    "z-file": "Regenerate the file with `scenelang embeddings`, or remove it.",
    "backend": "Use a file extension or backend listed by `scenelang backends`, and install what the hint names.",
    "physics": "Give another `--metres-per-unit`, or other masses and densities.",
    "unsupported": "Reduce the scene to a supported size, or use another backend (`scenelang backends`).",
    "weights": "Run once while online to download the weights, or pass the folder that contains them with "
    "`--models-dir DIR`.",
}

_PYTHON = {
    "openscad-syntax": "Correct the OpenSCAD program: the message says what was expected at this place.",
    "openscad-unsupported": "Write this part in another way, as the hint says, or by hand in the converted program.",
    "blender-unsupported": "Write this part with meshes, modifiers and transforms, or leave it out of the script.",
    "python-syntax": "Correct the Python code at the indicated place, or request a new program from the model.",
    "python-forbidden": "Remove it: a scene program may only compute shapes and numbers and draw random numbers.",
    "python-unsupported": "Rewrite it with plain functions, loops and lists; `docs/transpiler.md` lists the "
    "supported Python.",
    "python-name": "Correct the spelling, or define the name before its first use.",
    "python-call": "Pass the arguments that the function's signature requires.",
    "python-exception": "Correct the Python at the marked place; CPython would fail there, too.",
}

_MODELS = {
    "model-key": "Set the API key in the environment or in the configuration file, which only you may be able to read.",
    "model-offline": "Check the network connection and the base URL; `--dry-run` works offline.",
    "model-request": "Read the API's message. If the API is overloaded, wait and continue with `--resume`.",
    "model-cost": "Raise `--max-cost`, or lower `--max-tokens`, `-n` or `--critique`.",
    "model-price": "Pass `--price INPUT,OUTPUT`, add the price to the configuration file, or use a known model.",
    "model-refusal": "Rephrase the task.",
    "model-answer": "Allow more attempts with `--repair`, raise `--effort`, use another model, or simplify the task.",
    "listing": "Retry the request; each item must have `shape`, `attributes` and `pose`.",
    "prompt": "Correct the placeholder, or remove the file so that the built-in template is used.",
    "dataset": "Correct the spec at the place shown. `--resume` makes damaged files of a dataset again.",
    "sample": "Make the sample alone with `scenelang dataset sample SPEC KEY`, or loosen the filters of the spec.",
    "run": "Use a run that `scenelang runs` lists with another state than `damaged`, and wait until no other process is"
    " using it.",
}

_WARNINGS = {
    "conditional-failure": "Correct the expression as the message says, or remove the branch if it is never needed.",
    "out-of-range": "Use the unit and range of the hint: radians for angles, 0 to 1 for colors and shares.",
    "dropped-value": "Put everything that belongs to the scene into one `(union ...)`, which the body returns.",
    "unreachable-code": "Remove the code, or move it before the call that never returns.",
    "unused-value": "Write a field `{}` for each value, as in Python.",
    "elementwise-poses": "Compose poses with `(@ a b)`: the last one is applied first.",
    "plain-parameter": "Make it a keyword parameter of the word's function: `(lambda (:height) ...)`.",
    "endless-recursion": "Put the call into a branch, such as `(if (> n 0) (f (- n 1)) ...)`.",
    "undefined-word": "Move the `bind` before the call, or call the word inside a function.",
    "shadowed-macro": "Choose another name, or refer to the paper's macro by its full name, such as `std/union`.",
    "bound-twice": "Remove one of the two bindings, or rename one of the words.",
    "ambiguous-root": 'Name the root word with `(scene "word")` or `--root WORD`.',
    "optional-embedding": "Make it a keyword parameter, `(:height 2)`, and pass `:height` in the `call`.",
    "unused": "Remove it, use it, or start its name with `_`.",
    "shadowed-builtin": "Rename the parameter or local variable, or call the builtin as `std/name`.",
    "unreachable-word": "Call the word somewhere, remove its `bind`, or choose another root.",
    "constant-condition": "Test something that can vary, or keep only the branch that is taken.",
    "turned-after-moved": "Rotate first, then translate: `(@ (translate v) (rotate a axis))`. Or pass `rotate` the "
    "center of rotation.",
    "empty-box": "Measure a shape that contains at least one primitive.",
    "no-extent": "Give the primitive a non-zero size, or two different end points.",
    "unused-entry": "List the handles with `scenelang tree`, then rename or remove the entry with `scenelang "
    "embeddings`.",
    "embedding-only": "Remove the side effects from the called function, or set the attribute in the program.",
    "near-word": "Correct the spelling, or ignore the warning if the word is intended.",
    "idle-attribute": "Correct the spelling, or remove the attribute.",
    "set-order": "Use a list where the order matters; in Python, iterate over `sorted(names)`.",
    "overlap": "Move one of the parts, or remove the duplicate; allow it with `; lint: allow overlap` if intended.",
    "floating": "Place it with `on-top-of`, `align` or `attach`, or allow it with `; lint: allow floating`.",
    "unstable": "Move it over its support, or attach it; allow it with `; lint: allow unstable` if it is fixed there.",
    "below-ground": "Raise it by the depth below 0, which `compute-shape-min` returns.",
    "outlier": "Place it as its siblings are, or allow it with `; lint: allow outlier` if it is meant.",
    "outlier-note": "Place it as its siblings are, if it is not meant.",
    "overlap-note": "Move one of the objects, if it is not meant.",
    "floating-note": "Give it `:floating #t` if it flies, or place it on something.",
    "unstable-note": "Give it `:fixed #t`, or put `:body #t` around it and what holds it.",
    "below-ground-note": "Raise it, if it is not planted there.",
    "coincident-faces-note": "Move one of the faces by a thousandth.",
    "coincident-faces": "Move one of the faces by a thousandth, or make one of the parts slightly smaller.",
    "body-moves": "Level what carries it, raise its `:friction`, or fix it with the attribute `:fixed #t`.",
    "body-note": "Give it `:floating #t` or `:fixed #t`, or move it over its support.",
    "body-tips": "Move it over its support, widen the support, or fix it with `:fixed #t`.",
    "body-falls": "Put it on something, join it to what holds it with `:body #t` around both, or fix it.",
    "body-explodes": "Move the overlapping parts apart, or make them one body with `:body #t`.",
    "not-simulated": "Semantic primitives take part with `:body #t`; of a 4D scene, the first frame is simulated.",
    "geometry-limit": "Check a part of the scene separately with `--root WORD`.",
    "unknown-block": "Use the block named in the message, or another block of the game.",
    "block-property": "Use one of the properties or values listed in the message, or omit the property to use its "
    "default.",
    "off-cells": "Translate blocks by whole numbers, including the distances and gaps passed to combinators.",
    "no-block": "Create blocks with `set-cuboid`, or voxelize the scene with `export --voxelize`.",
    "single-precision": "Move the scene to the origin, or write a format with offsets or double precision.",
    "crossing-profile": "Give the corners in order, or say what is inside with `:fill :nonzero` or `:fill :even-odd`.",
    "crowded-edge": "Let the bodies overlap a little, or leave a gap between them; repairs of such edges differ.",
    "lost-attribute": "Export to Blender (`--to bpy`) or to .glb, which have these attributes.",
    "large-file": "Write a format that shares repeated parts, such as .glb, or use fewer :segments.",
    "too-new": "Set a newer version with `--mc-version`, or use a block that the older version has.",
    "lost-contents": "No action is required; fill chests and write signs in the game.",
    "plain-look": "Pass the complete assets of the game with `--textures`; a resource pack may contain only some of "
    "them.",
    "not-shown": "Fix the findings that are shown first; one mistake often causes several of them.",
    "crowded-layout": "Group whole entities with `--depth N` or `--entity NAME`, or move the camera closer with "
    "`--camera`.",
    "unread-vectors": "Choose a model with the text encoder that the embeddings were learned for: `--model NAME`.",
    "unknown-function": "Register a function of that name, or correct the name.",
    "fixed-parameter": "Write what computes the data with plain functions, loops and lists, so that it stays in the "
    "program.",
    "fixed-draws": "Write the decision with plain functions, loops and lists, so that it stays in the program.",
    "ignored-block": "Put the whole program in one code block.",
    "python-ignored": "No action is required; set the random seed with `--seed N`.",
    "draw-order": "Compare the result with the original; draw random numbers in only one place if the order matters.",
    "openscad-ignored": "Look whether the converted program needs the part; the limits in `docs/from-openscad.md` list "
    "the parts that are left out.",
    "blender-ignored": "Look whether the scene needs the part; the limits in `docs/from-blender.md` list the parts "
    "that are left out.",
    "print-limit": "Print less, or run with `--quiet`.",
}

REMEDIES: Mapping[str, str] = {
    **_READING, **_FORMS, **_NAMES, **_RUNNING, **_LIMITS, **_SCENES, **_FILES, **_PYTHON, **_MODELS, **_WARNINGS
}  # fmt: skip


def diagnostic_named(query: str) -> str | None:
    """Return the name of the diagnostic with the given code or name (ignoring case), or None if it does not exist."""
    by_code = {entry.code: name for name, entry in CODES.items()}
    name = by_code.get(query.upper(), query.lower())
    return name if name in CODES else None


_MAX_SHOWN_QUERY = 80  # characters of an unknown code or name in the message


def require_diagnostic(query: str) -> str:
    """Return the name of the diagnostic with the given code or name; raise ``UsageError`` if it does not exist."""
    name = diagnostic_named(query)
    if name is None:
        choices = [*(entry.code for entry in CODES.values()), *CODES]
        hint = suggest(query, choices) or "`scenelang explain` lists all codes"
        raise UsageError("value", f"unknown diagnostic code or name `{query[:_MAX_SHOWN_QUERY]}`", hint)
    return name


def explanation_data(name: str) -> dict[str, str]:
    """Return the explanation of a diagnostic as JSON-serializable data."""
    return {"code": CODES[name].code, "name": name, "why": CODES[name].why, "remedy": REMEDIES[name]}


def explanation(name: str) -> tuple[str, str, str]:
    """Return the explanation of a diagnostic as lines of text: code and name, cause, how to fix it."""
    return f"{CODES[name].code} {name}", f"  {CODES[name].why}", f"  {REMEDIES[name]}"


def by_code() -> list[str]:
    """Return the names of all diagnostics, sorted by code."""
    return sorted(CODES, key=lambda name: CODES[name].code)


def explained(names: Sequence[str]) -> str:
    """Return the explanations of the named diagnostics as text, or a summary of all of them if none is named."""
    if not names:
        return "\n".join(f"{CODES[name].code} {name}: {CODES[name].why}" for name in by_code())
    return "\n\n".join("\n".join(explanation(name)) for name in names)


# Diagnostics of a text that has been moved.


def moved_span(span: Span, move: Callable[[Span], tuple[Source, int]]) -> Span:
    """Convert a span, and those of the expansion that it comes from.

    ``move`` returns the source of the converted span and the number of characters by which it is shifted.
    """
    expansion = span.expansion
    if expansion is not None:
        definition = expansion.definition
        outer = Span(span.source, span.start, span.end, expansion.outer)
        moved = None if definition is None else moved_span(definition, move)
        expansion = Expansion(expansion.macro, moved, moved_span(outer, move).expansion)
    source, offset = move(span)
    return Span(source, span.start + offset, span.end + offset, expansion)


def moved_diagnostic(diagnostic: Diagnostic, place: Callable[[Span], Span]) -> Diagnostic:
    """Return a diagnostic with all its spans (notes, call stack, fixes) converted by ``place``."""
    if diagnostic.span is None and not diagnostic.notes:
        return diagnostic
    notes = tuple(Note(note.message, note.span and place(note.span)) for note in diagnostic.notes)
    chain = tuple((name, span and place(span)) for name, span in diagnostic.chain)
    fixes = tuple(
        replace(fix, edits=tuple(replace(edit, span=place(edit.span)) for edit in fix.edits))
        for fix in diagnostic.fixes
    )
    span = diagnostic.span and place(diagnostic.span)
    return replace(diagnostic, span=span, notes=notes, chain=chain, fixes=fixes)

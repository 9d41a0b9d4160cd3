"""Complete examination of a program for ``check --json``: fixes of findings about the scene, and the errors that other
errors hide.

A program or a language model that reads the report can then repair everything in one turn. People read one mistake
after another, so text output does without.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

from scenelang.grammar.datum import (
    Atom,
    Keyword,
    ListDatum,
    Source,
    Span,
    TextEdit,
    dataclass,
    replace,
    walk,
    with_edits,
)
from scenelang.grammar.diagnostics import ABOUT_SCENES, Diagnostic, Edit, Fix, SceneError
from scenelang.grammar.reader import read_pieces
from scenelang.interpreter.checker.lint import with_fixes
from scenelang.interpreter.plugins import SERVICES
from scenelang.interpreter.scene.entity import descendants
from scenelang.session.session import Session, is_python, linted

if TYPE_CHECKING:
    from scenelang.interpreter.scene.declarations import Declaration
    from scenelang.interpreter.scene.entity import Scene

_MAX_CHECKS_OF_FIXES = 3  # of a text with its fixes: errors that others hide may hide further ones
_MAX_SHOWN_LENGTH = 30  # characters of a value in a hint
# Findings that an error often causes. They are not reported for a text with fixes.
_CONSEQUENCES = frozenset(("unused", "unreachable-word", "unreachable-code", "constant-condition", "ambiguous-root"))


@dataclass(frozen=True, eq=False)
class Examined:
    """Diagnostics, the scene if it was evaluated, and the entity or mesh that an error is about, for an image of it."""

    diagnostics: Sequence[Diagnostic]
    scene: Scene | None = None
    subject: Any = None


@dataclass(frozen=True, eq=False)
class Examination:
    """Checks to run on a program.

    Attributes
    ----------
    run
        Evaluate it, and test its declarations.
    geometry
        Run the geometry lint on its scene.
    physics
        Simulate it: duration in seconds (None for the default), and meters per scene unit.
    stated
        Declarations besides those of the program.
    complete
        Add fixes of findings about the scene, and errors that others hide.
    """

    session: Session
    run: bool = False
    geometry: bool = False
    physics: tuple[float | None, float] | None = None
    stated: Sequence[Declaration] = ()
    complete: bool = False

    def of(self, source: Source, prepare: Callable[[Scene], None] = lambda scene: None) -> Examined:
        """Examine a program; ``prepare`` is called with its scene before that is examined."""
        examined = self._once(source, prepare)
        if not self.complete or is_python(source):
            return examined
        diagnostics_of = lambda fixed: self._once(fixed, prepare).diagnostics
        return replace(examined, diagnostics=with_hidden(source, examined.diagnostics, diagnostics_of))

    def _once(self, source: Source, prepare: Callable[[Scene], None]) -> Examined:
        """Examine a text as it is. Fixes are tested where the program has no scene, else edits that repair its scene.

        Findings about the scene wait for all others, because another mistake may be what moved an object.
        """
        if not (self.run or self.geometry or self.physics or self.stated):
            return Examined(explained(self.session, source, self.session.check(source).diagnostics))
        result = self.session.evaluate(source)
        if result.scene is None:
            diagnostics = explained(self.session, source, result.diagnostics)
            if self.complete and not is_python(source):
                with_tested = SERVICES.optional("tested-fixes")
                if with_tested is not None:
                    diagnostics = with_tested(source, diagnostics, self.session.evaluate)
            return Examined(diagnostics, None, result.subject)
        try:
            if result.scene is not None:
                prepare(result.scene)
            diagnostics = [*result.diagnostics, *linted(result, *self._lints())]
        except SceneError as error:
            return Examined([*result.diagnostics, error.diagnostic], result.scene, error.subject)
        if self.complete and result.scene is not None and not is_python(source) and not _changes(source, diagnostics):
            with_repairs = SERVICES.optional("scene-fixes")
            if with_repairs is not None:
                diagnostics = with_repairs(self.session, source, diagnostics, self.stated, geometry=self.geometry)
        return Examined(diagnostics, result.scene, result.subject)

    def _lints(self) -> Iterator[Callable[[Scene], list[Diagnostic]]]:
        """Yield the checks of the scene that are asked for."""
        if self.stated or self.run:
            yield lambda scene: declaration_errors(scene, self.stated)
        if self.geometry:
            yield SERVICES.find("geometry")
        if self.physics is not None:
            physics = SERVICES.find("physics")
            seconds, meters_per_unit = self.physics
            yield lambda scene: physics.check_physics(scene, seconds or physics.SECONDS, meters_per_unit)


def explained(session: Session, source: Source, diagnostics: Sequence[Diagnostic]) -> Sequence[Diagnostic]:
    """Return the diagnostics of a check or a run as people read them: with what a trial of other texts shows.

    Brackets that do not match, or close in the wrong place, are found by the texts in which they do.
    """
    if is_python(source) or not any(d.is_error for d in diagnostics):
        return diagnostics
    diagnostics = [with_fixes(d) for d in session.recovered(source, diagnostics)]
    return _with_sound_hints(session, source, session.rebracketed(source, with_options(source, diagnostics)))


_MAX_VERIFIED = 4  # errors whose hints are tried


def _with_sound_hints(session: Session, source: Source, diagnostics: Sequence[Diagnostic]) -> Sequence[Diagnostic]:
    """Return diagnostics without the hints whose code leads to another error in its place."""
    known = {(d.name, d.message) for d in diagnostics}
    errors = [d for d in diagnostics if d.is_error and d.fixes and d.span is not None and d.hint and "`" in d.hint]
    unsound: set[int] = set()
    for error in errors[:_MAX_VERIFIED]:
        edits = error.fixes[0].edits
        if error.code.startswith("E1") or any(e.span.source.name != source.name or e.span.expansion for e in edits):
            continue
        trial = Source(source.name, with_edits(source.text, error.fixes[0].text_edits))
        start = min(edit.span.start for edit in edits)
        end = max(edit.span.end for edit in edits) + sum(len(edit.text) for edit in edits)
        for d in session.check(trial).diagnostics:
            is_near = d.span is not None and d.span.start < end and start < d.span.end
            if d.is_error and is_near and (d.name, d.message) not in known:
                unsound.add(id(error))
    return [replace(d, hint=None, fixes=()) if id(d) in unsound else d for d in diagnostics]


def declaration_errors(scene: Scene, stated: Sequence[Declaration] = ()) -> list[Diagnostic]:
    """Return an error for each declaration of a scene, or in ``stated``, that does not hold.

    Only a scene with declarations needs the geometry checks; raises SceneError if this installation lacks them.
    """
    if not stated and not scene.declarations and not any(e.declarations for e in descendants(*scene.frames)):
        return []
    errors: list[Diagnostic] = SERVICES.find("declarations")(scene, stated)
    return errors


def with_options(source: Source, diagnostics: Sequence[Diagnostic]) -> Sequence[Diagnostic]:
    """Return diagnostics in which an unbound name that may be a keyword without its colon has a fix.

    The keyword is one of the function that is called, or one that the program uses elsewhere.
    """
    diagnostics = with_parameters(source, diagnostics)
    unbound = {d.span.start: d for d in diagnostics if d.name == "unbound" and d.span is not None}
    if not unbound:
        return diagnostics
    explained: dict[int, Diagnostic] = {}
    for form in walk(*read_pieces(source).forms):
        if not isinstance(form, ListDatum) or not form.items:
            continue
        for before, item, value in zip(form.items, form.items[1:], form.items[2:]):
            if isinstance(before, Atom) and type(before.value) is Keyword:
                continue  # the item is the value of a keyword
            d = unbound.get(item.span.start)
            if d is None or d.fixes or not isinstance(item, Atom):
                continue
            if _is_option(source, form.items[0].span.text, str(item.value)):
                written = f":{item.value}"
                fix = Fix(f"Change to `{written}`", (Edit(item.span, written),))
                hint = f"a keyword has a colon: `{written} {value.span.text[:_MAX_SHOWN_LENGTH]}`"
                explained[id(d)] = replace(d, hint=hint, fixes=(fix,), near=(written,))
    return [explained.get(id(d), d) for d in diagnostics]


def with_parameters(source: Source, diagnostics: Sequence[Diagnostic]) -> Sequence[Diagnostic]:
    """Return diagnostics in which the fix for ``(bind "word" PARTS)``, which lacks a function, also adds parameters.

    The parameters are the keywords that occur both in calls of the word and in its parts; errors about these names,
    which the fix corrects as well, are left out.
    """
    changed: dict[int, Diagnostic | None] = {}
    for d in diagnostics:
        edit = d.fixes[0].edits[0] if d.fixes and d.name == "type" and d.message.startswith("`bind` expects") else None
        if edit is None or not edit.text.startswith("(lambda () "):
            continue
        body = edit.span
        names = _passed(source, d.message, body.text)
        if names:
            head = f"(lambda ({' '.join(f':{name}' for name in names)})"
            fix = Fix(d.fixes[0].title, (Edit(body, head + edit.text.removeprefix("(lambda ()")),))
            changed[id(d)] = replace(d, fixes=(fix,), hint=f"wrap it in a function: `{head} ...)`")
            inside = (o for o in diagnostics if o.span is not None and body.start <= o.span.start < body.end)
            changed |= {id(o): None for o in inside if _is_about(o, names)}
    if not changed:
        return diagnostics
    remaining = (changed.get(id(d), d) for d in diagnostics)
    return [d for d in remaining if d is not None]


def _is_about(diagnostic: Diagnostic, names: Sequence[str]) -> bool:
    """Return whether a diagnostic is about a name that lacks a parameter: unbound, or a function of the language."""
    text = diagnostic.span.text if diagnostic.span is not None else ""
    builtin = re.search(r"got a Function: (\S+)\Z", diagnostic.message)
    return (diagnostic.name == "unbound" and text in names) or (builtin is not None and builtin[1] in names)


def _passed(source: Source, message: str, body: str) -> list[str]:
    """Return the keywords that calls of the word in a message pass, and that ``body`` reads as variables."""
    word = re.search(r'for ("[^"]+"),', message)
    calls = [
        form
        for form in walk(*read_pieces(source).forms)
        if isinstance(form, ListDatum)
        and len(form.items) > 2
        and form.items[0].span.text == "call"
        and word is not None
        and form.items[1].span.text == word[1]
    ]
    names = [str(i.value) for call in calls for i in call.items[2:] if isinstance(i, Atom) and type(i.value) is Keyword]
    return [name for name in dict.fromkeys(names) if re.search(rf"(?<=[\s\[]){re.escape(name)}(?=[\s\])])", body)]


@cache
def _attributes() -> frozenset[str]:
    """Return the names of all attributes that primitives read."""
    from scenelang.interpreter.scene.primitives import (
        COLOR,
        MATERIALS,
        PHYSICS,
        SCALE,
        geometry_attributes,
        solid_words,
    )

    geometry = {name for word in solid_words() for name in geometry_attributes(word) or ()}
    return frozenset(attribute.name for attribute in (SCALE, COLOR, *MATERIALS, *PHYSICS)) | geometry


def _is_option(source: Source, head: str, name: str) -> bool:
    """Return whether a name is a keyword of ``head``, or of any function if the program defines ``head``."""
    from scenelang.stdlib.reference import records

    if head in ("call", "embedding", "primitive") and name in _attributes():
        return True

    keyword = re.compile(rf"(?<![^\s(\[])[:&]{re.escape(name)}(?![^\s)\]:])")
    signature = next((record.signature for record in records() if record.name == head), None)
    return keyword.search(source.text if signature is None else signature) is not None


def with_hidden(
    source: Source, diagnostics: Sequence[Diagnostic], check: Callable[[Source], Sequence[Diagnostic]]
) -> list[Diagnostic]:
    """Return diagnostics together with those that errors hide.

    Hidden ones are what ``check`` reports for the text with the first fix of each error. Their positions are mapped
    back to the original text; those inside a fix are left out.
    """
    by_key = {_key(d): d for d in diagnostics}
    changes: list[TextEdit] = []
    for _ in range(_MAX_CHECKS_OF_FIXES):
        before, changes = changes, _changes(source, by_key.values())
        if changes == before:
            break
        fixed = _Fixed(source, changes)
        for d in map(fixed.original, check(fixed.source)):
            if d is None or d.name in _CONSEQUENCES:
                continue
            if d.name in ("unclosed", "extra-close"):  # all of them are known: a fix may close at another place
                continue
            known = by_key.get(_key(d))
            if known is None and any(_is_requoted(d, other, changes) for other in diagnostics):
                continue
            if known is None or (d.fixes and not known.fixes):
                by_key[_key(d)] = d
    return list(by_key.values())


def _is_requoted(diagnostic: Diagnostic, other: Diagnostic, changes: Iterable[TextEdit]) -> bool:
    """Return whether a diagnostic of a changed text is another one, whose message quotes code that was changed."""
    if diagnostic.span is None or other.span is None or diagnostic.name != other.name:
        return False
    span = other.span
    return diagnostic.span.start == span.start and any(span.start <= e.start and e.end <= span.end for e in changes)


def _key(diagnostic: Diagnostic) -> tuple[str, int, str]:
    """Return the identity of a diagnostic: name, position and message."""
    return diagnostic.name, diagnostic.span.start if diagnostic.span is not None else -1, diagnostic.message


def _changes(source: Source, diagnostics: Iterable[Diagnostic]) -> list[TextEdit]:
    """Return the edits of the first fixes of errors and warnings, in order, without those that overlap earlier ones.

    Findings about the scene are left out: another mistake may be what moved an object.
    """
    chosen: list[TextEdit] = []
    for diagnostic in sorted(diagnostics, key=lambda d: not d.is_error):
        if not diagnostic.fixes or diagnostic.name in _CONSEQUENCES or diagnostic.name in ABOUT_SCENES:
            continue
        edits = diagnostic.fixes[0].edits
        if any(edit.span.source.name != source.name or edit.span.expansion is not None for edit in edits):
            continue
        changes = diagnostic.fixes[0].text_edits
        if not any(change.overlaps(other) for change in changes for other in chosen):
            chosen += changes
    return sorted(chosen)


class _Fixed:
    """A text with changes, which maps positions back to the original text."""

    def __init__(self, written: Source, changes: Sequence[TextEdit]) -> None:
        self.written, self.changes = written, changes
        self.source = Source(written.name, with_edits(written.text, changes))

    def _offset(self, offset: int) -> int | None:
        """Return the original offset of an offset in the changed text; None inside a change."""
        shift = 0
        for start, end, text in self.changes:
            new = start + shift
            if offset <= new:
                break
            if offset < new + len(text):
                return None
            shift += len(text) - (end - start)
        return offset - shift

    def _span(self, span: Span) -> Span | None:
        """Return the original span of a span of the changed text; None if an end is inside a change."""
        start, end = self._offset(span.start), self._offset(span.end)
        if start is None or end is None or end < start:
            return None
        expansion = span.expansion
        if expansion is not None and expansion.definition is not None:
            is_here = expansion.definition.source.name == self.written.name
            expansion = expansion._replace(definition=self._span(expansion.definition)) if is_here else expansion
        return Span(self.written, start, end, expansion)

    def original(self, diagnostic: Diagnostic) -> Diagnostic | None:
        """Map a diagnostic of the changed text to the original; None if it is about a change or another file."""
        span = diagnostic.span
        if span is None or span.source.name != self.written.name:
            return None
        place = self._span(span)
        if place is None or any(c.text and c.start <= place.start and place.end <= c.end for c in self.changes):
            return None
        fixes = tuple(fix for fix in map(self._fix, diagnostic.fixes) if fix is not None)
        return replace(diagnostic, span=place, notes=(), chain=(), fixes=fixes)

    def _fix(self, fix: Fix) -> Fix | None:
        """Map a fix to the original text; None if it edits a change or another file."""
        edits = []
        for edit in fix.edits:
            place = self._span(edit.span) if edit.span.source.name == self.written.name else None
            if place is None or any(change.overlaps(TextEdit(place.start, place.end, "")) for change in self.changes):
                return None
            edits.append(Edit(place, edit.text))
        return replace(fix, edits=tuple(edits))

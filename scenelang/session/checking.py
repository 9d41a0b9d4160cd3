"""What ``check --json`` says about a program besides its findings: fixes for those about the scene, and what is behind
errors that it can fix, so that a program or a language model that reads it can repair all in one turn."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

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
from scenelang.session.session import Session, is_python, linted

if TYPE_CHECKING:
    from scenelang.interpreter.scene.declarations import Declaration
    from scenelang.interpreter.scene.entity import Scene

_ROUNDS = 3  # errors that others hide may hide further ones
_CONSEQUENCES = frozenset(("unused", "unreachable-word", "unreachable-code", "constant-condition", "ambiguous-root"))


class Examined(NamedTuple):
    """What was found, the scene if it was evaluated, and what an error is about that a picture can show."""

    diagnostics: Sequence[Diagnostic]
    scene: Scene | None = None
    subject: Any = None


@dataclass(frozen=True, eq=False)
class Examination:
    """What is asked of a program.

    Attributes
    ----------
    run, geometry, physics
        Whether it is evaluated and its declarations are tested, its geometry is examined, and it is simulated: for how
        many seconds (None: the default), and at how many metres per unit.
    stated
        Declarations besides those of the program.
    complete
        Whether findings about the scene get fixes, and what is behind errors is looked for.
    """

    session: Session
    run: bool = False
    geometry: bool = False
    physics: tuple[float | None, float] | None = None
    stated: Sequence[Declaration] = ()
    complete: bool = False

    def of(self, source: Source, prepare: Callable[[Scene], None] = lambda scene: None) -> Examined:
        """Examine a program; ``prepare`` is called with its scene before that is examined."""
        found = self._once(source, prepare)
        if not self.complete or is_python(source):
            return found
        return found._replace(
            diagnostics=with_hidden(source, found.diagnostics, lambda fixed: self._once(fixed, prepare).diagnostics)
        )

    def _once(self, source: Source, prepare: Callable[[Scene], None]) -> Examined:
        if not (self.run or self.geometry or self.physics or self.stated):
            found = self.session.recovered(source, self.session.check(source).diagnostics)
            return Examined(with_options(source, found))
        result = self.session.evaluate(source)
        if result.scene is None:
            found = [with_fixes(d) for d in self.session.recovered(source, result.diagnostics)]
            found = with_options(source, found)
            if self.complete and not is_python(source):
                with_tested = SERVICES.get("tested-fixes")
                found = found if with_tested is None else with_tested(source, found, self.session.evaluate)
            return Examined(found, None, result.subject)
        try:
            if result.scene is not None:
                prepare(result.scene)
            found = [*result.diagnostics, *linted(result, *self._lints())]
        except SceneError as error:
            return Examined([*result.diagnostics, error.diagnostic], result.scene, error.subject)
        if self.complete and result.scene is not None and not is_python(source) and not _changes(source, found):
            with_repairs = SERVICES.get("scene-fixes")
            if with_repairs is not None:
                found = with_repairs(self.session, source, found, self.stated, geometry=self.geometry)
        return Examined(found, result.scene, result.subject)

    def _lints(self) -> Iterator[Callable[[Scene], list[Diagnostic]]]:
        if self.stated or self.run:
            check_declarations = SERVICES.find("declarations")
            yield lambda scene: check_declarations(scene, self.stated)
        if self.geometry:
            yield SERVICES.find("geometry")
        if self.physics is not None:
            physics = SERVICES.find("physics")
            seconds, metres = self.physics
            yield lambda scene: physics.check_physics(scene, seconds or physics.SECONDS, metres)


def with_options(source: Source, found: Sequence[Diagnostic]) -> Sequence[Diagnostic]:
    """Return findings where a name that is not defined may be a keyword without its colon: one of the function that
    is called, or one that the program writes elsewhere."""
    found = with_parameters(source, found)
    unbound = {d.span.start: d for d in found if d.name == "unbound" and d.span is not None}
    if not unbound:
        return found
    explained: dict[int, Diagnostic] = {}
    for form in walk(*read_pieces(source).forms):
        if not isinstance(form, ListDatum) or not form.items:
            continue
        for before, item, value in zip(form.items, form.items[1:], form.items[2:]):
            if isinstance(before, Atom) and type(before.value) is Keyword:
                continue  # its value
            d = unbound.get(item.span.start)
            if (
                d is not None
                and isinstance(item, Atom)
                and _is_option(source, form.items[0].span.text, str(item.value))
            ):
                written = f":{item.value}"
                fix = Fix(f"Change to `{written}`", (Edit(item.span, written),))
                hint = f"a keyword has a colon: `{written} {value.span.text[:_SHOWN]}`"
                explained[id(d)] = replace(d, hint=hint, fixes=(fix,), near=(written,))
    return [explained.get(id(d), d) for d in found]


def with_parameters(source: Source, found: Sequence[Diagnostic]) -> Sequence[Diagnostic]:
    """Return findings where a word is bound to parts without a function: it gets the parameters that its calls pass and
    that its parts read, whose names are then defined."""
    changed: dict[int, Diagnostic | None] = {}
    for d in found:
        edit = d.fixes[0].edits[0] if d.fixes and d.name == "type" and d.message.startswith("`bind` expects") else None
        if edit is None or not edit.text.startswith("(lambda () "):
            continue
        body = edit.span
        names = _passed(source, d.message, body.text)
        if names:
            head = f"(lambda ({' '.join(f':{name}' for name in names)})"
            fix = Fix(d.fixes[0].title, (Edit(body, head + edit.text.removeprefix("(lambda ()")),))
            changed[id(d)] = replace(d, fixes=(fix,), hint=f"wrap it in a function: `{head} ...)`")
            inside = (o for o in found if o.span is not None and body.start <= o.span.start < body.end)
            changed |= {id(o): None for o in inside if _is_about(o, names)}
    if not changed:
        return found
    return [kept for each in found if (kept := changed.get(id(each), each)) is not None]


def _is_about(diagnostic: Diagnostic, names: Sequence[str]) -> bool:
    """Return whether a finding is about a name that has no parameter yet: undefined, or a function of the language."""
    text = diagnostic.span.text if diagnostic.span is not None else ""
    builtin = re.search(r"got a Function: (\S+)\Z", diagnostic.message)
    return (diagnostic.name == "unbound" and text in names) or (builtin is not None and builtin[1] in names)


def _passed(source: Source, message: str, body: str) -> list[str]:
    """Return the keywords that the program passes to the word of a message, and that a text reads as variables."""
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
    """Return the attributes that primitives read."""
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
    from scenelang.stdlib.reference import records

    if head in ("call", "embedding", "primitive") and name in _attributes():
        return True

    keyword = re.compile(rf"(?<![^\s(\[])[:&]{re.escape(name)}(?![^\s)\]:])")
    signature = next((record.signature for record in records() if record.name == head), "")
    return keyword.search(signature) is not None or keyword.search(source.text) is not None


_SHOWN = 30


def with_hidden(
    source: Source, found: Sequence[Diagnostic], check: Callable[[Source], Sequence[Diagnostic]]
) -> list[Diagnostic]:
    """Return findings with those that mistakes hide: what ``check`` finds in the text with the first fix of each.

    Their places are those in the text as it was written. What is about a fix itself is left out.
    """
    every = {_key(d): d for d in found}
    changes: list[TextEdit] = []
    for _ in range(_ROUNDS):
        before, changes = changes, _changes(source, every.values())
        if changes == before:
            break
        fixed = _Fixed(source, changes)
        for d in map(fixed.original, check(fixed.source)):
            if d is None or d.name in _CONSEQUENCES:
                continue
            known = every.get(_key(d))
            if known is None or (d.fixes and not known.fixes):
                every[_key(d)] = d
    return list(every.values())


def _key(diagnostic: Diagnostic) -> tuple[str, int, str]:
    return diagnostic.name, diagnostic.span.start if diagnostic.span is not None else -1, diagnostic.message


def _changes(source: Source, found: Iterable[Diagnostic]) -> list[TextEdit]:
    """Return the edits of the first fixes of mistakes in the text, without those that overlap earlier ones, in order.

    Findings about the scene wait: another mistake may be why a thing is where it is.
    """
    chosen: list[TextEdit] = []
    for diagnostic in sorted(found, key=lambda d: not d.is_error):
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
    """A text with changes, and the way back to the places of the text as it was written."""

    def __init__(self, written: Source, changes: Sequence[TextEdit]) -> None:
        self.written, self.changes = written, changes
        self.source = Source(written.name, with_edits(written.text, changes))

    def _offset(self, offset: int) -> int | None:
        """Return where an offset of the changed text was; None inside what was changed."""
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
        start, end = self._offset(span.start), self._offset(span.end)
        if start is None or end is None or end < start:
            return None
        expansion = span.expansion
        if expansion is not None and expansion.definition is not None:
            is_own = expansion.definition.source.name == self.written.name
            expansion = expansion._replace(definition=self._span(expansion.definition)) if is_own else expansion
        return Span(self.written, start, end, expansion)

    def original(self, diagnostic: Diagnostic) -> Diagnostic | None:
        """Return a diagnostic of the changed text as one of the text as it was written; None if about a change."""
        span = diagnostic.span
        if span is None or span.source.name != self.written.name:
            return None
        place = self._span(span)
        if place is None or any(c.text and c.start <= place.start and place.end <= c.end for c in self.changes):
            return None
        fixes = tuple(fix for each in diagnostic.fixes if (fix := self._fix(each)) is not None)
        return replace(diagnostic, span=place, notes=(), chain=(), fixes=fixes)

    def _fix(self, fix: Fix) -> Fix | None:
        edits = []
        for edit in fix.edits:
            place = self._span(edit.span) if edit.span.source.name == self.written.name else None
            if place is None or any(each.overlaps(TextEdit(place.start, place.end, "")) for each in self.changes):
                return None
            edits.append(Edit(place, edit.text))
        return replace(fix, edits=tuple(edits))

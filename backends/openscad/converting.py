"""Converts a program of OpenSCAD to one of the Scene Language (docs/from-openscad.md).

The conversion runs in rounds: each one writes the whole program with what the rounds before have found out about kinds,
dimensions and special variables, until nothing new is found. Facts only grow, so a few rounds are enough.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from pathlib import Path

from scenelang.backends.files import read_program
from scenelang.backends.openscad.arithmetic import Converter, Facts, NameScope, Snippet, constant, string_text
from scenelang.backends.openscad.definitions import HELPERS
from scenelang.backends.openscad.geometry import NOTHING, Objects, Shape
from scenelang.backends.openscad.syntax import MAX_SIZE, Branch, Instance, Statement, parse
from scenelang.grammar.datum import Source, Span
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.grammar.formatter import format_text
from scenelang.interpreter.expand.forms import FORMS, INDENTS
from scenelang.stdlib.library import build_library

_MAX_CONVERSIONS = 40  # of one program: each may learn kinds of values that change what the next one writes
_ROOT = -1
_SPECIALS = {"$fn": 0.0, "$fa": 12.0, "$fs": 2.0}
_RESERVED = {"scene", "pi", "tau", "none", "else", "profile", "number"}
# Names of the library that conversions write besides those in helpers.
_WRITTEN = """
@ * + - / < <= = > >= abs acos and append apply array asin atan call ceiling chr circle color cos cross
deg determinant difference dot empty? equal? exp expt extrude floor hull hypot intersection lathe length
list log log10 max max-of mesh min min-of minkowski none? norm not offset-profile ord polygon profile-
difference profile-hull profile-intersection profile-minkowski profile-union range rectangle ref
reflect remainder rgb rotate scale sign sin sqrt string-append tan text-outline to-degrees transform transform-profile
profile-section profile-silhouette translate uniform union solid-union number? string? boolean? procedure?
"""
_UPRIGHT = "(rotate (deg -90) [1 0 0])"


def imported(path: Path) -> tuple[str, list[Diagnostic]]:
    """Convert a file; returns the program and warnings. Raises SceneError with the place in the file."""
    return converted(read_program(path, MAX_SIZE * 4), str(path), path.stem)


def converted(text: str, name: str = "<text>", word: str = "part") -> tuple[str, list[Diagnostic]]:
    """Convert a program; ``word`` becomes the word of its root."""
    statements = parse(text.replace("\r\n", "\n"), name)
    source = Source(name, text)
    facts = Facts()
    for _ in range(_MAX_CONVERSIONS):
        facts.changed = False
        program = _Program(facts, source, re.sub(r"[^\w ]+", " ", word).replace("_", " ").strip() or "part")
        made = program.text(statements)
        if not facts.changed and program.converter.is_waiting and not facts.holds("assumed"):
            facts.mark("assumed")
        if not facts.changed:
            return format_text(made, INDENTS), list(program.converter.warnings.values())
    raise SceneError(
        "openscad-unsupported", "the kinds of this program's values cannot be found out", None, Span(source, 0, 1)
    )


class _Program:
    """One round of a conversion."""

    def __init__(self, facts: Facts, source: Source, word: str) -> None:
        self.converter = Converter(facts, HELPERS)
        self.source = source
        self.word = word

    def text(self, statements: Sequence[Statement]) -> str:
        place = Objects(self.converter, self._scope(), {}, _ROOT)
        for name, value in _SPECIALS.items():
            place.scope.variables[name] = constant(value)
        place.specials = {**place.scope.variables, "$preview": Snippet("#f", constant(0).kind, 0.0)}
        place.specials["$children"] = constant(0)
        definitions, shapes = place.block(_shown(statements))
        shape = self._solid(place, shapes)
        lines = [self._header(), *self._moment(), *self._helpers()]
        lines += ["".join(f"; {line}\n" for line in comments) + text for comments, text in definitions]
        body = place.commented(shape.moved("pose", _UPRIGHT))
        lines.append(f"(bind {string_text(self.word)}\n(lambda ()\n; z is up in OpenSCAD, and y here\n{body}))")
        return "\n\n".join(lines) + "\n"

    def _scope(self) -> NameScope:
        builtins = {*build_library().builtins, *library_names()}
        words = set(re.findall(r"[^\s()\[\]]+", " ".join(HELPERS.values()))) | set(_WRITTEN.split())
        taken = {*(builtins & words), *FORMS, *HELPERS, *_RESERVED}
        taken |= {"moment"} if self.converter.facts.holds("moment") else set()
        return NameScope(None, {}, {}, {}, taken, frozenset(builtins))

    def _header(self) -> str:
        return f"; Converted from {Path(self.source.name).name} (OpenSCAD) by `scenelang import`."

    def _moment(self) -> Iterable[str]:
        if self.converter.facts.holds("moment"):
            yield '(param moment 0 "the moment of the animation, $t of OpenSCAD" :min 0 :max 1)'

    def _helpers(self) -> Iterable[str]:
        """Return the definitions of the helpers that the program uses, and of those that they use."""
        wanted, needed = list(self.converter.helpers), set()
        while wanted:
            name = wanted.pop()
            if name not in needed:
                needed.add(name)
                wanted += [other for other in HELPERS if other != name and f"({other} " in HELPERS[name]]
        return [text for name, text in HELPERS.items() if name in needed]

    def _solid(self, place: Objects, shapes: Sequence[Shape]) -> Shape:
        """Return the scene: solids; a drawing without any becomes a thin plate, as OpenSCAD shows it."""
        span = Span(self.source, 0, 1)
        flat = [shape for shape in shapes if shape.dimensions == 2]
        solid = [shape for shape in shapes if shape.dimensions != 2]
        if flat and solid:
            self.converter.warn(span, "flat objects beside solids are left out, as OpenSCAD does")
            shapes = solid
        elif flat:
            self.converter.warn(span, "the drawing is flat: it became a plate of height 1")
            drawing = place.united(flat, span)
            text = place.place(drawing)
            if drawing.may_be_empty:
                text = f"({self.converter.helper('if-profile')} {text} (lambda (profile) (extrude profile 1)))"
                return Shape(text, 3, True)
            return Shape(f"(extrude {text} 1)", 3)
        shape = place.united(shapes, span)
        if shape is NOTHING and not self.converter.facts.changed:
            raise SceneError("empty-scene", f"`{self.source.name}` makes no objects", "call one of its modules", span)
        return shape


def library_names() -> set[str]:
    """Return the names of the library that are written in the language itself."""
    from scenelang.stdlib import library

    folder = Path(str(library.__file__)).parent
    texts = [(folder / name).read_text("utf-8") for name in ("prelude.scene", "combinators.scene")]
    return {match for text in texts for match in re.findall(r"^\(define \(?([^\s()]+)", text, re.MULTILINE)}


def _shown(statements: Sequence[Statement]) -> Sequence[Statement]:
    """Return the statements that count: if one is marked `!`, only this one makes objects."""
    marked = [each for each in statements if isinstance(each, Instance | Branch) and "!" in each.modifiers]
    if not marked:
        return statements
    kept = marked[-1]
    plain = kept.modifiers.replace("!", "")
    if isinstance(kept, Instance):
        alone: Statement = Instance(kept.span, kept.name, kept.arguments, kept.children, plain, kept.comments)
    else:
        alone = Branch(kept.span, kept.test, kept.yes, kept.no, plain, kept.comments)
    return [*(each for each in statements if not isinstance(each, Instance | Branch)), alone]

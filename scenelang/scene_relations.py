"""Relations of things, the methods of ``Scene`` that tell where things are and which declarations fail."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.grammar.settings import typed
from scenelang.interpreter.scene.declarations import RELATIONS

if TYPE_CHECKING:
    from scenelang.backends.geometry.relations import Violation
    from scenelang.interpreter.scene.declarations import Declaration
    from scenelang.scene import Scene
    from scenelang.session import Session


_BARE = re.compile(r"\s*\(\s*(?:not\s*\(\s*)?([^\s()]+)")  # a relation outside of `assert-that`


def declarations_of(session: Session, asked: str) -> tuple[Declaration, ...]:
    """Return the declarations of a text such as ``(on "cup" "table")``, or of a file of these or ``assert-that`` forms.

    Raises SceneError with the first mistake.
    """
    source = declaration_source(asked) if asked.lstrip().startswith("(") else session.source(asked)
    bare = _BARE.match(source.text)
    if bare is not None and bare[1] in RELATIONS:
        source = Source(source.name, declaration_source(source.text.strip()).text)
    found = session.declarations(source)
    if not found:
        hint = 'write `(assert-that (on "cup" "table"))`'
        raise SceneError("value", f"{Path(source.name).name} states no declaration", hint)
    return found


def declaration_source(text: str) -> Source:
    """Return the source of a declaration such as ``(on "cup" "table")``."""
    return Source("<declaration>", text if text.lstrip().startswith("(assert-that") else f"(assert-that {text})")


def declaration_problem(text: str) -> Diagnostic | None:
    """Return the first mistake in a declaration, None if it is well formed."""
    from scenelang.session import Session

    try:
        Session().declarations(declaration_source(text))
    except SceneError as error:
        return error.diagnostic
    return None


@typed
def violations(self: Scene, *declarations: str) -> list[Violation]:
    """Return the declarations that do not hold: those of the program, and the given ones about the whole scene.

    Parameters
    ----------
    declarations : str
        Each a declaration such as ``(on "cup" "table")``, or the path of a file of ``assert-that`` forms.

    Returns
    -------
    list of Violation
        In the order of frames; ``message`` says why, ``move`` is a translation in scene units that fixes it.

    Raises
    ------
    SceneError
        For a declaration that is malformed, whose words do not occur, or that has no meaning for a word.

    Examples
    --------
    >>> scene.violations('(on "cup" "table")', '(count "chair" 6)')
    []
    """
    from scenelang.backends.geometry.relations import violations as found_in
    from scenelang.session import Options, Session

    session = Session(self.options or Options())
    extra = [each for text in declarations for each in declarations_of(session, text)]
    return found_in(self.graph, extra)


@dataclass(frozen=True, slots=True)
class SceneRelation:
    """A relation that holds between two things.

    Attributes
    ----------
    relation : str
        "on", "inside", "touching" or "overlapping".
    subject, other : str
        Handles of the two things, such as "z3".
    subject_word, other_word : str
        Their words.
    distance : float
        Signed distance of their surfaces in scene units, negative where they overlap.
    """

    relation: str
    subject: str
    other: str
    subject_word: str
    other_word: str
    distance: float


@typed
def relations(
    self: Scene, words: str | Sequence[str] | None = None, frame: int = 0, limit: int = 20_000
) -> list[SceneRelation]:
    """Return the relations of things that touch or overlap: what is on, inside of, touching or overlapping what.

    Parameters
    ----------
    words : str or sequence of str, optional
        Words of the things; by default all that the program binds, and semantic primitives. Things are compared with
        those that have the same thing around them.
    frame : int
        Frame of a 4D scene, counted from 0.
    limit : int
        Most pairs of nearby things.

    Raises
    ------
    SceneError
        For a frame that does not exist, or too many pairs.

    Examples
    --------
    >>> [(each.subject_word, each.relation, each.other_word) for each in scene.relations()]
    [('cup', 'on', 'table')]
    """
    from scenelang.backends.geometry.arrangement import Arrangement, related
    from scenelang.backends.labels.things import is_thing
    from scenelang.interpreter.scene.numbering import frame_numbers, some_handles

    root = self._frame(frame)
    chosen = None if words is None else {words} if isinstance(words, str) else set(words)
    here = Arrangement(self.graph, self.graph.frames.index(root))
    ancestry = here.ancestry
    counts = [e.word in chosen if chosen is not None else is_thing(e) and e is not root for e in ancestry.nodes]
    rows = [row for row, node in enumerate(ancestry.node.tolist()) if counts[node]]
    found = related(here, rows, limit)
    numbers = frame_numbers(self.graph) if len(self.graph.frames) > 1 else None
    named = some_handles(self.graph, ancestry, sorted({n for r in found for n in (r.subject, r.other)}), numbers)
    words_of = {row: ancestry.entity(row).word for row in named}
    return [
        SceneRelation(r.relation, named[r.subject], named[r.other], words_of[r.subject], words_of[r.other], r.distance)
        for r in found
    ]

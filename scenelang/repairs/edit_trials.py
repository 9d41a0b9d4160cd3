"""Trials of edits: the engine of the searches that edit a program, evaluate it, and keep what helps.

``alternatives`` tries fixes of errors, ``repairing`` edits that resolve findings about a scene, ``instance_edits``
edits of the forms that make chosen instances. A search proposes candidates; ``Trials`` evaluates their texts and counts
the work; the search judges each result.

The budget is counted work, not time: a deadline would make the result depend on the machine and its load. Counted work
gives the same result everywhere, and predicts the duration of a search.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator
from typing import TYPE_CHECKING, Protocol, TypeVar

from scenelang.grammar.datum import Source, with_edits
from scenelang.grammar.diagnostics import Edit

if TYPE_CHECKING:
    from scenelang.session.session import Evaluated, Session

# Microseconds on one core of the test machine, measured over the examples and the rooms of `benchmarks`: a check takes
# 2 to 5 for each character of the program; the evaluator 1 to 2 for each step. The geometry checks take 30 to 290 ms
# for rooms of 20 to 90 primitives, and 80 to 800 microseconds for each primitive of the larger examples.
_CHARACTER_COST = 4
_STEP_COST = 2
_BOX_COST = 2  # the corners of one primitive
_EXAMINATION_COST = 50_000
_EXAMINED_PRIMITIVE_COST = 300
_MICROSECONDS_PER_UNIT = 1_000_000
# Steps of an edited version: several times those of the program, and enough for a small one whose edit adds objects.
# With an edited number, a recursion such as `(tower (- n 1))` passes its end. By the session's limits, 10 million steps
# and a depth of 100,000, each such trial took 1 to 3 s, and one move in a named `let` 43 s.
_STEP_GROWTH = 10
_FREE_STEPS = 50_000


class EditCandidate(Protocol):
    """An edit to try, made of text edits that do not overlap."""

    @property
    def edits(self) -> tuple[Edit, ...]:
        """Text edits, with spans in the text before all of them."""


class Priced(EditCandidate, Protocol):
    """A candidate with the cost that its search expects."""

    @property
    def cost(self) -> float:
        """Expected cost; cheaper candidates are tried first."""


AnyCandidate = TypeVar("AnyCandidate", bound=EditCandidate)
AnyPriced = TypeVar("AnyPriced", bound=Priced)
Result = TypeVar("Result")


class Trials:
    """Evaluates edited versions of a program while there is budget left.

    Parameters
    ----------
    name : str
        Name of the program in diagnostics.
    evaluate : callable
        ``Session.evaluate``, or what ``version_evaluator`` returns.
    effort : float
        Budget; one unit takes about a second on one core.
    most : int, optional
        Maximum number of evaluations.

    Examples
    --------
    >>> trials = Trials("a.scene", print, effort=0.1)
    >>> trials.spend_examination(200)
    >>> trials.can_go_on
    False
    """

    def __init__(
        self, name: str, evaluate: Callable[[Source], Evaluated], effort: float, most: int | None = None
    ) -> None:
        self._name, self._evaluate = name, evaluate
        self._microseconds = effort * _MICROSECONDS_PER_UNIT
        self._evaluations_left = most

    @property
    def can_go_on(self) -> bool:
        """Whether budget is left, and evaluations are."""
        return self._microseconds > 0 and self._evaluations_left != 0

    def evaluate(self, text: str) -> Evaluated:
        """Evaluate a version of the program and charge for it."""
        result = self._evaluate(Source(self._name, text))
        self._microseconds -= _CHARACTER_COST * len(text) + _STEP_COST * result.steps
        if self._evaluations_left:
            self._evaluations_left -= 1
        return result

    def spend_boxes(self, primitives: int) -> None:
        """Charge for computing the boxes of some primitives."""
        self._microseconds -= _BOX_COST * primitives

    def spend_examination(self, primitives: int) -> None:
        """Charge for the geometry checks and declarations of a scene."""
        self._microseconds -= _EXAMINATION_COST + _EXAMINED_PRIMITIVE_COST * primitives

    def first(
        self, candidates: Iterable[AnyCandidate], judge: Callable[[AnyCandidate], Result | None]
    ) -> Result | None:
        """Return the first result of ``judge`` that is not None.

        None means that no candidate has one, or that the budget is spent.
        """
        for candidate in candidates:
            if not self.can_go_on:
                return None
            result = judge(candidate)
            if result is not None:
                return result
        return None


def version_evaluator(session: Session) -> Callable[[Source], Evaluated]:
    """Return a function that evaluates the versions of a program, the program itself first.

    Of each version only what differs is evaluated. A version may take several times the steps of the program, so that
    an edit after which it does not end costs little.
    """
    from scenelang.session.editing import Editing

    editing = Editing(session)

    def evaluate(source: Source) -> Evaluated:
        """Evaluate the next version."""
        result = editing.evaluate(source)
        if editing.most_steps is None:
            editing.most_steps = _FREE_STEPS + _STEP_GROWTH * result.steps
        return result

    return evaluate


def edited(text: str, edits: Iterable[Edit]) -> str:
    """Apply edits that do not overlap; their spans are those of the text before all of them."""
    return with_edits(text, (edit.text_edit for edit in edits))


def cheapest(
    candidates: Iterable[AnyPriced], key: Callable[[AnyPriced], Hashable], tried: set[Hashable], most: int
) -> Iterator[AnyPriced]:
    """Yield up to ``most`` candidates, the cheapest first.

    Candidates whose key is in ``tried`` are skipped; the keys of the others are added to it.
    """
    count = 0
    for candidate in sorted(candidates, key=lambda candidate: candidate.cost):
        if key(candidate) in tried:
            continue
        if count == most:
            return
        tried.add(key(candidate))
        count += 1
        yield candidate

"""The geometric lint: findings of every frame as warnings at the calls that made the things (``check --geometry``)."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from scenelang.backends.solidity.bodies import MOST_PAIRS, Bodies, bodies_of
from scenelang.backends.solidity.findings import Finding, findings
from scenelang.grammar.diagnostics import Diagnostic, Note
from scenelang.grammar.source import Span
from scenelang.interpreter.entity import Scene, primitive_count

MOST_PRIMITIVES = 20_000
_MOST_FRAMES = 6
_MOST_SHOWN = 20


@dataclass(frozen=True, slots=True)
class _Named:
    """A finding with the words of what it is about, so that equal ones are told once."""

    finding: Finding
    words: tuple[str, ...]
    other: tuple[str, ...]
    place: Span | None
    other_place: Span | None
    frame: int


def check_geometry(scene: Scene) -> list[Diagnostic]:
    """Warnings about the geometry of a scene; of a film, what is so in most of some frames spread over it."""
    count = len(scene.frames)
    frames = sorted(
        {round(i * (count - 1) / max(_MOST_FRAMES - 1, 1)) for i in range(_MOST_FRAMES)} if count > 1 else {0}
    )
    found: dict[tuple[str, tuple[str, ...], tuple[str, ...]], list[_Named]] = {}
    remarks: list[Diagnostic] = []
    for number in frames:
        root = scene.frames[number]
        total = primitive_count(root)
        if total > MOST_PRIMITIVES:
            remarks.append(_not_looked_at(f"{total:,} primitives are more than the {MOST_PRIMITIVES:,}", number, count))
            continue
        bodies = bodies_of(root)
        for finding in findings(bodies):
            named = _named(bodies, finding, number)
            found.setdefault((finding.kind, named.words, named.other), []).append(named)
        if len(bodies) and not bodies.contacts[2]:
            remarks.append(_not_looked_at(f"more than {MOST_PAIRS:,} pairs are near one another", number, count))
    lasting = [group for group in found.values() if 2 * len({each.frame for each in group}) > len(frames)]
    shown = [_diagnostic(group, scene.animated) for group in lasting[:_MOST_SHOWN]]
    if len(lasting) > _MOST_SHOWN:
        shown.append(Diagnostic("geometry-limit", f"{len(lasting) - _MOST_SHOWN} more findings are not shown"))
    return [*shown, *remarks[:1]]


def _not_looked_at(why: str, frame: int, count: int) -> Diagnostic:
    where = f"frame {frame}" if count > 1 else "the scene"
    return Diagnostic("geometry-limit", f"{where} was not looked at whole: {why} that this check takes")


def _named(bodies: Bodies, finding: Finding, frame: int) -> _Named:
    other = finding.other
    return _Named(
        finding,
        bodies.words(finding.body),
        bodies.words(other) if other is not None else (),
        _place(bodies, finding.body),
        _place(bodies, other) if other is not None else None,
        frame,
    )


def _place(bodies: Bodies, i: int) -> Span | None:
    places = bodies.entities[bodies.entity[i]].places
    return places[0] if places else None


def _diagnostic(group: Iterable[_Named], animated: bool) -> Diagnostic:
    """One warning for equal findings, about the one that is farthest off."""
    every = list(group)
    named = max(every, key=lambda each: each.finding.amount)
    finding = named.finding
    frames = {each.frame for each in every}
    times = max(sum(1 for each in every if each.frame == frame) for frame in frames)
    name, tell = _TOLD[finding.kind]
    message = tell(named) + (f" ({times} times)" if times > 1 else "")
    if animated:
        message += f" (frame {min(frames)})"
    hint = None
    if finding.move is not None and any(abs(x) > 1e-9 for x in finding.move):
        hint = f"`(translate [{' '.join(f'{round(x, 6) + 0.0:.3g}' for x in finding.move)}])` would mend it"
    other = named.other_place
    notes = (Note("the other thing is made here", other),) if other is not None and other != named.place else ()
    return Diagnostic(name, message, named.place, hint, notes)


def _path(words: tuple[str, ...]) -> str:
    """The last words of a path; a person knows the rest."""
    return '"' + "/".join(words[-3:]) + '"'


def _twin(named: _Named) -> str:
    return f"{_path(named.words)} stands twice in the same place"


def _buried(named: _Named) -> str:
    return f"{_path(named.words)} is inside {_path(named.other)}, where it cannot be seen"


def _deep(named: _Named) -> str:
    return f"{_path(named.words)} goes {named.finding.amount:.3g} deep into its neighbour of the same word"


def _hovering(named: _Named) -> str:
    amount = f"{named.finding.amount:.3g}"
    if not named.other:
        return f"{_path(named.words)} touches nothing: it hovers {amount} above the ground"
    return f"{_path(named.words)} touches nothing: {amount} from {_path(named.other)}"


def _sunk(named: _Named) -> str:
    return f"{_path(named.words)} reaches {named.finding.amount:.3g} below the ground, y = 0"


def _fighting(named: _Named) -> str:
    return f"a face of {_path(named.words)} lies in the plane of one of {_path(named.other)}, in another colour"


_TOLD: dict[str, tuple[str, Callable[[_Named], str]]] = {
    "twin": ("overlap", _twin),
    "buried": ("overlap", _buried),
    "deep": ("overlap", _deep),
    "hovering": ("floating", _hovering),
    "sunk": ("below-ground", _sunk),
    "fighting": ("coincident-faces", _fighting),
}

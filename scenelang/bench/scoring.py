"""Scores of programs: which predicates of a task hold, what an edit leaves alone, and what the geometry warns of."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from scenelang.backends.geometry.lint import check_geometry, quoted_path
from scenelang.backends.geometry.relations import reasons
from scenelang.bench.tasks import GEOMETRY, KEEP, BenchTask
from scenelang.grammar.datum import Source, dataclass
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.inference.brief import TaskKind
from scenelang.interpreter.plugins import SERVICES
from scenelang.interpreter.scene.bounds import box_diagonal, entity_box, parts_box
from scenelang.interpreter.scene.entity import Entity, Scene, descendants
from scenelang.interpreter.scene.flatten import FlatFrame, flatten_entity
from scenelang.interpreter.values.values import Matrix, Pair
from scenelang.session.declarations import declared_in_python
from scenelang.session.session import Options, Session

_SAME = 1e-3  # of the scene's diagonal: what is nearer is where it was
# Difference of each component in linear sRGB, from 0 to 1, that is no change of color: four times the rounding of a
# color to two digits (0.005) or to a hex code (at most 0.0045).
_SAME_COLOR = 0.02
_COLLISIONS = frozenset({"overlap"})
_GAPS = frozenset({"floating"})
# Warnings that a pass must not have. An outlier or a flickering face is a guess at what was meant: a large ball among
# four small ones, which a task asked for, is called one.
_PHYSICAL = frozenset({"overlap", "floating", "unstable", "below-ground"})
_MOVES = frozenset({"body-moves", "body-tips", "body-falls", "body-explodes"})


@dataclass(frozen=True, slots=True)
class Score:
    """What a program comes to.

    Attributes
    ----------
    reasons
        For each declaration of the task why it does not hold, None if it holds.
    locality
        Share of the primitives that an edit must keep which are as before; None if nothing is to be kept.
    warnings
        Warnings of `check --geometry` that the task does not allow and that an edited program did not have before.
    collides, floats
        Whether the geometry lint finds parts that overlap, or that hang in the air; None for blocks.
    stable
        Whether all things stay where they are under gravity; None if it was not simulated.
    """

    reasons: tuple[str | None, ...]
    locality: float | None = None
    warnings: tuple[str, ...] = ()
    collides: bool | None = None
    floats: bool | None = None
    stable: bool | None = None

    @property
    def passed(self) -> bool:
        """Whether all predicates hold."""
        return all(reason is None for reason in self.reasons) and self.locality in (None, 1.0) and not self.warnings

    def failed(self, task: BenchTask) -> list[str]:
        """Return the predicates that do not hold: declarations of the task, "keep" and "geometry"."""
        failed = [text for text, reason in zip(task.that, self.reasons) if reason is not None]
        return [*failed, *([KEEP] if self.locality not in (None, 1.0) else []), *([GEOMETRY] if self.warnings else [])]


def score_of(task: BenchTask, scene: Scene, simulates: bool = False, is_python: bool = False) -> Score:
    """Judge the scene of a program by a task; words of Python may have underscores for hyphens.

    Raises SceneError where it cannot be judged, such as for meshes that cannot be read.
    """
    locality = None
    if task.keep and task.program is not None:
        locality = kept_share(scene_of(task.program), scene, task.keep)
    collides = floats = stable = None
    warnings: tuple[str, ...] = ()
    if task.kind is not TaskKind.BLOCKS:
        findings = check_geometry(scene)
        names = {finding.name for finding in findings}
        collides, floats = bool(names & _COLLISIONS), bool(names & _GAPS)
        stable = _is_stable(scene) if simulates and task.kind is TaskKind.STILL else None
        before = _warned(task.program) if task.program is not None else ()
        # What moves need not stand: a domino that falls is out of balance in every frame.
        ignored = {*task.allows, *(["unstable"] if scene.animated else [])}
        counted = [f for f in findings if f.severity == "warning" and f.name in _PHYSICAL]
        warnings = tuple(
            finding.message for finding in counted if finding.name not in ignored and _about(finding) not in before
        )
    declarations = task.declarations
    if is_python:
        words = {entity.word for entity in descendants(*scene.frames)}
        declarations = tuple(declared_in_python(declaration, words) for declaration in declarations)
    return Score(tuple(reasons(scene, declarations)), locality, warnings, collides, floats, stable)


@lru_cache(maxsize=64)
def _warned(program: str) -> Collection[tuple[str, str]]:
    """Return what the warnings of the geometry lint about a program's scene are about."""
    return {_about(finding) for finding in check_geometry(scene_of(program)) if finding.severity == "warning"}


def _about(finding: Diagnostic) -> tuple[str, str]:
    """Return the name of a finding, and the last word of the path that its message begins with."""
    return finding.name, quoted_path(finding).rpartition("/")[2]


def _is_stable(scene: Scene) -> bool | None:
    names = {finding.name for finding in SERVICES.find("physics").check_physics(scene)}
    return None if "not-simulated" in names else names.isdisjoint(_MOVES)


@lru_cache(maxsize=64)
def scene_of(program: str) -> Scene:
    """Evaluate a program of a task. Raises SceneError with its first mistake."""
    result = Session(Options(seed=0)).evaluate(Source("task.scene", program))
    if result.scene is None:
        problem = next(d for d in result.diagnostics if d.is_error)
        raise SceneError(problem.name, problem.message, problem.hint, problem.span)
    return result.scene


def kept_share(before: Scene, after: Scene, words: Sequence[str]) -> float:
    """Return the share of primitives in instances of ``words`` that are where and as they were, 1 if all are.

    What is added to these instances counts as well. The least of all frames is returned; a film that became another
    number of frames keeps nothing.
    """
    if len(before.frames) != len(after.frames):
        return 0.0
    shares = []
    for first, second in zip(before.frames, after.frames):
        a, b = flatten_entity(first), flatten_entity(second)
        box = entity_box(first)
        size = box_diagonal(box)
        shares += [_share(_rows(a, word), _rows(b, word), _SAME * size) for word in words]
    return min(shares)


_Rows = tuple[list[str], Any]


def _rows(frame: FlatFrame, word: str) -> _Rows:
    """Return the kinds of the primitives in instances of ``word``, and their boxes and colors (N, 9)."""
    inside = [word in path for path in frame.paths]
    kinds, rows = [], []
    for row, (path, number) in enumerate(zip(frame.path_index.tolist(), frame.index.tolist())):
        entity = frame.primitives[number]
        if inside[path] or entity.word == word:
            box = parts_box((Pair(entity, Matrix(frame.matrices[row].ravel().tolist())),))
            kinds.append(_kind(entity))
            rows.append([*(box or (0.0,) * 6), *(entity.shape.color if entity.shape is not None else (1.0,) * 3)])
    return kinds, np.array(rows, np.float64).reshape(-1, 9)


def _kind(entity: Entity) -> str:
    """Return the word of a primitive, with attributes that are texts, such as the type of a block."""
    texts = {name: value for name, value in entity.embedding.attributes.items() if isinstance(value, str)}
    return f"{entity.word} {sorted(texts.items())}" if texts else entity.word


def _share(before: _Rows, after: _Rows, within: float) -> float:
    """Match rows one to one, each with the first unmatched one that is alike, and return the share that is matched."""
    (words, rows), (others, other_rows) = before, after
    most = max(len(rows), len(other_rows))
    if not most:
        return 1.0
    left = np.ones(len(other_rows), bool)
    kinds = np.array(others, object)
    matched = 0
    for word, row in zip(words, rows):
        alike = left & (kinds == word) if len(other_rows) else left
        alike = alike & (np.abs(other_rows[:, :6] - row[:6]) <= within).all(axis=1)
        alike &= (np.abs(other_rows[:, 6:] - row[6:]) <= _SAME_COLOR).all(axis=1)
        hits = np.flatnonzero(alike)
        if len(hits):
            left[hits[0]] = False
            matched += 1
    return matched / most

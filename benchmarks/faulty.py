"""Plants faults of known kinds in sound programs, by edits of their texts: what lints of geometry are measured on.

Each form ``(transform ...)`` or ``(call ...)`` of a program is moved a little, which tells the instances that it makes
and the frame they are placed in. A fault is then a motion in the world, written back into the program: at the literal
of a ``translate`` where there is one, otherwise around the form. Every planted fault is checked by its geometry: a
thing that is to float touches nothing, one that is to topple has its centre of mass beside what it touches.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from scenelang.backends.facts.bodies import is_shape
from scenelang.backends.facts.words import flies
from scenelang.backends.surfaces.convex import Bodies, bodies_of, clusters
from scenelang.backends.surfaces.distance import depths
from scenelang.grammar.datum import ArrayDatum, Atom, Datum, ListDatum, Source, Symbol, subdatums
from scenelang.grammar.reader import read
from scenelang.interpreter.scene.entity import Entity, Scene, primitive_count
from scenelang.interpreter.scene.primitives.cube import BLOCK
from scenelang.session.session import Session

FloatArray = npt.NDArray[np.float64]

MAX_PRIMITIVES = 1_500  # of a program that faults are planted in
MAX_CANDIDATES = 40  # forms of a program that are tried
_PROBE = 1e-3  # of the scene's size
KINDS = (
    "floating", "sunk", "penetrating", "past the edge", "twin", "buried", "loop", "scale", "tilted", "hanging",
    "fighting", "top-heavy",
)  # fmt: skip
WHOLE = ("sunk", "penetrating", "past the edge", "buried", "scale", "tilted", "hanging", "top-heavy")  # not of parts
RARE = ("past the edge", "scale", "hanging", "top-heavy")  # planted twice in a thing, if need be
MOST = {"twin": 1, "sunk": 2, "floating": 2, "fighting": 2}  # of a kind in a program; else 3


@dataclass(frozen=True)
class Fault:
    """A program with a planted fault.

    Attributes
    ----------
    program, kind
        Name of the sound program, and what is wrong now.
    text
        The program with the fault.
    rows
        Primitives that are misplaced, by their positions in depth-first order.
    words
        The words that lead to the first of them.
    displacement
        How far they were moved, in scene units; 0 if something was added.
    """

    program: str
    kind: str
    text: str
    rows: frozenset[int]
    words: tuple[str, ...]
    displacement: float


@dataclass(frozen=True)
class _Candidate:
    """A form of the text: its instances, the rows of their primitives, and the frame (4, 4) that it is placed in."""

    form: ListDatum
    parent: Datum | None
    instances: tuple[tuple[int, ...], ...]
    frame: FloatArray
    is_part: bool  # of a thing, by its word


class Program:
    """A sound program, and the forms whose edits move something in it."""

    def __init__(self, name: str, text: str, session: Session, path: str = "fault.scene") -> None:
        self.name, self.text, self.session, self.path = name, text, session, path
        scene = self.evaluated(text)
        if scene is None:
            raise ValueError(f"{name} is no sound program")
        self.scene = scene
        self.is_film = len(scene.frames) > 1

    def evaluated(self, text: str) -> Scene | None:
        return self.session.evaluate(Source(self.path, text)).scene

    @cached_property
    def bodies(self) -> Bodies:
        return bodies_of(self.scene.root)

    @cached_property
    def candidates(self) -> tuple[_Candidate, ...]:
        if self.is_film or primitive_count(self.scene.root) > MAX_PRIMITIVES:
            return ()
        found: dict[tuple[tuple[int, ...], ...], _Candidate] = {}
        forms = [each for datum in read(Source("fault.scene", self.text)).forms for each in _forms(datum, None)]
        random.Random(self.name).shuffle(forms)
        for form, parent in forms[: 3 * MAX_CANDIDATES]:
            candidate = self._candidate(form, parent)
            if candidate is not None:
                found.setdefault(candidate.instances, candidate)
            if len(found) >= MAX_CANDIDATES:
                break
        return tuple(found.values())

    def _candidate(self, form: ListDatum, parent: Datum | None) -> _Candidate | None:
        size = self.bodies.size
        steps = [np.eye(4) for _ in range(4)]
        for axis in range(3):
            steps[axis][axis, 3] = _PROBE * size
        steps[3][:3, :3] *= 2.0
        shifted = []
        for pose in (*(_translation(step[:3, 3]) for step in steps[:3]), "(scale 2)"):
            scene = self.evaluated(_wrapped(self.text, form, pose))
            if scene is None or len(scene.frames) != 1:
                return None
            moved = moved_instances(self.scene.root, scene.root)
            if not moved:
                return None
            shifted.append(moved)
        rows = tuple(tuple(instance[0]) for instance in shifted[0])
        total = primitive_count(self.scene.root)
        if any(len(moved) != len(rows) for moved in shifted) or sum(map(len, rows)) > 0.6 * total:
            return None
        frame = np.eye(4)
        for axis in range(3):
            frame[:3, axis] = shifted[axis][0][1][:3, 3] / (_PROBE * size)
        frame[:3, 3] = -shifted[3][0][1][:3, 3]
        is_part = is_shape(shifted[0][0][2])
        return _Candidate(form, parent, rows, frame, is_part) if abs(np.linalg.det(frame)) > 1e-12 else None


def _forms(datum: Datum, parent: Datum | None) -> Iterator[tuple[ListDatum, Datum | None]]:
    """Yield the outermost forms that make a part, with what contains them."""
    if isinstance(datum, ListDatum) and datum.items and isinstance(datum.items[0], Atom):
        head = datum.items[0].value
        if head in ("transform", "call") and isinstance(head, Symbol):
            yield datum, parent
            inner = [each for each in datum.items[1:] if not (head == "transform" and each is datum.items[1])]
            for each in inner:
                yield from _forms(each, datum)
            return
    for each in subdatums(datum):
        yield from _forms(each, datum)


def _translation(offset: Sequence[float]) -> str:
    return f"(translate [{' '.join(_number(x) for x in offset)}])"


def _number(value: float) -> str:
    return f"{round(float(value), 9) + 0.0:.6g}"


def _wrapped(text: str, form: ListDatum, pose: str) -> str:
    start, end = form.span.start, form.span.end
    return f"{text[:start]}(transform {text[start:end]} {pose}){text[end:]}"


def moved_instances(before: Entity, after: Entity) -> list[tuple[list[int], FloatArray, Entity]] | None:
    """Return the rows of each instance whose own pose differs, its motion (4, 4) in the world, and its entity; None if
    the scenes have other parts."""
    found: list[tuple[list[int], FloatArray, Entity]] = []
    row = 0

    def walk(old: Entity, new: Entity, world: FloatArray, inside: bool) -> bool:
        nonlocal row
        if old.word != new.word or len(old.children) != len(new.children) or old.is_primitive != new.is_primitive:
            return False
        if old.is_primitive:
            if inside:
                found[-1][0].append(row)
            row += 1
        for first, second in zip(old.children, new.children, strict=True):
            was, now = world @ _square(first.cdr), world @ _square(second.cdr)
            moves = not inside and not np.allclose(first.cdr, second.cdr, rtol=0.0, atol=1e-12)
            if moves:
                found.append(([], now @ np.linalg.pinv(was), second.car))
            if not walk(first.car, second.car, was, inside or moves):
                return False
        return True

    return [each for each in found if each[0]] if walk(before, after, np.eye(4), False) else None


def _square(pose: Sequence[float]) -> FloatArray:
    whole = np.eye(4)
    whole[:3] = np.array(pose).reshape(3, 4)
    return whole


# --- what stands where -----------------------------------------------------------------------------------------------


class Thing:
    """The bodies of one instance of a candidate, and what they touch."""

    def __init__(self, bodies: Bodies, rows: Sequence[int]) -> None:
        self.bodies = bodies
        self.mask = np.isin(bodies.row, rows)
        self.own = np.flatnonzero(self.mask)
        low, high = bodies.boxes
        self.low, self.high = low[self.own].min(axis=0), high[self.own].max(axis=0)
        pairs = bodies.contacts[0]
        inside = self.mask[pairs]
        self.touching = pairs[inside.sum(axis=1) == 1]
        self.others = np.where(self.mask[self.touching[:, 0]], self.touching[:, 1], self.touching[:, 0])
        self.is_whole = len(np.unique(clusters(len(bodies), pairs[inside.all(axis=1)].tolist())[self.own])) == 1

    @property
    def size(self) -> FloatArray:
        return np.asarray(self.high - self.low, np.float64)

    @property
    def base(self) -> tuple[int, ...]:
        """Bodies that it stands on: those that it touches, if all are below it; empty otherwise."""
        _, high = self.bodies.boxes
        room = max(3.0 * self.bodies.touch, 0.05 * float(self.size[1]))
        below = high[self.others, 1] <= self.low[1] + room
        return tuple(dict.fromkeys(self.others.tolist())) if len(below) and below.all() else ()

    @property
    def center(self) -> FloatArray:
        """Centre of mass (3,)."""

        mass, center = self.bodies.masses
        return np.asarray((center[self.own] * mass[self.own, None]).sum(axis=0) / mass[self.own].sum(), np.float64)

    def words(self) -> tuple[str, ...]:
        return self.bodies.words(int(self.own[0]))


class Planter:
    """Plants faults in one program."""

    def __init__(self, program: Program, seed: int = 0) -> None:
        self.program, self.bodies = program, program.bodies
        self.random = random.Random(f"{seed} {program.name}")
        low, high = self.bodies.boxes
        self.low, self.high = low.min(axis=0), high.max(axis=0)
        self.ground = 0.0 if (np.abs(low[:, 1]) <= 2.0 * self.bodies.touch).any() else float(self.low[1])

    def faults(self, kinds: Sequence[str] = KINDS, most: Mapping[str, int] = MOST) -> Iterator[Fault]:
        """Yield at most so many faults of each kind."""
        for kind in kinds:
            plant: Callable[[_Candidate, Thing], Fault | None] = getattr(
                self, "_" + kind.replace(" ", "_").replace("-", "_")
            )
            candidates = list(self.program.candidates)
            self.random.shuffle(candidates)
            candidates *= 2 if kind in RARE else 1
            number = 0
            for candidate in candidates:
                if (len(candidate.instances) > 2) != (kind == "loop"):
                    continue
                if candidate.is_part and kind in WHOLE:
                    continue
                if not np.isin(self.bodies.row, candidate.instances[0]).any():
                    continue
                thing = Thing(self.bodies, candidate.instances[0])
                if not thing.is_whole or any(flies(word) for word in thing.words()):
                    continue
                fault = plant(candidate, thing)
                if fault is not None:
                    yield fault
                    number += 1
                    if number >= most.get(kind, 3):
                        break

    # --- edits ---

    def _moved(
        self, candidate: _Candidate, kind: str, motion: FloatArray, pose: str = ""
    ) -> tuple[Fault, Bodies] | None:
        """Return the program with a candidate moved in the world by ``motion`` (4, 4), if the edit does that."""
        local = np.linalg.inv(candidate.frame) @ motion @ candidate.frame
        if not pose:
            if not np.allclose(local[:3, :3], np.eye(3), atol=1e-9):
                raise ValueError("only translations are written without a pose")
            text = self._translated(candidate.form, local[:3, 3])
        else:
            text = _wrapped(self.program.text, candidate.form, pose)
        scene = self.program.evaluated(text)
        if scene is None:
            return None
        moved = moved_instances(self.program.scene.root, scene.root)
        if not moved or len(moved) != len(candidate.instances):
            return None
        if not np.allclose(moved[0][1], motion, atol=1e-4 * max(self.bodies.size, 1.0)):
            return None
        rows = frozenset(row for instance, *_ in moved for row in instance)
        bodies = bodies_of(scene.root)
        first = Thing(bodies, moved[0][0])
        old = Thing(self.bodies, candidate.instances[0])
        distance = float(np.linalg.norm((first.low + first.high - old.low - old.high) / 2.0))
        return Fault(self.program.name, kind, text, rows, first.words(), distance), bodies

    def _translated(self, form: ListDatum, offset: FloatArray) -> str:
        """Return the text with a form translated by ``offset``: at its literal, or around it."""
        text = self.program.text
        vector = _literal_offset(form)
        if vector is None:
            return _wrapped(text, form, _translation(offset))
        numbers = [float(item.value) + x for item, x in zip(vector.items, offset, strict=True)]
        new = f"[{' '.join(_number(x) for x in numbers)}]"
        return text[: vector.span.start] + new + text[vector.span.end :]

    def _added(self, candidate: _Candidate, kind: str, part: str) -> tuple[Fault, Bodies] | None:
        """Return the program with another part beside a candidate."""
        start, end = candidate.form.span.start, candidate.form.span.end
        both = f"{self.program.text[start:end]} {part}"
        parent = candidate.parent
        listed = (
            isinstance(parent, ListDatum) and isinstance(parent.items[0], Atom) and parent.items[0].value == "union"
        )
        text = self.program.text[:start] + (both if listed else f"(union {both})") + self.program.text[end:]
        scene = self.program.evaluated(text)
        if scene is None or len(scene.frames) != 1:
            return None
        bodies, before = bodies_of(scene.root), self.bodies
        old: dict[tuple[object, ...], int] = {}
        for i in range(len(before)):
            old[_key(before, i)] = old.get(_key(before, i), 0) + 1
        fresh = []
        for i in range(len(bodies)):
            if old.get(_key(bodies, i), 0) > 0:
                old[_key(bodies, i)] -= 1
            else:
                fresh.append(int(bodies.row[i]))
        if not fresh or any(old.values()):
            return None
        words = Thing(bodies, fresh).words()
        return Fault(self.program.name, kind, text, frozenset(fresh), words, 0.0), bodies

    # --- kinds ---

    def _floating(self, candidate: _Candidate, thing: Thing, kind: str = "floating") -> Fault | None:
        if not self._stands(thing):
            return None
        height = float(thing.size[1]) * self.random.uniform(0.15, 0.8)
        height = min(max(height, 0.02 * self.bodies.size), 1.5 * float(thing.size.max()))
        return self._checked(self._moved(candidate, kind, _shift(0.0, height, 0.0)), lambda now: not len(now.others))

    def _sunk(self, candidate: _Candidate, thing: Thing, kind: str = "sunk") -> Fault | None:
        on_ground = abs(thing.low[1]) <= 2.0 * self.bodies.touch and self.ground == 0.0
        broad = thing.size[[0, 2]].prod() > 0.2 * (self.high - self.low)[[0, 2]].prod()
        if not on_ground or broad or not self._is_upright(thing):
            return None
        dip = float(thing.size[1]) * self.random.uniform(0.5, 0.9)
        if any(self.bodies.solids.form(int(i))[0].is_rounded for i in thing.own) and len(thing.own) == 1:
            return None  # a stone
        return self._checked(
            self._moved(candidate, kind, _shift(0.0, -dip, 0.0)), lambda now: dip > 10.0 * self.bodies.touch
        )

    def _loop(self, candidate: _Candidate, thing: Thing) -> Fault | None:
        """A wrong offset of all that a loop makes: it floats, or is in the ground."""
        if self.random.random() < 0.3:
            found = self._sunk(candidate, thing, "loop")
            if found is not None:
                return found
        # What one step of the loop stands on decides, so that others may stand elsewhere.
        things = [Thing(self.bodies, rows) for rows in candidate.instances]
        if not all(self._stands(each) for each in things):
            return None
        return self._floating(candidate, thing, "loop")

    def _penetrating(self, candidate: _Candidate, thing: Thing) -> Fault | None:
        if not self._stands(thing):
            return None
        low, high = self.bodies.boxes
        beside = (
            ~thing.mask
            & (low[:, 1] < thing.high[1] - 0.3 * thing.size[1])
            & (high[:, 1] > thing.low[1] + 0.3 * thing.size[1])
        )
        beside &= self.bodies.exact & self.bodies.opaque & ((high - low).max(axis=1) < 4.0 * thing.size.max())
        rows = np.flatnonzero(beside)
        if not len(rows):
            return None
        middle = (thing.low + thing.high) / 2.0
        away = (low[rows] + high[rows]) / 2.0 - middle
        other = int(rows[np.argmin(np.abs(away[:, [0, 2]]).sum(axis=1))])
        offset = ((low[other] + high[other]) / 2.0 - middle) * self.random.uniform(0.75, 0.95)
        found = self._moved(candidate, "penetrating", _shift(float(offset[0]), 0.0, float(offset[2])))

        def is_deep(now: Thing) -> bool:
            pairs = now.touching[(now.others == other)]
            if not len(pairs):
                return False
            depth, _ = depths(now.bodies.pairs(pairs))
            sides = (now.bodies.boxes[1] - now.bodies.boxes[0])[pairs].min(axis=(1, 2))
            return bool((depth > 0.3 * sides).any())

        return self._checked(found, is_deep)

    def _past_the_edge(self, candidate: _Candidate, thing: Thing) -> Fault | None:
        table = self._table(thing)
        if table is None:
            return None
        low, high = self.bodies.boxes
        center = thing.center
        moves = []
        for axis in (0, 2):
            for side in (-1.0, 1.0):
                edge = (high if side > 0 else low)[table, axis]
                reach = side * (edge - center[axis]) + self.random.uniform(0.05, 0.3) * thing.size[axis]
                # Part of it stays on the table.
                if (
                    reach > 0.0
                    and side * (edge - (thing.low if side > 0 else thing.high)[axis]) - reach > -0.45 * thing.size[axis]
                ):
                    moves.append((reach, axis, side))
        if not moves:
            return None
        reach, axis, side = min(moves)
        offset = [0.0, 0.0, 0.0]
        offset[axis] = side * reach
        found = self._moved(candidate, "past the edge", _shift(*offset))
        return self._checked(found, lambda now: set(now.others.tolist()) == {table} and not _carries(now, table))

    def _tilted(self, candidate: _Candidate, thing: Thing) -> Fault | None:
        base = thing.base
        lowest = self.bodies.solids.form(int(thing.own[np.argmin(self.bodies.boxes[0][thing.own, 1])]))[0]
        if not (self._stands(thing) and _is_similarity(candidate.frame)) or lowest.is_rounded or len(base) > 1:
            return None
        if thing.size[1] < 0.2 * thing.size.max():
            return None  # a sheet leans wherever it lies
        angle = self.random.uniform(0.25, 0.8) * self.random.choice([-1.0, 1.0])
        axis = self.random.choice([np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])])
        turn = _rotation(axis, angle)
        center = thing.center
        points = _corners(self.bodies, thing.own)
        lowest_now = float(((points - center) @ turn.T + center)[:, 1].min())
        motion = np.eye(4)
        motion[:3, :3] = turn
        motion[:3, 3] = center - turn @ center + [0.0, thing.low[1] - lowest_now, 0.0]
        pose = _rigid_pose(np.linalg.inv(candidate.frame) @ motion @ candidate.frame)
        found = self._moved(candidate, "tilted", motion, pose)
        return self._checked(
            found, lambda now: set(now.others.tolist()) <= set(base) and bool(base) == bool(len(now.others))
        )

    def _twin(self, candidate: _Candidate, thing: Thing) -> Fault | None:
        found = self._added(candidate, "twin", candidate.form.span.text)
        return found[0] if found is not None else None

    def _buried(self, candidate: _Candidate, thing: Thing) -> Fault | None:
        low, high = self.bodies.boxes
        room = ((high - low) * 0.55 > thing.size).all(axis=1) & ~thing.mask & self.bodies.exact & self.bodies.opaque
        if not room.any() or not self._stands(thing):
            return None
        outer = int(self.random.choice(np.flatnonzero(room).tolist()))
        offset = (low[outer] + high[outer] - thing.low - thing.high) / 2.0
        if low[outer, 1] < self.ground - self.bodies.touch:
            return None  # nobody looks for it below the ground
        found = self._moved(candidate, "buried", _shift(*offset.tolist()))

        def is_inside(now: Thing) -> bool:
            from scenelang.backends.geometry.hidden import holds_points

            return holds_points(now.bodies, outer, _corners(now.bodies, now.own))

        return self._checked(found, is_inside)

    def _scale(self, candidate: _Candidate, thing: Thing) -> Fault | None:
        """One of several equal things is too large."""
        if not (self._stands(thing) and _is_similarity(candidate.frame)):
            return None
        factor = self.random.uniform(1.8, 3.0)
        foot = (thing.low + thing.high) / 2.0
        foot[1] = thing.low[1]
        motion = np.eye(4)
        motion[:3, :3] *= factor
        motion[:3, 3] = foot * (1.0 - factor)
        local = np.linalg.inv(candidate.frame) @ motion @ candidate.frame
        pose = f"(@ {_translation(local[:3, 3])} (scale {_number(factor)}))"
        found = self._moved(candidate, "scale", motion, pose)
        words = thing.words()

        def overlaps(now: Thing) -> bool:
            pairs = np.array(
                [
                    p
                    for p, o in zip(now.touching.tolist(), now.others.tolist(), strict=True)
                    if now.bodies.words(o) == words
                ]
            )
            if not len(pairs):
                return False
            depth, _ = depths(now.bodies.pairs(pairs))
            sides = (now.bodies.boxes[1] - now.bodies.boxes[0])[pairs].min(axis=(1, 2))
            return bool((depth > 0.3 * sides).any())

        return self._checked(found, overlaps)

    def _hanging(self, candidate: _Candidate, thing: Thing) -> Fault | None:
        table = self._table(thing)
        if table is None or not self.bodies.exact[table]:
            return None
        low, high = self.bodies.boxes
        thickness = float(high[table, 1] - low[table, 1])
        if low[table, 1] - thing.size[1] < self.ground + 0.1 * thing.size[1] or thickness > 2.0 * thing.size.max():
            return None
        found = self._moved(candidate, "hanging", _shift(0.0, float(low[table, 1] - thing.high[1]), 0.0))
        return self._checked(found, lambda now: set(now.others.tolist()) == {table})

    def _fighting(self, candidate: _Candidate, thing: Thing) -> Fault | None:
        """Add a slab of another colour whose top is level with that of a block."""
        tops = [i for i in thing.own.tolist() if self._has_flat_top(i)]
        if not tops or not _is_similarity(candidate.frame):
            return None
        low, high = self.bodies.boxes
        body = max(tops, key=lambda i: float(high[i, 1]))
        size = (high[body] - low[body]) * [0.6, 0.5, 0.6]
        if size.min() < 4.0 * self.bodies.touch:
            return None
        place = (low[body] + high[body]) / 2.0
        place[1] = high[body, 1] - size[1] / 2.0
        place[0] += 0.45 * (high[body, 0] - low[body, 0])
        color = "[.9 0 .9]" if self.bodies.colors[body][1] > 0.3 else "[.9 1 0]"
        return self._slab(candidate, "fighting", size, place, color)

    def _top_heavy(self, candidate: _Candidate, thing: Thing) -> Fault | None:
        """Add a beam to the top of a thing that is so long that it topples."""
        if not (self._stands(thing) and _is_similarity(candidate.frame)) or thing.size[1] < 0.6 * thing.size[0]:
            return None
        breadth = float(thing.size[0])
        size = np.array([5.0 * breadth, 0.3 * float(thing.size[1]), max(0.8 * float(thing.size[2]), 1e-9)])
        place = (thing.low + thing.high) / 2.0
        place[0] += size[0] / 2.0 - 0.1 * breadth
        place[1] = thing.high[1] - 0.1 * size[1] + size[1] / 2.0
        fault = self._slab(candidate, "top-heavy", size, place, "")
        if fault is None:
            return None
        scene = self.program.evaluated(fault.text)
        assert scene is not None
        bodies = bodies_of(scene.root)
        beam = Thing(bodies, sorted(fault.rows))
        below = {_key(self.bodies, int(i)) for i in thing.own}
        if not len(beam.others) or any(_key(bodies, int(o)) not in below for o in beam.others):
            return None
        rows = fault.rows | {int(bodies.row[i]) for i in range(len(bodies)) if _key(bodies, i) in below}
        return replace(fault, rows=frozenset(rows))

    def _slab(self, candidate: _Candidate, kind: str, size: FloatArray, place: FloatArray, color: str) -> Fault | None:
        """Add a box of the world's axes."""
        inverse = np.linalg.inv(candidate.frame)
        scale = float(np.cbrt(abs(np.linalg.det(candidate.frame[:3, :3]))))
        turn = inverse[:3, :3] * scale
        center = (inverse @ np.append(place, 1.0))[:3]
        look = f" :color {color}" if color else ""
        box = f'(call "cube" :scale [{" ".join(_number(x) for x in size / scale)}]{look})'
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = turn, center
        found = self._added(candidate, kind, f"(transform {box} {_rigid_pose(pose)})")
        return found[0] if found is not None else None

    # --- conditions ---

    def _stands(self, thing: Thing) -> bool:
        """Whether a thing stands free on something, or on the ground."""
        on_ground = not len(thing.others) and thing.low[1] <= self.ground + 2.0 * self.bodies.touch
        return self._is_upright(thing) and (on_ground or bool(thing.base))

    def _is_upright(self, thing: Thing) -> bool:
        broad = thing.size[[0, 2]].prod() > 0.35 * (self.high - self.low)[[0, 2]].prod()
        return (
            not broad
            and bool(self.bodies.opaque[thing.own].all())
            and bool((thing.size > 3.0 * self.bodies.touch).all())
        )

    def _table(self, thing: Thing) -> int | None:
        """Return the one body above the ground that a thing stands on."""
        base = thing.base
        if len(base) != 1 or not self._stands(thing) or not self.bodies.exact[base[0]]:
            return None
        low, high = self.bodies.boxes
        return (
            base[0]
            if high[base[0], 1] > self.ground + 2.0 * self.bodies.touch
            and low[base[0], 1] >= self.ground - self.bodies.touch
            else None
        )

    def _has_flat_top(self, i: int) -> bool:
        form, _ = self.bodies.solids.form(i)
        matrix = self.bodies.solids.matrices[i, :, :3]
        straight = np.count_nonzero(np.abs(matrix) > 1e-9 * np.abs(matrix).max()) == 3
        if form is not BLOCK or not straight or not self.bodies.opaque[i]:
            return False
        low, high = self.bodies.boxes
        # Nothing covers the place at its side where the slab goes.
        start, end = low[i].copy(), high[i].copy()
        start[0] = (low[i, 0] + high[i, 0]) / 2.0
        end[0] += 0.3 * (high[i, 0] - low[i, 0])
        start[1] = high[i, 1] - 2.0 * self.bodies.touch
        end[1] = high[i, 1] + 2.0 * self.bodies.touch
        near = ((low < end) & (high > start)).all(axis=1)
        near[i] = False
        return not near.any()

    def _checked(self, found: tuple[Fault, Bodies] | None, holds: Callable[[Thing], bool]) -> Fault | None:
        if found is None:
            return None
        fault, bodies = found
        return fault if holds(Thing(bodies, sorted(fault.rows))) else None


def _literal_offset(form: ListDatum) -> ArrayDatum | None:
    """Return the literal vector of the last translation of a form, None if there is none."""
    if not (isinstance(form.items[0], Atom) and form.items[0].value == "transform" and len(form.items) == 3):
        return None
    pose = form.items[2]
    while isinstance(pose, ListDatum) and pose.items and isinstance(pose.items[0], Atom):
        head = pose.items[0].value
        if head == "@" and len(pose.items) > 1:
            pose = pose.items[1]
            continue
        vector = pose.items[1] if head == "translate" and len(pose.items) == 2 else None
        if isinstance(vector, ArrayDatum) and len(vector.items) == 3:
            numbers = all(isinstance(x, Atom) and type(x.value) in (int, float) for x in vector.items)
            return vector if numbers else None
        return None
    return None


def _key(bodies: Bodies, i: int) -> tuple[object, ...]:
    return (bodies.words(i)[-1], *np.round(bodies.solids.matrices[i].ravel() / max(bodies.size, 1e-9), 5).tolist())


def _shift(x: float, y: float, z: float) -> FloatArray:
    motion = np.eye(4)
    motion[:3, 3] = (x, y, z)
    return motion


def _rotation(axis: FloatArray, angle: float) -> FloatArray:
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross, np.float64)


def _is_similarity(frame: FloatArray) -> bool:
    gram = frame[:3, :3].T @ frame[:3, :3]
    return bool(np.allclose(gram, np.eye(3) * gram[0, 0], atol=1e-6 * gram[0, 0]) and np.linalg.det(frame) > 0.0)


def _rigid_pose(pose: FloatArray) -> str:
    """Return a rotation and a translation as a pose of the language."""
    turn = pose[:3, :3]
    angle = math.acos(min(1.0, max(-1.0, (float(np.trace(turn)) - 1.0) / 2.0)))
    move = _translation(pose[:3, 3])
    if angle < 1e-9:
        return move
    values, vectors = np.linalg.eigh((turn + turn.T) / 2.0)
    axis = vectors[:, int(np.argmax(values))]
    if np.allclose(_rotation(axis, -angle), turn, atol=1e-6):
        axis = -axis
    numbers = " ".join(f"{float(x):.9g}" for x in axis)
    return f"(@ {move} (rotate {angle:.9g} [{numbers}]))"


def _corners(bodies: Bodies, rows: npt.NDArray[np.int64]) -> FloatArray:
    """Return points (K, 3) whose hull is that of bodies."""
    found = []
    for i in rows.tolist():
        form, ratios = bodies.solids.form(i)
        matrix = bodies.solids.matrices[i]
        found.append(form.mesh(48, ratios).vertices @ matrix[:, :3].T + matrix[:, 3])
    return np.concatenate(found)


def _carries(thing: Thing, table: int) -> bool:
    """Whether the centre of mass of a thing is above a body that it touches."""
    from scenelang.backends.geometry.hidden import holds_points

    point = thing.center
    low, high = thing.bodies.boxes
    heights = np.linspace(low[table, 1], high[table, 1], 9)[1:-1]
    return any(holds_points(thing.bodies, table, np.array([[point[0], y, point[2]]])) for y in heights)

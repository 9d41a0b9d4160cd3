"""The statics of the facts against MuJoCo, whose models are written here from the shapes, and hard cases by name.

A scene stays if no object of it moves by 3 % of its size or turns by 10 degrees in 2 s, with every center of mass
shifted by 1 % of the breadth to either side of either axis, and with a push.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from scenelang.backends.facts.frame import FrameFacts
from scenelang.backends.geometry.lint import check_geometry
from scenelang.grammar.datum import Source
from scenelang.interpreter.scene.entity import Scene
from scenelang.session.session import Session

FloatArray = npt.NDArray[np.float64]
Vector = tuple[float, float, float]

COUNT = 200
X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
SIDES = 64  # of the prisms that stand for standing cylinders and cones, as in the facts
FRICTION = 0.6
STEP, SECONDS = 0.001, 2.0
MOVED, TURNED = 0.03, math.radians(10.0)
SHIFT, PUSH = 0.01, 0.001  # of the breadth; metres per second for each metre of size
session = Session()


# --- scenes ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Piece:
    """A shape about its middle: "box" (sizes), "cylinder", "cone" and "capsule" (radius, length along y), "sphere"
    (radius), or "prism" (a convex profile, and its depth along z)."""

    kind: str
    sizes: tuple[float, ...]
    at: Vector = (0.0, 0.0, 0.0)
    angle: float = 0.0
    axis: Vector = Z
    profile: tuple[tuple[float, float], ...] = ()

    @property
    def text(self) -> str:
        a = self.sizes
        ends = f":p0 [0 {-a[-1] / 2!r} 0] :p1 [0 {a[-1] / 2!r} 0]"
        if self.kind == "box":
            shape = f'(call "cube" :scale [{a[0]!r} {a[1]!r} {a[2]!r}])'
        elif self.kind == "sphere":
            shape = f'(call "sphere" :radius {a[0]!r})'
        elif self.kind == "prism":
            shape = f"(extrude (list {' '.join(f'[{x!r} {y!r}]' for x, y in self.profile)}) {a[0]!r} :center #t)"
        else:
            shape = f'(call "{self.kind}" :radius {a[0]!r} {ends})'
        turn = f"(rotate {self.angle!r} [{' '.join(map(repr, self.axis))}])"
        return f"(transform {shape} (@ (translate [{' '.join(map(repr, self.at))}]) {turn}))"

    @property
    def turned(self) -> FloatArray:
        """Its rotation (3, 3)."""
        k = np.cross(np.eye(3), self.axis)
        return np.asarray(np.eye(3) + math.sin(self.angle) * k + (1.0 - math.cos(self.angle)) * k @ k, np.float64)

    @property
    def corners(self) -> FloatArray:
        """Points (K, 3) whose convex hull it is, but for the ends of capsules and spheres."""
        a = self.sizes
        if self.kind == "box":
            own = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * a
        elif self.kind == "prism":
            own = np.array([[x, y, s * a[0]] for s in (-0.5, 0.5) for x, y in self.profile])
        elif self.kind == "sphere":
            own = np.concatenate([np.eye(3), -np.eye(3)]) * a[0]
        else:
            turn = np.arange(SIDES) * (2.0 * math.pi / SIDES)
            circle = np.stack([np.cos(turn), 0.0 * turn, np.sin(turn)], axis=1) * a[0]
            half = np.array([0.0, a[1] / 2.0, 0.0])
            top = half[None] if self.kind == "cone" else circle + half
            own = np.concatenate([circle - half, top])
        return np.asarray(own @ self.turned.T + self.at, np.float64)

    def geom(self, name: str, middle: FloatArray, friction: float | None) -> tuple[str, str]:
        """Its mesh, if it needs one, and its geom."""
        a, place = self.sizes, np.subtract(self.at, middle)
        rest = f'friction="{FRICTION if friction is None else friction!r} 0 0" priority="{int(friction is not None)}"'
        if self.kind == "box":
            quaternion = (math.cos(self.angle / 2.0), *(math.sin(self.angle / 2.0) * k for k in self.axis))
            return "", (f'<geom type="box" size="{_numbers(np.array(a) / 2.0)}" pos="{_numbers(place)}" '
                        f'quat="{_numbers(quaternion)}" {rest}/>')  # fmt: skip
        if self.kind == "sphere":
            return "", f'<geom type="sphere" size="{a[0]!r}" pos="{_numbers(place)}" {rest}/>'
        along = self.turned[:, 1] * a[-1] / 2.0
        if self.kind == "capsule" or (self.kind == "cylinder" and abs(along[1]) < 0.9 * a[-1] / 2.0):
            ends = _numbers([*(place - along), *(place + along)])
            return "", f'<geom type="{self.kind}" size="{a[0]!r}" fromto="{ends}" {rest}/>'
        mesh = f'<mesh name="{name}" vertex="{_numbers((self.corners - middle).ravel())}"/>'
        return mesh, f'<geom type="mesh" mesh="{name}" {rest}/>'


def _numbers(values: Iterable[float]) -> str:
    return " ".join(repr(float(value)) for value in values)


@dataclass(frozen=True)
class Thing:
    """An object: one body. ``rolls`` is the axis about which it is round, or "ball"; its center is on it."""

    pieces: tuple[Piece, ...]
    fixed: bool = False
    friction: float | None = None
    rolls: Vector | str = ""

    @property
    def corners(self) -> FloatArray:
        return np.concatenate([piece.corners for piece in self.pieces])

    @property
    def size(self) -> FloatArray:
        return np.asarray(np.ptp(self.corners, axis=0), np.float64)

    def moved(self, x: float, y: float, z: float) -> Thing:
        places = [(piece.at[0] + x, piece.at[1] + y, piece.at[2] + z) for piece in self.pieces]
        return replace(self, pieces=tuple(replace(piece, at=at) for piece, at in zip(self.pieces, places)))

    def on(self, height: float) -> Thing:
        """It, with its lowest point at a height."""
        return self.moved(0.0, height - float(self.corners[:, 1].min()), 0.0)


@dataclass(frozen=True)
class Example:
    """A scene, with the verdict that its construction says, if that is known."""

    name: str
    things: tuple[Thing, ...]
    wanted: bool | None = None

    @property
    def text(self) -> str:
        words = [
            f'(bind "thing-{k}" (lambda () (union {" ".join(piece.text for piece in thing.pieces)})))'
            for k, thing in enumerate(self.things)
        ]
        calls = [
            f'(call "thing-{k}"{" :fixed #t" * thing.fixed}'
            + (f" :friction {thing.friction!r})" if thing.friction is not None else ")")
            for k, thing in enumerate(self.things)
        ]
        return "\n".join([*words, f'(bind "yard" (lambda () (union {" ".join(calls)})))', '(scene "yard")'])


def box(x: float, y: float, z: float, w: float, h: float, d: float, angle: float = 0.0, **options: Any) -> Thing:
    return Thing((Piece("box", (w, h, d), (x, y, z), angle),), **options)


def prism(profile: Sequence[tuple[float, float]], depth: float, **options: Any) -> Thing:
    middle = np.mean(profile, axis=0)
    points = tuple((float(x - middle[0]), float(y - middle[1])) for x, y in profile)
    return Thing((Piece("prism", (depth,), (float(middle[0]), float(middle[1]), 0.0), profile=points),), **options)


def round_thing(
    kind: str, radius: float, length: float = 0.0, angle: float = 0.0, axis: Vector = Z, **options: Any
) -> Thing:
    sizes = (radius,) if kind == "sphere" else (radius, length)
    return Thing((Piece(kind, sizes, angle=angle, axis=axis),), **options)


def pile(things: Sequence[Thing]) -> tuple[Thing, ...]:
    """Things, each lowered or raised onto the one before."""
    placed: list[Thing] = []
    for thing in things:
        placed.append(thing.on(float(placed[-1].corners[:, 1].max()) if placed else 0.0))
    return tuple(placed)


def stacked(random: Random) -> Example:
    count, spread = random.randint(2, 6), random.uniform(0.2, 0.9)
    sizes = [(random.uniform(0.5, 1.2), random.uniform(0.15, 0.6), random.uniform(0.5, 1.2)) for _ in range(count)]
    middles = [np.zeros(2)]
    for (w, _, d), (u, _, e) in pairwise(sizes):
        step = [random.uniform(-spread, spread) * (w + u) / 2.0, random.uniform(-spread, spread) * (d + e) / 2.0]
        middles.append(middles[-1] + step)
    return Example(
        "stack",
        pile([box(float(x), 0.0, float(z), *size) for (x, z), size in zip(middles, sizes)]),
        _stands(middles, sizes),
    )


def _stands(middles: Sequence[FloatArray], sizes: Sequence[Vector]) -> bool:
    """Whether a stack of boxes stands, with a shift: the boxes above each are over what it shares with the next."""
    mass = np.prod(sizes, axis=1)
    for k in range(1, len(sizes)):
        center = (np.array(middles[k:]) * mass[k:, None]).sum(axis=0) / mass[k:].sum()
        half, lower = np.array([sizes[k][0], sizes[k][2]]) / 2.0, np.array([sizes[k - 1][0], sizes[k - 1][2]]) / 2.0
        shift = (
            SHIFT
            * 2.0
            * (np.array([[s[0], s[2]] for s in sizes[k:]]) / 2.0 * mass[k:, None]).sum(axis=0)
            / mass[k:].sum()
        )
        low, high = (
            np.maximum(middles[k] - half, middles[k - 1] - lower),
            np.minimum(middles[k] + half, middles[k - 1] + lower),
        )
        if (center - shift < low).any() or (center + shift > high).any():
            return False
    return True


def harmonic(random: Random) -> Example:
    count, factor, length = random.randint(3, 7), random.uniform(0.85, 1.15), random.uniform(0.6, 1.5)
    height, x, things = random.uniform(0.08, 0.25), 0.0, list[Thing]()
    for k in range(count - 1, -1, -1):
        things.append(box(x, 0.0, 0.0, length, height, length / 2.0))
        x += factor * length / (2.0 * k) if k else 0.0
    return Example(f"harmonic x {factor:.3f}", pile(things), factor < 1.0 - 2.0 * SHIFT)


def voussoir(inner: float, outer: float, a: float, b: float, **options: Any) -> Thing:
    """A stone of an arch, between two angles and two radii."""
    corners = [
        (radius * math.cos(k), radius * math.sin(k)) for radius, k in ((inner, b), (outer, b), (outer, a), (inner, a))
    ]
    return prism(corners, 0.4, **options)


def arch(random: Random) -> Example:
    count, radius = random.choice((5, 7, 9, 11)), random.uniform(0.6, 1.2)
    thickness, half = radius * random.uniform(0.04, 0.25), math.radians(random.choice((90.0, 90.0, 75.0, 60.0)))
    angles = np.linspace(math.pi / 2.0 + half, math.pi / 2.0 - half, count + 1)
    inner, outer = radius - thickness / 2.0, radius + thickness / 2.0
    missing, mu = count // 2 if random.random() < 0.3 else -1, random.choice((None, None, 0.4, 0.2))
    stones = [
        voussoir(inner, outer, a, b, friction=mu)
        for k, (a, b) in enumerate(pairwise(angles.tolist())) if k != missing
    ]  # fmt: skip
    things, height = [stone.moved(0.0, 0.5, 0.0) for stone in stones], 0.5
    for side in (-1.0, 1.0):  # springers, below the ends
        (a, b), (c, d) = ((radius * math.sin(half), radius * math.cos(half)) for radius in (inner, outer))
        edge = [(a, b + height), (c, d + height), (c + 0.2, d + height), (c + 0.2, 0.0), (a, 0.0)]
        edge = [(side * x, y) for x, y in edge]
        things.append(prism(edge if side < 0.0 else edge[::-1], 0.4, fixed=True))
    name = (
        f"arch of {count}, {2.0 * math.degrees(half):.0f} deg, t/R {thickness / radius:.3f}, friction {mu or FRICTION}"
    )
    return Example(name + ", no keystone" * (missing >= 0), tuple(things), False if missing >= 0 else None)


def leaning(random: Random) -> Example:
    angle, length = math.radians(random.uniform(25.0, 72.0)), random.uniform(1.0, 2.0)
    friction, thick = random.choice((None, 0.2, 0.3, 0.4, 0.5)), random.uniform(0.04, 0.1)
    board = box(0.0, 0.0, 0.0, length, thick, random.uniform(0.2, 0.6), angle, friction=friction).on(0.0)
    board = board.moved(-float(board.corners[:, 0].max()), 0.0, 0.0)
    mu = FRICTION if friction is None else friction
    foot, middle = float(board.corners[np.argmin(board.corners[:, 1]), 0]), board.pieces[0].at[0]
    rise = float(board.corners[np.argmax(board.corners[:, 0]), 1])
    push = mu / (1.0 + mu * mu)  # at the wall when both ends slip, in weights; with mu times that upwards
    wanted = push * (rise - mu * foot) > middle - foot  # moments about the foot
    wall = box(0.15, 1.25, 0.0, 0.3, 2.5, 1.2, fixed=True)
    return Example(f"board at {math.degrees(angle):.0f} deg, friction {mu}", (wall, board), wanted)


def hanging(random: Random) -> Example:
    slope, mu = math.radians(random.uniform(-45.0, 45.0)) * random.choice((0, 1, 1)), random.choice((None, 0.2, 0.4))
    (along, down), half, bar = (math.cos(slope), math.sin(slope)), 0.03, 0.05
    at = (0.25 * along, 2.0 - 0.25 * down, 0.0)
    kind = random.choice(("box", "cylinder"))
    peg = Piece("box", (0.6, 0.06, 0.06), at, -slope)
    peg = peg if kind == "box" else Piece("cylinder", (half, 0.6), at, -slope - math.pi / 2.0)
    wall = [Piece("box", (0.1, 2.4, 1.0), (-0.05, 1.2, 0.0)), peg]
    stopped = random.random() < 0.3
    if stopped:
        wall.append(Piece("box", (0.05, 0.3, 0.06), (0.54 * along, 2.1 - 0.54 * down, 0.0)))
    wide, tall = random.uniform(0.3, 0.6), random.uniform(0.4, 0.8)
    x, y = at[0] + down * (half + bar / 2.0), at[1] + along * (half + bar / 2.0)
    bars = [Piece("box", (bar, bar, wide), (x, y, 0.0), -slope)]  # flat on the peg
    for side in (-1.0, 1.0):
        bars.append(Piece("box", (bar, tall, bar), (x, y - tall / 2.0 + bar / 2.0, side * (wide - bar) / 2.0)))
    bars.append(Piece("box", (bar, bar, wide), (x, y - tall + bar, 0.0)))
    ring, beside = Thing(tuple(bars), friction=mu), random.random() < 0.25
    if beside:
        ring = ring.moved(0.0, random.uniform(0.1, 0.6) * tall, half + wide / 2.0)  # a side bar touches the peg
    name = f"ring on a {kind} peg at {math.degrees(slope):.0f} deg, friction {mu or FRICTION}"
    name += ", with a stop" * stopped + ", beside it" * beside
    return Example(name, (Thing(tuple(wall), fixed=True), ring), False if beside else None if slope else True)


def walls(gap: float) -> list[Thing]:
    return [box(side * (gap / 2.0 + 0.15), 1.0, 0.0, 0.3, 2.0, 1.0, fixed=True) for side in (-1.0, 1.0)]


def between(random: Random) -> Example:
    case = random.choice(("clamped", "wedged", "upside down", "on ledges", "bridge", "one wall", "tight"))
    depth = random.uniform(0.4, 0.8)
    width, height = random.uniform(0.4, 0.9), random.uniform(0.3, 0.6)
    base, mu = random.uniform(0.6, 1.2), random.choice((None, 0.3, 0.9))
    if case in ("clamped", "one wall", "tight"):
        block = box(0.0, base + height / 2.0, 0.0, width, height, depth, friction=mu)
        sides = walls(width)[: 1 if case == "one wall" else 2]
        return Example(f"{case}, friction {mu or FRICTION}", (*sides, block), False)
    if case in ("wedged", "upside down"):
        lean = math.radians(random.uniform(4.0, 50.0)) * (1.0 if case == "wedged" else -1.0)
        grow = height * math.tan(lean)
        low, high = width / 2.0 - (grow if grow < 0.0 else 0.0), width / 2.0 + (grow if grow > 0.0 else 0.0)
        block = prism([(-low, base), (low, base), (high, base + height), (-high, base + height)], depth, friction=mu)
        up, down = 2.0 - base, base
        slope = math.tan(lean)
        top, foot = low + slope * up, low - slope * down
        far = max(top, foot) + 0.3
        side = [(foot, 0.0), (far, 0.0), (far, 2.0), (top, 2.0)]
        fixed = [prism(side, 1.0, fixed=True), prism([(-x, y) for x, y in side][::-1], 1.0, fixed=True)]
        name = f"{case}, sides at {math.degrees(lean):.0f} deg, friction {mu or FRICTION}"
        return Example(name, (*fixed, block), case == "wedged")
    if case == "on ledges":
        reach = random.uniform(0.02, 0.2)
        ledged = (
            Piece("box", (0.3, 2.0, 1.0), (width / 2.0 + 0.15, 1.0, 0.0)),
            Piece("box", (reach, 0.1, 1.0), (width / 2.0 - reach / 2.0, base - 0.05, 0.0)),
        )
        sides = [Thing(ledged, fixed=True)]
        if random.random() < 0.6:
            sides.append(Thing(tuple(replace(p, at=(-p.at[0], p.at[1], 0.0)) for p in ledged), fixed=True))
        block = box(0.0, base + height / 2.0, 0.0, width, height, depth, friction=mu)
        return Example(f"on {len(sides)} ledges", (*sides, block), len(sides) == 2)
    gap = random.uniform(0.3, 1.0)
    length = random.uniform(0.5, 2.0)
    x = random.uniform(-0.5, 0.5)
    beam = box(x, 2.0 + height / 2.0, 0.0, length, height, depth)
    pillars = walls(gap)
    ends = [x - length / 2.0, x + length / 2.0]
    spans = [
        (max(ends[0], s * (gap / 2.0 + 0.15) - 0.15), min(ends[1], s * (gap / 2.0 + 0.15) + 0.15)) for s in (-1.0, 1.0)
    ]
    held = [s for s in spans if s[1] > s[0]]
    wanted = bool(held) and held[0][0] < x - SHIFT * length and held[-1][1] > x + SHIFT * length
    return Example("bridge", (*pillars, beam), wanted)


def table(random: Random) -> Example:
    wide, deep, height = random.uniform(0.8, 1.6), random.uniform(0.6, 1.0), random.uniform(0.5, 0.9)
    inset, leg = random.uniform(0.05, 0.2), random.choice((0.06, 0.1))
    corners = [
        (sx * (wide / 2.0 - inset), sz * (deep / 2.0 - inset)) for sx, sz in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    kept = random.choice(((0, 1, 2, 3), (0, 1, 2), (0, 1, 2), (0, 2), (0, 1), (0,)))
    legs = [Piece("box", (leg, height, leg), (corners[k][0], height / 2.0, corners[k][1])) for k in kept]
    things = [Thing((Piece("box", (wide, 0.06, deep), (0.0, height + 0.03, 0.0)), *legs))]
    for _ in range(random.randint(0, 2)):
        size = random.uniform(0.15, 0.35)
        load = box(random.uniform(-0.6, 0.6) * wide, 0.0, random.uniform(-0.45, 0.45) * deep, size, size, size)
        others = [other.pieces[0] for other in things[1:]]
        apart = [np.abs(np.subtract(o.at, load.pieces[0].at))[[0, 2]].max() - (size + o.sizes[0]) / 2.0 for o in others]
        if min(apart, default=1.0) > 0.02:
            things.append(load.on(height + 0.06))
    return Example(f"table on {len(kept)} legs, {len(things) - 1} loads", tuple(things))


def cantilever(random: Random) -> Example:
    base = box(0.0, 0.0, 0.0, random.uniform(0.5, 0.8), random.uniform(0.3, 0.8), 0.6)
    length, out = random.uniform(1.2, 2.2), random.uniform(0.1, 0.9)
    half = base.pieces[0].sizes[0] / 2.0
    plank = box(half + out - length / 2.0, 0.0, 0.0, length, 0.08, 0.4)
    plank = plank if random.random() < 0.8 else plank.moved(0.25 * length, 0.0, 0.0)
    things = list(pile([base, plank]))
    top, middle = float(things[-1].corners[:, 1].max()), things[-1].pieces[0].at[0]
    for side in random.choice(((-1.0,), (1.0,), (-1.0, 1.0), (-1.0, 1.0))):
        size = random.uniform(0.15, 0.38)
        reach = random.uniform(0.6, 1.02)
        things.append(box(middle + side * reach * (length - size) / 2.0, 0.0, 0.0, size, size, size).on(top))
    return Example("cantilever", tuple(things), _on_base(things))


def _on_base(things: Sequence[Thing]) -> bool | None:
    """Whether a plank on a base stands with what lies on it, with a shift."""
    base, plank, *loads = things
    half = base.size[0] / 2.0
    low = max(-half, float(plank.corners[:, 0].min()))
    high = min(half, float(plank.corners[:, 0].max()))
    mass = np.array([np.prod(thing.pieces[0].sizes) for thing in (plank, *loads)])
    x, breadth = np.array([t.pieces[0].at[0] for t in (plank, *loads)]), np.array([t.size[0] for t in (plank, *loads)])
    center, shift = float(x @ mass / mass.sum()), float(breadth @ mass / mass.sum()) * SHIFT
    return bool(low < center - shift and center + shift < high)


ROUND: dict[str, Callable[[float, float], tuple[list[Thing], bool | None]]] = {
    "cone on its base": lambda r, h: ([round_thing("cone", r, h)], True),
    "cone on its tip": lambda r, h: ([round_thing("cone", r, h, math.pi)], False),
    "cylinder": lambda r, h: ([round_thing("cylinder", r, h)], True),
    "lying cylinder": lambda r, h: ([round_thing("cylinder", r, h, math.pi / 2.0, rolls=X)], True),
    "ball": lambda r, h: ([round_thing("sphere", r, rolls="ball")], True),
    "lying capsule": lambda r, h: ([round_thing("capsule", r, h, math.pi / 2.0, rolls=X)], True),
    "capsule on its end": lambda r, h: ([round_thing("capsule", r, h + r).moved(0.0, h / 2.0 + 1.5 * r, 0.0)], False),
    "cylinder on its edge": lambda r, h: ([round_thing("cylinder", r, h, 0.5 * math.atan2(2.0 * r, h))], False),
    "cylinder on a box": lambda r, h: (
        [box(0.0, 0.0, 0.0, 2.0 * r, 0.4, 2.0 * r), round_thing("cylinder", r, h).moved(0.9 * (h - 0.2), 0.0, 0.0)], 0.9 * (h - 0.2) < 0.98 * r),
    "ball on a box": lambda r, h: ([box(0.0, 0.0, 0.0, 3.0 * r, h, 3.0 * r), round_thing("sphere", r, rolls="ball")], True),
    "ball on a cylinder that lies": lambda r, h: (
        [round_thing("cylinder", r, h, math.pi / 2.0, rolls=X), round_thing("sphere", r, rolls="ball")], False),
    "box on a ball": lambda r, h: ([round_thing("sphere", r, rolls="ball"), box(0.0, 0.0, 0.0, r, 0.3 * h, r)], False),
    "box on a cone's tip": lambda r, h: ([round_thing("cone", r, h), box(0.0, 0.0, 0.0, r, 0.2, r)], False),
    "plank across a lying cylinder": lambda r, h: (
        [round_thing("cylinder", r, h, math.pi / 2.0, axis=X, rolls=Z), box(0.0, 0.0, 0.0, 4.0 * r, 0.1, 0.3)], False),
    "cone on a cylinder": lambda r, h: ([round_thing("cylinder", r, h), round_thing("cone", 1.2 * r, h)], True),
    "box on a cylinder": lambda r, h: (
        [round_thing("cylinder", r, h), box(1.1 * (h - 0.2), 0.0, 0.0, r, r, r)], None),
}  # fmt: skip


def rounded(random: Random) -> Example:
    name = random.choice(sorted(ROUND))
    things, wanted = ROUND[name](random.uniform(0.15, 0.4), random.uniform(0.3, 0.8))
    if name == "capsule on its end":
        return Example(name, tuple(things), wanted)
    if name in ("ball", "lying capsule"):
        radius = things[0].pieces[0].sizes[0]
        return Example(name, (things[0].moved(0.0, radius, 0.0),), wanted)
    return Example(name, pile(things), wanted)


def ramp(random: Random) -> Example:
    slope, mu = math.radians(random.uniform(3.0, 45.0)), random.choice((None, 0.1, 0.3, 0.5, 0.9))
    length = 2.0
    run, rise = length * math.cos(slope), length * math.sin(slope)
    wedge = prism([(0.0, 0.0), (run, 0.0), (run, rise)], 1.0, fixed=True)
    kind, size = random.choice(("box", "box", "box", "tall box", "sphere", "cylinder")), random.uniform(0.15, 0.4)
    tall = size * (random.uniform(1.5, 4.0) if kind == "tall box" else random.uniform(0.3, 1.0))
    height = size if kind in ("sphere", "cylinder") else tall / 2.0
    at = (run / 2.0 - math.sin(slope) * height, rise / 2.0 + math.cos(slope) * height, 0.0)
    wanted = False
    if kind in ("sphere", "cylinder"):
        rolls = "ball" if kind == "sphere" else Z
        piece = Piece(
            kind, (size,) if kind == "sphere" else (size, 0.5), at, *(() if kind == "sphere" else (math.pi / 2.0, X))
        )
        thing = Thing((piece,), friction=mu, rolls=rolls)
    else:
        thing = box(at[0], at[1], 0.0, size, tall, size, slope, friction=mu)
        wanted = math.tan(slope) < min(mu or FRICTION, size / tall)
    return Example(
        f"{kind} on a ramp at {math.degrees(slope):.0f} deg, friction {mu or FRICTION}", (wedge, thing), wanted
    )


FAMILIES: tuple[tuple[Callable[[Random], Example], int], ...] = (
    (stacked, 30), (harmonic, 20), (arch, 20), (leaning, 20), (hanging, 15), (between, 20), (table, 20),
    (cantilever, 20), (rounded, 20), (ramp, 15),
)  # fmt: skip


@cache
def examples() -> tuple[Example, ...]:
    """The scenes; each has a stream of random numbers of its own."""
    every = [make for make, count in FAMILIES for _ in range(count)]
    made = [make(Random(1_000 + k)) for k, make in enumerate(every)]
    return tuple(replace(example, name=f"{k} {example.name}") for k, example in enumerate(made))


# --- MuJoCo ----------------------------------------------------------------------------------------------------------


def model_of(example: Example) -> str:
    meshes, bodies = [], []
    for k, thing in enumerate(example.things):
        middle = np.zeros(3) if thing.fixed else (thing.corners.min(axis=0) + thing.corners.max(axis=0)) / 2.0
        parts = [piece.geom(f"m{k}-{i}", middle, thing.friction) for i, piece in enumerate(thing.pieces)]
        meshes += [mesh for mesh, _ in parts]
        geoms, joint = "".join(geom for _, geom in parts), "" if thing.fixed else "<freejoint/>"
        place = " ".join(map(repr, middle.tolist()))
        bodies.append(f'<body name="thing-{k}" pos="{place}" simple="false">{joint}{geoms}</body>')
    return f"""<mujoco><option timestep="{STEP}" gravity="0 -9.81 0" cone="elliptic" impratio="20" solver="Newton"
        iterations="100" tolerance="1e-10" integrator="implicitfast"><flag multiccd="enable"/></option>
        <default><geom solref="{2.0 * STEP} 1" solimp=".98 .999 .0001" condim="3" density="1000"/></default>
        <asset>{"".join(meshes)}</asset>
        <worldbody><geom type="plane" size="20 20 1" zaxis="0 1 0" friction="{FRICTION} 0 0"/>{"".join(bodies)}</worldbody>
        </mujoco>"""


def simulated(example: Example) -> dict[str, tuple[float, float, str]]:
    """The objects that move, with the largest share of their size and angle in degrees of all runs."""
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string(model_of(example))
    loose = [(k, thing) for k, thing in enumerate(example.things) if not thing.fixed]
    number = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, f"thing-{k}") for k, _ in loose]
    centers = model.body_ipos.copy()
    moved: dict[str, tuple[float, float, str]] = {}
    for name, shift in (("+x", X), ("-x", (-1.0, 0.0, 0.0)), ("+z", Z), ("-z", (0.0, 0.0, -1.0)), ("push", None)):
        model.body_ipos[:] = centers
        data = mujoco.MjData(model)
        for (_, thing), body in zip(loose, number):
            if shift is not None:
                model.body_ipos[body] += _shift_of(thing, np.array(shift))
        mujoco.mj_setConst(model, data)
        mujoco.mj_resetData(model, data)
        if shift is None:
            for (k, thing), body in zip(loose, number):
                start, angle = model.jnt_dofadr[model.body_jntadr[body]], 2.4 * k + 0.4
                speed = PUSH * float(np.linalg.norm(thing.size))
                data.qvel[start : start + 3] = speed * math.cos(angle), 0.0, speed * math.sin(angle)
        mujoco.mj_forward(model, data)
        before, turned = data.xipos.copy(), data.xquat.copy()
        for _ in range(round(SECONDS / STEP)):
            mujoco.mj_step(model, data)
        for (k, thing), body in zip(loose, number):
            share = float(np.linalg.norm(data.xipos[body] - before[body]) / np.linalg.norm(thing.size))
            angle = 2.0 * math.acos(min(1.0, abs(float(data.xquat[body] @ turned[body]))))
            if not (share <= MOVED and angle <= TURNED):
                worst = moved.get(f"thing-{k}", (0.0, 0.0, ""))
                moved[f"thing-{k}"] = (max(share, worst[0]), max(math.degrees(angle), worst[1]), worst[2] + " " + name)
    return moved


def _shift_of(thing: Thing, along: FloatArray) -> FloatArray:
    """The shift of its center: along the axis alone of what is round about it, and none of a ball."""
    if thing.rolls == "ball":
        return np.zeros(3)
    shift = along * SHIFT * thing.size
    return shift if isinstance(thing.rolls, str) else np.array(thing.rolls) * float(shift @ np.array(thing.rolls))


# --- facts -----------------------------------------------------------------------------------------------------------


def scene_of(text: str) -> Scene:
    return session.evaluate(Source("statics.scene", text)).require()


def judged(text: str) -> dict[str, str]:
    """The verdict on each object by its word: the worst of its bodies, with the note behind a colon."""
    facts = FrameFacts(scene_of(text).frames[0])
    found: dict[str, str] = {}
    for body, verdict in enumerate(facts.verdicts):
        word = facts.words_of(body)[0]
        if word not in found or found[word] in ("fixed", "supported"):
            found[word] = f"{verdict.kind}: {verdict.note}" if verdict.note else verdict.kind
    return found


def falling(text: str) -> dict[str, str]:
    return {word: kind for word, kind in judged(text).items() if kind not in ("fixed", "supported")}


# Disagreements that are no fault of the facts, by the number of the scene, each with its reason.
EXPLAINED: dict[int, str] = {
    37: "the top block's margin is .9 % of the breadth where 1 % is asked; the facts leave .2 % of weight times size",
}
SAMPLE = range(8, COUNT, 17)


def test_scenes() -> None:
    """Each object is one body in the facts, and about half of the scenes stay."""
    assert len(examples()) == COUNT
    for example in examples()[:: COUNT // 20]:
        facts = FrameFacts(scene_of(example.text).frames[0])
        assert [facts.words_of(k)[0] for k in range(len(facts.bodies))] == [
            f"thing-{k}" for k in range(len(example.things))
        ]


@pytest.mark.parametrize("number", SAMPLE, ids=lambda number: examples()[number].name)
def test_sample_agrees_with_mujoco(number: int) -> None:
    example = examples()[number]
    assert number in EXPLAINED or bool(falling(example.text)) == bool(simulated(example))


@pytest.mark.slow
def test_agrees_with_mujoco() -> None:
    """The facts and MuJoCo agree on which scenes stay; prints a table of the others."""
    rows, same, stay = [("scene", "wanted", "facts", "MuJoCo", "why")], list[bool](), 0
    for number, example in enumerate(examples()):
        found, moved = falling(example.text), simulated(example)
        stay += not moved
        same.append(bool(found) == bool(moved))
        if not same[-1]:
            wanted = {None: "?", True: "stays", False: "moves"}[example.wanted]
            kinds = ", ".join(f"{word} {kind}" for word, kind in found.items()) or "stays"
            much = (
                ", ".join(f"{word} {share:.2f} {angle:.0f} deg" for word, (share, angle, _) in moved.items()) or "stays"
            )
            rows.append((example.name, wanted, kinds, much, EXPLAINED.get(number, "")))
    table = "\n".join(" | ".join(row) for row in rows)
    print(table)
    counted = [good for number, good in enumerate(same) if number not in EXPLAINED]
    print(f"{sum(same)} of {COUNT} agree before any exclusion, {stay} stay")
    assert 0.4 * COUNT <= stay <= 0.6 * COUNT
    assert len(EXPLAINED) <= 0.02 * COUNT
    assert sum(counted) / len(counted) >= 0.98, table


# --- hard cases ------------------------------------------------------------------------------------------------------

HOUSE = '(bind "wall" (lambda () (transform (call "cube" :scale [4 3 .2]) (translate [0 1.5 -.1]))))'
CEILING = '(bind "ceiling" (lambda () (transform (call "cube" :scale [4 .2 4]) (translate [0 2.6 0]))))'
CEILED = '(call "ceiling" :fixed #t) (call "stone")'
STONE = '(bind "stone" (lambda () (transform (call "cube" :scale .2) (translate [1.5 .1 1]))))'
FLOOR = '(bind "floor" (lambda () (transform (call "cube" :scale [6 .2 6]) (translate [0 -.1 0]))))'
DRUM = (
    FLOOR
    + """
(bind "drum" (lambda () (union
  (call "cylinder" :radius .12 :p0 [0 1.4 -.5] :p1 [0 1.4 .5])
  (for/union ((z '(-.45 .45))) (transform (call "cube" :scale [.2 1.4 .1]) (translate (vector 0 .7 z)))))))"""
)
LADDER = """
(bind "ladder" (lambda () (transform (union
  (for*/union ((z '(-.2 .2))) (transform (call "cube" :scale [3 .08 .05]) (translate (vector 0 0 z))))
  (for/union ((i (iota 9))) (transform (call "cylinder" :radius .02 :p0 [0 0 -.2] :p1 [0 0 .2])
    (translate (vector (* .3 (- i 4)) 0 0)))))
  (@ (translate [-.78464 1.31904 0]) (rotate (/ tau 6) [0 0 1])))))
(bind "wall" (lambda () (transform (call "cube" :scale [.3 3.5 2]) (translate [.15 1.75 0]))))
"""
CUP = """
(bind "cup" (lambda () (lathe '([0 0] [.03 0] [.045 .1] [.042 .1] [.027 .005] [0 .005]))))
"""
CABINET = """
(bind "cabinet" (lambda () (union
  (for/union ((x '(-.49 .49))) (transform (call "cube" :scale [.02 .8 .5]) (translate (vector x .4 0))))
  (for/union ((y '(.01 .79 .4))) (transform (call "cube" :scale [.96 .02 .5]) (translate (vector 0 y 0))))
  (transform (call "cube" :scale [.96 .76 .02]) (translate [0 .4 -.24])))))
(bind "drawer" (lambda () (transform (call "cube" :scale [.94 .34 .46]) (translate [0 .6 .01]))))
"""
MUG = """
(bind "hook" (lambda () (call "capsule" :radius .008 :p0 [0 1.022 -.05] :p1 [0 1.022 .15])))
(bind "rack" (lambda () (union (transform (call "cube" :scale [.4 1.4 .04]) (translate [0 .7 -.07])) (call "hook"))))
(bind "mug" (lambda () (union
  (transform (call "torus" :radius .04 :tube .01) (@ (translate [0 1 .05]) (rotate (/ tau 4) [1 0 0])))
  (transform (difference (call "cylinder" :radius .045 :p0 [-.05 0 0] :p1 [.05 0 0])
                         (call "cylinder" :radius .04 :p0 [-.045 0 0] :p1 [.06 0 0])) (translate [0 .915 .05])))))
"""
TAIL = """
(bind "beam" (lambda () (transform (extrude (list [-.3 0] [-.05 0] [-.1 .1] [.1 .1] [.05 0] [.3 0] [.3 .2] [-.3 .2]) .4 :center #t)
  (translate [0 2 0]))))
(bind "hanger" (lambda () (union
  (transform (extrude (list [-.05 0] [.05 0] [.1 .1] [-.1 .1]) .3 :center #t) (translate [0 2 0]))
  (transform (call "cube" :scale [.1 .4 .3]) (translate [0 1.8 0])))))
"""


def stones(*, keystone: bool) -> str:
    """An arch of seven stones that stands on the ground."""
    angles = np.linspace(math.pi, 0.0, 8)
    pairs = enumerate(pairwise(angles.tolist()))
    parts = [voussoir(0.8, 1.0, a, b) for k, (a, b) in pairs if keystone or k != 3]
    return Example("arch", tuple(parts)).text


def root(words: str, *parts: str) -> str:
    return f'{words} (bind "yard" (lambda () (union {" ".join(parts)}))) (scene "yard")'


# A program, and what is wanted: a verdict for each word ("not": any but "fixed" and "supported"; "held": no warning), or
# under "*" what ``check_geometry`` says in all: "none" (no warning), or the name of a diagnostic, without warnings.
HARD: dict[str, tuple[str, dict[str, str]]] = {
    "a lamp on its cord": (root(CEILING + STONE + """
        (bind "lamp" (lambda () (union (call "cylinder" :radius .01 :p0 [0 1.8 0] :p1 [0 2.5 0])
          (call "cone" :radius .25 :p0 [0 1.6 0] :p1 [0 1.85 0]))))""", CEILED, '(call "lamp")'),
        {"lamp": "supported", "*": "none"}),
    "a rope beside the drum that it comes from": (root(DRUM + """
        (bind "rope" (lambda () (call "cylinder" :radius .012 :p0 [.13 1.4 0] :p1 [.13 .64 0])))""",
        '(call "floor")', '(call "drum")', '(call "rope")'), {"rope": "supported", "*": "none"}),
    "a bucket on a rope beside a drum": (root(DRUM + """
        (bind "rope" (lambda () (call "cylinder" :radius .012 :p0 [.13 1.4 0] :p1 [.13 .64 0])))
        (bind "bucket" (lambda () (transform (call "cylinder" :radius .15 :p1 [0 .3 0]) (translate [.13 .345 0]))))""",
        '(call "floor")', '(call "drum")', '(call "rope")', '(call "bucket")'), {"rope": "supported", "*": "none"}),
    "a pole beside a drum": (root(DRUM + """
        (bind "pole" (lambda () (call "cylinder" :radius .06 :p0 [.178 1.4 0] :p1 [.178 .64 0])))""",
        '(call "floor")', '(call "drum")', '(call "pole")'), {"pole": "not"}),
    "a rope whose middle touches a drum": (root(DRUM + """
        (bind "rope" (lambda () (call "cylinder" :radius .012 :p0 [.13 1.9 0] :p1 [.13 .9 0])))""",
        '(call "floor")', '(call "drum")', '(call "rope")'), {"rope": "not"}),
    "a lamp and its cord": (root(CEILING + STONE + """
        (bind "cord" (lambda () (call "cylinder" :radius .01 :p0 [0 1.8 0] :p1 [0 2.5 0])))
        (bind "lamp" (lambda () (transform (call "sphere" :radius .2) (translate [0 1.6 0]))))""",
        CEILED, '(call "cord")', '(call "lamp")'), {"lamp": "supported", "cord": "supported", "*": "none"}),
    "a picture on a wall": (root(HOUSE + STONE + """
        (bind "picture" (lambda () (transform (call "cube" :scale [.8 .6 .03]) (translate [0 1.6 .015]))))""",
        '(call "wall" :fixed #t)', '(call "stone")', '(call "picture")'), {"picture": "supported", "*": "none"}),
    "a picture on a wall that stands": (root(HOUSE + FLOOR + """
        (bind "picture" (lambda () (transform (call "cube" :scale [.8 .6 .03]) (translate [0 1.6 .015]))))""",
        '(call "floor")', '(call "wall")', '(call "picture")'), {"picture": "supported", "*": "none"}),
    "a curtain around its rod": (root(HOUSE + STONE + """
        (bind "rod" (lambda () (union (call "cylinder" :radius .02 :p0 [-1 2.2 .12] :p1 [1 2.2 .12])
          (for/union ((x '(-.95 .95))) (call "cylinder" :radius .015 :p0 (vector x 2.2 0) :p1 (vector x 2.2 .12))))))
        (bind "curtain" (lambda () (transform (call "cube" :scale [.8 2.1 .03]) (translate [.3 1.17 .12]))))""",
        '(call "wall" :fixed #t)', '(call "stone")', '(call "rod")', '(call "curtain")'), {"curtain": "supported", "*": "none"}),
    "a curtain below its rod": (root(HOUSE + STONE + """
        (bind "rod" (lambda () (union (call "cylinder" :radius .02 :p0 [-1 2.2 .12] :p1 [1 2.2 .12])
          (for/union ((x '(-.95 .95))) (call "cylinder" :radius .015 :p0 (vector x 2.2 0) :p1 (vector x 2.2 .12))))))
        (bind "curtain" (lambda () (transform (call "cube" :scale [.8 2 .01]) (translate [.3 1.18 .12]))))""",
        '(call "wall" :fixed #t)', '(call "stone")', '(call "rod" :fixed #t)', '(call "curtain")'), {"curtain": "supported", "*": "none"}),
    "a caged drawer": (root(CABINET, '(call "cabinet")', '(call "drawer")'), {"drawer": "held"}),
    "a planted tree": (root(STONE + """
        (bind "tree" (lambda () (union (call "cylinder" :radius .1 :p0 [0 -.3 0] :p1 [0 2 0])
          (transform (call "sphere" :radius .8) (translate [0 2.4 0])))))""", '(call "tree")', '(call "stone")'),
        {"tree": "supported", "*": "below-ground-note"}),
    "a tree that is planted in a lawn": (root(FLOOR + """
        (bind "tree" (lambda () (union (call "cylinder" :radius .1 :p0 [0 -.15 0] :p1 [0 2 0])
          (transform (call "sphere" :radius .8) (translate [0 2.4 0])))))""", '(call "floor")', '(call "tree")'),
        {"tree": "supported", "*": "below-ground-note"}),
    "fish in water": (root("""
        (bind "basin" (lambda () (difference (transform (call "cube" :scale [2 .6 1]) (translate [0 .3 0]))
          (transform (call "cube" :scale [1.9 .6 .9]) (translate [0 .35 0])))))
        (bind "water" (lambda () (transform (call "cube" :scale [1.9 .45 .9] :opacity .4) (translate [0 .275 0]))))
        (bind "fish" (lambda () (transform (call "sphere" :radius .06) (scale [2 1 .6]))))""",
        '(call "basin")', '(call "water")',
        *(f'(transform (call "fish") (translate [{x} {y} {z}]))' for x, y, z in ((-.5, .3, .1), (.2, .2, -.2), (.6, .35, 0)))),
        {"*": "none"}),
    "a cloud": (root(STONE + """
        (bind "cloud" (lambda () (union (call "sphere" :radius .5) (transform (call "sphere" :radius .4) (translate [.5 0 0])))))""",
        '(call "stone")', '(transform (call "cloud") (translate [0 .9 0]))'), {"cloud": "floating", "*": "floating-note"}),
    "snow": (root(FLOOR + '(bind "dot" (lambda () (call "sphere" :radius .03)))', '(call "floor")',
        *(f'(transform (call "dot") (translate [{math.sin(7.0 * i) * 2.5:.3f} {0.3 + 0.09 * i:.3f} {math.cos(11.0 * i) * 2.5:.3f}]))'
          for i in range(24))), {"dot": "floating", "*": "floating-note"}),
    "a rope from a ceiling": (root(CEILING + STONE + """
        (bind "rope" (lambda () (sweep (circle .02) [[0 2.5 0] [.02 1.8 0] [-.02 1.2 0] [0 .5 0]])))""", CEILED, '(call "rope")'),
        {"rope": "supported", "*": "none"}),
    "a rope of pieces from a ceiling": (root(CEILING + STONE + """
        (bind "rope" (lambda () (for/union ((i (iota 8)))
          (call "capsule" :radius .02 :p0 (vector 0 (- 2.48 (* .2 i)) 0) :p1 (vector 0 (- 2.28 (* .2 i)) 0)))))""",
        CEILED, '(call "rope")'), {"rope": "supported", "*": "none"}),
    "a ladder that slides": (root(LADDER, '(call "wall" :fixed #t)', '(call "ladder" :friction .2)'), {"ladder": "slides"}),
    "a ladder that stands": (root(LADDER, '(call "wall" :fixed #t)', '(call "ladder" :friction .6)'),
        {"ladder": "supported", "*": "none"}),
    "a dovetail": (root(TAIL + STONE, '(call "beam" :fixed #t)', '(call "stone")', '(call "hanger")'),
        {"hanger": "supported", "*": "none"}),
    "nested cups": (root(CUP, *(f'(transform (call "cup") (translate [0 {0.024 * k:.3f} 0]))' for k in range(4))),
        {"cup": "supported", "*": "none"}),
    "a mug on a hook": (root(MUG, '(call "rack" :fixed #t)', '(call "mug")'), {"mug": "supported", "*": "none"}),
    "a curved sheet on the floor": (root(STONE + """
        (bind "sheet" (lambda () (heightfield (lambda (x z) (+ .02 (* .1 (sin (* 3 x)) (sin (* 3 x))))) :size 2 :base 0)))""",
        '(call "sheet")', '(call "stone")'), {"*": "none"}),
    "a bent sheet on the floor": (root(STONE + """
        (bind "sheet" (lambda () (extrude (profile-difference (profile-intersection (circle 1) (polygon [[-2 .6] [2 .6] [2 2] [-2 2]]))
          (circle .98)) 1 :center #t)))""", '(transform (call "sheet") (translate [0 -.6 0]))', '(call "stone")'),
        {"sheet": "supported", "*": "none"}),
    "a cone on its tip": (root('(bind "cone-0" (lambda () (call "cone" :radius .3 :p0 [0 1 0] :p1 [0 0 0])))', '(call "cone-0")'),
        {"cone-0": "tips", "*": "unstable"}),
    "a ball on a flat floor": (root(FLOOR + '(bind "ball" (lambda () (transform (call "sphere" :radius .3) (translate [0 .3 0]))))',
        '(call "floor")', '(call "ball")'), {"ball": "supported", "*": "none"}),
    "a ball in a valley": (root("""
        (bind "hills" (lambda () (extrude (polygon [[-3 -1] [3 -1] [3 1.5] [1 0] [-1 0] [-3 1.5]]) 6 :center #t)))
        (bind "ball" (lambda () (transform (call "sphere" :radius .3) (translate [0 .28 0]))))""",
        '(call "hills")', '(call "ball")'), {"ball": "supported", "hills": "fixed", "*": "none"}),
    "a shovel in the snow": (root(FLOOR + """
        (bind "shovel" (lambda () (union (transform (call "cube" :scale [.28 .4 .02]) (translate [0 .1 0]))
          (call "cylinder" :radius .022 :p0 [0 .26 0] :p1 [0 1.25 0]))))""",
        '(call "floor")', '(transform (call "shovel") (rotate .08 [1 0 0]))'), {"shovel": "supported", "*": "none"}),
    "a knife at a bar": (root("""
        (bind "wall" (lambda () (transform (call "cube" :scale [2 2 .1]) (translate [0 1 -.05]))))
        (bind "bar" (lambda () (transform (call "cube" :scale [.6 .05 .018]) (translate [0 1.4 .009]))))
        (bind "knife" (lambda () (union (transform (call "cube" :scale [.05 .24 .002]) (translate [0 1.4 .019]))
          (transform (call "cube" :scale [.026 .13 .016]) (translate [0 1.22 .019])))))""",
        '(call "wall" :fixed #t)', '(call "bar")', '(call "knife")'), {"knife": "falls", "*": "unstable-note"}),
    "a book at the edge of a pile": (root(FLOOR + """
        (bind "book" (lambda () (transform (call "cube" :scale [.2 .03 .15]) (translate [0 .015 0]))))
        (bind "pile" (lambda () (for/union ((i (iota 4))) (transform (call "book")
          (translate (vector (if (= i 3) .12 0) (* .03 i) 0))))))""",
        '(call "floor")', '(call "pile")'), {"*": "unstable"}),
    "a ball on a slope": (root("""
        (bind "slope" (lambda () (extrude (list [0 0] [2 0] [2 .4]) 1 :center #t)))
        (bind "ball" (lambda () (transform (call "sphere" :radius .2) (translate [.96078 .39612 0]))))""",
        '(call "slope")', '(call "ball")'), {"ball": "not", "slope": "fixed"}),
    "an arch": (stones(keystone=True), {**{f"thing-{k}": "supported" for k in range(7)}, "*": "none"}),
    "an arch without its keystone": (stones(keystone=False), {"thing-2": "not", "thing-3": "not"}),
    "a block that is clamped": (root("""
        (bind "wall" (lambda () (transform (call "cube" :scale [.3 2 1]) (translate [0 1 0]))))
        (bind "block" (lambda () (transform (call "cube" :scale [.6 .4 .5]) (translate [0 1.2 0]))))""",
        *(f'(transform (call "wall" :fixed #t) (translate [{x} 0 0]))' for x in (-.45, .45)), '(call "block")'),
        {"block": "not"}),
    "a ladder of slippery round rails": (root(HOUSE + FLOOR + """
        (bind "ladder" (lambda () (for/union ((x '(-.2 .2)))
          (call "capsule" :radius .03 :p0 [x .03 1.28] :p1 [x 2.195 .03]))))""",
        '(call "floor")', '(call "wall")', '(call "ladder" :body #t :friction .1)'), {"ladder": "not"}),
    "a ladder of rough round rails": (root(HOUSE + FLOOR + """
        (bind "ladder" (lambda () (for/union ((x '(-.2 .2)))
          (call "capsule" :radius .03 :p0 [x .03 1.28] :p1 [x 2.195 .03]))))""",
        '(call "floor")', '(call "wall")', '(call "ladder" :body #t)'), {"ladder": "supported", "*": "none"}),
    "a flag that touches its pole": (root(FLOOR + """
        (bind "pole" (lambda () (call "cylinder" :radius .03 :p0 [0 0 0] :p1 [0 1.5 0])))
        (bind "flag" (lambda () (transform (call "cube" :scale [.8 .5 .01]) (translate [.43 1.15 0]))))""",
        '(call "floor")', '(call "pole")', '(call "flag")'), {"flag": "held"}),
    "a bowling ball": (root(FLOOR + """
        (bind "ball" (lambda () (transform (call "sphere" :radius .108) (translate [.12 .108 1.5]))))""",
        '(call "floor")', '(call "ball")'), {"ball": "supported", "*": "none"}),
    "a box on a steep ramp": (root("""
        (bind "ramp" (lambda () (extrude '([-1 0] [1 0] [1 1.4]) 1.0 :center #t)))
        (bind "box" (lambda () (transform (call "cube" :scale .3)
          (@ (translate [-.0859 .8228 0]) (rotate (atan .7) [0 0 1])))))""",
        '(call "ramp" :fixed #t)', '(call "box" :friction .3)'), {"box": "not"}),
    "a box on a ledge, against the wall": (root("""
        (bind "wall" (lambda () (union (transform (call "cube" :scale [.3 2 1]) (translate [.56 1 0]))
          (transform (call "cube" :scale [.14 .1 1]) (translate [.34 1.1 0])))))
        (bind "box" (lambda () (transform (call "cube" :scale [.82 .54 .5]) (translate [0 1.42 0]))))""",
        '(call "wall" :fixed #t)', '(call "box" :friction .9)'), {"box": "not"}),
    "a lamp whose shade is beside its flat foot": (root(FLOOR + """
        (bind "lamp" (lambda () (union (call "cylinder" :radius .2 :p1 [0 .03 0])
          (call "cylinder" :radius .015 :p0 [0 .03 0] :p1 [0 1.4 0])
          (call "cylinder" :radius .015 :p0 [0 1.4 0] :p1 [.7 1.5 0])
          (call "cylinder" :radius .15 :p0 [.7 1.4 0] :p1 [.7 1.65 0]))))""",
        '(call "floor")', '(call "lamp")'), {"lamp": "tips", "*": "unstable"}),
    "a parcel on the middle planks of a sledge": (root("""
        (bind "sledge" (lambda () (union
          (for/union ((z '(-.2 .2))) (transform (call "cube" :scale [1.2 .24 .03]) (translate [0 .12 z])))
          (for/union ((i (iota 5))) (transform (call "cube" :scale [1.1 .02 .08]) (translate [0 .25 (- (* .1 i) .2)]))))))
        (bind "parcel" (lambda () (transform (call "cube" :scale .22) (translate [.2 .37 0]))))""",
        '(call "sledge")', '(call "parcel")'), {"parcel": "held", "*": "none"}),
}  # fmt: skip


@pytest.mark.parametrize("name", HARD)
def test_hard_case(name: str) -> None:
    text, wanted = HARD[name]
    _compare(scene_of(text), text, wanted)


def _compare(scene: Scene, text: str, wanted: dict[str, str]) -> None:
    found, said = judged(text), {d.name for d in check_geometry(scene)}
    warnings = {name for name in said if not name.endswith("-note")}
    for word, kind in wanted.items():
        if word == "*":
            assert warnings == ({kind} - {"none"} if not kind.endswith("-note") else set()), said
            assert kind == "none" or kind in said, said
        elif kind == "not":
            assert found[word].split(":")[0] in ("tips", "slides", "falls", "floating"), found
        elif kind == "held":
            assert found[word] in ("fixed", "supported") or not warnings, (found, said)
        else:
            assert found[word].split(":")[0] == kind, (found, said)


def test_open_mesh_on_the_floor(tmp_path: Path) -> None:
    """A sheet without thickness, from a file, has no warning."""
    points = [(x, 0.05 * x * x, z) for x in range(-3, 4) for z in (-1, 1)]
    faces = [(k, k + 1, k + 3, k + 2) for k in range(1, 2 * 7 - 2, 2)]
    lines = [*("v {} {} {}".format(*point) for point in points), *("f {} {} {} {}".format(*face) for face in faces)]
    (tmp_path / "sheet.obj").write_text("\n".join(lines) + "\n", encoding="utf-8")
    text = root(
        FLOOR + '(bind "sheet" (lambda () (call "mesh" :file "sheet.obj")))', '(call "floor")', '(call "sheet")'
    )
    scene = session.evaluate(Source(str(tmp_path / "a.scene"), text)).require()
    assert [d.name for d in check_geometry(scene) if not d.name.endswith("-note")] == []

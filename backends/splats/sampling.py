"""Points that lie evenly on the surfaces of primitives: the same ones every time.

A surface is made of charts, each of which takes the unit square to a part of it without changing ratios of areas. On
each the points are a Fibonacci lattice, so that they are neither random nor in rows.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenelang.backends.meshes import triangle_normals
from scenelang.backends.solids import Form

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
Place = Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]

_GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
_PLASTIC = 1.324717957244746  # its powers do in the plane what the golden ratio does on the line


@dataclass(frozen=True, slots=True)
class Chart:
    """A part of a surface with this ``area``: ``place(u, v)`` gives points and unit normals (K, 3) for numbers (K,) in
    [0, 1)."""

    area: float
    place: Place


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """K points on a surface: ``places`` and unit ``normals`` (K, 3); ``area`` is the whole surface's."""

    places: FloatArray
    normals: FloatArray
    area: float


def on_solid(form: Form, half: Sequence[float], count: int, seed: int = 0) -> Samples:
    """``count`` points on the canonical solid ``form``, stretched by the three ``half`` sizes; a ball, cylinder or cone
    must be round, so that its first and last size are equal. ``seed`` shifts the lattice."""
    charts = [chart for chart in _charts(form, half) if chart.area > 0.0]
    area = sum(chart.area for chart in charts)
    if not charts:
        return Samples(np.zeros((0, 3)), np.zeros((0, 3)), 0.0)
    shares = _shared_out([chart.area for chart in charts], count)
    # each chart has its own shift, so that the two sides of something flat do not coincide
    found = [
        chart.place(*_lattice(share, seed + i)) for i, (chart, share) in enumerate(zip(charts, shares, strict=True))
    ]
    return Samples(np.concatenate([p for p, _ in found]), np.concatenate([n for _, n in found]), area)


def on_triangles(corners: FloatArray, count: int, seed: int = 0) -> tuple[Samples, IntArray]:
    """``count`` points on triangles (F, 3, 3), and on which each lies (K,); none where these have no area."""
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2.0
    reached = np.cumsum(areas)
    if not len(areas) or not 0.0 < reached[-1] < math.inf:
        return Samples(np.zeros((0, 3)), np.zeros((0, 3)), 0.0), np.zeros(0, np.int64)
    i = np.arange(count)
    which = np.searchsorted(reached, (i + 0.5) / count * reached[-1], side="right").clip(max=len(areas) - 1)
    u, v = np.modf(i / _PLASTIC + seed * _GOLDEN)[0], np.modf(i / _PLASTIC**2 + seed * _GOLDEN)[0]
    over = u + v > 1.0
    u, v = np.where(over, 1.0 - u, u)[:, None], np.where(over, 1.0 - v, v)[:, None]
    a, b, c = (corners[which, k] for k in range(3))
    return Samples(a + u * (b - a) + v * (c - a), triangle_normals(corners)[which], float(reached[-1])), which


def _lattice(count: int, seed: int) -> tuple[FloatArray, FloatArray]:
    i = np.arange(count)
    return (i + 0.5) / max(count, 1), np.modf(i * _GOLDEN + seed * math.sqrt(2.0))[0]


def _shared_out(areas: Sequence[float], count: int) -> list[int]:
    """``count`` in whole parts as the ``areas`` are, the largest rests rounded up."""
    exact = np.array(areas) / sum(areas) * count
    parts = np.floor(exact).astype(np.int64)
    parts[np.argsort(parts - exact, kind="stable")[: count - int(parts.sum())]] += 1
    return [int(part) for part in parts]


# --- charts ----------------------------------------------------------------------------------------------------


def _charts(form: Form, half: Sequence[float]) -> list[Chart]:
    x, y, _ = half
    if form is Form.BLOCK:
        return [_face(half, axis, side) for axis in range(3) for side in (-1.0, 1.0)]
    if form is Form.BALL:
        return [_sphere(x)]
    if form is Form.CYLINDER:
        return [_tube(x, y), _disc(x, y, 1.0), _disc(x, -y, -1.0)]
    return [_hat(x, y), _disc(x, -y, -1.0)]


def _face(half: Sequence[float], axis: int, side: float) -> Chart:
    """A face of a block; the lattice's steps go along its longer side."""
    long, short = sorted((k for k in range(3) if k != axis), key=lambda k: -half[k])

    def place(u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        places, normals = np.zeros((2, len(u), 3))
        places[:, axis], normals[:, axis] = side * half[axis], side
        places[:, long], places[:, short] = (2.0 * u - 1.0) * half[long], (2.0 * v - 1.0) * half[short]
        return places, normals

    return Chart(4.0 * half[long] * half[short], place)


def _sphere(radius: float) -> Chart:
    def place(u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        y = 1.0 - 2.0 * u
        normals = _round(np.sqrt(1.0 - y * y), v, y)
        return radius * normals, normals

    return Chart(4.0 * math.pi * radius * radius, place)


def _tube(radius: float, half: float) -> Chart:
    """The side of a cylinder."""

    def place(u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        return _round(radius + 0.0 * u, v, (2.0 * u - 1.0) * half), _round(1.0 + 0.0 * u, v, 0.0 * u)

    return Chart(4.0 * math.pi * radius * half, place)


def _hat(radius: float, half: float) -> Chart:
    """The side of a cone, whose apex is up."""
    slant = math.hypot(radius, 2.0 * half)

    def place(u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        down = np.sqrt(u)
        normals = _round(2.0 * half / slant + 0.0 * u, v, radius / slant + 0.0 * u)
        return _round(radius * down, v, half - 2.0 * half * down), normals

    return Chart(math.pi * radius * slant, place)


def _disc(radius: float, y: float, up: float) -> Chart:
    def place(u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        return _round(radius * np.sqrt(u), v, y + 0.0 * u), np.tile([0.0, up, 0.0], (len(u), 1))

    return Chart(math.pi * radius * radius, place)


def _round(radius: FloatArray, turn: FloatArray, y: FloatArray) -> FloatArray:
    """Points (K, 3) about the y axis, ``turn`` in full turns."""
    angle = 2.0 * math.pi * turn
    return np.stack([radius * np.sin(angle), y, radius * np.cos(angle)], axis=1)

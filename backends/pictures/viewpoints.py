"""Several cameras around a scene: random ones, an orbit, a trajectory."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from scenelang.backends.pictures.camera import Camera, Viewpoint, camera_at, looking
from scenelang.backends.pictures.declared import View
from scenelang.grammar.datum import replace
from scenelang.grammar.diagnostics import SceneError

_ELEVATIONS = (5.0, 65.0)  # degrees above the horizon of random viewpoints
MAX_VIEWS = 10_000  # images in one folder; `dataset` makes more, in shards


def hemisphere_views(count: int, random: np.random.Generator, like: Viewpoint) -> tuple[Viewpoint, ...]:
    """Return ``count`` random viewpoints around and above a scene, which share the other settings of ``like``."""
    azimuths, elevations = random.uniform(-180.0, 180.0, count), random.uniform(*_ELEVATIONS, count)
    pairs = zip(azimuths.tolist(), elevations.tolist(), strict=True)
    return tuple(replace(like, azimuth=azimuth, elevation=elevation) for azimuth, elevation in pairs)


def orbit_views(first: Viewpoint, count: int, sweep: float) -> tuple[Viewpoint, ...]:
    """Return ``count`` viewpoints on a circle from ``first``, evenly spaced over ``sweep`` degrees.

    The last one is a step before the end of a full turn, and at the end of a shorter arc.

    Examples
    --------
    >>> [view.azimuth for view in orbit_views(Viewpoint(azimuth=10), 4, 360.0)]
    [10.0, 100.0, 190.0, 280.0]
    """
    is_closed = abs(sweep) % 360.0 == 0.0
    step = sweep / (count if is_closed else max(1, count - 1))
    return tuple(replace(first, azimuth=first.azimuth + step * i) for i in range(count))


def trajectory_views(
    eyes: Sequence[Sequence[float]], target: Sequence[float], count: int, fov: float, size: tuple[int, int]
) -> tuple[Camera, ...]:
    """Return ``count`` cameras at equal distances along the polyline through ``eyes``, which look at ``target``.

    ``eyes`` (K, 3) and ``target`` (3,) are in the world, ``fov`` is the vertical field of view in degrees, ``size`` in
    pixels. Raises SceneError("value") if a camera is at its target.
    """
    points = np.array(eyes, np.float64)
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    places = np.linspace(0.0, lengths[-1], count)
    along = np.stack([np.interp(places, lengths, points[:, axis]) for axis in range(3)], axis=1)
    width, height = size
    focal = height / (2.0 * np.tan(np.radians(fov) / 2.0))
    return tuple(
        camera_at(eye, looking(eye, np.array(target, np.float64))[0], float(focal), width, height) for eye in along
    )


def views_of(given: Sequence[View], count: int | None, seed: int) -> tuple[View, ...]:
    """Return the given cameras, or ``count`` random ones that share the given viewpoint's other settings.

    Raises SceneError("value").
    """
    if count is None:
        return tuple(given)
    if not 1 <= count <= MAX_VIEWS:
        raise SceneError("value", f"`--views` must be 1 to {MAX_VIEWS:,}, not {count}")
    (like,) = given if len(given) == 1 else (None,)
    if not isinstance(like, Viewpoint):
        raise SceneError("value", "`--views` places cameras at random: give at most one viewpoint, which they share")
    return hemisphere_views(count, np.random.default_rng(seed), like)

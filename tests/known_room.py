"""A ball and a crate, still and in a film, and where rays meet them, in closed form."""

from __future__ import annotations

import numpy as np

FRAMES = 4
WORDS = """
(bind "ball" (lambda () (call "sphere" :radius .5)))
(bind "crate" (lambda () (call "cube" :scale [.9 .6 .5])))
"""
STILL = f"""{WORDS}
(bind "room" (lambda () (union
  (transform (call "ball") (translate [-.8 .1 .2]))
  (transform (call "crate") (@ (translate [.7 -.1 0]) (rotate .6 [0 1 0]))))))
"""
MOVING = f"""{WORDS}
(bind "room" (lambda () (frames (for/list ((i (iota {FRAMES}))) (union
  (transform (call "ball") (@ (translate [(- (* .1 i) .8) .1 .2]) (rotate (* .3 i) [0 0 1])))
  (transform (call "crate") (@ (translate [.7 (* .05 i) 0]) (rotate (* .2 i) [0 1 0]))))))))
"""
Pose = tuple[np.ndarray, np.ndarray]


def pose(place: tuple[float, float, float], angle: float, axis: int) -> Pose:
    """A turn about an axis of the world, and a place."""
    a, b = [k for k in range(3) if k != axis]
    sign = -1.0 if axis == 1 else 1.0
    turn = np.eye(3)
    turn[a, a] = turn[b, b] = np.cos(angle)
    turn[b, a], turn[a, b] = sign * np.sin(angle), -sign * np.sin(angle)
    return turn, np.array(place)


# By word, in the order of the numbers that `seen` gives.
THINGS = {"ball": pose((-0.8, 0.1, 0.2), 0.0, 2), "crate": pose((0.7, -0.1, 0.0), 0.6, 1)}
RADIUS, HALF = 0.5, np.array([0.45, 0.3, 0.25])


def in_film(frame: int) -> dict[str, Pose]:
    """The poses of a frame of MOVING."""
    ball = pose((0.1 * frame - 0.8, 0.1, 0.2), 0.3 * frame, 2)
    return {"ball": ball, "crate": pose((0.7, 0.05 * frame, 0.0), 0.2 * frame, 1)}


def off_surface(points: np.ndarray) -> np.ndarray:
    """The distance of each point from the nearest surface of STILL."""
    ball = np.abs(np.linalg.norm(points - THINGS["ball"][1], axis=1) - RADIUS)
    turn, place = THINGS["crate"]
    q = np.abs((points - place) @ turn) - HALF
    outside = np.linalg.norm(np.maximum(q, 0.0), axis=1)
    return np.minimum(ball, outside + np.abs(np.minimum(q.max(axis=1), 0.0)))


def seen(eye: np.ndarray, rays: np.ndarray, things: dict[str, Pose]) -> tuple[np.ndarray, np.ndarray]:
    """What each ray (N, 3) meets first, 0 for nothing, 1 for the ball and 2 for the crate, and where (N, 3)."""
    there = eye - things["ball"][1]
    a, b, c = (rays**2).sum(axis=1), rays @ there, there @ there - RADIUS**2
    root = np.sqrt(np.where(b * b >= a * c, b * b - a * c, np.nan))
    turn, place = things["crate"]
    origin, along = (eye - place) @ turn, rays @ turn
    sides = np.stack([(-HALF - origin) / along, (HALF - origin) / along])
    near, far = sides.min(axis=0).max(axis=1), sides.max(axis=0).min(axis=1)
    ways = np.stack([(-b - root) / a, np.where(near < far, near, np.nan)])
    ways = np.where(np.isnan(ways), np.inf, ways)
    which = np.where(np.isfinite(ways).any(axis=0), ways.argmin(axis=0) + 1, 0)
    return which, eye + np.where(which > 0, ways.min(axis=0), 0.0)[:, None] * rays


def outline(word: str, camera: np.ndarray) -> np.ndarray:
    """Points (N, 3) in the frame of a camera, whose box in a picture is that of a thing."""
    turn, place = THINGS[word]
    center = camera[:3, :3] @ place + camera[:3, 3]
    if word == "crate":
        corners = np.array(np.meshgrid(*[[-1.0, 1.0]] * 3)).reshape(3, 8).T * HALF
        return corners @ (camera[:3, :3] @ turn).T + center
    share = (RADIUS / np.linalg.norm(center)) ** 2  # the circle in which a cone from the eye touches the ball
    _, _, across = np.linalg.svd(center[None])
    angles = np.linspace(0.0, 2.0 * np.pi, 2_000)
    circle = np.column_stack([np.cos(angles), np.sin(angles)]) @ across[1:] * RADIUS * np.sqrt(1.0 - share)
    return center * (1.0 - share) + circle

"""
a stroboscopic picture of a basketball bouncing down a flight of steps
"""
from helper import *
from bisect import bisect_right
from dataclasses import dataclass, field
from typing import Generator
import math


@dataclass
class Stairs:
    runs: int = 5
    run: float = 1.6
    rise: float = 0.7

    edges: list[float] = field(init=False)

    def __post_init__(self):
        self.edges = [i * self.run for i in range(1, self.runs)]

    def level(self, x: float) -> float:
        return (self.runs - 1 - bisect_right(self.edges, x)) * self.rise

    def __getitem__(self, i: int) -> tuple[float, float, float]:
        if not 0 <= i < self.runs:
            raise IndexError(i)
        return i * self.run, (i + 1) * self.run, (self.runs - 1 - i) * self.rise


@dataclass
class Ball:
    x: float
    y: float
    vx: float
    vy: float = 0.0
    radius: float = 0.24
    bounces: int = 0


def integrate(ball: Ball, stairs: Stairs, *, g: float = 9.81, e: float = 0.8, dt: float = 0.004) -> Generator[Ball, None, None]:
    """Semi-implicit Euler; yields the same mutable ball at every step, forever."""
    while True:
        yield ball
        ball.vy -= g * dt
        ball.x += ball.vx * dt
        ball.y += ball.vy * dt
        floor = stairs.level(ball.x) + ball.radius
        if ball.y < floor and ball.vy < 0:
            ball.y = floor
            ball.vy = -ball.vy * e
            ball.bounces += 1


def strobe(every: int = 20, limit: int = 60):
    stairs = Stairs()
    ball = Ball(x=0.3, y=stairs.level(0.3) + 2.0, vx=1.9)
    frames = []
    for n, b in enumerate(integrate(ball, stairs)):
        if b.x > stairs.runs * stairs.run or len(frames) >= limit:
            break
        if n % every == 0:
            frames.append((b.x, b.y, math.hypot(b.vx, b.vy), b.bounces))
    return stairs, frames


@register()
def basketball(radius: float = 0.24, heat: float = 0.5) -> Shape:
    heat = min(max(heat, 0.0), 1.0)
    skin = (0.55 + 0.4 * heat, 0.35 + 0.1 * (1 - heat), 0.12)
    ball = primitive_call('sphere', {'radius': radius}, color=skin)
    seams = [primitive_call('cylinder', {'radius': radius * 1.01, 'p0': tuple(-0.012 * a for a in ax), 'p1': tuple(0.012 * a for a in ax)}, color=(0.1, 0.08, 0.06))
             for ax in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]
    return concat_shapes(ball, *seams)


@register()
def staircase(depth: float = 2.0) -> Shape:
    stairs = Stairs()
    blocks = []
    for i, (x0, x1, top) in enumerate(stairs):
        h = top + 0.4
        b = primitive_call('cube', {'scale': (x1 - x0, h, depth)}, color=(0.6 + 0.04 * i, 0.58, 0.55))
        blocks.append(transform_shape(b, translation_matrix(((x0 + x1) / 2, top - h / 2, 0))))
    return concat_shapes(*blocks)


@register()
def trail() -> Shape:
    _, frames = strobe()
    vmax = max(v for *_, v, _ in frames)
    shapes = []
    for i, (x, y, v, n) in enumerate(frames):
        ball = library_call('basketball', heat=v / vmax)
        ball = transform_shape(ball, rotation_matrix(-x / 0.24, (0, 0, 1), (0, 0, 0)))
        shapes.append(transform_shape(ball, translation_matrix((x, y, 0))))
    # the path between flashes
    for (xa, ya, *_), (xb, yb, *_) in zip(frames, frames[1:]):
        shapes.append(primitive_call('cylinder', {'radius': 0.015, 'p0': (xa, ya, 0), 'p1': (xb, yb, 0)}, color=(0.2, 0.2, 0.8)))
    return concat_shapes(*shapes)


@register()
def strobe_scene() -> Shape:
    steps = library_call('staircase')
    sizes = compute_shape_sizes(steps)
    backdrop = primitive_call('cube', {'scale': (sizes[0] + 2, sizes[1] + 4, 0.1)}, color=(0.15, 0.16, 0.2))
    backdrop = transform_shape(backdrop, translation_matrix((sizes[0] / 2, (sizes[1] + 2) / 2, -1.3)))
    return concat_shapes(backdrop, steps, library_call('trail'))

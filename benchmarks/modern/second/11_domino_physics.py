"""
a line of dominoes falling around a curve, frozen half way through
"""
from helper import *
import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np


@dataclass
class Domino:
    x: float
    z: float
    heading: float
    theta: float = 0.0
    omega: float = 0.0

    G: ClassVar[float] = 9.81
    HEIGHT: ClassVar[float] = 1.0
    REST: ClassVar[float] = math.radians(68)

    @property
    def falling(self) -> bool:
        return self.theta > 0

    def step(self, dt: float):
        if not self.falling or self.theta >= self.REST:
            return
        self.omega += 1.5 * self.G / self.HEIGHT * math.sin(self.theta) * dt
        self.theta = min(self.REST, self.theta + self.omega * dt)

    def reaches(self, other: 'Domino') -> bool:
        gap = math.hypot(other.x - self.x, other.z - self.z)
        return self.HEIGHT * math.sin(self.theta) >= gap


def layout(n: int) -> list[Domino]:
    """s-curve: heading changes as an integral of curvature"""
    s = np.linspace(0, 1, n)
    curvature = 2.6 * np.sin(2 * np.pi * s)
    heading = np.cumsum(curvature) / n * 2
    dx, dz = np.cos(heading) * 0.45, np.sin(heading) * 0.45
    return [Domino(float(x), float(z), float(h)) for x, z, h in zip(np.cumsum(dx), np.cumsum(dz), heading)]


def simulate(chain: list[Domino], until: float, dt: float = 1 / 240) -> list[Domino]:
    chain[0].theta, chain[0].omega = 0.05, 0.8
    t = 0.0
    while t < until:
        for d in chain:
            d.step(dt)
        for a, b in zip(chain, chain[1:]):
            if a.falling and not b.falling and a.reaches(b):
                b.theta, b.omega = 1e-3, a.omega * 0.8
        t += dt
    return chain


@register()
def domino_tile(pips: tuple[int, int] = (3, 5), color: tuple = (0.95, 0.94, 0.9)) -> Shape:
    h = Domino.HEIGHT
    slab = transform_shape(primitive_call('cube', {'scale': (0.16, h, 0.5)}, color=color), translation_matrix((0, h / 2, 0)))
    line = transform_shape(primitive_call('cube', {'scale': (0.17, 0.02, 0.44)}, color=(0.1, 0.1, 0.1)), translation_matrix((0, h / 2, 0)))
    spots = {1: [(0, 0)], 2: [(-1, -1), (1, 1)], 3: [(-1, -1), (0, 0), (1, 1)],
             4: [(-1, -1), (1, 1), (-1, 1), (1, -1)], 5: [(-1, -1), (1, 1), (-1, 1), (1, -1), (0, 0)],
             6: [(a, b) for a in (-1, 1) for b in (-1, 0, 1)]}
    dots = []
    for half, n in enumerate(pips):
        for u, v in spots.get(n, ()):
            dot = primitive_call('cylinder', {'radius': 0.04, 'p0': (-0.09, 0, 0), 'p1': (0.09, 0, 0)}, color=(0.1, 0.1, 0.1))
            dots.append(transform_shape(dot, translation_matrix((0, h * (0.25 + 0.5 * half) + v * 0.13, u * 0.14))))
    return concat_shapes(slab, line, *dots)


@register()
def placed_domino(x: float, z: float, heading: float, theta: float, pips: tuple[int, int] = (1, 6)) -> Shape:
    tint = (0.95, 0.94, 0.9) if theta == 0 else (0.95, 0.85, 0.7)
    tile = library_call('domino_tile', pips=pips, color=tint)
    # tip over its leading bottom edge
    tile = transform_shape(tile, rotation_matrix(-theta, (0, 0, 1), (0.08, 0, 0)))
    tile = transform_shape(tile, rotation_matrix(-heading, (0, 1, 0), (0, 0, 0)))
    return transform_shape(tile, translation_matrix((x, 0, z)))


@register()
def falling_dominoes(n: int = 36, until: float = 1.6) -> Shape:
    chain = simulate(layout(n), until)
    down = sum(d.falling for d in chain)
    assert 0 < down <= n, f'{down} of {n} fell'
    tiles = [library_call('placed_domino', x=d.x, z=d.z, heading=d.heading, theta=d.theta, pips=(i % 6 + 1, (i * 5) % 6 + 1))
             for i, d in enumerate(chain)]
    row = concat_shapes(*tiles)
    lo, hi = compute_shape_min(row), compute_shape_max(row)
    table = primitive_call('cube', {'scale': (hi[0] - lo[0] + 1, 0.2, hi[2] - lo[2] + 1)}, color=(0.45, 0.3, 0.2))
    table = transform_shape(table, translation_matrix(((lo[0] + hi[0]) / 2, -0.1, (lo[2] + hi[2]) / 2)))
    hand = transform_shape(primitive_call('sphere', {'radius': 0.2}, color=(0.9, 0.7, 0.6)),
                           translation_matrix((chain[0].x - 0.5, 0.8, chain[0].z)))
    return concat_shapes(table, row, hand)

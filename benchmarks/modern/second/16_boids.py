"""
a flock of birds flying over a lighthouse at the sea
"""
from helper import *
import numpy as np
from dataclasses import dataclass
from functools import reduce


@dataclass
class Flock:
    pos: np.ndarray
    vel: np.ndarray
    vmax: float = 1.2

    @classmethod
    def scatter(cls, n: int, *, seed: int = 0, box: float = 4.0) -> 'Flock':
        rng = np.random.default_rng(seed)
        pos = rng.uniform(-box, box, (n, 3)) * [1, 0.3, 1]
        vel = rng.normal(0, 0.4, (n, 3)) + [0.8, 0, 0.2]
        return cls(pos, vel)

    def step(self, dt: float = 0.1):
        diff = self.pos[None, :, :] - self.pos[:, None, :]
        dist = np.linalg.norm(diff, axis=-1)
        np.fill_diagonal(dist, np.inf)
        near = (dist < 2.0)[..., None]
        weight = np.maximum(near.sum(axis=1), 1)
        cohesion = (diff * near).sum(axis=1) / weight
        align = (np.where(near, self.vel[None], 0).sum(axis=1) / weight) - self.vel
        crowded = (dist < 0.7)[..., None]
        separate = -(diff * crowded / dist[..., None] ** 2).sum(axis=1)
        acc = 0.4 * cohesion + 0.5 * align + 0.15 * separate
        acc[:, 1] -= 0.3 * self.pos[:, 1]
        self.vel = self.vel + acc * dt
        speed = np.linalg.norm(self.vel, axis=1, keepdims=True)
        self.vel *= np.minimum(1, self.vmax / speed)
        self.pos = self.pos + self.vel * dt
        return self


@register()
def bird(flap: float = 0.3, size: float = 0.3, color: tuple = (0.95, 0.95, 0.97)) -> Shape:
    body = primitive_call('cylinder', {'radius': size * 0.15, 'p0': (-size * 0.5, 0, 0), 'p1': (size * 0.5, 0, 0)}, color=color)
    head = transform_shape(primitive_call('sphere', {'radius': size * 0.18}, color=color), translation_matrix((size * 0.6, 0.03, 0)))
    beak = primitive_call('cylinder', {'radius': size * 0.05, 'p0': (size * 0.7, 0.03, 0), 'p1': (size * 0.95, 0.02, 0)}, color=(0.95, 0.6, 0.1))
    wings = []
    for s in (-1, 1):
        wing = primitive_call('cube', {'scale': (size * 0.4, 0.02, size)}, color=(0.8, 0.82, 0.86))
        wing = transform_shape(wing, translation_matrix((0, 0, s * size * 0.5)))
        wings.append(transform_shape(wing, rotation_matrix(-s * flap, (1, 0, 0), (0, 0, 0))))
    return concat_shapes(body, head, beak, *wings)


@register()
def flock(n: int = 24, steps: int = 60, seed: int = 4) -> Shape:
    f = reduce(lambda acc, _: acc.step(), range(steps), Flock.scatter(n, seed=seed))
    f.pos -= f.pos.mean(axis=0)
    out = []
    for i, (p, v) in enumerate(zip(f.pos, f.vel)):
        yaw = np.arctan2(-v[2], v[0])
        b = library_call('bird', flap=0.5 * np.sin(i * 1.7))
        out.append(transform_shape(b, translation_matrix(p) @ rotation_matrix(yaw, (0, 1, 0), (0, 0, 0))))
    return concat_shapes(*out)


@register()
def lighthouse(height: float = 4.0, bands: int = 6) -> Shape:
    def band(i: int) -> Shape:
        r = np.interp((i + 0.5) / bands, [0, 1], [0.8, 0.5])
        c = (0.85, 0.15, 0.12) if i % 2 == 0 else (0.96, 0.96, 0.94)
        return primitive_call('cylinder', {'radius': r, 'p0': (0, i * height / bands, 0), 'p1': (0, (i + 1) * height / bands, 0)}, color=c)
    gallery = primitive_call('cylinder', {'radius': 0.75, 'p0': (0, height, 0), 'p1': (0, height + 0.08, 0)}, color=(0.2, 0.2, 0.2))
    lamp = primitive_call('cylinder', {'radius': 0.35, 'p0': (0, height + 0.08, 0), 'p1': (0, height + 0.6, 0)}, color=(1.0, 0.95, 0.6))
    cap = transform_shape(primitive_call('sphere', {'radius': 0.4}, color=(0.7, 0.12, 0.1)), translation_matrix((0, height + 0.65, 0)))
    return concat_shapes(loop(bands, band), gallery, lamp, cap)


@register()
def sea(n: int = 14, pitch: float = 0.9) -> Shape:
    i, j = np.indices((n, n))
    h = 0.15 * np.sin(i * 0.9) + 0.12 * np.cos(j * 0.7 + i * 0.3)
    xz = (np.dstack([i, j]) - (n - 1) / 2) * pitch
    tiles = []
    for idx in np.ndindex(n, n):
        x, z = xz[idx]
        t = float((h[idx] - h.min()) / np.ptp(h))
        tile = primitive_call('cube', {'scale': (pitch, 0.6, pitch)}, color=(0.1 + 0.2 * t, 0.35 + 0.25 * t, 0.55 + 0.25 * t))
        tiles += transform_shape(tile, translation_matrix((x, h[idx] - 0.5, z)))
    return tiles


@register()
def coast_scene() -> Shape:
    rock = transform_shape(primitive_call('sphere', {'radius': 1.8}, color=(0.4, 0.38, 0.36)), translation_matrix((0, -1.2, 0)))
    tower = transform_shape(library_call('lighthouse'), translation_matrix((0, 0.4, 0)))
    birds = transform_shape(library_call('flock'), translation_matrix((0, 6.2, 0)))
    return concat_shapes(library_call('sea'), rock, tower, birds)

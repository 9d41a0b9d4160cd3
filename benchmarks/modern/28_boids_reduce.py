"""a flock of birds flying over hills"""
from helper import *
import numpy as np


class Flock:
    """Boids in numpy; all updates are vectorized."""

    def __init__(self, n: int, seed: int):
        rng = np.random.default_rng(seed)
        self.pos = rng.uniform(-4, 4, (n, 3)) + np.array([0, 5, 0])
        self.vel = rng.normal(0, 0.5, (n, 3)) + [1.5, 0, 0]

    def __len__(self) -> int:
        return len(self.pos)

    def step(self, dt: float = 0.05) -> None:
        diff = self.pos[None, :, :] - self.pos[:, None, :]
        dist = np.linalg.norm(diff, axis=2) + np.eye(len(self))
        near = (dist < 2.5) & ~np.eye(len(self), dtype=bool)
        count = np.maximum(near.sum(axis=1, keepdims=True), 1)
        cohesion = (diff * near[..., None]).sum(axis=1) / count
        alignment = (near.astype(float) @ self.vel) / count - self.vel * near.any(axis=1, keepdims=True)
        push = np.where((dist < 0.9)[..., None], -diff / dist[..., None] ** 2, 0.0).sum(axis=1)
        self.vel += dt * (0.6 * cohesion + 0.8 * alignment + 1.2 * push)
        speed = np.linalg.norm(self.vel, axis=1, keepdims=True)
        self.vel *= np.clip(speed, 1.0, 2.5) / speed
        self.pos += dt * self.vel

    def headings(self) -> np.ndarray:
        return np.arctan2(-self.vel[:, 2], self.vel[:, 0])


@register()
def bird(flap: float = 0.3, size: float = 1.0) -> Shape:
    dark = (0.15, 0.15, 0.2)
    body = primitive_call('cylinder', shape_kwargs={'radius': 0.06 * size, 'p0': (-0.25 * size, 0, 0), 'p1': (0.2 * size, 0, 0)}, color=dark)
    beak = primitive_call('cylinder', shape_kwargs={'radius': 0.02 * size, 'p0': (0.2 * size, 0, 0), 'p1': (0.3 * size, 0, 0)}, color=(0.95, 0.6, 0.1))
    wings = []
    for side in (-1, 1):
        wing = primitive_call('cube', shape_kwargs={'scale': (0.18 * size, 0.02 * size, 0.5 * size)}, color=dark)
        wing = transform_shape(wing, translation_matrix((0, 0, side * 0.28 * size)))
        wings.append(transform_shape(wing, rotation_matrix(-side * flap, (1, 0, 0), (0, 0, 0))))
    return concat_shapes(body, beak, *wings)


@register()
def flock(n: int = 30, steps: int = 40, seed: int = 4) -> Shape:
    f = Flock(n, seed)
    for _ in range(steps):
        f.step()
    flaps = 0.5 * np.sin(np.arange(n) * 1.7)
    return concat_shapes(*(
        transform_shape(library_call('bird', flap=fl), translation_matrix(p) @ rotation_matrix(h, (0, 1, 0), (0, 0, 0)))
        for p, h, fl in zip(f.pos, f.headings(), flaps)))


@register()
def hills() -> Shape:
    specs = [(-5, 2.5, -2), (-1, 3.2, 1), (4, 2.8, -1), (8, 2.0, 2)]
    return concat_shapes(*[transform_shape(primitive_call('sphere', shape_kwargs={'radius': r}, color=(0.3, 0.55 + 0.03 * i, 0.25)), translation_matrix((x, -r * 0.5, z))) for i, (x, r, z) in enumerate(specs)])


@register()
def birds_over_hills() -> Shape:
    return concat_shapes(library_call('hills'), library_call('flock'))

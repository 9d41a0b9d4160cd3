"""
a flock of birds that avoid each other, as a snapshot after some steps
"""
from helper import *
import numpy as np
from dataclasses import dataclass


@dataclass
class Flock:
    positions: np.ndarray
    velocities: np.ndarray
    max_speed: float = 0.4

    @classmethod
    def create(cls, n: int, seed: int = 4) -> 'Flock':
        rng = np.random.default_rng(seed)
        return cls(rng.uniform(-3, 3, (n, 3)), rng.normal(0, 0.2, (n, 3)))

    def step(self, dt: float = 1.0) -> None:
        diff = self.positions[:, None, :] - self.positions[None, :, :]
        dist = np.linalg.norm(diff, axis=-1)
        np.fill_diagonal(dist, np.inf)
        close = dist < 1.0
        separation = np.where(close[..., None], diff / dist[..., None] ** 2, 0).sum(axis=1)
        neighbours = dist < 2.5
        counts = np.maximum(neighbours.sum(axis=1, keepdims=True), 1)
        alignment = (neighbours @ self.velocities) / counts - self.velocities
        cohesion = (neighbours @ self.positions) / counts - self.positions
        self.velocities += dt * (0.05 * separation + 0.1 * alignment + 0.02 * cohesion)
        speed = np.linalg.norm(self.velocities, axis=1, keepdims=True)
        self.velocities = np.where(speed > self.max_speed, self.velocities / speed * self.max_speed, self.velocities)
        self.positions = self.positions + dt * self.velocities


@register()
def bird(size: float = 0.3) -> Shape:
    body = primitive_call('cube', color=(0.2, 0.2, 0.25), shape_kwargs={'scale': (size * 0.3, size * 0.3, size)})
    wings = [
        transform_shape(
            transform_shape(primitive_call('cube', color=(0.35, 0.35, 0.4), shape_kwargs={'scale': (size, size * 0.08, size * 0.4)}),
                            translation_matrix((side * size * 0.5, 0, 0))),
            rotation_matrix(side * 0.4, (0, 0, 1), (0, 0, 0)))
        for side in (-1, 1)
    ]
    return concat_shapes(body, *wings)


def heading(v) -> float:
    return float(np.arctan2(v[0], v[2]))


@register()
def flock() -> Shape:
    boids = Flock.create(24)
    for _ in range(30):
        boids.step()
    birds = []
    for p, v in zip(boids.positions, boids.velocities):
        pose = translation_matrix(p) @ rotation_matrix(heading(v), (0, 1, 0), (0, 0, 0))
        birds.append(transform_shape(library_call('bird', size=0.35), pose))
    return concat_shapes(*birds)

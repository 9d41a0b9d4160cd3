"""
an aquarium with a school of fish after a few steps of flocking
"""
from helper import *
import numpy as np
from dataclasses import dataclass, field


@dataclass
class School:
    n: int = 14
    seed: int = 4
    pos: np.ndarray = field(init=False)
    vel: np.ndarray = field(init=False)

    def __post_init__(self):
        rng = np.random.default_rng(self.seed)
        self.pos = rng.uniform(-1.5, 1.5, (self.n, 3))
        self.vel = rng.normal(0, 0.3, (self.n, 3))

    def step(self, dt: float = 0.1) -> None:
        diff = self.pos[:, None] - self.pos[None]
        dist = np.sqrt((diff ** 2).sum(-1))
        near = (dist < 1.2) & ~np.eye(self.n, dtype=bool)
        count = near.sum(1, keepdims=True).clip(min=1)
        cohesion = (near[:, :, None] * -diff).sum(1) / count
        separation = np.where(near[..., None], diff / np.maximum(dist, 0.1)[..., None] ** 2, 0).sum(1)
        alignment = near.astype(float) @ self.vel / count - self.vel
        self.vel += dt * (0.8 * cohesion + 0.05 * separation + 0.5 * alignment - 0.1 * self.pos)
        speed = np.linalg.norm(self.vel, axis=1, keepdims=True)
        self.vel *= np.minimum(1.0, 0.8 / speed)
        self.pos += dt * self.vel

    def run(self, steps: int) -> 'School':
        for _ in range(steps):
            self.step()
        return self


@register()
def fish(color: tuple = (0.95, 0.5, 0.1), length: float = 0.5) -> Shape:
    body = transform_shape(primitive_call('sphere', color=color, shape_kwargs={'radius': length / 2}), scale_matrix((1, 0.5, 0.3), (0, 0, 0)))
    tail = transform_shape(primitive_call('cube', color=color, shape_kwargs={'scale': (length * 0.3, length * 0.4, 0.03)}), translation_matrix((-length * 0.6, 0, 0)))
    eyes = [transform_shape(primitive_call('sphere', color=(0, 0, 0), shape_kwargs={'radius': length * 0.06}), translation_matrix((length * 0.33, length * 0.08, s * length * 0.1))) for s in (-1, 1)]
    return concat_shapes(body, tail, *eyes)


@register()
def school(n: int = 14, steps: int = 20) -> Shape:
    flock = School(n).run(steps)
    shapes = []
    for i, (p, v) in enumerate(zip(flock.pos, flock.vel)):
        yaw = -np.arctan2(v[2], v[0])
        one = library_call('fish', color=(0.95, 0.4 + 0.04 * (i % 5), 0.1), length=0.4 + 0.02 * (i % 4))
        shapes.append(transform_shape(one, translation_matrix(p) @ rotation_matrix(yaw, (0, 1, 0), (0, 0, 0))))
    return concat_shapes(*shapes)


@register()
def weed(height: float = 1.2, pieces: int = 6) -> Shape:
    t = np.linspace(0, 1, pieces + 1)
    xs, ys = 0.15 * np.sin(5 * t), height * t
    return concat_shapes(*[primitive_call('cylinder', color=(0.15, 0.5 + 0.05 * k, 0.2), shape_kwargs={'radius': 0.05, 'p0': (xs[k], ys[k], 0), 'p1': (xs[k + 1], ys[k + 1], 0)}) for k in range(pieces)])


@register()
def aquarium(size: float = 5.0) -> Shape:
    sand = transform_shape(primitive_call('cube', color=(0.85, 0.75, 0.5), shape_kwargs={'scale': (size, 0.2, size * 0.7)}), translation_matrix((0, -2.2, 0)))
    edges = [primitive_call('cylinder', color=(0.2, 0.2, 0.2), shape_kwargs={'radius': 0.05, 'p0': (x, -2.3, z), 'p1': (x, 2.2, z)}) for x in (-size / 2, size / 2) for z in (-size * 0.35, size * 0.35)]
    weeds = [transform_shape(library_call('weed', height=0.8 + 0.2 * k), translation_matrix((-2 + k * 0.9, -2.1, -0.8 + 0.3 * (k % 3)))) for k in range(5)]
    return concat_shapes(sand, *edges, *weeds, library_call('school'))

"""a murmuration of starlings swirling above a reed-lined lake at sunset"""
from helper import *
from dataclasses import dataclass, field
from itertools import islice
from typing import Iterator
import numpy as np


@dataclass
class Flock:
    count: int = 60
    seed: int = 17
    speed_limits: tuple[float, float] = (0.6, 1.6)
    weights: dict[str, float] = field(default_factory=lambda: {'cohere': 0.02, 'align': 0.12, 'separate': 0.25, 'home': 0.015})
    position: np.ndarray = field(init=False, repr=False)
    velocity: np.ndarray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        rng = np.random.default_rng(self.seed)
        self.position = rng.uniform([-5, 3, -3], [5, 6, 3], size=(self.count, 3))
        self.velocity = rng.standard_normal((self.count, 3))

    def step(self, dt: float = 0.15) -> None:
        offset = self.position[None, :, :] - self.position[:, None, :]
        distance = np.linalg.norm(offset, axis=-1)
        near = (distance < 2.0) & ~np.eye(self.count, dtype=bool)
        crowded = near & (distance < 0.7)
        n = np.maximum(near.sum(axis=1, keepdims=True), 1)
        cohere = (offset * near[..., None]).sum(axis=1) / n
        align = (near.astype(float) @ self.velocity) / n - self.velocity * near.any(axis=1, keepdims=True)
        with np.errstate(divide='ignore', invalid='ignore'):
            push = np.where(crowded[..., None], -offset / distance[..., None] ** 2, 0.0)
        home = np.array([0, 4.5, 0]) - self.position
        swirl = np.cross(home, [0.0, 1.0, 0.0]) * 0.05
        w = self.weights
        self.velocity += w['cohere'] * cohere + w['align'] * align + w['separate'] * push.sum(axis=1) + w['home'] * home + swirl
        speed = np.linalg.norm(self.velocity, axis=1, keepdims=True)
        self.velocity *= np.clip(speed, *self.speed_limits) / speed
        self.position += self.velocity * dt

    def history(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        while True:
            self.step()
            yield self.position.copy(), self.velocity.copy()


def heading(v: np.ndarray) -> np.ndarray:
    """The pose that turns +x into the direction of v."""
    yaw, pitch = np.arctan2(-v[2], v[0]), np.arcsin(v[1] / np.linalg.norm(v))
    return rotation_matrix(yaw, (0, 1, 0), (0, 0, 0)) @ rotation_matrix(pitch, (0, 0, 1), (0, 0, 0))


@register()
def starling(flap: float = 0.4, size: float = 0.16) -> Shape:
    dark = (0.08, 0.07, 0.1)
    body = transform_shape(primitive_call('sphere', shape_kwargs={'radius': size * 0.35}, color=dark), scale_matrix((2.2, 1, 1), (0, 0, 0)))
    wing = transform_shape(primitive_call('cube', shape_kwargs={'scale': (size * 0.6, size * 0.08, size * 1.3)}, color=dark), translation_matrix((0, 0, size * 0.7)))
    right = transform_shape(wing, rotation_matrix(-flap, (1, 0, 0), (0, 0, 0)))
    return concat_shapes(body, right, transform_shape(right, reflection_matrix((0, 0, 0), (0, 0, 1))))


@register()
def murmuration(count: int = 60, steps: int = 30, trail: int = 3) -> Shape:
    flock = Flock(count)
    snapshots = list(islice(flock.history(), steps - trail, steps))
    (*past, (positions, velocities)) = snapshots
    birds = []
    for i, (p, v) in enumerate(zip(positions, velocities)):
        bird = library_call('starling', flap=0.6 * np.sin(i * 1.3))
        birds.append(transform_shape(bird, translation_matrix(p) @ heading(v)))
    ghosts = [transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.015 * (age + 1)}, color=(0.6, 0.5, 0.5)), translation_matrix(p))
              for age, (ps, _) in enumerate(past) for p in ps[::4]]
    return concat_shapes(*birds, *ghosts)


@register()
def lake(radius: float = 6.0, reeds: int = 70, seed: int = 5) -> Shape:
    rng = np.random.default_rng(seed)
    water = primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': (0, -0.1, 0), 'p1': (0, 0, 0)}, color=(0.85, 0.5, 0.35))
    shimmer = [primitive_call('cylinder', shape_kwargs={'radius': radius * f, 'p0': (0, 0.002 * k, 0), 'p1': (0, 0.002 * (k + 1), 0)}, color=(0.85 + 0.03 * k, 0.5 + 0.06 * k, 0.35))
               for k, f in enumerate(np.geomspace(0.9, 0.1, 5))]
    angle = rng.uniform(0, 2 * np.pi, reeds)
    r = radius * rng.normal(1.02, 0.03, reeds)
    tall = rng.gamma(6, 0.15, reeds)
    stalks = []
    for x, z, h in zip(r * np.cos(angle), r * np.sin(angle), tall):
        stalks.append(primitive_call('cylinder', shape_kwargs={'radius': 0.02, 'p0': (x, -0.1, z), 'p1': (x + 0.1 * h, h, z)}, color=(0.4, 0.42, 0.2)))
        if h > 0.9:
            stalks.append(primitive_call('cylinder', shape_kwargs={'radius': 0.045, 'p0': (x + 0.08 * h, h * 0.85, z), 'p1': (x + 0.1 * h, h * 1.05, z)}, color=(0.35, 0.2, 0.1)))
    return concat_shapes(water, *shimmer, *stalks)


@register()
def sunset() -> Shape:
    sun = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 1.2}, color=(1.0, 0.6, 0.2)), translation_matrix((0, 0.8, -9)))
    return concat_shapes(library_call('lake'), sun, library_call('murmuration'))

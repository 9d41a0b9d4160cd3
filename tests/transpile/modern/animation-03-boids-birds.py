import numpy as np
from helper import *

"""
a flock of birds above a lake
"""

class Flock:
    def __init__(self, n: int, rng: np.random.Generator):
        self.p = rng.uniform(-3, 3, (n, 3)) + [0, 4, 0]
        self.v = rng.normal(0, 1, (n, 3))
        self._limit()

    def _limit(self, top: float = 1.2) -> None:
        speed = np.linalg.norm(self.v, axis=1, keepdims=True)
        self.v = np.where(speed > top, self.v / speed * top, self.v)

    def step(self, dt: float = 0.2) -> None:
        d = self.p[None, :, :] - self.p[:, None, :]
        r = np.linalg.norm(d, axis=2)
        near = (r > 0) & (r < 2.5)
        counts = np.maximum(near.sum(axis=1), 1)[:, None]
        cohesion = (d * near[..., None]).sum(axis=1) / counts
        alignment = (near[..., None] * self.v[None]).sum(axis=1) / counts - self.v * near.any(axis=1)[:, None]
        close = (r > 0) & (r < 0.8)
        separation = -(d * close[..., None] / np.maximum(r, 0.1)[..., None] ** 2).sum(axis=1)
        home = np.array([0, 4, 0]) - self.p
        self.v += dt * (0.5 * cohesion + 0.4 * alignment + 0.6 * separation + 0.1 * home)
        self._limit()
        self.p += dt * self.v

@register()
def bird(flap: float) -> Shape:
    body = transform_shape(primitive_call('sphere', color=(0.25, 0.25, 0.3), shape_kwargs={'radius': 0.12}), scale_matrix((2, 1, 1), (0, 0, 0)))
    wings = []
    for side in (-1, 1):
        wing = transform_shape(primitive_call('cube', color=(0.4, 0.4, 0.45), shape_kwargs={'scale': (0.2, 0.02, 0.4)}), translation_matrix((0, 0, 0.25 * side)))
        wings.append(transform_shape(wing, rotation_matrix(-side * flap, (1, 0, 0), (0, 0, 0))))
    return concat_shapes(body, *wings)

@register()
def lake() -> Shape:
    return primitive_call('cylinder', color=(0.2, 0.4, 0.6), shape_kwargs={'radius': 5, 'p0': (0, -0.1, 0), 'p1': (0, 0, 0)})

@register_animation()
def flock_over_lake() -> Generator[Shape, None, None]:
    flock = Flock(12, np.random.default_rng(3))
    phases = np.random.rand(len(flock.p)) * 2 * np.pi
    water = library_call('lake')
    for frame in range(20):
        flock.step()
        birds = []
        for position, velocity, phase in zip(flock.p, flock.v, phases):
            heading = np.arctan2(-velocity[2], velocity[0])
            pose = translation_matrix(position) @ rotation_matrix(heading, (0, 1, 0), (0, 0, 0))
            birds.append(transform_shape(library_call('bird', flap=0.6 * np.sin(frame * 0.9 + phase)), pose))
        yield concat_shapes(water, *birds)

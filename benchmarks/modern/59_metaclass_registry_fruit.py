"""a fruit bowl with apples, oranges, bananas and grapes, settled by simple sphere relaxation"""
from helper import *
import numpy as np


class Fruit:
    kinds: dict[str, type] = {}
    radius: float = 0.3
    color = (1.0, 1.0, 1.0)

    def __init_subclass__(cls, **kwargs):
        super().__init_subclass__(**kwargs)
        Fruit.kinds[cls.__name__.lower()] = cls

    def flesh(self) -> Shape:
        return primitive_call('sphere', shape_kwargs={'radius': self.radius}, color=self.color)

    def build(self) -> Shape:
        return self.flesh()

    def __repr__(self) -> str:
        return f"{type(self).__name__}(r={self.radius:.2f})"


class Apple(Fruit):
    color = (0.8, 0.12, 0.1)

    def build(self):
        r = self.radius
        stalk = primitive_call('cylinder', shape_kwargs={'radius': 0.02, 'p0': (0, r * 0.9, 0), 'p1': (0.05, r * 1.25, 0)}, color=(0.35, 0.22, 0.1))
        leaf = transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.14, 0.01, 0.07)}, color=(0.2, 0.55, 0.15)), translation_matrix((0.1, r * 1.15, 0)))
        return concat_shapes(super().build(), stalk, leaf)


class Orange(Fruit):
    radius, color = 0.28, (0.98, 0.55, 0.08)

    def build(self):
        navel = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.04}, color=(0.3, 0.4, 0.15)), translation_matrix((0, self.radius, 0)))
        return super().build() + navel


class Grapes(Fruit):
    radius, color = 0.32, (0.4, 0.15, 0.45)

    def flesh(self):
        rng = np.random.default_rng(5)
        d = rng.normal(size=(18, 3))
        d *= self.radius * 0.7 / np.linalg.norm(d, axis=1)[:, None]
        return concat_shapes(*[transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.1}, color=self.color), translation_matrix(p)) for p in d])


class Banana(Fruit):
    radius, color = 0.3, (0.97, 0.85, 0.2)

    def flesh(self):
        a = np.linspace(-0.9, 0.9, 9)
        pts = np.column_stack([0.5 * np.sin(a), 0.5 - 0.5 * np.cos(a), 0 * a])
        w = 0.09 * np.sqrt(np.clip(1.05 - (a / 0.95) ** 2, 0.05, 1))
        return concat_shapes(*[primitive_call('cylinder', shape_kwargs={'radius': float(r), 'p0': p, 'p1': q}, color=self.color) for p, q, r in zip(pts, pts[1:], w)])


def settle(radii: np.ndarray, seed: int = 0, iterations: int = 120, bowl: float = 1.0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    pos = rng.uniform(-0.6, 0.6, (len(radii), 3)) + [0, 1, 0]
    for _ in range(iterations):
        pos[:, 1] -= 0.02
        delta = pos[:, None] - pos[None]
        dist = np.linalg.norm(delta, axis=-1)
        np.fill_diagonal(dist, np.inf)
        overlap = np.maximum(radii[:, None] + radii[None] - dist, 0)
        pos += 0.5 * np.sum(delta / dist[..., None] * overlap[..., None], axis=1)
        horizontal = np.hypot(pos[:, 0], pos[:, 2])
        scale = np.minimum(1.0, (bowl - 0.3 * radii) / np.maximum(horizontal, 1e-9))
        pos[:, [0, 2]] *= scale[:, None]
        pos[:, 1] = np.maximum(pos[:, 1], radii)
    return pos


@register()
def fruit(kind: str = 'apple') -> Shape:
    return Fruit.kinds[kind]().build()


@register()
def dish(radius: float = 1.25) -> Shape:
    return loop(6, lambda k: primitive_call('cylinder', shape_kwargs={'radius': radius * (0.5 + 0.1 * k), 'p0': (0, -0.3 + 0.05 * k, 0), 'p1': (0, -0.25 + 0.05 * k, 0)}, color=(0.5, 0.33, 0.2)))


@register()
def fruit_bowl(seed: int = 2) -> Shape:
    names = [*Fruit.kinds] * 2 + ['apple', 'orange']
    radii = np.array([Fruit.kinds[n].radius for n in names])
    spots = settle(radii, seed)
    spin = np.random.default_rng(seed + 1).uniform(0, 2 * np.pi, len(names))
    pieces = [transform_shape(library_call('fruit', kind=n), translation_matrix(p) @ rotation_matrix(a, (0, 1, 0), (0, 0, 0))) for n, p, a in zip(names, spots, spin)]
    return concat_shapes(library_call('dish'), *pieces)

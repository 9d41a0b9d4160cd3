"""a village around a duck pond: houses scattered at random, joined by the shortest network of paths"""
from helper import *
import math
import numpy as np
from contextlib import suppress
from typing import Protocol

np.random.seed(5)

HOUSES, POND = 11, 2.2


class Placeable(Protocol):
    def shape(self) -> Shape: ...


class Disjoint:
    """Union-find with path halving."""

    def __init__(self, n: int):
        self.parent = list(range(n))

    def find(self, a: int) -> int:
        while self.parent[a] != a:
            self.parent[a] = a = self.parent[self.parent[a]]
        return a

    def join(self, a: int, b: int) -> bool:
        a, b = self.find(a), self.find(b)
        if a == b:
            return False
        self.parent[b] = a
        return True


def scatter(n: int, spacing: float = 1.5) -> np.ndarray:
    """Points outside the pond that keep a distance from each other."""
    points: list[np.ndarray] = []
    while len(points) < n:
        p = np.random.uniform(-5.5, 5.5, size=2)
        if np.hypot(*p) < POND + 0.9:
            continue
        if all(np.linalg.norm(p - q) > spacing for q in points):
            points.append(p)
    return np.array(points)


def spanning_tree(points: np.ndarray) -> list[tuple[int, int]]:
    """Kruskal's algorithm; paths through the pond are twice as long."""
    n = len(points)
    distance = np.linalg.norm(points[:, None, :] - points[None, :, :], axis=-1)
    middle = np.linalg.norm((points[:, None, :] + points[None, :, :]) / 2, axis=-1)
    cost = np.where(middle < POND, 2 * distance, distance)
    edges = sorted((float(cost[i, j]), i, j) for i in range(n) for j in range(i + 1, n))
    sets = Disjoint(n)
    return [(i, j) for _, i, j in edges if sets.join(i, j)]


SITES = scatter(HOUSES)
PATHS = spanning_tree(SITES)
DEGREE = np.bincount(np.array(PATHS).ravel(), minlength=HOUSES)


class Placed:
    """A library word with its arguments at a place of the ground, turned around y."""

    def __init__(self, word: str, x: float, z: float, turn: float = 0.0, /, **arguments):
        self.word, self.x, self.z, self.turn, self.arguments = word, float(x), float(z), float(turn), arguments

    def shape(self) -> Shape:
        made = library_call(self.word, **self.arguments)
        if self.turn:
            made = transform_shape(made, rotation_matrix(self.turn, (0, 1, 0), (0, 0, 0)))
        return transform_shape(made, translation_matrix((self.x, 0, self.z)))


@register("a cottage; one with more paths is taller")
def cottage(storeys: int = 1, wall: tuple[float, float, float] = (0.9, 0.85, 0.75)) -> Shape:
    h = 0.45 * storeys
    body = transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.8, h, 0.6)}, color=wall), translation_matrix((0, h / 2, 0)))
    roof = loop(5, lambda i: transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.9, 0.08, 0.7 * (1 - i / 5))}, color=(0.6, 0.25, 0.18)), translation_matrix((0, h + 0.04 + 0.08 * i, 0))))
    door = transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.16, 0.3, 0.02)}, color=(0.3, 0.18, 0.1)), translation_matrix((0, 0.15, 0.31)))
    return concat_shapes(body, roof, door)


@register("a duck that swims along +x")
def duck(size: float = 0.2, color: tuple[float, float, float] = (0.95, 0.95, 0.9)) -> Shape:
    parts = [((0, 0.4, 0), 0.6, color), ((0.5, 1.1, 0), 0.35, (0.15, 0.45, 0.25)), ((0.85, 1.05, 0), 0.13, (0.95, 0.6, 0.1)), ((-0.6, 0.6, 0), 0.25, color)]
    lumps = [transform_shape(primitive_call('sphere', shape_kwargs={'radius': r}, color=c), translation_matrix(p)) for p, r, c in parts]
    return transform_shape(concat_shapes(*lumps), scale_matrix(size, (0, 0, 0)))


@register()
def paths() -> Shape:
    flat = np.column_stack([SITES[:, 0], np.full(HOUSES, 0.02), SITES[:, 1]])
    return concat_shapes(*[
        primitive_call('cylinder', shape_kwargs={'radius': 0.1, 'p0': tuple(flat[i].tolist()), 'p1': tuple(flat[j].tolist())}, color=(0.78, 0.68, 0.5))
        for i, j in PATHS])


@register()
def village_pond(ducks: int = 5) -> Shape:
    things: list[Placeable] = []
    for (x, z), degree in zip(SITES, DEGREE):
        facing = math.atan2(-x, -z)  # doors look at the pond
        things.append(Placed('cottage', x, z, facing, storeys=int(min(degree, 3))))
    for k, angle in enumerate(np.linspace(0, 2 * np.pi, ducks, endpoint=False)):
        things.append(Placed('duck', 1.2 * np.cos(angle), 1.2 * np.sin(angle), -angle - np.pi / 2, size=0.2 if k == 0 else 0.12))
    things.append("a cloud")  # not a thing with a shape: it is left out
    shapes = []
    for thing in things:
        with suppress(AttributeError):
            shapes.append(thing.shape())
    ground = primitive_call('cylinder', shape_kwargs={'radius': 8.0, 'p0': (0, -0.3, 0), 'p1': (0, 0, 0)}, color=(0.42, 0.62, 0.32))
    water = primitive_call('cylinder', shape_kwargs={'radius': POND, 'p0': (0, -0.1, 0), 'p1': (0, 0.03, 0)}, color=(0.3, 0.55, 0.75))
    return concat_shapes(ground, water, library_call('paths'), *shapes)

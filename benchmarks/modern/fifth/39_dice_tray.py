"""a felt tray with a dozen tumbling dice, some still in the air, and a tally of the results"""
from helper import *
from collections import Counter, OrderedDict, defaultdict
from dataclasses import dataclass, field
from functools import cache
from itertools import combinations, permutations, product
import numpy as np

PIPS: dict[int, list[tuple[int, int]]] = {
    1: [(0, 0)],
    2: [(-1, -1), (1, 1)],
    3: [(-1, -1), (0, 0), (1, 1)],
    4: [*product((-1, 1), repeat=2)],
    5: [*product((-1, 1), repeat=2), (0, 0)],
    6: [*product((-1, 1), (-1, 0, 1))],
}
FACES = OrderedDict([(1, (0, 1, 0)), (6, (0, -1, 0)), (2, (0, 0, 1)), (5, (0, 0, -1)), (3, (1, 0, 0)), (4, (-1, 0, 0))])
assert all(np.dot(FACES[k], FACES[7 - k]) == -1 for k in FACES)


@cache
def cube_rotations() -> tuple[np.ndarray, ...]:
    """The 24 rotations of a cube."""
    found = []
    for order in permutations(range(3)):
        for signs in product((1, -1), repeat=3):
            m = np.zeros((3, 3))
            m[range(3), order] = signs
            if np.linalg.det(m) > 0:
                found.append(m)
    return tuple(found)


def random_rotation(rng: np.random.Generator) -> np.ndarray:
    """From the QR decomposition of a random matrix, with the signs set right."""
    q, r = np.linalg.qr(rng.standard_normal((3, 3)))
    q = q * np.sign(np.diag(r))
    if np.linalg.det(q) < 0:
        q[:, 0] *= -1
    return q


def snap(rotation: np.ndarray) -> np.ndarray:
    """The cube rotation that is nearest, turned about the vertical only."""
    return max(cube_rotations(), key=lambda m: float(np.trace(m.T @ rotation)))


@dataclass
class Die:
    position: np.ndarray
    velocity: np.ndarray
    rotation: np.ndarray
    size: float = 0.3
    heading: float = 0.0
    bounces: int = field(default=0, init=False)

    @property
    def resting(self) -> bool:
        return self.bounces >= 3

    @property
    def top(self) -> int:
        return max(FACES, key=lambda k: (self.rotation @ np.array(FACES[k]))[1])

    def step(self, dt: float = 0.02) -> None:
        if self.resting:
            return
        self.velocity = self.velocity + np.array([0, -9.8, 0]) * dt
        self.position = self.position + self.velocity * dt
        if self.position[1] < self.size / 2 and self.velocity[1] < 0:
            self.position[1] = self.size / 2
            self.velocity *= [0.6, -0.45, 0.6]
            self.bounces += 1
            if self.resting:
                self.rotation = snap(self.rotation)

    @property
    def pose(self) -> np.ndarray:
        m = np.eye(4)
        m[:3, :3], m[:3, 3] = self.rotation, self.position
        if self.resting:
            m = translation_matrix(self.position) @ rotation_matrix(self.heading, (0, 1, 0), (0, 0, 0)) @ translation_matrix(-self.position) @ m
        return m


def throw(n: int = 12, steps: int = 95, seed: int = 66) -> list[Die]:
    rng = np.random.default_rng(seed)
    dice = [Die(rng.uniform((-1.5, 1.0, -1.2), (1.5, 4.5, 1.2)), rng.normal(0, 0.6, 3), random_rotation(rng), heading=float(rng.uniform(0, np.pi))) for _ in range(n)]
    for _ in range(steps):
        for d in dice:
            d.step()
        # push apart what overlaps on the table
        for a, b in combinations(dice, 2):
            gap = (b.position - a.position) * [1, 0, 1]
            dist = np.linalg.norm(gap)
            if 0 < dist < a.size * 1.45 and abs(a.position[1] - b.position[1]) < a.size:
                shift = gap / dist * (a.size * 1.45 - dist) / 2
                a.position, b.position = a.position - shift, b.position + shift
    return dice


@register()
def die(size: float = 0.3, color: tuple = (0.95, 0.94, 0.9), pip_color: tuple = (0.1, 0.1, 0.1), pip: float = 0.09) -> Shape:
    body = primitive_call('cube', shape_kwargs={'scale': (size,) * 3}, color=color)
    dots = []
    for value, normal in FACES.items():
        n = np.array(normal, dtype=float)
        u = np.roll(n, 1)
        v = np.cross(n, u)
        for a, b in PIPS[value]:
            p = n * size / 2 + (u * a + v * b) * size * 0.27
            dots.append(primitive_call('cylinder', shape_kwargs={'radius': size * pip, 'p0': tuple(p - n * 0.005), 'p1': tuple(p + n * 0.008)}, color=pip_color))
    return concat_shapes(body, *dots)


@register()
def thrown_dice(count: int = 12, steps: int = 95, seed: int = 66) -> Shape:
    by_state: defaultdict[bool, list[Die]] = defaultdict(list)
    for d in throw(count, steps, seed):
        by_state[d.resting].append(d)
    shapes = [transform_shape(library_call('die', color=(0.95, 0.94, 0.9)), d.pose) for d in by_state[True]]
    shapes += [transform_shape(library_call('die', color=(0.8, 0.15, 0.15), pip_color=(1, 1, 1)), d.pose) for d in by_state[False]]
    return concat_shapes(*shapes)


@register()
def tally(count: int = 12, steps: int = 95, seed: int = 66, unit: float = 0.14) -> Shape:
    counts = Counter(d.top for d in throw(count, steps, seed) if d.resting)
    bars = []
    for face in range(1, 7):
        n = counts[face]
        color = (0.9, 0.7, 0.2) if counts and n == max(counts.values()) else (0.4, 0.5, 0.6)
        bars.append(transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.2, 0.02 + n * unit, 0.2)}, color=color), translation_matrix(((face - 3.5) * 0.3, (0.02 + n * unit) / 2, 0))))
        label = transform_shape(library_call('die', size=0.12), np.block([[np.linalg.inv(next(m for m in cube_rotations() if np.allclose(m @ [0, 1, 0], FACES[face]))), np.zeros((3, 1))], [np.zeros((1, 3)), np.ones((1, 1))]]))
        bars.append(transform_shape(label, translation_matrix(((face - 3.5) * 0.3, 0.06, 0.25))))
    return concat_shapes(*bars)


@register()
def tray(width: float = 4.2, depth: float = 3.4, rim: float = 0.35) -> Shape:
    felt = transform_shape(primitive_call('cube', shape_kwargs={'scale': (width, 0.05, depth)}, color=(0.1, 0.35, 0.22)), translation_matrix((0, -0.025, 0)))
    sides = [((width + 0.3, rim, 0.15), (0, rim / 2, s * (depth / 2 + 0.075))) for s in (-1, 1)] + [((0.15, rim, depth), (s * (width / 2 + 0.075), rim / 2, 0)) for s in (-1, 1)]
    return concat_shapes(felt, *(transform_shape(primitive_call('cube', shape_kwargs={'scale': s}, color=(0.4, 0.22, 0.12)), translation_matrix(p)) for s, p in sides))


@register()
def game_table() -> Shape:
    chart = transform_shape(library_call('tally'), translation_matrix((0, 0, -2.3)))
    top = primitive_call('cylinder', shape_kwargs={'radius': 3.6, 'p0': (0, -0.15, 0), 'p1': (0, -0.05, 0)}, color=(0.5, 0.33, 0.2))
    return concat_shapes(top, library_call('tray'), library_call('thrown_dice'), chart)

"""a Chinese dragon dance: a long scaled dragon on poles chasing a pearl, with lanterns overhead"""
from helper import *
from dataclasses import dataclass
import numpy as np

Vector = np.ndarray


@dataclass
class Chain:
    """Points on a string that follow the first one (FABRIK-like dragging)."""
    points: Vector
    spacing: float

    @classmethod
    def straight(cls, n: int, spacing: float, start=(0.0, 0.0, 0.0)) -> 'Chain':
        return cls(np.asarray(start) - np.outer(np.arange(n) * spacing, [1.0, 0.0, 0.0]), spacing)

    def drag(self, target: Vector) -> None:
        self.points[0] = target
        for i in range(1, len(self)):
            d = self.points[i] - self.points[i - 1]
            self.points[i] = self.points[i - 1] + d * (self.spacing / np.linalg.norm(d))

    def follow(self, path, steps: int) -> 'Chain':
        for s in np.linspace(0, 1, steps):
            self.drag(path(s))
        return self

    def __len__(self) -> int:
        return self.points.shape[0]

    def __getitem__(self, key):
        return self.points[key]

    def frames(self):
        """Position and a right-handed orthonormal frame (forward, up, side) at every point."""
        forward = -np.gradient(self.points, axis=0)
        forward /= np.linalg.norm(forward, axis=1, keepdims=True)
        side = np.cross(forward, np.array([0.0, 1.0, 0.0]))
        side /= np.linalg.norm(side, axis=1)[:, None]
        up = np.cross(side, forward)
        for p, f, u, s in zip(self.points, forward, up, side):
            m = np.eye(4)
            m[:3, :] = np.column_stack([f, u, s, p])
            yield m


def dance(s: float) -> Vector:
    """A rising figure of eight."""
    a = 2 * np.pi * s * 1.25
    return np.array([3.2 * np.sin(a), 1.7 + 0.5 * np.sin(2.5 * a), 1.8 * np.sin(2 * a)])


@register()
def scale_ring(radius: float = 0.3, scales: int = 7, color: tuple = (0.85, 0.1, 0.1)) -> Shape:
    body = primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': (-0.1, 0, 0), 'p1': (0.1, 0, 0)}, color=color)
    def scale(i: int) -> Shape:
        plate = primitive_call('cube', shape_kwargs={'scale': (0.2, 0.03, radius * 0.7)}, color=(0.95, 0.75, 0.2) if i % 2 else color)
        angle = np.pi * (i / (scales - 1) - 0.5) * 1.5
        return transform_shape(plate, rotation_matrix(angle, (1, 0, 0), (0, 0, 0)) @ translation_matrix((0, radius, 0)) @ rotation_matrix(0.25, (0, 0, 1), (0, 0, 0)))
    fin = transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.12, radius * 0.8, 0.03)}, color=(0.2, 0.6, 0.35)), translation_matrix((0, radius * 1.3, 0)) @ rotation_matrix(0.5, (0, 0, 1), (0, 0, 0)))
    return concat_shapes(body, loop(scales, scale), fin)


@register()
def dragon_head(size: float = 0.55, mouth: float = 0.5) -> Shape:
    red, gold, white = (0.85, 0.1, 0.1), (0.95, 0.75, 0.2), (0.98, 0.97, 0.93)
    skull = transform_shape(primitive_call('sphere', shape_kwargs={'radius': size * 0.6}, color=red), scale_matrix((1.1, 0.9, 1), (0, 0, 0)))
    snout = transform_shape(primitive_call('cube', shape_kwargs={'scale': (size * 0.8, size * 0.3, size * 0.6)}, color=red), translation_matrix((size * 0.8, size * 0.1, 0)))
    jaw = transform_shape(primitive_call('cube', shape_kwargs={'scale': (size * 0.8, size * 0.15, size * 0.5)}, color=gold), translation_matrix((size * 0.3, -size * 0.25, 0)) @ rotation_matrix(-mouth, (0, 0, 1), (0, 0, 0)) @ translation_matrix((size * 0.4, 0, 0)))
    half = [transform_shape(primitive_call('sphere', shape_kwargs={'radius': size * 0.16}, color=white), translation_matrix((size * 0.45, size * 0.4, size * 0.3))),
            transform_shape(primitive_call('sphere', shape_kwargs={'radius': size * 0.08}, color=(0.05, 0.05, 0.05)), translation_matrix((size * 0.57, size * 0.42, size * 0.33))),
            primitive_call('cylinder', shape_kwargs={'radius': size * 0.05, 'p0': (-size * 0.1, size * 0.4, size * 0.25), 'p1': (-size * 0.7, size * 1.0, size * 0.4)}, color=gold),
            primitive_call('cylinder', shape_kwargs={'radius': size * 0.035, 'p0': (-size * 0.4, size * 0.7, size * 0.32), 'p1': (-size * 0.35, size * 1.05, size * 0.5)}, color=gold)]
    whisker = [(size * (1.1 + 0.2 * t), size * (0.1 + 0.3 * np.sin(2 * t)), size * (0.3 + 0.5 * t)) for t in np.linspace(0, 1.5, 8)]
    half += [primitive_call('cylinder', shape_kwargs={'radius': size * 0.025, 'p0': a, 'p1': b}, color=gold) for a, b in zip(whisker, whisker[1:])]
    right = concat_shapes(*half)
    mane = loop(9, lambda i: transform_shape(primitive_call('cylinder', shape_kwargs={'radius': size * 0.07, 'p0': (0, 0, 0), 'p1': (-size * 0.6, size * 0.7, 0)}, color=white), rotation_matrix((i - 4) * 0.4, (1, 0, 0), (0, 0, 0))))
    return concat_shapes(skull, snout, jaw, mane, right, transform_shape(right, reflection_matrix((0, 0, 0), (0, 0, 1))))


@register()
def dancer(pole: float = 1.5, shirt: tuple = (0.95, 0.8, 0.2)) -> Shape:
    """Stands below the origin, which is the top of the pole."""
    h = pole
    rod = primitive_call('cylinder', shape_kwargs={'radius': 0.025, 'p0': (0, 0, 0), 'p1': (0, -h * 0.65, 0)}, color=(0.5, 0.35, 0.2))
    torso = transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.18, h * 0.32, 0.28)}, color=shirt), translation_matrix((-0.15, -h * 0.55, 0)))
    head = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.1}, color=(0.85, 0.65, 0.5)), translation_matrix((-0.15, -h * 0.32, 0)))
    limbs = [primitive_call('cylinder', shape_kwargs={'radius': 0.05, 'p0': (-0.15, -h * 0.7, s * 0.08), 'p1': (-0.15 + s * 0.18, -h, s * 0.1)}, color=(0.75, 0.1, 0.1)) for s in (-1, 1)]
    arms = [primitive_call('cylinder', shape_kwargs={'radius': 0.035, 'p0': (-0.15, -h * 0.42, s * 0.14), 'p1': (0, -h * 0.5, 0)}, color=shirt) for s in (-1, 1)]
    return concat_shapes(rod, torso, head, *limbs, *arms)


@register()
def dragon(segments: int = 52, spacing: float = 0.2, handlers: int = 7) -> Shape:
    body = Chain.straight(segments, spacing, start=dance(0)).follow(dance, 240)
    fade = np.concatenate([np.linspace(0.26, 0.34, segments // 3), np.linspace(0.34, 0.06, segments - segments // 3)])
    rings = [transform_shape(library_call('scale_ring', radius=float(r), color=(0.85, 0.1 + 0.2 * (i % 2), 0.1)), m) for i, (r, m) in enumerate(zip(fade, body.frames())) if i]
    head = transform_shape(library_call('dragon_head'), next(body.frames()))
    stations = np.unique(np.linspace(0, segments - 1, handlers).round().astype(int))
    people = []
    for i in stations:
        x, y, z = body[i]
        people.append(transform_shape(library_call('dancer', pole=float(y)), translation_matrix((x, y, z))))
    pearl_at = body[0] + (body[0] - body[3]) * 2.2
    pearl = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.22}, color=(1, 0.9, 0.5)), translation_matrix(pearl_at))
    return concat_shapes(*rings, head, *people, pearl)


@register()
def lantern_string(count: int = 9, width: float = 9.0, sag: float = 0.8) -> Shape:
    x = np.linspace(-width / 2, width / 2, count)
    # a catenary through both ends, found with a polynomial fit of three points
    coefficients = np.polyfit([-width / 2, 0, width / 2], [0, -sag, 0], 2)
    y = np.polyval(coefficients, x)
    out = [primitive_call('cylinder', shape_kwargs={'radius': 0.012, 'p0': (*a, 0.0), 'p1': (*b, 0.0)}, color=(0.2, 0.2, 0.2)) for a, b in zip(zip(x, y), zip(x[1:], y[1:]))]
    for px, py in zip(x, y):
        lamp = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.2}, color=(0.9, 0.15, 0.1)), translation_matrix((px, py - 0.3, 0)) @ scale_matrix((1, 0.85, 1), (0, 0, 0)))
        out += [lamp, primitive_call('cylinder', shape_kwargs={'radius': 0.08, 'p0': (px, py - 0.5, 0), 'p1': (px, py - 0.1, 0)}, color=(0.95, 0.75, 0.2)), primitive_call('cylinder', shape_kwargs={'radius': 0.02, 'p0': (px, py - 0.75, 0), 'p1': (px, py - 0.5, 0)}, color=(0.95, 0.6, 0.1))]
    return concat_shapes(*out)


@register()
def festival() -> Shape:
    square = transform_shape(primitive_call('cube', shape_kwargs={'scale': (11, 0.1, 8)}, color=(0.5, 0.47, 0.45)), translation_matrix((0, -0.05, 0)))
    strings = [transform_shape(library_call('lantern_string', count=7 + 2 * k), translation_matrix((0, 4.4, -2.5 + 2.5 * k))) for k in range(3)]
    return concat_shapes(square, library_call('dragon'), *strings)

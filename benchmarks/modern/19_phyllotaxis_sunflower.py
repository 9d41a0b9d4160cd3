"""a field of sunflowers with phyllotaxis seed heads"""
from helper import *
import numpy as np

GOLDEN = np.pi * (3 - np.sqrt(5))


def vogel(n: int, spacing: float) -> np.ndarray:
    k = np.arange(n)
    r, a = spacing * np.sqrt(k), k * GOLDEN
    return np.column_stack((r * np.cos(a), r * np.sin(a), 0.03 * (1 - (r / r.max()) ** 2)))


@register()
def seed_head(n: int = 80, spacing: float = 0.03) -> Shape:
    pts = vogel(n, spacing)
    tone = np.interp(np.linalg.norm(pts[:, :2], axis=1), [0, pts[:, :2].max()], [0.2, 0.5])
    seeds = [
        transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.022}, color=(t, t * 0.65, 0.08)), translation_matrix(p))
        for p, t in zip(pts, tone)
    ]
    disc = primitive_call('cylinder', shape_kwargs={'radius': spacing * n ** 0.5, 'p0': (0, 0, -0.05), 'p1': (0, 0, 0)}, color=(0.3, 0.2, 0.08))
    return concat_shapes(disc, *seeds)


@register()
def petals(n: int = 21, inner: float = 0.26, length: float = 0.22) -> Shape:
    petal = transform_shape(
        primitive_call('cube', shape_kwargs={'scale': (length, 0.07, 0.015)}, color=(0.98, 0.8, 0.1)),
        translation_matrix((inner + length / 2, 0, 0)))
    return loop(n, lambda i: transform_shape(petal, rotation_matrix(2 * np.pi * i / n, (0, 0, 1), (0, 0, 0))))


@register()
def sunflower(height: float = 1.6, droop: float = 0.35, heading: float = 0.0) -> Shape:
    stem = primitive_call('cylinder', shape_kwargs={'radius': 0.03, 'p0': (0, 0, 0), 'p1': (0, height, 0)}, color=(0.3, 0.5, 0.15))
    head = concat_shapes(library_call('seed_head'), library_call('petals'))
    head = transform_shape(head, rotation_matrix(-droop, (1, 0, 0), (0, 0, 0)))
    head = transform_shape(head, translation_matrix((0, height, 0.05)))
    leaves = [transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.3, 0.01, 0.14)}, color=(0.25, 0.55, 0.2)),
                              translation_matrix((s * 0.15, height * f, 0))) for s, f in ((-1, 0.4), (1, 0.55))]
    return transform_shape(concat_shapes(stem, head, *leaves), rotation_matrix(heading, (0, 1, 0), (0, 0, 0)))


@register()
def sunflower_field(rows: int = 2, cols: int = 4, seed: int = 42) -> Shape:
    rng = np.random.default_rng(seed)
    jitter = rng.normal(scale=0.08, size=(rows, cols, 2))
    heights = rng.uniform(1.3, 1.8, size=(rows, cols))
    headings = rng.uniform(-0.3, 0.3, size=(rows, cols))
    flowers = []
    for (i, j), h in np.ndenumerate(heights):
        dx, dz = jitter[i, j]
        f = library_call('sunflower', height=float(h), heading=float(headings[i, j]))
        flowers.append(transform_shape(f, translation_matrix((j * 0.9 + dx, 0, -i * 1.2 + dz))))
    soil = transform_shape(primitive_call('cube', shape_kwargs={'scale': (5, 0.1, 4)}, color=(0.35, 0.25, 0.15)), translation_matrix((1.35, -0.05, -0.6)))
    return concat_shapes(soil, *flowers)

"""
an amphitheatre computed with numpy arrays
"""
from helper import *
import numpy as np


@register()
def seat(color) -> Shape:
    return primitive_call('cube', color=color, shape_kwargs={'scale': (0.5, 0.4, 0.45)})


@register()
def amphitheatre(rows: int = 6, aisles: int = 4) -> Shape:
    radii = 4 + 0.8 * np.arange(rows)
    heights = 0.45 * np.arange(rows)
    shapes = []
    palette = np.array([[0.7, 0.2, 0.2], [0.75, 0.5, 0.2], [0.3, 0.5, 0.3]])
    for row, (r, h) in enumerate(zip(radii, heights)):
        n = int(np.pi * r / 0.65)
        angles = np.linspace(0, np.pi, n)
        keep = np.ones(n, dtype=bool)
        gaps = np.linspace(0, np.pi, aisles + 1)[1:-1]
        keep &= (np.abs(angles[:, None] - gaps[None, :]).min(axis=1) > 0.35 / r)
        xs, zs = r * np.cos(angles[keep]), r * np.sin(angles[keep])
        color = palette[row % len(palette)] * (1 - 0.05 * row)
        for x, z, a in zip(xs, zs, angles[keep]):
            pose = translation_matrix([x, h, z]) @ rotation_matrix(np.pi / 2 - a, [0, 1, 0], [0, 0, 0])
            shapes.append(transform_shape(library_call('seat', color=tuple(color)), pose))
    return concat_shapes(*shapes)


@register()
def stage() -> Shape:
    boards = np.stack(np.meshgrid(np.arange(-2, 3), np.arange(-1, 2), indexing='ij'), axis=-1).reshape(-1, 2)
    tint = 0.4 + 0.1 * (boards.sum(axis=1) % 2)
    return concat_shapes(*[
        transform_shape(primitive_call('cube', color=(t, t * 0.7, t * 0.4), shape_kwargs={'scale': (0.98, 0.2, 0.98)}), translation_matrix((bx, -0.1, by)))
        for (bx, by), t in zip(boards, tint)
    ])


@register()
def theatre() -> Shape:
    audience = library_call('amphitheatre')
    center = compute_shape_center(audience)
    return concat_shapes(audience, transform_shape(library_call('stage'), translation_matrix((center[0], 0, -0.5))))

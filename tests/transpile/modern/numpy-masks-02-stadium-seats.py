import numpy as np
from helper import *

"""
stadium seats that show a picture
"""

def picture(rows: int, cols: int) -> np.ndarray:
    """An image of color indexes, made with masks, slices and np.select."""
    y, x = np.mgrid[0:rows, 0:cols]
    heart = (np.abs(x - cols // 2) + np.abs(y - rows // 2)) <= 3
    border = (y == 0) | (y == rows - 1)
    checks = (x + y) % 2 == 0
    image = np.select([heart, border, checks], [3, 2, 1], default=0)
    image[rows // 2, cols // 2] = 4
    image[1:3, :2] = image[1:3, -2:] = 5
    return image

COLORS = np.array([
    [0.2, 0.3, 0.6], [0.25, 0.35, 0.7], [0.9, 0.9, 0.9],
    [0.9, 0.1, 0.2], [1.0, 0.9, 0.2], [0.1, 0.6, 0.3],
])

@register()
def seat(color: tuple) -> Shape:
    base = primitive_call('cube', color=color, shape_kwargs={'scale': (0.4, 0.08, 0.4)})
    back = transform_shape(primitive_call('cube', color=color, shape_kwargs={'scale': (0.4, 0.4, 0.06)}), translation_matrix((0, 0.2, -0.2)))
    return concat_shapes(base, back)

@register()
def stand(rows: int = 8, cols: int = 15) -> Shape:
    image = picture(rows, cols)
    taken = np.ones(image.shape, bool)
    taken[::3, 1::4] = False
    taken &= ~np.eye(rows, cols, k=2, dtype=bool)
    rgb = COLORS[image]
    rgb[image == 3] *= 0.9
    shapes = []
    for (r, c), present in np.ndenumerate(taken):
        if not present:
            continue
        shapes.append(transform_shape(library_call('seat', color=tuple(rgb[r, c])), translation_matrix((0.5 * (c - cols // 2), 0.4 * r, -0.6 * r))))
    return concat_shapes(*shapes)

@register()
def stadium() -> Shape:
    image = picture(8, 15)
    values, counts = np.unique(image, return_counts=True)
    columns = []
    for v, n in zip(values.tolist(), counts.tolist()):
        bar = primitive_call('cube', color=tuple(COLORS[v]), shape_kwargs={'scale': (0.5, 0.05 * n, 0.5)})
        columns.append(transform_shape(bar, translation_matrix((0.8 * v - 2, 0.025 * n, 2))))
    pitch = primitive_call('cube', color=(0.2, 0.6, 0.2), shape_kwargs={'scale': (8, 0.05, 3)})
    spread = np.ptp(counts) / 20
    mast = primitive_call('cylinder', color=(0.6, 0.6, 0.6), shape_kwargs={'radius': 0.1, 'p0': (4.5, 0, 0), 'p1': (4.5, spread, 0)})
    return concat_shapes(library_call('stand'), transform_shape(pitch, translation_matrix((0, -0.05, 2))), mast, *columns)

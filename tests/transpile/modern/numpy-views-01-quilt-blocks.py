import numpy as np
from helper import *

"""
a quilt sewn from views: changing a view changes the cloth
"""

FABRICS = {0: (0.95, 0.92, 0.85), 1: (0.75, 0.2, 0.25), 2: (0.2, 0.35, 0.6), 3: (0.85, 0.65, 0.2), 4: (0.3, 0.5, 0.35)}


def quilt(n: int = 12) -> np.ndarray:
    cloth = np.zeros((n, n), dtype=int)
    border = cloth[1:-1, 1:-1]          # a view
    border[:] = 1
    border[1:-1, 1:-1] = 0
    middle = cloth[4:8, 4:8]
    middle[...] = np.arange(16).reshape(4, 4) % 4
    middle.T[0] = 2                     # a view of a view
    corner = cloth[:3, :3].copy()       # not a view
    corner += 9
    diagonal = cloth[np.arange(3), np.arange(3)]  # fancy indexing copies
    diagonal[:] = 4
    cloth[-3:, -3:] = np.rot90(middle[:3, :3])
    cloth[:3, -3:] = np.flip(middle[1:, 1:], axis=1)
    flat = cloth.ravel()
    flat[::13] = 3                      # the main diagonal through a flat view
    rows = cloth[::2]
    rows[1, ::2], rows[2, ::2] = 4, rows[1, ::2]
    cloth[:, 0] ^= 1
    a, b = cloth[9], cloth[10]
    a[2:5], b[2:5] = b[2:5].copy(), a[2:5].copy()
    return cloth


@register()
def patch(fabric: int) -> Shape:
    square = primitive_call('cube', color=FABRICS.get(fabric, (0.5, 0.3, 0.5)), shape_kwargs={'scale': (0.96, 0.1 + 0.03 * fabric, 0.96)})
    if fabric != 3:
        return square
    button = primitive_call('sphere', color=(1, 1, 1), shape_kwargs={'radius': 0.12})
    return concat_shapes(square, transform_shape(button, translation_matrix((0, 0.12, 0))))


@register()
def bed_with_quilt() -> Shape:
    cloth = quilt()
    shapes = [
        transform_shape(library_call('patch', fabric=int(v)), translation_matrix((c - 5.5, 1, r - 5.5)))
        for (r, c), v in np.ndenumerate(cloth)
    ]
    frame = transform_shape(primitive_call('cube', color=(0.4, 0.25, 0.15), shape_kwargs={'scale': (12.5, 0.8, 12.5)}), translation_matrix((0, 0.4, 0)))
    sums = cloth.sum(axis=0)
    rails = [primitive_call('cylinder', color=(0.5, 0.3, 0.2), shape_kwargs={'radius': 0.15, 'p0': (i - 5.5, 0.8, -6.5), 'p1': (i - 5.5, 1 + 0.1 * s, -6.5)}) for i, s in enumerate(sums)]
    return concat_shapes(frame, *shapes, *rails)

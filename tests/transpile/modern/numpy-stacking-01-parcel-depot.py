import numpy as np
from helper import *

"""
a parcel depot: footprints joined by stack, tile, repeat, pad and split
"""

SMALL = np.array([[1, 2], [3, 4]])


def layouts() -> list[np.ndarray]:
    a = SMALL
    b = a.T + 4
    return [
        np.vstack([a, b]),
        np.hstack((a, b, [[9], [9]])),
        np.concatenate([a, b], axis=1)[::-1],
        np.tile(a, (2, 2)),
        np.repeat(a, 2, axis=0),
        np.repeat(a.ravel(), [1, 2, 1, 2]).reshape(2, 3),
        np.pad(a, 1, constant_values=1),
        np.pad(a, ((0, 1), (1, 0)), mode="edge"),
        np.rot90(np.arange(6).reshape(2, 3)),
        np.flipud(np.hstack([a, np.fliplr(a)])),
        np.roll(np.arange(9).reshape(3, 3), 1, axis=1),
        np.stack([a, b], axis=-1).reshape(2, 4),
        np.block([[a, np.zeros((2, 1))], [np.ones((1, 2)), 7]]).astype(int),
        np.delete(np.arange(12).reshape(3, 4), 1, axis=1),
        np.insert(a, 1, 8, axis=0),
        np.array_split(np.arange(10), 3)[0][None, :].repeat(2, axis=0),
        np.kron(np.eye(2, dtype=int), a),
        np.diag([3, 1, 2]) + np.tri(3, dtype=int),
    ]


@register()
def parcel_stack(count: int, hue: float) -> Shape:
    colors = ((0.7, 0.5, 0.3), (0.75, 0.6, 0.4))
    return loop(min(count, 3), lambda i: transform_shape(
        primitive_call('cube', color=(*colors[i % 2][:2], hue), shape_kwargs={'scale': (0.8, 0.3 if i < 2 else 0.1 * (count - 1), 0.8)}),
        translation_matrix((0, 0.2 + 0.35 * i, 0))))


@register()
def pallet(layout: np.ndarray, hue: float) -> Shape:
    rows, cols = layout.shape
    deck = primitive_call('cube', color=(0.5, 0.4, 0.3), shape_kwargs={'scale': (cols, 0.1, rows)})
    stacks = [transform_shape(library_call('parcel_stack', count=int(n), hue=hue), translation_matrix((c - (cols - 1) / 2, 0, r - (rows - 1) / 2))) for (r, c), n in np.ndenumerate(layout) if n]
    return concat_shapes(deck, *stacks)


@register()
def depot() -> Shape:
    shapes = []
    x = z = depth = 0.0
    for k, layout in enumerate(layouts()):
        rows, cols = layout.shape
        shapes.append(transform_shape(library_call('pallet', layout=layout, hue=k / 20), translation_matrix((x + cols / 2, 0, z))))
        x += cols + 0.5
        depth = max(depth, rows)
        if k % 6 == 5:
            x, z, depth = 0.0, z + depth + 1, 0.0
    return concat_shapes(*shapes)

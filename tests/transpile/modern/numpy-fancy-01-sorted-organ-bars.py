import numpy as np
from helper import *

"""
sorting a field of columns with argsort, take, lexsort and friends
"""

HEIGHTS = np.array([3, 1, 4, 1, 5, 9, 2, 6, 5, 3, 5, 8])
WIDTHS = np.array([2, 7, 1, 8, 2, 8, 1, 8, 2, 8, 4, 5]) / 10


def variants() -> dict[str, np.ndarray]:
    h = HEIGHTS
    swapped = h.copy()
    swapped[[0, -1]] = swapped[[-1, 0]]
    bumped = h.copy()
    bumped[[1, 1, 3]] += 2  # a repeated index counts once
    added = h.copy()
    np.add.at(added, [1, 1, 3], 2)
    return {
        "sorted": h[np.argsort(h, kind="stable")],
        "falling": h[np.argsort(-h, kind="stable")],
        "by width": np.take(h, np.lexsort((h, WIDTHS))),
        "swapped": swapped,
        "bumped": bumped,
        "added": added,
        "ranks": np.argsort(np.argsort(h, kind="stable"), kind="stable") + 1,
        "rolled": np.roll(h, 3),
        "picked": np.where(h > 4, h, h[::-1]),
        "clipped": h.clip(2, 6),
        "running": np.maximum.accumulate(h),
        "diffs": np.abs(np.diff(h, append=0)),
    }


@register()
def bar_row(heights: np.ndarray, shade: float) -> Shape:
    shapes = []
    for i, (h, w) in enumerate(zip(heights, WIDTHS)):
        size = 0.2 * h + 0.02
        bar = primitive_call('cube', color=(shade, 0.3 + h / 20, 1 - shade), shape_kwargs={'scale': (0.3 + w / 2, size, 0.5)})
        shapes.append(transform_shape(bar, translation_matrix((0.9 * i, size / 2, 0))))
    return concat_shapes(*shapes)


@register()
def organ_bars() -> Shape:
    table = variants()
    shapes = []
    for k, (name, heights) in enumerate(table.items()):
        shapes.append(transform_shape(library_call('bar_row', heights=heights, shade=k / len(table)), translation_matrix((0, 0, -1.0 * k))))
    grid = np.array(list(table.values()))
    rows, cols = grid.shape
    best = grid[np.arange(rows), grid.argmax(axis=1)]
    markers = [transform_shape(primitive_call('sphere', color=(1, 0.8, 0.2), shape_kwargs={'radius': 0.03 * b}), translation_matrix((-1, 0.2 * b, -1.0 * k))) for k, b in enumerate(best)]
    block = grid[np.ix_([0, 2, 4], [1, 3])]
    where = np.searchsorted(np.sort(HEIGHTS), [2, 5, 9])
    signs = [transform_shape(primitive_call('cube', color=(0.9, 0.2, 0.2), shape_kwargs={'scale': (0.2, 0.2, 0.1 * v)}), translation_matrix((p, -0.5, 0.1 * s))) for v, p, s in zip(block.sum(axis=1), where, block[:, 0])]
    return concat_shapes(*shapes, *markers, *signs)

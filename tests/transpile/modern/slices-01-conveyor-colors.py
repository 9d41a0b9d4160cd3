from helper import *

"""
a bead counter: rows made with every kind of slice
"""

BASE = list(range(12))


def rows() -> list[list[int]]:
    a = BASE[:]
    result = [a[2:9], a[::3], a[::-1], a[-4:], a[:-8:-1], a[8:2:-2], a[100:], a[3:-3]]

    b = BASE.copy()
    b[2:5] = [20]
    b[:0] = [30, 31]
    b[len(b):] = (40,)
    result.append(b)

    c = list(BASE)
    c[::2] = c[1::2][::-1]
    result.append(c)

    d = BASE[:8]
    del d[1]
    del d[-3:]
    d.insert(-1, 50)
    result.append(d)

    e = BASE[:]
    del e[::3]
    e[1:1] = "ab" and [60, 61]
    result.append(e)

    window = slice(1, None, 4)
    result.append(BASE[window] + list(range(*slice(None, 20, 6).indices(30))))

    first, *middle, last = BASE
    (x, *_), [*ys, z] = [7, 8, 9], (1, 2, 3)
    result.append([last, *middle[::5], first, x, *ys, z])

    text = "conveyor"
    result.append([ord(ch) - 96 for ch in text[1:-1:2] + text[::-1][:3]])
    return result


@register()
def bead(value: int) -> Shape:
    hue = (value % 12) / 12
    color = (abs(1 - 2 * hue), hue, 1 - hue)
    return primitive_call('sphere', color=color, shape_kwargs={'radius': 0.15 + 0.004 * value})


@register()
def bead_row(values: list) -> Shape:
    n = max(len(values), 1)
    wire = primitive_call('cylinder', color=(0.3, 0.3, 0.3), shape_kwargs={'radius': 0.03, 'p0': (-0.5, 0, 0), 'p1': (n - 0.5, 0, 0)})
    return concat_shapes(wire, *[transform_shape(library_call('bead', value=v), translation_matrix((i, 0, 0))) for i, v in enumerate(values)])


@register()
def bead_counter() -> Shape:
    table = rows()
    shapes = [transform_shape(library_call('bead_row', values=row), translation_matrix((0, -0.6 * k, 0))) for k, row in enumerate(table)]
    column = [row[0] for row in table if row]
    shapes[-2:] = shapes[-1:-3:-1]
    side = [transform_shape(library_call('bead', value=v), translation_matrix((-1.5, -0.6 * k, 0))) for k, v in enumerate(column[::-1])]
    return concat_shapes(*shapes, *side)

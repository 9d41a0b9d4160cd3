from helper import *

"""
a toolbox: positional-only, keyword-only and forwarded arguments everywhere
"""


def cube(w, h=None, d=None, /, *, at=(0, 0, 0), **style) -> Shape:
    h = w if h is None else h
    d = h if d is None else d
    style.setdefault('color', (0.5, 0.5, 0.55))
    return transform_shape(primitive_call('cube', shape_kwargs={'scale': (w, h, d)}, **style), translation_matrix(at))


def rod(*points, radius=0.05, **style) -> Shape:
    """A bent rod through any number of points."""
    style = {'color': (0.6, 0.6, 0.65)} | style
    return concat_shapes(*[
        primitive_call('cylinder', shape_kwargs=dict(radius=radius, p0=a, p1=b), **style)
        for a, b in zip(points, points[1:])
    ])


def total(*numbers: float, scale: float = 1, **named: float) -> float:
    return scale * (sum(numbers) + sum(named.values()))


@register()
def hammer(length: float = 1.0, *, head: float = 0.3) -> Shape:
    return concat_shapes(rod((0, 0, 0), (0, length, 0), color=(0.6, 0.4, 0.2)), cube(head, head / 2, at=(0, length, 0)))


@register()
def hexkey(*, size: float, **style) -> Shape:
    return rod((0, 0, 0), (0, size, 0), (size / 3, size, 0), radius=size / 15, **style)


@register()
def saw(length: float, teeth: int = 8) -> Shape:
    blade = cube(length, 0.3, 0.03, at=(length / 2, 0, 0), color=(0.8, 0.8, 0.82))
    grip = cube(0.3, 0.4, 0.1, at=(-0.15, 0, 0), color=(0.8, 0.3, 0.1))
    points = [cube(length / teeth / 2, at=((i + 0.5) * length / teeth, -0.17, 0)) for i in range(teeth)]
    return concat_shapes(blade, grip, *points)


def arrange(*tools, gap=0.8, start=0.0, **poses) -> Shape:
    placed, x = [], start
    for name, kwargs in tools:
        y = poses.get(name, 0)
        placed.append(transform_shape(library_call(name, **kwargs), translation_matrix((x, y, 0))))
        x += gap
    return concat_shapes(*placed)


@register()
def toolbox() -> Shape:
    tools = [('hammer', {}), ('hammer', {'length': 1.4, 'head': 0.4}), *(('hexkey', dict(size=s, color=(s, 0.4, 0.4))) for s in (0.5, 0.7, 0.9)), ('saw', {'length': 1.5})]
    options = {'gap': 0.7, **{'saw': 0.5}}
    width = total(*[1] * len(tools), scale=0.7, margin=2.0, extra=total(0.1, 0.2))
    board = cube(width, 0.1, 1, at=(width / 2 - 0.5, -0.1, 0), color=(0.7, 0.1, 0.1))
    back = cube(*(width, 2), 0.1, at=(width / 2 - 0.5, 0.9, -0.5))
    return concat_shapes(board, back, arrange(*tools, **options))

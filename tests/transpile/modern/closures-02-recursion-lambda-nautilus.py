from helper import *

"""
sea shells grown by recursive lambdas
"""

# the fixed point combinator, because why not
fix = lambda f: (lambda x: x(x))(lambda x: f(lambda *a: x(x)(*a)))

fib = fix(lambda rec: lambda n: n if n < 2 else rec(n - 1) + rec(n - 2))
power = lambda b, n: 1 if n == 0 else b * power(b, n - 1) if n % 2 else power(b * b, n // 2)

def spiral_growth(rate: float, turn: float):
    angle = 0.0
    size = 0.1

    def grow():
        nonlocal angle, size
        point = (size * 4 * math.cos(angle), size * 4 * math.sin(angle), 0), size
        angle, size = angle + turn, size * rate
        return point

    return grow

def thresholds(*limits):
    """A chain of closures: each one handles what is below its limit."""
    def build(rest):
        if not rest:
            return lambda v: (0.9, 0.85, 0.8)
        (limit, color), *others = rest
        following = build(others)
        return lambda v: color if v < limit else following(v)
    return build(limits)

shade = thresholds((0.15, (0.5, 0.3, 0.2)), (0.25, (0.7, 0.5, 0.35)), (0.4, (0.85, 0.7, 0.55)))

@register()
def nautilus(chambers: int, rate: float) -> Shape:
    grow = spiral_growth(rate, 0.5)
    shapes = []
    for _ in range(chambers):
        point, size = grow()
        shell = primitive_call('sphere', color=shade(size), shape_kwargs={'radius': size * 1.2})
        shapes.append(transform_shape(shell, translation_matrix(point)))
    return concat_shapes(*shapes)

@register()
def beach() -> Shape:
    shells = [transform_shape(library_call('nautilus', chambers=12 + 4 * k, rate=1.05 + 0.01 * k), translation_matrix((4.0 * k, 0, 0))) for k in range(3)]
    pebbles = []
    for n in range(1, 10):
        r = 0.02 * fib(n) + 0.05
        pebble = transform_shape(primitive_call('sphere', color=(0.6, 0.6, 0.58), shape_kwargs={'radius': r}), translation_matrix((n - 1, -2.5, power(-1, n) * r)))
        pebbles.append(pebble)
    steps = (lambda self, n: [] if n == 0 else self(self, n - 1) + [n])(lambda self, n: [] if n == 0 else self(self, n - 1) + [n], 5)
    dunes = [transform_shape(primitive_call('cube', color=(0.85, 0.75, 0.5), shape_kwargs={'scale': (10, 0.1 * n, 1)}), translation_matrix((4, -3.5, n))) for n in steps]
    return concat_shapes(*shells, *pebbles, *dunes)

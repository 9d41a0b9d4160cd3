from helper import *

"""
a skyline of Collatz sequences, with prime towers marked
"""


def is_prime(n: int) -> bool:
    for d in range(2, int(n ** 0.5) + 1):
        if n % d == 0:
            break
    else:
        return n > 1
    return False


def collatz(n: int, limit: int = 20) -> tuple[list[int], bool]:
    values = [n]
    while (n := n // 2 if n % 2 == 0 else 3 * n + 1) != 1:
        values.append(n)
        if len(values) >= limit:
            break
    else:
        values.append(1)
        return values, True
    return values, False


def first_gap(values: list[int], size: int) -> int | None:
    for i, (a, b) in enumerate(zip(values, values[1:])):
        if abs(b - a) <= size:
            continue
        return i
    return None


def classify(v: int) -> str:
    return "low" if v < 5 else "mid" if 5 <= v < 16 else "high" if v <= 64 else "huge"


COLORS = {"low": (0.3, 0.5, 0.8), "mid": (0.3, 0.7, 0.4), "high": (0.9, 0.7, 0.2), "huge": (0.9, 0.3, 0.2)}


@register()
def tower(values: list, complete: bool) -> Shape:
    y, shapes = 0.0, []
    for v in values:
        h = 0.1 + 0.04 * v.bit_length()
        width = 0.4 + 0.1 * (v % 3)
        shapes.append(transform_shape(primitive_call('cube', color=COLORS[classify(v)], shape_kwargs={'scale': (width, h, width)}), translation_matrix((0, y + h / 2, 0))))
        y += h
    if complete:
        shapes.append(primitive_call('cylinder', color=(0.9, 0.9, 0.9), shape_kwargs={'radius': 0.03, 'p0': (0, y, 0), 'p1': (0, y + 0.5, 0)}))
    return concat_shapes(*shapes)


@register()
def skyline() -> Shape:
    shapes = []
    for n in range(2, 16):
        values, complete = collatz(n)
        col, row = (n - 2) % 5, (n - 2) // 5
        shapes.append(transform_shape(library_call('tower', values=values, complete=complete), translation_matrix((1.2 * col, 0, -1.5 * row))))
        if is_prime(n) and (gap := first_gap(values, 3)) is not None and 0 <= gap < len(values) - 1:
            shapes.append(transform_shape(primitive_call('sphere', color=(1, 0.2, 0.6), shape_kwargs={'radius': 0.1 + 0.05 * gap}), translation_matrix((1.2 * col, 0, -1.5 * row + 0.6))))
    while len(shapes) < 30:
        if not shapes:
            break
        shapes.append(transform_shape(primitive_call('cube', color=(0.4, 0.4, 0.4), shape_kwargs={'scale': (0.2, 0.1, 0.2)}), translation_matrix((0.3 * len(shapes), 0, 1.5))))
    else:
        shapes.append(transform_shape(primitive_call('cube', color=(0.2, 0.2, 0.2), shape_kwargs={'scale': (9, 0.05, 7)}), translation_matrix((2.4, -0.03, -1.5))))
    return concat_shapes(*shapes)

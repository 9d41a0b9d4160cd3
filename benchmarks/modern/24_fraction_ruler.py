"""a wooden ruler with tick marks at binary fractions of an inch, and a pencil next to it"""
from fractions import Fraction
from helper import *

INCHES = 6
FINEST = Fraction(1, 16)
LENGTHS = {1: 0.5, 2: 0.35, 4: 0.25, 8: 0.17, 16: 0.1}


def ticks(total: int, step: Fraction):
    pos = Fraction(0)
    while pos <= total:
        yield pos, LENGTHS[pos.denominator]
        pos += step


@register()
def tick(at: Fraction, length: float, thickness: float = 0.012) -> Shape:
    mark = primitive_call('cube', shape_kwargs={'scale': (thickness, 0.01, length)}, color=(0.05, 0.05, 0.05))
    return transform_shape(mark, translation_matrix((float(at), 0.055, -0.5 + length / 2)))


@register()
def ruler(inches: int = INCHES) -> Shape:
    body = primitive_call('cube', shape_kwargs={'scale': (inches + 0.3, 0.1, 1.0)}, color=(0.85, 0.7, 0.45))
    edge = primitive_call('cube', shape_kwargs={'scale': (inches + 0.3, 0.03, 0.03)}, color=(0.8, 0.8, 0.82))
    marks = [library_call('tick', at=p, length=l) for p, l in ticks(inches, FINEST)]
    return concat_shapes(
        transform_shape(body, translation_matrix((inches / 2, 0, 0))),
        transform_shape(edge, translation_matrix((inches / 2, 0.03, -0.51))),
        *marks,
    )


@register()
def pencil(length: float = 5.5, radius: float = 0.14) -> Shape:
    def along(x0, x1, r, color):
        return primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': (x0, 0, 0), 'p1': (x1, 0, 0)}, color=color)
    cone = [along(length + 0.05 * i, length + 0.05 * (i + 1), radius * (1 - i / 8), (0.9, 0.75, 0.55) if i < 6 else (0.15, 0.15, 0.15)) for i in range(8)]
    return concat_shapes(along(0, length, radius, (0.95, 0.75, 0.1)), along(-0.2, 0, radius * 1.02, (0.75, 0.75, 0.78)), along(-0.45, -0.2, radius, (0.9, 0.5, 0.5)), *cone)


@register()
def desk_set() -> Shape:
    p = transform_shape(library_call('pencil'), rotation_matrix(0.15, (0, 1, 0), (0, 0, 0)))
    return concat_shapes(library_call('ruler'), transform_shape(p, translation_matrix((0.2, 0.1, 1.4))))

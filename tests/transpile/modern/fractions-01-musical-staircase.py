from fractions import Fraction
from math import gcd, lcm
from helper import *

"""
just intonation as stairs, and Egyptian fractions as sliced cylinders
"""

RATIOS = [Fraction(1), Fraction(9, 8), Fraction(5, 4), Fraction("4/3"), Fraction(3, 2), Fraction(5, 3), Fraction(15, 8), Fraction(2)]

def egyptian(f: Fraction) -> List[Fraction]:
    """Greedy unit fractions that add up to f."""
    parts = []
    while f > 0:
        denominator = -(-f.denominator // f.numerator)
        parts.append(Fraction(1, denominator))
        f -= parts[-1]
    return parts

def continued(x: Fraction) -> List[int]:
    terms = []
    while True:
        whole = x.numerator // x.denominator
        terms.append(whole)
        if x == whole:
            return terms
        x = 1 / (x - whole)

@register()
def stair(index: int, ratio: Fraction) -> Shape:
    height = float(ratio)
    consonant = ratio.denominator <= 3
    step = primitive_call('cube', color=(0.9, 0.8, 0.5) if consonant else (0.5, 0.4, 0.3), shape_kwargs={'scale': (0.6, height, 1.5)})
    step = transform_shape(step, translation_matrix((0.6 * index, height / 2, 0)))
    beads = loop(ratio.numerator, lambda i: transform_shape(primitive_call('sphere', color=(0.2, 0.3, 0.8), shape_kwargs={'radius': 0.04}), translation_matrix((0.6 * index, height + 0.05, -0.7 + 0.09 * i))))
    return concat_shapes(step, beads)

@register()
def egyptian_column(f: Fraction) -> Shape:
    y, shapes = Fraction(0), []
    for k, part in enumerate(egyptian(f)):
        shapes.append(primitive_call('cylinder', color=(0.8, 0.3 + 0.2 * k, 0.2), shape_kwargs={'radius': 0.3, 'p0': (0, 2 * float(y), 0), 'p1': (0, 2 * float(y + part), 0)}))
        y += part
    assert y == f
    return concat_shapes(*shapes)

@register()
def music_steps() -> Shape:
    shapes = [library_call('stair', index=i, ratio=r) for i, r in enumerate(RATIOS)]
    for k, f in enumerate([Fraction(4, 5), Fraction(7, 15), Fraction(5, 6), Fraction(3, 7)]):
        shapes.append(transform_shape(library_call('egyptian_column', f=f), translation_matrix((1.2 * k, 0, 2))))
    terms = continued(Fraction(355, 113))
    total = sum(RATIOS, start=Fraction(0))
    floor = primitive_call('cube', color=(0.3, 0.3, 0.3), shape_kwargs={'scale': (float(total) / 2, 0.1, 5)})
    common = lcm(*(r.denominator for r in RATIOS)) // gcd(8, 12)
    bars = [transform_shape(primitive_call('cube', color=(0.2, 0.6, 0.4), shape_kwargs={'scale': (0.3, 0.1 * t, 0.3)}), translation_matrix((0.5 * k, 0.05 * t, 3))) for k, t in enumerate([*terms, common, round(Fraction(7, 2)), int(Fraction(-7, 2)) + 5])]
    return concat_shapes(transform_shape(floor, translation_matrix((2, -0.05, 1))), *shapes, *bars)

from fractions import Fraction


def ratio(size: int) -> Fraction:
    return 1 / Fraction(size, 4)


@register()
def scene() -> Shape:
    return primitive_call('cube', shape_kwargs={'scale': [1, *(float(ratio(size)) for size in (0, 8))]})

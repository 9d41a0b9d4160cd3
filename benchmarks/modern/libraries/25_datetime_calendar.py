"""
a calendar of cubes for march 2026
"""
from helper import *
import calendar
from datetime import date, timedelta


@register()
def day_tile(weekend: bool = False) -> Shape:
    return primitive_call('cube', color=(.9, .4, .3) if weekend else (.9, .9, .9), shape_kwargs={'scale': (.9, .9, .2)})


@register()
def month() -> Shape:
    first = date(2026, 3, 1)
    _, days = calendar.monthrange(2026, 3)
    shapes = []
    row = 0
    for n in range(days):
        day = first + timedelta(days=n)
        if day.weekday() == 0 and n:
            row += 1
        shapes.append(transform_shape(library_call('day_tile', weekend=day.weekday() >= 5), translation_matrix((day.weekday(), -row, 0))))
    return concat_shapes(*shapes)

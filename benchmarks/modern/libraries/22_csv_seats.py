"""
seats from a table
"""
from helper import *
import csv
import io

DATA = """row,count,color,price
A,5,red,30.5
B,7,green,20
C,9,blue,12.25
"""
COLORS = {'red': (.8, .1, .1), 'green': (.1, .7, .2), 'blue': (.1, .2, .8)}


@register()
def seat(color, height: float = .5) -> Shape:
    return primitive_call('cube', color=color, shape_kwargs={'scale': (.6, height, .6)})


@register()
def theatre() -> Shape:
    shapes = []
    reader = csv.DictReader(io.StringIO(DATA))
    for r, row in enumerate(reader):
        n = int(row['count'])
        for i in range(n):
            shapes.append(transform_shape(library_call('seat', color=COLORS[row['color']], height=.3 + float(row['price']) / 50), translation_matrix((i - (n - 1) / 2, r * .4, r))))
    return concat_shapes(*shapes)

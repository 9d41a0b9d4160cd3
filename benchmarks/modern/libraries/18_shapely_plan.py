"""
walls around the union of rooms
"""
from helper import *
from shapely.geometry import Polygon, Point, box
from shapely.ops import unary_union

ROOMS = [box(0, 0, 4, 3), box(3, 1, 7, 5), Point(2, 4).buffer(1.5)]


@register()
def wall(a, b, height: float = 1.0) -> Shape:
    return primitive_call('cylinder', color=(.8, .75, .7), shape_kwargs={'radius': .1, 'p0': (a[0], height, a[1]), 'p1': (b[0], height, b[1])})


@register()
def plan() -> Shape:
    outline = unary_union(ROOMS)
    coords = list(outline.exterior.coords)
    walls = [library_call('wall', a=a, b=b) for a, b in zip(coords, coords[1:])]
    c = outline.centroid
    pole = transform_shape(primitive_call('cube', color=(1, 0, 0), shape_kwargs={'scale': (.2, outline.area / 10, .2)}), translation_matrix((c.x, 0, c.y)))
    lamps = [transform_shape(primitive_call('sphere', color=(1, 1, 0), shape_kwargs={'radius': .2}), translation_matrix((x, 2, z)))
             for x in range(8) for z in range(6) if outline.contains(Point(x, z))]
    return concat_shapes(*walls, pole, *lamps)

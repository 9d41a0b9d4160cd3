"""
a geodesic dome of rods
"""
from helper import *
import numpy as np
import trimesh


@register()
def dome() -> Shape:
    mesh = trimesh.creation.icosphere(subdivisions=1, radius=3.0)
    shapes = []
    for a, b in mesh.edges_unique:
        p, q = mesh.vertices[a], mesh.vertices[b]
        if p[1] >= -.01 and q[1] >= -.01:
            shapes.append(primitive_call('cylinder', color=(.8, .8, .8), shape_kwargs={'radius': .05, 'p0': tuple(p), 'p1': tuple(q)}))
    for v in mesh.vertices:
        if v[1] >= -.01:
            shapes.append(transform_shape(primitive_call('sphere', color=(.9, .2, .2), shape_kwargs={'radius': .1}), translation_matrix(v)))
    return concat_shapes(*shapes)

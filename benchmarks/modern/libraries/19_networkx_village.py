"""
a village whose roads are a spanning tree
"""
from helper import *
import networkx as nx
import numpy as np

rng = np.random.default_rng(2)
HOUSES = [tuple(map(float, p)) for p in rng.uniform(-6, 6, size=(12, 2))]


@register()
def house() -> Shape:
    return transform_shape(primitive_call('cube', color=(.8, .6, .4), shape_kwargs={'scale': (.8, .7, .8)}), translation_matrix((0, .35, 0)))


@register()
def village() -> Shape:
    G = nx.Graph()
    for i, p in enumerate(HOUSES):
        G.add_node(i, pos=p)
    for i in range(len(HOUSES)):
        for j in range(i + 1, len(HOUSES)):
            G.add_edge(i, j, weight=float(np.hypot(HOUSES[i][0] - HOUSES[j][0], HOUSES[i][1] - HOUSES[j][1])))
    mst = nx.minimum_spanning_tree(G)
    roads = []
    for a, b, data in mst.edges(data=True):
        (x0, z0), (x1, z1) = G.nodes[a]['pos'], G.nodes[b]['pos']
        roads.append(primitive_call('cylinder', color=(.4, .4, .4), shape_kwargs={'radius': .1 + .01 * data['weight'], 'p0': (x0, 0, z0), 'p1': (x1, 0, z1)}))
    houses = [transform_shape(library_call('house'), translation_matrix((x, 0, z))) for x, z in HOUSES]
    return concat_shapes(*roads, *houses)

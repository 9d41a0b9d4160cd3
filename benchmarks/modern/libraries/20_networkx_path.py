"""
a path through a maze
"""
from helper import *
import networkx as nx


@register()
def maze_path() -> Shape:
    G = nx.grid_2d_graph(6, 6)
    G.remove_nodes_from([(1, 1), (1, 2), (1, 3), (3, 4), (3, 3), (3, 2), (4, 2)])
    path = nx.shortest_path(G, (0, 0), (5, 5))
    tiles = []
    for node in sorted(G.nodes):
        on = node in path
        tiles.append(transform_shape(primitive_call('cube', color=(.9, .3, .1) if on else (.8, .8, .8), shape_kwargs={'scale': (.9, .3 if on else .1, .9)}), translation_matrix((node[0], 0, node[1]))))
    degree = dict(G.degree())
    posts = [transform_shape(primitive_call('sphere', color=(0, 0, 1), shape_kwargs={'radius': .05 * degree[n]}), translation_matrix((n[0], .5, n[1]))) for n in path]
    return concat_shapes(*tiles, *posts)

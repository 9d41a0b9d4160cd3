import numpy as np
from dataclasses import dataclass, field
from helper import *

"""
an airline network laid out by forces between its nodes
"""


@dataclass
class Graph:
    edges: list[tuple[str, str]]
    names: list[str] = field(init=False)
    adjacency: np.ndarray = field(init=False, repr=False)

    def __post_init__(self):
        self.names = sorted({n for e in self.edges for n in e})
        index = {n: i for i, n in enumerate(self.names)}
        self.adjacency = np.zeros((len(self.names),) * 2)
        for a, b in self.edges:
            self.adjacency[index[a], index[b]] = self.adjacency[index[b], index[a]] = 1

    def layout(self, steps: int = 60, k: float = 1.2) -> np.ndarray:
        rng = np.random.default_rng(0)
        p = rng.uniform(-1, 1, (len(self.names), 3))
        temperature = 0.3
        for _ in range(steps):
            d = p[:, None] - p[None]
            r = np.linalg.norm(d, axis=-1) + 1e-6
            force = k * k / r ** 2 - self.adjacency * r / k
            move = np.einsum("ij,ijk->ik", force, d)
            length = np.linalg.norm(move, axis=1, keepdims=True)
            p += move / np.maximum(length, 1e-9) * np.minimum(length, temperature)
            temperature *= 0.95
        return p - p.mean(axis=0)

    def degree(self) -> np.ndarray:
        return self.adjacency.sum(axis=1).astype(int)

    def components(self) -> list[set[int]]:
        left, found = set(range(len(self.names))), []
        while left:
            stack, group = [min(left)], set()
            while stack:
                v = stack.pop()
                if v in group:
                    continue
                group.add(v)
                stack.extend(int(w) for w in np.flatnonzero(self.adjacency[v]) if w not in group)
            left -= group
            found.append(group)
        return found


ROUTES = "OSL-CPH OSL-LHR CPH-LHR CPH-FRA FRA-LHR FRA-FCO FCO-ATH LHR-JFK JFK-BOS JFK-LAX LAX-HNL SYD-AKL SYD-MEL"


@register()
def airport(degree: int, tint: float) -> Shape:
    return primitive_call('sphere', color=(0.9, 0.8 - tint, 0.2 + tint), shape_kwargs={'radius': 0.12 + 0.04 * degree})


@register()
def network() -> Shape:
    graph = Graph([tuple(r.split("-")) for r in ROUTES.split()])
    p, degree = graph.layout(), graph.degree()
    group = {v: g for g, members in enumerate(graph.components()) for v in members}
    shapes = [transform_shape(library_call('airport', degree=int(degree[i]), tint=0.5 * group[i]), translation_matrix(p[i])) for i in range(len(p))]
    for i, j in np.argwhere(np.triu(graph.adjacency)):
        shapes.append(primitive_call('cylinder', color=(0.6, 0.6, 0.7), shape_kwargs={'radius': 0.03, 'p0': p[i], 'p1': p[j]}))
    hubs = [graph.names[i] for i in np.argsort(-degree, kind="stable")[:3]]
    for hub in hubs:
        spot = p[graph.names.index(hub)]
        shapes.append(primitive_call('cylinder', color=(0.9, 0.1, 0.1), shape_kwargs={'radius': 0.02, 'p0': spot, 'p1': spot + [0, 0.8, 0]}))
    return concat_shapes(*shapes)

"""
a truss bridge whose members are coloured by the force that they carry
"""
from helper import *
import numpy as np
from dataclasses import dataclass, astuple
from itertools import combinations


@dataclass(frozen=True)
class Member:
    a: int
    b: int
    kind: str


class Truss:
    def __init__(self, panels: int, pitch: float, height: float):
        self.panels = panels
        bottom = [(i * pitch, 0.0) for i in range(panels + 1)]
        top = [((i + 0.5) * pitch, height) for i in range(panels)]
        self.nodes = np.array(bottom + top)
        n = panels + 1
        self.members = (
            [Member(i, i + 1, 'deck') for i in range(panels)]
            + [Member(n + i, n + i + 1, 'chord') for i in range(panels - 1)]
            + [Member(i, n + i, 'web') for i in range(panels)]
            + [Member(n + i, i + 1, 'web') for i in range(panels)]
        )

    def __len__(self):
        return len(self.nodes)

    def equilibrium(self) -> np.ndarray:
        n = len(self)
        A = np.zeros((2 * n, len(self.members) + 3))
        for j, m in enumerate(self.members):
            d = self.nodes[m.b] - self.nodes[m.a]
            u = d / np.linalg.norm(d)
            A[2 * m.a:2 * m.a + 2, j] += u
            A[2 * m.b:2 * m.b + 2, j] -= u
        A[0, -3] = 1
        A[1, -2] = 1
        A[2 * self.panels + 1, -1] = 1
        return A

    def forces(self, load: float = 1.0) -> np.ndarray:
        f = np.zeros(2 * len(self))
        for i in range(1, self.panels):
            f[2 * i + 1] = load
        return np.linalg.solve(self.equilibrium(), f)[:len(self.members)]


def color_of(force: float, largest: float) -> tuple[float, float, float]:
    t = force / largest
    return (0.8, 0.8 * (1 - t), 0.8 * (1 - t)) if t > 0 else (0.8 * (1 + t), 0.8 * (1 + t), 0.8)


@register()
def truss(panels: int = 6, pitch: float = 1.5, height: float = 1.4, side: float = 0.0) -> Shape:
    model = Truss(panels, pitch, height)
    forces = model.forces()
    largest = np.abs(forces).max()
    bars = []
    for member, force in zip(model.members, forces):
        a, b, kind = astuple(member)
        (x0, y0), (x1, y1) = model.nodes[a], model.nodes[b]
        r = {'deck': 0.08, 'chord': 0.1, 'web': 0.06}[kind]
        bars.append(primitive_call('cylinder', color=color_of(force, largest), shape_kwargs={'radius': r, 'p0': (x0, y0, side), 'p1': (x1, y1, side)}))
    joints = [transform_shape(primitive_call('sphere', color=(0.3, 0.3, 0.3), shape_kwargs={'radius': 0.13}), translation_matrix((x, y, side))) for x, y in model.nodes]
    return concat_shapes(*bars, *joints)


@register()
def deck(length: float = 9.0, width: float = 2.0, planks: int = 30) -> Shape:
    return loop(planks, lambda i: transform_shape(primitive_call('cube', color=(0.5, 0.36, 0.2), shape_kwargs={'scale': (length / planks * 0.9, 0.08, width)}), translation_matrix(((i + 0.5) * length / planks, 0.05, 0))))


@register()
def truss_bridge(panels: int = 6, pitch: float = 1.5, width: float = 2.0) -> Shape:
    sides = [library_call('truss', panels=panels, pitch=pitch, side=s * width / 2) for s in (-1, 1)]
    piers = [transform_shape(primitive_call('cube', color=(0.6, 0.6, 0.58), shape_kwargs={'scale': (0.8, 2, width + 0.4)}), translation_matrix((x, -1, 0))) for x in (0, panels * pitch)]
    pairs = list(combinations(range(panels), 2))[:4]
    braces = [primitive_call('cylinder', color=(0.5, 0.5, 0.5), shape_kwargs={'radius': 0.04, 'p0': ((i + 0.5) * pitch, 1.4, -width / 2), 'p1': ((j + 0.5) * pitch, 1.4, width / 2)}) for i, j in pairs]
    return concat_shapes(*sides, *piers, *braces, library_call('deck', length=panels * pitch, width=width))

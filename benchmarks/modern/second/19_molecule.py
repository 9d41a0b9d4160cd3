"""
a ball-and-stick model of a caffeine molecule
"""
from helper import *
import re
from collections import Counter
from io import StringIO
import csv
import numpy as np

XYZ = """\
element,x,y,z
O,0.47,2.5688,0.0006
O,-3.1271,-0.4436,-0.0003
N,-0.9686,-1.3125,0.0
N,2.2182,0.1412,-0.0003
N,-1.3477,1.0797,-0.0001
N,1.4119,-1.9372,0.0002
C,0.8579,0.2592,-0.0008
C,0.3897,-1.0264,-0.0004
C,0.0307,1.422,-0.0006
C,-1.9061,-0.2495,-0.0004
C,2.5032,-1.1998,0.0003
C,-1.4276,-2.6960,0.0008
C,3.1926,1.2061,0.0003
C,-2.2969,2.1881,0.0007
"""

ELEMENTS: dict[str, tuple[float, tuple[float, float, float]]] = {
    'H': (0.25, (0.95, 0.95, 0.95)),
    'C': (0.40, (0.25, 0.25, 0.25)),
    'N': (0.38, (0.20, 0.30, 0.85)),
    'O': (0.36, (0.85, 0.15, 0.12)),
}


class Molecule:
    def __init__(self, symbols, coords):
        self.symbols = list(symbols)
        self.coords = np.array(coords) - np.mean(coords, axis=0)

    @classmethod
    def from_csv(cls, text: str) -> 'Molecule':
        rows = list(csv.DictReader(StringIO(text)))
        return cls([r['element'] for r in rows], [[float(r[k]) for k in 'xyz'] for r in rows])

    def bonds(self, cutoff: float = 1.65):
        d = np.linalg.norm(self.coords[:, None] - self.coords[None], axis=2)
        i, j = np.where(np.triu((d < cutoff), k=1))
        for a, b in zip(i.tolist(), j.tolist()):
            yield a, b, bool(d[a, b] < 1.27)

    @property
    def formula(self) -> str:
        tally = Counter(self.symbols)
        return ''.join(f'{s}{n if n > 1 else ""}' for s, n in sorted(tally.items()))

    def __repr__(self):
        return f'<{type(self).__name__} {self.formula}>'


def parse_formula(text: str) -> dict[str, int]:
    return {m['el']: int(m['n'] or 1) for m in re.finditer(r'(?P<el>[A-Z][a-z]?)(?P<n>\d*)', text)}


@register()
def atom(element: str = 'C') -> Shape:
    radius, color = ELEMENTS[element]
    return primitive_call('sphere', {'radius': radius}, color=color)


@register()
def bond(p0: P = (0, 0, 0), p1: P = (1, 0, 0), double: bool = False, radius: float = 0.1) -> Shape:
    if not double:
        return primitive_call('cylinder', {'radius': radius, 'p0': p0, 'p1': p1}, color=(0.7, 0.7, 0.7))
    off = np.cross(np.subtract(p1, p0), (0, 0, 1))
    off = off / np.linalg.norm(off) * radius * 1.2
    return concat_shapes(*(primitive_call('cylinder', {'radius': radius * 0.7, 'p0': p0 + s * off, 'p1': p1 + s * off},
                                          color=(0.7, 0.7, 0.7)) for s in (-1, 1)))


@register()
def methyl(at: P = (0, 0, 0), away: P = (1, 0, 0), length: float = 0.95) -> Shape:
    away = np.asarray(away, float) / np.linalg.norm(away)
    helper_axis = np.array([0, 0, 1.0])
    u = np.cross(away, helper_axis)
    v = np.cross(away, u)
    shapes = []
    for k in range(3):
        a = 2 * np.pi * k / 3
        d = 0.35 * away + 0.94 * (np.cos(a) * u + np.sin(a) * v)
        tip = np.asarray(at) + d * length
        shapes += [library_call('bond', p0=at, p1=tip, radius=0.07),
                   transform_shape(library_call('atom', element='H'), translation_matrix(tip))]
    return concat_shapes(*shapes)


@register()
def caffeine() -> Shape:
    mol = Molecule.from_csv(XYZ)
    assert parse_formula(mol.formula) == {'C': 8, 'N': 4, 'O': 2}, mol
    atoms = [transform_shape(library_call('atom', element=s), translation_matrix(c)) for s, c in zip(mol.symbols, mol.coords)]
    bonds = list(mol.bonds())
    sticks = [library_call('bond', p0=mol.coords[a], p1=mol.coords[b], double=dbl) for a, b, dbl in bonds]
    degree = Counter(i for a, b, _ in bonds for i in (a, b))
    ends = [i for i, s in enumerate(mol.symbols) if s == 'C' and degree[i] == 1]
    caps = []
    for i in ends:
        (j,) = [b if a == i else a for a, b, _ in bonds if i in (a, b)]
        caps.append(library_call('methyl', at=mol.coords[i], away=mol.coords[i] - mol.coords[j]))
    return concat_shapes(*atoms, *sticks, *caps)

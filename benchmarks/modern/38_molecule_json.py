"""a ball-and-stick model of caffeine-like ring molecules from an embedded table"""
from helper import *
import json
from dataclasses import dataclass
import numpy as np

MOLECULE = json.loads('''{
  "elements": {"C": {"r": 0.34, "rgb": "#333333"}, "O": {"r": 0.32, "rgb": "#dd2222"}, "N": {"r": 0.33, "rgb": "#3355dd"}, "H": {"r": 0.2, "rgb": "#f4f4f4"}},
  "atoms": [["C", 0.0, 1.4, 0.0], ["C", 1.21, 0.7, 0.0], ["N", 1.21, -0.7, 0.0], ["C", 0.0, -1.4, 0.0], ["N", -1.21, -0.7, 0.0], ["C", -1.21, 0.7, 0.0],
            ["O", 0.0, -2.65, 0.0], ["O", -2.3, 1.35, 0.0], ["H", 0.0, 2.5, 0.0], ["H", 2.2, 1.25, 0.0], ["C", 2.5, -1.45, 0.0], ["H", 3.3, -0.8, 0.4], ["H", 2.6, -2.1, -0.85], ["H", 2.6, -2.1, 0.85], ["H", -2.1, -1.25, 0.0]],
  "double": [[3, 6], [5, 7], [0, 1]]
}''')


def hex_rgb(code: str) -> tuple[float, ...]:
    code = code.lstrip('#')
    return tuple(int(code[i:i + 2], 16) / 255 for i in range(0, 6, 2))


@dataclass
class Atom:
    symbol: str
    xyz: np.ndarray

    def __post_init__(self):
        style = MOLECULE['elements'][self.symbol]
        self.radius, self.color = style['r'], hex_rgb(style['rgb'])

    def distance(self, other: 'Atom') -> float:
        return float(np.linalg.norm(self.xyz - other.xyz))


ATOMS = [Atom(s, np.array(p)) for s, *p in MOLECULE['atoms']]


def bonds():
    doubles = {frozenset(p) for p in MOLECULE['double']}
    for i, a in enumerate(ATOMS):
        for j, b in enumerate(ATOMS[i + 1:], start=i + 1):
            limit = 1.25 if 'H' in (a.symbol, b.symbol) else 1.65
            if a.distance(b) < limit:
                yield a, b, 2 if {i, j} in doubles else 1


@register()
def atom(symbol: str, xyz) -> Shape:
    a = Atom(symbol, np.asarray(xyz))
    return transform_shape(primitive_call('sphere', shape_kwargs={'radius': a.radius}, color=a.color), translation_matrix(a.xyz))


@register()
def bond(p, q, order: int = 1, radius: float = 0.09) -> Shape:
    offsets = {1: [0.0], 2: [-0.11, 0.11]}[order]
    side = np.cross(q - p, [0, 0, 1.0])
    side = side / (np.linalg.norm(side) or 1.0)
    r = radius if order == 1 else radius * 0.7
    return concat_shapes(*[primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': p + o * side, 'p1': q + o * side}, color=(0.65, 0.65, 0.65)) for o in offsets])


@register()
def molecule() -> Shape:
    atoms = [library_call('atom', symbol=a.symbol, xyz=a.xyz) for a in ATOMS]
    sticks = [library_call('bond', p=a.xyz, q=b.xyz, order=n) for a, b, n in bonds()]
    assert len(sticks) >= len(atoms) - 1, "molecule must be connected"
    return sum(atoms + sticks, [])

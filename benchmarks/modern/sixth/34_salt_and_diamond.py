"""crystal models for a chemistry class: table salt and diamond, with a legend of ions"""
from helper import *
import itertools
import json
import math
import numpy as np

SPEC = json.loads("""
{
  "atoms": {
    "Na": {"radius": 0.20, "color": [0.55, 0.35, 0.85]},
    "Cl": {"radius": 0.32, "color": [0.30, 0.80, 0.35]},
    "C":  {"radius": 0.18, "color": [0.25, 0.25, 0.28]}
  },
  "crystals": [
    {"name": "salt", "edge": 2.0, "bond": 1.0, "cells": 1,
     "basis": {"Na": [[0, 0, 0]], "Cl": [[0.5, 0.5, 0.5]]}},
    {"name": "diamond", "edge": 2.4, "bond": 1.0393, "cells": 1,
     "basis": {"C": [[0, 0, 0], [0.25, 0.25, 0.25]]}}
  ]
}
""")
ATOMS, CRYSTALS = SPEC["atoms"], {c["name"]: c for c in SPEC["crystals"]}
FACE_CENTERED = np.array([[0, 0, 0], [0, .5, .5], [.5, 0, .5], [.5, .5, 0]])


class Crystal:
    def __init__(self, *, name: str, edge: float, bond: float, cells: int, basis: dict, **_):
        self.name, self.edge, self.bond = name, edge, bond
        self.atoms: list[tuple[str, np.ndarray]] = []
        self._fill(basis, cells)

    def _fill(self, basis, cells) -> None:
        """All lattice points within a closed cube of cells."""
        shifts = list(itertools.product(range(-1, cells + 1), repeat=3))
        seen = set()
        for symbol, motif in basis.items():
            for shift, corner, offset in itertools.product(shifts, FACE_CENTERED, motif):
                p = np.array(shift) + corner + np.asarray(offset)
                key = tuple(np.round(p, 4))
                if np.all((p > -1e-6) & (p < cells + 1e-6)) and key not in seen:
                    seen.add(key)
                    self.atoms.append((symbol, (p - cells / 2) * self.edge))

    def bonds(self):
        for (_, a), (_, b) in itertools.combinations(self.atoms, 2):
            if abs(np.linalg.norm(a - b) - self.bond) < 0.02:
                yield a, b

    def count(self, symbol: str) -> int:
        return sum(1 for s, _ in self.atoms if s == symbol)


MODELS = {name: Crystal(**spec) for name, spec in CRYSTALS.items()}


@register("an atom by its symbol")
def atom(symbol: str = 'C') -> Shape:
    spec = ATOMS[symbol]
    return primitive_call('sphere', shape_kwargs={'radius': spec['radius']}, color=tuple(spec['color']))


@register("balls and sticks within a wire cube")
def crystal(name: str = 'salt') -> Shape:
    model = MODELS[name]
    balls = [transform_shape(library_call('atom', symbol=s), translation_matrix(tuple(p.tolist()))) for s, p in model.atoms]
    sticks = [primitive_call('cylinder', shape_kwargs={'radius': 0.045, 'p0': tuple(a.tolist()), 'p1': tuple(b.tolist())}, color=(0.8, 0.8, 0.8)) for a, b in model.bonds()]
    h = model.edge / 2
    corners = list(itertools.product((-h, h), repeat=3))
    wires = [primitive_call('cylinder', shape_kwargs={'radius': 0.012, 'p0': a, 'p1': b}, color=(0.2, 0.2, 0.2))
             for a, b in itertools.combinations(corners, 2) if sum(u != v for u, v in zip(a, b)) == 1]
    return concat_shapes(*balls, *sticks, *wires)


@register("rows of atoms in the order of their number")
def legend(name: str = 'salt') -> Shape:
    model = MODELS[name]
    symbols = sorted({s for s, _ in model.atoms}, key=lambda s: (-model.count(s), s))
    shapes = []
    for row, symbol in enumerate(symbols):
        for k in range(model.count(symbol)):
            small = transform_shape(library_call('atom', symbol=symbol), scale_matrix(0.25, (0, 0, 0)))
            shapes.append(transform_shape(small, translation_matrix((0.16 * k, 0, 0.3 * row))))
    return concat_shapes(*shapes)


@register()
def crystal_models() -> Shape:
    shapes = []
    for k, name in enumerate(MODELS):
        x = 4.0 * k - 2.0
        tilted = transform_shape(library_call('crystal', name=name), rotation_matrix(math.radians(15 + 20 * k), (0, 1, 0), (0, 0, 0)))
        stand = primitive_call('cylinder', shape_kwargs={'radius': 1.7, 'p0': (x, -1.7, 0), 'p1': (x, -1.5, 0)}, color=(0.5, 0.35, 0.22))
        shapes += [stand, transform_shape(tilted, translation_matrix((x, 0, 0))),
                   transform_shape(library_call('legend', name=name), translation_matrix((x - 1.1, -1.5, 1.8)))]
    return concat_shapes(*shapes)

"""a DNA double helix with base pairs colored by a sequence"""
from helper import *
from functools import partial, reduce
import math
import operator

SEQUENCE = "ATGCGTACCTGATTACAGGCTTAACG"
PAIRS = dict(zip("ATGC", "TACG"))
COLORS = {"A": (0.9, 0.25, 0.2), "T": (0.95, 0.75, 0.2), "G": (0.2, 0.6, 0.3), "C": (0.2, 0.4, 0.85)}
BACKBONE = (0.75, 0.75, 0.8)

sphere = partial(primitive_call, 'sphere')
cylinder = partial(primitive_call, 'cylinder')


def helix_point(i: float, *, radius: float, rise: float, twist: float, phase: float = 0.0):
    a = i * twist + phase
    return (radius * math.cos(a), i * rise, radius * math.sin(a))


@register()
def base_pair(letter: str, p, q) -> Shape:
    mid = tuple((a + b) / 2 for a, b in zip(p, q))
    left = cylinder(shape_kwargs={'radius': 0.08, 'p0': p, 'p1': mid}, color=COLORS[letter])
    right = cylinder(shape_kwargs={'radius': 0.08, 'p0': mid, 'p1': q}, color=COLORS[PAIRS[letter]])
    return left + right


@register()
def backbone(strand) -> Shape:
    beads = [transform_shape(sphere(shape_kwargs={'radius': 0.16}, color=BACKBONE), translation_matrix(p)) for p in strand]
    links = [cylinder(shape_kwargs={'radius': 0.07, 'p0': p, 'p1': q}, color=BACKBONE) for p, q in zip(strand[:-1], strand[1:])]
    return reduce(operator.add, beads + links)


@register()
def dna(sequence: str = SEQUENCE, radius: float = 1.0, rise: float = 0.34, bp_per_turn: float = 10.5) -> Shape:
    if bad := set(sequence) - PAIRS.keys():
        raise ValueError(f"unknown bases: {sorted(bad)}")
    at = partial(helix_point, radius=radius, rise=rise, twist=math.tau / bp_per_turn)
    a = [at(i) for i in range(len(sequence))]
    b = [at(i, phase=math.radians(150)) for i in range(len(sequence))]
    pairs = [library_call('base_pair', letter=s, p=p, q=q) for s, p, q in zip(sequence, a, b, strict=True)]
    return concat_shapes(library_call('backbone', strand=a), library_call('backbone', strand=b), *pairs)


@register()
def dna_on_stand() -> Shape:
    model = library_call('dna')
    center = compute_shape_center(model)
    height = compute_shape_sizes(model)[1]
    stand = cylinder(shape_kwargs={'radius': 1.3, 'p0': (0, -height / 2 - 0.4, 0), 'p1': (0, -height / 2 - 0.2, 0)}, color=(0.1, 0.1, 0.1))
    return concat_shapes(transform_shape(model, translation_matrix(-center)), stand)

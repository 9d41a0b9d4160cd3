"""a classroom model of the DNA double helix on a stand"""
from helper import *
import math

# the base on the other strand, and the color of each base
PAIR = {'A': 'T', 'T': 'A', 'C': 'G', 'G': 'C'}
BASE_COLORS = {
    'A': (0.9, 0.25, 0.2),
    'T': (0.2, 0.5, 0.9),
    'C': (0.95, 0.8, 0.2),
    'G': (0.25, 0.7, 0.35),
}
SEQUENCE = 'ATGGCATTACGCTAGGATCCATGC'
BACKBONE = ((0.85, 0.85, 0.9), (0.45, 0.45, 0.55))


def helix_point(step: float, strand: int, radius: float, rise: float, twist: float) -> tuple[float, float, float]:
    # the second strand is shifted by the minor groove
    phase = math.radians(twist * step + (0 if strand == 0 else 150))
    return (radius * math.cos(phase), rise * step, radius * math.sin(phase))


def midpoint(a, b):
    return tuple((u + v) / 2 for u, v in zip(a, b))


@register("two half rods of different color between two points")
def base_pair(a: tuple[float, float, float] = (-1.0, 0.0, 0.0), b: tuple[float, float, float] = (1.0, 0.0, 0.0), letter: str = 'A') -> Shape:
    m = midpoint(a, b)
    bonds = 3 if letter in 'CG' else 2
    left = primitive_call('cylinder', shape_kwargs={'radius': 0.09, 'p0': a, 'p1': m}, color=BASE_COLORS[letter])
    right = primitive_call('cylinder', shape_kwargs={'radius': 0.09, 'p0': m, 'p1': b}, color=BASE_COLORS[PAIR[letter]])
    dots = []
    for k in range(bonds):
        offset = 0.07 * (k - (bonds - 1) / 2)
        dot = primitive_call('sphere', shape_kwargs={'radius': 0.03}, color=(1, 1, 1))
        dots.append(transform_shape(dot, translation_matrix((m[0], m[1] + 0.1, m[2] + offset))))
    return concat_shapes(left, right, *dots)


@register("sugar and phosphate beads of one strand, linked by rods")
def strand(which: int = 0, length: int = 24, radius: float = 1.0, rise: float = 0.34, twist: float = 36.0) -> Shape:
    points = [helix_point(i, which, radius, rise, twist) for i in range(length)]
    beads = [
        transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.16}, color=BACKBONE[which]), translation_matrix(p))
        for p in points
    ]
    links = []
    for i in range(length - 1):
        half = helix_point(i + 0.5, which, radius, rise, twist)
        for a, b in ((points[i], half), (half, points[i + 1])):
            links.append(primitive_call('cylinder', shape_kwargs={'radius': 0.06, 'p0': a, 'p1': b}, color=(0.7, 0.5, 0.2)))
    return concat_shapes(*beads, *links)


@register("the ladder for a sequence")
def double_helix(sequence: str = SEQUENCE, radius: float = 1.0, rise: float = 0.34, twist: float = 36.0) -> Shape:
    n = len(sequence)
    pairs = [
        library_call('base_pair', a=helix_point(i, 0, radius, rise, twist), b=helix_point(i, 1, radius, rise, twist), letter=letter)
        for i, letter in enumerate(sequence)
    ]
    strands = [library_call('strand', which=w, length=n, radius=radius, rise=rise, twist=twist) for w in range(2)]
    return concat_shapes(*strands, *pairs)


@register("a legend: one ball for each letter, with as many of them as the sequence has")
def legend() -> Shape:
    columns = []
    for index, letter in enumerate('ACGT'):
        count = SEQUENCE.count(letter)
        for k in range(count):
            ball = primitive_call('sphere', shape_kwargs={'radius': 0.1}, color=BASE_COLORS[letter])
            columns.append(transform_shape(ball, translation_matrix((2.2 + 0.25 * index, 0.1 + 0.2 * k, 0))))
    return concat_shapes(*columns)


@register()
def dna_model() -> Shape:
    base = primitive_call('cylinder', shape_kwargs={'radius': 1.4, 'p0': (0, -0.7, 0), 'p1': (0, -0.5, 0)}, color=(0.25, 0.2, 0.18))
    post = primitive_call('cylinder', shape_kwargs={'radius': 0.05, 'p0': (0, -0.5, 0), 'p1': (0, 8.2, 0)}, color=(0.6, 0.6, 0.6))
    shelf = transform_shape(primitive_call('cube', shape_kwargs={'scale': (1.4, 0.1, 0.6)}, color=(0.25, 0.2, 0.18)), translation_matrix((2.6, -0.05, 0)))
    return concat_shapes(base, post, shelf, library_call('double_helix'), library_call('legend'))

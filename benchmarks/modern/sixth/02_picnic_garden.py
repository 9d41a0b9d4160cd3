"""a picnic table on a lawn with a hedge and flower beds"""
from helper import *
import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Wood:
    color: tuple[float, float, float]
    plank: float = 0.14
    gap: float = 0.02

    @property
    def pitch(self) -> float:
        return self.plank + self.gap


PINE = Wood((0.76, 0.57, 0.33))


def box(size, at, color) -> Shape:
    return transform_shape(primitive_call('cube', shape_kwargs={'scale': size}, color=color), translation_matrix(at))


@register("planks side by side, centered, with their upper side at y = 0")
def planks(count: int = 5, length: float = 1.8) -> Shape:
    offset = (count - 1) / 2
    return loop(count, lambda i: box((length, 0.04, PINE.plank), (0, -0.02, (i - offset) * PINE.pitch), PINE.color))


@register("an A-shaped trestle in the yz plane")
def trestle(height: float = 0.75, spread: float = 0.6) -> Shape:
    top = spread * 0.35
    legs = [
        primitive_call('cylinder', shape_kwargs={'radius': 0.035, 'p0': (0, height, s * top), 'p1': (0, 0, s * spread)}, color=PINE.color)
        for s in (-1, 1)
    ]
    beam_height = 0.42
    beam = box((0.06, 0.08, 2 * spread + 0.5), (0, beam_height - 0.06, 0), PINE.color)
    return concat_shapes(*legs, beam)


@register()
def picnic_table(length: float = 1.8, height: float = 0.75) -> Shape:
    tabletop = transform_shape(library_call('planks', count=5, length=length), translation_matrix((0, height + 0.04, 0)))
    benches = [
        transform_shape(library_call('planks', count=2, length=length), translation_matrix((0, 0.44, side * 0.72)))
        for side in (-1, 1)
    ]
    trestles = [
        transform_shape(library_call('trestle', height=height), translation_matrix((end * length * 0.35, 0, 0)))
        for end in (-1, 1)
    ]
    return concat_shapes(tabletop, *benches, *trestles)


@register("a flower with petals around a yellow heart")
def flower(petals: int = 6, height: float = 0.3, color: tuple[float, float, float] = (0.9, 0.3, 0.5)) -> Shape:
    stem = primitive_call('cylinder', shape_kwargs={'radius': 0.008, 'p0': (0, 0, 0), 'p1': (0, height, 0)}, color=(0.2, 0.5, 0.15))
    heart = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.025}, color=(0.95, 0.8, 0.1)), translation_matrix((0, height, 0)))

    def petal(i: int) -> Shape:
        a = 2 * math.pi * i / petals
        return transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.028}, color=color),
                               translation_matrix((0.05 * math.cos(a), height, 0.05 * math.sin(a))))

    return concat_shapes(stem, heart, loop(petals, petal))


@register()
def flower_bed(columns: int = 8, rows: int = 2) -> Shape:
    palette = {0: (0.9, 0.3, 0.5), 1: (0.95, 0.95, 0.9), 2: (0.6, 0.35, 0.85)}
    soil = box((columns * 0.25, 0.06, rows * 0.25), (0, 0.03, 0), (0.3, 0.2, 0.12))
    shapes = [soil]
    for row in range(rows):
        for column in range(columns):
            x = (column - (columns - 1) / 2) * 0.25
            z = (row - (rows - 1) / 2) * 0.25
            kind = (row + column) % len(palette)
            shapes.append(transform_shape(
                library_call('flower', petals=5 + kind, height=0.25 + 0.04 * kind, color=palette[kind]),
                translation_matrix((x, 0.06, z))))
    return concat_shapes(*shapes)


@register("a clipped hedge of overlapping bushes")
def hedge(length: float = 4.0, bushes: int = 12) -> Shape:
    step = length / (bushes - 1)
    return loop(bushes, lambda i: transform_shape(
        primitive_call('sphere', shape_kwargs={'radius': 0.28 + 0.03 * (i % 3)}, color=(0.12, 0.35 + 0.04 * (i % 2), 0.13)),
        translation_matrix((-length / 2 + i * step, 0.25, 0))))


@register()
def picnic_garden() -> Shape:
    lawn = box((5, 0.1, 4), (0, -0.05, 0), (0.35, 0.58, 0.25))
    basket = box((0.3, 0.18, 0.2), (0.4, 0.88, 0.1), (0.6, 0.4, 0.2))
    return concat_shapes(
        lawn, library_call('picnic_table'), basket,
        transform_shape(library_call('hedge'), translation_matrix((0, 0, -1.7))),
        transform_shape(library_call('flower_bed'), translation_matrix((0, 0, 1.6))))

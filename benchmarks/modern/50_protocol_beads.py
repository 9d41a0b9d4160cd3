"""a pearl necklace with a pendant, lying on a velvet cushion"""
from helper import *
from typing import Protocol, runtime_checkable
import math


@runtime_checkable
class Bead(Protocol):
    def size(self) -> float: ...
    def shape(self) -> Shape: ...


class Pearl:
    def __init__(self, radius: float, warmth: float = 0.5):
        self._radius, self._warmth = radius, warmth

    def size(self) -> float:
        return 2 * self._radius

    def shape(self) -> Shape:
        return primitive_call('sphere', shape_kwargs={'radius': self._radius}, color=(0.97, 0.94 - 0.05 * self._warmth, 0.9 - 0.1 * self._warmth))


class GoldSpacer:
    def size(self) -> float:
        return 0.05

    def shape(self) -> Shape:
        return primitive_call('cylinder', shape_kwargs={'radius': 0.06, 'p0': (-0.02, 0, 0), 'p1': (0.02, 0, 0)}, color=(0.9, 0.72, 0.2))


def strand(n: int):
    for i in range(n):
        d = abs(i - (n - 1) / 2) / (n / 2)
        yield Pearl(0.14 - 0.06 * d, warmth=d)
        if i % 4 == 3 and i < n - 1:
            yield GoldSpacer()


def layout(beads: list[Bead], a: float = 1.5, b: float = 1.1, start: float = 0.35):
    """Walk along an ellipse by arc length."""
    theta = -math.pi / 2 + start
    for prev, bead in zip([None, *beads], beads):
        advance = ((prev.size() if prev else 0) + bead.size()) / 2
        moved = 0.0
        while moved < advance:
            dt = 0.002
            moved += math.hypot(a * math.sin(theta), b * math.cos(theta)) * dt
            theta += dt
        yield bead, (a * math.cos(theta), b * math.sin(theta)), math.atan2(b * math.cos(theta), -a * math.sin(theta))


@register()
def necklace(pearls: int = 35) -> Shape:
    beads = list(strand(pearls))
    assert all(isinstance(b, Bead) for b in beads)
    out = []
    for bead, (x, z), heading in layout(beads):
        s = transform_shape(bead.shape(), rotation_matrix(-heading, (0, 1, 0), (0, 0, 0)))
        out.append(transform_shape(s, translation_matrix((x, 0, z))))
    return concat_shapes(*out)


@register()
def pendant(color=(0.1, 0.3, 0.75)) -> Shape:
    gem = transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.25, 0.12, 0.25)}, color=color), rotation_matrix(math.pi / 4, (0, 1, 0), (0, 0, 0)))
    ring = loop(12, lambda i: transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.03}, color=(0.9, 0.72, 0.2)),
                                              translation_matrix((0.22 * math.cos(i * math.pi / 6), 0, 0.22 * math.sin(i * math.pi / 6)))))
    return concat_shapes(gem, ring)


@register()
def cushion(color=(0.45, 0.05, 0.15)) -> Shape:
    pad = primitive_call('cube', shape_kwargs={'scale': (4, 0.5, 3.4)}, color=color)
    edge = [primitive_call('cylinder', shape_kwargs={'radius': 0.25, 'p0': (-2, 0, z), 'p1': (2, 0, z)}, color=color) for z in (-1.7, 1.7)]
    tassels = [transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.15}, color=(0.9, 0.72, 0.2)), translation_matrix((sx * 2.1, 0, sz * 1.8))) for sx in (-1, 1) for sz in (-1, 1)]
    return concat_shapes(pad, *edge, *tassels)


@register()
def jewelry_display() -> Shape:
    neck = library_call('necklace')
    base = library_call('cushion')
    y = compute_shape_max(base)[1] + compute_shape_sizes(neck)[1] / 2
    gem = transform_shape(library_call('pendant'), translation_matrix((0, y, 1.35)))
    return concat_shapes(base, transform_shape(neck, translation_matrix((0, y, 0))), gem)

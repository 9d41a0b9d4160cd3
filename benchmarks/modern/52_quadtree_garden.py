"""a formal garden with flower beds laid out by a quadtree"""
from __future__ import annotations
from helper import *
import random
from dataclasses import dataclass, field


@dataclass
class Quad:
    cx: float
    cz: float
    half: float
    kids: list[Quad] | None = None
    rng: random.Random = field(default_factory=lambda: random.Random(17), repr=False)

    def grow(self, depth: int) -> Quad:
        if depth > 0 and self.rng.random() < 0.85:
            h = self.half / 2
            self.kids = [Quad(self.cx + sx * h, self.cz + sz * h, h, rng=self.rng).grow(depth - 1) for sx in (-1, 1) for sz in (-1, 1)]
        return self

    def leaves(self):
        if self.kids is None:
            yield self
            return
        for k in self.kids:
            yield from k.leaves()

    def __contains__(self, point) -> bool:
        x, z = point
        return abs(x - self.cx) <= self.half and abs(z - self.cz) <= self.half


FLOWERS = {'tulip': (0.9, 0.15, 0.2), 'lavender': (0.6, 0.45, 0.85), 'daisy': (0.98, 0.98, 0.95), 'marigold': (0.98, 0.6, 0.1)}


@register()
def flower(kind: str = 'tulip', height: float = 0.3) -> Shape:
    stem = primitive_call('cylinder', shape_kwargs={'radius': 0.015, 'p0': (0, 0, 0), 'p1': (0, height, 0)}, color=(0.2, 0.5, 0.2))
    bloom = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.07}, color=FLOWERS[kind]), translation_matrix((0, height, 0)))
    return stem + bloom


@register()
def bed(half: float, kind: str = 'tulip', seed: int = 0) -> Shape:
    rng = random.Random(seed)
    size = 2 * half - 0.25
    soil = primitive_call('cube', shape_kwargs={'scale': (size, 0.15, size)}, color=(0.35, 0.24, 0.15))
    trim = [primitive_call('cube', shape_kwargs={'scale': s}, color=(0.15, 0.4, 0.15)) for s in ((size + 0.1, 0.25, 0.08), (0.08, 0.25, size + 0.1))]
    hedges = [transform_shape(trim[0], translation_matrix((0, 0.05, s * size / 2))) for s in (-1, 1)]
    hedges += [transform_shape(trim[1], translation_matrix((s * size / 2, 0.05, 0))) for s in (-1, 1)]
    n = int(6 * size ** 2) or 1
    blooms = [transform_shape(library_call('flower', kind=kind, height=rng.uniform(0.2, 0.4)),
                              translation_matrix((rng.uniform(-1, 1) * size * 0.42, 0.07, rng.uniform(-1, 1) * size * 0.42))) for _ in range(n)]
    return concat_shapes(soil, *hedges, *blooms)


@register()
def fountain(tiers: int = 3) -> Shape:
    out, y = [], 0.0
    for k in range(tiers):
        r = 1.0 - 0.3 * k
        out.append(primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': (0, y, 0), 'p1': (0, y + 0.15, 0)}, color=(0.75, 0.74, 0.7)))
        out.append(primitive_call('cylinder', shape_kwargs={'radius': r * 0.9, 'p0': (0, y + 0.15, 0), 'p1': (0, y + 0.17, 0)}, color=(0.4, 0.7, 0.9)))
        out.append(primitive_call('cylinder', shape_kwargs={'radius': 0.12, 'p0': (0, y + 0.15, 0), 'p1': (0, y + 0.7, 0)}, color=(0.75, 0.74, 0.7)))
        y += 0.55
    return concat_shapes(*out)


@register()
def formal_garden() -> Shape:
    tree = Quad(0, 0, 5).grow(3)
    kinds = list(FLOWERS)
    beds = [transform_shape(library_call('bed', half=q.half, kind=kinds[i % len(kinds)], seed=i), translation_matrix((q.cx, 0.07, q.cz)))
            for i, q in enumerate(tree.leaves()) if (0, 0) not in q and q.half < 3]
    gravel = transform_shape(primitive_call('cube', shape_kwargs={'scale': (11, 0.1, 11)}, color=(0.8, 0.75, 0.65)), translation_matrix((0, -0.05, 0)))
    return concat_shapes(gravel, library_call('fountain'), *beds)

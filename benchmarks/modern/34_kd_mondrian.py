"""a 3D Mondrian relief painting by recursive subdivision"""
from __future__ import annotations
from helper import *
from dataclasses import dataclass
import random

PALETTE = {'white': (0.96, 0.96, 0.93), 'red': (0.85, 0.1, 0.1), 'blue': (0.1, 0.2, 0.65), 'yellow': (0.97, 0.83, 0.1), 'black': (0.08, 0.08, 0.08)}


@dataclass(frozen=True)
class Rect:
    x: float
    y: float
    w: float
    h: float

    @property
    def area(self) -> float:
        return self.w * self.h

    @property
    def center(self) -> tuple[float, float]:
        return self.x + self.w / 2, self.y + self.h / 2

    def split(self, t: float, vertical: bool) -> tuple[Rect, Rect]:
        if vertical:
            return Rect(self.x, self.y, self.w * t, self.h), Rect(self.x + self.w * t, self.y, self.w * (1 - t), self.h)
        return Rect(self.x, self.y, self.w, self.h * t), Rect(self.x, self.y + self.h * t, self.w, self.h * (1 - t))


def subdivide(rect: Rect, rng: random.Random, depth: int = 0):
    if depth >= 5 or rect.area < 0.6 or (depth > 2 and rng.random() < 0.2):
        yield rect
    else:
        a, b = rect.split(rng.uniform(0.3, 0.7), vertical=rect.w > rect.h)
        yield from subdivide(a, rng, depth + 1)
        yield from subdivide(b, rng, depth + 1)


@register()
def panel(rect: Rect, color_name: str = 'white', gap: float = 0.08) -> Shape:
    depth = 0.1 if color_name == 'white' else 0.25
    block = primitive_call('cube', shape_kwargs={'scale': (rect.w - gap, rect.h - gap, depth)}, color=PALETTE[color_name])
    cx, cy = rect.center
    return transform_shape(block, translation_matrix((cx, cy, depth / 2)))


@register()
def painting(width: float = 4.0, height: float = 4.0, seed: int = 1921) -> Shape:
    rng = random.Random(seed)
    rects = sorted(subdivide(Rect(0, 0, width, height), rng), key=lambda r: r.area, reverse=True)
    names = rng.choices(['white', 'red', 'blue', 'yellow'], weights=[6, 1, 1, 1], k=len(rects))
    names[:3] = ['red', 'white', 'blue']
    panels = [library_call('panel', rect=r, color_name=n) for r, n in zip(rects, names, strict=True)]
    back = transform_shape(primitive_call('cube', shape_kwargs={'scale': (width, height, 0.05)}, color=PALETTE['black']), translation_matrix((width / 2, height / 2, 0)))
    return concat_shapes(back, *panels)


@register()
def framed_painting() -> Shape:
    art = library_call('painting')
    c, (w, h, _) = compute_shape_center(art), compute_shape_sizes(art)
    t = 0.15
    bars = [((w + 2 * t, t, 0.35), (c[0], c[1] + s * (h + t) / 2, c[2])) for s in (-1, 1)]
    bars += [((t, h, 0.35), (c[0] + s * (w + t) / 2, c[1], c[2])) for s in (-1, 1)]
    frame = [transform_shape(primitive_call('cube', shape_kwargs={'scale': s}, color=(0.35, 0.22, 0.12)), translation_matrix(p)) for s, p in bars]
    return concat_shapes(art, *frame)

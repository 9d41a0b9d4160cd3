from __future__ import annotations
import math
from dataclasses import dataclass, field
from typing import Callable
from helper import *

"""
a table assembles itself: keyframes, easing functions and a timeline
"""

Easing = Callable[[float], float]

EASINGS: dict[str, Easing] = {
    "linear": lambda t: t,
    "smooth": lambda t: t * t * (3 - 2 * t),
    "bounce": lambda t: 1 - abs(math.cos(t * math.pi * 2.5)) * (1 - t),
    "elastic": lambda t: t if t in (0, 1) else 1 - math.exp(-5 * t) * math.cos(10 * t),
}


@dataclass
class Track:
    start: int
    end: int
    origin: tuple[float, float, float]
    target: tuple[float, float, float]
    easing: str = "smooth"

    def at(self, frame: int) -> tuple[float, ...] | None:
        if frame < self.start:
            return None
        t = min(1.0, (frame - self.start) / (self.end - self.start))
        e = EASINGS[self.easing](t)
        return tuple(a + (b - a) * e for a, b in zip(self.origin, self.target))


@dataclass
class Timeline:
    tracks: dict[str, Track] = field(default_factory=dict)
    cursor: int = 0

    def then(self, name: str, duration: int, origin, target, easing="smooth", *, overlap: int = 0) -> Timeline:
        start = max(0, self.cursor - overlap)
        self.tracks[name] = Track(start, start + duration, origin, target, easing)
        self.cursor = start + duration
        return self

    def __len__(self) -> int:
        return max(t.end for t in self.tracks.values()) + 1

    def __getitem__(self, frame: int) -> dict[str, tuple]:
        return {name: place for name, t in self.tracks.items() if (place := t.at(frame)) is not None}


@register()
def piece(name: str) -> Shape:
    match name.split("_"):
        case ["leg", n]:
            return primitive_call('cylinder', color=(0.5, 0.35, 0.2 + 0.02 * int(n)), shape_kwargs={'radius': 0.07, 'p0': (0, 0, 0), 'p1': (0, 1, 0)})
        case ["top"]:
            return primitive_call('cube', color=(0.6, 0.42, 0.25), shape_kwargs={'scale': (2.2, 0.1, 1.4)})
        case ["vase"]:
            return concat_shapes(primitive_call('sphere', color=(0.3, 0.5, 0.8), shape_kwargs={'radius': 0.2}), primitive_call('cylinder', color=(0.3, 0.5, 0.8), shape_kwargs={'radius': 0.1, 'p0': (0, 0, 0), 'p1': (0, 0.4, 0)}))
    return primitive_call('sphere', color=(1, 0, 1), shape_kwargs={'radius': 0.1})


@register_animation()
def assembly() -> Generator[Shape, None, None]:
    line = Timeline()
    for n, (x, z) in enumerate([(-1, -0.6), (1, -0.6), (-1, 0.6), (1, 0.6)]):
        line.then(f"leg_{n}", 5, (x * 3, 2, z * 3), (x, 0, z), "bounce" if n % 2 else "smooth", overlap=2)
    line.then("top", 6, (0, 4, 0), (0, 1.05, 0), "elastic").then("vase", 4, (0, 5, 0), (0.4, 1.3, 0)).then("dot", 1, (0, 2, 0), (0, 2.5, 0), "linear")
    floor = loop(3, lambda i: transform_shape(primitive_call('cube', color=(0.4 + 0.1 * i, 0.4, 0.4), shape_kwargs={'scale': (2, 0.1, 4)}), translation_matrix((2 * (i - 1), -0.05, 0))))
    for frame in range(len(line)):
        yield concat_shapes(floor, *[transform_shape(library_call('piece', name=name), translation_matrix(place)) for name, place in line[frame].items()])

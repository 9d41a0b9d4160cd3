from __future__ import annotations
import numpy as np
from typing import Iterable
from helper import *

"""
a city that grows frame by frame with a crane on its tallest building
"""


class City:
    def __init__(self, size: int = 5) -> None:
        self.heights = np.zeros((size, size))
        self.targets = np.random.randint(1, 6, size=(size, size)).astype(float)
        self.order = list(np.ndindex(size, size))
        np.random.shuffle(self.order)

    def __iter__(self) -> Iterable[City]:
        while (self.heights < self.targets).any():
            missing = self.targets - self.heights
            weights = missing.ravel() / missing.sum()
            picks = np.random.choice(missing.size, size=min(4, np.count_nonzero(missing)), replace=False, p=weights)
            self.heights.flat[picks] = np.minimum(self.heights.flat[picks] + 1, self.targets.flat[picks])
            yield self

    @property
    def tallest(self) -> tuple[int, int]:
        i, j = divmod(int(self.heights.argmax()), self.heights.shape[1])
        return i, j


@register()
def tower(height: float, finished: bool) -> Shape:
    if height == 0:
        return primitive_call('cube', color=(0.4, 0.5, 0.3), shape_kwargs={'scale': (0.9, 0.05, 0.9)})
    body = primitive_call('cube', color=(0.6, 0.65, 0.75) if finished else (0.7, 0.6, 0.5), shape_kwargs={'scale': (0.8, height, 0.8)})
    roof = primitive_call('cube', color=(0.3, 0.3, 0.35), shape_kwargs={'scale': (0.4, 0.1, 0.4)})
    return concat_shapes(transform_shape(body, translation_matrix((0, height / 2, 0))), transform_shape(roof, translation_matrix((0, height, 0))))


@register()
def crane(angle: float) -> Shape:
    mast = primitive_call('cylinder', color=(0.95, 0.7, 0.1), shape_kwargs={'radius': 0.06, 'p0': (0, 0, 0), 'p1': (0, 1.5, 0)})
    jib = primitive_call('cylinder', color=(0.95, 0.7, 0.1), shape_kwargs={'radius': 0.05, 'p0': (-0.5, 1.4, 0), 'p1': (1.5, 1.4, 0)})
    return concat_shapes(mast, transform_shape(jib, rotation_matrix(angle, (0, 1, 0), (0, 0, 0))))


@register_animation()
def growing_city() -> Generator[Shape, None, None]:
    city = City()
    for frame, state in enumerate(city):
        if frame >= 24:
            break
        shapes = [transform_shape(library_call('tower', height=float(state.heights[i, j]), finished=bool(state.heights[i, j] == state.targets[i, j])), translation_matrix((i, 0, j))) for i, j in state.order]
        i, j = state.tallest
        shapes.append(transform_shape(library_call('crane', angle=0.3 * frame), translation_matrix((i, state.heights[i, j], j))))
        yield concat_shapes(*shapes)

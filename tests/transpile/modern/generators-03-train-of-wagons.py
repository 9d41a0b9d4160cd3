from __future__ import annotations
from collections.abc import Generator, Iterable, Iterator
from helper import *

"""
a freight train: a pipeline of generators loads the wagons
"""

CARGO = "coal coal grain sand grain coal steel steel grain sand sand coal".split()
COLORS = {"coal": (0.1, 0.1, 0.1), "grain": (0.9, 0.8, 0.4), "sand": (0.85, 0.7, 0.5), "steel": (0.5, 0.55, 0.6)}


def batched(items: Iterable[str], size: int) -> Iterator[tuple[str, ...]]:
    batch: list[str] = []
    for item in items:
        batch.append(item)
        if len(batch) == size:
            yield tuple(batch)
            batch = []
    if batch:
        yield tuple(batch)


def without(items: Iterable[str], banned: set[str]) -> Generator[str, None, None]:
    yield from (item for item in items if item not in banned)


def numbered(items, *, start=1):
    n = start
    for item in items:
        yield n, item
        n += 1


def spaced(wagons: Iterable[tuple[int, tuple]], gap: float):
    x = 0.0
    for number, load in wagons:
        length = 0.6 * len(load) + 0.2
        yield x + length / 2, length, number, load
        x += length + gap


@register()
def wagon(length: float, load: tuple) -> Shape:
    bed = transform_shape(primitive_call('cube', color=(0.45, 0.15, 0.1), shape_kwargs={'scale': (length, 0.2, 0.9)}), translation_matrix((0, 0.4, 0)))
    wheels = [primitive_call('cylinder', color=(0.2, 0.2, 0.2), shape_kwargs={'radius': 0.2, 'p0': (sx * length * 0.35, 0.2, -0.5), 'p1': (sx * length * 0.35, 0.2, 0.5)}) for sx in (-1, 1)]
    cargo = (transform_shape(primitive_call('cube', color=COLORS[kind], shape_kwargs={'scale': (0.5, 0.5, 0.7)}), translation_matrix((0.6 * (i - (len(load) - 1) / 2), 0.75, 0))) for i, kind in enumerate(load))
    return concat_shapes(bed, *wheels, *cargo)


@register()
def freight_train() -> Shape:
    pipeline = spaced(numbered(batched(without(CARGO, {"sand"}), 4), start=10), gap=0.3)
    first = next(pipeline)
    shapes = []
    end = 0.0
    for x, length, number, load in (first, *pipeline):
        shapes.append(transform_shape(library_call('wagon', length=length, load=load), translation_matrix((x, 0, 0))))
        plate = primitive_call('cube', color=(1, 1, 1), shape_kwargs={'scale': (0.1 * len(str(number)), 0.05 * (number - 9), 0.02)})
        shapes.append(transform_shape(plate, translation_matrix((x, 0.4, 0.47))))
        end = x + length / 2
    exhausted = next(pipeline, None) is None
    rails = [transform_shape(primitive_call('cube', color=(0.5, 0.5, 0.5), shape_kwargs={'scale': (end + exhausted, 0.08, 0.08)}), translation_matrix((end / 2, 0, z))) for z in (-0.4, 0.4)]
    return concat_shapes(*rails, *shapes)

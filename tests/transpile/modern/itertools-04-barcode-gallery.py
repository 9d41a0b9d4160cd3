from itertools import compress, dropwhile, takewhile, tee, filterfalse, chain, islice, count
from helper import *

"""
a gallery of barcodes
"""


def digits(number: int) -> list[int]:
    return [int(d) for d in str(number)]


def window(items, n: int = 2):
    """Sliding window from n tees."""
    streams = tee(items, n)
    for lag, stream in enumerate(streams):
        for _ in range(lag):
            next(stream, None)
    return zip(*streams)


def chunked(iterable, n):
    it = iter(iterable)
    while chunk := list(islice(it, n)):
        yield chunk


def checksum(values) -> int:
    return (10 - sum(v * w for v, w in zip(values, chain.from_iterable([1, 3] for _ in count())))) % 10


@register()
def bar(width: float, height: float) -> Shape:
    return transform_shape(primitive_call('cube', color=(0.05, 0.05, 0.05), shape_kwargs={'scale': (width, height, 0.05)}), translation_matrix((width / 2, 0, 0)))


@register()
def barcode(number: int) -> Shape:
    values = digits(number)
    values.append(checksum(values))
    bits = [1, 0, 1] + [int(b) for v in values for b in format(v, "04b")] + [1, 0, 1]
    bars, x = [], 0.0
    unit = 0.05
    for _ in range(1):
        position = 0
        for chunk in chunked(bits, 4):
            for k in compress(range(4), chunk):
                height = 1.2 if position + k < 3 or position + k >= len(bits) - 3 else 1.0
                bars.append(transform_shape(library_call('bar', width=unit * 0.9, height=height), translation_matrix((unit * (position + k), 0, 0.05))))
            position += len(chunk)
        x = unit * position
    card = transform_shape(primitive_call('cube', color=(1, 1, 1), shape_kwargs={'scale': (x + 0.3, 1.6, 0.04)}), translation_matrix((x / 2, 0, 0)))
    rising = sum(1 for a, b in window(values) if b > a)
    dot = transform_shape(primitive_call('sphere', color=(0.8, 0.1, 0.1), shape_kwargs={'radius': 0.05 * (1 + rising)}), translation_matrix((x / 2, -1, 0)))
    return concat_shapes(card, *bars, dot)


@register()
def gallery() -> Shape:
    numbers = [7, 12, 400638, 133393, 5, 871125, 90210, 3]
    small = list(takewhile(lambda n: n < 100, numbers))
    rest = list(dropwhile(lambda n: n < 100, numbers))
    large = list(filterfalse(lambda n: n < 100, rest))
    shapes = [transform_shape(library_call('barcode', number=n), translation_matrix((2.2 * (k % 3), -2.5 * (k // 3), 0))) for k, n in enumerate(large + small)]
    return concat_shapes(*shapes)

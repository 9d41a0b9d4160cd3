"""
a banner that counts words, with formatted figures made of dots
"""
from helper import *
from collections import Counter
from itertools import zip_longest, groupby
from string import ascii_lowercase
import textwrap

TEXT = """It was the best of times, it was the worst of times, it was the age of wisdom,
it was the age of foolishness, it was the epoch of belief"""

FONT = {
    '0': '757', '1': '262', '2': '717', '3': '737', '4': '571', '5': '747', '6': '477', '7': '711', '8': '777', '9': '771', '%': '525', '.': '002', ' ': '000',
}


def words(text: str) -> list[str]:
    clean = ''.join(ch if ch in ascii_lowercase else ' ' for ch in text.lower())
    return clean.split()


COUNTS = Counter(words(TEXT))
TOP = COUNTS.most_common(5)
TOTAL = sum(COUNTS.values())
LABELS = [f'{n / TOTAL:>6.1%}' for _, n in TOP]
LENGTHS = {k: len(list(g)) for k, g in groupby(sorted(map(len, COUNTS)))}
COLUMNS = list(zip_longest(*textwrap.wrap(' '.join(COUNTS), width=16), fillvalue=' '))


@register()
def glyph(rows: str = '757', dot: float = 0.1) -> Shape:
    dots = []
    for r, ch in enumerate(rows):
        for bit in range(3):
            if int(ch) >> (2 - bit) & 1:
                dots.append(transform_shape(primitive_call('sphere', color=(1.0, 0.8, 0.2), shape_kwargs={'radius': dot}), translation_matrix((bit * dot * 2.2, -r * dot * 2.2, 0))))
    return concat_shapes(*dots) if dots else primitive_call('sphere', color=(0.2, 0.2, 0.2), shape_kwargs={'radius': dot / 4})


@register()
def bar(count: int = 4, label: str = '  10.0%', unit: float = 0.5) -> Shape:
    body = transform_shape(primitive_call('cube', color=(0.3, 0.5, 0.8), shape_kwargs={'scale': (count * unit, 0.5, 0.3)}), translation_matrix((count * unit / 2, 0, 0)))
    glyphs = [transform_shape(library_call('glyph', rows=FONT[ch]), translation_matrix((count * unit + 0.3 + 0.8 * i, 0.2, 0))) for i, ch in enumerate(label.strip())]
    return concat_shapes(body, *glyphs)


@register()
def chart(pitch: float = 1.0) -> Shape:
    return concat_shapes(*[transform_shape(library_call('bar', count=n, label=text), translation_matrix((0, -i * pitch, 0))) for i, ((_, n), text) in enumerate(zip(TOP, LABELS))])


@register()
def lengths() -> Shape:
    posts = [primitive_call('cylinder', color=(0.7, 0.3, 0.3), shape_kwargs={'radius': 0.15, 'p0': (size * 0.6, -7, 0), 'p1': (size * 0.6, -7 + n * 0.4, 0)}) for size, n in LENGTHS.items()]
    return concat_shapes(*posts)


@register()
def beads() -> Shape:
    balls = []
    for x, column in enumerate(COLUMNS):
        for y, ch in enumerate(column):
            if ch != ' ':
                hue = (ord(ch) - ord('a')) / 25
                balls.append(transform_shape(primitive_call('sphere', color=(hue, 0.5, 1 - hue), shape_kwargs={'radius': 0.12}), translation_matrix((x * 0.3 + 8, -y * 0.5, 0))))
    return concat_shapes(*balls)


@register()
def word_count() -> Shape:
    panel = transform_shape(primitive_call('cube', color=(0.95, 0.95, 0.95), shape_kwargs={'scale': (16, 10, 0.1)}), translation_matrix((6, -3, -0.4)))
    return concat_shapes(panel, library_call('chart'), library_call('lengths'), library_call('beads'))

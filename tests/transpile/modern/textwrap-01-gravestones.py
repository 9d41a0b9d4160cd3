import textwrap
import string
from helper import *

"""
an old churchyard: inscriptions are wrapped to the width of the stone
"""

EPITAPHS = {
    "Ada": "Here rests a mind that wove numbers into patterns of light.",
    "Bo": "Sailor.",
    "Cyrus the Old": "He planted a thousand trees and sat in the shade of none of them, but his children do.",
    "Dee": textwrap.dedent("""\
        Gardener
        and friend
        """),
}

@register()
def text_line(text: str, width: int) -> Shape:
    pieces = []
    column = 0
    for word in text.split():
        n = len(word)
        word_shape = primitive_call('cube', color=(0.2, 0.2, 0.2), shape_kwargs={'scale': (0.05 * n - 0.02, 0.05, 0.03)})
        pieces.append(transform_shape(word_shape, translation_matrix((0.05 * (column + n / 2 - width / 2), 0, 0))))
        column += n + 1
    return concat_shapes(*pieces)

@register()
def gravestone(name: str, epitaph: str, width: int = 24) -> Shape:
    lines = textwrap.wrap(epitaph, width=width)
    title = name.center(width, ".").strip(".").upper()
    h = 0.12 * (len(lines) + 4)
    w = 0.05 * width + 0.2
    stone = transform_shape(primitive_call('cube', color=(0.6, 0.6, 0.58), shape_kwargs={'scale': (w, h, 0.15)}), translation_matrix((0, h / 2, 0)))
    arch = primitive_call('cylinder', color=(0.6, 0.6, 0.58), shape_kwargs={'radius': w / 2, 'p0': (0, h, -0.07), 'p1': (0, h, 0.07)})
    rows = [transform_shape(library_call('text_line', text=title, width=len(title)), translation_matrix((0, h, 0.09)))]
    for k, line in enumerate(lines):
        rows.append(transform_shape(library_call('text_line', text=line, width=width), translation_matrix((0, h - 0.25 - 0.12 * k, 0.09))))
    vowels = sum(name.lower().count(v) for v in "aeiou")
    flowers = loop(vowels, lambda i: transform_shape(primitive_call('sphere', color=(0.9, 0.4, 0.6), shape_kwargs={'radius': 0.07}), translation_matrix((0.2 * i - 0.2, 0.05, 0.3))))
    return concat_shapes(stone, arch, *rows, flowers)

@register()
def churchyard() -> Shape:
    shapes = []
    for k, (name, epitaph) in enumerate(EPITAPHS.items()):
        stone = library_call('gravestone', name=string.capwords(name), epitaph=epitaph, width=16 + 4 * (k % 3))
        shapes.append(transform_shape(stone, translation_matrix((2 * k, 0, 0.4 * (k % 2)))))
    template = string.Template("$who rests since $year").substitute(who="everyone", year=1850 + len(EPITAPHS))
    short = textwrap.shorten("The quick brown fox jumps over the lazy dog", width=20, placeholder="...")
    gate = transform_shape(primitive_call('cube', color=(0.1, 0.1, 0.1), shape_kwargs={'scale': (0.1 * len(template), 0.1, 0.1)}), translation_matrix((3, 0.1 * len(short), -1)))
    grass = transform_shape(primitive_call('cube', color=(0.3, 0.45, 0.25), shape_kwargs={'scale': (9, 0.1, 3)}), translation_matrix((3, -0.05, 0)))
    return concat_shapes(grass, gate, *shapes)

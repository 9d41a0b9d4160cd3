from collections import Counter, OrderedDict
from helper import *

"""
letter frequencies as a histogram garden
"""

TEXT = """
The quick brown fox jumps over the lazy dog,
then naps under the old oak tree until dusk.
"""


def letters(text: str) -> Counter:
    return Counter(ch for ch in text.lower() if ch.isalpha())


@register()
def flower_bar(letter: str, n: int) -> Shape:
    hue = (ord(letter) - ord("a")) / 25
    stem = primitive_call('cylinder', color=(0.2, 0.5, 0.2), shape_kwargs={'radius': 0.05, 'p0': (0, 0, 0), 'p1': (0, 0.25 * n, 0)})
    petals = loop(min(n, 6), lambda i: transform_shape(
        primitive_call('sphere', color=(0.9, hue, 1 - hue), shape_kwargs={'radius': 0.08}),
        translation_matrix((0.1 * math.cos(i), 0.25 * n, 0.1 * math.sin(i)))))
    return concat_shapes(stem, petals)


@register()
def histogram() -> Shape:
    counts = letters(TEXT)
    vowels = Counter({v: counts[v] for v in "aeiou"})
    consonants = counts - vowels
    both = counts & Counter(e=3, t=99, o=2)
    more = counts + Counter("zzzzz")
    more.subtract({"z": 4, "q": 1})
    shapes = []
    for i, (letter, n) in enumerate(counts.most_common(10)):
        shapes.append(transform_shape(library_call('flower_bar', letter=letter, n=n), translation_matrix((0.6 * i, 0, 0))))
    for i, (letter, n) in enumerate(consonants.most_common()[:-6:-1]):
        shapes.append(transform_shape(library_call('flower_bar', letter=letter, n=n), translation_matrix((0.6 * i, 0, 1.2))))
    for i, letter in enumerate(sorted(both.elements())):
        shapes.append(transform_shape(primitive_call('cube', color=(0.5, 0.4, 0.3), shape_kwargs={'scale': (0.3, 0.1 * (ord(letter) - 96), 0.3)}), translation_matrix((0.4 * i, 0, 2.4))))
    order = OrderedDict(sorted(vowels.items()))
    order.move_to_end("a")
    order.popitem(last=False)
    for i, (letter, n) in enumerate(order.items()):
        shapes.append(transform_shape(library_call('flower_bar', letter=letter, n=n), translation_matrix((1.0 * i, 0, 3.4))))
    print(more["z"], more["q"], more.get("Z"), sum(counts.values()), counts["#"])
    size = 0.1 * more["z"] + 0.02 * sum(counts.values())
    soil = primitive_call('cube', color=(0.35, 0.25, 0.15), shape_kwargs={'scale': (7, 0.1, 3 + size)})
    return concat_shapes(transform_shape(soil, translation_matrix((2.7, -0.05, 1.7))), *shapes)

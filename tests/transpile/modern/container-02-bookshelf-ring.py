from collections.abc import MutableMapping, Sequence
from helper import *

"""
a library: shelves as sequence objects, a catalogue as a mapping
"""

class Shelf(Sequence):
    """Books by thickness; negative indexes and slices work as in a list."""

    def __init__(self, books):
        self._books = list(books)

    def __len__(self):
        return len(self._books)

    def __getitem__(self, i):
        if isinstance(i, slice):
            return Shelf(self._books[i])
        return self._books[i]

    def __add__(self, other):
        return Shelf([*self, *other])

    @property
    def width(self):
        return sum(self)

class Catalogue(MutableMapping):
    def __init__(self, **shelves):
        self._data = dict(shelves)

    def __getitem__(self, key):
        return self._data[key.lower()]

    def __setitem__(self, key, value):
        self._data[key.lower()] = value

    def __delitem__(self, key):
        del self._data[key.lower()]

    def __iter__(self):
        return iter(self._data)

    def __len__(self):
        return len(self._data)

@register()
def book_row(thicknesses: list) -> Shape:
    x, books = 0.0, []
    for i, t in enumerate(thicknesses):
        h = 0.8 + 0.1 * ((i * 7) % 4)
        shade = (i * 0.37) % 1
        book = primitive_call('cube', color=(shade, 0.3 + 0.4 * (1 - shade), 0.5), shape_kwargs={'scale': (t * 0.9, h, 0.6)})
        books.append(transform_shape(book, translation_matrix((x + t / 2, h / 2, 0))))
        x += t
    return concat_shapes(*books)

@register()
def library() -> Shape:
    cat = Catalogue(History=Shelf([0.2, 0.3, 0.15, 0.25]), art=Shelf([0.4] * 5))
    cat._data = {k.lower(): v for k, v in cat._data.items()}
    cat["Poetry"] = Shelf(0.1 + 0.02 * k for k in range(8))
    cat["SCIENCE"] = cat["history"][::-1] + cat["art"][1:3]
    cat.setdefault("comics", cat["poetry"][-3:])
    cat.update(maps=Shelf([0.6, 0.5]))
    removed = cat.pop("maps")
    shapes = []
    widest = max(s.width for s in cat.values())
    for level, (name, shelf) in enumerate(cat.items()):
        board = primitive_call('cube', color=(0.5, 0.35, 0.2), shape_kwargs={'scale': (widest, 0.06, 0.7)})
        shapes.append(transform_shape(board, translation_matrix((widest / 2, 1.3 * level - 0.03, 0))))
        row = library_call('book_row', thicknesses=list(shelf))
        shapes.append(transform_shape(row, translation_matrix((0, 1.3 * level, 0))))
    if removed not in cat.values() and 0.5 in removed and removed.index(0.5) == 1:
        pile = [transform_shape(primitive_call('cube', color=(0.8, 0.7, 0.5), shape_kwargs={'scale': (0.8, t, 0.6)}), translation_matrix((-0.8, 0.7 * k + t / 2, 0))) for k, t in enumerate(reversed(removed))]
        shapes += pile
    return concat_shapes(*shapes)

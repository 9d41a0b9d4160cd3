"""
a soroban abacus showing the number 1729, beside the word for it
"""
from helper import *
from functools import partial, reduce, wraps
from operator import add
import inspect

WOOD = (0.45, 0.28, 0.15)
BEAD = (0.75, 0.3, 0.15)

FONT = {
    '1': ['.#.', '##.', '.#.', '.#.', '###'],
    '2': ['##.', '..#', '.#.', '#..', '###'],
    '7': ['###', '..#', '.#.', '.#.', '.#.'],
    '9': ['###', '#.#', '###', '..#', '##.'],
    '0': ['###', '#.#', '#.#', '#.#', '###'],
}


def at(x: float = 0, y: float = 0, z: float = 0):
    """Moves what the decorated function returns."""
    def deco(fn):
        @wraps(fn)
        def inner(*args, **kwargs):
            return transform_shape(fn(*args, **kwargs), translation_matrix((x, y, z)))
        return inner
    return deco


def checked(fn):
    sig = inspect.signature(fn)

    @wraps(fn)
    def inner(*args, **kwargs):
        bound = sig.bind(*args, **kwargs)
        bound.apply_defaults()
        for k, v in bound.arguments.items():
            if isinstance(v, (int, float)) and v < 0:
                raise ValueError(f'{fn.__name__}: {k} must not be negative')
        return fn(*bound.args, **bound.kwargs)
    return inner


box = lambda dims, color: primitive_call('cube', {'scale': dims}, color=color)
rod = partial(primitive_call, 'cylinder', color=(0.8, 0.75, 0.6))


@register()
def bead(radius: float = 0.2, height: float = 0.2) -> Shape:
    discs = ((radius, 1.0, BEAD), (radius * 0.75, 1.7, (0.65, 0.25, 0.12)))
    return concat_shapes(*(primitive_call('cylinder', {'radius': r, 'p0': (0, -height * f / 4, 0), 'p1': (0, height * f / 4, 0)}, color=c)
                           for r, f, c in discs))


@register()
@checked
def abacus_column(digit: int = 0, height: float = 2.4, bar: float = 1.6) -> Shape:
    five, ones = divmod(digit, 5)
    pitch = 0.22
    beads = [bar + 0.2 if five else height - 0.2]
    beads += [bar - 0.2 - pitch * k for k in range(ones)]
    beads += [0.2 + pitch * k for k in range(4 - ones)]
    strung = [transform_shape(library_call('bead'), translation_matrix((0, y, 0))) for y in beads]
    return concat_shapes(rod({'radius': 0.03, 'p0': (0, 0, 0), 'p1': (0, height, 0)}), *strung)


@register()
def frame(width: float = 4.0, height: float = 2.4, bar: float = 1.6) -> Shape:
    pieces = {
        'bottom': ((width, 0.15, 0.4), (0, 0)),
        'top': ((width, 0.15, 0.4), (0, height)),
        'bar': ((width, 0.1, 0.25), (0, bar)),
        **{f'side{s:+d}': ((0.15, height + 0.15, 0.4), (s * width / 2, height / 2)) for s in (-1, 1)},
    }
    return reduce(add, (transform_shape(box(d, WOOD), translation_matrix((x, y, 0))) for d, (x, y) in pieces.values()))


@register()
def soroban(number: int = 1729, columns: int = 7) -> Shape:
    text = f'{number:0{columns}d}'
    if len(text) > columns:
        raise OverflowError(text)
    width = columns * 0.5 + 0.3
    cols = [transform_shape(library_call('abacus_column', digit=int(ch)), translation_matrix(((i - (columns - 1) / 2) * 0.5, 0, 0)))
            for i, ch in enumerate(text)]
    return concat_shapes(library_call('frame', width=width), *cols)


@register()
@at(y=-1.6, z=0.6)
def number_tiles(text: str = '1729', pixel: float = 0.14) -> Shape:
    shapes: Shape = []
    x0 = -len(text) * 4 * pixel / 2
    for n, ch in enumerate(text):
        try:
            glyph = FONT[ch]
        except KeyError as err:
            raise ValueError(f'no glyph for {ch!r}') from err
        for r, line in enumerate(glyph):
            for c, mark in enumerate(line):
                if mark == '#':
                    shapes += transform_shape(box((pixel * 0.95,) * 3, (0.2, 0.35, 0.6)), translation_matrix((x0 + (n * 4 + c) * pixel, (4 - r) * pixel, 0)))
    return shapes


@register()
def abacus_scene(number: int = 1729) -> Shape:
    desk = transform_shape(box((6, 0.2, 3), (0.6, 0.5, 0.4)), translation_matrix((0, -1.8, 0)))
    tool = transform_shape(library_call('soroban', number=number), rotation_matrix(-0.35, (1, 0, 0), (0, 0, 0)))
    return concat_shapes(desk, tool, library_call('number_tiles', text=str(number)))

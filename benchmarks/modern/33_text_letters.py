"""the word HELLO as a neon sign on a brick wall"""
from helper import *
from functools import partial

FONT = {
    'H': "#.#|#.#|###|#.#|#.#",
    'E': "###|#..|##.|#..|###",
    'L': "#..|#..|#..|#..|###",
    'O': "###|#.#|#.#|#.#|###",
    '!': ".#.|.#.|.#.|...|.#.",
}


class MissingGlyph(KeyError):
    pass


def glyph(ch: str) -> list[str]:
    try:
        return FONT[ch.upper()].split('|')
    except KeyError as err:
        raise MissingGlyph(f"no glyph for {ch!r}") from err


def safe_glyphs(text: str):
    for ch in text:
        try:
            yield ch, glyph(ch)
        except MissingGlyph:
            yield ch, None


@register()
def letter(ch: str = 'H', unit: float = 0.3, color=(1.0, 0.3, 0.8)) -> Shape:
    rows = glyph(ch)
    height = len(rows)
    on = {(c, height - 1 - r) for r, row in enumerate(rows) for c, v in enumerate(row) if v == '#'}
    tube = partial(primitive_call, 'cylinder', color=color)
    shapes = []
    for c, r in sorted(on):
        shapes.append(transform_shape(primitive_call('sphere', shape_kwargs={'radius': unit * 0.25}, color=color), translation_matrix((c * unit, r * unit, 0))))
        for dc, dr in ((1, 0), (0, 1)):
            if (c + dc, r + dr) in on:
                shapes.append(tube(shape_kwargs={'radius': unit * 0.22, 'p0': (c * unit, r * unit, 0), 'p1': ((c + dc) * unit, (r + dr) * unit, 0)}))
    return concat_shapes(*shapes)


@register()
def word(text: str = "HELLO", unit: float = 0.3) -> Shape:
    palette = [(1.0, 0.3, 0.8), (0.3, 0.9, 1.0), (1.0, 0.9, 0.3)]
    shapes = []
    for i, (ch, rows) in enumerate(safe_glyphs(text)):
        if rows is None:
            continue
        g = library_call('letter', ch=ch, unit=unit, color=palette[i % len(palette)])
        shapes.append(transform_shape(g, translation_matrix((i * unit * 4, 0, 0))))
    joined = concat_shapes(*shapes)
    return transform_shape(joined, translation_matrix(-compute_shape_center(joined)))


@register()
def brick_wall(rows: int = 10, cols: int = 9, brick=(0.9, 0.35, 0.2)) -> Shape:
    w, h, d = brick
    out = []
    for r in range(rows):
        shift = 0.5 * w if r % 2 else 0.0
        for c in range(cols):
            tone = 0.9 + 0.1 * ((r * 7 + c * 3) % 5) / 4
            b = primitive_call('cube', shape_kwargs={'scale': (w * 0.95, h * 0.92, d)}, color=(0.5 * tone, 0.22 * tone, 0.17 * tone))
            out.append(transform_shape(b, translation_matrix(((c - cols / 2) * w + shift, (r - rows / 2 + 0.5) * h, 0))))
    return concat_shapes(*out)


@register()
def neon_sign(text: str = "Hello?!") -> Shape:
    return concat_shapes(transform_shape(library_call('brick_wall'), translation_matrix((0, 0, -0.3))), library_call('word', text=text))

from dataclasses import dataclass
from helper import *

"""
a station clock and departure board in a pixel font
"""

GLYPHS = {
    "0": ("111", "101", "101", "101", "111"),
    "1": ("010", "110", "010", "010", "111"),
    "2": ("111", "001", "111", "100", "111"),
    "3": ("111", "001", "111", "001", "111"),
    "4": ("101", "101", "111", "001", "001"),
    "5": ("111", "100", "111", "001", "111"),
    "7": ("111", "001", "010", "010", "010"),
    "9": ("111", "101", "111", "001", "111"),
    ":": ("0", "1", "0", "1", "0"),
    " ": ("0",) * 5,
}


@dataclass(frozen=True)
class Time:
    minutes: int

    def __format__(self, spec: str) -> str:
        h, m = divmod(self.minutes, 60)
        if spec == "short":
            return f"{h}:{m:02}"
        return f"{h:02d}:{m:02d}"

    def __add__(self, minutes: int) -> "Time":
        return Time((self.minutes + minutes) % 1440)


@register()
def pixel_text(text: str, color: tuple, size: float = 0.1) -> Shape:
    shapes, column = [], 0
    for ch in text:
        glyph = GLYPHS.get(ch, GLYPHS[" "])
        for row, bits in enumerate(glyph):
            for c, bit in enumerate(bits):
                if bit == "1":
                    dot = primitive_call('cube', color=color, shape_kwargs={'scale': (size * 0.9, size * 0.9, 0.03)})
                    shapes.append(transform_shape(dot, translation_matrix((size * (column + c), -size * row, 0))))
        column += len(glyph[0]) + 1
    return concat_shapes(*shapes)


@register()
def departure_board() -> Shape:
    start = Time(13 * 60 + 5)
    shapes = []
    for k, (late, text) in enumerate([(0, f"{start}"), (14, f"{start + 14:short}"), (415, f"{start + 415}"), (900, "{:short}".format(start + 900))]):
        color = (1.0, 0.7, 0.1) if late < 400 else (0.9, 0.2, 0.2)
        shapes.append(transform_shape(library_call('pixel_text', text=text, color=color), translation_matrix((0, -0.8 * k, 0.05))))
        remaining = f"{late:>4}".replace(" ", "")
        shapes.append(transform_shape(library_call('pixel_text', text=remaining.zfill(3), color=(0.4, 0.8, 1.0), size=0.07), translation_matrix((2.3, -0.8 * k, 0.05))))
    board = primitive_call('cube', color=(0.05, 0.05, 0.08), shape_kwargs={'scale': (4.4, 3.6, 0.05)})
    poles = [primitive_call('cylinder', color=(0.5, 0.5, 0.5), shape_kwargs={'radius': 0.06, 'p0': (x, -4.5, 0), 'p1': (x, -2.8, 0)}) for x in (0.0, 0.5 * len(f"{start:long}") + 0.5)]
    return concat_shapes(transform_shape(board, translation_matrix((1.6, -1.3, 0))), *poles, *shapes)

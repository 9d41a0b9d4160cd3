from __future__ import annotations
from helper import *

"""
a parade of flags made by alternative constructors
"""


class Color:
    def __init__(self, r: float, g: float, b: float):
        self.rgb = (r, g, b)

    @classmethod
    def from_hex(cls, text: str) -> Color:
        text = text.lstrip("#")
        if len(text) == 3:
            text = "".join(2 * ch for ch in text)
        return cls(*(int(text[i:i + 2], 16) / 255 for i in range(0, 6, 2)))

    @classmethod
    def gray(cls, level: float) -> Color:
        return cls(level, level, level)

    @staticmethod
    def mix(a: Color, b: Color, t: float = 0.5) -> Color:
        return Color(*((1 - t) * x + t * y for x, y in zip(a.rgb, b.rgb)))


class Flag:
    registry: list[Flag] = []

    def __init__(self, stripes: list[Color], vertical: bool):
        self.stripes, self.vertical = stripes, vertical
        type(self).registry.append(self)

    @classmethod
    def tricolor(cls, *codes: str, vertical: bool = False) -> Flag:
        return cls([Color.from_hex(c) for c in codes], vertical)

    @classmethod
    def gradient(cls, start: str, stop: str, n: int) -> Flag:
        a, b = Color.from_hex(start), Color.from_hex(stop)
        return cls([Color.mix(a, b, i / (n - 1)) for i in range(n)], False)

    @staticmethod
    def size(n: int) -> tuple[float, float]:
        return (1.5 / n, 1.0)


@register("a flag on its pole")
def flag(index: int) -> Shape:
    f = Flag.registry[index]
    n = len(f.stripes)
    pole = primitive_call('cylinder', color=Color.gray(0.7).rgb, shape_kwargs={'radius': 0.04, 'p0': (-0.8, 0, 0), 'p1': (-0.8, 3.2, 0)})
    cloth = []
    for i, color in enumerate(f.stripes):
        along, across = Flag.size(n)
        if f.vertical:
            scale, at = (along, across, 0.03), ((i + 0.5) * along - 0.75, 2.6, 0)
        else:
            scale, at = (1.5, across / n, 0.03), (0, 3.1 - (i + 0.5) / n, 0)
        cloth.append(transform_shape(primitive_call('cube', color=color.rgb, shape_kwargs={'scale': scale}), translation_matrix(at)))
    return concat_shapes(pole, *cloth)


@register("parade")
def parade() -> Shape:
    Flag.registry.clear()
    Flag.tricolor("#000", "#dd0000", "#ffce00")
    Flag.tricolor("#0055a4", "#fff", "#ef4135", vertical=True)
    Flag.gradient("#ff0000", "#0000ff", 6)
    Flag.tricolor("#009246", "#ffffff", "#ce2b37", vertical=True)
    Flag([Color.gray(i / 3) for i in range(4)], vertical=False)
    return loop(len(Flag.registry), lambda i: transform_shape(library_call('flag', index=i), translation_matrix((2.2 * i, 0, 0.3 * (i % 2)))))

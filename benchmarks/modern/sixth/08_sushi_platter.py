"""a wooden sushi platter with nigiri, maki, wasabi, ginger, soy sauce and chopsticks"""
from helper import *
import math
from dataclasses import dataclass, field

RICE = (0.97, 0.96, 0.92)
NORI = (0.07, 0.12, 0.08)
TOPPINGS = {
    'salmon': (0.98, 0.5, 0.3),
    'tuna': (0.75, 0.12, 0.18),
    'egg': (0.97, 0.82, 0.3),
    'shrimp': (0.98, 0.7, 0.6),
}


@dataclass
class Row:
    kind: str
    count: int
    z: float
    names: list[str] = field(default_factory=list)

    def x(self, index: int, pitch: float = 0.42) -> float:
        return (index - (self.count - 1) / 2) * pitch


ROWS = [
    Row('nigiri', 5, -0.45, ['salmon', 'tuna', 'egg']),
    Row('maki', 6, 0.0, ['salmon', 'egg']),
    Row('nigiri', 4, 0.45, ['shrimp', 'salmon']),
]


def put(shape: Shape, x=0.0, y=0.0, z=0.0) -> Shape:
    return transform_shape(shape, translation_matrix((x, y, z)))


@register("a pad of rice under a slice")
def nigiri(topping: str = 'salmon', length: float = 0.34) -> Shape:
    grains = loop(4, lambda i: put(primitive_call('sphere', shape_kwargs={'radius': 0.075}, color=RICE), z=(i - 1.5) * length / 5, y=0.07))
    color = TOPPINGS.get(topping, (0.8, 0.8, 0.8))
    fish = put(primitive_call('cube', shape_kwargs={'scale': (0.17, 0.045, length)}, color=color), y=0.155)
    if topping == 'egg':  # an egg nigiri is tied with seaweed
        extra = put(primitive_call('cube', shape_kwargs={'scale': (0.175, 0.11, 0.05)}, color=NORI), y=0.13)
    else:
        pale = tuple(min(1.0, c + 0.2) for c in color)
        extra = loop(3, lambda i: put(primitive_call('cube', shape_kwargs={'scale': (0.172, 0.047, 0.012)}, color=pale), y=0.156, z=(i - 1) * 0.09))
    return concat_shapes(grains, fish, extra)


@register("a roll that stands upright")
def maki(filling: str = 'salmon', radius: float = 0.14, height: float = 0.16) -> Shape:
    layers = [(radius, NORI, 0.0), (radius * 0.9, RICE, 0.004), (radius * 0.4, TOPPINGS[filling], 0.008)]
    return concat_shapes(*[
        primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': (0, 0, 0), 'p1': (0, height + lift, 0)}, color=c)
        for r, c, lift in layers
    ])


@register("pink ginger, folded like a rose")
def ginger(leaves: int = 7) -> Shape:
    shapes = []
    for i in range(leaves):
        a = i * 137.5 * math.pi / 180
        r = 0.02 * math.sqrt(i)
        leaf = primitive_call('sphere', shape_kwargs={'radius': 0.05 - 0.003 * i}, color=(0.98, 0.75, 0.7))
        shapes.append(put(leaf, r * math.cos(a), 0.04 + 0.01 * i, r * math.sin(a)))
    return concat_shapes(*shapes)


@register()
def soy_dish(radius: float = 0.22) -> Shape:
    bowl = primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': (0, 0, 0), 'p1': (0, 0.08, 0)}, color=(0.92, 0.92, 0.95))
    sauce = primitive_call('cylinder', shape_kwargs={'radius': radius * 0.85, 'p0': (0, 0.03, 0), 'p1': (0, 0.085, 0)}, color=(0.15, 0.06, 0.03))
    return concat_shapes(bowl, sauce)


@register()
def chopsticks(length: float = 1.5) -> Shape:
    sticks = [primitive_call('cylinder', shape_kwargs={'radius': 0.02, 'p0': (-length / 2, 0.08, z), 'p1': (length / 2, 0.04, z * 0.4)}, color=(0.5, 0.1, 0.08))
              for z in (-0.05, 0.05)]
    rest = put(primitive_call('cube', shape_kwargs={'scale': (0.08, 0.06, 0.2)}, color=(0.2, 0.3, 0.5)), -length * 0.4, 0.03)
    return concat_shapes(*sticks, rest)


@register()
def platter(width: float = 2.8, depth: float = 1.6) -> Shape:
    top = put(primitive_call('cube', shape_kwargs={'scale': (width, 0.06, depth)}, color=(0.72, 0.5, 0.28)), y=0.13)
    feet = [put(primitive_call('cube', shape_kwargs={'scale': (0.12, 0.1, depth * 0.9)}, color=(0.6, 0.4, 0.2)), s * width * 0.35, 0.05) for s in (-1, 1)]
    return concat_shapes(top, *feet)


@register()
def sushi_platter() -> Shape:
    pieces = []
    for row in ROWS:
        for i in range(row.count):
            name = row.names[i % len(row.names)]
            piece = library_call('nigiri', topping=name) if row.kind == 'nigiri' else library_call('maki', filling=name)
            pieces.append(put(piece, row.x(i), 0.16, row.z))
    wasabi = put(primitive_call('sphere', shape_kwargs={'radius': 0.08}, color=(0.6, 0.75, 0.3)), 1.2, 0.2, 0.55)
    return concat_shapes(library_call('platter'), *pieces, wasabi,
                         put(library_call('ginger'), 1.22, 0.16, 0.3),
                         put(library_call('soy_dish'), 1.8, 0, -0.2),
                         put(library_call('chopsticks'), 0, 0, 1.1))

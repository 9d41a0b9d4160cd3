"""a programmer's desk with an ultrawide monitor, a laptop, a keyboard and a cup of pencils"""
from helper import *
from dataclasses import dataclass
import random

Color = tuple[float, float, float]


@dataclass(frozen=True)
class Theme:
    metal: Color = (0.7, 0.71, 0.74)
    plastic: Color = (0.12, 0.12, 0.13)
    accent: Color = (0.95, 0.45, 0.2)
    wood: Color = (0.5, 0.34, 0.2)


THEME = Theme()
SYNTAX: list[Color] = [(0.4, 0.7, 0.95), (0.95, 0.6, 0.3), (0.6, 0.85, 0.5), (0.85, 0.85, 0.8)]

CODE = """
def scene():
    trees = [tree(i)
        for i in range(9)]
    house = cabin(3, 4)

    return join(trees, house)
"""


def block(w: float, h: float, d: float, at: tuple[float, float, float] = (0, 0, 0), color: Color = THEME.plastic) -> Shape:
    return transform_shape(primitive_call('cube', shape_kwargs={'scale': (w, h, d)}, color=color), translation_matrix(at))


@register()
def code_lines(char: float = 0.018, line_height: float = 0.04, max_lines: int = 6) -> Shape:
    """Coloured bars, one for each word of the code."""
    bars = []
    for row, line in enumerate(CODE.strip('\n').splitlines()[:max_lines]):
        column = len(line) - len(line.lstrip())
        for k, word in enumerate(line.split()):
            width = len(word) * char
            x = column * char + width / 2
            bars.append(block(width, line_height * 0.5, 0.004, (x, -row * line_height, 0), SYNTAX[(k + row) % len(SYNTAX)]))
            column += len(word) + 1
    return concat_shapes(*bars)


@register()
def monitor(width: float = 1.1, height: float = 0.45, tilt: float = -0.06) -> Shape:
    panel = concat_shapes(block(width, height, 0.04), block(width - 0.03, height - 0.03, 0.01, (0, 0, 0.02), (0.1, 0.12, 0.17)))
    text = transform_shape(library_call('code_lines'), translation_matrix((-width / 2 + 0.06, height / 2 - 0.08, 0.028)))
    sidebar = block(0.18, height - 0.05, 0.006, (width / 2 - 0.12, 0, 0.024), (0.16, 0.18, 0.24))
    screen = transform_shape(concat_shapes(panel, text, sidebar), rotation_matrix(tilt, (1, 0, 0), (0, 0, 0)))
    stand = concat_shapes(block(0.06, 0.35, 0.04, (0, 0.175, -0.04), THEME.metal), block(0.3, 0.02, 0.22, (0, 0.01, 0), THEME.metal))
    return concat_shapes(stand, transform_shape(screen, translation_matrix((0, 0.12 + height / 2, 0))))


@register()
def keyboard(rows: int = 5, columns: int = 14, key: float = 0.024) -> Shape:
    pitch = key * 1.2
    case = block(columns * pitch + 0.03, 0.02, rows * pitch + 0.03, (0, 0.01, 0))
    keys = []
    for r in range(rows):
        c = 0
        while c < columns:
            span = 6 if r == rows - 1 and c == 4 else 2 if c in (0, columns - 2) and r in (1, 2, 3) else 1
            x = (c + span / 2 - columns / 2) * pitch
            z = (r + 0.5 - rows / 2) * pitch
            color = THEME.accent if (r, c) == (0, 0) else (0.85, 0.85, 0.83) if span == 1 else (0.6, 0.62, 0.65)
            keys.append(block(span * pitch - (pitch - key), 0.015, key, (x, 0.028, z), color))
            c += span
    return concat_shapes(case, *keys)


@register()
def laptop(opening: float = 110.0) -> Shape:
    base = concat_shapes(block(0.36, 0.015, 0.25, (0, 0.008, 0), THEME.metal), block(0.3, 0.004, 0.1, (0, 0.017, -0.04)), block(0.11, 0.003, 0.07, (0, 0.017, 0.075), (0.62, 0.63, 0.66)))
    lid = concat_shapes(block(0.36, 0.01, 0.25, (0, 0, 0.125), THEME.metal), block(0.34, 0.004, 0.22, (0, -0.006, 0.125), (0.15, 0.25, 0.4)))
    lid = transform_shape(lid, rotation_matrix(-math.radians(opening), (1, 0, 0), (0, 0, 0)))
    return concat_shapes(base, transform_shape(lid, translation_matrix((0, 0.016, -0.125))))


@register()
def pencil_cup(pencils: int = 7, seed: int = 3) -> Shape:
    rnd = random.Random(seed)
    parts = [primitive_call('cylinder', shape_kwargs={'radius': 0.045, 'p0': (0, 0, 0), 'p1': (0, 0.11, 0)}, color=THEME.accent)]
    for _ in range(pencils):
        a, lean = rnd.uniform(0, 2 * math.pi), rnd.uniform(0.0, 0.035)
        foot = (lean * math.cos(a), 0.02, lean * math.sin(a))
        tip = (-2 * foot[0] + 0.01, rnd.uniform(0.16, 0.2), -2 * foot[2])
        parts.append(primitive_call('cylinder', shape_kwargs={'radius': 0.005, 'p0': foot, 'p1': tip}, color=rnd.choice(SYNTAX)))
    return concat_shapes(*parts)


@register()
def desk(width: float = 1.8, depth: float = 0.8, height: float = 0.74, drawers: int = 3) -> Shape:
    top = block(width, 0.04, depth, (0, height - 0.02, 0), THEME.wood)
    legs = [block(0.05, height - 0.04, 0.05, (-width / 2 + 0.05, (height - 0.04) / 2, s * (depth / 2 - 0.05)), THEME.metal) for s in (-1, 1)]
    h = (height - 0.06) / drawers
    fronts = loop(drawers, lambda i: concat_shapes(block(0.4, h - 0.02, depth - 0.1, (width / 2 - 0.22, h * (i + 0.5), 0), (0.9, 0.9, 0.88)),
                                                   block(0.12, 0.02, 0.02, (width / 2 - 0.22, h * (i + 0.5) + 0.04, depth / 2 - 0.04), THEME.metal)))
    return concat_shapes(top, *legs, fronts)


@register()
def workspace(seed: int = 3) -> Shape:
    d = library_call('desk')
    y = float(compute_shape_max(d)[1])
    put = lambda shape, x, z, turn=0.0: transform_shape(transform_shape(shape, rotation_matrix(turn, (0, 1, 0), (0, 0, 0))), translation_matrix((x, y, z)))
    return concat_shapes(d, put(library_call('monitor'), 0.0, -0.2), put(library_call('laptop'), -0.6, 0.12, 0.35),
                         put(library_call('keyboard'), 0.05, 0.18), put(library_call('pencil_cup', seed=seed), 0.65, -0.1))

"""a space invader built from cubes, as pixel art with depth"""
from helper import *
from collections import Counter

SPRITE = """
..#.....#..
...#...#...
..#######..
.##o###o##.
###########
#.#######.#
#.#.....#.#
...##.##...
"""
LEGEND = {'#': (0.25, 0.85, 0.35), 'o': (0.95, 0.2, 0.2)}


def parse(sprite: str) -> dict[tuple[int, int], str]:
    rows = [line for line in sprite.splitlines() if line]
    assert len({len(r) for r in rows}) == 1, f"ragged sprite: {[len(r) for r in rows]}"
    h = len(rows)
    return {(x, h - 1 - y): ch for y, row in enumerate(rows) for x, ch in enumerate(row) if ch != '.'}


PIXELS = parse(SPRITE)
COUNTS = Counter(PIXELS.values())
assert COUNTS['o'] == 2, "an invader has two eyes"


@register()
def pixel(ch: str, size: float = 1.0, depth: float = 1.0) -> Shape:
    bump = 1.4 if ch == 'o' else 1.0
    return primitive_call('cube', shape_kwargs={'scale': (size * 0.95, size * 0.95, depth * bump)}, color=LEGEND[ch])


@register()
def invader(size: float = 1.0) -> Shape:
    shapes = [
        transform_shape(library_call('pixel', ch=ch, size=size), translation_matrix((x * size, y * size, 0)))
        for (x, y), ch in sorted(PIXELS.items(), key=lambda kv: (kv[0][1], kv[0][0]))
    ]
    whole = concat_shapes(*shapes)
    return transform_shape(whole, translation_matrix(-compute_shape_center(whole)))


@register()
def laser(length: float = 2.0) -> Shape:
    return primitive_call('cylinder', shape_kwargs={'radius': 0.15, 'p0': (0, 0, 0), 'p1': (0, -length, 0)}, color=(1, 1, 0.3))


@register()
def invader_fleet(rows: int = 2, cols: int = 3) -> Shape:
    one = library_call('invader')
    w, h, _ = compute_shape_sizes(one)
    fleet = loop(rows * cols, lambda k: transform_shape(one, translation_matrix((
        (k % cols - (cols - 1) / 2) * w * 1.25, (k // cols) * h * 1.4, 0))))
    shot = transform_shape(library_call('laser'), translation_matrix((0, compute_shape_min(fleet)[1] - 0.5, 0)))
    return concat_shapes(fleet, shot)

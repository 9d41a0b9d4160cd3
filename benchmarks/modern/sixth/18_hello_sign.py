"""the word HELLO as a lit sign on a roof frame"""
from helper import *

# five columns and seven rows for each letter
FONT = {
    'H': ["#...#", "#...#", "#...#", "#####", "#...#", "#...#", "#...#"],
    'E': ["#####", "#....", "#....", "####.", "#....", "#....", "#####"],
    'L': ["#....", "#....", "#....", "#....", "#....", "#....", "#####"],
    'O': [".###.", "#...#", "#...#", "#...#", "#...#", "#...#", ".###."],
    '!': ["..#..", "..#..", "..#..", "..#..", "..#..", ".....", "..#.."],
}
GLOW = [(1.0, 0.25, 0.4), (1.0, 0.75, 0.2), (0.3, 0.9, 0.5), (0.3, 0.6, 1.0), (0.8, 0.4, 1.0)]
STEEL = (0.35, 0.36, 0.4)


@register("a light bulb in a square socket; the bulb looks along +z")
def bulb(color: tuple[float, float, float] = (1.0, 0.8, 0.3), size: float = 0.16) -> Shape:
    socket = primitive_call('cube', shape_kwargs={'scale': (size, size, size * 0.3)}, color=(0.15, 0.15, 0.17))
    glass = primitive_call('sphere', shape_kwargs={'radius': size * 0.42}, color=color)
    return concat_shapes(socket, transform_shape(glass, translation_matrix((0, 0, size * 0.35))))


@register("one letter of bulbs; its lower left corner at the origin")
def letter(char: str = 'H', color: tuple[float, float, float] = (1.0, 0.8, 0.3), pitch: float = 0.18) -> Shape:
    rows = FONT[char]
    lit = [(column, len(rows) - 1 - row) for row, line in enumerate(rows) for column, mark in enumerate(line) if mark == '#']
    return concat_shapes(*[
        transform_shape(library_call('bulb', color=color), translation_matrix((x * pitch, y * pitch, 0))) for x, y in lit
    ])


@register("a word of letters")
def word(text: str = "HELLO!", pitch: float = 0.18, spacing: float = 1.15) -> Shape:
    shapes = []
    for i, char in enumerate(text):
        if char not in FONT:
            continue  # also a space
        color = GLOW[i % len(GLOW)]
        shapes.append(transform_shape(library_call('letter', char=char, color=color, pitch=pitch), translation_matrix((i * spacing, 0, 0))))
    return concat_shapes(*shapes)


@register("a truss along x: two chords with zigzag members")
def truss(length: float = 7.0, bays: int = 14, height: float = 0.35) -> Shape:
    bay = length / bays

    def member(i):
        y0, y1 = (0, height) if i % 2 == 0 else (height, 0)
        return primitive_call('cylinder', shape_kwargs={'radius': 0.02, 'p0': (i * bay, y0, 0), 'p1': ((i + 1) * bay, y1, 0)}, color=STEEL)

    chords = [primitive_call('cylinder', shape_kwargs={'radius': 0.035, 'p0': (0, y, 0), 'p1': (length, y, 0)}, color=STEEL) for y in (0, height)]
    return concat_shapes(*chords, loop(bays, member))


@register("posts with a diagonal brace toward the back")
def posts(count: int = 5, length: float = 7.0, height: float = 2.2) -> Shape:
    step = length / (count - 1)
    members = []
    for i in range(count):
        x = i * step
        members.append(primitive_call('cylinder', shape_kwargs={'radius': 0.045, 'p0': (x, 0, 0), 'p1': (x, height, 0)}, color=STEEL))
        members.append(primitive_call('cylinder', shape_kwargs={'radius': 0.03, 'p0': (x, height * 0.8, 0), 'p1': (x, 0, -1.2)}, color=STEEL))
    return concat_shapes(*members)


@register("a brick parapet: rows shifted by half a brick")
def parapet(length: float = 7.6, courses: int = 4, brick: float = 0.4) -> Shape:
    bricks = []
    for c in range(courses):
        count = int(length / brick) - c % 2
        start = -count * brick / 2
        for k in range(count):
            tone = 0.5 + 0.07 * ((k * 5 + c * 3) % 4)
            cube = primitive_call('cube', shape_kwargs={'scale': (brick * 0.95, 0.14, 0.25)}, color=(tone, tone * 0.45, tone * 0.35))
            bricks.append(transform_shape(cube, translation_matrix((start + (k + 0.5) * brick, 0.08 + 0.15 * c, 0))))
    return concat_shapes(*bricks)


@register()
def hello_sign(text: str = "HELLO!") -> Shape:
    length = len(text) * 1.15
    offset = -length / 2
    lettering = transform_shape(library_call('word', text=text), translation_matrix((offset + 0.2, 0.95, 0.12)))
    frame = [transform_shape(library_call('truss', length=length), translation_matrix((offset, y, 0))) for y in (0.5, 2.2)]
    supports = transform_shape(library_call('posts', length=length), translation_matrix((offset, 0, -0.1)))
    front = transform_shape(library_call('parapet', length=length + 0.6), translation_matrix((0, -0.1, 0.6)))
    roof = transform_shape(primitive_call('cube', shape_kwargs={'scale': (length + 0.8, 0.2, 2.4)}, color=(0.4, 0.4, 0.42)), translation_matrix((0, -0.1, -0.4)))
    return concat_shapes(roof, front, supports, *frame, lettering)

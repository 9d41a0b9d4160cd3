"""a black grand piano with an open lid, a music stand and a stool"""
from helper import *
import math

BLACK = (0.05, 0.05, 0.06)
IVORY = (0.97, 0.96, 0.92)
GOLD = (0.85, 0.66, 0.25)

# y up; the keyboard lies along x at z = 0, the case extends to negative z
WHITE_NOTES = 'CDEFGAB'
SHARP_AFTER = {'C', 'D', 'F', 'G', 'A'}


def slab(size, at, color=BLACK):
    return transform_shape(primitive_call('cube', shape_kwargs={'scale': size}, color=color), translation_matrix(at))


@register()
def keyboard(first: str = 'A', white_keys: int = 52, width: float = 1.23, pressed: tuple = (20, 24, 27)) -> Shape:
    key_w = width / white_keys
    start = WHITE_NOTES.index(first)
    keys = []
    for i in range(white_keys):
        note = WHITE_NOTES[(start + i) % 7]
        x = -width / 2 + (i + 0.5) * key_w
        dip = -0.008 if i in pressed else 0.0
        keys.append(slab((key_w * 0.94, 0.02, 0.15), (x, dip, 0), IVORY))
        if note in SHARP_AFTER and i < white_keys - 1:
            keys.append(slab((key_w * 0.55, 0.025, 0.095), (x + key_w / 2, 0.014, -0.027), BLACK))
    return concat_shapes(*keys)


@register()
def case(width: float = 1.5, depth: float = 1.9, height: float = 0.3, slices: int = 24) -> Shape:
    """The wing-shaped body out of slices: the right side bends inwards."""
    def right_edge(t: float) -> float:
        # smoothstep from full width to a third of it
        s = t * t * (3 - 2 * t)
        return width / 2 - s * width * 0.62

    step = depth / slices
    body = []
    for k in range(slices):
        t = (k + 0.5) / slices
        left, right = -width / 2, right_edge(t)
        tail = max(0.0, (t - 0.85) / 0.15)
        left += tail * 0.12
        body.append(slab((right - left, height, step * 1.02), ((left + right) / 2, 0, -t * depth)))
        if 2 <= k < slices - 2:
            body.append(slab((right - left - 0.1, 0.01, step * 1.02), ((left + right) / 2, height / 2, -t * depth), GOLD))
    return concat_shapes(*body)


@register()
def strings(count: int = 30, width: float = 1.2, longest: float = 1.5) -> Shape:
    def string(i: int) -> Shape:
        t = i / (count - 1)
        x = -width / 2 + width * t
        reach = longest * (1 - 0.72 * t ** 0.8)
        return primitive_call('cylinder', shape_kwargs={'radius': 0.004 - 0.0025 * t, 'p0': (x, 0, -0.15), 'p1': (x - 0.02, 0, -0.15 - reach)},
                              color=(0.75, 0.5, 0.3) if t < 0.3 else (0.8, 0.8, 0.82))
    return loop(count, string)


@register()
def lid(width: float = 1.5, depth: float = 1.9, opening: float = 38.0, slices: int = 18) -> Shape:
    step = depth / slices
    boards = []
    for k in range(slices):
        t = (k + 0.5) / slices
        s = t * t * (3 - 2 * t)
        w = width - s * width * 0.62
        boards.append(slab((w, 0.025, step * 1.02), (w / 2, 0, -t * depth)))
    return transform_shape(concat_shapes(*boards), rotation_matrix(math.radians(opening), (0, 0, 1), (0, 0, 0)))


@register()
def leg(height: float = 0.6) -> Shape:
    rings = [(0.05, 0.06), (0.3, 0.045), (0.55, 0.055), (0.8, 0.065), (1.0, 0.075)]
    parts, previous = [], 0.0
    for fraction, radius in rings:
        parts.append(primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': (0, previous * height, 0), 'p1': (0, fraction * height, 0)}, color=BLACK))
        previous = fraction
    wheel = primitive_call('cylinder', shape_kwargs={'radius': 0.04, 'p0': (-0.015, 0, 0), 'p1': (0.015, 0, 0)}, color=GOLD)
    return concat_shapes(*parts, wheel)


@register()
def stool(seat_height: float = 0.48) -> Shape:
    cushion = concat_shapes(slab((0.6, 0.08, 0.35), (0, seat_height, 0), (0.35, 0.05, 0.07)), slab((0.62, 0.05, 0.37), (0, seat_height - 0.06, 0)))
    buttons = [transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.012}, color=GOLD), translation_matrix((x, seat_height + 0.04, z)))
               for x in (-0.2, 0, 0.2) for z in (-0.08, 0.08)]
    feet = [primitive_call('cylinder', shape_kwargs={'radius': 0.025, 'p0': (sx * 0.26, 0, sz * 0.14), 'p1': (sx * 0.26, seat_height - 0.08, sz * 0.14)}, color=BLACK) for sx in (-1, 1) for sz in (-1, 1)]
    return concat_shapes(cushion, *buttons, *feet)


@register()
def grand_piano(leg_height: float = 0.62) -> Shape:
    y = leg_height + 0.15
    legs = [transform_shape(library_call('leg', height=leg_height), translation_matrix(p)) for p in ((-0.65, 0, -0.15), (0.65, 0, -0.15), (-0.45, 0, -1.65))]
    keys = transform_shape(library_call('keyboard'), translation_matrix((0, y + 0.06, 0.1)))
    shelf = slab((1.5, 0.12, 0.3), (0, y - 0.03, 0.1))
    cheeks = [slab((0.1, 0.2, 0.3), (s * 0.7, y + 0.04, 0.1)) for s in (-1, 1)]
    top = transform_shape(library_call('lid'), translation_matrix((-0.75, y + 0.17, 0)))
    prop = primitive_call('cylinder', shape_kwargs={'radius': 0.012, 'p0': (0.55, y + 0.15, -0.5), 'p1': (0.2, y + 0.9, -0.5)}, color=BLACK)
    stand = transform_shape(slab((0.6, 0.28, 0.015), (0, 0.14, 0)), translation_matrix((0, y + 0.16, -0.15)) @ rotation_matrix(-0.3, (1, 0, 0), (0, 0, 0)))
    sheets = [transform_shape(slab((0.2, 0.24, 0.006), (s * 0.11, 0.14, 0.012), (1, 1, 0.97)), translation_matrix((0, y + 0.16, -0.15)) @ rotation_matrix(-0.3, (1, 0, 0), (0, 0, 0))) for s in (-1, 1)]
    return concat_shapes(*legs, transform_shape(library_call('case'), translation_matrix((0, y, 0))), transform_shape(library_call('strings'), translation_matrix((0, y + 0.17, 0))),
                         keys, shelf, *cheeks, top, prop, stand, *sheets)


@register()
def recital() -> Shape:
    stage = loop(12, lambda i: slab((0.33, 0.1, 4.5), (-2 + 0.34 * i, -0.05, -0.4), (0.6 + 0.03 * (i % 3), 0.42, 0.25)))
    return concat_shapes(stage, library_call('grand_piano'), transform_shape(library_call('stool'), translation_matrix((0, 0, 0.75))))

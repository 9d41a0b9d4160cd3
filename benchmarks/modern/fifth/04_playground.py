"""a playground with a swing set, a slide, a seesaw and a sandbox"""
from helper import *
import math

RED, BLUE, YELLOW, GREEN = (0.85, 0.15, 0.15), (0.15, 0.35, 0.8), (0.95, 0.8, 0.15), (0.2, 0.6, 0.25)
STEEL = (0.65, 0.67, 0.7)


def box(size, center=(0, 0, 0), color=(1, 1, 1)) -> Shape:
    return transform_shape(primitive_call('cube', shape_kwargs={'scale': size}, color=color), translation_matrix(center))


def pipe(a, b, r=0.05, color=STEEL) -> Shape:
    return primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': a, 'p1': b}, color=color)


@register()
def swing(rope: float = 1.8, angle: float = 0.0, color: tuple = RED) -> Shape:
    seat = box((0.5, 0.05, 0.22), (0, -rope, 0), color)
    ropes = concat_shapes(*(pipe((x, 0, 0), (x, -rope, 0), 0.012, (0.3, 0.3, 0.3)) for x in (-0.22, 0.22)))
    return transform_shape(concat_shapes(seat, ropes), rotation_matrix(math.radians(angle), (1, 0, 0), (0, 0, 0)))


@register()
def swing_set(swings: int = 3, height: float = 2.3, spacing: float = 1.0) -> Shape:
    span = spacing * (swings + 0.4)
    beam = pipe((-span / 2, height, 0), (span / 2, height, 0), 0.06)
    legs = [pipe((sx * span / 2, height, 0), (sx * (span / 2 + 0.2), 0, sz * 0.9)) for sx in (-1, 1) for sz in (-1, 1)]
    colors = [RED, YELLOW, BLUE, GREEN]
    angles = [25, -12, 0, 18]
    hung = []
    for i in range(swings):
        s = library_call('swing', rope=height - 0.5, angle=angles[i % 4], color=colors[i % 4])
        hung.append(transform_shape(s, translation_matrix(((i - (swings - 1) / 2) * spacing, height, 0))))
    return concat_shapes(beam, *legs, *hung)


@register()
def slide(height: float = 1.8, length: float = 3.0, width: float = 0.6, steps: int = 6) -> Shape:
    def curve(t: float) -> tuple[float, float]:
        # smooth drop with a flat run-out
        return length * t, height * (1 - t) ** 2 * (1 + 2 * t)

    n = 16
    chute = []
    for i in range(n):
        (x0, y0), (x1, y1) = curve(i / n), curve((i + 1) / n)
        seg, slope = math.hypot(x1 - x0, y1 - y0), math.atan2(y1 - y0, x1 - x0)
        piece = concat_shapes(
            box((seg * 1.05, 0.04, width), color=YELLOW),
            box((seg * 1.05, 0.16, 0.04), (0, 0.08, width / 2), RED),
            box((seg * 1.05, 0.16, 0.04), (0, 0.08, -width / 2), RED),
        )
        piece = transform_shape(piece, rotation_matrix(slope, (0, 0, 1), (0, 0, 0)))
        chute.append(transform_shape(piece, translation_matrix(((x0 + x1) / 2, (y0 + y1) / 2 + 0.1, 0))))
    platform = box((0.7, 0.08, width + 0.1), (-0.35, height + 0.1, 0), BLUE)
    posts = [pipe((x, 0, z), (x, height + 0.9, z)) for x in (-0.7, 0.0) for z in (-width / 2, width / 2)]
    ladder = loop(steps, lambda i: pipe((-0.75 - 0.08 * (steps - i), (i + 1) * height / (steps + 1), -width / 2),
                                        (-0.75 - 0.08 * (steps - i), (i + 1) * height / (steps + 1), width / 2), 0.03))
    roof = concat_shapes(*[transform_shape(box((0.6, 0.05, width + 0.3), color=GREEN),
                                           translation_matrix((-0.35 + s * 0.22, height + 1.05, 0)) @ rotation_matrix(-s * 0.6, (0, 0, 1), (0, 0, 0)))
                           for s in (-1, 1)])
    return concat_shapes(platform, *posts, ladder, roof, *chute)


@register()
def seesaw(length: float = 3.0, tilt: float = 14.0) -> Shape:
    plank = [box((length, 0.07, 0.28), color=BLUE)]
    for s in (-1, 1):
        plank += [box((0.35, 0.05, 0.3), (s * (length / 2 - 0.25), 0.06, 0), RED),
                  pipe((s * (length / 2 - 0.55), 0, 0), (s * (length / 2 - 0.55), 0.3, 0), 0.02),
                  pipe((s * (length / 2 - 0.55), 0.3, -0.15), (s * (length / 2 - 0.55), 0.3, 0.15), 0.02)]
    board = transform_shape(concat_shapes(*plank), rotation_matrix(math.radians(tilt), (0, 0, 1), (0, 0, 0)))
    pivot = concat_shapes(pipe((0, 0.5, -0.25), (0, 0.5, 0.25), 0.08), pipe((0, 0.5, 0.2), (0, 0, 0.35)), pipe((0, 0.5, -0.2), (0, 0, -0.35)))
    return concat_shapes(pivot, transform_shape(board, translation_matrix((0, 0.55, 0))))


@register()
def sandbox(size: float = 2.0) -> Shape:
    frame = loop(4, lambda i: transform_shape(box((size + 0.2, 0.25, 0.2), (0, 0.125, size / 2), (0.55, 0.38, 0.2)),
                                              rotation_matrix(i * math.pi / 2, (0, 1, 0), (0, 0, 0))))
    sand = box((size, 0.15, size), (0, 0.075, 0), (0.9, 0.82, 0.58))
    castle = loop(5, lambda i: pipe((0.18 * (i - 2), 0.15, 0.1 * (i % 2)), (0.18 * (i - 2), 0.3 + 0.1 * (2 - abs(i - 2)), 0.1 * (i % 2)), 0.08, (0.85, 0.75, 0.5)))
    return concat_shapes(frame, sand, castle)


@register()
def playground() -> Shape:
    layout = [
        (library_call('swing_set'), (-3, 0, -1.5), 0),
        (library_call('slide'), (1.2, 0, -1.8), -20),
        (library_call('seesaw'), (-2, 0, 2), 35),
        (library_call('sandbox'), (2.2, 0, 1.6), 10),
    ]
    lawn = box((11, 0.1, 8), (0, -0.05, 0), (0.4, 0.65, 0.3))
    return concat_shapes(lawn, *[transform_shape(transform_shape(s, rotation_matrix(math.radians(deg), (0, 1, 0), (0, 0, 0))), translation_matrix(p))
                                 for s, p, deg in layout])

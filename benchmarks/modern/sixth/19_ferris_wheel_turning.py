"""a Ferris wheel that turns, as an animation of 8 frames"""
from helper import *
import math

WHITE = (0.95, 0.95, 0.95)
GONDOLA_COLORS = [(0.9, 0.2, 0.2), (0.95, 0.7, 0.1), (0.2, 0.65, 0.35), (0.2, 0.45, 0.85)]
GONDOLAS = 12
RADIUS = 3.0
AXLE = 3.8


def tube(a, b, r=0.04, color=WHITE):
    return primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': a, 'p1': b}, color=color)


@register("a cabin that hangs below the origin")
def gondola(color: tuple[float, float, float] = (0.9, 0.2, 0.2)) -> Shape:
    hanger = tube((0, 0, 0), (0, -0.25, 0), 0.02)
    roof = tube((0, -0.25, 0), (0, -0.31, 0), 0.34, color)
    tub = tube((0, -0.8, 0), (0, -0.58, 0), 0.3, color)
    bars = loop(4, lambda i: tube(
        (0.27 * math.cos(math.pi * (i + 0.5) / 2), -0.8, 0.27 * math.sin(math.pi * (i + 0.5) / 2)),
        (0.27 * math.cos(math.pi * (i + 0.5) / 2), -0.3, 0.27 * math.sin(math.pi * (i + 0.5) / 2)), 0.015))
    return concat_shapes(hanger, roof, tub, bars)


@register("a rim of straight pieces, with spokes")
def rim(radius: float = RADIUS, spokes: int = GONDOLAS, z: float = 0.45) -> Shape:
    def corner(k: int, r: float) -> tuple[float, float, float]:
        a = 2 * math.pi * k / spokes
        return (r * math.cos(a), r * math.sin(a), z)

    shapes = []
    for k in range(spokes):
        shapes.append(tube(corner(k, radius), corner(k + 1, radius)))
        shapes.append(tube(corner(k, radius * 0.85), corner(k + 1, radius * 0.85), 0.025))
        shapes.append(tube((0, 0, z), corner(k, radius), 0.02))
        # zigzag between both rings
        shapes.append(tube(corner(k, radius * 0.85), corner(k + 1, radius), 0.015))
    return concat_shapes(*shapes)


@register("everything that turns; the gondolas stay upright")
def wheel(angle: float = 0.0) -> Shape:
    rims = concat_shapes(library_call('rim', z=-0.45), library_call('rim', z=0.45))
    turned = transform_shape(rims, rotation_matrix(math.radians(angle), (0, 0, 1), (0, 0, 0)))
    hung = []
    for k in range(GONDOLAS):
        a = math.radians(angle) + 2 * math.pi * k / GONDOLAS
        at = (RADIUS * math.cos(a), RADIUS * math.sin(a), 0)
        hung.append(tube((at[0], at[1], -0.45), (at[0], at[1], 0.45), 0.02))
        hung.append(transform_shape(library_call('gondola', color=GONDOLA_COLORS[k % len(GONDOLA_COLORS)]), translation_matrix(at)))
    return transform_shape(concat_shapes(turned, *hung), translation_matrix((0, AXLE, 0)))


@register("two A-frames, the axle and a platform")
def support() -> Shape:
    steel = (0.3, 0.4, 0.6)
    legs = [tube((sx * 1.6, 0, sz * 0.9), (0, AXLE, sz * 0.6), 0.09, steel) for sx in (-1, 1) for sz in (-1, 1)]
    axle = tube((0, AXLE, -0.75), (0, AXLE, 0.75), 0.15, steel)
    deck = transform_shape(primitive_call('cube', shape_kwargs={'scale': (4.5, 0.12, 2.6)}, color=(0.6, 0.45, 0.3)), translation_matrix((0, -0.06, 0)))
    booth = transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.5, 0.8, 0.5)}, color=(0.9, 0.85, 0.3)), translation_matrix((1.9, 0.4, 0.9)))
    return concat_shapes(*legs, axle, deck, booth)


@register()
def ferris_wheel(angle: float = 0.0) -> Shape:
    return concat_shapes(library_call('support'), library_call('wheel', angle=angle))


@register_animation()
def turning() -> list[Shape]:
    frames = 8
    step = 360 / GONDOLAS / frames  # after all frames the wheel looks the same again
    return [library_call('ferris_wheel', angle=k * step) for k in range(frames)]

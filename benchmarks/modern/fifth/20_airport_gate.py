"""a passenger airplane at an airport gate with luggage carts and a control tower"""
from helper import *
import math

WHITE = (0.95, 0.95, 0.97)
NAVY = (0.1, 0.18, 0.45)


def seg(a, b, r, c=WHITE):
    return primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': a, 'p1': b}, color=c)


def brick(s, p, c=WHITE, m=None):
    shape = primitive_call('cube', shape_kwargs={'scale': s}, color=c)
    if m is not None:
        shape = transform_shape(shape, m)
    return transform_shape(shape, translation_matrix(p))


def orb(p, r, c=WHITE):
    return transform_shape(primitive_call('sphere', shape_kwargs={'radius': r}, color=c), translation_matrix(p))


@register()
def fuselage(length: float = 12.0, radius: float = 0.9, windows: int = 22) -> Shape:
    stations = [(-0.5, 0.15), (-0.42, 0.45), (-0.32, 0.8), (-0.2, 1.0), (0.36, 1.0), (0.42, 0.9), (0.47, 0.65), (0.5, 0.3)]
    hull = []
    for (t0, r0), (t1, r1) in zip(stations, stations[1:]):
        pieces = 1 if r0 == r1 else 4
        for k in range(pieces):
            f0, f1 = k / pieces, (k + 1) / pieces
            r = r0 + (r1 - r0) * (f0 + f1) / 2
            lift = (1 - r) * 0.3 * radius if t0 < -0.2 else 0.0
            hull.append(seg(((t0 + (t1 - t0) * f0) * length, lift, 0), ((t0 + (t1 - t0) * f1) * length, lift, 0), r * radius))
    nose = orb((length * 0.5, -0.05, 0), radius * 0.3)
    stripe = [brick((length * 0.56, 0.14, 0.02), (length * 0.08, 0.0, s * radius * 0.99), NAVY) for s in (-1, 1)]
    panes = loop(windows * 2, lambda i: brick((0.14, 0.2, 0.02), (-length * 0.18 + (i // 2) * length * 0.52 / windows, 0.28, (1 if i % 2 else -1) * radius * 0.96), (0.15, 0.2, 0.3)))
    cockpit = brick((0.4, 0.25, 0.9), (length * 0.45, 0.35, 0), (0.1, 0.15, 0.2), rotation_matrix(-0.5, (0, 0, 1), (0, 0, 0)))
    return concat_shapes(*hull, nose, *stripe, panes, cockpit)


@register()
def wing(span: float = 5.5, root: float = 2.2, tip: float = 0.7, sweep: float = 28.0, dihedral: float = 5.0, sections: int = 10) -> Shape:
    parts = []
    for k in range(sections):
        t = (k + 0.5) / sections
        chord = root + (tip - root) * t
        x = -math.tan(math.radians(sweep)) * span * t
        parts.append(brick((chord, 0.12 * (1.2 - t), span / sections * 1.02), (x, math.tan(math.radians(dihedral)) * span * t, span * t), (0.85, 0.86, 0.9)))
    return concat_shapes(*parts)


@register()
def engine(radius: float = 0.42, length: float = 1.3, fan_blades: int = 14) -> Shape:
    cowl = seg((-length / 2, 0, 0), (length / 2, 0, 0), radius, NAVY)
    inlet = seg((length / 2, 0, 0), (length / 2 + 0.02, 0, 0), radius * 0.85, (0.1, 0.1, 0.1))
    fan = loop(fan_blades, lambda i: seg((length / 2 + 0.03, 0, 0), (length / 2 + 0.03, radius * 0.8 * math.cos(math.tau * i / fan_blades), radius * 0.8 * math.sin(math.tau * i / fan_blades)), 0.02, (0.6, 0.6, 0.65)))
    cone = seg((-length / 2 - 0.4, 0, 0), (-length / 2, 0, 0), radius * 0.4, (0.4, 0.4, 0.42))
    return concat_shapes(cowl, inlet, fan, cone)


@register()
def airplane(length: float = 12.0) -> Shape:
    right = transform_shape(library_call('wing'), translation_matrix((0.6, -0.4, 0.6)))
    left = transform_shape(right, reflection_matrix((0, 0, 0), (0, 0, 1)))
    engines = [transform_shape(library_call('engine'), translation_matrix((0.6, -0.8, s * 2.3))) for s in (-1, 1)]
    fin = transform_shape(library_call('wing', span=2.2, root=1.6, tip=0.8, sweep=38, dihedral=0, sections=7), translation_matrix((-length * 0.42, 0.6, 0)) @ rotation_matrix(-math.pi / 2, (1, 0, 0), (0, 0, 0)))
    stab = transform_shape(library_call('wing', span=2.0, root=1.1, tip=0.5, sections=5), translation_matrix((-length * 0.44, 0.3, 0.2)))
    gear = []
    for x, z, wheels in ((length * 0.38, 0.0, 2), (0.0, 0.9, 4), (0.0, -0.9, 4)):
        gear.append(seg((x, -0.7, z), (x, -1.6, z), 0.07, (0.7, 0.7, 0.7)))
        for k in range(wheels):
            dx, dz = (k // 2 - (wheels // 2 - 1) / 2) * 0.5, (-1) ** k * 0.16
            gear.append(seg((x + dx, -1.65, z + dz - 0.07), (x + dx, -1.65, z + dz + 0.07), 0.22, (0.08, 0.08, 0.08)))
    plane = concat_shapes(library_call('fuselage', length=length), left, right, *engines, fin, stab, transform_shape(stab, reflection_matrix((0, 0, 0), (0, 0, 1))), *gear)
    return transform_shape(plane, translation_matrix((0, 1.87, 0)))


@register()
def jet_bridge(reach: float = 4.0, segments: int = 3) -> Shape:
    tunnel = [brick((0.9 + 0.1 * k, 1.0 + 0.1 * k, reach / segments * 1.05), (0, 2.0, -reach / 2 + (k + 0.5) * reach / segments), (0.7, 0.72, 0.75)) for k in range(segments)]
    ribs = loop(8, lambda i: brick((1.0, 1.05, 0.05), (0, 2.0, -reach / 2 - 0.5 + 0.06 * i), (0.25, 0.25, 0.27)))
    leg = concat_shapes(seg((-0.35, 0, 0), (-0.35, 1.6, 0), 0.08, (0.4, 0.4, 0.4)), seg((0.35, 0, 0), (0.35, 1.6, 0), 0.08, (0.4, 0.4, 0.4)))
    return concat_shapes(*tunnel, ribs, leg)


@register()
def luggage_train(carts: int = 4, curve: float = 0.25) -> Shape:
    shapes, x, z, heading = [], 0.0, 0.0, 0.0
    bags = [(0.6, 0.2, 0.2), (0.2, 0.3, 0.5), (0.2, 0.5, 0.3), (0.5, 0.4, 0.2), (0.3, 0.3, 0.3)]
    for k in range(carts + 1):
        if k == 0:
            unit = concat_shapes(brick((0.9, 0.4, 0.6), (0, 0.35, 0), (0.95, 0.8, 0.1)), brick((0.4, 0.5, 0.5), (-0.1, 0.8, 0), (0.3, 0.35, 0.4)))
        else:
            load = [brick((0.3, 0.22, 0.2), (-0.25 + 0.25 * (b % 3), 0.42 + 0.24 * (b // 3), 0.08 * (-1) ** b), bags[(b + k) % 5]) for b in range(3 + k % 3)]
            unit = concat_shapes(brick((0.9, 0.08, 0.6), (0, 0.26, 0), (0.5, 0.5, 0.52)), *load)
        wheels = [seg((wx, 0.12, wz - 0.04), (wx, 0.12, wz + 0.04), 0.12, (0.1, 0.1, 0.1)) for wx in (-0.3, 0.3) for wz in (-0.28, 0.28)]
        shapes.append(transform_shape(concat_shapes(unit, *wheels), translation_matrix((x, 0, z)) @ rotation_matrix(heading, (0, 1, 0), (0, 0, 0))))
        heading += curve
        x -= 1.15 * math.cos(heading)
        z += 1.15 * math.sin(heading)
    return concat_shapes(*shapes)


@register()
def control_tower(height: float = 7.0) -> Shape:
    shaft = loop(7, lambda i: seg((0, height * i / 7, 0), (0, height * (i + 1) / 7, 0), 0.7 - 0.05 * i, (0.8, 0.8, 0.78)))
    cab = loop(3, lambda i: seg((0, height + 0.3 * i, 0), (0, height + 0.3 * (i + 1), 0), 0.9 + 0.12 * i, (0.25, 0.4, 0.5) if i else (0.6, 0.6, 0.6)))
    roof = seg((0, height + 0.9, 0), (0, height + 1.0, 0), 1.25, (0.6, 0.6, 0.62))
    antenna = [seg((dx, height + 1, 0), (dx, height + 1.6 + dx, 0), 0.03, (0.85, 0.2, 0.2)) for dx in (-0.3, 0.0, 0.4)]
    return concat_shapes(shaft, cab, roof, *antenna)


@register()
def airport() -> Shape:
    apron = brick((20, 0.1, 20), (0, -0.05, -1), (0.45, 0.46, 0.48))
    line = loop(14, lambda i: brick((0.7, 0.02, 0.12), (-7 + i, 0.01, 0), (0.95, 0.8, 0.15)))
    terminal = concat_shapes(brick((18, 3.2, 3), (0, 1.6, -8.5), (0.75, 0.78, 0.82)), loop(12, lambda i: brick((1.2, 1.8, 0.05), (-8.2 + 1.49 * i, 1.9, -6.98), (0.35, 0.55, 0.65))))
    bridge = transform_shape(library_call('jet_bridge', reach=5.6), translation_matrix((3.4, 0.2, -4.0)))
    carts = transform_shape(library_call('luggage_train'), translation_matrix((0, 0, 5)))
    return concat_shapes(apron, line, terminal, bridge, carts, library_call('airplane'), transform_shape(library_call('control_tower'), translation_matrix((-8, 0, -6))))

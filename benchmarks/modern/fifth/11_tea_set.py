"""a porcelain tea set on a round tray: a teapot, four cups and a sugar bowl"""
from helper import *
import math


def revolve(profile, color, steps=3):
    """A solid of revolution about y out of thin discs; the profile is a list of (radius, height)."""
    discs = []
    for (r0, y0), (r1, y1) in zip(profile, profile[1:]):
        for s in range(steps):
            t0, t1 = s / steps, (s + 1) / steps
            radius = r0 + (r1 - r0) * (t0 + t1) / 2
            discs.append(primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': (0, y0 + (y1 - y0) * t0, 0), 'p1': (0, y0 + (y1 - y0) * t1, 0)}, color=color))
    return concat_shapes(*discs)


def tube(points, radius_of, color):
    n = len(points) - 1
    parts = []
    for i in range(n):
        parts.append(primitive_call('cylinder', shape_kwargs={'radius': radius_of(i / n), 'p0': points[i], 'p1': points[i + 1]}, color=color))
        if i > 0:
            joint = primitive_call('sphere', shape_kwargs={'radius': radius_of(i / n)}, color=color)
            parts.append(transform_shape(joint, translation_matrix(points[i])))
    return concat_shapes(*parts)


def cubic(p0, p1, p2, p3, n=10):
    result = []
    for i in range(n + 1):
        t = i / n
        u = 1 - t
        result.append(tuple(u**3 * a + 3 * u**2 * t * b + 3 * u * t**2 * c + t**3 * d for a, b, c, d in zip(p0, p1, p2, p3)))
    return result


@register()
def teapot(scale: float = 1.0, glaze: tuple = (0.88, 0.92, 0.96), trim: tuple = (0.15, 0.3, 0.6)) -> Shape:
    body = revolve([(0.1, 0), (0.22, 0.05), (0.28, 0.14), (0.26, 0.24), (0.16, 0.32), (0.12, 0.34)], glaze)
    lid = revolve([(0.13, 0.34), (0.1, 0.37), (0.03, 0.39)], trim, steps=2)
    knob = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.03}, color=trim), translation_matrix((0, 0.41, 0)))
    spout = tube(cubic((0.24, 0.1, 0), (0.38, 0.1, 0), (0.34, 0.28, 0), (0.46, 0.33, 0)), lambda t: 0.05 - 0.025 * t, glaze)
    handle = tube(cubic((-0.24, 0.26, 0), (-0.48, 0.34, 0), (-0.45, 0.06, 0), (-0.26, 0.1, 0)), lambda t: 0.022, trim)
    pot = concat_shapes(body, lid, knob, spout, handle)
    return transform_shape(pot, scale_matrix(scale, (0, 0, 0)))


@register()
def cup(radius: float = 0.09, fill: float = 0.8, tea: tuple = (0.6, 0.3, 0.1)) -> Shape:
    saucer = revolve([(0.07, 0), (0.15, 0.02)], (0.88, 0.92, 0.96), steps=2)
    wall = revolve([(radius * 0.5, 0.02), (radius * 0.85, 0.06), (radius, 0.12)], (0.88, 0.92, 0.96))
    surface = 0.04 + 0.081 * fill
    liquid = primitive_call('cylinder', shape_kwargs={'radius': radius * 0.92, 'p0': (0, surface - 0.005, 0), 'p1': (0, surface, 0)}, color=tea)
    handle = tube([(radius + 0.035 * math.sin(a), 0.075 + 0.035 * math.cos(a), 0) for a in [math.pi * k / 6 for k in range(7)]], lambda t: 0.008, (0.15, 0.3, 0.6))
    return concat_shapes(saucer, wall, liquid, handle)


@register()
def sugar_bowl(cubes: int = 7) -> Shape:
    bowl = revolve([(0.05, 0), (0.1, 0.05), (0.11, 0.1)], (0.88, 0.92, 0.96))
    lumps = []
    for i in range(cubes):
        ring, k = (0, 0) if i == 0 else (1 + (i - 1) // 6, (i - 1) % 6)
        a = k * math.pi / 3
        lump = primitive_call('cube', shape_kwargs={'scale': (0.035, 0.035, 0.035)}, color=(0.99, 0.98, 0.95))
        lump = transform_shape(lump, rotation_matrix(i * 0.7, (0.3, 1, 0.2), (0, 0, 0)))
        lumps.append(transform_shape(lump, translation_matrix((0.055 * ring * math.cos(a), 0.12 - 0.01 * ring, 0.055 * ring * math.sin(a)))))
    return concat_shapes(bowl, *lumps)


@register()
def tray(radius: float = 0.75, beads: int = 40) -> Shape:
    disc = primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': (0, -0.03, 0), 'p1': (0, 0, 0)}, color=(0.45, 0.25, 0.12))
    def bead(i):
        a = 2 * math.pi * i / beads
        return transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.03}, color=(0.8, 0.65, 0.3)), translation_matrix((radius * math.cos(a), 0, radius * math.sin(a))))
    return concat_shapes(disc, loop(beads, bead))


@register()
def tea_set(cups: int = 4) -> Shape:
    around = []
    for i in range(cups):
        c = transform_shape(library_call('cup', fill=1 - 0.2 * i), translation_matrix((0.5, 0, 0)))
        around.append(transform_shape(c, rotation_matrix(2 * math.pi * (i + 0.5) / cups, (0, 1, 0), (0, 0, 0))))
    pot = transform_shape(library_call('teapot', scale=0.9), translation_matrix((0.02, 0, 0.05)))
    sugar = transform_shape(library_call('sugar_bowl'), translation_matrix((0, 0, -0.5)))
    return concat_shapes(library_call('tray'), pot, sugar, *around)

"""five wind turbines on rolling green hills"""
from helper import *
import numpy as np
import math


def hill_height(x, z):
    """Works for scalars and arrays."""
    return 1.2 * np.sin(0.25 * x) * np.cos(0.3 * z) + 0.5 * np.cos(0.6 * x + 0.2 * z)


@register()
def blade(length: float = 2.6, root: float = 0.22, sections: int = 9, twist: float = 25.0) -> Shape:
    out = []
    step = length / sections
    for i in range(sections):
        t = (i + 0.5) / sections
        chord = root * (1 - 0.75 * t)
        cube = primitive_call('cube', shape_kwargs={'scale': (chord, step * 1.05, 0.04 * (1 - 0.6 * t))}, color=(0.95, 0.95, 0.96))
        cube = transform_shape(cube, rotation_matrix(math.radians(twist * (1 - t)), (0, 1, 0), (0, 0, 0)))
        out.append(transform_shape(cube, translation_matrix((0, 0.2 + step * (i + 0.5), 0))))
    return concat_shapes(*out)


@register()
def rotor(blades: int = 3, phase: float = 0.0, length: float = 2.6) -> Shape:
    b = library_call('blade', length=length)
    spinner = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.22}, color=(0.85, 0.85, 0.87)), scale_matrix((1, 1, 1.4), (0, 0, 0)))
    return concat_shapes(spinner, loop(blades, lambda i: transform_shape(b, rotation_matrix(phase + 2 * math.pi * i / blades, (0, 0, 1), (0, 0, 0)))))


@register()
def turbine(height: float = 6.0, yaw: float = 0.0, phase: float = 0.0) -> Shape:
    n = 6
    radii = np.linspace(0.28, 0.14, n)
    mast = loop(n, lambda i: primitive_call('cylinder', shape_kwargs={'radius': float(radii[i]), 'p0': (0, height * i / n, 0), 'p1': (0, height * (i + 1) / n, 0)},
                                            color=(0.93, 0.93, 0.94) if i != 1 else (0.8, 0.25, 0.2)))
    nacelle = transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.4, 0.4, 1.1)}, color=(0.88, 0.88, 0.9)), translation_matrix((0, height + 0.15, -0.2)))
    spin = transform_shape(library_call('rotor', phase=phase, length=height * 0.42), translation_matrix((0, height + 0.15, 0.5)))
    head = transform_shape(concat_shapes(nacelle, spin), rotation_matrix(yaw, (0, 1, 0), (0, 0, 0)))
    return concat_shapes(mast, head)


@register()
def hills(size: int = 20, cell: float = 1.0) -> Shape:
    axis = (np.arange(size) - (size - 1) / 2) * cell
    x, z = np.meshgrid(axis, axis, indexing='ij')
    y = hill_height(x, z)
    low, high = y.min(), y.max()
    green = (y - low) / (high - low)
    columns = []
    for i in range(size):
        for j in range(size):
            g = float(green[i, j])
            depth = float(y[i, j] - low) + 0.5
            c = primitive_call('cube', shape_kwargs={'scale': (cell, depth, cell)}, color=(0.25 + 0.3 * g, 0.5 + 0.2 * g, 0.2))
            columns.append(transform_shape(c, translation_matrix((x[i, j], y[i, j] - depth / 2, z[i, j]))))
    return concat_shapes(*columns)


@register()
def sheep_flock(count: int = 8, seed: int = 21) -> Shape:
    rng = np.random.default_rng(seed)
    positions = rng.uniform(-7, 7, size=(count, 2))
    def sheep(i: int) -> Shape:
        x, z = positions[i]
        body = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.3}, color=(0.97, 0.96, 0.92)), scale_matrix((1.3, 1, 1), (0, 0, 0)))
        head = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.14}, color=(0.15, 0.13, 0.12)), translation_matrix((0.4, 0.12, 0)))
        legs = [primitive_call('cylinder', shape_kwargs={'radius': 0.04, 'p0': (lx, -0.5, lz), 'p1': (lx, -0.15, lz)}, color=(0.15, 0.13, 0.12))
                for lx in (-0.2, 0.2) for lz in (-0.12, 0.12)]
        one = transform_shape(concat_shapes(body, head, *legs), rotation_matrix(i * 1.9, (0, 1, 0), (0, 0, 0)))
        return transform_shape(one, translation_matrix((x, hill_height(x, z) + 0.55, z)))
    return loop(count, sheep)


@register()
def wind_farm(count: int = 5, radius: float = 6.5) -> Shape:
    turbines = []
    for i in range(count):
        a = 2 * math.pi * i / count + 0.3
        x, z = radius * math.cos(a), radius * math.sin(a) * 0.8
        t = library_call('turbine', height=5.5 + 0.5 * (i % 3), yaw=0.15 * i, phase=0.7 * i)
        turbines.append(transform_shape(t, translation_matrix((x, hill_height(x, z) - 0.2, z))))
    return concat_shapes(library_call('hills'), library_call('sheep_flock'), *turbines)

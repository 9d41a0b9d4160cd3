"""a voxel island with beaches, grass, snow and palm trees, Minecraft style"""
from helper import *
import numpy as np

N = 16
WATER_LEVEL = 2


def heightmap(n: int = N, seed: int = 1) -> np.ndarray:
    rng = np.random.default_rng(seed)
    noise = np.zeros((n, n))
    for octave, amp in ((4, 1.0), (8, 0.5)):
        coarse = rng.random((octave, octave))
        idx = np.linspace(0, octave - 1, n)
        lo = np.floor(idx).astype(int)
        hi = np.minimum(lo + 1, octave - 1)
        f = idx - lo
        rows = coarse[lo] * (1 - f)[:, None] + coarse[hi] * f[:, None]
        noise += amp * (rows[:, lo] * (1 - f) + rows[:, hi] * f)
    yy, xx = np.mgrid[-1:1:n * 1j, -1:1:n * 1j]
    island = np.clip(1.1 - np.hypot(xx, yy), 0, 1)
    return np.rint(noise * island * 7).astype(int)


def material(y: int) -> tuple[float, float, float]:
    match y:
        case _ if y <= WATER_LEVEL:
            return (0.87, 0.8, 0.55)
        case 3 | 4:
            return (0.35, 0.65, 0.25)
        case 5 | 6:
            return (0.5, 0.48, 0.45)
        case _:
            return (0.97, 0.97, 1.0)


@register()
def column(height: int) -> Shape:
    return loop(height, lambda y: transform_shape(
        primitive_call('cube', shape_kwargs={'scale': (1, 1, 1)}, color=material(y)), translation_matrix((0, y + 0.5, 0))))


@register()
def palm(height: int = 3) -> Shape:
    trunk = loop(height, lambda y: transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.3, 1, 0.3)}, color=(0.5, 0.35, 0.2)), translation_matrix((0.05 * y, y + 0.5, 0))))
    leaves = [transform_shape(primitive_call('cube', shape_kwargs={'scale': s}, color=(0.15, 0.55, 0.2)), translation_matrix((0, height, 0)))
              for s in ((2.4, 0.2, 0.4), (0.4, 0.2, 2.4), (0.8, 0.5, 0.8))]
    return concat_shapes(trunk, *leaves)


@register()
def island(seed: int = 1) -> Shape:
    h = heightmap(seed=seed)
    out = []
    for (z, x), y in np.ndenumerate(h):
        if y > 0:
            out.append(transform_shape(library_call('column', height=int(y)), translation_matrix((x - N / 2, 0, z - N / 2))))
    spots = np.argwhere(h == 3)[::5]
    for z, x in spots:
        out.append(transform_shape(library_call('palm'), translation_matrix((x - N / 2, 3, z - N / 2))))
    return concat_shapes(*out)


@register()
def voxel_island() -> Shape:
    sea = transform_shape(primitive_call('cube', shape_kwargs={'scale': (N + 8, WATER_LEVEL, N + 8)}, color=(0.2, 0.5, 0.8)), translation_matrix((-0.5, WATER_LEVEL / 2 - 0.2, -0.5)))
    return concat_shapes(sea, library_call('island'))

"""
vines on a trellis, placed by value noise and a parallel transport frame
"""
from helper import *
import math
from functools import cache
from dataclasses import dataclass


@dataclass(frozen=True)
class Vec3:
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0

    def __add__(self, o): return Vec3(self.x + o.x, self.y + o.y, self.z + o.z)
    def __sub__(self, o): return Vec3(self.x - o.x, self.y - o.y, self.z - o.z)
    def __mul__(self, k): return Vec3(self.x * k, self.y * k, self.z * k)
    __rmul__ = __mul__
    def __matmul__(self, o): return self.x * o.x + self.y * o.y + self.z * o.z
    def __xor__(self, o): return Vec3(self.y * o.z - self.z * o.y, self.z * o.x - self.x * o.z, self.x * o.y - self.y * o.x)
    def __abs__(self): return math.sqrt(self @ self)
    def __iter__(self): yield from (self.x, self.y, self.z)
    @property
    def unit(self): return self * (1 / (abs(self) or 1.0))


@cache
def lattice(i: int, j: int) -> float:
    n = (i * 374761393 + j * 668265263) & 0xFFFFFFFF
    n = ((n ^ (n >> 13)) * 1274126177) & 0xFFFFFFFF
    return (n & 0xFFFF) / 0xFFFF


def smooth(t: float) -> float:
    return t * t * (3 - 2 * t)


def noise(x: float, y: float) -> float:
    i, j = math.floor(x), math.floor(y)
    u, v = smooth(x - i), smooth(y - j)
    top = lattice(i, j) * (1 - u) + lattice(i + 1, j) * u
    bottom = lattice(i, j + 1) * (1 - u) + lattice(i + 1, j + 1) * u
    return top * (1 - v) + bottom * v


def path(seed: float, n: int, height: float):
    here = Vec3(seed, 0, 0)
    for k in range(n):
        yield here
        sway = (noise(seed * 3.1, k * 0.5) - 0.5) * 0.6
        here += Vec3(sway, height / n, 0.15 * math.cos(k))


@register()
def vine(seed: float = 0.0, pieces: int = 12, height: float = 3.0) -> Shape:
    points = list(path(seed, pieces + 1, height))
    parts = []
    side = Vec3(0, 0, 1)
    for k, (a, b) in enumerate(zip(points, points[1:])):
        tangent = (b - a).unit
        side = (side - tangent * (side @ tangent)).unit
        across = tangent ^ side
        parts.append(primitive_call('cylinder', color=(0.3, 0.45, 0.15), shape_kwargs={'radius': 0.04, 'p0': tuple(a), 'p1': tuple(b)}))
        tip = b + 0.2 * (side if k % 2 else across)
        leaf = primitive_call('sphere', color=(0.2, 0.5 + 0.3 * noise(k, seed), 0.2), shape_kwargs={'radius': 0.09})
        parts.append(transform_shape(leaf, translation_matrix(tuple(tip))))
    return concat_shapes(*parts)


@register()
def trellis(width: float = 4.0, height: float = 3.0, n: int = 6) -> Shape:
    bars = [primitive_call('cylinder', color=(0.6, 0.45, 0.3), shape_kwargs={'radius': 0.03, 'p0': (-width / 2 + i * width / (n - 1), 0, -0.1), 'p1': (-width / 2 + i * width / (n - 1), height, -0.1)}) for i in range(n)]
    rails = [primitive_call('cylinder', color=(0.6, 0.45, 0.3), shape_kwargs={'radius': 0.03, 'p0': (-width / 2, j * height / (n - 1), -0.12), 'p1': (width / 2, j * height / (n - 1), -0.12)}) for j in range(n)]
    return concat_shapes(*bars, *rails)


@register()
def garden_wall() -> Shape:
    vines = [library_call('vine', seed=x, pieces=8 + 2 * i) for i, x in enumerate((-1.6, -0.5, 0.4, 1.5))]
    wall = transform_shape(primitive_call('cube', color=(0.75, 0.6, 0.5), shape_kwargs={'scale': (5, 3.4, 0.2)}), translation_matrix((0, 1.6, -0.4)))
    return concat_shapes(wall, library_call('trellis'), *vines)

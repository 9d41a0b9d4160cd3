"""Gradient noise as three packages compute it: ``noise``, ``opensimplex`` and ``perlin_noise``.

The numbers are those of the packages, so that a terrain has the same hills: ``noise`` 1.2 computes with 32 bits, and
reads its tables by indices that may run past them into the next one; ``opensimplex`` 0.4 is Spencer's noise of 2014,
whose lattice points the package finds by more cases.
"""

from __future__ import annotations

import itertools
import math
import random
from collections.abc import Callable, Mapping
from functools import lru_cache, partial
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.interpreter.transpile.evaluation import MAX_ITEMS, UnsupportedPython
from scenelang.interpreter.transpile.evaluation.objects import HostObject, Native

Floats = npt.NDArray[np.float64]
_MAX_OCTAVES = 64  # of one call, each as long as a call without octaves

# --- noise ------------------------------------------------------------------------------------------------------------

# Perlin's permutation, as the package has it.
_SHUFFLED = (
    "151 160 137 91 90 15 131 13 201 95 96 53 194 233 7 225 140 36 103 30 69 142 8 99 37 240 21 10 23 190 6 148 247 "
    "120 234 75 0 26 197 62 94 252 219 203 117 35 11 32 57 177 33 88 237 149 56 87 174 20 125 136 171 168 68 175 74 "
    "165 71 134 139 48 27 166 77 146 158 231 83 111 229 122 60 211 133 230 220 105 92 41 55 46 245 40 244 102 143 54 "
    "65 25 63 161 1 216 80 73 209 76 132 187 208 89 18 169 200 196 135 130 116 188 159 86 164 100 109 198 173 186 3 "
    "64 52 217 226 250 124 123 5 202 38 147 118 126 255 82 85 212 207 206 59 227 47 16 58 17 182 189 28 42 223 183 "
    "170 213 119 248 152 2 44 154 163 70 221 153 101 155 167 43 172 9 129 22 39 253 19 98 108 110 79 113 224 232 178 "
    "185 112 104 218 246 97 228 251 34 242 193 238 210 144 12 191 179 162 241 81 51 145 235 249 14 239 107 49 192 "
    "214 31 181 199 106 157 184 84 204 176 115 121 50 45 127 4 150 254 138 236 205 93 222 114 67 29 24 72 243 141 "
    "128 195 78 66 215 61 156 180"
)
_PERMUTATION = [int(each) for each in _SHUFFLED.split()] * 2
_EDGES = (
    (1, 1, 0), (-1, 1, 0), (1, -1, 0), (-1, -1, 0), (1, 0, 1), (-1, 0, 1), (1, 0, -1), (-1, 0, -1),
    (0, 1, 1), (0, -1, 1), (0, 1, -1), (0, -1, -1), (1, 0, -1), (-1, 0, -1), (0, -1, 1), (0, 1, 1),
)  # fmt: skip
_F = np.float32


def _permuted(index: int) -> int:
    if not 0 <= index < len(_PERMUTATION):
        raise UnsupportedPython("with this `base`, the package `noise` reads past the end of its table", "use `base=0`")
    return _PERMUTATION[index]


def _eased(t: Any) -> Any:
    return t * t * t * (t * (t * 6 - 15) + 10)


def _between(t: Any, a: Any, b: Any) -> Any:
    return a + t * (b - a)


def _cell(value: Any, repeat: Any, base: int) -> tuple[int, int]:
    """Return the indices of the two lattice points beside a coordinate."""
    first = int(np.floor(np.fmod(value, repeat)))
    following = int(np.fmod(_F(first + 1), repeat))
    return (first & 255) + base, (following & 255) + base


def _along(hashed: int, *offsets: Any) -> Any:
    return sum((part * offset for part, offset in zip(_EDGES[hashed & 15], offsets)), _F(0))


def _perlin(point: list[Any], repeats: list[Any], base: int) -> Any:
    """Return Perlin's noise in one to three dimensions."""
    places = [np.floor(point[0])] if len(point) == 1 else point
    cells = [_cell(value, repeat, base) for value, repeat in zip(places, repeats)]
    rest = [value - np.floor(value) for value in point]
    curves = [_eased(each) for each in rest]
    if len(point) == 1:
        slopes = [_F(-1) if h & 8 else _F((h & 7) + 1) for h in map(_permuted, cells[0])]
        return _between(curves[0], slopes[0] * rest[0], slopes[1] * (rest[0] - 1)) * _F(0.4)

    def corner(places: tuple[int, ...]) -> Any:
        hashed = _permuted(cells[0][places[0]])
        for axis in range(1, len(point)):
            hashed = _permuted(hashed + cells[axis][places[axis]])
        hashed = _permuted(hashed) if len(point) == 2 else hashed
        return _along(hashed, *(value - place for value, place in zip(rest, places)))

    def interpolated(axis: int, places: tuple[int, ...]) -> Any:
        if axis < 0:
            return corner(places)
        return _between(curves[axis], *(interpolated(axis - 1, (place, *places)) for place in (0, 1)))

    return interpolated(len(point) - 1, ())


def _simplex(*point: Any) -> Any:
    """Return Perlin's simplex noise in two or three dimensions."""
    n = len(point)
    skew, unskew = (_F(0.3660254037844386), _F(0.21132486540518713)) if n == 2 else (_F(1 / 3), _F(1 / 6))
    s = sum(point[1:], point[0]) * skew
    corner = [np.floor(value + s) for value in point]
    t = sum(corner[1:], corner[0]) * unskew
    first = [value - (place - t) for value, place in zip(point, corner)]
    total = _F(0)
    for step, offset in enumerate(_steps(first)):
        around = [value - o + step * unskew for value, o in zip(first, offset)]
        if step == n:
            around = [value - _F(1) + n * unskew for value in first]
        reach = _F(0.5 if n == 2 else 0.6)
        for each in around:
            reach = reach - each * each
        if reach > 0:
            hashed = 0
            for place, o in reversed([*zip(corner, offset)]):
                hashed = _permuted((int(place) & 255) + o + hashed)
            total = total + reach * reach * reach * reach * _along(hashed % 12, *around)
    return total * _F(70 if n == 2 else 32)


def _steps(first: list[Any]) -> list[tuple[int, ...]]:
    """Return the corners of a simplex, from the origin along the longest coordinates."""
    n = len(first)
    middle: list[tuple[int, ...]]
    if n == 2:
        middle = [(1, 0) if first[0] > first[1] else (0, 1)]
    else:
        x, y, z = first
        if x >= y:
            middle = [(1, 0, 0) if y >= z or x >= z else (0, 0, 1), (1, 1, 0) if y >= z else (1, 0, 1)]
        else:
            middle = [(0, 0, 1) if y < z else (0, 1, 0), (0, 1, 1) if y < z or x < z else (1, 1, 0)]
    return [(0,) * n, *middle, (1,) * n]


def _layers(octaves: int, persistence: float, lacunarity: float) -> list[tuple[Any, Any]]:
    if octaves <= 0:
        raise ValueError("Expected octaves value > 0")
    if octaves > _MAX_OCTAVES:
        raise UnsupportedPython("these octaves are too many")
    layers, frequency, amplitude = [], _F(1), _F(1)
    for _ in range(octaves):
        layers.append((frequency, amplitude))
        frequency, amplitude = frequency * _F(lacunarity), amplitude * _F(persistence)
    return layers


def _summed(layers: list[tuple[Any, Any]], value: Callable[[Any], Any]) -> float:
    total, most = _F(0), _F(0)
    for frequency, amplitude in layers:
        total, most = total + value(frequency) * amplitude, most + amplitude
    return float(total / most) if len(layers) > 1 else float(total)


def pnoise1(
    x: float, octaves: int = 1, persistence: float = 0.5, lacunarity: float = 2.0, repeat: int = 1024, base: int = 0
) -> float:
    """Return Perlin noise on a line."""
    layers = _layers(octaves, persistence, lacunarity)
    return _summed(layers, lambda k: _perlin([_F(x) * k], [_F(int(repeat * k))], base))


def pnoise2(
    x: float, y: float, octaves: int = 1, persistence: float = 0.5, lacunarity: float = 2.0,
    repeatx: float = 1024, repeaty: float = 1024, base: int = 0,
) -> float:  # fmt: skip
    """Return Perlin noise on a plane."""
    layers = _layers(octaves, persistence, lacunarity)
    return _summed(layers, lambda k: _perlin([_F(x) * k, _F(y) * k], [_F(repeatx) * k, _F(repeaty) * k], base))


def pnoise3(
    x: float, y: float, z: float, octaves: int = 1, persistence: float = 0.5, lacunarity: float = 2.0,
    repeatx: int = 1024, repeaty: int = 1024, repeatz: int = 1024, base: int = 0,
) -> float:  # fmt: skip
    """Return Perlin noise in space."""
    repeats = (repeatx, repeaty, repeatz)
    layers = _layers(octaves, persistence, lacunarity)
    return _summed(
        layers, lambda k: _perlin([_F(each) * k for each in (x, y, z)], [_F(int(each * k)) for each in repeats], base)
    )


def snoise2(
    x: float, y: float, octaves: int = 1, persistence: float = 0.5, lacunarity: float = 2.0,
    repeatx: float | None = None, repeaty: float | None = None, base: float = 0.0,
) -> float:  # fmt: skip
    """Return simplex noise on a plane."""
    if repeatx is not None or repeaty is not None:
        raise UnsupportedPython("`snoise2` that repeats is not supported", "use `pnoise2`, or leave out `repeatx`")
    z = _F(base)
    layers = _layers(octaves, persistence, lacunarity)
    return _summed(layers, lambda k: _simplex(_F(x) * k + z, _F(y) * k + z))


def snoise3(x: float, y: float, z: float, octaves: int = 1, persistence: float = 0.5, lacunarity: float = 2.0) -> float:
    """Return simplex noise in space."""
    layers = _layers(octaves, persistence, lacunarity)
    return _summed(layers, lambda k: _simplex(_F(x) * k, _F(y) * k, _F(z) * k))


# --- opensimplex ------------------------------------------------------------------------------------------------------


_GRADIENTS: dict[int, list[tuple[int, ...]]] = {
    2: [(5, 2), (2, 5), (-5, 2), (-2, 5), (5, -2), (2, -5), (-5, -2), (-2, -5)],
    3: [(a * x, b * y, c * z) for c, b, a in itertools.product((1, -1), repeat=3)
        for x, y, z in ((-11, 4, 4), (-4, 11, 4), (-4, 4, 11))],
}  # fmt: skip
_DIVISORS = {2: 47.0, 3: 103.0}
_STEPS = [*itertools.product(range(-1, 3), repeat=2)]  # to all lattice points that may be in reach on a plane


def _corners(inside: list[float]) -> list[tuple[int, ...]]:
    """Return the lattice points of which the package adds the contributions in space: those of the solid around a
    point, and two more, which leaves out some that are hardly in reach.
    """
    total = sum(inside)
    if total >= 2:
        return [tuple(1 - each for each in row) for row in _corners([1 - each for each in inside])]
    units = [(1, 0, 0), (0, 1, 0), (0, 0, 1)]
    if total <= 1:
        a, b, c = sorted(range(3), key=lambda axis: -inside[axis])
        pairs = [(a, b), (a, c)] if 1 - total > inside[b] else []
        more = [tuple(u - v for u, v in zip(units[i], units[j])) for i, j in pairs]
        both = tuple(u + v for u, v in zip(units[a], units[b]))
        return [(0, 0, 0), *units, *(more or [both, tuple(u - v for u, v in zip(both, units[c]))])]
    pairs_of = [tuple(1 - each for each in unit) for unit in units]
    sums = [total - each - 1 for each in inside]  # above 0 where the pair is nearer than the axis
    near = sorted(range(3), key=lambda axis: -abs(sums[axis]))[:2]
    (other,) = {0, 1, 2} - {*near}
    if all(sums[axis] > 0 for axis in near):
        extra = [(1, 1, 1), tuple(2 * each for each in units[other])]
    elif all(sums[axis] <= 0 for axis in near):
        extra = [(0, 0, 0), tuple(1 - 2 * each for each in units[other])]
    else:
        single, pair = sorted(near, key=lambda axis: sums[axis])
        extra = [tuple(1 - 2 * each for each in units[pair]), tuple(2 * each for each in units[single])]
    return [*units, *pairs_of, *extra]


class OpenSimplex(HostObject):
    """Noise of one seed."""

    python_name = "OpenSimplex"
    shown = frozenset(["noise2", "noise3", "noise2array", "noise3array", "get_seed"])

    def __init__(self, seed: int) -> None:
        self._seed = seed
        state = _as_64_bits(seed)
        for _ in range(3):
            state = _as_64_bits(state * 6364136223846793005 + 1442695040888963407)
        source = list(range(256))
        shuffled = [0] * 256
        for i in range(255, -1, -1):
            state = _as_64_bits(state * 6364136223846793005 + 1442695040888963407)
            place = (state + 31) % (i + 1)
            shuffled[i] = source[place]
            source[place] = source[i]
        self._shuffled = shuffled

    def get_seed(self) -> int:
        """Return the seed."""
        return self._seed

    def noise2(self, x: float, y: float) -> float:
        """Return noise on a plane."""
        return self._noise(x, y)

    def noise3(self, x: float, y: float, z: float) -> float:
        """Return noise in space."""
        return self._noise(x, y, z)

    def noise2array(self, x: Floats, y: Floats) -> Floats:
        """Return the noise of a grid, by rows."""
        return self._grid(x, y)

    def noise3array(self, x: Floats, y: Floats, z: Floats) -> Floats:
        """Return the noise of a grid, by layers."""
        return self._grid(x, y, z)

    def _grid(self, *axes: Floats) -> Floats:
        count = math.prod(each.size for each in axes)
        if count > MAX_ITEMS // 10:
            raise UnsupportedPython("this grid has too many points")
        values = [self._noise(*reversed(point)) for point in itertools.product(*reversed(axes))]
        return np.array(values).reshape([each.size for each in reversed(axes)])

    def _noise(self, *point: float) -> float:
        n = len(point)
        stretch, squish = (1 / math.sqrt(n + 1) - 1) / n, (math.sqrt(n + 1) - 1) / n
        skewed = [float(value) + sum(point) * stretch for value in point]
        base = [math.floor(value) for value in skewed]
        total = 0.0
        for step in _STEPS if n == 2 else _corners([value - place for value, place in zip(skewed, base)]):
            corner = [place + each for place, each in zip(base, step)]
            shift = sum(corner) * squish
            offsets = [value - place - shift for value, place in zip(point, corner)]
            reach = 2 - sum(each * each for each in offsets)
            if reach > 0:
                hashed = 0
                for place in corner:
                    hashed = self._shuffled[(hashed + place) & 255]
                slope = _GRADIENTS[n][(hashed & 0x0E) >> 1 if n == 2 else hashed % 24]
                total += reach**4 * sum(part * each for part, each in zip(slope, offsets))
        return total / _DIVISORS[n]


def _as_64_bits(value: int) -> int:
    value &= 2**64 - 1
    return value - 2**64 if value >> 63 else value


class SimplexOfModule(HostObject):
    """Noise of the functions of the module ``opensimplex``, whose seed the program may set."""

    def __init__(self) -> None:
        self.noise = OpenSimplex(3)

    def seed(self, seed: int = 3) -> None:
        """Seed the functions of the module."""
        self.noise = OpenSimplex(seed)

    def call(self, name: str, *arguments: Any, **named: Any) -> Any:
        """Call a function of the module."""
        return getattr(self.noise, name)(*arguments, **named)


def open_simplex() -> dict[str, Any]:
    """Return the names of the module ``opensimplex``."""
    module = SimplexOfModule()
    names = {
        name: Native(f"opensimplex.{name}", partial(module.call, name), attributes={"module": module})
        for name in OpenSimplex.shown
    }
    names["seed"] = Native("opensimplex.seed", module.seed, attributes={"module": module})
    names["OpenSimplex"] = Native("opensimplex.OpenSimplex", OpenSimplex, OpenSimplex)
    return names


# --- perlin_noise -----------------------------------------------------------------------------------------------------


class PerlinNoise(HostObject):
    """Noise of the package ``perlin_noise``, whose lattice has random slopes."""

    python_name = "PerlinNoise"
    shown = frozenset(["noise", "octaves", "seed"])

    def __init__(self, octaves: float = 1, seed: int | None = None) -> None:
        if octaves <= 0:
            raise ValueError("octaves expected to be positive number")
        if not seed:
            raise UnsupportedPython("`PerlinNoise` without a seed gives other numbers in every run", "write `seed=1`")
        self.octaves, self.seed = octaves, seed

    def __call__(self, coordinates: Any, tile_sizes: Any = None) -> float:
        return self.noise(coordinates, tile_sizes)

    def noise(self, coordinates: Any, tile_sizes: Any = None) -> float:
        """Return the noise at a point."""
        if not isinstance(coordinates, (int, float, list, tuple)):
            raise TypeError("coordinates must be int, float or iterable")
        if tile_sizes is not None:
            raise UnsupportedPython("tiles of `PerlinNoise` are not supported", "leave out `tile_sizes`")
        given = [coordinates] if isinstance(coordinates, (int, float)) else coordinates
        if len(given) > 4:
            raise UnsupportedPython("noise of more than four dimensions is not supported")
        point = [each * self.octaves for each in given]
        total = 0.0
        for corner in itertools.product(*((math.floor(each), math.floor(each) + 1) for each in point)):
            offsets = [value - place for value, place in zip(point, corner)]
            slopes = _slopes(self.seed * _hashed(corner), len(corner))
            weight = math.prod(_smooth(1 - abs(each)) for each in offsets)
            total += weight * sum(slope * offset for slope, offset in zip(slopes, offsets))
        return total


def _hashed(corner: tuple[int, ...]) -> int:
    return max(1, int(abs(sum(10**axis * place for axis, place in enumerate(corner)) + 1)))


def _smooth(t: float) -> float:
    return 6 * t**5 - 15 * t**4 + 10 * t**3


@lru_cache(maxsize=10_000)
def _slopes(seed: int, n: int) -> tuple[float, ...]:
    stream = random.Random(seed)
    return tuple(stream.uniform(-1, 1) for _ in range(n))


NOISE: Mapping[str, Callable[[], dict[str, Any]]] = MappingProxyType({
    "noise": lambda: {
        each.__name__: Native(f"noise.{each.__name__}", each) for each in (pnoise1, pnoise2, pnoise3, snoise2, snoise3)
    },
    "opensimplex": open_simplex,
    "perlin_noise": lambda: {"PerlinNoise": Native("perlin_noise.PerlinNoise", PerlinNoise, PerlinNoise)},
})  # fmt: skip


def noise_names(path: str) -> dict[str, Any]:
    """Return the names of a package of noise."""
    return NOISE[path]()

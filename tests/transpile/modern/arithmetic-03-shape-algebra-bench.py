"""A park bench made with a small algebra of parts: + joins, * repeats, >> moves, | mirrors."""
from helper import *


class Part:
    def __init__(self, *primitives):
        self.shape = concat_shapes(*primitives)

    def __add__(self, other: "Part") -> "Part":
        return Part(self.shape, other.shape)

    def __radd__(self, other):
        # lets sum() start at 0
        return self if other == 0 else other + self

    def __rshift__(self, offset) -> "Part":
        return Part(transform_shape(self.shape, translation_matrix(offset)))

    def __or__(self, normal) -> "Part":
        return self + Part(transform_shape(self.shape, reflection_matrix((0, 0, 0), normal)))

    def __mul__(self, spec) -> "Part":
        n, step = spec
        return sum((self >> tuple(k * s for s in step) for k in range(n)), start=Part())

    def __xor__(self, angle: float) -> "Part":
        return Part(transform_shape(self.shape, rotation_matrix(angle, (1, 0, 0), (0, 0, 0))))

    def __len__(self) -> int:
        return len(self.shape)

    def __bool__(self) -> bool:
        return len(self) > 0


def cube(w, h, d, color=(0.55, 0.35, 0.2)) -> Part:
    return Part(primitive_call('cube', color=color, shape_kwargs={'scale': (w, h, d)}))


def rod(p, q, r=0.05, color=(0.15, 0.15, 0.17)) -> Part:
    return Part(primitive_call('cylinder', color=color, shape_kwargs={'radius': r, 'p0': p, 'p1': q}))


@register("bench")
def bench(length: float = 3.0) -> Shape:
    slat = cube(length, 0.05, 0.12)
    seat = (slat * (5, (0, 0, 0.15))) >> (0, 0.8, -0.3)
    back = ((slat * (3, (0, 0, 0.16))) ^ -1.4) >> (0, 1.05, -0.4)
    leg = sum([rod((0, 0, -0.35), (0, 0.8, -0.35)), rod((0, 0, 0.35), (0, 0.8, 0.35)), rod((0, 0.78, -0.4), (0, 0.78, 0.4))])
    legs = (leg >> (length / 2 - 0.3, 0, 0)) | (1, 0, 0)
    whole = seat + back + legs
    return whole.shape if whole else Part(rod((0, 0, 0), (0, 1, 0)).shape).shape


@register("park with benches round a fountain")
def park() -> Shape:
    empty = Part()
    fountain = empty + rod((0, 0, 0), (0, 0.3, 0), 1.0, (0.6, 0.6, 0.65)) + rod((0, 0.3, 0), (0, 1.2, 0), 0.2, (0.6, 0.6, 0.65))
    jets = Part(*[primitive_call('cylinder', color=(0.6, 0.8, 1), shape_kwargs={'radius': 0.03, 'p0': (0, 1.2, 0), 'p1': (math.cos(a), 1.6, math.sin(a))}) for a in np.linspace(0, 2 * math.pi, 8, endpoint=False)])
    ring = loop(4, lambda i: transform_shape(transform_shape(library_call('bench'), translation_matrix((0, 0, -3.2))), rotation_matrix(i * math.pi / 2, (0, 1, 0), (0, 0, 0))))
    return concat_shapes((fountain + jets).shape, ring)

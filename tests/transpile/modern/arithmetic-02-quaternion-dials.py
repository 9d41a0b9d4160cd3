import math
from helper import *

"""
a wall of dials turned by quaternions
"""

class Quaternion:
    __slots__ = ("w", "x", "y", "z")

    def __init__(self, w=1.0, x=0.0, y=0.0, z=0.0):
        self.w, self.x, self.y, self.z = w, x, y, z

    @classmethod
    def about(cls, axis: str, angle: float) -> "Quaternion":
        s = math.sin(angle / 2)
        return cls(math.cos(angle / 2), **{axis: s})

    def __mul__(self, other):
        if isinstance(other, (int, float)):
            return Quaternion(self.w * other, self.x * other, self.y * other, self.z * other)
        a, b = self, other
        return Quaternion(
            a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
            a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
            a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
            a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w,
        )

    def __invert__(self):
        return Quaternion(self.w, -self.x, -self.y, -self.z)

    def __pow__(self, n: int):
        result = Quaternion()
        for _ in range(abs(n)):
            result = result * self
        return result if n >= 0 else ~result

    def __imul__(self, other):
        self.w, self.x, self.y, self.z = (lambda q: (q.w, q.x, q.y, q.z))(self * other)
        return self

    def rotate(self, p):
        q = self * Quaternion(0, *p) * ~self
        return (q.x, q.y, q.z)

    def __repr__(self):
        return f"Quaternion({self.w:.3f}, {self.x:.3f}, {self.y:.3f}, {self.z:.3f})"

@register()
def dial(turn: Quaternion, color: tuple) -> Shape:
    face = primitive_call('cylinder', color=(0.95, 0.95, 0.95), shape_kwargs={'radius': 0.9, 'p0': (0, 0, -0.1), 'p1': (0, 0, -0.05)})
    tip = turn.rotate((0, 0.8, 0))
    hand = primitive_call('cylinder', color=color, shape_kwargs={'radius': 0.04, 'p0': (0, 0, 0), 'p1': tip})
    knob = transform_shape(primitive_call('sphere', color=color, shape_kwargs={'radius': 0.08}), translation_matrix(tip))
    return concat_shapes(face, hand, knob)

@register()
def dial_wall() -> Shape:
    step = Quaternion.about("z", -math.pi / 6)
    lean = Quaternion.about("x", 0.4)
    running = Quaternion()
    shapes = []
    for i in range(12):
        row, col = divmod(i, 4)
        turn = (step ** i, lean * step ** -i, running)[row]
        running *= step * lean
        print(repr(turn))
        shapes.append(transform_shape(library_call('dial', turn=turn, color=(0.2 + 0.25 * row, 0.3, 0.8 - 0.25 * row)), translation_matrix((2 * col, -2 * row, 0))))
    return concat_shapes(*shapes)

"""`mathutils` for the evaluator of Python: vectors, colors, matrices, quaternions and Euler angles.

Numbers are floats of 64 bits, where Blender's have 32.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.interpreter.transpile.evaluation import UnsupportedPython, words
from scenelang.interpreter.transpile.evaluation.objects import MISSING, HostObject, Module, Native

FloatArray = npt.NDArray[np.float64]
_MAX_LENGTH = 100
_AXES = "xyzw"


class Numbers(HostObject):
    """Fixed number of floats that a program can read and assign one by one."""

    python_name = "bpy_prop_array"
    names = ""
    shown = frozenset(("copy", "foreach_get", "foreach_set"))

    def __init__(self, values: Iterable[Any] = ()) -> None:
        self.values = [float(value) for value in values]
        if len(self.values) > _MAX_LENGTH:
            raise UnsupportedPython("this vector is too long")

    def read(self, name: str) -> Any:
        if name in self.shown:
            return super().read(name)
        if name and all(letter in self.names for letter in name):
            places = [self.names.index(letter) for letter in name]
            if max(places) < len(self.values):
                return self.values[places[0]] if len(name) == 1 else VectorValue(self.values[i] for i in places)
        return MISSING

    def assign(self, name: str, value: Any) -> None:
        if name and all(letter in self.names for letter in name):
            given = [value] if len(name) == 1 else [*value]
            for letter, number in zip(name, given, strict=True):
                self.values[self.names.index(letter)] = float(number)
            return
        super().assign(name, value)

    def set(self, values: Any) -> None:
        """Replace all numbers; a sequence of another length is an error, as in Blender."""
        given = [float(value) for value in values]
        if len(given) != len(self.values):
            raise ValueError(f"sequences of dimension 0 should contain {len(self.values)} items, not {len(given)}")
        self.values[:] = given

    def copy(self) -> Any:
        """Return a copy."""
        return type(self)(self.values)

    def array(self) -> FloatArray:
        """Return the numbers as an array."""
        return np.array(self.values)

    def __len__(self) -> int:
        return len(self.values)

    def __iter__(self) -> Iterator[float]:
        return iter(list(self.values))

    def __getitem__(self, index: Any) -> Any:
        return tuple(self.values[index]) if isinstance(index, slice) else self.values[index]

    def __setitem__(self, index: Any, value: Any) -> None:
        if isinstance(index, slice):
            new = [float(each) for each in value]
            if len(new) != len(self.values[index]):
                raise ValueError("the number of items does not fit")
            self.values[index] = new
        else:
            self.values[index] = float(value)

    def __eq__(self, other: object) -> bool:
        try:
            return len(self) == len(other) and all(  # type: ignore[arg-type]
                abs(a - b) <= 1e-6 * max(1.0, abs(a))
                for a, b in zip(self.values, other)  # type: ignore[call-overload]
            )
        except TypeError:
            return False

    def __hash__(self) -> int:
        return hash(tuple(self.values))

    def __repr__(self) -> str:
        return f"{self.python_name}(({', '.join(repr(value) for value in self.values)}))"


def _numbers_of(value: Any, length: int | None = None) -> list[float]:
    numbers = [float(each) for each in value]
    if length is not None and len(numbers) != length:
        raise ValueError(f"expected {length} numbers, got {len(numbers)}")
    return numbers


class VectorValue(Numbers):
    """Vector of `mathutils`."""

    python_name = "Vector"
    names = _AXES
    shown = Numbers.shown | frozenset(
        words(
            "length length_squared magnitude normalized normalize dot cross lerp angle negate to_tuple to_2d to_3d "
            "to_4d rotate rotation_difference to_track_quat project reflect freeze resized slerp orthogonal zero "
            "resize_3d resize_2d"
        )
    )

    def __init__(self, values: Iterable[Any] = (0.0, 0.0, 0.0)) -> None:
        super().__init__(values)

    @property
    def length(self) -> float:
        """Return the Euclidean length."""
        return math.sqrt(sum(value * value for value in self.values))

    magnitude = length

    @property
    def length_squared(self) -> float:
        """Return the square of the length."""
        return sum(value * value for value in self.values)

    def assign(self, name: str, value: Any) -> None:
        if name in ("length", "magnitude"):
            self.values[:] = [each * float(value) / (self.length or 1.0) for each in self.values]
        else:
            super().assign(name, value)

    def normalized(self) -> VectorValue:
        """Return the unit vector of this direction."""
        length = self.length
        return VectorValue(value / length for value in self.values) if length else self.copy()

    def normalize(self) -> None:
        """Make this a unit vector."""
        self.values[:] = self.normalized().values

    def zero(self) -> None:
        """Set all numbers to 0."""
        self.values[:] = [0.0] * len(self.values)

    def negate(self) -> None:
        """Reverse the direction."""
        self.values[:] = [-value for value in self.values]

    def freeze(self) -> VectorValue:
        """Return the vector itself."""
        return self

    def dot(self, other: Any) -> float:
        """Return the scalar product."""
        return sum(a * b for a, b in zip(self.values, _numbers_of(other, len(self.values)), strict=True))

    def cross(self, other: Any) -> Any:
        """Return the vector product."""
        if len(self.values) == 2:
            x, y = _numbers_of(other, 2)
            return self.values[0] * y - self.values[1] * x
        return VectorValue(np.cross(self.array(), _numbers_of(other, 3)))

    def lerp(self, other: Any, factor: float) -> VectorValue:
        """Return the linear interpolation."""
        return VectorValue(a + (b - a) * factor for a, b in zip(self.values, _numbers_of(other, len(self.values))))

    def slerp(self, other: Any, factor: float, fallback: Any = None) -> VectorValue:
        """Return the spherical interpolation of directions."""
        angle = self.angle(other)
        if angle < 1e-9:
            return self.lerp(other, factor)
        a, b = math.sin((1 - factor) * angle) / math.sin(angle), math.sin(factor * angle) / math.sin(angle)
        return VectorValue(x * a + y * b for x, y in zip(self.values, other))

    def angle(self, other: Any, fallback: Any = MISSING) -> Any:
        """Return the angle between two directions."""
        lengths = self.length * VectorValue(other).length
        if not lengths:
            if fallback is MISSING:
                raise ValueError("Vector.angle(other): zero length vectors have no valid angle")
            return fallback
        return math.acos(min(1.0, max(-1.0, self.dot(other) / lengths)))

    def to_tuple(self, precision: int | None = None) -> tuple[float, ...]:
        """Return the numbers as a tuple."""
        return tuple(self.values if precision is None else (round(value, precision) for value in self.values))

    def to_2d(self) -> VectorValue:
        """Return the first two numbers."""
        return VectorValue(self.values[:2])

    def to_3d(self) -> VectorValue:
        """Return the first three numbers."""
        return VectorValue([*self.values, 0.0][:3])

    def to_4d(self) -> VectorValue:
        """Return four numbers, the last of which is 1 unless there is one."""
        return VectorValue([*self.to_3d().values, 1.0][:4] if len(self.values) < 4 else self.values)

    def resized(self, size: int) -> VectorValue:
        """Return the vector with another number of components."""
        return VectorValue(([*self.values, *[0.0] * size])[: min(size, _MAX_LENGTH)])

    def resize_3d(self) -> None:
        """Make this a vector of three numbers."""
        self.values[:] = self.to_3d().values

    def resize_2d(self) -> None:
        """Make this a vector of two numbers."""
        self.values[:] = self.values[:2]

    def rotate(self, rotation: Any) -> None:
        """Rotate this vector."""
        if isinstance(rotation, (Quaternion, Euler, MatrixValue)):
            rotation = matrix_of(rotation)[: len(self.values), : len(self.values)]
        self.values[:] = (np.array(rotation) @ self.array()).tolist()

    def rotation_difference(self, other: Any) -> Quaternion:
        """Return the shortest rotation to another direction."""
        a, b = self.normalized(), VectorValue(other).normalized()
        axis = a.cross(b)
        if axis.length < 1e-9:
            return Quaternion() if a.dot(b) > 0 else Quaternion(a.orthogonal(), math.pi)
        return Quaternion(axis, a.angle(b))

    def orthogonal(self) -> VectorValue:
        """Return a perpendicular vector."""
        least = min(range(3), key=lambda i: abs(self.values[i]))
        return VectorValue(np.cross(self.array(), [float(i == least) for i in range(3)]))

    def project(self, other: Any) -> VectorValue:
        """Return the projection onto another vector."""
        onto = VectorValue(other)
        return onto * (self.dot(other) / onto.length_squared)

    def reflect(self, mirror: Any) -> VectorValue:
        """Return the reflection about a mirror's normal."""
        normal = VectorValue(mirror).normalized()
        return self - normal * (2 * self.dot(normal))

    def to_track_quat(self, track: str = "Z", up: str = "Y") -> Quaternion:
        """Return the rotation that turns the axis ``track`` to this direction, with ``up`` as far up as possible."""
        sign = -1.0 if track.startswith("-") else 1.0
        forward, upward = "XYZ".index(track[-1]), "XYZ".index(up)
        if self.length < 1e-9:
            return Quaternion()
        direction = self.normalized().array() * sign
        world_up = np.array([0.0, 0.0, 1.0])
        if np.linalg.norm(np.cross(direction, world_up)) < 1e-6:
            # Blender keeps the direction of y where z is ambiguous.
            world_up = np.array([0.0, 1.0, 0.0])
        across = world_up - direction * float(world_up @ direction)
        across /= np.linalg.norm(across)
        axes = np.zeros((3, 3))
        axes[:, forward], axes[:, upward] = direction, across
        rest = 3 - forward - upward
        axes[:, rest] = np.cross(axes[:, (rest + 1) % 3], axes[:, (rest + 2) % 3])
        return quaternion_of(axes)

    def _each(self, other: Any, what: Any) -> VectorValue:
        if not isinstance(other, Numbers):
            raise TypeError(f"Vector arithmetic: expected a vector, got a {type(other).__name__}")
        if len(other) != len(self):
            raise ValueError("Vector arithmetic: vectors must have the same dimensions")
        return VectorValue(what(a, b) for a, b in zip(self.values, other.values, strict=True))

    def __add__(self, other: Any) -> VectorValue:
        return self._each(other, lambda a, b: a + b)

    def __sub__(self, other: Any) -> VectorValue:
        return self._each(other, lambda a, b: a - b)

    def __iadd__(self, other: Any) -> VectorValue:
        self.values[:] = (self + other).values
        return self

    def __isub__(self, other: Any) -> VectorValue:
        self.values[:] = (self - other).values
        return self

    def __mul__(self, other: Any) -> VectorValue:
        if isinstance(other, Numbers):
            return self._each(other, lambda a, b: a * b)
        return VectorValue(value * float(other) for value in self.values)

    __rmul__ = __mul__

    def __imul__(self, other: Any) -> VectorValue:
        self.values[:] = (self * other).values
        return self

    def __truediv__(self, other: Any) -> VectorValue:
        return VectorValue(value / float(other) for value in self.values)

    def __itruediv__(self, other: Any) -> VectorValue:
        self.values[:] = (self / other).values
        return self

    def __neg__(self) -> VectorValue:
        return VectorValue(-value for value in self.values)

    def __matmul__(self, other: Any) -> Any:
        return (
            self.dot(other)
            if isinstance(other, VectorValue)
            else VectorValue(self.array() @ other.array()[: len(self)])
        )

    def __getitem__(self, index: Any) -> Any:
        return VectorValue(self.values[index]) if isinstance(index, slice) else self.values[index]

    def __lt__(self, other: Any) -> bool:
        return self.length < VectorValue(other).length

    def __gt__(self, other: Any) -> bool:
        return self.length > VectorValue(other).length


class Color(Numbers):
    """Color of `mathutils`, with its components in HSV."""

    python_name = "Color"
    names = "rgb"
    shown = Numbers.shown | frozenset(("h", "s", "v", "hsv", "from_scene_linear_to_srgb", "from_srgb_to_scene_linear"))

    def __init__(self, values: Iterable[Any] = (0.0, 0.0, 0.0)) -> None:
        super().__init__(values)

    @property
    def hsv(self) -> tuple[float, float, float]:
        """Return hue, saturation and value."""
        import colorsys

        return colorsys.rgb_to_hsv(self.values[0], self.values[1], self.values[2])

    h = property(lambda self: self.hsv[0])
    s = property(lambda self: self.hsv[1])
    v = property(lambda self: self.hsv[2])

    def assign(self, name: str, value: Any) -> None:
        import colorsys

        if name == "hsv":
            self.values[:] = colorsys.hsv_to_rgb(*value)
        elif name in ("h", "s", "v"):
            parts = [*self.hsv]
            parts["hsv".index(name)] = float(value)
            self.values[:] = colorsys.hsv_to_rgb(*parts)
        else:
            super().assign(name, value)

    def from_srgb_to_scene_linear(self) -> Color:
        """Decode sRGB."""
        return Color(c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in self.values)

    def from_scene_linear_to_srgb(self) -> Color:
        """Encode sRGB."""
        return Color(c * 12.92 if c <= 0.0031308 else 1.055 * c ** (1 / 2.4) - 0.055 for c in self.values)

    def __mul__(self, other: Any) -> Color:
        return Color(value * float(other) for value in self.values)

    __rmul__ = __mul__


class Euler(Numbers):
    """Euler angles; ``order`` "XYZ" turns about x first."""

    python_name = "Euler"
    names = "xyz"
    shown = Numbers.shown | frozenset(words("order to_matrix to_quaternion rotate_axis rotate zero"))

    def __init__(self, values: Iterable[Any] = (0.0, 0.0, 0.0), order: str = "XYZ") -> None:
        super().__init__(values)
        self.order = order

    def copy(self) -> Euler:
        return Euler(self.values, self.order)

    def set(self, values: Any) -> None:
        super().set(values)
        if isinstance(values, Euler):
            self.order = values.order

    def zero(self) -> None:
        """Set all angles to 0."""
        self.values[:] = [0.0, 0.0, 0.0]

    def assign(self, name: str, value: Any) -> None:
        if name == "order":
            self.order = str(value)
        else:
            super().assign(name, value)

    def to_matrix(self) -> MatrixValue:
        """Return the rotation as a matrix."""
        return MatrixValue(euler_matrix(self.values, self.order))

    def to_quaternion(self) -> Quaternion:
        """Return the rotation as a quaternion."""
        return quaternion_of(euler_matrix(self.values, self.order))

    def rotate_axis(self, axis: str, angle: float) -> None:
        """Rotate about a local axis."""
        turned = euler_matrix(self.values, self.order) @ axis_rotation(axis, angle)
        self.values[:] = euler_of(turned, self.order).values

    def rotate(self, other: Any) -> None:
        """Rotate by another rotation."""
        turned = matrix_of(other)[:3, :3] @ euler_matrix(self.values, self.order)
        self.values[:] = euler_of(turned, self.order).values

    def __repr__(self) -> str:
        return f"Euler(({', '.join(map(repr, self.values))}), '{self.order}')"


class Quaternion(Numbers):
    """Quaternion (w, x, y, z), by its numbers or an axis and an angle."""

    python_name = "Quaternion"
    names = "wxyz"
    shown = Numbers.shown | frozenset(
        words(
            "to_matrix to_euler normalized normalize inverted invert conjugated conjugate slerp angle axis dot "
            "rotation_difference to_axis_angle rotate magnitude"
        )
    )

    def __init__(self, values: Iterable[Any] = (1.0, 0.0, 0.0, 0.0), angle: float | None = None) -> None:
        numbers = _numbers_of(values)
        if angle is not None:
            x, y, z = VectorValue(numbers).normalized().values
            half = math.sin(angle / 2)
            numbers = [math.cos(angle / 2), x * half, y * half, z * half]
        super().__init__(numbers)

    @property
    def magnitude(self) -> float:
        """Return the length."""
        return math.sqrt(sum(value * value for value in self.values))

    @property
    def angle(self) -> float:
        """Return the angle of the rotation."""
        return 2 * math.acos(min(1.0, max(-1.0, self.normalized().values[0])))

    @property
    def axis(self) -> VectorValue:
        """Return the axis of the rotation."""
        axis = VectorValue(self.values[1:])
        return axis.normalized() if axis.length > 1e-9 else VectorValue((1.0, 0.0, 0.0))

    def to_axis_angle(self) -> tuple[VectorValue, float]:
        """Return the axis and the angle."""
        return self.axis, self.angle

    def normalized(self) -> Quaternion:
        """Return the unit quaternion."""
        return Quaternion(value / (self.magnitude or 1.0) for value in self.values)

    def normalize(self) -> None:
        """Make this a unit quaternion."""
        self.values[:] = self.normalized().values

    def conjugated(self) -> Quaternion:
        """Return the conjugate."""
        w, x, y, z = self.values
        return Quaternion((w, -x, -y, -z))

    def inverted(self) -> Quaternion:
        """Return the inverse."""
        square = self.magnitude**2
        return Quaternion(value / square for value in self.conjugated().values)

    def invert(self) -> None:
        """Make this its inverse."""
        self.values[:] = self.inverted().values

    conjugate = invert

    def dot(self, other: Any) -> float:
        """Return the scalar product."""
        return sum(a * b for a, b in zip(self.values, _numbers_of(other, 4), strict=True))

    def to_matrix(self) -> MatrixValue:
        """Return the rotation as a matrix."""
        return MatrixValue(quaternion_matrix(self.values))

    def to_euler(self, order: str = "XYZ", compatible: Any = None) -> Euler:
        """Return the rotation as Euler angles."""
        return euler_of(quaternion_matrix(self.values), order)

    def rotation_difference(self, other: Quaternion) -> Quaternion:
        """Return the rotation from this one to another."""
        return _product(self.inverted(), other)

    def rotate(self, other: Any) -> None:
        """Rotate by another rotation."""
        self.values[:] = quaternion_of(matrix_of(other)[:3, :3] @ quaternion_matrix(self.values)).values

    def slerp(self, other: Any, factor: float) -> Quaternion:
        """Return the spherical interpolation."""
        cosine = self.dot(other)
        target = [-value for value in other] if cosine < 0 else [*other]
        angle = math.acos(min(1.0, abs(cosine)))
        if angle < 1e-6:
            return Quaternion(a + (b - a) * factor for a, b in zip(self.values, target))
        first, second = math.sin((1 - factor) * angle) / math.sin(angle), math.sin(factor * angle) / math.sin(angle)
        return Quaternion(a * first + b * second for a, b in zip(self.values, target))

    def __matmul__(self, other: Any) -> Any:
        if isinstance(other, Quaternion):
            return _product(self, other)
        return VectorValue(quaternion_matrix(self.values) @ np.array(_numbers_of(other, 3)))

    def __mul__(self, other: Any) -> Quaternion:
        if isinstance(other, Quaternion):
            return Quaternion(a * b for a, b in zip(self.values, other.values))
        return Quaternion(value * float(other) for value in self.values)

    def __neg__(self) -> Quaternion:
        return Quaternion(-value for value in self.values)


def _product(left: Quaternion, right: Quaternion) -> Quaternion:
    a, b, c, d = left.values
    e, f, g, h = right.values
    return Quaternion(
        (
            a * e - b * f - c * g - d * h,
            a * f + b * e + c * h - d * g,
            a * g - b * h + c * e + d * f,
            a * h + b * g - c * f + d * e,
        )
    )


class MatrixRow(VectorValue):
    """Row or column of a matrix, in which numbers can be assigned."""

    def __init__(self, matrix: MatrixValue, index: int, is_column: bool = False) -> None:
        self._line = matrix.numbers[:, index] if is_column else matrix.numbers[index]
        super().__init__(self._line.tolist())

    def copy(self) -> VectorValue:
        return VectorValue(self.values)

    def __setitem__(self, index: Any, value: Any) -> None:
        super().__setitem__(index, value)
        self._line[:] = self.values

    def assign(self, name: str, value: Any) -> None:
        super().assign(name, value)
        self._line[:] = self.values


class MatrixValue(HostObject):
    """Matrix of `mathutils`, of 2 to 4 rows and columns."""

    python_name = "Matrix"
    shown = frozenset(
        words(
            "copy translation to_translation to_euler to_quaternion to_scale to_3x3 to_4x4 inverted inverted_safe "
            "invert transposed transpose decompose determinant normalized normalize row col identity is_negative "
            "freeze lerp median_scale"
        )
    )

    def __init__(self, rows: Any = None) -> None:
        numbers = np.eye(4) if rows is None else np.array([_numbers_of(row) for row in rows])
        if numbers.ndim != 2 or not all(2 <= size <= 4 for size in numbers.shape):
            raise ValueError("Matrix(): expects no args or a single arg containing 2-4 numeric sequences")
        self.numbers = numbers

    def read(self, name: str) -> Any:
        if name == "translation":
            return MatrixTranslation(self.numbers[:, 3]) if len(self.numbers) == 4 else MISSING
        return super().read(name)

    def assign(self, name: str, value: Any) -> None:
        if name != "translation":
            super().assign(name, value)
        self.numbers[:3, 3] = _numbers_of(value, 3)

    def array(self) -> FloatArray:
        """Return the numbers as an array."""
        return self.numbers

    def copy(self) -> MatrixValue:
        """Return a copy."""
        return MatrixValue(self.numbers)

    freeze = copy

    @property
    def row(self) -> list[MatrixRow]:
        """Return the rows."""
        return [MatrixRow(self, i) for i in range(len(self.numbers))]

    @property
    def col(self) -> list[MatrixRow]:
        """Return the columns."""
        return [MatrixRow(self, i, True) for i in range(self.numbers.shape[1])]

    @property
    def is_negative(self) -> bool:
        """Return whether the matrix mirrors."""
        return bool(np.linalg.det(self.numbers[:3, :3]) < 0)

    @property
    def median_scale(self) -> float:
        """Return the mean scale."""
        return float(np.mean(_scales(self.numbers)))

    def identity(self) -> None:
        """Make this the identity."""
        self.numbers[:] = np.eye(len(self.numbers))

    def to_translation(self) -> VectorValue:
        """Return the translation."""
        return VectorValue(self.numbers[:3, 3])

    def to_3x3(self) -> MatrixValue:
        """Return the linear part."""
        return MatrixValue(self.numbers[:3, :3])

    def to_4x4(self) -> MatrixValue:
        """Return the matrix with four rows and columns."""
        made = np.eye(4)
        rows, columns = self.numbers.shape
        made[:rows, :columns] = self.numbers
        return MatrixValue(made)

    def to_scale(self) -> VectorValue:
        """Return the scale."""
        return VectorValue(_scales(self.numbers))

    def to_euler(self, order: str = "XYZ", compatible: Any = None) -> Euler:
        """Return the rotation as Euler angles."""
        return euler_of(_rotation(self.numbers), order)

    def to_quaternion(self) -> Quaternion:
        """Return the rotation as a quaternion."""
        return quaternion_of(_rotation(self.numbers))

    def decompose(self) -> tuple[VectorValue, Quaternion, VectorValue]:
        """Return translation, rotation and scale."""
        return self.to_translation(), self.to_quaternion(), self.to_scale()

    def determinant(self) -> float:
        """Return the determinant."""
        return float(np.linalg.det(self.numbers))

    def inverted(self, fallback: Any = MISSING) -> Any:
        """Return the inverse."""
        if abs(np.linalg.det(self.numbers)) < 1e-12:
            if fallback is MISSING:
                raise ValueError("Matrix.invert(ed): matrix does not have an inverse")
            return fallback
        return MatrixValue(np.linalg.inv(self.numbers))

    inverted_safe = inverted

    def invert(self) -> None:
        """Make this its inverse."""
        self.numbers[:] = self.inverted().numbers

    def transposed(self) -> MatrixValue:
        """Return the transpose."""
        return MatrixValue(self.numbers.T)

    def transpose(self) -> None:
        """Make this its transpose."""
        self.numbers[:] = self.numbers.T.copy()

    def normalized(self) -> MatrixValue:
        """Return the matrix with unit columns."""
        return MatrixValue(self.numbers / np.linalg.norm(self.numbers, axis=0))

    def normalize(self) -> None:
        """Make the columns unit vectors."""
        self.numbers[:] = self.normalized().numbers

    def lerp(self, other: MatrixValue, factor: float) -> MatrixValue:
        """Return the interpolation of translation, rotation and scale."""
        a, b = self.decompose(), other.decompose()
        parts = a[0].lerp(b[0], factor), a[1].slerp(b[1], factor), a[2].lerp(b[2], factor)
        return MatrixValue(composed(*parts))

    def __matmul__(self, other: Any) -> Any:
        if isinstance(other, MatrixValue):
            return MatrixValue(self.numbers @ other.numbers)
        vector = np.array(_numbers_of(other))
        if len(self.numbers) == 4 and len(vector) == 3:
            return VectorValue((self.numbers @ [*vector, 1.0])[:3])
        return VectorValue(self.numbers @ vector)

    def __imatmul__(self, other: Any) -> MatrixValue:
        self.numbers[:] = (self @ other).numbers
        return self

    def __mul__(self, factor: Any) -> MatrixValue:
        return MatrixValue(self.numbers * (factor.numbers if isinstance(factor, MatrixValue) else float(factor)))

    __rmul__ = __mul__

    def __add__(self, other: MatrixValue) -> MatrixValue:
        return MatrixValue(self.numbers + other.numbers)

    def __sub__(self, other: MatrixValue) -> MatrixValue:
        return MatrixValue(self.numbers - other.numbers)

    def __len__(self) -> int:
        return len(self.numbers)

    def __iter__(self) -> Iterator[MatrixRow]:
        return iter(self.row)

    def __getitem__(self, index: Any) -> Any:
        return self.row[index]

    def __setitem__(self, index: Any, value: Any) -> None:
        self.numbers[index] = [*value] if not isinstance(index, slice) else [[*row] for row in value]

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, MatrixValue)
            and self.numbers.shape == other.numbers.shape
            and bool(np.allclose(self.numbers, other.numbers, atol=1e-6))
        )

    __hash__ = None  # type: ignore[assignment]


class MatrixTranslation(VectorValue):
    """Translation of a matrix, in which numbers can be assigned."""

    def __init__(self, column: FloatArray) -> None:
        self._column = column
        super().__init__(column[:3].tolist())

    def copy(self) -> VectorValue:
        return VectorValue(self.values)

    def __setitem__(self, index: Any, value: Any) -> None:
        super().__setitem__(index, value)
        self._column[:3] = self.values

    def assign(self, name: str, value: Any) -> None:
        super().assign(name, value)
        self._column[:3] = self.values


# --- rotations as arrays ---------------------------------------------------------------------------------------------


def axis_rotation(axis: Any, angle: float, size: int = 3) -> FloatArray:
    """Return the rotation by an angle about "X", "Y", "Z" or a vector."""
    direction = (
        [float(name == axis) for name in "XYZ"] if isinstance(axis, str) else VectorValue(axis).normalized().values
    )
    x, y, z = direction
    c, s = math.cos(angle), math.sin(angle)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    outer = np.outer(direction, direction)
    made = np.eye(size)
    made[:3, :3] = c * np.eye(3) + s * cross + (1 - c) * outer
    return made


def euler_matrix(angles: Iterable[float], order: str = "XYZ") -> FloatArray:
    """Return the rotation (3, 3) of Euler angles about x, y and z, in an order."""
    by_axis = dict(zip("XYZ", angles, strict=True))
    made = np.eye(3)
    for axis in order:
        made = axis_rotation(axis, by_axis[axis]) @ made
    return made


def euler_of(rotation: FloatArray, order: str = "XYZ") -> Euler:
    """Return the Euler angles of a rotation."""
    i, j, k = ("XYZ".index(axis) for axis in order)
    parity = 1.0 if (j - i) % 3 == 1 else -1.0
    cosine = math.hypot(rotation[i, i], rotation[j, i])
    angles = [0.0, 0.0, 0.0]
    if cosine > 1e-6:
        angles[i] = math.atan2(parity * rotation[k, j], rotation[k, k])
        angles[j] = math.atan2(-parity * rotation[k, i], cosine)
        angles[k] = math.atan2(parity * rotation[j, i], rotation[i, i])
    else:
        angles[i] = math.atan2(-parity * rotation[j, k], rotation[j, j])
        angles[j] = math.atan2(-parity * rotation[k, i], cosine)
    return Euler(angles, order)


def quaternion_matrix(numbers: Iterable[float]) -> FloatArray:
    """Return the rotation (3, 3) of a quaternion (w, x, y, z)."""
    w, x, y, z = np.array([*numbers]) / (math.sqrt(sum(n * n for n in numbers)) or 1.0)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def quaternion_of(rotation: FloatArray) -> Quaternion:
    """Return the quaternion of a rotation."""
    m = rotation
    trace = float(np.trace(m))
    if trace > 0:
        s = 2 * math.sqrt(trace + 1)
        return Quaternion((s / 4, (m[2, 1] - m[1, 2]) / s, (m[0, 2] - m[2, 0]) / s, (m[1, 0] - m[0, 1]) / s))
    i = int(np.argmax(np.diag(m)))
    j, k = (i + 1) % 3, (i + 2) % 3
    s = 2 * math.sqrt(max(1 + m[i, i] - m[j, j] - m[k, k], 1e-30))
    numbers = [(m[k, j] - m[j, k]) / s, 0.0, 0.0, 0.0]
    numbers[i + 1], numbers[j + 1], numbers[k + 1] = s / 4, (m[j, i] + m[i, j]) / s, (m[k, i] + m[i, k]) / s
    return Quaternion(numbers if numbers[0] >= 0 else [-number for number in numbers])


def matrix_of(rotation: Any) -> FloatArray:
    """Return the matrix of a rotation of `mathutils`."""
    return rotation.numbers if isinstance(rotation, MatrixValue) else rotation.to_matrix().numbers


def composed(location: Any, rotation: Any, scale: Any) -> FloatArray:
    """Return the matrix (4, 4) that scales, rotates and moves."""
    made = np.eye(4)
    linear = rotation if isinstance(rotation, np.ndarray) else matrix_of(rotation)
    made[:3, :3] = linear[:3, :3] * np.array([*scale])
    made[:3, 3] = [*location]
    return made


def _scales(numbers: FloatArray) -> FloatArray:
    lengths: FloatArray = np.linalg.norm(numbers[:3, :3], axis=0)
    return -lengths if np.linalg.det(numbers[:3, :3]) < 0 else lengths


def _rotation(numbers: FloatArray) -> FloatArray:
    scales = _scales(numbers)
    made: FloatArray = numbers[:3, :3] / np.where(scales == 0, 1.0, scales)
    return made


def decomposed(numbers: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return translation, rotation (3, 3) and scale of a matrix, as Blender takes it apart."""
    return numbers[:3, 3].copy(), _rotation(numbers), _scales(numbers)


def _rotation_matrix(angle: float, size: int = 4, axis: Any = "Z") -> MatrixValue:
    if size == 2:
        return MatrixValue([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    return MatrixValue(axis_rotation(axis, angle, size))


def _scale_matrix(factor: float, size: int = 4, axis: Any = None) -> MatrixValue:
    made = np.eye(size)
    if axis is None:
        made[:3, :3] *= factor
    else:
        direction = VectorValue(axis).normalized().array()
        made[:3, :3] += (factor - 1) * np.outer(direction, direction)
    return MatrixValue(made)


def _loc_rot_scale(location: Any, rotation: Any, scale: Any) -> MatrixValue:
    turn = np.eye(3) if rotation is None else matrix_of(rotation)
    return MatrixValue(composed(location or (0, 0, 0), turn, scale or (1, 1, 1)))


def _translation_matrix(offset: Any) -> MatrixValue:
    return MatrixValue(composed(offset, np.eye(3), (1, 1, 1)))


_MATRIX_FUNCTIONS: dict[str, Any] = {
    "Rotation": _rotation_matrix,
    "Scale": _scale_matrix,
    "Translation": _translation_matrix,
    "Diagonal": lambda values: MatrixValue(np.diag(_numbers_of(values))),
    "Identity": lambda size: MatrixValue(np.eye(size)),
    "LocRotScale": _loc_rot_scale,
}


def mathutils_module() -> Module:
    """Return the module `mathutils`."""
    kinds: dict[str, Any] = {"Vector": VectorValue, "Euler": Euler, "Quaternion": Quaternion, "Color": Color}
    names: dict[str, Any] = {name: Native(f"mathutils.{name}", kind, kind) for name, kind in kinds.items()}
    matrix = Native("mathutils.Matrix", lambda rows=None: MatrixValue(rows), MatrixValue)
    matrix.attributes = {name: Native(f"Matrix.{name}", make) for name, make in _MATRIX_FUNCTIONS.items()}
    names["Vector"].attributes = {
        "Fill": Native("Vector.Fill", lambda size, fill=0.0: VectorValue([fill] * min(size, _MAX_LENGTH))),
    }
    names["Matrix"] = matrix
    return Module("mathutils", names)

"""Rotations of ``scipy.spatial.transform`` in Python: translated with a program, and evaluated where it is.

``ROTATION`` has one rotation each. What takes or gives many (``STACKS``) is known to the evaluator alone: a rotation
of the first kind refuses what only the second can hold, so that a program which has both is evaluated. Formulas and
signs are those of scipy 1.17.
"""

from __future__ import annotations

import ast
from collections.abc import Callable

from scenelang.interpreter.transpile.analysis.python_text import walk_tree

MODULE = "scipy.spatial.transform"
ROTATIONS = f"{MODULE}.Rotation"
ROTATION = """
@dataclass
class Rotation:
    x: float
    y: float
    z: float
    w: float

    @staticmethod
    def identity():
        return Rotation(0.0, 0.0, 0.0, 1.0)

    @staticmethod
    def from_quat(quat, scalar_first=False):
        a, b, c, d = float(quat[0]), float(quat[1]), float(quat[2]), float(quat[3])
        size = math.sqrt(a * a + b * b + c * c + d * d)
        if size == 0:
            raise ValueError("Found zero norm quaternions in `quat`.")
        if scalar_first:
            return Rotation(b / size, c / size, d / size, a / size)
        return Rotation(a / size, b / size, c / size, d / size)

    @staticmethod
    def from_rotvec(rotvec, degrees=False):
        unit = math.pi / 180 if degrees else 1.0
        x, y, z = float(rotvec[0]) * unit, float(rotvec[1]) * unit, float(rotvec[2]) * unit
        angle = math.sqrt(x * x + y * y + z * z)
        k = math.sin(angle / 2) / angle if angle > 0.001 else 0.5 - angle**2 / 48 + angle**4 / 3840
        return Rotation(x * k, y * k, z * k, math.cos(angle / 2))

    @staticmethod
    def from_euler(seq, angles, degrees=False):
        values = [angles] if len(seq) == 1 else list(angles)
        if len(values) != len(seq):
            raise ValueError("Expected last dimension of `angles` to match number of sequence axes specified.")
        lower = seq.lower()
        is_known = all(axis in "xyz" for axis in lower) and seq in (lower, seq.upper())
        if not is_known or "xx" in lower or "yy" in lower or "zz" in lower:
            raise ValueError("Expected axes from `seq` to be from ['x', 'y', 'z'] or ['X', 'Y', 'Z'].")
        turned = Rotation(0.0, 0.0, 0.0, 1.0)
        for axis, value in zip(seq, values):
            half = (math.radians(float(value)) if degrees else float(value)) / 2
            sine = math.sin(half)
            turn = Rotation(
                sine if axis in ("x", "X") else 0.0,
                sine if axis in ("y", "Y") else 0.0,
                sine if axis in ("z", "Z") else 0.0,
                math.cos(half),
            )
            turned = turn * turned if seq == lower else turned * turn
        return turned

    @staticmethod
    def from_matrix(matrix):
        a, b, c = float(matrix[0][0]), float(matrix[0][1]), float(matrix[0][2])
        d, e, f = float(matrix[1][0]), float(matrix[1][1]), float(matrix[1][2])
        g, h, i = float(matrix[2][0]), float(matrix[2][1]), float(matrix[2][2])
        skew = max(abs(a * d + b * e + c * f), abs(a * g + b * h + c * i), abs(d * g + e * h + f * i))
        if abs(a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) - 1) > 1e-9 or skew > 1e-9:
            raise ValueError("this matrix is no rotation")
        trace = a + e + i
        if trace >= a and trace >= e and trace >= i:
            return Rotation.from_quat([h - f, c - g, d - b, 1 + trace])
        if a >= e and a >= i:
            return Rotation.from_quat([1 - trace + 2 * a, d + b, g + c, h - f])
        if e >= i:
            return Rotation.from_quat([d + b, 1 - trace + 2 * e, h + f, c - g])
        return Rotation.from_quat([g + c, h + f, 1 - trace + 2 * i, d - b])

    def __mul__(self, other):
        return Rotation(
            self.w * other.x + self.x * other.w + self.y * other.z - self.z * other.y,
            self.w * other.y - self.x * other.z + self.y * other.w + self.z * other.x,
            self.w * other.z + self.x * other.y - self.y * other.x + self.z * other.w,
            self.w * other.w - self.x * other.x - self.y * other.y - self.z * other.z,
        )

    def __pow__(self, n):
        return Rotation.from_rotvec(self.as_rotvec() * n)

    def inv(self):
        return Rotation(-self.x, -self.y, -self.z, self.w)

    def magnitude(self):
        size = math.sqrt(self.x * self.x + self.y * self.y + self.z * self.z)
        return 2 * math.atan2(size, abs(self.w))

    def canonical_sign(self):
        parts = [part for part in (self.w, self.x, self.y, self.z) if part != 0]
        return -1.0 if parts[0] < 0 else 1.0

    def as_quat(self, canonical=False, scalar_first=False):
        s = self.canonical_sign() if canonical else 1.0
        if scalar_first:
            return np.array([self.w * s, self.x * s, self.y * s, self.z * s])
        return np.array([self.x * s, self.y * s, self.z * s, self.w * s])

    def as_rotvec(self, degrees=False):
        s = self.canonical_sign()
        size = math.sqrt(self.x * self.x + self.y * self.y + self.z * self.z)
        angle = 2 * math.atan2(size, self.w * s)
        k = angle / math.sin(angle / 2) if angle > 0.001 else 2 + angle**2 / 12 + 7 * angle**4 / 2880
        k = math.degrees(k * s) if degrees else k * s
        return np.array([self.x * k, self.y * k, self.z * k])

    def as_matrix(self):
        x, y, z, w = self.x, self.y, self.z, self.w
        return np.array([
            [x * x - y * y - z * z + w * w, 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), y * y - x * x - z * z + w * w, 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), z * z - x * x - y * y + w * w],
        ])

    def apply(self, vectors, inverse=False):
        matrix = self.as_matrix()
        return np.array(vectors) @ (matrix if inverse else matrix.T)

    def as_euler(self, seq, degrees=False):
        is_fixed = seq == seq.lower()
        q = [self.x, self.y, self.z]
        axes = ["xyz".index(axis) for axis in (seq.lower() if is_fixed else seq.lower()[::-1])]
        i, j = axes[0], axes[1]
        is_symmetric = axes[0] == axes[2]
        k = 3 - i - j if is_symmetric else axes[2]
        sign = (i - j) * (j - k) * (k - i) // 2
        a = self.w if is_symmetric else self.w - q[j]
        b = q[i] if is_symmetric else q[i] + q[k] * sign
        c = q[j] if is_symmetric else q[j] + self.w
        d = q[k] * sign if is_symmetric else q[k] * sign - q[i]
        middle = 2 * math.atan2(math.hypot(c, d), math.hypot(a, b))
        half_sum, half_difference = math.atan2(b, a), math.atan2(d, c)
        less = half_sum - half_difference
        more = half_sum + half_difference
        first, third = (less, more) if is_fixed else (more, less)
        if abs(middle) <= 1e-7:
            first, third = 2 * half_sum, 0.0
        elif abs(middle - math.pi) <= 1e-7:
            first, third = 2 * half_difference * (-1 if is_fixed else 1), 0.0
        if not is_symmetric:
            if is_fixed:
                third *= sign
            else:
                first *= sign
            middle -= math.pi / 2
        angles = []
        for angle in (first, middle, third):
            if angle < -math.pi:
                angle += 2 * math.pi
            elif angle > math.pi:
                angle -= 2 * math.pi
            angles.append(math.degrees(angle) if degrees else angle)
        return np.array(angles)
"""
STACKS = """
def is_stack(values, depth=1):
    if depth == 1:
        return len(values) > 0 and isinstance(values[0], (list, tuple, np.ndarray))
    return is_stack(values[0], depth - 1)

def check_axes(seq):
    is_known = seq.lower().strip("xyz") == "" and seq in (seq.lower(), seq.upper())
    if not 1 <= len(seq) <= 3 or not is_known or any(a == b for a, b in zip(seq, seq[1:])):
        raise ValueError(f"Expected axes from `seq` to be from ['x', 'y', 'z'] or ['X', 'Y', 'Z'], got {seq}")

One = Rotation

class Rotation(One):
    @staticmethod
    def identity(num=None):
        one = Rotation(0.0, 0.0, 0.0, 1.0)
        return one if num is None else RotationStack([one] * num)

    @staticmethod
    def from_quat(quat, *, scalar_first=False):
        single = lambda each: One.from_quat(each, scalar_first)
        return RotationStack(list(map(single, quat))) if is_stack(quat) else single(quat)

    @staticmethod
    def from_rotvec(rotvec, degrees=False):
        single = lambda each: One.from_rotvec(each, degrees)
        return RotationStack(list(map(single, rotvec))) if is_stack(rotvec) else single(rotvec)

    @staticmethod
    def from_euler(seq, angles, degrees=False):
        check_axes(seq)
        single = lambda each: One.from_euler(seq, each, degrees)
        if len(seq) == 1 and isinstance(angles, (list, tuple, np.ndarray)):
            if len(angles) == 1 and not is_stack(angles):
                return single(angles[0])
            return RotationStack([single(each[0] if is_stack([each]) else each) for each in angles])
        if len(seq) > 1 and not isinstance(angles, (list, tuple, np.ndarray)):
            raise ValueError("Expected last dimension of `angles` to match number of sequence axes specified, got 1.")
        return RotationStack(list(map(single, angles))) if len(seq) > 1 and is_stack(angles) else single(angles)

    @staticmethod
    def from_matrix(matrix):
        if is_stack(matrix, 2):
            return RotationStack(list(map(Rotation.from_matrix, matrix)))
        array = np.array(matrix)
        if not np.allclose(array @ array.T, np.eye(3), rtol=0, atol=1e-12):
            if np.linalg.det(array) <= 0:
                raise ValueError("Non-positive determinant (left-handed or null coordinate frame) in rotation matrix")
            u, _, v = np.linalg.svd(array)
            array = u @ v
        elif np.linalg.det(array) <= 0:
            raise ValueError("Non-positive determinant (left-handed or null coordinate frame) in rotation matrix")
        return One.from_matrix(array)

    @staticmethod
    def random(num=None, *, rng=None, random_state=None):
        given = random_state if rng is None else rng
        if given is None:
            unsupported("`Rotation.random` without a seed gives other rotations in every run")
        stream = given
        if isinstance(given, int):
            stream = np.random.RandomState(given) if rng is None else np.random.default_rng(given)
        drawn = stream.normal(size=4 if num is None else (num, 4))
        return Rotation.from_quat(drawn)

    @staticmethod
    def concatenate(rotations):
        return RotationStack([one for each in rotations for one in (each.items if hasattr(each, "items") else [each])])

    @staticmethod
    def align_vectors(a, b, weights=None):
        a, b = np.atleast_2d(np.array(a, dtype=float)), np.atleast_2d(np.array(b, dtype=float))
        if len(a) == 1 and weights is None:
            found = turned_onto(b[0] / np.linalg.norm(b[0]), a[0] / np.linalg.norm(a[0]))
            return found, float(np.linalg.norm(a - found.apply(b)))
        w = np.ones(len(b)) if weights is None else np.array(weights, dtype=float)
        u, s, v = np.linalg.svd(np.einsum("ji,jk->ik", w[:, None] * a, b))
        if np.linalg.det(u @ v) < 0:
            s[-1] = -s[-1]
            u[:, -1] = -u[:, -1]
        rest = float(np.sum(w * np.sum(b**2 + a**2, axis=1)) - 2 * np.sum(s))
        return Rotation.from_matrix(u @ v), math.sqrt(max(rest, 0.0))

    def __mul__(self, other):
        if isinstance(other, RotationStack):
            return RotationStack([self * each for each in other.items])
        return super().__mul__(other)

    def __pow__(self, n):
        return self if n == 1 else self.inv() if n == -1 else super().__pow__(n)

    def as_euler(self, seq, degrees=False):
        check_axes(seq)
        return super().as_euler(seq, degrees)

    def approx_equal(self, other, atol=None, degrees=False):
        limit = 1e-8 if atol is None else math.radians(atol) if degrees else atol
        return (other * self.inv()).magnitude() < limit

    @property
    def single(self):
        return True

def turned_onto(b, a):
    cross, cosine = np.cross(b, a), float(np.dot(a, b))
    size = float(np.linalg.norm(cross))
    angle = math.atan2(size, cosine)
    if size == 0 and cosine < 0:
        i = int(np.argmin(np.abs(a)))
        axis = np.zeros(3)
        axis[i - 1], axis[i - 2] = a[i - 2], -a[i - 1]
        return Rotation.from_rotvec(axis / np.linalg.norm(axis) * math.pi)
    return Rotation.from_rotvec(cross * (angle / size if size > 0 else 1.0))

class RotationStack:
    def __init__(self, items):
        self.items = items

    @property
    def single(self):
        return False

    def __len__(self):
        return len(self.items)

    def __iter__(self):
        return iter(self.items)

    def __getitem__(self, index):
        if isinstance(index, (list, tuple, np.ndarray)):
            chosen = np.arange(len(self.items))[np.array(index)]
            return RotationStack([self.items[i] for i in chosen])
        found = self.items[index]
        return RotationStack(found) if isinstance(found, list) else found

    def __mul__(self, other):
        others = other.items if isinstance(other, RotationStack) else [other]
        n = max(len(self.items), len(others))
        if len(self.items) not in (1, n) or len(others) not in (1, n):
            raise ValueError("Expected equal number of rotations in both or a single rotation in either object")
        return RotationStack([self.items[i % len(self.items)] * others[i % len(others)] for i in range(n)])

    def __pow__(self, n):
        return RotationStack([each**n for each in self.items])

    def inv(self):
        return RotationStack([each.inv() for each in self.items])

    def apply(self, vectors, inverse=False):
        rows = vectors if is_stack(vectors) else [vectors]
        n = max(len(self.items), len(rows))
        if len(self.items) not in (1, n) or len(rows) not in (1, n):
            raise ValueError("Expected equal numbers of rotations and vectors, or a single one of either")
        return np.array([self.items[i % len(self.items)].apply(rows[i % len(rows)], inverse) for i in range(n)])

    def as_matrix(self):
        return np.array([each.as_matrix() for each in self.items])

    def as_quat(self, canonical=False, *, scalar_first=False):
        return np.array([each.as_quat(canonical, scalar_first) for each in self.items])

    def as_rotvec(self, degrees=False):
        return np.array([each.as_rotvec(degrees) for each in self.items])

    def as_euler(self, seq, degrees=False):
        return np.array([each.as_euler(seq, degrees) for each in self.items])

    def magnitude(self):
        return np.array([each.magnitude() for each in self.items])

    def mean(self, weights=None):
        w = np.ones(len(self.items)) if weights is None else np.array(weights, dtype=float)
        q = self.as_quat()
        _, vectors = np.linalg.eigh((q * w[:, None]).T @ q)
        return Rotation.from_quat(vectors[:, -1])

class Slerp:
    def __init__(self, times, rotations):
        self.times = [float(each) for each in times]
        self.rotations = rotations
        if len(self.times) < 2 or len(self.times) != len(rotations):
            raise ValueError("Expected number of rotations to be equal to number of timestamps given, and at least 2")
        if any(b <= a for a, b in zip(self.times, self.times[1:])):
            raise ValueError("Times must be in strictly increasing order.")

    def at(self, time):
        if not self.times[0] <= time <= self.times[-1]:
            raise ValueError("Interpolation times must be within the range of the given times.")
        place = 0
        while place + 2 < len(self.times) and time >= self.times[place + 1]:
            place += 1
        a, b = self.rotations[place], self.rotations[place + 1]
        part = (time - self.times[place]) / (self.times[place + 1] - self.times[place])
        return a * Rotation.from_rotvec((a.inv() * b).as_rotvec() * part)

    def __call__(self, times):
        if isinstance(times, (list, tuple, np.ndarray)):
            return RotationStack([self.at(float(each)) for each in times])
        return self.at(times)
"""
_MEMBERS = frozenset(
    node.name for node in ast.walk(ast.parse(ROTATION)) if isinstance(node, ast.FunctionDef) and node.name[0] != "_"
)
_NOT_SINGLE = {  # members of scipy's rotations that the class has not
    "approx_equal", "as_davenport", "as_mrp", "create_group", "from_davenport", "from_mrp", "reduce",
}  # fmt: skip


def with_rotations(tree: ast.Module, path_of: Callable[[ast.AST], str | None]) -> list[str]:
    """Write the rotations of a module, in place, by the class of one rotation; return the text of the class.

    A program that uses more of scipy's module stays as it is.
    """
    nodes = walk_tree(tree)
    names = [each for each in nodes if path_of(each) == ROTATIONS]
    inner = {id(each.value) for each in nodes if isinstance(each, ast.Attribute) and path_of(each) == ROTATIONS}
    uses = [each for each in names if id(each) not in inner]
    used = {each.attr for each in nodes if isinstance(each, ast.Attribute) and path_of(each.value) == ROTATIONS}
    others = {path for each in nodes if (path := path_of(each) or "").startswith("scipy.")} - {ROTATIONS, MODULE}
    others = {path for path in others if not path.startswith(f"{ROTATIONS}.") and not MODULE.startswith(path)}
    others |= {each.attr for each in nodes if isinstance(each, ast.Attribute)} & _NOT_SINGLE
    bound = {each.name for each in nodes if isinstance(each, (ast.ClassDef, ast.FunctionDef))}
    if not uses or not used <= _MEMBERS or others or "Rotation" in bound:
        return []
    _Named({id(each) for each in uses}).visit(tree)
    for statement in [each for each in tree.body if isinstance(each, ast.ImportFrom)]:
        if (statement.module or "").startswith("scipy"):
            tree.body.remove(statement)
    return [ROTATION]


class _Named(ast.NodeTransformer):
    """Names the class where a program names scipy's."""

    def __init__(self, places: set[int]) -> None:
        self._places = places

    def visit_Name(self, node: ast.Name) -> ast.expr:
        return ast.copy_location(ast.Name("Rotation", node.ctx), node) if id(node) in self._places else node

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        if id(node) in self._places:
            return ast.copy_location(ast.Name("Rotation", node.ctx), node)
        self.generic_visit(node)
        return node

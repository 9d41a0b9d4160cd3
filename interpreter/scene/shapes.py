"""The geometry of primitives: what an unbound word and its attributes are, before any pose (language.md, section 6)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType
from typing import Any, Protocol

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.runtime.values import Array, MutableArray, MutableList, Pair, Vector, list_items

Point = tuple[float, float, float]
Box = tuple[float, float, float, float, float, float]  # min x, y, z, max x, y, z


class PrimitiveKind(Enum):
    """CUBE: centred box of ``size``. SPHERE: centred, ``radius``. CYLINDER, CONE: solid from ``p0`` to ``p1`` (the
    cone's apex is ``p1``). BOX: the stand-in for a semantic primitive, a centred box of ``size``. CUBOID: Minecraft
    blocks from the origin to ``size``. VOID: deleted blocks, no geometry. ASSET: the mesh of ``asset``."""

    CUBE = "cube"
    SPHERE = "sphere"
    CYLINDER = "cylinder"
    CONE = "cone"
    BOX = "box"
    CUBOID = "cuboid"
    VOID = "void"
    ASSET = "asset"


WORDS = {
    "cube": PrimitiveKind.CUBE,
    "sphere": PrimitiveKind.SPHERE,
    "cylinder": PrimitiveKind.CYLINDER,
    "cone": PrimitiveKind.CONE,
    "set-cuboid": PrimitiveKind.CUBOID,
    "delete-blocks": PrimitiveKind.VOID,
    "asset": PrimitiveKind.ASSET,
}

BLOCK_WORDS = tuple(word for word, kind in WORDS.items() if kind in (PrimitiveKind.CUBOID, PrimitiveKind.VOID))

# The attributes that each geometric primitive reads.
GEOMETRY = {
    "cube": ("scale", "color"),
    "sphere": ("radius", "color"),
    "cylinder": ("radius", "p0", "p1", "color"),
    "cone": ("radius", "p0", "p1", "color"),
}

# The attributes that every primitive with a meaning of its own reads, material aside.
READ: Mapping[str, tuple[str, ...]] = MappingProxyType({
    **GEOMETRY,
    "asset": ("file", "color"),
    "set-cuboid": ("block-type", "block-kwargs", "scale", "fill", "color"),
    "delete-blocks": ("scale",),
})  # fmt: skip

# What each primitive is, in a line.
PRIMITIVES: Mapping[str, str] = MappingProxyType({
    "cube": "a box centred at the origin",
    "sphere": "a ball centred at the origin",
    "cylinder": "a solid cylinder, its axis from :p0 to :p1",
    "cone": "a solid cone, its base around :p0, its apex at :p1",
    "asset": "a mesh file inside the project's folder",
    "set-cuboid": "Minecraft blocks from the origin on, +z forward",
    "delete-blocks": "removes Minecraft blocks from the origin on, +z forward",
})  # fmt: skip

# What each attribute means, in a line.
ATTRIBUTES: Mapping[str, str] = MappingProxyType({
    "scale": "sizes along x, y and z in the scene's units, or one number for all; default [1 1 1]",
    "radius": "the radius in the scene's units, of a cone that of its base; default 1",
    "p0": "where the axis begins, a point [x y z]; default [0 0 0]",
    "p1": "where the axis ends, of a cone its apex, a point [x y z]; default [0 1 0]",
    "color": "reflected light, linear sRGB from 0 to 1; default white; `(color \"ivory\")` converts",
    "file": "the mesh file: .glb .gltf .obj .ply .stl .off, inside the project's folder",
    "block-type": "the kind of block, a string such as \"stone\"",
    "block-kwargs": "the block's states, an association list or table; default none",
    "fill": "#t: all blocks, #f: only those of the six faces; default #t",
})  # fmt: skip


class Support(Protocol):
    """How far something reaches."""

    def interval(self, a: float, b: float, c: float) -> tuple[float, float]:
        """Least and greatest value of ``a x + b y + c z`` over it."""
        ...

    def __len__(self) -> int:
        """How many points decide that."""
        ...


@dataclass(frozen=True, slots=True)
class Asset:
    """A mesh file: its resolved ``path``, the folder ``root`` in which all that it refers to must lie, and the ``box``
    and ``support`` of its vertices."""

    path: str
    root: str
    box: Box
    support: Support


@dataclass(frozen=True, slots=True)
class PrimitiveShape:
    """A primitive's own geometry. Sizes are in the scene's units, ``color`` is linear sRGB in [0, 1]."""

    kind: PrimitiveKind
    size: Point = (1.0, 1.0, 1.0)
    radius: float = 1.0
    p0: Point = (0.0, 0.0, 0.0)
    p1: Point = (0.0, 1.0, 0.0)
    color: Point = (1.0, 1.0, 1.0)
    file: str | None = None  # ASSET only, as the next
    asset: Asset | None = None

    @property
    def root(self) -> str | None:
        """The folder in which what the mesh file refers to lies."""
        return None if self.asset is None else self.asset.root

    @property
    def has_geometry(self) -> bool:
        return self.kind is not PrimitiveKind.VOID

    @property
    def is_flat(self) -> bool:
        """True when the primitive has no extent in some direction."""
        if self.kind in (PrimitiveKind.CUBE, PrimitiveKind.BOX, PrimitiveKind.CUBOID):
            return 0.0 in self.size
        if self.kind in (PrimitiveKind.CYLINDER, PrimitiveKind.CONE):
            return self.radius == 0.0 or self.p0 == self.p1
        return self.kind is PrimitiveKind.SPHERE and self.radius == 0.0


def items_of(value: Any) -> Sequence[Any] | None:
    """The items of whatever may stand for an array of numbers; None for anything else."""
    if isinstance(value, tuple):
        return value
    if type(value) is Pair:
        return list_items(value)
    if isinstance(value, MutableList):
        return value.items
    if isinstance(value, (Array, MutableArray)):
        flat: list[Any] = value.data.ravel().tolist()
        return flat
    return None


def _problem(word: str, name: str, wanted: str) -> SceneError:
    return SceneError("attribute", f'the attribute `:{name}` of "{word}" must be {wanted}')


def _point(word: str, name: str, value: Any, wanted: str = "three finite numbers") -> Point:
    if type(value) is Vector and len(value) == 3 and type(value[0]) is float:
        x, y, z = value
        if math.isfinite(x + y + z):
            return (x, y, z)
    numbers = items_of(value)
    if numbers is None or len(numbers) != 3 or not all(type(x) in (int, float) for x in numbers):
        raise _problem(word, name, wanted)
    try:
        x, y, z = (float(n) for n in numbers)
    except OverflowError:
        raise _problem(word, name, wanted) from None
    if not math.isfinite(x + y + z):
        raise _problem(word, name, wanted)
    return (x, y, z)


def _size(word: str, value: Any) -> Point:
    if type(value) in (int, float):
        value = Vector((value, value, value))
    size = _point(word, "scale", value, "a finite number or three of them")
    return (abs(size[0]), abs(size[1]), abs(size[2]))


def _radius(word: str, value: Any) -> float:
    if type(value) not in (int, float) or not math.isfinite(value):
        raise _problem(word, "radius", "a finite number")
    return abs(float(value))


def _color(word: str, value: Any) -> Point:
    numbers = items_of(value)
    if numbers is not None and len(numbers) > 3:
        value = Vector(numbers[:3])
    r, g, b = _point(word, "color", value, 'three numbers (red, green, blue), as `(color "ivory")` gives')
    if 0.0 <= r <= 1.0 and 0.0 <= g <= 1.0 and 0.0 <= b <= 1.0:
        return (r, g, b)
    return (min(1.0, max(0.0, r)), min(1.0, max(0.0, g)), min(1.0, max(0.0, b)))


def shape_of(word: str, attributes: Mapping[str, Any], asset: Asset | None = None) -> PrimitiveShape:
    """The geometry of the primitive ``word``; raises SceneError where an attribute does not fit it.

    A missing attribute, or one that is ``none``, has the default of language.md, section 6.
    """
    kind = WORDS.get(word, PrimitiveKind.BOX)
    given = {name: value for name, value in attributes.items() if value is not None}
    color = _color(word, given["color"]) if "color" in given else (1.0, 1.0, 1.0)
    if kind is PrimitiveKind.SPHERE:
        return PrimitiveShape(kind, radius=_radius(word, given.get("radius", 1.0)), color=color)
    if kind in (PrimitiveKind.CYLINDER, PrimitiveKind.CONE):
        p0 = _point(word, "p0", given["p0"]) if "p0" in given else (0.0, 0.0, 0.0)
        p1 = _point(word, "p1", given["p1"]) if "p1" in given else (0.0, 1.0, 0.0)
        return PrimitiveShape(kind, radius=_radius(word, given.get("radius", 1.0)), p0=p0, p1=p1, color=color)
    if kind is PrimitiveKind.ASSET:
        return PrimitiveShape(kind, color=color, file=given.get("file"), asset=asset)
    size = _size(word, given["scale"]) if "scale" in given else (1.0, 1.0, 1.0)
    return PrimitiveShape(kind, size=size, color=color)


def default_attributes(shape: PrimitiveShape) -> dict[str, Any]:
    """The attributes that define ``shape``'s geometry, defaults filled in, under their names in the language."""
    if shape.kind is PrimitiveKind.SPHERE:
        return {"radius": shape.radius, "color": list(shape.color)}
    if shape.kind in (PrimitiveKind.CYLINDER, PrimitiveKind.CONE):
        return {"radius": shape.radius, "p0": list(shape.p0), "p1": list(shape.p1), "color": list(shape.color)}
    if shape.kind in (PrimitiveKind.CUBE, PrimitiveKind.BOX):
        return {"scale": list(shape.size), "color": list(shape.color)}
    if shape.kind is PrimitiveKind.CUBOID:
        return {"scale": list(shape.size), "fill": True}
    if shape.kind is PrimitiveKind.VOID:
        return {"scale": list(shape.size)}
    return {"color": list(shape.color)}


def box_under(shape: PrimitiveShape, m: Sequence[float]) -> Box:
    """The exact axis-aligned box of ``shape`` under the affine pose ``m`` (12 floats); closed form per kind.

    An ellipsoid's box is the ellipsoid's; a cylinder is the hull of its two disks, a cone of its disk and apex, a mesh
    of its vertices.
    """
    low, high = [0.0] * 3, [0.0] * 3
    for axis in range(3):
        a, b, c, t = m[4 * axis : 4 * axis + 4]
        low[axis], high[axis] = interval(shape, a, b, c)
        low[axis] += t
        high[axis] += t
    return (low[0], low[1], low[2], high[0], high[1], high[2])


def interval(shape: PrimitiveShape, a: float, b: float, c: float) -> tuple[float, float]:
    """Least and greatest value of ``a x + b y + c z`` over the shape (its support in both directions)."""
    kind = shape.kind
    if kind is PrimitiveKind.CUBE or kind is PrimitiveKind.BOX:
        x, y, z = shape.size
        half = 0.5 * (abs(a) * x + abs(b) * y + abs(c) * z)
        return -half, half
    if kind is PrimitiveKind.SPHERE:
        half = shape.radius * math.sqrt(a * a + b * b + c * c)
        return -half, half
    if kind is PrimitiveKind.CYLINDER or kind is PrimitiveKind.CONE:
        return _round_interval(shape, a, b, c)
    if shape.asset is not None:
        return shape.asset.support.interval(a, b, c)
    x0 = y0 = z0 = 0.0
    x1, y1, z1 = shape.size
    middle = 0.5 * (a * (x0 + x1) + b * (y0 + y1) + c * (z0 + z1))
    half = 0.5 * (abs(a) * (x1 - x0) + abs(b) * (y1 - y0) + abs(c) * (z1 - z0))
    return middle - half, middle + half


def _round_interval(shape: PrimitiveShape, a: float, b: float, c: float) -> tuple[float, float]:
    (x0, y0, z0), (x1, y1, z1) = shape.p0, shape.p1
    u, v, w = x1 - x0, y1 - y0, z1 - z0
    length = math.sqrt(u * u + v * v + w * w)
    start = a * x0 + b * y0 + c * z0
    end = a * x1 + b * y1 + c * z1
    if length == 0.0:
        return start, start
    # |n x d| is the length of d's projection onto the disk's plane, without the cancellation of |d|^2 - (n.d)^2
    i, j, k = v * c - w * b, w * a - u * c, u * b - v * a
    reach = shape.radius * math.sqrt(i * i + j * j + k * k) / length
    apex = reach if shape.kind is PrimitiveKind.CYLINDER else 0.0
    return min(start - reach, end - apex), max(start + reach, end + apex)

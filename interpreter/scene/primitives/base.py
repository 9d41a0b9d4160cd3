"""What a primitive is: its attributes, and everything that can be asked of its geometry (language.md, section 6).

A primitive is one class in one file. It says its word, what it is, its attributes with types, docs and defaults, and
its geometry before any pose. Where it is a canonical form under an affine pose (``placed``), all else follows from the
form; one that only makes triangles (``triangulate``) inherits exact rays, samples, box and volume of its mesh.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Protocol

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.runtime.values import Array, MutableArray, MutableList, Pair, Vector, list_items
from scenelang.interpreter.scene.primitives.lazy import np

if TYPE_CHECKING:
    from scenelang.interpreter.scene.primitives.forms import CanonicalForm, Rows
    from scenelang.interpreter.scene.primitives.mesh import BoolArray, FloatArray, Mesh

Point = tuple[float, float, float]
Box = tuple[float, float, float, float, float, float]  # min x, y, z, max x, y, z

WHITE: Point = (1.0, 1.0, 1.0)
ORIGIN: Point = (0.0, 0.0, 0.0)
FINE = 1e-3  # of a primitive's largest side: how far a mesh that stands for it may lie from its surface


# --- attributes ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Attribute:
    """One attribute of a primitive: its name in the language, what it means (with its default, in a line), its type in
    words and its default. ``read(word, name, value)`` checks a given value and brings it into the form that the
    primitive's ``field`` keeps; it raises SceneError("attribute"). None: no geometry reads it, only backends do."""

    name: str
    doc: str
    type: str
    default: Any = None
    read: Callable[[str, str, Any], Any] | None = None
    field: str = ""
    accepts: tuple[str, ...] = ()
    low: float | None = None
    high: float = math.inf
    aliases: tuple[str, ...] = ()


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


def point_of(word: str, name: str, value: Any, wanted: str = "three finite numbers") -> Point:
    """Three finite numbers."""
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


def size_of(word: str, name: str, value: Any) -> Point:
    """Three sizes, or one for all; signs do not matter."""
    if type(value) in (int, float):
        value = Vector((value, value, value))
    size = point_of(word, name, value, "a finite number or three of them")
    return (abs(size[0]), abs(size[1]), abs(size[2]))


def length_of(word: str, name: str, value: Any) -> float:
    """A finite number, whose sign does not matter."""
    if type(value) not in (int, float) or not math.isfinite(value):
        raise _problem(word, name, "a finite number")
    return abs(float(value))


def color_of(word: str, value: Any) -> Point:
    """The first three numbers, each cut to 0 to 1."""
    numbers = items_of(value)
    if numbers is not None and len(numbers) > 3:
        value = Vector(numbers[:3])
    r, g, b = point_of(word, "color", value, 'three numbers (red, green, blue), as `(color "ivory")` gives')
    if 0.0 <= r <= 1.0 and 0.0 <= g <= 1.0 and 0.0 <= b <= 1.0:
        return (r, g, b)
    return (min(1.0, max(0.0, r)), min(1.0, max(0.0, g)), min(1.0, max(0.0, b)))


SCALE = Attribute(
    "scale", "sizes along x, y and z in the scene's units, or one number for all; default [1 1 1]",
    "a number or three", WHITE, size_of, "size", ("Number", "Triple"), 0.0,
    aliases=("size", "sizes", "dimensions", "dims", "extent", "extents", "half-extents", "scaling"),
)  # fmt: skip
RADIUS = Attribute(
    "radius", "the radius in the scene's units, of a cone that of its base, of a torus that of its ring; default 1",
    "a number", 1.0, length_of, "radius", ("Number",), 0.0, aliases=("r", "rad", "base-radius", "bottom-radius", "r1"),
)  # fmt: skip
P0 = Attribute(
    "p0", "where the axis begins, a point [x y z]; default [0 0 0]", "a point", ORIGIN, point_of, "p0", ("Triple",),
    aliases=("start", "from", "bottom", "base", "begin", "point-a"),
)  # fmt: skip
P1 = Attribute(
    "p1", "where the axis ends, of a cone its apex, a point [x y z]; default [0 1 0]",
    "a point", (0.0, 1.0, 0.0), point_of, "p1", ("Triple",),
    aliases=("end", "to", "top", "tip", "apex", "point-b"),
)  # fmt: skip
COLOR = Attribute(
    "color", "reflected light, linear sRGB from 0 to 1; default white; `(color \"ivory\")` converts",
    "three numbers", WHITE, accepts=("Color",), low=0.0, high=1.0, aliases=("colour", "rgb", "albedo", "base-color", "diffuse"),
)  # fmt: skip

# Attributes of the material, which every primitive has and only backends read.
MATERIALS = (
    Attribute("emission", "radiance, a number (times the colour) or [r g b]; default 0", "a number or three", 0.0,
              accepts=("Number", "Triple"), low=0.0, aliases=("emissive", "glow", "light", "radiance")),
    Attribute("opacity", "from 0 to 1, opaque at 1; default 1", "a number", 1.0, accepts=("Number",), low=0.0, high=1.0,
              aliases=("alpha", "transparency", "transparent")),
    Attribute("metallic", "from 0 to 1: metals reflect their colour; default 0", "a number", 0.0, accepts=("Number",),
              low=0.0, high=1.0, aliases=("metalness", "metal")),
    Attribute("roughness", "from 0, polished, to 1, rough; default matte, without highlights", "a number",
              accepts=("Number",), low=0.0, high=1.0, aliases=("shininess", "glossiness", "smoothness")),
    Attribute("ior", "index of refraction, 1 to 4: glossy, refracts what `:opacity` lets through; default none",
              "a number", accepts=("Number",), low=1.0, high=4.0, aliases=("refraction", "index-of-refraction")),
)  # fmt: skip


# --- primitives ------------------------------------------------------------------------------------------------------


class Support(Protocol):
    """How far something reaches."""

    def interval(self, a: float, b: float, c: float) -> tuple[float, float]:
        """Least and greatest value of ``a x + b y + c z`` over it."""
        ...

    def __len__(self) -> int:
        """How many points decide that."""
        ...


class Placed(NamedTuple):
    """A canonical form with its ratios, and the pose (12 floats) that takes it to the primitive's own frame."""

    form: CanonicalForm
    ratios: tuple[float, ...]
    rows: Rows

    @property
    def matrix(self) -> FloatArray:
        """The pose (3, 4)."""
        return np.array(self.rows, np.float64).reshape(3, 4)


class Symmetry(NamedTuple):
    """What of a primitive's pose can be told apart when two scenes are compared (see ``difference``).

    ``ends``: its :p0 and :p1 and the cross-section between them. ``edges``: directions of edges that are alike, as a
    cube's. ``whole``: nothing is known of its symmetries.
    """

    ends: bool = False
    edges: bool = False
    whole: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Primitive:
    """A primitive with its parameters, defaults filled in. Sizes are in the scene's units, ``color`` is linear sRGB in
    [0, 1]. Every method speaks of the primitive's own frame.

    A class for a new word sets ``word``, ``doc`` and ``attributes``, keeps one field for each attribute that its
    geometry reads, and writes ``placed`` or ``triangulate``. ``interval``, ``contains`` and others may be written too,
    where a closed form beats what the mesh gives. It is a frozen dataclass.
    """

    word: ClassVar[str] = ""
    doc: ClassVar[str] = ""  # what it is, in a line
    attributes: ClassVar[tuple[Attribute, ...]] = ()  # but for the color
    is_solid: ClassVar[bool] = True  # its attributes alone say what is seen
    is_semantic: ClassVar[bool] = False  # a box that stands for a word without geometry
    is_block: ClassVar[bool] = False  # a part of a Minecraft build
    is_file: ClassVar[bool] = False  # a mesh file that must be found and measured
    has_geometry: ClassVar[bool] = True
    has_color: ClassVar[bool] = True
    meaning: ClassVar[str | None] = None  # what people call it, where that is not its word
    turn: ClassVar[Symmetry] = Symmetry(whole=True)

    color: Point = WHITE

    @classmethod
    def made(cls, word: str, given: Mapping[str, Any], asset: Any = None) -> Primitive:
        """The primitive of the attributes ``given``; raises SceneError where one does not fit. One that is missing, or
        ``none``, has its default."""
        found = {}
        for attribute in cls.attributes:
            if attribute.read is not None and (value := given.get(attribute.name)) is not None:
                found[attribute.field or attribute.name] = attribute.read(word, attribute.name, value)
        if (value := given.get("color")) is not None:
            found["color"] = color_of(word, value)
        return cls(**found)

    @classmethod
    def attribute_names(cls) -> tuple[str, ...]:
        """The attributes that it reads, material aside."""
        own = tuple(attribute.name for attribute in cls.attributes)
        return (*own, "color") if cls.has_color else own

    def defining(self) -> dict[str, Any]:
        """The attributes that define the geometry, defaults filled in, under their names in the language, plain."""
        found: dict[str, Any] = {}
        for attribute in self.attributes:
            if attribute.read is not None:
                value = getattr(self, attribute.field or attribute.name)
                found[attribute.name] = list(value) if isinstance(value, tuple) else value
        return {**found, "color": list(self.color)} if self.has_color else found

    @property
    def key(self) -> Primitive:
        """What the geometry depends on: the primitive without its colour."""
        return self if self.color == WHITE else replace(self, color=WHITE)

    def own_color(self, word: str, attributes: Mapping[str, Any]) -> tuple[str, float, float] | None:
        """Where backends choose the colour of what names none: a text that decides it, HSV saturation and value."""
        return None

    def name_of(self, word: str) -> str | None:
        """What people call it, where neither its word nor its ``meaning`` says that."""
        return self.meaning

    @classmethod
    def compared(cls, given: Mapping[str, Any]) -> tuple[str, tuple[float, float, float] | None]:
        """For comparing scenes, of plain attributes: a text that is equal where no pose makes the primitives equal
        unless they are, and the sizes (None: those of :scale)."""
        if cls.turn.whole and cls.is_solid:
            names = (attribute.name for attribute in cls.attributes if attribute.read is not None)
            return " ".join(f"{name} {given.get(name.replace('-', '_'))}" for name in names), WHITE
        return "", None

    # --- how far it reaches ---

    @property
    def is_flat(self) -> bool:
        """True when the primitive has no extent in some direction."""
        x0, y0, z0, x1, y1, z1 = self.box_under((1.0, 0, 0, 0, 0, 1.0, 0, 0, 0, 0, 1.0, 0))
        return x0 == x1 or y0 == y1 or z0 == z1

    @property
    def cost(self) -> int:
        """The steps that asking how far it reaches counts for."""
        return 1 if type(self).interval is not Primitive.interval else 64

    def interval(self, a: float, b: float, c: float) -> tuple[float, float]:
        """Least and greatest value of ``a x + b y + c z`` over it (its support in both directions)."""
        along = mesh_of(self).vertices @ np.array((a, b, c))
        return (float(along.min()), float(along.max())) if len(along) else (0.0, 0.0)

    def box_under(self, m: Sequence[float]) -> Box:
        """Its exact axis-aligned box under the affine pose ``m`` (12 floats)."""
        x0, x1 = self.interval(m[0], m[1], m[2])
        y0, y1 = self.interval(m[4], m[5], m[6])
        z0, z1 = self.interval(m[8], m[9], m[10])
        return (x0 + m[3], y0 + m[7], z0 + m[11], x1 + m[3], y1 + m[7], z1 + m[11])

    @property
    def extent(self) -> float:
        """The largest side of its box."""
        x0, y0, z0, x1, y1, z1 = self.box_under((1.0, 0, 0, 0, 0, 1.0, 0, 0, 0, 0, 1.0, 0))
        return max(x1 - x0, y1 - y0, z1 - z0)

    # --- its surface ---

    def placed(self) -> Placed | None:
        """The canonical form that it is, under a pose; None where it is none, or there is nothing to see."""
        return None

    def triangulate(self, tolerance: float) -> Mesh:
        """Its closed surface, at most ``tolerance`` from the true one; empty where there is nothing to see."""
        from scenelang.interpreter.scene.primitives.forms import segments_within
        from scenelang.interpreter.scene.primitives.mesh import empty, posed

        placed = self.placed()
        if placed is None:
            return empty()
        radius = max(math.sqrt(sum(x * x for x in placed.rows[k::4])) for k in range(3))
        mesh = placed.form.mesh(segments_within(tolerance, radius), placed.ratios)
        return posed(mesh, placed.matrix[None])

    def intersect(self, origins: FloatArray, directions: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The least ray parameter (N,) above 0 at which rays (N, 3) meet the surface, infinity where they do not, and
        the outward unit normals (N, 3) there, zero where there are none."""
        from scenelang.interpreter.scene.primitives.forms import nearest_hit, unit
        from scenelang.interpreter.scene.primitives.mesh import first_hits, inverses_of, triangle_normals

        normals = np.zeros(origins.shape)
        placed = self.placed()
        if placed is None:
            corners = mesh_of(self).corners
            t, which = first_hits(corners, origins, directions)
            normals[which >= 0] = triangle_normals(corners)[which[which >= 0]]
            return t, normals
        inverse = inverses_of(placed.matrix[None, :, :3])[0]
        o, d = (origins - placed.matrix[:, 3]) @ inverse.T, directions @ inverse.T
        with np.errstate(all="ignore"):
            found = nearest_hit(
                placed.form, (o[:, 0], o[:, 1], o[:, 2]), (d[:, 0], d[:, 1], d[:, 2]), placed.ratios, 0.0
            )
        t = np.asarray(found, np.float64)
        hit = np.flatnonzero(np.isfinite(t))
        points = o[hit] + t[hit, None] * d[hit]
        normals[hit] = unit(placed.form.normals(points, placed.ratios) @ inverse)
        return t, normals

    def sample(self, count: int, rng: Any) -> tuple[FloatArray, FloatArray]:
        """``count`` points that lie uniformly on the surface, and the outward unit normals there, (K, 3) each; none
        where it has no area. ``rng`` is a ``numpy.random.Generator``."""
        from scenelang.interpreter.scene.primitives.mesh import sampled

        placed = self.placed()
        if placed is None:
            return sampled(mesh_of(self), count, rng)
        axes, half = _stretched(placed)
        charts = placed.form.charts(half, placed.ratios)
        areas = np.array([chart.area for chart in charts])
        if not areas.sum() > 0.0:
            return np.zeros((0, 3)), np.zeros((0, 3))
        shares = rng.multinomial(count, areas / areas.sum())
        found = [chart.place(rng.random(n), rng.random(n)) for chart, n in zip(charts, shares.tolist(), strict=True)]
        points, normals = (np.concatenate([each[k] for each in found]) for k in (0, 1))
        return points @ axes.T + placed.matrix[:, 3], normals @ axes.T

    # --- its inside ---

    def contains(self, points: FloatArray) -> BoolArray:
        """Whether points (N, 3) lie inside it or on its surface."""
        from scenelang.interpreter.scene.primitives.mesh import encloses, inverses_of

        placed = self.placed()
        if placed is None:
            return encloses(mesh_of(self).corners, points)
        local = (points - placed.matrix[:, 3]) @ inverses_of(placed.matrix[None, :, :3])[0].T
        return placed.form.contains(local[:, 0], local[:, 1], local[:, 2], placed.ratios)

    def volume(self) -> float:
        """What it encloses, in cubes of the scene's units."""
        from scenelang.interpreter.scene.primitives.mesh import volume_of

        placed = self.placed()
        if placed is None:
            return volume_of(mesh_of(self).corners)
        return placed.form.volume(placed.ratios) * abs(float(np.linalg.det(placed.matrix[:, :3])))

    def area(self) -> float:
        """The area of its surface, in squares of the scene's units."""
        from scenelang.interpreter.scene.primitives.mesh import areas_of

        placed = self.placed()
        if placed is None:
            return float(areas_of(mesh_of(self).corners).sum())
        return sum(chart.area for chart in placed.form.charts(_stretched(placed)[1], placed.ratios))


def _stretched(placed: Placed) -> tuple[FloatArray, list[float]]:
    """The axes (3, 3) of a primitive's pose as unit columns, and their lengths."""
    linear = placed.matrix[:, :3]
    half = np.linalg.norm(linear, axis=0)
    axes: FloatArray = np.where(half > 0.0, linear / np.where(half > 0.0, half, 1.0), np.eye(3))
    return axes, half.tolist()


def mesh_of(primitive: Primitive) -> Mesh:
    """The triangles of a primitive that only has these; made once."""
    return _made_mesh(primitive.key)


@lru_cache(maxsize=64)
def _made_mesh(primitive: Primitive) -> Mesh:
    rough = primitive.triangulate(math.inf)
    size = float(np.ptp(rough.vertices, axis=0).max()) if len(rough.vertices) else 0.0
    return primitive.triangulate(FINE * size) if size > 0.0 else rough


def is_field_of(cls: type[Primitive], name: str) -> bool:
    """Whether ``name`` is a field of a primitive's class."""
    return any(field.name == name for field in fields(cls))

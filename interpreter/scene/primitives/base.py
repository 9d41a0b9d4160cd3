"""Protocol of primitives: attributes and geometry (docs/language.md, "Geometry").

A primitive is one class in one file. It defines its word, a description, its attributes with types, descriptions and
defaults, and its geometry in the local frame. If it is a canonical form under an affine pose (``placed``), all other
methods are derived from the form; a class that only implements ``triangulate`` inherits rays, samples, box and volume
that are exact for its mesh.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Protocol

from scenelang.grammar.datum import dataclass, fields, replace
from scenelang.grammar.diagnostics import SceneError, suggest
from scenelang.interpreter.loading import np
from scenelang.interpreter.scene.primitives.substances import DENSITIES, SUBSTANCES
from scenelang.interpreter.scene.primitives.textures import Texture, texture
from scenelang.interpreter.values.values import Array, MutableArray, MutableList, Pair, Vector, list_items

if TYPE_CHECKING:
    from scenelang.interpreter.scene.primitives.forms import CanonicalForm, Rows
    from scenelang.interpreter.scene.primitives.mesh import BoolArray, FloatArray, Mesh

Point = tuple[float, float, float]
Box = tuple[float, float, float, float, float, float]  # min x, y, z, max x, y, z

_MESH_QUERY_STEPS = 64  # steps of a support query over the vertices of a mesh
WHITE: Point = (1.0, 1.0, 1.0)
ORIGIN: Point = (0.0, 0.0, 0.0)
MESH_TOLERANCE = 1e-3  # maximum distance of an approximating mesh from the surface, relative to the largest side


# --- attributes ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Attribute:
    """Attribute of a primitive.

    Attributes
    ----------
    name
        Name in the language.
    doc
        One-line description, including the default.
    type
        Description of the type.
    default
        Default value.
    read
        ``read(word, name, value)`` validates and converts a value; it raises ``SceneError("attribute")``. None for an
        attribute that only backends use.
    field
        Field of the primitive that stores the converted value, if its name differs.
    accepts
        Types of the language that the checker accepts.
    low, high
        Range of sensible numbers, for warnings of the checker.
    aliases
        Names of the attribute in other tools, for "did you mean" hints.
    former
        Name in earlier versions, which a fix replaces (docs/decisions.md, "Names of the field").
    needed
        Text of a value, if the primitive is nothing without the attribute: for the hint of the error.
    """

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
    former: str = ""
    needed: str = ""


def items_of(value: Any) -> Sequence[Any] | None:
    """Return the items of any sequence or array of numbers, or None for other values."""
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


def _invalid(word: str, name: str, expected: str) -> SceneError:
    """Return the error for an invalid attribute value."""
    return SceneError("attribute", f'the attribute `:{name}` of "{word}" must be {expected}')


def point_of(word: str, name: str, value: Any, expected: str = "three finite numbers") -> Point:
    """Convert ``value`` to three finite numbers.

    Parameters
    ----------
    word, name
        Word of the call, and attribute that the error message names.
    value
        Vector, array or list.
    expected
        What the attribute expects, for the error message.

    Raises
    ------
    SceneError
        "attribute" if the value is something else.
    """
    if type(value) is Vector and len(value) == 3 and type(value[0]) is float:
        x, y, z = value
        if math.isfinite(x + y + z):
            return (x, y, z)
    numbers = items_of(value)
    if numbers is None or len(numbers) != 3 or not all(type(x) in (int, float) for x in numbers):
        raise _invalid(word, name, expected)
    try:
        x, y, z = (float(n) for n in numbers)
    except OverflowError:
        raise _invalid(word, name, expected) from None
    if not math.isfinite(x + y + z):
        raise _invalid(word, name, expected)
    return (x, y, z)


def triple_of(word: str, name: str, value: Any) -> Point:
    """Convert a number or three numbers to three numbers: one number counts for all axes.

    ``word`` and ``name`` are the word of the call and the attribute, for the message of SceneError("attribute"), which
    is raised for anything else.
    """
    if type(value) in (int, float):
        value = Vector((value, value, value))
    return point_of(word, name, value, "a finite number or three finite numbers")


def size_of(word: str, name: str, value: Any) -> Point:
    """Convert a number, or three numbers, to three absolute sizes; raise SceneError("attribute") for anything else.

    ``word`` and ``name`` are the word of the call and the attribute, for the message.
    """
    size = triple_of(word, name, value)
    return (abs(size[0]), abs(size[1]), abs(size[2]))


def number_of(word: str, name: str, value: Any) -> float:
    """Convert ``value`` to a finite number.

    Raises SceneError("attribute"), which names the attribute ``name`` and the ``word`` of the call, for anything else.
    """
    if type(value) not in (int, float) or not math.isfinite(value):
        raise _invalid(word, name, "a finite number")
    return float(value)


def length_of(word: str, name: str, value: Any) -> float:
    """Return the absolute value of a finite number; raise SceneError("attribute") for anything else.

    ``word`` and ``name`` are the word of the call and the attribute, for the message.
    """
    return abs(number_of(word, name, value))


def linear(encoded: float) -> float:
    """Return the linear light of an sRGB component from 0 to 1 (IEC 61966-2-1); ``encoded`` is the inverse."""
    return encoded / 12.92 if encoded <= 0.04045 else float(((encoded + 0.055) / 1.055) ** 2.4)


def encoded(light: float) -> float:
    """Return a component of linear light, 0 to 1, as sRGB."""
    return light * 12.92 if light <= 0.0031308 else float(1.055 * light ** (1 / 2.4) - 0.055)


def color_of(word: str, value: Any, name: str = "color") -> Point:
    """Convert the value of a color attribute to linear sRGB: its first three numbers, clamped to [0, 1].

    Raises SceneError("attribute"), which names the ``word`` of the call and the attribute, for other values.
    """
    numbers = items_of(value)
    if numbers is not None and len(numbers) > 3:
        value = Vector(numbers[:3])
    r, g, b = point_of(word, name, value, 'three numbers (red, green, blue), as `(color "ivory")` gives')
    if 0.0 <= r <= 1.0 and 0.0 <= g <= 1.0 and 0.0 <= b <= 1.0:
        return (r, g, b)
    return (min(1.0, max(0.0, r)), min(1.0, max(0.0, g)), min(1.0, max(0.0, b)))


def material_of(word: str, name: str, value: Any) -> str:
    """Return ``value`` if it is the name of a substance; otherwise raise SceneError("attribute").

    ``word`` and ``name`` are the word of the call and the attribute, for the message.
    """
    if type(value) is not str:
        raise _invalid(word, name, 'the name of a material, as "oak" or "brushed steel"')
    return _substance(word, name, value, SUBSTANCES)


def _substance(word: str, name: str, value: str, known: Mapping[str, Any]) -> str:
    """Return ``value`` if it is one of the ``known`` substances; otherwise raise SceneError("attribute")."""
    if value not in known:
        raise SceneError(
            "attribute", f'the attribute `:{name}` of "{word}" names no known substance: "{value}"',
            suggest(value, known) or f"known substances: {', '.join(known)}",
        )  # fmt: skip
    return value


def texture_of(word: str, name: str, value: Any, where: str | None = None) -> Texture:
    """Return the texture that the value of an attribute describes.

    ``word`` and ``name`` are the word of the call and the attribute, for the message of SceneError("attribute"), which
    is raised for an unknown pattern and an invalid setting. ``where`` replaces them there.
    """
    where = where or f'the attribute `:{name}` of "{word}"'
    if type(value) is str:
        return texture(value, {}, where)
    parts = list(items_of(value) or ())
    if not parts or type(parts[0]) is not str or len(parts) % 2 == 0:
        raise _invalid(word, name, 'the name of a pattern, as "brick", of an image, or `(texture "brick" :scale 0.3)`')
    settings = dict(zip(map(str, parts[1::2]), parts[2::2], strict=True))
    if settings.get("colors") is not None:
        colors = items_of(settings["colors"]) or ()
        if len(colors) == 6:  # the rows of an array, as in [[1 0 0] [0 0 1]]
            colors = (Vector(colors[:3]), Vector(colors[3:]))
        if len(colors) != 2:
            raise SceneError("attribute", f"`:colors` of {where} must be two colors")
        settings["colors"] = tuple(color_of(word, color, "colors") for color in colors)
    if settings.get("at") is not None:
        settings["at"] = items_of(settings["at"]) or ()
    return texture(parts[0], settings, where)


SCALE = Attribute(
    "scale", "side lengths along x, y and z in scene units, or one number for all three; default [1 1 1]",
    "a number or three", WHITE, size_of, "size", ("Number", "Triple"), 0.0,
    aliases=("size", "sizes", "dimensions", "dims", "extent", "extents", "half-extents", "scaling"),
)  # fmt: skip
RADIUS = Attribute(
    "radius", "radius in scene units (of a cone: of its base; of a torus: of its ring); default 1",
    "a number", 1.0, length_of, "radius", ("Number",), 0.0, aliases=("r", "rad", "base-radius", "bottom-radius", "r1"),
)  # fmt: skip
P0 = Attribute(
    "p0", "start point [x y z] of the axis; default [0 0 0]", "a point", ORIGIN, point_of, "p0", ("Triple",),
    aliases=("start", "from", "bottom", "base", "begin", "point-a"),
)  # fmt: skip
P1 = Attribute(
    "p1", "end point [x y z] of the axis, for a cone its apex; default [0 1 0]",
    "a point", (0.0, 1.0, 0.0), point_of, "p1", ("Triple",),
    aliases=("end", "to", "top", "tip", "apex", "point-b"),
)  # fmt: skip
COLOR = Attribute(
    "color", "diffuse reflectance in linear sRGB, each from 0 to 1; default white; `(color \"ivory\")` converts a name",
    "three numbers", WHITE, accepts=("Color",), low=0.0, high=1.0,
    aliases=("colour", "rgb", "albedo", "base-color", "diffuse"),
)  # fmt: skip

# Attributes of the material, which every primitive has. Only backends use them; all are checked where they are given.
MATERIALS = (
    Attribute("emission", "radiance, a number (times the color) or [r g b]; default 0", "a number or three", 0.0,
              triple_of, accepts=("Number", "Triple"), low=0.0, aliases=("emissive", "glow", "light", "radiance")),
    Attribute("opacity", "from 0, transparent, to 1: light that each surface stops; default 1", "a number", 1.0,
              number_of, accepts=("Number",), low=0.0, high=1.0, aliases=("alpha", "transparency", "transparent")),
    Attribute("metallic", "from 0 to 1: metals reflect their color; default 0", "a number", 0.0, number_of,
              accepts=("Number",), low=0.0, high=1.0, aliases=("metalness", "metal")),
    Attribute("roughness", "from 0, polished, to 1, rough; default matte, without highlights", "a number", None,
              number_of, accepts=("Number",), low=0.0, high=1.0, aliases=("shininess", "glossiness", "smoothness")),
    Attribute("ior", "index of refraction, 1 to 4: glossy, refracts what `:opacity` lets through; default none",
              "a number", None, number_of, accepts=("Number",), low=1.0, high=4.0,
              aliases=("refraction", "index-of-refraction")),
    Attribute("coat", "from 0 to 1: a clear varnish; default 0", "a number", 0.0, number_of,
              accepts=("Number",), low=0.0, high=1.0, aliases=("clearcoat", "clear-coat", "varnish", "lacquer")),
    Attribute("sheen", "from 0 to 1: the bright rim of fabric; default 0", "a number", 0.0, number_of,
              accepts=("Number",), low=0.0, high=1.0, aliases=("fuzz", "velvet")),
    Attribute("material", 'a substance, as "oak" or "brushed steel", for what no other attribute sets; default none',
              "a string", None, material_of, accepts=("String",), aliases=("substance", "made-of")),
    Attribute("texture", 'a pattern, as "brick", an image, or `(texture "brick" :scale 0.3)`; default none',
              "a string or a list", None, texture_of, accepts=("String", "List"), aliases=("pattern", "map", "image")),
)  # fmt: skip


def boolean_of(word: str, name: str, value: Any) -> bool:
    """Return ``value`` if it is a boolean; otherwise raise SceneError("attribute").

    ``word`` and ``name`` are the word of the call and the attribute, for the message.
    """
    if type(value) is not bool:
        raise _invalid(word, name, "#t or #f")
    return value


def positive_of(word: str, name: str, value: Any) -> float:
    """Return ``value`` if it is a finite number above 0; otherwise raise SceneError("attribute").

    ``word`` and ``name`` are the word of the call and the attribute, for the message.
    """
    if type(value) not in (int, float) or not 0.0 < value < math.inf:
        raise _invalid(word, name, "a finite number above 0")
    return float(value)


def friction_of(word: str, name: str, value: Any) -> float:
    """Return ``value`` if it is a finite number of at least 0; otherwise raise SceneError("attribute").

    ``word`` and ``name`` are the word of the call and the attribute, for the message.
    """
    if type(value) not in (int, float) or not 0.0 <= value < math.inf:
        raise _invalid(word, name, "a finite number, 0 or more")
    return float(value)


def density_of(word: str, name: str, value: Any) -> float:
    """Convert a number in kg/m³, or the name of a substance, to a density in kg/m³.

    Raises SceneError("attribute"), which names the attribute ``name`` and the ``word`` of the call, for other values.
    """
    if type(value) is str:
        return DENSITIES[_substance(word, name, value, DENSITIES)]
    return positive_of(word, name, value)


# Attributes of physics (docs/physics.md), which any entity may have: calls of bound words too, whatever parameters
# their functions have. Only simulations read them.
PHYSICS = (
    Attribute("fixed", "for simulations: whether it is one body that cannot move; default #f", "#t or #f", False,
              boolean_of, accepts=("Boolean",), aliases=("static", "anchored")),
    Attribute("floating", "for checks and simulations: whether it stays where it is without support, as a cloud does; "
              "default #f", "#t or #f", False, boolean_of, accepts=("Boolean",), aliases=("flying", "hovering")),
    Attribute("body", "for simulations: #t, it is one rigid body; #f, its parts are separate; default: by contact",
              "#t or #f", None, boolean_of, accepts=("Boolean",), aliases=("rigid",)),
    Attribute("mass", "for simulations: mass in kg of all that is in it; default: by density", "a number", None,
              positive_of, accepts=("Number",), low=0.0, aliases=("weight",)),
    Attribute("density", 'for simulations: density in kg/m^3, or a substance, as "oak" or "steel"; default 1000',
              "a number or a string", 1000.0, density_of, accepts=("Number", "String"), low=0.0),
    Attribute("friction", "for simulations: coefficient of sliding friction; default 0.6", "a number", 0.6,
              friction_of, accepts=("Number",), low=0.0),
)  # fmt: skip


# --- primitives ------------------------------------------------------------------------------------------------------


class Support(Protocol):
    """Support function of a shape."""

    def interval(self, a: float, b: float, c: float) -> tuple[float, float]:
        """Return the minimum and maximum of ``a x + b y + c z`` over the shape."""
        ...

    def __len__(self) -> int:
        """Return the number of points that determine the support."""
        ...


class Placed(NamedTuple):
    """Canonical form with its ratios, and the pose (12 floats) from the frame of the form to that of the primitive."""

    form: CanonicalForm
    ratios: tuple[float, ...]
    rows: Rows

    @property
    def matrix(self) -> FloatArray:
        """Pose as an array (3, 4)."""
        return np.array(self.rows, np.float64).reshape(3, 4)


class Symmetry(NamedTuple):
    """Aspects of a primitive's orientation that the comparison of scenes distinguishes (see ``difference``).

    Attributes
    ----------
    axis
        The endpoints :p0 and :p1, and the cross-section between them.
    edges
        The directions of equivalent edges, as for a cube.
    unknown
        Everything, because no symmetry is known.
    """

    axis: bool = False
    edges: bool = False
    unknown: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Primitive:
    """Primitive with its parameters, with defaults filled in.

    Sizes are in scene units, ``color`` is linear sRGB in [0, 1]. All methods use the local frame of the primitive.

    A class for a new word is a frozen dataclass that sets ``word``, ``doc`` and ``attributes``, has one field for each
    attribute that its geometry depends on, and implements ``placed`` or ``triangulate``. It may override ``interval``,
    ``contains`` and other methods with closed forms.
    """

    word: ClassVar[str] = ""
    doc: ClassVar[str] = ""  # one-line description
    attributes: ClassVar[tuple[Attribute, ...]] = ()  # without the color
    is_solid: ClassVar[bool] = True  # the attributes alone determine the appearance
    is_semantic: ClassVar[bool] = False  # a placeholder box for a word without geometry
    is_block: ClassVar[bool] = False  # made of Minecraft blocks
    is_file: ClassVar[bool] = False  # a mesh file that must be located and measured
    has_geometry: ClassVar[bool] = True
    is_remnant: ClassVar[bool] = False  # left by a change of the scene, so that no program or data can describe it
    has_color: ClassVar[bool] = True
    common_name: ClassVar[str | None] = None  # noun for prompts, if it differs from the word
    symmetry: ClassVar[Symmetry] = Symmetry(unknown=True)

    color: Point = WHITE
    image: str | None = None  # path of the image of the texture

    @classmethod
    def from_attributes(cls, word: str, attributes: Mapping[str, Any], asset: Any = None) -> Primitive:
        """Create the primitive of a call.

        Parameters
        ----------
        word
            Word of the call, for error messages.
        attributes
            Values by name; missing ones and ``none`` mean the defaults.
        asset
            Metadata of the mesh file; only the primitive "mesh" uses it.

        Raises
        ------
        SceneError
            "attribute" if an attribute is invalid.
        """
        values = {}
        for attribute in cls.attributes:
            if attribute.read is not None and (value := attributes.get(attribute.name)) is not None:
                values[attribute.field or attribute.name] = attribute.read(word, attribute.name, value)
        if (value := attributes.get("color")) is not None:
            values["color"] = color_of(word, value)
        elif (value := attributes.get("material")) is not None and cls.has_color:
            values["color"] = SUBSTANCES[material_of(word, "material", value)].color
        if (value := attributes.get("texture")) is not None and cls.has_color:
            chosen = texture_of(word, "texture", value)
            values["image"] = chosen.name if chosen.is_image else None
        for attribute in MATERIALS if cls.is_semantic else (*MATERIALS, *PHYSICS):
            if attribute.read is not None and (value := attributes.get(attribute.name)) is not None:
                attribute.read(word, attribute.name, value)
        return cls(**values)

    @classmethod
    def attribute_names(cls) -> tuple[str, ...]:
        """Return the names of the attributes, except those of the material."""
        names = tuple(attribute.name for attribute in cls.attributes)
        return (*names, "color") if cls.has_color else names

    def defining_attributes(self) -> dict[str, Any]:
        """Return the attributes that determine the geometry as plain data, by language name, with defaults filled in.

        The color is among them, if the primitive has one.
        """
        values: dict[str, Any] = {}
        for attribute in self.attributes:
            if attribute.read is not None:
                value = getattr(self, attribute.field or attribute.name)
                values[attribute.name] = list(value) if isinstance(value, tuple) else value
        return {**values, "color": list(self.color)} if self.has_color else values

    @property
    def own_texture(self) -> Texture | None:
        """Texture of a surface that no attribute gives it, such as the image of a mesh file."""
        return None

    @property
    def key(self) -> Primitive:
        """Primitive without its color and image, a cache key for its geometry."""
        return self if self.color == WHITE and self.image is None else replace(self, color=WHITE, image=None)

    def color_seed(self, word: str, attributes: Mapping[str, Any]) -> tuple[str, float, float] | None:
        """Return the seed of the default color: a text that determines the hue, HSV saturation and value.

        Returns None to use ``color``.
        """
        return None

    def display_name(self, word: str) -> str | None:
        """Return the noun for this primitive in prompts, or None to use the word."""
        return self.common_name

    @classmethod
    def comparison_key(cls, given: Mapping[str, Any]) -> tuple[str, tuple[float, float, float] | None]:
        """Return a key and the sizes that comparisons of scenes use (``inspection/difference``).

        Primitives with different keys are never equal, whatever their poses. The sizes are None if they are those of
        :scale.
        """
        if cls.symmetry.unknown and cls.is_solid:
            names = (attribute.name for attribute in cls.attributes if attribute.read is not None)
            return " ".join(f"{name} {given.get(name.replace('-', '_'))}" for name in names), WHITE
        return "", None

    # --- extent ---

    @property
    def is_flat(self) -> bool:
        """Whether the extent along some axis is zero."""
        x0, y0, z0, x1, y1, z1 = self.box_under((1.0, 0, 0, 0, 0, 1.0, 0, 0, 0, 0, 1.0, 0))
        return x0 == x1 or y0 == y1 or z0 == z1

    @property
    def cost(self) -> int:
        """Number of evaluation steps that a support query costs."""
        return 1 if type(self).interval is not Primitive.interval else _MESH_QUERY_STEPS

    def interval(self, a: float, b: float, c: float) -> tuple[float, float]:
        """Return the minimum and maximum of ``a x + b y + c z`` over the primitive.

        That is its support function in the direction (a, b, c), not necessarily of length 1, and in the opposite one.
        """
        along = mesh_of(self).vertices @ np.array((a, b, c))
        return (float(along.min()), float(along.max())) if len(along) else (0.0, 0.0)

    def box_under(self, m: Sequence[float]) -> Box:
        """Return the exact axis-aligned bounding box under the affine pose ``m`` (12 floats)."""
        x0, x1 = self.interval(m[0], m[1], m[2])
        y0, y1 = self.interval(m[4], m[5], m[6])
        z0, z1 = self.interval(m[8], m[9], m[10])
        return (x0 + m[3], y0 + m[7], z0 + m[11], x1 + m[3], y1 + m[7], z1 + m[11])

    @property
    def extent(self) -> float:
        """Longest side of the bounding box."""
        x0, y0, z0, x1, y1, z1 = self.box_under((1.0, 0, 0, 0, 0, 1.0, 0, 0, 0, 0, 1.0, 0))
        return max(x1 - x0, y1 - y0, z1 - z0)

    # --- surface ---

    def placed(self) -> Placed | None:
        """Return the canonical form with its pose, or None if there is none or the primitive is invisible."""
        return None

    def triangulate(self, tolerance: float) -> Mesh:
        """Return the closed surface as a mesh within ``tolerance`` of the true surface.

        The mesh is empty if the primitive is invisible.
        """
        from scenelang.interpreter.scene.primitives.mesh import empty, posed

        placed = self.placed()
        if placed is None:
            return empty()
        radius = max(math.sqrt(sum(x * x for x in placed.rows[k::4])) for k in range(3))  # the longest half axis
        mesh = placed.form.mesh(placed.form.segments_within(tolerance, radius), placed.ratios)
        return posed(mesh, placed.matrix[None])

    def intersect(self, origins: FloatArray, directions: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Intersect rays with the surface.

        Parameters
        ----------
        origins, directions : (N, 3)
            Rays.

        Returns
        -------
        t : (N,)
            Smallest positive ray parameter of an intersection; infinity for a miss.
        normals : (N, 3)
            Outward unit normals; zero for a miss.
        """
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
            start, ray = (o[:, 0], o[:, 1], o[:, 2]), (d[:, 0], d[:, 1], d[:, 2])
            t = np.asarray(nearest_hit(placed.form, start, ray, placed.ratios, 0.0), np.float64)
        hit = np.flatnonzero(np.isfinite(t))
        points = o[hit] + t[hit, None] * d[hit]
        normals[hit] = unit(placed.form.normals(points, placed.ratios) @ inverse)
        return t, normals

    def sample(self, count: int, rng: Any) -> tuple[FloatArray, FloatArray]:
        """Sample points uniformly from the surface.

        Parameters
        ----------
        count
            Number of points K.
        rng
            A ``numpy.random.Generator``.

        Returns
        -------
        points, normals : (K, 3)
            Points and outward unit normals; empty if the surface has no area.
        """
        from scenelang.interpreter.scene.primitives.mesh import sample_surface

        placed = self.placed()
        if placed is None:
            return sample_surface(mesh_of(self), count, rng)
        axes, half = _axes_and_lengths(placed)
        charts = placed.form.charts(half, placed.ratios)
        areas = np.array([chart.area for chart in charts])
        if not areas.sum() > 0.0:
            return np.zeros((0, 3)), np.zeros((0, 3))
        shares = rng.multinomial(count, areas / areas.sum())
        samples = [chart.place(rng.random(n), rng.random(n)) for chart, n in zip(charts, shares.tolist(), strict=True)]
        points, normals = (np.concatenate(arrays) for arrays in zip(*samples))
        return points @ axes.T + placed.matrix[:, 3], normals @ axes.T

    # --- interior ---

    def contains(self, points: FloatArray) -> BoolArray:
        """Return for each of the ``points`` (N, 3) whether it is inside or on the surface.

        There is no tolerance, so for points on the surface, rounding errors decide.
        """
        from scenelang.interpreter.scene.primitives.mesh import encloses, inverses_of

        placed = self.placed()
        if placed is None:
            return encloses(mesh_of(self).corners, points)
        local = (points - placed.matrix[:, 3]) @ inverses_of(placed.matrix[None, :, :3])[0].T
        return placed.form.contains(local[:, 0], local[:, 1], local[:, 2], placed.ratios)

    def volume(self) -> float:
        """Return the enclosed volume in cubic scene units."""
        from scenelang.interpreter.scene.primitives.mesh import volume_of

        placed = self.placed()
        if placed is None:
            return volume_of(mesh_of(self).corners)
        return placed.form.volume(placed.ratios) * abs(float(np.linalg.det(placed.matrix[:, :3])))

    def area(self) -> float:
        """Return the surface area in square scene units."""
        from scenelang.interpreter.scene.primitives.mesh import areas_of

        placed = self.placed()
        if placed is None:
            return float(areas_of(mesh_of(self).corners).sum())
        return sum(chart.area for chart in placed.form.charts(_axes_and_lengths(placed)[1], placed.ratios))


def _axes_and_lengths(placed: Placed) -> tuple[FloatArray, list[float]]:
    """Return the axes (3, 3) of the pose as unit columns, and their lengths."""
    linear = placed.matrix[:, :3]
    half = np.linalg.norm(linear, axis=0)
    axes: FloatArray = np.where(half > 0.0, linear / np.where(half > 0.0, half, 1.0), np.eye(3))
    return axes, half.tolist()


def mesh_of(primitive: Primitive) -> Mesh:
    """Return the mesh of a primitive without a canonical form, cached."""
    return _cached_mesh(primitive.key)


@lru_cache(maxsize=64)
def _cached_mesh(primitive: Primitive) -> Mesh:
    """Triangulate a primitive within ``MESH_TOLERANCE`` of its size, which a coarse mesh gives."""
    rough = primitive.triangulate(math.inf)
    size = float(np.ptp(rough.vertices, axis=0).max()) if len(rough.vertices) else 0.0
    return primitive.triangulate(MESH_TOLERANCE * size) if size > 0.0 else rough


def is_field_of(cls: type[Primitive], name: str) -> bool:
    """Return whether the class of a primitive has a field ``name``."""
    return any(field.name == name for field in fields(cls))

"""Primitives, lights and cameras of other tools in calls.

A word without a binding is a noun and is drawn as a labeled box, so ``(call "box" :size [1 2 3])`` would draw a labeled
unit box. A noun may have any descriptive attribute, so only three mistakes are reported: attributes that do not
describe objects, sizes of a primitive that has another name here, and names of classes of another tool. The tables are
from three.js, Babylon.js, A-Frame, Blender, OpenSCAD, POV-Ray, trimesh and pyrender.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from itertools import pairwise
from typing import Any

from scenelang.grammar import ast
from scenelang.grammar.datum import Span, dataclass
from scenelang.grammar.diagnostics import Diagnostic, Edit, Fix
from scenelang.grammar.lazy_patterns import lazy_pattern
from scenelang.interpreter.scene.primitives import COLOR, geometry_attributes, is_word
from scenelang.interpreter.values.values import Keyword


@dataclass(frozen=True, slots=True)
class Meaning:
    """Equivalent of an attribute of another tool: a hint, and the attribute that replaces it, if there is one."""

    hint: str
    attribute: str | None = None


_MATERIAL = "a material is made of `:color`, `:roughness`, `:metallic`, `:opacity`, `:emission` and `:ior`"
_SIZES = Meaning("the sizes along x, y and z are `:scale [x y z]`", "scale")
_EDGES = Meaning("a part has its size by `:scale [x y z]`, and is placed by `transform`")
_STROKES = Meaning('paths of SVG are profiles: `(extrude (svg-path "M 0 0 L 1 0 L 1 1 Z") 1)`')
_RADIANCE = Meaning("a surface with `:emission` is a light", "emission")
_CAMERA = Meaning('a camera is declared at top level: `(camera "main" :eye [3 2 5] :look-at [0 1 0] :fov 35)`')
_AIMED = Meaning("a part is turned by `(look-at eye target)`, and a camera by `(camera :look-at [0 1 0])` at top level")
_SHADOWS = Meaning("every surface casts and receives shadows in final images")
_SMOOTH = Meaning("surfaces are exact; `export --tolerance` says how finely they are divided")
_SIDES = Meaning("surfaces have two sides, and are always filled")
_PLACED = Meaning("a part is placed by `transform`: `(transform part (translate [x y z]))`")
_TURNED = Meaning("a part is turned by `transform`: `(transform part (rotate angle [0 1 0]))`")
_SHADED = Meaning(_MATERIAL)
_MESH = Meaning("a mesh is made by `(mesh vertices faces)`")
_PART = 'a word is bound to what it draws: `(bind "word" (lambda () ...))`'
_IS = 'the primitive is "{}"'

_NAMES_BY_MEANING: Mapping[Meaning, str] = {
    _SIZES: "size dimensions dims extents local-scale",
    _EDGES: "dx dy dz xmin xmax ymin ymax zmin zmax x1 y1 x2 y2 cx cy",
    _RADIANCE: "intensity luminosity lumens irradiance radiance penumbra shadow-soft-size",
    _CAMERA: """
        fov fovy fovx yfov xfov field-of-view focal-length aspect aspect-ratio look-at clip-start clip-end znear zfar
        near-plane far-plane ortho-scale
    """,
    _SHADOWS: "cast-shadow cast-shadows receive-shadow receive-shadows shadow-map",
    _SMOOTH: """
        radial-segments width-segments height-segments depth-segments tubular-segments segment-count ring-count
        subdivisions $fn $fa $fs theta-start theta-length phi-start phi-length
    """,
    _SIDES: "wireframe double-sided side-orientation open-ended flat-shading smooth-shading",
    _PLACED: "position pos translation translate local-position location",
    _AIMED: "target look-target",
    _TURNED: "rotation rotate euler quaternion local-rotation local-euler-angles",
    _SHADED: "diffuse specular shininess metalness diffuse-color specular-color base-color",
    _MESH: "geometry vertices faces paths indices triangles normal normals",
    _STROKES: "stroke stroke-width stroke-opacity stroke-dasharray stroke-linecap stroke-linejoin",
}
_ATTRIBUTES: Mapping[str, Meaning] = {
    name: meaning for meaning, names in _NAMES_BY_MEANING.items() for name in names.split()
}

_ARRAYS = (_PLACED, _TURNED, _MESH, _AIMED)  # attributes that hold arrays there; with a number they describe a noun

# The primitive for each name that other tools use ("" if there is none), and the attributes of its size there.
_PRIMITIVES: Mapping[str, str] = {
    name: primitive
    for primitive, names in {
        "cube": "box cuboid rect rectangle square quad plane prism",
        "sphere": "ball icosphere uvsphere ellipsoid spheroid",
        "cylinder": "disk disc circle tube pipe",
        "torus": "ring donut annulus",
        "cone": "pyramid frustum",
        "": "tetrahedron octahedron dodecahedron icosahedron polyhedron torus-knot",
    }.items()
    for name in names.split()
}
_MEASURED = """
    width height depth length radius diameter r d w h l x y z rx ry rz radii x-size y-size z-size r1 r2 radius1 radius2
    radius-top radius-bottom top-radius bottom-radius inner-radius outer-radius radius-inner radius-outer major-radius
    minor-radius tube p0 p1 rounding corner-radius segments slices stacks sectors facets detail
"""
_MEASURES = frozenset(_MEASURED.split())
_SAME = {"r": "radius", "p0": "p0", "p1": "p1", "radius": "radius", "tube": "tube"}  # as the primitives here call them

_LIGHTS = (
    "point spot directional ambient area hemisphere hemispheric rect rect-area rectangle-area disk sphere dome mesh"
)
_NOUNS = frozenset(("spot-light", "dome-light", "disk-light"))  # lamps, unless written as a class: `SpotLight`
_UNPLACED = frozenset(("directional-light", "ambient-light", "hemisphere-light", "hemispheric-light", "dome-light"))
_SOLIDS = {
    "box": "cube", "cube": "cube", "sphere": "sphere", "cylinder": "cylinder", "cone": "cone", "torus": "torus",
    "capsule": "capsule", "plane": "cube", "circle": "cylinder", "ring": "torus", "tube": "cylinder",
}  # fmt: skip
_SHAPES = (
    "buffer extrude lathe shape torus-knot polyhedron icosahedron dodecahedron octahedron tetrahedron edges wireframe"
)
_MATERIALS = """
    mesh-standard mesh-basic mesh-phong mesh-physical mesh-lambert mesh-normal mesh-toon standard pbr phong lambert
"""
_CAMERAS = "perspective orthographic arc-rotate free universal pinhole intrinsics"
_OTHERS = """
    linear-extrude rotate-extrude orbit-controls axes-helper grid-helper skinned-mesh instanced-mesh
    julia-fractal sphere-sweep bicubic-patch smooth-triangle isosurface
    a-scene a-entity a-assets a-sky a-light a-camera a-text a-image a-video a-sound a-cursor a-mixin
"""
_LIGHT = (
    "a light is declared at top level: `(light :position [2 3 2] :power 100)`; a surface with `:emission` shines too"
)


@cache
def _compounds() -> Mapping[str, tuple[str | None, str]]:
    """Return the primitive, if there is one, and a hint for each class name of another tool, such as "sphere-mesh"."""
    meanings: dict[str, tuple[str | None, str]] = {f"{kind}-light": (None, _LIGHT) for kind in _LIGHTS.split()}
    meanings.update({f"{kind}-camera": (None, _CAMERA.hint) for kind in _CAMERAS.split()})
    meanings.update({f"{kind}-material": (None, _MATERIAL) for kind in _MATERIALS.split()})
    for ending in ("geometry", "buffer-geometry"):
        meanings.update({f"{kind}-{ending}": (None, _PART) for kind in _SHAPES.split()})
    for ending in ("geometry", "buffer-geometry", "shape", "mesh", "primitive"):
        meanings.update({f"{kind}-{ending}": (primitive, _IS.format(primitive)) for kind, primitive in _SOLIDS.items()})
    meanings.update({f"a-{kind}": (primitive, _IS.format(primitive)) for kind, primitive in _SOLIDS.items()})  # A-Frame
    meanings.update(dict.fromkeys(_OTHERS.split(), (None, _PART)))
    return meanings | dict.fromkeys(("uv-sphere", "ico-sphere"), ("sphere", _IS.format("sphere")))


_CAMEL = lazy_pattern(r"(?<=[a-z0-9])(?=[A-Z])|[_\s]+")


def _normal(name: str) -> str:
    """Return ``pointLight``, ``PointLight`` and ``point_light`` as ``point-light``."""
    return _CAMEL.sub("-", name).lower()


def calls_of_other_tools(node: ast.Call, word: str) -> Iterator[Diagnostic]:
    """Iterate over the mistakes in a call of a word that is not a primitive.

    It is assumed that the program does not bind the word.
    """
    if is_word(word):
        return
    compound = _compounds().get(_normal(word))
    if compound is not None and (_normal(word) not in _NOUNS or word != word.lower()):
        yield _compound(node, word, *compound)
        return
    attributes = list(_attributes_of(node))
    primitive = _PRIMITIVES.get(_normal(word))
    reported: set[str] = set()
    for key, value in attributes:
        name = _normal(str(key.value))
        is_text = type(value) is ast.Constant and type(value.value) is str and not name.startswith("stroke")
        meaning = _ATTRIBUTES.get(name)
        if meaning is None and primitive is not None and name in _MEASURES:
            hint = f"{_IS.format(primitive)}, with {_listed(primitive)}" if primitive else _PART
            meaning = Meaning(hint, _SAME.get(name))
        if (
            meaning in _ARRAYS and primitive is None and _is_number(value)
        ):  # a die has 6 `:faces`, a runner the `:position` 3
            continue
        if meaning is not None and not is_text and meaning.hint not in reported:  # one warning for a width and a height
            reported.add(meaning.hint)
            yield _attribute(word, key, meaning, _fix(node, key, attributes, primitive, meaning))


def meaning_of_function(name: str) -> str | None:
    """Return what to write for a primitive, light or camera of another tool that is called as a function, or None.

    Examples
    --------
    >>> meaning_of_function("pointLight")
    'a light is declared at top level: `(light :position [2 3 2] :power 100)`; a surface with `:emission` shines too'
    >>> meaning_of_function("chair")
    """
    normal = _normal(name)
    compound = _compounds().get(normal)
    primitive = compound[0] if compound is not None else _PRIMITIVES.get(normal)
    if primitive:
        return f'{_IS.format(primitive)}: `(call "{primitive}" {_usage(primitive, is_flat=normal in _FLAT)})`'
    if normal.rpartition("-")[2] in ("light", "sun", "lamp"):
        return _LIGHT
    if normal.rpartition("-")[2] == "camera":
        return _CAMERA.hint
    if normal.rpartition("-")[2] == "material":
        return _MATERIAL
    if normal == "line":
        return 'a line is a thin cylinder: `(call "cylinder" :radius .02 :p0 [0 0 0] :p1 [1 0 0])`'
    return compound[1] if compound is not None else None


_FLAT = frozenset(("plane", "quad", "square"))


def _usage(primitive: str, *, is_flat: bool) -> str:
    """Return the attributes of a primitive's geometry with examples of their values."""
    values = {"scale": "[4 .02 4]" if is_flat else "[1 2 3]", "p0": "[0 0 0]", "p1": "[0 1 0]"}
    names = [name for name in geometry_attributes(primitive) or () if name != COLOR.name]
    return " ".join(f":{name} {values.get(name, '.5')}" for name in names)


def hint_for_primitive(name: str) -> tuple[str, str | None] | None:
    """Return the hint for an attribute of other tools on a primitive, and the attribute that replaces it, if any."""
    meaning = _ATTRIBUTES.get(_normal(name))
    return None if meaning is None else (meaning.hint, meaning.attribute)


def _is_number(value: Any) -> bool:
    """Return whether an expression is a literal number."""
    return type(value) is ast.Constant and isinstance(value.value, (int, float))


def _attributes_of(node: ast.Call) -> Iterator[tuple[ast.Constant, Any]]:
    """Iterate over the keywords of a call and their values."""
    for key, value in pairwise(node.arguments):
        if type(key) is ast.Constant and type(key.value) is Keyword:
            yield key, value


def _listed(primitive: str) -> str:
    """Return the attributes of a primitive, for error messages."""
    return ", ".join(f"`:{name}`" for name in geometry_attributes(primitive) or ())


def _compound(node: ast.Call, word: str, primitive: str | None, hint: str) -> Diagnostic:
    """Return the warning about a class name of another tool."""
    fix = (
        Fix(f'Change to "{primitive}"', (Edit(node.word.span, f'"{primitive}"'),))
        if primitive is not None
        else _light(node, word)
    )
    message = f'"{word}" is never bound and names nothing, so it is drawn as a labeled box'
    return Diagnostic(
        "near-word", message, node.word.span, hint, fixes=(fix,), near=(primitive,) if primitive is not None else ()
    )


def _placed_lights() -> frozenset[str]:
    """Return the names of lights that have a position."""
    return frozenset(f"{kind}-light" for kind in _LIGHTS.split()) - _UNPLACED


def _light(node: ast.Call, word: str) -> Fix:
    """Return the fix that replaces a light by an emissive sphere, and any other class by nothing."""
    strength = next(
        (value.span.text for key, value in _attributes_of(node) if _normal(str(key.value)) == "intensity"), "1"
    )
    text = f'(call "sphere" :radius .1 :emission {strength})' if _normal(word) in _placed_lights() else "(union)"
    return Fix(f"Change to `{text}`", (Edit(node.span, text),))


def _attribute(word: str, key: ast.Constant, meaning: Meaning, fix: Fix | None) -> Diagnostic:
    """Return the warning about an attribute of another tool."""
    message = f'"{word}" is never bound, so it is drawn as a labeled box, which does not use `:{key.value}`'
    near = (f":{meaning.attribute}",) if meaning.attribute is not None else ()
    return Diagnostic("idle-attribute", message, key.span, meaning.hint, fixes=(fix,) if fix is not None else (),
                      found=f":{key.value}", near=near)  # fmt: skip


def _fix(
    node: ast.Call,
    key: ast.Constant,
    attributes: Sequence[tuple[ast.Constant, Any]],
    primitive: str | None,
    meaning: Meaning,
) -> Fix | None:
    """Return the fix for one attribute: another word, a transform, another attribute, or its removal."""
    if node.span.expansion is not None or not isinstance(key.span, Span):
        return None
    replacement = _as_primitive(node, attributes, primitive) if primitive else None
    if replacement is not None:
        return replacement
    value = next(value for other, value in attributes if other is key)
    if meaning is _PLACED:
        rest = _without(node, key, value)
        written = f"(transform {rest} (translate {value.span.text}))"
        return Fix(f"Change to `{written}`", (Edit(node.span, written),))
    if meaning.attribute is not None and (primitive is None or meaning in (_SIZES, _RADIANCE)):
        return Fix(f"Change to `:{meaning.attribute}`", (Edit(key.span, f":{meaning.attribute}"),))
    return Fix(f"Remove `:{key.value}`", (Edit(Span(key.span.source, key.span.start, value.span.end), ""),))


def _without(node: ast.Call, key: ast.Constant, value: Any) -> str:
    """Return the text of a call without an attribute."""
    text, start = node.span.source.text, node.span.start
    before, after = text[start : key.span.start].rstrip(), text[value.span.end : node.span.end]
    return before + (after if after.startswith((")", " ")) else f" {after}")


def _as_primitive(node: ast.Call, attributes: Sequence[tuple[ast.Constant, Any]], primitive: str) -> Fix | None:
    """Return the fix that calls the primitive instead, if it has an equivalent of every attribute."""
    if 2 * len(attributes) != len(node.arguments):  # an embedding by position
        return None
    values = {_normal(str(key.value)): value.span.text for key, value in attributes}
    sizes = [next((values.pop(name) for name in names if name in values), None) for names in _AXES]
    written: dict[str, str] = {}
    if primitive == "cube" and any(size is not None for size in sizes):
        written["scale"] = f"[{' '.join(size or '1' for size in sizes)}]"
    elif any(size is not None for size in sizes):
        return None
    known = geometry_attributes(primitive) or ()
    for name, value in values.items():
        attribute = "scale" if _ATTRIBUTES.get(name) is _SIZES else _SAME.get(name, name)
        if attribute in written or (attribute not in known and (name in _ATTRIBUTES or name in _MEASURES)):
            return None
        written[attribute] = value
    text = " ".join([f'(call "{primitive}"', *(f":{name} {value}" for name, value in written.items())]) + ")"
    return Fix(f"Change to `{text}`", (Edit(node.span, text),))


# Attributes of the sizes along x, y and z in other tools.
_AXES = (("width", "w", "x", "x-size"), ("height", "h", "y", "y-size"), ("depth", "d", "length", "l", "z", "z-size"))

"""Solid modelling: booleans, hulls, sums, cuts, and solids from profiles (docs/solids.md)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.loading import np
from scenelang.interpreter.runtime import parts
from scenelang.interpreter.runtime.show import show
from scenelang.interpreter.runtime.types import Registry
from scenelang.interpreter.scene import pose
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.scene.modelling import curves
from scenelang.interpreter.scene.modelling.contours import NON_ZERO, Contours
from scenelang.interpreter.scene.modelling.operations import SEGMENTS, Expression, Operand, check_size
from scenelang.interpreter.scene.modelling.solid import SolidShape, operand_of
from scenelang.interpreter.scene.modelling.sweeping import check_corners
from scenelang.interpreter.scene.primitives.base import MATERIALS, PHYSICS, color_of
from scenelang.interpreter.scene.primitives.mesh import flat_mesh, posed, sample_surface
from scenelang.interpreter.values.values import IDENTITY, Embedding, Matrix, Procedure, Vector, make_list
from scenelang.stdlib.operands import from_numpy, items, to_numpy
from scenelang.stdlib.paths import path_of
from scenelang.stdlib.profiles import (
    FILL,
    LEFT,
    TEXT,
    crossing_place,
    filled,
    finite,
    one_or_two,
    outline_of,
    positive,
    profile_of,
    profile_value,
    segment_count,
)
from scenelang.stdlib.random import numpy_source

if TYPE_CHECKING:
    from scenelang.interpreter.runtime.runtime import Runtime
    from scenelang.interpreter.scene.modelling.measuring import Measures

registry = Registry("solids")
define = registry.define

LOOK = "[:color] [:opacity] [:metallic] [:roughness] [:emission] [:ior] [:coat] [:sheen] [:material] [:texture]"
_MATERIAL_NAMES = tuple(attribute.name for attribute in (*MATERIALS, *PHYSICS))
_MAX_PLACES = 100_000  # of `surface-poses`
_MAX_SLICES = 10_000  # of an extrusion
_MAX_TWIST = 10_000.0  # radians of a sweep
_ORIGIN = Vector((0.0, 0.0, 0.0))


# --- operands --------------------------------------------------------------------------------------------------------


def solid_operand(rt: Runtime, name: str, value: Any, segments: int = SEGMENTS) -> Operand:
    """Return an entity or parts as one operand of an operation: their union if there are several primitives.

    Parameters
    ----------
    name
        Builtin that error messages name.
    value
        Entity, or list of parts.
    segments
        Number of sides of a full circle in the meshes of round primitives.

    Raises
    ------
    SceneError
        "solid" for primitives that are not solids.
    """
    leaves = _leaves(rt, name, value, segments)
    if not leaves:
        raise SceneError("solid", f"`{name}` has an operand without primitives")
    if len(leaves) == 1:
        return leaves[0]
    return Operand(Expression("solid-union", operands=tuple(leaves)), IDENTITY)


def _leaves(rt: Runtime, name: str, value: Any, segments: int) -> list[Operand]:
    """Return the primitives of parts as operands, each with the word of the entity that it is part of."""
    leaves: list[Operand] = []
    stack = [(part.car, part.cdr, "") for part in reversed(parts.parts_of(rt, value))]
    while stack:
        entity, matrix, word = stack.pop()
        rt.charge(1)
        if entity.is_primitive:
            leaves.append(operand_of(name, entity, matrix, word or entity.word, segments))
            rt.meter.check_growth(len(leaves), "a list of operands")
            continue
        for part in reversed(entity.children):
            stack.append((part.car, pose.compose(matrix, part.cdr), entity.word))
    return leaves


# --- results ---------------------------------------------------------------------------------------------------------


def solid_entity(
    rt: Runtime, name: str, parameters: Mapping[str, Any], operands: Sequence[Operand], look: Mapping[str, Any],
    like: Any = None, word: str = "", caller: str = "",
) -> Entity:  # fmt: skip
    """Return the entity of a solid.

    Parameters
    ----------
    name, parameters, operands
        Operation, as in ``Expression``.
    look
        Color and material that the program gives, by name.
    like
        Parts whose first primitive gives the material otherwise; the color is that of the operands.
    word
        Word of the entity, by default the name of the operation.
    caller
        Builtin that the operation is part of, for error messages.
    """
    attributes = _material_like(rt, like)
    attributes |= {key: value for key, value in look.items() if value is not None}
    color = color_of(name, attributes["color"]) if "color" in attributes else None
    if color is None and operands:
        color = _first_color(operands[0])
    word = word or name
    expression = Expression(name, parameters, tuple(operands), None, word, color or (1.0, 1.0, 1.0), rt.site, caller)
    check_size(expression)
    colors = expression.colors
    if "color" not in attributes and len(colors) == 1 and operands:
        attributes["color"] = Vector(next(iter(colors)))
    rt.charge(64 + 8 * len(operands))
    return rt.solid(word, parts.with_attributes(rt, Embedding(), attributes), expression)


def _first_color(operand: Operand) -> tuple[float, float, float]:
    """Return the color of the first primitive of an operand."""
    while operand.color is None and operand.expression.operands:
        operand = operand.expression.operands[0]
    return operand.expression.color if operand.color is None else operand.color


def _material_like(rt: Runtime, like: Any) -> dict[str, Any]:
    """Return the material, without the color, of the first primitive of an operand."""
    members = parts.parts_of(rt, like) if like is not None else ()
    while members:
        entity = members[0].car
        if entity.is_primitive:
            attributes = entity.embedding.attributes
            return {name: attributes[name] for name in _MATERIAL_NAMES if attributes.get(name) is not None}
        members = entity.children
    return {}


# --- booleans --------------------------------------------------------------------------------------------------------


def _combined(
    rt: Runtime, name: str, values: Sequence[Any], segments: int, look: Mapping[str, Any], caller: str = ""
) -> Entity:  # fmt: skip
    """Return a boolean of solids; ``caller`` is the builtin, if it has another name than the operation."""
    sides = segment_count(caller or name, segments)
    operands = [solid_operand(rt, caller or name, value, sides) for value in values]
    return solid_entity(rt, name, {}, operands, look, values[0], caller=caller)


@define(
    "difference", f"base::Parts tools::Parts ... [:segments::Integer] {LOOK}", "Entity",
    "Return the solid that remains of `base` without `tools`. Faces keep the colors and words of their operands.",
    ('(volume (difference (call "cube") (call "cube" :scale [.5 .5 2])))', "0.75"),
    picture='(difference (call "cube" :color (color "tomato")) (call "sphere" :radius .62 :color (color '
            '"gold")))',
)  # fmt: skip
def difference(rt: Runtime, base: Any, *tools: Any, segments: int = SEGMENTS, **look: Any) -> Entity:
    return _combined(rt, "difference", (base, *tools), segments, look)


@define(
    "intersection", f"first::Parts others::Parts ... [:segments::Integer] {LOOK}", "Entity",
    "Return the solid of what is inside of all operands.",
    ('(volume (intersection (call "cube") (transform (call "cube") (translate [.5 0 0]))))', "0.5"),
    picture='(intersection (call "cube" :color (color "tomato")) (call "sphere" :radius .65 :color (color '
            '"gold")))',
)  # fmt: skip
def intersection(rt: Runtime, first: Any, *others: Any, segments: int = SEGMENTS, **look: Any) -> Entity:
    return _combined(rt, "intersection", (first, *others), segments, look)


@define(
    "solid-union", f"first::Parts others::Parts ... [:segments::Integer] {LOOK}", "Entity",
    "Return one watertight solid of all operands. `union` keeps them as separate parts, which costs nothing.",
    ('(volume (solid-union (call "cube") (transform (call "cube") (translate [.5 0 0]))))', "1.5"),
    picture='(solid-union (call "cube" :color (color "tomato")) (transform (call "sphere" :radius .5 :color '
            '(color "gold")) (translate [.4 .4 .4])))',
)  # fmt: skip
def solid_union(rt: Runtime, first: Any, *others: Any, segments: int = SEGMENTS, **look: Any) -> Entity:
    return _combined(rt, "solid-union", (first, *others), segments, look)


@define(
    "hull", f"first::Parts others::Parts ... [:segments::Integer] {LOOK}", "Entity",
    "Return the convex hull of all operands.",
    ('(volume (hull (call "cube") (transform (call "cube") (translate [1 0 0]))))', "2.0"),
    picture='(hull (call "sphere" :radius .5 :color (color "gold")) (transform (call "cube") (translate [1.5 '
            '0 0])))',
)  # fmt: skip
def hull(rt: Runtime, first: Any, *others: Any, segments: int = SEGMENTS, **look: Any) -> Entity:
    return _combined(rt, "hull", (first, *others), segments, look)


# --- sums ------------------------------------------------------------------------------------------------------------


@define(
    "minkowski", f"base::Parts tool::Parts [:segments::Integer] {LOOK}", "Entity",
    "Return the Minkowski sum: what a convex `tool`, moved by its origin over all of `base`, covers. The time grows "
    "with the product of the numbers of faces; curved operands have `:segments` sides, 12 by default.",
    ('(compute-shape-sizes (minkowski (call "cube") (call "cube" :scale .5)))', "[1.5 1.5 1.5]"),
    picture='(minkowski (call "cube" :scale [2 .4 1] :color (color "slategray")) (call "cone" :radius .3 :p1 '
            '[0 .5 0]))',
)  # fmt: skip
def minkowski(rt: Runtime, base: Any, tool: Any, segments: int = 12, **look: Any) -> Entity:
    return _combined(rt, "minkowski", (base, tool), segments, look)


def _with_ball(rt: Runtime, name: str, base: Any, key: str, size: float, sides: int, look: Mapping[str, Any]) -> Entity:
    operand = solid_operand(rt, name, base, segment_count(name, sides))
    return solid_entity(rt, name, {key: size, "segments": sides}, [operand], look, base)


@define(
    "rounded", f"solid::Parts radius::Number [:segments::Integer] {LOOK}", "Entity",
    "Return a solid of the same size with its outer edges rounded by `radius`, in scene units. The ball of the "
    "Minkowski sums has `:segments` sides, 12 by default.",
    ('(round (compute-shape-sizes (rounded (call "cube") .1)) 3)', "[1.0 1.0 1.0]"),
    picture='(rounded (call "cube" :color (color "gold")) .2)',
)  # fmt: skip
def rounded(rt: Runtime, solid: Any, radius: Any, segments: int = 12, **look: Any) -> Entity:
    return _with_ball(rt, "rounded", solid, "radius", positive("rounded", "the radius", radius), segments, look)


@define(
    "shell", f"solid::Parts thickness::Number [:segments::Integer] {LOOK}", "Entity",
    "Return a solid hollowed out, with walls of `thickness`, in scene units; cut it to see inside.",
    ('(round (volume (shell (call "cube") .25 :segments 4)) 3)', "0.875"),
    picture='(cut-plane (shell (call "sphere" :color (color "tomato")) .2 :segments 16) [-1 0 -1])',
)  # fmt: skip
def shell(rt: Runtime, solid: Any, thickness: Any, segments: int = 12, **look: Any) -> Entity:
    return _with_ball(rt, "shell", solid, "thickness", positive("shell", "the thickness", thickness), segments, look)


@define(
    "offset-solid", f"solid::Parts distance::Number [:segments::Integer] {LOOK}", "Entity",
    "Return a solid that is larger by `distance` on all sides, with rounded edges; smaller if it is negative.",
    ('(round (compute-shape-sizes (offset-solid (call "cube") .5)) 3)', "[2.0 2.0 2.0]"),
    picture='(offset-solid (difference (call "cube" :scale [2 .6 1] :color (color "slategray")) (call "cube" '
            ':scale [.6 2 .4])) .1)',
)  # fmt: skip
def offset_solid(rt: Runtime, solid: Any, distance: Any, segments: int = 12, **look: Any) -> Entity:
    positive("offset-solid", "the distance", abs(distance))
    return _with_ball(rt, "offset-solid", solid, "distance", float(distance), segments, look)


# --- cuts ------------------------------------------------------------------------------------------------------------


def _plane(name: str, normal: Vector, point: Vector) -> dict[str, Any]:
    """Return the parameters of a plane through a point."""
    if len(normal) != 3 or len(point) != 3:
        raise SceneError("value", f"`{name}` expects three numbers for the normal and for the point")
    if not any(normal):
        raise SceneError("value", f"the normal of `{name}` is zero")
    offset = sum(a * b for a, b in zip(normal, point, strict=True))
    return {"normal": np.array(normal, np.float64), "offset": float(offset)}


@define(
    "cut-plane", f"solid::Parts normal::Vector [point::Vector] [:segments::Integer] {LOOK}", "Entity",
    "Return the part of a solid on the side of a plane that its `normal` points to; the plane goes through `point`, by "
    "default the origin.",
    ('(compute-shape-min (cut-plane (call "cube") [0 1 0]))', "[-0.5 0.0 -0.5]"),
    picture='(cut-plane (call "torus" :color (color "gold")) [-1 0 0])',
)  # fmt: skip
def cut_plane(
    rt: Runtime, solid: Any, normal: Vector, point: Vector = _ORIGIN, segments: int = SEGMENTS, **look: Any
) -> Entity:  # fmt: skip
    operand = solid_operand(rt, "cut-plane", solid, segment_count("cut-plane", segments))
    return solid_entity(rt, "cut-plane", _plane("cut-plane", normal, point), [operand], look, solid)


@define(
    "split", f"solid::Parts tool::Parts [:segments::Integer] {LOOK}", "List[Entity]",
    "Return two solids: the part of a solid inside of `tool`, and the part outside.",
    ('(length (split (call "cube") (transform (call "cube") (translate [.75 0 0]))))', "2"),
    picture='(map transform (split (call "sphere" :color (color "tomato")) (transform (call "cube" :scale 3) '
            '(translate [-1.3 0 0]))) (list (translate [-.4 0 0]) (translate [.4 0 0])))',
)  # fmt: skip
def split(rt: Runtime, solid: Any, tool: Any, segments: int = SEGMENTS, **look: Any) -> Any:
    sides = ("intersection", "difference")
    return make_list([_combined(rt, name, (solid, tool), segments, look, "split") for name in sides])


# --- profiles of solids ----------------------------------------------------------------------------------------------


def _drawn(rt: Runtime, name: str, solid: Any, segments: int, height: float | None) -> Any:
    """Return the outline of a solid along the z axis, or its section at a height."""
    from scenelang.interpreter.scene.modelling.computing import manifold_of
    from scenelang.interpreter.scene.modelling.contours import contours_of

    operand = solid_operand(rt, name, solid, segment_count(name, segments))
    manifold = manifold_of(Expression("solid-union", {}, (operand,), None, name, site=rt.site)).manifold
    rt.charge(64 + (manifold.num_tri() >> 3))
    return profile_value(rt, contours_of(manifold.project() if height is None else manifold.slice(height)))


@define(
    "profile-section", "solid::Parts [z::Number] [:segments::Integer]", "List",
    "Return the profile that a plane of constant `z`, by default 0, cuts out of a solid; an empty one if it meets "
    "nothing.",
    ('(round (profile-area (profile-section (call "sphere") .6 :segments 1024)) 3)', "2.011"),
    picture='(extrude (profile-section (transform (call "torus") (rotate .6 [1 0 0]))) .2 :color (color "gold"))',
)  # fmt: skip
def profile_section(rt: Runtime, solid: Any, z: Any = 0, segments: int = SEGMENTS) -> Any:
    return _drawn(rt, "profile-section", solid, segments, finite("profile-section", "z", z))


@define(
    "profile-silhouette", "solid::Parts [:segments::Integer]", "List",
    "Return the profile of a solid as it is seen along the z axis, from the front.",
    ('(profile-area (profile-silhouette (transform (call "cube") (scale [2 3 1]))))', "6.0"),
    picture='(extrude (profile-silhouette (transform (call "cube") (rotate 1 [1 1 0]))) .2 :color (color "gold"))',
)  # fmt: skip
def profile_silhouette(rt: Runtime, solid: Any, segments: int = SEGMENTS) -> Any:
    return _drawn(rt, "profile-silhouette", solid, segments, None)


# --- profiles --------------------------------------------------------------------------------------------------------


@define(
    "extrude",
    f"profile height::Number [:twist::Number] [:taper] [:slices::Integer] [:center::Boolean] {FILL} {LOOK}",
    "Entity",
    "Return a profile in the plane of x and y, extruded from z = 0 along +z by `height`. The top is turned by "
    "`:twist` radians and scaled by `:taper`, one factor or two; `:slices` are layers of a twist; `:center` puts the "
    "middle at z = 0. `:fill` is that of `profile-union`.",
    ("(volume (extrude [[0 0] [2 0] [2 1] [0 1]] 3))", "6.0"),
    picture='(extrude [[0 0] [2 0] [2 .5] [.5 .5] [.5 1.5] [0 1.5]] .8 :color (color "steelblue"))',
)  # fmt: skip
def extrude(
    rt: Runtime, profile: Any, height: Any, twist: Any = 0, taper: Any = 1, slices: int = 0, center: bool = False,
    fill: Any = None, **look: Any,
) -> Entity:  # fmt: skip
    if slices < 0 or slices > _MAX_SLICES:
        raise SceneError("value", f"`extrude` expects at most 10,000 :slices, got {slices}")
    contours, rule = filled(rt, "extrude", profile, fill)
    if not math.isfinite(twist):
        raise SceneError("value", f"`extrude` expects a finite :twist, got {show(twist, 20)}")
    layers = slices or max(1, math.ceil(abs(float(twist)) / math.tau * SEGMENTS))
    scale = one_or_two(rt, "extrude", ":taper", taper)
    if min(scale) < 0.0:
        raise SceneError("value", "`extrude` expects a :taper of at least 0")
    parameters = _extrusion(
        contours,
        positive("extrude", "the height", height),
        math.degrees(float(twist)),
        scale,
        layers,
        center=bool(center),
    )
    return solid_entity(rt, "extrude", parameters | _rule(rule), (), look)


def _rule(rule: str) -> dict[str, str]:
    """Return the parameter for a fill rule; the default is left out, so that digests stay the same."""
    return {} if rule == NON_ZERO else {"fill": rule}


def _extrusion(
    contours: Any, height: float, twist: float = 0.0, taper: Sequence[float] = (1.0, 1.0), layers: int = 1,
    *, center: bool = False,
) -> dict[str, Any]:  # fmt: skip
    """Return the parameters of the operation ``extrude``; ``twist`` is in degrees."""
    return {
        "profile": contours, "height": height, "twist": twist, "taper": np.array(taper), "slices": layers - 1,
        "center": center,
    }  # fmt: skip


@define(
    "text", f"text::String [:depth::Number] {TEXT} {LOOK}", "Entity",
    "Return a text as a solid that faces +z, its baseline at y = 0, its back at z = 0. It is the outlines, as "
    "by `text-outline` with its keywords, extruded by `:depth`, a fifth of the size by default.",
    ('(entity-word (text "Ada"))', '"text"'),
    picture='(text "Ada" :depth .3 :color (color "gold"))',
)  # fmt: skip
def text_solid(
    rt: Runtime, text: str, depth: Any = None, size: Any = 1, font: str | None = None, align: Any = LEFT,
    spacing: Any = 0, line_height: Any = 1.2, **look: Any,
) -> Entity:  # fmt: skip
    """Return the solid of a text; parameters after ``depth`` are keywords of ``text-outline``, then of looks."""
    contours = outline_of(rt, "text", text, font, size, align, spacing, line_height)
    if not contours:
        raise SceneError("value", f"`text` expects a text with visible characters, got {show(text, 40)}")
    parameters = _extrusion(contours, positive("text", ":depth", size / 5.0 if depth is None else depth))
    return solid_entity(rt, "extrude", parameters, (), look, word="text")


@define(
    "lathe", f"profile [:angle::Number] [:segments::Integer] {FILL} {LOOK}", "Entity",
    "Return a profile turned around the y axis: x is the distance from the axis, and what is at x < 0 is left out. "
    "`:angle`, in radians, is above 0 and at most a full turn, the default; `:segments` are those of a full turn, "
    "a part has its share. "
    "`:fill` is that of `profile-union`.",
    ("(round (volume (lathe [[0 0] [1 0] [1 1] [0 1]] :segments 1024)) 3)", "3.142"),
    picture='(lathe [[0 0] [.5 0] [.15 .2] [.1 1] [.6 1.6] [.5 1.6] [0 1.1]] :color (color "gold"))',
)  # fmt: skip
def lathe(
    rt: Runtime, profile: Any, angle: Any = math.tau, segments: int = SEGMENTS, fill: Any = None, **look: Any
) -> Entity:  # fmt: skip
    if not 0.0 < angle <= math.tau + 1e-9:
        raise SceneError("value", f"`lathe` expects an :angle above 0 up to a full turn, got {show(angle, 40)}")
    share = min(1.0, float(angle) / math.tau)
    contours, rule = filled(rt, "lathe", profile, fill)
    # A part of a turn has its share of the sides, rounded up, so that a half and a whole turn with one number fit.
    parameters = {
        "profile": contours, "angle": min(360.0, math.degrees(float(angle))),
        "segments": max(1, math.ceil(segment_count("lathe", segments) * share - 1e-9)),
    }  # fmt: skip
    return solid_entity(rt, "lathe", parameters | _rule(rule), (), look)


@define(
    "sweep", f"profile path::ArrayLike [:twist::Number] [:taper] [:closed::Boolean] {FILL} {LOOK}", "Entity",
    "Return a profile moved along a path, its y axis as far upwards as possible at the start. It does not turn about "
    "the path except by `:twist` radians in all; `:taper`, one factor or two, is its final size. Corners are "
    "mitred. `:closed` leads from the last point back to the first; a path that ends where it begins is closed. "
    "`:fill` is that of `profile-union`.",
    ("(volume (sweep (rectangle 1 2) [[0 0 0] [5 0 0] [5 0 5]]))", "20.0"),
    picture='(sweep (profile-difference (circle .3) (circle .2)) [[0 0 0] [2 0 0] [2 1.5 0] [2 1.5 2]] :color (color '
            '"gold"))',
)  # fmt: skip
def sweep(
    rt: Runtime, profile: Any, path: Any, twist: Any = 0, taper: Any = 1, closed: bool = False, fill: Any = None,
    **look: Any,
) -> Entity:  # fmt: skip
    (contours, rule), points = filled(rt, "sweep", profile, fill), path_of(rt, "sweep", path)
    if closed and not curves.is_closed(points):
        points = np.concatenate([points, points[:1]])
    scale, turn = np.array(one_or_two(rt, "sweep", ":taper", taper)), finite("sweep", ":twist", twist)
    if scale.min() < 0.0:
        raise SceneError("value", "`sweep` expects a :taper of at least 0")
    if curves.is_closed(points) and (abs(math.remainder(turn, math.tau)) > 1e-6 or not (scale == 1.0).all()):
        hint = "use a multiple of `tau` for :twist, and no :taper"
        raise SceneError("value", "the ends of a closed `sweep` do not meet", hint)
    if abs(turn) > _MAX_TWIST:
        raise SceneError("value", f"`sweep` expects a :twist of at most 10,000 radians, got {show(twist, 40)}")
    rt.charge(len(points) >> 2)
    parameters = {"profile": contours, "path": points, "twist": turn, "taper": scale}
    return solid_entity(rt, "sweep", parameters | _rule(rule), (), look)


def _poses_of(rt: Runtime, heights: Any, poses: Any, count: int) -> Any:
    """Return the poses (P, 3, 4) of the profiles of a loft."""
    if poses is not None:
        if heights is not None:
            raise SceneError("value", "`loft` expects :heights or :poses, not both")
        matrices = [parts.pose_from(rt, matrix) for matrix in items(rt, poses, "loft")]
        placed = np.array(matrices, np.float64).reshape(-1, 3, 4)
    else:
        levels = np.arange(count) if heights is None else np.asarray(to_numpy(rt, heights, "loft"), np.float64)
        if levels.ndim != 1 or not (np.diff(levels) > 0.0).all() or not np.isfinite(levels).all():
            raise SceneError("value", f"`loft` expects increasing numbers for :heights, got {show(heights, 60)}")
        placed = np.tile(np.eye(3, 4), (len(levels), 1, 1))
        placed[:, 2, 3] = levels
    if len(placed) != count:
        raise SceneError("value", f"`loft` expects a height or pose for each of {count} profiles, got {len(placed)}")
    return placed


def _loftable(rt: Runtime, profile: Any) -> Contours:
    """Return a profile of a loft; raises SceneError for one that crosses itself, whose points have no order."""
    contours = profile_of(rt, "loft", profile)
    place = crossing_place(rt, contours)
    if place is not None:
        message = f"a profile of `loft` crosses itself at {place}"
        raise SceneError("value", message, "take its outline, `(profile-union profile)`")
    return contours


@define(
    "loft", f"profiles::Sequence [:heights] [:poses] {LOOK}", "Entity",
    "Return the solid that leads from each profile of a list to the next one. They are at z = 0, 1, 2, ..., or at "
    "`:heights`, or each in the plane of x and y of one of `:poses`. They need equal numbers of contours; points "
    "correspond by their order if their numbers are equal, else by their shares of the length.",
    ("(round (volume (loft (list (rectangle 2 2) (rectangle 1 1)) :heights [0 3])) 6)", "7.0"),
    picture='(loft (list (rectangle 2 2) (circle .6) (star 5 1 .5)) :heights [0 1.5 2.5] :color (color "gold"))',
)  # fmt: skip
def loft(rt: Runtime, profiles: Any, heights: Any = None, poses: Any = None, **look: Any) -> Entity:
    sections = [_loftable(rt, profile) for profile in items(rt, profiles, "loft")]
    if len(sections) < 2:
        raise SceneError("value", f"`loft` expects a list of at least two profiles, got {len(sections)}")
    placed = _poses_of(rt, heights, poses, len(sections))
    contours = tuple(contour for profile in sections for contour in profile)
    check_corners("loft", 1, sum(map(len, contours)))
    rt.charge(sum(map(len, contours)) >> 1)
    counts = np.array([len(profile) for profile in sections], np.float64)
    return solid_entity(rt, "loft", {"contours": contours, "counts": counts, "poses": placed}, (), look)


@define(
    "heightfield", f"heights [:size] [:base::Number] [:segments::Integer] {LOOK}", "Entity",
    "Return a block around the y axis whose top has these heights: an array, rows along z and columns along x, or a "
    "function of x and z, called at `:segments` + 1 places of each axis, 64 by default. `:size` is its extent along x "
    "and z, one number or two, 10 by default. The bottom is at y = `:base`, by default a twentieth of the size below "
    "the lowest height.",
    ("(volume (heightfield [[1 1] [1 1]] :size 2 :base 0))", "4.0"),
    picture='(heightfield (lambda (x z) (* 2 (fbm [(* .3 x) (* .3 z)]))) :color (color "forestgreen"))',
)  # fmt: skip
def heightfield(
    rt: Runtime, heights: Any, size: Any = 10, base: Any = None, segments: int = SEGMENTS, **look: Any
) -> Entity:  # fmt: skip
    extent = np.array(one_or_two(rt, "heightfield", ":size", size))
    for side in extent.tolist():
        positive("heightfield", ":size", side)
    if isinstance(heights, Procedure):
        grid = _sampled(rt, heights, extent, segment_count("heightfield", segments, 1))
    else:
        grid = np.asarray(to_numpy(rt, heights, "heightfield"), np.float64)
    if grid.ndim != 2 or min(grid.shape) < 2:
        raise SceneError("value", "`heightfield` expects at least two rows of at least two heights, or a function")
    check_corners("heightfield", *grid.shape)
    if not np.isfinite(grid).all():
        raise SceneError("value", "`heightfield` expects finite heights")
    low = float(grid.min())
    bottom = low - float(extent.max()) / 20.0 if base is None else finite("heightfield", ":base", base)
    if bottom >= low:
        raise SceneError("value", f"`heightfield` expects a :base below the lowest height {low:g}, got {bottom:g}")
    rt.charge(grid.size >> 6)
    return solid_entity(rt, "heightfield", {"heights": grid, "size": extent, "base": bottom}, (), look)


def _sampled(rt: Runtime, function: Any, size: Any, segments: int) -> Any:
    """Return the heights that ``function`` returns on a grid around the origin.

    Parameters
    ----------
    size : (2,)
        Extent of the grid along x and z.
    segments
        Number of cells along each axis.

    Returns
    -------
    array of shape (segments + 1, segments + 1)
        Heights, rows along z and columns along x.
    """
    steps = (np.arange(segments + 1) / segments - 0.5).tolist()
    grid = np.empty((segments + 1, segments + 1))
    for row, z in enumerate(steps):
        for column, x in enumerate(steps):
            height = rt.call2(function, x * float(size[0]), z * float(size[1]))
            if type(height) not in (int, float):
                raise SceneError(
                    "type", f"`heightfield` expects a function that returns numbers, got {show(height, 40)}"
                )
            grid[row, column] = height
    return grid


@define(
    "mesh", f"vertices::ArrayLike faces {LOOK}", "Entity",
    "Return the solid with these corners [x y z] and faces, lists of the indices of corners, counter-clockwise seen "
    "from outside. It must be closed.",
    ("(volume (mesh [[0 0 0] [1 0 0] [0 1 0] [0 0 1]] [[0 2 1] [0 1 3] [1 2 3] [0 3 2]]))", "0.16666666666666666"),
    picture="(mesh [[-1 0 -1] [1 0 -1] [1 0 1] [-1 0 1] [0 1.4 0]] '((0 1 2 3) (4 1 0) (4 2 1) (4 3 2) (4 0 "
            "3)) :color (color \"sienna\"))",
)  # fmt: skip
def mesh(rt: Runtime, vertices: Any, faces: Any, **look: Any) -> Entity:
    points = np.asarray(to_numpy(rt, vertices, "mesh"), np.float64)
    if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
        raise SceneError("value", "`mesh` expects a list of finite points [x y z]")
    triangles = []
    for face in items(rt, faces, "mesh"):
        indices = np.asarray(to_numpy(rt, face, "mesh"), np.float64).reshape(-1)
        if len(indices) < 3 or not ((indices >= 0) & (indices < len(points)) & (indices == np.floor(indices))).all():
            raise SceneError("value", f"`mesh` expects faces of at least three whole indices below {len(points)}")
        corners = indices.astype(np.int64).tolist()
        triangles += [(corners[0], b, c) for b, c in pairwise(corners[1:])]
    parameters = {"vertices": points, "faces": np.array(triangles, np.float64).reshape(-1, 3)}
    entity = solid_entity(rt, "mesh", parameters, (), look)
    assert isinstance(entity.shape, SolidShape)
    _ = entity.shape.computed  # a mesh that is not closed is an error where it is written
    return entity


# --- places on surfaces ----------------------------------------------------------------------------------------------


@define(
    "surface-poses", "x::Parts count::Integer [:stream::Stream]", "List[Matrix]",
    "Return so many random poses on the surfaces of all primitives in `x`, uniform by area: each is at a point of a "
    "surface, with +y along its normal. They are drawn as by `uniform`. `scatter-on` places copies there.",
    ("(length (surface-poses (call \"cube\") 5))", "5"),
)  # fmt: skip
def surface_poses(rt: Runtime, x: Any, count: int, stream: Any = None) -> Any:
    if not 0 <= count <= _MAX_PLACES:
        raise SceneError("value", f"`surface-poses` expects 0 to {_MAX_PLACES:,} places, got {count:,}")
    from scenelang.interpreter.scene.modelling.computing import leaf_mesh

    surfaces = []  # corners (F, 3, 3) of all primitives, so that one sample is uniform over all of them
    for part in parts.primitives_of(rt, x):
        if part.car.shape.has_geometry:
            matrix = np.array(part.cdr, np.float64).reshape(1, 3, 4)
            surfaces.append(posed(leaf_mesh(part.car.shape, SEGMENTS).faceted(), matrix).corners)
    corners = np.concatenate([np.zeros((0, 3, 3)), *surfaces])
    rt.charge((len(corners) >> 3) + count)
    surface = flat_mesh(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))
    points, normals = sample_surface(surface, count, numpy_source(rt, "surface-poses", stream))
    if len(points) < count:
        raise SceneError("solid", "`surface-poses` expects something with a surface")
    return make_list([_standing(p, n) for p, n in zip(points.tolist(), normals.tolist(), strict=True)])


def _standing(point: Sequence[float], normal: Sequence[float]) -> Matrix:
    """Return the pose at a point with +y along a unit normal and +z as close to the +z of the scene as possible."""
    y = np.array(normal)
    z = np.array([0.0, 0.0, 1.0]) if abs(y[2]) < 0.999 else np.array([0.0, -1.0, 0.0])
    x = np.cross(y, z)
    x /= np.linalg.norm(x)
    return Matrix(np.column_stack([x, y, np.cross(x, y), point]).ravel().tolist())


# --- measures --------------------------------------------------------------------------------------------------------


def _measured(rt: Runtime, name: str, x: Any) -> Measures:
    """Return the measures of an entity or parts as one solid."""
    from scenelang.interpreter.scene.modelling.measuring import measured

    operands = _leaves(rt, name, x, SEGMENTS)
    rt.charge(64 * len(operands))
    return measured(operands)


@define(
    "volume", "x::Parts", "Float",
    "Return the volume of an entity or parts as one solid, in cubic scene units; 0 of nothing.",
    ('(volume (call "cube" :scale [1 2 3]))', "6.0"),
)  # fmt: skip
def volume(rt: Runtime, x: Any) -> float:
    return _measured(rt, "volume", x).volume


@define(
    "surface-area", "x::Parts", "Float",
    "Return the area of the surface of an entity or parts as one solid, in square scene units.",
    ('(surface-area (call "cube" :scale [1 2 3]))', "22.0"),
)  # fmt: skip
def surface_area(rt: Runtime, x: Any) -> float:
    return _measured(rt, "surface-area", x).area


@define(
    "centroid", "x::Parts", "Vector", "Return the center of mass of an entity or parts of uniform density.",
    ('(centroid (transform (call "cube") (translate [1 2 3])))', "[1.0 2.0 3.0]"),
)  # fmt: skip
def centroid(rt: Runtime, x: Any) -> Vector:
    return Vector(_measured(rt, "centroid", x).centroid.tolist())


@define(
    "inertia", "x::Parts", "Array",
    "Return the inertia tensor of an entity or parts of density 1 about its center of mass, along its own axes.",
    ('(round (inertia (call "cube" :scale 6)) 6)', "[[1296.0 0.0 0.0] [0.0 1296.0 0.0] [0.0 0.0 1296.0]]"),
)  # fmt: skip
def inertia(rt: Runtime, x: Any) -> Any:
    return from_numpy(_measured(rt, "inertia", x).inertia)

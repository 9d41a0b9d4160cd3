"""Modifiers of meshes: arrays and mirrors of pieces, bevels of boxes and upright cylinders, and others of polygons."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.blender import polygons
from scenelang.backends.blender.pieces import BooleanPiece, MeshPiece, PieceForm, polygons_of
from scenelang.backends.blender.polygons import Polygons
from scenelang.backends.blender.vectors import euler_matrix
from scenelang.interpreter.transpile.evaluation import UnsupportedPython

FloatArray = npt.NDArray[np.float64]
_MAX_COPIES = 5_000

# Settings with the defaults of Blender 5. A kind that is not here can be made, and is refused when it is applied.
DEFAULTS: dict[str, dict[str, Any]] = {
    "BEVEL": {
        "width": 0.1, "width_pct": 0.1, "segments": 1, "affect": "EDGES", "limit_method": "ANGLE",
        "angle_limit": math.radians(30), "vertex_group": "", "use_clamp_overlap": True, "offset_type": "OFFSET",
        "profile": 0.5, "profile_type": "SUPERELLIPSE", "material": -1, "loop_slide": True, "mark_seam": False,
        "mark_sharp": False, "harden_normals": False, "face_strength_mode": "FSTR_NONE", "miter_outer": "MITER_SHARP",
        "miter_inner": "MITER_SHARP", "spread": 0.1, "vmesh_method": "ADJ", "invert_vertex_group": False,
        "edge_weight": "bevel_weight_edge", "vertex_weight": "bevel_weight_vert",
    },
    "ARRAY": {
        "fit_type": "FIXED_COUNT", "count": 2, "fit_length": 0.0, "curve": None, "use_constant_offset": False,
        "constant_offset_displace": (1.0, 0.0, 0.0), "use_relative_offset": True,
        "relative_offset_displace": (1.0, 0.0, 0.0), "use_merge_vertices": False, "use_merge_vertices_cap": False,
        "merge_threshold": 0.01, "use_object_offset": False, "offset_object": None, "start_cap": None,
        "end_cap": None, "offset_u": 0.0, "offset_v": 0.0,
    },
    "MIRROR": {
        "use_axis": (True, False, False), "use_bisect_axis": (False, False, False),
        "use_bisect_flip_axis": (False, False, False), "use_clip": False, "use_mirror_vertex_groups": True,
        "use_mirror_merge": True, "use_mirror_u": False, "use_mirror_v": False, "use_mirror_udim": False,
        "mirror_offset_u": 0.0, "mirror_offset_v": 0.0, "offset_u": 0.0, "offset_v": 0.0, "merge_threshold": 0.001,
        "bisect_threshold": 0.001, "mirror_object": None,
    },
    "SOLIDIFY": {
        "solidify_mode": "EXTRUDE", "thickness": 0.01, "thickness_clamp": 0.0, "use_thickness_angle_clamp": False,
        "thickness_vertex_group": 0.0, "offset": -1.0, "edge_crease_inner": 0.0, "edge_crease_outer": 0.0,
        "edge_crease_rim": 0.0, "material_offset": 0, "material_offset_rim": 0, "vertex_group": "",
        "use_rim": True, "use_even_offset": False, "use_quality_normals": False, "invert_vertex_group": False,
        "use_flat_faces": False, "use_flip_normals": False, "use_rim_only": False, "shell_vertex_group": "",
        "rim_vertex_group": "", "nonmanifold_thickness_mode": "CONSTRAINTS", "nonmanifold_boundary_mode": "NONE",
        "nonmanifold_merge_threshold": 1e-4, "bevel_convex": 0.0,
    },
    "SUBSURF": {
        "uv_smooth": "PRESERVE_BOUNDARIES", "quality": 3, "boundary_smooth": "ALL",
        "subdivision_type": "CATMULL_CLARK", "levels": 1, "render_levels": 2, "show_only_control_edges": True,
        "use_creases": True, "use_custom_normals": False, "use_limit_surface": True, "use_adaptive_subdivision": False,
    },
    "BOOLEAN": {
        "object": None, "collection": None, "operation": "DIFFERENCE", "operand_type": "OBJECT",
        "double_threshold": 1e-6, "solver": "EXACT", "use_self": False, "use_hole_tolerant": False,
        "material_mode": "INDEX", "debug_options": (),
    },
    "WEIGHTED_NORMAL": {
        "weight": 50, "keep_sharp": False, "mode": "FACE_AREA", "thresh": 0.01, "use_face_influence": False,
    },
    "EDGE_SPLIT": {"split_angle": math.radians(30), "use_edge_angle": True, "use_edge_sharp": True},
    "TRIANGULATE": {
        "quad_method": "SHORTEST_DIAGONAL", "ngon_method": "BEAUTY", "min_vertices": 4, "keep_custom_normals": False,
    },
    "SIMPLE_DEFORM": {
        "deform_method": "TWIST", "vertex_group": "", "deform_axis": "X", "origin": None, "factor": math.pi / 4,
        "angle": math.pi / 4, "limits": (0.0, 1.0), "lock_x": False, "lock_y": False, "lock_z": False,
        "invert_vertex_group": False,
    },
    "SCREW": {
        "object": None, "steps": 16, "render_steps": 16, "iterations": 1, "axis": "Z", "angle": 2 * math.pi,
        "screw_offset": 0.0, "merge_threshold": 0.01, "use_normal_flip": False, "use_normal_calculate": False,
        "use_object_screw_offset": False, "use_merge_vertices": False, "use_smooth_shade": True,
        "use_stretch_u": False, "use_stretch_v": False,
    },
    "WELD": {
        "mode": "ALL", "merge_threshold": 0.001, "vertex_group": "", "invert_vertex_group": False, "loose_edges": False,
    },
}  # fmt: skip
_SHADING = ("WEIGHTED_NORMAL", "EDGE_SPLIT", "TRIANGULATE", "NORMAL_EDIT", "DATA_TRANSFER", "UV_PROJECT", "UV_WARP")


def evaluated(blend: Any, obj: Any) -> list[MeshPiece]:
    """Return the pieces of an object under its modifiers."""
    pieces = list(obj.data.settled())
    for modifier in obj.modifiers.items_:
        if modifier.settings.get("show_render", True) is False:
            continue
        pieces = applied(blend, obj, modifier, pieces)
    return pieces


def applied(blend: Any, obj: Any, modifier: Any, pieces: list[MeshPiece]) -> list[MeshPiece]:
    """Return pieces under one modifier."""
    if modifier.type in _SHADING or not pieces:
        return pieces
    function = _MODIFIERS.get(modifier.type)
    if function is None:
        name = modifier.type.lower().replace("_", " ")
        raise UnsupportedPython(f"the modifier `{modifier.type}` ({name}) is not supported")
    made: list[MeshPiece] = function(blend, obj, modifier.settings, pieces)
    blend.tick(50 + sum(len(piece.mesh.points) if piece.mesh is not None else 10 for piece in made))
    return made


def _array(blend: Any, obj: Any, settings: dict[str, Any], pieces: list[MeshPiece]) -> list[MeshPiece]:
    """Return pieces with the copies that an array modifier makes."""
    if settings["start_cap"] or settings["end_cap"] or settings["fit_type"] == "FIT_CURVE":
        raise UnsupportedPython("arrays along curves or with caps are not supported")
    points = polygons_of(pieces).points
    sizes = points.max(axis=0) - points.min(axis=0)
    step = np.eye(4)
    if settings["use_relative_offset"]:
        step[:3, 3] += sizes * settings["relative_offset_displace"].array()
    if settings["use_constant_offset"]:
        step[:3, 3] += settings["constant_offset_displace"].array()
    if settings["use_object_offset"] and settings["offset_object"] is not None:
        between = np.linalg.inv(obj.computed_world()) @ settings["offset_object"].computed_world()
        step = step @ between  # as in Blender: the object's offset is in the axes of the copy
    count = int(settings["count"])
    if settings["fit_type"] == "FIT_LENGTH":
        length = float(np.linalg.norm(step[:3, 3]))
        # Blender's tolerance: a length that is a multiple of the step includes the last copy
        count = int((settings["fit_length"] + 1e-6) / length) + 1 if length > 1e-6 else 1
    if count * len(pieces) > _MAX_COPIES:
        raise UnsupportedPython(f"this array has more than {_MAX_COPIES:,} parts")
    made: list[MeshPiece] = []
    matrix = np.eye(4)
    for _ in range(max(1, count)):
        made += [piece.moved(matrix) for piece in pieces]
        matrix = matrix @ step
    if settings["use_merge_vertices"]:
        welded = polygons_of(made).welded(settings["merge_threshold"])
        if len(welded.points) < len(polygons_of(made).points):
            return [_raw(welded, pieces)]
    return made


def _raw(mesh: Polygons, pieces: Sequence[MeshPiece]) -> MeshPiece:
    return MeshPiece(np.eye(4), None, mesh, 0, bool(pieces) and all(piece.is_smooth for piece in pieces))


def _mirror(blend: Any, obj: Any, settings: dict[str, Any], pieces: list[MeshPiece]) -> list[MeshPiece]:
    """Return pieces with their reflections along the chosen axes of the object or of ``mirror_object``."""
    frame = np.eye(4)
    if settings["mirror_object"] is not None:
        frame = np.linalg.inv(obj.computed_world()) @ settings["mirror_object"].computed_world()
    made = list(pieces)
    for axis in range(3):
        if not settings["use_axis"][axis]:
            continue
        flip = np.eye(4)
        flip[axis, axis] = -1.0
        reflection = frame @ flip @ np.linalg.inv(frame)
        # this row of the inverse gives the coordinate of a point along the axis in the mirror's frame
        normal = np.linalg.inv(frame)[axis]
        if settings["use_bisect_axis"][axis]:
            sign = -1.0 if settings["use_bisect_flip_axis"][axis] else 1.0
            keep = lambda points, n=normal, s=sign: s * (points @ n[:3] + n[3])
            made = [_raw(polygons.bisected(polygons_of(made), keep), made)]
        if settings["use_mirror_merge"]:
            made = _merged(made, reflection, normal, settings["merge_threshold"])
        else:
            made = [*made, *(piece.moved(reflection) for piece in made)]
    return made


def _merged(pieces: list[MeshPiece], reflection: FloatArray, normal: FloatArray, threshold: float) -> list[MeshPiece]:
    """Mirror pieces; corners on the plane become one with their images."""
    made: list[MeshPiece] = []
    for piece in pieces:
        mesh = piece.polygons()
        near = np.abs(mesh.points @ normal[:3] + normal[3]) * 2 <= threshold
        if not near.any() or mesh.is_closed():
            # A closed mesh that touches the plane keeps its face there, and encloses the same volume.
            made += [piece, piece.moved(reflection)]
            continue
        image = mesh.moved(reflection)
        count = len(mesh.points)
        both = polygons.combined([mesh, image])
        place = [*range(count), *(i if near[i] else i + count for i in range(count))]
        made.append(_raw(both._relabeled(place), [piece]))
    return made


def _solidify(blend: Any, obj: Any, settings: dict[str, Any], pieces: list[MeshPiece]) -> list[MeshPiece]:
    if settings["solidify_mode"] != "EXTRUDE" or settings["vertex_group"] or settings["use_rim_only"]:
        raise UnsupportedPython("this kind of `SOLIDIFY` is not supported")
    made = []
    for piece in pieces:
        thick = polygons.solidified(
            piece.polygons(),
            settings["thickness"],
            settings["offset"],
            has_rim=settings["use_rim"],
            is_even=settings["use_even_offset"],
        )
        made.append(_raw(thick, [piece]))
    return made


def _subsurf(blend: Any, obj: Any, settings: dict[str, Any], pieces: list[MeshPiece]) -> list[MeshPiece]:
    levels = int(settings["levels"])
    if levels == 0:
        return pieces
    is_simple = settings["subdivision_type"] == "SIMPLE"
    if is_simple:
        return pieces  # of the same shape
    on_limit = bool(settings["use_limit_surface"])
    return [_raw(polygons.subdivided(piece.polygons(), levels, on_limit=on_limit), [piece]) for piece in pieces]


def _bevel(blend: Any, obj: Any, settings: dict[str, Any], pieces: list[MeshPiece]) -> list[MeshPiece]:
    if settings["affect"] != "EDGES" or settings["limit_method"] in ("VGROUP",):
        raise UnsupportedPython("only bevels of edges are supported")
    if settings["limit_method"] == "WEIGHT":
        return pieces  # no edge has a weight
    if settings["profile_type"] != "SUPERELLIPSE" or abs(settings["profile"] - 0.5) > 1e-6:
        raise UnsupportedPython("only bevels with the profile 0.5 are supported")
    limit = settings["angle_limit"] if settings["limit_method"] == "ANGLE" else -1.0
    width, segments = float(settings["width"]), max(1, int(settings["segments"]))
    if settings["offset_type"] not in ("OFFSET", "WIDTH"):
        raise UnsupportedPython(f"bevels whose width is `{settings['offset_type']}` are not supported")
    if width <= 0:
        return pieces
    return [_beveled(piece, width, segments, limit, settings) for piece in pieces]


def _beveled(piece: MeshPiece, width: float, segments: int, limit: float, settings: dict[str, Any]) -> MeshPiece:
    mesh = piece.polygons()
    if not _sharp_edges(mesh, limit):
        return piece
    boxed = as_box(mesh)
    if boxed is not None:
        matrix, sizes = boxed
        at_right_angle = width if settings["offset_type"] == "OFFSET" else width / math.sqrt(2)
        if settings["use_clamp_overlap"]:
            at_right_angle = min(at_right_angle, float(sizes.min()) / 2)
        return replace(
            piece, matrix=matrix @ np.diag([*sizes, 1.0]), form=PieceForm("cube"), mesh=None,
            bevel=(at_right_angle, segments), bevel_sizes=tuple(sizes.tolist()),
            slot=mesh.slots()[0],
        )  # fmt: skip
    if piece.form is not None and piece.form.kind == "cone" and settings["offset_type"] == "OFFSET":
        turned = _beveled_cone(piece, width, segments, limit)
        if turned is not None:
            return _raw(turned, [piece])
    raise UnsupportedPython(
        "bevels are supported for boxes and upright cylinders only",
        "leave the modifier out, or build the shape with it",
    )


def _sharp_edges(mesh: Polygons, limit: float) -> bool:
    normals = mesh.face_normals()
    for around in mesh.edges().values():
        if len(around) == 2:
            cosine = float(np.clip(normals[around[0]] @ normals[around[1]], -1, 1))
            angle = math.acos(cosine)
            if angle > max(limit, 1e-4) + 1e-6 or (limit < 0 and angle >= 0):
                return True
    return False


def as_box(mesh: Polygons) -> tuple[FloatArray, FloatArray] | None:
    """Return a matrix (4, 4) and sizes if a mesh is a box: rectangular, of eight corners and six faces."""
    if len(mesh.points) != 8 or len(mesh.faces) != 6 or any(len(face) != 4 for face in mesh.faces):
        return None
    start = mesh.points[0]
    ends = {b for a, b in mesh.edges() if a == 0} | {a for a, b in mesh.edges() if b == 0}
    if len(ends) != 3:
        return None
    sides = np.array(
        [mesh.points[end] - start for end in sorted(ends, key=lambda e: _main_axis(mesh.points[e] - start))]
    )
    lengths = np.linalg.norm(sides, axis=1)
    if lengths.min() <= 1e-12:
        return None
    axes = sides / lengths[:, None]
    if not np.allclose(axes @ axes.T, np.eye(3), atol=1e-5):
        return None
    center = start + sides.sum(axis=0) / 2
    inside = np.abs((mesh.points - center) @ axes.T) / lengths
    if not np.allclose(inside, 0.5, atol=1e-5) or not mesh.is_closed():
        return None
    axes *= np.sign(axes[np.arange(3), np.abs(axes).argmax(axis=1)])[:, None]
    matrix = np.eye(4)
    if np.linalg.det(axes) < 0:
        axes[2] *= -1
    matrix[:3, :3], matrix[:3, 3] = axes.T, center
    return matrix, lengths


def _main_axis(direction: FloatArray) -> int:
    return int(np.abs(direction).argmax())


def _beveled_cone(piece: MeshPiece, width: float, segments: int, limit: float) -> Polygons | None:
    """Return a frustum with beveled rims; its sides must be upright, and the edges between them below the limit."""
    form = piece.form
    assert form is not None, "the caller has a form"
    count = form.counts[0]
    bottom, top = form.sizes
    linear = piece.matrix[:3, :3]
    scales = np.linalg.norm(linear, axis=0)
    is_regular = np.allclose(linear.T @ linear, np.diag(scales**2), atol=1e-6) and abs(scales[0] - scales[1]) < 1e-6
    if (
        form.fill != "NGON"
        or not is_regular
        or abs(bottom - top) > 1e-9
        or 2 * math.pi / count > limit > 0
        or limit < 0
    ):
        return None
    radius, half = bottom * scales[0], scales[2] / 2
    inset = math.cos(math.pi / count)
    width = min(width, half, radius * inset)
    levels = [math.pi / 2 * i / segments for i in range(segments + 1)]
    rows = [(radius - width / inset * (1 - math.cos(a)), half - width * (1 - math.sin(a))) for a in levels]
    rows = [(r, -z) for r, z in reversed(rows)] + rows
    points = [point for r, z in rows for point in polygons.ring_points(count, r, z)]
    at: Callable[[int, int], int] = lambda j, i: j * count + i % count
    faces: list[tuple[int, ...]] = [
        (at(j, i + 1), at(j, i), at(j + 1, i), at(j + 1, i + 1)) for j in range(len(rows) - 1) for i in range(count)
    ]
    last = (len(rows) - 1) * count
    faces += [tuple(range(count)), tuple(range(last, last + count))[::-1]]
    made = Polygons(np.array(points), tuple(faces), (piece.slot,) * len(faces))
    return made.moved(piece.matrix @ np.diag([*(1 / scales), 1.0])).welded(1e-7)


def _boolean(blend: Any, obj: Any, settings: dict[str, Any], pieces: list[MeshPiece]) -> list[MeshPiece]:
    tools: list[Any] = [settings["object"]] if settings["object"] is not None else []
    if settings["operand_type"] == "COLLECTION" and settings["collection"] is not None:
        tools = [each for each in settings["collection"].all_objects if each.type == "MESH"]
    if not tools:
        return pieces
    inverse = np.linalg.inv(obj.computed_world())
    parts = []
    for tool in tools:
        if tool is obj or tool.type != "MESH":
            raise UnsupportedPython("this operand of a boolean is not supported")
        matrix = inverse @ tool.computed_world()
        parts.append(tuple(piece.moved(matrix) for piece in evaluated(blend, tool)))
    for piece in (*pieces, *(piece for part in parts for piece in part)):
        if piece.operation is None and not piece.is_closed():
            raise UnsupportedPython("a boolean of a mesh that is not closed is not supported")
    operation = BooleanPiece(settings["operation"], tuple(pieces), tuple(part for part in parts if part))
    slot = pieces[0].slot if pieces[0].mesh is None else pieces[0].mesh.slots()[0]
    return [MeshPiece(np.eye(4), operation=operation, is_smooth=pieces[0].is_smooth, slot=slot)]


def _simple_deform(blend: Any, obj: Any, settings: dict[str, Any], pieces: list[MeshPiece]) -> list[MeshPiece]:
    if settings["origin"] is not None or settings["vertex_group"] or list(settings["limits"]) != [0.0, 1.0]:
        raise UnsupportedPython("a `SIMPLE_DEFORM` with an origin, limits or a vertex group is not supported")
    method, axis = settings["deform_method"], "XYZ".index(settings["deform_axis"])
    if method not in ("TWIST", "TAPER"):
        raise UnsupportedPython(f"a `SIMPLE_DEFORM` of the kind {method} is not supported")
    mesh = polygons_of(pieces)
    points = mesh.points.copy()
    low, high = points[:, axis].min(), points[:, axis].max()
    # Blender deforms about the origin, where a corner at 0 has no turn, by the share of the extent.
    share = points[:, axis] / max(high - low, 1e-9)
    if method == "TAPER":
        factor = 1 + share * settings["factor"]
        for other in {0, 1, 2} - {axis}:
            points[:, other] *= factor
    else:
        for i, each in enumerate(share):
            angles = [0.0, 0.0, 0.0]
            angles[axis] = float(each * settings["angle"])
            points[i] = euler_matrix(angles) @ points[i]
    return [_raw(Polygons(points, mesh.faces, mesh.slots()), pieces)]


def _weld(blend: Any, obj: Any, settings: dict[str, Any], pieces: list[MeshPiece]) -> list[MeshPiece]:
    return [_raw(polygons_of(pieces).welded(settings["merge_threshold"]), pieces)]


def _screw(blend: Any, obj: Any, settings: dict[str, Any], pieces: list[MeshPiece]) -> list[MeshPiece]:
    raise UnsupportedPython("the modifier `SCREW` is not supported", "build the corners of the turned profile")


_MODIFIERS: dict[str, Callable[..., list[MeshPiece]]] = {
    "ARRAY": _array, "MIRROR": _mirror, "SOLIDIFY": _solidify, "SUBSURF": _subsurf, "BEVEL": _bevel, "WELD": _weld,
    "SCREW": _screw, "BOOLEAN": _boolean, "SIMPLE_DEFORM": _simple_deform,
}  # fmt: skip

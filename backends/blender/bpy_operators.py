"""`bpy.ops`: the operators that have a meaning for a scene; the others are refused by name where they are called."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.blender import modifiers, polygons
from scenelang.backends.blender.blend_model import Blend, MeshBlock, Object, OtherData
from scenelang.backends.blender.pieces import MeshPiece, PieceForm, polygons_of
from scenelang.backends.blender.vectors import MatrixValue, composed, euler_matrix
from scenelang.interpreter.transpile.evaluation import UnsupportedPython
from scenelang.interpreter.transpile.evaluation.objects import MISSING, HostObject, Native

FloatArray = npt.NDArray[np.float64]
_DONE = frozenset({"FINISHED"})
_ZERO, _ONE = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)
_MAX_SIDES = 10_000

# Groups and operators that change nothing that a scene has.
_HARMLESS_GROUPS = (
    "render", "export_scene", "export_mesh", "screen", "view3d", "ed", "outliner", "info", "preferences", "script",
    "sequencer", "image", "uv", "world", "ui", "file", "workspace", "console", "text", "wm",
)  # fmt: skip
_HARMLESS = {
    "object": "make_single_user make_local hide_view_clear material_slot_remove_unused select_linked bake track_clear "
    "constraints_clear collection_objects_select",
    "mesh": "select_mode mark_sharp mark_seam customdata_custom_splitnormals_clear customdata_custom_splitnormals_add "
    "faces_shade_smooth faces_shade_flat uv_texture_add vertex_color_add edges_select_sharp select_non_manifold "
    "tris_convert_to_quads quads_convert_to_tris",
    "material": "new",
}
_FILE_READERS = (
    "obj_import",
    "stl_import",
    "ply_import",
    "usd_import",
    "alembic_import",
    "append",
    "link",
    "collada_import",
)


class OperatorRoot(HostObject):
    """`bpy.ops`."""

    python_name = "ops"

    def __init__(self, operators: Operators) -> None:
        self._operators = operators

    def read(self, name: str) -> Any:
        return MISSING if name.startswith("_") else OperatorGroup(self._operators, name)


class OperatorGroup(HostObject):
    """`bpy.ops.mesh` and the like."""

    python_name = "ops"

    def __init__(self, operators: Operators, name: str) -> None:
        self._operators, self._name = operators, name

    def read(self, name: str) -> Any:
        if name.startswith("_"):
            return MISSING
        return Operator(self._operators, self._name, name)


class Operator(HostObject):
    """Operator, which can be called or asked whether it can run."""

    python_name = "ops"

    def __init__(self, operators: Operators, group: str, name: str) -> None:
        self._operators, self._group, self._name = operators, group, name

    def read(self, name: str) -> Any:
        return Native("poll", lambda *_: True) if name == "poll" else MISSING

    def __call__(self, *context: Any, **named: Any) -> Any:
        return self._operators.call(self._group, self._name, named)


class Operators:
    """Runs operators on the state of Blender."""

    def __init__(self, blend: Blend) -> None:
        self.blend = blend

    def call(self, group: str, name: str, named: dict[str, Any]) -> frozenset[str]:
        """Run an operator by name; a keyword that it does not have is an error, as in Blender."""
        method: Callable[..., Any] | None = getattr(self, f"{group}_{name}", None)
        if method is not None:
            self.blend.update()
            method(**named)
            self.blend.update()
            return _DONE
        if name in _HARMLESS.get(group, "").split():
            return _DONE
        if group in _HARMLESS_GROUPS and name not in _FILE_READERS and group != "import_scene":
            if group.startswith("export") or name.endswith(("export", "save_as_mainfile")) or group == "render":
                self.blend.warn("files and pictures that the script writes are left out")
            return _DONE
        raise UnsupportedPython(f"the operator `bpy.ops.{group}.{name}` is not supported", _hint(group, name))

    # --- adding objects

    def _added(self, name: str, data: Any, location: Any, rotation: Any) -> Object:
        blend = self.blend
        if blend.mode == "EDIT":
            raise UnsupportedPython("primitives that are added in edit mode are not supported", "use object mode")
        made = Object(blend, name, data)
        made.location.set(location)
        made.rotation_euler.set([*rotation])
        blend.collection.objects.link(made)
        blend.select([made])
        blend.active = made
        return made

    def _primitive(self, name: str, form: PieceForm, sizes: Sequence[float], options: dict[str, Any]) -> None:
        location, rotation = options.pop("location", _ZERO), options.pop("rotation", _ZERO)
        scale = [float(value) for value in options.pop("scale", _ZERO)]
        if options.pop("align", "WORLD") not in ("WORLD", "VIEW", "CURSOR"):
            raise UnsupportedPython("this alignment is not supported")
        in_edit_mode = options.pop("enter_editmode", False)
        options.pop("calc_uvs", None)
        options.pop("generate_uvs", None)
        if options:
            raise TypeError(f'Converting py args to operator properties: keyword "{next(iter(options))}" unrecognized')
        mesh = MeshBlock(self.blend, name)
        # A scale is that of the mesh, and the object has none; zeros are Blender's way to say that none is given.
        factors = np.array(_ONE if not any(scale) else scale)
        mesh.pieces = [MeshPiece(np.diag([*(np.array(sizes) * factors), 1.0]), form)]
        self._added(name, mesh, location, rotation)
        if in_edit_mode:
            self.object_mode_set("EDIT")

    def mesh_primitive_cube_add(self, size: float = 2.0, **options: Any) -> None:
        """Add a cube."""
        self._primitive("Cube", PieceForm("cube"), [size] * 3, options)

    def mesh_primitive_plane_add(self, size: float = 2.0, **options: Any) -> None:
        """Add a square."""
        self._primitive("Plane", PieceForm("plane", (1, 1)), [size] * 3, options)

    def mesh_primitive_grid_add(
        self, x_subdivisions: int = 10, y_subdivisions: int = 10, size: float = 2.0, **options: Any
    ) -> None:
        """Add a square of many faces."""
        self._primitive(
            "Grid", PieceForm("plane", (_sides(x_subdivisions), _sides(y_subdivisions))), [size] * 3, options
        )

    def mesh_primitive_circle_add(
        self, vertices: int = 32, radius: float = 1.0, fill_type: str = "NOTHING", **options: Any
    ) -> None:
        """Add a disk."""
        self._primitive("Circle", PieceForm("circle", (_sides(vertices),), fill=fill_type), [radius] * 3, options)

    def mesh_primitive_uv_sphere_add(
        self, segments: int = 32, ring_count: int = 16, radius: float = 1.0, **options: Any
    ) -> None:
        """Add a sphere."""
        self._primitive("Sphere", PieceForm("sphere", (_sides(segments), _sides(ring_count))), [radius] * 3, options)

    def mesh_primitive_ico_sphere_add(self, subdivisions: int = 2, radius: float = 1.0, **options: Any) -> None:
        """Add a sphere of triangles."""
        self._primitive("Icosphere", PieceForm("ico", (subdivisions,)), [radius] * 3, options)

    def mesh_primitive_cylinder_add(
        self,
        vertices: int = 32,
        radius: float = 1.0,
        depth: float = 2.0,
        end_fill_type: str = "NGON",
        **options: Any,
    ) -> None:
        """Add a cylinder."""
        form = PieceForm("cone", (_sides(vertices),), (1.0, 1.0), end_fill_type)
        self._primitive("Cylinder", form, [radius, radius, depth], options)

    def mesh_primitive_cone_add(
        self,
        vertices: int = 32,
        radius1: float = 1.0,
        radius2: float = 0.0,
        depth: float = 2.0,
        end_fill_type: str = "NGON",
        **options: Any,
    ) -> None:
        """Add a cone or a frustum."""
        largest = max(radius1, radius2) or 1.0
        form = PieceForm("cone", (_sides(vertices),), (radius1 / largest, radius2 / largest), end_fill_type)
        self._primitive("Cone", form, [largest, largest, depth], options)

    def mesh_primitive_torus_add(
        self,
        major_segments: int = 48,
        minor_segments: int = 12,
        mode: str = "MAJOR_MINOR",
        major_radius: float = 1.0,
        minor_radius: float = 0.25,
        abso_major_rad: float = 1.25,
        abso_minor_rad: float = 0.75,
        **options: Any,
    ) -> None:
        """Add a torus."""
        if mode == "EXT_INT":
            major_radius, minor_radius = (abso_major_rad + abso_minor_rad) / 2, (abso_major_rad - abso_minor_rad) / 2
        form = PieceForm("torus", (_sides(major_segments), _sides(minor_segments)), (major_radius, minor_radius))
        self._primitive("Torus", form, _ONE, options)

    def object_empty_add(
        self, type: str = "PLAIN_AXES", radius: float = 1.0, location: Any = _ZERO, rotation: Any = _ZERO, **_: Any
    ) -> None:
        """Add an object without geometry."""
        self._added("Empty", None, location, rotation)

    def object_camera_add(self, location: Any = _ZERO, rotation: Any = _ZERO, **_: Any) -> None:
        """Add a camera, which is left out."""
        self.blend.warn_left_out("CAMERA")
        self._added("Camera", OtherData(self.blend.cameras, "Camera", "CAMERA"), location, rotation)

    def object_light_add(
        self, type: str = "POINT", radius: float = 1.0, location: Any = _ZERO, rotation: Any = _ZERO, **_: Any
    ) -> None:
        """Add a light, which is left out."""
        self.blend.warn_left_out("LIGHT")
        data = OtherData(self.blend.lights, type.title(), "LIGHT")
        data.assign("type", type)
        self._added(type.title(), data, location, rotation)

    # --- selection

    def object_select_all(self, action: str = "TOGGLE") -> None:
        """Select or deselect all objects."""
        for each in self.blend.scene.collection.all_objects:
            if not each.is_hidden:
                each.is_selected = {"SELECT": True, "DESELECT": False}.get(action, not each.is_selected)

    def object_select_by_type(self, extend: bool = False, type: str = "MESH") -> None:
        """Select the objects of a kind."""
        for each in self.blend.scene.collection.all_objects:
            each.is_selected = each.type == type or (extend and each.is_selected)

    def object_select_pattern(self, pattern: str = "*", extend: bool = True, case_sensitive: bool = False) -> None:
        """Select objects by name."""
        from fnmatch import fnmatch

        for each in self.blend.scene.collection.all_objects:
            each.is_selected = fnmatch(each.name.lower(), pattern.lower()) or (extend and each.is_selected)

    def _selected(self) -> list[Object]:
        return self.blend.selected()

    def object_delete(self, use_global: bool = False, confirm: bool = True) -> None:
        """Delete the selected objects."""
        for each in self._selected():
            self.blend.objects.remove(each)

    def object_duplicate(self, linked: bool = False, mode: str = "TRANSLATION") -> None:
        """Duplicate the selected objects."""
        blend = self.blend
        active, copies = blend.active, []
        place: dict[int, Object] = {}
        for each in self._selected():
            made = place[id(each)] = each.copy()
            if not linked and each.data is not None and each.type == "MESH":
                made.data = each.data.copy()
            for collection in each.users_collection:
                collection.objects.link(made)
            copies.append(made)
            if each is active:
                blend.active = made
        for made in copies:
            if made.parent is not None and id(made.parent) in place:
                made.parent = place[id(made.parent)]
        blend.select(copies)

    def object_duplicate_move(
        self, OBJECT_OT_duplicate: Any = None, TRANSFORM_OT_translate: Any = None, **_: Any
    ) -> None:
        """Duplicate the selected objects and move the copies."""
        self.object_duplicate(**{k: v for k, v in (OBJECT_OT_duplicate or {}).items() if k == "linked"})
        self.transform_translate(**(TRANSFORM_OT_translate or {}))

    def object_duplicate_move_linked(self, OBJECT_OT_duplicate: Any = None, TRANSFORM_OT_translate: Any = None) -> None:
        """Duplicate the selected objects with their data and move the copies."""
        self.object_duplicate(linked=True)
        self.transform_translate(**(TRANSFORM_OT_translate or {}))

    def object_join(self) -> None:
        """Join the selected meshes into the active one."""
        active = self.blend.active
        if active is None or active.type != "MESH":
            raise RuntimeError("Operator bpy.ops.object.join.poll() failed, context is incorrect")
        inverse = np.linalg.inv(active.world)
        pieces = list(active.data.settled())
        materials = list(active.data.materials.items_)
        if not materials and any(o.data.materials.items_ for o in self._selected() if o.type == "MESH"):
            materials = [None]
        for each in self._selected():
            if each is active or each.type != "MESH":
                continue
            if each.modifiers.items_:
                self.blend.warn("`join` drops the modifiers of the objects that are joined, as Blender does")
            places = [_place(materials, material) for material in each.data.materials.items_] or [0]
            matrix = inverse @ each.world
            pieces += [_with_slots(piece, places).moved(matrix) for piece in each.data.settled()]
            self.blend.objects.remove(each)
        active.data._shown = None
        active.data.pieces = pieces
        active.data.materials.items_ = materials
        if not any(piece.operation is not None for piece in pieces):
            self.blend.tick(sum(len(piece.polygons().points) for piece in pieces))

    # --- transforms

    def object_transform_apply(
        self, location: bool = True, rotation: bool = True, scale: bool = True, properties: bool = True,
        isolate_users: bool = False,
    ) -> None:  # fmt: skip
        """Move transforms from the selected objects into their meshes."""
        for each in self._selected():
            if each.type not in ("MESH", "EMPTY"):
                continue
            turn = each.rotation() if rotation else np.eye(3)
            factors = each.scale.array() if scale else np.ones(3)
            offset = each.location.array() if location else np.zeros(3)
            applied = composed(offset, turn, factors)
            if rotation and not scale:  # the scale stays outside, along the axes after the rotation
                kept = np.diag([*each.scale.array(), 1.0])
                applied = np.linalg.inv(kept) @ composed(offset, turn, each.scale.array())
                if not np.allclose(applied, composed(offset, turn, np.ones(3)), atol=1e-6):
                    raise UnsupportedPython("a rotation of an object with an uneven scale cannot be applied alone")
            elif location and not (rotation and scale):
                inner = composed(np.zeros(3), np.eye(3) if rotation else each.rotation(), _ONE if scale else each.scale)
                applied = np.linalg.inv(inner) @ composed(offset, each.rotation(), each.scale)
            if isinstance(each.data, MeshBlock):
                if sum(o.data is each.data for o in self.blend.objects.listed()) > 1:
                    raise RuntimeError("Error: Cannot apply to a multi user: Object, Mesh, aborting")
                each.data.pieces = [piece.moved(applied) for piece in each.data.settled()]
            for child in each.children_:
                child.matrix_parent_inverse = MatrixValue(applied @ child.matrix_parent_inverse.numbers)
            if location:
                each.location.zero()
            if rotation:
                each.turn(np.eye(3))
            if scale:
                each.scale.set(_ONE)

    def object_visual_transform_apply(self) -> None:
        """Set the transforms of the selected objects to what they look like."""
        for each in self._selected():
            world = each.computed_world()
            each.matrix_world = MatrixValue(world)

    def object_location_clear(self, clear_delta: bool = False) -> None:
        """Clear locations."""
        for each in self._selected():
            each.location.zero()

    def object_rotation_clear(self, clear_delta: bool = False) -> None:
        """Clear rotations."""
        for each in self._selected():
            each.turn(np.eye(3))

    def object_scale_clear(self, clear_delta: bool = False) -> None:
        """Clear scales."""
        for each in self._selected():
            each.scale.set(_ONE)

    def object_origin_set(self, type: str = "GEOMETRY_ORIGIN", center: str = "MEDIAN") -> None:
        """Move origins relative to the geometry."""
        for each in self._selected():
            if not isinstance(each.data, MeshBlock):
                continue
            points = polygons_of(each.data.settled()).points
            if type == "GEOMETRY_ORIGIN":
                self._shift(each, -self._middle(points, center))
                continue
            if type == "ORIGIN_GEOMETRY":
                target = self._middle(points, center)
            elif type == "ORIGIN_CURSOR":
                cursor = self.blend.scene.cursor.values["location"]
                target = (np.linalg.inv(each.world) @ [*cursor, 1.0])[:3]
            elif type in ("ORIGIN_CENTER_OF_MASS", "ORIGIN_CENTER_OF_VOLUME"):
                target = _center_of_volume(polygons_of(each.data.settled()))
            else:
                raise UnsupportedPython(f"`origin_set` of the kind {type} is not supported")
            self._shift(each, -target)
            moved = each.basis()[:3, :3] @ target
            each.location.set(each.location.array() + moved)

    def _middle(self, points: FloatArray, center: str) -> FloatArray:
        if center == "BOUNDS":
            return (points.min(axis=0) + points.max(axis=0)) / 2  # type: ignore[no-any-return]
        return points.mean(axis=0)  # type: ignore[no-any-return]

    def _shift(self, obj: Object, offset: FloatArray) -> None:
        matrix = composed(offset, np.eye(3), _ONE)
        obj.data.pieces = [piece.moved(matrix) for piece in obj.data.settled()]

    def transform_translate(self, value: Any = _ZERO, orient_type: str = "GLOBAL", **_: Any) -> None:
        """Move the selected objects."""
        if self.blend.mode == "EDIT":
            self._edit_matrix(composed([*value], np.eye(3), _ONE))
            return
        for each in self._tops():
            world = each.computed_world()
            world[:3, 3] += [*value]
            each.matrix_world = MatrixValue(world)

    def transform_rotate(
        self,
        value: float = 0.0,
        orient_axis: str = "Z",
        orient_type: str = "GLOBAL",
        center_override: Any = None,
        **_: Any,
    ) -> None:
        """Rotate the selected objects about their middle."""
        chosen = self._tops()
        if not chosen:
            return
        # The operator turns against the right-hand rule of the view; Blender 5 turns with it about the axis.
        turn = euler_matrix([value * (name == orient_axis) for name in "XYZ"])
        middle = self._pivot(chosen, center_override)
        for each in chosen:
            matrix = (
                composed(middle, np.eye(3), _ONE) @ composed(_ZERO, turn, _ONE) @ composed(-middle, np.eye(3), _ONE)
            )
            each.matrix_world = MatrixValue(matrix @ each.computed_world())

    def transform_resize(self, value: Any = _ONE, center_override: Any = None, **_: Any) -> None:
        """Scale the selected objects about their middle."""
        if self.blend.mode == "EDIT":
            raise UnsupportedPython("`transform.resize` in edit mode is not supported", "set `obj.scale`")
        chosen = self._tops()
        if not chosen:
            return
        middle = self._pivot(chosen, center_override)
        for each in chosen:
            if not np.allclose(each.rotation(), np.eye(3)) and len({round(float(v), 9) for v in value}) > 1:
                raise UnsupportedPython("an uneven `transform.resize` of a rotated object is not supported")
            world = each.computed_world()
            each.scale.set(each.scale.array() * np.array([*value]))
            place = middle + (world[:3, 3] - middle) * np.array([*value])
            each.location.set(each.location.array() + place - world[:3, 3])

    def _pivot(self, chosen: Sequence[Object], given: Any) -> FloatArray:
        """Return the middle of the box of the origins (Blender's median of objects is that of their origins)."""
        if given is not None:
            return np.array([*given], np.float64)
        return np.mean([each.computed_world()[:3, 3] for each in chosen], axis=0)  # type: ignore[no-any-return]

    def _tops(self) -> list[Object]:
        chosen = self._selected()
        return [each for each in chosen if not any(each.parent is other for other in chosen)]

    # --- parents

    def object_parent_set(self, type: str = "OBJECT", keep_transform: bool = False, **_: Any) -> None:
        """Make the active object the parent of the other selected ones, which stay where they are."""
        parent = self.blend.active
        if type not in ("OBJECT",) or parent is None:
            raise UnsupportedPython(f"parents of the kind {type} are not supported")
        for each in self._selected():
            if each is parent:
                continue
            world = each.computed_world()
            each.parent = parent
            each.matrix_parent_inverse = MatrixValue(np.linalg.inv(parent.computed_world()))
            if keep_transform or not np.allclose(each.computed_world(), world):
                each.world = world
                each.matrix_world = MatrixValue(world)

    def object_parent_clear(self, type: str = "CLEAR") -> None:
        """Remove the parents of the selected objects."""
        for each in self._selected():
            world = each.computed_world()
            each.parent = None
            if type == "CLEAR_KEEP_TRANSFORM":
                each.matrix_world = MatrixValue(world)

    def object_move_to_collection(
        self, collection_index: int = 0, is_new: bool = False, new_collection_name: str = ""
    ) -> None:
        """Move the selected objects to a new collection."""
        if not is_new:
            return
        collection = self.blend.collections.new(new_collection_name)
        self.blend.scene.collection.children.link(collection)
        for each in self._selected():
            for old in each.users_collection:
                old.objects.unlink(each)
            collection.objects.link(each)

    # --- modes, shading, modifiers, materials

    def object_mode_set(self, mode: str = "OBJECT", toggle: bool = False) -> None:
        """Change the mode."""
        if mode not in ("OBJECT", "EDIT"):
            raise UnsupportedPython(f"the mode {mode} is not supported", _hint("object", mode.lower()))
        if mode == "EDIT" and (self.blend.active is None or not isinstance(self.blend.active.data, MeshBlock)):
            raise RuntimeError("Operator bpy.ops.object.mode_set.poll() Context missing active object")
        self.blend.mode = mode

    def object_editmode_toggle(self) -> None:
        """Change between object mode and edit mode."""
        self.object_mode_set("OBJECT" if self.blend.mode == "EDIT" else "EDIT")

    def _shade(self, *, is_smooth: bool) -> None:
        for each in self._selected():
            if isinstance(each.data, MeshBlock):
                each.data.pieces = [replace(piece, is_smooth=is_smooth) for piece in each.data.settled()]

    def object_shade_smooth(self, **_: Any) -> None:
        """Shade the selected objects smooth."""
        self._shade(is_smooth=True)

    def object_shade_smooth_by_angle(self, angle: float = math.radians(30), **_: Any) -> None:
        """Shade the selected objects smooth where their faces meet below an angle."""
        for each in self._selected():
            if isinstance(each.data, MeshBlock):
                pieces = each.data.settled()
                each.data.pieces = [replace(piece, is_smooth=_meets_below(piece, angle)) for piece in pieces]

    def object_shade_auto_smooth(self, use_auto_smooth: bool = True, angle: float = math.radians(30), **_: Any) -> None:
        """Shade the selected objects smooth where their faces meet below an angle."""
        self.object_shade_smooth_by_angle(angle)

    def object_shade_flat(self, **_: Any) -> None:
        """Shade the selected objects flat."""
        self._shade(is_smooth=False)

    def object_modifier_add(self, type: str = "SUBSURF", **_: Any) -> None:
        """Add a modifier to the active object."""
        if type == "PARTICLE_SYSTEM" or self.blend.active is None:
            raise UnsupportedPython("particle systems are not supported")
        taken = {modifier.name for modifier in self.blend.active.modifiers.items_}
        stem = _MODIFIER_NAMES.get(type, type.title().replace("_", ""))
        name = next(n for n in (stem, *(f"{stem}.{i:03d}" for i in range(1, 1000))) if n not in taken)
        made = self.blend.active.modifiers.new(name, type)
        self.blend.active.modifiers.active = made

    def object_modifier_apply(self, modifier: str = "", apply_as: str = "DATA", report: bool = False, **_: Any) -> None:
        """Apply a modifier of the active object to its mesh."""
        active = self.blend.active
        applied = active.modifiers.get(modifier) if active is not None else None
        if active is None or applied is None:
            raise RuntimeError("Error: Modifier not found")
        active.data.pieces = modifiers.applied(self.blend, active, applied, list(active.data.settled()))
        active.modifiers.remove(applied)

    def object_modifier_remove(self, modifier: str = "", report: bool = False) -> None:
        """Remove a modifier of the active object."""
        if self.blend.active is not None:
            self.blend.active.modifiers.remove(self.blend.active.modifiers[modifier])

    def object_modifier_move_up(self, modifier: str = "") -> None:
        """Move a modifier up."""
        assert self.blend.active is not None, "an operator that Blender polls"
        items = self.blend.active.modifiers.items_
        place = self.blend.active.modifiers.find(modifier)
        if place > 0:
            items[place - 1], items[place] = items[place], items[place - 1]

    def object_convert(self, target: str = "MESH", **_: Any) -> None:
        """Convert the selected objects to meshes, with their modifiers applied."""
        for each in self._selected():
            if target != "MESH" or not isinstance(each.data, MeshBlock):
                raise UnsupportedPython("only meshes can be converted to meshes")
            each.data.pieces = modifiers.evaluated(self.blend, each)
            each.modifiers.clear()

    def object_material_slot_add(self) -> None:
        """Add a slot for a material."""
        if self.blend.active is not None and isinstance(self.blend.active.data, MeshBlock):
            self.blend.active.data.materials.append(None)
            self.blend.active.active_material_index = len(self.blend.active.data.materials) - 1

    def object_make_links_data(self, type: str = "OBDATA") -> None:
        """Give the selected objects the data or the materials of the active one."""
        source = self.blend.active
        for each in self._selected():
            if source is None or each is source or each.type != "MESH":
                continue
            if type == "MATERIAL":
                each.data.materials.items_ = list(source.data.materials.items_)
            elif type == "OBDATA":
                each.data = source.data
            elif type == "MODIFIERS":
                each.modifiers.items_ = list(source.copy().modifiers.items_)

    # --- files

    def wm_read_factory_settings(self, use_empty: bool = False, **_: Any) -> None:
        """Load the startup file, or an empty one."""
        for each in self.blend.objects.listed():
            self.blend.objects.remove(each)
        for blocks in (self.blend.meshes, self.blend.materials, self.blend.collections):
            blocks.by_name.clear()
        self.blend.scene.collection.children.clear()
        self.blend.collection = self.blend.scene.collection
        if not use_empty:
            self.blend.collection = self.blend.collections.new("Collection")
            self.blend.scene.collection.children.link(self.blend.collection)
            self.blend._add_startup_objects()

    def wm_read_homefile(self, use_empty: bool = False, **_: Any) -> None:
        """Load the startup file, or an empty one."""
        self.wm_read_factory_settings(use_empty)

    # --- edit mode

    def _edited(self) -> MeshBlock:
        active = self.blend.active
        if self.blend.mode != "EDIT" or active is None:
            raise RuntimeError("Operator bpy.ops.mesh poll() failed, context is incorrect")
        mesh: MeshBlock = active.data
        return mesh

    def _edit_matrix(self, world: FloatArray) -> None:
        mesh = self._edited()
        if getattr(mesh, "is_deselected", False):
            return
        assert self.blend.active is not None, "edit mode has an active object"
        frame = self.blend.active.computed_world()
        matrix = np.linalg.inv(frame) @ world @ frame
        mesh.pieces = [piece.moved(matrix) for piece in mesh.settled()]

    def mesh_select_all(self, action: str = "TOGGLE") -> None:
        """Select all or nothing in edit mode."""
        mesh = self._edited()
        mesh.is_deselected = action == "DESELECT"  # type: ignore[attr-defined]

    def _all_selected(self, name: str) -> MeshBlock:
        mesh = self._edited()
        if getattr(mesh, "is_deselected", False):
            raise UnsupportedPython(f"`bpy.ops.mesh.{name}` of a part of a mesh is not supported", "use `bmesh`")
        return mesh

    def mesh_normals_make_consistent(self, inside: bool = False) -> None:
        """Turn all faces outwards."""
        mesh = self._all_selected("normals_make_consistent")
        if all(piece.form is not None for piece in mesh.settled()):
            return
        made = polygons_of(mesh.settled()).oriented()
        mesh.become(made.flipped() if inside else made)

    def mesh_remove_doubles(self, threshold: float = 1e-4, **_: Any) -> None:
        """Merge corners."""
        mesh = self._all_selected("remove_doubles")
        made = polygons_of(mesh.settled())
        welded = made.welded(threshold)
        if len(welded.points) < len(made.points):
            mesh.become(welded)

    def mesh_flip_normals(self, **_: Any) -> None:
        """Turn all faces around."""
        self._all_selected("flip_normals").flip_normals()

    def mesh_subdivide(self, number_cuts: int = 1, smoothness: float = 0.0, fractal: float = 0.0, **_: Any) -> None:
        """Cut all faces."""
        mesh = self._all_selected("subdivide")
        if smoothness or fractal:
            raise UnsupportedPython("a `subdivide` that is smooth or random is not supported")
        mesh.become(polygons.split_faces(polygons_of(mesh.settled()), number_cuts))

    def mesh_delete(self, type: str = "VERT") -> None:
        """Delete everything."""
        mesh = self._all_selected("delete")
        mesh.become(polygons.EMPTY)


def _sides(count: Any) -> int:
    if not isinstance(count, int):
        raise TypeError(f"expected an int type, not {type(count).__name__}")
    if count > _MAX_SIDES:
        raise UnsupportedPython(f"this primitive has more than {_MAX_SIDES:,} sides")
    return max(1, count)


def _place(materials: list[Any], material: Any) -> int:
    for i, each in enumerate(materials):
        if each is material:
            return i
    materials.append(material)
    return len(materials) - 1


def _with_slots(piece: MeshPiece, places: Sequence[int]) -> MeshPiece:
    at: Callable[[int], int] = lambda slot: places[min(slot, len(places) - 1)]
    mesh = piece.mesh
    if mesh is not None:
        mesh = polygons.Polygons(mesh.points, mesh.faces, tuple(at(slot) for slot in mesh.slots()))
    return replace(piece, slot=at(piece.slot), mesh=mesh)


def _meets_below(piece: MeshPiece, angle: float) -> bool:
    """Return whether the sides of a form meet below an angle, so that they are shaded as one surface."""
    if piece.form is None or piece.form.kind == "cube":
        return piece.is_smooth
    return 2 * math.pi / max(piece.form.counts[0], 1) < angle + 1e-6


def _center_of_volume(mesh: polygons.Polygons) -> FloatArray:
    a, b, c = np.moveaxis(mesh.points[mesh.triangles()], 1, 0)
    volumes = np.einsum("ij,ij->i", a, np.cross(b, c))
    center: FloatArray = (volumes[:, None] * (a + b + c)).sum(axis=0) / (4 * volumes.sum())
    return center


_MODIFIER_NAMES = {"SUBSURF": "Subdivision", "EDGE_SPLIT": "EdgeSplit", "WEIGHTED_NORMAL": "WeightedNormal"}


def _hint(group: str, name: str) -> str | None:
    if group == "sculpt" or name == "sculpt":
        return "sculpting has no counterpart in a scene: build the shape from meshes"
    if group in ("curve", "font", "mball") or name in ("text_add", "metaball_add"):
        return "build it from meshes"
    if name in _FILE_READERS or group.startswith("import"):
        return 'a mesh file is a primitive of a scene: `(call "mesh" :file "chair.glb")`'
    if group in ("ptcache", "rigidbody", "cloth", "fluid", "particle"):
        return "simulations are not part of a scene"
    return None

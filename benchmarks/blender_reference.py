"""Measure Blender scripts in Blender: `PYTHON benchmarks/blender_reference.py OUT.json SCRIPT.py ...`, with bpy 5.

Every script runs three times (once with `--once`), in a process of its own: as it is, with its round primitives of 16
or more sides at 256, and with all of them. For each mesh that a picture shows: name, box and volume (area, if it is
open) in the world, and the linear base color, at the first, the middle and the last frame of an animation.
"""

from __future__ import annotations

import ast
import json
import os
import signal
import sys
import traceback
from itertools import pairwise
from pathlib import Path
from typing import Any

TIMEOUT = 150
SIDES = 256
_COUNTS = {
    "primitive_uv_sphere_add": (("segments", 32, 256), ("ring_count", 16, 128)),
    "primitive_cylinder_add": (("vertices", 32, 256),),
    "primitive_cone_add": (("vertices", 32, 256),),
    "primitive_circle_add": (("vertices", 32, 256),),
    "primitive_torus_add": (("major_segments", 48, 256), ("minor_segments", 12, 128)),
    "create_uvsphere": (("u_segments", 32, 256), ("v_segments", 16, 128)),
    "create_cone": (("segments", 32, 256),),
    "create_circle": (("segments", 32, 256),),
}


class _Rounder(ast.NodeTransformer):
    def visit_Call(self, node: ast.Call) -> ast.AST:
        self.generic_visit(node)
        if isinstance(node.func, ast.Attribute) and (node.func.attr in _COUNTS or "ico" in node.func.attr):
            return ast.Call(
                ast.Name("_round_", ast.Load()), [ast.Constant(node.func.attr), node.func, *node.args], node.keywords
            )
        return node


def _rounder(least: int, divisor: int) -> Any:
    def call(name: str, function: Any, *arguments: Any, **named: Any) -> Any:
        if "ico" in name and named.get("subdivisions", 2) >= (3 if least > 3 else 1):
            named["subdivisions"] = 6
        first = True
        for key, default, many in _COUNTS.get(name, ()):
            count = named.get(key, default)
            is_across = key == "minor_segments"
            if first or is_across:
                wanted = count >= least
            first = False
            if wanted:
                named[key] = max(many // divisor, count)
        return function(*arguments, **named)

    return call


def measured() -> dict[str, Any]:
    """Return the measures of the meshes of the scene."""
    import bpy

    scene = bpy.context.scene
    for collection in bpy.data.collections:
        collection.hide_viewport = False
    for obj in bpy.data.objects:
        if not obj.hide_render:
            obj.hide_viewport = False
    frames = []
    for obj in scene.objects:
        action = obj.animation_data.action if obj.animation_data else None
        if action is not None:
            frames += list(action.frame_range)
    found = {}
    moments = sorted({min(frames), (min(frames) + max(frames)) / 2, max(frames)}) if frames else [None]
    for moment in moments:
        if moment is not None:
            scene.frame_set(int(moment), subframe=moment - int(moment))
        bpy.context.view_layer.update()
        found[str(moment)] = [row for obj in _shown(scene.collection) for row in [_measure(obj)] if row is not None]
    return found


def _shown(collection: Any) -> list[Any]:
    if collection.hide_render:
        return []
    objects = [obj for obj in collection.objects if obj.type == "MESH" and not obj.hide_render]
    for child in collection.children:
        objects += [obj for obj in _shown(child) if obj not in objects]
    return objects


def _measure(obj: Any) -> dict[str, Any] | None:
    import bpy
    import numpy as np

    depsgraph = bpy.context.evaluated_depsgraph_get()
    evaluated = obj.evaluated_get(depsgraph)
    mesh = evaluated.to_mesh()
    if not len(mesh.polygons):
        return None
    count = len(mesh.vertices)
    points = np.empty(count * 3)
    mesh.vertices.foreach_get("co", points)
    world = np.array(evaluated.matrix_world)
    used = np.zeros(count, bool)
    loops = np.empty(len(mesh.loops), int)
    mesh.loops.foreach_get("vertex_index", loops)
    used[loops] = True
    points = points.reshape(-1, 3) @ world[:3, :3].T + world[:3, 3]
    mesh.calc_loop_triangles()
    triangles = np.empty(len(mesh.loop_triangles) * 3, int)
    mesh.loop_triangles.foreach_get("vertices", triangles)
    face_of = np.empty(len(mesh.loop_triangles), int)
    mesh.loop_triangles.foreach_get("polygon_index", face_of)
    a, b, c = np.moveaxis(points[triangles.reshape(-1, 3)], 1, 0)
    area = float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)
    edge_of = np.empty(len(mesh.loops), int)
    mesh.loops.foreach_get("edge_index", edge_of)
    counts = np.bincount(edge_of, minlength=len(mesh.edges))
    # faces that an extrusion leaves inside a body do not count
    ends = np.cumsum([0, *(polygon.loop_total for polygon in mesh.polygons)])
    inner = np.array([(counts[edge_of[i:j]] > 2).all() for i, j in pairwise(ends)])
    counts = np.bincount(edge_of[~np.repeat(inner, np.diff(ends))], minlength=len(mesh.edges))
    is_closed = bool((counts[counts > 0] % 2 == 0).all()) and not inner.all()
    center = points[used].mean(axis=0)
    a, b, c = (each[~inner[face_of]] - center for each in (a, b, c))
    volume = float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)
    row = {
        "name": obj.name,
        "low": points[used].min(axis=0).tolist(),
        "high": points[used].max(axis=0).tolist(),
        "volume": abs(volume) if is_closed else None,
        "area": area,
        "color": _color(obj),
    }
    evaluated.to_mesh_clear()
    return row


def _color(obj: Any) -> list[float] | None:
    """Return the linear base color; None if a texture decides, or several materials."""
    slots = [slot.material for slot in obj.material_slots]
    used = {polygon.material_index for polygon in obj.data.polygons}
    chosen = {slots[min(i, len(slots) - 1)] if slots else None for i in used}
    if len(chosen) != 1:
        return None
    material = next(iter(chosen))
    if material is None:
        return [0.8, 0.8, 0.8]
    node = None
    for output in material.node_tree.nodes if material.node_tree else ():
        if output.type == "OUTPUT_MATERIAL" and output.inputs["Surface"].links:
            node = output.inputs["Surface"].links[0].from_node
    socket = node.inputs.get("Base Color") or node.inputs.get("Color") if node is not None else None
    if socket is None or socket.links:
        return None
    color = list(socket.default_value)[:3]
    diffuse = list(material.diffuse_color)[:3]
    is_default = node.type == "BSDF_PRINCIPLED" and all(abs(c - 0.8) < 1e-5 for c in color)
    return diffuse if is_default else color


def _run(path: str, least: int | None, divisor: int) -> dict[str, Any]:
    tree = ast.parse(Path(path).read_text("utf-8"))
    names: dict[str, Any] = {"__name__": "__main__", "__file__": path}
    if least is not None:
        tree = ast.fix_missing_locations(_Rounder().visit(tree))
        names["_round_"] = _rounder(least, divisor)
    sys.argv = [path]
    try:
        exec(compile(tree, path, "exec"), names)  # noqa: S102 - a file that the caller chose, in a child process
        return {"frames": measured()}
    except BaseException:
        return {"error": traceback.format_exc(limit=-2)[-300:]}


def _in_child(path: str, least: int | None, divisor: int = 1) -> dict[str, Any]:
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reading)
        signal.alarm(TIMEOUT)
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, 1)
        os.dup2(null, 2)
        data = json.dumps(_run(path, least, divisor)).encode()
        with os.fdopen(writing, "wb") as file:
            file.write(data)
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading, "rb") as file:
        data = file.read()
    os.waitpid(child, 0)
    return json.loads(data) if data else {"error": "timeout or crash"}


def main() -> None:
    import bpy  # noqa: F401 - once, before the children

    out = Path(sys.argv[1])
    found = json.loads(out.read_text()) if out.exists() else {}
    variants = (("as is", None), ("round", 16), ("all round", 3))
    scripts = [path for path in sys.argv[2:] if path != "--once"]
    for path in scripts:
        if Path(path).name not in found:
            chosen = variants[: 1 if "--once" in sys.argv else 3]
            found[Path(path).name] = {name: _in_child(path, least) for name, least in chosen}
            if "error" in found[Path(path).name].get("round", {}):  # half as many sides, compared with more tolerance
                found[Path(path).name]["coarse"] = _in_child(path, 16, 2)
            out.write_text(json.dumps(found))


if __name__ == "__main__":
    main()

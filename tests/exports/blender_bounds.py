"""Run by a Python that has Blender's module `bpy`: bounds, mesh count, volumes and colors of imported files, as JSON.

python blender_bounds.py FRAME FILE...: FRAME counts from 0. Bounds are in scene axes: Blender's z is up.
"""

from __future__ import annotations

import json
import sys

import bpy
import numpy as np


def bounds(file: str, frame: int) -> dict[str, object]:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.fps = 24
    if file.endswith(".glb"):
        bpy.ops.import_scene.gltf(filepath=file)
    else:
        bpy.ops.wm.usd_import(filepath=file, support_scene_instancing=True)
    start = bpy.context.scene.frame_start if file.endswith(".usdc") else 0
    bpy.context.scene.frame_set(start + frame if not file.endswith(".glb") else frame)
    graph = bpy.context.evaluated_depsgraph_get()
    points, meshes, colors, solids = [], 0, [], []
    for instance in graph.object_instances:
        if instance.object.type != "MESH" or not instance.show_self:
            continue
        meshes += 1
        colors.append(_color(instance.object))
        matrix = instance.matrix_world
        solids.append({"volume": _volume(instance.object, np.array(matrix)), "colors": _colors(instance.object)})
        points += [matrix @ vertex.co for vertex in instance.object.data.vertices]
    low = [min(point[axis] for point in points) for axis in range(3)]
    high = [max(point[axis] for point in points) for axis in range(3)]
    names = sorted({object_.name for object_ in bpy.data.objects})
    # Blender turned y up into z up: its (x, y, z) is the scene's (x, -z, y)
    box = [low[0], low[2], -high[1], high[0], high[2], -low[1]]
    return {"box": box, "meshes": meshes, "names": names[:2000], "colors": colors, "solids": solids}


def _volume(thing: bpy.types.Object, matrix: np.ndarray) -> float:
    """What the triangles of an object enclose in the world."""
    mesh = thing.data
    mesh.calc_loop_triangles()
    vertices = np.array([vertex.co for vertex in mesh.vertices]) @ matrix[:3, :3].T
    corners = vertices[np.array([triangle.vertices for triangle in mesh.loop_triangles])]
    a, b, c = (corners[:, k] - corners[0, 0] for k in range(3))
    return abs(float(np.einsum("ni,ni->n", a, np.cross(b, c)).sum())) / 6.0


def _colors(thing: bpy.types.Object) -> list[list[float]] | None:
    """The distinct base colors of an object, those of its vertices where its material reads them."""
    material = next((slot.material for slot in thing.material_slots if slot.material is not None), None)
    if material is None:
        return None
    shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    if not shader.inputs["Base Color"].is_linked:
        return [list(shader.inputs["Base Color"].default_value)[:3]]
    found = [list(each.color)[:3] for each in thing.data.color_attributes[0].data]
    return np.unique(np.round(found, 3), axis=0).tolist()


def _color(thing: bpy.types.Object) -> list[float] | None:
    """The base color of an object's material; None where it has none."""
    material = next((slot.material for slot in thing.material_slots if slot.material is not None), None)
    if material is None or material.node_tree is None:
        return None
    shader = next((node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED"), None)
    return None if shader is None else list(shader.inputs["Base Color"].default_value)[:3]


if __name__ == "__main__":
    number, *files = sys.argv[1:]
    print("RESULT " + json.dumps([bounds(file, int(number)) for file in files]))

"""Run by a Python that has Blender's module `bpy`: draw the base colors of a file, and what each pixel shows.

python blender_textures.py FILE IMAGE POINTS: a view without light or perspective of the objects of `textured_scene`, drawn
by Cycles; and an .npz file with the pixels (row, column) that show a surface, its points and normals in scene axes.
"""

from __future__ import annotations

import math
import sys

import bpy
import numpy as np
from mathutils import Matrix, Vector

WIDTH, HEIGHT, SCALE = 1000, 720, 25.0  # pixels, and units along the width


def unlit(material: bpy.types.Material) -> None:
    """Make a material shine with its base color."""
    nodes, links = material.node_tree.nodes, material.node_tree.links
    shader = next(node for node in nodes if node.type == "BSDF_PRINCIPLED")
    output = next(node for node in nodes if node.type == "OUTPUT_MATERIAL")
    light = nodes.new("ShaderNodeEmission")
    links.new(shader.inputs["Base Color"].links[0].from_socket, light.inputs["Color"])
    links.new(light.outputs["Emission"], output.inputs["Surface"])


def draw(file: str, image: str) -> bpy.types.Object:
    """Draw a file; return the camera."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    if file.endswith(".glb"):
        bpy.ops.import_scene.gltf(filepath=file)
    else:
        bpy.ops.wm.usd_import(filepath=file)
    for material in bpy.data.materials:
        if material.users:
            unlit(material)
    scene = bpy.context.scene
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(camera)
    camera.data.type, camera.data.ortho_scale = "ORTHO", SCALE
    turn = Matrix.Rotation(math.radians(35), 4, "Z") @ Matrix.Rotation(math.radians(60), 4, "X")
    camera.matrix_world = Matrix.Translation(Vector((11, 0, 4.6)) + turn @ Vector((0, 0, 50))) @ turn
    scene.camera = camera
    render = scene.render
    render.engine, render.filepath, render.resolution_x, render.resolution_y = "CYCLES", image, WIDTH, HEIGHT
    render.dither_intensity, render.film_transparent = 0.0, True
    scene.cycles.samples, scene.cycles.use_adaptive_sampling, scene.cycles.use_denoising = 1, False, False
    scene.cycles.filter_width, scene.cycles.max_bounces = 0.01, 0
    scene.view_settings.view_transform = "Standard"
    bpy.ops.render.render(write_still=True)
    return camera


def points(camera: bpy.types.Object) -> dict[str, np.ndarray]:
    """What a ray through the middle of each pixel meets."""
    graph, scene = bpy.context.evaluated_depsgraph_get(), bpy.context.scene
    world, step = camera.matrix_world, SCALE / WIDTH
    direction = world.to_3x3() @ Vector((0, 0, -1))
    rows = []
    for row in range(HEIGHT):
        for column in range(WIDTH):
            across, up = (column + 0.5 - WIDTH / 2) * step, (HEIGHT / 2 - row - 0.5) * step
            hit, place, normal, *_ = scene.ray_cast(graph, world @ Vector((across, up, 0)), direction)
            if hit:
                rows.append((row, column, *place, *normal))
    table = np.array(rows)
    upright = [0, 2, 1]  # Blender's (x, y, z) is the scene's (x, -z, y)
    place, normal = (table[:, start : start + 3][:, upright] * [1, 1, -1] for start in (2, 5))
    return {"pixels": table[:, :2].astype(int), "points": place, "normals": normal}


if __name__ == "__main__":
    np.savez(sys.argv[3], **points(draw(sys.argv[1], sys.argv[2])))
    print("RESULT true")

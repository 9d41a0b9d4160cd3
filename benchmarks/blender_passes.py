"""Renders a GLB file in Blender's own module with the passes that BlenderProc writes; run with a Python that has bpy.

    python blender_passes.py SCENE.glb VIEWS SIZE

Colour by Cycles with 16 samples on one thread, depth, normals and the index of each object, in one file. Prints the
seconds of one picture. bpy is under the GPL: nothing of scenelang imports this file.
"""

from __future__ import annotations

import math
import sys
import tempfile
import time

import bpy


def prepare(path: str, size: int) -> None:
    """Load the scene, number its objects, and ask for the passes."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=path)
    for number, item in enumerate(bpy.context.scene.objects, start=1):
        item.pass_index = number
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.device, scene.cycles.samples, scene.cycles.use_denoising = "CPU", 16, False
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.use_persistent_data = True
    layer = bpy.context.view_layer
    layer.use_pass_z = layer.use_pass_normal = layer.use_pass_object_index = True
    if hasattr(scene.render.image_settings, "media_type"):  # Blender 5
        scene.render.image_settings.media_type = "MULTI_LAYER_IMAGE"
    scene.render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
    light = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    light.data.energy, light.rotation_euler = 3.0, (0.6, 0.2, 0.4)
    scene.collection.objects.link(light)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(camera)
    scene.camera = camera


def main() -> None:
    path, views, size = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    prepare(path, size)
    scene = bpy.context.scene
    times = []
    with tempfile.TemporaryDirectory() as folder:
        for view in range(views + 1):
            angle = 2.0 * math.pi * view / (views + 1)
            scene.camera.location = (2.2 * math.sin(angle), -2.2 * math.cos(angle), 1.4)
            scene.camera.rotation_euler = (math.radians(58), 0.0, angle)
            scene.render.filepath = f"{folder}/{view:03d}.exr"
            started = time.perf_counter()
            bpy.ops.render.render(write_still=True)
            times.append(time.perf_counter() - started)
    print(f"{sum(times[1:]) / views:.4f}")  # without the first, which compiles


if __name__ == "__main__":
    main()

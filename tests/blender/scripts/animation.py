"""Keyframes of parents and children, with curves of several kinds."""

import math

import bpy

bpy.ops.object.select_all(action="SELECT")
bpy.ops.object.delete()
bpy.ops.object.empty_add(location=(1, 0, 0))
pivot = bpy.context.object
pivot.name = "Pivot"
for frame, angle in ((1, 0), (21, math.pi / 2), (31, math.pi * 0.7), (61, math.pi)):
    pivot.rotation_euler = (0, 0, angle)
    pivot.keyframe_insert(data_path="rotation_euler", frame=frame)
bpy.ops.mesh.primitive_cube_add(size=0.5, location=(2, 0, 0))
moon = bpy.context.object
moon.name = "Moon"
moon.parent = pivot
moon.scale = (1, 1, 1)
moon.keyframe_insert("scale", frame=1)
moon.scale = (2, 0.5, 1)
moon.keyframe_insert("scale", frame=41)
bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 5, 0), rotation=(0.2, 0.3, 0))
still = bpy.context.object
still.name = "Still"
bpy.ops.mesh.primitive_cube_add(size=0.3, location=(0, 0, 0))
linear = bpy.context.object
linear.name = "Linear"
bpy.context.preferences.edit.keyframe_new_interpolation_type = "LINEAR"
for frame in (1, 11, 61):
    linear.location = (frame / 10, 0, 3 if frame == 11 else 1)
    linear.keyframe_insert(data_path="location", frame=frame)
bpy.context.scene.frame_end = 61

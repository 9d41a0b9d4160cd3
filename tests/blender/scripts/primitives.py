"""Every primitive with its options, rotated, scaled and with applied transforms."""

import math

import bpy

bpy.ops.object.select_all(action="SELECT")
bpy.ops.object.delete(use_global=False)
bpy.ops.mesh.primitive_cube_add(size=1.5, location=(1, 2, 3), rotation=(0.3, 0.4, 0.5), scale=(1, 2, 0.5))
bpy.ops.mesh.primitive_uv_sphere_add(radius=0.7, location=(-3, 0, 1))
bpy.context.object.scale = (1, 1, 0.5)
bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, radius=0.8, location=(0, 4, 0))
bpy.ops.mesh.primitive_cylinder_add(vertices=6, radius=0.5, depth=2, location=(4, 0, 0), rotation=(math.pi / 2, 0, 0.2))
bpy.ops.mesh.primitive_cylinder_add(radius=0.4, depth=1.2, location=(6, 0, 0.6))
bpy.ops.mesh.primitive_cone_add(radius1=1, radius2=0.4, depth=1.5, location=(0, -4, 0))
bpy.ops.mesh.primitive_cone_add(vertices=4, radius1=1, depth=1, location=(3, -4, 0))
bpy.ops.mesh.primitive_torus_add(major_radius=1, minor_radius=0.3, location=(-4, -4, 0), rotation=(0.7, 0, 0))
bpy.ops.mesh.primitive_uv_sphere_add(segments=8, ring_count=6, radius=0.5, location=(-6, 0, 0))
bpy.ops.mesh.primitive_plane_add(size=20, location=(0, 0, -1))
bpy.ops.mesh.primitive_circle_add(vertices=32, radius=2, fill_type="NGON", location=(0, 0, 5))
bpy.ops.mesh.primitive_cube_add(size=2)
box = bpy.context.active_object
box.name = "Block"
box.dimensions = (3, 1, 0.4)
box.location = (-5, 5, 0)
box.rotation_euler = (0, 0, math.radians(30))
bpy.ops.object.transform_apply(location=True, rotation=True, scale=True)
bpy.ops.mesh.primitive_cube_add(size=1)
turned = bpy.context.object
turned.name = "Turned"
turned.rotation_mode = "QUATERNION"
turned.rotation_quaternion = (0.8, 0.2, 0.4, 0.4)
turned.location.x += 9
turned.location[2] = 1

"""Modifiers of boxes, cylinders, planes and meshes."""

import math

import bpy

bpy.ops.object.select_all(action="SELECT")
bpy.ops.object.delete()


def cube(name, x, size=1.0):
    bpy.ops.mesh.primitive_cube_add(size=size, location=(x, 0, 0))
    bpy.context.object.name = name
    return bpy.context.object


one = cube("Chamfered", 0)
one.modifiers.new("Bevel", "BEVEL").width = 0.1
two = cube("Rounded", 2)
two.scale = (1, 2, 0.5)
bpy.ops.object.transform_apply(scale=True)
bevel = two.modifiers.new("Bevel", "BEVEL")
bevel.width, bevel.segments = 0.08, 4
three = cube("Row", 4, 0.4)
array = three.modifiers.new("Array", "ARRAY")
array.count = 4
array.relative_offset_displace = (0, 1.5, 0)
four = cube("Steps", 6, 0.4)
array = four.modifiers.new("Array", "ARRAY")
array.use_relative_offset, array.use_constant_offset, array.count = False, True, 3
array.constant_offset_displace = (0.1, 0.5, 0.4)
five = cube("Mirrored", 8, 0.5)
for vertex in five.data.vertices:
    vertex.co.x += 0.6
mirror = five.modifiers.new("Mirror", "MIRROR")
mirror.use_axis[1] = True
six = cube("Smooth", 11)
six.modifiers.new("Subdivision", "SUBSURF").levels = 2
bpy.ops.mesh.primitive_plane_add(size=2, location=(14, 0, 0))
sheet = bpy.context.object
sheet.name = "Sheet"
solid = sheet.modifiers.new("Solidify", "SOLIDIFY")
solid.thickness, solid.offset = 0.2, 0
bpy.ops.mesh.primitive_cylinder_add(vertices=24, radius=0.5, depth=1, location=(17, 0, 0))
can = bpy.context.object
can.name = "Can"
bevel = can.modifiers.new("Bevel", "BEVEL")
bevel.width, bevel.segments, bevel.limit_method = 0.06, 2, "ANGLE"
bevel.angle_limit = math.radians(40)
bpy.ops.mesh.primitive_cube_add(size=1, location=(20, 0, 0))
drilled = bpy.context.object
drilled.name = "Drilled"
bpy.ops.mesh.primitive_cylinder_add(vertices=64, radius=0.3, depth=3, location=(20, 0, 0))
drill = bpy.context.object
cut = drilled.modifiers.new("Cut", "BOOLEAN")
cut.object, cut.operation = drill, "DIFFERENCE"
bpy.context.view_layer.objects.active = drilled
bpy.ops.object.modifier_apply(modifier="Cut")
bpy.data.objects.remove(drill, do_unlink=True)

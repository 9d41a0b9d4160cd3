"""A wooden chair with a cushion, and a row of three."""

import math

import bpy


def material(name, color, roughness):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    shader = made.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*color, 1)
    shader.inputs["Roughness"].default_value = roughness
    return made


def box(name, location, size, look):
    bpy.ops.mesh.primitive_cube_add(size=1, location=location)
    made = bpy.context.object
    made.name = name
    made.scale = size
    made.data.materials.append(look)
    return made


def make_chair(location, wood, cloth):
    x, y, z = location
    for dx in (-0.2, 0.2):
        for dy in (-0.2, 0.2):
            bpy.ops.mesh.primitive_cylinder_add(radius=0.025, depth=0.45, location=(x + dx, y + dy, z + 0.225))
            bpy.context.object.name = "Leg"
            bpy.context.object.data.materials.append(wood)
    seat = box("Seat", (x, y, z + 0.47), (0.48, 0.48, 0.04), wood)
    bevel = seat.modifiers.new("Bevel", "BEVEL")
    bevel.width, bevel.segments = 0.01, 3
    box("Cushion", (x, y, z + 0.515), (0.42, 0.42, 0.05), cloth)
    back = box("Back", (x, y + 0.22, z + 0.75), (0.46, 0.03, 0.5), wood)
    back.rotation_euler.x = math.radians(-8)


bpy.ops.object.select_all(action="SELECT")
bpy.ops.object.delete()
oak = material("Oak", (0.42, 0.25, 0.11), 0.6)
linen = material("Linen", (0.7, 0.62, 0.5), 0.9)
for i in range(3):
    make_chair((i * 0.8, 0, 0), oak, linen)

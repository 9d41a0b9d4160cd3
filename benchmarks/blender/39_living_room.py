# Prompt: cozy living room with sofa, coffee table, TV, floor lamp, rug, plant, and pictures on the wall
import bpy
from math import radians
import random

random.seed(99)

# ------------------------------------------------------------------ utils
def clear_scene():
    """Remove all objects, and orphan data."""
    bpy.ops.object.select_all(action='SELECT')
    bpy.ops.object.delete()
    for m in list(bpy.data.materials):
        bpy.data.materials.remove(m)

def mat(name, color, roughness=0.5, metallic=0.0, emission=None, strength=1.0):
    m = bpy.data.materials.new(name)
    m.use_nodes = True
    p = m.node_tree.nodes.get("Principled BSDF")
    p.inputs["Base Color"].default_value = (*color, 1)
    p.inputs["Roughness"].default_value = roughness
    p.inputs["Metallic"].default_value = metallic
    if emission:
        try:
            p.inputs["Emission"].default_value = (*emission, 1)
        except KeyError:
            p.inputs["Emission Color"].default_value = (*emission, 1)
        p.inputs["Emission Strength"].default_value = strength
    return m

def cube(name, x, y, z, sx, sy, sz, material, bevel=0.0):
    bpy.ops.mesh.primitive_cube_add(size=1, location=(x, y, z))
    o = bpy.context.active_object
    o.name = name
    o.scale = (sx, sy, sz)
    bpy.ops.object.transform_apply(scale=True)
    o.data.materials.append(material)
    if bevel > 0:
        b = o.modifiers.new("Bevel", 'BEVEL')
        b.width = bevel
        b.segments = 3
    return o

def cyl(name, x, y, z, r, h, material, verts=32):
    bpy.ops.mesh.primitive_cylinder_add(vertices=verts, radius=r, depth=h, location=(x, y, z))
    o = bpy.context.active_object
    o.name = name
    o.data.materials.append(material)
    return o

# ------------------------------------------------------------------ room
def make_room():
    cube("Floor", 0, 0, -0.05, 6, 5, 0.1, mat("FloorWood", (0.4, 0.25, 0.13)))
    wall = mat("Wall", (0.85, 0.82, 0.76), 0.9)
    cube("WallBack", 0, 2.55, 1.4, 6, 0.1, 2.8, wall)
    cube("WallLeft", -3.05, 0, 1.4, 0.1, 5, 2.8, wall)
    cube("Rug", 0, 0.2, 0.01, 3, 2, 0.02, mat("Rug", (0.55, 0.15, 0.15), 1.0))

def make_sofa(x, y):
    fabric = mat("SofaFabric", (0.15, 0.25, 0.35), 0.95)
    cube("SofaBase", x, y, 0.25, 2.2, 0.9, 0.3, fabric, 0.05)
    cube("SofaBack", x, y + 0.4, 0.65, 2.2, 0.2, 0.6, fabric, 0.08)
    for s in (-1, 1):
        cube("SofaArm", x + s * 1.1, y, 0.42, 0.2, 0.9, 0.6, fabric, 0.06)
        cube("SofaCushion", x + s * 0.5, y - 0.05, 0.47, 0.95, 0.75, 0.15, fabric, 0.05)

def make_coffee_table(x, y):
    wood = mat("Walnut", (0.25, 0.12, 0.06))
    cube("CoffeeTop", x, y, 0.4, 1.1, 0.6, 0.04, wood, 0.01)
    [cyl("CoffeeLeg", x + a * 0.48, y + b * 0.24, 0.19, 0.025, 0.38, wood) for a in (-1, 1) for b in (-1, 1)]

def make_lamp(x, y):
    metal = mat("LampMetal", (0.1, 0.1, 0.1), 0.3, 1.0)
    cyl("LampBase", x, y, 0.02, 0.2, 0.04, metal)
    cyl("LampPole", x, y, 0.8, 0.02, 1.6, metal)
    bpy.ops.mesh.primitive_cone_add(radius1=0.28, radius2=0.18, depth=0.35, location=(x, y, 1.7))
    bpy.context.object.data.materials.append(mat("LampShade", (1, 0.9, 0.7), emission=(1, 0.8, 0.5), strength=4))

def make_plant(x, y):
    cyl("Pot", x, y, 0.2, 0.2, 0.4, mat("Terracotta", (0.7, 0.3, 0.15)))
    leaf = mat("Leaf", (0.05, 0.35, 0.08))
    for i in range(14):
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, radius=0.22, location=(
            x + random.uniform(-.2, .2), y + random.uniform(-.2, .2), random.uniform(.6, 1.3)))
        o = bpy.context.object
        o.scale = (0.35, 1, 0.15)
        o.rotation_euler = [random.uniform(-1, 1) for _ in range(3)]
        o.data.materials.append(leaf)

clear_scene()
make_room()
make_sofa(0, 1.8)
make_coffee_table(0, 0.5)
make_lamp(-2.4, 1.9)
make_plant(2.5, 2.0)
cube("TVStand", 0, -2.0, 0.25, 1.8, 0.4, 0.5, mat("Stand", (0.08, 0.08, 0.08)))
cube("TV", 0, -2.0, 0.95, 1.5, 0.05, 0.85, mat("Screen", (0.01, 0.01, 0.015), 0.1))
for i, x in enumerate((-1, 0, 1)):
    cube(f"Picture{i}", x, 2.48, 1.7, 0.6, 0.03, 0.8 - 0.15 * abs(x), mat(f"Art{i}", tuple(random.random() for _ in range(3))))

"""
A toy steam locomotive with spoked wheels, boiler, cab, chimney and two wagons.
Wheels are parented to the cars, and the cars are parented to the engine.
"""
import bpy
from math import pi, cos, sin
from mathutils import Vector, Euler


def wipe():
    while bpy.data.objects:
        bpy.data.objects.remove(bpy.data.objects[0], do_unlink=True)


MATS = {}


def M(name, rgb=(0.5, 0.5, 0.5), metallic=0.0):
    if name not in MATS:
        mat = bpy.data.materials.new(name)
        mat.use_nodes = True
        n = mat.node_tree.nodes["Principled BSDF"]
        n.inputs["Base Color"].default_value = rgb + (1.0,)
        n.inputs["Metallic"].default_value = metallic
        MATS[name] = mat
    return MATS[name]


def finish(name, mat, parent):
    ob = bpy.context.object
    ob.name = name
    ob.data.materials.append(mat)
    ob.parent = parent
    return ob


def box(name, loc, size, mat, parent):
    bpy.ops.mesh.primitive_cube_add(size=1, location=loc)
    bpy.context.object.scale = size
    return finish(name, mat, parent)


def cyl(name, loc, r, h, mat, parent, rot=(0, 0, 0)):
    bpy.ops.mesh.primitive_cylinder_add(radius=r, depth=h, location=loc, rotation=rot)
    return finish(name, mat, parent)


def wheel(loc, r, parent, spokes=6):
    hub = bpy.data.objects.new("Wheel", None)
    bpy.context.collection.objects.link(hub)
    hub.location = loc
    hub.rotation_euler = Euler((pi / 2, 0, 0))
    hub.parent = parent
    bpy.ops.mesh.primitive_torus_add(major_radius=r, minor_radius=r * 0.12, major_segments=32, minor_segments=8)
    finish("Rim", M("Iron", (0.05, 0.05, 0.05), 0.8), hub)
    cyl("Hub", (0, 0, 0), r * 0.2, 0.12, M("Red", (0.7, 0.05, 0.05)), hub)
    for k in range(spokes):
        a = 2 * pi * k / spokes
        b = box("Spoke", (cos(a) * r / 2, sin(a) * r / 2, 0), (r, r * 0.1, 0.05), M("Red"), hub)
        b.rotation_euler.z = a
    return hub


def engine():
    root = bpy.data.objects.new("Engine", None)
    bpy.context.collection.objects.link(root)
    green = M("Green", (0.03, 0.3, 0.1))
    black = M("Black", (0.02, 0.02, 0.02))
    box("Chassis", (0, 0, 0.6), (4.2, 1.1, 0.2), black, root)
    cyl("Boiler", (0.5, 0, 1.25), 0.55, 2.6, green, root, (0, pi / 2, 0))
    box("Cab", (-1.4, 0, 1.5), (1.2, 1.3, 1.6), green, root)
    box("CabRoof", (-1.4, 0, 2.35), (1.5, 1.5, 0.1), black, root)
    cyl("Chimney", (1.4, 0, 2.1), 0.16, 0.8, black, root)
    bpy.ops.mesh.primitive_cone_add(radius1=0.16, radius2=0.3, depth=0.3, location=(1.4, 0, 2.6))
    finish("ChimneyTop", black, root)
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.25, location=(0.4, 0, 1.8))
    finish("Dome", M("Brass", (0.8, 0.6, 0.2), 1.0), root)
    for s in (-1, 1):
        for x, r in ((-1.3, 0.5), (0, 0.5), (1.2, 0.35)):
            wheel((x, s * 0.6, r), r, root)
    return root


def wagon(index, engine_root, color):
    root = bpy.data.objects.new(f"Wagon_{index}", None)
    bpy.context.collection.objects.link(root)
    root.parent = engine_root
    root.location = Vector((-4.0 - (index - 1) * 3.4, 0, 0))
    mat = M(f"Wagon{index}", color)
    box("Floor", (0, 0, 0.6), (2.8, 1.1, 0.15), mat, root)
    for s in (-1, 1):
        box("SideWall", (0, s * 0.55, 1.0), (2.8, 0.08, 0.7), mat, root)
        box("EndWall", (s * 1.4, 0, 1.0), (0.08, 1.1, 0.7), mat, root)
        for x in (-0.9, 0.9):
            wheel((x, s * 0.6, 0.3), 0.3, root, spokes=4)
    return root


wipe()
loco = engine()
for i, c in enumerate([(0.6, 0.3, 0.1), (0.1, 0.2, 0.6)], 1):
    wagon(i, loco, c)

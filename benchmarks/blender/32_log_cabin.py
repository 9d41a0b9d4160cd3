"""Log cabin in the woods with stacked interlocking logs, gable roof, door, window, chimney."""
import bpy
import math
import random

random.seed(3)

LOG_R = 0.15
LENGTH_X = 5.0
LENGTH_Y = 4.0
ROWS = 9

def new_material(name, base_color, **kw):
    mat = bpy.data.materials.new(name)
    mat.use_nodes = True
    principled = mat.node_tree.nodes["Principled BSDF"]
    principled.inputs["Base Color"].default_value = base_color
    for socket, value in kw.items():
        if socket in principled.inputs:
            principled.inputs[socket].default_value = value
    return mat

def log(start_axis, center, length, mat, jitter=0.01):
    rot = (0, math.pi / 2, 0) if start_axis == "x" else (math.pi / 2, 0, 0)
    bpy.ops.mesh.primitive_cylinder_add(
        vertices=12,
        radius=LOG_R + random.uniform(-jitter, jitter),
        depth=length,
        location=center,
        rotation=rot,
    )
    ob = bpy.context.object
    ob.name = f"Log_{start_axis}"
    ob.data.materials.append(mat)
    return ob

def walls(mat):
    over = 0.5
    for row in range(ROWS):
        z = LOG_R + row * 2 * LOG_R * 0.95
        for s in (-1, 1):
            log("x", (0, s * LENGTH_Y / 2, z), LENGTH_X + over, mat)
            log("y", (s * LENGTH_X / 2, 0, z + LOG_R), LENGTH_Y + over, mat)
    return LOG_R + ROWS * 2 * LOG_R * 0.95

def gable_roof(base_z, mat, pitch=1.6, overhang=0.5):
    hx = LENGTH_X / 2 + overhang
    hy = LENGTH_Y / 2 + overhang
    verts = [(-hx, -hy, base_z), (hx, -hy, base_z), (hx, hy, base_z), (-hx, hy, base_z),
             (-hx, 0, base_z + pitch), (hx, 0, base_z + pitch)]
    faces = [(0, 1, 5, 4), (2, 3, 4, 5), (0, 4, 3), (1, 2, 5), (0, 3, 2, 1)]
    me = bpy.data.meshes.new("Roof")
    me.from_pydata(verts, [], faces)
    me.update()
    ob = bpy.data.objects.new("Roof", me)
    bpy.context.scene.collection.objects.link(ob)
    ob.data.materials.append(mat)
    return ob

def box(name, loc, size, mat):
    bpy.ops.mesh.primitive_cube_add(location=loc)      # 2 m default cube
    ob = bpy.context.object
    ob.name = name
    ob.scale = [s / 2 for s in size]
    ob.data.materials.append(mat)
    return ob

def main():
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.delete()
    timber = new_material("Timber", (0.3, 0.16, 0.07, 1), Roughness=0.85)
    shingle = new_material("Shingle", (0.12, 0.1, 0.09, 1), Roughness=0.95)
    glass = new_material("WindowGlass", (0.9, 0.75, 0.4, 1), Roughness=0.1)
    stone = new_material("ChimneyStone", (0.4, 0.4, 0.4, 1))
    top = walls(timber)
    gable_roof(top, shingle)
    front = -LENGTH_Y / 2 - LOG_R - 0.02
    box("Door", (-1.0, front, 1.0), (0.9, 0.08, 2.0), shingle)
    box("Window", (1.2, front, 1.4), (1.0, 0.06, 0.8), glass)
    box("WindowBarV", (1.2, front - 0.03, 1.4), (0.05, 0.06, 0.8), timber)
    box("WindowBarH", (1.2, front - 0.03, 1.4), (1.0, 0.06, 0.05), timber)
    box("Chimney", (1.7, 0.8, top + 1.0), (0.6, 0.6, 2.2), stone)

if __name__ == "__main__":
    main()

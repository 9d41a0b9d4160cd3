"""Rubik's cube, 3x3x3, bevelled cubies with coloured stickers, top layer turned 30 degrees"""
import bpy
import math
from itertools import product
from mathutils import Matrix, Vector

COLORS = {
    (1, 0, 0): ("Red", (0.8, 0.02, 0.02, 1)),
    (-1, 0, 0): ("Orange", (1.0, 0.3, 0.0, 1)),
    (0, 1, 0): ("Blue", (0.0, 0.1, 0.7, 1)),
    (0, -1, 0): ("Green", (0.0, 0.5, 0.1, 1)),
    (0, 0, 1): ("White", (0.95, 0.95, 0.95, 1)),
    (0, 0, -1): ("Yellow", (1.0, 0.85, 0.0, 1)),
}

bpy.ops.wm.read_factory_settings(use_empty=True)

def get_mat(name, rgba):
    m = bpy.data.materials.get(name) or bpy.data.materials.new(name)
    m.diffuse_color = rgba
    m.roughness = 0.3
    return m

plastic = get_mat("Plastic", (0.02, 0.02, 0.02, 1))
turn = Matrix.Rotation(math.radians(30), 4, 'Z')

for x, y, z in product((-1, 0, 1), repeat=3):
    if (x, y, z) == (0, 0, 0):
        continue
    created = []
    bpy.ops.mesh.primitive_cube_add(size=0.96, location=(x, y, z))
    cubie = bpy.context.object
    cubie.name = f"Cubie_{x}_{y}_{z}"
    cubie.data.materials.append(plastic)
    bv = cubie.modifiers.new("Bevel", 'BEVEL')
    bv.width, bv.segments = 0.06, 2
    created.append(cubie)

    for normal, (cname, rgba) in COLORS.items():
        n = Vector(normal)
        if n.dot(Vector((x, y, z))) < 0.5:
            continue
        bpy.ops.mesh.primitive_plane_add(size=0.8, location=Vector((x, y, z)) + n * 0.485,
                                         rotation=n.to_track_quat('Z', 'Y').to_euler())
        sticker = bpy.context.object
        sticker.name = f"Sticker_{cname}"
        sticker.data.materials.append(get_mat(cname, rgba))
        created.append(sticker)
    if z == 1:
        bpy.context.view_layer.update()
        for o in created:
            o.matrix_world = turn @ o.matrix_world

"""Chess board with pawns lined up on both sides."""
import bpy

bpy.ops.object.select_all(action='SELECT')
bpy.ops.object.delete()

def m(name, c):
    x = bpy.data.materials.new(name); x.diffuse_color = c
    return x

white, black = m("White", (.9, .85, .75, 1)), m("Black", (.08, .05, .04, 1))
border = m("Border", (.25, .12, .05, 1))

bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 0, -0.11))
b = bpy.context.object; b.scale = (9, 9, .2); b.name = "Border"; b.data.materials.append(border)

for r in range(8):
    for c in range(8):
        bpy.ops.mesh.primitive_plane_add(size=1, location=(c - 3.5, r - 3.5, 0))
        bpy.context.object.name = f"{'abcdefgh'[c]}{r + 1}"
        bpy.context.object.data.materials.append(white if (r + c) % 2 else black)

# build one pawn, then duplicate it
bpy.ops.mesh.primitive_cylinder_add(radius=.3, depth=.12, location=(0, 0, .06))
base = bpy.context.object
bpy.ops.mesh.primitive_cone_add(radius1=.24, radius2=.1, depth=.6, location=(0, 0, .4))
body = bpy.context.object
bpy.ops.mesh.primitive_uv_sphere_add(radius=.18, location=(0, 0, .8))
head = bpy.context.object
for o in (base, body, head):
    o.select_set(True)
bpy.context.view_layer.objects.active = base
bpy.ops.object.join()
pawn = bpy.context.object
pawn.name = "Pawn"

for side, row, material in (("W", 1, white), ("B", 6, black)):
    for c in range(8):
        p = pawn.copy()
        p.data = pawn.data.copy()
        p.name = f"Pawn_{side}{c}"
        p.location = (c - 3.5, row - 3.5, p.location.z)
        p.data.materials.clear()
        p.data.materials.append(material)
        bpy.context.collection.objects.link(p)

bpy.data.objects.remove(pawn, do_unlink=True)

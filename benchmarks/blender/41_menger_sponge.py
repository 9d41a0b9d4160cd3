# Menger sponge level 2 as one mesh
import bpy
from itertools import product

def menger(level, cx=0.0, cy=0.0, cz=0.0, size=3.0):
    """Yield (center, size) of the solid cubes."""
    if level == 0:
        yield (cx, cy, cz), size
        return
    s = size / 3
    for dx, dy, dz in product((-1, 0, 1), repeat=3):
        if (dx == 0) + (dy == 0) + (dz == 0) >= 2:
            continue
        yield from menger(level - 1, cx + dx * s, cy + dy * s, cz + dz * s, s)

CUBE_V = list(product((-0.5, 0.5), repeat=3))
CUBE_F = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]

verts, faces = [], []
for (x, y, z), s in menger(2):
    base = len(verts)
    verts.extend((x + vx * s, y + vy * s, z + vz * s) for vx, vy, vz in CUBE_V)
    faces.extend(tuple(base + i for i in f) for f in CUBE_F)

for o in list(bpy.data.objects):
    if o.type == 'MESH':
        bpy.data.objects.remove(o)

me = bpy.data.meshes.new("Menger")
me.from_pydata(verts, [], faces)
me.update()
ob = bpy.data.objects.new("MengerSponge", me)
bpy.context.collection.objects.link(ob)
m = bpy.data.materials.new("Concrete")
m.diffuse_color = (.5, .5, .55, 1)
me.materials.append(m)
print(len(verts), "verts", len(faces), "faces")

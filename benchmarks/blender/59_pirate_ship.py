# Pirate ship
# Steps: 1) hull via lofted cross-sections 2) deck, masts, sails 3) cannons with array 4) flag
import bpy
from math import pi, sin, cos

bpy.ops.object.select_all(action='SELECT')
bpy.ops.object.delete(use_global=False)

# ---------- materials ----------
def get_mat(name, r, g, b, a=1.0):
    m = bpy.data.materials.new(name)
    m.use_nodes = True
    bsdf = m.node_tree.nodes.get("Principled BSDF")
    if bsdf is not None:
        bsdf.inputs["Base Color"].default_value = (r, g, b, a)
    m.diffuse_color = (r, g, b, a)
    return m

WOOD = get_mat("HullWood", 0.28, 0.15, 0.06)
DECK = get_mat("DeckWood", 0.5, 0.32, 0.15)
CLOTH = get_mat("SailCloth", 0.9, 0.86, 0.75)
BLACK = get_mat("Black", 0.02, 0.02, 0.02)

# ---------- 1) hull ----------
stations, half_ring = 13, 7
length = 10.0
verts, faces = [], []
for i in range(stations):
    t = i / (stations - 1)
    x = -length / 2 + length * t
    beam = 1.5 * sin(pi * min(1, 0.25 + 0.75 * t)) ** 0.7 if t < 1 else 0.02
    keel = -1.0 * (1 - (2 * t - 1) ** 4)
    sheer = 1.0 + 0.8 * (2 * t - 1) ** 2
    for j in range(2 * half_ring - 1):
        a = pi * j / (2 * half_ring - 2)
        verts.append((x, -beam * cos(a), sheer + (keel - sheer) * sin(a) ** 0.8))
n = 2 * half_ring - 1
for i in range(stations - 1):
    for j in range(n - 1):
        faces.append((i * n + j, (i + 1) * n + j, (i + 1) * n + j + 1, i * n + j + 1))
faces.append(tuple(range(n)))          # transom
mesh = bpy.data.meshes.new("Hull")
mesh.from_pydata(verts, [], faces)
mesh.validate(verbose=False)
mesh.update()
hull = bpy.data.objects.new("Hull", mesh)
bpy.context.collection.objects.link(hull)
hull.data.materials.append(WOOD)
sol = hull.modifiers.new("Solidify", 'SOLIDIFY')
sol.thickness = 0.1

# ---------- 2) deck ----------
bpy.ops.mesh.primitive_cube_add(size=1, location=(-0.5, 0, 0.75))
deck = bpy.context.object
deck.name = "Deck"
deck.scale = (7.5, 2.2, 0.1)
deck.data.materials.append(DECK)
bpy.ops.mesh.primitive_cube_add(size=1, location=(-4, 0, 1.6))
cabin = bpy.context.object
cabin.name = "Cabin"
cabin.scale = (1.6, 1.8, 1.4)
cabin.data.materials.append(WOOD)

# ---------- masts + sails ----------
def sail_mesh(w, h, belly=0.5, nx=8, ny=6):
    vs = [(belly * sin(pi * u / nx) * sin(pi * v / ny), -w / 2 + w * u / nx, h * v / ny)
          for v in range(ny + 1) for u in range(nx + 1)]
    fs = [(v * (nx + 1) + u, v * (nx + 1) + u + 1, (v + 1) * (nx + 1) + u + 1, (v + 1) * (nx + 1) + u)
          for v in range(ny) for u in range(nx)]
    me = bpy.data.meshes.new("Sail")
    me.from_pydata(vs, [], fs)
    me.materials.append(CLOTH)
    return me

for x, h in ((-2.2, 5.5), (0.4, 7.0), (2.8, 5.0)):
    bpy.ops.mesh.primitive_cylinder_add(radius=0.12, depth=h, location=(x, 0, 0.8 + h / 2))
    bpy.context.object.name = "Mast"
    bpy.context.object.data.materials.append(WOOD)
    for k, (frac, w) in enumerate(((0.25, 3.4), (0.62, 2.6))):
        z = 0.8 + h * frac
        sh = h * 0.32
        s = bpy.data.objects.new(f"Sail{k}", sail_mesh(w, sh))
        s.location = (x + 0.15, 0, z)
        bpy.context.collection.objects.link(s)
        for zz in (z, z + sh):
            bpy.ops.mesh.primitive_cylinder_add(radius=0.05, depth=w + 0.3, location=(x + 0.12, 0, zz), rotation=(pi / 2, 0, 0))
            bpy.context.object.name = "Yard"

# bowsprit
bpy.ops.mesh.primitive_cylinder_add(radius=0.08, depth=3, location=(5.6, 0, 2.2), rotation=(0, pi / 2 - 0.4, 0))
bpy.context.object.name = "Bowsprit"

# ---------- 3) cannons ----------
for side in (-1, 1):
    bpy.ops.mesh.primitive_cylinder_add(radius=0.1, depth=0.8, location=(-2.5, side * 1.4, 0.5), rotation=(side * pi / 2, 0, 0))
    gun = bpy.context.object
    gun.name = "Cannons"
    bpy.ops.object.transform_apply(location=False, rotation=True, scale=False)
    arr = gun.modifiers.new("Array", 'ARRAY')
    arr.count = 5
    arr.use_relative_offset = False
    arr.use_constant_offset = True
    arr.constant_offset_displace = (1.1, 0, 0)
    gun.data.materials.append(BLACK)

# ---------- 4) flag ----------
bpy.ops.mesh.primitive_grid_add(x_subdivisions=10, y_subdivisions=4, size=1, location=(0.0, 0, 7.95), rotation=(pi / 2, 0, 0))
flag = bpy.context.object
flag.name = "JollyRoger"
for v in flag.data.vertices:
    v.co.z = 0.08 * sin(v.co.x * 9)
flag.data.materials.append(BLACK)

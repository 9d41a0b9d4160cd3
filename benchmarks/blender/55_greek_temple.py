"""Prompt: Create a Greek temple with fluted columns, stepped base, entablature and triangular pediment. """
import bpy
import bmesh
import math

COLUMNS_FRONT = 6
COLUMNS_SIDE = 11
SPACING = 2.0
COL_HEIGHT = 6.0
COL_RADIUS = 0.5
FLUTES = 16

def fluted_column_mesh():
    """One shaft + capital as a single mesh, using bmesh."""
    bm = bmesh.new()
    n = FLUTES * 2
    levels = 9
    rings = []
    for l in range(levels):
        t = l / (levels - 1)
        taper = COL_RADIUS * (1.0 - 0.18 * t) + 0.03 * math.sin(math.pi * t)   # entasis
        ring = []
        for i in range(n):
            a = 2 * math.pi * i / n
            r = taper if i % 2 == 0 else taper * 0.93
            ring.append(bm.verts.new((r * math.cos(a), r * math.sin(a), t * (COL_HEIGHT - 0.5))))
        rings.append(ring)
    for low, high in zip(rings[:-1], rings[1:]):
        for i in range(n):
            j = (i + 1) % n
            bm.faces.new((low[i], low[j], high[j], high[i]))
    bm.faces.new(list(reversed(rings[0])))
    bm.faces.new(rings[-1])

    # echinus
    ret = bmesh.ops.create_cone(bm, cap_ends=True, cap_tris=False, segments=32,
                                radius1=COL_RADIUS * 0.82, radius2=COL_RADIUS * 1.25, depth=0.25)
    bmesh.ops.translate(bm, verts=ret["verts"], vec=(0, 0, COL_HEIGHT - 0.375))
    # abacus
    ret = bmesh.ops.create_cube(bm, size=1.0)
    bmesh.ops.scale(bm, verts=ret["verts"], vec=(COL_RADIUS * 2.6, COL_RADIUS * 2.6, 0.25))
    bmesh.ops.translate(bm, verts=ret["verts"], vec=(0, 0, COL_HEIGHT - 0.125))

    me = bpy.data.meshes.new("FlutedColumn")
    bm.to_mesh(me)
    bm.free()
    return me

def add_box(name, location, size):
    bpy.ops.mesh.primitive_cube_add(size=1, location=location)
    ob = bpy.context.object
    ob.name = name
    ob.scale = size
    bpy.ops.object.transform_apply(location=False, rotation=False, scale=True)
    return ob

bpy.ops.object.select_all(action='SELECT')
bpy.ops.object.delete()

W = (COLUMNS_FRONT - 1) * SPACING
L = (COLUMNS_SIDE - 1) * SPACING
objects = []

# crepidoma: three steps
for i in range(3):
    grow = (3 - i) * 0.8 + 0.8
    objects.append(add_box(f"Step{i}", (0, 0, 0.2 + 0.4 * i), (W + grow + 1, L + grow + 1, 0.4)))
floor = 1.2

mesh = fluted_column_mesh()
count = 0
for ix in range(COLUMNS_FRONT):
    for iy in range(COLUMNS_SIDE):
        on_edge = ix in (0, COLUMNS_FRONT - 1) or iy in (0, COLUMNS_SIDE - 1)
        if not on_edge:
            continue
        ob = bpy.data.objects.new(f"Column_{count:02d}", mesh)
        ob.location = (ix * SPACING - W / 2, iy * SPACING - L / 2, floor)
        bpy.context.collection.objects.link(ob)
        objects.append(ob)
        count += 1

# cella
objects.append(add_box("Cella", (0, 0, floor + COL_HEIGHT / 2), (W - 3.2, L - 5, COL_HEIGHT)))

# entablature
top = floor + COL_HEIGHT
objects.append(add_box("Architrave", (0, 0, top + 0.3), (W + 1.4, L + 1.4, 0.6)))
objects.append(add_box("Cornice", (0, 0, top + 0.75), (W + 2.0, L + 2.0, 0.3)))

# roof prism with pediments
hw, hl, rise, z = (W + 2.0) / 2, (L + 2.0) / 2, 2.0, top + 0.9
v = [(-hw, -hl, z), (hw, -hl, z), (0, -hl, z + rise), (-hw, hl, z), (hw, hl, z), (0, hl, z + rise)]
f = [(0, 1, 2), (4, 3, 5), (1, 4, 5, 2), (3, 0, 2, 5), (0, 3, 4, 1)]
rm = bpy.data.meshes.new("Roof")
rm.from_pydata(v, [], f)
roof = bpy.data.objects.new("Roof", rm)
bpy.context.collection.objects.link(roof)
objects.append(roof)

marble = bpy.data.materials.new("Marble")
marble.use_nodes = True
marble.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.88, 0.85, 0.78, 1)
mesh.materials.append(marble)
for ob in objects:
    if not ob.data.materials:
        ob.data.materials.append(marble)

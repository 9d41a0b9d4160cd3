"""
Suspension bridge

User request: "Build a red suspension bridge with two towers, deck, main cables following a parabola and vertical hangers"
"""
import bpy
from mathutils import Vector, Matrix

SPAN, SIDE, DECK_W, DECK_Z, TOWER_H, SAG = 40.0, 15.0, 5.0, 4.0, 14.0, 8.0


def purge():
    for coll in (bpy.data.objects, bpy.data.meshes, bpy.data.materials):
        for item in list(coll):
            coll.remove(item)


def link(obj):
    bpy.context.scene.collection.objects.link(obj)
    return obj


_unit_cube = None


def unit_cube():
    """Shared cube mesh so every box is an instance."""
    global _unit_cube
    if _unit_cube is None:
        import bmesh
        bm = bmesh.new()
        bmesh.ops.create_cube(bm, size=1.0)
        _unit_cube = bpy.data.meshes.new("UnitCube")
        bm.to_mesh(_unit_cube)
        bm.free()
    return _unit_cube


def box(name, center, size):
    o = bpy.data.objects.new(name, unit_cube())
    o.matrix_world = Matrix.Translation(center) @ Matrix.Diagonal((*size, 1.0))
    return link(o)


def strut(name, a, b, thickness=0.15):
    a, b = Vector(a), Vector(b)
    d = b - a
    rot = d.to_track_quat('Z', 'Y').to_matrix().to_4x4()
    o = bpy.data.objects.new(name, unit_cube())
    o.matrix_world = Matrix.Translation((a + b) * 0.5) @ rot @ Matrix.Diagonal((thickness, thickness, d.length, 1))
    return link(o)


def cable_z(x):
    """Parabola between the towers, straight line to the anchors outside."""
    half = SPAN / 2
    if abs(x) <= half:
        return TOWER_H - SAG * (1 - (x / half) ** 2)
    t = (abs(x) - half) / SIDE
    return TOWER_H + (DECK_Z - TOWER_H) * t


purge()
red = bpy.data.materials.new("InternationalOrange")
red.diffuse_color = (0.75, 0.15, 0.06, 1)
unit_cube().materials.append(red)

total = SPAN + 2 * SIDE
box("Deck", (0, 0, DECK_Z), (total, DECK_W, 0.5))
for sx in (-1, 1):
    x = sx * SPAN / 2
    for sy in (-1, 1):
        box("TowerLeg", (x, sy * DECK_W / 2, TOWER_H / 2), (1.0, 0.8, TOWER_H))
    for z in (DECK_Z - 1, 9, TOWER_H - 0.5):
        box("TowerBeam", (x, 0, z), (0.8, DECK_W, 0.6))

steps = 28
xs = [-total / 2 + total * i / steps for i in range(steps + 1)]
for sy in (-1, 1):
    y = sy * DECK_W / 2
    for x0, x1 in zip(xs, xs[1:]):
        strut("Cable", (x0, y, cable_z(x0)), (x1, y, cable_z(x1)))
    for x in xs[1:-1]:
        z = cable_z(x)
        if z - DECK_Z > 0.3:
            strut("Hanger", (x, y, DECK_Z), (x, y, z), 0.06)

"""Model a fantasy sword: double-edged blade, cross guard, leather grip and a jeweled pommel."""
import bpy
import bmesh
from mathutils import Vector

def new_object(name, bm, material=None):
    mesh = bpy.data.meshes.new(name)
    bm.to_mesh(mesh)
    bm.free()
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(obj)
    if material:
        obj.data.materials.append(material)
    return obj

def principled(name, **inputs):
    mat = bpy.data.materials.new(name)
    mat.use_nodes = True
    node = mat.node_tree.nodes["Principled BSDF"]
    for k, v in inputs.items():
        key = k.replace("_", " ").title()
        if key in node.inputs:
            node.inputs[key].default_value = v
    return mat

def blade(length=3.0, width=0.22, thickness=0.06, tip=0.5):
    bm = bmesh.new()
    rings = []
    for z in (0.0, length - tip):
        ring = [
            bm.verts.new((-width, 0, z)),
            bm.verts.new((0, -thickness, z)),
            bm.verts.new((width, 0, z)),
            bm.verts.new((0, thickness, z)),
        ]
        rings.append(ring)
    tip_v = bm.verts.new((0, 0, length))
    bm.faces.new(reversed(rings[0]))
    for i in range(4):
        j = (i + 1) % 4
        bm.faces.new((rings[0][i], rings[0][j], rings[1][j], rings[1][i]))
        bm.faces.new((rings[1][i], rings[1][j], tip_v))
    bm.normal_update()
    return bm

def guard(span=1.0):
    bm = bmesh.new()
    bmesh.ops.create_cube(bm, size=1.0)
    bmesh.ops.scale(bm, vec=Vector((span, 0.16, 0.14)), verts=bm.verts)
    # flare the ends upward
    for v in bm.verts:
        if abs(v.co.x) > span * 0.4:
            v.co.z += 0.08
    bmesh.ops.translate(bm, vec=(0, 0, -0.07), verts=bm.verts)
    return bm

def grip(radius=0.08, length=0.8):
    bm = bmesh.new()
    bmesh.ops.create_cone(bm, cap_ends=True, segments=16, radius1=radius, radius2=radius * 0.9, depth=length)
    bmesh.ops.translate(bm, vec=(0, 0, -0.14 - length / 2), verts=bm.verts)
    return bm

def pommel(radius=0.15, z=-1.05):
    bm = bmesh.new()
    bmesh.ops.create_icosphere(bm, subdivisions=2, radius=radius)
    bmesh.ops.translate(bm, vec=(0, 0, z), verts=bm.verts)
    return bm

# clear
for o in list(bpy.data.objects):
    bpy.data.objects.remove(o, do_unlink=True)

steel = principled("Steel", base_color=(0.75, 0.77, 0.8, 1), metallic=1.0, roughness=0.15)
gold = principled("Gold", base_color=(0.9, 0.65, 0.2, 1), metallic=1.0, roughness=0.3)
leather = principled("Leather", base_color=(0.12, 0.05, 0.02, 1), roughness=0.85)
ruby = principled("Ruby", base_color=(0.7, 0.0, 0.05, 1), transmission_weight=0.8, roughness=0.05)

parts = [
    new_object("Blade", blade(), steel),
    new_object("Guard", guard(), gold),
    new_object("Grip", grip(), leather),
    new_object("Pommel", pommel(), ruby),
]
root = bpy.data.objects.new("Sword", None)
bpy.context.collection.objects.link(root)
for p in parts:
    p.parent = root
root.location.z = 1.2

"""a gear with 24 teeth"""
import bpy
import bmesh
from math import cos, sin, tau

def make_gear(teeth=24, r_root=1.0, r_tip=1.18, r_hole=0.3, width=0.3, name="Gear"):
    outer = []
    step = tau / teeth
    for i in range(teeth):
        a = i * step
        for frac, r in ((0.0, r_root), (0.2, r_root), (0.32, r_tip), (0.68, r_tip), (0.8, r_root)):
            ang = a + frac * step
            outer.append((r * cos(ang), r * sin(ang)))
    n = len(outer)
    inner = [(r_hole * cos(tau * i / n), r_hole * sin(tau * i / n)) for i in range(n)]

    verts = []
    for z in (-width / 2, width / 2):
        verts += [(x, y, z) for x, y in outer]
        verts += [(x, y, z) for x, y in inner]
    faces = []
    for i in range(n):
        j = (i + 1) % n
        faces.append((i, n + i, n + j, j))                          # bottom
        faces.append((2*n + i, 2*n + j, 3*n + j, 3*n + i))          # top
        faces.append((i, j, 2*n + j, 2*n + i))                      # outside
        faces.append((n + i, 3*n + i, 3*n + j, n + j))              # hole
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(verts, [], faces)
    mesh.update()
    bm = bmesh.new()
    bm.from_mesh(mesh)
    bmesh.ops.recalc_face_normals(bm, faces=bm.faces)
    bm.to_mesh(mesh)
    bm.free()
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(obj)
    return obj

if "Cube" in bpy.data.objects:
    bpy.data.objects.remove(bpy.data.objects["Cube"], do_unlink=True)

gear = make_gear()
steel = bpy.data.materials.new("Steel")
steel.use_nodes = True
nodes = steel.node_tree.nodes
nodes["Principled BSDF"].inputs["Metallic"].default_value = 1.0
nodes["Principled BSDF"].inputs["Roughness"].default_value = 0.3
nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.6, 0.6, 0.63, 1)
gear.data.materials.append(steel)

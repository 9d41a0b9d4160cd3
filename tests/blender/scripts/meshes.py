"""Meshes by bmesh: extrusions, insets, merged corners, spheres with moved corners, a turned profile."""

import math
import random

import bmesh
import bpy
from mathutils import Matrix, Vector

bpy.ops.object.select_all(action="SELECT")
bpy.ops.object.delete()


def finish(bm, name, x):
    mesh = bpy.data.meshes.new(name)
    bm.normal_update()
    bm.to_mesh(mesh)
    bm.free()
    made = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(made)
    made.location.x = x
    return made


bm = bmesh.new()
bmesh.ops.create_cube(bm, size=1, matrix=Matrix.Translation((0, 0, 0.5)))
bm.faces.ensure_lookup_table()
top = max(bm.faces, key=lambda face: face.calc_center_median().z)
bmesh.ops.inset_individual(bm, faces=[top], thickness=0.2)
moved = bmesh.ops.extrude_face_region(bm, geom=[top])
bmesh.ops.translate(bm, vec=Vector((0, 0, 0.7)), verts=[v for v in moved["geom"] if isinstance(v, bmesh.types.BMVert)])
bmesh.ops.delete(bm, geom=[top], context="FACES_ONLY")
finish(bm, "Tower", 0)

bm = bmesh.new()
bmesh.ops.create_cube(bm, size=1)
bm.faces.ensure_lookup_table()
side = bm.faces[2]
bmesh.ops.inset_region(bm, faces=[side], thickness=0.1, depth=0.2, use_even_offset=True)
bm.faces.ensure_lookup_table()
grown = bmesh.ops.extrude_discrete_faces(bm, faces=[bm.faces[5]])
bmesh.ops.translate(bm, vec=(0, 0, 0.5), verts=grown["faces"][0].verts[:])
finish(bm, "Extruded", -4)

bm = bmesh.new()
points = [
    bm.verts.new((math.cos(a) * r, math.sin(a) * r, 0)) for a, r in ((math.tau * i / 10, 1 + i % 2) for i in range(10))
]
face = bm.faces.new(points)
moved = bmesh.ops.extrude_face_region(bm, geom=[face])
bmesh.ops.translate(bm, verts=[v for v in moved["geom"] if isinstance(v, bmesh.types.BMVert)], vec=(0, 0, 0.5))
bmesh.ops.recalc_face_normals(bm, faces=bm.faces)
finish(bm, "Star", 4)

random.seed(3)
bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, radius=1, location=(8, 0, 0))
rock = bpy.context.object
rock.name = "Rock"
for vertex in rock.data.vertices:
    vertex.co *= random.uniform(0.8, 1.2)
bpy.ops.mesh.primitive_uv_sphere_add(segments=16, ring_count=8, location=(11, 0, 0))
bpy.context.object.name = "Pebble"
for i, vertex in enumerate(bpy.context.object.data.vertices):
    vertex.co.z *= 0.5 + 0.1 * (i % 3)

profile = [(0.0, 0.0), (0.5, 0.0), (0.6, 0.4), (0.3, 0.8), (0.0, 0.9)]
points, faces, count = [], [], 12
for r, z in profile[1:-1]:
    points += [(r * math.cos(math.tau * i / count), r * math.sin(math.tau * i / count), z) for i in range(count)]
for j in range(len(profile) - 3):
    faces += [
        (j * count + i, j * count + (i + 1) % count, (j + 1) * count + (i + 1) % count, (j + 1) * count + i)
        for i in range(count)
    ]
faces += [tuple(range(count))[::-1], tuple(range(2 * count, 3 * count))]
mesh = bpy.data.meshes.new("Vase")
mesh.from_pydata(points, [], faces)
vase = bpy.data.objects.new("Vase", mesh)
vase.location = (14, 0, 0)
bpy.context.scene.collection.objects.link(vase)

bpy.ops.mesh.primitive_grid_add(x_subdivisions=6, y_subdivisions=6, size=4, location=(20, 0, 0))
bpy.context.object.name = "Terrain"
for vertex in bpy.context.object.data.vertices:
    vertex.co.z = 0.3 * math.sin(vertex.co.x * 2) * math.cos(vertex.co.y)

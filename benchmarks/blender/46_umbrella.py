"""Beach umbrella"""
import bpy, bmesh
from math import *

def lathe_canopy(radius=1.5, height=0.5, ribs=8, rings=6):
    bm = bmesh.new()
    apex = bm.verts.new((0, 0, height))
    prev = None
    mat_lookup = []
    n = ribs * 2
    for r in range(1, rings + 1):
        t = r / rings
        ring = []
        for k in range(n):
            a = 2 * pi * k / n
            # fabric sags between ribs
            sag = 0.0 if k % 2 == 0 else 0.06 * t
            rr = radius * sin(t * pi / 2) * (1 if k % 2 == 0 else cos(pi / n) ** .5)
            ring.append(bm.verts.new((rr * cos(a), rr * sin(a), height * cos(t * pi / 2) - sag)))
        for k in range(n):
            k2 = (k + 1) % n
            if prev is None:
                f = bm.faces.new((apex, ring[k], ring[k2]))
            else:
                f = bm.faces.new((prev[k], ring[k], ring[k2], prev[k2]))
            f.material_index = (k // 2) % 2
            f.smooth = True
        prev = ring
    me = bpy.data.meshes.new('Canopy')
    bm.to_mesh(me)
    bm.free()
    return me

for o in bpy.data.objects[:]:
    bpy.data.objects.remove(o)

canopy = bpy.data.objects.new('Canopy', lathe_canopy())
for nm, c in (('StripeA', (.9, .1, .1, 1)), ('StripeB', (1, 1, 1, 1))):
    m = bpy.data.materials.new(nm)
    m.diffuse_color = c
    canopy.data.materials.append(m)
bpy.context.collection.objects.link(canopy)
canopy.location.z = 2.0
mod = canopy.modifiers.new('Thickness', 'SOLIDIFY')
mod.thickness = 0.01

bpy.ops.mesh.primitive_cylinder_add(radius=.03, depth=2.6, location=(0, 0, 1.25))
pole = bpy.context.object; pole.name = 'Pole'
bpy.ops.mesh.primitive_uv_sphere_add(radius=.05, location=(0, 0, 2.57))
knob = bpy.context.object; knob.name = 'Finial'

# tilt everything together
for o in (canopy, knob):
    o.parent = pole
    o.matrix_parent_inverse.translation = (0, 0, -1.25)
pole.rotation_euler = (radians(12), 0, 0)

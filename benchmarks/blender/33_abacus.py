# abacus
import bpy
bpy.ops.object.select_all(action='SELECT'); bpy.ops.object.delete()
N_RODS = 9
cube, cyl, tor = bpy.ops.mesh.primitive_cube_add, bpy.ops.mesh.primitive_cylinder_add, bpy.ops.mesh.primitive_torus_add

w = N_RODS * .5 + .5
for z in (0, 1.6, 2.6):
    cube(size=1, location=(0, 0, z), scale=(w, .25, .12))
    bpy.context.object.name = 'Beam'
for x in (-w/2, w/2):
    cube(size=1, location=(x, 0, 1.3), scale=(.12, .25, 2.72))
    bpy.context.object.name = 'Side'

bead_mats = []
for k in range(3):
    m = bpy.data.materials.new(f'Bead{k}')
    m.diffuse_color = [(.8, .1, .1, 1), (.1, .5, .2, 1), (.9, .7, .1, 1)][k]
    bead_mats.append(m)

number = 402617395
digits = [int(c) for c in str(number).zfill(N_RODS)]
for i, d in enumerate(digits):
    x = (i - (N_RODS - 1) / 2) * .5
    cyl(vertices=12, radius=.025, depth=2.6, location=(x, 0, 1.3))
    five, ones = divmod(d, 5)
    zs = [1.6 + .18 if five else 2.6 - .18]
    for b in range(4):
        zs.append(1.6 - .18 - b * .2 if b < ones else .18 + (3 - b) * .2)
    for z in zs:
        tor(major_radius=.12, minor_radius=.08, major_segments=24, minor_segments=10, location=(x, 0, z))
        bead = bpy.context.object
        bead.data.materials.append(bead_mats[i % 3])

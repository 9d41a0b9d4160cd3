# sofa modelled in edit mode: extrude + inset + loop operations
import bpy
import bmesh

bpy.ops.object.select_all(action='SELECT')
bpy.ops.object.delete()

bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 0, 0.3))
sofa = bpy.context.object
sofa.name = "Sofa"
sofa.scale = (2.2, 0.9, 0.3)
bpy.ops.object.transform_apply(location=True, rotation=True, scale=True)

me = sofa.data
bm = bmesh.new()
bm.from_mesh(me)

# cut into 5 sections along X, so arms can be raised
bmesh.ops.bisect_plane(bm, geom=bm.verts[:] + bm.edges[:] + bm.faces[:], plane_co=(-0.85, 0, 0), plane_no=(1, 0, 0))
bmesh.ops.bisect_plane(bm, geom=bm.verts[:] + bm.edges[:] + bm.faces[:], plane_co=(0.85, 0, 0), plane_no=(1, 0, 0))
bmesh.ops.bisect_plane(bm, geom=bm.verts[:] + bm.edges[:] + bm.faces[:], plane_co=(0, 0.2, 0), plane_no=(0, 1, 0))
bm.faces.ensure_lookup_table()

def tops():
    return [f for f in bm.faces if f.normal.z > 0.9]

bm.normal_update()
arms = [f for f in tops() if abs(f.calc_center_median().x) > 0.85]
back = [f for f in tops() if f.calc_center_median().y > 0.2 and abs(f.calc_center_median().x) < 0.85]

for group, rise in ((arms, 0.25), (back, 0.5)):
    res = bmesh.ops.extrude_face_region(bm, geom=group)
    new_verts = [g for g in res["geom"] if isinstance(g, bmesh.types.BMVert)]
    bmesh.ops.translate(bm, verts=new_verts, vec=(0, 0, rise))
    bmesh.ops.delete(bm, geom=group, context='FACES')

bmesh.ops.recalc_face_normals(bm, faces=bm.faces[:])
bm.to_mesh(me)
bm.free()

bev = sofa.modifiers.new("Bevel", 'BEVEL')
bev.width = 0.04
bev.segments = 3

# cushions via ops in edit mode
for x in (-0.43, 0.43):
    bpy.ops.mesh.primitive_cube_add(size=1, location=(x, -0.13, 0.52))
    c = bpy.context.object
    c.name = "Cushion"
    c.scale = (0.82, 0.62, 0.14)
    bpy.ops.object.mode_set(mode='EDIT')
    bpy.ops.mesh.subdivide(number_cuts=2)
    bpy.ops.object.mode_set(mode='OBJECT')
    c.modifiers.new("Subsurf", 'SUBSURF').levels = 1
    bpy.ops.object.shade_smooth()

fabric = bpy.data.materials.new("Fabric")
fabric.diffuse_color = (0.35, 0.4, 0.3, 1)
for o in bpy.data.objects:
    if o.type == 'MESH':
        o.data.materials.append(fabric)

for sx in (-1, 1):
    for sy in (-1, 1):
        bpy.ops.mesh.primitive_cylinder_add(radius=0.03, depth=0.15, location=(sx, sy * 0.38, 0.075))

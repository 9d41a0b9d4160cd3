"""Prompt: A roller coaster track from beveled curves with support columns."""
import bpy
import math
from mathutils import Vector

for o in list(bpy.data.objects):
    bpy.data.objects.remove(o, do_unlink=True)


def track_point(t: float) -> Vector:
    a = t * 2 * math.pi
    return Vector((12 * math.cos(a), 8 * math.sin(a), 4 + 2.5 * math.sin(2 * a) + 1.2 * math.cos(3 * a)))


def make_rail(name, offset, bevel=0.12, samples=64):
    cu = bpy.data.curves.new(name, type='CURVE')
    cu.dimensions = '3D'
    cu.bevel_depth = bevel
    cu.bevel_resolution = 4
    cu.resolution_u = 6
    spline = cu.splines.new('NURBS')
    spline.points.add(samples - 1)
    for i in range(samples):
        t = i / samples
        p = track_point(t)
        d = (track_point(t + 1e-3) - track_point(t - 1e-3)).normalized()
        side = d.cross(Vector((0, 0, 1))).normalized()
        q = p + side * offset
        spline.points[i].co = (q.x, q.y, q.z, 1.0)
    spline.use_cyclic_u = True
    spline.order_u = 4
    ob = bpy.data.objects.new(name, cu)
    bpy.context.collection.objects.link(ob)
    return ob


blue = bpy.data.materials.new("TrackBlue")
blue.diffuse_color = (0.05, 0.2, 0.7, 1)
for name, off in (("RailLeft", -0.5), ("RailRight", 0.5)):
    make_rail(name, off).data.materials.append(blue)
make_rail("Spine", 0.0, 0.2).data.materials.append(blue)

for i in range(24):
    p = track_point(i / 24)
    bpy.ops.mesh.primitive_cylinder_add(vertices=12, radius=0.12, depth=p.z, location=(p.x, p.y, p.z / 2))
    bpy.context.object.name = f"Support.{i:03d}"

# train with a follow path constraint
bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 0, 0))
car = bpy.context.object
car.name = "Car"
car.scale = (0.9, 1.6, 0.7)
con = car.constraints.new('FOLLOW_PATH')
con.target = bpy.data.objects["Spine"]
con.use_curve_follow = True
con.use_fixed_location = True
con.offset_factor = 0.0
con.keyframe_insert("offset_factor", frame=1)
con.offset_factor = 1.0
con.keyframe_insert("offset_factor", frame=240)

"""A terracotta vase (screw modifier from an edge profile) with ivy vines as beveled bezier curves."""
import bpy
import math
import random

random.seed(5)
bpy.ops.object.select_all(action='SELECT')
bpy.ops.object.delete()

# --- vase: edges only + screw
profile = [(0.0, 0.0), (0.35, 0.0), (0.5, 0.35), (0.48, 0.7), (0.28, 1.05), (0.25, 1.2), (0.33, 1.3)]
me = bpy.data.meshes.new("VaseProfile")
me.from_pydata([(x, 0, z) for x, z in profile], [(i, i + 1) for i in range(len(profile) - 1)], [])
vase = bpy.data.objects.new("Vase", me)
bpy.context.collection.objects.link(vase)
screw = vase.modifiers.new("Screw", 'SCREW')
screw.axis = 'Z'
screw.angle = 2 * math.pi
screw.steps = 48
screw.render_steps = 48
screw.use_merge_vertices = True
solid = vase.modifiers.new("Solidify", 'SOLIDIFY')
solid.thickness = 0.03
terracotta = bpy.data.materials.new("Terracotta")
terracotta.diffuse_color = (0.7, 0.32, 0.18, 1)
me.materials.append(terracotta)

# --- vines
green = bpy.data.materials.new("Ivy")
green.diffuse_color = (0.08, 0.3, 0.06, 1)

leaf_me = bpy.data.meshes.new("Leaf")
leaf_me.from_pydata([(0, 0, 0), (0.06, 0.05, 0.01), (0, 0.16, -0.02), (-0.06, 0.05, 0.01)], [], [(0, 1, 2, 3)])
leaf_me.materials.append(green)

def vine(angle, drops=5):
    cu = bpy.data.curves.new("Vine", 'CURVE')
    cu.dimensions = '3D'
    cu.bevel_depth = 0.012
    cu.bevel_resolution = 2
    sp = cu.splines.new('BEZIER')
    sp.bezier_points.add(drops)
    for k, bp in enumerate(sp.bezier_points):
        r = 0.2 + 0.12 * k
        z = 1.25 + 0.25 * math.sin(k * 0.9) - 0.2 * max(0, k - 1)
        a = angle + random.uniform(-0.2, 0.2)
        bp.co = (r * math.cos(a), r * math.sin(a), z)
        bp.handle_left_type = bp.handle_right_type = 'AUTO'
        for _ in range(2):
            leaf = bpy.data.objects.new("Leaf", leaf_me)
            leaf.location = bp.co
            leaf.rotation_euler = (random.uniform(-0.6, 0.6), 0, random.uniform(0, math.tau))
            leaf.scale = [random.uniform(0.7, 1.3)] * 3
            bpy.context.collection.objects.link(leaf)
    ob = bpy.data.objects.new("Vine", cu)
    ob.data.materials.append(green)
    bpy.context.collection.objects.link(ob)

for i in range(6):
    vine(i * math.tau / 6)

# a circle curve as a decorative ring
bpy.ops.curve.primitive_bezier_circle_add(radius=0.51, location=(0, 0, 0.4))
ring = bpy.context.object
ring.data.bevel_depth = 0.02

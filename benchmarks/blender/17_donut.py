# Prompt: A donut with pink icing and sprinkles
import bpy
import random
from math import cos, sin, pi
from mathutils import Euler

random.seed(0)
bpy.ops.object.select_all(action='SELECT')
bpy.ops.object.delete()

bpy.ops.mesh.primitive_torus_add(major_radius=1, minor_radius=0.45, major_segments=64, minor_segments=24)
donut = bpy.context.object
donut.name = "Donut"
bpy.ops.object.shade_smooth()
dough = bpy.data.materials.new("Dough")
dough.use_nodes = True
dough.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.65, 0.38, 0.15, 1)
donut.data.materials.append(dough)

# Icing: duplicate, keep upper half, inflate a little
icing = donut.copy()
icing.data = donut.data.copy()
icing.name = "Icing"
bpy.context.collection.objects.link(icing)
icing.data.materials.clear()
pink = bpy.data.materials.new("PinkIcing")
pink.use_nodes = True
pink.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.95, 0.4, 0.6, 1)
pink.node_tree.nodes["Principled BSDF"].inputs["Roughness"].default_value = 0.2
icing.data.materials.append(pink)

for v in icing.data.vertices:
    if v.co.z < -0.02:
        v.co.z = -0.02 + 0.05 * sin(v.co.x * 7) * cos(v.co.y * 5)
    v.co += v.normal * 0.03

solid = icing.modifiers.new(name="Solidify", type='SOLIDIFY')
solid.thickness = 0.04
solid.offset = 1
sub = icing.modifiers.new(name="Subdivision", type='SUBSURF')
sub.levels = 1
sub.render_levels = 2

# Sprinkles
palette = [(1, 1, 1, 1), (1, 0.9, 0.1, 1), (0.1, 0.6, 1, 1), (0.2, 0.9, 0.3, 1), (0.9, 0.1, 0.2, 1)]
mats = []
for i, c in enumerate(palette):
    m = bpy.data.materials.new(f"Sprinkle_{i}")
    m.diffuse_color = c
    mats.append(m)

bpy.ops.mesh.primitive_cylinder_add(vertices=8, radius=0.02, depth=0.14)
template = bpy.context.object
for i in range(120):
    u = random.uniform(0, 2 * pi)
    v = random.uniform(pi * 0.2, pi * 0.8)
    r = 1 + 0.5 * cos(v)
    s = template.copy()
    s.data = template.data.copy()
    s.location = (r * cos(u), r * sin(u), 0.5 * sin(v))
    s.rotation_euler = Euler((pi / 2 + random.uniform(-0.3, 0.3), 0, random.uniform(0, pi)), 'XYZ')
    s.data.materials.append(random.choice(mats))
    bpy.context.collection.objects.link(s)
bpy.data.objects.remove(template)

"""A white picket fence made with array modifiers."""
import bpy

# Remove default objects
for name in ("Cube", "Light", "Camera"):
    ob = bpy.data.objects.get(name)
    if ob:
        bpy.data.objects.remove(ob)

PICKETS = 20
SPACING = 0.25

white = bpy.data.materials.new("WhitePaint")
white.diffuse_color = (0.95, 0.95, 0.93, 1.0)

# One picket with a pointed top
w, d, h, point = 0.1, 0.02, 1.0, 0.12
outline = [(-w/2, 0), (w/2, 0), (w/2, h), (0, h + point), (-w/2, h)]
verts = [(x, -d/2, z) for x, z in outline] + [(x, d/2, z) for x, z in outline]
n = len(outline)
faces = [list(range(n)), list(range(2*n - 1, n - 1, -1))]
faces += [[i, i + n, (i + 1) % n + n, (i + 1) % n] for i in range(n)]
me = bpy.data.meshes.new("Picket")
me.from_pydata(verts, [], faces)
picket = bpy.data.objects.new("Pickets", me)
bpy.context.collection.objects.link(picket)
me.materials.append(white)

arr = picket.modifiers.new("Array", "ARRAY")
arr.count = PICKETS
arr.use_relative_offset = False
arr.use_constant_offset = True
arr.constant_offset_displace = (SPACING, 0, 0)

# Two rails
length = SPACING * (PICKETS - 1) + 0.3
for z in (0.25, 0.8):
    bpy.ops.mesh.primitive_cube_add(size=1, location=(length/2 - 0.15, 0.03, z))
    rail = bpy.context.object
    rail.name = "Rail"
    rail.dimensions = (length, 0.04, 0.08)
    rail.data.materials.append(white)

# Posts, every five pickets
bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 0.1, 0.6))
post = bpy.context.object
post.name = "Posts"
post.scale = (0.1, 0.1, 1.2)
bpy.ops.object.transform_apply(scale=True)
post.data.materials.append(white)
bpy.ops.object.modifier_add(type='ARRAY')
post.modifiers["Array"].count = 5
post.modifiers["Array"].use_relative_offset = False
post.modifiers["Array"].use_constant_offset = True
post.modifiers["Array"].constant_offset_displace[0] = SPACING * 19 / 4
bev = post.modifiers.new(name="Bevel", type='BEVEL')
bev.width = 0.01

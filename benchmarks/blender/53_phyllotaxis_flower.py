# sunflower
import bpy
from math import sqrt, cos, sin, radians, pi
from mathutils import Matrix
GOLDEN = pi * (3 - sqrt(5))

bpy.ops.object.select_all(action='SELECT')
bpy.ops.object.delete()

petal_mat = bpy.data.materials.new('Petal');  petal_mat.diffuse_color = (1, .75, 0, 1)
seed_mat = bpy.data.materials.new('Seed');    seed_mat.diffuse_color = (.12, .06, .02, 1)
stem_mat = bpy.data.materials.new('Stem');    stem_mat.diffuse_color = (.1, .4, .08, 1)

head = bpy.data.objects.new('SunflowerHead', None)
bpy.context.collection.objects.link(head)

# seeds share one mesh
bpy.ops.mesh.primitive_uv_sphere_add(segments=8, ring_count=6, radius=.035)
proto = bpy.context.object
proto.data.materials.append(seed_mat)
for n in range(1, 180):
    r, th = .055 * sqrt(n), n * GOLDEN
    s = bpy.data.objects.new(f'Seed{n:03d}', proto.data)
    s.location = r * cos(th), r * sin(th), .08 * (1 - (r / .75) ** 2)
    s.scale = (1, .6, 1.2)
    s.rotation_euler.z = th
    s.parent = head
    bpy.context.collection.objects.link(s)
bpy.data.objects.remove(proto)

bpy.ops.mesh.primitive_cylinder_add(radius=.78, depth=.1, location=(0, 0, -.03))
disc = bpy.context.object
disc.data.materials.append(seed_mat)
disc.parent = head

# petals
pts = [(0, -.1), (.25, -.14), (.6, -.1), (.85, 0), (.6, .1), (.25, .14), (0, .1)]
petal = bpy.data.meshes.new('Petal')
petal.from_pydata([(x, y, .12 * x * (1 - x) - y * y) for x, y in pts], [], [list(range(len(pts)))])
petal.materials.append(petal_mat)
for layer, count, tilt in ((0, 21, 5), (1, 21, 22)):
    for k in range(count):
        a = 2 * pi * (k + .5 * layer) / count
        p = bpy.data.objects.new('Petal', petal)
        bpy.context.collection.objects.link(p)
        p.matrix_local = (Matrix.Rotation(a, 4, 'Z') @ Matrix.Translation((.7, 0, -.02 * layer))
                          @ Matrix.Rotation(radians(-tilt), 4, 'Y'))
        p.parent = head

head.location = (0, -.2, 3)
head.rotation_euler = (radians(65), 0, 0)

bpy.ops.mesh.primitive_cylinder_add(radius=.06, depth=3, location=(0, 0, 1.5), vertices=12)
bpy.context.object.data.materials.append(stem_mat)
bpy.context.object.name = 'Stem'
for z, a in ((.9, 0), (1.5, 130), (2, 250)):
    bpy.ops.mesh.primitive_circle_add(vertices=12, radius=.3, fill_type='TRIFAN',
        location=(.35 * cos(radians(a)), .35 * sin(radians(a)), z), rotation=(0, radians(-25), radians(a)))
    leaf = bpy.context.object
    leaf.scale = (1.2, .6, 1)
    leaf.name = 'Leaf'
    leaf.data.materials.append(stem_mat)

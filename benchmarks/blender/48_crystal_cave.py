"""Cluster of glowing crystals growing from a rock base (low-poly)."""
import bpy, random, math
from mathutils import Vector, Quaternion, Matrix

SEED = 77
rnd = random.Random(SEED)

def crystal_geometry(radius, height, sides=6, tip=0.25):
    ring = lambda r, z: [(r * math.cos(2*math.pi*i/sides), r * math.sin(2*math.pi*i/sides), z) for i in range(sides)]
    verts = ring(radius * 0.8, 0) + ring(radius, height * (1 - tip)) + [(0, 0, height)]
    faces = [tuple(range(sides))[::-1]]
    for i in range(sides):
        j = (i + 1) % sides
        faces.append((i, j, sides + j, sides + i))
        faces.append((sides + i, sides + j, 2 * sides))
    return verts, faces

def emissive(name, rgb, strength):
    mat = bpy.data.materials.new(name)
    mat.use_nodes = True
    bsdf = mat.node_tree.nodes["Principled BSDF"]
    settings = {
        "Base Color": (*rgb, 1),
        "Roughness": 0.1,
        "Transmission Weight": 0.6,
        "Transmission": 0.6,
        "Emission Color": (*rgb, 1),
        "Emission": (*rgb, 1),
        "Emission Strength": strength,
    }
    for key, val in settings.items():
        if key in bsdf.inputs:
            bsdf.inputs[key].default_value = val
    return mat

bpy.ops.object.select_all(action='SELECT')
bpy.ops.object.delete()

mats = [emissive("Amethyst", (0.5, 0.1, 0.9), 1.5),
        emissive("Aqua", (0.1, 0.7, 0.9), 1.2),
        emissive("Rose", (0.95, 0.3, 0.5), 1.0)]

bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, radius=1.6, location=(0, 0, -0.3))
base = bpy.context.object
base.name = "RockBase"
base.scale = (1.0, 0.9, 0.4)
for v in base.data.vertices:
    v.co *= rnd.uniform(0.9, 1.12)

for i in range(22):
    az = rnd.uniform(0, 2 * math.pi)
    lean = rnd.triangular(0, 1.1, 0.3)
    direction = Vector((math.sin(lean) * math.cos(az), math.sin(lean) * math.sin(az), math.cos(lean)))
    h = rnd.uniform(0.6, 2.2) * (1.2 - lean * 0.6)
    v, f = crystal_geometry(rnd.uniform(0.08, 0.22), h, rnd.choice((5, 6, 6, 7)))
    me = bpy.data.meshes.new(f"Crystal{i:02}")
    me.from_pydata(v, [], f)
    me.materials.append(mats[i % len(mats)])
    ob = bpy.data.objects.new(me.name, me)
    q = Vector((0, 0, 1)).rotation_difference(direction)
    spin = Quaternion((0, 0, 1), rnd.uniform(0, math.pi))
    pos = Vector((direction.x, direction.y, 0)) * 0.9
    ob.matrix_world = Matrix.LocRotScale(pos, q @ spin, Vector((1, 1, 1)))
    bpy.context.collection.objects.link(ob)

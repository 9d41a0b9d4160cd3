# wine glass by revolving a profile (screw modifier replaced with explicit lathe)
import bpy, math

profile = [(0.0, 0.0), (0.45, 0.0), (0.45, 0.02), (0.1, 0.06), (0.04, 0.12), (0.04, 0.9),
           (0.12, 0.98), (0.32, 1.15), (0.42, 1.4), (0.42, 1.6), (0.36, 1.9),
           (0.345, 1.9), (0.4, 1.6), (0.4, 1.42), (0.3, 1.19), (0.1, 1.04), (0.0, 1.02)]
N = 48

verts, faces = [], []
for r, z in profile:
    for k in range(N):
        a = 2 * math.pi * k / N
        verts.append((r * math.cos(a), r * math.sin(a), z))
for i in range(len(profile) - 1):
    for k in range(N):
        k2 = (k + 1) % N
        faces.append((i*N + k, i*N + k2, (i+1)*N + k2, (i+1)*N + k))

mesh = bpy.data.meshes.new("WineGlass")
mesh.from_pydata(verts, [], faces)
mesh.update(calc_edges=True)
glass = bpy.data.objects.new("WineGlass", mesh)
bpy.context.collection.objects.link(glass)
for poly in mesh.polygons:
    poly.use_smooth = True

mat = bpy.data.materials.new("Glass")
mat.use_nodes = True
b = mat.node_tree.nodes["Principled BSDF"]
b.inputs["Roughness"].default_value = 0.0
b.inputs["IOR"].default_value = 1.45
try:
    b.inputs["Transmission Weight"].default_value = 1.0   # 4.x
except KeyError:
    b.inputs["Transmission"].default_value = 1.0          # 3.x
mesh.materials.append(mat)

cube = bpy.data.objects.get("Cube")
if cube is not None:
    bpy.data.objects.remove(cube, do_unlink=True)

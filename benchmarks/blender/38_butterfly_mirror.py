"""a butterfly, built with one wing and a mirror modifier, flapping"""
import bpy
import math

bpy.ops.object.select_all(action='SELECT')
bpy.ops.object.delete()

# wing outlines in the XY plane (x > 0 half)
upper = [(0.05, 0.1), (0.4, 0.7), (1.0, 1.15), (1.5, 1.1), (1.55, 0.7), (1.2, 0.2), (0.5, -0.05), (0.05, 0.0)]
lower = [(0.05, 0.0), (0.5, -0.05), (1.0, -0.2), (1.15, -0.6), (0.9, -1.0), (0.55, -0.95), (0.2, -0.5), (0.05, -0.2)]

def wing(name, outline, color):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([(x, y, 0.0) for x, y in outline], [], [tuple(range(len(outline)))])
    mesh.update()
    ob = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(ob)
    mat = bpy.data.materials.new(name + "Mat")
    mat.use_nodes = True
    mat.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = color
    ob.data.materials.append(mat)
    mir = ob.modifiers.new("Mirror", 'MIRROR')
    mir.use_axis[0] = True
    mir.use_axis[1] = False
    mir.use_clip = True
    sol = ob.modifiers.new("Solidify", 'SOLIDIFY')
    sol.thickness = 0.02
    return ob

wings = [wing("UpperWings", upper, (0.95, 0.45, 0.05, 1)),
         wing("LowerWings", lower, (0.9, 0.6, 0.1, 1))]

# body
bpy.ops.mesh.primitive_uv_sphere_add(radius=0.5, location=(0, -0.1, 0))
body = bpy.context.object
body.name = "Body"
body.scale = (0.12, 1.2, 0.12)
bpy.ops.mesh.primitive_uv_sphere_add(radius=0.1, location=(0, 0.58, 0.02))
head = bpy.context.object
head.name = "Head"

# antennae
for s in (1, -1):
    bpy.ops.mesh.primitive_cylinder_add(radius=0.01, depth=0.5, location=(s * 0.1, 0.83, 0.1),
                                        rotation=(math.radians(-70), 0, math.radians(-s * 20)))
    bpy.context.object.name = "Antenna"

root = bpy.data.objects.new("Butterfly", None)
bpy.context.collection.objects.link(root)
for o in bpy.context.collection.objects:
    if o is not root:
        o.parent = root

for f in range(0, 49, 6):
    root.location.z = 1 + 0.2 * math.sin(f / 48 * 2 * math.pi)
    root.keyframe_insert("location", frame=f + 1)
    for w in wings:
        w.scale.x = 1.0 if f % 12 == 0 else 0.35
        w.keyframe_insert("scale", index=0, frame=f + 1)

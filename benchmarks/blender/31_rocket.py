# A cartoon rocket: body, nose cone, three fins, round window, flame. Then it lifts off.
import bpy
from math import sin, cos, radians, pi

bpy.ops.object.select_all(action='SELECT')
bpy.ops.object.delete()

def color(name, r, g, b):
    m = bpy.data.materials.new(name)
    m.diffuse_color = (r, g, b, 1)
    m.use_nodes = True
    m.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (r, g, b, 1)
    return m

white = color("RocketWhite", .92, .92, .94)
red = color("RocketRed", .8, .06, .05)
blue = color("Window", .1, .4, .8)
orange = color("Flame", 1, .45, 0)

bpy.ops.object.empty_add(type='ARROWS', location=(0, 0, 0))
rocket = bpy.context.object
rocket.name = "Rocket"

bpy.ops.mesh.primitive_cylinder_add(radius=.6, depth=2.4, location=(0, 0, 2))
body = bpy.context.object
body.data.materials.append(white)
body.parent = rocket

bpy.ops.mesh.primitive_cone_add(radius1=.6, radius2=0, depth=1.2, location=(0, 0, 3.8))
nose = bpy.context.object
nose.data.materials.append(red)
nose.parent = rocket

# fins: thin triangular prisms
t = .05
tri = [(0.55, 1.6), (1.3, 0.5), (0.55, 0.8)]
for k in range(3):
    ang = k * 2 * pi / 3
    vs = [(x, -t, z) for x, z in tri] + [(x, t, z) for x, z in tri]
    fs = [(0, 1, 2), (5, 4, 3), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)]
    me = bpy.data.meshes.new(f"Fin{k}")
    me.from_pydata(vs, [], fs)
    fin = bpy.data.objects.new(f"Fin{k}", me)
    fin.rotation_euler = (0, 0, ang)
    me.materials.append(red)
    bpy.context.collection.objects.link(fin)
    fin.parent = rocket

bpy.ops.mesh.primitive_cylinder_add(radius=.22, depth=.1, location=(0, -.58, 2.5), rotation=(radians(90), 0, 0))
win = bpy.context.object
win.data.materials.append(blue)
win.parent = rocket

bpy.ops.mesh.primitive_cone_add(radius1=.4, radius2=0, depth=1, location=(0, 0, .3), rotation=(pi, 0, 0))
flame = bpy.context.object
flame.name = "Flame"
flame.data.materials.append(orange)
flame.parent = rocket
for f in range(1, 61, 5):
    flame.scale = (1, 1, 1 + .4 * sin(f))
    flame.keyframe_insert("scale", frame=f)

rocket.keyframe_insert("location", frame=1)
rocket.location.z = 30
rocket.keyframe_insert("location", frame=60)

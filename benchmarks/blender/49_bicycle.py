"""
Prompt: "Create a bicycle with frame, two spoked wheels, handlebars, seat, pedals and a chain ring."

Coordinates: X forward, Z up, units in metres.
"""
import bpy
from math import pi, cos, sin, radians
from mathutils import Vector

WHEEL_R = 0.34
REAR = Vector((-0.5, 0, WHEEL_R))
FRONT = Vector((0.55, 0, WHEEL_R))
BB = Vector((-0.07, 0, 0.28))            # bottom bracket
SEAT_TOP = Vector((-0.2, 0, 0.85))
HEAD_TOP = Vector((0.36, 0, 0.88))
HEAD_BOT = Vector((0.41, 0, 0.72))


def tube(start, end, radius, name, material):
    start, end = Vector(start), Vector(end)
    axis = end - start
    bpy.ops.mesh.primitive_cylinder_add(vertices=20, radius=radius, depth=axis.length)
    obj = bpy.context.object
    obj.name = name
    obj.location = start.lerp(end, 0.5)
    obj.rotation_mode = 'QUATERNION'
    obj.rotation_quaternion = Vector((0, 0, 1)).rotation_difference(axis)
    obj.data.materials.append(material)
    return obj


def wheel(center, rubber, metal, spokes=20):
    bpy.ops.mesh.primitive_torus_add(location=center, rotation=(pi / 2, 0, 0), major_radius=WHEEL_R - 0.02,
                                     minor_radius=0.02, major_segments=64, minor_segments=12)
    bpy.context.object.name = "Tire"
    bpy.context.object.data.materials.append(rubber)
    bpy.ops.mesh.primitive_torus_add(location=center, rotation=(pi / 2, 0, 0), major_radius=WHEEL_R - 0.045,
                                     minor_radius=0.01, major_segments=64, minor_segments=8)
    bpy.context.object.name = "Rim"
    bpy.context.object.data.materials.append(metal)
    tube(center + Vector((0, -0.05, 0)), center + Vector((0, 0.05, 0)), 0.02, "Hub", metal)
    for i in range(spokes):
        a = 2 * pi * i / spokes
        side = 0.03 if i % 2 else -0.03
        tip = center + Vector((cos(a), 0, sin(a))) * (WHEEL_R - 0.045)
        tube(center + Vector((0, side, 0)), tip, 0.0015, "Spoke", metal)


def mat(name, rgb, metallic=0.0, roughness=0.5):
    m = bpy.data.materials.new(name)
    m.use_nodes = True
    n = m.node_tree.nodes["Principled BSDF"]
    n.inputs["Base Color"].default_value = [*rgb, 1.0]
    n.inputs["Metallic"].default_value = metallic
    n.inputs["Roughness"].default_value = roughness
    return m


bpy.ops.object.select_all(action='SELECT')
bpy.ops.object.delete()

paint = mat("TealPaint", (0.0, 0.35, 0.4), 0.3, 0.25)
chrome = mat("Chrome", (0.8, 0.8, 0.8), 1.0, 0.1)
rubber = mat("Rubber", (0.02, 0.02, 0.02), 0.0, 0.9)

wheel(REAR, rubber, chrome)
wheel(FRONT, rubber, chrome)

tube(BB, SEAT_TOP, 0.018, "SeatTube", paint)
tube(SEAT_TOP, HEAD_TOP - Vector((0, 0, 0.03)), 0.017, "TopTube", paint)
tube(BB, HEAD_BOT, 0.02, "DownTube", paint)
tube(HEAD_BOT, HEAD_TOP, 0.022, "HeadTube", paint)
for s in (-0.05, 0.05):
    off = Vector((0, s, 0))
    tube(REAR + off, BB + off * 0.5, 0.01, "ChainStay", paint)
    tube(REAR + off, SEAT_TOP - Vector((0, 0, 0.05)), 0.009, "SeatStay", paint)
    tube(FRONT + off, HEAD_BOT, 0.012, "Fork", paint)

# cockpit
stem_top = HEAD_TOP + Vector((0.03, 0, 0.08))
tube(HEAD_TOP, stem_top, 0.012, "Stem", chrome)
tube(stem_top + Vector((0, -0.28, 0)), stem_top + Vector((0, 0.28, 0)), 0.012, "Handlebar", chrome)
for s in (-1, 1):
    tube(stem_top + Vector((0, s * 0.2, 0)), stem_top + Vector((0, s * 0.3, 0)), 0.016, "Grip", rubber)

# saddle
tube(SEAT_TOP, SEAT_TOP + Vector((-0.02, 0, 0.1)), 0.013, "SeatPost", chrome)
bpy.ops.mesh.primitive_uv_sphere_add(radius=0.13, location=SEAT_TOP + Vector((-0.02, 0, 0.12)))
saddle = bpy.context.object
saddle.name = "Saddle"
saddle.scale = (1.0, 0.5, 0.25)
saddle.data.materials.append(rubber)

# drivetrain
tube(BB + Vector((0, -0.065, 0)), BB + Vector((0, -0.06, 0)), 0.1, "ChainRing", chrome)
for s in (-1, 1):
    end = BB + Vector((s * 0.12, s * 0.09, -s * 0.12))
    tube(BB + Vector((0, s * 0.08, 0)), end, 0.009, "Crank", chrome)
    bpy.ops.mesh.primitive_cube_add(size=1, location=end + Vector((0, s * 0.05, 0)))
    bpy.context.object.name = "Pedal"
    bpy.context.object.dimensions = (0.08, 0.09, 0.02)

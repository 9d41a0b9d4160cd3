"""Wall clock showing 10:10 with hour marks, minute ticks; second hand animated for 60 seconds."""
import bpy
import math

HOUR, MINUTE = 10, 10
R = 1.0

def ensure_clean():
    bpy.ops.object.select_all(action='SELECT')
    bpy.ops.object.delete()

def simple_material(name, rgb):
    material = bpy.data.materials.new(name)
    material.diffuse_color = rgb + (1.0,)
    return material

def polar(radius, degrees_clockwise_from_12):
    a = math.radians(90 - degrees_clockwise_from_12)
    return radius * math.cos(a), radius * math.sin(a)

def add_tick(deg, length, width, mat):
    x, y = polar(R * 0.92 - length / 2, deg)
    bpy.ops.mesh.primitive_cube_add(size=1, location=(x, y, 0.06), rotation=(0, 0, math.radians(-deg)))
    t = bpy.context.object
    t.name = f"Tick_{int(deg):03d}"
    t.scale = (width, length, 0.02)
    t.data.materials.append(mat)
    return t

def add_hand(name, length, width, z, deg, mat):
    """A hand whose origin sits at the clock centre."""
    tail = 0.12
    verts = [(-width/2, -tail, 0), (width/2, -tail, 0), (width/4, length, 0), (-width/4, length, 0)]
    verts += [(x, y, 0.02) for x, y, _ in verts]
    faces = [(3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    me = bpy.data.meshes.new(name)
    me.from_pydata(verts, [], faces)
    ob = bpy.data.objects.new(name, me)
    ob.location.z = z
    ob.rotation_euler.z = math.radians(-deg)
    bpy.context.collection.objects.link(ob)
    me.materials.append(mat)
    return ob

ensure_clean()
black = simple_material("Black", (0.02, 0.02, 0.02))
white = simple_material("Face", (0.96, 0.95, 0.9))
red = simple_material("SecondRed", (0.8, 0.05, 0.05))

bpy.ops.mesh.primitive_cylinder_add(vertices=96, radius=R, depth=0.1)
bpy.context.object.name = "Face"
bpy.context.object.data.materials.append(white)
bpy.ops.mesh.primitive_torus_add(major_radius=R, minor_radius=0.06, major_segments=96, minor_segments=12)
bpy.context.object.name = "Bezel"
bpy.context.object.data.materials.append(black)

for m in range(60):
    if m % 5 == 0:
        add_tick(m * 6, 0.14, 0.04, black)
    else:
        add_tick(m * 6, 0.05, 0.012, black)

add_hand("HourHand", 0.5, 0.07, 0.07, (HOUR % 12) * 30 + MINUTE * 0.5, black)
add_hand("MinuteHand", 0.78, 0.05, 0.1, MINUTE * 6, black)
second = add_hand("SecondHand", 0.85, 0.02, 0.13, 0, red)
bpy.ops.mesh.primitive_cylinder_add(radius=0.05, depth=0.12, location=(0, 0, 0.1))
bpy.context.object.data.materials.append(red)

for s in range(0, 61, 15):
    second.rotation_euler.z = math.radians(-6 * s)
    second.keyframe_insert("rotation_euler", frame=1 + s * 24)
bpy.context.scene.frame_end = 1 + 60 * 24

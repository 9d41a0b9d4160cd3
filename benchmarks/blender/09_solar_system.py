# A solar system: sun, eight planets with keyframed orbits, Saturn's ring, and the Moon
import bpy
import math

# name, radius, orbit distance, period (frames), color
PLANETS = [
    ("Mercury", 0.18, 3.0, 60, (0.5, 0.45, 0.4, 1)),
    ("Venus", 0.3, 4.2, 110, (0.85, 0.65, 0.3, 1)),
    ("Earth", 0.32, 5.6, 160, (0.1, 0.3, 0.8, 1)),
    ("Mars", 0.24, 7.0, 220, (0.75, 0.25, 0.1, 1)),
    ("Jupiter", 0.9, 9.8, 400, (0.75, 0.6, 0.45, 1)),
    ("Saturn", 0.75, 12.8, 600, (0.85, 0.75, 0.5, 1)),
    ("Uranus", 0.5, 15.4, 800, (0.5, 0.8, 0.85, 1)),
    ("Neptune", 0.48, 17.6, 1000, (0.2, 0.3, 0.9, 1)),
]

bpy.ops.object.select_all(action='SELECT')
bpy.ops.object.delete()

world = bpy.context.scene.world
world.use_nodes = True
bg = world.node_tree.nodes.get("Background")
if bg:
    bg.inputs[0].default_value = (0, 0, 0.005, 1)
    bg.inputs[1].default_value = 0.2

def planet_mat(name, color):
    m = bpy.data.materials.new(name + "_mat")
    m.use_nodes = True
    m.node_tree.nodes["Principled BSDF"].inputs['Base Color'].default_value = color
    return m

# Sun
bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, radius=1.8)
sun = bpy.context.object
sun.name = "Sun"
bpy.ops.object.shade_smooth()
sm = planet_mat("Sun", (1, 0.7, 0.1, 1))
p = sm.node_tree.nodes["Principled BSDF"]
for key in ("Emission Color", "Emission"):
    if key in p.inputs:
        p.inputs[key].default_value = (1, 0.6, 0.1, 1)
        break
p.inputs["Emission Strength"].default_value = 5
sun.data.materials.append(sm)

for name, radius, dist, period, color in PLANETS:
    bpy.ops.object.empty_add(type='PLAIN_AXES', location=(0, 0, 0))
    pivot = bpy.context.object
    pivot.name = f"{name}_Orbit"

    bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16, radius=radius, location=(dist, 0, 0))
    planet = bpy.context.object
    planet.name = name
    planet.parent = pivot
    planet.data.materials.append(planet_mat(name, color))
    bpy.ops.object.shade_smooth()

    # thin torus for the path
    bpy.ops.mesh.primitive_torus_add(major_radius=dist, minor_radius=0.01, major_segments=96, minor_segments=4)
    bpy.context.object.name = f"{name}_Path"

    pivot.rotation_euler = (0, 0, 0)
    pivot.keyframe_insert(data_path="rotation_euler", frame=1)
    pivot.rotation_euler = (0, 0, 2 * math.pi)
    pivot.keyframe_insert(data_path="rotation_euler", frame=1 + period)

    if name == "Saturn":
        bpy.ops.mesh.primitive_torus_add(location=(dist, 0, 0), rotation=(math.radians(20), 0, 0),
                                         major_radius=1.3, minor_radius=0.25)
        ring = bpy.context.object
        ring.name = "Saturn_Ring"
        ring.scale = (1, 1, 0.05)
        ring.parent = pivot
    elif name == "Earth":
        bpy.ops.mesh.primitive_uv_sphere_add(radius=0.09, location=(0.6, 0, 0))
        moon = bpy.context.object
        moon.name = "Moon"
        moon.parent = planet

bpy.context.scene.frame_start = 1
bpy.context.scene.frame_end = 1000

"""
Prompt: Create a desk lamp with an emissive bulb.
"""
import bpy
import math
from mathutils import Vector

# Clear existing mesh objects
for obj in list(bpy.data.objects):
    bpy.data.objects.remove(obj, do_unlink=True)


def make_metal(name, color):
    m = bpy.data.materials.new(name)
    m.use_nodes = True
    p = m.node_tree.nodes.get("Principled BSDF")
    if p:
        p.inputs["Base Color"].default_value = (*color, 1.0)
        p.inputs["Metallic"].default_value = 0.9
        p.inputs["Roughness"].default_value = 0.25
    return m


def make_emissive(name, color, strength):
    m = bpy.data.materials.new(name)
    m.use_nodes = True
    p = m.node_tree.nodes.get("Principled BSDF")
    # Blender 4.0+ renamed "Emission" to "Emission Color"
    key = "Emission Color" if "Emission Color" in p.inputs else "Emission"
    p.inputs[key].default_value = (*color, 1.0)
    p.inputs["Emission Strength"].default_value = strength
    return m


def cylinder_between(p1, p2, radius, name):
    """Create a cylinder between two points."""
    p1, p2 = Vector(p1), Vector(p2)
    direction = p2 - p1
    mid = (p1 + p2) / 2
    bpy.ops.mesh.primitive_cylinder_add(radius=radius, depth=direction.length, location=mid, vertices=24)
    cyl = bpy.context.active_object
    cyl.name = name
    cyl.rotation_mode = 'QUATERNION'
    cyl.rotation_quaternion = direction.to_track_quat('Z', 'Y')
    return cyl


black = make_metal("BlackMetal", (0.02, 0.02, 0.025))
brass = make_metal("Brass", (0.8, 0.6, 0.2))
glow = make_emissive("BulbGlow", (1.0, 0.85, 0.5), 12.0)

# --- Base ---
bpy.ops.mesh.primitive_cylinder_add(radius=0.5, depth=0.08, location=(0, 0, 0.04), vertices=64)
base = bpy.context.active_object
base.name = "Base"
base.data.materials.append(black)
bevel = base.modifiers.new(name="Bevel", type='BEVEL')
bevel.width = 0.02
bevel.segments = 3

# --- Arms ---
A = (0, 0, 0.08)
B = (-0.35, 0, 0.95)
C = (0.45, 0, 1.55)
for a, b, nm in ((A, B, "LowerArm"), (B, C, "UpperArm")):
    arm = cylinder_between(a, b, 0.03, nm)
    arm.data.materials.append(brass)

# --- Joints ---
for i, p in enumerate((A, B, C)):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12, radius=0.055, location=p)
    j = bpy.context.active_object
    j.name = f"Joint_{i}"
    j.data.materials.append(black)
    bpy.ops.object.shade_smooth()

# --- Shade ---
bpy.ops.mesh.primitive_cone_add(radius1=0.3, radius2=0.1, depth=0.35, location=(0.55, 0, 1.42),
                                rotation=(0, math.radians(-30), 0), end_fill_type='NOTHING')
shade = bpy.context.active_object
shade.name = "Shade"
sol = shade.modifiers.new("Solidify", 'SOLIDIFY')
sol.thickness = 0.01
shade.data.materials.append(black)

# --- Bulb ---
bpy.ops.mesh.primitive_uv_sphere_add(radius=0.09, location=(0.6, 0, 1.33))
bulb = bpy.context.active_object
bulb.name = "Bulb"
bulb.data.materials.append(glow)
bpy.ops.object.shade_smooth()

light_data = bpy.data.lights.new(name="BulbLight", type='POINT')
light_data.energy = 40
light_data.color = (1.0, 0.85, 0.6)
light_obj = bpy.data.objects.new("BulbLight", light_data)
light_obj.location = (0.62, 0, 1.25)
bpy.context.scene.collection.objects.link(light_obj)

"""Create an extruded 3D text logo that says "HELLO" with gold material, standing on a podium."""
import bpy
from math import radians

bpy.ops.object.select_all(action='SELECT')
bpy.ops.object.delete()

# Text
bpy.ops.object.text_add(location=(0, 0, 0.6), rotation=(radians(90), 0, 0))
txt = bpy.context.object
txt.data.body = "HELLO"
txt.data.extrude = 0.1
txt.data.bevel_depth = 0.015
txt.data.bevel_resolution = 3
txt.data.align_x = 'CENTER'
txt.data.size = 1.2

gold = bpy.data.materials.new("Gold")
gold.use_nodes = True
b = gold.node_tree.nodes.get("Principled BSDF")
b.inputs["Base Color"].default_value = (1.0, 0.77, 0.34, 1)
b.inputs["Metallic"].default_value = 1
b.inputs["Roughness"].default_value = 0.2
txt.data.materials.append(gold)

# second line as another font curve
curve = bpy.data.curves.new(type="FONT", name="SubtitleCurve")
curve.body = "est. 2025"
curve.size = 0.25
curve.align_x = 'CENTER'
sub = bpy.data.objects.new("Subtitle", curve)
sub.location = (0, -0.81, 0.2)
sub.rotation_euler = (radians(90), 0, 0)
bpy.context.scene.collection.objects.link(sub)

# Podium
bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 0, 0.25))
podium = bpy.context.object
podium.name = "Podium"
podium.dimensions = (5, 1.6, 0.5)
bpy.ops.object.transform_apply(location=False, rotation=False, scale=True)
bev = podium.modifiers.new("Bevel", 'BEVEL')
bev.width = 0.06
bev.segments = 4
bev.limit_method = 'ANGLE'

bpy.ops.object.light_add(type='AREA', location=(3, -4, 5), rotation=(radians(45), 0, radians(35)))
bpy.context.object.data.energy = 600
bpy.context.object.data.size = 3
bpy.ops.object.camera_add(location=(0, -8, 2), rotation=(radians(82), 0, 0))
bpy.context.scene.camera = bpy.context.object

# Create a snowman with a hat, carrot nose, coal eyes and stick arms
import bpy
import math

bpy.ops.object.select_all(action='SELECT')
bpy.ops.object.delete(use_global=False)

# Materials
snow = bpy.data.materials.new(name="Snow")
snow.use_nodes = True
snow.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.95, 0.97, 1.0, 1.0)
if "Subsurface Weight" in snow.node_tree.nodes["Principled BSDF"].inputs:
    snow.node_tree.nodes["Principled BSDF"].inputs["Subsurface Weight"].default_value = 0.2

coal = bpy.data.materials.new(name="Coal")
coal.use_nodes = True
coal.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.01, 0.01, 0.01, 1.0)

carrot = bpy.data.materials.new(name="Carrot")
carrot.use_nodes = True
carrot.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (1.0, 0.4, 0.0, 1.0)

stick = bpy.data.materials.new(name="Stick")
stick.use_nodes = True
stick.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.15, 0.08, 0.03, 1.0)

# Body
bpy.ops.mesh.primitive_uv_sphere_add(radius=1.0, location=(0, 0, 1.0))
bottom = bpy.context.active_object
bottom.name = "Bottom"
bottom.data.materials.append(snow)
bpy.ops.object.shade_smooth()

bpy.ops.mesh.primitive_uv_sphere_add(radius=0.7, location=(0, 0, 2.4))
middle = bpy.context.active_object
middle.name = "Middle"
middle.data.materials.append(snow)
bpy.ops.object.shade_smooth()

bpy.ops.mesh.primitive_uv_sphere_add(radius=0.5, location=(0, 0, 3.4))
head = bpy.context.active_object
head.name = "Head"
head.data.materials.append(snow)
bpy.ops.object.shade_smooth()

# Eyes
for x in [-0.17, 0.17]:
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.06, location=(x, -0.45, 3.52))
    eye = bpy.context.active_object
    eye.data.materials.append(coal)

# Nose
bpy.ops.mesh.primitive_cone_add(radius1=0.09, radius2=0.0, depth=0.5, location=(0, -0.7, 3.38), rotation=(math.radians(90), 0, 0))
nose = bpy.context.active_object
nose.name = "Nose"
nose.data.materials.append(carrot)

# Buttons
for i in range(3):
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.06, location=(0, -0.68 + abs(i - 1) * 0.05, 2.15 + i * 0.25))
    bpy.context.active_object.data.materials.append(coal)

# Hat
bpy.ops.mesh.primitive_cylinder_add(radius=0.55, depth=0.06, location=(0, 0, 3.78))
brim = bpy.context.active_object
brim.data.materials.append(coal)
bpy.ops.mesh.primitive_cylinder_add(radius=0.36, depth=0.6, location=(0, 0, 4.1))
top = bpy.context.active_object
top.data.materials.append(coal)

# Arms
for side in (-1, 1):
    bpy.ops.mesh.primitive_cylinder_add(radius=0.035, depth=1.2, location=(side * 1.1, 0, 2.7), rotation=(0, side * math.radians(60), 0))
    arm = bpy.context.active_object
    arm.name = "Arm_R" if side > 0 else "Arm_L"
    arm.data.materials.append(stick)

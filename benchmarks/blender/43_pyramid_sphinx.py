# Three Giza pyramids with stepped stone courses in the desert
import bpy
import math

bpy.ops.object.select_all(action='SELECT')
bpy.ops.object.delete(use_global=False)

sand = bpy.data.materials.new(name="Sand")
sand.use_nodes = True
sand.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.76, 0.6, 0.38, 1.0)
sand.node_tree.nodes["Principled BSDF"].inputs["Roughness"].default_value = 1.0

stone = bpy.data.materials.new(name="Limestone")
stone.use_nodes = True
stone.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.7, 0.58, 0.4, 1.0)

bpy.ops.mesh.primitive_plane_add(size=200, location=(0, 0, 0))
desert = bpy.context.active_object
desert.name = "Desert"
desert.data.materials.append(sand)

def create_pyramid(name, x, y, base, height, courses=12):
    step_height = height / courses
    for i in range(courses):
        size = base * (1 - i / courses)
        bpy.ops.mesh.primitive_cube_add(size=1, location=(x, y, step_height * (i + 0.5)))
        block = bpy.context.active_object
        block.name = f"{name}_Course_{i + 1}"
        block.scale = (size, size, step_height)
        block.data.materials.append(stone)

create_pyramid("Khufu", -25, 20, 23, 14.6, 16)
create_pyramid("Khafre", 0, 0, 21.5, 14.3, 15)
create_pyramid("Menkaure", 22, -18, 10.5, 6.5, 8)

# smooth capstone on Khafre: a 4-sided cone
bpy.ops.mesh.primitive_cone_add(vertices=4, radius1=3, radius2=0, depth=2.2, location=(0, 0, 14.0), rotation=(0, 0, math.radians(45)))
cap = bpy.context.active_object
cap.name = "Capstone"
cap.data.materials.append(sand)

# Sun
bpy.ops.object.light_add(type='SUN', location=(50, -50, 80))
sun = bpy.context.active_object
sun.data.energy = 5
sun.data.angle = math.radians(0.5)
sun.rotation_euler = (math.radians(45), math.radians(15), 0)

# Sky
world = bpy.context.scene.world or bpy.data.worlds.new("World")
bpy.context.scene.world = world
world.use_nodes = True
world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.4, 0.6, 0.95, 1.0)
world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.8

# Camera
bpy.ops.object.camera_add(location=(60, -70, 25))
cam = bpy.context.active_object
cam.rotation_euler = (math.radians(75), 0, math.radians(40))
bpy.context.scene.camera = cam

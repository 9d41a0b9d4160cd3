# windmill with rotating blades (animated, driver-free)
import bpy, math

# Clean scene
if bpy.context.mode != 'OBJECT':
    bpy.ops.object.mode_set(mode='OBJECT')
bpy.ops.object.select_all(action='SELECT')
bpy.ops.object.delete(use_global=False)

def assign(obj, name, rgba):
    mat = bpy.data.materials.get(name)
    if not mat:
        mat = bpy.data.materials.new(name=name)
        mat.use_nodes = True
        mat.node_tree.nodes["Principled BSDF"].inputs[0].default_value = rgba
    if obj.data.materials:
        obj.data.materials[0] = mat
    else:
        obj.data.materials.append(mat)

# Tower (octagonal, tapered)
bpy.ops.mesh.primitive_cone_add(vertices=8, radius1=2, radius2=1.3, depth=6, location=(0, 0, 3))
tower = bpy.context.object
tower.name = 'Tower'
assign(tower, 'Plaster', (0.85, 0.82, 0.75, 1))

# Cap
bpy.ops.mesh.primitive_uv_sphere_add(radius=1.4, location=(0, 0, 6))
cap = bpy.context.object
cap.scale[2] = 0.8
assign(cap, 'Thatch', (0.3, 0.2, 0.08, 1))

# Axle
bpy.ops.mesh.primitive_cylinder_add(radius=0.15, depth=1.2, location=(0, -1.6, 6.3), rotation=(math.pi/2, 0, 0))
axle = bpy.context.object
assign(axle, 'DarkWood', (0.15, 0.08, 0.03, 1))

# Rotor pivot
bpy.ops.object.empty_add(location=(0, -2.2, 6.3))
rotor = bpy.context.object
rotor.name = 'Rotor'

for i in range(4):
    ang = i * math.pi / 2
    # spar
    bpy.ops.mesh.primitive_cube_add(size=1, location=(1.75*math.sin(ang), 0, 1.75*math.cos(ang)), rotation=(0, ang, 0))
    spar = bpy.context.object
    spar.scale = (0.1, 0.1, 3.5)
    spar.parent = rotor
    assign(spar, 'DarkWood', (0.15, 0.08, 0.03, 1))
    # sail: a lattice frame
    for k in range(6):
        d = 1.0 + k * 0.45
        bpy.ops.mesh.primitive_cube_add(size=1, location=(d*math.sin(ang) + 0.35*math.cos(ang), 0, d*math.cos(ang) - 0.35*math.sin(ang)), rotation=(0, ang, 0))
        slat = bpy.context.object
        slat.scale = (0.7, 0.04, 0.06)
        slat.parent = rotor
        assign(slat, 'DarkWood', (0.15, 0.08, 0.03, 1))
    bpy.ops.mesh.primitive_plane_add(size=1, location=(2.1*math.sin(ang) + 0.35*math.cos(ang), 0.03, 2.1*math.cos(ang) - 0.35*math.sin(ang)), rotation=(math.pi/2, ang, 0))
    sail = bpy.context.object
    sail.scale = (0.7, 2.4, 1)
    sail.parent = rotor
    assign(sail, 'Canvas', (0.9, 0.87, 0.8, 1))

# Door
bpy.ops.mesh.primitive_cube_add(size=1, location=(0, -1.85, 0.9))
door = bpy.context.object
door.scale = (0.8, 0.2, 1.8)
assign(door, 'Door', (0.1, 0.2, 0.35, 1))

# Animation
rotor.rotation_euler = (0, 0, 0)
rotor.keyframe_insert(data_path='rotation_euler', frame=1)
rotor.rotation_euler[1] = math.radians(360)
rotor.keyframe_insert(data_path='rotation_euler', frame=121)

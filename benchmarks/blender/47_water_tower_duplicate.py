# water tower; legs created with bpy.ops.object.duplicate, then everything joined
import bpy
import math

def deselect():
    bpy.ops.object.select_all(action='DESELECT')

bpy.ops.object.select_all(action='SELECT')
bpy.ops.object.delete()

# first leg
bpy.ops.mesh.primitive_cylinder_add(vertices=12, radius=0.12, depth=5, location=(1.4, 1.4, 2.5))
leg = bpy.context.active_object
leg.name = "Leg"
legs = [leg]

# duplicate to the other corners
for x, y in ((-1.4, 1.4), (-1.4, -1.4), (1.4, -1.4)):
    deselect()
    leg.select_set(True)
    bpy.context.view_layer.objects.active = leg
    bpy.ops.object.duplicate(linked=False)
    new_leg = bpy.context.active_object
    new_leg.location.x = x
    new_leg.location.y = y
    legs.append(new_leg)

# cross braces
braces = []
for z in (1.2, 3.2):
    for k in range(4):
        a = k * math.pi / 2
        for tilt in (1, -1):
            bpy.ops.mesh.primitive_cylinder_add(
                vertices=8, radius=0.04, depth=math.hypot(2.8, 1.6),
                location=(1.4 * math.cos(a), 1.4 * math.sin(a), z),
                rotation=(tilt * math.atan2(2.8, 1.6), 0, a))
            braces.append(bpy.context.active_object)

# platform, tank and roof
bpy.ops.mesh.primitive_cylinder_add(radius=2.2, depth=0.15, location=(0, 0, 5.07))
platform = bpy.context.active_object
bpy.ops.mesh.primitive_cylinder_add(vertices=24, radius=1.8, depth=2.4, location=(0, 0, 6.35))
tank = bpy.context.active_object
bpy.ops.mesh.primitive_cone_add(vertices=24, radius1=2.0, radius2=0.0, depth=1.1, location=(0, 0, 8.1))
roof = bpy.context.active_object

# hoops around the tank
hoops = []
for i in range(4):
    bpy.ops.mesh.primitive_torus_add(major_radius=1.81, minor_radius=0.03, location=(0, 0, 5.5 + i * 0.55))
    hoops.append(bpy.context.active_object)

def assign(objs, name, rgba):
    m = bpy.data.materials.new(name)
    m.diffuse_color = rgba
    for o in objs:
        o.data.materials.clear()
        o.data.materials.append(m)

assign(legs + braces + [platform], "Timber", (0.28, 0.17, 0.09, 1))
assign([tank], "Planks", (0.45, 0.28, 0.15, 1))
assign([roof] + hoops, "Tin", (0.4, 0.42, 0.43, 1))

# join
deselect()
for o in legs + braces + [platform, tank, roof] + hoops:
    o.select_set(True)
bpy.context.view_layer.objects.active = tank
bpy.ops.object.join()
tank.name = "WaterTower"

# a second one, linked, farther away and smaller
bpy.ops.object.duplicate(linked=True)
second = bpy.context.active_object
second.location.x += 9
second.rotation_euler.z = math.radians(30)
second.scale = (0.7, 0.7, 0.7)

"""Create a wooden dining table with four chairs."""
import bpy
import math


def clear_scene():
    bpy.ops.object.select_all(action='SELECT')
    bpy.ops.object.delete(use_global=False)


def create_material(name, color, roughness=0.5):
    mat = bpy.data.materials.new(name=name)
    mat.use_nodes = True
    bsdf = mat.node_tree.nodes["Principled BSDF"]
    bsdf.inputs["Base Color"].default_value = color
    bsdf.inputs["Roughness"].default_value = roughness
    return mat


def create_box(name, location, dimensions, material):
    bpy.ops.mesh.primitive_cube_add(size=1, location=location)
    obj = bpy.context.active_object
    obj.name = name
    obj.scale = dimensions
    bpy.ops.object.transform_apply(location=False, rotation=False, scale=True)
    obj.data.materials.append(material)
    return obj


def create_table(material, length=1.8, width=0.9, height=0.75, thickness=0.05):
    parts = [create_box("TableTop", (0, 0, height - thickness / 2), (length, width, thickness), material)]
    leg = 0.07
    for sx in (-1, 1):
        for sy in (-1, 1):
            x = sx * (length / 2 - leg)
            y = sy * (width / 2 - leg)
            parts.append(create_box("TableLeg", (x, y, (height - thickness) / 2), (leg, leg, height - thickness), material))
    bpy.ops.object.select_all(action='DESELECT')
    for p in parts:
        p.select_set(True)
    bpy.context.view_layer.objects.active = parts[0]
    bpy.ops.object.join()
    table = bpy.context.active_object
    table.name = "DiningTable"
    return table


def create_chair(name, location, rotation_z, material, cushion_material):
    chair = bpy.data.objects.new(name, None)
    bpy.context.collection.objects.link(chair)
    seat_h = 0.45
    pieces = [
        create_box(name + "_Seat", (0, 0, seat_h), (0.42, 0.42, 0.04), material),
        create_box(name + "_Cushion", (0, 0, seat_h + 0.035), (0.38, 0.38, 0.03), cushion_material),
        create_box(name + "_Back", (0, -0.2, seat_h + 0.28), (0.42, 0.03, 0.45), material),
    ]
    for i, (dx, dy) in enumerate([(-1, -1), (1, -1), (1, 1), (-1, 1)]):
        pieces.append(create_box(f"{name}_Leg{i}", (dx * 0.18, dy * 0.18, seat_h / 2), (0.04, 0.04, seat_h), material))
    for piece in pieces:
        piece.parent = chair
    chair.location = location
    chair.rotation_euler = (0, 0, rotation_z)
    return chair


clear_scene()
wood = create_material("OakWood", (0.42, 0.23, 0.1, 1.0), 0.6)
cushion = create_material("Cushion", (0.6, 0.1, 0.1, 1.0), 0.9)

create_table(wood)
placements = [
    ((-0.4, -0.7, 0), 0),
    ((0.4, -0.7, 0), 0),
    ((-0.4, 0.7, 0), math.pi),
    ((0.4, 0.7, 0), math.pi),
]
for idx, (loc, rot) in enumerate(placements, start=1):
    create_chair(f"Chair_{idx}", loc, rot, wood, cushion)

bpy.ops.object.light_add(type='AREA', location=(0, 0, 3))
bpy.context.object.data.energy = 150
bpy.ops.object.camera_add(location=(3, -3, 2.2), rotation=(math.radians(65), 0, math.radians(45)))
bpy.context.scene.camera = bpy.context.object

"""Lighthouse: striped tower, gallery with railing, lantern room, rotating spotlight, rocky island."""
import bpy
import math
import random

random.seed(1234)


def delete_default_objects():
    for name in ["Cube", "Camera", "Light"]:
        if name in bpy.data.objects:
            bpy.data.objects.remove(bpy.data.objects[name], do_unlink=True)


def create_principled(name: str, base=(0.8, 0.8, 0.8, 1.0), **kwargs):
    mat = bpy.data.materials.new(name)
    mat.use_nodes = True
    nodes = mat.node_tree.nodes
    links = mat.node_tree.links
    nodes.clear()
    out = nodes.new(type="ShaderNodeOutputMaterial")
    out.location = (300, 0)
    bsdf = nodes.new(type="ShaderNodeBsdfPrincipled")
    bsdf.location = (0, 0)
    links.new(bsdf.outputs["BSDF"], out.inputs["Surface"])
    bsdf.inputs["Base Color"].default_value = base
    for k, v in kwargs.items():
        sock = bsdf.inputs.get(k.replace("_", " ").title())
        if sock is not None:
            sock.default_value = v
    return mat


def create_tower(bands=6, height=9.0, r0=1.5, r1=0.95):
    red = create_principled("TowerRed", (0.75, 0.05, 0.04, 1))
    white = create_principled("TowerWhite", (0.93, 0.93, 0.9, 1))
    bh = height / bands
    for i in range(bands):
        ra = r0 + (r1 - r0) * i / bands
        rb = r0 + (r1 - r0) * (i + 1) / bands
        bpy.ops.mesh.primitive_cone_add(vertices=48, radius1=ra, radius2=rb, depth=bh, location=(0, 0, 1 + bh * (i + 0.5)))
        seg = bpy.context.active_object
        seg.name = f"Band_{i}"
        seg.data.materials.append(red if i % 2 == 0 else white)
    return 1 + height


def create_gallery(z):
    iron = create_principled("Iron", (0.05, 0.05, 0.05, 1), metallic=0.9, roughness=0.4)
    bpy.ops.mesh.primitive_cylinder_add(vertices=48, radius=1.4, depth=0.15, location=(0, 0, z + 0.075))
    bpy.context.active_object.data.materials.append(iron)
    for i in range(16):
        a = math.tau * i / 16
        bpy.ops.mesh.primitive_cylinder_add(vertices=6, radius=0.025, depth=0.6,
                                            location=(1.3 * math.cos(a), 1.3 * math.sin(a), z + 0.45))
        bpy.context.active_object.data.materials.append(iron)
    for dz in (0.45, 0.75):
        bpy.ops.mesh.primitive_torus_add(major_radius=1.3, minor_radius=0.025, location=(0, 0, z + dz))
        bpy.context.active_object.data.materials.append(iron)


def create_lantern(z):
    glass = create_principled("LanternGlass", (0.9, 0.95, 1, 1), roughness=0.0, transmission_weight=0.95)
    roof = bpy.data.materials["TowerRed"]
    bpy.ops.mesh.primitive_cylinder_add(vertices=12, radius=0.65, depth=1.2, location=(0, 0, z + 0.75))
    bpy.context.active_object.data.materials.append(glass)
    bpy.ops.mesh.primitive_cone_add(vertices=24, radius1=0.9, depth=0.8, location=(0, 0, z + 1.75))
    bpy.context.active_object.data.materials.append(roof)
    bpy.ops.object.light_add(type='SPOT', location=(0, 0, z + 0.75), rotation=(math.pi / 2, 0, 0))
    spot = bpy.context.active_object
    spot.data.energy = 5000
    spot.data.spot_size = math.radians(25)
    for frame, turn in ((1, 0), (121, 1)):
        spot.rotation_euler.z = math.tau * turn
        spot.keyframe_insert("rotation_euler", frame=frame)


def create_island():
    rock = create_principled("Rock", (0.25, 0.23, 0.21, 1), roughness=1.0)
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, radius=4)
    island = bpy.context.active_object
    island.scale = (1, 0.85, 0.3)
    bpy.ops.object.transform_apply(location=False, rotation=False, scale=True)
    for v in island.data.vertices:
        v.co.x += random.uniform(-0.15, 0.15)
        v.co.y += random.uniform(-0.15, 0.15)
        if v.co.z < 1.0:
            v.co.z += random.uniform(-0.1, 0.1)
    island.data.materials.append(rock)


if __name__ == "__main__":
    delete_default_objects()
    create_island()
    top = create_tower()
    create_gallery(top)
    create_lantern(top)

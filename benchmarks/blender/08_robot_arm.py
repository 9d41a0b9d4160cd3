"""A 4-joint industrial robot arm with parented segments and a gripper, with a simple animation."""
from __future__ import annotations
import bpy
from dataclasses import dataclass
from math import radians
from mathutils import Vector


@dataclass
class Segment:
    name: str
    length: float
    radius: float
    angle_deg: float
    color: tuple[float, float, float, float] = (1.0, 0.45, 0.05, 1.0)


SEGMENTS = [
    Segment("Shoulder", 1.4, 0.22, 20),
    Segment("Elbow", 1.2, 0.18, 55),
    Segment("Wrist", 0.7, 0.13, 40, (0.2, 0.2, 0.22, 1.0)),
]


def get_material(name: str, color) -> bpy.types.Material:
    mat = bpy.data.materials.get(name)
    if mat is None:
        mat = bpy.data.materials.new(name)
        mat.use_nodes = True
        mat.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = color
        mat.node_tree.nodes["Principled BSDF"].inputs["Metallic"].default_value = 0.4
    return mat


def add_empty(name: str, parent=None, location=(0, 0, 0)):
    e = bpy.data.objects.new(name, None)
    e.empty_display_size = 0.2
    bpy.context.collection.objects.link(e)
    e.parent = parent
    e.location = location
    return e


def add_cyl(name, radius, depth, loc, parent, mat, rot=(0, 0, 0)):
    bpy.ops.mesh.primitive_cylinder_add(radius=radius, depth=depth, location=loc, rotation=rot, vertices=32)
    o = bpy.context.object
    o.name = name
    o.parent = parent
    o.data.materials.append(mat)
    return o


def build() -> list[bpy.types.Object]:
    dark = get_material("Dark", (0.05, 0.05, 0.06, 1))
    add_cyl("Base", 0.6, 0.25, (0, 0, 0.125), None, dark)
    joint = add_empty("J0", None, (0, 0, 0.25))
    joints = [joint]
    offset = Vector((0, 0, 0.3))
    add_cyl("Turret", 0.35, 0.3, (0, 0, 0.15), joint, dark)
    for i, seg in enumerate(SEGMENTS, 1):
        j = add_empty(f"J{i}", joints[-1], offset)
        j.rotation_euler = (0, radians(seg.angle_deg), 0)
        m = get_material(f"Paint_{seg.name}", seg.color)
        add_cyl(f"{seg.name}_hub", seg.radius * 1.3, seg.radius * 2.4, (0, 0, 0), j, dark, (radians(90), 0, 0))
        add_cyl(f"{seg.name}_link", seg.radius, seg.length, (0, 0, seg.length / 2), j, m)
        joints.append(j)
        offset = Vector((0, 0, seg.length))
    # gripper
    for s in (-1, 1):
        bpy.ops.mesh.primitive_cube_add(size=1.0, location=(0, s * 0.12, SEGMENTS[-1].length + 0.15))
        f = bpy.context.object
        f.name = "Finger_L" if s < 0 else "Finger_R"
        f.dimensions = (0.1, 0.05, 0.3)
        f.parent = joints[-1]
        f.data.materials.append(dark)
    return joints


def animate(joints):
    base = joints[0]
    for frame, deg in ((1, 0), (40, 90), (80, -45), (120, 0)):
        base.rotation_euler[2] = radians(deg)
        base.keyframe_insert(data_path="rotation_euler", index=2, frame=frame)
    bpy.context.scene.frame_end = 120


if __name__ == "__main__":
    bpy.ops.object.select_all(action='SELECT')
    bpy.ops.object.delete()
    animate(build())

"""Traffic light at an intersection cycling red, green, yellow with emission keyframes."""
from enum import Enum
import bpy
import math


class Signal(Enum):
    RED = ((1.0, 0.05, 0.02), 72)
    YELLOW = ((1.0, 0.7, 0.0), 24)
    GREEN = ((0.05, 1.0, 0.2), 72)

    @property
    def rgb(self):
        return self.value[0]

    @property
    def frames(self):
        return self.value[1]


def reset_scene():
    if bpy.context.active_object and bpy.context.active_object.mode != 'OBJECT':
        bpy.ops.object.mode_set(mode='OBJECT')
    bpy.ops.object.select_all(action='SELECT')
    bpy.ops.object.delete(use_global=False)
    for mat in bpy.data.materials:
        bpy.data.materials.remove(mat)


def paint(name, rgb, **props):
    m = bpy.data.materials.new(name)
    m.use_nodes = True
    node = m.node_tree.nodes["Principled BSDF"]
    node.inputs["Base Color"].default_value = (*rgb, 1)
    for k, v in props.items():
        node.inputs[k].default_value = v
    return m


def build_signal_head(location, rotation_z=0.0):
    bpy.ops.object.empty_add(type='CUBE', radius=0.2, location=location)
    head = bpy.context.object
    head.name = "SignalHead"
    head.rotation_euler[2] = rotation_z
    dark = paint("Housing", (0.03, 0.03, 0.03), Roughness=0.6)

    bpy.ops.mesh.primitive_cube_add(size=1.0, location=(0, 0, 0))
    box = bpy.context.object
    box.dimensions = (0.4, 0.3, 1.2)
    box.parent = head
    box.data.materials.append(dark)

    lamps = {}
    for sig, z in zip(Signal, (0.38, 0.0, -0.38)):
        bpy.ops.mesh.primitive_uv_sphere_add(radius=0.14, location=(0, -0.14, z))
        lens = bpy.context.object
        lens.name = f"Lamp_{sig.name}"
        lens.scale.y = 0.4
        lens.parent = head
        m = paint(f"Lens_{sig.name}", sig.rgb, Roughness=0.2)
        n = m.node_tree.nodes["Principled BSDF"]
        if "Emission Color" in n.inputs:
            n.inputs["Emission Color"].default_value = (*sig.rgb, 1)
        lens.data.materials.append(m)
        lamps[sig] = n
        # visor: half-open cylinder
        bpy.ops.mesh.primitive_cylinder_add(vertices=24, radius=0.16, depth=0.18, end_fill_type='NOTHING',
                                            location=(0, -0.23, z), rotation=(math.radians(90), 0, 0))
        visor = bpy.context.object
        visor.parent = head
        visor.data.materials.append(dark)
    return head, lamps


def cycle(lamps, order=(Signal.RED, Signal.GREEN, Signal.YELLOW), loops=2):
    frame = 1
    for _ in range(loops):
        for active in order:
            for sig, node in lamps.items():
                strength = node.inputs["Emission Strength"]
                strength.default_value = 8.0 if sig is active else 0.0
                strength.keyframe_insert("default_value", frame=frame)
            frame += active.frames
    bpy.context.scene.frame_end = frame


def main():
    reset_scene()
    pole_mat = paint("Pole", (0.3, 0.32, 0.3), Metallic=0.8)
    bpy.ops.mesh.primitive_cylinder_add(radius=0.08, depth=4.5, location=(0, 0, 2.25))
    bpy.context.object.data.materials.append(pole_mat)
    bpy.ops.mesh.primitive_cylinder_add(radius=0.05, depth=2.5, location=(1.2, 0, 4.4), rotation=(0, math.pi / 2, 0))
    bpy.context.object.data.materials.append(pole_mat)
    for loc in ((2.3, 0, 3.8), (0, -0.25, 3.0)):
        _, lamps = build_signal_head(loc)
        cycle(lamps)


if __name__ == "__main__":
    main()

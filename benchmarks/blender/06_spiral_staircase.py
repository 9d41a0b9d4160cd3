"""Prompt: Design a spiral staircase with a central pole, wedge-shaped steps and a handrail."""
import bpy
import math
from typing import List, Tuple

NUM_STEPS: int = 20
STEP_RISE: float = 0.18
STEP_ANGLE: float = math.radians(22.5)
INNER_R: float = 0.12
OUTER_R: float = 1.2
THICKNESS: float = 0.05


def reset() -> None:
    bpy.ops.wm.read_factory_settings(use_empty=True)


def wedge_mesh(angle: float, segments: int = 4) -> bpy.types.Mesh:
    verts: List[Tuple[float, float, float]] = []
    faces: List[Tuple[int, ...]] = []
    for z in (0.0, THICKNESS):
        for i in range(segments + 1):
            a = angle * i / segments
            verts.append((INNER_R * math.cos(a), INNER_R * math.sin(a), z))
            verts.append((OUTER_R * math.cos(a), OUTER_R * math.sin(a), z))
    off = 2 * (segments + 1)
    for i in range(segments):
        a, b, c, d = 2 * i, 2 * i + 1, 2 * i + 3, 2 * i + 2
        faces.append((d, c, b, a))
        faces.append((a + off, b + off, c + off, d + off))
        faces.append((b, c, c + off, b + off))
        faces.append((d, a, a + off, d + off))
    faces.append((0, 1, 1 + off, off))
    last = 2 * segments
    faces.append((last + 1, last, last + off, last + 1 + off))
    mesh = bpy.data.meshes.new("WedgeStep")
    mesh.from_pydata(verts, [], faces)
    mesh.validate()
    return mesh


def main() -> None:
    reset()
    col = bpy.data.collections.new("SpiralStaircase")
    bpy.context.scene.collection.children.link(col)

    wood = bpy.data.materials.new("StepWood")
    wood.diffuse_color = (0.45, 0.26, 0.12, 1.0)
    metal = bpy.data.materials.new("DarkMetal")
    metal.diffuse_color = (0.08, 0.08, 0.09, 1.0)
    metal.metallic = 1.0

    mesh = wedge_mesh(STEP_ANGLE * 1.1)
    mesh.materials.append(wood)
    for i in range(NUM_STEPS):
        step = bpy.data.objects.new(f"Step_{i:02d}", mesh)
        step.location.z = i * STEP_RISE
        step.rotation_euler.z = i * STEP_ANGLE
        col.objects.link(step)

        # baluster
        a = (i + 0.5) * STEP_ANGLE
        x, y = (OUTER_R - 0.05) * math.cos(a), (OUTER_R - 0.05) * math.sin(a)
        bpy.ops.mesh.primitive_cylinder_add(
            vertices=8, radius=0.015, depth=0.9,
            location=(x, y, i * STEP_RISE + THICKNESS + 0.45))
        bal = bpy.context.object
        bal.name = f"Baluster_{i:02d}"
        bal.data.materials.append(metal)

        # handrail piece to the next baluster
        a2 = a + STEP_ANGLE
        x2, y2 = (OUTER_R - 0.05) * math.cos(a2), (OUTER_R - 0.05) * math.sin(a2)
        if i < NUM_STEPS - 1:
            run = math.hypot(x2 - x, y2 - y)
            length = math.hypot(run, STEP_RISE)
            bpy.ops.mesh.primitive_cylinder_add(
                vertices=12, radius=0.025, depth=length,
                location=((x + x2) / 2, (y + y2) / 2, i * STEP_RISE + THICKNESS + 0.9 + STEP_RISE / 2),
                rotation=(0, math.acos(STEP_RISE / length), math.atan2(y2 - y, x2 - x)))
            bpy.context.object.data.materials.append(metal)

    total = NUM_STEPS * STEP_RISE + 1.0
    bpy.ops.mesh.primitive_cylinder_add(vertices=32, radius=INNER_R, depth=total, location=(0, 0, total / 2))
    pole = bpy.context.object
    pole.name = "CentralPole"
    pole.data.materials.append(metal)


if __name__ == "__main__":
    main()

"""
Task: playground scene with a swing set, slide, seesaw and sandbox.

Sub-tasks (planner):
  - materials library
  - swing set (A-frames, beam, 2 swings; swings animated)
  - slide with ladder
  - seesaw tilted by 12 degrees
  - sandbox with rim and sand
"""
import bpy
import math
import functools
from contextlib import contextmanager
from mathutils import Vector

D = math.radians


@functools.lru_cache(maxsize=None)
def lib(name):
    table = dict(red=(0.8, 0.08, 0.06), blue=(0.08, 0.2, 0.75), yellow=(0.95, 0.75, 0.05),
                 wood=(0.45, 0.28, 0.13), steel=(0.6, 0.62, 0.65), sand=(0.85, 0.75, 0.5), grass=(0.15, 0.4, 0.1))
    m = bpy.data.materials.new(name.capitalize())
    m.diffuse_color = (*table[name], 1.0)
    m.metallic = 0.9 if name == "steel" else 0.0
    return m


@contextmanager
def group(name, location=(0, 0, 0), rotation=(0, 0, 0)):
    """Parent every object made inside the block to a new empty."""
    before = set(bpy.context.scene.objects)
    yield
    root = bpy.data.objects.new(name, None)
    bpy.context.scene.collection.objects.link(root)
    for o in set(bpy.context.scene.objects) - before - {root}:
        if o.parent is None:
            o.parent = root
    root.location, root.rotation_euler = location, rotation


def box(center, size, mat, *, rot=(0, 0, 0), name="Box"):
    bpy.ops.mesh.primitive_cube_add(size=1, location=center, rotation=rot)
    o = bpy.context.object
    o.name, o.scale = name, size
    o.data.materials.append(lib(mat))
    return o


def pipe(a, b, mat="steel", r=0.05, name="Pipe"):
    a, b = Vector(a), Vector(b)
    bpy.ops.mesh.primitive_cylinder_add(radius=r, depth=(b - a).length, location=(a + b) * 0.5, vertices=16)
    o = bpy.context.object
    o.name = name
    o.rotation_euler = (b - a).to_track_quat('Z', 'X').to_euler()
    o.data.materials.append(lib(mat))
    return o


def swing_set():
    with group("SwingSet", (-3, 2, 0)):
        for x in (-1.6, 1.6):
            for y in (-0.8, 0.8):
                pipe((x, y, 0), (x, 0, 2.4), "red", 0.06)
        pipe((-1.8, 0, 2.4), (1.8, 0, 2.4), "red", 0.06)
        for i, x in enumerate((-0.75, 0.75)):
            bpy.ops.object.empty_add(location=(x, 0, 2.4))
            pivot = bpy.context.object
            pivot.name = f"SwingPivot{i}"
            for o in (box((0, 0, -1.9), (0.5, 0.2, 0.04), "wood", name="Seat"),
                      pipe((-0.22, 0, -1.9), (-0.22, 0, 0), r=0.012),
                      pipe((0.22, 0, -1.9), (0.22, 0, 0), r=0.012)):
                o.parent = pivot
            for f in range(1, 98, 12):
                pivot.rotation_euler.x = D(25) * math.sin(2 * math.pi * (f - 1) / 48 + i)
                pivot.keyframe_insert("rotation_euler", index=0, frame=f)


def slide():
    with group("Slide", (3, 2, 0), (0, 0, D(-30))):
        ang = math.atan2(1.8, 3.0)
        box((0, 0.6, 1.0), (0.7, math.hypot(1.8, 3.0), 0.05), "yellow", rot=(-ang, 0, 0), name="Chute")
        for s in (-0.35, 0.35):
            box((s, 0.6, 1.1), (0.05, math.hypot(1.8, 3.0), 0.2), "yellow", rot=(-ang, 0, 0), name="ChuteSide")
        box((0, -1.2, 1.9), (0.8, 0.7, 0.06), "wood", name="Landing")
        for s in (-0.3, 0.3):
            pipe((s, -2.1, 0), (s, -1.5, 1.9), "blue", 0.04)
        for k in range(1, 7):
            t = k / 7
            pipe((-0.3, -2.1 + 0.6 * t, 1.9 * t), (0.3, -2.1 + 0.6 * t, 1.9 * t), "blue", 0.025, "Rung")


def seesaw():
    with group("Seesaw", (-2.5, -2.5, 0)):
        bpy.ops.mesh.primitive_cone_add(vertices=3, radius1=0.5, radius2=0.2, depth=0.6, location=(0, 0, 0.3))
        bpy.context.object.data.materials.append(lib("blue"))
        with group("Plank", (0, 0, 0.65), (0, D(12), 0)):
            box((0, 0, 0), (3.2, 0.3, 0.06), "wood")
            for s in (-1, 1):
                pipe((s * 1.2, -0.2, 0.25), (s * 1.2, 0.2, 0.25), "red", 0.03, "Handle")
                pipe((s * 1.2, 0, 0), (s * 1.2, 0, 0.25), "red", 0.03, "HandlePost")


def sandbox(side=2.4):
    with group("Sandbox", (2.5, -2.5, 0)):
        box((0, 0, 0.08), (side, side, 0.16), "sand", name="Sand")
        for k in range(4):
            a = k * math.pi / 2
            box((side / 2 * math.cos(a), side / 2 * math.sin(a), 0.15), (0.15, side + 0.15, 0.3), "wood", rot=(0, 0, a), name="Rim")


if __name__ == "__main__":
    bpy.ops.object.select_all(action='SELECT')
    bpy.ops.object.delete()
    box((0, 0, -0.05), (12, 10, 0.1), "grass", name="Ground")
    for task in (swing_set, slide, seesaw, sandbox):
        task()

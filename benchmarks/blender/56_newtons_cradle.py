# Newton's cradle, animated
import bpy
import math
from mathutils import Vector

N, R, L, GAP = 5, 0.25, 2.0, 0.0
bpy.ops.object.select_all(action="SELECT")
bpy.ops.object.delete()

def metal(name, c, rough):
    m = bpy.data.materials.new(name)
    m.use_nodes = True
    b = m.node_tree.nodes["Principled BSDF"]
    b.inputs["Base Color"].default_value = c
    b.inputs["Metallic"].default_value = 1.0
    b.inputs["Roughness"].default_value = rough
    return m

chrome = metal("Chrome", (.9, .9, .92, 1), .05)
frame_m = metal("Frame", (.3, .3, .32, 1), .35)

def bar(a, b, r=0.05, mat=frame_m):
    a, b = Vector(a), Vector(b)
    bpy.ops.mesh.primitive_cylinder_add(radius=r, depth=(b - a).length, location=(a + b) / 2,
                                        rotation=(b - a).to_track_quat("Z", "Y").to_euler())
    bpy.context.object.data.materials.append(mat)
    return bpy.context.object

half, depth, top = N * R + 0.4, 0.8, L + R + 0.3
for y in (-depth, depth):
    bar((-half, y, top), (half, y, top))
    for x in (-half, half):
        bar((x, y, 0), (x, y, top))
for x in (-half, half):
    bar((x, -depth, 0), (x, depth, 0))
bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 0, -0.05))
plate = bpy.context.object
plate.scale = (2 * half + .2, 2 * depth + .2, .1)
plate.data.materials.append(frame_m)

pivots = []
for i in range(N):
    x = (i - (N - 1) / 2) * (2 * R + GAP)
    pivot = bpy.data.objects.new(f"Pivot{i}", None)
    pivot.location = (x, 0, top)
    bpy.context.collection.objects.link(pivot)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16, radius=R, location=(0, 0, -L))
    ball = bpy.context.object
    ball.name = f"Ball{i}"
    bpy.ops.object.shade_smooth()
    ball.data.materials.append(chrome)
    strings = [bar((0, s * depth, 0), (0, 0, -L + R * .9), 0.008) for s in (-1, 1)]
    for o in (ball, *strings):
        o.parent = pivot
    pivots.append(pivot)

AMP, HALF = math.radians(40), 20
first, last = pivots[0], pivots[-1]
frame, damping = 1, 1.0
for swing in range(6):
    mover = first if swing % 2 == 0 else last
    sign = 1 if mover is first else -1
    for dt, k in ((0, 0 if swing else 1), (HALF // 2, 1), (HALF, 0)):
        mover.rotation_euler.y = sign * AMP * damping * k
        mover.keyframe_insert("rotation_euler", index=1, frame=frame + dt)
    frame += HALF
    damping *= .93
bpy.context.scene.frame_end = frame
bpy.context.scene.frame_set(1)

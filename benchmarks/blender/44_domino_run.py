"""Dominoes along a spiral that fall one after another (keyframes, no physics)."""
import bpy
from math import cos, sin, radians, pi, hypot
from mathutils import Vector

H, W, T = 0.5, 0.25, 0.08
SPACING = 0.3

def spiral_points(spacing, turns=2.0, a=0.8, b=0.25):
    """Points spaced by approximately equal arc length."""
    theta = 0.0
    while theta < turns * 2 * pi:
        r = a + b * theta
        yield Vector((r * cos(theta), r * sin(theta), 0)), theta
        theta += spacing / hypot(r, b)

def domino_mesh():
    me = bpy.data.meshes.new("Domino")
    # origin at front bottom edge so it can tip
    xs, ys, zs = (-T, 0.0), (-W / 2, W / 2), (0.0, H)
    v = [(x, y, z) for x in xs for y in ys for z in zs]
    f = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    me.from_pydata(v, [], f)
    me.update()
    return me

bpy.ops.object.select_all(action='SELECT')
bpy.ops.object.delete()

mesh = domino_mesh()
points = list(spiral_points(SPACING))
print(f"{len(points)} dominoes")

for i, (p, theta) in enumerate(points):
    d = bpy.data.objects.new(f"Domino_{i:03d}", mesh)
    bpy.context.collection.objects.link(d)
    d.location = p
    nxt = points[i + 1][0] if i + 1 < len(points) else p + (p - points[i - 1][0])
    heading = nxt - p
    from math import atan2
    yaw = atan2(heading.y, heading.x)
    d.rotation_euler = (0, 0, yaw)
    hue = i / len(points)
    d.color = (abs(cos(pi * hue)), abs(sin(pi * hue)), 0.4, 1)

    start = 10 + i * 3
    d.keyframe_insert(data_path="rotation_euler", frame=start)
    d.rotation_euler = (0, radians(62 if i + 1 < len(points) else 90), yaw)
    d.keyframe_insert(data_path="rotation_euler", frame=start + 8)

ivory = bpy.data.materials.new("Ivory")
ivory.diffuse_color = (0.95, 0.93, 0.85, 1)
mesh.materials.append(ivory)

bpy.ops.mesh.primitive_plane_add(size=14)
bpy.context.object.name = "Table"
bpy.context.scene.frame_end = 30 + 3 * len(points)

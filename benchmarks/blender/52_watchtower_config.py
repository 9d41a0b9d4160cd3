"""Parametric wooden watchtower driven by a config dict."""
import bpy
import json
from math import atan2, hypot, pi

CONFIG = json.loads("""
{
  "height": 6.0,
  "base": 3.0,
  "top": 2.2,
  "beam": 0.18,
  "platform": {"overhang": 0.4, "thickness": 0.15},
  "railing": {"height": 0.9, "posts_per_side": 4},
  "roof": {"rise": 1.2, "clearance": 2.0},
  "colors": {"wood": [0.36, 0.22, 0.11], "roof": [0.5, 0.35, 0.15]}
}
""")

def wipe_scene():
    for ob in bpy.context.scene.objects:
        ob.select_set(True)
    bpy.ops.object.delete()

def mats(colors):
    out = {}
    for name, rgb in colors.items():
        m = bpy.data.materials.new(name.title())
        m.use_nodes = True
        m.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (*rgb, 1.0)
        out[name] = m
    return out

def beam(p, q, size, material, name="Beam"):
    from mathutils import Vector
    p, q = Vector(p), Vector(q)
    d = q - p
    bpy.ops.mesh.primitive_cube_add(size=1, location=(p + q) / 2)
    o = bpy.context.active_object
    o.name = name
    o.scale = (size, size, d.length)
    o.rotation_euler = (0, atan2(hypot(d.x, d.y), d.z), atan2(d.y, d.x))
    o.data.materials.append(material)
    return o

def slab(center, size, material, name):
    bpy.ops.mesh.primitive_cube_add(size=1, location=center)
    o = bpy.context.active_object
    o.name, o.scale = name, size
    o.data.materials.append(material)
    return o

def build(cfg):
    m = mats(cfg["colors"])
    h, b, t, s = cfg["height"], cfg["base"] / 2, cfg["top"] / 2, cfg["beam"]
    corners = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    for x, y in corners:
        beam((x * b, y * b, 0), (x * t, y * t, h), s, m["wood"], "Leg")
    # cross bracing between neighbouring legs
    levels = [0.1, 0.5, 0.9]
    at = lambda f: b + (t - b) * f
    for lo, hi in zip(levels, levels[1:]):
        for (x1, y1), (x2, y2) in zip(corners, corners[1:] + corners[:1]):
            r0, r1 = at(lo), at(hi)
            beam((x1 * r0, y1 * r0, h * lo), (x2 * r1, y2 * r1, h * hi), s * 0.5, m["wood"], "Brace")
            beam((x2 * r0, y2 * r0, h * lo), (x1 * r1, y1 * r1, h * hi), s * 0.5, m["wood"], "Brace")

    pf = cfg["platform"]
    side = cfg["top"] + 2 * pf["overhang"]
    slab((0, 0, h), (side, side, pf["thickness"]), m["wood"], "Platform")

    rl = cfg["railing"]
    e, z = side / 2 - 0.06, h + pf["thickness"] / 2
    n = rl["posts_per_side"]
    for k in range(n):
        u = -e + 2 * e * k / n
        for x, y in ((u, -e), (e, u), (-u, e), (-e, -u)):
            slab((x, y, z + rl["height"] / 2), (0.08, 0.08, rl["height"]), m["wood"], "RailPost")
    for x, y, sx, sy in ((0, -e, 2 * e, .1), (0, e, 2 * e, .1), (e, 0, .1, 2 * e), (-e, 0, .1, 2 * e)):
        slab((x, y, z + rl["height"]), (sx, sy, 0.06), m["wood"], "HandRail")

    rf = cfg["roof"]
    for x, y in corners:
        slab((x * t, y * t, z + rf["clearance"] / 2), (s, s, rf["clearance"]), m["wood"], "RoofPost")
    bpy.ops.mesh.primitive_cone_add(vertices=4, radius1=side * 0.85, radius2=0, depth=rf["rise"],
                                    location=(0, 0, z + rf["clearance"] + rf["rise"] / 2), rotation=(0, 0, pi / 4))
    bpy.context.active_object.name = "Roof"
    bpy.context.active_object.data.materials.append(m["roof"])

    # ladder
    for sx in (-0.25, 0.25):
        beam((sx, -b - 0.3, 0), (sx, -side / 2, h), 0.08, m["wood"], "LadderRail")
    for i in range(1, 16):
        f = i / 16
        slab((0, (-b - 0.3) + (b + 0.3 - side / 2) * f, h * f), (0.5, 0.05, 0.05), m["wood"], "Rung")

wipe_scene()
build(CONFIG)

"""Prompt: "a bookshelf with random books" """
import bpy, random

rng = random.Random(7)
W, D, H, T = 1.0, 0.3, 1.8, 0.02
SHELVES = 5

for o in list(bpy.context.scene.objects):
    bpy.data.objects.remove(o)

def cuboid(name, cx, cy, cz, sx, sy, sz, color):
    """Axis-aligned box from pure mesh data."""
    hx, hy, hz = sx / 2, sy / 2, sz / 2
    v = [(x, y, z) for x in (-hx, hx) for y in (-hy, hy) for z in (-hz, hz)]
    f = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    me = bpy.data.meshes.new(name)
    me.from_pydata(v, [], f)
    ob = bpy.data.objects.new(name, me)
    ob.location = cx, cy, cz
    bpy.context.scene.collection.objects.link(ob)
    m = bpy.data.materials.new(name + "Mat")
    m.diffuse_color = color
    me.materials.append(m)
    return ob

WOOD = (0.35, 0.2, 0.1, 1)
cuboid("SideL", -W/2 + T/2, 0, H/2, T, D, H, WOOD)
cuboid("SideR", W/2 - T/2, 0, H/2, T, D, H, WOOD)
cuboid("BackPanel", 0, D/2 - T/4, H/2, W, T/2, H, WOOD)
levels = [T/2 + i * (H - T) / SHELVES for i in range(SHELVES + 1)]
for i, z in enumerate(levels):
    cuboid(f"Shelf{i}", 0, 0, z, W - 2*T, D, T, WOOD)

gap = (H - T) / SHELVES - T
for lvl in levels[:-1]:
    x = -W/2 + T + 0.005
    while True:
        t = rng.uniform(0.015, 0.05)
        if x + t > W/2 - T:
            break
        if rng.random() < 0.08:      # leave a gap
            x += rng.uniform(0.03, 0.1)
            continue
        h = rng.uniform(0.6, 0.92) * gap
        d = rng.uniform(0.6, 0.8) * D
        col = (rng.random(), rng.random(), rng.random(), 1.0)
        b = cuboid("Book", x + t/2, -D/2 + d/2 + 0.01, lvl + T/2 + h/2, t, d, h, col)
        x += t + 0.001
print("books:", sum(o.name.startswith("Book") for o in bpy.data.objects))

"""Generate mountainous terrain from fractal noise with snow, rock and grass materials by height, plus a water plane."""
import bpy
import math
from mathutils import noise, Vector

SIZE = 20.0
RES = 64
HEIGHT = 3.5
OCTAVES = 5


def height(x: float, y: float) -> float:
    p = Vector((x * 0.12, y * 0.12, 0.0))
    h, amp, freq = 0.0, 1.0, 1.0
    for _ in range(OCTAVES):
        h += amp * (1.0 - abs(noise.noise(p * freq)))
        amp *= 0.45
        freq *= 2.1
    falloff = max(0.0, 1.0 - (math.hypot(x, y) / (SIZE * 0.55)) ** 2)
    return (h - 0.9) * HEIGHT * falloff


def main():
    if "Cube" in bpy.data.objects:
        bpy.data.objects.remove(bpy.data.objects["Cube"], do_unlink=True)

    coords = [-SIZE / 2 + SIZE * i / RES for i in range(RES + 1)]
    verts = [(x, y, height(x, y)) for y in coords for x in coords]
    row = RES + 1
    faces = [(j * row + i, j * row + i + 1, (j + 1) * row + i + 1, (j + 1) * row + i)
             for j in range(RES) for i in range(RES)]

    mesh = bpy.data.meshes.new("Terrain")
    mesh.from_pydata(verts, [], faces)
    terrain = bpy.data.objects.new("Terrain", mesh)
    bpy.context.collection.objects.link(terrain)

    for nm, col in (("Grass", (0.12, 0.35, 0.08, 1)), ("Rock", (0.35, 0.32, 0.3, 1)), ("Snow", (0.95, 0.95, 1, 1))):
        m = bpy.data.materials.new(nm)
        m.use_nodes = True
        m.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = col
        m.diffuse_color = col
        mesh.materials.append(m)

    mesh.update()
    for poly in mesh.polygons:
        z = poly.center.z
        slope = poly.normal.z
        if z > 2.4 and slope > 0.6:
            poly.material_index = 2
        elif slope < 0.75 or z > 1.6:
            poly.material_index = 1
        else:
            poly.material_index = 0
        poly.use_smooth = True

    bpy.ops.mesh.primitive_plane_add(size=SIZE, location=(0, 0, 0.25))
    water = bpy.context.object
    water.name = "Water"
    wm = bpy.data.materials.new("Water")
    wm.use_nodes = True
    wb = wm.node_tree.nodes["Principled BSDF"]
    wb.inputs["Base Color"].default_value = (0.02, 0.12, 0.25, 1)
    wb.inputs["Roughness"].default_value = 0.05
    water.data.materials.append(wm)


main()

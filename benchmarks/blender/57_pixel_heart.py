"""Voxel art heart from an ASCII map."""
import bpy

ART = """
..rr...rr..
.rrrr.rrrr.
rrwwrrrrrrr
rrwrrrrrrrr
rrrrrrrrrrr
.rrrrrrrrd.
..rrrrrrd..
...rrrrd...
....rrd....
.....d.....
""".strip().splitlines()

PALETTE = {"r": (0.85, 0.05, 0.1, 1), "w": (1, 0.9, 0.9, 1), "d": (0.5, 0.0, 0.05, 1)}

bpy.ops.object.select_all(action='SELECT')
bpy.ops.object.delete()

materials = {}
for ch, rgba in PALETTE.items():
    mat = bpy.data.materials.new(f"Pixel_{ch}")
    mat.diffuse_color = rgba
    mat.use_nodes = True
    mat.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = rgba
    materials[ch] = mat

rows, cols = len(ART), max(map(len, ART))
voxels = [
    (c - cols / 2 + 0.5, rows - 1 - r + 0.5, ch)
    for r, line in enumerate(ART)
    for c, ch in enumerate(line)
    if ch in PALETTE
]

for x, z, ch in voxels:
    bpy.ops.mesh.primitive_cube_add(size=0.95, location=(x, 0, z))
    cube = bpy.context.active_object
    cube.name = f"Voxel_{ch}"
    cube.data.materials.append(materials[ch])

bpy.ops.object.select_by_type(type='MESH')
bpy.context.view_layer.objects.active = bpy.context.selected_objects[0]
bpy.ops.object.join()
heart = bpy.context.active_object
heart.name = "PixelHeart"
bpy.ops.object.origin_set(type='ORIGIN_GEOMETRY', center='BOUNDS')

for frame, s in ((1, 1.0), (8, 1.15), (14, 0.97), (20, 1.08), (30, 1.0)):
    heart.scale = (s, s, s)
    heart.keyframe_insert(data_path="scale", frame=frame)
print(f"Created {len(voxels)} voxels")

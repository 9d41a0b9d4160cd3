"""Import a statue OBJ from disk if it exists, otherwise make a placeholder statue on a pedestal."""
import bpy
import os
from pathlib import Path

MODEL_PATH = Path(os.path.expanduser("~/models/statue.obj"))


def import_statue(path: Path):
    before = set(bpy.data.objects)
    if hasattr(bpy.ops.wm, "obj_import"):
        bpy.ops.wm.obj_import(filepath=str(path))
    else:
        bpy.ops.import_scene.obj(filepath=str(path))
    return [o for o in bpy.data.objects if o not in before]


def placeholder():
    objs = []
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.2, location=(0, 0, 2.55))
    objs.append(bpy.context.object)
    bpy.ops.mesh.primitive_cone_add(radius1=0.45, radius2=0.15, depth=1.2, location=(0, 0, 1.8))
    objs.append(bpy.context.object)
    for s in (-1, 1):
        bpy.ops.mesh.primitive_cylinder_add(radius=0.07, depth=0.7, location=(s * 0.3, 0, 2.1), rotation=(0, s * -0.5, 0))
        objs.append(bpy.context.object)
    return objs


def pedestal():
    for i, (s, h, z) in enumerate([(1.4, 0.2, 0.1), (1.2, 0.8, 0.6), (1.35, 0.2, 1.1)]):
        bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 0, z))
        o = bpy.context.object
        o.name = f"Pedestal_{i}"
        o.dimensions = (s, s, h)


bpy.ops.object.select_all(action='SELECT')
bpy.ops.object.delete()
pedestal()

statue = []
try:
    if not MODEL_PATH.exists():
        raise FileNotFoundError(MODEL_PATH)
    statue = import_statue(MODEL_PATH)
except (FileNotFoundError, RuntimeError, AttributeError) as exc:
    print(f"Could not import statue ({exc}); using a placeholder")
    statue = placeholder()

marble = bpy.data.materials.new("Marble")
marble.use_nodes = True
marble.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.9, 0.88, 0.85, 1.0)
for o in statue:
    if o.type == 'MESH':
        o.data.materials.clear()
        o.data.materials.append(marble)

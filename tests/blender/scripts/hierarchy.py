"""Parents with and without inverses, empties, collections, duplicates, joins and matrices of the last update."""

import bpy
from mathutils import Matrix, Vector

bpy.ops.wm.read_factory_settings(use_empty=True)
arms = bpy.data.collections.new("Arms")
bpy.context.scene.collection.children.link(arms)
bases = bpy.data.collections.new("Bases")
bpy.context.scene.collection.children.link(bases)


def link(name, data, collection):
    made = bpy.data.objects.new(name, data)
    collection.objects.link(made)
    return made


mesh = bpy.data.meshes.new("Bar")
mesh.from_pydata(
    [(0, 0, 0), (2, 0, 0), (2, 0.2, 0), (0, 0.2, 0), (0, 0, 0.2), (2, 0, 0.2), (2, 0.2, 0.2), (0, 0.2, 0.2)],
    [],
    [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)],
)
mesh.update()
shoulder = link("Shoulder", None, arms)
shoulder.location = (1, 2, 3)
shoulder.rotation_euler = (0, 0, 0.6)
upper = link("Upper", mesh, arms)
upper.parent = shoulder
lower = link("Lower", mesh, arms)
lower.parent = upper
lower.location = (2, 0, 0)
lower.rotation_euler.y = 0.5
lower.scale = (0.8, 1, 1)
stale = link("Stale", mesh, bases)
stale.location = (5, 5, 0)
stale.parent = shoulder
stale.matrix_parent_inverse = shoulder.matrix_world.inverted()
bpy.context.view_layer.update()
kept = link("Kept", mesh, bases)
kept.location = (-5, 5, 0)
kept.parent = shoulder
kept.matrix_parent_inverse = shoulder.matrix_world.inverted()
set_ = link("Set", mesh, bases)
set_.matrix_world = Matrix.Translation(Vector((0, -4, 0))) @ Matrix.Rotation(1.0, 4, "X")
bpy.context.view_layer.active_layer_collection = bpy.context.view_layer.layer_collection.children["Bases"]
bpy.ops.mesh.primitive_cube_add(size=1, location=(8, 0, 0))
first = bpy.context.object
first.name = "Joined"
bpy.ops.mesh.primitive_cylinder_add(radius=0.3, depth=2, location=(9, 0, 1))
bpy.context.object.select_set(True)
first.select_set(True)
bpy.context.view_layer.objects.active = first
bpy.ops.object.join()
bpy.ops.object.duplicate(linked=True)
bpy.context.object.location.y += 3
bpy.ops.object.duplicate_move(TRANSFORM_OT_translate={"value": (0, 3, 0)})
hidden = first.copy()
arms.objects.link(hidden)
hidden.hide_render = True

# cloth simulation: tablecloth falling on a round table
import bpy

bpy.ops.object.select_all(action="SELECT"); bpy.ops.object.delete()

# table
bpy.ops.mesh.primitive_cylinder_add(radius=1.0, depth=0.08, location=(0, 0, 1.0), vertices=64)
top = bpy.context.object
top.name = "TableTop"
top.modifiers.new("Collision", 'COLLISION')
top.collision.thickness_outer = 0.01
bpy.ops.mesh.primitive_cylinder_add(radius=0.1, depth=1.0, location=(0, 0, 0.5))
bpy.context.object.name = "TableStem"
bpy.ops.mesh.primitive_cylinder_add(radius=0.5, depth=0.06, location=(0, 0, 0.03))
bpy.context.object.name = "TableFoot"

# cloth
bpy.ops.mesh.primitive_grid_add(x_subdivisions=40, y_subdivisions=40, size=3, location=(0, 0, 1.4))
cloth = bpy.context.object
cloth.name = "Cloth"
bpy.ops.object.shade_smooth()
mod = cloth.modifiers.new("Cloth", 'CLOTH')
mod.settings.quality = 5
mod.settings.mass = 0.3
mod.settings.tension_stiffness = 15
mod.collision_settings.use_self_collision = True
mod.collision_settings.distance_min = 0.01

sub = cloth.modifiers.new("Subsurf", 'SUBSURF')
sub.levels = 1

mat = bpy.data.materials.new("Linen")
mat.use_nodes = True
p = mat.node_tree.nodes["Principled BSDF"]
p.inputs["Base Color"].default_value = (0.85, 0.1, 0.12, 1)
for k in ("Sheen Weight", "Sheen"):
    if k in p.inputs:
        p.inputs[k].default_value = 0.5
cloth.data.materials.append(mat)

bpy.context.scene.frame_end = 60
for f in range(1, 6):
    bpy.context.scene.frame_set(f)

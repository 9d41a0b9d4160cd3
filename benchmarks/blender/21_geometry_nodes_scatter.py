"""Scatter grass-like cones over a plane with geometry nodes."""
import bpy

bpy.ops.object.select_all(action='SELECT')
bpy.ops.object.delete()

# Instance object
bpy.ops.mesh.primitive_cone_add(vertices=4, radius1=0.03, depth=0.4, location=(100, 0, 0))
blade = bpy.context.object
blade.name = "Blade"

# Ground
bpy.ops.mesh.primitive_grid_add(x_subdivisions=20, y_subdivisions=20, size=10)
ground = bpy.context.object
ground.name = "Lawn"

# Node group
ng = bpy.data.node_groups.new("ScatterGrass", 'GeometryNodeTree')
ng.interface.new_socket("Geometry", in_out='INPUT', socket_type='NodeSocketGeometry')
ng.interface.new_socket("Geometry", in_out='OUTPUT', socket_type='NodeSocketGeometry')
nodes, links = ng.nodes, ng.links
n_in = nodes.new('NodeGroupInput')
n_out = nodes.new('NodeGroupOutput')
n_dist = nodes.new('GeometryNodeDistributePointsOnFaces')
n_inst = nodes.new('GeometryNodeInstanceOnPoints')
n_obj = nodes.new('GeometryNodeObjectInfo')
n_rand = nodes.new('FunctionNodeRandomValue')
n_join = nodes.new('GeometryNodeJoinGeometry')

n_dist.inputs['Density'].default_value = 20
n_obj.inputs['Object'].default_value = blade
n_rand.data_type = 'FLOAT'

links.new(n_in.outputs[0], n_dist.inputs['Mesh'])
links.new(n_dist.outputs['Points'], n_inst.inputs['Points'])
links.new(n_dist.outputs['Rotation'], n_inst.inputs['Rotation'])
links.new(n_obj.outputs['Geometry'], n_inst.inputs['Instance'])
links.new(n_rand.outputs[1], n_inst.inputs['Scale'])
links.new(n_in.outputs[0], n_join.inputs[0])
links.new(n_inst.outputs['Instances'], n_join.inputs[0])
links.new(n_join.outputs[0], n_out.inputs[0])

for i, n in enumerate((n_in, n_dist, n_inst, n_join, n_out)):
    n.location = (i * 220, 0)

mod = ground.modifiers.new("Scatter", 'NODES')
mod.node_group = ng

green = bpy.data.materials.new("Green")
green.diffuse_color = (0.1, 0.5, 0.1, 1)
blade.data.materials.append(green)
ground.data.materials.append(green)

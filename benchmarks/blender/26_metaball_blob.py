# Lava lamp: metaballs inside a glass body
import bpy, random

random.seed(11)
bpy.ops.object.select_all(action='SELECT')
bpy.ops.object.delete()

def simple(name, c, e=0):
    m = bpy.data.materials.new(name); m.use_nodes = True
    n = m.node_tree.nodes["Principled BSDF"]
    n.inputs["Base Color"].default_value = c
    if e and "Emission Color" in n.inputs:
        n.inputs["Emission Color"].default_value = c
        n.inputs["Emission Strength"].default_value = e
    return m

metal = simple("Metal", (.6, .6, .65, 1))
lava = simple("Lava", (1, .2, .05, 1), 3)

bpy.ops.mesh.primitive_cone_add(radius1=.6, radius2=.4, depth=.6, location=(0, 0, .3))
bpy.context.object.data.materials.append(metal)
bpy.ops.mesh.primitive_cone_add(radius1=.2, radius2=.15, depth=.3, location=(0, 0, 2.75))
bpy.context.object.data.materials.append(metal)

bpy.ops.mesh.primitive_cone_add(radius1=.4, radius2=.2, depth=2, location=(0, 0, 1.6))
body = bpy.context.object
body.name = "GlassBody"
g = simple("Glass", (1, .9, .9, 1))
g.node_tree.nodes["Principled BSDF"].inputs["Alpha"].default_value = .25
body.data.materials.append(g)

mb = bpy.data.metaballs.new("LavaBlobs")
mb.resolution = .08
mb.threshold = .6
ob = bpy.data.objects.new("LavaBlobs", mb)
bpy.context.collection.objects.link(ob)
ob.data.materials.append(lava)
for _ in range(9):
    el = mb.elements.new()
    el.type = 'BALL'
    el.co = (random.uniform(-.12, .12), random.uniform(-.12, .12), random.uniform(.7, 2.4))
    el.radius = random.uniform(.12, .28)

bpy.ops.object.metaball_add(type='BALL', radius=0.3, location=(0, 0, .75))
bpy.context.object.data.materials.append(lava)

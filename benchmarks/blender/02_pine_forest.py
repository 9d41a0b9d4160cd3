# Prompt: a low-poly pine forest
import bpy, random
from math import radians, pi

random.seed(42)

# Delete everything
bpy.ops.object.select_all(action="SELECT")
bpy.ops.object.delete()

def mat(name, rgb):
    m = bpy.data.materials.new(name)
    m.diffuse_color = (*rgb, 1)
    m.use_nodes = True
    m.node_tree.nodes.get("Principled BSDF").inputs[0].default_value = (*rgb, 1)
    return m

greens = [mat(f"Needle{i}", (0.05 + 0.03*i, 0.25 + 0.06*i, 0.08)) for i in range(3)]
bark = mat("Bark", (0.2, 0.1, 0.05))
grass = mat("Grass", (0.18, 0.35, 0.1))

# ground
bpy.ops.mesh.primitive_plane_add(size=40, location=(0, 0, 0))
ground = bpy.context.object
ground.name = "Ground"
ground.data.materials.append(grass)

def pine(x, y, s=1.0):
    bpy.ops.mesh.primitive_cylinder_add(vertices=6, radius=0.18*s, depth=1.0*s, location=(x, y, 0.5*s))
    trunk = bpy.context.object
    trunk.data.materials.append(bark)
    z = 1.0 * s
    layers = random.randint(3, 4)
    for i in range(layers):
        t = i / layers
        r = (1.1 - 0.8*t) * s
        h = 1.2 * s
        bpy.ops.mesh.primitive_cone_add(vertices=7, radius1=r, radius2=0, depth=h,
                                        location=(x, y, z + h/2),
                                        rotation=(0, 0, random.uniform(0, 2*pi)))
        cone = bpy.context.object
        cone.data.materials.append(random.choice(greens))
        z += 0.65 * s
    return trunk

placed = []
tries = 0
while len(placed) < 25 and tries < 500:
    tries += 1
    x, y = random.uniform(-18, 18), random.uniform(-18, 18)
    if all((x-a)**2 + (y-b)**2 > 6 for a, b in placed):
        placed.append((x, y))
        pine(x, y, random.uniform(0.8, 1.8))

# a few rocks
for _ in range(10):
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=1, radius=random.uniform(0.2, 0.6),
        location=(random.uniform(-18, 18), random.uniform(-18, 18), 0.1))
    rock = bpy.context.object
    rock.scale.z = 0.6
    rock.rotation_euler.z = random.random() * 6.28

bpy.ops.object.light_add(type='SUN', rotation=(radians(50), 0, radians(30)))
bpy.context.object.data.energy = 3.0

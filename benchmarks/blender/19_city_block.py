# procedurally generate a small city with random building heights, roads, and lit windows
import bpy, random
random.seed(2024)

def clear():
    bpy.ops.object.select_all(action='SELECT')
    bpy.ops.object.delete(use_global=False)
    for block in list(bpy.data.meshes):
        if block.users == 0:
            bpy.data.meshes.remove(block)

def mat(name, color, emission=0.0):
    if name in bpy.data.materials:
        return bpy.data.materials[name]
    m = bpy.data.materials.new(name)
    m.use_nodes = True
    bsdf = next(n for n in m.node_tree.nodes if n.type == 'BSDF_PRINCIPLED')
    bsdf.inputs['Base Color'].default_value = color
    if emission > 0:
        emi = bsdf.inputs.get('Emission Color') or bsdf.inputs.get('Emission')
        emi.default_value = color
        bsdf.inputs['Emission Strength'].default_value = emission
    return m

def cube(loc, dim, material, name='Cube', coll=None):
    bpy.ops.mesh.primitive_cube_add(size=1, enter_editmode=False, align='WORLD', location=loc, scale=(1, 1, 1))
    o = bpy.context.active_object
    o.name = name
    o.scale = dim
    o.data.materials.append(material)
    if coll:
        for c in list(o.users_collection):
            c.objects.unlink(o)
        coll.objects.link(o)
    return o

GRID, BLOCK, ROAD = 4, 6.0, 2.0
clear()
buildings = bpy.data.collections.new('Buildings')
bpy.context.scene.collection.children.link(buildings)

step = BLOCK + ROAD
extent = GRID * step
cube((0, 0, -0.05), (extent, extent, 0.1), mat('Asphalt', (0.04, 0.04, 0.045, 1)), 'Roads')

for i in range(GRID):
    for j in range(GRID):
        cx = (i - (GRID - 1) / 2) * step
        cy = (j - (GRID - 1) / 2) * step
        cube((cx, cy, 0.05), (BLOCK, BLOCK, 0.1), mat('Pavement', (0.35, 0.35, 0.36, 1)), 'Sidewalk')
        if random.random() < 0.15:
            cube((cx, cy, 0.12), (BLOCK * 0.9, BLOCK * 0.9, 0.05), mat('Park', (0.1, 0.4, 0.12, 1)), 'Park')
            continue
        dist = (cx ** 2 + cy ** 2) ** 0.5
        h = max(3, random.gauss(14 - dist * 0.5, 3))
        w = random.uniform(3.5, 5.2)
        d = random.uniform(3.5, 5.2)
        shade = random.uniform(0.25, 0.6)
        tower = cube((cx, cy, h / 2 + 0.1), (w, d, h), mat(f'Wall_{i}_{j}', (shade, shade, shade * 1.1, 1)), f'Building_{i}_{j}', buildings)
        floors = int(h // 1.2)
        for f in range(floors):
            if random.random() < 0.3:
                continue
            z = 0.7 + f * 1.2
            cube((cx, cy, z), (w * 1.01, d * 0.8, 0.4), mat('WindowLit', (1, 0.8, 0.4, 1), 2.0), 'Windows', buildings)
        if h > 10:
            bpy.ops.mesh.primitive_cylinder_add(radius=0.08, depth=2.5, location=(cx, cy, h + 1.35))
            bpy.context.active_object.name = 'Antenna'

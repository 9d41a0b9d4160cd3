# sculpted-looking boulder: subdivide + displace texture, then sculpt mode remesh settings
import bpy

bpy.ops.object.select_all(action='SELECT')
bpy.ops.object.delete()

bpy.ops.mesh.primitive_cube_add(size=2, location=(0, 0, 0.7))
rock = bpy.context.object
rock.name = "Boulder"

bpy.ops.object.mode_set(mode='EDIT')
bpy.ops.mesh.select_all(action='SELECT')
bpy.ops.mesh.subdivide(number_cuts=3, smoothness=1.0, fractal=0.6, seed=5)
bpy.ops.mesh.vertices_smooth(factor=0.5, repeat=2)
bpy.ops.object.mode_set(mode='OBJECT')

sub = rock.modifiers.new("Subdivision", 'SUBSURF')
sub.levels = 2

tex = bpy.data.textures.new("RockNoise", type='CLOUDS')
tex.noise_scale = 0.6
tex.noise_depth = 3
disp = rock.modifiers.new("Displace", 'DISPLACE')
disp.texture = tex
disp.strength = 0.4
disp.mid_level = 0.5

# voxel settings for sculpting
rock.data.remesh_voxel_size = 0.08
try:
    bpy.ops.object.mode_set(mode='SCULPT')
    bpy.context.scene.tool_settings.sculpt.use_symmetry_x = False
    brush = bpy.context.tool_settings.sculpt.brush
    if brush is not None:
        brush.strength = 0.5
except Exception as e:
    print("sculpt tools unavailable:", e)
finally:
    if bpy.context.object.mode != 'OBJECT':
        bpy.ops.object.mode_set(mode='OBJECT')

rock.scale = (1.3, 1.0, 0.8)
m = bpy.data.materials.new("Granite")
m.diffuse_color = (0.38, 0.37, 0.36, 1)
rock.data.materials.append(m)

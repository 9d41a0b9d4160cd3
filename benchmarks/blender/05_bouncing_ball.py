# Bouncing ball animation with squash and stretch
import bpy

scene = bpy.context.scene
scene.frame_start = 1
scene.frame_end = 120
scene.render.fps = 24

# remove default cube
bpy.ops.object.select_all(action='DESELECT')
for o in scene.objects:
    if o.type == 'MESH':
        o.select_set(True)
bpy.ops.object.delete()

# floor
bpy.ops.mesh.primitive_plane_add(size=10)
floor = bpy.context.active_object
floor.name = "Floor"
floor_mat = bpy.data.materials.new("FloorMat")
floor_mat.diffuse_color = (0.3, 0.3, 0.35, 1)
floor.data.materials.append(floor_mat)

# ball
radius = 0.5
bpy.ops.mesh.primitive_uv_sphere_add(radius=radius, location=(0, 0, 4))
ball = bpy.context.active_object
ball.name = "Ball"
bpy.ops.object.shade_smooth()

red = bpy.data.materials.new(name="RedRubber")
red.use_nodes = True
bsdf = red.node_tree.nodes["Principled BSDF"]
bsdf.inputs["Base Color"].default_value = (0.9, 0.1, 0.08, 1)
bsdf.inputs["Roughness"].default_value = 0.35
ball.data.materials.append(red)

height = 4.0
frame = 1
half = 14
restitution = 0.72

while frame < 120 and height > radius + 0.05:
    # top of arc
    ball.location = (0, 0, height)
    ball.scale = (1, 1, 1)
    ball.keyframe_insert(data_path="location", frame=frame)
    ball.keyframe_insert(data_path="scale", frame=frame)

    # contact
    contact = frame + half
    ball.location.z = radius
    ball.keyframe_insert(data_path="location", index=2, frame=contact)
    squash = min(0.35, height * 0.08)
    ball.scale = (1 + squash, 1 + squash, 1 - squash)
    ball.keyframe_insert("scale", frame=contact)
    ball.scale = (1, 1, 1)
    ball.keyframe_insert("scale", frame=contact - 2)
    ball.keyframe_insert("scale", frame=contact + 2)

    height *= restitution
    half = max(4, int(half * restitution ** 0.5))
    frame = contact + half

# set interpolation if the legacy API is there
action = ball.animation_data.action
if hasattr(action, "fcurves"):
    for fc in action.fcurves:
        for kp in fc.keyframe_points:
            kp.interpolation = 'BEZIER'

scene.frame_set(1)

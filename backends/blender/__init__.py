"""Blender: follows a script of `bpy` and writes a program of the Scene Language, and back (docs/from-blender.md).

``vectors`` is `mathutils`, ``polygons`` meshes and Blender's primitives, ``pieces`` what a mesh is made of,
``blend_model`` the objects of `bpy`, ``bpy_operators`` `bpy.ops`, ``bmeshes`` `bmesh`, ``modifiers`` the modifiers,
``animating`` the keyframes; ``following`` evaluates a script with them, ``importing`` writes the program, ``script`` a
script of a scene. A script is never executed: it is evaluated by the interpreter of ``transpile``, where these are its
objects.
"""

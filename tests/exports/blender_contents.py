"""Run by a Python that has Blender's module `bpy`: what an imported file has, as JSON.

python blender_contents.py < JOBS, a list of [FILE, [FRAME, ...]]: objects with their words, materials and world matrices
at frames, which count from 0; materials with the inputs of their shaders; actions with the numbers of their slots.
"""

from __future__ import annotations

import json
import sys
from typing import Any

import bpy

INPUTS = {
    "color": "Base Color",
    "metallic": "Metallic",
    "roughness": "Roughness",
    "transmission": "Transmission Weight",
    "ior": "IOR",
    "alpha": "Alpha",
    "coat": "Coat Weight",
    "coat_roughness": "Coat Roughness",
    "sheen": "Sheen Weight",
    "sheen_tint": "Sheen Tint",
    "emission": "Emission Color",
    "strength": "Emission Strength",
}


def contents(file: str, frames: list[int]) -> dict[str, Any]:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.fps = 24
    bpy.ops.import_scene.gltf(filepath=file)
    things = list(bpy.data.objects)
    objects = [
        {
            "name": thing.name,
            "word": thing.get("word"),
            "material": next((slot.material.name for slot in thing.material_slots if slot.material is not None), None),
            "worlds": [],
        }
        for thing in things
    ]
    for frame in frames:
        bpy.context.scene.frame_set(frame)
        bpy.context.view_layer.update()
        for one, thing in zip(objects, things, strict=True):
            one["worlds"].append([list(row) for row in thing.matrix_world])
    return {
        "objects": objects,
        "materials": {material.name: shader(material) for material in bpy.data.materials if material.users},
        "actions": {action.name: len(action.slots) for action in bpy.data.actions},
    }


def shader(material: bpy.types.Material) -> dict[str, Any]:
    """The inputs of a material's shader; of those that are linked, the type of the node before them."""
    node = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    found: dict[str, Any] = {}
    for key, name in INPUTS.items():
        socket = node.inputs[name]
        value = socket.default_value
        found[key] = (
            socket.links[0].from_node.type
            if socket.is_linked
            else list(value)[:3]
            if hasattr(value, "__len__")
            else value
        )
    return found


if __name__ == "__main__":
    print("RESULT " + json.dumps([contents(file, frames) for file, frames in json.load(sys.stdin)]))

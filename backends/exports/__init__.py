"""Scenes as files for other programs (docs/exports.md).

``items`` and ``surfaces`` say what there is to write, ``export`` what all formats share; ``gltf``, ``usd``,
``mesh_files`` (OBJ, PLY, STL), ``mitsuba_xml`` and ``scene_json`` write. Formats know nothing of one another.
"""

"""Export of scenes to files of other programs (docs/exports.md).

``plan`` defines what is written, ``export`` contains what the formats share, ``trs`` splits poses; ``gltf``, ``usd``,
``mesh_files`` (OBJ, PLY, STL), ``mitsuba_xml`` and ``scene_json`` write. Formats are independent of one another.
"""

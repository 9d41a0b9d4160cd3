"""Minecraft builds (the paper, appendix "Minecraft Renderer"; docs/minecraft.md).

``voxels`` places entities in a grid, ``connections`` and ``table`` resolve blocks and their states, ``filling``
voxelizes meshes, ``build_files`` and ``export`` write files, ``models`` converts blocks to boxes. ``extract`` generates
the tables and is never imported. This package is independent of the renderers.
"""

"""Builds of Minecraft's blocks (the paper, appendix "Minecraft Renderer"; docs/minecraft.md).

``voxels`` puts entities into a grid, ``connections`` and ``table`` settle blocks and their states, ``filling`` fills
meshes, ``build_files`` and ``export`` write, ``models`` gives blocks their shapes. ``extract`` makes the tables and is
never imported. It knows nothing of rendering.
"""

"""The asset-based renderer: builds of Minecraft's blocks (the paper, appendix "Minecraft Renderer")."""

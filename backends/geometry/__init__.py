"""Solids and meshes, mesh assets, distances between solids, and the lint of a scene's geometry."""

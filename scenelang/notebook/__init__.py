"""The cell magic of notebooks.

``magic`` evaluates a cell and shows its scene, with params as controls. It knows the viewer, and no command.
"""

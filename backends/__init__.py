"""Rendering backends: pictures, labels, exported files and Minecraft builds from a scene's entity graph.

``base`` defines the backend interface and discovers backends that packages provide; ``files`` writes output atomically.
Each subpackage produces one kind of result. Backends receive an evaluated scene: they do not read programs, and nothing
here depends on the command line, the servers or the notebook extension.
"""

"""The entity graph and its geometry, computed on the DAG without expanding it where possible.

``entity`` and ``parts`` build the graph, ``pose`` multiplies matrices, ``bounds``, ``numbering``, ``outline`` and
``flatten`` analyze it, and ``difference`` compares two scenes. ``primitives`` has one class per file. Nothing here
imports a backend, and numpy is imported lazily.
"""

"""The entity graph and its geometry, worked out on the graph without expanding it where that can be.

``entity`` and ``parts`` make it, ``pose`` multiplies matrices, ``bounds``, ``numbering``, ``outline`` and ``flatten``
read it, ``difference`` compares; ``primitives`` has one class a file. It knows no backend, and numpy is imported at
first use.
"""

"""Core AST to running code, and back to text.

``analyse`` finds variables and frames, ``compile`` makes closures, with ``calls`` and ``intrinsics`` for fast paths and
``comprehension`` for loops, ``unparse`` prints. ``compile`` and ``comprehension`` import each other: they recurse on
the same tree. It runs nothing.
"""

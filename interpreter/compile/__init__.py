"""Compiler from the core AST to Python closures, and back to text.

``analyze`` resolves variables and frames, ``compile`` creates closures, with fast paths in ``calls`` and ``intrinsics``
and loops in ``comprehension``; ``unparse`` prints. ``compile`` and ``comprehension`` import each other because they
recurse on the same tree. Nothing is run here.
"""

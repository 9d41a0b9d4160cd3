"""Geometry of whole scenes: posed solids, mesh assets, distances and geometric checks.

``solids`` are posed primitives, ``assets`` meshes loaded from files, ``distance`` computes contacts and penetration,
``lint`` reports floating, overlapping and z-fighting parts. Primitives are accessed through their protocol, never by
name.
"""

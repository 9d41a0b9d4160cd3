"""Geometry of whole scenes: what is where, how far apart.

``solids`` are posed primitives, ``assets`` meshes from files, ``distance`` finds contacts and gaps, ``lint`` says what
floats, overlaps or flickers. It asks primitives through their protocol and knows none by name.
"""

"""Solid modelling: solids as lazy expressions, computed by Manifold; profiles, paths and outlines to make them from.

``operations`` says what a solid is, ``computing`` makes its surface, ``solid`` is the primitive that the scene and the
backends see. ``contours``, ``curves`` and ``outlines`` (of text) make plain arrays of points. Nothing here imports a
backend; numpy and manifold3d are imported when a solid is computed.
"""

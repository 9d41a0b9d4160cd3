"""Surfaces that pictures, exports, labels and checks share: posed solids with their looks.

``solids`` are posed primitives, ``appearance`` materials and colors, ``assets`` meshes from files, ``convex`` and
``distance`` contacts and penetration, ``precision`` and ``contraction`` meshes in single precision. Primitives are
accessed through their protocol, never by name.
"""

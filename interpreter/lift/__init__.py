"""Lifting: rewrites a program to an equal one that reads as if written by hand.

``tree`` is the mutable tree that the rules change, with names, effects and arithmetic; ``simplify`` inlines, composes,
removes and declares params; ``patterns`` finds rings, grids and aligned parts, ``tables`` loops over tables and
formulas; ``lift`` applies all of them to a program. Nothing here evaluates a program.
"""

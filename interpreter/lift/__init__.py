"""Lifting: rewrites a program to an equal one that reads as if written by hand.

``tree`` is the mutable tree that the rules change, with names and effects; ``algebra`` is arithmetic on expressions;
``simplify`` inlines, composes, removes and declares params; ``patterns`` finds rings, grids, tables and aligned parts;
``lift`` applies all of them to a program. Nothing here evaluates a program.
"""

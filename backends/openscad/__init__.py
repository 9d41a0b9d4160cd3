"""OpenSCAD: reads a subset of its language and writes a program of the Scene Language.

``syntax`` is the parser, ``terms`` converts values, ``geometry`` the calls of modules, ``converting`` whole
programs; ``helpers`` are functions that these programs define. Nothing here runs a program or knows the command line.
"""

"""OpenSCAD: reads a subset of its language and writes a program of the Scene Language.

``syntax`` is the parser, ``arithmetic`` converts values, ``geometry`` the calls of modules, ``converting`` whole
programs; ``preamble`` has functions that these programs define. Nothing here runs a program or knows the command line.
"""

"""OpenSCAD: reads a subset of its language and writes a program of the Scene Language.

``syntax`` is the parser, ``expressions`` converts values, ``geometry`` the calls of modules, ``converting`` whole programs.
Nothing here runs a program or imports the command line.
"""

"""OpenSCAD: reads a subset of its language and writes a program of the Scene Language (docs/from-openscad.md).

``syntax`` is the parser, ``arithmetic`` converts values, ``geometry`` the calls of modules, ``converting`` whole
programs, which define functions from ``definitions``. Nothing here runs a program or knows the command line.
"""

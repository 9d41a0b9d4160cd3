"""Blender scripts in sessions: the front end that checks, runs and converts them (docs/from-blender.md).

``backends/blender`` follows a script and writes the program; here it is checked and run as any other. Sessions find the
front end as the service "blender". Nothing here knows the command line.
"""

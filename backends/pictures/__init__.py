"""Pictures and films (docs/pictures.md).

``camera``, ``studio`` and ``stage`` define viewpoint, lighting and the geometry to draw, ``appearance`` the materials;
``rays``, ``draft`` and ``draft_light`` implement a ray caster in numpy, ``mitsuba`` and ``mitsuba_scene`` a path
tracer; ``film`` selects the backend and saves the result. Primitives are accessed through their protocol, never by
name.
"""

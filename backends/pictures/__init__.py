"""Pictures and films (docs/pictures.md).

``camera`` and ``stage`` define viewpoint and the geometry to draw, ``appearance`` materials, lighting and ground;
``rays``, ``draft`` and ``draft_light`` implement a ray caster in numpy, ``mitsuba`` and ``mitsuba_scene`` a path
tracer; ``film`` selects the backend and saves the result. Primitives are accessed through their protocol, never by
name.
"""

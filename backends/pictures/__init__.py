"""Pictures and films (docs/pictures.md).

``camera``, ``studio`` and ``stage`` say what is drawn from where in which light, ``appearance`` how surfaces look;
``rays``, ``draft`` and ``draft_light`` draw in numpy, ``mitsuba`` and ``mitsuba_scene`` trace paths; ``film`` chooses
and saves. Primitives are asked through their protocol, none is known by name.
"""

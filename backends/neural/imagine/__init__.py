"""Pictures by text-to-image models that follow a scene's layout (docs/imagine.md).

``layout`` says what is where in a shot, ``regional`` and ``migc`` steer attention by it, ``sampling`` draws. It knows
scenes as boxes and sentences only.
"""

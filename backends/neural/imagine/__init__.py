"""Text-to-image generation conditioned on a scene's layout (docs/imagine.md).

``layout`` computes the boxes of a shot, ``regional`` and ``migc`` condition attention layers on them, ``sampling``
generates images. The package sees a scene only as boxes and prompts.
"""

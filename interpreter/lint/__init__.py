"""Warnings about programs that have no error: what is nearly always a mistake, found before anything runs.

``rules`` looks at one top-level form, ``lint`` at the whole program and its fixes. What is odd about the geometry of a
scene is found by ``backends.geometry.lint``.
"""
